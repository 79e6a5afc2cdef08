"""What is taken away from a page, as bytes: tables, NetCDF, pictures, the script, and a report."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lobex.results.result import Result

_RESOLUTION = 150


def saved(result: Result, ending: str) -> bytes:
    """What ``result.save`` writes to a file of an ending, such as ".nc"."""
    with tempfile.TemporaryDirectory(prefix="lobex-") as folder:
        path = Path(folder) / f"taken{ending}"
        result.save(path)
        return path.read_bytes()


def picture(plot: Callable[[], Any], kind: str) -> bytes:
    """The figure that ``plot`` makes, or that its axes stand in, as "png" or "svg"."""
    import io

    import matplotlib.pyplot as plt

    made = plot()
    figure = made if hasattr(made, "savefig") else made.figure
    stream = io.BytesIO()
    try:
        # A date would make two pictures of the same screen differ.
        figure.savefig(stream, dpi=_RESOLUTION, format=kind, metadata={"Date": None} if kind == "svg" else None)
    finally:
        plt.close(figure)
    return stream.getvalue()
