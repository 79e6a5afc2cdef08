"""``lobex wear``: wear map, spectrum and worn casing as a file, pictures and a summary."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lobex import _checks
from lobex.shell.from_flags import output_files, rod_modes_of
from lobex.shell.pictures import drawn
from lobex.shell.shares import shared
from lobex.shell.values import parse_grid
from lobex.shell.wear_arguments import DEFAULTS, LAWS, ContactFlags, Wear, WearFlags

if TYPE_CHECKING:
    from lobex.results.wear_map import WearMap


def run_wear(command: Wear) -> None:
    """Check everything, march, then write the file and its pictures."""
    flags = command.march
    speed = _speeds(flags)
    numbers = law_numbers(flags.contact)
    endings = [".png", "-casing.png"]
    if len(speed) > 1:
        endings.append("-spectrum.png" if flags.ramp == 0 else "-history.png")
    stored, *files = output_files(flags, (".nc", *endings))

    with shared(flags.storage) as share:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        from lobex.contact import laws
        from lobex.contact.casing import Casing
        from lobex.studies.wear_marches import march_wear

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
        march = march_wear(
            rod_modes_of(flags.blade),
            casing,
            getattr(laws, flags.contact.law.title().replace("-", ""))(**numbers),
            speed,
            flags.revolutions,
            flags.steps,
            **share.arguments,
            progress=not flags.output.quiet,
        )
    if not share.writes:
        return
    # Of one contact.
    result = cast("WearMap", march)
    pictures = _pictures(result, endings)
    result.save(stored)
    for ending, path in zip(endings, files, strict=True):
        if ending in pictures:
            path.write_bytes(pictures[ending])
    if not flags.output.quiet:
        written = [stored, *(path for ending, path in zip(endings, files, strict=True) if ending in pictures)]
        print(f"{result!r}\n  written          {', '.join(map(str, written))}")


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


def _pictures(result: "WearMap", endings: list[str]) -> dict[str, bytes]:
    """The pictures by the endings of their files; a march whose every lane failed has none."""
    if result.failed == len(result.speed):
        return {}
    worst = float(result.speed[np.nanargmax(result.volume)])
    # One speed makes no map, and the spectrum needs two revolutions.
    plots = {
        ".png": result.plot_history if len(result.speed) == 1 else result.plot,
        "-casing.png": lambda: result.plot_casing(worst),
        "-history.png": result.plot_history,
    }
    if result.revolutions > 1:
        plots["-spectrum.png"] = lambda: result.spectrum().plot()
    return {ending: drawn(plots[ending]) for ending in endings if ending in plots}
