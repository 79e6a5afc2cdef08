"""Frequency responses of a universal file: datasets 58 and 58b, with the units of dataset 164."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from lobex._optional import needed
from lobex.measured.response_units import ResponseUnit, frequency_scale, response_unit
from lobex.measured.samples import Samples

_RESPONSE, _COHERENCE = 4, 6
_MEASURED = {8: "displacement", 11: "velocity", 12: "acceleration"}
_FORCES = (9, 13)
_AXES = {1: "x", 2: "y", 3: "z"}
_FUNCTIONS = {0: "unknown functions", 1: "time responses", 2: "auto spectra", 3: "cross spectra", 6: "coherences"}
_FUNCTIONS |= {9: "power spectra", 12: "spectra"}
# The seventh line of a dataset 58: kind of numbers, and how many values there are.
_COUNT = re.compile(rb"^ {4}58[^\r\n]*\r?\n(?:[^\n]*\n){6}[^\n]{10}([ ]*-?\d+)[ ]", re.MULTILINE)
# Of a dataset 58b its head up to the numbers, with the kind of these, how many there are, and whether evenly spaced.
_BINARY = re.compile(
    rb"^ {4}58[bB][^\n]*\n(?:[^\n]*\n){6}([ \d]{10})([ \d]{10})([ \d]{10})[^\n]*\n(?:[^\n]*\n){4}", re.MULTILINE
)
# Bytes of a value and of its frequency by the kind of numbers: real and complex ones, single and double.
_BYTES = {2: (4, 4), 4: (8, 8), 5: (8, 4), 6: (16, 8)}
# Beyond which, in any unit, no response is; numbers of another byte order are.
_LARGEST = 1e30
_MARK = re.compile(rb" {4}-1[ ]*(?:[\r\n]|$)")
# Between two frequency axes that are the same, of their steps.
_SAME = 1e-3


def samples_of_universal_file(path: Path) -> Samples:
    """All frequency responses to translations of one axis of frequencies, by the directions that the file names.

    Raises:
        ValueError: for a file that is cut short, has none of them, or several axes.
    """
    sets, factor = _sets(path)
    found = [one for one in sets if one["func_type"] == _RESPONSE]
    if not found:
        kinds = sorted({_FUNCTIONS.get(one["func_type"], f"functions of type {one['func_type']}") for one in sets})
        raise ValueError(
            f"path = {str(path)!r} has no frequency response (function type 4 of dataset 58), but "
            f"{', '.join(kinds) or 'no functions'}; export those"
        )
    notes = [f"{len(found)} frequency responses of dataset 58{'b' if found[0]['binary'] else ''}"]
    moving = [one for one in found if abs(one["rsp_dir"]) < 4 and abs(one["ref_dir"]) < 4]
    if not moving:
        raise ValueError(f"path = {str(path)!r} has responses of rotations alone; export those of translations")
    notes += [f"{len(found) - len(moving)} of rotations left out"] * (len(moving) < len(found))
    notes += ["directions against an axis turned round"] * any(min(_directions(one)) < 0 for one in moving)
    for one in moving:
        _check(one, path)
    frequency = np.asarray(moving[0]["x"], float)
    step = np.median(np.abs(np.diff(frequency))) if len(frequency) > 1 else 1.0
    for one in moving:
        if len(one["x"]) != len(frequency) or np.max(np.abs(one["x"] - frequency)) > _SAME * step:
            raise ValueError(
                f"path = {str(path)!r} has responses over different frequencies; keep those of one axis in it"
            )
    names = [(_name(one, "rsp", moving), _name(one, "ref", moving)) for one in moving]
    response, reference = (tuple(dict.fromkeys(pair[end] for pair in names)) for end in (0, 1))
    value = np.full((len(frequency), len(response), len(reference)), np.nan, complex)
    coherence = np.full(value.shape, np.nan)
    for one, pair in zip(moving, names, strict=True):
        place = response.index(pair[0]), reference.index(pair[1])
        if not np.isnan(value[0, *place]):
            raise ValueError(
                f"path = {str(path)!r} has two responses of {pair[0] or 'a scalar'!r} to {pair[1] or 'a scalar'!r}; "
                "keep one in the file"
            )
        value[:, *place] = np.prod(np.sign(_directions(one, least=1))) * np.asarray(one["data"])
        coherence[:, *place] = _coherence_of(one, sets, len(frequency))
    units = [_unit(one, factor) for one in moving]
    if len({unit and unit[:2] for unit in units}) > 1:
        said = " and ".join(sorted({repr(unit.text) if unit else "nothing" for unit in units}))
        raise ValueError(f"path = {str(path)!r} says {said} of the units of its responses; give unit=, that of all")
    scale = frequency_scale(moving[0].get("abscissa_axis_units_lab", "")) or 1.0
    known = None if np.isnan(coherence).all() else coherence
    return Samples(frequency, value, response, reference, known, units[0], scale, tuple(notes))


def _sets(path: Path) -> tuple[list[dict[str, Any]], float | None]:
    """All datasets 58, and how many m/N the file's unit of length over force is, where it says so."""
    pyuff = needed("pyuff", "a universal file", "measured")
    content = path.read_bytes()
    marks = len(_MARK.findall(content))
    if marks == 0:
        raise ValueError(f"path = {str(path)!r} is no universal file, whose datasets stand between lines of '    -1'")
    if marks % 2:
        raise ValueError(f"path = {str(path)!r} is cut short: its last dataset has no end '    -1'; export it again")
    for said in _COUNT.findall(content):
        # Of a count, pyuff makes as many frequencies, however few values there are; each takes a byte at least.
        if not 0 < int(said) <= len(content):
            raise ValueError(
                f"path = {str(path)!r} is cut short: a dataset says {int(said)} values, in a file of {len(content)} "
                "bytes; export it again"
            )
    _check_binary(content, path)
    try:
        file = pyuff.UFF(str(path))
        kinds = file.get_set_types()
        sets = [file.read_sets(int(i)) for i in np.flatnonzero(kinds == 58)]
        units = [file.read_sets(int(i)) for i in np.flatnonzero(kinds == 164)]
    # What pyuff raises is an Exception.
    except Exception as error:
        why = str(error).partition("\n")[0]
        raise ValueError(f"path = {str(path)!r} has a dataset 58 that is damaged ({why}); export it again") from None
    factors = {unit["force"] / unit["length"] for unit in units}
    return sets, factors.pop() if len(factors) == 1 else None


def _check_binary(content: bytes, path: Path) -> None:
    """Require numbers of datasets 58b to fill the bytes that their heads say, but for white space behind them."""
    for head in _BINARY.finditer(content):
        kind, count, even = map(int, head.groups())
        if kind not in _BYTES:
            continue
        value, place = _BYTES[kind]
        size = count * (value + (0 if even else place))
        end = _MARK.search(content, head.end() + size)
        if end is not None and content[head.end() + size : end.start()].strip():
            raise ValueError(
                f"path = {str(path)!r} has a dataset 58b with more than the {size} bytes of numbers that its head "
                "says, as where a transfer as text put in newlines; copy it as a binary file, or export it again"
            )


def _check(one: dict[str, Any], path: Path) -> None:
    """Require a whole dataset of complex numbers."""
    count = int(one["num_pts"])
    if len(one["data"]) < count or len(one["x"]) < count:
        raise ValueError(
            f"path = {str(path)!r} is cut short: a dataset says {count} values and has {len(one['data'])}; export "
            "it again"
        )
    one["data"], one["x"] = np.asarray(one["data"])[:count], np.asarray(one["x"])[:count]
    if not np.iscomplexobj(one["data"]):
        raise ValueError(f"path = {str(path)!r} has responses without imaginary part; export complex ones")
    if np.any(np.abs(np.nan_to_num(one["data"], posinf=np.inf)) > _LARGEST):
        raise ValueError(
            f"path = {str(path)!r} has numbers above {_LARGEST:g}, and no response has; what it says of their bytes "
            "may be wrong: export it again, as text if it can be"
        )


def _directions(one: dict[str, Any], least: int = 0) -> tuple[int, int]:
    """Direction codes of response and reference, a scalar being ``least``."""
    return one["rsp_dir"] or least, one["ref_dir"] or least


def _name(one: dict[str, Any], end: str, sets: list[dict[str, Any]]) -> str:
    """Such as "x", or "12 x" where the file has several points."""
    nodes = {other[f"{side}_node"] for other in sets for side in ("rsp", "ref")}
    axis = _AXES.get(abs(one[f"{end}_dir"]), "")
    return axis if len(nodes) == 1 else f"{one[f'{end}_node']} {axis}".strip()


def _unit(one: dict[str, Any], factor: float | None) -> ResponseUnit | None:
    """By the labels of the axes, which take precedence, or the kinds of data and the file's units."""
    above, below = (_label(one, axis) for axis in ("ordinate", "orddenom"))
    for text in (f"({above})/({below})", above) if below else (above,):
        if above and (found := response_unit(text)) is not None:
            return found._replace(text=text.replace("(", "").replace(")", ""))
    measured = _MEASURED.get(one.get("ordinate_spec_data_type", 0))
    if measured is None or one.get("orddenom_spec_data_type") not in _FORCES or factor is None:
        return None
    return ResponseUnit(measured, factor, f"{measured} over force in the units of dataset 164")


def _label(one: dict[str, Any], axis: str) -> str:
    text = str(one.get(f"{axis}_axis_units_lab", "")).strip()
    return "" if text.upper() == "NONE" else text


def _coherence_of(one: dict[str, Any], sets: list[dict[str, Any]], count: int) -> Any:
    """The coherence of the same ends, NaN where the file has none."""
    ends = ("rsp_node", "rsp_dir", "ref_node", "ref_dir")
    for other in sets:
        alike = all(abs(other.get(end, 0)) == abs(one[end]) for end in ends)
        if other["func_type"] == _COHERENCE and alike and len(other["data"]) >= count:
            return np.real(other["data"][:count])
    return np.nan
