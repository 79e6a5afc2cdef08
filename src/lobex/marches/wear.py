"""The wear march: what a blade that rubs its casing for some revolutions leaves of it, at many speeds at once."""

import threading
from contextlib import nullcontext
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float
from tqdm import tqdm

from lobex import _checks
from lobex._batches import side_by_side
from lobex._devices import workers
from lobex._float64 import at_once, widened
from lobex._memory import check_memory
from lobex._shapes import AnyArray
from lobex._timing import timed
from lobex._warnings import SweepWarning, warn
from lobex.contact.casing import Casing, check_casing
from lobex.contact.laws import ContactLaw, check_law
from lobex.marches.central_difference import highest_frequency
from lobex.marches.decimation import LENGTH, factor_for, filter_matrix, lag_of, usable_orders
from lobex.marches.fed_vibrations import check_cells
from lobex.marches.march_lanes import check_steps
from lobex.marches.rub_revolution import Totals, at_rest, revolve
from lobex.processes.plausible import warn_of_implausible
from lobex.processes.process import check_speed
from lobex.processes.regenerative import Rub
from lobex.results.description import describe
from lobex.results.wear_map import WearMap
from lobex.structures.modes import Modes, check_modes

# Lanes marched together on a CPU: their modes stay in a core's cache, and the loop's overhead is shared.
_LANES = 384
_FEWEST_LANES = 32
_NAMED = 5

_PER_REVOLUTION = (*Totals._fields, "stored_energy")

_turn = jax.jit(revolve, static_argnames="factor")
# Threads that meet a new program at once would each compile it.
_COMPILING = threading.Lock()


def march_wear(
    modes: Modes,
    casing: Casing,
    law: ContactLaw,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    progress: bool = False,
    plausible: bool = True,
) -> WearMap:
    """``lobex.march_wear`` without further axes and stores; arguments, errors and warnings as there.

    With ``plausible=False`` nothing is said of implausible numbers: a study looks at all of them itself.
    """
    revolutions = _checks.integer("revolutions", revolutions, 1)
    steps = _checks.integer("steps_per_revolution", steps_per_revolution, 16)
    samples = _checks.integer("samples_per_revolution", samples_per_revolution, 16)
    lanes = (np.shape(speed) or (1,))[0]
    check_memory(
        f"{lanes} speeds, {revolutions} revolutions and {steps} steps",
        8 * lanes * (2 * steps + revolutions * (2 * samples + 16)),
        "give fewer, or a store that takes the speeds in parts: store=, in the shell --store DIR",
    )
    history = _checked_speeds(modes, casing, law, speed, revolutions, plausible)
    factor = factor_for(steps, samples)
    with timed() as spent:
        with at_once():
            modes, law, casing = widened((modes, law, casing))
            profile = np.asarray(casing.profile(steps))
            _check_steps(modes, casing, law, profile, float(history.min()), steps)
        parts = _march(modes, law, profile, history, factor, progress)
    failed = _failed(parts, float(casing.radius))
    if failed.any():
        named = ", ".join(f"{s:.6g}" for s in history[failed, 0][:_NAMED])
        warn(
            f"{failed.sum()} of {len(failed)} lanes blew up and are NaN, at speed = {named}"
            f"{', …' if failed.sum() > _NAMED else ''} Hz; take more steps per revolution or a softer law",
            SweepWarning,
        )
        for values in parts.values():
            values[failed] = np.nan
    wear = parts.pop("removed") * 2 * np.pi * float(casing.radius) / steps
    return WearMap(
        speed=history[:, 0].copy(),
        speed_history=history,
        angle=2 * np.pi * np.arange(steps) / steps,
        unworn=profile,
        wear=wear,
        samples_per_revolution=steps // factor,
        lag=lag_of(factor),
        usable_orders=usable_orders(steps, factor),
        natural_frequency=np.asarray(modes.frequency),
        nodal_diameters=casing.nodal_diameters,
        radius=float(casing.radius),
        axial_width=float(casing.axial_width),
        model={"modes": describe(modes), "casing": describe(casing), "law": describe(law)},
        seconds=spent.seconds,
        compiling=spent.compiling,
        failed=int(failed.sum()),
        **parts,
    )


def _checked_speeds(modes: Any, casing: Any, law: Any, speed: Any, revolutions: int, plausible: bool) -> np.ndarray:
    """The speed of every lane in every revolution, (n, revolutions), once all arguments are what they should be."""
    check_modes(modes, in_phase=True)
    check_casing(casing)
    check_law(law)
    if modes.directions != 1:
        raise ValueError(f"modes have {modes.directions} contact directions; give modes with one")
    _checks.untraced("a march", modes=modes, casing=casing, law=law, speed=speed)
    check_speed(Rub(modes), speed)
    if plausible:
        warn_of_implausible(Rub(modes), speed)
    speeds = np.asarray(speed, dtype=np.float64)
    if speeds.ndim not in (1, 2) or speeds.size == 0 or (speeds.ndim == 2 and speeds.shape[1] != revolutions):
        raise ValueError(f"speed has shape {speeds.shape}; give (n,) or (n, {revolutions}), one column per revolution")
    return np.ascontiguousarray(np.broadcast_to(speeds.reshape(len(speeds), -1), (len(speeds), revolutions)))


def _check_steps(
    modes: Modes, casing: Casing, law: ContactLaw, profile: np.ndarray, slowest: float, steps: int
) -> None:
    """Require steps that resolve the bumps and, at the lowest speed and against the stiffest contact that the casing
    leads to, what the contact feeds, and with which central differences are stable."""
    if casing.surface is None:
        check_cells("steps_per_revolution", steps, casing.nodal_diameters, float(casing.bump_width))
    deepest = max(float(-profile.min()), float(np.ptp(profile)))
    stiffness = 0.0
    if deepest > 0:
        stiffness = float(np.asarray(_slopes(law, np.linspace(0, deepest, 65)[1:])).max())
    highest = highest_frequency(modes, stiffness)
    needed = int(highest / (2 * slowest)) + 1
    if steps < needed:
        raise ValueError(
            f"steps_per_revolution = {steps} is too few at speed = {slowest:.6g} Hz, where central differences are "
            f"stable from {needed} on (highest frequency {highest / (2 * np.pi):.6g} Hz, in contact)"
        )
    speed = np.array([slowest])
    system = jax.tree.map(lambda leaf: np.asarray(leaf)[None], Rub(modes).system(slowest, stiffness))
    check_steps("steps_per_revolution", system, np.array([stiffness]), speed, steps)


@jax.jit
def _slopes(law: ContactLaw, penetration: Float[AnyArray, " depths"]) -> Float[AnyArray, " depths"]:
    return jax.vmap(jax.grad(lambda h: law.force(h, jnp.zeros(()))))(penetration)


def _march(
    modes: Modes, law: ContactLaw, profile: np.ndarray, history: np.ndarray, factor: int, progress: bool
) -> dict[str, np.ndarray]:
    """March every block of lanes, side by side; results with lanes first."""
    (lanes, revolutions), cells = history.shape, len(profile)
    parts = {name: np.empty((lanes, revolutions)) for name in _PER_REVOLUTION}
    parts["depth"] = np.empty((lanes, cells))
    parts["displacement"] = np.empty((lanes, revolutions * (cells // factor)))
    matrix = filter_matrix(cells, factor) if factor > 1 else np.zeros((1, 1))
    blocks = _blocks(lanes)
    total = len(blocks) * revolutions
    with tqdm(total=total, unit="rev", disable=not progress, leave=False) as bar:
        work = partial(_march_block, modes, law, profile, history, factor, matrix, parts, bar.update)
        list(side_by_side(lambda number: work(blocks[number]), len(blocks), first_alone=False))
    return parts


def _march_block(
    modes: Modes,
    law: ContactLaw,
    profile: np.ndarray,
    history: np.ndarray,
    factor: int,
    matrix: np.ndarray,
    parts: dict[str, np.ndarray],
    done: Any,
    block: np.ndarray,
) -> None:
    samples = len(profile) // factor
    blade = at_rest(modes, len(profile), len(block), LENGTH * factor if factor > 1 else 0)
    for turn in range(history.shape[1]):
        with _COMPILING if turn == 0 else nullcontext():
            blade, result = _turn(modes, law, profile, history[block, turn], blade, matrix, factor=factor)
        for name, values in zip(_PER_REVOLUTION, (*result.totals, result.stored_energy), strict=True):
            parts[name][block, turn] = np.asarray(values)
        parts["displacement"][block, turn * samples : (turn + 1) * samples] = np.asarray(result.tip).T
        done()
    parts["depth"][block] = np.asarray(blade.depth).T


def _blocks(lanes: int) -> list[np.ndarray]:
    """Lane numbers of equal blocks; the last reaches back over lanes of the one before, so that one shape serves."""
    cpu = jax.default_backend() == "cpu"
    side = workers() if cpu else len(jax.local_devices())
    count = max(min(side, lanes // _FEWEST_LANES), -(-lanes // _LANES) if cpu else 1, 1)
    size = -(-lanes // count)
    return [np.arange(size) + min(start, lanes - size) for start in range(0, lanes, size)]


def _failed(parts: dict[str, np.ndarray], radius: float) -> np.ndarray:
    """Lanes that are not finite, or whose tip has left the casing by more than its radius."""
    totals = np.sum([parts[name].sum(axis=1) for name in _PER_REVOLUTION], axis=0)
    return ~np.isfinite(totals) | ~(parts["amplitude"].max(axis=1) < radius)
