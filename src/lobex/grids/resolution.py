"""Whether a method's samples can follow a grid of speeds, asked before any computing."""

import numpy as np

from lobex.characteristic.method import CharacteristicRoots
from lobex.operators.operator import Method
from lobex.processes.process import Process


def oddities(process: Process, method: Method | CharacteristicRoots, slowest: float, largest_gain: float) -> list[str]:
    """Messages about a sweep whose speeds are too slow for the method's samples."""
    system = process.system(slowest, largest_gain)
    blocks = np.asarray(system.blocks)
    if not np.isfinite(blocks).all():
        return []
    turning = np.max(np.imag(np.linalg.eigvals(blocks)), axis=-1)
    turns = float(np.min(turning) * np.asarray(system.period))
    allowed = method.resolved_radians(system)
    if turns > allowed:
        return [
            f"at speed = {slowest:.6g} Hz the first mode turns through {turns:.0f} rad per period, more than the "
            f"{allowed:.0f} rad that {method} resolves; take more nodes or steps, or check that speeds are "
            "revolutions per second"
        ]
    return []
