# %% [markdown]
# # Quickstart in five minutes
#
# A blade rubs the abradable coating of its casing. The tip meets the surface that it left one revolution ago, and that
# feedback may make a small vibration grow. At which speeds, and up to which contact stiffness, does it die out?
#
# Everything is in SI units: speeds are revolutions per second (Hz), contact stiffnesses N/m.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import lobex

# %% [markdown]
# ## A structure, a process, two points
#
# The structure is a clamped rod; a process says what feeds its past back to it. `spectral_radius` is the factor by
# which the least damped motion changes from one revolution to the next: below 1 it dies out, above 1 it grows.

# %%
blade = lobex.Rod(elements=5, young_modulus=210e7, density=4600.0, length=0.5, area=10e-4)
rub = lobex.Rub(blade.modes(damping_ratio=0.03))
print("natural frequencies (Hz):", np.round(rub.modes.frequency, 1))

STIFFNESS = 0.8e6  # of the contact, N/m
SPEEDS = np.array([112.0, 200.0])  # two candidates, revolutions per second
radius = lobex.spectral_radius(rub, SPEEDS, STIFFNESS)
for speed, value in zip(SPEEDS, radius, strict=True):
    print(f"{speed:.0f} Hz: times {value:.4f} per revolution, {'dies out' if value < 1 else 'grows'}")

# %% [markdown]
# ## The whole map, and the limit
#
# A sweep computes every point of a grid. The limit itself needs no grid: `critical_gain` finds it to rounding here, and
# says of each speed whether there is one, of which kind, and at which frequency the blade would chatter.

# %%
chart = lobex.sweep(rub, speed=np.linspace(60, 240, 181), gain=np.linspace(0, 2.4e6, 61))
limit = lobex.critical_gain(rub, chart.speed, bounds=(1e4, 5e6))
print(limit)
best, worst = np.argmax(limit.gain), np.argmin(limit.gain)
print(f"most stable:  {limit.speed[best]:.0f} Hz, up to {limit.gain[best] / 1e6:.3f} MN/m")
print(f"least stable: {limit.speed[worst]:.0f} Hz, up to {limit.gain[worst] / 1e6:.3f} MN/m")

gap = np.abs(chart.critical_gain() / limit.gain - 1)
print(f"read from the map between its grid points, the limit is off by {100 * np.nanmax(gap):.1f} % at most")

# %% [markdown]
# ## A file that others can open
#
# NetCDF-4, with units and the model inside; Python, MATLAB and Julia read it.

# %%
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "rub.nc"
    chart.save(path)
    again = lobex.load(path)
print("read back equal:", np.array_equal(again.spectral_radius, chart.spectral_radius))

# %% [markdown]
# ## The proof in time
#
# The multipliers are a claim about motions, so let us march one: a tip that is let go from 1 µm, at both speeds.

# %%
REVOLUTIONS = 12
march = lobex.march_delay(rub, SPEEDS, STIFFNESS, lambda time: 1e-6, REVOLUTIONS, 1000, every=2)
for speed, growth, value in zip(SPEEDS, march.growth, radius, strict=True):
    print(f"{speed:.0f} Hz: the march changes by {growth:.4f} per revolution, max|μ| is {value:.4f}")

# %% [markdown]
# ## Conclusion
#
# At the same contact stiffness the slower of the two speeds is safe and the faster one is not: the limit goes up and
# down with the speed in lobes. The map says it, and the motions in time follow it.

# %%
figure, (upper, *lower) = plt.subplots(3, 1, figsize=(7.0, 7.6), layout="constrained", height_ratios=(3, 1, 1))
chart.plot(upper)
for axes, speed, time, tip, mark in zip(lower, SPEEDS, march.time, march.displacement[..., 0], "os", strict=True):
    upper.plot(speed, STIFFNESS / 1e6, mark, color="black", markerfacecolor="white", markersize=8)
    upper.annotate(
        f"{speed:.0f} Hz",
        (speed, STIFFNESS / 1e6),
        xytext=(9, 6),
        textcoords="offset points",
        fontweight="bold",
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1},
    )
    axes.plot(1e3 * time, 1e6 * tip, color="#12436d", linewidth=0.9)
    axes.plot(0.02, 0.86, mark, color="black", markerfacecolor="white", transform=axes.transAxes, markersize=7)
    axes.text(0.04, 0.86, f"{speed:.0f} Hz", transform=axes.transAxes, va="center", fontweight="bold")
    axes.set_xlim(0, 1e3 * time[-1])
    axes.margins(y=0.15)
    axes.set_ylabel("tip (µm)")
lower[-1].set_xlabel("time (ms)")
plt.show()
