"""Blades that cannot be: refused in one line that names the argument, its value and what would be right."""

import jax
import numpy as np
import pytest

import lobex
from refusals import refused

GIVEN = {"length": 0.2, "width": 0.05, "thickness": 0.004, "young_modulus": 110e9, "density": 4430.0}
PLAIN = {"length": 0.2, "young_modulus": 110e9, "density": 4430.0, "area": 2e-4, "flap_inertia": 3e-10,
         "edge_inertia": 4e-8, "torsion_constant": 1e-9}  # fmt: skip
BLADE = lobex.Beam.rectangular(elements=1, **GIVEN)
TWO = lobex.Modes([100.0, 300.0], [0.01, 0.02], np.eye(2))
SOFT = {"angular_frequency": [100.0, 300.0], "damping_ratio": 0.01, "shape": np.ones((2, 1)), "keep": [1]}
SINKING = lobex.RotatingModes(spin_stiffness=np.diag([-0.5, 1.0]), gyroscopic=None, **SOFT)
TABLE = SINKING.over(np.array([10.0, 20.0]))


def rectangular(**changes):
    return lobex.Beam.rectangular(**(GIVEN | changes))


def rotating(**changes):
    return lobex.RotatingModes(**({"spin_stiffness": np.eye(2), "gyroscopic": None} | SOFT | changes))


def of_matrices(**changes):
    given = {"mass": np.eye(2), "stiffness": 1e4 * np.diag([1.0, 2.0]), "contact": [1.0, 0.0], "damping_ratio": 0.01}
    return lobex.Modes.from_matrices(**(given | {"spin_stiffness": np.eye(2)} | changes))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: rectangular(elements=0), "elements = 0 must be a whole number of at least 1"),
        (lambda: rectangular(elements=2.5), "elements = 2.5 must be a whole number"),
        (lambda: rectangular(elements=10**4), "elements = 10000 is more than can be computed; give at most 100"),
        (lambda: rectangular(length=0.0), "length = 0 must be positive; give a number above 0 in m"),
        (lambda: rectangular(length=[0.2]), "length has shape (1,); give one number"),
        (lambda: rectangular(density=np.nan), "density = nan has NaN"),
        (lambda: rectangular(young_modulus="steel"), "young_modulus = 'steel' is not a number"),
        (lambda: rectangular(thickness=[0.004, -0.001]), "thickness = [0.004, -0.001] must be positive"),
        (lambda: rectangular(thickness=lambda s: 0.004 * (1 - s)), "thickness = [0.004,"),
        (lambda: rectangular(width=[0.05]), "width has shape (1,); give one number, two or more from root to tip"),
        (lambda: rectangular(width=lambda s: np.ones(3)), "width returns the shape (3,) at (10, 5) shares of the span"),
        (lambda: rectangular(width=[[0.05, 0.04]]), "width has shape (1, 2); give one number, two or more"),
        (lambda: rectangular(twist_degrees=["0", "9 deg"]), "twist_degrees = ['0', '9 deg'] is not a number"),
        (lambda: rectangular(width=[[0.05], [0.05, 0.06]]), "width = [[0.05], [0.05, 0.06]] is not a number"),
        (lambda: rectangular(root_stiffness=["stiff"] * 6), "root_stiffness = ['stiff', 'stiff',"),
        (lambda: BLADE.modes(0.01, chord=["30 mm"]), "chord = ['30 mm'] is not a number"),
        (lambda: BLADE.modes(0.01, normal=["up", "on", 1]), "normal = ['up', 'on', 1] is not a number"),
        (lambda: rotating(spin_stiffness=[["a", 1.0], [1.0, 1.0]]), "spin_stiffness = [['a', 1.0], [1.0, 1.0]] is not"),
        (lambda: rectangular(twist_degrees=[0.0, np.inf]), "twist_degrees = [0, inf] has NaN or infinite"),
        (lambda: rectangular(stagger_degrees="north"), "stagger_degrees = 'north' is not a number"),
        (lambda: rectangular(hub_radius=-0.1), "hub_radius = -0.1 must not be negative"),
        (lambda: rectangular(poisson_ratio=0.7), "poisson_ratio = 0.7 is no material's"),
        (lambda: rectangular(root_stiffness=[1e6, 1e6]), "root_stiffness has shape (2,); give one of each of radial"),
        (lambda: rectangular(root_stiffness=-np.ones(6)), "root_stiffness = [-1, -1, -1, -1, …] must not be negative"),
        (lambda: rectangular(root_stiffness=np.zeros(6)).modes(0.01), "clamp rigid-body motion"),
        (lambda: lobex.Beam(elements=2, **(PLAIN | {"area": -1.0})), "area = -1 must be positive"),
        (lambda: lobex.Beam(elements=2, **(PLAIN | {"edge_inertia": "big"})), "edge_inertia = 'big' is not a number"),
        (lambda: BLADE.modes(-0.01), "damping_ratio = -0.01 must not be negative"),
        (lambda: BLADE.modes([0.01, 0.02], [1]), "damping_ratio has shape (2,); give one number or one per mode"),
        (lambda: BLADE.modes(0.01, [9]), "keep = [9] asks for mode 9 of 8"),
        (lambda: BLADE.modes(0.01, normal=(0, 0, 0)), "normal is a vector of no length"),
        (lambda: BLADE.modes(0.01, normal=(1e-200, 0, 0)), "normal is a vector of no length"),
        (lambda: BLADE.modes(0.01, normal=(1, 0)), "normal has shape (2,); give one number per direction, (3,)"),
        (lambda: BLADE.modes(0.01, sliding=(0, 0, 0)), "sliding is a vector of no length"),
        (lambda: BLADE.modes(0.01, sliding=(1, 1, 0)), "sliding is 45 degrees from normal; give a direction along"),
        (lambda: BLADE.modes(0.01, friction=0.2), "friction = 0.2 has no direction; give sliding"),
        (lambda: BLADE.modes(0.01, sliding=(0, 1, 0), friction=-0.2), "friction = -0.2 must not be negative"),
        (lambda: BLADE.modes(0.01, sliding=(0, 1, 0), friction=[[0.2]]), "friction has shape (1, 1)"),
        (lambda: BLADE.modes(0.01, normal=np.eye(3)[:2], sliding=(0, 0, 1), friction=np.ones(3)), "has 2 contacts"),
        (lambda: BLADE.modes(0.01, chord=[0, 0.1], sliding=(0, 0, 1), friction=np.ones(3)), "chord has 2 places"),
        (lambda: BLADE.modes(0.01, chord=[]), "chord has shape (0,); give one place along the tip"),
        (lambda: BLADE.rotating(0.01, [1, 2], basis=1), "basis = 1 must be a whole number of at least 2"),
        (lambda: TWO.in_contact([1.0]), "normal has shape (1,); give one number per direction, (2,)"),
        (lambda: TWO.in_contact([0.0, 1.0], friction=0.1), "friction = 0.1 has no direction"),
        (lambda: of_matrices(damping_ratio=None, damping=np.eye(2)), "damping is a matrix, which modes that follow"),
        (lambda: of_matrices(spin_stiffness=np.eye(3)), "spin_stiffness has shape (3, 3) and mass (2, 2)"),
        (lambda: of_matrices(spin_stiffness=[[1.0, 1.0], [0.0, 1.0]]), "spin_stiffness is not symmetric, by up to 1"),
        (lambda: of_matrices(gyroscopic=np.eye(3)), "gyroscopic has shape (3, 3) and mass (2, 2)"),
        (lambda: of_matrices(gyroscopic=np.eye(2)), "gyroscopic is not skew"),
        (lambda: of_matrices(mass=np.diag([1.0, -1.0])), "mass is singular or indefinite"),
        (lambda: of_matrices(stiffness=np.eye(3)), "stiffness has shape (3, 3) and mass (2, 2)"),
        (lambda: of_matrices(mass=np.eye(3), spin_stiffness=None), "stiffness has shape (2, 2) and mass (3, 3)"),
        (lambda: of_matrices(contact=[0.0, 0.0]), "contact has a direction of zeros alone"),
        (lambda: of_matrices(contact=[[1.0, 0.0], [1.0, 0.0]], spin_stiffness=None), "a direction of zeros"),
        (lambda: of_matrices(contact=[1.0]), "contact has shape (1,); give (2,) or (2, directions)"),
        (lambda: rotating(spin_stiffness=np.eye(3)), "spin_stiffness has shape (3, 3); give that of 2 modes, (2, 2)"),
        (lambda: rotating(spin_stiffness=[[1.0, 0.5], [0.0, 1.0]]), "spin_stiffness is not symmetric"),
        (lambda: rotating(gyroscopic=np.eye(2)), "gyroscopic is not skew"),
        (lambda: rotating(angular_frequency=[100.0, 0.0]), "angular_frequency = [100, 0] must be positive"),
        (lambda: rotating(keep=[3]), "keep = [3] asks for mode 3 of 2"),
        (lambda: rotating(keep=[]), "must be a list of mode numbers"),
    ],
)  # fmt: skip
def test_blades_are_refused_in_one_line(call, words):
    with refused(words):
        call()


def test_a_speed_that_softens_below_zero_is_refused_and_that_of_divergence_named():
    # 100² rad²/s² = 0.5 Ω².
    diverging = 100 * np.sqrt(2) / (2 * np.pi)
    assert SINKING.divergence_speed == pytest.approx(diverging, rel=1e-12)
    words = f"softens the structure to a negative stiffness; give less than {diverging:.6g} Hz, at which it diverges"
    for call in (
        lambda: SINKING.at(30.0),
        lambda: lobex.sweep(lobex.Rub(SINKING), [20.0, 30.0], [1e3]),
        lambda: lobex.exact_limit(lobex.Rub(SINKING), 30.0),
        lambda: lobex.critical_gain(lobex.Rub(SINKING), [20.0, 30.0], (1.0, 2.0)),
    ):
        with pytest.raises(ValueError, match="speed = 30 Hz " + words.replace(".", r"\.")):
            call()
    assert SINKING.at(22.0).frequency[0] == pytest.approx(np.sqrt(100**2 - 0.5 * (44 * np.pi) ** 2) / (2 * np.pi))
    # What stiffens in every direction never diverges.
    assert BLADE.rotating(0.01, normal=(1, 0, 0)).divergence_speed > 1e3
    assert rotating().divergence_speed == np.inf
    with pytest.raises(ValueError, match="modes is traced by JAX; divergence_speed runs outside"):
        jax.jit(lambda modes: modes.divergence_speed)(SINKING)


def test_a_march_of_wear_is_refused_beyond_divergence():
    with pytest.raises(ValueError, match="speed = 30 Hz softens the structure to a negative stiffness"):
        lobex.march_wear(SINKING, lobex.Casing(), lobex.Linear(1e5), [20.0, 30.0], 2, 1024)


@pytest.mark.parametrize("modes", [SINKING, TABLE], ids=["rotating", "table"])
@pytest.mark.parametrize(
    ("speed", "words"),
    [
        (np.nan, "speed = nan has NaN or infinite values"),
        ("fast", "speed = 'fast' is not a number"),
        (12.0 + 1j, "speed = 12+1j is complex"),
        ([12.0, 15.0], "speed has shape (2,); give one number"),
    ],
)
def test_modes_are_those_at_one_speed(modes, speed, words):
    with pytest.raises(ValueError) as error:
        modes.at(speed)
    assert words in str(error.value)


def test_an_exact_limit_takes_one_speed_or_a_list():
    for speed in ([], [[12.0]]):
        with pytest.raises(ValueError, match=r"^speed has shape .*; give one speed or a list of them$"):
            lobex.exact_limit(lobex.Rub(SINKING), speed)


NOWHERE = lobex.Modes([100.0], [0.01], [[0.0]])


@pytest.mark.parametrize(
    "modes",
    [
        NOWHERE,
        lobex.Modes([100.0], [0.01], np.zeros((1, 2))),
        lobex.Blading(NOWHERE, 3),
        lobex.Blading(NOWHERE, 3, mistuning=[0.0, 0.01, -0.01], coupling=5.0),
    ],
    ids=["one", "several", "tuned", "coupled"],
)
def test_a_contact_that_no_mode_moves_has_no_limit_and_says_so(modes):
    with refused("meets nothing that moves; give critical_gain"):
        lobex.exact_limit(lobex.Rub(modes), 4.0)
