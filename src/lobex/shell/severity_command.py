"""``lobex severity``: how bad marches get over speed and penetration, with the lobes over it, as files and picture."""

from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.shell.from_flags import output_files
from lobex.shell.from_wear_flags import law_numbers, march_of
from lobex.shell.pictures import drawn
from lobex.shell.severity_arguments import Severity, SeverityFlags
from lobex.shell.storage import stored
from lobex.shell.values import parse_grid

if TYPE_CHECKING:
    from lobex.results.limit import Limit

# Speeds of the prediction in closed form; and the range of gains, as shares of the contact's stiffness, of a search.
_FINE, _SCAN, _LOWEST = 401, 33, 1e-3
_MOST_LOBES = 100_000
_QUANTITIES = ("amplitude", "wear")


def run_severity(command: Severity) -> None:
    """Check everything, march over speed and penetration, find the limit, then write files and picture."""
    flags = command.march
    speed, penetration = parse_grid("speed", flags.speed, "Hz"), parse_grid("penetration", flags.penetration, "m")
    for name, values, unit in (("speed", speed, "Hz"), ("penetration", penetration, "m")):
        _checks.positive(name, values, unit)
        if len(values) < 2:
            raise ValueError(f"{name} = {getattr(flags, name)!r} is one value; a map takes two or more")
    _checks.choice("of", flags.of, _QUANTITIES)
    if flags.lobes is not None:
        _checks.integer("lobes", flags.lobes, 0, _MOST_LOBES)
    law_numbers(flags.contact)
    files = output_files(flags, (".nc", "-limit.nc", ".png"))

    with stored(flags.storage) as storage:
        # JAX is slow to import: only now.
        from lobex.shell.environment import prepare_jax

        prepare_jax()
        import lobex

        model, shown = march_of(flags), not flags.output.quiet
        if isinstance(model["casing"], list):
            raise ValueError(f"blade = {flags.blade_file!r} has several [[casing]]; a map takes one for all tracks")
        study = lobex.march_wear(
            **model,
            speed=speed,
            revolutions=flags.revolutions,
            steps_per_revolution=flags.steps,
            over={"casing.amplitude": penetration + float(model["casing"].clearance)},
            **storage,
            progress=shown,
        )
    stiffness = _stiffness(model["law"])
    limit = None if stiffness is None or flags.lobes == 0 else _limit(model, speed, stiffness, flags)
    picture = drawn(lambda: lobex.severity(study, limit, None if limit is None else stiffness, of=flags.of))
    study.save(files[0])
    if limit is not None:
        limit.save(files[1])
    files[2].write_bytes(picture)
    if shown:
        written = [path for path in files if limit is not None or path != files[1]]
        print(f"{study!r}\n{_foretold(limit, stiffness)}\n  written          {', '.join(map(str, written))}")


def _stiffness(law: Any) -> float | None:
    """That of a contact as it begins, N/m; None of laws, or several of them, that have none to hold a limit against."""
    from lobex.contact.laws import Bilinear, Cubic, KelvinVoigt, Linear

    if isinstance(law, list):
        found = {_stiffness(one) for one in law}
        return found.pop() if len(found) == 1 else None
    if isinstance(law, Cubic):
        return float(law.width * law.first) or None
    return float(law.stiffness) or None if isinstance(law, Linear | Bilinear | KelvinVoigt) else None


def _limit(model: dict[str, Any], speed: np.ndarray, stiffness: float, flags: SeverityFlags) -> "Limit":
    """The limit in closed form or, where there is none, up to the contact's stiffness by an operator."""
    import lobex

    process = lobex.Rub(model["modes"], casing=model["casing"].structure)
    fine = np.linspace(speed[0], speed[-1], _FINE if flags.lobes is None else max(flags.lobes, 2))
    try:
        return lobex.exact_limit(process, fine)
    except ValueError as error:
        if "has no exact limit" not in str(error):
            raise
    wanted = speed if flags.lobes is None else fine
    bounds = _LOWEST * stiffness, stiffness
    return lobex.critical_gain(process, wanted, bounds, scan=_SCAN, progress=not flags.output.quiet)


def _foretold(limit: "Limit | None", stiffness: float | None) -> str:
    if limit is None:
        why = (
            "not asked for" if stiffness is not None else "none: the law has no stiffness that a limit is held against"
        )
        return f"  lobes foretell   {why}"
    unstable = int(np.sum(np.asarray(limit.gain) < stiffness))
    return f"  lobes foretell   chatter at {unstable} of {len(limit.speed)} speeds with K = {stiffness:.4g} N/m"
