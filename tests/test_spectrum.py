"""Amplitudes of spectra against known signals and a transfer function; decimation without aliasing; the pictures."""

from functools import partial

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lobex
from cases import assert_same_fields
from lobex.marches.decimation import LENGTH, decimate, factor_for, filter_matrix, usable_orders
from lobex.results.spectrum_map import amplitude_spectrum
from refusals import refused

ROD = lobex.Rod(3).modes(0.03)


@given(st.floats(1e-6, 1e3), st.floats(8, 240), st.floats(0, 6.2), st.floats(-3, 3))
def test_a_sine_of_any_frequency_gives_its_amplitude(amplitude, cycles, phase, mean):
    signal = amplitude * (np.sin(2 * np.pi * cycles * np.arange(512) / 512 + phase) + mean)
    lines = amplitude_spectrum(signal)
    # Where the window's side lobes of the negative frequency do not reach: flat top within 0.01 dB.
    assert lines[4:].max() == pytest.approx(amplitude, rel=3e-3)
    assert abs(np.argmax(lines[4:]) + 4 - cycles) <= 1
    assert lines[0] == pytest.approx(abs(np.mean(signal)), rel=1e-9, abs=1e-9 * amplitude)


@pytest.mark.parametrize("window", ["hann", "boxcar", "blackman"])
def test_a_sine_on_a_line_gives_its_amplitude_in_every_window(window):
    time = np.arange(600) / 600
    lines = amplitude_spectrum(2e-4 * np.sin(2 * np.pi * 30 * time) + 5e-5 * np.cos(2 * np.pi * 100 * time), window)
    assert lines[[30, 100]] == pytest.approx([2e-4, 5e-5], rel=1e-12)
    assert lines[60] == pytest.approx(0, abs=1e-16)


@pytest.mark.parametrize("factor", [2, 8])
def test_decimation_keeps_the_usable_band_and_stops_what_would_alias_into_it(factor):
    steps, lanes = 64 * factor, 3
    matrix = filter_matrix(steps, factor)
    decimated = jax.jit(partial(decimate, matrix, factor))
    time = np.arange(4 * steps)
    usable = usable_orders(steps, factor)
    assert usable == 16

    def through(cycles_per_revolution):
        signal = np.sin(2 * np.pi * cycles_per_revolution * time / steps)[:, None] * np.arange(1, lanes + 1)
        tail, parts = np.zeros((LENGTH * factor, lanes)), []
        with jax.enable_x64(True):
            for part in np.split(signal, 4):
                parts.append(np.asarray(decimated(tail, part)))
                tail = part[-len(tail) :]
        return np.concatenate(parts)

    for cycles in (1.0, 7.3, float(usable)):
        expected = np.sin(2 * np.pi * cycles * (np.arange(256) - LENGTH // 2) / 64)
        settled = slice(LENGTH, None)
        assert through(cycles)[settled, 0] == pytest.approx(expected[settled], abs=2e-4)
        assert through(cycles)[settled, 2] == pytest.approx(3 * expected[settled], abs=6e-4)
    # Samples of 64 per revolution turn an order of 64 − k into k.
    for image in (64 - usable, 64 - 5.5, 64 + 3, *([128 + 9.2] if factor > 2 else [])):
        assert np.max(np.abs(through(image)[LENGTH:, 0])) < 2e-4


@pytest.mark.parametrize(
    ("steps", "samples", "factor"), [(4096, 512, 8), (1024, 512, 2), (1000, 512, 1), (1500, 500, 3), (1009, 100, 1)]
)
def test_decimation_divides_the_revolution(steps, samples, factor):
    assert factor_for(steps, samples) == factor
    assert usable_orders(steps, factor) == (steps // factor // 4 if factor > 1 else steps // 2)


def test_forced_vibration_has_the_amplitude_of_the_transfer_function():
    """In permanent contact without wear, a casing of one harmonic drives a linear blade at one engine order."""
    steps, stiffness, height = 2048, 2e6, 1e-4
    surface = -height * (3 + np.cos(2 * np.pi * 3 * np.arange(steps) / steps))
    law = lobex.Plastic(stiffness=stiffness, yield_force=1e30)
    speeds = np.array([70.0, 125.0, 190.0])
    result = lobex.march_wear(ROD, lobex.Casing(3, surface=surface), law, speeds, 60, steps)
    spectrum = result.spectrum(skip=40)
    omega, ratio, shape = ROD.angular_frequency, ROD.damping_ratio, ROD.shape[:, 0]
    drive = 2 * np.pi * 3 * speeds[:, None]
    receptance = np.sum(shape**2 / (omega**2 - drive**2 + 2j * ratio * omega * drive), axis=1)
    expected = np.abs(stiffness * height * receptance / (1 + stiffness * receptance))
    assert spectrum.engine_order(3) == pytest.approx(expected, rel=1e-3)
    assert np.all(spectrum.engine_order(6) < 1e-3 * expected)
    assert spectrum.frequency[1, np.argmax(np.where(spectrum.order > 1, spectrum.amplitude[1], 0))] == 375
    static = np.sum(shape**2 / omega**2)
    assert spectrum.amplitude[:, 0] == pytest.approx(
        np.full(3, 3 * stiffness * height * static / (1 + stiffness * static)), rel=1e-4
    )


def test_critical_speeds_divide_the_natural_frequencies():
    speeds = lobex.critical_speeds(lobex.Rod(30).modes(), nodal_diameters=2, harmonics=4)
    assert speeds.shape == (30, 4)
    # The thesis gives 338, 1015, 1694 Hz for 30 elements.
    assert speeds[:3, 0] * 2 == pytest.approx([338, 1015, 1694], abs=1)
    assert speeds[0, 0] / speeds[0] == pytest.approx([1, 2, 3, 4], rel=1e-14)


@pytest.fixture(scope="module")
def spectrum():
    speeds = np.linspace(60, 400, 41)
    return lobex.march_wear(ROD, lobex.Casing(), lobex.Linear(4.5e6), speeds, 4, 320).spectrum(window="hann")


def test_the_picture_shows_engine_orders_natural_frequencies_and_critical_speeds(spectrum):
    axes = spectrum.plot(highest=1000.0, orders=4)
    assert axes.get_xlabel() == "rotational frequency (Hz)"
    assert axes.get_ylabel() == "frequency (Hz)"
    slopes = [
        line.get_ydata()[1] / line.get_xdata()[1]
        for line in axes.get_lines()
        if line.get_xdata()[0] == 60 and line.get_ydata()[0] > 0
    ]
    assert slopes == pytest.approx([1, 2, 3, 4])
    level = [line.get_ydata()[0] for line in axes.get_lines() if list(line.get_xdata()) == [0, 1]]
    assert level == pytest.approx([ROD.frequency[0]])
    upright = [line.get_xdata()[0] for line in axes.get_lines() if list(line.get_ydata()) == [0, 1]]
    assert sorted(upright) == pytest.approx(sorted(ROD.frequency[0] / np.array([1.0, 2, 4])))
    names = {text.get_text() for text in axes.texts}
    assert {"$f_1$", "$f_1/2$", "$f_1/4$", "2", "4"} <= names
    assert axes.figure.axes[1].get_ylabel() == "amplitude of the tip (µm)"
    shown = axes.collections[0].get_array()
    assert shown.max() == pytest.approx(
        1e6 * np.max(np.where((spectrum.frequency > 4) & (spectrum.frequency < 1000), spectrum.amplitude, 0)), rel=1e-9
    )


def test_the_campbell_diagram_marks_the_critical_speeds():
    axes = lobex.campbell(ROD, nodal_diameters=3)
    marks = next(line for line in axes.get_lines() if line.get_marker() == "o")
    speeds = lobex.critical_speeds(ROD, 3, 6)
    for speed, frequency in zip(marks.get_xdata(), marks.get_ydata(), strict=True):
        assert frequency / speed % 3 == pytest.approx(0, abs=1e-9)
        assert np.min(np.abs(speeds - speed)) < 1e-9
    assert f"{speeds[0, 0]:.4g} Hz" in [text.get_text() for text in axes.texts]
    assert len(axes.get_legend().get_texts()) == 4


@pytest.mark.slow
def test_critical_speeds_of_modes_that_stiffen_lie_on_their_own_frequencies():
    # f² = f₀² + B s²: order k meets it at s = f₀/√(k² − B), and no order below √B does.
    still, stiffening = np.array([200.0, 500.0]), np.array([1.6, 6.5])
    shape = np.ones((2, 1))
    modes = lobex.RotatingModes(2 * np.pi * still, np.diag(stiffening), None, [0.01, 0.01], shape, None, (1, 2))
    order = np.arange(1, 7)
    with np.errstate(invalid="ignore"):
        expected = still[:, None] / np.sqrt(order**2 - stiffening[:, None])
    np.testing.assert_allclose(lobex.critical_speeds(modes, 1, 6), expected, rtol=1e-12)
    limit = lobex.exact_limit(lobex.Rub(modes), [60.0, 80.0])
    axes = lobex.campbell(modes, nodal_diameters=2, highest_speed=120.0, limit=limit)
    marks = next(line for line in axes.get_lines() if line.get_marker() == "o" and line.get_markersize() == 5)
    speed, frequency = marks.get_data()
    assert len(speed) > 3
    assert np.max(np.min(np.abs(frequency[:, None] - 2 * order * speed[:, None]), axis=1)) < 1e-9
    chatter = np.concatenate([line.get_ydata() for line in axes.get_lines() if "chatter" in str(line.get_label())])
    np.testing.assert_allclose(chatter, limit.chatter_frequency)


def test_printing_and_saving(spectrum, tmp_path):
    for part in ("41 speeds ×", "window 'hann'", "largest line"):
        assert part in repr(spectrum)
    spectrum.save(tmp_path / "s.nc")
    again = lobex.load(tmp_path / "s.nc")
    assert_same_fields(again, spectrum)
    assert spectrum.to_xarray()["frequency"].dims == ("speed", "order")


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: s.engine_order(999), "number = 999"),
        (lambda s: s.plot(highest=-1.0), "highest = -1"),
        (lambda s: s.plot(orders=-1), "orders = -1"),
        (lambda s: lobex.critical_speeds("rod"), "modes = 'rod'"),
        (lambda s: lobex.critical_speeds(ROD, 0), "nodal_diameters = 0"),
        (lambda s: lobex.critical_speeds(ROD, 2, 0), "harmonics = 0"),
        (lambda s: lobex.campbell("rod"), "modes = 'rod'"),
        (lambda s: lobex.campbell(ROD, limit="rub"), "limit = 'rub' is no limit"),
        (lambda s: lobex.campbell(ROD, highest_speed=np.nan), "highest_speed = nan"),
    ],
)
def test_bad_input_is_refused_in_one_line(spectrum, call, words):
    with refused(words):
        call(spectrum)
