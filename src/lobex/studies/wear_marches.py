"""``march_wear``, with further axes and a store: each chunk is a march of its own."""

from typing import TYPE_CHECKING, Any, overload

import numpy as np

from lobex import _checks
from lobex.contact.casing import Casing
from lobex.contact.laws import ContactLaw
from lobex.marches import wear
from lobex.processes.plausible import implausible
from lobex.processes.regenerative import Rub
from lobex.results.wear_map import WearMap
from lobex.structures.modes import Modes
from lobex.studies.task import COPIES, Numbers, Over, Path, Share, Task
from lobex.studies.variation import Variation, axes_of

if TYPE_CHECKING:
    from lobex.studies.study import Study

# Lanes of a chunk, and time steps of all of them together: some seconds on two cores.
_LANES, _STEPS = 768, 2**26


@overload
def march_wear(
    modes: Modes,
    casing: Casing,
    law: ContactLaw,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    store: Path | None = None,
    processes: Share | None = None,
    progress: bool = False,
) -> WearMap: ...
@overload
def march_wear(
    modes: Modes | Numbers,
    casing: Casing | Numbers,
    law: ContactLaw | Numbers,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    over: Over,
    store: Path | None = None,
    processes: Share | None = None,
    progress: bool = False,
) -> "Study": ...
def march_wear(
    modes: Any,
    casing: Any,
    law: Any,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    over: Over | None = None,
    store: Path | None = None,
    processes: Share | None = None,
    progress: bool = False,
) -> "WearMap | Study":
    """March a rubbing blade over some revolutions at every speed, wearing the casing: chapter 1.

    Central differences, (1.16)-(1.17), in modal form, one casing cell per step. The reaction −F of the law acts on
    the tip. The blade starts at rest at θ = 0. All arithmetic is float64.

    Args:
        modes: the blade's modes, with one contact direction.
        casing: its profile before wear.
        law: the contact law, such as ``Linear(4.5e6)``.
        speed: rotational frequencies, Hz: (n,), or (n, revolutions) for a speed that changes from one revolution to
            the next and is constant within each. Interaction depends on history: rising and falling speeds differ.
        revolutions: number of revolutions.
        steps_per_revolution: time steps per revolution, and casing cells.
        samples_per_revolution: least number of samples of the tip's displacement to keep per revolution, for
            spectra; engine orders up to a quarter of it are right. Taken behind a low-pass filter of 80 dB.
        over, store, processes: further axes, the study's folder and its share, as ``sweep`` takes them. Names are
            such as "modes.damping_ratio", "casing.amplitude" and "law.stiffness"; each of the three may be a function
            of a dictionary of numbers, which gets the names that are no paths.
        progress: show a progress bar on standard error; with ``over`` or ``store``, if that is a terminal.

    Returns:
        A ``WearMap``, or with ``over`` a ``Study``.

    Raises:
        ValueError: for speeds that are not finite and positive or can only be rpm, for numbers that are not whole and
            positive, for a casing of another number of cells, for fewer than 8 cells per bump or 8 steps per wave of
            the first mode or of what the contact can feed, or fewer steps than central differences are stable with
            (the message names the speed and the steps that it needs), and axes or stores as ``sweep`` refuses
            them.

    Warns:
        SweepWarning: when lanes blew up: they are NaN and their speeds are named; or when chunks of the store were
            damaged (they are computed again).
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent.
    """
    turns: dict[str, Any] = {
        "revolutions": revolutions,
        "steps_per_revolution": steps_per_revolution,
        "samples_per_revolution": samples_per_revolution,
    }
    if over is None and store is None and processes is None:
        return wear.march_wear(modes, casing, law, speed, **turns, progress=progress)
    from lobex.studies.run import run_study

    variation = Variation({"modes": modes, "casing": casing, "law": law}, axes_of(over, "march_wear"))
    for name, least in (("revolutions", 1), ("steps_per_revolution", 16), ("samples_per_revolution", 16)):
        _checks.integer(name, turns[name], least)
    speeds = _checks.as_numbers("speed", speed, "Hz")
    if speeds is None or speeds.ndim not in (1, 2) or speeds.size == 0:
        raise ValueError(f"speed has shape {np.shape(speed)}; give (n,) or (n, {revolutions}), not traced by JAX")
    steps = revolutions * steps_per_revolution
    task = Task(
        verb="march_wear",
        variation=variation,
        speed=speeds,
        settings=turns,
        compute=lambda model, part: wear.march_wear(**model, speed=part, **turns, plausible=False),
        implausible=lambda model: implausible(Rub(model["modes"]), speeds),
        points=revolutions,
        lanes=max(min(_LANES, _STEPS // steps), 1),
        bytes=COPIES * 8 * (2 * steps_per_revolution + revolutions * (2 * samples_per_revolution + 16)),
    )
    return run_study(task, store, processes, progress, over is not None)
