"""A verb that takes further axes, a store and an executor, made of the plain one and of what tells its chunks."""

import inspect
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, TypeVar, cast, overload, runtime_checkable

from lobex.studies.task import Over, Task

if TYPE_CHECKING:
    from lobex.studies.study import Study

P = ParamSpec("P")
R = TypeVar("R", covariant=True)
_RUN = ("over", "store", "executor")


@runtime_checkable
class Verb(Protocol[P, R]):
    """Returns a ``Study`` with ``over``, and what the plain verb returns without."""

    @overload
    def __call__(self, *arguments: Any, over: Over, **others: Any) -> "Study": ...
    @overload
    def __call__(self, *arguments: P.args, **others: P.kwargs) -> R: ...


def studied(plain: Callable[..., R]) -> Callable[[Callable[P, Task]], Verb[P, R]]:
    """The verb of the signature and docstring of what it decorates, which is asked for the chunks of a study.

    Args:
        plain: what computes where neither further axes nor a store nor an executor are given, of the same arguments
            but for these.
    """

    def made(task_of: Callable[P, Task]) -> Verb[P, R]:
        signature = inspect.signature(task_of)

        @wraps(task_of)
        def verb(*arguments: P.args, **others: P.kwargs) -> Any:
            given = signature.bind(*arguments, **others)
            given.apply_defaults()
            over, store, executor = (given.arguments[name] for name in _RUN)
            if over is None and store is None and executor is None:
                return plain(**{name: value for name, value in given.arguments.items() if name not in _RUN})
            from lobex.studies.run import run_study

            return run_study(
                task_of(*arguments, **others), store, executor, given.arguments["progress"], over is not None
            )

        returned = inspect.signature(plain).return_annotation
        verb.__dict__["__signature__"] = signature.replace(return_annotation=returned)
        return cast(Verb[P, R], verb)

    return made
