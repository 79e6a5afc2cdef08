"""``exact_limit`` of several contacts, each in its own track, by the eigenvalues of their receptance."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from jax.tree_util import Partial

import lobex
from contact_scan import least_limit
from lobex.limits.d_subdivision import exact_branches, exact_critical, exact_minimum
from own_feedback import seen
from refusals import refused

SPEEDS = np.array([37.0, 61.0, 130.0, 420.0])


def structure(seed, contacts, friction=0.0):
    """Four modes, of which every second structure has two as good as coincident."""
    rng = np.random.default_rng(seed)
    omega = 2 * np.pi * np.sort(rng.uniform(100.0, 600.0, 4))
    omega[1] = omega[0] * (1 + 1e-4) if seed % 2 else omega[1]
    ratio = np.exp(rng.uniform(np.log(0.005), np.log(0.08), 4))
    shape = rng.normal(size=(4, contacts))
    return lobex.Modes(omega, ratio, shape, shape + friction * rng.normal(size=shape.shape))


TWO = structure(0, 2)


@pytest.mark.parametrize(
    ("seed", "contacts", "friction"),
    [
        (2, 2, 0.4),
        *(pytest.param(*case, marks=pytest.mark.slow) for case in ((0, 2, 0.0), (5, 3, 0.4))),
        *(pytest.param(*case, marks=pytest.mark.search) for case in ((1, 2, 0.0), (3, 2, 0.4), (4, 3, 0.0))),
    ],
)
def test_no_crossing_is_missed(seed, contacts, friction):
    modes = structure(seed, contacts, friction)
    weight = modes.shape[:, :, None] * modes.loading[:, None, :]
    wanted = [least_limit(modes.angular_frequency, modes.damping_ratio, weight, speed) for speed in SPEEDS]
    limit = lobex.exact_limit(lobex.Rub(modes), SPEEDS)
    assert limit.gain == pytest.approx([gain for gain, _ in wanted], rel=1e-11)
    assert 2 * np.pi * limit.chatter_frequency == pytest.approx([omega for _, omega in wanted], rel=1e-9)
    assert set(limit.status) == {"found"}


@pytest.mark.slow
def test_the_monodromy_operator_is_at_the_limit_there_and_stable_below():
    process = lobex.Rub(TWO)
    limit = lobex.exact_limit(process, SPEEDS)
    factor = np.array([1.0, 0.999, 1.001])
    radius = lobex.spectral_radius(process, SPEEDS[:, None], limit.gain[:, None] * factor, lobex.Chebyshev(64))
    assert radius[:, 0] == pytest.approx(1.0, abs=1e-8)
    assert np.all((radius[:, 1] < 1) & (radius[:, 2] > 1))


def test_a_symmetric_structure_is_two_of_one_contact():
    even = np.array([True, False, True, False])
    modes = replace(TWO, shape=np.column_stack([np.ones(4), np.where(even, 1.0, -1.0)]), force_shape=None)
    limit = lobex.exact_limit(lobex.Rub(modes), SPEEDS)
    parts = []
    for half in (even, ~even):
        numbers = (part[half] for part in (TWO.angular_frequency, TWO.damping_ratio))
        parts.append(exact_critical(lobex.Modes(*numbers, np.full((2, 1), np.sqrt(2))), SPEEDS).gain)
    assert limit.gain == pytest.approx(np.min(parts, axis=0), rel=1e-12)
    # Both halves have the limit at one speed or another.
    assert len(set(np.argmin(parts, axis=0))) == 2


@pytest.mark.slow
def test_sharp_resonances_keep_their_digits():
    # Where two contacts have nothing in common, the limit is that of one: near 1e-7 of a frequency from its resonance.
    x, y = (lobex.Modes([own, 1.7 * own], [1e-7, 2e-7], [[1.0], [0.7]]) for own in (900.0, 1000.0))
    limit = lobex.exact_limit(lobex.Rub(lobex.Modes.plane(x=x, y=y)), SPEEDS).gain
    each = [lobex.exact_limit(lobex.Rub(one), SPEEDS).gain for one in (x, y)]
    assert limit == pytest.approx(np.min(each, axis=0), rel=1e-12)


def test_equal_blades_that_are_not_coupled_have_the_limit_of_one():
    one = lobex.Modes.single(frequency=400.0, damping_ratio=0.005, mass=1 / 9)
    process = lobex.Rub(lobex.Modes.plane(x=one, y=one))
    limit = lobex.exact_limit(process, SPEEDS)
    assert limit.gain == pytest.approx(lobex.exact_limit(lobex.Rub(one), SPEEDS).gain, rel=1e-12)
    # Which of the two begins is left open.
    assert set(limit.status) == {"tie"}


@pytest.mark.slow
def test_a_ring_of_coupled_blades_is_one_contact_for_each_nodal_diameter():
    blades, own, between, phi = 6, 2 * np.pi * 400.0, (2 * np.pi * 60.0) ** 2, 3.0
    unit = np.eye(blades)
    ring = 2 * unit - np.roll(unit, 1, axis=0) - np.roll(unit, -1, axis=0)
    pull = -(phi**2) * unit
    process = lobex.LinearDelay(
        np.block([[0 * unit, unit], [-(own**2) * unit - between * ring, -0.01 * own * unit]]),
        [(Partial(seen, -pull), None)],
        present=Partial(seen, pull),
        inputs=np.concatenate([0 * unit, unit]),
        outputs=np.concatenate([unit, 0 * unit], axis=1),
    )
    speeds = np.array([330.0, 420.0, 510.0, 660.0])
    frequency = np.sqrt(own**2 + 4 * between * np.sin(np.pi * np.arange(4) / blades) ** 2)
    each = [exact_critical(lobex.Modes([omega], [0.005 * own / omega], [[phi]]), speeds).gain for omega in frequency]
    limit = lobex.exact_limit(process, speeds)
    assert limit.gain == pytest.approx(np.min(each, axis=0), rel=1e-10)
    # Nodal diameters but the first and the last come in pairs.
    assert ((limit.status == "tie") == np.isin(np.argmin(each, axis=0), [1, 2])).all()
    assert len(set(np.argmin(each, axis=0))) > 1


def by_hand(now, before, narrow=True):
    """The equation of the two contacts in matrices: f = −K [W y − V y(t − τ)], with forces of the state or without."""
    omega, ratio, shape, none = TWO.angular_frequency, TWO.damping_ratio, TWO.shape, np.zeros((4, 4))
    drift = np.block([[none, np.diag(omega)], [-np.diag(omega), -2 * np.diag(ratio * omega)]])
    inputs, outputs = np.concatenate([0 * shape, shape / omega[:, None]]), np.concatenate([shape, 0 * shape]).T
    sides = {"inputs": inputs, "outputs": outputs} if narrow else {}
    now, before = (part if narrow else inputs @ part @ outputs for part in (now, before))
    return lobex.LinearDelay(drift, [(Partial(seen, before), None)], present=Partial(seen, -now), **sides)


def test_contacts_whose_displacements_make_forces_at_each_other():
    across = np.array([[1.0, 0.3], [-0.2, 0.8]])
    wanted = lobex.exact_limit(lobex.Rub(replace(TWO, force_shape=TWO.shape @ across)), SPEEDS).gain
    for narrow in (True, False):
        process = by_hand(across, across, narrow)
        assert lobex.exact_limit(process, SPEEDS).gain == pytest.approx(wanted, rel=1e-11)


def test_lobes_as_curves_and_their_minimum():
    lobes = lobex.exact_lobes(lobex.Rub(TWO), lobes=4)
    assert lobes.speed.shape == (4, *lobes.gain.shape)
    assert exact_minimum(lobex.Rub(TWO), 4).gain == lobes.minimum.gain
    below = np.nanmin(lobes.gain)
    assert below * (1 - 1e-3) < lobes.minimum.gain <= below
    at_least = lobex.exact_limit(lobex.Rub(TWO), lobes.minimum.speed).gain
    assert at_least == pytest.approx(np.full(4, lobes.minimum.gain), rel=1e-10)
    speed, gain = lobes.speed[1][::23], lobes.gain[::23]
    shown = np.isfinite(gain)
    limit = lobex.exact_limit(lobex.Rub(TWO), speed[shown]).gain
    assert np.all(limit <= gain[shown] * (1 + 1e-10))
    assert np.any(np.isclose(limit, gain[shown], rtol=1e-9))


@pytest.mark.slow
def test_derivatives_by_the_numbers_of_a_structure_and_by_the_speed():
    def limit(shape, speed):
        return lobex.exact_limit(lobex.Rub(replace(TWO, shape=shape, force_shape=None)), speed).gain[0]

    with jax.enable_x64(True):
        by_shape, by_speed = jax.grad(limit, argnums=(0, 1))(TWO.shape, 61.0)
    step = 1e-6
    change = np.zeros((4, 2))
    change[1, 0] = step
    difference = (limit(TWO.shape + change, 61.0) - limit(TWO.shape - change, 61.0)) / (2 * step)
    assert by_shape[1, 0] == pytest.approx(difference, rel=1e-7)
    assert by_speed == pytest.approx((limit(TWO.shape, 61.001) - limit(TWO.shape, 60.999)) / 0.002, rel=1e-6)
    # A limit is as many times as large where all shapes are as small.
    assert np.sum(np.asarray(by_shape) * TWO.shape) == pytest.approx(-2 * limit(TWO.shape, 61.0), rel=1e-10)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: jax.jit(lambda s: lobex.exact_limit(lobex.Rub(TWO), s).gain)(60.0), "outside jit and vmap"),
        (lambda: lobex.exact_limit(lobex.Rub(replace(TWO, damping_ratio=0 * TWO.damping_ratio)), 60.0), "without damp"),
        (lambda: lobex.exact_limit(by_hand(np.eye(2), np.eye(2)[::-1]), 60.0), "not one of what is now less what was"),
        (lambda: exact_branches(lobex.Rub(TWO), [1.0]), "give exact_lobes"),
        (lambda: exact_critical(lobex.Rub(TWO), 60.0, 1e3), "lowest = 1000.0"),
        (lambda: jax.grad(lambda s: exact_minimum(lobex.Rub(replace(TWO, shape=s))).gain)(TWO.shape), "is traced"),
        (lambda: exact_minimum(TWO), "2 contact directions"),
    ],
)
def test_what_is_refused(call, words):
    with refused(match=words):
        call()
