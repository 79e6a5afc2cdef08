"""What the gain of a process is: its name and units, on which axes and messages agree."""

from typing import NamedTuple


class Quantity(NamedTuple):
    """A gain: ``scale`` of the display unit in SI, and whether it may be negative."""

    name: str
    symbol: str
    unit: str
    display_unit: str
    scale: float
    signed: bool = False


CONTACT_STIFFNESS = Quantity("contact stiffness", "K_e", "N/m", "MN/m", 1e6)
DEPTH_OF_CUT = Quantity("depth of cut", "b", "m", "mm", 1e-3)
DELAYED_GAIN = Quantity("delayed gain", "b", "1", "1", 1.0, signed=True)
