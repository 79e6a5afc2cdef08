"""Spectra of a rubbing blade over speed, and the speeds at which they are expected to peak."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex._by_name import by_name
from lobex.results.fields import Array, Coordinate, derived, field
from lobex.results.result import Result
from lobex.structures.engine_orders import crossing_speeds
from lobex.structures.modes import check_modes
from lobex.structures.rotating_modes import AnyModes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.wear_map import WearMap

_BLOCK = 64


class SpectrumMap(Result, form="lobex spectrum 1"):
    """Amplitudes of the tip's motion over speed and frequency, on each speed's own frequencies.

    Attributes:
        speed: (n,), Hz.
        order: frequency divided by speed, which is the engine order at whole numbers, (m,).
        amplitude: amplitude of a line at that frequency, m, (n, m); NaN where a lane failed.
        natural_frequency: the blade's, Hz, (modes,); at the first speed, if they follow it.
        nodal_diameters: bumps of the casing per revolution.
        window: the window used.
    """

    speed: np.ndarray = field(Coordinate("speed", "rotational frequency", "Hz"))
    order: np.ndarray = field(Coordinate("order", "frequency divided by speed", "1", increasing=True))
    amplitude: np.ndarray = field(Array("speed order", "amplitude of the tip", "m"))
    natural_frequency: np.ndarray = field(Array("mode", "natural frequency", "Hz", known=True))
    nodal_diameters: int
    window: str

    @property
    @derived(Coordinate("speed order", "frequency", "Hz"), after="order")
    def frequency(self) -> np.ndarray:
        """Frequency of every point, Hz, (n, m)."""
        return self.speed[:, None] * self.order

    def engine_order(self, number: int) -> np.ndarray:
        """Amplitude along engine order ``number``, m, (n,)."""
        _checks.choice("number", int(number), [int(k) for k in self.order[self.order % 1 == 0]])
        return self.amplitude[:, int(np.argmin(np.abs(self.order - number)))]

    def __repr__(self) -> str:
        lines = [
            f"SpectrumMap: {len(self.speed)} speeds × {len(self.order)} frequencies, window {self.window!r}",
            f"  speed            {self.speed.min():.6g} to {self.speed.max():.6g} Hz",
            f"  engine order     {self.order[0]:.6g} to {self.order[-1]:.6g} in steps of {self.order[1]:.6g}",
        ]
        if np.isfinite(self.amplitude).any():
            i, j = np.unravel_index(np.nanargmax(self.amplitude), self.amplitude.shape)
            lines.append(
                f"  largest line     {self.amplitude[i, j]:.6g} m at {self.frequency[i, j]:.6g} Hz, engine order "
                f"{self.order[j]:.6g}, speed {self.speed[i]:.6g} Hz"
            )
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, highest: float | None = None, orders: int | None = None) -> "Axes":
        """Amplitude over speed and frequency with engine orders, natural frequencies and critical speeds, Fig. 1.4.

        ``highest`` is the highest frequency drawn, Hz; ``orders`` the number of engine orders drawn. Returns the axes.
        """
        return by_name("plots.spectrum_picture.plot_spectrum")(self, ax, highest, orders)


def amplitude_spectrum(signal: np.ndarray, window: str = "flattop") -> np.ndarray:
    """Amplitudes of the lines of real signals (…, samples), shape (…, samples//2 + 1).

    Windowed and scaled such that a sine of amplitude a gives a at its frequency; the mean comes first, and is taken
    off before the window so that it does not leak.
    """
    from scipy.signal import get_window

    try:
        weight: np.ndarray = np.asarray(get_window(window, signal.shape[-1]), dtype=np.float64)
    except ValueError:
        raise ValueError(f"window = {window!r} is unknown; give a name such as 'flattop' or 'hann'") from None
    mean = np.mean(signal, axis=-1, keepdims=True)
    lines = 2 / np.sum(weight) * np.abs(np.fft.rfft((signal - mean) * weight, axis=-1))
    lines[..., 0] = np.abs(mean[..., 0])
    return lines


def spectrum_of(march: "WearMap", skip: int, window: str) -> SpectrumMap:
    """The spectra of a march; see ``WearMap.spectrum``."""
    skip = _checks.integer("skip", skip, 0)
    turns = march.revolutions - skip
    if turns < 2:
        raise ValueError(f"skip = {skip} leaves {max(turns, 0)} of {march.revolutions} revolutions; leave two or more")
    if not march.steady:
        raise ValueError("a march of changing speed has no spectrum per speed; see WearMap.plot_history()")
    signal = march.displacement[:, skip * march.samples_per_revolution :]
    count = march.usable_orders * turns + 1
    amplitude = np.empty((len(march.speed), count))
    # In blocks: the transform of all lanes at once would be the largest array of all.
    for start in range(0, len(amplitude), _BLOCK):
        lanes = np.s_[start : start + _BLOCK]
        amplitude[lanes] = amplitude_spectrum(signal[lanes], window)[:, :count]
    return SpectrumMap(
        speed=march.speed,
        order=np.arange(count) / turns,
        amplitude=amplitude,
        natural_frequency=march.natural_frequency,
        nodal_diameters=march.nodal_diameters,
        window=window,
    )


def critical_speeds(modes: AnyModes, nodal_diameters: int = 2, harmonics: int = 3) -> np.ndarray:
    """Speeds at which a multiple of the casing's nodal diameters excites a natural frequency, (1.18).

    Args:
        modes: the blade's modes, also those that follow the speed.
        nodal_diameters: bumps of the casing per revolution.
        harmonics: how many multiples k = nodal_diameters · 1, 2, …

    Returns:
        f/k in Hz, shape (modes, harmonics), with f at that very speed, NaN where a mode stiffens away from an order:
        engine-order resonances without contact, which stiffens the blade and moves them up.
    """
    check_modes(modes, over_speed=True)
    _checks.untraced("critical_speeds", modes=modes)
    return crossing_speeds(modes, multiples(nodal_diameters, harmonics))


def critical_speeds_of(frequency: Any, nodal_diameters: int, harmonics: int) -> np.ndarray:
    """f/k of natural frequencies (modes,), shape (modes, harmonics)."""
    return np.asarray(frequency, dtype=float)[:, None] / multiples(nodal_diameters, harmonics)


def multiples(nodal_diameters: int, harmonics: int) -> np.ndarray:
    """k = nodal_diameters · 1, 2, …, (harmonics,)."""
    nodal_diameters = _checks.integer("nodal_diameters", nodal_diameters, 1)
    return nodal_diameters * np.arange(1, _checks.integer("harmonics", harmonics, 1) + 1)
