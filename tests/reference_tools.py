"""Reference cases of cutters and turning tools: variable pitch, process damping and motion, groups a, e and f."""

from collections.abc import Iterator
from math import pi
from typing import Any

import numpy as np

import lobex
from reference_tasks import Case, Motion, Multiplier, Task, crossings, lowest, name


def cutter(tool: Case, case: Case) -> Any:
    """The tool of a case."""
    modes = tool["modes"]
    frequency, ratio, mass = (
        np.array([mode[key] for mode in modes]) for key in ("frequency_Hz", "damping_ratio", "modal_mass_kg")
    )
    along = np.array([[float(mode["axis"] == axis) for axis in "xy"] for mode in modes])
    immersion = 1.0 if case["direction"] == "slot" else case["radial_immersion"]
    direction = "down" if case["direction"] == "slot" else case["direction"]
    others: dict[str, Any] = {"feed_per_tooth": case["feed_per_tooth_m"]} if "feed_per_tooth_m" in case else {}
    diameter = (tool | case).get("diameter_m")
    if damping := tool.get("process_damping"):
        diameter = 2 * damping["radius_m"]
        others["process_damping"] = lobex.ProcessDamping(damping["C_N_per_m"], damping["mu_f"])
    helix = np.atleast_1d(case.get("helix_deg") or 0.0)
    geometry = lobex.Cutter.end_mill(
        diameter,
        pitch_degrees=(tool | case)["pitch_deg"],
        helix_degrees=helix[0] if len(set(helix)) == 1 else helix,
        runout=case.get("runout_m"),
    )
    structure = lobex.Modes(2 * pi * frequency, ratio, along / np.sqrt(mass)[:, None])

    forces = tool["Kt_N_per_m2"], tool["Kn_N_per_m2"]
    return lobex.Milling(structure, geometry, *forces, immersion, direction, **others)


def periods(cutter: lobex.Cutter) -> int:
    """Of how many periods of the process the file tells a multiplier: of a tooth's where all are alike, else of a
    revolution's."""
    return 1 if cutter.alike == cutter.teeth else cutter.alike


def variable_pitch(content: Case) -> Iterator[Task]:
    """Group a."""
    for case in content["mu"]:
        process = cutter(content["tools"][case["tool"]], case)
        told = periods(process.cutter)
        yield Multiplier("a mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, told)
    for case in content["critical"]:
        process = cutter(content["tools"][case["tool"]], case)
        yield crossings("a critical", process, case["rpm"] / 60, case, "depth_m")


def helix(content: Case) -> Iterator[Task]:
    """Group b."""
    for part in ("mu", "variable_mu", "critical", "variable_critical"):
        for case in content.get(part, []):
            tool = content["tools"][case["tool"]] | case.get("changes", {})
            process, speed = cutter(tool, tool | case), case["rpm"] / 60
            if part.endswith("mu"):
                told = periods(process.cutter)
                yield Multiplier(f"b {part}", name(case), process, speed, case["depth_m"], case, told)
            else:
                yield crossings(f"b {part}", process, speed, case, "depth_m")


def forced_motion(content: Case) -> Iterator[Task]:
    """Group f."""
    for part in ("straight", "helix"):
        for case in content.get(part, []):
            tool = content["tools"][case["tool"]]
            process, depth = cutter(tool, case), case["depth_m"]
            heights = np.array(case.get("heights_m", [0.0])) / depth
            told = periods(process.cutter)
            yield Motion(f"f {part}", name(case), process, case["rpm"] / 60, depth, heights, case, told)


def process_damping(content: Case) -> Iterator[Task]:
    """Group e."""
    for case in content["milling_mu"]:
        tool = content["tools"][case["tool"]]
        process = cutter(tool, tool)
        told = periods(process.cutter)
        yield Multiplier("e milling_mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, told)
    for case in content["milling_critical"]:
        tool = content["tools"][case["tool"]]
        yield crossings("e milling_critical", cutter(tool, tool), case["rpm"] / 60, case, "depth_m")
    for case in content["turning"]:
        machine = content["machines"][case["machine"]]
        frequency, ratio, mass = (
            np.array([mode[key] for mode in machine["modes"]])
            for key in ("frequency_Hz", "damping_ratio", "modal_mass_kg")
        )
        process = lobex.Turning(
            lobex.Modes(2 * pi * frequency, ratio, 1 / np.sqrt(mass)[:, None]),
            machine["K_N_per_m2"],
            diameter=2 * machine["radius_m"],
            process_damping=lobex.ProcessDamping(machine["C_N_per_m"]),
        )
        speed = case["rpm"] / 60
        # The largest depth that anybody cuts, unless the file's limit lies above.
        bounds = 1e-6, max(3e-3, 2 * (case["depth_m"] or 0.0))
        yield lowest("e turning limit", process, speed, case, case["depth_m"], bounds, 129)
        for point in case["points"]:
            whole = f"{name(case)} depth={point['depth_m']:g}"
            yield Multiplier("e turning mu", whole, process, speed, point["depth_m"], point)
