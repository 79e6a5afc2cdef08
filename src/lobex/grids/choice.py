"""Which method serves a process, and which operator stands in for one that has none."""

from typing import Any

from lobex import _checks
from lobex._pytree import pytree
from lobex.characteristic.method import CharacteristicRoots
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method, check_method
from lobex.processes.process import Process

# Estimated relative error of |μ| that is enough where nobody chose another.
TOLERANCE = 1e-8


@pytree()
class Auto:
    """The first of ``candidates`` that serves a process: no operator where there need be none, else the general one."""

    @property
    def candidates(self) -> tuple[CharacteristicRoots, Duhamel]:
        """``CharacteristicRoots()`` for constant coefficients and one delay; ``Duhamel()`` refuses nothing."""
        return CharacteristicRoots(), Duhamel()


AUTO = Auto()
AnyMethod = Method | CharacteristicRoots | Auto


def tolerance_of(method: Any) -> float:
    """The estimated relative error of |μ| above which a point is warned of, whatever computed it."""
    return getattr(method, "tolerance", TOLERANCE)


def check_any_method(method: Any) -> None:
    """Require ``Auto()``, ``CharacteristicRoots()``, or something that makes a monodromy operator."""
    if not isinstance(method, Auto | CharacteristicRoots):
        check_method(method)


def chosen_method(method: AnyMethod, process: Process, speed: float) -> Method | CharacteristicRoots:
    """The method itself, or that which ``Auto()`` takes for a process.

    Raises:
        ValueError: for a method that refuses the process, in its own words.
    """
    if isinstance(method, Auto):
        roots, general = method.candidates
        return general if roots.refuses(process, speed) else roots
    if isinstance(method, CharacteristicRoots) and (why := method.refuses(process, speed)):
        raise ValueError(f"CharacteristicRoots does not serve process = {_checks.brief(process)}, {why}")
    return method


def operator_of(method: AnyMethod) -> Method:
    """The method, or the operator for what needs one: derivatives, and points that the roots leave open."""
    return Duhamel() if isinstance(method, Auto | CharacteristicRoots) else method
