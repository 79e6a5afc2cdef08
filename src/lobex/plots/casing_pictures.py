"""Casings in polar form, before and after wear, with radial distances exaggerated."""

from typing import TYPE_CHECKING, Any, cast

import numpy as np

from lobex import _checks
from lobex.plots.frame import one_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.projections.polar import PolarAxes

    from lobex.contact.casing import Casing
    from lobex.results.wear_map import WearMap

_CELLS = 1440
_UNWORN = "#12436d"
_WORN = "#8c3b0a"
_REMOVED = "#f6d9a8"
# The largest distance from the tip's circle fills this share of its radius.
_SHARE = 0.25


def plot_casing(casing: "Casing", ax: "Axes | None", magnification: float | None) -> "Axes":
    """The surface of an unworn casing around the circle of the tip at rest."""
    cells = _CELLS if casing.surface is None else len(casing.surface)
    profile = np.asarray(casing.profile(cells))
    axes = _polar(ax)
    scale = _magnification(magnification, float(casing.radius), profile)
    _draw(axes, profile, float(casing.radius), scale, _UNWORN, "-", "casing before wear")
    _finish(axes, scale, "")
    return axes


def plot_worn_casing(march: "WearMap", lane: int, ax: "Axes | None", magnification: float | None) -> "Axes":
    """The surface before and after wear at one speed, and what was removed between."""
    unworn, worn = march.unworn, march.profile[lane]
    if not np.isfinite(worn).all():
        raise ValueError(f"speed = {march.speed[lane]:.6g} Hz: this lane failed and has no profile; choose another")
    axes = _polar(ax)
    scale = _magnification(magnification, march.radius, np.r_[unworn, worn])
    angle = np.r_[march.angle, 2 * np.pi]
    inner, outer = (1 + scale * np.r_[p, p[0]] / march.radius for p in (unworn, worn))
    axes.fill_between(angle, inner, outer, color=_REMOVED, linewidth=0, label="removed")
    _draw(axes, unworn, march.radius, scale, _UNWORN, "--", "casing before wear")
    _draw(axes, worn, march.radius, scale, _WORN, "-", f"after {march.revolutions} revolutions")
    _finish(axes, scale, f"{march.speed[lane]:.6g} Hz, ")
    return axes


def _polar(ax: "Axes | None") -> "PolarAxes":
    ax = one_of(ax, 5.2, 5.8, subplot_kw={"projection": "polar"})
    if not hasattr(ax, "set_theta_zero_location"):
        raise ValueError("ax is not polar; make it with subplot_kw={'projection': 'polar'}")
    return cast(Any, ax)


def _magnification(given: float | None, radius: float, profile: np.ndarray) -> float:
    """The one given, or the largest of 1, 2, 5, 10, … that keeps the picture in proportion."""
    if given is not None:
        _checks.positive("magnification", given)
        _checks.scalar("magnification", given)
        return float(given)
    largest = float(np.max(np.abs(profile)))
    if largest == 0:
        return 1.0
    wanted = _SHARE * radius / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * decade for step in (1, 2, 5) if step * decade <= wanted))


def _draw(
    axes: "PolarAxes", profile: np.ndarray, radius: float, scale: float, colour: str, line: str, name: str
) -> None:
    angle = 2 * np.pi * np.arange(len(profile) + 1) / len(profile)
    axes.plot(angle, 1 + scale * np.r_[profile, profile[0]] / radius, line, color=colour, linewidth=1.3, label=name)


def _finish(axes: "PolarAxes", scale: float, what: str) -> None:
    turn = np.linspace(0, 2 * np.pi, 361)
    axes.plot(turn, np.ones_like(turn), ":", color="0.35", linewidth=1.0, label="blade tip at rest")
    axes.set_yticks([])
    axes.set_ylim(0, None)
    axes.spines["polar"].set_visible(False)
    axes.grid(color="0.9")
    axes.set_title(f"{what}exaggerated: distances from the tip's circle × {scale:.6g}", fontsize="medium")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.05), ncols=2, frameon=False, fontsize="small")
