"""The terms of serrated teeth: of every tooth ahead that may have left what is met, with its delay."""

from collections.abc import Iterator
from copy import copy
from typing import Any

import numpy as np

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import Number
from lobex.processes.cutter import TURN
from lobex.processes.serrated_teeth import SerratedTeeth
from lobex.processes.serration import Serration
from lobex.processes.specific_force import CHIP
from lobex.processes.wave_cells import Lines, bends
from lobex.systems.coefficients import Following
from lobex.systems.delays import Share, WholePeriod
from lobex.systems.terms import Regenerative

# Of a pitch angle, by how much those of a cutter may differ that are the same.
_SAME = 1e-12
# So many places more or less share a program, and there is room for as many at least.
_MORE = 4


def serrated_cuts(process: Any, depth: Number) -> Iterator[Regenerative]:
    """What the serrated teeth of a period of milling meet, at a depth of cut, m."""
    cutter = process.cutter
    count, (entry, exit_) = cutter.teeth // cutter.alike, process.engagement
    shares: Any = cutter.shares
    lib = namespace(shares)
    before: Any = lib.cumsum(shares) - shares
    lines = lines_of(process)

    def force(teeth: slice, ahead: int) -> SerratedTeeth:
        return SerratedTeeth(
            depth=depth,
            tangential=process.tangential,
            normal=process.normal,
            axial=None,
            plunge=None,
            entry=entry,
            exit=exit_,
            before=before[teeth],
            teeth=cutter.alike,
            directions=process.modes.directions,
            law=CHIP,
            wave_length=cutter.serration.wave_length,
            twist=cutter.twist,
            lines=lines.of(teeth),
            ahead=ahead,
            bends=process.layout.bends,
        )

    every = slice(None)
    # The first says where all of them bend.
    yield Regenerative(force(every, count), WholePeriod())
    even = not _checks.is_traced(shares) and np.ptp(shares) < _SAME
    for ahead in range(1, count):
        if even:
            yield Regenerative(Following(force(every, ahead)), Share(ahead / count))
            continue
        since: Any = sum(lib.roll(shares, -other) for other in range(ahead))
        for tooth in range(count):
            yield Regenerative(Following(force(slice(tooth, tooth + 1), ahead)), Share(since[tooth]))


def bends_of(process: Any) -> int | None:
    """At how many places along a wave integrals bend at most, or a few more; None where that is not known."""
    if not process.cutter.serrated or _checks.is_traced((process.cutter, process.feed_per_tooth, process.engagement)):
        return None
    entry, exit_ = process.engagement
    places = np.asarray(bends(lines_of(process), (np.sin(entry), np.sin(exit_), 1.0)))
    most = int(np.max(np.sum(places > 0, axis=1)))
    return min(_MORE * (most // _MORE + 2), places.shape[1])


def with_any_wave(process: Any) -> Any:
    """The same with other waves, feed and helix, by which tips enter nowhere else; edges of a helix that is so steep
    are in the cut at all angles.
    """
    made, cutter = copy(process), copy(process.cutter)
    object.__setattr__(cutter, "serration", Serration(0.0, 1.0))
    if cutter.helix is not None:
        object.__setattr__(cutter, "helix", 1.0)
        object.__setattr__(cutter, "diameter", 1e-3)
    object.__setattr__(made, "cutter", cutter)
    object.__setattr__(made, "feed_per_tooth", 1.0)
    return made


def lines_of(process: Any) -> Lines:
    """What each tooth of a period may meet, of a process with serrated teeth and a feed."""
    cutter = process.cutter
    count = cutter.teeth // cutter.alike
    lib = namespace(cutter, process.feed_per_tooth)
    pitch = cutter.pattern
    # Each tooth takes its share of the feed, and so do those that it passes over.
    feed = [lib.zeros(count), *(lib.roll(pitch, -ahead) for ahead in range(count))]
    feed = lib.cumsum(lib.stack(feed, axis=1), axis=1) * (cutter.teeth * process.feed_per_tooth / TURN)
    wave = cutter.serration.of_teeth(cutter.teeth)
    out = lib.zeros(cutter.teeth) if cutter.runout is None else lib.asarray(cutter.runout)

    def apart(radius: Any) -> Any:
        """What each has above those 1, 2, … ahead; above none there is nothing to take off."""
        ahead = [(radius - lib.roll(radius, -other))[:count] for other in range(1, count + 1)]
        return lib.stack([lib.zeros(count), *ahead], axis=1)

    return Lines(feed, apart(out), apart(lib.real(wave)), -apart(lib.imag(wave)))


def check_serrated(process: Any) -> None:
    """Require of a milling process what a serrated cutter asks for, and nothing that it does not take.

    Raises:
        ValueError: without a feed, and for process damping, a speed that varies, and forces along the axis or of edges.
    """
    if process.cutter.serration is None:
        return
    if process.feed_per_tooth is None:
        raise ValueError(
            "feed_per_tooth = None with a serrated cutter, whose teeth meet one another by it; give it in m"
        )
    others = {
        "process_damping": process.process_damping,
        "speed_variation": process.speed_variation,
        "axial": process.axial,
        "edge": process.edge,
    }
    for name, value in others.items():
        if value is not None:
            raise ValueError(f"{name} = {_checks.brief(value)} with a serrated cutter; leave it out")
    if process.modes.directions > 2:
        raise ValueError("modes has 3 contact directions with a serrated cutter; give 1 or 2")
