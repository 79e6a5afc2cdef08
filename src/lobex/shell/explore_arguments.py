"""The flags of ``lobex explore``."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from lobex.shell.arguments import count_hint


def _file(name: str) -> object:
    return tyro.conf.arg(name=name, metavar="FILE", help_behavior_hint="(default: the thesis' model)")


@dataclass(frozen=True)
class Explore:
    """Lobes that follow sliders, on a page in the browser that this machine alone sees; Ctrl-C ends it.

    Takes panel and bokeh: pip install 'lobex[explore]'.

    Example: lobex explore milling --tool docs/howto/tool.toml
    """

    process: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="rub|turning|milling|blading")] = "rub"
    """What the page begins with."""
    tool_file: Annotated[str | None, _file("tool")] = None
    """TOML file of a tool, of turning or milling (docs/howto/cutters.md)."""
    frf_file: Annotated[str | None, _file("frf")] = None
    """Measured frequency response, whose fitted modes the page begins with."""
    frf_unit: Annotated[str | None, tyro.conf.arg(metavar="UNIT", help_behavior_hint="(default: as the file says)")] = (
        None
    )
    """Unit of the response over the force, such as m/N or g/N."""
    port: Annotated[int, count_hint("any that is free")] = 0
    """To listen at, on 127.0.0.1."""
    show: bool = True
    """Open the page in the browser."""
