"""What a fresh process compiles for each verb's first call: PROGRAMS.md.

python benchmarks/programs.py            measure all of them and write the table
python benchmarks/programs.py NAME       measure one here, and list its programs
"""

import collections
import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np

from machine import machine

HERE = Path(__file__).parent
STAGES = {
    "/jax/core/compile/jaxpr_trace_duration": "tracing",
    "/jax/core/compile/jaxpr_to_mlir_module_duration": "lowering",
    "/jax/core/compile/backend_compile_duration": "compiling",
}

# Of each call in November 2026, when a model's numbers were still computed one operation, and so one program, at a
# time: programs, seconds spent on them, and processor seconds of the call.
BEFORE = {
    "sweep, rod": (48, 3.9, 5.4),
    "sweep, 1-DoF cutter": (40, 2.9, 4.2),
    "sweep, 2-DoF cutter": (43, 3.4, 5.1),
    "critical_gain, rod": (45, 3.4, 3.3),
    "critical_gain, 1-DoF cutter": (41, 9.7, 10.0),
    "critical_gain, 2-DoF cutter": (44, 7.5, 11.9),
    "exact_limit, rod": (62, 5.6, 6.2),
    "exact_limit, 1-DoF cutter": (46, 4.3, 4.8),
    "boundary, rod": (47, 8.1, 10.1),
    "boundary, 1-DoF cutter": (31, 6.5, 11.9),
    "boundary, 2-DoF cutter": (34, 7.2, 19.1),
    "sensitivities, rod": (63, 10.9, 13.3),
    "sensitivities, 1-DoF cutter": (42, 9.3, 14.2),
    "sensitivities, 2-DoF cutter": (45, 11.3, 18.3),
    "march_wear, rod": (48, 2.0, 2.9),
    # Later in that month, before what it answers beyond the nodes was bounded by its receptance.
    "critical_gain, coupled blades": (15, 96.3, 55.5),
}


def calls() -> dict[str, Callable[[], object]]:
    """The first calls by name; the models are made in them, as a user makes them."""
    import lobex

    def rod() -> lobex.Rub:
        return lobex.Rub(lobex.Rod(5).modes(0.03))

    def tool() -> lobex.Modes:
        return lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)

    def mill() -> lobex.Milling:
        return lobex.Milling(tool(), teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5, direction="down")

    def plane() -> lobex.Milling:
        one = lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993)
        both = lobex.Modes.plane(x=one, y=one)
        return lobex.Milling(both, teeth=2, tangential=6e8, normal=2e8, radial_immersion=0.05, direction="down")

    def stage() -> lobex.Rub:
        one = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=0.11)
        return lobex.Rub(lobex.Blading(one, 6, [0.013, -0.021, 0.004, 0.017, -0.009, -0.004], coupling=60.0))

    def lathe() -> lobex.Turning:
        return lobex.Turning(tool(), radial=2e8)

    slow, fast, quick = np.linspace(50, 400, 50), np.linspace(50, 400, 50), np.linspace(100, 400, 50)
    stiff, deep = np.linspace(4.5e4, 4.5e6, 50), np.linspace(0, 5e-3, 50)
    few = np.linspace(0, 49, 25).astype(int)
    bounds, depths = (0.0, 4.5e6), (0.0, 5e-3)
    return {
        "sweep, rod": lambda: lobex.sweep(rod(), slow, stiff),
        "sweep, 1-DoF cutter": lambda: lobex.sweep(mill(), fast, deep),
        "sweep, 2-DoF cutter": lambda: lobex.sweep(plane(), quick, deep),
        "critical_gain, rod": lambda: lobex.critical_gain(rod(), slow, bounds),
        "critical_gain, 1-DoF cutter": lambda: lobex.critical_gain(mill(), fast, depths),
        "critical_gain, 2-DoF cutter": lambda: lobex.critical_gain(plane(), quick, depths),
        "exact_limit, rod": lambda: lobex.exact_limit(rod(), slow),
        "exact_limit, 1-DoF cutter": lambda: lobex.exact_limit(lathe(), fast),
        "boundary, rod": lambda: lobex.boundary(rod(), slow[25:], stiff[few]),
        "boundary, 1-DoF cutter": lambda: lobex.boundary(mill(), fast[25:], deep[few]),
        "boundary, 2-DoF cutter": lambda: lobex.boundary(plane(), quick[25:], deep[few]),
        "sensitivities, rod": lambda: lobex.sensitivities(rod(), slow),
        "sensitivities, 1-DoF cutter": lambda: lobex.sensitivities(mill(), fast, depths),
        "sensitivities, 2-DoF cutter": lambda: lobex.sensitivities(plane(), quick, depths),
        "march_wear, rod": lambda: lobex.march_wear(
            lobex.Rod(5).modes(0.03), lobex.Casing(), lobex.Linear(4.5e6), slow, 5, 1024
        ),
        "critical_gain, coupled blades": lambda: lobex.critical_gain(stage(), np.linspace(50, 160, 6), (1e3, 3e5)),
    }


def measured(name: str) -> dict[str, Any]:
    """Programs compiled by one call in this process, what was spent on them, and the processor time of the call."""
    seconds: collections.Counter[str] = collections.Counter()
    programs: list[str] = []

    def listen(event: str, duration: float, **about: object) -> None:
        if event in STAGES:
            seconds[STAGES[event]] += duration
        if STAGES.get(event) == "compiling":
            programs.append(str(about.get("fun_name")))

    jax.monitoring.register_event_duration_secs_listener(listen)
    before = resource.getrusage(resource.RUSAGE_SELF)
    calls()[name]()
    after = resource.getrusage(resource.RUSAGE_SELF)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"programs": programs, "seconds": dict(seconds), "processor": spent}


def in_a_fresh_process(name: str) -> dict[str, Any]:
    """``measured`` where nothing is compiled or cached yet."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    done = subprocess.run(
        [sys.executable, __file__, name, "--json"], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


def table() -> str:
    """The page: every call in a process of its own."""
    rows = []
    for name in calls():
        found = in_a_fresh_process(name)
        programs, seconds = len(found["programs"]), sum(found["seconds"].values())
        old, old_seconds, old_processor = BEFORE[name]
        rows.append(
            f"| {name} | {old} | {programs} | {old_seconds:.1f} | {seconds:.1f} | {old_processor:.1f} "
            f"| {found['processor']:.1f} |"
        )
        print(rows[-1], flush=True)
    return "\n".join(
        [
            "# Programs that a first call compiles",
            "",
            "Made by `python benchmarks/programs.py`: each call in a fresh process with nothing cached, models made in "
            "it. Seconds are those of tracing, lowering and compiling, added up over threads, and processor seconds "
            "those of the whole call. What was before is written in that script.",
            "",
            "| first call | programs before | now | seconds before | now | processor seconds before | now |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
            f"Machine: {machine()}.",
            "",
        ]
    )


if __name__ == "__main__":
    if len(sys.argv) == 1:
        (HERE / "PROGRAMS.md").write_text(table())
    elif "--json" in sys.argv:
        print(json.dumps(measured(sys.argv[1])))
    else:
        one = measured(sys.argv[1])
        print(one["seconds"], one["processor"])
        for program, count in collections.Counter(one["programs"]).most_common():
            print(count, program)
