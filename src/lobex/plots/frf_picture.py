"""Measured responses, what was fitted to them, and where its poles are from."""

from typing import TYPE_CHECKING, Any, cast

import matplotlib.pyplot as plt
import numpy as np

from lobex.plots.frame import legend_above

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.measured.frf import Frf
    from lobex.measured.modal_fit import ModalFit

_MEASURED, _FITTED, _MODE, _PASSING = "#7a8ca0", "#c8500a", "0.55", "0.75"
_STABLE = "#12436d"
_DECADES = 4.5
_MOST_PAIRS = 6


def plot_frf(frf: "Frf") -> "Figure":
    """Magnitude over phase of every pair, and below them the coherence."""
    shown = frf.pairs[:_MOST_PAIRS]
    rows = 2 if frf.coherence is None else 3
    axes = _panels(rows, 1, (2.0, 1.0, 0.7)[:rows])[:, 0]
    for response, reference in shown:
        values = frf.values(response, reference)
        label = f"{response} to {reference}"
        axes[0].semilogy(frf.frequency, np.abs(values), linewidth=1.0, label=label)
        axes[1].plot(frf.frequency, _phase(values), linewidth=1.0)
        if frf.coherence is not None:
            place = frf.responses.index(response), frf.references.index(reference)
            axes[2].plot(frf.frequency, frf.coherence[:, *place], linewidth=0.8)
    if frf.coherence is not None:
        axes[2].set_ylabel("coherence")
        axes[2].set_ylim(0, 1.05)
    _finish(axes, frf.frequency, [frf.values(*pair) for pair in shown])
    legend_above(axes[0])
    return cast("Figure", axes[0].figure)


def plot_fit(fit: "ModalFit") -> "Figure":
    """Measured against fitted, a column for each pair, with natural frequencies."""
    pairs = list(fit.misfit)[:_MOST_PAIRS]
    axes = _panels(2, len(pairs), (2.0, 1.0))
    inside = (fit.frf.frequency >= fit.band[0]) & (fit.frf.frequency <= fit.band[1])
    for column, pair in zip(axes.T, pairs, strict=True):
        omega = next(part.fitted.omega for part in fit.parts if pair in part.pairs)
        measured, found = fit.frf.values(*pair)[inside], fit.values(*pair)
        for ax, of in zip(column, (np.abs, _phase), strict=True):
            for number, frequency in enumerate(omega / (2 * np.pi)):
                ax.axvline(frequency, color=_MODE, linewidth=0.7, linestyle=":", label=None if number else "modes")
            drawn = cast("Axes", ax)
            drawn.plot(_lines(fit), of(measured), color=_MEASURED, linewidth=1.2, label="measured")
            drawn.plot(_lines(fit), of(found), color=_FITTED, linewidth=1.1, linestyle="--", label="fitted")
        _finish(column, _lines(fit), [measured])
        column[0].set_yscale("log")
        column[0].set_title(f"{pair[0]} to {pair[1]}: misfit {100 * fit.misfit[pair]:.2g} %", fontsize="medium", pad=26)
        legend_above(column[0])
    return cast("Figure", axes[0, 0].figure)


def plot_stabilisation(fit: "ModalFit") -> "Figure":
    """Poles by order over the sum of the magnitudes, those that are stable and those kept told apart."""
    axes = _panels(len(fit.parts), 1, (1.0,) * len(fit.parts), height=4.2)[:, 0]
    for ax, part in zip(axes, fit.parts, strict=True):
        chart = part.stabilisation
        for stable, marker, colour, label in (
            (False, "x", _PASSING, "new at its order"),
            (True, "o", _STABLE, "stable in frequency and damping"),
        ):
            here = chart.stable == stable
            style: dict[str, Any] = {"linestyle": "none", "markersize": 3.2, "color": colour}
            ax.plot(chart.frequency[here], chart.order[here], marker=marker, label=label, **style)
        for number, omega in enumerate(part.fitted.omega):
            ax.axvline(omega / (2 * np.pi), color=_FITTED, linewidth=0.9, label=None if number else "kept")
        other = ax.twinx()
        size = np.sum(np.abs(part.band.response), axis=1)
        other.semilogy(_lines(fit), size, color=_MEASURED, linewidth=0.9, label="sum of |G|", zorder=0)
        other.set_ylabel("sum of |G| (m/N)")
        ax.plot([], [], color=_MEASURED, linewidth=0.9, label="sum of |G|")
        ax.set_ylabel("order" if len(axes) == 1 else f"order, {', '.join(part.names)}")
        ax.set_ylim(0, np.max(chart.order) + 1)
        ax.set_xlim(*_lines(fit)[[0, -1]])
    axes[-1].set_xlabel("frequency (Hz)")
    legend_above(axes[0], columns=4)
    return cast("Figure", axes[0].figure)


def _panels(rows: int, columns: int, heights: tuple[float, ...], height: float = 5.2) -> Any:
    size = (max(7.0, 4.2 * columns), height)
    return plt.subplots(
        rows, columns, figsize=size, sharex=True, squeeze=False, layout="constrained", height_ratios=heights
    )[1]


def _finish(column: Any, frequency: np.ndarray, values: list[np.ndarray]) -> None:
    """Labels, and ends within which there is something to see."""
    top = max(float(np.max(np.abs(one))) for one in values)
    low = min(float(np.min(np.abs(one))) for one in values)
    column[0].set_ylim(max(low / 1.5, top * 10**-_DECADES), 2 * top)
    column[0].set_ylabel("receptance |G| (m/N)")
    column[1].set_ylabel("phase (°)")
    column[1].set_yticks([-270, -180, -90, 0, 90])
    column[1].set_ylim(-275, 95)
    column[-1].set_xlabel("frequency (Hz)")
    column[-1].set_xlim(frequency[0], frequency[-1])


def _lines(fit: "ModalFit") -> np.ndarray:
    return fit.parts[0].band.omega / (2 * np.pi)


def _phase(values: np.ndarray) -> np.ndarray:
    """Degrees from −270 to 90, so that a driving point is in the middle, broken where they leap from end to end."""
    angle = np.rad2deg(np.angle(1j * values)) - 90
    return np.where(np.abs(np.diff(angle, prepend=angle[0])) > 180, np.nan, angle)
