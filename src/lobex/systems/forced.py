"""Forced systems as systems without forcing: what pushes is the feedback of a state that is 1 at all times."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex._namespace import namespace
from lobex._shapes import AnyArray
from lobex.systems.coefficients import Coefficient, Framed
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Feedback, Present, Regenerative


def as_feedback(system: DelaySystem) -> DelaySystem:
    """The same motion without forcing: g(t) acts on one more output, that of a state which keeps its value.

    A period is then a linear map of the state with a 1 in it, so that whatever knows the maps of unforced systems knows
    the affine ones of forced systems, and jumps of the forcing end pieces as others do.

    Returns:
        A system of one more block, of which the first number, ``system.state_size`` in z, is to be 1 and the others 0,
        and of one more output, the last.
    """
    s = np.shape(system.blocks)[1]
    r, e = system.output_size, system.force_size
    lib = namespace(system.blocks, system.inputs, system.outputs)
    # In the size of the other outputs, by which forces are scaled.
    size = lib.sqrt(lib.sum(lib.asarray(system.outputs) ** 2))
    of_one = lib.zeros((1, r + 1, s)) + size * np.eye(r + 1, s, -r)
    unit = np.eye(e)
    seen, one = np.eye(r, r + 1), np.eye(1, r + 1, r) / size

    def framed(left: Float[AnyArray, "e f"], coefficient: Coefficient, right: Float[AnyArray, "q r"]) -> Any:
        return Framed(left, coefficient, right)

    def terms() -> Iterator[Feedback]:
        for term in system.feedback:
            if isinstance(term, Present | Regenerative):
                sign = 1.0 if isinstance(term, Present) else -1.0
                yield Present(framed(sign * unit, term.coefficient, seen))
            if isinstance(term, Delayed | Regenerative):
                yield Delayed(term.coefficient, term.delay)
        for term in system.forcing:
            yield Present(framed(unit, term.coefficient, one))

    def widened(part: Float[AnyArray, "n ..."], *added: tuple[int, int]) -> Float[AnyArray, "n+1 ..."]:
        return lib.pad(lib.asarray(part), ((0, 1), *added))

    outputs = lib.concatenate([lib.pad(lib.asarray(system.outputs), ((0, 0), (0, 1), (0, 0))), of_one])
    return replace(
        system,
        blocks=widened(system.blocks, (0, 0), (0, 0)),
        inputs=widened(system.inputs, (0, 0), (0, 0)),
        outputs=outputs,
        remembered=widened(system.recalled, (0, 0), (0, 0)),
        terms=tuple(terms()),
    )
