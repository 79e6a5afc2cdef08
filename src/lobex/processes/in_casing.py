"""The delay system of blades in a casing, which may give way."""

from dataclasses import replace
from typing import Any

from lobex._namespace import namespace
from lobex._shapes import Number
from lobex.structures.modes import Modes
from lobex.structures.ring_waves import PassingWaves
from lobex.systems.system import DelaySystem, modal_system
from lobex.systems.terms import Term


def system_in_casing(
    modes: Modes, casing: Modes | PassingWaves | None, period: Number, terms: tuple[Term, ...], **others: Any
) -> DelaySystem:
    """As ``modal_system``, with y how far the blades go beyond the casing: forces act on both, in opposite directions.

    The modes of the blades come first.
    """
    if casing is None:
        return modal_system(modes, period, terms, **others)
    if isinstance(casing, Modes):
        return modal_system(Modes.relative(tool=modes, workpiece=casing), period, terms, **others)
    system = modal_system(modes, period, terms, **others)
    lib = namespace(system, casing)
    blocks, inputs, outputs = casing.states()
    return replace(
        system,
        blocks=lib.concatenate([system.blocks, blocks]),
        inputs=lib.concatenate([system.inputs, -inputs]),
        outputs=lib.concatenate([system.outputs, -outputs]),
    )
