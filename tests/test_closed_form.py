"""``exact_limit`` of processes of one's own: it is their equations that are asked, not their class."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax.tree_util import Partial

import lobex
from cases import ROD
from lobex._pytree import pytree
from lobex.limits.closed_form import Regeneration, closed_form
from lobex.systems.coefficients import Constant
from lobex.systems.delays import Share
from lobex.systems.terms import Delayed, Present, Regenerative
from own_feedback import held, modal, seen
from reference_cases import blade_process

SPEEDS = np.linspace(60, 400, 32)
UNIT = np.ones((1, 1))


def own_rub(modes, **others):
    omega, ratio, shape = modes.angular_frequency, modes.damping_ratio, modes.shape[:, 0]
    dense = modal(omega, ratio, np.ones_like(omega))
    return lobex.LinearDelay(
        dense.drift,
        [(Partial(seen, UNIT), None)],
        present=Partial(seen, -UNIT),
        inputs=np.concatenate([0 * omega, shape / omega])[:, None],
        outputs=np.concatenate([shape, 0 * omega])[None],
        **others,
    )


@pytest.mark.slow
def test_an_equation_written_by_hand_has_the_limit_of_the_rub():
    exact, own = lobex.exact_limit(ROD, SPEEDS), lobex.exact_limit(own_rub(ROD.modes), SPEEDS)
    assert own.gain == pytest.approx(exact.gain, rel=1e-11)
    assert own.chatter_frequency == pytest.approx(exact.chatter_frequency, rel=1e-11)
    assert own.method == exact.method
    lobes = lobex.exact_lobes(own_rub(ROD.modes), 3).minimum
    assert lobes.gain == pytest.approx(lobex.exact_lobes(ROD, 3).minimum.gain, rel=1e-11)


@pytree()
class Tip:
    """A rub of one's own, in blocks of two states, which leaves a part of its track."""

    modes: lobex.Modes
    stiffness: float
    left: float = 1.0

    gain = lobex.Rub.gain
    speed_unit = "Hz"

    def system(self, speed, gain):
        unit = self.stiffness * gain * jnp.eye(1)
        terms = Present(Constant(-unit)), Delayed(Constant(self.left * unit))
        return replace(lobex.Rub(self.modes).system(speed, gain), terms=terms)


@pytree()
class Whole(Tip):
    """As above, with all of its track."""

    def system(self, speed, gain):
        terms = (Regenerative(Constant(self.stiffness * gain * jnp.eye(1))),)
        return replace(lobex.Rub(self.modes).system(speed, gain), terms=terms)


@pytest.mark.slow
def test_a_class_of_ones_own_and_derivatives_by_its_numbers():
    exact = lobex.exact_limit(ROD, SPEEDS).gain
    for own in (Tip(ROD.modes, 2.0), Whole(ROD.modes, 2.0)):
        assert lobex.exact_limit(own, SPEEDS).gain == pytest.approx(exact / 2, rel=1e-13)
    with jax.enable_x64(True):

        def limit(process):
            return lobex.exact_limit(process, 85.0).gain[0]

        mine, wanted = (jax.tree.map(np.asarray, jax.jit(jax.grad(limit))(p)) for p in (Whole(ROD.modes, 2.0), ROD))
        # A part that is left is a number like any other, of which nothing is known while it is traced.
        with pytest.raises(ValueError, match="Tip has no exact limit, since it has a force that is not one of what is"):
            jax.grad(limit)(Tip(ROD.modes, 2.0))
    assert mine.modes.damping_ratio == pytest.approx(wanted.modes.damping_ratio / 2, rel=1e-10)
    assert mine.modes.shape == pytest.approx(wanted.modes.shape / 2, rel=1e-10)
    assert mine.stiffness == pytest.approx(-limit(ROD) / 4, rel=1e-10)


@pytest.mark.slow
def test_traced_critical_gains_ask_the_same():
    with jax.enable_x64(True):
        traced = jax.jit(lambda p: lobex.critical_gain(p, SPEEDS[:4], (1e3, 1e7)).gain)(Whole(ROD.modes, 1.0))
    assert np.asarray(traced) == pytest.approx(lobex.exact_limit(ROD, SPEEDS[:4]).gain, rel=1e-12)


@pytest.mark.slow
def test_a_measured_receptance_in_a_class_of_ones_own():
    frequency = np.linspace(150, 2500, 4000)
    omega = 2 * np.pi * frequency[:, None]
    own, ratio = ROD.modes.angular_frequency, ROD.modes.damping_ratio
    response = np.sum(ROD.modes.shape[:, 0] ** 2 / (own**2 - omega**2 + 2j * ratio * own * omega), axis=1)
    measured = lobex.Receptance(frequency, response)
    speeds = np.array([60.0, 85.0, 150.0, 200.0])
    expected = lobex.exact_limit(lobex.Rub(measured), speeds).gain
    assert lobex.exact_limit(Tip(measured, 2.0), speeds).gain == pytest.approx(expected / 2, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("lead", [2e-4, -1e-4])
def test_velocities_that_are_seen(lead):
    # f = −K [x + c ẋ − the same a period ago], so that G is (1 + jωc) times that of the displacement.
    omega, ratio, mass = np.array([900.0, 1500.0]), np.array([0.03, 0.02]), np.array([1.0, 2.0])
    rows = np.array([[1.0, lead]])
    process = modal(omega, ratio, mass, present=Partial(seen, -rows), delayed=[(Partial(seen, rows), None)])
    speeds = np.linspace(40, 300, 32)
    limit = lobex.exact_limit(process, speeds)
    found = 2 * np.pi * limit.chatter_frequency[:, None]
    receptance = np.sum((1 + 1j * lead * found) / mass / (omega**2 - found**2 + 2j * ratio * omega * found), axis=1)
    assert limit.gain == pytest.approx(-0.5 / receptance.real, rel=1e-11)
    loop = 1 + limit.gain * receptance * (1 - np.exp(-1j * found[:, 0] / speeds))
    assert np.max(np.abs(loop)) < 1e-9
    # That none is lower, by all crossings of the axis.
    assert limit.gain == pytest.approx(lobex.critical_gain(process, speeds, (1e2, 1e9)).gain, rel=1e-10)


def test_a_spring_without_gain_is_part_of_the_structure():
    own = modal([600.0], [0.02], [2.0])
    process = replace(own, delayed=((Partial(seen, UNIT), None),), present=Partial(held, np.array([[-3e5], [1.0]])))
    process = replace(process, outputs=own.outputs[:1])
    stiffer = np.sqrt(600.0**2 + 1.5e5)
    mode = lobex.Modes.single(frequency=stiffer / (2 * np.pi), damping_ratio=12.0 / stiffer, mass=2.0)
    speeds = np.linspace(40, 150, 32)
    assert lobex.exact_limit(process, speeds).gain == pytest.approx(
        lobex.exact_limit(lobex.Rub(mode), speeds).gain, rel=1e-11
    )


def test_a_single_state_is_hayes_equation():
    own = lobex.LinearDelay([[-1.5]], [(Partial(seen, 2 * UNIT), None)])
    limit, scalar = (lobex.exact_limit(process, [0.5, 2.0]) for process in (own, lobex.Scalar(-1.5)))
    assert limit.gain == pytest.approx(scalar.gain / 2, rel=1e-14)
    assert limit.intervals == pytest.approx(scalar.intervals / 2, rel=1e-14)


def test_without_damping_the_limit_is_undefined_at_whole_waves():
    process = own_rub(lobex.Modes.single(frequency=100.0, damping_ratio=0.0, mass=2.0))
    assert lobex.exact_limit(process, [50.0, 80.0]).status.tolist() == ["undefined", "found"]


BEAM = {
    "beam": {"E": 110e9, "rho": 4430.0, "L": 0.2, "width": 0.05, "thickness": 0.004, "xi": 0.01},
    "beta": [1.8751040687119611, 4.694091132974174, 7.854757438237613],
    "casing": {"frequency_Hz": 350.0, "xi": 0.02, "m": 1.5, "nd": 2, "alpha_deg": 30, "friction": 0.15},
}


@pytest.mark.parametrize(
    ("speed", "gain", "frequency"),
    [(60.0, 5343.42631014, 91.5005856041), (180.0, 6526.9186286, 93.7748290323), (260.0, 30972.1589952, 131.423335107)],
)
def test_a_ring_casing_that_the_contact_turns_past(speed, gain, frequency):
    # Two codes agree to 1e-12. The casing's pair of modes is coupled by the turning, so that no mode is its own.
    process = blade_process(BEAM, {"case": "casing-ring", "speed_Hz": speed})
    limit = lobex.exact_limit(process, speed)
    assert limit.gain[0] == pytest.approx(gain, rel=5e-12)
    assert limit.chatter_frequency[0] == pytest.approx(frequency, rel=5e-12)


def pulling(numbers, t, speed, gain):
    return gain * speed * jnp.ones((1, 1))


@pytree()
class Early(Tip):
    """As above, of a track that is half as old."""

    def system(self, speed, gain):
        terms = (Regenerative(Constant(gain * jnp.eye(1)), Share(0.5)),)
        return replace(lobex.Rub(self.modes).system(speed, gain), terms=terms, shortest=0.5)


@pytree()
class Twice(Tip):
    """As above, of two blades that follow each other in a revolution."""

    def system(self, speed, gain):
        return lobex.Rub(self.modes).system(2 * speed, gain)


@pytest.mark.parametrize(
    ("process", "words"),
    [
        (Twice(ROD.modes, 1.0), "has another period than one revolution"),
        (Tip(ROD.modes, 1.0, 0.6), "has a force that is not one of what is now less what was a period ago"),
        (Early(ROD.modes, 1.0), "has other delays than its period"),
        (lobex.DelayedMathieu(1.0, 1.0), "has periodic coefficients"),
        (lobex.LinearDelay([[-1.0]], [(Partial(pulling, 0.0), None)]), "has coefficients that follow the speed"),
        (replace(own_rub(ROD.modes), drift=-np.asarray(own_rub(ROD.modes).drift)), "is not stable by itself"),
        (replace(own_rub(ROD.modes), delayed=((UNIT, None),)), "has forces that are not proportional to the gain"),
    ],
)
def test_what_has_no_closed_form_is_refused_in_words(process, words):
    assert not isinstance(closed_form(process), Regeneration)
    with pytest.raises(ValueError) as error:
        lobex.exact_limit(process, [100.0])
    assert words in str(error.value)
    assert "give critical_gain" in str(error.value)
    assert "\n" not in str(error.value)


def test_matrices_in_coordinates_of_ones_own():
    own = own_rub(ROD.modes)
    turned = np.eye(10) + 0.1 * np.random.default_rng(3).normal(size=(10, 10))
    drift, inputs, outputs = (np.asarray(part) for part in (own.drift, own.inputs, own.outputs))
    force = turned @ inputs @ outputs @ np.linalg.inv(turned)
    process = lobex.LinearDelay(
        turned @ drift @ np.linalg.inv(turned), [(Partial(seen, force), None)], present=Partial(seen, -force)
    )
    assert lobex.exact_limit(process, SPEEDS).gain == pytest.approx(lobex.exact_limit(ROD, SPEEDS).gain, rel=1e-9)
