"""What results say in small numbers: words for people, and flags with their meanings for files."""

from enum import IntEnum
from typing import Any

import numpy as np


class Code(IntEnum):
    """One of a few things that can be said of a point."""

    @property
    def words(self) -> str:
        """Such as "none in range"."""
        return self.name.lower().replace("_", " ")

    @classmethod
    def words_of(cls, codes: Any) -> np.ndarray:
        """The words of every one of an array of codes."""
        return np.array([code.words for code in cls])[np.asarray(codes)]


class PointStatus(Code):
    """What became of a point of a chart; of several the worst."""

    GOOD = 0
    SETTLED_AGAIN = 1
    ABOVE_TOLERANCE = 2
    FAILED = 3


class OrbitStatus(Code):
    """What became of the periodic motion at a point."""

    GOOD = 0
    ABOVE_TOLERANCE = 1
    UNSTABLE = 2
    FAILED = 3
    TOOTH_LEAVES_THE_CUT = 4


class Binding(Code):
    """What keeps a depth of cut from being larger."""

    STABILITY = 0
    POWER = 1
    TORQUE = 2
    LOCATION_ERROR = 3
    RANGE = 4


class Outcome(Code):
    """What a model said of a cut that was made."""

    QUIET_AS_SAID = 0
    CHATTER_AS_SAID = 1
    CHATTER_BELOW_THE_LIMIT = 2
    QUIET_ABOVE_THE_LIMIT = 3
    OUTSIDE_THE_CHART = 4


class Status(Code):
    """What became of the search at one speed."""

    FOUND = 0
    NONE_IN_RANGE = 1
    UNSTABLE_AT_THE_LOWER_BOUND = 2
    NOT_CONVERGED = 3
    TIE = 4
    BEYOND_THE_MEASURED_FREQUENCIES = 5
    UNDEFINED = 6
    STABLE_AT_ANY_GAIN = 7
    MORE_INTERVALS_THAN_KEPT = 8


class Kind(Code):
    """How the dominant multiplier leaves the unit circle."""

    NONE = 0
    HOPF = 1
    FLIP = 2
    FOLD = 3

    @property
    def words(self) -> str:
        """Such as "hopf", empty where there is no limit."""
        return "" if self is Kind.NONE else super().words


def flags(codes: type[Code]) -> dict[str, Any]:
    """The attributes of a variable of codes, as the conventions for climate and forecast metadata have them."""
    meanings = " ".join(code.name.lower() for code in codes)
    return {"flag_values": np.array(list(codes), dtype=np.int8), "flag_meanings": meanings}
