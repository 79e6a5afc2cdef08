"""``lobex wear``: wear map, spectrum and worn casing as a file, pictures and a summary."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.shell.from_flags import output_files
from lobex.shell.from_wear_flags import law_numbers, march_of
from lobex.shell.pictures import drawn
from lobex.shell.storage import stored, written
from lobex.shell.values import parse_axes, parse_grid
from lobex.shell.wear_arguments import Wear, WearFlags

if TYPE_CHECKING:
    from lobex.results.blading_wear import BladingWear
    from lobex.results.wear_map import WearMap


def run_wear(command: Wear) -> None:
    """Check everything, march, then write the file and its pictures."""
    flags = command.march
    speed = _speeds(flags)
    law_numbers(flags.contact)
    endings = [".png", "-casing.png"]
    if len(speed) > 1:
        endings.append("-spectrum.png" if flags.ramp == 0 else "-history.png")
    over = parse_axes(flags.axes.over)
    target, *files = output_files(flags, (".nc",) if over else (".nc", *endings))

    with stored(flags.storage) as storage:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        from lobex.studies.wear_marches import march_wear

        result: Any = march_wear(
            **march_of(flags),
            speed=speed,
            revolutions=flags.revolutions,
            steps_per_revolution=flags.steps,
            incursion=flags.incursion,
            **over,
            **storage,
            progress=not flags.output.quiet,
        )
    if over:
        return written(result, target, not flags.output.quiet)
    pictures = _pictures(result, endings)
    result.save(target)
    for ending, path in zip(endings, files, strict=True):
        if ending in pictures:
            path.write_bytes(pictures[ending])
    if not flags.output.quiet:
        there = [target, *(path for ending, path in zip(endings, files, strict=True) if ending in pictures)]
        print(f"{result!r}\n  written          {', '.join(map(str, there))}")


def _speeds(flags: WearFlags) -> np.ndarray:
    """Speeds (n,), or (n, revolutions) on a ramp, Hz."""
    speed = parse_grid("speed", flags.speed, "Hz")
    _checks.positive("speed", speed, "Hz")
    revolutions = _checks.integer("revolutions", flags.revolutions, 1)
    _checks.as_numbers("ramp", flags.ramp, "Hz per revolution")
    if flags.ramp == 0:
        return speed
    last = speed[0] + flags.ramp * (revolutions - 1)
    if last <= 0:
        raise ValueError(
            f"ramp = {flags.ramp:.6g} Hz takes the speed of {speed[0]:.6g} Hz to {last:.6g} Hz in "
            f"{revolutions} revolutions; give a flatter ramp"
        )
    return speed[:, None] + flags.ramp * np.arange(revolutions)


def _pictures(result: "WearMap | BladingWear", endings: list[str]) -> dict[str, bytes]:
    """The pictures by the endings of their files; a march whose every lane failed has none."""
    if result.failed == len(result.speed):
        return {}
    lane = int(np.nanargmax(result.volume))
    one = _loudest(result, lane)
    # One speed makes no map, and the spectrum needs two revolutions.
    plots = {
        ".png": one.plot_history if len(result.speed) == 1 else result.plot,
        "-casing.png": lambda: one.plot_casing(float(result.speed[lane])),
        "-history.png": one.plot_history,
    }
    if result.revolutions > 1:
        plots["-spectrum.png"] = lambda: one.spectrum().plot()
    return {ending: drawn(plots[ending]) for ending in endings if ending in plots}


def _loudest(result: "WearMap | BladingWear", lane: int) -> "WearMap":
    """The contact that moves most in a lane, of several."""
    from lobex.results.wear_map import WearMap

    return result if isinstance(result, WearMap) else result.of(int(np.argmax(result.peak[lane])))
