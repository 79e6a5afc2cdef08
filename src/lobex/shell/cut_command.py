"""``lobex orbit`` and ``lobex recommend``: the motion of a milling cut, and which cut to take."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from lobex import _checks
from lobex._lengths import metres
from lobex.shell.cut_arguments import Orbit, OrbitMilling, Recommend, RecommendMilling
from lobex.shell.from_flags import gain_text, output_files, process_of
from lobex.shell.pictures import drawn
from lobex.shell.values import in_metres, parse_values

_MOST_POINTS = 6


def run_orbit(command: Orbit) -> None:
    """Check everything, find the motion, then write PATH.nc and PATH.png."""
    flags = command.process
    speed, gain = parse_values("rpm", flags.rpm, "rpm"), parse_values("gain", gain_text(flags), "m")
    _checks.positive("rpm", speed, "rpm")
    if speed.size * gain.size > _MOST_POINTS:
        raise ValueError(
            f"rpm and gain make {speed.size * gain.size} points; give at most {_MOST_POINTS}, which one picture holds"
        )
    feed, files = metres("feed", flags.feed), output_files(flags, (".nc", ".png"))
    lobex = _prepared()
    points = np.repeat(speed / 60, gain.size), np.tile(gain, speed.size)
    _written(lobex.orbit(_fed(flags, feed), *points), files, flags.output.quiet)


def run_recommend(command: Recommend) -> None:
    """Check everything, seek the cuts, then write PATH.nc and PATH.png."""
    flags = command.process
    speed, depth = _ends("rpm", flags.rpm), _ends("gain", flags.gain, in_metres)
    feed, files = metres("feed", flags.feed), output_files(flags, (".nc", ".png"))
    wall = None if flags.location_error is None else metres("location_error", flags.location_error)
    lobex = _prepared()
    limits = {"power": flags.power, "torque": flags.torque, "location_error": wall}
    others = {"margin": flags.margin, "count": flags.count}
    _written(lobex.recommend(_fed(flags, feed), speed / 60, depth, **limits, **others), files, flags.output.quiet)


def _prepared() -> Any:
    # JAX is slow to import: only once all flags are read.
    from lobex.shell.environment import prepare_jax

    prepare_jax()
    import lobex

    return lobex


def _fed(flags: OrbitMilling | RecommendMilling, feed: float) -> Any:
    return replace(process_of(flags), feed_per_tooth=feed)


def _ends(name: str, text: str, plain: Callable[[str, str], str] | None = None) -> np.ndarray:
    """The two ends of a range, whose text something else may make plain."""
    try:
        low, high = map(float, (text if plain is None else plain(name, text)).split(":"))
    except ValueError:
        raise ValueError(f"{name} = {_checks.brief(text)} is not low:high; give such as 3000:12000") from None
    return np.array([low, high])


def _written(result: Any, files: list[Any], quiet: bool) -> None:
    picture = drawn(result.plot)
    result.save(files[0])
    files[1].write_bytes(picture)
    if not quiet:
        print(f"{result!r}\n  written          {files[0]}, {files[1]}")
