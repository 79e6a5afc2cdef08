"""Time per point, with the error reached, of lobex and of its rivals in one run: RESULTS.md and results.png.

make bench
"""

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

import lobex
import thesis_method
from machine import machine
from measured_charts import MILL, PROBLEMS, ROD, TOOL, Problem
from semi_discretization_numba import spectral_radii

HERE = Path(__file__).parent
SAMPLE, FEW, ROUNDS = 64, 8, 4
STEPS = (40, 80, 160)
# As their authors state them: who, which chart, seconds a point (and core, where said), error, on what.
PUBLISHED = (
    ("thesis, Appendix A in Octave, a comparable two-core machine", "rub", 56e-3, None),
    ("SemiDiscretizationMethod.jl, one core", "Mathieu", 0.43e-3, 6e-4),
    ("SOSD.jl, one core", "Mathieu", 1.1e-3, 1e-5),
    ("SOSD.jl, 16 threads", "2-DoF milling", 64.7 / (256 * 128), None),
    ("SOSD.jl, NVIDIA A100, float64", "2-DoF milling", 2.44 / (256 * 128), None),
)


class Row(NamedTuple):
    """A line of the table."""

    problem: str
    method: str
    point: float
    error: float | None
    whole: float | None = None
    compiling: float | None = None
    memory: float | None = None


def seconds(function: Callable[[], object]) -> float:
    """Wall time of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def peak() -> float:
    """Peak memory of this process so far, GB; on Linux, where resource's figure would be the parent's at the start."""
    status = Path("/proc/self/status").read_text()
    return next(float(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")) / 1e6


def memory(work: str, number: int = 0) -> float:
    """Peak memory of a process that does one work and nothing else, GB."""
    command = [sys.executable, __file__, work, str(number)]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def measure(name: str, problem: Problem) -> list[Row]:
    """The rows of one chart."""
    process, speeds, gains = problem.process, problem.speeds, problem.gains
    points = len(speeds) * len(gains)
    rng = np.random.default_rng(0)
    i, j = rng.integers(0, len(speeds), SAMPLE), rng.integers(0, len(gains), SAMPLE)
    converged = lobex.spectral_radius(process, speeds[i], gains[j], problem.reference)

    def off(radius: np.ndarray) -> float:
        return float(np.max(np.abs(radius / converged[: len(radius)] - 1)))

    rows = []
    for number, method in enumerate(problem.own):
        charts: list[lobex.Chart] = []

        def draw(method: object = method, charts: list[lobex.Chart] = charts) -> None:
            charts.append(lobex.sweep(process, speeds, gains, method))  # pyright: ignore[reportArgumentType]

        cold = seconds(draw)
        warm = min(seconds(draw) for _ in range(ROUNDS))
        error = off(charts[-1].spectral_radius[i, j])
        label = f"lobex.sweep, {type(method).__name__}"
        if isinstance(method, lobex.Duhamel):
            label += f", tolerance {method.tolerance:.0e}"
        rows.append(Row(name, label, warm / points, error, warm, cold - warm, memory(name, number)))

    lobex.monodromy(process, speeds[i], gains[j], problem.rival)
    found: list[np.ndarray] = []
    batch = seconds(
        lambda: found.append(
            np.abs(np.linalg.eigvals(lobex.monodromy(process, speeds[i], gains[j], problem.rival))).max(-1)
        )
    )
    label = f"NumPy eigvals of lobex' operators, {problem.rival.nodes} nodes"
    rows.append(Row(name, label, batch / SAMPLE, off(found[0])))
    if process is ROD:
        radii: list[float] = []
        loop = seconds(
            lambda: radii.extend(
                thesis_method.spectral_radius(ROD.modes, float(speeds[a]), float(gains[b]))
                for a, b in zip(i[:FEW], j[:FEW], strict=True)
            )
        )
        label = f"Appendix B's 400×400 operator in a SciPy loop ({FEW} points)"
        rows.append(Row(name, label, loop / FEW, off(np.array(radii))))
    if process is MILL:
        rows.extend(_numba(name, problem, i, j, off))
    return rows


def _numba(name: str, problem: Problem, i: np.ndarray, j: np.ndarray, off: Callable[[np.ndarray], float]) -> list[Row]:
    """The usual method, on all cores."""
    omega, ratio = float(TOOL.angular_frequency[0]), float(TOOL.damping_ratio[0])
    mass = float(1 / TOOL.shape[0, 0] ** 2)
    enter = float(np.arccos(2 * MILL.radial_immersion - 1))
    forces = float(MILL.tangential), float(MILL.normal)
    rows = []
    for steps in STEPS:
        radii: list[np.ndarray] = []

        def run(steps: int = steps, radii: list[np.ndarray] = radii) -> None:
            places = problem.speeds[i], problem.gains[j]
            radii.append(spectral_radii(omega, ratio, mass, *forces, enter, np.pi, *places, steps))

        run()
        spent = min(seconds(run) for _ in range(ROUNDS))
        rows.append(Row(name, f"semi-discretization in numba, {steps} steps", spent / SAMPLE, off(radii[-1])))
    return rows


def limits() -> dict[str, Callable[[], lobex.Limit]]:
    """The limits over the speed that are measured."""
    speeds, rpm = np.linspace(50, 400, 1000), np.linspace(2000, 25000, 300)
    return {
        "lobex.exact_limit, closed form": lambda: lobex.exact_limit(ROD, speeds),
        "lobex.critical_gain": lambda: lobex.critical_gain(ROD, speeds, (4.5e4, 4.5e6)),
        "lobex.critical_gain, milling": lambda: lobex.critical_gain(MILL, rpm / 60, (0, 5e-3)),
    }


def measure_limits() -> list[Row]:
    """Limits over the speed; a point is a speed."""
    results, times = {}, {}
    for name, function in limits().items():
        cold = seconds(function)
        warm = min(seconds(lambda: results.update({name: function()})) for _ in range(ROUNDS))  # noqa: B023
        times[name] = warm, cold - warm, memory(name)
    exact, search, mill = results.values()
    finer = lobex.critical_gain(MILL, mill.speed, (0, 5e-3), lobex.Chebyshev(48))
    errors = (
        None,
        float(np.nanmax(np.abs(search.gain / exact.gain - 1))),
        float(
            np.max(np.abs(mill.intervals - finer.intervals)[mill.intervals > 0] / mill.intervals[mill.intervals > 0])
        ),
    )
    rod, milling = "limit of the rod, 1,000 speeds", "limit of §3.4's milling, 300 speeds, every interval"
    return [
        Row(work, name.removesuffix(", milling"), times[name][0] / len(results[name].speed), error, *times[name])
        for work, name, error in zip((rod, rod, milling), results, errors, strict=True)
    ]


def short(number: float) -> str:
    """Three digits, and none after the point where there are as many before it."""
    return f"{number:.3g}" if number < 100 else f"{float(f'{number:.3g}'):,.0f}"


def table(rows: list[Row]) -> list[str]:
    """The rows in Markdown."""
    lines = [
        "| work | method | time per point | error | ratio | whole | compiling | memory |",
        "|---|---|---|---|---|---|---|---|",
    ]
    first: dict[str, Row] = {}
    for row in rows:
        own = first.setdefault(row.problem, row)
        error = "closed form" if row.error is None else f"{row.error:.0e}"
        whole = "" if row.whole is None else f"{row.whole:.3g} s"
        compiling = "" if row.compiling is None else f"{row.compiling:.1f} s"
        memory = "" if row.memory is None else f"{row.memory:.2f} GB"
        lines.append(
            f"| {row.problem if own is row else ''} | {row.method} | {short(1e6 * row.point)} µs | {error} | "
            f"{short(row.point / own.point)} | {whole} | {compiling} | {memory} |"
        )
    return lines


def draw(rows: list[Row]) -> None:
    """Error over time per point: lower left is better."""
    matplotlib.use("Agg")
    problems = list(dict.fromkeys(row.problem for row in rows if row.problem in PROBLEMS))
    figure, axes = plt.subplots(
        1, len(problems), figsize=(3.1 * len(problems), 3.6), sharex=True, sharey=True, layout="constrained"
    )
    styles = {
        "lobex": ("lobex", "o", "#0b4f6c"),
        "NumPy": ("NumPy eigvals of lobex' operators", "s", "#8f8f8f"),
        "semi": ("semi-discretization, numba", "^", "#c8553d"),
        "Appendix": ("Appendix B, SciPy", "D", "#e0a458"),
        "published": ("published, others' machines", "x", "#333333"),
    }
    for ax, problem in zip(axes, problems, strict=True):
        for row in rows:
            if row.problem == problem and row.error is not None:
                label, marker, colour = styles[row.method.replace("-", " ").split()[0].split(".")[0]]
                ax.loglog(1e6 * row.point, max(row.error, 1e-15), marker, color=colour, label=label)
        for _, chart, point, error in PUBLISHED:
            if error is not None and chart in problem:
                label, marker, colour = styles["published"]
                ax.loglog(1e6 * point, error, marker, color=colour, label=label)
        ax.set_title(problem.replace(", ", "\n", 1), fontsize=9)
        ax.set_xlabel("time per point (µs)")
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("largest relative error of max|μ|")
    handles = {}
    for ax in axes:
        handles.update({text: handle for handle, text in zip(*ax.get_legend_handles_labels(), strict=True)})
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, fontsize=9)
    figure.savefig(HERE / "results.png", dpi=130)


def main() -> None:
    """Measure everything and write the table."""
    rows = [row for name, problem in PROBLEMS.items() for row in measure(name, problem)]
    rows += measure_limits()
    published = [
        f"| {who} | {chart} | {short(1e6 * point)} µs | {'not said' if error is None else f'{error:.0e}'} |"
        for who, chart, point, error in PUBLISHED
    ]
    text = "\n".join(
        [
            "# Measured",
            "",
            "Made by `make bench`. Time per point, the largest relative error of max|μ| over a random sample of "
            f"{SAMPLE} points against converged Chebyshev collocation and the dense solver, how many times longer it "
            f"took than the first row of its block, the whole work (the best of {ROUNDS}), what compiling added "
            "to the first call, all in one run, and the peak memory of a process that does it alone, Python and JAX "
            "included. A point of a limit is a speed; the error of a limit is that of the "
            "gain, against the closed form and against 48 Chebyshev nodes.",
            "",
            *table(rows),
            "",
            "![Error over time per point](results.png)",
            "",
            "Published figures, as their authors state them, on other machines:",
            "",
            "| code | chart | time per point | error |",
            "|---|---|---|---|",
            *published,
            "",
            f"Machine: {machine()}.",
            "",
            "How cost grows: [GROWTH.md](GROWTH.md). The wear march: [WEAR.md](WEAR.md). Large studies: "
            "[STUDIES.md](STUDIES.md). First calls: [PROGRAMS.md](PROGRAMS.md).",
            "",
        ]
    )
    (HERE / "RESULTS.md").write_text(text)
    print(text)
    draw(rows)


def alone(work: str, number: int) -> None:
    """One work, twice, and the peak memory."""
    for _ in range(2):
        if work in PROBLEMS:
            problem = PROBLEMS[work]
            lobex.sweep(problem.process, problem.speeds, problem.gains, problem.own[number])
        else:
            limits()[work]()
    print(peak())


if __name__ == "__main__":
    alone(sys.argv[1], int(sys.argv[2])) if len(sys.argv) > 1 else main()
