"""What all pictures share: whose axes they draw into, units, labels and legends."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex import _checks
from lobex.processes.quantity import SPEED_UNITS, Quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_apart: ContextVar[bool] = ContextVar("apart", default=False)


def one_of(ax: "Axes | None", width: float, height: float, **settings: Any) -> "Axes":
    """The axes given, or those of a new figure of so many inches.

    Raises:
        ValueError: for anything but axes.
    """
    if ax is not None:
        return _checked("ax", ax)
    if _apart.get():
        from matplotlib.figure import Figure

        return Figure(figsize=(width, height), layout="constrained").subplots(**settings)
    import matplotlib.pyplot as plt

    return plt.subplots(figsize=(width, height), layout="constrained", **settings)[1]


@contextmanager
def apart_from_pyplot() -> Iterator[None]:
    """Within, new figures are those of nobody's screen, and pyplot, which takes long to import, is not."""
    token = _apart.set(True)
    try:
        yield
    finally:
        _apart.reset(token)


def several_of(axes: Any, names: tuple[str, ...], make: "Callable[[], Any]") -> "list[Axes]":
    """The axes given, one for each of ``names``, or those that ``make`` makes.

    Raises:
        ValueError: for anything but so many axes.
    """
    given = make() if axes is None else axes
    listed = list(np.ravel(given)) if isinstance(given, np.ndarray | list | tuple) else [given]
    if len(listed) != len(names):
        raise ValueError(f"axes has {len(listed)}, and the picture takes {len(names)}: {', '.join(names)}")
    return [_checked("axes", ax) for ax in listed]


def speed_axis(unit: str) -> tuple[float, str]:
    """The factor from Hz to ``unit``, "Hz", "rpm" or "1", and the axis' label."""
    _checks.choice("speed_unit", unit, SPEED_UNITS)
    labels = {"Hz": "rotational frequency (Hz)", "rpm": "spindle speed (rpm)", "1": "speed 1/τ"}
    return 60.0 if unit == "rpm" else 1.0, labels[unit]


def frequency_label(speed_unit: str) -> str:
    """Of an axis of chatter frequencies."""
    return "chatter frequency" if speed_unit == "1" else "chatter frequency (Hz)"


def gain_label(quantity: Quantity) -> str:
    """Such as "depth of cut b (mm)"."""
    head, _, tail = quantity.symbol.partition("_")
    unit = "" if quantity.display_unit == "1" else f" ({quantity.display_unit})"
    return f"{quantity.name} ${head}{f'_{{{tail}}}' if tail else ''}${unit}"


def legend_above(ax: "Axes", columns: int = 3, **settings: Any) -> None:
    """A legend of all that has a label, also of what was drawn before, above the axes."""
    handles, labels = ax.get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "frameon": False}
    ax.legend(once.values(), once.keys(), ncols=columns, fontsize="small", **place, **settings)


def _checked(name: str, ax: Any) -> "Axes":
    from matplotlib.axes import Axes

    if not isinstance(ax, Axes):
        raise ValueError(f"{name} = {_checks.brief(ax)} is no matplotlib axes; give such as plt.subplots() makes")
    return ax
