"""Marches and cuts as labelled datasets and back; the lanes, of whatever shape, lie along one dimension."""

import json
from typing import Any

import numpy as np
import xarray

from lobex.processes.quantity import Quantity
from lobex.results.cut import Cut
from lobex.results.march import March

MARCH = "lobex march 1"
CUT = "lobex cut 1"
_SPEED = {"long_name": "rotational frequency", "units": "Hz"}
_SAMPLES = ("displacement", "chip_thickness", "force")


def march_to_dataset(march: March) -> xarray.Dataset:
    """The march's arrays over lane, phase, output and state."""
    quantity, unit = march.quantity, "m" if "modes" in march.process else "1"
    displacement = march.displacement.reshape(march.speed.size, *march.displacement.shape[-2:])
    growth = {"long_name": "estimated error of the fitted |μ|", "units": "1"}
    return xarray.Dataset(
        data_vars={
            "displacement": (
                ("lane", "phase", "output"),
                displacement,
                {"long_name": "displacement at the contact", "units": unit},
            ),
            "state": (("lane", "component"), _flat(march.state), {"long_name": "state at the end"}),
            "multiplier": ("lane", march.multiplier.ravel(), {"long_name": "fitted multiplier μ", "units": "1"}),
            "growth_error": ("lane", march.growth_error.ravel(), growth),
        },
        coords={
            "speed": ("lane", march.speed.ravel(), _SPEED),
            "gain": ("lane", march.gain.ravel(), {"long_name": quantity.name, "units": quantity.unit}),
            "delay": ("lane", march.delay.ravel(), {"long_name": "delay, which is the period", "units": "s"}),
            "phase": ("phase", march.phase, {"long_name": "time in delays", "units": "1"}),
        },
        attrs={
            "format": MARCH,
            "lanes": json.dumps(march.speed.shape),
            "quantity": json.dumps(quantity._asdict(), ensure_ascii=False),
            "speed_unit": march.speed_unit,
            "process": json.dumps(march.process, ensure_ascii=False),
            "steps_per_period": march.steps_per_period,
            "seconds": march.seconds,
        },
    )


def cut_to_dataset(cut: Cut) -> xarray.Dataset:
    """The cut's arrays over lane, phase and state."""
    about = (
        {"long_name": "tool displacement", "units": "m"},
        {"long_name": "chip thickness", "units": "m"},
        {"long_name": "radial cutting force", "units": "N"},
    )
    samples = {n: (("lane", "phase"), _flat(getattr(cut, n)), a) for n, a in zip(_SAMPLES, about, strict=True)}
    return xarray.Dataset(
        data_vars={**samples, "state": (("lane", "component"), _flat(cut.state), {"long_name": "state at the end"})},
        coords={
            "speed": ("lane", cut.speed.ravel(), _SPEED),
            "depth": ("lane", cut.depth.ravel(), {"long_name": "depth of cut", "units": "m"}),
            "phase": ("phase", cut.phase, {"long_name": "revolutions", "units": "1"}),
        },
        attrs={
            "format": CUT,
            "lanes": json.dumps(cut.speed.shape),
            "feed": cut.feed,
            "modes": json.dumps(cut.modes, ensure_ascii=False),
            "law": json.dumps(cut.law, ensure_ascii=False),
            "steps_per_revolution": cut.steps_per_revolution,
            "seconds": cut.seconds,
        },
    )


def read_march(dataset: xarray.Dataset) -> March:
    """A march from a file of ``MARCH``."""
    attributes, lanes = dataset.attrs, _lanes(dataset)
    outputs = dataset["displacement"].to_numpy()
    multiplier = dataset["multiplier_real"].to_numpy() + 1j * dataset["multiplier_imag"].to_numpy()
    return March(
        **{name: dataset[name].to_numpy().reshape(lanes) for name in ("speed", "gain", "delay", "growth_error")},
        phase=dataset["phase"].to_numpy(),
        displacement=outputs.reshape(*lanes, *outputs.shape[1:]),
        state=dataset["state"].to_numpy().reshape(*lanes, -1),
        multiplier=multiplier.reshape(lanes),
        steps_per_period=int(attributes["steps_per_period"]),
        quantity=Quantity(**json.loads(attributes["quantity"])),
        speed_unit=str(attributes["speed_unit"]),
        process=json.loads(attributes["process"]),
        seconds=float(attributes["seconds"]),
    )


def read_cut(dataset: xarray.Dataset) -> Cut:
    """A cut from a file of ``CUT``."""
    attributes, lanes = dataset.attrs, _lanes(dataset)
    return Cut(
        **{name: dataset[name].to_numpy().reshape(lanes) for name in ("speed", "depth")},
        **{name: dataset[name].to_numpy().reshape(*lanes, -1) for name in (*_SAMPLES, "state")},
        phase=dataset["phase"].to_numpy(),
        feed=float(attributes["feed"]),
        steps_per_revolution=int(attributes["steps_per_revolution"]),
        modes=json.loads(attributes["modes"]),
        law=json.loads(attributes["law"]),
        seconds=float(attributes["seconds"]),
    )


def _flat(samples: np.ndarray) -> np.ndarray:
    return samples.reshape(-1, samples.shape[-1])


def _lanes(dataset: Any) -> tuple[int, ...]:
    return tuple(json.loads(dataset.attrs["lanes"]))
