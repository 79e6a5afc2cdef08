"""The orbit of a blade's tip in a march: what it moves in two directions, along the casing and across."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection

from lobex import _checks
from lobex.plots.frame import legend_above, one_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.wear_map import WearMap

DIRECTIONS = ("radial", "tangential", "axial")
"""In which ``Beam.watch(tip=True)`` sees the tip, in order."""

_BEFORE = "0.75"
# Of positions around the casing, which come back to where they began.
_COLOURS = "twilight_shifted"
_MARGIN = 0.06
# Directions in which the tip moves so many times as far as in the other have scales of their own.
_APART = 20.0


def plot_tip_orbit(
    march: "WearMap", lane: int, ax: "Axes | None", directions: tuple[str, str], revolutions: int
) -> "Axes":
    """Draw the last revolutions of a lane: the last in the colours of its place around the casing, others in grey."""
    if march.watched.shape[1] < len(DIRECTIONS):
        raise ValueError(
            f"march watched {march.watched.shape[1]} outputs; an orbit takes march_wear(…, watched=3) of modes that "
            "were given watched=blade.watch(tip=True)"
        )
    if len(directions) != 2 or directions[0] == directions[1]:
        raise ValueError(f"directions = {_checks.brief(directions)}; give two of {', '.join(DIRECTIONS)}")
    for name in directions:
        _checks.choice("directions", name, DIRECTIONS)
    count = _checks.integer("revolutions", revolutions, 1, march.revolutions)
    across = march.watched[lane, [DIRECTIONS.index(name) for name in directions]] * 1e6
    if not np.isfinite(across).all():
        raise ValueError(f"speed = {march.speed[lane]:.6g} Hz: this lane failed and has no orbit; choose another")
    each = march.samples_per_revolution
    # With the sample before, so that revolutions hang together.
    first = across.shape[1] - count * each
    path = across[:, max(first - 1, 0) :]
    place = (np.arange(across.shape[1])[-path.shape[1] :] - march.lag) % each / each * 360
    last = path.shape[1] - each - 1
    ax = one_of(ax, 6.0, 5.0)
    if last > 0:
        ax.plot(*path[:, : last + 1], color=_BEFORE, linewidth=0.7, label="revolutions before", zorder=1)
    points = path[:, max(last, 0) :].T
    coloured = LineCollection(list(np.stack([points[:-1], points[1:]], axis=1)), cmap=_COLOURS, linewidths=1.4)
    coloured.set_array(place[-(len(points) - 1) :])
    coloured.set_clim(0, 360)
    ax.add_collection(coloured)
    ax.plot(*points[-1], "o", color="k", markersize=4, label="end", zorder=3)
    ax.margins(_MARGIN)
    ax.autoscale_view()
    spread = np.ptp(path, axis=1)
    if max(spread) <= _APART * min(spread):
        ax.set_aspect("equal", adjustable="datalim")
    bar = ax.figure.colorbar(coloured, ax=ax, pad=0.02, ticks=np.arange(0, 361, 60))
    bar.set_label("last revolution: turned from where the contact begins (°)")
    ax.set_xlabel(f"{directions[0]} displacement of the tip (µm)")
    ax.set_ylabel(f"{directions[1]} displacement of the tip (µm)")
    legend_above(ax, title=f"revolution {march.revolutions}, at {march.speed_history[lane, -1]:.6g} Hz")
    return ax
