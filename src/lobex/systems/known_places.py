"""Where pieces end, as far as it is known before tracing: which places matter, and which are carried to one another."""

from math import ceil

import numpy as np

from lobex.systems.closed_places import acting_at, closed_places
from lobex.systems.links import due_from_before
from lobex.systems.mesh import IMAGES, ROUNDING, carriers_of, generations_of, phases_of_jumps
from lobex.systems.system import Closed, DelaySystem, Places


def places_that_matter(system: DelaySystem) -> Places:
    """Of all jumps and their images, of a system of known numbers, those that differ and at which a force acts.

    To be asked by processes whose jumps and delays keep their order whatever speed and gain, once when they are made:
    each place that is left out is a piece less.
    """
    generations = [np.mod(np.asarray(part), 1.0) for part in generations_of(system, IMAGES + 1)]
    places = np.concatenate(generations)
    distinct: list[int] = []
    for index in np.flatnonzero(_bending(system, generations)):
        distance = np.abs(np.mod(places[index] - places[distinct] + 0.5, 1.0) - 0.5)
        if not np.any(distance < ROUNDING):
            distinct.append(int(index))
    kept = [index for index in distinct if index < sum(map(len, generations[: 1 + IMAGES]))]
    start = np.sort(places[kept])
    # How many starts lie within the longest delay before each, and one more for the piece that its end falls into.
    before = np.mod(start[:, None] - start, 1.0)
    reach = int(np.max(np.sum((before > 0) & (before < system.longest - ROUNDING), axis=1))) + 1
    reach = min(reach, len(kept)) if system.longest <= 1 else ceil(system.longest) * len(kept)
    return Places(tuple(kept), reach, len(kept) == len(distinct), _closed(system, reach), len(generations[0]))


def places_by_angle(system: DelaySystem, repeats: int) -> Places:
    """Of all places of a system that repeats in angle, whose delays are not above such a part of it, wherever they are.

    To be asked by processes whose jumps move.
    """
    every = sum(map(len, generations_of(system, IMAGES)))
    # As many in each part of the turning, and the piece that its end falls into.
    return Places(tuple(range(every)), every // repeats + 1, False)


def closed_by_angle(system: DelaySystem, repeats: int) -> Places | None:
    """The same with those that delays carry to one another, in the order that they have at the gain of ``system``; None
    where these are many.
    """
    places = places_by_angle(system, repeats)
    closed = _closed(system, places.reach)
    return None if closed is None else places._replace(closed=closed)


def _closed(system: DelaySystem, reach: int) -> Closed | None:
    """Places that delays carry to one another, unless more is remembered from node to node than in ``reach`` pieces
    between the nodes.
    """
    closed = closed_places(system, np.asarray(phases_of_jumps(system)))
    if closed is None or len(due_from_before(closed.links, sum(closed.parts))) > reach:
        return None
    return closed


def _bending(system: DelaySystem, generations: list[np.ndarray]) -> np.ndarray:
    """Whether a force acts at each place, and acted at the one of which it is the image, and so on; of all in turn."""
    bent = [np.ones(len(generations[0]), dtype=bool)]
    carriers = carriers_of(system)
    for images in generations[1:]:
        around = np.split(np.stack([images - ROUNDING, images + ROUNDING]), len(carriers), axis=1)
        acts = np.asarray(acting_at(system, np.stack([side.ravel() for side in around]), tuple(carriers)))
        acts = [part.reshape(2, -1).any(axis=0) for part in acts]
        bent.append(np.concatenate([part & bent[-1] for part in acts]))
    return np.concatenate(bent)
