"""Constant forces that act in one direction of the state, taken together as one."""

from typing import NamedTuple

from jaxtyping import Bool, Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.systems.system import DelaySystem, dense_outputs

# Of a product of two rounded numbers, and more.
_ROUNDING = 1e-12


class OneForce(NamedTuple):
    """ż = A z + b (p z(t) + q z(t − τ)).

    Attributes:
        inputs: b, (d,).
        present: p, (d,).
        delayed: q, (d,).
        apart: whether the forces act in several directions, so that no b serves all.
    """

    inputs: Float[AnyArray, " d"]
    present: Float[AnyArray, " d"]
    delayed: Float[AnyArray, " d"]
    apart: Bool[AnyArray, ""]


def one_force(system: DelaySystem, present: Float[AnyArray, "e r"], delayed: Float[AnyArray, "e m"]) -> OneForce:
    """E (P C z(t) + Q D z(t − τ)) with a single b: E itself, or of several forces what their products have in common.

    Args:
        system: with E, C and D.
        present: P, (e, r).
        delayed: Q, (e, m).
    """
    lib = namespace(system, present, delayed)
    inputs, seen = system.input_matrix(), (present @ system.output_matrix(), delayed @ dense_outputs(system.recalled))
    if system.force_size == 1:
        return OneForce(inputs[:, 0], seen[0][0], seen[1][0], lib.zeros((), dtype=bool))
    acting = inputs @ lib.concatenate(seen, axis=1)
    # Each column is a multiple of b, and so of the largest.
    along = lib.take(acting, lib.argmax(lib.sum(acting**2, axis=0)), axis=1)
    size = along @ along
    rows = (along @ acting) / lib.where(size == 0, 1.0, size)
    apart = lib.any(lib.abs(acting - along[:, None] * rows) > _ROUNDING * lib.abs(acting))
    return OneForce(along, rows[: system.state_size], rows[system.state_size :], apart)
