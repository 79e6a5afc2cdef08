"""Force and displacement in directions of their own: residues of either sign through every verb, against own codes."""

from dataclasses import replace

import jax
import numpy as np
import pytest
from scipy.optimize import brentq, newton

import lobex
from cases import ROD
from lobex.limits.d_subdivision import exact_critical, exact_minimum
from lobex.results.description import describe
from lobex.results.rebuild import rebuild

# A textbook's turning: the force at 65° to the surface normal, modes at 35° and 55° on either side of it.
OMEGA = np.sqrt([2e7, 3e7])
ANGLE = np.radians([35.0, -55.0])
MODES = lobex.Modes(
    OMEGA, np.array([450.0, 650.0]) / (2 * OMEGA), np.cos(ANGLE)[:, None], np.cos(ANGLE - np.radians(65.0))[:, None]
)
TURNING = lobex.Turning(MODES, radial=2e9)
SPEED = 26140 / 60
DEPTHS = np.array([1.2548e-3, 2e-3])


def receptance(modes, s):
    """G at complex s, with residues written out as force shape times displacement shape."""
    own, ratio, shape, force = (np.asarray(leaf).reshape(-1) for leaf in jax.tree.leaves(modes))
    s = np.asarray(s)[..., None]
    return np.sum(shape * force / (own**2 + s**2 + 2 * ratio * own * s), axis=-1)


def characteristic(modes, stiffness, speed, s):
    return 1 + stiffness * receptance(modes, s) * (1 - np.exp(-s / speed))


def roots_beyond(modes, stiffness, speed, line):
    """How many roots of 1 + K G (1 − e^{−sτ}) = 0 lie to the right of Re s = line ≥ 0, by the argument principle."""
    top = np.max(modes.angular_frequency)
    omega = np.concatenate([np.linspace(0, 10 * top, 100_001), np.geomspace(10 * top, 1e5 * top, 20_000)])
    turning = np.unwrap(np.angle(characteristic(modes, stiffness, speed, line + 1j * omega)))
    assert np.max(np.abs(np.diff(turning))) < 0.5
    # The part below the real axis turns as much as the one above it.
    return round((turning[0] - turning[-1]) / np.pi)


def lowest_limit(modes, speed):
    """The least K with an imaginary root by a scan of ω and Brent's method, in a form without arguments of G.

    G = −(1 − j cot(ωτ/2))/2K, so that Im G sin(ωτ/2) + Re G cos(ωτ/2) = 0 and K = −1/(2 Re G).
    """
    own, ratio, *_ = (np.asarray(leaf) for leaf in jax.tree.leaves(modes))

    def miss(omega):
        response = receptance(modes, 1j * omega)
        return response.imag * np.sin(omega / speed / 2) + response.real * np.cos(omega / speed / 2)

    parts = [np.linspace(0, 3 * own.max(), 20001)[1:], np.arange(1, 4000) * (2 * np.pi * speed / 40)]
    sides = [(w, side * z * w) for w, z in zip(own, ratio, strict=True) for side in (-1, 1)]
    parts += [w + half_width * np.geomspace(1e-3, 0.99 * w / abs(half_width), 2000) for w, half_width in sides]
    omega = np.unique(np.concatenate(parts))
    value, real = miss(omega), receptance(modes, 1j * omega).real
    at = np.flatnonzero((value[1:] * value[:-1] < 0) & (np.minimum(real[1:], real[:-1]) < 0))
    roots = np.array([brentq(miss, omega[i], omega[i + 1], xtol=1e-13 * omega[i], rtol=1e-15) for i in at])
    gain = -0.5 / receptance(modes, 1j * roots).real
    return gain[gain > 0].min()


def mixed(seed):
    """Three modes with residues of either sign."""
    random = np.random.default_rng(seed)
    frequency = np.sort(random.uniform(100.0, 600.0, 3))
    ratio = np.exp(random.uniform(np.log(1e-3), np.log(0.2), 3))
    return lobex.Modes(2 * np.pi * frequency, ratio, *random.normal(size=(2, 3, 1)))


# --- the textbook's case through every verb


def test_the_residues_have_both_signs():
    assert (MODES.shape * MODES.loading).ravel() == pytest.approx([0.7094, -0.2868], abs=5e-5)


@pytest.mark.slow
def test_the_closed_form_gives_the_published_depth():
    limit = lobex.exact_limit(TURNING, [SPEED])
    assert limit.gain * 2e9 == pytest.approx([lowest_limit(MODES, SPEED)], rel=1e-10)
    assert limit.gain == pytest.approx([1.2548e-3], abs=5e-8)
    assert exact_minimum(TURNING, 2).gain == pytest.approx(1.2547e-3, abs=5e-8)
    assert roots_beyond(MODES, 0.99 * limit.gain[0] * 2e9, SPEED, 0.0) == 0
    assert roots_beyond(MODES, 1.01 * limit.gain[0] * 2e9, SPEED, 0.0) == 2


@pytest.mark.parametrize(
    "method", [lobex.Auto(), pytest.param(lobex.Duhamel(), marks=pytest.mark.slow)], ids=["axis", "operator"]
)
def test_the_search_gives_the_published_depth(method):
    searched = lobex.critical_gain(TURNING, [SPEED], (1e-4, 3e-3), method)
    assert searched.gain == pytest.approx(lobex.exact_limit(TURNING, [SPEED]).gain, rel=1e-9)
    assert searched.intervals[0, 0].tolist() == [1e-4, searched.gain[0]]


def test_the_map_the_operator_and_the_march_agree_with_the_roots():
    chart = lobex.sweep(TURNING, [SPEED, 1.01 * SPEED], DEPTHS)
    radius = chart.spectral_radius[0]
    assert radius == pytest.approx([1.000, 1.223], abs=5e-4)
    stiffness = DEPTHS[1] * 2e9
    start = SPEED * np.log(radius[1]) + 2j * np.pi * chart.chatter_frequency[0, 1]
    root = newton(lambda s: characteristic(MODES, stiffness, SPEED, s), start * 1.001)
    assert np.exp(root.real / SPEED) == pytest.approx(radius[1], rel=1e-10)
    assert [roots_beyond(MODES, stiffness, SPEED, share * root.real) for share in (1.02, 0.98)] == [0, 2]
    assert lobex.spectral_radius(TURNING, SPEED, DEPTHS) == pytest.approx(radius, abs=1e-9)
    march = lobex.march_delay(TURNING, SPEED, DEPTHS, lambda t: 1e-6, 40, 400)
    assert march.growth == pytest.approx(radius, rel=1e-4)


@pytest.mark.slow
def test_sensitivities_tell_force_and_displacement_apart():
    table = lobex.sensitivities(TURNING, [SPEED])
    parts = {name: [table[f"modes.{name}[{i},0]"][0] for i in (0, 1)] for name in ("shape", "force_shape")}
    # Both enter as their product, and K scales as one over it.
    assert parts["shape"] == pytest.approx(parts["force_shape"], rel=1e-9)
    assert sum(parts["shape"]) == pytest.approx(-1, rel=1e-9)
    step = 1e-5
    moved = [
        lowest_limit(replace(MODES, force_shape=MODES.force_shape * [[1.0], [1.0 + s]]), SPEED) for s in (step, -step)
    ]
    assert parts["force_shape"][1] == pytest.approx(np.log(moved[0] / moved[1]) / (2 * step), rel=1e-5)


# --- the closed form over many models


def test_no_crossing_is_missed_whatever_the_signs():
    for seed in range(12):
        modes = mixed(seed)
        first = modes.frequency[0]
        speeds = first * np.exp(np.random.default_rng(seed).uniform(np.log(0.05), np.log(10.0), 3))
        found = exact_critical(modes, speeds)
        assert found.gain == pytest.approx([lowest_limit(modes, s) for s in speeds], rel=1e-9)
        assert np.all(receptance(modes, 1j * found.angular_frequency).real < 0)


def test_a_mode_without_damping_gains_energy_on_the_other_half_of_a_lobe_where_its_residue_is_negative():
    # 2jω ds = −K r (1 − e^{−jωτ}): Re ds > 0 where r sin ωτ < 0, however small K.
    speeds = np.array([700.0, 260.0, 90.0])
    for sign in (1.0, -1.0):
        modes = lobex.Modes([1000.0, 1700.0, 2900.0], [0.0, 0.02, 0.03], np.ones((3, 1)), [[sign], [1.0], [-0.5]])
        gain = exact_critical(modes, speeds).gain
        assert (gain == 0).tolist() == (sign * np.sin(1000.0 / speeds) < 0).tolist()


# --- one shape that is both


def test_one_shape_is_both_and_stays_one_leaf():
    shape = ROD.modes.shape
    assert ROD.modes.force_shape is None
    assert ROD.modes.loading is shape
    assert len(jax.tree.leaves(ROD.modes)) == 3
    assert len(jax.tree.leaves(replace(ROD.modes, force_shape=shape))) == 4
    with jax.enable_x64(True):
        # φ² of one shape has the slope 2φ, through every transformation.
        static = jax.jit(lambda modes: (modes.shape * modes.loading).sum())
        slope = jax.grad(static)(jax.tree.map(np.asarray, ROD.modes))
        rows = jax.vmap(lambda modes: modes.shape * modes.loading)(ROD.modes)
    assert np.asarray(slope.shape) == pytest.approx(2 * shape)
    assert np.asarray(rows) == pytest.approx(shape**2)


def test_selected_and_combined_modes_keep_their_force_shapes():
    one = MODES.select([2])
    assert one.force_shape.tolist() == MODES.force_shape[[1]].tolist()
    assert ROD.modes.select([1, 3]).force_shape is None
    plain = lobex.Modes.single(frequency=100.0, damping_ratio=0.01, mass=4.0)
    both = lobex.Modes.plane(x=MODES, y=plain)
    assert both.loading == pytest.approx(np.array([*np.c_[MODES.force_shape, [0, 0]], [0.0, 0.5]]))
    assert both.shape == pytest.approx(np.array([*np.c_[MODES.shape, [0, 0]], [0.0, 0.5]]))
    assert lobex.Modes.plane(x=plain, y=plain).force_shape is None


def test_a_description_keeps_the_force_shape_and_its_absence():
    for process in (TURNING, ROD):
        again = rebuild(describe(process))
        for leaf, expected in zip(jax.tree.leaves(again), jax.tree.leaves(process), strict=True):
            assert np.array_equal(leaf, expected)


def test_wear_of_a_mode_pushed_aside():
    """One mode: the tip follows ÿ + 2ξω ẏ + ω² y = φψ F alone, and energies are those of F along its own motion."""
    along = lobex.Modes([2000.0], [0.03], [[0.6]])
    aside = lobex.Modes([2000.0], [0.03], [[1.2]], [[0.3]])
    runs = [
        lobex.march_wear(modes, lobex.Casing(), lobex.Linear(1e6), np.array([62.0, 92.0]), 2, 128)
        for modes in (along, aside)
    ]
    for name in ("displacement", "wear", "amplitude"):
        assert getattr(runs[1], name) == pytest.approx(getattr(runs[0], name), rel=1e-9, abs=1e-15)
    for name in ("input_energy", "removal_energy", "damping_energy", "stored_energy"):
        assert np.any(getattr(runs[0], name) > 0)
        assert getattr(runs[1], name) == pytest.approx(0.25 * getattr(runs[0], name), rel=1e-9)
    assert runs[1].energy_error == pytest.approx(runs[0].energy_error, rel=1e-6, abs=1e-12)
