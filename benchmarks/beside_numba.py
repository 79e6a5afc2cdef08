"""A wear march of lobex and the same loops in numba, timed in turn, and the table of both."""

import os
import platform
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from lobex.marches.decimation import filter_matrix


def taps_of(cells: int, factor: int) -> np.ndarray:
    """The weights of the decimation's filter, without the zeros behind them."""
    row = filter_matrix(cells, factor)[0]
    return row[: np.flatnonzero(row)[-1] + 1]


def in_turn(own: Callable[[], Any], other: Callable[[], Any], rounds: int) -> tuple[Any, Any, np.ndarray]:
    """The last results of both, and the seconds of each in all rounds, (2, rounds)."""
    times, results = [], (None, None)
    for _ in range(rounds):
        begun = time.perf_counter()
        mine = own()
        middle = time.perf_counter()
        results = mine, other()
        times.append((middle - begun, time.perf_counter() - middle))
        print("lobex {:.2f} s, numba {:.2f} s".format(*times[-1]), flush=True)
    return *results, np.array(times).T


def write_table(
    name: str, title: str, what: str, times: np.ndarray, apart: np.ndarray, energy: np.ndarray, more: Sequence[str]
) -> None:
    """Write and print a page: what was marched, times, and how far depths and damping losses differ by speed."""
    import numba

    mine, theirs = times
    ratio = theirs / mine
    lines = [
        f"# {title}",
        "",
        what,
        "",
        "| | fastest | median | speed against numba, median of rounds (least, most) |",
        "|---|---|---|---|",
        f"| lobex.march_wear | {mine.min():.2f} s | {np.median(mine):.2f} s | {np.median(ratio):.2f} "
        f"({ratio.min():.2f}, {ratio.max():.2f}) |",
        f"| numba, prange over speeds | {theirs.min():.2f} s | {np.median(theirs):.2f} s | 1 |",
        "",
        f"Depths agree to {np.median(apart):.0e} (median speed; {np.max(apart):.0e} at worst), damping losses to "
        f"{np.max(np.abs(energy)):.0e}. {' '.join(more)} {os.cpu_count()} cores, {platform.system()}, Python "
        f"{platform.python_version()}, jax {jax.__version__}, numba {numba.__version__}.",
        "",
    ]
    Path(__file__).with_name(name).write_text("\n".join(lines))
    print("\n".join(lines))
