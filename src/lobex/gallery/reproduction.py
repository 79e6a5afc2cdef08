"""What the gallery holds of a figure: how it is computed and drawn, and what the thesis reads from it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Results of lobex or datasets of xarray, by name.
Results = dict[str, Any]


@dataclass(frozen=True)
class Finding:
    """One thing that the thesis says or shows, beside what comes out here.

    Attributes:
        claim: the thesis' claim, in our words.
        thesis: its value or wording.
        ours: what was computed, in words with numbers.
        agrees: whether the two agree.
        why: the reason for a difference, or what bounds the agreement.
        numbers: the numbers behind ``ours``, by name, in SI units or as shares.
    """

    claim: str
    thesis: str
    ours: str
    agrees: bool
    why: str = ""
    numbers: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Reproduction:
    """A figure of the thesis.

    Attributes:
        name: such as "fig-4.3".
        title: what the figure shows.
        claim: what the thesis reads from it, in our words.
        compute: the numbers behind the figure: results or datasets by name. Its argument is the share of the full
            grid's points along each axis, 1 for the figure itself and less for a quick look.
        draw: the figure, from what ``compute`` returned.
        findings: the claims one by one, with numbers, from what ``compute`` returned.
    """

    name: str
    title: str
    claim: str
    compute: Callable[[float], Results]
    draw: Callable[[Results], "Figure"]
    findings: Callable[[Results], list[Finding]]
