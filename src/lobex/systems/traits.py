"""What of a process its gain and its speed enter, found by following them through its equations."""

from typing import Any, NamedTuple

import jax
import numpy as np
from jax.extend.core import Literal
from jaxtyping import Float

from lobex._shapes import AnyArray, Number
from lobex.systems.form import by_form
from lobex.systems.mesh import mesh_of


class Traits(NamedTuple):
    """Of a process, whatever its numbers.

    Attributes:
        structure_by_gain: structure, period, jumps or delays follow the gain, so that nothing that a method makes of
            them serves two gains.
        present_by_gain: the coefficients of forces that act at once follow it.
        chips_by_gain: the chips that outputs make, where forces are of chips, follow it.
        coefficients_by_speed: coefficients or where pieces end follow the speed. It is looked for where coefficients
            bend within pieces alone, which take long to compute.
    """

    structure_by_gain: bool
    present_by_gain: bool
    chips_by_gain: bool
    coefficients_by_speed: bool = True


FOLLOWING = Traits(True, True, True)
"""Of a system of which nothing is known."""


@by_form
def traits_of(made: Any, shapes: tuple[Any, ...], number: Any) -> Traits:
    """The traits of a process, by its equations in JAX: nothing is declared, so that nothing is declared wrongly.

    A function that JAX keeps closed (one of ``jax.jit``, a loop) counts as a whole: all that comes out of it follows
    the gain if anything that goes in does.
    """

    def parts(numbers: tuple[Float[AnyArray, "..."], ...], speed: Number, gain: Number) -> tuple[Any, ...]:
        system = made(numbers).system(speed, gain)
        mesh = mesh_of(system)
        phase = mesh.start + mesh.length / 2
        structure = system.blocks, system.inputs, system.outputs, system.remembered, system.period
        chips = [jax.vmap(lambda at, chip=chip: chip.factors(at, at[None])[1])(phase) for chip in system.chips]
        coefficients = system.at(phase)
        bent = (mesh.start, mesh.length, coefficients) if system.bends else None
        structure = structure, mesh.start, mesh.length, mesh.gap, system.lags(phase)
        return structure, coefficients.present, chips, bent

    traced, shapes = jax.make_jaxpr(parts, return_shape=True)(shapes, number, number)
    ends = np.cumsum([len(jax.tree.leaves(part)) for part in shapes])[:-1]
    by_gain, (*_, bent_by_speed) = (np.split(followers(traced.jaxpr, argument), ends) for argument in (-1, -2))
    structure_follows, present_follows, chips_follow = (bool(np.any(part)) for part in by_gain[:-1])
    quick = bent_by_speed.size == 0
    return Traits(structure_follows, present_follows, chips_follow, quick or bool(np.any(bent_by_speed)))


def followers(jaxpr: Any, argument: int = -1) -> list[bool]:
    """Which results follow an argument, the last one."""
    touched = {jaxpr.invars[argument]}
    for equation in jaxpr.eqns:
        if any(not isinstance(given, Literal) and given in touched for given in equation.invars):
            touched.update(equation.outvars)
    return [not isinstance(result, Literal) and result in touched for result in jaxpr.outvars]
