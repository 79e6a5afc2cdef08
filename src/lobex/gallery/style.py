"""How all figures of the gallery look: lines told apart in grey, too, and the labels that they share."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPEED = "rotational frequency (Hz)"
CRITICAL = "critical contact stiffness $K_e$ (MN/m)"
# Pale to dark, so that it reads in grey.
BLUES = ("#f2f7fb", "#b3d3e8", "#5b8fb9", "#12436d", "#061c30")
LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "#12436d", "linestyle": "-", "linewidth": 1.5},
    {"color": "#c8500a", "linestyle": (0, (6, 2)), "linewidth": 1.4},
    {"color": "#5d8a3a", "linestyle": (0, (5, 1.5, 1, 1.5)), "linewidth": 1.4},
    {"color": "#7a4b94", "linestyle": (0, (1.2, 1.2)), "linewidth": 1.5},
)
REFERENCE: dict[str, Any] = {"color": "0.15", "linestyle": "-", "linewidth": 2.6, "alpha": 0.35}
"""What the lines are measured against: broad and pale, so that a line on top of it stays visible."""


def panels(rows: int, height: float, **options: Any) -> "tuple[Figure, Any]":
    """A figure of one column; the axes, or an array of them."""
    import matplotlib.pyplot as plt

    return plt.subplots(rows, 1, figsize=(7.0, height), layout="constrained", **options)


def legend_above(ax: "Axes", columns: int) -> None:
    """The legend over the axes, where it hides nothing."""
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, frameon=False, fontsize="small")


def over_speed(ax: "Axes", speed: np.ndarray, label: str, named: bool = True) -> None:
    """Limits and labels of axes over the rotational frequency, Hz."""
    ax.set_xlim(float(speed[0]), float(speed[-1]))
    ax.set_ylabel(label)
    if named:
        ax.set_xlabel(SPEED)


def letter(ax: "Axes", text: str) -> None:
    """The panel's letter, left above it."""
    ax.text(-0.05, 1.02, text, transform=ax.transAxes, ha="right", va="bottom", fontweight="bold")


def draw_map(ax: "Axes", data: Any, along: str, label: str, lowest: float, highest: float) -> None:
    """Critical stiffnesses in MN/m over speed and ``along``, on a logarithmic scale between two of them."""
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    speed, value = data["speed"].to_numpy(), data[along].to_numpy()
    # A limit of zero has no logarithm and is drawn as below the scale.
    gain = np.maximum(data["critical_stiffness"].to_numpy() / 1e6, lowest / 2)
    colours = LinearSegmentedColormap.from_list("limit", BLUES)
    mesh = ax.pcolormesh(
        speed, value, gain, cmap=colours, norm=LogNorm(lowest, highest), shading="gouraud", rasterized=True
    )
    over_speed(ax, speed, label)
    ax.set_ylim(float(value[0]), float(value[-1]))
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.02, extend="both", format="{x:g}")
    bar.set_label(CRITICAL)
