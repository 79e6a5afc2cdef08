# %% [markdown]
# # Milling: from cutter data to a speed and a depth
#
# How deep may a cutter cut before it chatters, and at which spindle speed? From the data of a tool and its cutting
# forces to a recommendation that survives their uncertainty. And what simpler codes get wrong on the way.

# %%
import matplotlib.pyplot as plt
import numpy as np

import lobex

# %% [markdown]
# ## The cutter
#
# A slender end mill with two teeth, as in Insperger and Stépán, *Semi-Discretization for Time-Delay Systems* (2011):
# one bending mode along the feed, up-milling with a tenth of its diameter in the material. It cuts for a short part
# of each tooth pass and flies freely for the rest.

# %%
TOOL = {"frequency": 922.0, "damping_ratio": 0.011, "mass": 0.03993}  # Hz, 1, kg
FORCES = {"tangential": 6e8, "normal": 2e8}  # specific cutting forces, N/m²
CUT = {"teeth": 2, "radial_immersion": 0.1, "direction": "up"}
RPM = np.linspace(8500, 14500, 121)
speed = RPM / 60  # lobex takes revolutions per second
mill = lobex.Milling(lobex.Modes.single(**TOOL), **FORCES, **CUT)

chart = lobex.sweep(mill, speed, np.linspace(0, 14e-3, 71))
print(chart)
chart.plot()
plt.show()

# %% [markdown]
# ## The limit, its kinds, and what lies above it
#
# `critical_gain` polishes the lowest depth at which stability is lost, and says how it is lost: in a **Hopf**
# bifurcation a chatter frequency appears beside the tooth passes; at a **flip** every second tooth cuts deep, so that
# the frequency is an odd multiple of half the tooth-passing frequency. Flips are what interrupted cutting adds to
# turning.

# %%
limit = lobex.critical_gain(mill, speed, bounds=(1e-4, 16e-3), scan=97)
print(limit)
flips = limit.kind == "flip"
waves = limit.chatter_frequency / (mill.teeth * limit.speed)
print(f"{flips.sum()} of {np.sum(limit.kind != '')} limits are flips, at {RPM[flips].min():.0f} to ", end="")
print(f"{RPM[flips].max():.0f} rpm, mostly with {np.median(waves[flips]):.4f} waves per tooth pass")
limit.plot()
plt.show()

# %% [markdown]
# A curve of the lowest limit hides that stability may come *back* above it. `intervals` holds every stable interval of
# depths within the bounds: between the flips and the Hopf lobe a tongue of stable depths stays. At some speeds it is an
# island, cut off from the stable depths below.

# %%
again = np.isfinite(limit.intervals[:, 1:, 0]).any(axis=1)
shown = int(np.argmin(np.abs(RPM - 12000)))
print(f"stable again above the limit at {again.sum()} of {len(RPM)} speeds")
for low, high in limit.intervals[shown][np.isfinite(limit.intervals[shown, :, 0])]:
    print(f"{RPM[shown]:.0f} rpm: stable from {1e3 * low:.3f} to {1e3 * high:.3f} mm")

island = lobex.sweep(mill, np.linspace(11500, 12500, 61) / 60, np.linspace(2e-3, 6e-3, 49))
island.plot()
plt.show()

# %% [markdown]
# ## The recommendation
#
# The highest peak is no place to work: a little less frequency of the tool and its far side, a cliff, is where the peak
# was. So we step back twice:
#
# - in depth: the first-order band shows how much the limit moves with the data's scatter, and we take its lower edge,
#   two standard deviations down;
# - in speed: first order knows slopes and no cliffs. A tool of 1 % more frequency has the whole diagram 1 % to the
#   right, so that the lowest edge within two standard deviations of frequency on either side counts.

# %%
SCATTER = {"modes.angular_frequency": 0.005, "modes.damping_ratio": 0.2, "tangential": 0.1, "normal": 0.1}
band = limit.band(SCATTER)
print(band)
edge = band.interval(2)[0]
near = np.abs(RPM[:, None] / RPM - 1) <= 2 * SCATTER["modes.angular_frequency"]
safe = np.min(np.where(near, edge, np.inf), axis=1)
whole = (RPM / RPM[0] > 1.01) & (RPM / RPM[-1] < 0.99)  # where all of the neighbourhood was looked at
best = int(np.argmax(np.where(whole, safe, 0)))
peak = int(np.argmax(limit.gain))
depth = np.floor(safe[best] * 1e4) / 1e4
print(f"recommended: {RPM[best]:.0f} rpm and {1e3 * depth:.1f} mm; the limit there is {1e3 * limit.gain[best]:.2f} mm")
print(f"the highest peak: {RPM[peak]:.0f} rpm, {1e3 * limit.gain[peak]:.2f} mm; beside it {1e3 * safe[peak]:.2f} mm")

# %% [markdown]
# Is that enough? Let us draw tools from that scatter and ask each one, at the recommended point and at the same speed's
# bare limit, and at the peak with the recommended depth.

# %%
TOOLS = 100
random = np.random.default_rng(0)
draws = {name: 1 + sigma * random.standard_normal(TOOLS) for name, sigma in SCATTER.items()}
points = {
    "recommended point": (speed[best], depth),
    "same speed, at the limit": (speed[best], limit.gain[best]),
    "speed of the highest peak, recommended depth": (speed[peak], depth),
}
held = dict.fromkeys(points, 0)
for i in range(TOOLS):
    modes = lobex.Modes.single(
        frequency=TOOL["frequency"] * draws["modes.angular_frequency"][i],
        damping_ratio=TOOL["damping_ratio"] * draws["modes.damping_ratio"][i],
        mass=TOOL["mass"],
    )
    forces = {name: value * draws[name][i] for name, value in FORCES.items()}
    drawn = lobex.Milling(modes, **forces, **CUT)
    radius = lobex.spectral_radius(drawn, *map(np.array, zip(*points.values(), strict=True)))
    for name, value in zip(points, radius, strict=True):
        held[name] += value < 1
for name, count in held.items():
    print(f"{name}: {count} of {TOOLS} tools are stable")

# %% [markdown]
# ## What simpler codes get wrong
#
# 1. **One interval of polynomials over the whole tooth pass.** The cutting force jumps where a tooth enters and
#    leaves, and a polynomial cannot. `Chebyshev(aligned=False)` does it for comparison; lobex' own methods end their
#    pieces at the jumps.
# 2. **Up- and down-milling exchanged**, which is quickly done: angles are counted from different axes.
# 3. **The first crossing taken for the end of the matter**, which hides the islands above.

# %%
one_interval = lobex.Chebyshev(nodes=40, aligned=False)
# On the limit max|μ| is 1.
error = np.abs(lobex.spectral_radius(mill, limit.speed, limit.gain, one_interval) - 1)
pieces = np.abs(lobex.spectral_radius(mill, limit.speed, limit.gain, lobex.Chebyshev(nodes=40)) - 1)
few = np.s_[::6]
naive = lobex.critical_gain(mill, speed[few], limit.bounds, one_interval, scan=33)
off = np.abs(naive.gain / limit.gain[few] - 1)
print(
    f"max|μ| on the limit, 40 nodes in one interval: off by {np.median(error):.0e} (median), {error.max():.0e} at most"
)
print(f"  the same number of nodes in each piece: {pieces.max():.0e} at most")
print(f"the limit by one interval: off by {100 * np.median(off):.1f} % (median), {100 * off.max():.0f} % at most")

swapped = lobex.sweep(lobex.Milling(mill.modes, **FORCES, **(CUT | {"direction": "down"})), speed, chart.gain)
verdict = np.mean((swapped.spectral_radius < 1) != (chart.spectral_radius < 1))
radius = lobex.spectral_radius(lobex.Milling(mill.modes, **FORCES, **(CUT | {"direction": "down"})), speed[best], depth)
print(f"up and down exchanged: {100 * verdict:.0f} % of the map is called wrong; ", end="")
print(f"the recommended point would have max|μ| = {radius:.2f}")

# %% [markdown]
# ## Conclusion
#
# The recommended point keeps away from the cliff and stays below the band. The one-interval code promises too much
# depth nearly everywhere, by a few percent, and nothing in its output says so.

# %%
figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
low, high = band.interval(2)
axes.fill_between(RPM, 1e3 * low, 1e3 * high, color="#f0c48a", linewidth=0, label="± 2 standard deviations")
axes.plot(RPM, 1e3 * limit.gain, color="#12436d", linewidth=1.6, label="limit")
axes.plot(RPM[few], 1e3 * naive.gain, "x", color="#c8500a", markersize=4.5, label="one interval, 40 nodes")
axes.plot(RPM[best], 1e3 * depth, "*", color="black", markersize=12, label="recommended")
axes.set_xlim(RPM[0], RPM[-1])
axes.set_ylim(0, 14)
axes.set_xlabel("spindle speed (rpm)")
axes.set_ylabel("depth of cut $b$ (mm)")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False, fontsize="small")
plt.show()
