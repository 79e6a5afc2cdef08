"""Frequency responses from files of analysers and programs."""

import os
from pathlib import Path
from typing import Any

import numpy as np

from lobex import _checks
from lobex._warnings import warn
from lobex.limits.measurement import (
    MEASURED,
    NO_DRIVING_POINT,
    as_receptance,
    named,
    oddity,
    readings,
)
from lobex.measured.array_files import arrays_of
from lobex.measured.column_roles import refuse_speeds, samples_of
from lobex.measured.frf import Frf, names_of
from lobex.measured.named_arrays import samples_of_arrays
from lobex.measured.response_units import ResponseUnit, check_frequency_unit, check_response_unit, with_measured
from lobex.measured.samples import Samples
from lobex.measured.text_table import existing_file, read_text, table_of

_UNIVERSAL = (".uff", ".unv", ".ufb", ".uf", ".bunv")
_ARRAYS = (".npz", ".npy", ".mat")
_BEGINS = b"    -1"
# Of HDF5, and so of the results that lobex saves.
_HDF5 = b"\x89HDF\r\n\x1a\n"
# Of CutPro, whose three columns are frequency, real and imaginary part.
_CUTPRO, _CUTPRO_UNIT = ".frf", "m/N"
_SHARE = 0.5
# Hz, below which no analyser's band ends.
_LOW = 20.0


def read_frf(
    path: str | os.PathLike[str],
    *,
    unit: str | None = None,
    frequency_unit: str | None = None,
    conjugate: bool = False,
    columns: Any = None,
    response: Any = None,
    reference: Any = None,
) -> Frf:
    """Frequency responses of a file, as receptances in m/N.

    Universal files (.uff, .unv: datasets 58 and 58b, by the package pyuff), CutPro's .frf, tables (.csv, .txt) with
    columns of real and imaginary parts or magnitude and phase, whose separators and decimal sign are found, NumPy's
    .npz and .npy, and MATLAB's .mat. What was measured and in which unit is what the file says, or ``unit``, which has
    precedence; where neither says it, the file is refused. Frequencies without a unit are Hz.

    Args:
        path: of the file.
        unit: of the response over the force, which also says what was measured: "m/N" or "um/N" of a receptance,
            "m/s/N" of a mobility, "m/s^2/N" or "g/N" of an accelerance. None for what the file says.
        frequency_unit: "Hz", "kHz", "rad/s" or "rpm"; None for what the file says, or Hz.
        conjugate: True where the time dependence is e^{−jωt}; files do not say, and it is rare.
        columns: what the columns of a table are, where its head does not say: "frequency", "real", "imaginary",
            "magnitude", "decibels", "phase_degrees", "phase_radians", "coherence" and "unused", in order or by what
            stands above each; or of named arrays a dictionary of "frequency", "complex" and "coherence" by name.
        response: names of the directions of the responses, (r,), where the file has none, "x" of a single one by
            default, and with a sign, "-x", where the sensor pointed the other way; else those to keep.
        reference: names of the directions of the forces, (p,), in the same way; by default those of the responses where
            there are as many.

    Returns:
        The ``Frf``, sorted by frequency; its ``notes`` tell how the file was read.

    Raises:
        ValueError: in one line that says what to do, for a file that cannot be read, is cut short, holds something
            else, or does not say what it holds.

    Warns:
        LobexWarning: for lines that are left out, a ``unit`` that contradicts the file, and samples of a driving point
            that no driving point can have, with the argument that would mend them.
    """
    place = existing_file(path)
    _checks.choice("conjugate", conjugate, (False, True))
    asked = None if unit is None else check_response_unit(unit)
    scale = None if frequency_unit is None else check_frequency_unit(frequency_unit)
    rows, forces = names_of("response", response), names_of("reference", reference)
    samples = _samples(place, columns)
    own = _unit(asked, samples.unit, place)
    samples = _named(samples, rows, forces, place)
    frequency, matrix, coherence, notes = _cleaned(samples, scale, place)
    flat = matrix.reshape(len(frequency), -1) * own.scale
    receptance = np.stack([as_receptance(frequency, one, own.measured, conjugate) for one in flat.T], axis=1)
    notes = [f"{own.text}, " + ("of unit=" if asked else "as the file or its format says"), *samples.notes, *notes]
    made = Frf(
        frequency,
        receptance.reshape(matrix.shape),
        samples.response,
        samples.reference,
        coherence,
        own.measured,
        place.name,
        tuple(notes),
    )
    for name in made.driving_points:
        _check_driving_point(made, name, own, conjugate, f"-{name}" in (rows or ()))
    return made


def _samples(path: Path, columns: Any) -> Samples:
    """What the reader of the file's format finds."""
    ending = path.suffix.lower()
    if ending in _ARRAYS:
        return samples_of_arrays(arrays_of(path), columns, path)
    with open(path, "rb") as file:
        start = file.read(len(_HDF5))
    if start == _HDF5:
        raise ValueError(
            f"path = {str(path)!r} is an HDF5 file, such as of a result, which lobex.load reads, and no frequency "
            "response; give the file of a measurement, with the ending that its format has"
        )
    universal = start.startswith(_BEGINS)
    if ending in _UNIVERSAL or universal:
        if path.stat().st_size == 0:
            raise ValueError(f"path = {str(path)!r} is empty; give a universal file")
        # The package is asked for where there is such a file alone.
        from lobex.measured.universal_file import samples_of_universal_file

        if columns is not None:
            raise ValueError(f"columns has no use with path = {str(path)!r}, a universal file; drop it")
        return samples_of_universal_file(path)
    text = read_text(path, "a file of frequency responses")
    if columns is None:
        refuse_speeds(text, path)
    table = table_of(text, path)
    return samples_of(table, columns, path, _CUTPRO_UNIT if ending == _CUTPRO else None)


def _unit(asked: ResponseUnit | None, said: ResponseUnit | None, path: Path) -> ResponseUnit:
    """What was measured and in which unit: as asked, or as the file says."""
    if asked is None and said is None:
        raise ValueError(
            f"path = {str(path)!r} does not say what was measured in which unit; give unit=, such as 'm/N' of a "
            "receptance, 'm/s/N' of a mobility, or 'm/s^2/N' or 'g/N' of an accelerance"
        )
    if asked is not None and said is not None and asked[:2] != said[:2]:
        warn(f"unit = {asked.text!r} is taken, where {path.name} says {said.text!r}")
    return asked or said  # pyright: ignore[reportReturnType]


def _named(
    samples: Samples, response: tuple[str, ...] | None, reference: tuple[str, ...] | None, path: Path
) -> Samples:
    """With the names of all directions, or with those kept that were asked for."""
    if any(samples.response) and any(samples.reference):
        return _kept(samples, response, reference, path)
    rows, forces = samples.value.shape[1:]
    response = response or (("x",) if rows == 1 else None)
    reference = reference or (tuple(name.lstrip("-") for name in response or ()) if rows == forces else None)
    for name, given, count in (("response", response, rows), ("reference", reference, forces)):
        if given is None or len(given) != count:
            has = "" if given is None else f"{name} has {len(given)} names, and "
            raise ValueError(
                f"{has}path = {str(path)!r} does not name the directions of its {count} {name}s; give {name}=, such as "
                f"{('x', 'y', 'z')[: max(count, 1)]!r}"
            )
    assert response is not None
    assert reference is not None
    signs = [np.array([-1.0 if name.startswith("-") else 1.0 for name in names]) for names in (response, reference)]
    plain = [tuple(name.lstrip("-") for name in names) for names in (response, reference)]
    return samples._replace(value=samples.value * np.outer(signs[0], signs[1]), response=plain[0], reference=plain[1])


def _kept(samples: Samples, response: tuple[str, ...] | None, reference: tuple[str, ...] | None, path: Path) -> Samples:
    index = []
    for name, asked, own in (("response", response, samples.response), ("reference", reference, samples.reference)):
        for one in asked or ():
            if one not in own:
                raise ValueError(f"{name} = {one!r} is not in path = {str(path)!r}, which has {', '.join(own)}")
        index.append([own.index(one) for one in asked or own])
    place = np.ix_(range(len(samples.frequency)), *index)
    coherence = None if samples.coherence is None else samples.coherence[place]
    names = [
        tuple(own[i] for i in kept) for own, kept in zip((samples.response, samples.reference), index, strict=True)
    ]
    return samples._replace(value=samples.value[place], coherence=coherence, response=names[0], reference=names[1])


def _cleaned(
    samples: Samples, scale: float | None, path: Path
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None, list[str]]:
    """Frequencies in Hz, increasing and above zero, and what was measured there, without lines that have gaps."""
    notes = []
    if scale is None and samples.frequency_scale is None:
        notes.append("frequencies without a unit taken for Hz")
        _warn_of_units(samples.frequency)
    factor = next(one for one in (scale, samples.frequency_scale, 1.0) if one is not None)
    frequency, value = samples.frequency * factor, samples.value
    measured = ~np.isnan(value).all(axis=0)
    whole = np.isfinite(frequency) & np.isfinite(value[:, measured]).all(axis=1) & measured.any()
    if np.mean(whole) < _SHARE:
        raise ValueError(
            f"path = {str(path)!r} has no number in {np.sum(~whole)} of its {len(whole)} lines; check how it was "
            "exported"
        )
    if np.any(~whole):
        warn(f"{path.name} has no number in {np.sum(~whole)} of {len(whole)} lines, which are left out")
    if np.any(frequency[whole] < 0):
        raise ValueError(f"path = {str(path)!r} has frequencies below zero; export the one-sided response")
    if np.any(frequency[whole] == 0):
        notes.append("the line at 0 Hz left out")
    keep = np.flatnonzero(whole & (frequency > 0))
    order = keep[np.argsort(frequency[keep], kind="stable")]
    if np.any(np.diff(order) < 0):
        notes.append("sorted by frequency")
    twice = np.flatnonzero(np.diff(frequency[order]) == 0)
    if twice.size:
        raise ValueError(
            f"path = {str(path)!r} has {frequency[order[twice[0]]]:.6g} Hz in several lines; give each response its "
            "own columns or file"
        )
    coherence = None if samples.coherence is None else samples.coherence[order]
    return frequency[order], value[order], coherence, notes


def _warn_of_units(frequency: np.ndarray) -> None:
    """Warn where frequencies without a unit step by 2π times a round number, or end where tap tests begin."""
    if (last := np.max(frequency, initial=0.0, where=np.isfinite(frequency))) < _LOW:
        warn(f"frequencies end at {last:.6g}, and are taken for Hz; give frequency_unit='kHz' if they are in that")
        return
    steps = np.diff(np.sort(frequency[np.isfinite(frequency)]))
    if not steps.size or np.ptp(steps) > 1e-4 * np.median(steps) or np.median(steps) <= 0:
        return
    step = float(np.median(steps))

    def round_number(number: float) -> bool:
        return abs(float(f"{number:.2g}") / number - 1) < 1e-5

    if round_number(step / (2 * np.pi)) and not round_number(step):
        warn(
            f"frequencies step by {step:.6g}, 2π times {step / (2 * np.pi):.2g}, and are taken for Hz; give "
            "frequency_unit='rad/s' if they are angular"
        )


def _check_driving_point(frf: Frf, name: str, unit: ResponseUnit, conjugate: bool, against: bool) -> None:
    """Warn where a driving point would give out energy, or lie above itself, with what would mend it."""
    own = frf.values(name, name) * (2j * np.pi * frf.frequency) ** MEASURED.index(unit.measured)
    own = own.conj() if conjugate else own
    found = oddity(own, unit.measured, conjugate)
    if found is None:
        return
    told = f"{frf.source}, {name} to {name}, taken for {named(unit.measured)}: {found}"
    if not np.any(np.imag(own)):
        warn(f"{told}; export real and imaginary parts, or magnitude and phase")
        return
    ways = []
    for other in readings(own):
        arguments = [f"unit={with_measured(unit, other.measured)!r}"] * (other.measured != unit.measured)
        arguments += [f"conjugate={other.conjugate}"] * (other.conjugate != conjugate)
        arguments += [f"response={name if against else f'-{name}'!r}"] * other.against
        ways.append(f"{named(*other)} {'' if ways else 'is read '}by {', '.join(arguments)}")
    why = f"no receptance of a driving point has; {', or '.join(ways)}" if ways else NO_DRIVING_POINT
    warn(f"{told}, which {why}")
