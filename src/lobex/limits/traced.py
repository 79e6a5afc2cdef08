"""The critical gain under ``jit``, ``grad`` and ``vmap``: the lowest limit in pure JAX, with its derivative."""

from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int, Real

from lobex._float64 import in_float64
from lobex._missing import where_there, without_derivative
from lobex._shapes import AnyArray, Number
from lobex.characteristic.method import CharacteristicRoots
from lobex.floquet import power
from lobex.grids.choice import AnyMethod, Auto, operator_of
from lobex.limits.changes import TIE, label_densely, operator_family
from lobex.limits.chattering_mode import no_labels
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.limits.d_subdivision import exact_critical
from lobex.limits.growth import SQUARINGS, find_zero_growth, growth
from lobex.operators.operator import Method
from lobex.processes.process import Process
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.results.limit import Limit

# Gain, chatter frequency, kind and status of every speed.
_Parts = tuple[Float[AnyArray, " lanes"], Float[AnyArray, " lanes"], Int[AnyArray, " lanes"], Int[AnyArray, " lanes"]]

# Of the scan, where only the sign counts.
_SCAN_SQUARINGS = 16


def traced_critical_gain(process: Process, speed: Any, gains: np.ndarray, method: AnyMethod) -> Limit:
    """The lowest limit between the first and the last of ``gains`` where speed or process are traced.

    What has it in closed form, such as ``Rub`` and ``Turning``, has it by D-subdivision, unless a method with an
    operator is asked for. Of everything else the gains are scanned with an operator of fixed size, and Newton's method
    polishes the first change.
    """
    speeds = jnp.atleast_1d(jnp.asarray(speed, dtype=jnp.result_type(float)))
    exact = isinstance(method, Auto | CharacteristicRoots)
    found = closed_form(process) if exact else None
    if isinstance(found, Regeneration):
        method = CharacteristicRoots()
        parts = _by_subdivision(found, speeds, float(gains[0]), float(gains[-1]))
    else:
        method = operator_of(method)
        parts = _by_operator(process, speeds, gains, method)
    gain, frequency, kind, status = parts
    nothing = jnp.full((*jnp.shape(gain), 1, 2), jnp.nan)
    return Limit(
        speed=speeds,
        gain=gain,
        chatter_frequency=frequency,
        kind_code=kind,
        status_code=status,
        intervals=nothing,
        **no_labels(jnp.size(gain))._asdict(),
        error=nothing[:, 0, 0],
        bounds=(float(gains[0]), float(gains[-1])),
        quantity=process.gain,
        speed_unit=process.speed_unit,
        process={"type": type(process).__name__},
        method=describe(method),
        seconds=float("nan"),
        compiling=float("nan"),
    )


def _by_subdivision(source: Regeneration, speeds: Real[AnyArray, " lanes"], lowest: float, highest: float) -> _Parts:
    found = exact_critical(source, speeds, lowest if lowest > 0 else None)
    within = found.gain <= highest
    status = jnp.where(within, jnp.where(found.tie, Status.TIE, Status.FOUND), Status.NONE_IN_RANGE)
    status = jnp.where(jnp.isnan(found.gain), Status.UNSTABLE_AT_THE_LOWER_BOUND, status)
    kind, frequency = jnp.where(within, Kind.HOPF, Kind.NONE), found.angular_frequency / (2 * np.pi)
    return where_there(within, found.gain), where_there(within, frequency), kind, status


@in_float64
def _by_operator(process: Process, speeds: Real[AnyArray, " lanes"], gains: np.ndarray, method: Method) -> _Parts:
    fixed = jax.lax.stop_gradient((process, speeds))

    def search(
        speed: Number,
    ) -> tuple[Float[Array, ""], Int[Array, ""], Float[Array, ""], Int[Array, ""], Float[Array, ""]]:
        _, family = operator_family(fixed[0], method, speed, jnp.asarray(gains[0]))
        values = jax.vmap(lambda g: _growth_of(family(g)[0]))(jnp.asarray(gains))
        unstable = values >= 0
        first = jnp.argmax(unstable)
        before = jnp.maximum(first - 1, 0)
        ends = values[before], values[first]
        low, high = jnp.asarray(gains)[before], jnp.asarray(gains)[first]
        guess = low + (high - low) * ends[0] / (ends[0] - ends[1])
        change = find_zero_growth(family, low, high, ends, guess, SQUARINGS)
        bracketed = unstable.any() & (first > 0)
        good = bracketed & (jnp.abs(change.growth) < jnp.sqrt(jnp.finfo(values.dtype).eps) / 10)
        status = jnp.where(
            good,
            Status.FOUND,
            jnp.where(
                unstable[0],
                Status.UNSTABLE_AT_THE_LOWER_BOUND,
                jnp.where(bracketed | jnp.isnan(values).any(), Status.NOT_CONVERGED, Status.NONE_IN_RANGE),
            ),
        )
        gain = cast(Array, jnp.where(good, change.gain, jnp.nan))
        label = label_densely(fixed[0], method, speed, jnp.nan_to_num(gain, nan=gains[0]))
        status = jnp.where(good & (jnp.log(label.rival) > -TIE), Status.TIE, status)
        frequency = jnp.where(good, label.frequency, jnp.nan)
        return gain, status, frequency, jnp.where(good, label.kind, Kind.NONE), change.slope

    root, status, frequency, kind, slope = jax.lax.stop_gradient(jax.lax.map(search, fixed[1]))
    there = ~jnp.isnan(root)
    safe = jnp.where(there, root, gains[0])
    # On the limit the growth stays zero: ∂F/∂θ dθ + ∂F/∂g dg = 0.
    residual = jax.vmap(partial(growth, process, method))(speeds, safe)
    moved = (residual - jax.lax.stop_gradient(residual)) / cast(Array, jnp.where(there, slope, 1.0))
    gain = where_there(there, safe - moved)
    return gain, without_derivative(frequency, gain), kind, status


def _growth_of(matrix: Float[Array, "N N"]) -> Float[Array, ""]:
    pair = power.pair_by_squaring(matrix, jnp.asarray(_SCAN_SQUARINGS))
    return jnp.log(jnp.sum(pair.value**2)) / 2
