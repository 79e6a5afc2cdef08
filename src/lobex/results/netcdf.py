"""Results as NetCDF-4 files, which Python, MATLAB and Julia open, and back."""

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray

from lobex.processes.quantity import hertz
from lobex.results.boundary import FORM as BOUNDARY
from lobex.results.boundary import Boundary, read_boundary
from lobex.results.chart import Chart
from lobex.results.codes import Kind, PointStatus, Status, flags
from lobex.results.cut import Cut
from lobex.results.limit import Limit
from lobex.results.march import March
from lobex.results.march_file import CUT, MARCH, read_cut, read_march
from lobex.results.sensitivities import FORM as SENSITIVITIES
from lobex.results.sensitivities import Sensitivities, read_sensitivities
from lobex.results.spectrum_map import SpectrumMap
from lobex.results.stored import Stored
from lobex.results.wear_file import SPECTRUM, WEAR_MAP, read_spectrum, read_wear_map
from lobex.results.wear_map import WearMap

Result = Chart | Limit | Sensitivities | Boundary | WearMap | SpectrumMap | March | Cut

_CHART = "lobex chart 4"
_LIMIT = "lobex limit 2"


def chart_to_dataset(chart: Chart) -> xarray.Dataset:
    """The chart's arrays over the coordinates speed and gain."""
    axes = ("speed", "gain")
    return xarray.Dataset(
        data_vars={
            "spectral_radius": (axes, chart.spectral_radius, {"long_name": "spectral radius max|μ|", "units": "1"}),
            "multiplier": (axes, chart.multiplier, {"long_name": "dominant Floquet multiplier μ", "units": "1"}),
            "chatter_frequency": (axes, chart.chatter_frequency, _in_hertz(chart, "chatter frequency")),
            "error": (axes, chart.error, {"long_name": "estimated relative error of max|μ|", "units": "1"}),
            "status": (axes, chart.status_code, flags("what became of the point", PointStatus)),
        },
        coords={
            "speed": ("speed", chart.speed, _in_hertz(chart, "rotational frequency")),
            "gain": ("gain", chart.gain, {"long_name": chart.quantity.name, "units": chart.quantity.unit}),
        },
        attrs=_attributes(chart, _CHART),
    )


def limit_to_dataset(limit: Limit) -> xarray.Dataset:
    """The limit's arrays over the coordinate speed; kind and status as flags with their meanings."""
    unit = limit.quantity.unit
    return xarray.Dataset(
        data_vars={
            "gain": ("speed", limit.gain, {"long_name": f"critical {limit.quantity.name}", "units": unit}),
            "chatter_frequency": ("speed", limit.chatter_frequency, _in_hertz(limit, "chatter frequency")),
            "lobe": ("speed", limit.lobe, {"long_name": "whole waves between two passes, -1 where there is no limit"}),
            "kind": (
                "speed",
                limit.kind_code,
                flags("how the dominant multiplier leaves the unit circle", Kind),
            ),
            "status": ("speed", limit.status_code, flags("what became of the search", Status)),
            "stable_interval": (
                ("speed", "interval", "edge"),
                limit.intervals,
                {"long_name": "stable intervals within the bounds", "units": unit},
            ),
            "error": ("speed", limit.error, {"long_name": "estimated error of the gain", "units": unit}),
        },
        coords={"speed": ("speed", limit.speed, _in_hertz(limit, "rotational frequency"))},
        attrs={**_attributes(limit, _LIMIT), "bounds": np.asarray(limit.bounds, dtype=float)},
    )


def _in_hertz(result: Chart | Limit, name: str) -> dict[str, str]:
    return {"long_name": name, "units": hertz(result.speed_unit).strip() or "1"}


def _attributes(result: Chart | Limit, form: str) -> dict[str, Any]:
    return {
        "format": form,
        "quantity": json.dumps(result.quantity._asdict(), ensure_ascii=False),
        "speed_unit": result.speed_unit,
        "process": json.dumps(result.process, ensure_ascii=False),
        "method": json.dumps(result.method, ensure_ascii=False),
        "seconds": result.seconds,
        "compiling": result.compiling,
    }


def result_of(dataset: xarray.Dataset, source: str, *others: str) -> Result:
    """The result that a file's dataset stands for; ``source`` says in messages where it is from, and what
    ``others`` can be read beside the forms of results.
    """
    readers: dict[str, Callable[[Stored], Result]] = {
        _CHART: _read_chart,
        _LIMIT: _read_limit,
        WEAR_MAP: read_wear_map,
        SPECTRUM: read_spectrum,
        BOUNDARY: read_boundary,
        SENSITIVITIES: lambda stored: read_sensitivities(stored, _read_limit(stored)),
        MARCH: read_march,
        CUT: read_cut,
    }
    form = dataset.attrs.get("format")
    if not isinstance(form, str) or not form.startswith("lobex "):
        raise ValueError(f"{source} is not a lobex result; give a file that a result's save wrote")
    if form not in readers:
        known = ", ".join(map(repr, (*readers, *others)))
        raise ValueError(f"{source} has format {form!r}, and this version of lobex reads {known}; compute it again")
    return readers[form](Stored(dataset, source))


def _common(stored: Stored) -> dict[str, Any]:
    return {
        "quantity": stored.quantity("quantity"),
        "speed_unit": stored.unit("speed_unit"),
        "process": stored.description("process"),
        "method": stored.description("method"),
        "seconds": stored.number("seconds"),
        "compiling": stored.number("compiling"),
    }


def _read_chart(stored: Stored) -> Chart:
    axes = ("speed", "gain")
    return Chart(
        speed=stored.known("speed", "speed", increasing=True),
        gain=stored.known("gain", "gain", increasing=True),
        spectral_radius=stored.array("spectral_radius", *axes),
        multiplier=stored.complex("multiplier", *axes),
        chatter_frequency=stored.array("chatter_frequency", *axes),
        error=stored.array("error", *axes),
        status_code=stored.flags("status", PointStatus, *axes),
        **_common(stored),
    )


def _read_limit(stored: Stored) -> Limit:
    intervals = stored.array("stable_interval", "speed", "interval", "edge")
    if intervals.shape[2] != 2:
        stored.refuse("has variable 'stable_interval' with other than 2 edges")
    low, high = stored.numbers("bounds", 2)
    # Told by the frequency, for who reads the file with another program.
    stored.array("lobe", "speed", kind="i")
    return Limit(
        speed=stored.known("speed", "speed"),
        gain=stored.array("gain", "speed"),
        chatter_frequency=stored.array("chatter_frequency", "speed"),
        kind_code=stored.flags("kind", Kind, "speed"),
        status_code=stored.flags("status", Status, "speed"),
        intervals=intervals,
        error=stored.array("error", "speed"),
        bounds=(low, high),
        **_common(stored),
    )
