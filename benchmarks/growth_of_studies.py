"""How time and memory grow with a study, and what larger ones would cost; writes STUDIES.md and studies.png.

    python benchmarks/growth_of_studies.py

Every study runs in a process of its own, with a store, on all cores. One that compiles everything runs before it and
is not counted. The two models: a blade rub by characteristic roots, over its damping, and milling by operators of
chosen size, over the cutting force.
"""

import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import jax
import matplotlib
import numpy as np

import lobex

HERE = Path(__file__).parent
SPEEDS, GAINS = 250, 400
SIZES = {"rub": (1, 3, 10, 30, 100), "milling": (1, 3, 10)}
WARM = 10
METHODS = {"rub": "characteristic roots", "milling": "Duhamel, tolerance 1e-8"}
LARGE = (1e8, 1e12)


def study(name: str, combinations: int, folder: str) -> None:
    """One study, to a store."""
    if name == "rub":
        process = lobex.Rub(lobex.Rod(5).modes(0.03))
        axis = {"modes.damping_ratio": np.linspace(0.01, 0.05, combinations)}
        lobex.sweep(process, np.linspace(50, 400, SPEEDS), np.linspace(4.5e4, 4.5e6, GAINS), over=axis, store=folder)
        return
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
    mill = lobex.Milling(tool, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5)
    axis = {"tangential": np.linspace(4e8, 7e8, combinations)}
    lobex.sweep(mill, np.linspace(2000, 25000, SPEEDS) / 60, np.linspace(0, 5e-3, GAINS), over=axis, store=folder)


def measured(name: str, combinations: int) -> dict[str, float]:
    """Seconds, peak memory in GB and size of the store in MB, of a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, name, str(combinations), folder]
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def one(name: str, combinations: int, folder: str) -> None:
    """What ``measured`` runs."""
    study(name, WARM, f"{folder}/warm")
    begun, used = time.perf_counter(), time.process_time()
    study(name, combinations, f"{folder}/store")
    seconds, core_seconds = time.perf_counter() - begun, time.process_time() - used
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e9 if sys.platform == "darwin" else 1e6)
    size = sum(path.stat().st_size for path in Path(folder, "store").iterdir()) / 1e6
    print(json.dumps({"seconds": seconds, "core_seconds": core_seconds, "memory": peak, "store": size}))


Table = dict[str, list[tuple[float, dict[str, float]]]]


def main() -> None:
    """Measure every size, fit, and write."""
    table: Table = {}
    for name, sizes in SIZES.items():
        for combinations in sizes:
            row = measured(name, combinations)
            table.setdefault(name, []).append((float(SPEEDS * GAINS * combinations), row))
            print(name, table[name][-1], flush=True)
    write(table)
    draw(table)


def write(table: Table) -> None:
    """The table, the fitted growth, and what larger studies would cost."""
    rows, fits, costs = [], [], []
    for name, results in table.items():
        points = np.array([n for n, _ in results])
        spent = np.array([row["core_seconds"] for _, row in results])
        fits.append(f"{name}: core-seconds ∝ points^{np.polyfit(np.log(points), np.log(spent), 1)[0]:.2f}")
        rows += [
            f"| {name}, {METHODS[name]} | {n:.0e} | {row['seconds']:.2f} s | {row['core_seconds']:.2f} | "
            f"{n / row['core_seconds']:,.0f} | {row['memory']:.2f} GB | {row['store']:.0f} MB |"
            for n, row in results
        ]
        for large in LARGE:
            share = large / points[-1]
            times = [in_words(spent[-1] * share / cores) for cores in (2, 1000)]
            costs.append(
                f"| {name} | {large:.0e} | {spent[-1] * share / 3600:,.3g} | {' | '.join(times)} | "
                f"{results[-1][1]['store'] * share / 1e3:,.3g} GB |"
            )
    text = "\n".join(
        [
            "# Studies, measured",
            "",
            f"Made by `python benchmarks/growth_of_studies.py`: {SPEEDS} speeds × {GAINS} gains at 1 to "
            f"{max(SIZES['rub'])} values of a further axis, to a store on disk, everything compiled before. "
            "Core-seconds are processor time, which other work on the machine lengthens less than wall time.",
            "",
            "| study | points | wall time | core-seconds | points per core-second | peak memory | store |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
            f"Fitted: {'; '.join(fits)}. The interpreter, JAX and the compiled programs are in the peak memory. "
            "Points that the roots leave open, two in the rub's 3e+06, go to an operator, which is compiled when the "
            "first of them comes.",
            "",
            "![Time and memory over points](studies.png)",
            "",
            "At the rate of the largest study, on cores like these that are kept busy:",
            "",
            "| study | points | core-hours | on 2 cores | on 1,000 cores | store |",
            "|---|---|---|---|---|---|",
            *costs,
            "",
            f"Machine: {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}, "
            f"jax {jax.__version__}, NumPy {np.__version__}.",
            "",
        ]
    )
    (HERE / "STUDIES.md").write_text(text)
    print(text)


def in_words(seconds: float) -> str:
    """Such as "2.9 min"."""
    for unit, length in (("s", 60), ("min", 60), ("h", 24)):
        if seconds < 1.5 * length:
            return f"{seconds:,.2g} {unit}"
        seconds /= length
    return f"{seconds:,.2g} days"


def draw(table: Table) -> None:
    """Time and memory over points, with the line of proportion."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.6), layout="constrained")
    styles = {"rub": ("o", "#1f4e79"), "milling": ("s", "#8c3b0a")}
    for name, results in table.items():
        points = np.array([n for n, _ in results])
        spent = np.array([row["core_seconds"] for _, row in results])
        marker, colour = styles[name]
        label = f"{name}, {METHODS[name]}"
        left.loglog(points, spent, marker, color=colour, label=label)
        left.loglog(points, spent[-1] * points / points[-1], "--", color=colour, linewidth=0.9)
        right.semilogx(points, [row["memory"] for _, row in results], f"{marker}-", color=colour, label=label)
    left.plot([], [], "--", color="0.4", linewidth=0.9, label="time ∝ points")
    left.set(xlabel="points", ylabel="time of all cores (s)")
    right.set(xlabel="points", ylabel="peak resident memory (GB)", ylim=(0, 2))
    left.legend(frameon=False, fontsize="small")
    right.legend(frameon=False, fontsize="small", loc="center left")
    figure.savefig(HERE / "studies.png", dpi=150)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        one(sys.argv[1], int(sys.argv[2]), sys.argv[3])
    else:
        main()
