"""Multipliers at one point in pure JAX, and their derivatives in the form that a process has for them."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax.custom_derivatives import SymbolicZero
from jaxtyping import Array, Complex, Float, Inexact

from lobex._shapes import AnyArray, Number
from lobex.floquet.dense import all_multipliers, largest_modulus
from lobex.operators.operator import Method
from lobex.processes.process import Process, differentiable


def matrix_of(process: Process, method: Method, speed: Number, gain: Number) -> Float[Array, "N N"]:
    """The operator's matrix at one point."""
    return method.operator(process.system(speed, gain)).matrix


@jax.custom_jvp
def radius(process: Process, method: Method, speed: Number, gain: Number) -> Float[Array, ""]:
    """max|μ| at one point, in pure JAX; differentiated in the form that the process has for it."""
    return largest_modulus(matrix_of(process, method, speed, gain))


@jax.custom_jvp
def sorted_multipliers(process: Process, method: Method, speed: Number, gain: Number) -> Complex[Array, " N"]:
    """All multipliers at one point, largest modulus first; differentiated as ``radius`` is."""
    return all_multipliers(matrix_of(process, method, speed, gain))


@partial(radius.defjvp, symbolic_zeros=True)
def _(primals: tuple[Any, ...], tangents: tuple[Any, ...]) -> tuple[Inexact[Array, "..."], Inexact[Array, "..."]]:
    return _along(largest_modulus, primals, tangents)


@partial(sorted_multipliers.defjvp, symbolic_zeros=True)
def _(primals: tuple[Any, ...], tangents: tuple[Any, ...]) -> tuple[Inexact[Array, "..."], Inexact[Array, "..."]]:
    values = sorted_multipliers(*primals)
    # The other form may have more rows, whose multipliers are zeros behind all others.
    return values, _along(all_multipliers, primals, tangents)[1][: len(values)]


def _along(
    of_matrix: Callable[[Float[Array, "N N"]], Inexact[Array, "..."]],
    primals: tuple[Any, ...],
    tangents: tuple[Any, ...],
) -> tuple[Inexact[Array, "..."], Inexact[Array, "..."]]:
    """Value and derivative of a function of the operator, along those numbers alone that do vary."""
    leaves, tree = jax.tree.flatten(primals)
    changes = jax.tree.leaves(tangents)
    varied = [i for i, change in enumerate(changes) if not isinstance(change, SymbolicZero)]

    def value(*numbers: Inexact[AnyArray, "..."]) -> Inexact[Array, "..."]:
        every = dict(enumerate(leaves)) | dict(zip(varied, numbers, strict=True))
        process, *others = jax.tree.unflatten(tree, every.values())
        weights, forms = zip(*differentiable(process), strict=True)
        if len(forms) == 1:
            return of_matrix(matrix_of(forms[0], *others))
        stacked = jax.tree.map(lambda *parts: jnp.stack(parts), *forms)
        values = jax.vmap(lambda form: of_matrix(matrix_of(form, *others)))(stacked)
        return jnp.tensordot(jnp.asarray(weights), values, axes=1)

    return jax.jvp(value, [leaves[i] for i in varied], [changes[i] for i in varied])
