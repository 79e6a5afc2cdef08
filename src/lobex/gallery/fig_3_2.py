"""Fig. 3.2: the stability lobe diagram of milling by the thesis' two methods, beside the converged one."""

from typing import TYPE_CHECKING, Any

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMES = {
    "converged": "converged",
    "chebyshev": "Chebyshev, 40 nodes, one interval",
    "semi_discretization": "semi-discretization, 40 steps",
}


def compute(share: float = 1.0) -> Results:
    """The three maps. The thesis takes 300 × 300 points; curves need fewer depths when read between them."""
    speed = models.grid(2000, 25000, 401, share) / 60
    depth = models.grid(0, 5e-3, 101, share)
    methods: dict[str, Any] = {
        "converged": lobex.Auto(),
        "chebyshev": lobex.Chebyshev(nodes=40, aligned=False),
        "semi_discretization": lobex.SemiDiscretization(steps=40),
    }
    return {name: lobex.sweep(models.milling(), speed, depth, method) for name, method in methods.items()}


def _errors(results: Results) -> dict[str, np.ndarray]:
    """Relative errors of max|μ| of the thesis' methods, (speeds, depths)."""
    exact = results["converged"].spectral_radius
    names = ("chebyshev", "semi_discretization")
    # At depth zero there is no cut and no jump.
    return {name: np.abs(results[name].spectral_radius / exact - 1)[:, 1:] for name in names}


def draw(results: Results) -> "Figure":
    """The limits, and the errors of max|μ| below them."""
    figure, (upper, lower) = style.panels(2, 6.2, height_ratios=(1.7, 1), sharex=True)
    looks = dict(zip(_NAMES, (style.REFERENCE, style.LOOKS[1], style.LOOKS[0]), strict=True))
    for name, label in _NAMES.items():
        chart, look = results[name], looks[name]
        upper.contour(
            60 * chart.speed,
            1e3 * chart.gain,
            chart.spectral_radius.T,
            levels=[1.0],
            colors=[look["color"]],
            linestyles=[look["linestyle"]],
            linewidths=[look["linewidth"]],
            alpha=look.get("alpha"),
        )
        upper.plot([], [], label=label, **look)
    upper.set_ylim(0, 5)
    upper.set_ylabel("depth of cut $b$ (mm)")
    style.legend_above(upper, 3)
    for name, error in _errors(results).items():
        look = looks[name]
        worst, half = error.max(axis=1), np.median(error, axis=1)
        lower.fill_between(60 * results[name].speed, half, worst, color=look["color"], alpha=0.25, linewidth=0)
        lower.semilogy(60 * results[name].speed, half, label=f"{_NAMES[name].split(',')[0]}: median to largest", **look)
    lower.set_xlim(2000, 25000)
    lower.set_ylim(1e-6, 1)
    lower.set_xlabel("spindle speed (rpm)")
    lower.set_ylabel("error of max|μ|\nover all depths")
    lower.legend(frameon=False, fontsize="small", loc="upper right", ncols=2)
    return figure


def findings(results: Results) -> list[Finding]:
    """What each method costs in accuracy."""
    exact = results["converged"].spectral_radius
    errors = _errors(results)
    half = {name: float(np.median(error)) for name, error in errors.items()}
    worst = {name: float(error.max()) for name, error in errors.items()}
    verdict = {name: float(np.mean((results[name].spectral_radius > 1) == (exact > 1))) for name in errors}
    ratio = half["chebyshev"] / half["semi_discretization"]
    return [
        Finding(
            "Despite differences between the methods, the general behaviour is the same.",
            "unchanged",
            f"stable or unstable as the converged map says: Chebyshev at {100 * verdict['chebyshev']:.1f} % and "
            f"semi-discretization at {100 * verdict['semi_discretization']:.1f} % of the points",
            min(verdict.values()) > 0.9,
            "Down-milling by Appendix A's angles; §2.2.2 exchanges up and down.",
            {f"verdict_{name}": value for name, value in verdict.items()},
        ),
        Finding(
            "Both methods reproduce the published diagrams precisely.",
            "precisely, with 40 nodes or 40 steps",
            f"max|μ| errs by {half['chebyshev']:.1e} (median; {worst['chebyshev']:.1e} at most) with Chebyshev, by "
            f"{half['semi_discretization']:.1e} ({worst['semi_discretization']:.1e}) with semi-discretization: "
            f"{ratio:.0f} times as much",
            False,
            "K_s(t) jumps where the tooth enters and leaves. One interval of polynomials cannot follow a jump; pieces "
            "that end there can.",
            {
                "chebyshev": half["chebyshev"],
                "semi_discretization": half["semi_discretization"],
                "worst_chebyshev": worst["chebyshev"],
                "worst_semi_discretization": worst["semi_discretization"],
                "ratio": ratio,
            },
        ),
    ]


FIGURE = Reproduction(
    "fig-3.2",
    "Stability lobe diagram of milling, one degree of freedom",
    "Chebyshev collocation and semi-discretization draw the same diagram.",
    compute,
    draw,
    findings,
)
