"""Fig. 4.12: the four points that are integrated in time."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEEDS = (85.0, 112.0)
STIFFNESSES = (4.5e5, 1.35e6)
_CAPTION = 1.35e5


def compute(share: float = 1.0) -> Results:
    """The map around the points, the points themselves and, third, what the caption of Fig. 4.13 prints."""
    process = models.rub()
    speed, stiffness = models.grid(50, 250, 301, share), models.grid(*models.CONTACT_STIFFNESS, 151, share)
    return {
        "map": lobex.sweep(process, speed, stiffness),
        "points": lobex.sweep(process, SPEEDS, (_CAPTION, *STIFFNESSES)),
        "limit": models.family(
            "method", ["D-subdivision"], np.array(SPEEDS), [models.limits(process, np.array(SPEEDS))[0]]
        ),
    }


def draw(results: Results) -> "Figure":
    """The map with the points, hollow where stable."""
    figure, ax = style.panels(1, 4.6)
    results["map"].plot(ax)
    points = results["points"]
    handles, labels = [], []
    for stable, name in ((True, "stable point"), (False, "unstable point")):
        row, column = np.nonzero((points.spectral_radius[:, 1:] < 1) == stable)
        (line,) = ax.plot(
            points.speed[row],
            points.gain[1:][column] / 1e6,
            linestyle="none",
            marker="o" if stable else "s",
            markersize=6.5,
            markerfacecolor="white" if stable else "black",
            markeredgecolor="black",
            zorder=5,
        )
        handles.append(line)
        labels.append(name)
    old = ax.get_legend()
    names = [text.get_text() for text in old.get_texts()]
    ax.legend(
        [*old.legend_handles, *handles],
        [*names, *labels],
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=3,
        frameon=False,
        fontsize="small",
    )
    return figure


def findings(results: Results) -> list[Finding]:
    """The multipliers at the points."""
    radius = results["points"].spectral_radius
    critical = results["limit"]["critical_stiffness"].to_numpy()[0]
    distance = STIFFNESSES[1] / critical
    return [
        Finding(
            "At 85 and at 112 Hz, 4.5·10⁵ N/m is stable and 1.35·10⁶ N/m unstable.",
            "stable, unstable",
            "; ".join(
                f"{speed:g} Hz: max|μ| = {row[1]:.4f} and {row[2]:.4f}"
                for speed, row in zip(SPEEDS, radius, strict=True)
            ),
            bool(np.all(radius[:, 1] < 1) and np.all(radius[:, 2] > 1)),
            "K_e is in N/m; the text also prints N/m².",
            {
                "stable_85": float(radius[0, 1]),
                "unstable_85": float(radius[0, 2]),
                "stable_112": float(radius[1, 1]),
                "unstable_112": float(radius[1, 2]),
            },
        ),
        Finding(
            "The caption of Fig. 4.13 calls 1.35·10⁵ N/m unstable.",
            "1.35·10⁵ unstable",
            f"max|μ| = {radius[0, 0]:.4f} and {radius[1, 0]:.4f}: stable at both speeds",
            False,
            "A slip: the text of §4.4 has 1.35·10⁶, which is unstable.",
            {"caption_85": float(radius[0, 0]), "caption_112": float(radius[1, 0])},
        ),
        Finding(
            "The unstable point is much closer to the stable domain at 112 than at 85 Hz.",
            "much closer",
            f"1.35 MN/m is {distance[0]:.2f} times the limit at 85 Hz and {distance[1]:.2f} times at 112 Hz",
            bool(distance[1] < distance[0]),
            numbers={"ratio_85": float(distance[0]), "ratio_112": float(distance[1])},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.12",
    "The four points that are integrated in time",
    "Two points lie in the stable and two in the unstable domain.",
    compute,
    draw,
    findings,
)
