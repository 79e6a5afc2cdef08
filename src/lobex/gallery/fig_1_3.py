"""Fig. 1.3: the casing after 20 revolutions, over the rotational frequency."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The wear map, and what a casing with three nodal diameters loses."""
    return {"wear": models.wear(2, share), "three_diameters": models.removed(models.wear(3, share))}


def draw(results: Results) -> "Figure":
    """The map, and the volume that each speed removes."""
    march = results["wear"]
    figure, (upper, lower) = style.panels(2, 6.2, height_ratios=(2.2, 1), sharex=True)
    march.plot(upper)
    first = float(march.natural_frequency.min())
    upper.set_xlabel("")
    # The wear map names those that have room on a linear axis.
    place = {"xycoords": upper.get_xaxis_transform(), "xytext": (0, 2), "textcoords": "offset points"}
    upper.annotate("$f_1/6$", (first / 6, 1.0), ha="center", va="bottom", fontsize="small", **place)
    # Critical speeds lie at fractions: on a logarithmic axis they are equally easy to read.
    upper.set_xscale("log")
    upper.set_xticks([30, 50, 100, 200, 500, 1000, 1500], minor=False)
    upper.xaxis.set_major_formatter("{x:g}")
    upper.xaxis.set_minor_formatter("")
    lower.plot(march.speed, march.volume * 1e6, **style.LOOKS[0])
    for order in (1, 2, 4, 6):
        named = "critical speeds $f_1/2$, $f_1/4$, $f_1/6$ without contact, and $f_1$" if order == 1 else None
        lower.axvline(first / order, color="0.3", linewidth=0.8, linestyle=(0, (4, 3)), label=named)
    style.over_speed(lower, march.speed, "removed (cm³\nper m width)")
    lower.set_ylim(bottom=0)
    lower.legend(framealpha=1, edgecolor="none", fontsize="small", loc="upper right")
    return figure


def findings(results: Results) -> list[Finding]:
    """Where the wear peaks lie."""
    march = results["wear"]
    first = float(march.natural_frequency.min())
    peaks = {k: models.peak_speed(march.speed, march.volume, first / k) for k in (2, 4, 6)}
    ratio = {k: peak * k / first for k, peak in peaks.items()}
    past = march.speed > 1.2 * first
    volume = march.volume / march.volume.max()
    tall = float(min(volume[march.speed == peak][0] for peak in peaks.values()))
    beyond = float(volume[past].max())
    odd = results["three_diameters"]["volume"].to_numpy()
    third = models.peak_speed(march.speed, odd, first / 3)
    at_third = float(odd[march.speed == third][0] / np.median(odd[past]))
    rod = np.asarray(lobex.Rod(30).modes().frequency)[:5]
    return [
        Finding(
            "The rod's first natural frequencies with 30 elements.",
            "338, 1015, 1694, 2378, 3069 Hz",
            ", ".join(f"{f:.1f}" for f in rod) + " Hz",
            bool(np.all(np.abs(rod - [338, 1015, 1694, 2378, 3069]) < 1)),
            "They are those of the clamped rod.",
            {f"f{i}": float(f) for i, f in enumerate(rod, 1)},
        ),
        Finding(
            "Most wear happens where the rotational frequency is an even divider of f₁, (1.18).",
            f"near f₁/6, f₁/4, f₁/2 = {first / 6:.0f}, {first / 4:.0f}, {first / 2:.0f} Hz",
            f"peaks at {peaks[6]:.0f}, {peaks[4]:.0f}, {peaks[2]:.0f} Hz",
            all(1 < r < 1.15 for r in ratio.values()),
            "With the reaction of the contact as −K_e h on the tip: (1.12)-(1.15) have its sign the other way round, "
            "and would soften. The cell is worn after its own force is evaluated; worn before, no force is left.",
            {f"peak{k}": peak for k, peak in peaks.items()},
        ),
        Finding(
            "Contact and wear raise these speeds slightly: contact stiffening.",
            "slightly",
            "by a factor of " + ", ".join(f"{ratio[k]:.3f}" for k in (6, 4, 2)),
            all(1 < r < 1.15 for r in ratio.values()),
            "The size depends on K_e, which the thesis does not give here.",
            {f"ratio{k}": r for k, r in ratio.items()},
        ),
        Finding(
            "Past f₁ no major wear is seen.",
            "none",
            f"at most {100 * beyond:.0f} % of the largest wear, where the smallest of the three peaks has "
            f"{100 * tall:.0f} %",
            beyond < 0.25,
            "What remains is the bumps' first contact, at every speed.",
            {"beyond": beyond, "smallest_peak": tall},
        ),
        Finding(
            "An odd number of nodal diameters makes odd dividers contribute.",
            "k odd may contribute",
            f"with three diameters the peak beside f₁/3 = {first / 3:.0f} Hz is at {third:.0f} Hz, with "
            f"{at_third:.1f} times the usual wear past f₁",
            at_third > 3,
            numbers={"third": third, "prominence": at_third},
        ),
    ]


FIGURE = Reproduction(
    "fig-1.3",
    "Abradable layer after 20 revolutions",
    "Wear concentrates a little above the critical speeds f₁/2, f₁/4, f₁/6, and fades past f₁.",
    compute,
    draw,
    findings,
)
