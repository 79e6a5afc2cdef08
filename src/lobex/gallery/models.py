"""The thesis' models, and what several figures compute of them."""

from functools import cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from jaxtyping import Float

import lobex

if TYPE_CHECKING:
    import xarray

CONTACT_STIFFNESS = (4.5e4, 4.5e6)
"""Chapter 4's range of K_e, N/m."""
RADIAL = 2e8
"""Radial specific cutting force K_r of the turning figures, N/m²: §3.4's K_n."""


def grid(low: float, high: float, count: int, share: float) -> np.ndarray:
    """``count`` equal steps' worth of points from low to high, or that share of them."""
    return np.linspace(low, high, max(round(share * (count - 1)), 4) + 1)


def rub(
    elements: int = 5,
    damping_ratio: float = 0.03,
    keep: tuple[int, ...] | None = None,
    stiffness: float = 1.0,
    mass: float = 1.0,
) -> lobex.Rub:
    """Chapter 4's rod in permanent contact, its stiffness (4.1) and mass (4.2) multiplied by factors.

    ξ is 0.03 as in the text; Appendix B has 0.0177, and the figures do not say which they are drawn with.
    """
    nominal = lobex.Rod(elements)
    rod = lobex.Rod(elements, stiffness * nominal.young_modulus, mass * nominal.density)
    return lobex.Rub(rod.modes(damping_ratio, keep=keep))


def natural_frequency(elements: int = 5) -> Float[np.ndarray, " elements"]:
    """Of the rod, Hz."""
    modes: Any = rub(elements).modes
    return np.asarray(modes.frequency)


def tool() -> lobex.Modes:
    """§3.4's tool."""
    return lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)


def turning() -> lobex.Turning:
    """Turning with §3.4's tool; the thesis shows its turning figures without parameters."""
    return lobex.Turning(tool(), radial=RADIAL)


def milling() -> lobex.Milling:
    """§3.4's milling: one tooth, down, half immersion as in Appendix A."""
    return lobex.Milling(tool(), teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5, direction="down")


def limits(process: Any, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The exact stability limit and its chatter frequency (Hz) at every speed."""
    found = lobex.exact_limit(process, speed)
    return found.gain, found.chatter_frequency


def family(
    along: str, values: Any, speed: np.ndarray, gain: Any, frequency: Any = None, meaning: str = ""
) -> "xarray.Dataset":
    """Critical contact stiffnesses over speed, one row for each value of what the figure varies."""
    import xarray

    axes = (along, "speed")
    stiffness = {"long_name": "critical contact stiffness", "units": "N/m"}
    variables = {"critical_stiffness": (axes, np.asarray(gain), stiffness)}
    if frequency is not None:
        variables["chatter_frequency"] = (axes, np.asarray(frequency), {"long_name": "at the limit", "units": "Hz"})
    coordinates = {
        along: (along, np.asarray(values), {"long_name": meaning or along}),
        "speed": ("speed", speed, {"long_name": "rotational frequency", "units": "Hz"}),
    }
    return xarray.Dataset(variables, coordinates)


def least(process: Any, lobes: int = 4) -> tuple[float, np.ndarray, float]:
    """The least limit over all speeds, the speeds of lobes 1, 2, … that reach it (Hz), and its frequency (Hz)."""
    minimum = lobex.exact_lobes(process, lobes).minimum
    return float(minimum.gain), np.asarray(minimum.speed), float(minimum.angular_frequency) / (2 * np.pi)


@cache
def wear(nodal_diameters: int, share: float) -> lobex.WearMap:
    """Chapter 1's march: 20 revolutions at speeds of 30 to 1,500 Hz, close together where the blade resonates.

    The thesis gives no contact stiffness, profile or step for it: cos² bumps of 0.1 mm, no clearance and 4.5 MN/m
    show what it reports.
    """
    speed = np.r_[grid(30, 400, 371, share)[:-1], grid(400, 1500, 221, share)]
    march = lobex.march_wear(
        lobex.Rod(10).modes(0.03),
        lobex.Casing(nodal_diameters, amplitude=1e-4),
        lobex.Linear(4.5e6),
        speed,
        revolutions=20,
        steps_per_revolution=2048,
        samples_per_revolution=256,
    )
    # Of one contact.
    return cast(lobex.WearMap, march)


def removed(march: lobex.WearMap) -> "xarray.Dataset":
    """The volume removed over the speed."""
    import xarray

    volume = {"long_name": "volume removed per metre of axial width", "units": "m³"}
    speed = {"long_name": "rotational frequency", "units": "Hz"}
    return xarray.Dataset({"volume": ("speed", march.volume, volume)}, {"speed": ("speed", march.speed, speed)})


def peak_speed(speed: np.ndarray, height: np.ndarray, near: float) -> float:
    """The speed of the largest value between 0.85 and 1.25 times a critical speed, Hz."""
    inside = (speed > 0.85 * near) & (speed < 1.25 * near)
    return float(speed[inside][np.argmax(height[inside])])
