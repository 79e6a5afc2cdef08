"""Modes fitted to responses of structures that are known, with and without noise."""

import re

import numpy as np
import pytest

import lobex
from refusals import refused
from tap_test import ACCELERANCE, FREQUENCY, OMEGA, OWN, POINT, RATIO, RECEPTANCE, SHAPE, noisy

BOTH = ("x", "y"), ("x", "y")


def as_measured(noise, seed=0):
    """Both directions, measured as accelerances."""
    response = noisy(ACCELERANCE, noise, seed) / -(OMEGA[:, None, None] ** 2)
    return lobex.Frf(FREQUENCY, response, *BOTH, measured="acceleration")


def off(fit):
    """Largest relative errors of frequency, damping and shape."""
    shape = np.asarray(fit.modes.shape)
    turned = shape * np.sign(np.sum(shape * SHAPE, axis=1, keepdims=True))
    return (
        np.max(np.abs(np.asarray(fit.modes.frequency) / OWN - 1)),
        np.max(np.abs(np.asarray(fit.modes.damping_ratio) / RATIO - 1)),
        np.max(np.abs(turned - SHAPE)) / np.max(np.abs(SHAPE)),
    )


@pytest.mark.parametrize(
    ("noise", "frequency", "damping", "shape"),
    [(0.0, 1e-9, 1e-7, 1e-7), (0.01, 1e-3, 0.05, 0.02), (0.05, 2e-3, 0.1, 0.05)],
)
def test_modes_of_noisy_responses_are_those_of_the_structure(noise, frequency, damping, shape):
    fit = as_measured(noise).fit()
    assert fit.modes.count == 3
    found = off(fit)
    assert found[0] < frequency
    assert found[1] < damping
    assert found[2] < shape
    # Noise of each response is told by the root mean square of what is left.
    size = np.sqrt(np.mean(np.abs(ACCELERANCE) ** 2, axis=0))
    share = noise * np.abs(ACCELERANCE).max(axis=0) / size
    for (i, j), lost in fit.misfit.items():
        assert lost == pytest.approx(share["xy".index(i), "xy".index(j)], rel=0.1, abs=1e-7)


def disturbed(where, noise, seed=1):
    """An accelerance whose noise is larger in a band, and the coherence that it has."""
    random = np.random.default_rng(seed)
    clean = ACCELERANCE[:, 0, 0]
    deviation = (
        0.005 * np.abs(clean).max() * np.where(np.abs(FREQUENCY - np.mean(where)) < np.ptp(where) / 2, noise, 1.0)
    )
    white = (random.standard_normal((2, len(FREQUENCY))) * [[1], [1j]]).sum(axis=0) / np.sqrt(2)
    coherence = np.abs(clean) ** 2 / (np.abs(clean) ** 2 + deviation**2)
    return (clean + deviation * white) / -(OMEGA**2), coherence


@pytest.mark.parametrize("where", [(470.0, 560.0), (400.0, 445.0), (600.0, 860.0), (55.0, 130.0)])
def test_a_band_of_bad_coherence_spoils_no_fit(where):
    found = []
    response, coherence = disturbed(where, 100.0)
    for known in (None, coherence[:, None, None]):
        frf = lobex.Frf(FREQUENCY, response, measured="acceleration", coherence=known)
        modes = frf.modes(order=3)
        off = [np.asarray(modes.frequency) / OWN - 1, np.asarray(modes.damping_ratio) / RATIO - 1]
        found.append([np.max(np.abs(one)) for one in off])
    without, weighed = found
    assert weighed[0] < 1e-3
    assert weighed[1] < 0.02
    assert without[1] > 1.5 * weighed[1]
    # As many modes as there are, without being told.
    assert frf.modes().count == 3


def test_a_coherence_of_one_or_none_changes_nothing():
    response, _ = disturbed((0.0, 0.0), 1.0)
    plain = lobex.Frf(FREQUENCY, response, measured="acceleration").modes(order=3)
    for value in (1.0, np.nan):
        known = np.full((len(FREQUENCY), 1, 1), value)
        again = lobex.Frf(FREQUENCY, response, measured="acceleration", coherence=known).modes(order=3)
        np.testing.assert_array_equal(again.angular_frequency, plain.angular_frequency)


def test_one_response_by_itself():
    frf = lobex.Frf(FREQUENCY, as_measured(0.01).values("x"), measured="acceleration")
    fit = frf.fit()
    assert np.asarray(fit.modes.frequency) == pytest.approx(OWN, rel=1e-3)
    assert np.asarray(fit.modes.damping_ratio) == pytest.approx(RATIO, rel=0.05)
    assert np.asarray(frf.modes(order=3).shape) == pytest.approx(np.asarray(fit.modes.shape), rel=1e-9)


@pytest.mark.slow
def test_standard_deviations_are_those_of_repeated_measurements():
    numbers, told, correlations = [], [], []
    for seed in range(60):
        frf = lobex.Frf(FREQUENCY, as_measured(0.01, seed).values("x"), measured="acceleration")
        fit = frf.fit(order=1, band=(350.0, 600.0))
        numbers.append(np.concatenate([np.ravel(part) for part in vars(fit.modes).values() if part is not None]))
        told.append(list(fit.relative_standard_deviation.values()))
        correlations.append(fit.correlation)
    # Of 60 samples a standard deviation is known to a tenth.
    spread = np.std(numbers, axis=0, ddof=1) / np.mean(numbers, axis=0)
    assert np.mean(told, axis=0) == pytest.approx(np.abs(spread), rel=0.3)
    assert np.mean(correlations, axis=0) == pytest.approx(np.corrcoef(np.array(numbers).T), abs=0.25)
    # The height of a peak is known best: its residue is found larger where its damping is.
    assert np.mean(correlations, axis=0)[1, 2] > 0.5


def test_one_column_of_references_gives_whole_shapes():
    frf = lobex.Frf(FREQUENCY, RECEPTANCE[:, :, :1], ("x", "y"), ("x",))
    fit = frf.fit()
    assert off(fit)[2] < 1e-6
    assert fit.directions == ("x", "y")


def test_driving_points_without_cross_responses_stand_beside_each_other():
    alone = np.where(np.eye(2, dtype=bool), RECEPTANCE, np.nan)
    fit = lobex.Frf(FREQUENCY, alone, *BOTH).fit()
    by_hand = [lobex.Frf(FREQUENCY, RECEPTANCE[:, i, i]).modes() for i in range(2)]
    plane = lobex.Modes.plane(x=by_hand[0], y=by_hand[1])
    np.testing.assert_allclose(fit.modes.angular_frequency, plane.angular_frequency, rtol=1e-12)
    np.testing.assert_allclose(fit.modes.shape, plane.shape, rtol=1e-12)
    assert len(fit.relative_standard_deviation) == 2 * fit.modes.count + fit.modes.count


def test_complex_modes_of_damping_that_couples():
    # Two masses, of which one is damped against the ground.
    mass, stiffness = np.diag([1.0, 0.7]), 4e5 * np.array([[2.0, -1.0], [-1.0, 1.5]])
    damping = np.array([[30.0, 0.0], [0.0, 2.0]])
    exact = lobex.Modes.from_matrices(mass, stiffness, contact=np.eye(2), damping=damping)
    s = 1j * OMEGA[:, None, None]
    response = np.linalg.inv(mass * s**2 + damping * s + stiffness)
    frf = lobex.Frf(FREQUENCY, response, *BOTH)
    fit = frf.fit(real=False, band=(50.0, 400.0))
    assert fit.modes.complex
    np.testing.assert_allclose(fit.modes.frequency, exact.frequency, rtol=1e-8)
    np.testing.assert_allclose(fit.modes.damping_ratio, exact.damping_ratio, rtol=1e-6)
    inside = (FREQUENCY >= 50) & (FREQUENCY <= 400)
    np.testing.assert_allclose(fit.values("y", "x"), response[inside, 1, 0], rtol=1e-6)
    # Modes whose points move in phase leave more than noise, and that is told.
    with pytest.warns(lobex.LobexWarning, match="that is no noise; give another band= or order=, or real=False"):
        frf.fit(order=2, band=(50.0, 400.0))


def test_modes_outside_the_band_are_two_residuals():
    fit = lobex.Frf(FREQUENCY, RECEPTANCE[:, 1, 1], "y", "y").fit(order=1, band=(300.0, 700.0))
    assert np.asarray(fit.modes.frequency) == pytest.approx(OWN[1:2], rel=1e-4)
    assert np.asarray(fit.modes.damping_ratio) == pytest.approx(RATIO[1:2], rel=5e-3)
    assert fit.band == (300.0, 700.0)
    assert fit.misfit["y", "y"] < 0.02


def test_closely_spaced_modes_are_told_apart():
    own, ratio = np.array([500.0, 512.0]), np.array([0.02, 0.025])
    natural = 2 * np.pi * own
    shape = np.array([[0.5, 0.4], [0.4, -0.5]])
    terms = 1 / (natural**2 - OMEGA[:, None] ** 2 + 2j * ratio * natural * OMEGA[:, None])
    frf = lobex.Frf(FREQUENCY, noisy(np.einsum("nk,ki,kj->nij", terms, shape, shape), 0.01), *BOTH)
    modes = frf.modes()
    assert np.asarray(modes.frequency) == pytest.approx(own, rel=1e-3)
    assert np.asarray(modes.damping_ratio) == pytest.approx(ratio, rel=0.05)


def test_the_report_and_its_pictures():
    fit = as_measured(0.01).fit()
    lines = repr(fit).splitlines()
    assert lines[0] == "ModalFit of samples: 3 modes, 50 to 1197.5 Hz"
    assert re.match(r"     1  1(79\.9|80\.0)\d ± 0\.0\d+ +0\.0(19|20)\d+ ± 0\.00\d+ ", lines[3])
    figure = fit.plot()
    drawn = {line.get_label(): line.get_ydata() for line in figure.axes[0].lines}
    assert drawn["fitted"] == pytest.approx(np.abs(fit.values("x", "x")))
    assert drawn["measured"] == pytest.approx(np.abs(fit.frf.values("x", "x")))
    chart = fit.plot_stabilisation()
    kept = [line.get_xdata()[0] for line in chart.axes[0].lines if line.get_color() == "#c8500a"]
    assert kept == pytest.approx(np.asarray(fit.modes.frequency))
    assert fit.frf.plot().axes[0].get_ylabel() == "receptance |G| (m/N)"


@pytest.mark.parametrize(
    ("fit", "words"),
    [
        (lambda frf: frf.fit(order=0), "order = 0 must be a whole number of at least 1"),
        (lambda frf: frf.fit(order=24), "order = 24 is more than the"),
        (lambda frf: frf.fit(band=(100.0,)), "band has 1 numbers; give the lowest and the highest"),
        (lambda frf: frf.fit(band=(2000.0, 3000.0)), "holds 0 lines of 50 to 1197.5 Hz; give a wider one"),
        (lambda frf: frf.fit(real="no"), "real = 'no' is unknown"),
        (lambda frf: lobex.Frf(FREQUENCY, POINT, "y", "x").fit(), "no driving point among y to x"),
    ],
)
def test_fits_that_cannot_be_are_refused(fit, words):
    with refused(words):
        fit(lobex.Frf(FREQUENCY, noisy(POINT, 1e-3)))


@pytest.mark.parametrize("seed", range(3))
def test_noise_alone_has_no_modes_of_which_much_is_said(seed):
    random = np.random.default_rng(seed)
    white = random.standard_normal((2, len(FREQUENCY)))
    fit = lobex.Frf(FREQUENCY, white[0] + 1j * white[1]).fit()
    assert fit.modes.count <= 2
    assert fit.misfit["x", "x"] > 0.9


def test_another_program_finds_the_same_poles(tmp_path):
    ema = pytest.importorskip("sdypy.EMA", reason="sdypy-EMA, an independent modal fit, is not installed")
    response = noisy(RECEPTANCE[:, :, 0], 1e-3)
    model = ema.Model(response.T, FREQUENCY, lower=60, upper=1190, pol_order_high=40, frf_form="receptance")
    model.get_poles(show_progress=False)
    model.select_closest_poles(OWN.tolist())
    fit = lobex.Frf(FREQUENCY, response[:, :, None], ("x", "y"), ("x",)).fit()
    assert np.asarray(fit.modes.frequency) == pytest.approx(model.nat_freq, rel=1e-3)
    # Its damping is that of the linear fit, which noise lowers.
    assert np.asarray(fit.modes.damping_ratio) == pytest.approx(model.nat_xi, rel=0.05)
    assert np.asarray(fit.modes.damping_ratio) == pytest.approx(RATIO, rel=0.005)


# Sensitivities compile.
@pytest.mark.slow
def test_a_band_of_numbers_that_hang_together_is_the_scatter_of_limits():
    speed, limits = [100.0, 170.0], []
    for seed in range(60):
        frf = lobex.Frf(FREQUENCY, as_measured(0.01, seed).values("x"), measured="acceleration")
        fit = frf.fit(order=1, band=(350.0, 600.0))
        found = lobex.exact_limit(lobex.Turning(fit.modes, radial=1e8), speed)
        limits.append(found.gain)
    told = fit.relative_standard_deviation
    together = found.band(told, correlation=fit.correlation).relative
    scatter = np.std(np.log(limits), axis=0, ddof=1)
    assert together == pytest.approx(scatter, rel=0.3)
    # Taken for independent, as damping and residue are not, they would be off by more.
    assert np.all(np.abs(np.log(found.band(told).relative / scatter)) > np.abs(np.log(together / scatter)))
