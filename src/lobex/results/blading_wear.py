"""The result of a wear march of several contacts: those of a blading, or several on one tip."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex._by_name import by_name
from lobex.results.description import wall_time
from lobex.results.fields import Array, field
from lobex.results.of_wear import OfWear, open_share
from lobex.results.wear_map import WearMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class BladingWear(OfWear, form="lobex blading wear 2"):
    """What rubbing blades left of their casing, and how each of them moved, over n lanes of speeds.

    Contacts are those of the first blade, of the second, and so on, C in all. Lanes that blew up are NaN in every array
    but the speeds. Pictures and summaries count blades and tracks from 1.

    Attributes:
        speed, speed_history, angle: as of ``WearMap``.
        blade, track: whose each contact is, and in which track it runs, (C,).
        place: angle at which each contact begins, rad, (C,), to the nearest cell.
        unworn: the tracks' profiles before wear, seen from tips at rest, m, (tracks, cells).
        depth: depth removed after the last revolution, m, at least 0, (n, tracks, cells).
        wear: cross-section removed from each track in every revolution, m², (n, tracks, revolutions).
        displacement: of the tip at every contact, low-pass filtered and sampled, m, (n, C, samples).
        amplitude, casing_amplitude, contact, force, input_energy, removal_energy, friction_energy: as of ``WearMap``,
            of every contact, (n, C, revolutions).
        damping_energy, stored_energy, speeding_energy: as of ``WearMap``, of every blade, (n, blades, revolutions).
        casing_damping_energy, casing_stored_energy, casing_speeding_energy: the same of the casing, (n, revolutions).
        watched: as of ``WearMap``, of every blade, (n, blades, watched, samples).
        watched_amplitude: the largest of each in every revolution, (n, blades, watched, revolutions).
        natural_frequency: of the blade without mistuning or coupling, Hz, (modes,); at the first speed, if they
            follow it.
        samples_per_revolution, lag, usable_orders, nodal_diameters, radius, axial_width, model, seconds, compiling,
            failed: as of ``WearMap``.
    """

    blade: np.ndarray = field(Array("contact", "blade of the contact", name="blade_of_contact", dtype=np.int64))
    track: np.ndarray = field(Array("contact", "track of the contact", name="track_of_contact", dtype=np.int64))
    place: np.ndarray = field(
        Array("contact", "angle at which the contact begins", "rad", name="place_of_contact", known=True)
    )
    unworn: np.ndarray = field(Array("track angle", "profile before wear", "m"))
    depth: np.ndarray = field(Array("speed track angle", "depth removed", "m"))
    wear: np.ndarray = field(Array("speed track revolution", "cross-section removed", "m2"))
    displacement: np.ndarray = field(Array("speed contact sample", "displacement of the tip", "m"))
    amplitude: np.ndarray = field(Array("speed contact revolution", "largest displacement of the tip", "m"))
    casing_amplitude: np.ndarray = field(Array("speed contact revolution", "largest displacement of the casing", "m"))
    contact: np.ndarray = field(
        Array("speed contact revolution", "share of time in contact", "1", name="contact_share")
    )
    force: np.ndarray = field(Array("speed contact revolution", "largest contact force", "N"))
    input_energy: np.ndarray = field(Array("speed contact revolution", "work of the contact that drives the tip", "J"))
    removal_energy: np.ndarray = field(Array("speed contact revolution", "work of the tip on the coating", "J"))
    friction_energy: np.ndarray = field(Array("speed contact revolution", "work of the tip against friction", "J"))
    damping_energy: np.ndarray = field(Array("speed blade revolution", "energy lost in damping", "J"))
    stored_energy: np.ndarray = field(Array("speed blade revolution", "kinetic and strain energy at the end", "J"))
    speeding_energy: np.ndarray = field(Array("speed blade revolution", "energy gained by a change of speed", "J"))
    casing_damping_energy: np.ndarray = field(Array("speed revolution", "energy lost in the casing's damping", "J"))
    casing_stored_energy: np.ndarray = field(Array("speed revolution", "energy of the casing at the end", "J"))
    casing_speeding_energy: np.ndarray = field(Array("speed revolution", "energy that the casing gained", "J"))
    watched: np.ndarray = field(Array("speed blade output sample", "what is watched"))
    watched_amplitude: np.ndarray = field(Array("speed blade output revolution", "largest of what is watched"))

    @property
    def blades(self) -> int:
        """Number of blades."""
        return self.damping_energy.shape[1]

    @property
    def profile(self) -> np.ndarray:
        """The tracks' profiles after the last revolution, m, (n, tracks, cells)."""
        return self.unworn + self.depth

    @property
    def peak(self) -> np.ndarray:
        """Largest |displacement| of the tip at every contact, m, (n, C)."""
        return np.max(self.amplitude, axis=2)

    @property
    def blade_to_blade(self) -> np.ndarray:
        """Largest |displacement| of every blade over the mean of all, (n, blades)."""
        largest = np.stack([self.peak[:, self.blade == one].max(axis=1) for one in range(self.blades)], axis=1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return largest / np.mean(largest, axis=1, keepdims=True)

    @property
    def volume(self) -> np.ndarray:
        """Volume removed from all tracks, m³, (n,)."""
        return self.axial_width * np.sum(self.wear, axis=(1, 2))

    @property
    def energy_error(self) -> np.ndarray:
        """What the energy balance of blades and casing leaves open, as a share of the input, (n,)."""
        lost = np.sum(self.removal_energy, axis=(1, 2))
        lost += np.sum(self.damping_energy - self.speeding_energy, axis=(1, 2))
        lost += np.sum(self.casing_damping_energy - self.casing_speeding_energy, axis=1)
        stored = np.sum(self.stored_energy[:, :, -1], axis=1) + self.casing_stored_energy[:, -1]
        return open_share(np.sum(self.input_energy, axis=(1, 2)), lost + stored)

    def of(self, contact: int) -> WearMap:
        """One contact and its track as a ``WearMap``, whose spectra and pictures are those of any other.

        Its energies of damping and vibration are those of the contact's blade; the casing's are left out, and with
        them, and with other contacts of the blade, its energy balance stays open.

        Raises:
            ValueError: for a contact that is not there.
        """
        contact = _checks.integer("contact", contact, 0, len(self.track) - 1)
        own, track = int(self.blade[contact]), int(self.track[contact])
        names = ("displacement", "amplitude", "casing_amplitude", "contact", "force")
        energies = ("input_energy", "removal_energy", "friction_energy")
        of_blade = ("damping_energy", "stored_energy", "speeding_energy", "watched", "watched_amplitude")
        shared = ("speed", "speed_history", "angle", "samples_per_revolution", "lag", "usable_orders")
        model = ("natural_frequency", "nodal_diameters", "radius", "axial_width", "seconds", "compiling", "failed")
        values: dict[str, Any] = {name: getattr(self, name) for name in (*shared, *model)}
        values |= {name: getattr(self, name)[:, contact] for name in (*names, *energies)}
        values |= {name: getattr(self, name)[:, own] for name in of_blade}
        casing, law = self.model["casing"], self.model["law"]
        of_contact = contact % int(np.sum(self.blade == 0))
        said = {
            "modes": self.model["modes"],
            "casing": casing[track] if isinstance(casing, list) else casing,
            "law": law[of_contact] if isinstance(law, list) else law,
        }
        return WearMap(
            unworn=self.unworn[track], depth=self.depth[:, track], wear=self.wear[:, track], model=said, **values
        )

    def __repr__(self) -> str:
        tracks = len(self.unworn)
        lines = [
            f"BladingWear of {self.blades} blade{'s' * (self.blades > 1)}, {len(self.track)} contacts in {tracks} "
            f"track{'s' * (tracks > 1)}: {len(self.speed)} speeds × {self.revolutions} revolutions × "
            f"{len(self.angle)} cells",
            f"  speed            {self.speed_history.min():.6g} to {self.speed_history.max():.6g} Hz"
            + ("" if self.steady else ", changing"),
        ]
        if self.failed < len(self.speed):
            worst, (lane, contact) = (
                int(np.nanargmax(self.volume)),
                np.unravel_index(np.nanargmax(self.peak), self.peak.shape),
            )
            lines += [
                f"  most wear        {self.volume[worst]:.6g} m³ at {self.speed[worst]:.6g} Hz",
                f"  largest motion   {self.peak[lane, contact]:.6g} m of blade {self.blade[contact] + 1} at "
                f"{self.speed[lane]:.6g} Hz",
                f"  largest force    {np.nanmax(self.force):.6g} N",
                f"  energy balance   open by {np.nanmax(np.abs(self.energy_error)):.1e} of the input, at most",
            ]
        lines += [
            f"  wall time        {wall_time(self, len(self.speed), 'lane')}",
            f"  failed           {self.failed} lanes",
        ]
        return "\n".join(lines)

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """The largest motion of every blade over speed; returns the axes."""
        return by_name("plots.blading_picture.plot_blading")(self, ax)
