# %% [markdown]
# # A staggered fan blade
#
# A blade that bends and twists, set at an angle on a disc, rubs its casing with friction. Which of its modes chatters
# at which speed? What does friction do? And what can be won by blades that are not quite alike?

# %%
import jax
import matplotlib.pyplot as plt
import numpy as np

import lobex

DAMPING_RATIO = 0.005
SPEED = np.linspace(30.0, 130.0, 401)  # revolutions per second
blade = lobex.Beam.rectangular(
    elements=6,
    length=0.18,  # m
    width=[0.060, 0.070],
    thickness=lambda share: 0.007 - 0.004 * share**0.8,
    young_modulus=110e9,
    density=4430.0,
    hub_radius=0.12,
    stagger_degrees=20.0,
    twist_degrees=[0.0, 35.0],
)
NORMAL = {"normal": (0.97, 0.0, 0.24)}  # radial, tangential, axial: the casing is a cone
smooth = blade.rotating(DAMPING_RATIO, [1, 2, 3, 4], **NORMAL)
rough = blade.rotating(DAMPING_RATIO, [1, 2, 3, 4], **NORMAL, sliding=(0.0, 1.0, 0.0), friction=0.15)
for one in (1.0, 65.0, 130.0):
    print(f"at {one:5.1f} Hz the modes are at {np.round(smooth.at(one).frequency, 1)} Hz")

# %% [markdown]
# ## Lobes by mode, and what friction makes of them
#
# The modes follow the speed, so that the limit is taken with those of each. A limit tells which mode chatters.

# %%
limits = {name: lobex.exact_limit(lobex.Rub(modes), SPEED) for name, modes in (("smooth", smooth), ("rough", rough))}
limits["smooth"].plot()
plt.show()
for name, limit in limits.items():
    shares = ", ".join(f"mode {mode} at {np.mean(limit.mode == mode):.0%}" for mode in np.unique(limit.mode))
    print(f"{name}: least limit {np.min(limit.gain) / 1e6:.4f} MN/m; of the speeds {shares}")

# %%
ratio = limits["rough"].gain / limits["smooth"].gain
print(f"friction makes the limit {ratio.min():.2f} to {ratio.max():.2f} times that without")

# %% [markdown]
# ## Engine orders and lobes in one picture
#
# Two things that are apart: where a casing with two bumps excites the blade, and at which frequencies its lobes
# chatter.

# %%
lobex.campbell(rough, nodal_diameters=2, highest_speed=130.0, limit=limits["rough"])
plt.show()

# %% [markdown]
# ## Six blades, not quite alike
#
# In a stage each blade rubs in the track of the one before it. Equal blades pass a wave on from one to the next; blades
# that differ a little do that less well. By how much may their frequencies differ for the best, within ±3 %? The limit
# has a derivative by every one of them: a pattern is climbed, of the least limit from 85 to 95 revolutions per second.

# %%
STAGE_SPEED = np.linspace(85.0, 95.0, 11)
MOST = 0.03
STEPS = 40
first = rough.at(90.0).select([1])


def least(shares):
    limit = lobex.exact_limit(lobex.Rub(lobex.Blading(first, 6, shares)), STAGE_SPEED).gain
    # A smooth stand-in for the least of them.
    return -jax.numpy.log(jax.numpy.mean((limit / SCALE) ** -8.0)) / 8


tuned = lobex.exact_limit(lobex.Rub(lobex.Blading(first, 6)), STAGE_SPEED)
SCALE = float(np.min(tuned.gain))
shares = MOST * np.array([0.1, -0.2, 0.3, -0.1, 0.2, -0.3])
slope_of = jax.grad(least)
for step in range(STEPS):
    slope = np.asarray(slope_of(shares))
    shares = np.clip(shares + 0.25 * MOST * 0.93**step * slope / np.max(np.abs(slope)), -MOST, MOST)
stage = lobex.Rub(lobex.Blading(first, 6, shares))
found = lobex.exact_limit(stage, STAGE_SPEED)
gain = float(np.min(found.gain)) / SCALE
print(f"frequencies higher by {np.round(100 * shares, 2)} %: least limit {gain:.2f} times that of equal blades")

# %%
wide = np.linspace(60.0, 130.0, 281)
fig, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
for name, rub in (("equal blades", lobex.Rub(lobex.Blading(first, 6))), ("the pattern found", stage)):
    lobex.exact_limit(rub, wide).plot(ax, label=name)
ax.axvspan(85.0, 95.0, color="0.9", zorder=0)
ax.set_ylim(0, None)
plt.show()

# %% [markdown]
# ## In time
#
# Marches of the stage that was found, at 90 revolutions per second in a casing that comes closer all the time, so that
# blades begin in contact: below the limit a motion dies out, above it grows until blades leave the coating, about as
# the largest multiplier says: others that are nearly as large beat with it.

# %%
CELLS, REVOLUTIONS = 1536, 50
at = float(lobex.exact_limit(stage, 90.0).gain[0])
motion, expected = {}, {}
fig, ax = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
for share, colour in ((0.7, "#12436d"), (1.2, "#c8500a")):
    march = lobex.march_wear(
        stage.modes,
        lobex.Casing(amplitude=0.0),
        lobex.Linear(share * at),
        [90.0],
        REVOLUTIONS,
        CELLS,
        incursion=1e-6,
    )
    turns = march.displacement[0].reshape(6, REVOLUTIONS, -1)
    # What the contact settles at is the same in every revolution.
    motion[share] = np.max(np.abs(np.diff(turns, axis=1)), axis=(0, 2))
    # Of a revolution, that of six passes.
    expected[share] = float(lobex.spectral_radius(stage, 90.0, share * at)) ** 6
    number = np.arange(2, REVOLUTIONS + 1)
    ax.semilogy(number, 1e9 * motion[share], ".-", color=colour, label=f"march, {share} of the limit")
    line = 1e9 * motion[share][10] * expected[share] ** (number - number[10])
    ax.semilogy(number, line, "--", color=colour, label=f"multiplier, {expected[share]:.3f} a revolution")
    print(f"{share} of the limit: all blades in contact for {np.sum(march.contact[0].min(axis=0) > 0.99)} revolutions")
ax.set_xlabel("revolution")
ax.set_ylabel("change of the motion in a revolution (nm)")
ax.legend(frameon=False)
plt.show()
