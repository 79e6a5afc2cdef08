"""Derivatives of the spectral radius against central differences and closed forms."""

from dataclasses import replace

import jax
import numpy as np
import pytest

import lobex
from cases import MILL, MULTIPLIER_TOOLS, ROD, milling
from lobex.processes.teeth import ALONE, WHOLE

MATHIEU = lobex.DelayedMathieu(delta=3.0, epsilon=2.0, damping=0.1)
FAST = milling({**MULTIPLIER_TOOLS["Insperger-Stepan"], "teeth": 4}, 0.4, "up", 2)
FEW = lobex.Chebyshev(20)
POINTS = [
    (ROD, 85.0, 1.35e6, lobex.Chebyshev(40)),
    (ROD, 112.0, 4.5e5, lobex.SemiDiscretization(48, order=1)),
    (MILL, 133.0, 3e-3, lobex.Chebyshev(24)),
    (MILL, 50.0, 1e-3, lobex.SemiDiscretization(40)),
    (FAST, 60.0, 4e-4, lobex.Chebyshev(24)),
    (MATHIEU, 1 / (2 * np.pi), -0.15, lobex.Chebyshev(32)),
]


def directional(function, at, direction, step):
    """Fourth-order central difference along a direction."""

    def along(t):
        return float(function(jax.tree.map(lambda a, d: a + t * step * d, at, direction)))

    return (8 * (along(1) - along(-1)) - (along(2) - along(-2))) / (12 * step)


@pytest.mark.parametrize(("process", "speed", "gain", "method"), POINTS)
def test_gradient_of_everything_against_differences(process, speed, gain, method):
    with jax.enable_x64(True):
        at = jax.tree.map(lambda leaf: np.asarray(leaf, dtype=float), (process, speed, gain))
        # Of one program: compiled by itself, each of value, value for the derivative, and derivative takes as long.
        both = jax.jit(jax.value_and_grad(lambda p: lobex.spectral_radius(*p, method)))
        gradient = both(at)[1]
        leaves = jax.tree.leaves(at)
        structure = jax.tree.structure(at)
        for index in range(len(leaves)):
            direction = [np.zeros_like(leaf) for leaf in leaves]
            direction[index] = np.where(leaves[index] == 0, 0.0, np.abs(leaves[index]))
            moved = jax.tree.unflatten(structure, direction)
            difference = directional(lambda p: both(p)[0], at, moved, 1e-4)
            exact = sum(np.sum(g * d) for g, d in zip(jax.tree.leaves(gradient), direction, strict=True))
            assert exact == pytest.approx(difference, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("process", [ROD, MILL, FAST, lobex.Turning(ROD.modes, radial=1e9)])
@pytest.mark.parametrize("method", [lobex.Chebyshev(24), lobex.SemiDiscretization(24)])
def test_gain_zero_has_finite_values_and_gradients(process, method):
    def radius(process, speed, gain):
        return lobex.spectral_radius(process, speed, gain, method)

    @jax.jit
    def both_ways(process, speed, gain):
        forward = jax.jvp(lambda g: radius(process, speed, g), (gain,), (1.0,))[1]
        return jax.grad(radius, argnums=(0, 1, 2))(process, speed, gain), forward

    with jax.enable_x64(True):
        slopes, forward = both_ways(process, 90.0, 0.0)
    assert all(np.isfinite(leaf).all() for leaf in jax.tree.leaves(slopes))
    assert float(forward) == pytest.approx(float(slopes[2]), rel=1e-10)


def test_gain_zero_derivative_by_speed_is_that_of_the_free_decay():
    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(lambda s: lobex.spectral_radius(MILL, s, 0.0)))(50.0)
    rate = float(MILL.modes.damping_ratio[0] * MILL.modes.angular_frequency[0])
    assert float(slope) == pytest.approx(np.exp(-rate / 50) * rate / 50**2, rel=1e-9)


def test_gradient_through_an_immersion_that_is_only_known_when_traced():
    tool = MULTIPLIER_TOOLS["Insperger-Stepan"]

    def radius(immersion, teeth):
        template = milling({**tool, "teeth": teeth}, 0.3, "down")
        process = lobex.Milling(template.modes, teeth, template.tangential, template.normal, immersion)
        return lobex.spectral_radius(process, 80.0, 8e-4, lobex.Chebyshev(40))

    with jax.enable_x64(True):
        for teeth in (2, 6):
            traced, slope = jax.jit(jax.value_and_grad(radius), static_argnums=1)(0.3, teeth)
            assert float(traced) == pytest.approx(float(radius(0.3, teeth)), rel=1e-10)
            difference = directional(lambda a, teeth=teeth: radius(a, teeth), 0.3, 0.3, 1e-4)
            assert float(slope) * 0.3 == pytest.approx(difference, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("directions", [1, 2])
def test_gradient_where_whole_pitches_are_in_the_cut(directions):
    # Four teeth at half immersion: one leaves as the next enters, and a little more or less has two pieces.
    process, method = milling({**MULTIPLIER_TOOLS["Insperger-Stepan"], "teeth": 4}, 0.5, "up", directions), FEW
    assert process.layout.parts == ALONE

    def radius(immersion):
        return lobex.spectral_radius(replace(process, radial_immersion=immersion), 320.0, 8e-4, method)

    with jax.enable_x64(True):
        slope = jax.jit(jax.grad(lambda p: lobex.spectral_radius(p, 320.0, 8e-4, method)))(process).radial_immersion
        assert float(slope) * 0.5 == pytest.approx(directional(radius, 0.5, 0.5, 1e-6), rel=2e-6)
        if directions == 1:
            largest = jax.jit(jax.grad(lambda p: jax.numpy.abs(lobex.multipliers(p, 320.0, 8e-4, method)[0])))(process)
            assert float(largest.radial_immersion) == pytest.approx(float(slope), rel=1e-7)
            # The operator in one piece has none of its own, and says so.
            entry = jax.jit(jax.jacfwd(lambda p: lobex.monodromy(p, 320.0, 8e-4, method)[0, 0]))(process)
            assert np.isnan(entry.radial_immersion)


@pytest.mark.slow
def test_at_full_immersion_in_two_directions_the_derivative_is_infinite_and_no_other_is():
    process = milling(MULTIPLIER_TOOLS["Insperger-Stepan"], 1.0, "down", 2)

    def radius(process, gain):
        return lobex.spectral_radius(process, 320.0, gain, FEW)

    with jax.enable_x64(True):
        slopes, by_gain = jax.jit(jax.grad(radius, argnums=(0, 1)))(process, 4e-4)
    near, far = (replace(process, radial_immersion=1 - h) for h in (1e-8, 4e-8))
    drops = [float(radius(process, 4e-4) - radius(other, 4e-4)) for other in (near, far)]
    assert drops[1] / drops[0] == pytest.approx(2, rel=0.02)
    assert float(slopes.radial_immersion) == np.sign(drops[0]) * np.inf
    assert np.isfinite([slopes.tangential, slopes.normal, by_gain]).all()


def test_gradient_through_the_rod_obeys_the_stiffness_scaling_law():
    # max|μ| is unchanged by E → αE, f → √α f, K → αK.
    with jax.enable_x64(True):

        def radius(log_e, log_f, log_k):
            rod = lobex.Rod(5, young_modulus=210e7 * jax.numpy.exp(log_e))
            return lobex.spectral_radius(
                lobex.Rub(rod.modes()), 85.0 * jax.numpy.exp(log_f), 1.3e6 * jax.numpy.exp(log_k)
            )

        by_e, by_f, by_k = jax.jit(jax.grad(radius, argnums=(0, 1, 2)))(0.0, 0.0, 0.0)
    assert float(by_e) + float(by_f) / 2 + float(by_k) == pytest.approx(0, abs=1e-8)
    assert abs(float(by_k)) > 0.1


def test_vmap_over_a_model_parameter():
    with jax.enable_x64(True):
        ratios = np.array([0.01, 0.03, 0.05])
        radii = jax.vmap(lambda r: lobex.spectral_radius(lobex.Rub(lobex.Rod(4).modes(r)), 85.0, 6e5))(ratios)
    single = [lobex.spectral_radius(lobex.Rub(lobex.Rod(4).modes(float(r))), 85.0, 6e5) for r in ratios]
    assert np.asarray(radii) == pytest.approx(np.array(single), rel=1e-11)


def test_replacing_the_immersion_renews_the_layout():
    process = milling({**MULTIPLIER_TOOLS["Insperger-Stepan"], "teeth": 4}, 0.05, "down")
    assert process.layout.parts == ("cut", "idle")
    assert replace(process, radial_immersion=0.9).layout.parts == ("cut", "cut")
    assert replace(process, radial_immersion=1.0).layout.parts == WHOLE
