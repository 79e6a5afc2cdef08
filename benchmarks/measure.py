"""Time per point, with the error reached, of lobex and of its rivals in one run; writes benchmarks/RESULTS.md.

make bench
"""

import os
import platform
import resource
import time
from collections.abc import Callable
from pathlib import Path

import jax
import numpy as np

import lobex
import thesis_method

TOOL = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
MILL = lobex.Milling(TOOL, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5, direction="down")
CUTTER = lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993)
PLANE = lobex.Milling(
    lobex.Modes.plane(x=CUTTER, y=CUTTER), teeth=2, tangential=6e8, normal=2e8, radial_immersion=0.05, direction="down"
)
ROD = lobex.Rub(lobex.Rod(5).modes(0.03))
# Process, speeds, gains, and the coarsest operator of ours that holds 1e-8 over the whole grid, for the rivals.
GRIDS = {
    "Appendix B, rub, 351×401, n = 5": (
        ROD,
        np.linspace(50, 400, 351),
        np.linspace(4.5e4, 4.5e6, 401),
        lobex.Duhamel(nodes=46),
    ),
    "§3.4, milling, 301×301": (
        MILL,
        np.linspace(2000, 25000, 301) / 60,
        np.linspace(0, 5e-3, 301),
        lobex.Duhamel(nodes=12),
    ),
    "2-DoF milling, a_D = 0.05, 256×128": (
        PLANE,
        np.linspace(5000, 25000, 256) / 60,
        np.linspace(0, 5e-3, 128),
        lobex.Duhamel(nodes=6),
    ),
}
SAMPLE = 64
OWN = {lobex.Rub: (lobex.CharacteristicRoots(), lobex.Duhamel()), lobex.Milling: (lobex.Duhamel(),)}


def seconds(function: Callable[[], object]) -> float:
    """Wall time of one call."""
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def sample_of(speeds: np.ndarray, gains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of random grid points."""
    rng = np.random.default_rng(0)
    return rng.integers(0, len(speeds), SAMPLE), rng.integers(0, len(gains), SAMPLE)


def measure(name: str) -> list[str]:
    """The rows of one grid."""
    process, speeds, gains, method = GRIDS[name]
    points = len(speeds) * len(gains)
    i, j = sample_of(speeds, gains)
    converged = lobex.spectral_radius(process, speeds[i], gains[j], lobex.Chebyshev(100))
    rows: list[str] = []
    own = 0.0
    for chosen in OWN[type(process)]:
        cold = seconds(lambda chosen=chosen: lobex.sweep(process, speeds, gains, chosen))
        charts: list[lobex.Chart] = []
        warm = min(
            seconds(lambda chosen=chosen, charts=charts: charts.append(lobex.sweep(process, speeds, gains, chosen)))
            for _ in range(3)
        )
        error = np.max(np.abs(charts[-1].spectral_radius[i, j] / converged - 1))
        own = own or warm / points
        rows.append(
            f"| {'' if rows else name} | lobex.sweep, {type(chosen).__name__} | {1e6 * warm / points:.2f} µs | "
            f"{error:.0e} | {warm / points / own:.2g} | {warm:.2f} s | {cold - warm:.1f} s |"
        )

    lobex.monodromy(process, speeds[i], gains[j], method)
    found: list[np.ndarray] = []
    batch = seconds(
        lambda: found.append(np.abs(np.linalg.eigvals(lobex.monodromy(process, speeds[i], gains[j], method))).max(-1))
    )
    error = np.max(np.abs(found[0] / converged - 1))
    rows.append(
        f"| | NumPy eigvals of lobex' operators, {method.nodes} nodes | {1e6 * batch / SAMPLE:.0f} µs | {error:.0e} | "
        f"{batch / SAMPLE / own:.0f} | | |"
    )
    if process is ROD:
        few = 8
        radii: list[float] = []
        loop = seconds(
            lambda: radii.extend(
                thesis_method.spectral_radius(ROD.modes, speeds[a], gains[b])
                for a, b in zip(i[:few], j[:few], strict=True)
            )
        )
        error = np.max(np.abs(np.array(radii) / converged[:few] - 1))
        rows.append(
            f"| | Appendix B's 400×400 operator in a SciPy loop ({few} points) | {1e6 * loop / few:.0f} µs | "
            f"{error:.0e} | {loop / few / own:.0f} | | |"
        )
    return rows


def measure_limits() -> list[str]:
    """The rod's limit at 1,000 speeds, in closed form and by search; the error is that against the closed form."""
    speeds, bounds = np.linspace(50, 400, 1000), (1e5, 4e6)
    results: dict[str, lobex.Limit] = {}
    lobex.exact_limit(ROD, speeds)
    exact = min(seconds(lambda: results.update(exact=lobex.exact_limit(ROD, speeds))) for _ in range(5))
    search = min(
        seconds(lambda: results.update(search=lobex.critical_gain(ROD, speeds, bounds, scan=17))) for _ in range(2)
    )
    error = np.nanmax(np.abs(results["search"].gain / results["exact"].gain - 1))
    name = "limit of the rod, 1,000 speeds"
    return [
        f"| {name} | lobex.exact_limit | {1e3 * exact:.1f} µs | closed form | 1 | {exact:.3f} s | |",
        f"| | lobex.critical_gain, scan of 17 | {1e3 * search:.0f} µs | {error:.0e} | {search / exact:.0f} "
        f"| {search:.2f} s | |",
    ]


def main() -> None:
    """Measure every grid and write the table."""
    rows = [*(row for name in GRIDS for row in measure(name)), *measure_limits()]
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    cpu = next((line.split(":")[1].strip() for line in _cpuinfo() if line.startswith("model name")), platform.machine())
    text = "\n".join(
        [
            "# Measured",
            "",
            "Made by `make bench`. Time per point, the largest relative error of max|μ| over a random sample of "
            f"{SAMPLE} grid points against Chebyshev collocation with 100 nodes and the dense solver, how many times "
            "longer it took than the first row of its block, the time of the whole grid, and what compiling added to "
            "the first call, all in one run. A point of the limit is a speed.",
            "",
            "| grid | method | time per point | error | ratio | whole | compiling |",
            "|---|---|---|---|---|---|---|",
            *rows,
            "",
            f"Peak memory of the run: {peak:.2f} GB. Machine: {cpu}, {os.cpu_count()} cores, "
            f"{platform.system()}; Python {platform.python_version()}, jax {jax.__version__}, "
            f"NumPy {np.__version__}.",
            "",
        ]
    )
    Path(__file__).with_name("RESULTS.md").write_text(text)
    print(text)


def _cpuinfo() -> list[str]:
    path = Path("/proc/cpuinfo")
    return path.read_text().splitlines() if path.exists() else []


if __name__ == "__main__":
    main()
