"""Where a march starts from: the motion during the delay before it, and the state at its end."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex import _checks
from lobex._float64 import in_float64
from lobex._shapes import ArrayLike
from lobex.structures.eigenproblem import vibration_modes
from lobex.structures.rod import Rod
from lobex.systems.system import DelaySystem

History = Callable[[np.ndarray], Any]

# (4.3) multiplies by 1.0005 at every step of 1e-6 s.
_THESIS_RATE = math.log(1.0005) / 1e-6
# Beyond that no number holds what grows.
_MOST_GROWTH = 600.0


def growing_history(
    rod: Rod, speed: ArrayLike, *, tip: float = 1e-7, rate: float = _THESIS_RATE, keep: Sequence[int] | None = None
) -> tuple[History, np.ndarray]:
    """§4.4's start of a march of the rod, (4.3): all nodes grow together, q(t) = q₀ exp(rate · (t + τ)), for one delay.

    q₀ rises in proportion to the distance from the clamp. The thesis multiplies by 1.0005 at each step of 1e-6 s; the
    exponential says the same for every step size.

    Args:
        rod: the blade.
        speed: the speeds of the march, Hz, any shape.
        tip: displacement of the tip at t = −τ, m.
        rate: growth rate, 1/s; ln(1.0005)/1e-6 = 499.9 in the thesis.
        keep: the mode numbers that the march's modes keep, from 1; all by default.

    Returns:
        The history of the tip's displacement and the state at t = 0, for ``march_delay``'s ``history`` and ``state``.

    Raises:
        ValueError: for what is no rod, speeds that are not above zero, numbers that are not finite, and a growth in a
            revolution that no number holds.
    """
    if not isinstance(rod, Rod):
        raise ValueError(f"rod = {_checks.brief(rod)} is no rod; give lobex.Rod()")
    _checks.untraced("a march", rod=rod, speed=speed, tip=tip, rate=rate)
    _checks.positive("speed", speed, "Hz")
    for name, value in (("tip", tip), ("rate", rate)):
        _checks.scalar(name, value)
        _checks.as_numbers(name, value)
    angular_frequency, displacement, shape = _nodes_in_modes(rod, keep)
    delay = 1 / np.asarray(speed, dtype=float)[..., None]
    if np.max(rate * delay) > _MOST_GROWTH:
        raise ValueError(
            f"speed = {1 / np.max(delay):.6g} Hz leaves rate = {rate:.6g}/s to grow by more than e^{_MOST_GROWTH:g} in "
            "a revolution; give a higher speed, or a lower rate"
        )
    contact = float(displacement @ shape) * tip

    def history(time: np.ndarray) -> np.ndarray:
        return contact * np.exp(rate * (time + delay))

    modal = tip * displacement * np.exp(rate * delay)
    # The state of a mode is (u, u̇/ω).
    state = np.stack([modal, rate * modal / angular_frequency], axis=-1)
    return history, state.reshape(*delay.shape[:-1], -1)


@in_float64
def _nodes_in_modes(
    rod: Rod, keep: Sequence[int] | None
) -> tuple[Float[Array, " n"], Float[Array, " n"], Float[Array, " n"]]:
    """ω, the modal coordinates of a shape that rises linearly to 1 m at the tip, and the modes there, each (n,)."""
    mass, stiffness, _ = rod.matrices()
    angular_frequency, vectors = vibration_modes(mass, stiffness, keep)
    nodes = jnp.arange(1, rod.elements + 1) / rod.elements
    return jnp.asarray(angular_frequency), jnp.asarray(vectors).T @ mass @ nodes, jnp.asarray(vectors[-1])


def sample_history(history: Any, delay: Float[Any, "*lanes"], steps: int, outputs: int) -> np.ndarray:
    """w over [−τ, 0] of every lane in so many steps, (*lanes, steps + 1, m), from a function of time."""
    if not callable(history):
        raise ValueError(
            f"history = {_checks.brief(history)} is no function; give the displacement as a function of time (s) "
            "over the delay before t = 0, such as lambda t: 1e-6 * np.cos(500 * t)"
        )
    time = delay[..., None] * (np.arange(steps + 1) / steps - 1)
    given: Any = history(time)
    values = _checks.as_numbers("history(t)", given, "m")
    if values is None:
        raise ValueError("history(t) is traced by JAX; a march runs outside jit, grad and vmap: give plain numbers")
    shape = (*time.shape, outputs)
    if outputs == 1 and values.shape != shape:
        values = values[..., None]
    try:
        return np.array(np.broadcast_to(values, shape))
    except ValueError:
        wanted = f"{time.shape} or {shape}" if outputs == 1 else f"{shape}"
        raise ValueError(f"history(t) has shape {np.shape(given)}; give {wanted}, one value per time") from None


def starting_state(system: DelaySystem, state: Any, end: np.ndarray) -> np.ndarray:
    """z(0) of every lane, (lanes, d): as given, or held at rest by a force at the contact, where the history ends."""
    lanes, outputs = end.shape
    size = int(np.prod(np.shape(system.blocks)[1:3]))
    if state is not None:
        values = _checks.as_numbers("state", state)
        if values is None:
            raise ValueError("state is traced by JAX; a march runs outside jit, grad and vmap: give plain numbers")
        values = values.reshape(-1, values.shape[-1]) if values.ndim > 1 else values
        try:
            # A single number would be taken for all of them.
            if values.shape[-1:] != (size,):
                raise ValueError
            return np.array(np.broadcast_to(values, (lanes, size)))
        except ValueError:
            raise ValueError(
                f"state has shape {np.shape(state)}; give the {size} numbers of z at t = 0, or one row per lane"
            ) from None
    blocks, inputs, contact = (np.asarray(a) for a in (system.blocks, system.inputs, system.recalled))
    try:
        if size == outputs:
            return np.linalg.solve(np.swapaxes(contact, 1, 2).reshape(lanes, outputs, size), end[..., None])[..., 0]
        bent = -np.linalg.solve(blocks, inputs)
        compliance = np.einsum("lnas,lnsb->lab", contact, bent)
        force = np.linalg.solve(compliance, end[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise ValueError("state = None, but without stiffness no force holds the structure; give z at t = 0") from None
    return np.einsum("lnsr,lr->lns", bent, force).reshape(lanes, size)
