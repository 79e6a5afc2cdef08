"""Fig. 4.1: convergence over the Chebyshev nodes."""

import warnings
from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NODES = (20, 40, 60)


def compute(share: float = 1.0) -> Results:
    """The limit read from maps with 20, 40 and 60 nodes, and the exact one."""
    speed = models.grid(50, 250, 121, share)
    stiffness = np.geomspace(*models.CONTACT_STIFFNESS, max(round(56 * share), 24) + 1)
    with warnings.catch_warnings():
        # Too few nodes for the lowest speeds is what the figure is about.
        warnings.simplefilter("ignore", lobex.SweepWarning)
        charts = [lobex.sweep(models.rub(), speed, stiffness, lobex.Chebyshev(nodes)) for nodes in _NODES]
    gain = [chart.critical_gain() for chart in charts]
    exact, _ = models.limits(models.rub(), speed)
    return {
        "nodes": models.family("nodes", _NODES, speed, gain, meaning="Chebyshev nodes per delay"),
        "exact": models.family("method", ["D-subdivision"], speed, [exact]),
    }


def draw(results: Results) -> "Figure":
    """The limits, and how far they are from that of 60 nodes."""
    data = results["nodes"]
    speed, gain = data["speed"].to_numpy(), data["critical_stiffness"].to_numpy() / 1e6
    figure, (upper, lower) = style.panels(2, 6.0, height_ratios=(1.7, 1), sharex=True)
    exact = results["exact"]
    upper.plot(exact["speed"], exact["critical_stiffness"][0] / 1e6, label="exact", **style.REFERENCE)
    looks = dict(zip(_NODES, (style.LOOKS[1], style.LOOKS[0], style.LOOKS[2]), strict=True))
    for nodes, row in zip(_NODES, gain, strict=True):
        upper.plot(speed, row, label=f"{nodes} nodes", **looks[nodes])
        if nodes != _NODES[-1]:
            # Equal numbers are drawn at the precision of double numbers.
            lower.semilogy(speed, np.maximum(np.abs(row / gain[-1] - 1), 1e-16), **looks[nodes])
    style.over_speed(upper, speed, style.CRITICAL, named=False)
    upper.set_ylim(bottom=0)
    style.over_speed(lower, speed, "relative difference\nto 60 nodes")
    lower.set_ylim(1e-16, 10)
    style.legend_above(upper, 4)
    return figure


def findings(results: Results) -> list[Finding]:
    """Differences between the numbers of nodes."""
    data = results["nodes"]
    speed, gain = data["speed"].to_numpy(), data["critical_stiffness"].to_numpy()
    coarse, middle = (np.abs(row / gain[2] - 1) for row in gain[:2])
    slow = speed <= 80
    low, high = float(np.nanmax(coarse[slow])), float(np.nanmax(coarse[~slow]))
    close = float(np.nanmax(middle))
    return [
        Finding(
            "The curves of 40 and 60 nodes overlap, so that 40 are enough.",
            "overlap perfectly",
            f"{close:.1e} apart at most, in relative terms",
            close < 1e-3,
            numbers={"40_against_60": close},
        ),
        Finding(
            "With 20 nodes there is a major difference at 50 to 80 Hz, where the delay is long.",
            "major difference below 80 Hz",
            f"up to {100 * low:.0f} % at 50 to 80 Hz, up to {100 * high:.2g} % above",
            low > 0.1 and high < 0.05,
            numbers={"below_80_Hz": low, "above_80_Hz": high},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.1",
    "Convergence over the Chebyshev nodes",
    "40 nodes per revolution are enough; 20 are too few at low speeds.",
    compute,
    draw,
    findings,
)
