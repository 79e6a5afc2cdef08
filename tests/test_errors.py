"""Bad input to processes, methods and verbs: one line that names argument, value and remedy."""

import jax
import numpy as np
import pytest

import lobex
from cases import MILL, MULTIPLIER_TOOLS, ROD, milling
from refusals import refused

TOOL = MULTIPLIER_TOOLS["Insperger-Stepan"]
GOOD = [1e5, 2e5]
MEASURED = lobex.Rub(lobex.Receptance([10.0, 20.0, 30.0, 40.0], np.full(4, 1e-6 - 1e-7j)))


def mill(**changes):
    return milling(
        {**TOOL, "teeth": changes.get("teeth", 2)}, changes.get("immersion", 0.5), changes.get("direction", "up")
    )


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: mill(teeth=0), "teeth = 0"),
        (lambda: mill(teeth=1.5), "teeth = 1.5"),
        (lambda: mill(immersion=0.0), "radial_immersion = 0 "),
        (lambda: mill(immersion=1.2), "radial_immersion = 1.2"),
        (lambda: mill(immersion=-0.1), "radial_immersion = -0.1"),
        (lambda: mill(immersion=np.nan), "radial_immersion = nan"),
        (lambda: mill(direction="sideways"), "direction = 'sideways'"),
        (lambda: lobex.Turning(ROD.modes, radial=0.0), "radial = 0"),
        (lambda: lobex.Rub(lobex.Rod()), "lobex.Rod().modes()"),
        (lambda: lobex.Turning(None, radial=1e8), "modes = None"),
        (lambda: lobex.spectral_radius(ROD, 80.0, None), "gain = None is not a number; give a real number in N/m"),
        (lambda: lobex.critical_gain(ROD, 80.0, (None, 1e6)), "gain = (None, 1000000.0) is not a number"),
        (lambda: lobex.sweep(ROD, None, [1e5, 1e6]), "speed = None is not a number; give a real number in Hz"),
        (
            lambda: lobex.sweep(ROD, [80.0], [1e5], over={"modes.damping_ratio[9]": [0.01, 0.02]}),
            "over names 'modes.damping_ratio[9]', which the model has not; modes.damping_ratio has "
            "modes.damping_ratio[0] to modes.damping_ratio[4]",
        ),
        (lambda: lobex.Milling(lobex.Rod(), 2, 1e8, 1e8, 0.5), "lobex.Rod().modes()"),
        (lambda: lobex.spectral_radius(MEASURED, 50.0, 1e5), "a measured receptance serves exact_limit"),
        (lambda: lobex.sweep(MEASURED, [50.0, 60.0], GOOD), "a measured receptance serves exact_limit"),
        (lambda: lobex.critical_gain(MEASURED, 50.0, (1e5, 2e5)), "a measured receptance serves exact_limit"),
        (lambda: lobex.DelayedMathieu(delta=1.0, epsilon=0.1, damping=-0.2), "damping = -0.2"),
        (lambda: lobex.Scalar(np.inf), "a = inf"),
        (lambda: lobex.Chebyshev(nodes=1), "nodes = 1"),
        (lambda: lobex.Chebyshev(nodes=20.0), "nodes = 20.0"),
        (lambda: lobex.SemiDiscretization(steps=0), "steps = 0"),
        (lambda: lobex.SemiDiscretization(order=3), "order = 3"),
        (lambda: lobex.spectral_radius(ROD, 0.0, 1e5), "speed = 0"),
        (lambda: lobex.spectral_radius(ROD, -5.0, 1e5), "speed = -5"),
        (lambda: lobex.spectral_radius(ROD, np.nan, 1e5), "speed = nan"),
        (lambda: lobex.spectral_radius(ROD, [50.0, np.inf], 1e5), "speed = [50, inf]"),
        (lambda: lobex.spectral_radius(ROD, "fast", 1e5), "speed = 'fast'"),
        (lambda: lobex.spectral_radius(ROD, [[50.0, 60.0], [70.0]], 1e5), "speed = [[50.0"),
        (lambda: lobex.spectral_radius(ROD, 85 + 1j, 1e5), "speed = 85+1j is complex"),
        (lambda: lobex.exact_limit(ROD, "fast"), "speed = 'fast'"),
        (lambda: lobex.critical_gain(ROD, 85.0, ("a", "b")), "gain = ('a', 'b')"),
        (lambda: lobex.spectral_radius(ROD, 50.0, -1.0), "gain = -1"),
        (lambda: lobex.spectral_radius(ROD, 50.0, np.nan), "gain = nan"),
        (lambda: lobex.spectral_radius(ROD, [50.0, 60.0], [1.0, 2.0, 3.0]), "give shapes that broadcast"),
        (lambda: lobex.spectral_radius(ROD, 85.0, 1e5, "sdm"), "method = 'sdm'"),
        (lambda: lobex.spectral_radius(ROD, 85.0, 1e5, lobex.Chebyshev), "is no method"),
        (lambda: lobex.spectral_radius(lobex.Rub, 85.0, 1e5), "is no process"),
        (lambda: lobex.multipliers(MILL, 12_000.0, 1e-3), "rpm/60"),
        (lambda: lobex.sweep(ROD, [], GOOD), "speed is empty"),
        (lambda: lobex.sweep(ROD, [60.0, 50.0], GOOD), "speed = [60, 50] is not strictly increasing"),
        (lambda: lobex.sweep(ROD, [50.0, 50.0], GOOD), "not strictly increasing"),
        (lambda: lobex.sweep(ROD, [[50.0, 60.0]], GOOD), "speed has shape (1, 2)"),
        (lambda: lobex.sweep(ROD, 50.0, GOOD), "speed has shape ()"),
        (lambda: lobex.sweep(ROD, [0.0, 60.0], GOOD), "speed = [0, 60]"),
        (lambda: lobex.sweep(ROD, [50.0, 60.0], []), "gain is empty"),
        (lambda: lobex.sweep(ROD, [50.0, 60.0], [2.0, 1.0]), "gain = [2, 1]"),
        (lambda: lobex.sweep(ROD, [50.0, 60.0], [-1.0, 1.0]), "gain = [-1, 1]"),
        (lambda: lobex.sweep(ROD, [50.0, np.nan], GOOD), "speed = [50, nan]"),
        (lambda: lobex.sweep(None, [50.0, 60.0], GOOD), "process = None"),
        (lambda: lobex.sweep(ROD, [50.0, 60.0], GOOD, method=40), "method = 40"),
        (lambda: ROD.system(-1.0, 1.0), "speed = -1"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="wobble"):
        _ = lobex.wobble


def test_four_contact_directions_cannot_mill():
    modes = lobex.Modes([10.0], [0.1], [[1.0, 1.0, 1.0, 1.0]])
    with pytest.raises(ValueError, match="4 contact directions"):
        lobex.Milling(modes, teeth=2, tangential=1e8, normal=1e8, radial_immersion=0.5)


ROD_MODES = ROD.modes
MATRICES = lobex.Rod(3).matrices()[:2]
SOUND = {
    lobex.Modes: {"angular_frequency": [9.0], "damping_ratio": [0.1], "shape": [[1.0]], "force_shape": [[1.0]]},
    lobex.Modes.single: {"frequency": 1.0, "damping_ratio": 0.1, "mass": 1.0},
    lobex.Modes.from_matrices: dict(zip(("mass", "stiffness"), MATRICES, strict=True))
    | {"contact": [0.0, 0.0, 1.0], "damping_ratio": 0.1},
    lobex.Rod: {"young_modulus": 1.0, "density": 1.0, "length": 1.0, "area": 1.0},
    lobex.Rod(2).modes: {"damping_ratio": 0.1},
    lobex.Receptance: {"frequency": [1.0, 2.0, 3.0, 4.0], "response": -1j * np.ones(4)},
    lobex.Turning: {"modes": ROD_MODES, "radial": 1e8},
    lobex.Milling: {"modes": ROD_MODES, "teeth": 2, "tangential": 1e8, "normal": 1e8, "radial_immersion": 0.5},
    lobex.DelayedMathieu: {"delta": 1.0, "epsilon": 0.1, "damping": 0.1},
    lobex.Scalar: {"a": 1.0},
    lobex.Casing: {"amplitude": 1e-4, "clearance": 0.0, "radius": 0.5, "axial_width": 0.01},
    lobex.Linear: {"stiffness": 1.0},
    lobex.Plastic: {"stiffness": 1.0, "yield_force": 1.0, "hardening": 1.0},
    lobex.spectral_radius: {"process": ROD, "speed": [50.0], "gain": [1e5]},
    lobex.sweep: {"process": ROD, "speed": [50.0, 60.0], "gain": GOOD},
    lobex.exact_limit: {"process": ROD, "speed": [50.0]},
    lobex.critical_gain: {"process": ROD, "speed": [50.0], "bounds": GOOD},
    lobex.sensitivities: {"process": ROD, "speed": [50.0]},
    lobex.march_delay: {"process": ROD, "speed": 50.0, "gain": 1e5, "history": np.cos, "periods": 9}
    | {"steps_per_period": 900, "state": np.zeros(10)},
    lobex.growing_history: {"rod": lobex.Rod(2), "speed": 50.0, "tip": 1e-7, "rate": 500.0},
    lobex.simulate_turning: {"modes": ROD_MODES, "law": lobex.Linear(1e8), "speed": 50.0, "depth": 1e-4}
    | {"feed": 1e-4, "revolutions": 2, "steps_per_revolution": 900},
    lobex.march_wear: {"modes": ROD_MODES, "casing": lobex.Casing(), "law": lobex.Linear(1e6), "speed": [50.0]}
    | {"revolutions": 1, "steps_per_revolution": 128},
}
OTHER = {"response", "modes", "process", "rod", "law", "casing", "history", "teeth", "periods", "revolutions"}
OTHER |= {"steps_per_period", "steps_per_revolution"}
REAL = [(call, name) for call, sound in SOUND.items() for name in sound if name not in OTHER]


@pytest.mark.parametrize(("call", "name"), REAL, ids=[f"{call.__qualname__}-{name}" for call, name in REAL])
def test_a_complex_number_is_refused_and_not_cut_to_its_real_part(call, name):
    for turn in (np.exp(0.1j), 1 + 0j):
        with pytest.raises(ValueError, match=r"complex; give real numbers") as error:
            call(**{**SOUND[call], name: np.asarray(SOUND[call][name]) * turn})
        assert "\n" not in str(error.value)


def test_a_complex_number_is_refused_where_jax_traces_it():
    with pytest.raises(ValueError, match="shape is complex"):
        jax.eval_shape(lambda shape: lobex.Modes(np.ones(1), np.ones(1), shape), np.ones((1, 1), complex))


@pytest.mark.parametrize(
    ("speed", "words"),
    [
        (["100"], "speed = .* is not a number"),
        ([True], "speed = .* is not a number"),
        ([b"1"], "speed = .* is not a number"),
        (np.ma.array([1.0, 2.0], mask=[0, 1]), "speed = .* has masked values"),
    ],
)
def test_what_numpy_would_take_for_a_number_is_refused(speed, words):
    with pytest.raises(ValueError, match=words):
        lobex.sweep(lobex.DelayedMathieu(2.5, 1.3, 0.05), speed, [0.3])
