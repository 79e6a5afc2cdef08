"""How cost grows with modes, points, nodes and revolutions, and how two cores are best used: GROWTH.md, growth.png.

python benchmarks/cost_growth.py
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import NullFormatter

import lobex
from machine import machine
from measured_charts import MILL

HERE = Path(__file__).parent
ROUNDS = 3
MODES = (1, 2, 3, 5, 10, 20, 30)
POINTS = (1_000, 10_000, 100_000, 1_000_000)
NODES = (8, 12, 16, 24, 32, 48, 64)
REVOLUTIONS = (5, 10, 20, 40, 80)
# Work for the comparison of threads and devices: points, and nodes per piece.
BATCH, COUNT = 8192, 16


def seconds(function: Callable[[], object]) -> float:
    """The best of a few calls after the first."""
    function()
    times = []
    for _ in range(ROUNDS):
        begun = time.perf_counter()
        function()
        times.append(time.perf_counter() - begun)
    return min(times)


def curves() -> dict[str, tuple[str, np.ndarray, np.ndarray]]:
    """By name: what grows, its values, and seconds."""
    speeds, gains = np.linspace(100, 400, 64), np.linspace(4.5e4, 2e6, 64)
    rods = [lobex.Rub(lobex.Rod(n).modes(0.03)) for n in MODES]
    many = [(np.linspace(2000, 25000, n) / 60, np.linspace(0, 5e-3, n)) for n in (int(np.sqrt(p)) for p in POINTS)]
    few = np.linspace(2000, 25000, 64) / 60, np.linspace(0, 5e-3, 64)
    march = lobex.Rod(5).modes(0.03), lobex.Casing(), lobex.Linear(4.5e6), np.linspace(100, 800, 64)
    work: dict[str, tuple[str, tuple[int, ...], list[Callable[[], object]]]] = {
        "chart by CharacteristicRoots": (
            "modes",
            MODES,
            [lambda p=p: lobex.sweep(p, speeds, gains, lobex.CharacteristicRoots()) for p in rods],
        ),
        "chart by Duhamel, tolerance 1e-8": (
            "modes",
            MODES,
            [lambda p=p: lobex.sweep(p, speeds, gains / 10, lobex.Duhamel()) for p in rods],
        ),
        "milling chart, tolerance 1e-8": ("points", POINTS, [lambda g=g: lobex.sweep(MILL, *g) for g in many]),
        "milling chart of 4,096 points": (
            "nodes per piece",
            NODES,
            [lambda n=n: lobex.sweep(MILL, *few, lobex.Duhamel(nodes=n)) for n in NODES],
        ),
        "wear march, 64 speeds × 1,024 cells": (
            "revolutions",
            REVOLUTIONS,
            [lambda r=r: lobex.march_wear(*march, r, 1024) for r in REVOLUTIONS],
        ),
    }
    return {
        name: (axis, np.array(values, dtype=float), np.array([seconds(f) for f in functions]))
        for name, (axis, values, functions) in work.items()
    }


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Of the power law fitted to the upper half of the values, where the cost of a call no longer counts."""
    upper = slice(len(x) // 2, None)
    return float(np.polyfit(np.log(x[upper]), np.log(y[upper]), 1)[0])


def two_cores(kind: str) -> float:
    """Seconds for the same points: on one thread, on two threads of one device, or on two devices by shard_map."""
    import jax
    from jax.sharding import Mesh, PartitionSpec

    from lobex.floquet import power
    from lobex.operators.elimination import inverse

    method = lobex.Duhamel(nodes=COUNT)

    def point(speed: Any, gain: Any) -> Any:
        system = MILL.system(speed, gain)
        prepared = method.prepare(system)
        return power.pair_by_squaring(method.assemble(method.respond(prepared, system, inverse), system), 8).value

    speed, gain = np.tile(np.linspace(40, 400, 64), BATCH // 64), np.repeat(np.linspace(0, 5e-3, BATCH // 64), 64)
    size = 512
    with jax.enable_x64(True):
        if kind == "two devices":
            mesh = Mesh(np.array(jax.devices()[:2]), ("points",))
            both = jax.shard_map(
                jax.vmap(point),
                mesh=mesh,
                in_specs=PartitionSpec("points"),
                out_specs=PartitionSpec("points"),
                # Nothing is exchanged: there is nothing to check.
                check_vma=False,
            )
            run = jax.jit(both)
            # A chunk of the same size on each device.
            return seconds(
                lambda: [
                    np.asarray(run(speed[k : k + 2 * size], gain[k : k + 2 * size])) for k in range(0, BATCH, 2 * size)
                ]
            )
        run = jax.jit(jax.vmap(point))

        def chunk(k: int) -> np.ndarray:
            with jax.enable_x64(True):
                return np.asarray(run(speed[k : k + size], gain[k : k + size]))

        if kind == "one thread":
            return seconds(lambda: [chunk(k) for k in range(0, BATCH, size)])
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(2) as pool:
            return seconds(lambda: list(pool.map(chunk, range(0, BATCH, size))))


def compared() -> dict[str, float]:
    """Each way in a process of its own, since the number of devices is fixed at its start."""
    results = {}
    for kind in ("one thread", "two threads", "two devices"):
        flags = "--xla_force_host_platform_device_count=2" if kind == "two devices" else ""
        done = subprocess.run(
            [sys.executable, __file__, kind],
            env={**os.environ, "XLA_FLAGS": flags},
            check=True,
            capture_output=True,
            text=True,
        )
        results[kind] = json.loads(done.stdout.splitlines()[-1])
    return results


def draw(found: dict[str, tuple[str, np.ndarray, np.ndarray]]) -> None:
    """Seconds over what grows, one panel for each."""
    matplotlib.use("Agg")
    axes_of = list(dict.fromkeys(axis for axis, _, _ in found.values()))
    figure, axes = plt.subplots(1, len(axes_of), figsize=(3.1 * len(axes_of), 3.4), layout="constrained")
    colours = {"chart by Duhamel, tolerance 1e-8": "#c8553d"}
    for name, (axis, x, y) in found.items():
        ax = axes[axes_of.index(axis)]
        colour = colours.get(name, "#0b4f6c")
        ax.loglog(
            x,
            y,
            "o-" if colour == "#0b4f6c" else "s--",
            color=colour,
            label=f"{name}\n∝ {axis.split()[0]}$^{{{exponent(x, y):.2f}}}$",
        )
        ax.set_xlabel(axis)
        ax.grid(alpha=0.3, which="both")
        ax.legend(fontsize=7, loc="upper left")
        ax.margins(y=0.35)
        if x[-1] < 1000:
            ax.set_xticks(x, [f"{value:g}" for value in x])
            ax.set_xticks([], minor=True)
        ax.yaxis.set_minor_formatter(NullFormatter())
    axes[0].set_ylabel("time (s)")
    figure.savefig(HERE / "growth.png", dpi=130)


def main() -> None:
    """Measure, draw and write."""
    if len(sys.argv) > 1:
        print(json.dumps(two_cores(sys.argv[1])))
        return
    cores = compared()
    found = curves()
    draw(found)
    rows = [
        f"| {name} | {axis} | {', '.join(f'{v:,.0f}' for v in x)} | {', '.join(f'{s:.3g}' for s in y)} "
        f"| {exponent(x, y):.2f} |"
        for name, (axis, x, y) in found.items()
    ]
    text = "\n".join(
        [
            "# How cost grows",
            "",
            "Made by `python benchmarks/cost_growth.py`: the best of three warm calls. The exponent is fitted to the "
            "upper half of the values.",
            "",
            "| work | what grows | values | seconds | exponent |",
            "|---|---|---|---|---|",
            *rows,
            "",
            "![Time over modes, points, nodes and revolutions](growth.png)",
            "",
            f"## Two cores\n\n{BATCH:,} points of milling with {COUNT} nodes a piece, the same chunks each time:",
            "",
            "| how | seconds | against one thread |",
            "|---|---|---|",
            *(f"| {kind} | {spent:.3f} | {cores['one thread'] / spent:.2f} |" for kind, spent in cores.items()),
            "",
            "Threads inside one device are what `sweep` uses: they need no flag that is to be set before JAX starts, "
            "and chunks of different cost share the cores evenly.",
            "",
            f"Machine: {machine()}.",
            "",
        ]
    )
    (HERE / "GROWTH.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
