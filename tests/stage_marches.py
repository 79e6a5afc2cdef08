"""Stages that march in casings that give way, and the growth that the equations say they have."""

from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

import lobex
from real_blades import grown, in_permanent_contact


def a_step_early(blading, casing, speed, steps):
    """The rub of which every blade comes to its track a step early, of a structure that goes by the true speed; and the
    speed at which it is to be asked.
    """
    early = 1 - blading.count / steps
    rub = lobex.Rub(blading, casing=casing).at_speed(speed)
    if blading.spacing is not None:
        gaps = (np.asarray(blading.spacing) / 360 - 1 / steps) / early
        rub = replace(rub, modes=replace(rub.modes, spacing=360 * gaps))
    return rub, speed / early


def growth(blading, casing, stiffness, speed, steps):
    """|μ| per revolution of a march in permanent contact, by the operator."""
    rub, faster = a_step_early(blading, casing, speed, steps)
    period = float(rub.system(faster, stiffness).period)
    return float(lobex.spectral_radius(rub, faster, stiffness)) ** (1 / (speed * period))


def stiffness_of(blading, casing, speed, steps, wanted):
    """The contact stiffness with which a march grows by about so much in a revolution."""
    low, high = 1e3, 1e3
    while growth(blading, casing, high, speed, steps) < wanted:
        low, high = high, 3 * high
    return brentq(lambda one: growth(blading, casing, one, speed, steps) - wanted, low, high, rtol=1e-2)


def marched_growth(blading, casing, stiffness, speed, steps, revolutions):
    """The same from the march itself."""
    march = in_permanent_contact(blading, stiffness, speed, steps, revolutions, casing, incursion=4e-5)
    return np.abs(grown(march))[0]
