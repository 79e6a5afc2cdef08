"""``lobex wear``: wear map, spectrum and worn casing as a file, pictures and a summary."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.shell.arguments import parse_range
from lobex.shell.models import output_files, rod_modes_of
from lobex.shell.shares import shared
from lobex.shell.wear_arguments import DEFAULTS, LAWS, ContactFlags, Wear, WearFlags

if TYPE_CHECKING:
    from lobex.results.wear_map import WearMap


def run_wear(command: Wear) -> None:
    """Check everything, march, then write the file and its pictures."""
    flags = command.march
    speed = _speeds(flags)
    numbers = law_numbers(flags.contact)
    second = "-spectrum.png" if flags.ramp == 0 else "-history.png"
    files = output_files(flags, (".nc", ".png", "-casing.png", second))

    with shared(flags.storage) as share:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        from lobex.contact import laws
        from lobex.contact.casing import Casing
        from lobex.studies.wear import march_wear

        shape = flags.casing
        casing = Casing(
            shape.nodal_diameters,
            shape.amplitude,
            shape.clearance,
            shape.bump,
            shape.bump_width,
            shape.radius,
            shape.axial_width,
        )
        result = march_wear(
            rod_modes_of(flags.blade),
            casing,
            getattr(laws, flags.contact.law.capitalize())(**numbers),
            speed,
            flags.revolutions,
            flags.steps,
            **share.arguments,
            progress=not flags.output.quiet,
        )
    if not share.writes:
        return
    result.save(files[0])
    drawn = _draw(result, files[1:], steady=flags.ramp == 0)
    if not flags.output.quiet:
        print(f"{result!r}\n  written          {', '.join(map(str, [files[0], *drawn]))}")


def law_numbers(flags: ContactFlags) -> dict[str, float]:
    """The numbers of the chosen law; ValueError for those of another law, and for missing ones."""
    _checks.choice("law", flags.law, tuple(LAWS))
    own = LAWS[flags.law]
    given: dict[str, Any] = {name: value for name, value in vars(flags).items() if name != "law" and value is not None}
    for name, value in given.items():
        if name not in own:
            raise ValueError(f"{name} = {value} has no meaning with --law {flags.law}; drop it")
    numbers = {name: given.get(name, DEFAULTS.get(name)) for name in own}
    for name, value in numbers.items():
        if value is None:
            raise ValueError(f"{name} is missing; --law {flags.law} needs --{name.replace('_', '-')}")
    return {name: float(value) for name, value in numbers.items() if value is not None}


def _speeds(flags: WearFlags) -> np.ndarray:
    """Speeds (n,), or (n, revolutions) on a ramp, Hz."""
    speed = parse_range("speed", flags.speed, "Hz")
    _checks.positive("speed", speed, "Hz")
    turns = np.arange(_checks.integer("revolutions", flags.revolutions, 1))
    _checks.as_numbers("ramp", flags.ramp, "Hz per revolution")
    if flags.ramp == 0:
        return speed
    history = speed[:, None] + flags.ramp * turns
    if history.min() <= 0:
        raise ValueError(
            f"ramp = {flags.ramp:.6g} Hz takes the speed of {speed[0]:.6g} Hz to {history.min():.6g} Hz in "
            f"{flags.revolutions} revolutions; give a flatter ramp"
        )
    return history


def _draw(result: "WearMap", files: list[Path], steady: bool) -> list[Path]:
    """The pictures; a march whose every lane failed has none."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.axes import Axes

    if result.failed == len(result.speed):
        return []
    worst = float(result.speed[np.nanargmax(result.volume)])
    # The spectrum needs two revolutions.
    other = result.plot_history if not steady else (lambda: result.spectrum().plot())
    draw = [result.plot, lambda: result.plot_casing(worst)]
    if not steady or result.revolutions > 1:
        draw.append(other)
    for path, make in zip(files, draw, strict=False):
        drawn = make()
        figure: Any = drawn.figure if isinstance(drawn, Axes) else drawn
        figure.savefig(path, dpi=150)
        plt.close("all")
    return files[: len(draw)]
