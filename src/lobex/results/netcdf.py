"""Charts as NetCDF-4 files, which Python, MATLAB and Julia open, and back."""

import json
import os
from pathlib import Path
from typing import Any

import xarray

from lobex import _checks
from lobex.processes.quantity import Quantity
from lobex.results.chart import Chart

_FORMAT = "lobex chart 1"


def chart_to_dataset(chart: Chart) -> xarray.Dataset:
    """The chart's arrays over the coordinates speed and gain."""
    axes = ("speed", "gain")
    quantity = chart.quantity
    return xarray.Dataset(
        data_vars={
            "spectral_radius": (
                axes,
                chart.spectral_radius,
                {"long_name": "spectral radius max|μ|", "units": "1"},
            ),
            "multiplier": (
                axes,
                chart.multiplier,
                {"long_name": "dominant Floquet multiplier μ", "units": "1"},
            ),
            "chatter_frequency": (
                axes,
                chart.chatter_frequency,
                {"long_name": "chatter frequency", "units": "Hz"},
            ),
        },
        coords={
            "speed": ("speed", chart.speed, {"long_name": "rotational frequency", "units": "Hz"}),
            "gain": ("gain", chart.gain, {"long_name": quantity.name, "units": quantity.unit}),
        },
        attrs={
            "format": _FORMAT,
            "quantity": json.dumps(quantity._asdict(), ensure_ascii=False),
            "speed_unit": chart.speed_unit,
            "process": json.dumps(chart.process, ensure_ascii=False),
            "method": json.dumps(chart.method, ensure_ascii=False),
            "seconds": chart.seconds,
            "failed": chart.failed,
            "repeated": chart.repeated,
        },
    )


def save_chart(chart: Chart, path: str | os.PathLike[str]) -> None:
    """Write ``path`` in one step: a file beside it is written first and then takes its place."""
    target = _checks.writable("path", path)
    dataset = chart_to_dataset(chart)
    # Real and imaginary parts: a complex type is outside the NetCDF-4 standard and MATLAB cannot read it.
    multiplier = dataset["multiplier"]
    for part, values in (("real", multiplier.real), ("imag", multiplier.imag)):
        dataset[f"multiplier_{part}"] = values.assign_attrs(long_name=f"{part} part of μ", units="1")
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        dataset.drop_vars("multiplier").to_netcdf(partial, engine="h5netcdf", format="NETCDF4")
        os.replace(partial, target)
    except OSError as error:
        raise ValueError(f"path = {str(target)!r} cannot be written ({error}); choose another place") from error
    finally:
        partial.unlink(missing_ok=True)


def load(path: str | os.PathLike[str]) -> Chart:
    """Read a chart that ``Chart.save`` wrote. Raises ValueError for a file that is missing or is no chart."""
    source = Path(path)
    if not source.is_file():
        raise ValueError(f"path = {str(path)!r} is not a file; give the .nc file that a chart was saved to")
    try:
        with xarray.open_dataset(source, engine="h5netcdf") as stored:
            dataset = stored.load()
    except (OSError, ValueError, KeyError) as error:
        raise ValueError(f"path = {str(path)!r} is no readable NetCDF-4 file ({error})") from error
    if dataset.attrs.get("format") != _FORMAT:
        raise ValueError(f"path = {str(path)!r} is not a lobex chart; give a file that Chart.save wrote")
    attributes: dict[str, Any] = dataset.attrs
    return Chart(
        speed=dataset["speed"].to_numpy(),
        gain=dataset["gain"].to_numpy(),
        spectral_radius=dataset["spectral_radius"].to_numpy(),
        multiplier=dataset["multiplier_real"].to_numpy() + 1j * dataset["multiplier_imag"].to_numpy(),
        chatter_frequency=dataset["chatter_frequency"].to_numpy(),
        quantity=Quantity(**json.loads(attributes["quantity"])),
        speed_unit=str(attributes["speed_unit"]),
        process=json.loads(attributes["process"]),
        method=json.loads(attributes["method"]),
        seconds=float(attributes["seconds"]),
        failed=int(attributes["failed"]),
        repeated=int(attributes["repeated"]),
    )
