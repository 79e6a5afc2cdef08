"""Wear maps and spectra as labelled datasets, and back."""

import json
from typing import Any

import numpy as np
import xarray

from lobex.results.spectrum_map import SpectrumMap
from lobex.results.wear_map import WearMap

WEAR_MAP = "lobex wear map 1"
SPECTRUM = "lobex spectrum 1"

_SPEED = {"long_name": "rotational frequency", "units": "Hz"}
_ARRAYS = {
    "speed_history": (("lane", "revolution"), "rotational frequency of every revolution", "Hz"),
    "unworn": (("angle",), "profile before wear", "m"),
    "depth": (("lane", "angle"), "depth removed", "m"),
    "wear": (("lane", "revolution"), "cross-section removed", "m2"),
    "displacement": (("lane", "sample"), "displacement of the tip", "m"),
    "amplitude": (("lane", "revolution"), "largest displacement of the tip", "m"),
    "contact": (("lane", "revolution"), "share of time in contact", "1"),
    "input_energy": (("lane", "revolution"), "work of the contact that drives the tip back", "J"),
    "removal_energy": (("lane", "revolution"), "work of the tip on the coating", "J"),
    "damping_energy": (("lane", "revolution"), "energy lost in damping", "J"),
    "stored_energy": (("lane", "revolution"), "kinetic and strain energy at the end", "J"),
    "natural_frequency": (("mode",), "natural frequency", "Hz"),
}
_NUMBERS = (
    "samples_per_revolution",
    "lag",
    "usable_orders",
    "nodal_diameters",
    "radius",
    "axial_width",
    "seconds",
    "failed",
)


def wear_map_to_dataset(march: WearMap) -> xarray.Dataset:
    """The march's arrays over lanes (which carry their speed), angles, revolutions and samples."""
    return xarray.Dataset(
        data_vars={
            name: (axes, getattr(march, name), {"long_name": words, "units": unit})
            for name, (axes, words, unit) in _ARRAYS.items()
        },
        coords={
            "speed": ("lane", march.speed, _SPEED),
            "angle": ("angle", march.angle, {"long_name": "casing position", "units": "rad"}),
        },
        attrs={
            "format": WEAR_MAP,
            "model": json.dumps(march.model, ensure_ascii=False),
            **{name: getattr(march, name) for name in _NUMBERS},
        },
    )


def read_wear_map(dataset: xarray.Dataset) -> WearMap:
    """The march that a dataset was made of."""
    numbers: dict[str, Any] = {name: dataset.attrs[name].item() for name in _NUMBERS}
    arrays: dict[str, np.ndarray] = {name: dataset[name].to_numpy() for name in (*_ARRAYS, "speed", "angle")}
    return WearMap(model=json.loads(dataset.attrs["model"]), **arrays, **numbers)


def spectrum_to_dataset(spectrum: SpectrumMap) -> xarray.Dataset:
    """The amplitudes over speed and engine order, with the frequency of every point."""
    axes = ("speed", "order")
    return xarray.Dataset(
        data_vars={
            "amplitude": (axes, spectrum.amplitude, {"long_name": "amplitude of the tip", "units": "m"}),
            "natural_frequency": (
                "mode",
                spectrum.natural_frequency,
                {"long_name": "natural frequency", "units": "Hz"},
            ),
        },
        coords={
            "speed": ("speed", spectrum.speed, _SPEED),
            "order": ("order", spectrum.order, {"long_name": "frequency divided by speed", "units": "1"}),
            "frequency": (axes, spectrum.frequency, {"long_name": "frequency", "units": "Hz"}),
        },
        attrs={"format": SPECTRUM, "nodal_diameters": spectrum.nodal_diameters, "window": spectrum.window},
    )


def read_spectrum(dataset: xarray.Dataset) -> SpectrumMap:
    """The spectrum that a dataset was made of."""
    return SpectrumMap(
        speed=dataset["speed"].to_numpy(),
        order=dataset["order"].to_numpy(),
        amplitude=dataset["amplitude"].to_numpy(),
        natural_frequency=dataset["natural_frequency"].to_numpy(),
        nodal_diameters=int(dataset.attrs["nodal_diameters"]),
        window=str(dataset.attrs["window"]),
    )
