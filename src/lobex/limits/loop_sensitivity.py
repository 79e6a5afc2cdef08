"""How limits of milling from receptances move with every number: by the vectors of the loop's eigenvalue.

With w M v the eigenvalue −1/b of the loop M, and vectors that stay as they are, which to first order they may, what is
left is a sum over the phases φ of each tooth: of Σₖ wₖ e^{−2πjkφ}, its force H(φ), and what it meets there,
Σₗ (1 − e^{−j(ω + lω_T)τ}) G(ω + lω_T) vₗ e^{2πjlφ}. The phase of w M v stays at π, which tells how ω moves; of flips
and folds, ω is held.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from lobex._batches import in_batches, over_few, together
from lobex._compiled import compiled_quickly_for
from lobex._shapes import Number
from lobex.limits.loop_of_teeth import loops_of
from lobex.limits.parameters import in_rows
from lobex.limits.receptance_matrix import MatrixCurve
from lobex.limits.tooth_harmonics import in_the_cut
from lobex.processes.process import differentiable
from lobex.processes.tooth import Tooth, teeth_of
from lobex.results.codes import Kind
from lobex.results.limit import Limit

_BATCH, _TOGETHER = 16, 4


class _At(NamedTuple):
    """Limits, each with the vectors of its loop.

    Attributes:
        speed, gain: (n,).
        waves: ω in those of the period, (n,).
        held: whether ω is a share of that of the period, as of flips and folds, (n,).
        left, right: w and v, zero at harmonics that are not kept, (n, lines, r).
    """

    speed: Float[Any, " *n"]
    gain: Float[Any, " *n"]
    waves: Float[Any, " *n"]
    held: Bool[Any, " *n"]
    left: Complex[Any, "*n lines r"]
    right: Complex[Any, "*n lines r"]


def of_teeth(limit: Limit, build: Callable[[Any], Any], parameters: Any) -> Float[np.ndarray, "found parameters"]:
    """dK/dp at the limits that were found, of the process that ``build`` makes of parameters.

    Call it in the scope of float64.
    """
    process = build(parameters)
    curve, loops = MatrixCurve(process.modes), loops_of(limit, process)
    found = [(number, loop) for number, loop in enumerate(loops) if loop is not None]
    order = np.unique(np.concatenate([loop.order for _, loop in found]))
    shape = len(found), len(order), curve.directions
    left, right = np.zeros(shape, complex), np.zeros(shape, complex)
    for row, (_, loop) in enumerate(found):
        vectors, kept = loop.eigenvalue(loop.matrices(curve)[0]), np.searchsorted(order, loop.order)
        left[row, kept], right[row, kept] = (
            part.reshape(len(kept), curve.directions) for part in (vectors.left, vectors.right)
        )
    there = [number for number, _ in found]
    held = np.isin(np.asarray(limit.kind_code)[there], (Kind.FLIP, Kind.FOLD))
    waves = np.array([loop.waves for _, loop in found])
    at = _At(np.asarray(limit.speed, float)[there], np.asarray(limit.gain, float)[there], waves, held, left, right)

    def batch(count: Int[Array, ""], *at: Any) -> Float[Array, "n parameters"]:
        return _derivatives(build, parameters, order, count, *at)

    return in_batches(batch, at, _BATCH)


@compiled_quickly_for("build")
def _derivatives(
    build: Callable[[Any], Any], parameters: Any, order: Int[Any, " lines"], count: Int[Array, ""], *at: Any
) -> Float[Array, "n parameters"]:
    def point(*at: Any) -> tuple[Any, Array]:
        here = _At(*at)

        def logarithm(parameters: Any, speed: Number, waves: Number) -> tuple[Float[Array, ""], Float[Array, ""]]:
            value = _eigenvalue(build(parameters), speed, waves, order, here)
            found = jnp.log(value / jax.lax.stop_gradient(value))
            return jnp.real(found), jnp.imag(found)

        _, back = jax.vjp(logarithm, parameters, here.speed, here.waves)
        one, none = jnp.ones_like(here.speed), jnp.zeros_like(here.speed)
        (*size, by_waves), (*turn, turning) = back((one, none)), back((none, one))
        share = jnp.where(here.held, 0.0, by_waves / jnp.where(here.held, 1.0, turning))
        moves = jax.tree.map(lambda size, turn: here.gain * (share * turn - size), size, turn)
        return tuple(moves)

    return in_rows(over_few(point, together(len(at[0]), _TOGETHER), count, *at))


def _eigenvalue(process: Any, speed: Number, waves: Number, order: Int[Any, " lines"], at: _At) -> Complex[Array, ""]:
    """w M v, in the form of a process from which derivatives come out right."""
    total: Any = 0
    form: Any
    for weight, form in differentiable(process):
        lines = (waves + order) * 2 * jnp.pi * speed * form.cutter.alike
        moved = jnp.einsum("lij,lj->li", MatrixCurve(form.modes, lines)(lines), at.right)

        def of_tooth(tooth: Tooth, moved: Complex[Array, "lines r"] = moved) -> Complex[Array, ""]:
            share = 1.0 if tooth.share is None else tooth.share
            met = (1 - jnp.exp(-2j * jnp.pi * (waves + order) * share))[:, None] * moved
            total: Any = 0
            for phase, force in in_the_cut(tooth, 0 if len(order) == 1 else len(order)):
                wave = jnp.exp(2j * jnp.pi * phase[:, None] * order)
                pushed, chip = jnp.conj(wave) @ at.left, wave @ met
                total = total + jnp.sum(pushed * jnp.einsum("pij,pj->pi", force, chip))
            return total

        # Traced once for all.
        teeth = jax.tree.map(lambda *parts: jnp.stack(parts), *teeth_of(form, 1.0))
        total = total + weight * jnp.sum(jax.vmap(of_tooth)(teeth))
    return total
