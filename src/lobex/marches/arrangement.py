"""What rubs where: the blades, the casing and the laws of a march, in order."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex.contact.casing import Casing, check_casing
from lobex.contact.law_of_each import OfEach
from lobex.contact.laws import ContactLaw, check_law
from lobex.marches.bodies import Structure
from lobex.marches.tracks import Tracks
from lobex.structures.ring_waves import RingWaves


class Arrangement(NamedTuple):
    """Blades and casing of a march.

    Attributes:
        blades: one, or all of a blading.
        structure: what carries the coating, or None where it is rigid.
        casings: one for each track.
        laws: one for each contact of a blade.
        track, place: of each contact of a blade, (contacts,), and where each begins, in shares of a revolution,
            (contacts, blades).
    """

    blades: Structure
    structure: Structure | None
    casings: tuple[Casing, ...]
    laws: tuple[ContactLaw, ...]
    track: tuple[int, ...]
    place: Float[np.ndarray, "contacts blades"]

    @classmethod
    def of(cls, modes: Any, casing: Any, law: Any, angles: Any, tracks: Any, watched: int) -> "Arrangement":
        """Of the arguments of ``march_wear``, once they are what they should be."""
        blades = Structure("modes", modes)
        watched = _checks.integer("watched", watched, 0)
        if watched >= blades.contacts:
            raise ValueError(
                f"watched = {watched} leaves no contact of the {blades.contacts} contact directions of modes; give less"
            )
        blades = Structure("modes", modes, blades.contacts - watched)
        place = _places(modes, blades, angles)
        track = _track_of(tracks, blades.contacts)
        casings = _each("casing", casing, max(track) + 1, check_casing, "track")
        laws = _each("law", law, blades.contacts, check_law, "contact")
        first = casings[0]
        if any(float(one.radius) != float(first.radius) or one.structure is not first.structure for one in casings):
            raise ValueError("casing has tracks of several radii or structures; give one radius and one structure")
        structure = None
        if first.structure is not None:
            wanted, carries = place.size, first.structure
            if wanted > 1 and hasattr(carries, "nodal_diameter"):
                carries = RingWaves(carries, 2 * np.pi * place.ravel())
            structure = Structure("casing.structure", carries)
            if structure.contacts != wanted:
                raise ValueError(
                    f"casing.structure has {structure.contacts} contact directions; give one for each contact, {wanted}"
                )
        return cls(blades, structure, casings, laws, track, place)

    @property
    def structures(self) -> tuple[Structure, ...]:
        """What moves: the blades, and a casing that is flexible."""
        return (self.blades,) if self.structure is None else (self.blades, self.structure)

    @property
    def single(self) -> bool:
        """Whether there is one contact alone."""
        return self.place.size == 1

    @property
    def law(self) -> ContactLaw:
        """One law for all contacts, its numbers over (contacts, 1, 1) where they differ."""
        if len(self.laws) == 1:
            return self.laws[0]
        if len({type(one) for one in self.laws}) > 1:
            return OfEach(self.laws)
        return jax.tree.map(lambda *parts: np.array(parts, dtype=float).reshape(-1, 1, 1), *self.laws)

    def tracks(self, cells: int) -> Tracks:
        """The places in cells, the nearest ones."""
        return Tracks.of(cells, self.track, np.round(self.place * cells).astype(int) % cells)

    def profiles(self, cells: int) -> Float[np.ndarray, "tracks {cells}"]:
        """Of all tracks before wear, m."""
        return np.stack([np.asarray(one.profile(cells)) for one in self.casings])


def _each(name: str, given: Any, count: int, check: Any, what: str) -> tuple[Any, ...]:
    """One for all, or a list of one each, checked."""
    if not isinstance(given, list | tuple):
        check(given)
        return (given,) * count
    if len(given) != count:
        raise ValueError(f"{name} has {len(given)} entries; give one, or one for each {what}, {count}")
    for one in given:
        check(one)
    return tuple(given)


def _track_of(tracks: Any, contacts: int) -> tuple[int, ...]:
    if tracks is None:
        return tuple(range(contacts))
    if not isinstance(tracks, Sequence) or len(tracks) != contacts:
        raise ValueError(f"tracks = {_checks.brief(tracks)}; give one number for each contact, {contacts}, from 0")
    numbers = tuple(_checks.integer("tracks", number, 0, contacts - 1) for number in tracks)
    if set(numbers) != set(range(max(numbers) + 1)):
        raise ValueError(f"tracks = {_checks.brief(tracks)} leaves a track out; number them 0, 1, …")
    return numbers


def _places(modes: Any, blades: Structure, angles: Any) -> Float[np.ndarray, "contacts blades"]:
    own = np.zeros(blades.contacts)
    if angles is not None:
        degrees = _checks.as_numbers("angles_degrees", angles, "degrees")
        if degrees is None or degrees.shape != (blades.contacts,):
            raise ValueError(
                f"angles_degrees has shape {np.shape(angles)}; give one for each contact, ({blades.contacts},)"
            )
        own = degrees / 360
    ahead = np.asarray(modes.places) if blades.blades > 1 else np.zeros(1)
    return own[:, None] + ahead
