"""What is odd about a grid of speeds, asked before any computing."""

import numpy as np

from lobex.characteristic.method import CharacteristicRoots
from lobex.operators.operator import Method
from lobex.processes.process import Process

# Above every lobe: the first one of a single mode ends at 1 pass per period of the mode.
_FAST = 5.0


def oddities(process: Process, method: Method | CharacteristicRoots, slowest: float, largest_gain: float) -> list[str]:
    """Messages about a sweep whose speeds are too slow for the method's samples, or above every lobe."""
    system = process.system(slowest, largest_gain)
    blocks = np.asarray(system.blocks)
    if not np.isfinite(blocks).all():
        return []
    turning = np.max(np.imag(np.linalg.eigvals(blocks)), axis=-1)
    turns = float(np.min(turning) * np.asarray(system.delay))
    allowed = method.resolved_radians(system)
    if turns > allowed:
        return [
            f"at speed = {slowest:.6g} Hz the first mode turns through {turns:.0f} rad per delay, more than the "
            f"{allowed:.0f} rad that {method} resolves; take more nodes or steps, or check that speeds are "
            "revolutions per second"
        ]
    if 0 < turns < 2 * np.pi / _FAST:
        return [
            f"every speed, from {slowest:.6g} Hz, passes more than {_FAST:.0f} times per period of the first mode, "
            "above every lobe; speeds are revolutions per second, which is rpm/60"
        ]
    return []
