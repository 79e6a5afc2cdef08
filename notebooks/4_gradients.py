# %% [markdown]
# # Gradients: sensitivities, uncertainty, design
#
# Every verb of lobex can be differentiated with respect to every number of the model. Three things an engineer does
# with that: find out which number matters, put an uncertainty on a limit, and let a shape improve itself.

# %%
import jax
import jax.numpy as jnp
import matplotlib.pyplot as plt
import numpy as np

import lobex

SPEED = np.linspace(60.0, 240.0, 91)  # revolutions per second
NOMINAL = {"young_modulus": 210e7, "density": 4600.0, "length": 0.5, "area": 10e-4, "damping_ratio": 0.03}

# %% [markdown]
# ## Which number matters?
#
# A function says how the process is made from its numbers; `sensitivities` finds the limit at each speed and
# differentiates it by all of them at once. d ln K/d ln p = 2 means: one percent more of p, two percent more of limit.


# %%
def process(numbers):
    rod = lobex.Rod(5, *(numbers[name] for name in ("young_modulus", "density", "length", "area")))
    return lobex.Rub(rod.modes(numbers["damping_ratio"]))


table = lobex.sensitivities(process, SPEED, at=NOMINAL)
print(table)
table.plot()
plt.show()

# %% [markdown]
# A check that owes nothing to the code: a blade of α times the modulus has α times the limit at √α times the speed. So
# the sensitivity to the modulus and half of that to the speed must add up to one, at every speed.

# %%
by_speed = lobex.sensitivities(process(NOMINAL), SPEED)["speed"]
scaling = np.max(np.abs(table["young_modulus"] + by_speed / 2 - 1))
print(f"the sum differs from one by {scaling:.0e} at most")

# %% [markdown]
# ## How sure is the limit?
#
# With a standard deviation for each number the same table gives a band. It is of first order: we draw blades at random
# and compare.

# %%
SCATTER = {"young_modulus": 0.02, "density": 0.01, "damping_ratio": 0.1}
band = table.band(SCATTER)
print(band)

BLADES = 200
random = np.random.default_rng(0)
drawn = {name: np.full(BLADES, value) for name, value in NOMINAL.items()}
for name, sigma in SCATTER.items():
    drawn[name] = drawn[name] * (1 + sigma * random.standard_normal(BLADES))
with jax.enable_x64(True):
    samples = np.asarray(jax.jit(jax.vmap(lambda numbers: lobex.exact_limit(process(numbers), SPEED).gain))(drawn))
low, high = band.interval(1.0)
inside = np.mean((samples > low) & (samples < high), axis=0)
print(f"blades inside ± 1 standard deviation: {100 * np.median(inside):.0f} % at the median speed (normal law: 68 %),")
print(f"  {100 * inside.min():.0f} % at the worst, {SPEED[np.argmin(inside)]:.0f} Hz")

figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
axes.plot(SPEED, samples[:40].T / 1e6, color="0.6", linewidth=0.4)
axes.plot([], [], color="0.6", linewidth=0.8, label="40 blades drawn at random")
axes.fill_between(SPEED, low / 1e6, high / 1e6, color="#f0c48a", alpha=0.8, linewidth=0, label="± 1 standard deviation")
axes.plot(SPEED, table.limit.gain / 1e6, color="#12436d", label="nominal")
axes.set_xlim(SPEED[0], SPEED[-1])
axes.set_ylim(0, 1.25 * table.limit.gain.max() / 1e6)
axes.set_xlabel("rotational frequency (Hz)")
axes.set_ylabel("critical contact stiffness $K_e$ (MN/m)")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize="small")
plt.show()

# %% [markdown]
# Only near the cusps between two lobes the band fails: there the lower one of the lobes wins, which no first order
# knows, and most blades leave it.
#
# ## A shape that improves itself
#
# The blade may be thick here and thin there, with the same mass: eight cross-sections within 60 % and 160 % of the
# mean. Which distribution is stable up to the highest stiffness **everywhere** between 100 and 130 Hz? Eight numbers
# are too many to try out, and one gradient costs about as much as one limit. (`design_by_gradient.py` beside this
# notebook does the same for one number, step by step, and explains the soft minimum.)

# %%
SECTIONS = 8
RANGE = np.linspace(100.0, 130.0, 31)
LIGHTEST, HEAVIEST = 0.6, 1.6
TEMPERATURE, STEPS, FIRST_STEP, SHRINK = 0.01, 60, 0.15, 0.95


@jax.jit
def tapered(free):
    """A rub of the blade whose cross-sections, from the clamp to the tip, follow from eight free numbers."""
    share = LIGHTEST + (HEAVIEST - LIGHTEST) * jax.nn.sigmoid(free)
    area = NOMINAL["area"] * share / jnp.mean(share)
    h = NOMINAL["length"] / SECTIONS
    stretch, inertia = NOMINAL["young_modulus"] * area / h, NOMINAL["density"] * area * h / 6
    after = jnp.append(stretch[1:], 0), jnp.append(inertia[1:], 0)
    stiffness = jnp.diag(stretch + after[0]) - jnp.diag(stretch[1:], 1) - jnp.diag(stretch[1:], -1)
    mass = 2 * jnp.diag(inertia + after[1]) + jnp.diag(inertia[1:], 1) + jnp.diag(inertia[1:], -1)
    tip = np.eye(SECTIONS)[-1]
    return lobex.Rub(lobex.Modes.from_matrices(mass, stiffness, tip, NOMINAL["damping_ratio"])), area


def limits(free):
    return lobex.exact_limit(tapered(free)[0], RANGE).gain


def soft_minimum(free):
    return -TEMPERATURE * jax.nn.logsumexp(-jnp.log(limits(free)) / TEMPERATURE)


@jax.jit
def climb(start):
    def step(free, length):
        slope = jax.grad(soft_minimum)(free)
        return free + length * slope / jnp.linalg.norm(slope) * np.sqrt(SECTIONS), slope

    return jax.lax.scan(step, start, FIRST_STEP * SHRINK ** jnp.arange(STEPS))


UNIFORM = np.full(SECTIONS, np.log((1 - LIGHTEST) / (HEAVIEST - 1)))
with jax.enable_x64(True):
    best, slopes = (np.asarray(part) for part in climb(UNIFORM))
    areas = np.asarray(tapered(best)[1])
    before, after = (np.asarray(limits(free)) for free in (UNIFORM, best))
    first, natural = (float(tapered(free)[0].modes.frequency[0]) for free in (UNIFORM, best))
print("cross-sections from clamp to tip (cm²):", np.round(1e4 * areas, 2))
print(f"stable up to {before.min() / 1e6:.3f} MN/m before and {after.min() / 1e6:.3f} MN/m after, in the whole range,")
print(f"  {after.min() / before.min():.2f} times; first natural frequency {first:.0f} Hz, then {natural:.0f} Hz")

# %% [markdown]
# ## Conclusion
#
# The gradient takes mass from the tip and puts it into the blade's middle. That raises the natural frequency and
# moves the peak between two lobes up into the range, until both ends of it are equally weak. Mass and material are
# the same.

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8.4, 3.8), layout="constrained", width_ratios=(1, 1.3))
ends = np.linspace(0, NOMINAL["length"], SECTIONS + 1)
left.stairs(1e4 * areas, ends, color="#c8500a", linewidth=1.8, baseline=None)
left.axhline(1e4 * NOMINAL["area"], color="#12436d", linestyle="--", linewidth=1.4)
left.set_xlim(0, NOMINAL["length"])
left.set_ylim(0, None)
left.set_xlabel("distance from the clamp (m)")
left.set_ylabel("cross-section (cm²)")
right.plot(RANGE, before / 1e6, color="#12436d", linestyle="--", linewidth=1.4, label="uniform")
right.plot(RANGE, after / 1e6, color="#c8500a", linewidth=1.8, label="by gradient")
right.set_xlim(RANGE[0], RANGE[-1])
right.set_ylim(0, None)
right.set_xlabel("rotational frequency (Hz)")
right.set_ylabel("critical contact stiffness $K_e$ (MN/m)")
right.legend(frameon=False, fontsize="small")
plt.show()
