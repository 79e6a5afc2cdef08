"""The result of a wear march."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex._by_name import by_name
from lobex.results.description import in_words, wall_time
from lobex.results.fields import Array, Attribute, Coordinate, field
from lobex.results.result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.spectrum_map import SpectrumMap


class WearMap(Result, form="lobex wear map 2"):
    """What a rubbing blade left of its casing, and how it moved, over n lanes of speeds.

    Lanes that blew up are NaN in every array but the speeds.

    Attributes:
        speed: speed of the first revolution, Hz, (n,).
        speed_history: speed of every revolution, Hz, (n, revolutions).
        angle: angle of every casing cell, rad, (cells,).
        unworn: the casing's profile before wear, seen from the tip at rest, m, (cells,).
        depth: depth removed after the last revolution, m, at least 0, (n, cells).
        wear: cross-section removed in every revolution, m², (n, revolutions).
        displacement: displacement of the tip, low-pass filtered and sampled, m, (n, samples); see ``time``.
        amplitude: largest |displacement| of the tip in every revolution, of all time steps, m, (n, revolutions).
        contact: share of every revolution spent in contact, (n, revolutions).
        input_energy: work of the contact on a tip that it drives back, J, in every revolution, (n, revolutions).
        removal_energy: work of the tip that moves into the coating against the contact force, J, likewise.
        damping_energy: energy lost in the modal damping, J, likewise.
        stored_energy: kinetic and strain energy of the blade at the end of every revolution, J, likewise.
        samples_per_revolution: samples of ``displacement`` per revolution.
        lag: samples by which ``displacement`` is late, from the filter.
        usable_orders: engine orders up to which ``displacement`` holds the motion.
        natural_frequency: the blade's, Hz, (modes,).
        nodal_diameters: bumps of the casing per revolution.
        radius, axial_width: of the casing, m.
        model: modes, casing and law as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
        failed: number of lanes that are NaN.
    """

    speed: np.ndarray = field(Coordinate("lane", "rotational frequency", "Hz"))
    speed_history: np.ndarray = field(
        Array("lane revolution", "rotational frequency of every revolution", "Hz", known=True)
    )
    angle: np.ndarray = field(Coordinate("angle", "casing position", "rad", increasing=True))
    unworn: np.ndarray = field(Array("angle", "profile before wear", "m"))
    depth: np.ndarray = field(Array("lane angle", "depth removed", "m"))
    wear: np.ndarray = field(Array("lane revolution", "cross-section removed", "m2"))
    displacement: np.ndarray = field(Array("lane sample", "displacement of the tip", "m"))
    amplitude: np.ndarray = field(Array("lane revolution", "largest displacement of the tip", "m"))
    contact: np.ndarray = field(Array("lane revolution", "share of time in contact", "1"))
    input_energy: np.ndarray = field(Array("lane revolution", "work of the contact that drives the tip back", "J"))
    removal_energy: np.ndarray = field(Array("lane revolution", "work of the tip on the coating", "J"))
    damping_energy: np.ndarray = field(Array("lane revolution", "energy lost in damping", "J"))
    stored_energy: np.ndarray = field(Array("lane revolution", "kinetic and strain energy at the end", "J"))
    samples_per_revolution: int
    lag: int
    usable_orders: int
    natural_frequency: np.ndarray = field(Array("mode", "natural frequency", "Hz", known=True))
    nodal_diameters: int
    radius: float
    axial_width: float
    model: dict[str, Any] = field(Attribute(lambda stored, name: stored.descriptions(name, "modes", "casing", "law")))
    seconds: float
    compiling: float
    failed: int

    @property
    def revolutions(self) -> int:
        """Number of revolutions."""
        return self.speed_history.shape[1]

    @property
    def profile(self) -> np.ndarray:
        """The casing's profile after the last revolution, m, (n, cells)."""
        return self.unworn + self.depth

    @property
    def peak(self) -> np.ndarray:
        """Largest |displacement| of the tip, m, (n,)."""
        return np.max(self.amplitude, axis=1)

    @property
    def separation(self) -> np.ndarray:
        """Share of the march spent out of contact, by steps, (n,)."""
        return 1 - np.mean(self.contact, axis=1)

    @property
    def volume(self) -> np.ndarray:
        """Volume removed, m³, (n,)."""
        return self.axial_width * np.sum(self.wear, axis=1)

    @property
    def energy_error(self) -> np.ndarray:
        """What the energy balance leaves open, as a share of the input, (n,): of the order of the squared step."""
        lost = np.sum(self.removal_energy + self.damping_energy, axis=1) + self.stored_energy[:, -1]
        given = np.sum(self.input_energy, axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(given == lost, 0.0, (given - lost) / given)

    @property
    def steady(self) -> bool:
        """Whether every lane kept its speed."""
        return bool(np.all(self.speed_history == self.speed[:, None]))

    def time(self, lane: int) -> np.ndarray:
        """Times of the samples of ``displacement`` in a lane of constant speed, s, (samples,)."""
        if np.any(self.speed_history[lane] != self.speed[lane]):
            raise ValueError(f"lane = {lane} changes its speed; its samples lie at equal angles, not at equal times")
        samples = np.arange(self.displacement.shape[1]) - self.lag
        return samples / (self.samples_per_revolution * self.speed[lane])

    def nearest(self, speed: float) -> int:
        """The lane whose first speed is nearest to ``speed``, Hz."""
        _checks.positive("speed", speed, "Hz")
        _checks.scalar("speed", speed)
        return int(np.argmin(np.abs(self.speed - speed)))

    def __repr__(self) -> str:
        lines = [
            f"WearMap of {self.model['law']['type']} contact: {len(self.speed)} speeds × {self.revolutions} "
            f"revolutions × {len(self.angle)} cells",
            f"  speed            {self.speed_history.min():.6g} to {self.speed_history.max():.6g} Hz"
            + ("" if self.steady else ", changing"),
            f"  casing           {in_words({k: v for k, v in self.model['casing'].items() if k != 'surface'})}",
            f"  law              {in_words(self.model['law'])}",
        ]
        if self.failed < len(self.speed):
            worst = int(np.nanargmax(self.volume))
            error = np.nanmax(np.abs(self.energy_error))
            lines += [
                f"  most wear        {self.volume[worst]:.6g} m³ at {self.speed[worst]:.6g} Hz",
                f"  largest motion   {np.nanmax(self.peak):.6g} m at {self.speed[np.nanargmax(self.peak)]:.6g} Hz",
                f"  energy balance   open by {error:.1e} of the input, at most",
            ]
        lines += [
            f"  wall time        {wall_time(self, len(self.speed), 'lane')}",
            f"  failed           {self.failed} lanes",
        ]
        return "\n".join(lines)

    def spectrum(self, skip: int = 0, window: str = "flattop") -> "SpectrumMap":
        """Amplitudes of the tip's motion over frequency, at every speed, Fig. 1.4.

        Args:
            skip: revolutions to leave out at the start.
            window: a name of ``scipy.signal.get_window``. "flattop" gives amplitudes right to 0.1 % at any frequency;
                "hann" tells closer lines apart and is up to 15 % low between its bins.

        Raises:
            ValueError: for fewer than two revolutions left, an unknown window, or lanes that change their speed.
        """
        from lobex.results.spectrum_map import spectrum_of

        return spectrum_of(self, skip, window)

    def plot(self, ax: "Axes | None" = None, speed_along: str = "x") -> "Axes":
        """The depth removed over speed and casing position, Fig. 1.3, speed along "x" or "y"; returns the axes."""
        return by_name("plots.wear_pictures.plot_wear")(self, ax, speed_along)

    def plot_casing(self, speed: float, ax: "Axes | None" = None, magnification: float | None = None) -> "Axes":
        """The worn casing at the lane nearest to ``speed`` (Hz), in polar form and exaggerated; returns the axes."""
        return by_name("plots.casing_pictures.plot_worn_casing")(self, self.nearest(speed), ax, magnification)

    def plot_history(self, axes: "Sequence[Axes] | None" = None) -> "Figure":
        """Amplitude and wear of every revolution over its speed (a ramp) or over the revolutions; returns the figure.

        ``axes`` are two axes to draw into, for amplitude and for wear.
        """
        return by_name("plots.wear_pictures.plot_history")(self, axes)
