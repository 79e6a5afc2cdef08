"""Speeds at which a tooth passes once in so many waves of a chatter that was heard."""

from typing import Any

import numpy as np

from lobex.processes.quantity import Quantity
from lobex.results.codes import Status
from lobex.results.fields import Array, Attribute, Codes, Coordinate, field, in_gain
from lobex.results.result import Result
from lobex.results.stored import Stored
from lobex.results.units import shown_gain, shown_speed


class NextSpeeds(Result, form="lobex next speeds 1"):
    """Speeds f/(N k), the one to try first coming first.

    Attributes:
        lobe: k, waves of the chatter between teeth, (s,).
        speed: Hz, (s,).
        limit: the lowest limit of the gain there, (s,); NaN where there is none in the range, and where no process was
            given.
        status_code: members of ``Status``, (s,): of the search for the limit; "undefined" where no process was given.
        chatter_frequency: f, Hz.
        teeth: N.
        quantity: what the gain is.
        speed_unit: "Hz" or "rpm", for texts.
    """

    lobe: np.ndarray = field(Array("choice", "waves of the chatter between teeth", "1"))
    speed: np.ndarray = field(Coordinate("choice", "spindle speed", "Hz"))
    limit: np.ndarray = field(Array("choice", lambda found: f"limit of the {found.quantity.name}", in_gain))
    status_code: np.ndarray = field(Codes("choice", "what became of the search", name="status", codes=Status))
    chatter_frequency: float
    teeth: int
    quantity: Quantity
    speed_unit: str = field(Attribute(Stored.unit))

    @property
    def status(self) -> np.ndarray:
        """What became of the search for each limit, in words, (s,), as of ``Limit``."""
        return Status.words_of(self.status_code)

    def __repr__(self) -> str:
        lines = [f"Next speeds against chatter at {self.chatter_frequency:.6g} Hz of {self.teeth} teeth"]
        rows: Any = zip(self.lobe, self.speed, self.limit, self.status, strict=True)
        for lobe, speed, limit, status in rows:
            known = "" if status == "undefined" else f": {status}"
            told = f": limit {shown_gain(limit, self.quantity)}" if np.isfinite(limit) else known
            lines.append(f"  k = {lobe:.0f}, {shown_speed(speed, self.speed_unit)}{told}")
        return "\n".join(lines)
