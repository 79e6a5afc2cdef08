"""The spectrum of a rubbing blade over speed, with engine orders, natural frequencies and critical speeds."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm

from lobex import _checks
from lobex.plots.campbell import draw_engine_orders, draw_natural_frequencies
from lobex.plots.frame import one_of
from lobex.plots.pooling import on_common_frequencies, speed_order
from lobex.plots.wear_pictures import COLOURS, mark_critical_speeds

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.spectrum_map import SpectrumMap

_ROWS = 480
_DECADES = 3


def plot_spectrum(spectrum: "SpectrumMap", ax: "Axes | None", highest: float | None, orders: int | None) -> "Axes":
    """Draw the amplitudes on a logarithmic scale of three decades, in µm."""
    order = speed_order("spectrum", spectrum.speed)
    speed = spectrum.speed[order]
    top = _highest(spectrum, highest)
    count = _checks.integer("orders", 12 if orders is None else orders, 0)
    ax = one_of(ax, 7.0, 5.4)
    edges = np.linspace(0, top, _ROWS + 1)
    rows = on_common_frequencies(spectrum.amplitude[order] * 1e6, spectrum.frequency[order], edges)
    # The mean is no vibration.
    rows[:, 0] = np.nan
    largest = float(np.nanmax(rows)) if np.isfinite(rows).any() else 1.0
    largest = largest if largest > 0 else 1.0
    mesh = ax.pcolormesh(
        speed,
        (edges[1:] + edges[:-1]) / 2,
        np.ma.masked_invalid(np.maximum(rows, largest * 10.0**-_DECADES)).T,
        cmap=COLOURS,
        norm=LogNorm(largest * 10.0**-_DECADES, largest),
        shading="nearest",
        rasterized=True,
    )
    ax.set_xlim(speed[0], speed[-1])
    ax.set_ylim(0, top)
    draw_engine_orders(ax, count, spectrum.nodal_diameters)
    draw_natural_frequencies(ax, spectrum.natural_frequency)
    mark_critical_speeds(ax, spectrum.natural_frequency, spectrum.nodal_diameters, (speed[0], speed[-1]))
    ax.set_xlabel("rotational frequency (Hz)")
    ax.set_ylabel("frequency (Hz)")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2, frameon=False, fontsize="small")
    bar = ax.figure.colorbar(mesh, ax=ax, pad=0.08)
    bar.set_label("amplitude of the tip (µm)")
    return ax


def _highest(spectrum: "SpectrumMap", given: float | None) -> float:
    if given is not None:
        _checks.positive("highest", given, "Hz")
        _checks.scalar("highest", given)
        return float(given)
    natural = np.sort(spectrum.natural_frequency)
    return float(1.15 * natural[1] if len(natural) > 1 else 3 * natural[0])
