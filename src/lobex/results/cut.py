"""The result of a simulation of turning."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex._by_name import by_name
from lobex.processes.quantity import DEPTH_OF_CUT
from lobex.results.description import in_words, wall_time
from lobex.results.fields import Array, Coordinate, field
from lobex.results.march import span
from lobex.results.result import Result
from lobex.results.units import shown_gain, shown_span, shown_speed

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Cut(Result, form="lobex cut 2"):
    """Turning in time, lane by lane; lanes have the broadcast shape of speed and depth.

    Attributes:
        speed: (*lanes,), Hz.
        depth: depth of cut b, (*lanes,), m.
        feed: feed per revolution h₀, m.
        phase: revolutions since the start, (samples,).
        displacement: q of the tool away from the workpiece, (*lanes, samples), m; NaN once a lane has grown beyond
            floating point.
        chip_thickness: h, (*lanes, samples), m; 0 out of contact.
        force: radial cutting force, (*lanes, samples), N; 0 out of contact.
        state: the modes' (u, u̇/ω) at the end, (*lanes, d).
        steps_per_revolution: steps per revolution.
        modes, law: the tool and the cutting law, as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
    """

    speed: np.ndarray = field(Coordinate("*lane", "rotational frequency", "Hz"))
    depth: np.ndarray = field(Coordinate("*lane", "depth of cut", "m"))
    feed: float
    phase: np.ndarray = field(Coordinate("phase", "revolutions", "1", increasing=True))
    displacement: np.ndarray = field(Array("*lane phase", "tool displacement", "m"))
    chip_thickness: np.ndarray = field(Array("*lane phase", "chip thickness", "m"))
    force: np.ndarray = field(Array("*lane phase", "radial cutting force", "N"))
    state: np.ndarray = field(Array("*lane component", "state at the end"))
    steps_per_revolution: int
    modes: dict[str, Any]
    law: dict[str, Any]
    seconds: float
    compiling: float

    @property
    def time(self) -> np.ndarray:
        """The times of the samples, s, (*lanes, samples)."""
        return self.phase / self.speed[..., None]

    @property
    def amplitude(self) -> np.ndarray:
        """Half the range of the displacement over the last revolution, m, (*lanes,)."""
        last = self._last_revolution(self.displacement)
        return (last.max(axis=-1) - last.min(axis=-1)) / 2

    @property
    def separation(self) -> np.ndarray:
        """Share of the last revolution that the tool spends out of the cut, (*lanes,)."""
        force = self._last_revolution(self.force)
        return np.where(np.isnan(force).any(axis=-1), np.nan, np.mean(force == 0, axis=-1))

    def _last_revolution(self, samples: np.ndarray) -> np.ndarray:
        return samples[..., self.phase > self.phase[-1] - 1 + 1e-9]

    def __repr__(self) -> str:
        lost = int(np.isnan(self.state).any(axis=-1).sum())
        lines = [
            f"Cut: {self.speed.size} lanes, {self.phase[-1]:.0f} revolutions of {self.steps_per_revolution} steps",
            f"  speed            {shown_span(self.speed, lambda speed: shown_speed(speed, 'rpm'))}",
            f"  depth of cut     {shown_span(self.depth, lambda depth: shown_gain(depth, DEPTH_OF_CUT))}",
            f"  feed             {1e3 * self.feed:.6g} mm per revolution",
            f"  law              {in_words(self.law)} per depth",
            f"  last revolution  amplitude {span(self.amplitude)} m, out of the cut for {span(self.separation)} of it",
            f"  largest force    {span(np.nanmax(self.force, axis=-1, initial=0.0))} N",
            f"  wall time        {wall_time(self, self.speed.size, 'lane')}",
            f"  failed           {lost} lanes",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None, what: str = "displacement") -> "Axes":
        """Over revolutions, lane by lane as in Fig. 2.5; returns the axes.

        ``what`` is "displacement", "chip_thickness" or "force".
        """
        return by_name("plots.cut_picture.plot_cut")(self, ax, what)
