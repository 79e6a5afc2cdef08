"""The first-order uncertainty of a stability limit whose model is uncertain."""

from collections.abc import Mapping

import numpy as np

from lobex import _checks
from lobex.results.band import Band
from lobex.results.sensitivities import Sensitivities


def band(sensitivities: Sensitivities, relative_standard_deviation: Mapping[str, float]) -> Band:
    """Propagate independent relative standard deviations: σ²(ln K) = Σ (d ln K/d ln p · σ_p/p)².

    A name without index, such as "modes.damping_ratio", stands for each of its numbers, every one
    independent of the others; for numbers that vary together, take sensitivities to the one that they are made from.

    Raises:
        ValueError: for names that the table does not have, and standard deviations that are negative or not finite.
    """
    if not isinstance(relative_standard_deviation, Mapping) or not relative_standard_deviation:
        raise ValueError(
            f"relative_standard_deviation = {_checks.brief(relative_standard_deviation)} must be a dictionary of "
            "one or more numbers by name"
        )
    deviation = np.zeros(len(sensitivities.names))
    taken: dict[int, str] = {}
    for name, value in relative_standard_deviation.items():
        _checks.not_negative(f"relative_standard_deviation[{name!r}]", value)
        _checks.scalar(f"relative_standard_deviation[{name!r}]", value)
        meant = [i for i, full in enumerate(sensitivities.names) if full == name or full.startswith(f"{name}[")]
        if not meant:
            known = dict.fromkeys(full.partition("[")[0] for full in sensitivities.names)
            raise ValueError(f"relative_standard_deviation names {name!r}; give some of {', '.join(known)}")
        for i in meant:
            if i in taken:
                raise ValueError(f"relative_standard_deviation names {taken[i]!r} and {name!r}, which overlap")
            deviation[i], taken[i] = value, name
    used = sorted(taken)
    return Band(
        limit=sensitivities.limit,
        names=tuple(sensitivities.names[i] for i in used),
        deviation=deviation[used],
        # What is certain adds nothing, be its sensitivity infinite.
        contribution=np.where(deviation[used] > 0, np.abs(sensitivities.logarithmic[:, used]) * deviation[used], 0.0),
    )
