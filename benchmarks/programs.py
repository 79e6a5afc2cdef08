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

import jax
import numpy as np

HERE = Path(__file__).parent
STAGES = {
    "/jax/core/compile/jaxpr_trace_duration": "tracing",
    "/jax/core/compile/jaxpr_to_mlir_module_duration": "lowering",
    "/jax/core/compile/backend_compile_duration": "compiling",
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
    }


def measured(name: str) -> dict[str, object]:
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


def in_a_fresh_process(name: str) -> dict[str, object]:
    """``measured`` where nothing is compiled or cached yet."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith("JAX_")}
    done = subprocess.run(
        [sys.executable, __file__, name, "--json"], env=environment, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


if __name__ == "__main__":
    if len(sys.argv) > 1:
        found = measured(sys.argv[1])
        if "--json" in sys.argv:
            print(json.dumps(found))
        else:
            print(len(found["programs"]), found["seconds"], found["processor"])
            for program, count in collections.Counter(found["programs"]).most_common():
                print(count, program)
    else:
        for name in calls():
            found = in_a_fresh_process(name)
            print(name, len(found["programs"]), found["seconds"], round(found["processor"], 1), flush=True)
