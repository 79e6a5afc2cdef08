"""Results as NetCDF-4 files, which Python, MATLAB and Julia open, and back."""

import json
import os
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from lobex import _checks
from lobex.processes.quantity import Quantity, hertz
from lobex.results.boundary import FORM as BOUNDARY
from lobex.results.boundary import Boundary, boundary_from
from lobex.results.chart import Chart
from lobex.results.cut import Cut
from lobex.results.limit import Kind, Limit, Status
from lobex.results.march import March
from lobex.results.march_file import CUT, MARCH, read_cut, read_march
from lobex.results.sensitivities import FORM as SENSITIVITIES
from lobex.results.sensitivities import Sensitivities, sensitivities_from
from lobex.results.spectrum_map import SpectrumMap
from lobex.results.study import FORM as STUDY
from lobex.results.study import Study
from lobex.results.wear_file import SPECTRUM, WEAR_MAP, read_spectrum, read_wear_map
from lobex.results.wear_map import WearMap
from lobex.studies.export import study_from

Result = Chart | Limit | Sensitivities | Boundary | WearMap | SpectrumMap | March | Cut | Study

_CHART = "lobex chart 2"
_LIMIT = "lobex limit 1"


def chart_to_dataset(chart: Chart) -> xarray.Dataset:
    """The chart's arrays over the coordinates speed and gain."""
    axes = ("speed", "gain")
    return xarray.Dataset(
        data_vars={
            "spectral_radius": (axes, chart.spectral_radius, {"long_name": "spectral radius max|μ|", "units": "1"}),
            "multiplier": (axes, chart.multiplier, {"long_name": "dominant Floquet multiplier μ", "units": "1"}),
            "chatter_frequency": (axes, chart.chatter_frequency, _in_hertz(chart, "chatter frequency")),
            "error": (axes, chart.error, {"long_name": "estimated relative error of max|μ|", "units": "1"}),
        },
        coords={
            "speed": ("speed", chart.speed, _in_hertz(chart, "rotational frequency")),
            "gain": ("gain", chart.gain, {"long_name": chart.quantity.name, "units": chart.quantity.unit}),
        },
        attrs={**_attributes(chart, _CHART), "failed": chart.failed, "repeated": chart.repeated},
    )


def limit_to_dataset(limit: Limit) -> xarray.Dataset:
    """The limit's arrays over the coordinate speed; kind and status as flags with their meanings."""
    unit = limit.quantity.unit
    return xarray.Dataset(
        data_vars={
            "gain": ("speed", limit.gain, {"long_name": f"critical {limit.quantity.name}", "units": unit}),
            "chatter_frequency": ("speed", limit.chatter_frequency, _in_hertz(limit, "chatter frequency")),
            "kind": ("speed", limit.kind_code, _flags("how the dominant multiplier leaves the unit circle", Kind)),
            "status": ("speed", limit.status_code, _flags("what became of the search", Status)),
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
    }


def _flags(name: str, codes: type[IntEnum]) -> dict[str, Any]:
    meanings = " ".join(code.name.lower() for code in codes)
    return {"long_name": name, "flag_values": np.array(list(codes), dtype=np.int8), "flag_meanings": meanings}


def save_dataset(dataset: xarray.Dataset, path: str | os.PathLike[str]) -> None:
    """Write ``path`` in one step: a file beside it is written first and then takes its place."""
    target = _checks.writable("path", path)
    dataset = in_parts(dataset)
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        dataset.to_netcdf(partial, engine="h5netcdf", format="NETCDF4")
        os.replace(partial, target)
    except OSError as error:
        raise ValueError(f"path = {str(target)!r} cannot be written ({error}); choose another place") from error
    finally:
        partial.unlink(missing_ok=True)


def in_parts(dataset: xarray.Dataset) -> xarray.Dataset:
    """Real and imaginary parts: a complex type is outside the NetCDF-4 standard and MATLAB cannot read it."""
    if "multiplier" not in dataset:
        return dataset
    multiplier = dataset["multiplier"]
    for part, values in (("real", multiplier.real), ("imag", multiplier.imag)):
        dataset[f"multiplier_{part}"] = values.assign_attrs(long_name=f"{part} part of μ", units="1")
    return dataset.drop_vars("multiplier")


def load(path: str | os.PathLike[str]) -> Result:
    """Read what the ``save`` of a result wrote. Raises ValueError for any other file, or none."""
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"path = {str(path)!r} is not a file; give the .nc file that a result was saved to")
    try:
        with xarray.open_dataset(source, engine="h5netcdf") as stored:
            dataset = stored.load()
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"path = {str(path)!r} is no readable NetCDF-4 file ({error})") from error
    result = result_of(dataset)
    if result is None:
        raise ValueError(f"path = {str(path)!r} is not a lobex result; give a file that a result's save wrote")
    return result


def result_of(dataset: xarray.Dataset) -> Result | None:
    """The result that a file's dataset stands for, or None where it is of no known format."""
    readers: dict[Any, Callable[[xarray.Dataset], Result]] = {
        _CHART: _read_chart,
        _LIMIT: _read_limit,
        WEAR_MAP: read_wear_map,
        SPECTRUM: read_spectrum,
        BOUNDARY: boundary_from,
        SENSITIVITIES: lambda dataset: sensitivities_from(dataset, _read_limit(dataset)),
        MARCH: read_march,
        CUT: read_cut,
        STUDY: study_from,
    }
    reader = readers.get(dataset.attrs.get("format"))
    return None if reader is None else reader(dataset)


def _common(dataset: xarray.Dataset) -> dict[str, Any]:
    attributes = dataset.attrs
    return {
        "speed": dataset["speed"].to_numpy(),
        "chatter_frequency": dataset["chatter_frequency"].to_numpy(),
        "quantity": Quantity(**json.loads(attributes["quantity"])),
        "speed_unit": str(attributes["speed_unit"]),
        "process": json.loads(attributes["process"]),
        "method": json.loads(attributes["method"]),
        "seconds": float(attributes["seconds"]),
    }


def _read_chart(dataset: xarray.Dataset) -> Chart:
    return Chart(
        gain=dataset["gain"].to_numpy(),
        spectral_radius=dataset["spectral_radius"].to_numpy(),
        multiplier=dataset["multiplier_real"].to_numpy() + 1j * dataset["multiplier_imag"].to_numpy(),
        error=dataset["error"].to_numpy(),
        failed=int(dataset.attrs["failed"]),
        repeated=int(dataset.attrs["repeated"]),
        **_common(dataset),
    )


def _read_limit(dataset: xarray.Dataset) -> Limit:
    low, high = np.asarray(dataset.attrs["bounds"], dtype=float)
    return Limit(
        gain=dataset["gain"].to_numpy(),
        kind_code=dataset["kind"].to_numpy(),
        status_code=dataset["status"].to_numpy(),
        intervals=dataset["stable_interval"].to_numpy(),
        error=dataset["error"].to_numpy(),
        bounds=(float(low), float(high)),
        **_common(dataset),
    )
