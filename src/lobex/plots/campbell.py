"""The Campbell diagram: natural frequencies, engine orders, and the critical speeds where they cross."""

from typing import TYPE_CHECKING

import numpy as np

from lobex import _checks
from lobex.plots.frame import one_of
from lobex.plots.limit_picture import groups
from lobex.processes.at_speeds import follows_speed
from lobex.results.spectrum_map import critical_speeds
from lobex.structures.engine_orders import natural_frequencies, speed_range
from lobex.structures.modes import check_modes
from lobex.structures.rotating_modes import AnyModes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lobex.results.limit import Limit

_NATURAL = "#12436d"
_ORDER = "0.45"
_CRITICAL = "#c8500a"
# Multiples of the casing's bumps whose critical speeds are marked, and points of a curve over speed.
_HARMONICS, _POINTS = 6, 61
# Of the frequency axis, what the name of a critical speed takes.
_LOW = 0.25
# Keeps names readable over lines.
_PATCH = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5}


def campbell(
    modes: AnyModes,
    nodal_diameters: int = 2,
    highest_speed: float | None = None,
    highest: float | None = None,
    ax: "Axes | None" = None,
    *,
    limit: "Limit | None" = None,
) -> "Axes":
    """Draw natural frequencies and engine orders over speed; crossings that the casing excites are marked.

    Two things that are apart meet in one picture: resonances with the engine orders of an uneven casing, and with
    ``limit`` the frequencies at which lobes chatter.

    Args:
        modes: the blade's modes: level lines, or curves of those that follow the speed.
        nodal_diameters: bumps of the casing per revolution: multiples of it are the engine orders that it excites.
        highest_speed: end of the speed axis, Hz; by default past the first critical speed.
        highest: end of the frequency axis, Hz; by default past the second natural frequency.
        ax: axes to draw into.
        limit: the stability limit of the same blade, whose chatter frequencies are drawn, of each mode in its colour.

    Returns:
        The axes.

    Raises:
        ValueError: for anything but modes, numbers that are not positive, and speeds at which there are no modes.
    """
    check_modes(modes, over_speed=True)
    _checks.untraced("a picture", modes=modes)
    if limit is not None and not hasattr(limit, "chatter_frequency"):
        raise ValueError(f"limit = {_checks.brief(limit)} is no limit; give one such as lobex.exact_limit finds")
    critical = critical_speeds(modes, nodal_diameters, _HARMONICS)
    slowest, last = speed_range(modes)
    first = critical[0, 0] if np.isfinite(critical[0, 0]) else natural_frequencies(modes, np.array([slowest]))[0, 0]
    fastest = min(1.3 * first, last) if highest_speed is None else highest_speed
    _checks.positive("highest_speed", fastest, "Hz")
    _checks.scalar("highest_speed", fastest)
    if fastest > last:
        raise ValueError(f"highest_speed = {float(fastest):.6g} Hz is beyond the modes; give {last:.6g} Hz or less")
    speed = np.linspace(slowest, float(fastest), _POINTS if follows_speed(modes) else 2)
    natural = natural_frequencies(modes, speed)
    second = np.max(natural[:, min(1, natural.shape[1] - 1)])
    top = (1.15 * second if natural.shape[1] > 1 else 2 * second) if highest is None else highest
    _checks.positive("highest", top, "Hz")
    _checks.scalar("highest", top)
    ax = one_of(ax, 7.0, 4.8)
    ax.set_xlim(0, float(fastest))
    ax.set_ylim(0, float(top))
    draw_engine_orders(ax, _HARMONICS * nodal_diameters, nodal_diameters)
    draw_natural_frequencies(ax, natural[-1], speed, natural)
    frequency = critical * nodal_diameters * np.arange(1, _HARMONICS + 1)
    with np.errstate(invalid="ignore"):
        inside = (critical <= fastest) & (frequency <= top)
    ax.plot(
        critical[inside],
        frequency[inside],
        linestyle="none",
        marker="o",
        markersize=5,
        color=_CRITICAL,
        label=f"critical speed, f/k, k = {nodal_diameters}, {2 * nodal_diameters}, …",
        zorder=5,
    )
    for place, height in zip(critical[0][inside[0]][:3], frequency[0][inside[0]], strict=False):
        # Above what is too near to the axis for a name below it.
        low = height < _LOW * top
        ax.annotate(
            f"{place:.4g} Hz",
            (place, height),
            xytext=(0, 8 if low else -8),
            textcoords="offset points",
            ha="center",
            va="bottom" if low else "top",
            rotation=90,
            fontsize="small",
            bbox=_PATCH,
        )
    if limit is not None:
        draw_chatter(ax, limit)
    ax.set_xlabel("rotational frequency (Hz)")
    ax.set_ylabel("frequency (Hz)")
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False, fontsize="small")
    return ax


def draw_chatter(ax: "Axes", limit: "Limit") -> None:
    """The chatter frequencies of a limit within the axes."""
    order = np.argsort(limit.speed)
    for here, style, name in groups(limit, order):
        drawn = {**style, "markersize": 2.4, "zorder": 4}
        ax.plot(
            limit.speed[order][here],
            limit.chatter_frequency[order][here],
            label=f"chatter, {name}",
            scalex=False,
            scaley=False,
            **drawn,
        )


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


def draw_natural_frequencies(
    ax: "Axes", frequency: np.ndarray, speed: np.ndarray | None = None, curves: np.ndarray | None = None
) -> None:
    """Natural frequencies within the axes, named at the right: level lines (modes,), or curves (speeds, modes) that end
    at these.
    """
    top = ax.get_ylim()[1]
    style = {"color": _NATURAL, "linewidth": 1.1, "linestyle": (0, (6, 2))}
    order = np.argsort(frequency)
    for number, value in enumerate(frequency[order], start=1):
        label = "natural frequency" if number == 1 else None
        if speed is None or curves is None:
            if value > top:
                break
            ax.axhline(value, label=label, **style)
        else:
            ax.plot(speed, curves[:, order[number - 1]], label=label, scalex=False, scaley=False, **style)
        if value > top:
            continue
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
