"""A stack of straight discs in place of a profile: the thickness, the lead angle and the lag of each."""

from typing import Any

import numpy as np
from jaxtyping import Float

from lobex import _checks
from lobex._namespace import namespace
from lobex._shapes import AnyArray


def stacked(thickness: Any, lead_degrees: Any, lag_degrees: Any) -> Float[AnyArray, "discs 3"]:
    """Thickness, m, lead angle and lag, rad, of discs from the tip, (discs, 3); 90 and 0 degrees for None.

    Raises:
        ValueError: for discs without thickness, lead angles that are not above 0 and up to 90 degrees, and other
            lengths than that of ``thickness``.
    """
    thickness = _checks.as_array(thickness)
    _checks.positive("thickness", thickness, "m")
    count = np.shape(thickness)
    if len(count) != 1:
        raise ValueError(f"thickness has shape {count}; give one number a disc")

    def angle(name: str, given: Any, usual: float) -> Any:
        degrees = np.full(count, usual) if given is None else _checks.as_array(given)
        _checks.as_numbers(name, degrees, "degrees")
        if np.shape(degrees) != count:
            raise ValueError(f"{name} has shape {np.shape(degrees)}; give one angle a disc, {count}")
        return degrees * (np.pi / 180)

    lead, lag = angle("lead_degrees", lead_degrees, 90.0), angle("lag_degrees", lag_degrees, 0.0)
    if not _checks.is_traced(lead) and not np.all((lead > 0) & (lead <= np.pi / 2)):
        raise ValueError(f"lead_degrees = {_checks.brief(lead_degrees)}; give angles above 0 and up to 90")
    lib = namespace(thickness, lead, lag)
    return lib.stack([lib.asarray(part) for part in (thickness, lead, lag)], axis=1)
