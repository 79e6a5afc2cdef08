"""Numbers that are not there: NaN, and so are derivatives that nothing has."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Inexact

from lobex._namespace import namespace, still
from lobex._shapes import AnyArray

# Of one number or of many.
_Truths = Bool[AnyArray, "..."] | np.bool_ | bool
_Values = Inexact[AnyArray, "..."] | float | complex


def where_there(there: _Truths, value: _Values) -> Inexact[AnyArray, "..."]:
    """``value`` where it is there, and elsewhere NaN.

    What is not there has no derivative either, NaN; but where nobody asks for it, as in a sum or a minimum over the
    others, it hides none of theirs.
    """
    if namespace(there, value) is np:
        return np.where(there, value, np.nan)
    return _marked(*jnp.broadcast_arrays(there, value))


def with_stand_in(there: _Truths, value: _Values, other: float) -> Any:
    """``value`` where it is there, and elsewhere ``other`` that moves as it does, to go on to ``where_there``."""
    lib = namespace(there, value)
    return value + still(lib.where(there, 0.0, other - value))


@jax.custom_jvp
def without_derivative(value: Inexact[Array, "..."], beside: Inexact[Array, "..."]) -> Inexact[Array, "..."]:
    """``value``, of which nobody knows how it moves with what moves ``beside``: its derivative is NaN."""
    return value


@jax.custom_jvp
def _marked(there: Bool[Array, "..."], value: Inexact[Array, "..."]) -> Inexact[Array, "..."]:
    return jnp.where(there, value, jnp.nan)


@without_derivative.defjvp
def _(primals: tuple[Any, Any], tangents: tuple[Any, Any]) -> tuple[Any, Any]:
    value, beside = primals
    return without_derivative(value, beside), _known_move(jnp.zeros(jnp.shape(value), bool), tangents[1])


@_marked.defjvp
def _(primals: tuple[Any, Any], tangents: tuple[Any, Any]) -> tuple[Any, Any]:
    there, value = primals
    return _marked(there, value), _known_move(there, tangents[1])


def _known_move(there: Bool[Array, "..."], move: Inexact[Array, "..."]) -> Inexact[Array, "..."]:
    """How a number moves, NaN where it is not there; the other way, only where somebody asks.

    A product with NaN would give NaN for what nobody asks for. Of a linear map JAX takes a rule for the other way for
    the solution of an equation alone.
    """

    def forwards(_: Any, move: Any) -> Any:
        return jnp.where(there, move, jnp.nan)

    def backwards(_: Any, asked: Any) -> Any:
        return jnp.where(there | (asked == 0), asked, jnp.nan)

    return jax.lax.custom_linear_solve(lambda move: move, move, forwards, backwards)
