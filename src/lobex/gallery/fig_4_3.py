"""Fig. 4.3: the stability diagram up to 8,000 Hz."""

from typing import TYPE_CHECKING

import numpy as np

import lobex
from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STIFFNESS = (4.5e4, 13.5e6)
_BANDS = ((20, 800), (800, 1600), (1600, 3200), (3200, 8000))


def compute(share: float = 1.0) -> Results:
    """Maps of the whole range and of its low end, and the exact limit."""
    stiffness = models.grid(*_STIFFNESS, 121, share)
    process = models.rub()
    speed = np.geomspace(20, 8000, 2000)
    gain, frequency = models.limits(process, speed)
    return {
        "whole": lobex.sweep(process, models.grid(20, 8000, 400, share), stiffness),
        "low": lobex.sweep(process, models.grid(20, 800, 400, share), stiffness),
        "limit": models.family("method", ["D-subdivision"], speed, [gain], [frequency]),
    }


def draw(results: Results) -> "Figure":
    """The whole range as the thesis shows it, and its first tenth."""
    figure, (upper, lower) = style.panels(2, 7.4)
    results["whole"].plot(upper)
    results["low"].plot(lower)
    lower.get_legend().remove()
    upper.set_xlabel("")
    style.letter(upper, "(a)")
    style.letter(lower, "(b)")
    return figure


def findings(results: Results) -> list[Finding]:
    """What the limit does over the speed."""
    data = results["limit"]
    speed = data["speed"].to_numpy()
    gain, frequency = (data[name].to_numpy()[0] for name in ("critical_stiffness", "chatter_frequency"))
    natural = models.natural_frequency()
    first = float(natural[0])
    least = [float(gain[(speed >= low) & (speed < high)].min()) for low, high in _BANDS]
    minimum, lobes, chatter = models.least(models.rub())
    nearest = np.abs(frequency[:, None] - natural).argmin(axis=1)
    # Equal steps of the logarithm of the speed; shares are of the speed itself.
    weight = np.gradient(speed)
    driven = float(np.sum(weight * (nearest == 0)) / weight.sum())
    last = float(speed[nearest == 0].max())
    low = float(speed[gain < 2 * minimum].max())
    bands = ", ".join(f"{low}-{high} Hz" for low, high in _BANDS)
    return [
        Finding(
            "The stable domain grows with the rotational frequency.",
            "increases",
            f"least limits of {', '.join(f'{g / 1e6:.2f}' for g in least)} MN/m at {bands}",
            bool(np.all(np.diff(least) > 0)),
            f"Not below {_BANDS[0][1]} Hz: there every lobe of mode 1 comes down to the same {minimum / 1e6:.3f} MN/m.",
            {f"least{i}": g for i, g in enumerate(least)},
        ),
        Finding(
            "The first mode is the most unstable one: chatter is close to the natural frequency of the dominant mode.",
            "close to a natural frequency",
            f"the least limit has chatter at {chatter:.1f} Hz = {chatter / first:.4f} f₁",
            1 < chatter / first < 1.05,
            "For one mode it is f₁√(1 + 2ξ) = 1.0296 f₁.",
            {"least": minimum, "chatter_ratio": chatter / first},
        ),
        Finding(
            "That no large vibration is expected past f₁ confirms this.",
            "no major vibrations past f₁",
            f"the lobe of highest speed comes down to {minimum / 1e6:.3f} MN/m at {lobes[0]:.0f} Hz = "
            f"{lobes[0] / first:.2f} f₁, as low as any other; only past {low:.0f} Hz does the limit stay above twice "
            "that",
            False,
            "Two phenomena: chapter 1's critical speeds are resonances with the bumps of a casing, chapter 4's lobes "
            "are regenerative instability. The first end at f₁/2, the second do not.",
            {"first_lobe": float(lobes[0]), "first_lobe_ratio": float(lobes[0] / first), "low": low},
        ),
        Finding(
            "Mode 1 drives the stability of the whole diagram.",
            "global stability is driven by mode 1",
            f"chatter is nearest to f₁ up to {last:.0f} Hz, at {100 * driven:.0f} % of the speeds to 8,000 Hz; above, "
            "higher modes set the limit",
            driven > 0.5,
            "True where the limit is low, and so for the design; not over the range of this figure.",
            {"share": driven, "last": last},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.3",
    "Global stability diagram",
    "The stable domain grows with speed, so that the first mode is the most unstable one.",
    compute,
    draw,
    findings,
)
