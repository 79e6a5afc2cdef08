"""What of a process its gain enters, found by following the gain through its equations."""

from typing import Any, NamedTuple

import jax
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
    """

    structure_by_gain: bool
    present_by_gain: bool
    chips_by_gain: bool


FOLLOWING = Traits(True, True, True)
"""Of a system of which nothing is known."""


@by_form
def traits_of(made: Any, shapes: tuple[Any, ...], number: Any) -> Traits:
    """The traits of a process, by its equations in JAX: nothing is declared, so that nothing is declared wrongly.

    A function that JAX keeps closed (one of ``jax.jit``, a loop) counts as a whole: all that comes out of it follows
    the gain if anything that goes in does.
    """

    def parts(numbers: tuple[Float[AnyArray, "..."], ...], speed: Number, gain: Number) -> tuple[Any, Any, Any]:
        system = made(numbers).system(speed, gain)
        mesh = mesh_of(system)
        phase = mesh.start + mesh.length / 2
        structure = system.blocks, system.inputs, system.outputs, system.remembered, system.period
        chips = [jax.vmap(lambda at, chip=chip: chip.factors(at, at[None])[1])(phase) for chip in system.chips]
        return (structure, mesh.start, mesh.length, mesh.gap, system.lags(phase)), system.at(phase).present, chips

    traced, shapes = jax.make_jaxpr(parts, return_shape=True)(shapes, number, number)
    follows = followers(traced.jaxpr)
    structure = len(jax.tree.leaves(shapes[0]))
    return Traits(any(follows[:structure]), follows[structure], any(follows[structure + 1 :]))


def followers(jaxpr: Any) -> list[bool]:
    """Which results follow the last argument."""
    touched = {jaxpr.invars[-1]}
    for equation in jaxpr.eqns:
        if any(not isinstance(given, Literal) and given in touched for given in equation.invars):
            touched.update(equation.outvars)
    return [not isinstance(result, Literal) and result in touched for result in jaxpr.outvars]
