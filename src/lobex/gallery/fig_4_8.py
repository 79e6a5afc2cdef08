"""Fig. 4.8: the limit as the rod's mass changes."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The exact limits at β from 0.1 to 2, M' = βM (4.2)."""
    speed, factor = models.grid(50, 400, 351, share), models.grid(0.1, 2.0, 191, share)
    return parameter.limits_of(lambda beta: models.rub(mass=beta), "mass_factor", factor, speed)


def draw(results: Results) -> "Figure":
    """The map."""
    return parameter.draw_map(results, "mass factor $\\beta$", 0.3, 10)


def findings(results: Results) -> list[Finding]:
    """The scaling law of the mass."""
    data = results["mass_factor"]
    factor, speed = data["mass_factor"].to_numpy(), data["speed"].to_numpy()
    rows = np.unique(np.linspace(0, len(factor) - 1, 5).astype(int))
    gain = data["critical_stiffness"].to_numpy()
    apart = max(
        float(np.abs(gain[i] / models.limits(models.rub(), speed * np.sqrt(factor[i]))[0] - 1).max()) for i in rows
    )
    power = float(np.polyfit(np.log(factor), np.log(data["lobe_speed"].to_numpy()[:, 0]), 1)[0])
    return [
        Finding(
            "Lobes shift to the left, with the inverse square root of the mass.",
            "inverse of a square root",
            f"their speeds go as β to the power {power:.6f}",
            abs(power + 0.5) < 1e-6,
            numbers={"power": power},
        ),
        Finding(
            "The mass has its effect through the natural frequencies alone.",
            "follows the evolution of the eigenfrequencies",
            f"K_c(βM; f) = K_c(M; f√β) within {apart:.0e}",
            apart < 1e-6,
            numbers={"apart": apart},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.8",
    "Influence of the rod's mass",
    "A heavier rod has its lobes at lower speeds, by the inverse square root.",
    compute,
    draw,
    findings,
)
