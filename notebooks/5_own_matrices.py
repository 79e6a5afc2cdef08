# %% [markdown]
# # Your own finite-element matrices
#
# Any program that exports a mass and a stiffness matrix can stand for the structure. Here the program is a few lines of
# beam elements; what follows the files is the same for a model of a million elements.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import scipy.io
import scipy.sparse

import lobex

# %% [markdown]
# ## The program: an Euler-Bernoulli beam
#
# A titanium blade that bends like a clamped strip. Each node has a deflection (m) and a slope (rad), each element the
# usual cubic shape functions.

# %%
YOUNG_MODULUS, DENSITY = 114e9, 4430.0  # Pa, kg/m³
LENGTH, WIDTH, THICKNESS = 0.2, 0.06, 0.006  # m
ELEMENTS = 20
area, second_moment = WIDTH * THICKNESS, WIDTH * THICKNESS**3 / 12


def beam(elements):
    """Mass and stiffness of a clamped beam, sparse; degrees of freedom (deflection, slope), clamp to tip."""
    h = LENGTH / elements
    scale = np.diag([1, h, 1, h])  # the slope is times h where the shape functions are without dimension
    stiffness = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
    mass = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    parts = [
        (DENSITY * area * h / 420, np.array(mass)),
        (YOUNG_MODULUS * second_moment / h**3, np.array(stiffness)),
    ]
    size = 2 * (elements + 1)
    whole = []
    for factor, element in parts:
        matrix = scipy.sparse.lil_array((size, size))
        for i in range(elements):
            place = slice(2 * i, 2 * i + 4)
            matrix[place, place] = matrix[place, place].toarray() + factor * scale @ element @ scale
        whole.append(scipy.sparse.csr_array(matrix)[2:, 2:])
    return whole


# %% [markdown]
# ## The files
#
# Matrix Market is plain text, and most programs write it or something that SciPy reads.

# %%
with tempfile.TemporaryDirectory() as folder:
    for name, matrix in zip(("mass.mtx", "stiffness.mtx"), beam(ELEMENTS), strict=True):
        scipy.io.mmwrite(Path(folder) / name, matrix, symmetry="symmetric", precision=17)
    print("\n".join((Path(folder) / "mass.mtx").read_text().splitlines()[:4]))
    mass, stiffness = (scipy.io.mmread(Path(folder) / name, spmatrix=False) for name in ("mass.mtx", "stiffness.mtx"))
print(f"{mass.shape[0]} degrees of freedom, {stiffness.nnz} entries of the stiffness")

# %% [markdown]
# ## Where the blade touches
#
# `contact` says which combination of the degrees of freedom moves the contact point into the coating. This blade
# leans by 10° from the radius and carries a light winglet of 30 mm at its tip, whose edge touches: deflection and
# slope of the last node both count. Of a sparse model the modes that are kept are the only ones computed.

# %%
LEAN, OVERHANG = np.radians(10), 0.03  # rad, m
DAMPING_RATIO = 0.01
contact = np.zeros(mass.shape[0])
contact[-2:] = np.sin(LEAN), OVERHANG * np.cos(LEAN)
modes = lobex.Modes.from_matrices(mass, stiffness, contact, DAMPING_RATIO, keep=[1, 2, 3, 4, 5])

# Roots of cos x cosh x = −1, from any handbook.
WAVE_NUMBERS = np.array([1.875104069, 4.694091133, 7.854757438, 10.99554073, 14.13716839])
handbook = WAVE_NUMBERS**2 / (2 * np.pi) * np.sqrt(YOUNG_MODULUS * second_moment / (DENSITY * area)) / LENGTH**2
deviation = np.abs(modes.frequency / handbook - 1)
for number, (found, exact, error) in enumerate(zip(modes.frequency, handbook, deviation, strict=True), start=1):
    print(f"mode {number}: {found:9.3f} Hz, handbook {exact:9.3f} Hz, {100 * error:.4f} % apart")

# %% [markdown]
# ## The lobe diagram
#
# From here on nothing differs from any other structure. How many modes does the limit need?

# %%
SPEED = np.linspace(30.0, 150.0, 601)
limits = {
    count: lobex.critical_gain(lobex.Rub(modes.select(range(1, count + 1))), SPEED, bounds=(1.0, 1e7))
    for count in (1, 2, 5)
}
full = limits[5].gain
for count in (1, 2):
    ratio = limits[count].gain / full
    worst = np.argmax(np.abs(np.log(ratio)))
    print(
        f"{count} of 5 modes: off by {100 * np.median(np.abs(ratio - 1)):.1f} % in the median; "
        f"{ratio[worst]:.2f} times the limit at worst, at {SPEED[worst]:.1f} Hz"
    )

chart = lobex.sweep(lobex.Rub(modes), np.linspace(30, 150, 241), np.linspace(0, 0.8 * full.max(), 61))
print(chart)

# %% [markdown]
# ## Conclusion
#
# The bottoms of the large lobes belong to the first mode, and one mode is enough for them. The peaks between them,
# where one would want to run, are another matter: there the second mode chatters first, and a model of one mode
# promises what the blade does not hold. Two modes tell nearly all; the picture shows where they do.

# %%
wrong = np.argmax(limits[1].gain / full)
best = np.argmax(full)
print(f"{SPEED[wrong]:.1f} Hz: one mode promises {limits[1].gain[wrong] / 1e3:.0f} kN/m, ", end="")
print(f"the blade chatters at {full[wrong] / 1e3:.0f} kN/m with {limits[5].chatter_frequency[wrong]:.0f} Hz")
print(f"{SPEED[best]:.1f} Hz has the highest limit, {full[best] / 1e3:.0f} kN/m")

figure, axes = plt.subplots(figsize=(7.0, 4.6), layout="constrained")
LOOKS = {1: ("#c8500a", (0, (6, 2)), 1.2), 2: ("#5d8a3a", (0, (5, 1.5, 1, 1.5)), 1.2), 5: ("#12436d", "-", 1.8)}
axes.fill_between(SPEED, full / 1e3, color="#d6e6f2", linewidth=0, label="stable")
for count, limit in limits.items():
    colour, dash, width = LOOKS[count]
    plural = "mode" if count == 1 else "modes"
    axes.plot(SPEED, limit.gain / 1e3, color=colour, linestyle=dash, linewidth=width, label=f"{count} {plural}")
axes.set_xlim(SPEED[0], SPEED[-1])
axes.set_ylim(0, 1.3 * full.max() / 1e3)
axes.set_xlabel("rotational frequency (Hz)")
axes.set_ylabel("critical contact stiffness $K_e$ (kN/m)")
axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, frameon=False, fontsize="small")
plt.show()

# %%
chart.plot()
plt.show()
