"""Turning in time, with loss of contact and the surface that all earlier passes left."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._compiled import compiled, compiled_for
from lobex._float64 import at_once, widened
from lobex._shapes import AnyArray, ArrayLike, Number
from lobex._timing import timed
from lobex._warnings import warn
from lobex.contact.laws import ContactLaw, Plastic, check_law
from lobex.marches.cutting import Pass, march_cut
from lobex.marches.march_lanes import check_length, check_steps, lanes_of, warn_of_lost_lanes
from lobex.marches.start import History, sample_history, starting_state
from lobex.processes.plausible import too_long
from lobex.processes.quantity import DEPTH_OF_CUT
from lobex.processes.regenerative import Turning
from lobex.results.cut import Cut
from lobex.results.description import describe
from lobex.structures.modes import Modes, check_modes
from lobex.systems.system import DelaySystem

# A radial force in the place of the law's, N/m².
_NOT_USED = 1e9


def simulate_turning(
    modes: Modes,
    law: ContactLaw,
    speed: ArrayLike,
    depth: ArrayLike,
    feed: float,
    revolutions: int,
    steps_per_revolution: int,
    *,
    history: History | None = None,
    state: ArrayLike | None = None,
    every: int = 1,
) -> Cut:
    """Simulate turning with a flexible tool, (2.8)-(2.12), where the tool may leave the cut.

    The cutting force is F = b · law(h). The chip thickness h reaches from the tool to the lowest surface that any
    earlier pass left there, so that what the tool jumps over is met again revolutions later; without loss of
    contact that is h₀ + q(t − τ) − q(t) of (2.12). q is positive away from the workpiece. Second order in the
    step for laws without a jump, with the same exact free vibration as ``march_delay``.

    Args:
        modes: the tool's modes in the direction of the chip thickness, one contact direction.
        law: the radial force per depth of cut, with force(h): ``Linear(K_r)`` (2.2), or ``Cubic`` (2.4),
            ``Threshold`` (2.5) or ``Power`` (2.6) of width 1, their coefficients times K_r/K_t (2.3).
        speed: spindle speeds, Hz (revolutions per second), any shape.
        depth: depths of cut b, m, broadcast against ``speed``; the broadcast shape is that of the lanes.
        feed: feed per revolution h₀, m.
        revolutions: how many revolutions to march.
        steps_per_revolution: equal steps per revolution.
        history: displacement of the tool during the revolution before t = 0, as for ``march_delay``. By
            default the tool was not deflected: it starts with the whole feed to cut.
        state: the tool at t = 0, (u, u̇/ω) mode by mode, (d,) or (*lanes, d). By default at rest where the history ends.
        every: keep every n-th step, to save memory; a divisor of ``steps_per_revolution``.

    Returns:
        A ``Cut`` of float64 NumPy arrays.

    Raises:
        ValueError: for a law of another width or an elastic-plastic coating, a feed that is not positive, and as
            ``march_delay``.

    Warns:
        SweepWarning: when lanes grow beyond floating point; they are NaN from there on.
        LobexWarning: as ``march_delay``.
    """
    check_modes(modes)
    if modes.directions != 1:
        raise ValueError(
            f"modes has {modes.directions} contact directions; turning takes 1, that of the chip thickness"
        )
    _checks.untraced("a march", modes=modes, law=law, speed=speed, depth=depth, feed=feed)
    _check_cutting(law)
    _checks.not_negative("depth", depth, "m")
    _checks.positive("feed", feed, "m")
    _checks.scalar("feed", feed)
    if message := too_long("feed", feed):
        warn(message)
    revolutions = _checks.integer("revolutions", revolutions, 1)
    steps = _checks.integer("steps_per_revolution", steps_per_revolution, 3)
    every = _checks.integer("every", every, 1)
    if steps % every:
        raise ValueError(f"every = {every} does not divide steps_per_revolution = {steps}; give a divisor")
    tool = Turning(modes, _NOT_USED)
    speeds, depths = lanes_of(tool, speed, depth, name="depth")
    with timed() as spent, at_once():
        tool, law, feed = widened((tool, law, feed))
        system = jax.tree.map(np.asarray, _structures(tool, speeds.ravel()))
        slope = float(jax.grad(law.force)(jnp.asarray(feed)))
        check_steps("steps_per_revolution", system, 2 * depths.ravel() * abs(slope), speeds.ravel(), steps)
        check_length(speeds.size, revolutions, steps, 3 / every)
        delay = 1 / speeds
        past = sample_history(history or np.zeros_like, delay, steps, 1).reshape(speeds.size, steps + 1, 1)
        first = starting_state(system, state, past[:, -1])
        samples, final = jax.tree.map(
            np.asarray, _march(system, law, depths.ravel(), feed, past, first, revolutions, every)
        )
    samples, final = jax.tree.map(lambda part: np.where(np.isfinite(part), part, np.nan), (samples, final))
    warn_of_lost_lanes(np.isnan(final).any(axis=1), DEPTH_OF_CUT, speeds, depths)
    lanes = speeds.shape
    return Cut(
        speed=speeds,
        depth=depths,
        feed=float(feed),
        phase=np.arange(samples.displacement.shape[1]) * (every / steps),
        displacement=samples.displacement.reshape(*lanes, -1),
        chip_thickness=samples.chip_thickness.reshape(*lanes, -1),
        force=samples.force.reshape(*lanes, -1),
        state=final.reshape(*lanes, -1),
        steps_per_revolution=steps,
        modes=describe(tool.modes),
        law=describe(law),
        seconds=spent.seconds,
        compiling=spent.compiling,
    )


def _check_cutting(law: Any) -> None:
    check_law(law, by_rate=False)
    if isinstance(law, Plastic):
        raise ValueError("law = Plastic is a coating, which does not part into chips; give a cutting law")
    width = getattr(law, "width", 1.0)
    if float(width) != 1.0:
        raise ValueError(f"law.width = {float(width):.6g} would count twice beside depth; give a law of width 1.0")


@compiled
def _structures(tool: Turning, speed: Float[AnyArray, " lanes"]) -> DelaySystem:
    return jax.vmap(lambda s: tool.system(s, jnp.zeros_like(s)))(speed)


@compiled_for("revolutions", "every")
def _march(
    system: DelaySystem,
    law: ContactLaw,
    depth: Float[AnyArray, " lanes"],
    feed: Number,
    past: Float[AnyArray, "lanes edges 1"],
    state: Float[AnyArray, "lanes d"],
    revolutions: int,
    every: int,
) -> tuple[Pass, Float[Array, "lanes d"]]:
    def lane(
        system: DelaySystem, depth: Number, past: Float[AnyArray, "edges 1"], state: Float[AnyArray, " d"]
    ) -> tuple[Pass, Float[Array, " d"]]:
        return march_cut(system, law, depth, feed, past, state, revolutions, every)

    return jax.vmap(lane)(system, depth, past, state)
