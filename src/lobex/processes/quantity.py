"""What the gain of a process is: its name and units, on which axes and messages agree."""

from typing import NamedTuple


class Quantity(NamedTuple):
    """A gain: ``scale`` of the display unit in SI, whether it may be negative, and whether all present forces are
    the same whatever it is.
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
