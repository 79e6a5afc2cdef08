"""Saint-Venant's torsion of a rectangular section (Timoshenko and Goodier, Theory of Elasticity, 1970)."""

import numpy as np

from lobex._namespace import namespace
from lobex._shapes import Numbers

# Σ 1/n⁵ over odd n, which is 31/32 of ζ(5), and the terms of which the sum of the rest is below rounding, h/b up to 3.
_WHOLE, _TERMS = 31 / 32 * 1.0369277551433699, 2 * np.arange(24) + 1


def torsion_constant(width: Numbers, thickness: Numbers) -> Numbers:
    """J, m⁴: b h³ [1/3 − (64/π⁵)(h/b) Σ tanh(nπb/2h)/n⁵], n odd (ibid., §109)."""
    lib = namespace(width, thickness)
    slender = lib.asarray(width / thickness)
    short = lib.sum((1 - lib.tanh(_TERMS * (np.pi / 2) * slender[..., None])) / _TERMS**5.0, axis=-1)
    return width * thickness**3 * (1 / 3 - 64 / np.pi**5 / slender * (_WHOLE - short))
