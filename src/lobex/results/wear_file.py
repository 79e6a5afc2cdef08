"""Wear maps and spectra as labelled datasets, and back."""

import json
from typing import Any

import numpy as np
import xarray

from lobex.results.spectrum_map import SpectrumMap
from lobex.results.stored import Stored
from lobex.results.wear_map import WearMap

WEAR_MAP = "lobex wear map 2"
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
_COUNTS = ("samples_per_revolution", "lag", "usable_orders", "nodal_diameters", "failed")
_NUMBERS = ("radius", "axial_width", "seconds", "compiling")


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
            **{name: getattr(march, name) for name in (*_COUNTS, *_NUMBERS)},
        },
    )


def read_wear_map(stored: Stored) -> WearMap:
    """The march that a dataset was made of."""
    arrays: dict[str, np.ndarray] = {name: stored.array(name, *dims) for name, (dims, _, _) in _ARRAYS.items()}
    if len(arrays["natural_frequency"]) == 0 or stored.size("revolution") == 0:
        stored.refuse("has no mode or no revolution")
    numbers: dict[str, Any] = {name: stored.number(name) for name in _NUMBERS}
    counts: dict[str, Any] = {name: stored.count(name) for name in _COUNTS}
    return WearMap(
        speed=stored.known("speed", "lane"),
        angle=stored.known("angle", "angle", increasing=True),
        model=stored.descriptions("model", "modes", "casing", "law"),
        **arrays,
        **numbers,
        **counts,
    )


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


def read_spectrum(stored: Stored) -> SpectrumMap:
    """The spectrum that a dataset was made of."""
    # A product of the others, for who reads the file with another program.
    stored.array("frequency", "speed", "order")
    return SpectrumMap(
        speed=stored.known("speed", "speed"),
        order=stored.known("order", "order", increasing=True),
        amplitude=stored.array("amplitude", "speed", "order"),
        natural_frequency=stored.known("natural_frequency", "mode"),
        nodal_diameters=stored.count("nodal_diameters"),
        window=stored.text("window"),
    )
