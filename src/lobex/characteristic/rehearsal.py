"""The programs of a chart by strips, compiled side by side before the first of them is needed."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from lobex._batches import side_by_side
from lobex.characteristic.cells import PARTS
from lobex.characteristic.climb import newton
from lobex.characteristic.closed_loop import Loops
from lobex.characteristic.follow import STRIDE, follow_each
from lobex.characteristic.function import Contact
from lobex.characteristic.lanes import placed, take
from lobex.characteristic.last_digits import polish
from lobex.characteristic.line import passes_of, verdicts_of
from lobex.characteristic.open_loop import Open
from lobex.characteristic.strips import passes_over, verdicts_over

_rehearsed: set[Any] = set()


def rehearse(opened: Open, loops: Loops, contact: Contact, gains: Float[Any, " m"]) -> None:
    """Have every program made for lanes of this kind, once in a process; what they find is of no use.

    Args:
        opened: the lanes.
        loops: those closed at a gain.
        contact: as it is polished.
        gains: K.
    """
    kind = jax.tree.map(np.shape, (take(opened, np.zeros(1, int)).filled(), placed(contact.filled())))
    leaves = tuple(jax.tree.leaves(kind))
    if leaves in _rehearsed:
        return
    one = np.zeros(1, dtype=int)
    there, closed = placed(take(opened, one).filled()), placed(take(loops, one).filled())
    place, real, cells = np.full(1, 1j), np.ones(1), np.ones((1, PARTS))
    # Those that take longest first.
    parts: list[Callable[[], Any]] = [
        partial(follow_each, there, one, np.full((1, STRIDE), gains[0]), place),
        partial(polish, contact, one, gains[:1], place),
        partial(verdicts_over, there, one, real, real, real, cells, cells),
        partial(newton, closed, one, place),
        partial(passes_over, there, one, real, real, real, real, real > 0),
        partial(verdicts_of, closed, one, real, real, cells, cells),
        partial(passes_of, closed, one, real, real, real),
    ]
    with np.errstate(all="ignore"):
        list(side_by_side(lambda number: parts[number](), len(parts), first_alone=False))
    _rehearsed.add(leaves)
