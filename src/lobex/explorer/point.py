"""What goes on at one point of the diagram: the motion in time, its spectrum, once-per-tooth samples, and the wall."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from lobex.explorer.recipes import process_of
from lobex.explorer.state import BladingNumbers, Measured, State
from lobex.marches.delay import fewest_steps, march_delay
from lobex.motions.forced_motion import orbit
from lobex.results.march import March
from lobex.results.orbit import Orbit
from lobex.verbs import spectral_radius

# Of a march, steps are so many times what it takes at least, rounded up to a power of two, so that few sizes compile.
_FINER, _LEAST = 16, 256
# Where nothing forces the motion it begins with a deflection, m.
_DEFLECTION = 1e-6
_MOST_SAMPLES = 400_000


@dataclass(frozen=True, eq=False)
class AtPoint:
    """What was found at a point.

    Attributes:
        speed, gain: of it, Hz and N/m or m.
        radius: max|μ|.
        deflection: that it starts from, m, of each contact, (r,): of blades the first alone, so that all waves around
            the disc are in it.
        march: the motion.
        orbit: the periodic motion of a forced stable point; None of others.
    """

    speed: float
    gain: float
    radius: float
    deflection: tuple[float, ...]
    march: March
    orbit: Orbit | None

    @property
    def location_error(self) -> Float[np.ndarray, " teeth"] | None:
        """Material left at the finished wall by each tooth, m, of all heights what is largest in size, (teeth,)."""
        error = getattr(self.orbit, "surface_location_error", None)
        if error is None or not np.isfinite(error).any():
            return None
        error = error.reshape(error.shape[-2:])
        return error[np.arange(len(error)), np.argmax(np.abs(error), axis=1)]

    def spectrum(self) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n r"]]:
        """Frequencies, Hz, and amplitudes, m, of the last half of the march under Hann's window."""
        moved = self.march.displacement
        half = moved[len(moved) // 2 :]
        half = half[np.isfinite(half).all(axis=1)]
        step = float(self.march.delay) / self.march.steps_per_period
        window = np.hanning(len(half))[:, None]
        parts = np.fft.rfft((half - half.mean(axis=0)) * window, axis=0) / max(window.sum() / 2, 1.0)
        return np.fft.rfftfreq(len(half), step), np.abs(parts)

    def samples(self) -> Float[np.ndarray, "n r"]:
        """The displacement once per pass, m."""
        return self.march.displacement[:: self.march.steps_per_period]


def at_point(state: State) -> AtPoint:
    """March the process of a state at its point.

    Raises:
        ValueError: without a point, for a measured structure, and for marches that do not fit.
    """
    if state.point is None:
        raise ValueError("point = None; click at a point of the diagram")
    if isinstance(state.structure, Measured):
        raise ValueError("structure = measured has no equations to march in time; give modes, such as fitted ones")
    process, point = process_of(state), state.point
    needed = _FINER * fewest_steps(process, point.speed, point.gain)
    steps = max(_LEAST, 1 << int(np.ceil(np.log2(needed))))
    periods = min(state.periods, _MOST_SAMPLES // steps)
    forced = bool(process.system(point.speed, point.gain).forcing)
    directions = process.modes.directions
    alike = not isinstance(state.numbers, BladingNumbers)
    deflection = tuple(0.0 if forced or (i and not alike) else _DEFLECTION for i in range(directions))

    def history(time: np.ndarray) -> np.ndarray:
        return np.zeros((*time.shape, 1)) + np.array(deflection)

    march = march_delay(process, point.speed, point.gain, history, periods, steps)
    radius = float(spectral_radius(process, point.speed, point.gain))
    motion = orbit(process, point.speed, point.gain) if forced and radius < 1 else None
    return AtPoint(point.speed, point.gain, radius, deflection, march, motion)
