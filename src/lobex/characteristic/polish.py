"""The dominant root at every gain of a row, from the leading paths of its interval."""

from typing import Any, cast

import jax
import jax.numpy as jnp

from lobex.characteristic.function import Contact, loop, newton_step

Array = Any

_LAST_STEPS = 2
_NEAR = 1e-3
# A root this far from where its path was expected is another path's.
_FAR = 0.1
_CONVERGED = 1e-9
# Paths this close behind the foremost must have converged as well, and to other roots.
_RIVAL = 0.05
_SAME = 1e-7


@jax.jit
def dominant(
    contact: Contact, ends: Array, rest: Array, closed: Array, first: Array, step: Array, gain: Array, steps: Array
) -> tuple[Array, Array, Array]:
    """The dominant root z, (b, m), how far the last step went, and whether its rivals are all accounted for.

    Args:
        contact: of lanes (b,).
        ends: of the leading paths at the intervals' ends, (b, nodes, leaders, 4).
        rest: Re z that other paths do not pass, (b, nodes).
        closed: whether all roots beyond the line are at hand, (b, nodes).
        first: gain of the first node, (b,).
        step: of log K from node to node, (b,).
        gain: gains above 0, (m,).
        steps: Newton's on every leading path; the foremost gets two more.
    """
    along = jnp.log(gain / first[:, None]) / step[:, None]
    interval = jnp.clip(jnp.floor(along).astype(int) + 1, 0, jnp.shape(rest)[1] - 1)
    share = jnp.where(interval == 0, gain / first[:, None], along - (interval - 1))
    row = jnp.arange(jnp.shape(rest)[0])[:, None]
    start, start_slope, stop, stop_slope = ends[row, interval].transpose(3, 0, 2, 1)
    lanes = jax.tree.map(lambda a: a[..., None, None], contact)
    share, gain = share[:, None], gain
    cubic = start + share * (
        start_slope
        + share * (3 * (stop - start) - 2 * start_slope - stop_slope)
        + share**2 * (start_slope + stop_slope - 2 * (stop - start))
    )
    ahead, back = start + share * start_slope, stop - (1 - share) * stop_slope
    guess = jnp.where(jnp.isnan(start), back, jnp.where(jnp.isnan(stop), ahead, cubic))
    root, change = _improve(lanes, guess, gain, steps)
    good = (jnp.abs(change) < _NEAR) & (jnp.abs(root - guess) < _FAR)
    reached = cast(Array, jnp.where(good, root.real, -jnp.inf))
    foremost = jnp.argmax(reached, axis=1, keepdims=True)
    best = jnp.take_along_axis(root, foremost, axis=1)
    others = jnp.arange(jnp.shape(root)[1])[:, None] != foremost
    doubtful = ~good | (jnp.abs(root - best) < _SAME)
    rival = others & doubtful & (guess.real > best.real - _RIVAL)
    clear = ~jnp.any(rival, axis=1) & (best[:, 0].real > rest[row, interval]) & closed[row, interval]
    best, change = _improve(lanes, best, gain, _LAST_STEPS)
    return best[:, 0], jnp.abs(change[:, 0]), clear


def _improve(contact: Contact, z: Array, gain: Array, steps: Array) -> tuple[Array, Array]:
    def improve(_: int, state: tuple[Array, Array]) -> tuple[Array, Array]:
        change = newton_step(loop(contact, state[0]), gain)
        return state[0] + change, change

    z, change = jax.lax.fori_loop(0, steps, improve, (z, jnp.zeros_like(z)))
    return cast(Array, jnp.where(z.imag < 0, z.conj(), z)), change
