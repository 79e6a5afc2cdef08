"""Pictures as bytes: all of a command's are drawn before its first file is written, so that they belong together."""

import io
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

_RESOLUTION = 150


def drawn(plot: Callable[[], "Artist | Figure"]) -> bytes:
    """The figure that ``plot`` makes, or that its axes stand in, as a PNG."""
    import matplotlib

    from lobex.plots.frame import apart_from_pyplot

    matplotlib.use("Agg")
    with apart_from_pyplot():
        made: Any = plot()
    figure = made if hasattr(made, "savefig") else made.figure
    stream = io.BytesIO()
    figure.savefig(stream, dpi=_RESOLUTION, format="png")
    # Some pictures are by pyplot, which keeps them.
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close(figure)
    return stream.getvalue()
