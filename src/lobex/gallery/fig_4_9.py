"""Fig. 4.9: the limit at two masses of the rod."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The exact limits at β = 0.5 and 1.5."""
    speed = models.grid(50, 400, 701, share)
    return parameter.limits_of(lambda beta: models.rub(mass=beta), "mass_factor", (0.5, 1.5), speed)


def draw(results: Results) -> "Figure":
    """Both limits."""
    return parameter.draw_pair(results, "mass factor $\\beta$", 4.5)


def findings(results: Results) -> list[Finding]:
    """Shift to the left at the same height."""
    data = results["mass_factor"]
    least, place = data["least_stiffness"].to_numpy(), data["lobe_speed"].to_numpy()
    up, left = float(least[1] / least[0]), float(place[1, 0] / place[0, 0])
    return [
        Finding(
            "The mass affects the position of the lobes and not their size.",
            "no vertical translation",
            f"least limits of {least[0] / 1e6:.6f} and {least[1] / 1e6:.6f} MN/m, a ratio of 1 within "
            f"{abs(up - 1):.0e}",
            abs(up - 1) < 1e-9,
            numbers={"up": up},
        ),
        Finding(
            "The lobes move to lower speeds.",
            "to the left",
            f"by a factor of {left:.5f} from β = 0.5 to 1.5, where 1/√3 = {1 / np.sqrt(3):.5f}",
            abs(left * np.sqrt(3) - 1) < 1e-6,
            numbers={"left": left},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.9",
    "Limits at two masses",
    "The mass moves the lobes and leaves their size.",
    compute,
    draw,
    findings,
)
