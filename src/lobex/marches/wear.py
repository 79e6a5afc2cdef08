"""The wear march: what blades that rub their casing for some revolutions leave of it, at many speeds at once."""

import threading
from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Float
from tqdm import tqdm

from lobex import _checks
from lobex._batches import side_by_side
from lobex._compiled import compiled_for
from lobex._devices import workers
from lobex._float64 import at_once, widened
from lobex._memory import check_memory
from lobex._timing import timed
from lobex._warnings import SweepWarning, warn
from lobex.marches.arrangement import Arrangement
from lobex.marches.decimation import LENGTH, factor_for, filter_matrix
from lobex.marches.resolved_steps import check_resolution
from lobex.marches.rub_revolution import at_rest, revolve
from lobex.marches.tracks import Tracks
from lobex.marches.wear_results import Record, result_of
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import check_speed
from lobex.processes.regenerative import Rub
from lobex.results.blading_wear import BladingWear
from lobex.results.wear_map import WearMap

# Marched together on a CPU are so many modes of lanes and blades, which stay in a core's cache while the loop's cost
# is shared; and so many numbers seen in a revolution, beyond which the system takes its time to make room.
_MODES, _SEEN = 3840, 384 * 4096
_FEWEST_LANES = 32
_NAMED = 5

_turn = compiled_for("tracks", "factor")(revolve)
# Threads that meet a new program at once would each compile it.
_COMPILING = threading.Lock()


def march_wear(
    modes: Any,
    casing: Any,
    law: Any,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    incursion: float = 0.0,
    angles_degrees: Any = None,
    tracks: Any = None,
    watched: int = 0,
    progress: bool = False,
    plausible: bool = True,
) -> WearMap | BladingWear:
    """``lobex.march_wear`` without further axes and stores; arguments, errors and warnings as there.

    With ``plausible=False`` nothing is said of implausible numbers: a study looks at all of them itself.
    """
    turns = revolutions, steps_per_revolution, samples_per_revolution
    arranged, speeds = checked(modes, casing, law, speed, turns, angles_degrees, tracks, watched)
    (revolutions, steps, samples), lanes = map(int, turns), len(speeds)
    check_memory(
        f"{lanes} speeds, {revolutions} revolutions and {steps} steps",
        bytes_of_lane(arranged, revolutions, steps, samples) * lanes,
        "give fewer, or a store that takes the speeds in parts: store=, in the shell --store DIR",
    )
    if plausible:
        warn_of_implausible(Rub(arranged.blades.blade), speeds)
    history = np.ascontiguousarray(np.broadcast_to(speeds.reshape(lanes, -1), (lanes, revolutions)))
    closing = _closing(incursion, revolutions, float(arranged.casings[0].radius))
    factor = factor_for(steps, samples)
    with timed() as spent:
        with at_once():
            for structure in arranged.structures:
                structure.learn(history)
            profiles = arranged.profiles(steps)
            check_resolution(arranged, profiles, max(closing, 0.0) * revolutions, float(history.min()))
            places = arranged.tracks(steps)
        record = Record.empty(arranged, history, steps, factor)
        _march(arranged, places, profiles, closing, record, factor, progress)
    failed = record.lose(float(arranged.casings[0].radius))
    if failed.any():
        named = ", ".join(f"{s:.6g}" for s in history[failed, 0][:_NAMED])
        warn(
            f"{failed.sum()} of {len(failed)} lanes blew up and are NaN, at speed = {named}"
            f"{', …' if failed.sum() > _NAMED else ''} Hz; take more steps per revolution or a softer law",
            SweepWarning,
        )
    record.depth = places.in_place(record.depth)
    described = {"modes": modes, "casing": casing, "law": law}
    return result_of(record, arranged, profiles, places, factor, described, spent)


def checked(
    modes: Any,
    casing: Any,
    law: Any,
    speed: Any,
    turns: tuple[int, int, int],
    angles_degrees: Any = None,
    tracks: Any = None,
    watched: int = 0,
) -> tuple[Arrangement, Float[np.ndarray, "n ..."]]:
    """What meets in a march, and its speeds, Hz, (n,) or (n, revolutions), once they are what they should be; ``turns``
    are revolutions, and steps and samples of each.
    """
    least = {"revolutions": 1, "steps_per_revolution": 16, "samples_per_revolution": 16}
    revolutions, *_ = (_checks.integer(name, turn, least[name]) for name, turn in zip(least, turns, strict=True))
    _checks.untraced("a march", modes=modes, casing=casing, law=law, speed=speed)
    arranged = Arrangement.of(modes, casing, law, angles_degrees, tracks, watched)
    speed = speeds_of(speed, revolutions)
    check_speed(Rub(arranged.blades.blade), speed)
    speeds = np.asarray(speed, dtype=np.float64)
    if speeds.ndim not in (1, 2) or speeds.size == 0 or (speeds.ndim == 2 and speeds.shape[1] != revolutions):
        raise ValueError(f"speed has shape {speeds.shape}; give (n,) or (n, {revolutions}), one column per revolution")
    return arranged, speeds


def speeds_of(speed: Any, revolutions: int) -> Any:
    """The speeds of a march, Hz: what a function makes of the numbers 0, 1, … of all revolutions, one lane at least."""
    if not callable(speed):
        return speed
    given = np.asarray(speed(np.arange(float(revolutions))), dtype=float)
    if given.shape[-1:] != (revolutions,) or given.ndim > 2:
        raise ValueError(
            f"speed(number) has shape {given.shape} of {revolutions} revolutions; give one speed for each, "
            f"({revolutions},) or (n, {revolutions})"
        )
    return np.atleast_2d(given)


def bytes_of_lane(arranged: Arrangement, revolutions: int, steps: int, samples: int) -> int:
    """Memory that the results of one lane take."""
    contacts, seen = arranged.place.size, arranged.blades.blades * arranged.blades.blade.directions
    return 8 * (2 * steps * (max(arranged.track) + 1) + revolutions * (2 * samples * seen + 16 * contacts))


def _closing(incursion: Any, revolutions: int, radius: float) -> float:
    _checks.untraced("a march", incursion=incursion)
    _checks.as_numbers("incursion", incursion, "m per revolution")
    _checks.scalar("incursion", incursion)
    if abs(float(incursion)) * revolutions >= radius:
        raise ValueError(
            f"incursion = {float(incursion):.6g} m in each of {revolutions} revolutions is not below the casing's "
            f"radius = {radius:.6g} m; check the units"
        )
    return float(incursion)


def _march(
    arranged: Arrangement,
    places: Tracks,
    profiles: Float[np.ndarray, "tracks cells"],
    incursion: float,
    record: Record,
    factor: int,
    progress: bool,
) -> None:
    """March every block of lanes, side by side, into the record."""
    cells = places.cells
    matrix = filter_matrix(cells, factor) if factor > 1 else np.zeros((1, 1))
    lanes, revolutions = record.history.shape
    blocks = _blocks(lanes, arranged, cells)
    work = _Work(arranged, places, places.unworn(profiles), incursion, matrix, factor)
    with tqdm(total=len(blocks) * revolutions, unit="rev", disable=not progress, leave=False) as bar:
        part = partial(_march_block, work, record, bar.update)
        list(side_by_side(lambda number: part(blocks[number]), len(blocks), first_alone=False))


class _Work:
    """What all blocks of a march share."""

    def __init__(
        self,
        arranged: Arrangement,
        places: Tracks,
        unworn: Float[np.ndarray, "cells contacts blades"],
        incursion: float,
        matrix: Float[np.ndarray, "tile stretch"],
        factor: int,
    ) -> None:
        self.arranged, self.places, self.unworn = arranged, places, unworn
        self.incursion, self.matrix, self.factor = incursion, matrix, factor
        self.law = widened(arranged.law)

    def closing(self, turn: int) -> Float[np.ndarray, " ends"] | None:
        """By how much the casing has come closer at the instants of a revolution, m."""
        cells = self.places.cells
        return None if self.incursion == 0 else self.incursion * (turn + np.arange(cells + 1) / cells)


def _march_block(work: _Work, record: Record, done: Callable[[], Any], block: np.ndarray) -> None:
    arranged, places = work.arranged, work.places
    speeds = record.history[block]
    bodies, state = None, None
    for turn in range(speeds.shape[1]):
        if bodies is None or np.any(speeds[:, turn] != speeds[:, turn - 1]):
            bodies = tuple(structure.body(speeds[:, turn]) for structure in arranged.structures)
        if state is None:
            tail = LENGTH * work.factor if work.factor > 1 else 0
            state = at_rest(bodies, arranged.blades.blades, places, len(block), tail)
        with _COMPILING if turn == 0 else nullcontext():
            state, result = _turn(
                bodies,
                work.law,
                work.unworn,
                work.closing(turn),
                speeds[:, turn],
                state,
                work.matrix,
                tracks=places,
                factor=work.factor,
            )
        record.put(block, turn, result)
        done()
    assert state is not None
    depth = np.asarray(state.depth).reshape(places.cells, places.number, len(block))
    record.depth[block] = np.moveaxis(depth, -1, 0).swapaxes(1, 2)


def _blocks(lanes: int, arranged: Arrangement, cells: int) -> list[np.ndarray]:
    """Lane numbers of equal blocks; the last reaches back over lanes of the one before, so that one shape serves."""
    cpu = jax.default_backend() == "cpu"
    side = workers() if cpu else len(jax.local_devices())
    blade, blades = arranged.blades.blade, arranged.blades.blades
    most = max(min(_MODES // blade.count, _SEEN // (cells * blade.directions)) // blades, 1)
    count = max(min(side, max(lanes * blades // _FEWEST_LANES, 1), lanes), -(-lanes // most) if cpu else 1, 1)
    # As many for each worker, where all have some.
    count = min(-(-count // side) * side, lanes) if count > side else count
    size = -(-lanes // count)
    return [np.arange(size) + min(start, lanes - size) for start in range(0, lanes, size)]
