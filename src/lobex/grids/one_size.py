"""Points with one number of nodes per piece: what is the same at a speed, and the multiplier with its errors."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Inexact, Int

from lobex._batches import over_few, together
from lobex._compiled import either_way
from lobex._shapes import AnyArray, Number
from lobex.floquet import dense
from lobex.floquet.chatter import carrier_frequency
from lobex.floquet.power import Pair, as_complex, as_pair
from lobex.floquet.subspace import dominant_pair
from lobex.operators.duhamel import Duhamel
from lobex.operators.elimination import inverse, pivoted_inverse
from lobex.processes.process import Process
from lobex.systems.mesh import mesh_of
from lobex.systems.system import Forces
from lobex.systems.traits import Traits

# Points, of coupled modes.
_FEW = 1000
FEWEST = 8
"""Of what is computed side by side."""
# The same of coefficients that are shared, each of which takes long.
_SIDE_BY_SIDE = 4


def _prepared_at(
    process: Process,
    method: Duhamel,
    speeds: Float[AnyArray, " speeds"],
    gain: Number,
    count: Number,
    traits: Traits,
    in_flight: int,
) -> Any:
    """What of the operators is the same for all gains at each of the first ``count`` speeds; None where nothing is."""
    if traits.structure_by_gain:
        return None

    def at(speed: Number) -> Any:
        return method.prepare(process.system(speed, gain), traits, in_flight)

    return over_few(at, together(len(speeds), FEWEST), count, speeds)


def _coefficients_at(
    process: Process, method: Duhamel, speed: Number, gains: Float[AnyArray, " gains"], count: Number
) -> Forces:
    """The coefficients that are the same for all speeds, at the first ``count`` gains."""

    def at(gain: Number) -> Forces:
        return method.coefficients(process.system(speed, gain))

    return over_few(at, together(len(gains), _SIDE_BY_SIDE), count, gains)


def _with_errors(
    process: Process,
    prepared: Any,
    row: Int[AnyArray, " p"],
    speed: Float[AnyArray, " p"],
    gain: Float[AnyArray, " p"],
    method: Duhamel,
    squarings: int | Int[Array, ""],
    count: Number,
    densely: bool,
    several: int,
    samples: int | None,
    frequencies: bool,
    shared: tuple[Forces, Int[AnyArray, " p"]] | None = None,
) -> tuple[Inexact[Array, " p"], ...]:
    """Dominant multipliers, chatter frequencies (NaN unless ``frequencies``), estimated errors by nodes and by
    rounding, and defects, at the first ``count`` points; with ``samples`` of the structure's kernel where nothing is
    prepared. Of ``shared`` coefficients and which of them is each point's they are taken in place of computing them.
    """

    def point(
        row: Int[Array, ""], speed: Float[Array, ""], gain: Float[Array, ""], *which: Int[Array, ""]
    ) -> tuple[Inexact[Array, ""], ...]:
        system = process.system(speed, gain)
        if prepared is None:
            mine = method.prepare(system, samples=samples)
        else:
            mine = jax.tree.map(lambda part: part[row], prepared)
        coefficients = None if shared is None else jax.tree.map(lambda part: part[which[0]], shared[0])
        forces = method.forces(system, coefficients)
        pieces = method.respond(mine, system, pivoted_inverse if densely else inverse, forces)
        matrix = method.assemble(pieces, system)
        if densely:
            value, vector = dense.pair_by_eigensolver(matrix)
            pair = Pair(*map(as_pair, (value, vector, dense.left_vector(matrix, value, vector))))
        else:
            mesh = mesh_of(system)
            pair = dominant_pair(matrix, system.state_size, squarings, -(-mesh.history // mesh.pieces))
        motion = method.motion(mine, pieces, system, pair, forces)
        frequency = jnp.full_like(motion.error, jnp.nan)
        if frequencies:
            frequency = carrier_frequency(motion.phase, motion.weight, motion.output, system.period, pair.value)
        return as_complex(pair.value), frequency, motion.error, motion.rounding, motion.defect

    return over_few(point, several, count, row, speed, gain, *([] if shared is None else shared[1:]))


prepared_at = either_way(_prepared_at, "traits", "in_flight")
coefficients_at = either_way(_coefficients_at)
with_errors = either_way(_with_errors, "densely", "several", "samples", "frequencies")


def compile_longer(process: Process, speed: np.ndarray, gain: np.ndarray) -> bool:
    """Whether operators take longer to compile than to compute at each speed, Hz, with each gain, which are few then:
    of blades that are coupled, and others with many states in a block.
    """
    few = 0 < speed.size * gain.size < _FEW
    return few and np.shape(process.system(float(speed[0]), float(gain[0])).blocks)[1] > 2


def few_of_each(row: np.ndarray, few: int) -> np.ndarray:
    """Which of the points of rows (p,) are ``few`` of each, or one more, evenly among them; all where they are not
    twice as many.
    """
    order = np.argsort(row, kind="stable")
    number = np.empty(len(row), dtype=int)
    number[order] = np.arange(len(row)) - np.searchsorted(row[order], row[order])
    step = np.maximum(np.bincount(row)[row] // few, 1)
    return number % step == step // 2
