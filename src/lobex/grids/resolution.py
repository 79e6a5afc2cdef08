"""Whether a method's samples can follow a grid of speeds, asked before any computing."""

import numpy as np

from lobex.characteristic.method import CharacteristicRoots
from lobex.operators.operator import Method
from lobex.processes.declared import largest_force
from lobex.processes.process import Process
from lobex.systems.system import DelaySystem

# Beyond, rounding of an angle is no longer small beside a turn.
_MOST_RADIANS = 1e14


def oddities(process: Process, method: Method | CharacteristicRoots, slowest: float, largest_gain: float) -> list[str]:
    """Messages about a sweep whose speeds are too slow for the method's samples.

    Raises:
        ValueError: where a model moves so fast that double precision knows nothing of its motion over a delay.
    """
    system = process.system(slowest, largest_gain)
    blocks = np.asarray(system.blocks)
    if not np.isfinite(blocks).all():
        return []
    radians = _fastest(system, largest_force(process, slowest, largest_gain)) * float(np.asarray(system.period))
    if radians > _MOST_RADIANS:
        raise ValueError(
            f"speed = {slowest:.6g} Hz: up to gain = {largest_gain:.6g} the model moves through {radians:.3g} rad per "
            f"period, and double precision follows {_MOST_RADIANS:g} at most; check the units of speed, gain and modes"
        )
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


def _fastest(system: DelaySystem, force: float) -> float:
    """What no rate of motion is far above, rad/s: the structure's fastest, stiffened by the largest force."""
    blocks, inputs, outputs = (np.asarray(part) for part in (system.blocks, system.inputs, system.outputs))
    seen = np.concatenate([outputs, np.asarray(system.recalled)], axis=1)
    at_once, by_inertia = (float(np.sum(np.abs(seen @ part))) for part in (inputs, blocks @ inputs))
    return float(np.max(np.abs(np.linalg.eigvals(blocks)))) + force * at_once + np.sqrt(force * by_inertia)
