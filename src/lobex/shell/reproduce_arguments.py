"""The flags of ``lobex reproduce``."""

from dataclasses import dataclass
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Reproduce:
    """Reproduce the thesis' figures: all, or those named, each to OUT/NAME.png with its numbers in OUT/NAME.nc.

    What the thesis reads from a figure is printed beside what comes out here.

    Example: lobex reproduce fig-4.3 fig-4.13 --out figures
    """

    names: Annotated[
        tuple[str, ...], tyro.conf.Positional, tyro.conf.arg(metavar="[NAME ...]", help_behavior_hint="(default: all)")
    ] = ()
    """Figures, such as fig-4.3; all of them if none is named."""
    out: Annotated[str, tyro.conf.arg(metavar="DIR")] = "figures"
    """Folder to write into; it is made if it is not there."""
    show: Annotated[bool, tyro.conf.FlagCreatePairsOff, tyro.conf.arg(name="list")] = False
    """List the names and titles, and do nothing else."""
    pdf: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write OUT/NAME.pdf, too."""
    quiet: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """No progress bar and no findings."""
