"""Fig. 3.1: Chebyshev points as projections from a half circle."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_INTERVALS = 16


def compute(share: float = 1.0) -> Results:
    """The points of (3.10), and the phases at which lobex' collocation samples the delay. Always m = 16."""
    import jax
    import xarray

    index = np.arange(_INTERVALS + 1)
    with jax.enable_x64(True):
        system = models.turning().system(80.0, 1e-4)
        phase = np.asarray(lobex.Chebyshev(nodes=_INTERVALS + 1, aligned=False).operator(system).phase)
    return {
        "points": xarray.Dataset(
            {
                "x": ("index", np.cos(index * np.pi / _INTERVALS)),
                "angle": ("index", index * np.pi / _INTERVALS, {"units": "rad"}),
                "phase": ("index", phase, {"long_name": "t/τ of lobex' collocation points, increasing", "units": "1"}),
            },
            {"index": ("index", index)},
        )
    }


def draw(results: Results) -> "Figure":
    """Equal angles on the half circle, and below them the points."""
    points = results["points"]
    x, angle = points["x"].to_numpy(), points["angle"].to_numpy()
    figure, ax = style.panels(1, 4.0)
    turn = np.linspace(0, np.pi, 361)
    ax.plot(np.cos(turn), np.sin(turn), color="0.35", linewidth=1.0)
    ax.vlines(x, 0, np.sin(angle), color="0.6", linewidth=0.8, linestyle=(0, (3, 2)))
    ax.axhline(0, color="0.35", linewidth=1.0)
    ax.plot(np.cos(angle), np.sin(angle), "o", color="white", markeredgecolor="0.2", markersize=5, label="equal angles")
    ax.plot(x, 0 * x, "o", color=style.LOOKS[0]["color"], markersize=5, clip_on=False, label="Chebyshev points $x_j$")
    ax.annotate("$x_0 = 1$", (1, 0), xytext=(0, -9), textcoords="offset points", ha="center", va="top")
    ax.annotate(
        f"$x_{{{_INTERVALS}}} = -1$", (-1, 0), xytext=(0, -9), textcoords="offset points", ha="center", va="top"
    )
    ax.annotate("$x_j = \\cos(j\\pi/m)$, $m = 16$", (0, 0.42), ha="center", bbox={"facecolor": "white", "linewidth": 0})
    ax.set_aspect("equal")
    ax.set_ylim(-0.16, 1.08)
    ax.set_axis_off()
    style.legend_above(ax, 2)
    return figure


def _derivative(x: np.ndarray, doubled: tuple[int, int]) -> np.ndarray:
    """The differentiation matrix as it is written under (3.11), c = 2 at the two indices."""
    m = len(x) - 1
    c = np.where(np.isin(np.arange(m + 1), doubled), 2.0, 1.0)
    sign = (-1.0) ** np.add.outer(np.arange(m + 1), np.arange(m + 1))
    with np.errstate(divide="ignore"):
        matrix = np.outer(c, 1 / c) * sign / np.subtract.outer(x, x)
    np.fill_diagonal(matrix, np.r_[0.0, -x[1:-1] / (2 * (1 - x[1:-1] ** 2)), 0.0])
    matrix[0, 0], matrix[m, m] = (2 * m**2 + 1) / 6, -(2 * m**2 + 1) / 6
    return matrix


def findings(results: Results) -> list[Finding]:
    """The points, their polynomials and their differentiation matrix, corrected and as printed."""
    points = results["points"]
    x, m = points["x"].to_numpy(), _INTERVALS
    same = float(np.abs((1 - x) / 2 - points["phase"].to_numpy()).max())
    gaps = -np.diff(x)
    wanted = 5 * x**4
    errors = [float(np.abs(_derivative(x, ends) @ x**5 - wanted).max()) for ends in ((0, m), (1, m))]
    order = np.arange(m + 1)
    extremes = float(np.abs(np.abs(np.cos(m * np.arccos(x))) - 1).max())
    undefined = int(np.sum(np.abs(order * x) > 1 + 1e-12))
    return [
        Finding(
            "Collocation takes the unevenly spaced points cos(jπ/m), ordered from right to left.",
            "x_j = cos(jπ/m), j = 0 … m",
            f"lobex' points are the same, mapped to the delay, within {same:.0e}; the gaps at the ends are "
            f"{gaps[0] / gaps.max():.3f} of those in the middle",
            same < 1e-14,
            "m intervals have m + 1 points; the thesis' codes count m points.",
            {"apart": same, "gap": float(gaps[0] / gaps.max())},
        ),
        Finding(
            "The polynomials are T_j with T_j(x_j) = arccos(j x_j).",
            "T_j(x_j) = arccos(j x_j)",
            f"arccos(j x_j) has no real value for {undefined} of the {m + 1} points; T_j(x) = cos(j arccos x), and the "
            "points are where |T_m| = 1",
            False,
            "A slip in the text: cos and arccos are exchanged. No figure depends on it.",
            {"extremes": extremes, "undefined": undefined},
        ),
        Finding(
            "The differentiation matrix has c_i = 2 for i = 1 and m.",
            "c_1 = c_m = 2",
            f"the derivative of x⁵ is then wrong by {errors[1]:.1f}; with c_0 = c_m = 2 by {errors[0]:.0e}",
            False,
            "A slip in the text: the doubled ones are the ends, 0 and m. The thesis' code takes cheb.m, which is "
            "right.",
            {"as_printed": errors[1], "corrected": errors[0]},
        ),
    ]


FIGURE = Reproduction(
    "fig-3.1",
    "Chebyshev points",
    "The points are projections of equal angles on a half circle, dense at the ends of the interval.",
    compute,
    draw,
    findings,
)
