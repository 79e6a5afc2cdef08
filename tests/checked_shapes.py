"""Calls every verb with the shapes of all signatures checked: a process of its own, which test_shapes.py starts."""

import warnings

import jax
import matplotlib
import numpy as np
import pytest
from jaxtyping import TypeCheckError, install_import_hook

# An integer is taken for a float, as type checkers do.
install_import_hook("lobex", "beartype.beartype(conf=beartype.BeartypeConf(is_pep484_tower=True))")

import lobex
from lobex.floquet.power import pair_by_squaring
from lobex.systems.system import DelaySystem
from tap_test import FREQUENCY, RECEPTANCE, noisy

SPEED, GAIN = np.array([60.0, 90.0]), np.array([1e5, 4e5])
SIX = lobex.Duhamel(nodes=6)
MODES = lobex.Rod(2).modes()
RUB = lobex.Rub(MODES)
BEAM = lobex.Beam.rectangular(
    elements=1, length=0.2, width=[0.05, 0.04], thickness=0.004, young_modulus=110e9, density=4430.0
)
PLACES = {"angles_degrees": (0.0, 9.0)}
RUBBING = {"sliding": (0.0, 1.0, 0.0), "friction": 0.2}
MILLING = lobex.Milling(
    modes=lobex.Modes.single(frequency=922.0, damping_ratio=0.011, mass=0.03993),
    teeth=2,
    tangential=6e8,
    normal=2e8,
    radial_immersion=0.1,
    feed_per_tooth=1e-4,
)


def multipliers():
    for method in (SIX, lobex.Chebyshev(nodes=8), lobex.SemiDiscretization(steps=8)):
        lobex.monodromy(MILLING, 150.0, 1e-3, method)
    lobex.multipliers(RUB, 60.0, 1e5, SIX)
    lobex.spectral_radius(RUB, SPEED, GAIN)
    jax.grad(lambda gain: lobex.spectral_radius(RUB, 60.0, gain, SIX))(1e5)


def charts():
    lobex.sweep(RUB, SPEED, GAIN)


def limits():
    lobex.exact_limit(RUB, SPEED)
    BEAM.modes(0.01, [1, 2], **RUBBING)
    lobex.exact_limit(lobex.Rub(BEAM.rotating(0.01, [1, 2, 3], **RUBBING)), SPEED)
    lobex.exact_lobes(RUB, lobes=2)
    lobex.critical_gain(RUB, SPEED, (0.0, 1e6))
    lobex.sensitivities(RUB, SPEED)


def measured():
    frf = lobex.Frf(FREQUENCY, noisy(RECEPTANCE, 0.01), ("x", "y"), ("x", "y"))
    frf.fit(order=2, real=False).plot()
    fit = frf.fit()
    repr(fit), fit.plot_stabilisation(), frf.between(100.0, 900.0).plot()
    for modes in (frf.receptance_matrix(), frf.receptance("x"), fit.modes):
        process = lobex.Milling(modes, 4, 6e8, 2e8, 0.5, "down")
        lobex.zero_order_limit(process, 80.0)
        lobex.multi_frequency_limit(process, 80.0)


def marches():
    lobex.orbit(MILLING, 150.0, 1e-4, SIX)
    lobex.march_delay(RUB, 60.0, 1e5, lambda t: 1e-6 * np.cos(500 * t), 2, 300)
    lobex.march_wear(MODES, lobex.Casing(), lobex.Linear(1e5), SPEED, 2, 1024)
    blades = lobex.Blading(
        BEAM.rotating(0.01, [1, 2], **RUBBING), 3, mistuning=np.array([0.0, 0.01, 0.02]), coupling=10.0
    )
    ring = lobex.Casing(3, structure=lobex.Ring(*(np.array([number]) for number in (2.0, 300.0, 0.02, 5.0))))
    lobex.march_wear(blades, ring, lobex.KelvinVoigt(1e5, 10.0), SPEED, 2, 1536, incursion=1e-6)
    watched = BEAM.modes(0.01, [1, 2], chord=[0.0, 0.01], watched=BEAM.watch(tip=True, root_loads=True))
    march = lobex.march_wear(
        watched, lobex.Casing(), lobex.Linear(1e5), SPEED, 2, 1536, watched=9, tracks=(0, 0), angles_degrees=(0, 9)
    )
    march.of(1)
    lobex.simulate_turning(MODES, lobex.Linear(1e8), 60.0, 1e-4, 1e-4, 2, 300)


def refusals():
    """The same check finds a wrong shape in a function, and in a system that is made."""
    with pytest.raises(TypeCheckError, match="matrix"):
        pair_by_squaring(jax.numpy.zeros((3, 2)), 4)
    right = RUB.system(60.0, 1e5)
    with pytest.raises(TypeCheckError, match="inputs"):
        DelaySystem(right.blocks, right.outputs[:1], right.outputs, right.period, right.terms)


if __name__ == "__main__":
    matplotlib.use("Agg")
    # Of so few nodes, and of modes that are not complex.
    warnings.simplefilter("ignore", lobex.LobexWarning)
    for part in (multipliers, charts, limits, measured, marches, refusals):
        part()
        print(part.__name__)
