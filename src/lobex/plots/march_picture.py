"""Marches as pictures: the displacement of every lane over revolutions or tooth passes."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from lobex.plots.frame import one_of
from lobex.processes.quantity import Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.march import March

# Distinct in grey by lightness, and by dash where lanes of one kind meet.
_STABLE = ("#12436d", "#5b8fb9", "#0b7a75")
_UNSTABLE = ("#c8500a", "#e8a33d", "#8c3b0a")
_DASHES = ("-", "--", ":")
_MOST_LANES = 6
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p"))


def plot_march(march: "March", ax: "Axes | None") -> "Axes":
    """Draw every lane, blue where it dies out and orange where it grows; two outputs solid and dashed."""
    check_lanes(march.speed.size)
    ax = one_of(ax, 7.0, 3.6)
    lanes = march.displacement.reshape(march.speed.size, len(march.phase), -1)
    scale, prefix = prefix_of(lanes) if "modes" in march.process else (1.0, "")
    names = lane_names(march.speed, march.gain / march.quantity.scale, march.quantity, march.speed_unit)
    growth = march.growth.ravel()
    # Large motion first, so that small motion is drawn over it and stays visible.
    for lane in np.argsort([-reach(displacement) for displacement in lanes]):
        colours = _UNSTABLE if growth[lane] > 1 else _STABLE
        same = np.flatnonzero((growth > 1) == (growth[lane] > 1)).tolist()
        label = f"{names[lane]}: |μ| = {growth[lane]:.4g}" if np.isfinite(growth[lane]) else names[lane]
        for output in range(lanes.shape[2]):
            ax.plot(
                march.phase,
                lanes[lane, :, output] / scale,
                color=colours[same.index(lane) % len(colours)],
                linestyle=_DASHES[output % len(_DASHES)],
                linewidth=0.9,
                label=label if lanes.shape[2] == 1 else f"{label}, {'xyz'[output]}",
            )
    vibrates = "modes" in march.process
    teeth = march.process.get("teeth", 1)
    ax.set_xlabel("tooth passes" if teeth > 1 else "revolutions" if vibrates else "periods")
    ax.set_ylabel(f"displacement ({prefix}m)" if vibrates else "displacement")
    finish(ax, march.phase[-1])
    return ax


def check_lanes(count: int) -> None:
    """Refuse more lines than an eye can follow."""
    if count > _MOST_LANES:
        raise ValueError(f"{count} lanes are too many for one picture; march at most {_MOST_LANES} to plot them")


def reach(displacement: np.ndarray) -> float:
    """The largest finite displacement, 0 if there is none."""
    return float(np.max(np.abs(displacement), initial=0.0, where=np.isfinite(displacement)))


def prefix_of(samples: np.ndarray) -> tuple[float, str]:
    """The unit's prefix in which the largest sample has one to three digits, and its factor."""
    largest = reach(samples)
    return next((p for p in _PREFIXES if largest >= p[0]), (1.0, "") if largest == 0 else _PREFIXES[-1])


def lane_names(speed: np.ndarray, gain: np.ndarray, quantity: Quantity, speed_unit: str) -> list[str]:
    """What tells the lanes apart, such as "112 Hz, $K_e$ = 0.45 MN/m"."""
    factor = 60 if speed_unit == "rpm" else 1
    head, _, tail = quantity.symbol.partition("_")
    symbol, unit = f"${head}{f'_{{{tail}}}' if tail else ''}$", quantity.display_unit
    unit = "" if unit == "1" else f" {unit}"
    per = "" if speed_unit == "1" else f" {speed_unit}"
    pairs = zip(speed.ravel(), gain.ravel(), strict=True)
    return [f"{s * factor:.5g}{per}, {symbol} = {g:.4g}{unit}".replace("-", "−") for s, g in pairs]


def finish(ax: "Axes", last: float) -> None:
    """Limits, grid and a legend above, in columns."""
    ax.set_xlim(0, last)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.axhline(0, color="0.6", linewidth=0.6, zorder=0)
    handles, labels = ax.get_legend_handles_labels()
    order = sorted(range(len(labels)), key=labels.__getitem__)
    ax.legend(
        [handles[i] for i in order],
        [labels[i] for i in order],
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        ncols=min(len(labels), 2),
        frameon=False,
        fontsize="small",
    )
