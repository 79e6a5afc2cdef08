"""Fig. 4.10: the limit as the damping changes."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The exact limits at ξ from 0 to 0.05."""
    speed, ratio = models.grid(50, 400, 351, share), models.grid(0.0, 0.05, 101, share)
    return parameter.limits_of(lambda xi: models.rub(damping_ratio=xi), "damping_ratio", ratio, speed)


def draw(results: Results) -> "Figure":
    """The map."""
    return parameter.draw_map(results, "damping ratio $\\xi$", 0.05, 10)


def findings(results: Results) -> list[Finding]:
    """The limit grows in proportion to the damping."""
    data = results["damping_ratio"]
    ratio, gain = data["damping_ratio"].to_numpy(), data["critical_stiffness"].to_numpy()
    modes: Any = models.rub().modes
    stiffness = float(np.asarray(modes.angular_frequency)[0] ** 2 / np.asarray(modes.shape)[0, 0] ** 2)
    some = ratio[ratio > 0]
    closed = 2 * stiffness * some * (1 + some)
    single = np.array(
        [models.least(models.rub(damping_ratio=float(xi), keep=(1,)))[0] for xi in some[:: len(some) // 5]]
    )
    apart = float(np.abs(single / closed[:: len(some) // 5] - 1).max())
    whole = data["least_stiffness"].to_numpy()[ratio > 0] / closed
    none = gain[ratio == 0][0]
    undamped = float(np.mean(none == 0))
    return [
        Finding(
            "Damping expands the stable domain.",
            "expansion",
            f"mode 1 alone has a least limit of 2kξ(1 + ξ) within {apart:.0e}; all modes have "
            f"{100 * (whole.min() - 1):.1f} to {100 * (whole.max() - 1):.1f} % more",
            apart < 1e-9 and bool(np.all(np.diff(data["least_stiffness"].to_numpy()) > 0)),
            numbers={"apart": apart, "least_over": float(whole.min()), "most_over": float(whole.max())},
        ),
        Finding(
            "The map begins without damping, at ξ = 0.",
            "ξ from 0 to 0.05",
            f"there the limit is zero at {100 * undamped:.0f} % of the speeds, and at most {none.max() / 1e6:.2f} MN/m",
            True,
            "To first order contact feeds mode n where sin(ω_n τ) < 0, however soft it is: one such mode is enough.",
            {"undamped": undamped, "most_undamped": float(none.max())},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.10",
    "Influence of the damping ratio",
    "Damping enlarges the stable domain and does not move the lobes.",
    compute,
    draw,
    findings,
)
