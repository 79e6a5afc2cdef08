"""What is drawn of a limit, as columns of numbers in the units of the axes."""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from lobex.explorer.curves import Predicted
from lobex.plots.frame import speed_axis
from lobex.plots.limit_picture import groups
from lobex.processes.quantity import Quantity
from lobex.results.band import Band
from lobex.results.limit import Limit
from lobex.results.sensitivities import Sensitivities

DEVIATIONS = 2.0
"""Of a band, on either side."""
_MOST_BARS = 12
# Of numbers that are not of a mode.
_ROWS: dict[str, str] = dict.fromkeys(("pitch_degrees", "helix_degrees", "runout"), "tooth")
_ROWS |= dict.fromkeys(("mistuning", "spacing"), "blade")
# Of the axis, what is next to its lower end.
_NEXT = 0.06

Columns = dict[str, np.ndarray]


class Series(NamedTuple):
    """Limits that are drawn alike: their name, colour, and columns."""

    name: str
    colour: str
    columns: Columns


def limit_columns(limit: Limit, band: Band | None = None) -> Columns:
    """Speed, gain and chatter frequency, codes, and edges of a band."""
    scale, size = speed_axis(limit.speed_unit)[0], limit.quantity.scale
    order = np.argsort(limit.speed)
    gain, frequency = np.asarray(limit.gain)[order] / size, np.asarray(limit.chatter_frequency)[order]
    columns = {
        "speed": limit.speed[order] * scale,
        "gain": gain,
        "frequency": frequency,
        "kind": np.asarray(limit.kind_code)[order].astype(np.int32),
        "status": np.asarray(limit.status_code)[order].astype(np.int32),
        "lobe": limit.lobe[order].astype(np.int32),
    }
    if band is not None:
        columns["low"], columns["high"] = (edge[order] / size for edge in band.interval(DEVIATIONS))
    return columns


def series_of(limit: Limit) -> list[Series]:
    """By kind, or where there is one kind, by the modes or the waves around the disc that chatter, as in pictures."""
    scale, size = speed_axis(limit.speed_unit)[0], limit.quantity.scale
    order = np.argsort(limit.speed)
    speed, gain = limit.speed[order] * scale, np.asarray(limit.gain)[order] / size
    frequency = np.asarray(limit.chatter_frequency)[order]
    found = []
    for here, style, name in groups(limit, order):
        # A line goes on to where the next begins.
        reached = here | np.r_[False, here[:-1]]
        columns = {
            "speed": speed,
            "gain": np.where(reached, gain, np.nan),
            "frequency": np.where(here, frequency, np.nan),
        }
        found.append(Series(name, style["color"], columns))
    return found


def predicted_columns(found: Predicted | Limit, speed_unit: str, quantity: Quantity) -> Columns:
    """Of a prediction, or of a first look, the line."""
    order = np.argsort(found.speed)
    speed, gain = found.speed[order] * speed_axis(speed_unit)[0], np.asarray(found.gain)[order] / quantity.scale
    return {"speed": speed, "gain": gain}


def stable_columns(limit: Limit) -> dict[str, list[Any]]:
    """The stable region as polygons, xs and ys, each a list of lists.

    Speeds with as many stable intervals as the one before belong to a polygon for each; between speeds with different
    numbers of them it ends in the middle.
    """
    order = np.argsort(limit.speed)
    speed = limit.speed[order] * speed_axis(limit.speed_unit)[0]
    low, high = np.moveaxis(np.asarray(limit.intervals)[order] / limit.quantity.scale, 2, 0)
    count = np.sum(np.isfinite(low) & np.isfinite(high), axis=1)
    middles = np.r_[speed[0], (speed[1:] + speed[:-1]) / 2, speed[-1]]
    xs, ys = [], []
    for start, stop in pairwise(np.r_[0, np.flatnonzero(np.diff(count)) + 1, len(speed)].tolist()):
        x = np.r_[middles[start], speed[start:stop], middles[stop]]
        for k in range(count[start]):
            lower, upper = (np.pad(edge[start:stop, k], 1, mode="edge") for edge in (low, high))
            xs.append(np.r_[x, x[::-1]])
            ys.append(np.r_[lower, upper[::-1]])
    return {"xs": xs, "ys": ys}


def band_columns(band: Band | None) -> dict[str, list[Any]]:
    """A band as polygons, xs and ys, one of every stretch of speeds with a limit."""
    found: dict[str, list[Any]] = {"xs": [], "ys": []}
    if band is None:
        return found
    columns = limit_columns(band.limit, band)
    there = np.isfinite(columns["low"]) & np.isfinite(columns["high"])
    for stretch in np.split(np.arange(len(there)), np.flatnonzero(np.diff(there)) + 1):
        if there[stretch[0]]:
            x, low, high = (columns[name][stretch] for name in ("speed", "low", "high"))
            found["xs"].append(np.r_[x, x[::-1]])
            found["ys"].append(np.r_[low, high[::-1]])
    return found


def lobe_columns(limit: Limit, top: float) -> dict[str, Any]:
    """The number of each lobe under its lowest point, or above it where that is next to the axis, which ends at
    ``top``; the offset is in pixels.
    """
    columns = limit_columns(limit)
    speed, gain, lobe = (columns[name] for name in ("speed", "gain", "lobe"))
    places = []
    for number in np.unique(lobe[lobe >= 0]):
        here = np.flatnonzero((lobe == number) & np.isfinite(gain))
        if here.size:
            lowest = here[np.argmin(gain[here])]
            # At an end of the picture its lowest point may lie outside.
            if 0 < lowest < len(speed) - 1:
                places.append((speed[lowest], gain[lowest], str(number)))
    spread = 0.025 * (speed[-1] - speed[0])
    kept: list[tuple[float, float, str]] = []
    for place in sorted(places):
        if not kept or place[0] - kept[-1][0] > spread:
            kept.append(place)
    shown = {name: [place[i] for place in kept] for i, name in enumerate(("speed", "gain", "number"))}
    return shown | {"offset": [11 if low > _NEXT * top else -11 for _, low, _ in kept]}


def bar_columns(table: Sensitivities, speed: float | None) -> tuple[dict[str, Any], float]:
    """d ln K/d ln p at the speed nearest to one, Hz, or at the lowest limit; and that speed."""
    limit = table.limit
    there = np.isfinite(np.asarray(limit.gain))
    if not there.any():
        return {"name": [], "size": [], "text": []}, np.nan
    away = np.asarray(limit.gain) if speed is None else np.abs(limit.speed - speed)
    lane = int(np.argmin(np.where(there, away, np.inf)))
    sizes = np.nan_to_num(table.logarithmic[lane])
    chosen = [i for i in np.argsort(-np.abs(sizes), kind="stable")[:_MOST_BARS] if abs(sizes[i]) >= 5e-4]
    shown = {
        "name": [in_words(table.names[i]) for i in chosen],
        "size": [float(sizes[i]) for i in chosen],
        "text": [f"{sizes[i]:+.3f}".replace("-", "−") for i in chosen],
    }
    return shown, float(limit.speed[lane])


def in_words(name: str) -> str:
    """ "frequency[0]" as "frequency, mode 1"; of numbers of a tooth or a blade, "tooth 1"."""
    stem, _, index = name.partition("[")
    if not index:
        return stem.replace("_", " ")
    whose = _ROWS.get(stem, "mode")
    words = stem.removesuffix("_degrees").replace("_", " ")
    return f"{words}, {whose} {int(index.rstrip(']')) + 1}"
