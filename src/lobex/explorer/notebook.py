"""``explore``: the explorer of a process, in a notebook or as a page."""

from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lobex.explorer.page import Explorer


def explore(process: Any = "rub", speed: Any = None, gain: Any = None) -> "Explorer":
    """Lobes that follow the numbers of a process: the last line of a notebook's cell shows them.

    Every number has a slider and a field; a click at the diagram marches the motion there in time; and the screen is
    taken away as a Python script that makes it again, as tables and as pictures. ``lobex explore`` in the shell shows
    the same as a page.

    Args:
        process: ``Rub``, of a ``Blading``, too, ``Turning`` or ``Milling``; or "rub", "turning", "milling" or
            "blading", the models that a page begins with.
        speed: lowest and highest speed, Hz, that are drawn; by default around the lobes of the most flexible mode.
        gain: lowest and highest gain.

    Returns:
        An ``Explorer``, a part of panel: its ``state`` is what the screen shows, and ``show()`` opens it in a browser.

    Raises:
        ValueError: without panel, for other processes, and for parts of one that a page has no numbers for, such as
            modes that follow the speed.
    """
    for package in ("panel", "bokeh"):
        if find_spec(package) is None:
            raise ValueError(f"explore takes {package}, which is not installed; run pip install 'lobex[explore]'")
    import panel as pn

    from lobex import _checks
    from lobex.explorer.page import Explorer
    from lobex.explorer.started import state_of
    from lobex.explorer.state import STARTS

    if isinstance(process, str):
        _checks.choice("process", process, tuple(STARTS))
        if speed is not None or gain is not None:
            from lobex.explorer.recipes import process_of

            state = state_of(process_of(STARTS[process]), speed, gain)
        else:
            state = STARTS[process]
    else:
        state = state_of(process, speed, gain)
    # What a notebook shows comes from this machine, too.
    pn.extension("tabulator", inline=True)
    return Explorer(state)
