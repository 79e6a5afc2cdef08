"""Fig. 4.4: what each of the first modes contributes."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

_KEPT: dict[str, tuple[int, ...] | None] = {"mode 1": (1,), "mode 2": (2,), "modes 1+2": (1, 2), "all 5 modes": None}


def compute(share: float = 1.0) -> Results:
    """The exact limits of single modes, of two and of all, where the lobes are and over the whole range."""
    near = models.grid(50, 400, 701, share)
    whole = np.geomspace(20, 8000, 2000)
    return {name: _limits(speed) for name, speed in (("near", near), ("whole", whole))}


def _limits(speed: np.ndarray) -> "xarray.Dataset":
    found = [models.limits(models.rub(keep=kept), speed) for kept in _KEPT.values()]
    gain, frequency = zip(*found, strict=True)
    return models.family("modes", list(_KEPT), speed, gain, frequency, "modes kept")


def draw(results: Results) -> "Figure":
    """Both ranges."""
    figure, axes = style.panels(2, 7.0)
    looks = (style.LOOKS[1], style.LOOKS[2], style.LOOKS[0], style.REFERENCE)
    for ax, data, text in zip(axes, results.values(), ("(a)", "(b)"), strict=True):
        speed = data["speed"].to_numpy()
        for name, row, look in zip(_KEPT, data["critical_stiffness"].to_numpy() / 1e6, looks, strict=True):
            ax.plot(speed, row, label=name, zorder=1 if look is style.REFERENCE else 2, **look)
        style.over_speed(ax, speed, style.CRITICAL)
        style.letter(ax, text)
    upper, lower = axes
    upper.set_ylim(0, 4.5)
    lower.set_xscale("log")
    lower.set_yscale("log")
    lower.set_ylim(0.2, 100)
    style.legend_above(upper, 4)
    return figure


def findings(results: Results) -> list[Finding]:
    """How far mode 1 alone tells the limit."""
    near, whole = results["near"], results["whole"]
    gain = dict(zip(_KEPT, near["critical_stiffness"].to_numpy(), strict=True))
    far = dict(zip(_KEPT, whole["critical_stiffness"].to_numpy(), strict=True))
    every = gain["all 5 modes"]
    off = {name: np.abs(gain[name] / every - 1) for name in ("mode 1", "modes 1+2")}
    within = {percent: float(np.mean(off["mode 1"] < percent / 100)) for percent in (1, 10)}
    natural = models.natural_frequency()
    chatter = near["chatter_frequency"].to_numpy()[3]
    driven = float(np.mean(np.abs(chatter[:, None] - natural).argmin(axis=1) == 0))
    least = {name: models.least(models.rub(keep=kept))[0] for name, kept in _KEPT.items()}
    floor = least["mode 1"] / least["all 5 modes"]
    high = float(least["mode 2"] / least["all 5 modes"])
    speed = whole["speed"].to_numpy()
    at = int(np.argmin(np.abs(speed - 2000)))
    over = float(far["mode 1"][at] / far["all 5 modes"][at])
    return [
        Finding(
            "Global stability is driven by the first mode.",
            "clearly",
            f"at {100 * driven:.0f} % of the speeds of 50 to 400 Hz chatter is nearest to f₁, and mode 1 alone has the "
            f"least limit within {100 * abs(floor - 1):.0f} %",
            driven > 0.99 and abs(floor - 1) < 0.05,
            numbers={"driven": driven, "least_ratio": floor},
        ),
        Finding(
            "The diagram of mode 1 alone shows the global limit.",
            "the curves are shown on top of each other",
            f"within 1 % at {100 * within[1]:.0f} % of the speeds and within 10 % at {100 * within[10]:.0f} %; "
            f"{100 * np.median(off['mode 1']):.1f} % off in the median",
            within[1] > 0.5,
            "At this frequency the higher modes are springs in series with the first. Their compliance raises the "
            "limit, most where it is high; the lobes' feet hardly change.",
            {"within_1": within[1], "within_10": within[10], "median": float(np.median(off["mode 1"]))},
        ),
        Finding(
            "Two modes show the same.",
            "same observation",
            f"modes 1+2 are {100 * np.median(off['modes 1+2']):.1f} % off in the median",
            bool(np.median(off["modes 1+2"]) < 0.05),
            numbers={"median": float(np.median(off["modes 1+2"]))},
        ),
        Finding(
            "What mode 2 alone finds stable may be unstable with mode 1.",
            "parameters stable with mode 2 alone may be unstable",
            f"the least limit of mode 2 is {high:.1f} times the global one",
            high > 1,
            numbers={"ratio": high},
        ),
        Finding(
            "Mode 1 drives stability over the whole range of Fig. 4.3.",
            "to 8,000 Hz",
            f"at {speed[at]:.0f} Hz mode 1 alone has {over:.1f} times the limit",
            False,
            "There the lobes of the higher modes lie lower than what is left of mode 1.",
            {"overestimate": over},
        ),
    ]


FIGURE = Reproduction(
    "fig-4.4",
    "Contributions of the modes",
    "The first mode alone decides the stability of the whole.",
    compute,
    draw,
    findings,
)
