"""The teeth of a period of milling, each with its force, its delay, and what pushes it whatever the motion."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from lobex import _checks
from lobex._missing import without_derivative
from lobex._namespace import namespace
from lobex._shapes import Number
from lobex.processes.cutter import TURN
from lobex.processes.disc_teeth import DiscTeeth
from lobex.processes.edge_points import EdgeDelay, EdgePoint, edge_points
from lobex.processes.engagement import angles_to_wall
from lobex.processes.orbiting import OrbitingAxis
from lobex.processes.profiled_teeth import ProfiledTeeth
from lobex.processes.specific_force import CHIP, EDGE, STEP
from lobex.processes.teeth import HelicalTeeth, StraightTeeth, in_one_piece
from lobex.systems.coefficients import Following, Framed
from lobex.systems.delays import Share, WholePeriod
from lobex.systems.terms import Forcing, Regenerative, Term

Edges = StraightTeeth | HelicalTeeth | ProfiledTeeth | DiscTeeth


class Tooth(NamedTuple):
    """What a tooth of the period does.

    Attributes:
        force: of its edge.
        step: what its radius has above that of the tooth ahead, m; None without runout.
        share: its pitch angle, in periods; None where that is the period.
        points: of an edge along which the delay changes, each with its own.
    """

    force: Edges
    step: Number | None
    share: Number | None = None
    points: tuple[tuple[EdgePoint, EdgeDelay], ...] = ()

    def cuts(self) -> list[Term]:
        """What it meets."""
        if self.points:
            # The points of an edge enter and leave together.
            (first, since), *others = self.points
            rest: list[Term] = [Regenerative(Following(point), delay) for point, delay in others]
            return [Regenerative(first, since), *rest]
        return [Regenerative(self.force, WholePeriod() if self.share is None else Share(self.share))]

    def steps(self) -> list[Term]:
        """What its step gives to cut."""
        return [] if self.step is None else [_step_force(self.force, self.step)]


def teeth_of(process: Any, depth: Number) -> Iterator[Tooth]:
    """The teeth of a period of milling, at a depth of cut, m."""
    cutter, layout = process.cutter, process.layout
    entry, exit_ = process.engagement
    if cutter.discs is not None and process.angles is None:
        standing_off = cutter.diameter * (0.5 - process.radial_immersion)
        entry, exit_ = angles_to_wall(standing_off, cutter.discs[:, 3], process.direction)
    if in_one_piece(layout.parts) and _checks.is_traced((process.radial_immersion, process.angles)):
        # What follows would make a wrong one of it.
        given = process.radial_immersion if process.angles is None else jnp.sum(process.angles)
        entry = without_derivative(jnp.asarray(entry, dtype=jnp.result_type(float)), given)

    def force(before: Number | None, twist: Number | None) -> Edges:
        numbers = depth, process.tangential, process.normal, process.axial, None, entry, exit_, before
        sizes = cutter.alike, process.modes.directions, CHIP
        if cutter.discs is not None:
            return DiscTeeth(*numbers, *sizes, cutter.discs)
        if cutter.shaped:
            lead = np.pi / 2 if cutter.lead is None else cutter.lead
            return ProfiledTeeth(*numbers, *sizes, cutter.corner_radius, lead, twist, layout.parts)
        return StraightTeeth(*numbers, *sizes, layout.parts) if twist is None else HelicalTeeth(*numbers, *sizes, twist)

    count = process.teeth // cutter.alike
    twist: Any = cutter.twist
    steps = [None] * count if cutter.runout is None else cutter.steps
    if count == 1:
        yield Tooth(force(None, twist if cutter.one_helix else twist[0]), steps[0])
        return
    shares = cutter.shares
    before = namespace(shares).cumsum(shares) - shares
    for number, (share, step) in enumerate(zip(shares, steps, strict=True)):
        if cutter.one_helix:
            yield Tooth(force(before[number], twist), step, share)
            continue
        edge: Any = force(before[number], twist[number])
        narrowing = twist[(number + 1) % count] - twist[number]
        yield Tooth(edge, step, share, tuple(edge_points(edge, TURN * share, narrowing, process.points)))


def standing(process: Any, teeth: list[Tooth]) -> list[Forcing]:
    """What pushes whatever the feed: an axis of the teeth that is off, and edges."""
    pushed: list[Any] = []
    if process.cutter.offset is not None:
        angle = 0.0 if process.cutter.offset_angle is None else process.cutter.offset_angle
        share = 1 / process.teeth
        pushed += [
            OrbitingAxis(tooth.force, process.cutter.offset, angle, share if tooth.share is None else tooth.share)
            for tooth in teeth
        ]
    if process.edge is not None:
        names = dict(zip(("tangential", "normal", "axial"), process.edge, strict=True))
        edges = [replace(tooth.force, law=EDGE, **names) for tooth in teeth]
        unit = np.eye(process.modes.directions)
        pushed += [Framed(-unit, one, np.ones((1, 1))) for one in edges]
    return [Forcing(Following(one)) for one in pushed]


def _step_force(teeth: Edges, step: Number) -> Forcing:
    """−b Σ (K_t t + K_n n) step, of a chip that is thicker by a step."""
    pushed: Any = Framed(-np.eye(teeth.directions), Following(replace(teeth, law=STEP)), step * np.ones((1, 1)))
    return Forcing(pushed)
