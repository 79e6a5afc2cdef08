"""Fig. 1.4: the spectrum of the tip's motion, over the rotational frequency."""

from typing import TYPE_CHECKING

import numpy as np

from lobex.gallery import models, style
from lobex.gallery.reproduction import Finding, Reproduction, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def compute(share: float = 1.0) -> Results:
    """The spectra of the march behind Fig. 1.3, and its wear."""
    march = models.wear(2, share)
    return {"spectrum": march.spectrum(), "wear": models.removed(march)}


def draw(results: Results) -> "Figure":
    """The map up to the second natural frequency, at speeds up to 500 Hz."""
    spectrum = results["spectrum"]
    figure, ax = style.panels(1, 5.6)
    spectrum.plot(ax)
    ax.set_xlim(float(spectrum.speed[0]), 500.0)
    return figure


def findings(results: Results) -> list[Finding]:
    """Speeds and frequencies of the largest lines."""
    spectrum = results["spectrum"]
    first = float(spectrum.natural_frequency.min())
    largest = np.nanmax(spectrum.amplitude[:, 1:], axis=1)
    peaks, orders, shift = {}, {}, {}
    for k in (2, 4, 6):
        peaks[k] = models.peak_speed(spectrum.speed, largest, first / k)
        lane = int(np.flatnonzero(spectrum.speed == peaks[k])[0])
        line = 1 + int(np.argmax(spectrum.amplitude[lane, 1:]))
        orders[k] = float(spectrum.order[line])
        shift[k] = float(spectrum.frequency[lane, line] / first)
    worn = {k: models.peak_speed(spectrum.speed, results["wear"]["volume"].to_numpy(), first / k) for k in peaks}
    apart = max(abs(peaks[k] / worn[k] - 1) for k in peaks)
    beyond = float(largest[spectrum.speed > 1.2 * first].max() / largest.max())
    return [
        Finding(
            "The largest vibrations lie where engine orders cross the first natural frequency, slightly shifted.",
            "intersections of f = k f_Ω and f₁, slightly shifted",
            "; ".join(f"{peaks[k]:.0f} Hz: order {orders[k]:.2f}, {shift[k]:.3f} f₁" for k in (6, 4, 2)),
            all(abs(orders[k] - k) < 0.25 and 1 < shift[k] < 1.15 for k in (2, 4, 6)),
            "Contact stiffens the blade, so that the lines lie above f₁.",
            {**{f"order{k}": o for k, o in orders.items()}, **{f"shift{k}": s for k, s in shift.items()}},
        ),
        Finding(
            "The spectrum agrees with the wear map.",
            "in perfect agreement",
            "the largest amplitudes are at "
            + ", ".join(f"{peaks[k]:.0f}" for k in (6, 4, 2))
            + " Hz, the most wear at "
            + ", ".join(f"{worn[k]:.0f}" for k in (6, 4, 2))
            + " Hz",
            apart < 0.04,
            numbers={**{f"peak{k}": p for k, p in peaks.items()}, "apart": apart},
        ),
        Finding(
            "No large vibration past f₁.",
            "none",
            f"at most {100 * beyond:.0f} % of the largest amplitude",
            beyond < 0.25,
            numbers={"beyond": beyond},
        ),
    ]


FIGURE = Reproduction(
    "fig-1.4",
    "Spectrum of the blade's tip",
    "Vibration is large where an even engine order meets the first natural frequency, which contact raises a little.",
    compute,
    draw,
    findings,
)
