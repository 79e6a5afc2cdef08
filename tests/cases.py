"""The reference cases (numbers from two or three independent codes) and the models that tests share."""

import json
from pathlib import Path
from typing import Any

import numpy as np

import lobex

_DATA = Path(__file__).parent / "data"


GENERAL: dict[str, Any] = json.loads((_DATA / "general.json").read_text())
"""Cases of several delays, delays apart from the period, and delays that vary."""


def reference(name: str) -> tuple[dict[str, dict[str, Any]], list[dict[str, Any]]]:
    """The tools, by name, and the cases of ``data/<name>.json``."""
    content = json.loads((_DATA / f"{name}.json").read_text())
    return {tool["name"]: tool for tool in content["tools"]}, content["cases"]


MULTIPLIER_TOOLS, MULTIPLIER_CASES = reference("multipliers")
LIMIT_TOOLS, LIMIT_CASES = reference("limits")


def label(case: dict[str, Any]) -> str:
    """A short test name."""
    keys = ("tool", "radial_immersion", "direction", "speed_rpm", "speed_Hz", "damping_ratio", "epsilon")
    values = [case[k] for k in (*keys, "depth_m", "contact_stiffness_N_per_m") if k in case]
    return "-".join([case["problem"], *(str(v) for v in values)])


def milling(tool: dict[str, Any], radial_immersion: float, direction: str, directions: int = 1) -> lobex.Milling:
    """Milling with one of the reference tools."""
    modes = lobex.Modes.single(
        frequency=tool["natural_frequency_Hz"],
        damping_ratio=tool["damping_ratio"],
        mass=tool["modal_mass_kg"],
    )
    return lobex.Milling(
        lobex.Modes.plane(x=modes, y=modes) if directions == 2 else modes,
        teeth=tool["teeth"],
        tangential=tool["tangential_N_per_m2"],
        normal=tool["normal_N_per_m2"],
        radial_immersion=radial_immersion,
        direction=direction,
    )


def rub(elements: int = 5, damping_ratio: float = 0.03, **rod: float) -> lobex.Rub:
    """The thesis' rod in permanent contact."""
    return lobex.Rub(lobex.Rod(elements, **rod).modes(damping_ratio))


def point(case: dict[str, Any]) -> tuple[Any, float, float]:
    """Process, speed in Hz and gain of a reference case."""
    if case["problem"].startswith("milling"):
        directions = 2 if "2dof" in case["problem"] else 1
        tool = MULTIPLIER_TOOLS[case["tool"]]
        process = milling(tool, case["radial_immersion"], case["direction"], directions)
        return process, case["speed_rpm"] / 60, case["depth_m"]
    if case["problem"] == "delayed-mathieu":
        process = lobex.DelayedMathieu(delta=case["delta"], epsilon=case["epsilon"], damping=case["damping"])
        return process, 1 / (2 * np.pi), case["b"]
    process = rub(case["elements"], case["damping_ratio"])
    return process, case["speed_Hz"], case.get("contact_stiffness_N_per_m", np.nan)


THESIS_TOOL = MULTIPLIER_TOOLS["thesis-3.4"]
ROD = rub()
"""Chapter 4's rod: 5 elements, ξ = 0.03."""
MILL = milling(THESIS_TOOL, 0.5, "down")
"""§3.4's milling: one tooth, half immersion, down."""


def assert_same_fields(actual: Any, expected: Any) -> None:
    """Every field of two results is equal, arrays bit for bit and in type."""
    for name, value in vars(expected).items():
        if isinstance(value, np.ndarray):
            assert getattr(actual, name).dtype == value.dtype, name
            np.testing.assert_array_equal(getattr(actual, name), value, err_msg=name)
        else:
            assert getattr(actual, name) == value, name
