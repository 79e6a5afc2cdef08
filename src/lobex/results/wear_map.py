"""The result of a wear march of one contact."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lobex._by_name import by_name
from lobex.results.description import in_words, wall_time
from lobex.results.fields import Array, field
from lobex.results.of_wear import OfWear, open_share

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lobex.results.spectrum_map import SpectrumMap


class WearMap(OfWear, form="lobex wear map 4"):
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
        casing_amplitude: the same of a casing that is flexible, at the contact, m, likewise.
        contact: share of every revolution spent in contact, (n, revolutions).
        force: largest contact force in every revolution, N, (n, revolutions).
        input_energy: work of the contact on a tip that it drives back, J, in every revolution, (n, revolutions).
        removal_energy: work of the tip that moves into the coating against the contact force, J, likewise.
        friction_energy: of removal − input, what the part of the force along the surface takes, J, likewise: that of
            the vibration, besides the heat of the sliding, which the rotor pays for.
        damping_energy: energy lost in the modal damping, J, likewise.
        stored_energy: kinetic and strain energy of blade and casing at the end of every revolution, J, likewise.
        speeding_energy: what these gained before each revolution as their modes became those of another speed, J.
        watched: displacements, loads or stresses that are no contacts, as ``displacement``, (n, watched, samples).
        watched_amplitude: the largest of each in every revolution, (n, watched, revolutions).
        samples_per_revolution: samples of ``displacement`` per revolution.
        lag: samples by which ``displacement`` is late, from the filter.
        usable_orders: engine orders up to which ``displacement`` holds the motion.
        natural_frequency: the blade's, Hz, (modes,); at the first speed, if they follow it.
        nodal_diameters: bumps of the casing per revolution.
        radius, axial_width: of the casing, m.
        model: modes, casing and law as plain dictionaries.
        seconds: wall time, compiling included.
        compiling: the part of it in which JAX traced and compiled programs; 0 where they were there already.
        failed: number of lanes that are NaN.
    """

    unworn: np.ndarray = field(Array("angle", "profile before wear", "m"))
    depth: np.ndarray = field(Array("speed angle", "depth removed", "m"))
    wear: np.ndarray = field(Array("speed revolution", "cross-section removed", "m2"))
    displacement: np.ndarray = field(Array("speed sample", "displacement of the tip", "m"))
    amplitude: np.ndarray = field(Array("speed revolution", "largest displacement of the tip", "m"))
    casing_amplitude: np.ndarray = field(Array("speed revolution", "largest displacement of the casing", "m"))
    contact: np.ndarray = field(Array("speed revolution", "share of time in contact", "1"))
    force: np.ndarray = field(Array("speed revolution", "largest contact force", "N"))
    input_energy: np.ndarray = field(Array("speed revolution", "work of the contact that drives the tip back", "J"))
    removal_energy: np.ndarray = field(Array("speed revolution", "work of the tip on the coating", "J"))
    friction_energy: np.ndarray = field(Array("speed revolution", "work of the tip against friction", "J"))
    damping_energy: np.ndarray = field(Array("speed revolution", "energy lost in damping", "J"))
    stored_energy: np.ndarray = field(Array("speed revolution", "kinetic and strain energy at the end", "J"))
    speeding_energy: np.ndarray = field(Array("speed revolution", "energy gained by a change of speed", "J"))
    watched: np.ndarray = field(Array("speed output sample", "what is watched"))
    watched_amplitude: np.ndarray = field(Array("speed output revolution", "largest of what is watched"))

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
    def clearance_consumed(self) -> np.ndarray:
        """By how much the tip came closer to the casing than at rest, at most, of the samples, m, (n, revolutions)."""
        turns = self.displacement.reshape(len(self.speed), self.revolutions, -1)
        return np.maximum(np.max(turns, axis=2), 0.0)

    @property
    def energy_error(self) -> np.ndarray:
        """What the energy balance leaves open, as a share of the input, (n,): of the order of the squared step."""
        lost = np.sum(self.removal_energy + self.damping_energy - self.speeding_energy, axis=1)
        return open_share(np.sum(self.input_energy, axis=1), lost + self.stored_energy[:, -1])

    def __repr__(self) -> str:
        casing = {name: of for name, of in self.model["casing"].items() if name not in ("surface", "structure")}
        lines = [
            f"WearMap of {self.model['law']['type']} contact: {len(self.speed)} speeds × {self.revolutions} "
            f"revolutions × {len(self.angle)} cells",
            f"  speed            {self.speed_history.min():.6g} to {self.speed_history.max():.6g} Hz"
            + ("" if self.steady else ", changing"),
            f"  casing           {in_words(casing)}",
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

    def plot_tip_orbit(
        self,
        speed: float,
        ax: "Axes | None" = None,
        directions: tuple[str, str] = ("tangential", "axial"),
        revolutions: int = 1,
    ) -> "Axes":
        """The path of the tip at the lane nearest to ``speed`` (Hz), as ``Beam.watch(tip=True)`` sees it first among
        what is watched; returns the axes.

        Args:
            speed: Hz.
            ax: axes to draw into.
            directions: along the two axes, "radial", "tangential" or "axial".
            revolutions: so many of the last ones.

        Raises:
            ValueError: where no tip was watched, and for other directions or more revolutions than there are.
        """
        draw = by_name("plots.tip_orbit_picture.plot_tip_orbit")
        return draw(self, self.nearest(speed), ax, directions, revolutions)
