"""Constant forces that act in one direction of the state, taken together as one."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.systems.system import DelaySystem, dense_outputs

# Of a product of two rounded numbers, and more.
_ROUNDING = 1e-12


class OneForce(NamedTuple):
    """ż = A z + b (p z(t) + q z(t − τ)), or with a sum over delays.

    Attributes:
        inputs: b, (d,).
        present: p, (d,).
        delayed: q, (d,), or (k, d) of k delays.
        apart: whether the forces act in several directions, so that no b serves all.
    """

    inputs: Float[AnyArray, " d"]
    present: Float[AnyArray, " d"]
    delayed: Float[AnyArray, "*k d"]
    apart: Bool[AnyArray, ""]


def one_force(system: DelaySystem, present: Float[AnyArray, "e r"], delayed: Float[AnyArray, "*k e m"]) -> OneForce:
    """E (P C z(t) + Q D z(t − τ)) with a single b: E itself, or of several forces what their products have in common.

    Args:
        system: with E, C and D.
        present: P, (e, r).
        delayed: Q, (e, m), or (k, e, m) of k delays.
    """
    lib = namespace(system, present, delayed)
    several = np.ndim(delayed) == 3
    recalled = dense_outputs(system.recalled)
    before = tuple(part @ recalled for part in delayed) if several else (delayed @ recalled,)
    inputs, seen = system.input_matrix(), (present @ system.output_matrix(), *before)
    if system.force_size == 1:
        then = lib.stack([part[0] for part in before]) if several else before[0][0]
        return OneForce(inputs[:, 0], seen[0][0], then, lib.zeros((), dtype=bool))
    acting = inputs @ lib.concatenate(seen, axis=1)
    # Each column is a multiple of b, and so of the largest.
    along = lib.take(acting, lib.argmax(lib.sum(acting**2, axis=0)), axis=1)
    size = along @ along
    rows = (along @ acting) / lib.where(size == 0, 1.0, size)
    apart = lib.any(lib.abs(acting - along[:, None] * rows) > _ROUNDING * lib.abs(acting))
    then = rows[system.state_size :]
    return OneForce(along, rows[: system.state_size], then.reshape(-1, system.state_size) if several else then, apart)
