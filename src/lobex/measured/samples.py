"""What the readers of all formats hand on: responses as a file has them, and what it says of their units."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Complex, Float

from lobex.measured.response_units import ResponseUnit


class Samples(NamedTuple):
    """Responses in the units of a file.

    Attributes:
        frequency: (n,), in the file's order.
        value: (n, responses, references); NaN throughout of a pair that was not measured.
        response, reference: names of their directions; nothing where the file has none.
        coherence: as many, or None.
        unit: of the responses, None where the file does not say.
        frequency_scale: size of the unit of frequency, Hz, None where the file does not say.
        notes: how the file was read.
    """

    frequency: Float[np.ndarray, " n"]
    value: Complex[np.ndarray, "n responses references"]
    response: tuple[str, ...] = ()
    reference: tuple[str, ...] = ()
    coherence: Float[np.ndarray, "n responses references"] | None = None
    unit: ResponseUnit | None = None
    frequency_scale: float | None = None
    notes: tuple[str, ...] = ()
