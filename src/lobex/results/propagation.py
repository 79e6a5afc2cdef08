"""The first-order uncertainty of a stability limit whose model is uncertain."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lobex import _checks
from lobex.results.band import Band
from lobex.results.sensitivities import Sensitivities

# Added to a correlation matrix on its diagonal, for those that are singular up to rounding.
_ROUNDING = 1e-10


def band(
    sensitivities: Sensitivities, relative_standard_deviation: Mapping[str, float], correlation: Any = None
) -> Band:
    """Propagate relative standard deviations: σ²(ln K) = Σ (d ln K/d ln p · σ_p/p)², of independent numbers.

    Of a complex number, such as a sample of a measurement, each part deviates by a share of its modulus: noise that is
    as large in both.

    A name without index, such as "modes.damping_ratio", stands for each of its numbers, every one
    independent of the others; for numbers that vary together, take sensitivities to the one that they are made from,
    or their correlation R: σ² = Σ Σ Rᵢⱼ (…)ᵢ (…)ⱼ. The contribution of each is then that of what the ones before leave
    of it, by Cholesky's factors, so that their squares add up.

    Raises:
        ValueError: for names that the table does not have, standard deviations that are negative or not finite, and a
            correlation that is none of these numbers.
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
    if correlation is not None:
        return _together(sensitivities, relative_standard_deviation, correlation)
    used = sorted(taken)
    return Band(
        limit=sensitivities.limit,
        names=tuple(sensitivities.names[i] for i in used),
        deviation=deviation[used],
        # What is certain adds nothing, be its sensitivity infinite.
        contribution=np.where(deviation[used] > 0, np.abs(_relative(sensitivities)[:, used]) * deviation[used], 0.0),
    )


def _relative(sensitivities: Sensitivities) -> np.ndarray:
    """d ln K/d ln p, (n, p), and of parts of complex numbers d ln K by shares of the modulus."""
    found, names = sensitivities.logarithmic, sensitivities.names
    # The imaginary part follows the real one.
    first = np.array([i for i, name in enumerate(names) if name.endswith(".real")], dtype=int)
    if first.size:
        both = np.stack([first, first + 1])
        modulus = np.hypot(*np.moveaxis(sensitivities.value[:, both], 1, 0))
        gain = np.asarray(sensitivities.limit.gain)[:, None]
        for part in both:
            found[:, part] = sensitivities.derivative[:, part] * modulus / np.where(gain == 0, np.nan, gain)
    return found


def _together(sensitivities: Sensitivities, relative_standard_deviation: Mapping[str, float], correlation: Any) -> Band:
    """Of numbers that hang together, each named by itself."""
    names = tuple(relative_standard_deviation)
    if whole := [name for name in names if name not in sensitivities.names]:
        raise ValueError(
            f"relative_standard_deviation names {whole[0]!r}; with correlation, name each number by itself"
        )
    matrix = _checks.as_numbers("correlation", correlation)
    count = len(names)
    if matrix is None or matrix.shape != (count, count):
        raise ValueError(f"correlation has shape {np.shape(correlation)}; give ({count}, {count}) of {count} numbers")
    signed = np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1.0)
    if not signed or np.min(np.linalg.eigvalsh(matrix)) < -1e-6:
        raise ValueError("correlation is no correlation matrix; give a symmetric one with ones on its diagonal")
    deviation = np.array([float(relative_standard_deviation[name]) for name in names])
    place = [sensitivities.names.index(name) for name in names]
    slope = np.where(deviation > 0, _relative(sensitivities)[:, place] * deviation, 0.0)
    factor = np.linalg.cholesky(matrix + _ROUNDING * np.eye(count))
    return Band(sensitivities.limit, names, deviation, np.abs(slope @ factor))
