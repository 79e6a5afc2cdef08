"""What is known of a period of milling before tracing: where pieces end, and how far back delays reach."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from lobex import _checks
from lobex._float64 import at_once
from lobex._shapes import Number
from lobex.processes.cutter import Cutter
from lobex.processes.engagement import parts_of
from lobex.processes.serrated_cuts import bends_of, with_any_wave
from lobex.processes.teeth import Parts
from lobex.structures.modes_over_speed import ModesOverSpeed
from lobex.structures.rotating_modes import AnyModes
from lobex.systems.known_places import closed_by_angle, places_by_angle, places_that_matter
from lobex.systems.mesh import mesh_of
from lobex.systems.system import Places


class Layout(NamedTuple):
    """What is known of a period before tracing.

    Attributes:
        parts: of a straight tooth's, in the cut or idle.
        shortest, longest: delay, in periods, or less and more.
        places: where pieces end, as ``known_places.places_that_matter`` says.
        bends: of serrated teeth, places along a wave, see ``serrated_cuts.bends_of``.
        repeats, cycles: how often the teeth repeat, and in how many variations of the speed, until both come back.
    """

    parts: Parts | None = None
    shortest: float = 0.0
    longest: float = 1.0
    places: Places | None = None
    bends: int | None = None
    repeats: int = 1
    cycles: int = 1


UNKNOWN = Layout()
# Into so many parts an octave of delays is divided, so that cutters of much the same pitch share their programs.
_PARTS = 4
# Of a part: what is whole parts stays so.
_ROUNDING = 1e-6


def layout_of(process: Any, arc: float | None) -> Layout:
    """What is known of a milling process' period, with the arc of its cut, rad, where that is, but for its places."""
    alike, varied = process.cutter.alike, process.speed_variation
    plain = _straight(process.cutter) and not process.cutter.serrated
    layout = Layout(parts_of(arc, alike) if arc is not None and plain else None, bends=bends_of(process))
    if varied is not None:
        layout = layout._replace(**dict(zip(("repeats", "cycles"), varied.passes(alike), strict=True)))
    known = not _checks.is_traced(process.cutter.pitch) and process.cutter.one_helix
    bounds = (float(np.min(process.cutter.shares)), float(np.max(process.cutter.shares))) if known else (0.0, 1.0)
    if process.cutter.serrated:
        # What a tooth left may be met by itself.
        bounds = bounds[0], 1.0
    if varied is not None:
        bounds = tuple(bound / layout.repeats for bound in varied.delay_range(*bounds))
    return layout._replace(shortest=bounds[0], longest=bounds[1])


def in_octaves(layout: Layout) -> Layout:
    """The same with a range of delays that ends at whole parts of an octave, and is no narrower.

    Once its places are known, since to a longer delay one more of them would seem to be remembered.
    """
    shortest, longest = layout.shortest, layout.longest
    least = 2.0 ** (np.floor(_PARTS * np.log2(shortest) + _ROUNDING) / _PARTS) if shortest else 0.0
    most = 2.0 ** (np.ceil(_PARTS * np.log2(longest) - _ROUNDING) / _PARTS)
    return layout._replace(shortest=float(least), longest=float(most))


def places_of(process: Any) -> Places | None:
    """Where pieces of a milling process' period end, once its layout is known; None where every place may matter."""
    cutter, varied = process.cutter, process.speed_variation
    straight = _straight(cutter)
    known = not _checks.is_traced((cutter.pitch, process.tangential, process.normal, process.modes, varied))
    steady = varied is None and (not straight or cutter.alike == cutter.teeth) and not cutter.serrated
    # A measurement has no system, nor pieces.
    if not known or not cutter.one_helix or steady or hasattr(process.modes, "response"):
        return None
    with at_once():
        known_wave = with_any_wave(process) if cutter.serrated else process
        system = known_wave.system(_some_speed(process.modes), 1.0)
        # With a helix they move with the depth, unless they are tips alone.
        if straight or cutter.serrated:
            return places_that_matter(system)
        return places_by_angle(system, process.layout.repeats)


def layouts_by_depth(process: Any, depths: Float[np.ndarray, " p"]) -> Iterator[tuple[Layout, Bool[np.ndarray, " p"]]]:
    """Layouts of edges with a helix in which delays carry places to one another, each with the depths, m, that it is
    for: those at which the places are in one order, which they keep between two of them. Some depths may be in none.
    """
    cutter, left = process.cutter, np.ones(np.shape(depths), dtype=bool)
    moving = cutter.helix is not None and cutter.one_helix and process.speed_variation is None and not cutter.serrated
    if _checks.is_traced(process) or not moving:
        return
    speed = _some_speed(process.modes)
    while left.any():
        deepest = depths[left].max()
        with at_once():
            places = closed_by_angle(process.system(speed, deepest), process.layout.repeats)
            if places is None:
                # Of deeper cuts, whose edges are in more places.
                left &= depths < deepest / 2
                continue
            layout = process.layout._replace(places=places)
            laid, shallower = process.with_layout(layout), np.unique(depths[left])
            fits = [bool(np.isfinite(mesh_of(laid.system(speed, depth)).length).all()) for depth in shallower]
        served = left & (depths >= shallower[np.argmax(fits)])
        yield layout, served
        left &= ~served


def _straight(cutter: Cutter) -> bool:
    """Whether jumps stand where they are at any depth."""
    return cutter.helix is None and cutter.discs is None


def _some_speed(modes: AnyModes) -> Number:
    """A speed, Hz, at which there are modes."""
    return modes.speed[0] if isinstance(modes, ModesOverSpeed) else 1.0
