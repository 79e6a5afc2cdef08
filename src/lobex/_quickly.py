"""Programs that take longer to compile than to run: compiled quickly, and so to run a few times slower."""

from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

from lobex._checks import is_traced

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

# LLVM as it comes, loops written by the older of XLA's two generators, whose code is shorter, and each program in one
# part: a sixth of the time that the defaults take.
QUICK = {
    "xla_backend_optimization_level": 0,
    "xla_cpu_use_fusion_emitters": False,
    "xla_cpu_parallel_codegen_split_count": 1,
}


def compiled_quickly(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
    """``jax.jit`` of what is computed on few numbers, once or a few times: a whole structure, say, and not a grid.

    Within another program it is a part of that, and compiled as that is.
    """

    @cache
    def program(quick: bool) -> Any:
        import jax

        return jax.jit(function, compiler_options=_options() if quick else None)

    @wraps(function)
    def called(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        from jax.core import trace_ctx

        alone = trace_ctx.is_top_level() and not is_traced((args, kwargs))
        return program(alone)(*args, **kwargs)

    return called


@cache
def _options() -> dict[str, Any]:
    """Those that this XLA knows: with one that it does not it compiles nothing."""
    import jax

    def known(name: str) -> bool:
        with suppress(RuntimeError):
            jax.jit(lambda x: x, compiler_options={name: QUICK[name]}).lower(0.0).compile()
            return True
        return False

    return {name: value for name, value in QUICK.items() if known(name)}
