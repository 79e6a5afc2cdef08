"""Fig. 4.11: the limit at two damping ratios."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, parameter
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RATIOS = (0.015, 0.04)


def compute(share: float = 1.0) -> Results:
    """The exact limits at ξ = 0.015 and 0.04."""
    speed = models.grid(50, 400, 701, share)
    return parameter.limits_of(lambda xi: models.rub(damping_ratio=xi), "damping_ratio", _RATIOS, speed)


def draw(results: Results) -> "Figure":
    """Both limits."""
    return parameter.draw_pair(results, "damping ratio $\\xi$", 4.5)


def findings(results: Results) -> list[Finding]:
    """Up, and hardly aside."""
    data = results["damping_ratio"]
    least, place = data["least_stiffness"].to_numpy(), data["lobe_speed"].to_numpy()
    frequency = data["lobe_frequency"].to_numpy()
    low, high = _RATIOS
    shift = place[1] / place[0] - 1
    bound = float(np.sqrt((1 + 2 * high) / (1 + 2 * low)) - 1)
    chatter = float(frequency[1] / frequency[0] - 1)
    natural = models.natural_frequency()
    nearest = np.abs(data["chatter_frequency"].to_numpy()[..., None] - natural).argmin(axis=-1)
    others = [float(share) for share in np.mean(nearest > 0, axis=1)]
    up, wanted = float(least[1] / least[0]), high * (1 + high) / (low * (1 + low))
    return [
        Finding(
            "The stable domain expands with the damping.",
            "expansion",
            f"the least limit grows by a factor of {up:.3f}; ξ(1 + ξ) by {wanted:.3f}",
            abs(up / wanted - 1) < 0.03,
            numbers={"up": up, "closed_form": wanted},
        ),
        Finding(
            "No lateral shift of the lobes is seen.",
            "no lateral shift",
            f"lobes 1 to 4 move by {100 * shift.min():.1f} to {100 * shift.max():.1f} % of their speed",
            bool(np.all(np.abs(shift) <= bound)),
            f"Less than the {100 * bound:.1f} % by which √(1 + 2ξ) grows, and too little to be seen in the figure.",
            {"least_shift": float(shift.min()), "largest_shift": float(shift.max()), "bound": bound},
        ),
        Finding(
            "There is none because damping does not affect the natural frequencies.",
            "does not affect the eigenfrequencies",
            f"chatter is not at the natural frequency: it moves by {100 * chatter:.2f} %",
            False,
            f"It is at ω_n√(1 + 2ξ), which moves by {100 * bound:.2f} %.",
            {"chatter_shift": chatter, "bound": bound},
        ),
        Finding(
            "Mode 1 sets the limit.",
            "global stability is driven by mode 1",
            f"higher modes set it at {100 * others[0]:.0f} % of the speeds with ξ = {low}, at {100 * others[1]:.0f} % "
            f"with ξ = {high}",
            others[0] < 0.01,
            "With little damping lobes of mode 2 come up between those of mode 1, where the limit is high.",
            {"others_low": others[0], "others_high": others[1]},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.11",
    "Limits at two damping ratios",
    "Damping lifts the lobes and does not move them aside.",
    compute,
    draw,
    findings,
)
