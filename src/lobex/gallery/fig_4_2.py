"""Fig. 4.2: convergence over the elements of the rod."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ELEMENTS = (2, 5, 10, 20)


def compute(share: float = 1.0) -> Results:
    """The exact limit of each mesh: in time nothing is discretised, so that space alone is compared."""
    speed = models.grid(50, 250, 401, share)
    gain = [models.limits(models.rub(n), speed)[0] for n in _ELEMENTS]
    return {"elements": models.family("elements", _ELEMENTS, speed, gain, meaning="truss elements")}


def draw(results: Results) -> "Figure":
    """The limits, and how far they are from that of 20 elements."""
    data = results["elements"]
    speed, gain = data["speed"].to_numpy(), data["critical_stiffness"].to_numpy() / 1e6
    figure, (upper, lower) = style.panels(2, 6.0, height_ratios=(1.7, 1), sharex=True)
    looks = (style.LOOKS[2], style.LOOKS[1], style.LOOKS[0], style.REFERENCE)
    for elements, row, look in sorted(zip(_ELEMENTS, gain, looks, strict=True), key=lambda entry: -entry[0]):
        upper.plot(speed, row, label=f"{elements} elements", **look)
        if elements != 20:
            lower.semilogy(speed, np.abs(row / gain[-1] - 1), **look)
    style.over_speed(upper, speed, style.CRITICAL, named=False)
    upper.set_ylim(bottom=0)
    style.over_speed(lower, speed, "relative difference\nto 20 elements")
    lower.set_ylim(1e-3, 2)
    style.legend_above(upper, 4)
    return figure


def findings(results: Results) -> list[Finding]:
    """Differences to 20 elements."""
    gain = dict(zip(_ELEMENTS, results["elements"]["critical_stiffness"].to_numpy(), strict=True))
    off = {n: np.abs(gain[n] / gain[20] - 1) for n in (2, 5, 10)}
    half = {n: float(np.median(error)) for n, error in off.items()}
    most = {n: float(error.max()) for n, error in off.items()}
    first = [float(models.natural_frequency(n)[0]) for n in (5, 20)]
    numbers = {f"median{n}": half[n] for n in off} | {f"most{n}": most[n] for n in off}
    return [
        Finding(
            "There is no major difference between 10 and 20 elements.",
            "no major difference",
            f"{100 * half[10]:.1f} % in the median, {100 * most[10]:.1f} % at most",
            half[10] < 0.02,
            numbers=numbers,
        ),
        Finding(
            "5 elements are of good accuracy already, and serve the rest of the study.",
            "good accuracy",
            f"{100 * half[5]:.1f} % in the median, and {100 * most[5]:.0f} % at most, on the steep sides of the lobes "
            f"(2 elements: {100 * half[2]:.0f} % and {100 * most[2]:.0f} %)",
            half[5] < 0.05,
            f"Few elements are too stiff: with five f₁ is {first[0]:.1f} Hz, with twenty {first[1]:.1f} Hz, which "
            "shifts the lobes.",
            {"median": half[5], "most": most[5], "frequency_ratio": first[0] / first[1]},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.2",
    "Convergence over the finite elements",
    "10 elements are converged and 5 accurate enough.",
    compute,
    draw,
    findings,
)
