"""``march_wear``, with further axes and a store: each chunk is a march of its own."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lobex._shapes import ArrayLike
from lobex.marches import wear
from lobex.processes.plausible import implausible
from lobex.processes.regenerative import Rub
from lobex.results.blading_wear import BladingWear
from lobex.results.wear_map import WearMap
from lobex.studies.studied import studied
from lobex.studies.task import AnyExecutor, Over, Path, Task
from lobex.studies.variation import Variation, axes_of

# Lanes of a chunk, and time steps of all of them together: some seconds on two cores.
_LANES, _STEPS = 768, 2**26


@studied(wear.march_wear)
def march_wear(
    modes: Any,
    casing: Any,
    law: Any,
    speed: Any,
    revolutions: int = 20,
    steps_per_revolution: int = 4096,
    *,
    samples_per_revolution: int = 512,
    incursion: float = 0.0,
    angles_degrees: ArrayLike | None = None,
    tracks: Sequence[int] | None = None,
    watched: int = 0,
    over: Over | None = None,
    store: Path | None = None,
    executor: AnyExecutor | None = None,
    progress: bool = False,
) -> Task:
    """March rubbing blades over some revolutions at every speed, wearing the casing: chapter 1, for real blades too.

    Central differences, (1.16)-(1.17), in modal form, one casing cell per step: second order in the step, and stable
    where a step is shorter than 2/ω of the highest frequency in contact. A contact leaves its track as it stands one
    step later, §1.4, so that the next one comes to it a step less than the time between them after it. The reaction −F
    of the law acts on the tip, and F on a casing that is flexible. All starts at rest, the first blade at θ = 0. All
    arithmetic is float64.

    Args:
        modes: the blade's: ``Modes``, real or complex, those that follow the speed (``Beam.rotating``,
            ``ModesOverSpeed``), or a ``Blading`` of them, of which each blade runs in the track of the one before. Each
            contact direction is a contact, which may load others than it sees, with friction. As the speed changes from
            one revolution to the next, modes become those of another speed, and go on as they move.
        casing: its profile before wear, or one for each track, and with ``structure`` how it gives way.
        law: the contact law, such as ``Linear(4.5e6)``, or one for each contact.
        speed: rotational frequencies, Hz: (n,), or (n, revolutions) for a speed that changes from one revolution to
            the next and is constant within each, or a function of the numbers 0, 1, … of all revolutions that gives
            these. Interaction depends on history: rising and falling speeds differ.
        revolutions: number of revolutions.
        steps_per_revolution: time steps per revolution, and casing cells.
        samples_per_revolution: least number of samples of the tip's displacement to keep per revolution, for
            spectra; engine orders up to a quarter of it are right. Taken behind a low-pass filter of 80 dB.
        incursion: by how much blades and casing come closer in every revolution, m, from the first on.
        angles_degrees: where around the casing each contact of one blade begins, (contacts,), in the direction of the
            motion; 0 where it is left out. To the nearest cell.
        tracks: in which track each contact of a blade runs, (contacts,), from 0; in one of its own where it is left
            out. Of those in one track each comes to what the one before it has left.
        watched: so many of the last contact directions are no contacts: what they see, such as displacements in other
            directions, a root moment or a stress, is recorded as the tip is.
        over, store, executor: further axes, the study's folder and who computes it, as ``sweep`` takes them. Names are
            such as "modes.damping_ratio", "casing.amplitude" and "law.stiffness"; each of the three may be a function
            of a dictionary of numbers, which gets the names that are no paths.
        progress: show a progress bar on standard error; with ``over`` or ``store``, if that is a terminal.

    Returns:
        A ``WearMap`` of one contact, a ``BladingWear`` of several, or with ``over`` a ``Study``.

    Raises:
        ValueError: for speeds that are not finite and positive or can only be rpm, for numbers that are not whole and
            positive, for a casing of another number of cells, for fewer than 8 cells per bump or 8 steps per wave of
            the first mode or of what the contact can feed, or fewer steps than central differences are stable with
            (the message names the speed and the steps that it needs), for lists of other lengths than there are
            contacts and tracks, two contacts of a track in one cell, a casing that gives way in another number of
            directions than there are contacts, and axes, stores or executors as ``sweep``
            refuses them.

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
    sizes = revolutions, steps_per_revolution, samples_per_revolution
    around = {"angles_degrees": angles_degrees, "tracks": tracks, "watched": watched}
    variation = Variation({"modes": modes, "casing": casing, "law": law}, axes_of(over, "march_wear"))
    arranged, speeds = wear.checked(**variation.at(0), speed=speed, turns=sizes, **around)
    # A manifest tells of what is not as it is by default.
    given = {"incursion": incursion, **around}
    turns |= {name: v for name, v in given.items() if np.any(v) or (name == "tracks" and v is not None)}
    return Task(
        verb="march_wear",
        variation=variation,
        speed=speeds,
        settings=turns,
        compute=_march,
        implausible=lambda model: implausible(Rub(getattr(model["modes"], "blade", model["modes"])), speeds),
        points=revolutions,
        lanes=max(min(_LANES, _STEPS // (revolutions * steps_per_revolution * arranged.place.size)), 1),
        bytes=wear.bytes_of_lane(arranged, *sizes),
    )


def _march(**arguments: Any) -> WearMap | BladingWear:
    return wear.march_wear(**arguments, plausible=False)
