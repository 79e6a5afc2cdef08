"""Fig. 1.2: the casing before wear."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The profile over the angle and along the perimeter."""
    import xarray

    casing = lobex.Casing(nodal_diameters=2, amplitude=1e-4)
    cells = max(round(2048 * share), 64)
    turn = np.arange(cells) / cells
    radius = float(np.asarray(casing.radius))
    return {
        "casing": xarray.Dataset(
            {"profile": ("angle", np.asarray(casing.profile(cells)), {"units": "m", "long_name": "surface, outwards"})},
            {
                "angle": ("angle", 2 * np.pi * turn, {"units": "rad"}),
                "position": ("angle", 2 * np.pi * radius * turn, {"units": "m"}),
            },
            {"radius": radius, "nodal_diameters": casing.nodal_diameters},
        )
    }


def draw(results: Results) -> "Figure":
    """Around the tip's circle, exaggerated, and rolled out in true size."""
    import matplotlib.pyplot as plt

    data = results["casing"]
    figure = plt.figure(figsize=(7.6, 4.2), layout="constrained")
    left, right = figure.add_gridspec(1, 2, width_ratios=(1, 1.15))
    polar = figure.add_subplot(left, projection="polar")
    lobex.Casing(surface=data["profile"].to_numpy(), radius=data.attrs["radius"]).plot(polar)
    polar.set_title(polar.get_title(), fontsize="small", wrap=True)
    # The other panel's legend serves both.
    if legend := polar.get_legend():
        legend.remove()
    flat = figure.add_subplot(right)
    flat.axhline(0, color="0.35", linestyle=":", linewidth=1.0, label="blade tip at rest")
    flat.plot(data["position"], data["profile"] * 1e6, label="casing before wear", **style.LOOKS[0])
    flat.set_xlim(0, 2 * np.pi * data.attrs["radius"])
    flat.set_xlabel("position along the casing (m)")
    flat.set_ylabel("surface, positive outwards (µm)")
    style.legend_above(flat, 2)
    return figure


def findings(results: Results) -> list[Finding]:
    """Size and shape."""
    data = results["casing"]
    profile = data["profile"].to_numpy()
    perimeter = 2 * np.pi * data.attrs["radius"]
    harmonics = np.abs(np.fft.rfft(profile - profile.mean()))
    main = int(np.argmax(harmonics))
    return [
        Finding(
            "A casing of 1 m diameter has a perimeter of about 3.14 m.",
            "3.14 m",
            f"{perimeter:.4f} m",
            round(perimeter, 2) == 3.14,
            numbers={"perimeter": perimeter},
        ),
        Finding(
            "The profile has two nodal diameters and takes up the initial tip clearance.",
            "ovoid, two nodal diameters, by a 'blister' function; no numbers given",
            f"largest harmonic {main} per revolution; bumps reach {-profile.min() * 1e6:.0f} µm inside the tip's "
            f"circle, and between them the clearance is {profile.max() * 1e6:.0f} µm",
            main == 2,
            "Height, width and clearance are ours: cos² bumps of 0.1 mm over half the casing, no clearance.",
            {"harmonic": main, "height": -float(profile.min()), "clearance": float(profile.max())},
        ),
    ]


FIGURE = Reproduction(
    "fig-1.2",
    "Shape of the abradable layer before wear",
    "The casing is ovoid, with two nodal diameters, so that the blade meets it twice per revolution.",
    compute,
    draw,
    findings,
)
