# %% [markdown]
# # A blade rub study
#
# Two different questions are asked of a blade that rubs its casing, and both are answered with a list of speeds:
#
# - **Critical speeds**: the casing is not round. Its bumps push the tip a few times per revolution, and where a
#   multiple of that meets a natural frequency the blade resonates. They are f₁/2, f₁/4, f₁/6 for a casing with two
#   bumps.
# - **Lobes**: the tip meets the surface that it left one revolution ago. At some speeds that feedback makes a vibration
#   grow in a soft contact already, be the casing perfectly round.
#
# They are easily taken for each other. Here is one blade, looked at in both ways at the same speeds.

# %%
import matplotlib.pyplot as plt
import numpy as np

import lobex

SPEED = np.linspace(40.0, 240.0, 401)  # revolutions per second
DAMPING_RATIO = 0.03
modes = lobex.Rod(elements=5).modes(DAMPING_RATIO)
f1 = modes.frequency[0]
print("natural frequencies (Hz):", np.round(modes.frequency, 1))

# %% [markdown]
# ## The lobes: how stiff may the contact be?
#
# `critical_gain` has the limit at every speed, over all modes and lobes. `exact_lobes` has its least value, which all
# lobes share, and the speeds at which they reach it. For one mode it is 2 k ξ (1 + ξ), k the modal stiffness at the
# tip.

# %%
rub = lobex.Rub(modes)
limit = lobex.critical_gain(rub, SPEED, bounds=(1e4, 1e7))
least = lobex.exact_lobes(rub, lobes=9).minimum
bottoms = np.sort(np.asarray(least.speed))
bottoms = bottoms[(bottoms > SPEED[0]) & (bottoms < SPEED[-1])]
modal_stiffness = modes.angular_frequency[0] ** 2 / modes.shape[0, 0] ** 2
rule = 2 * modal_stiffness * DAMPING_RATIO * (1 + DAMPING_RATIO)
print(f"least critical stiffness {least.gain / 1e6:.4f} MN/m; of mode 1 alone {rule / 1e6:.4f} MN/m")
print("bottoms of the lobes (Hz):", np.round(bottoms, 1))

critical = lobex.critical_speeds(modes, nodal_diameters=2)[0]
at_critical = np.interp(critical, SPEED, limit.gain) / least.gain
for order, speed, share in zip((2, 4, 6), critical, at_critical, strict=True):
    print(f"f1/{order} = {speed:.1f} Hz: critical stiffness {share:.1f} times the least")

# %% [markdown]
# So the critical speeds lie near the *most stable* speeds of the lobes, not near their bottoms: a vibration that fits
# the revolution a whole number of times finds its own trace in phase, and cuts nothing new.
#
# ## The wear: where does the blade resonate?
#
# The casing has two bumps of 0.1 mm. The march lets the blade rub for 20 revolutions at each speed and keeps what it
# removed. The contact is far stiffer than the limit above: whenever the tip is in the coating, feedback may act too.

# %%
STIFFNESS = 4.5e6  # of the contact, N/m
marches = {
    bumps: lobex.march_wear(
        modes,
        lobex.Casing(nodal_diameters=bumps, amplitude=1e-4),
        lobex.Linear(STIFFNESS),
        SPEED,
        revolutions=20,
        steps_per_revolution=2048,
    )
    for bumps in (2, 3)
}
wear = marches[2]
print(wear)
wear.plot()
plt.show()

# %%
resonance = []
for order, speed in zip((2, 4, 6), critical, strict=True):
    near = np.abs(SPEED / speed - 1.1) < 0.15
    resonance.append(float(SPEED[near][np.argmax(wear.volume[near])]))
    print(f"f1/{order} = {speed:.1f} Hz; most wear at {resonance[-1]:.1f} Hz, {resonance[-1] / speed:.2f} times")

# %% [markdown]
# The contact stiffens the blade while it lasts: each peak of wear lies about a tenth above its critical speed.
#
# ## The spectrum: what does the blade vibrate with?

# %%
spectrum = wear.spectrum()
spectrum.plot()
plt.show()
lines = []
for speed in resonance:
    lane = wear.nearest(speed)
    lines.append(int(np.argmax(spectrum.amplitude[lane, 1:]) + 1))
    print(
        f"{speed:.1f} Hz: largest line {1e6 * spectrum.amplitude[lane, lines[-1]]:.0f} µm at "
        f"{spectrum.frequency[lane, lines[-1]]:.0f} Hz, engine order {spectrum.order[lines[-1]]:.2f}"
    )

# %% [markdown]
# The largest lines are near the first natural frequency, and a little *below* the whole engine orders 2, 4 and 6. Bumps
# alone would force whole orders. A vibration a little short of a whole number of waves meets its own trace out of
# phase: in a contact this stiff the feedback takes part.
#
# ## Conclusion
#
# Both at the same speeds, with a second casing of three bumps for comparison.

# %%
three = marches[3].volume / marches[3].volume.max()
two = wear.volume / wear.volume.max()
print("share of the largest wear, casing with two and with three bumps:")
for name, speeds in (("critical speed", critical), ("bottom of a lobe", bottoms)):
    for speed in speeds:
        shares = (np.interp(speed, SPEED, volume) for volume in (two, three))
        print(f"  {speed:5.1f} Hz, {name:<16} " + " ".join(f"{100 * share:4.0f} %" for share in shares))

figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.0, 6.0), sharex=True, layout="constrained")
upper.fill_between(SPEED, limit.gain / 1e6, color="#d6e6f2", linewidth=0)
upper.plot(SPEED, limit.gain / 1e6, color="#12436d", label="limit of the feedback")
upper.set_ylabel("critical contact stiffness\n$K_e$ (MN/m)")
upper.set_ylim(0, 1.08 * limit.gain.max() / 1e6)
lower.plot(SPEED, 1e6 * wear.volume, color="#c8500a", label="worn, two bumps")
lower.plot(SPEED, 1e6 * marches[3].volume, color="#5d8a3a", linestyle=(0, (5, 1.5)), label="worn, three bumps")
lower.set_ylabel("cross-section removed\nin 20 revolutions (mm²)")
lower.set_ylim(0, None)
lower.set_xlim(SPEED[0], SPEED[-1])
lower.set_xlabel("rotational frequency (Hz)")
for axes in (upper, lower):
    for speeds, style, name in (
        (critical, {"color": "0.15", "linestyle": "-"}, "critical speeds f₁/2, f₁/4, f₁/6"),
        (bottoms, {"color": "0.5", "linestyle": ":"}, "bottoms of the lobes"),
    ):
        for i, speed in enumerate(speeds):
            axes.axvline(speed, linewidth=1.0, zorder=0.5, label=name if i == 0 and axes is upper else None, **style)
figure.legend(loc="outside upper center", ncols=3, frameon=False, fontsize="small")
plt.show()

# %% [markdown]
# - The lobes belong to the blade: no casing moves them. Which speeds wear most is up to the casing: with a third bump
#   the wear above f₁/2 and f₁/4 goes, and another peak comes above f₁/3.
# - At the critical speeds themselves little is worn, and the limit is high. The contact carries the resonance
#   upwards, to where a lobe has its bottom, and there both act together.
# - Neither list alone tells the speeds to avoid: not every bottom of a lobe is worn, and no critical speed is a peak.
#   March the wear.
