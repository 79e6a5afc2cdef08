"""Which method serves a process, and which operator stands in for one that has none."""

from typing import Any

from lobex.characteristic.method import CharacteristicRoots, suits
from lobex.operators.duhamel import Duhamel
from lobex.operators.operator import Method, check_method
from lobex.processes.process import Process

# Estimated relative error of |μ| that is enough where nobody chose another.
TOLERANCE = 1e-8


def tolerance_of(method: Any) -> float:
    """The estimated relative error of |μ| above which a point is warned of, whatever computed it."""
    return getattr(method, "tolerance", TOLERANCE)


def check_sweep_method(method: Any) -> None:
    """Require None, ``CharacteristicRoots()``, or something that makes a monodromy operator."""
    if method is not None and not isinstance(method, CharacteristicRoots):
        check_method(method)


def chosen_method(process: Process, speed: float) -> CharacteristicRoots | Duhamel:
    """Characteristic roots where coefficients are constant, which takes no discretisation; else the operator."""
    return CharacteristicRoots() if suits(process, speed) else Duhamel()


def operator_of(method: Method | CharacteristicRoots | None) -> Method:
    """The method, or the operator for what needs one: derivatives, and points that the roots leave open."""
    return Duhamel() if method is None or isinstance(method, CharacteristicRoots) else method
