"""Fig. 2.6: the analytic stability lobe diagram of turning."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import fig_2_5, models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RPM = (2000.0, 14000.0)
_LOBES = 6


def compute(share: float = 1.0) -> Results:
    """The lobes as curves over the chatter frequency, and the limit under them."""
    import xarray

    process = models.turning()
    lobes = lobex.exact_lobes(process, _LOBES)
    rpm = models.grid(*_RPM, 601, share)
    depth, frequency = models.limits(process, rpm / 60)
    return {
        "lobes": xarray.Dataset(
            {
                "depth": ("frequency", np.asarray(lobes.gain), {"units": "m", "long_name": "depth of cut"}),
                "speed": (("lobe", "frequency"), np.asarray(lobes.speed), {"units": "Hz"}),
            },
            {
                "frequency": ("frequency", np.asarray(lobes.angular_frequency) / (2 * np.pi), {"units": "Hz"}),
                "lobe": ("lobe", np.arange(1, _LOBES + 1)),
            },
            {"least_depth": float(lobes.minimum.gain), "least_speeds": np.asarray(lobes.minimum.speed)},
        ),
        "limit": xarray.Dataset(
            {
                "depth": ("speed", depth, {"units": "m", "long_name": "critical depth of cut"}),
                "chatter_frequency": ("speed", frequency, {"units": "Hz"}),
            },
            {"speed": ("speed", rpm / 60, {"units": "Hz"})},
        ),
    }


def draw(results: Results) -> "Figure":
    """Lobes, the limit as their lower envelope, and the two cuts of Fig. 2.5."""
    lobes, limit = results["lobes"], results["limit"]
    figure, ax = style.panels(1, 4.2)
    rpm, depth = 60 * limit["speed"], 1e3 * limit["depth"]
    least, most = 0.03, 10.0
    ax.fill_between(rpm, least, depth.clip(max=most), color="#d6e6f2", linewidth=0, label="stable")
    for lobe in lobes["lobe"].to_numpy():
        speed = 60 * lobes["speed"].sel(lobe=lobe)
        label = "lobes 1, 2, …" if lobe == 1 else None
        ax.plot(speed, 1e3 * lobes["depth"], color="0.45", linewidth=0.8, linestyle=(0, (4, 2)), label=label)
        lowest = 60 * lobes.attrs["least_speeds"][lobe - 1]
        if _RPM[0] < lowest < _RPM[1]:
            ax.text(lowest, 1.1 * least, str(lobe), ha="center", va="bottom", fontsize="small")
    ax.plot(rpm, depth, label="stability limit", **style.LOOKS[0])
    for deep, marker, name in zip(fig_2_5.DEPTHS, "os", ("stable", "unstable"), strict=True):
        ax.plot(
            60 * fig_2_5.SPEED,
            1e3 * deep,
            marker,
            color=style.LOOKS[1]["color"],
            markerfacecolor="white" if name == "stable" else style.LOOKS[1]["color"],
            linestyle="none",
            label=f"{name} cut of Fig. 2.5",
        )
    ax.set_xlim(*_RPM)
    ax.set_yscale("log")
    ax.set_ylim(least, most)
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set_xlabel("spindle speed (rpm)")
    ax.set_ylabel("depth of cut $b$ (mm)")
    style.legend_above(ax, 3)
    return figure


def findings(results: Results) -> list[Finding]:
    """The minimum in closed form, and the limit against an operator."""
    process, limit = models.turning(), results["limit"]
    modes = process.modes
    ratio = float(np.asarray(modes.damping_ratio)[0])
    stiffness = float(np.asarray(modes.angular_frequency)[0] ** 2 / np.asarray(modes.shape)[0, 0] ** 2)
    closed = 2 * stiffness * ratio * (1 + ratio) / models.RADIAL
    least = results["lobes"].attrs["least_depth"]
    some = limit.isel(speed=slice(None, None, max(limit.sizes["speed"] // 12, 1)))
    depth = some["depth"].to_numpy()
    around = np.stack([0.99 * depth, depth, 1.01 * depth], axis=-1)
    radius = lobex.spectral_radius(process, some["speed"].to_numpy()[:, None], around, lobex.Chebyshev(40))
    found = float(np.mean((radius[:, 0] < 1) & (radius[:, 2] > 1)))
    return [
        Finding(
            "The boundary is where a root of the characteristic equation has a real part of zero: stable below it, "
            "unstable above.",
            "stable for b < b_lim",
            f"at {100 * found:.0f} % of {len(depth)} speeds Chebyshev collocation has max|μ| < 1 one percent below "
            "and > 1 one percent above",
            found == 1,
            numbers={"share": found, "worst": float(np.abs(radius[:, 1] - 1).max())},
        ),
        Finding(
            "The figure is an example without numbers; for one mode the least limit is 2kξ(1 + ξ)/K_r.",
            "no value given",
            f"{1e3 * least:.5f} mm, in closed form {1e3 * closed:.5f} mm",
            bool(abs(least / closed - 1) < 1e-9),
            numbers={"least": least, "closed_form": closed},
        ),
    ]


FIGURE = Reproduction(
    "fig-2.6",
    "Stability lobe diagram of turning",
    "Lobes bound the depths of cut: any cut under them is stable, and speeds between two lobes allow deeper ones.",
    compute,
    draw,
    findings,
)
