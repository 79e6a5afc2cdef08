"""The Campbell diagram: natural frequencies, engine orders, and the critical speeds where they cross."""

from typing import TYPE_CHECKING

import numpy as np

from lobex import _checks
from lobex.plots.frame import one_of
from lobex.results.spectrum_map import critical_speeds_of
from lobex.structures.modes import Modes, check_modes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_NATURAL = "#12436d"
_ORDER = "0.45"
_CRITICAL = "#c8500a"
# Keeps names readable over lines.
_PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5}


def campbell(
    modes: Modes,
    nodal_diameters: int = 2,
    highest_speed: float | None = None,
    highest: float | None = None,
    ax: "Axes | None" = None,
) -> "Axes":
    """Draw natural frequencies and engine orders over speed; crossings that the casing excites are marked.

    The blade of this model does not stiffen with speed, so that its natural frequencies are level.

    Args:
        modes: the blade's modes.
        nodal_diameters: bumps of the casing per revolution: multiples of it are the engine orders that it excites.
        highest_speed: end of the speed axis, Hz; by default past the first natural frequency over the bumps.
        highest: end of the frequency axis, Hz; by default past the second natural frequency.
        ax: axes to draw into.

    Returns:
        The axes.

    Raises:
        ValueError: for anything but modes, and numbers that are not positive.
    """
    check_modes(modes)
    _checks.untraced("a picture", modes=modes)
    nodal_diameters = _checks.integer("nodal_diameters", nodal_diameters, 1)
    natural = np.sort(np.asarray(modes.frequency))
    fastest = 1.3 * natural[0] / nodal_diameters if highest_speed is None else highest_speed
    top = (1.15 * natural[1] if len(natural) > 1 else 2 * natural[0]) if highest is None else highest
    for name, value in (("highest_speed", fastest), ("highest", top)):
        _checks.positive(name, value, "Hz")
        _checks.scalar(name, value)
    ax = one_of(ax, 7.0, 4.8)
    ax.set_xlim(0, float(fastest))
    ax.set_ylim(0, float(top))
    draw_engine_orders(ax, 6 * nodal_diameters, nodal_diameters)
    draw_natural_frequencies(ax, natural)
    shown = natural[natural <= top]
    speeds = critical_speeds_of(shown, nodal_diameters, 6)
    inside = speeds <= fastest
    frequency = np.broadcast_to(shown[:, None], speeds.shape)
    ax.plot(
        speeds[inside],
        frequency[inside],
        linestyle="none",
        marker="o",
        markersize=5,
        color=_CRITICAL,
        label=f"critical speed, f/k, k = {nodal_diameters}, {2 * nodal_diameters}, …",
        zorder=5,
    )
    if len(shown):
        for speed in speeds[0][inside[0]][:3]:
            ax.annotate(
                f"{speed:.4g} Hz",
                (speed, shown[0]),
                xytext=(0, -8),
                textcoords="offset points",
                ha="center",
                va="top",
                rotation=90,
                fontsize="small",
                bbox=_PATCH,
            )
    ax.set_xlabel("rotational frequency (Hz)")
    ax.set_ylabel("frequency (Hz)")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize="small")
    return ax


def draw_engine_orders(ax: "Axes", count: int, nodal_diameters: int) -> None:
    """Lines f = k · speed, (1.19), up to order ``count``, named where they leave the axes; those that the casing
    excites are solid."""
    (low, fastest), (_, top) = ax.get_xlim(), ax.get_ylim()
    span = np.array([low, fastest])
    named = {True: False, False: False}
    last = np.inf
    for order in range(1, count + 1):
        excited = order % nodal_diameters == 0
        name = "engine order, excited by the casing" if excited else "other engine order"
        ax.plot(
            span,
            order * span,
            color=_ORDER,
            linewidth=0.9 if excited else 0.6,
            linestyle="-" if excited else ":",
            label=None if named[excited] else name,
            scalex=False,
            scaley=False,
        )
        named[excited] = True
        if not excited and nodal_diameters > 1:
            continue
        speed = min(fastest, top / order)
        room = 0.03 * (fastest - low)
        if speed > low + room and (last - speed > room or speed == fastest):
            last = speed
            ax.annotate(
                str(order),
                (speed, order * speed),
                xytext=(-3, -3) if speed < fastest else (-3, 3),
                textcoords="offset points",
                ha="right",
                va="top" if speed < fastest else "bottom",
                fontsize="x-small",
                color="0.25",
                bbox=_PATCH,
            )


def draw_natural_frequencies(ax: "Axes", frequency: np.ndarray) -> None:
    """Level lines at the natural frequencies within the axes, named at the right."""
    top = ax.get_ylim()[1]
    for number, value in enumerate(np.sort(frequency), start=1):
        if value > top:
            break
        ax.axhline(
            value,
            color=_NATURAL,
            linewidth=1.1,
            linestyle=(0, (6, 2)),
            label="natural frequency" if number == 1 else None,
        )
        ax.annotate(
            f"$f_{{{number}}}$",
            (1.0, value),
            xycoords=ax.get_yaxis_transform(),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize="small",
            color=_NATURAL,
        )
