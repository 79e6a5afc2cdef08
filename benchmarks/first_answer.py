"""How long a first answer takes, from a process that does not run yet: FIRST_ANSWER.md.

python benchmarks/first_answer.py            measure, and write the page
python benchmarks/first_answer.py BEFORE     beside the src folder of another tree, in turn with it
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from machine import machine

HERE = Path(__file__).parent
ROUNDS = 3
LIMIT = "import numpy, lobex; lobex.exact_limit(lobex.Rub(lobex.Rod(5).modes(0.03)), numpy.linspace(50, 400, 1000))"
CHART, AGAIN, COLD = (
    "`lobex lobes rub`, nothing in the cache folder",
    "the same again",
    "`exact_limit` of the rod, 1,000 speeds, from cold Python",
)


class Spent(NamedTuple):
    """Seconds from the start of a process to its end, and of all processors together."""

    wall: float
    processor: float


def process(words: list[str], source: Path, folder: Path) -> Spent:
    """What one process takes, with ``folder`` for its cache and its files."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("JAX_", "XLA_"))}
    environment = {**kept, "PYTHONPATH": str(source), "XDG_CACHE_HOME": str(folder / "cache")}
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, *words], env=environment, cwd=folder, capture_output=True, check=True)
    wall, after = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Spent(wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def answers(source: Path) -> dict[str, Spent]:
    """Each answer once, with a cache folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        words = ["-m", "lobex.shell.main", "lobes", "rub", "--out", "rub"]
        return {
            CHART: process(words, source, folder),
            AGAIN: process(words, source, folder),
            COLD: process(["-c", LIMIT], source, folder),
        }


def fastest(sources: list[Path], rounds: int) -> list[dict[str, Spent]]:
    """Of each source the fastest round of every answer, the sources in turn; files are in memory from a first one."""
    for source in sources:
        answers(source)
    made = [[answers(source) for source in sources] for _ in range(rounds)]
    every = [[one[number] for one in made] for number in range(len(sources))]
    return [
        {name: Spent(*(min(part) for part in zip(*(one[name] for one in of), strict=True))) for name in of[0]}
        for of in every
    ]


def page(found: list[dict[str, Spent]]) -> str:
    """The page: of this tree, which is the last, and of the one before it, if there is one."""
    names = ["before", "now"][-len(found) :]
    rows = [f"| {what} | {' | '.join(f'{part:.2f}' for one in found for part in one[what])} |" for what in found[-1]]
    return "\n".join(
        [
            "# First answers",
            "",
            "Made by `python benchmarks/first_answer.py`, beside another tree as it says: processes from their start "
            f"to their end, the fastest of {ROUNDS}, in seconds. The command computes 351 × 401 points, and writes "
            "them and their picture.",
            "",
            f"| what | {' | '.join(f'wall {name} | processor {name}' for name in names)} |",
            f"|---|{'---|---|' * len(found)}",
            *rows,
            "",
            f"Machine: {machine()}.",
            "",
        ]
    )


if __name__ == "__main__":
    trees = [*(Path(name).resolve() for name in sys.argv[1:]), HERE.parent / "src"]
    (HERE / "FIRST_ANSWER.md").write_text(page(fastest(trees, ROUNDS)))
