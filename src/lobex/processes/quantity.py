"""What the gain of a process is: its name and units, on which axes and messages agree."""

from typing import NamedTuple


class Quantity(NamedTuple):
    """What a gain is, and what its process promises of it; nothing checks the promises.

    Attributes:
        name, symbol, unit: for axes and messages.
        display_unit, scale: the unit of axes, and its size in SI.
        signed: negative gains have a meaning. Otherwise they are refused.
        delayed_only: the present forces P y are the same whatever the gain, which acts on the delayed ones alone.
            Operators then solve for the present forces once, and numbers are wrong where the promise is not kept.
    """

    name: str
    symbol: str
    unit: str
    display_unit: str
    scale: float
    signed: bool = False
    delayed_only: bool = False


CONTACT_STIFFNESS = Quantity("contact stiffness", "K_e", "N/m", "MN/m", 1e6)
DEPTH_OF_CUT = Quantity("depth of cut", "b", "m", "mm", 1e-3)
DELAYED_GAIN = Quantity("delayed gain", "b", "1", "1", 1.0, signed=True, delayed_only=True)
