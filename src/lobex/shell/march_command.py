"""``lobex march``: motions in time as a file, a picture and a summary beside the prediction."""

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.processes.quantity import quantity_of
from lobex.results.units import shown_gain, shown_speed
from lobex.shell.from_flags import output_files, process_of, speeds_and_gains
from lobex.shell.march_arguments import MOST_LANES, March, MarchFlags, MarchRub, MarchTurning
from lobex.shell.pictures import drawn
from lobex.shell.values import parse_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def run_march(command: March) -> None:
    """Check everything, march, then write PATH.nc and PATH.png."""
    flags = command.process
    speed, gain = _points(flags)
    _checks.integer("periods", flags.periods, 1)
    _checks.integer("steps", flags.steps, 3)
    _checks.as_numbers("start", flags.start)
    files = output_files(flags, (".nc", ".png"))

    # JAX is slow to import: only now.
    from lobex.shell.environment import prepare_jax

    prepare_jax()
    import lobex

    process = process_of(flags)
    result, growth = _run(flags, process, speed, gain)
    picture = drawn(partial(_figure, result))
    result.save(files[0])
    files[1].write_bytes(picture)
    if not flags.output.quiet:
        predicted = np.asarray(lobex.spectral_radius(process, speed, gain))
        rows = _comparison(process, speed, gain, growth, predicted)
        print("\n".join([repr(result), *rows, f"  written          {files[0]}, {files[1]}"]))


def _points(flags: MarchFlags) -> tuple[np.ndarray, np.ndarray]:
    """Every speed (Hz) with every gain, both (lanes,)."""
    speed, gain = speeds_and_gains(flags, parse_values)
    if speed.size * gain.size > MOST_LANES:
        raise ValueError(
            f"speed and gain make {speed.size * gain.size} points; give at most {MOST_LANES}, which one picture holds"
        )
    return np.repeat(speed, gain.size), np.tile(gain, speed.size)


def _run(flags: MarchFlags, process: Any, speed: np.ndarray, gain: np.ndarray) -> tuple[Any, np.ndarray | None]:
    """The result, and its growth per period where it has one."""
    if isinstance(flags, MarchTurning) and flags.feed is not None:
        from lobex._lengths import metres
        from lobex.contact.laws import Linear
        from lobex.marches.turning import simulate_turning

        for name in ("process_damping", "speed_variation"):
            if getattr(process, name) is not None:
                raise ValueError(f"feed = {flags.feed!r} with a {name} of the tool's file; drop one of the two")
        law, feed = Linear(process.radial), metres("feed", flags.feed)
        return simulate_turning(process.modes, law, speed, gain, feed, flags.periods, flags.steps), None
    from lobex.marches.delay import march_delay

    history, state = _start(flags, process, speed)
    march = march_delay(process, speed, gain, history, flags.periods, flags.steps, state=state)
    return march, march.growth


def _start(flags: MarchFlags, process: Any, speed: np.ndarray) -> tuple[Any, Any]:
    """History and state: §4.4's for the rod, and a deflection until t = 0 for the others."""
    if isinstance(flags, MarchRub) and flags.blade_file is None:
        import lobex
        from lobex.marches.start import growing_history

        rod = lobex.Rod(flags.elements, flags.young_modulus, flags.density, flags.length, flags.area)
        return growing_history(rod, speed, tip=flags.start, keep=flags.keep or None)
    outputs = process.modes.directions if hasattr(process, "modes") else 1
    return lambda time: np.full((*time.shape, outputs), flags.start), None


def _comparison(
    process: Any, speed: np.ndarray, gain: np.ndarray, growth: np.ndarray | None, predicted: np.ndarray
) -> list[str]:
    """One line per lane: what was found beside what the monodromy operator says."""
    rows = []
    for lane, radius in enumerate(predicted):
        found = "" if growth is None else f"growth {growth[lane]:.6f} per period, "
        size = shown_gain(gain[lane], quantity_of(process))
        point = f"{shown_speed(speed[lane], process.speed_unit)}, {process.gain.symbol} = {size}"
        rows.append(f"  at {point}: {found}predicted max|μ| {radius:.6f}, {'unstable' if radius > 1 else 'stable'}")
    return rows


def _figure(result: Any) -> "Figure":
    import matplotlib.pyplot as plt

    if hasattr(result, "chip_thickness"):
        from lobex.plots.cut_picture import plot_histories

        return plot_histories(result)
    figure, axes = plt.subplots(figsize=(7.0, 4.0), layout="constrained")
    result.plot(axes)
    return figure
