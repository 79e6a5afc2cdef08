"""The reference cases of ``tests/data``, computed with lobex' own choice of method."""

import json
from pathlib import Path
from typing import Any

import numpy as np

import lobex

DATA = Path(__file__).parents[1] / "tests" / "data"
Case = dict[str, Any]
Row = dict[str, Any]


def read(name: str) -> tuple[dict[str, Case], list[Case]]:
    """Tools by name, and cases, of ``tests/data/<name>.json``."""
    content = json.loads((DATA / f"{name}.json").read_text())
    return {tool["name"]: tool for tool in content["tools"]}, content["cases"]


def multipliers(problem: str = "") -> list[Row]:
    """max|μ| of every case whose problem begins so, by ``lobex.sweep``."""
    tools, cases = read("multipliers")
    rows = []
    for case in cases:
        if case["problem"].startswith(problem):
            chart = lobex.sweep(_process(case, tools), [_speed(case)], [_gain(case)])
            rows.append(_row(case, case["spectral_radius"], chart.spectral_radius[0, 0]))
    return rows


def limits(problem: str = "") -> list[Row]:
    """The limits of every case whose problem begins so: exact of the rod, by ``lobex.critical_gain`` of milling."""
    tools, cases = read("limits")
    rows = []
    for case in cases:
        process = _process(case, tools)
        if not case["problem"].startswith(problem):
            continue
        if case["problem"] == "rod-rub":
            limit = lobex.exact_limit(process, _speed(case))
            rows.append(_row(case, case["critical_contact_stiffness_N_per_m"], limit.gain[0]))
            continue
        wanted = np.atleast_1d(case["critical_depth_m"])
        limit = lobex.critical_gain(process, _speed(case), (1e-5, 1.5 * float(wanted[-1])))
        # Ends of the stable intervals within the bounds, in the order of depth.
        edges = limit.intervals[0][np.isfinite(limit.intervals[0])][1:]
        rows += [_row(case, *pair) for pair in zip(wanted, edges[: len(wanted)], strict=True)]
    return rows


def _row(case: Case, reference: float, ours: float) -> Row:
    return {
        "problem": case["problem"],
        "point": _describe(case),
        "reference": float(reference),
        "lobex": float(ours),
        "difference": float(abs(ours / reference - 1)),
    }


def _describe(case: Case) -> str:
    """The case in a few words."""
    if case["problem"] == "delayed-mathieu":
        return f"δ = {case['delta']}, ε = {case['epsilon']}, b = {case['b']}, c = {case['damping']}"
    if case["problem"] == "rod-rub":
        words = [f"n = {case['elements']}, ξ = {case['damping_ratio']}, {case['speed_Hz']:g} Hz"]
        stiffness = case.get("contact_stiffness_N_per_m")
        return ", ".join(words + ([f"{stiffness / 1e6:g} MN/m"] if stiffness else []))
    words = [case["tool"], f"immersion {case['radial_immersion']:g} {case['direction']}", f"{case['speed_rpm']} rpm"]
    return ", ".join(words + ([f"{1e3 * case['depth_m']:g} mm"] if "depth_m" in case else []))


def _process(case: Case, tools: dict[str, Case]) -> Any:
    if case["problem"] == "delayed-mathieu":
        return lobex.DelayedMathieu(delta=case["delta"], epsilon=case["epsilon"], damping=case["damping"])
    if case["problem"] == "rod-rub":
        return lobex.Rub(lobex.Rod(case["elements"]).modes(case["damping_ratio"]))
    tool = tools[case["tool"]]
    modes = lobex.Modes.single(
        frequency=tool["natural_frequency_Hz"], damping_ratio=tool["damping_ratio"], mass=tool["modal_mass_kg"]
    )
    return lobex.Milling(
        lobex.Modes.plane(x=modes, y=modes) if "2dof" in case["problem"] else modes,
        teeth=tool["teeth"],
        tangential=tool["tangential_N_per_m2"],
        normal=tool["normal_N_per_m2"],
        radial_immersion=case["radial_immersion"],
        direction=case["direction"],
    )


def _speed(case: Case) -> float:
    if case["problem"] == "delayed-mathieu":
        return 1 / (2 * np.pi)
    return case["speed_Hz"] if "speed_Hz" in case else case["speed_rpm"] / 60


def _gain(case: Case) -> float:
    return next(case[key] for key in ("contact_stiffness_N_per_m", "depth_m", "b") if key in case)
