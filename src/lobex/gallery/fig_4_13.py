"""Fig. 4.13: the tip's displacement in time at the four points."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.fig_4_12 import SPEEDS, STIFFNESSES
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_REVOLUTIONS = 10
# Δt is then 0.98 and 0.74 µs; the thesis has 1 µs.
_STEPS = 12000


def compute(share: float = 1.0) -> Results:
    """Ten revolutions from (4.3)'s growing start, at both stiffnesses. Always of full length."""
    marches = {}
    for speed in SPEEDS:
        history, state = lobex.growing_history(lobex.Rod(5), speed=speed)
        marches[f"at_{speed:g}_Hz"] = lobex.march_delay(
            models.rub(), speed, STIFFNESSES, history, _REVOLUTIONS, _STEPS, state=state, every=20
        )
    return marches


def draw(results: Results) -> "Figure":
    """One panel for each speed."""
    figure, axes = style.panels(2, 6.0)
    for ax, march, text in zip(axes, results.values(), ("(a)", "(b)"), strict=True):
        march.plot(ax)
        style.letter(ax, text)
    axes[0].set_xlabel("")
    return figure


def findings(results: Results) -> list[Finding]:
    """Growth beside the multipliers, and how large the unstable motions get."""
    growth = np.array([march.growth for march in results.values()])
    predicted = lobex.sweep(models.rub(), SPEEDS, STIFFNESSES).spectral_radius
    error = float(np.abs(growth / predicted - 1).max())
    # From the start of the march on: the largest motion of the last revolution by that of the first.
    ratio = []
    for march in results.values():
        tip = np.abs(march.displacement[1, :, 0])
        last, first = march.phase > _REVOLUTIONS - 1, march.phase < 1
        ratio.append(float(tip[last].max() / tip[first].max()))
    return [
        Finding(
            "The responses are stable and unstable as the lobe diagram says.",
            "conclusive",
            "growth per revolution "
            + "; ".join(f"{s:g} Hz: {g[0]:.4f} and {g[1]:.4f}" for s, g in zip(SPEEDS, growth, strict=True))
            + f", max|μ| within {error:.0e}",
            bool(np.all((growth > 1) == (predicted > 1))),
            "With 1.35·10⁶ N/m, not the caption's 1.35·10⁵. The start is q₀ exp(t ln(1.0005)/1 µs): 1.0005 per step, "
            "as printed, would make it depend on the step.",
            {
                "error": error,
                "stable_85": float(growth[0, 0]),
                "unstable_85": float(growth[0, 1]),
                "stable_112": float(growth[1, 0]),
                "unstable_112": float(growth[1, 1]),
            },
        ),
        Finding(
            "The unstable motion grows much more at 85 than at 112 Hz, as that point is further from the stable "
            "domain.",
            "large difference in amplitude",
            f"in ten revolutions the motion grows {ratio[0]:.3g}-fold at 85 Hz and {ratio[1]:.3g}-fold at 112 Hz",
            ratio[0] > 3 * ratio[1],
            numbers={"growth_85": ratio[0], "growth_112": ratio[1]},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.13",
    "Responses in time at the four points",
    "Time integration confirms the lobe diagram.",
    compute,
    draw,
    findings,
)
