"""Fig. 4.5: convergence over the modes."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_KEPT = {"mode 1": (1,), "modes 1+2": (1, 2), "modes 1 to 5": (1, 2, 3, 4, 5), "modes 1 to 15": None}


def compute(share: float = 1.0) -> Results:
    """The exact limits of a rod of 15 elements with some of its modes."""
    speed = models.grid(50, 400, 701, share)
    gain = [models.limits(models.rub(15, keep=kept), speed)[0] for kept in _KEPT.values()]
    return {"modes": models.family("modes", list(_KEPT), speed, gain, meaning="modes kept")}


def draw(results: Results) -> "Figure":
    """The limits, and how far they are from that of all modes."""
    data = results["modes"]
    speed, gain = data["speed"].to_numpy(), data["critical_stiffness"].to_numpy() / 1e6
    figure, (upper, lower) = style.panels(2, 6.0, height_ratios=(1.7, 1), sharex=True)
    looks = (style.LOOKS[1], style.LOOKS[2], style.LOOKS[0], style.REFERENCE)
    for name, row, look in zip(_KEPT, gain, looks, strict=True):
        upper.plot(speed, row, label=name, zorder=1 if look is style.REFERENCE else 2, **look)
        if look is not style.REFERENCE:
            lower.semilogy(speed, np.abs(row / gain[-1] - 1), **look)
    style.over_speed(upper, speed, style.CRITICAL, named=False)
    upper.set_ylim(0, 4.5)
    style.over_speed(lower, speed, "relative difference\nto all 15 modes")
    lower.set_ylim(1e-3, 2)
    style.legend_above(upper, 4)
    return figure


def findings(results: Results) -> list[Finding]:
    """Differences to all 15 modes."""
    gain = results["modes"]["critical_stiffness"].to_numpy()
    half = [float(np.median(np.abs(row / gain[-1] - 1))) for row in gain[:-1]]
    numbers = {f"median{count}": value for count, value in zip((1, 2, 5), half, strict=True)}
    return [
        Finding(
            "The diagram converges as modes are added.",
            "modal convergence",
            f"medians of the difference to 15 modes: {', '.join(f'{100 * h:.1f} %' for h in half)} with 1, 2 and 5",
            half[0] > half[1] > half[2],
            numbers=numbers,
        ),
        Finding(
            "Higher modes have very little influence.",
            "very small influence",
            f"modes 6 to 15 move the limit by {100 * half[2]:.1f} % in the median, modes 2 to 15 by "
            f"{100 * half[0]:.1f} %",
            half[2] < 0.03,
            numbers=numbers,
        ),
    ]


FIGURE = Reproduction(
    "fig-4.5",
    "Convergence over the modes",
    "The higher a mode, the less it matters.",
    compute,
    draw,
    findings,
)
