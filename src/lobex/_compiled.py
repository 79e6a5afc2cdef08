"""``jax.jit`` with what XLA is told of each program: how long it is to be optimised."""

import os
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from typing import Any, TypeVar

from lobex._checks import is_traced

Result = TypeVar("Result")

# Loops written by the older of XLA's two generators, whose code is shorter, and few of LLVM's passes: half of the time
# that the defaults take. Programs of products of small matrices run as fast, or faster.
SHORT = {"xla_backend_optimization_level": 1, "xla_cpu_use_fusion_emitters": False}
# LLVM as it comes, and each program in one part: a sixth of that time, for code that is two or three times slower.
QUICK = {
    "xla_backend_optimization_level": 0,
    "xla_cpu_use_fusion_emitters": False,
    "xla_cpu_parallel_codegen_split_count": 1,
}


def compiled(function: Callable[..., Result]) -> Callable[..., Result]:
    """``jax.jit`` of what is computed on batches of points.

    Within another program it is a part of that, and compiled as that is.
    """
    return _told(function, SHORT)


def compiled_for(*static: str) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """As ``compiled``, once for each value of the arguments of these names."""
    return lambda function: _told(function, SHORT, static_argnames=static)


def compiled_quickly(function: Callable[..., Result]) -> Callable[..., Result]:
    """As ``compiled``, what is computed on few numbers, once or a few times: a whole structure, say, and not a grid."""
    return _told(function, QUICK)


def compiled_quickly_for(*static: str) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """As ``compiled_quickly``, once for each value of the arguments of these names."""
    return lambda function: _told(function, QUICK, static_argnames=static)


def either_way(function: Callable[..., Result], *static: str) -> dict[bool, Callable[..., Result]]:
    """As ``compiled_for``, False, and as ``compiled_quickly``, True, of what is computed on many numbers or on few."""
    return {quick: _told(function, QUICK if quick else SHORT, static_argnames=static) for quick in (False, True)}


def _told(function: Callable[..., Result], options: dict[str, Any], **static: Any) -> Callable[..., Result]:
    @cache
    def program(alone: bool) -> Any:
        import jax

        return jax.jit(function, compiler_options=known(options) if alone else None, **static)

    @wraps(function)
    def called(*args: Any, **kwargs: Any) -> Result:
        from jax.core import trace_ctx

        alone = trace_ctx.is_top_level() and not is_traced((args, kwargs))
        return program(alone)(*args, **kwargs)

    return called


def known(options: dict[str, Any]) -> dict[str, Any]:
    """Those that this XLA knows, since with one that it does not it compiles nothing, and that ``XLA_FLAGS`` leaves
    open; none but on a processor, where they were measured.
    """
    import jax

    if jax.default_backend() != "cpu":
        return {}
    told = os.environ.get("XLA_FLAGS", "")
    left = {name: value for name, value in options.items() if name not in told}
    if _are_known(*left.items()):
        return left
    return {name: value for name, value in left.items() if _are_known((name, value))}


@cache
def _are_known(*options: tuple[str, Any]) -> bool:
    import jax

    with suppress(RuntimeError):
        jax.jit(lambda x: x, compiler_options=dict(options)).lower(0.0).compile()
        return True
    return False
