"""Fig. 4.7: the limit at two stiffnesses of the rod."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The exact limits at α = 0.5 and 1.5."""
    speed = models.grid(50, 400, 701, share)
    return parameter.limits_of(lambda alpha: models.rub(stiffness=alpha), "stiffness_factor", (0.5, 1.5), speed)


def draw(results: Results) -> "Figure":
    """Both limits."""
    return parameter.draw_pair(results, "stiffness factor $\\alpha$", 4.5)


def findings(results: Results) -> list[Finding]:
    """Shift to the right and upwards."""
    data = results["stiffness_factor"]
    least, place = data["least_stiffness"].to_numpy(), data["lobe_speed"].to_numpy()
    up, right = float(least[1] / least[0]), float(place[1, 0] / place[0, 0])
    return [
        Finding(
            "The lobes move to higher speeds.",
            "lateral translation",
            f"by a factor of {right:.5f} from α = 0.5 to 1.5, where √3 = {np.sqrt(3):.5f}",
            abs(right / np.sqrt(3) - 1) < 1e-6,
            numbers={"right": right},
        ),
        Finding(
            "They also move up, which makes the stable domain slightly larger.",
            "increases slightly",
            f"the least limit goes up from {least[0] / 1e6:.3f} to {least[1] / 1e6:.3f} MN/m, by a factor of {up:.4f}",
            False,
            "It moves up, but not slightly: in proportion to the stiffness. On an axis to 4.5 MN/m the lobes' feet "
            "hardly show it.",
            {"up": up},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.7",
    "Limits at two stiffnesses",
    "With the stiffness the lobes move to the right and up.",
    compute,
    draw,
    findings,
)
