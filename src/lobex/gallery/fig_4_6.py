"""Fig. 4.6: the limit as the rod's stiffness changes."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The exact limits at α from 0.1 to 2, K' = αK (4.1)."""
    speed, factor = models.grid(50, 400, 351, share), models.grid(0.1, 2.0, 191, share)
    return parameter.limits_of(lambda alpha: models.rub(stiffness=alpha), "stiffness_factor", factor, speed)


def draw(results: Results) -> "Figure":
    """The map."""
    return parameter.draw_map(results, "stiffness factor $\\alpha$", 0.05, 10)


def findings(results: Results) -> list[Finding]:
    """The scaling law of the stiffness."""
    data = results["stiffness_factor"]
    factor, speed = data["stiffness_factor"].to_numpy(), data["speed"].to_numpy()
    rows = np.unique(np.linspace(0, len(factor) - 1, 5).astype(int))
    gain = data["critical_stiffness"].to_numpy()
    apart = max(
        float(np.abs(gain[i] / (factor[i] * models.limits(models.rub(), speed / np.sqrt(factor[i]))[0]) - 1).max())
        for i in rows
    )
    place = data["lobe_speed"].to_numpy()
    power = float(np.polyfit(np.log(factor), np.log(place[:, 0]), 1)[0])
    return [
        Finding(
            "Lobes shift with the square root of the stiffness and expand.",
            "evolution as a square root",
            f"their speeds go as α to the power {power:.6f}",
            abs(power - 0.5) < 1e-6,
            numbers={"power": power},
        ),
        Finding(
            "Each lobe expands as stiffness and speed grow.",
            "global expansion",
            f"K_c(αK; f) = α K_c(K; f/√α) within {apart:.0e}: the diagram of one stiffness is that of all",
            apart < 1e-6,
            numbers={"apart": apart},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.6",
    "Influence of the rod's stiffness",
    "A stiffer rod has its lobes at higher speeds, by the square root, and larger.",
    compute,
    draw,
    findings,
)
