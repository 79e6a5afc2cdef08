"""The march of a delayed process in time: the proof, by integration, of what a multiplier says."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._compiled import compiled, compiled_for
from lobex._float64 import at_once, widened
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex._timing import timed
from lobex.marches.growth_fit import MOST_PERIODS, fit_growth
from lobex.marches.linear import Marched, march_system, steps_ahead, steps_back
from lobex.marches.march_lanes import check_length, check_steps, lanes_of, steps_needed, warn_of_lost_lanes
from lobex.marches.start import History, sample_history, starting_state
from lobex.processes.process import Process, check_process
from lobex.processes.quantity import quantity_of
from lobex.results.description import describe
from lobex.results.march import March
from lobex.systems.system import DelaySystem

# Of a forced motion, changes below this share hold rounding.
_SETTLED = 1e-10
# Of a period, at which the stiffness of a contact that varies is looked at.
_PHASES = 64


def march_delay(
    process: Process,
    speed: ArrayLike,
    gain: ArrayLike,
    history: History,
    periods: int,
    steps_per_period: int,
    *,
    state: ArrayLike | None = None,
    every: int = 1,
) -> March:
    """March a delayed process in time, from its motion during the longest delay, and fit how it grows per period.

    A forced one comes to its ``orbit`` where it is stable; what is fitted then is how the motion about that grows.

    Steps are T/``steps_per_period``, so that Δt differs from speed to speed; what delays bring from between steps is on
    a straight line. Free vibration is integrated exactly and the force by a trapezoidal rule with the exact means of
    periodic coefficients: second order in the step, over the jumps of milling, too, and stable however stiff the
    modes. All lanes advance side by side. The growth is fitted to the last periods (at most 8, at most half of
    them); ``March.growth_error`` tells how far the fit had converged, and knows nothing of the error of
    the steps, which falls as their number squared.

    Args:
        process: a process, such as ``Rub(modes)``.
        speed: speeds, Hz (revolutions per second), any shape.
        gain: gains, broadcast against ``speed``; the broadcast shape is that of the lanes.
        history: what is remembered of the longest delay before t = 0 (y, where the process says nothing else), as a
            function of time: it is called once, with an array of times in s, of shape (*lanes, steps + 1) for the steps
            that the delay reaches back, steps_per_period of them where it is the period, and returns m of the same
            shape, or with the outputs as one more axis; a constant will do. For §4.4 see ``growing_history``.
        periods: how many to march: revolutions of a blade, tooth passes of a cutter.
        steps_per_period: steps per period, of which the shortest delay takes one at least.
        state: z(0), (d,) or (*lanes, d); for vibration modes (u, u̇/ω) mode by mode, for ``DelayedMathieu``
            (x, ẋ). By default the structure is at rest and bent by a force at the contact to where the
            history ends.
        every: keep every n-th step of the displacement, to save memory; a divisor of ``steps_per_period``.

    Returns:
        A ``March`` of float64 NumPy arrays.

    Raises:
        ValueError: for a history or state that has a wrong shape or is not finite, sizes that are not whole
            numbers, delays shorter than a step, and fewer than 8 steps per wave of the first mode or of any vibration
            that the contact can feed at its gain, naming the speed and the steps it needs.

    Warns:
        SweepWarning: when lanes grow beyond floating point; they are NaN from there on.
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.

    Source: §4.4 of the thesis, with the exponential steps of Hochbruck and Ostermann, Exponential integrators,
        Acta Numerica 19 (2010).
    """
    check_process(process)
    periods = _checks.integer("periods", periods, 1)
    steps = _checks.integer("steps_per_period", steps_per_period, 3)
    every = _checks.integer("every", every, 1)
    if steps % every:
        raise ValueError(f"every = {every} does not divide steps_per_period = {steps}; give a divisor")
    _checks.untraced("a march", process=process, speed=speed, gain=gain)
    speeds, gains = lanes_of(process, speed, gain)
    with timed() as spent, at_once():
        process = widened(process)
        system = jax.tree.map(np.asarray, _systems(process, speeds.ravel(), gains.ravel()))
        outputs, remembered = np.shape(system.outputs)[-2], np.shape(system.recalled)[-2]
        _check_delays(system, steps)
        check_steps("steps_per_period", system, np.asarray(_stiffness(system)), speeds.ravel(), steps)
        check_length(speeds.size, periods, steps, outputs / every)
        period = np.broadcast_to(system.period, speeds.size).reshape(speeds.shape)
        back = steps_back(system, steps)
        past = sample_history(history, period * (back / steps), back, remembered)
        past = past.reshape(speeds.size, back + 1, remembered)
        first = starting_state(system, state, past[:, -1])
        motion = jax.tree.map(
            np.asarray, _march(process, speeds.ravel(), gains.ravel(), past, first, steps, periods, every)
        )
    lanes = speeds.shape
    # A lane may go beyond floating point within the very periods that are fitted.
    with np.errstate(over="ignore", invalid="ignore"):
        growth = fit_growth(_free_states(motion, system, min(MOST_PERIODS, periods // 2)))
    start = np.einsum("lnrs,lns->lr", system.outputs, first.reshape(*np.shape(system.outputs)[:2], -1))
    displacement = np.concatenate([start[:, None], motion.output.reshape(speeds.size, -1, outputs)], axis=1)
    displacement, final = (np.where(np.isfinite(part), part, np.nan) for part in (displacement, motion.states[:, -1]))
    warn_of_lost_lanes(np.isnan(final).any(axis=1), process.gain, speeds, gains)
    return March(
        speed=speeds,
        gain=gains,
        delay=period,
        phase=np.arange(displacement.shape[1]) * (every / steps),
        displacement=displacement.reshape(*lanes, -1, outputs),
        state=final.reshape(*lanes, -1),
        multiplier=growth.multiplier.reshape(lanes),
        growth_error=growth.error.reshape(lanes),
        steps_per_period=steps,
        quantity=quantity_of(process),
        speed_unit=process.speed_unit,
        process=describe(process),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def fewest_steps(process: Process, speed: float, gain: float) -> int:
    """The fewest steps per period with which ``march_delay`` marches at a point."""
    speeds, gains = lanes_of(process, [speed], [gain])
    with at_once():
        system = jax.tree.map(np.asarray, _systems(widened(process), speeds, gains))
        needed = steps_needed(system, np.asarray(_stiffness(system)))[0]
    delay = np.ceil(1 / system.shortest) if system.shortest else 1
    return int(max(needed[0], delay, 3))


def _check_delays(system: DelaySystem, steps: int) -> None:
    """Require a shortest delay of a step at least."""
    if not system.shortest:
        raise ValueError("march_delay takes systems that say how short a delay may be; give a delay_range above zero")
    if not steps_ahead(system, steps):
        raise ValueError(
            f"steps_per_period = {steps} is too few for a delay of {system.shortest:.6g} periods, which is a step at "
            f"least; give {np.ceil(1 / system.shortest):.0f} or more"
        )


def _free_states(motion: Marched, system: DelaySystem, count: int) -> np.ndarray:
    """``_delay_states``; of a forced motion how they change from period to period, in which the orbit drops out."""
    if not system.forcing:
        return _delay_states(motion, system, count)
    states = _delay_states(motion, system, min(count + 1, np.shape(motion.states)[1] - 1))
    change = np.diff(states, axis=1)
    size, left = (np.linalg.norm(part, axis=2, keepdims=True) for part in (states[:, 1:], change))
    return np.where(left > _SETTLED * size, change, 0.0)


def _delay_states(motion: Marched, system: DelaySystem, count: int) -> np.ndarray:
    """The last ``count`` + 1 states, of z and of y in the period before, (lanes, count + 1, size), in comparable units.

    Where delays are longer, the fit sees a part of the motion alone, which grows as the whole does.
    """
    lanes = len(motion.states)
    history = motion.output[:, -count - 1 :].reshape(lanes, count + 1, -1)
    scale = np.linalg.norm(np.reshape(system.outputs, (lanes, -1)), axis=-1)[:, None, None]
    return np.concatenate([scale * motion.states[:, -count - 1 :], history / np.sqrt(history.shape[-1])], axis=-1)


@compiled
@jax.vmap
def _stiffness(system: DelaySystem) -> Float[Array, ""]:
    """The largest contact force per displacement in a period, now and a delay ago together."""
    forces = system.at(jnp.arange(1 if system.constant else _PHASES) / _PHASES)
    return jnp.max(sum(jnp.linalg.norm(part, axis=(1, 2)) for part in (forces.present, *forces.delayed)))


@compiled
def _systems(process: Process, speed: Float[AnyArray, " lanes"], gain: Float[AnyArray, " lanes"]) -> DelaySystem:
    return jax.vmap(process.system)(speed, gain)


@compiled_for("steps", "periods", "every")
def _march(
    process: Process,
    speed: Float[AnyArray, " lanes"],
    gain: Float[AnyArray, " lanes"],
    past: Float[AnyArray, "lanes back m"],
    state: Float[AnyArray, "lanes d"],
    steps: int,
    periods: int,
    every: int,
) -> Marched:
    def lane(speed: Number, gain: Number, past: Float[AnyArray, "back m"], state: Float[AnyArray, " d"]) -> Marched:
        return march_system(process.system(speed, gain), past, state, steps, periods, every)

    return jax.vmap(lane)(speed, gain, past, state)
