"""Marches and cuts as labelled datasets and back; the lanes, of whatever shape, lie along one dimension."""

import json
import math

import numpy as np
import xarray

from lobex.results.cut import Cut
from lobex.results.march import March
from lobex.results.stored import Stored

MARCH = "lobex march 2"
CUT = "lobex cut 2"
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
            "compiling": march.compiling,
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
            "compiling": cut.compiling,
        },
    )


def read_march(stored: Stored) -> March:
    """A march from a file of ``MARCH``."""
    lanes = _lanes(stored)
    outputs = stored.array("displacement", "lane", "phase", "output")
    return March(
        **{name: stored.known(name, "lane").reshape(lanes) for name in ("speed", "gain", "delay")},
        growth_error=stored.array("growth_error", "lane").reshape(lanes),
        phase=stored.known("phase", "phase", increasing=True),
        displacement=outputs.reshape(*lanes, *outputs.shape[1:]),
        state=stored.array("state", "lane", "component").reshape(*lanes, -1),
        multiplier=stored.complex("multiplier", "lane").reshape(lanes),
        steps_per_period=stored.count("steps_per_period"),
        quantity=stored.quantity("quantity"),
        speed_unit=stored.unit("speed_unit"),
        process=stored.description("process"),
        seconds=stored.number("seconds"),
        compiling=stored.number("compiling"),
    )


def read_cut(stored: Stored) -> Cut:
    """A cut from a file of ``CUT``."""
    lanes = _lanes(stored)
    return Cut(
        **{name: stored.known(name, "lane").reshape(lanes) for name in ("speed", "depth")},
        **{name: stored.array(name, "lane", "phase").reshape(*lanes, -1) for name in _SAMPLES},
        state=stored.array("state", "lane", "component").reshape(*lanes, -1),
        phase=stored.known("phase", "phase", increasing=True),
        feed=stored.number("feed"),
        steps_per_revolution=stored.count("steps_per_revolution"),
        modes=stored.description("modes"),
        law=stored.description("law"),
        seconds=stored.number("seconds"),
        compiling=stored.number("compiling"),
    )


def _lanes(stored: Stored) -> tuple[int, ...]:
    shape = stored.sizes("lanes")
    if math.prod(shape) != stored.size("lane"):
        stored.refuse(f"has attribute 'lanes' = {list(shape)}, which are not the {stored.size('lane')} lanes it holds")
    return shape


def _flat(samples: np.ndarray) -> np.ndarray:
    return samples.reshape(-1, samples.shape[-1])
