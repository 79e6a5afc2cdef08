"""Against closed forms, and against methods that discretise no delay."""

from functools import partial

import jax
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lobex
from cases import MILL, MULTIPLIER_CASES, MULTIPLIER_TOOLS, ROD, label, milling, point
from lobex.systems.mesh import pieces_of

FINE = lobex.Chebyshev(nodes=48)


def fundamental_matrix(system, mu):
    """Ψ over one delay of the ordinary equation that z(t − τ) = z(t)/μ leaves, by an 8th-order integrator."""
    drift, inputs, outputs = (np.asarray(m()) for m in (system.drift, system.input_matrix, system.output_matrix))
    size, tau = len(drift), float(system.period)
    psi = np.eye(size, dtype=complex)
    for piece in pieces_of(system):
        coefficients = jax.jit(partial(system.within, piece.start + piece.length / 2))

        def slope(phase, z, coefficients=coefficients):
            current, delayed = (np.asarray(m)[0] for m in jax.tree.leaves(coefficients(np.array([phase]))))
            matrix = drift + inputs @ (current + delayed / mu) @ outputs
            return tau * (matrix @ z.reshape(size, -1)).ravel()

        start = float(piece.start)
        span = (start, start + float(piece.length))
        psi = solve_ivp(slope, span, psi.ravel(), "DOP853", rtol=1e-11, atol=1e-13).y[:, -1].reshape(size, size)
    return psi


INDEPENDENT = [MULTIPLIER_CASES[i] for i in (5, 11, 12, 19, 24, 28)]


@pytest.mark.parametrize("case", INDEPENDENT, ids=label)
def test_leading_multipliers_solve_the_ordinary_problem(case):
    process, speed, gain = point(case)
    with jax.enable_x64(True):
        system = process.system(speed, gain)
        leading = lobex.multipliers(process, speed, gain, lobex.Chebyshev(nodes=64))[:3]
        for mu in leading[leading.imag >= 0]:
            eigenvalues = np.linalg.eigvals(fundamental_matrix(system, mu))
            assert np.min(np.abs(eigenvalues - mu)) < 1e-8 * abs(mu)


def test_rod_limit_by_d_subdivision():
    # On the boundary 1 + K G(jω)(1 − e^{−jωτ}) = 0: any ω with Re G < 0 gives a gain and a delay.
    modes = ROD.modes
    for omega in 2 * np.pi * np.array([343.0, 350.0, 365.0, 390.0]):
        squared = modes.shape[:, 0] ** 2
        damping = 2j * modes.damping_ratio * modes.angular_frequency * omega
        receptance = np.sum(squared / (modes.angular_frequency**2 - omega**2 + damping))
        gain = -1 / (2 * receptance.real)
        delay = (2 * np.angle(receptance) + 3 * np.pi) / omega
        mu = lobex.multipliers(ROD, 1 / delay, gain, FINE)
        assert np.min(np.abs(mu - np.exp(1j * omega * delay))) < 1e-9


def test_turning_has_the_single_mode_minimum():
    # Absolute minimum 2kξ(1+ξ), at the frequency ω_n √(1+2ξ).
    frequency, ratio, mass, cutting = 150.0, 0.02, 2.0, 3e8
    process = lobex.Turning(lobex.Modes.single(frequency=frequency, damping_ratio=ratio, mass=mass), radial=cutting)
    stiffness = mass * (2 * np.pi * frequency) ** 2
    depth = 2 * stiffness * ratio * (1 + ratio) / cutting
    omega = 2 * np.pi * frequency * np.sqrt(1 + 2 * ratio)
    phase = np.angle(1 / (stiffness - mass * omega**2 + 2j * ratio * mass * 2 * np.pi * frequency * omega))
    delay = (2 * phase + 3 * np.pi) / omega
    chart = lobex.sweep(process, [1 / delay], [depth], FINE)
    assert chart.spectral_radius[0, 0] == pytest.approx(1, abs=1e-10)
    assert chart.chatter_frequency[0, 0] == pytest.approx(omega / (2 * np.pi), rel=1e-9)


@pytest.mark.parametrize("radial_immersion", [0.05, 0.3, 0.5, 1.0])
def test_symmetric_tool_in_the_plane_up_equals_down(radial_immersion):
    tool = MULTIPLIER_TOOLS["Insperger-Stepan"]
    up, down = (milling(tool, radial_immersion, direction, 2) for direction in ("up", "down"))
    speeds, depths = np.array([6000.0, 9000.0, 16000.0])[:, None] / 60, np.array([2e-4, 1e-3, 3e-3])
    method = lobex.Chebyshev(nodes=56)
    both = [lobex.spectral_radius(process, speeds, depths, method) for process in (up, down)]
    assert both[0] == pytest.approx(both[1], rel=1e-9)


def test_gain_zero_is_the_free_structure():
    free = [np.exp(-ROD.modes.damping_ratio * ROD.modes.angular_frequency / f).max() for f in (60.0, 400.0)]
    assert lobex.spectral_radius(ROD, [60.0, 400.0], 0.0, lobex.Chebyshev(64)) == pytest.approx(free, rel=1e-9)
    decay = np.exp(-MILL.modes.damping_ratio[0] * MILL.modes.angular_frequency[0] / 50.0)
    assert lobex.spectral_radius(MILL, 50.0, 0.0) == pytest.approx(decay, rel=1e-11)
