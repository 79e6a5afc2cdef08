"""Sensitivities of the stability limit: how it moves with every number of the model, at limits already found."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import jax
import numpy as np
from jaxtyping import Array, Float, Int

from lobex import _checks
from lobex._batches import in_batches, over_few, together
from lobex._compiled import compiled_for
from lobex._float64 import at_once, widened
from lobex._pytree import is_measured
from lobex._shapes import AnyArray, Number
from lobex.grids.choice import AUTO, AnyMethod, operator_of, tolerance_of
from lobex.limits.closed_form import closed_form
from lobex.limits.critical import critical_gain
from lobex.limits.d_subdivision import limit_followed
from lobex.limits.exact_limit import exact_limit
from lobex.limits.growth import growth
from lobex.limits.loop_of_teeth import ALL, MEAN
from lobex.limits.loop_sensitivity import of_teeth
from lobex.limits.parameters import in_rows, number_names, number_values
from lobex.operators.operator import Method
from lobex.processes.process import Process, check_process, fine_enough
from lobex.results.limit import Limit
from lobex.results.rebuild import rebuild
from lobex.results.sensitivities import Sensitivities

Builder = Callable[[Any], Process]
Verb = Callable[[Any, Any], Limit]

_CLOSED_FORM = "DSubdivision"
# Speeds side by side: those of a first look, since the last batch is filled up with repeats.
_BATCH, _TOGETHER = 16, 4


def sensitivities(
    process: Process | Builder,
    speed: Any,
    bounds: tuple[Any, Any] | None = None,
    method: AnyMethod = AUTO,
    *,
    at: Mapping[str, Any] | None = None,
    verb: Verb | None = None,
    scan: int = 65,
    progress: bool = False,
) -> Sensitivities:
    """How much the stability limit moves with each number of the model: d ln K / d ln p, per speed.

    The limit K is found first: in closed form (``exact_limit``), with ``bounds`` by ``critical_gain``, or by ``verb``,
    such as ``zero_order_limit``. The derivative is that of the implicit function theorem at the limit found,
    dK/dp = −(∂F/∂p)/(∂F/∂K) with F = log max|μ|, or with the equation that the verb solves in F's place: one
    reverse-mode gradient per speed gives it for all numbers at once, and nothing is traced through the search.

    The numbers are those of the process, named by their path, such as "modes.damping_ratio[0]", and "speed".
    Those of a measured ``Receptance`` are its frequencies and samples, "modes.frequency[7]", "modes.response[7].real"
    and "modes.response[7].imag": which lines matter, and with ``band`` what their noise does to the limit.
    For numbers that the process is made from, give the function that makes it and the numbers ``at`` which::

        lobex.sensitivities(
            lambda p: lobex.Rub(lobex.Rod(young_modulus=p["E"]).modes(p["damping_ratio"])),
            speed,
            at={"E": 210e7, "damping_ratio": 0.03},
        )

    Args:
        process: a process or, with ``at``, a function of a dictionary of numbers that makes one in pure JAX.
        speed: speeds, Hz (revolutions per second), (n,) or one number.
        bounds: lowest and highest gain of a search, as ``critical_gain`` takes them; None for ``exact_limit``.
        method: as ``critical_gain`` takes it, used with ``bounds``; derivatives are those of an operator in any case.
        at: numbers or arrays of numbers by name, handed to the function ``process``.
        verb: what finds the limit of a process at speeds, where it is neither of the two: ``lobex.zero_order_limit``,
            ``lobex.multi_frequency_limit``, or one with arguments of its own, such as
            ``partial(lobex.multi_frequency_limit, reach=4000.0)``.
        scan: number of gains in the scan, used with ``bounds``.
        progress: show a progress bar on standard error.

    Returns:
        ``Sensitivities``, with the ``Limit`` in it. NaN where there is no limit; at a status of "tie" (a cusp
        between lobes) they are those of one side.

    Raises:
        ValueError: as ``exact_limit``, ``critical_gain`` and ``verb`` do, for a function without ``at`` or the other
            way round, for a verb that finds no ``Limit``, and for a verb and ``bounds`` together.

    Warns:
        LobexWarning: as ``exact_limit`` and ``critical_gain``.
    """
    _checks.untraced("sensitivities", process=process, speed=speed, at=at)
    if verb is not None and (bounds is not None or not callable(verb)):
        raise ValueError(
            f"verb = {_checks.brief(verb)} finds the limit by itself, as a function of process and speed; give that, "
            "without bounds"
        )
    if at is None:
        parameters, build = process, _itself
        check_process(process)
    else:
        if hasattr(process, "system") or not callable(process):
            raise ValueError(f"process = {_checks.brief(process)}: with at, give a function of its numbers")
        parameters, build = _numbers(at), process
        with at_once():
            process = build(parameters)
        check_process(process)
    model: Any = process
    if bounds is not None:
        limit = critical_gain(model, speed, bounds, method, scan=scan, progress=progress)
        return at_limit(limit, build, parameters, operator_of(method))
    limit = exact_limit(model, speed) if verb is None else verb(model, speed)
    if not isinstance(limit, Limit):
        raise ValueError(f"verb finds {_checks.brief(limit)}, and no Limit; give such as lobex.zero_order_limit")
    return at_limit(limit, build, parameters, _operator(limit))


def sensitivities_of(limit: Limit) -> Sensitivities:
    """The sensitivities of a limit to the numbers of its process, which is made again from its description.

    Raises:
        ValueError: for a limit whose process is not one of lobex's own, or was traced.
    """
    return at_limit(limit, _itself, rebuild(limit.process), _operator(limit))


def _operator(limit: Limit) -> Method | None:
    """Of the method that found a limit, None where that solved an equation without one."""
    return None if limit.method["type"] in (_CLOSED_FORM, MEAN, ALL) else operator_of(rebuild(limit.method))


def at_limit(limit: Limit, build: Builder, parameters: Any, method: Method | None) -> Sensitivities:
    """The sensitivities at limits already found: of the equations that found them, or of a method's operator."""
    found = np.flatnonzero(np.isfinite(limit.gain))
    names = (*number_names(parameters), "speed")
    speed, gain = limit.speed[found], np.asarray(limit.gain)[found]
    values = np.tile(np.r_[number_values(parameters), 0.0], (len(limit.speed), 1))
    values[:, -1] = limit.speed
    derivative = np.full((len(limit.speed), len(names)), np.nan)
    with at_once():
        wide = widened(parameters)
        if found.size and method is not None:
            wide = fine_enough(wide, speed, gain, tolerance_of(method))
        if found.size and limit.method["type"] in (MEAN, ALL):
            derivative[found] = of_teeth(limit, build, wide)
        elif found.size and method is None and any(map(is_measured, _leaves(build(wide)))):
            omega = 2 * np.pi * np.asarray(limit.chatter_frequency)[found]
            derivative[found] = in_batches(partial(_of_samples, build, wide), (speed, omega))
        elif found.size and method is None:
            derivative[found] = in_batches(partial(_closed_form, build, wide), (speed,))
        elif found.size:
            derivative[found] = in_batches(partial(_by_growth, build, wide, method), (speed, gain), _BATCH)
    return Sensitivities(names=names, value=values, derivative=derivative, limit=limit)


def _leaves(process: Any) -> list[Any]:
    return jax.tree.leaves(process, is_leaf=is_measured)


def _itself(process: Any) -> Any:
    return process


@compiled_for("build")
def _closed_form(
    build: Builder, parameters: Any, count: Int[Array, ""], speed: Float[AnyArray, " speeds"]
) -> Float[Array, "speeds parameters"]:
    def gain(parameters: Any, speed: Number) -> Float[Array, ""]:
        return exact_limit(build(parameters), speed).gain[0]

    by_all = jax.vmap(jax.grad(gain, argnums=(0, 1)), in_axes=(None, 0))
    return in_rows(by_all(parameters, speed))


@compiled_for("build")
def _of_samples(
    build: Builder,
    parameters: Any,
    count: Int[Array, ""],
    speed: Float[AnyArray, " speeds"],
    omega: Float[AnyArray, " speeds"],
) -> Float[Array, "speeds parameters"]:
    """Of a measurement, whose samples are many: without the search."""

    def gain(parameters: Any, speed: Float[Array, ""], omega: Float[Array, ""]) -> Float[AnyArray, ""]:
        found: Any = closed_form(build(parameters))
        return limit_followed(found, speed, omega)

    return in_rows(jax.vmap(jax.grad(gain, argnums=(0, 1)), in_axes=(None, 0, 0))(parameters, speed, omega))


@compiled_for("build")
def _by_growth(
    build: Builder,
    parameters: Any,
    method: Method,
    count: Int[Array, ""],
    speed: Float[AnyArray, " speeds"],
    gain: Float[AnyArray, " speeds"],
) -> Float[Array, "speeds parameters"]:
    def value(parameters: Any, speed: Number, gain: Number) -> Float[Array, ""]:
        return growth(build(parameters), method, speed, gain)

    def point(speed: Number, gain: Number) -> tuple[Any, Array, Array]:
        return jax.grad(value, argnums=(0, 1, 2))(parameters, speed, gain)

    *others, by_gain = over_few(point, together(len(speed), _TOGETHER), count, speed, gain)
    return -in_rows(others) / by_gain[:, None]


def _numbers(at: Any) -> dict[str, Any]:
    if not isinstance(at, Mapping) or not at:
        raise ValueError(f"at = {_checks.brief(at)} must be a dictionary of one or more numbers by name")
    for name, value in at.items():
        _checks.as_numbers(f"at[{name!r}]", value)
    return {name: np.asarray(value, dtype=np.float64) for name, value in at.items()}
