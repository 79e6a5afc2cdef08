"""Whatever an analyser's file holds: read as what it is, and warned of where it is taken for something else."""

import warnings

import numpy as np
import pytest

import lobex
from lobex.processes.process import check_speed
from refusals import refused

OWN, RATIO, MASS, RADIAL = 2 * np.pi * 146.5, 0.03, 2.573, 2e8
SPEEDS = [50.0, 75.0, 100.0, 125.0, 150.0]
# Of the mode itself, in mm.
LIMITS = [1.95095253, 2.68118639, 1.19098266, 3.94412077, 4.89726776]
FREQUENCY = np.arange(20.0, 1200.0)
OMEGA = 2 * np.pi * FREQUENCY
RECEPTANCE = 1 / MASS / (OWN**2 - OMEGA**2 + 2j * RATIO * OWN * OMEGA)
KINDS = {"displacement": RECEPTANCE, "velocity": 1j * OMEGA * RECEPTANCE, "acceleration": -(OMEGA**2) * RECEPTANCE}
READINGS = [(measured, conjugate) for measured in KINDS for conjugate in (False, True)]


def samples(measured, conjugate):
    return KINDS[measured].conj() if conjugate else KINDS[measured]


def limits(receptance):
    return lobex.exact_limit(lobex.Turning(receptance, radial=RADIAL), SPEEDS)


@pytest.mark.parametrize(("measured", "conjugate"), READINGS)
def test_every_kind_is_read_as_the_same_receptance(measured, conjugate):
    read = lobex.Receptance(FREQUENCY, samples(measured, conjugate), measured, conjugate)
    assert read.response == pytest.approx(RECEPTANCE, rel=1e-14)


def test_its_limits_are_those_of_the_mode():
    # A sample a hertz, between which 1/G is interpolated.
    limit = limits(lobex.Receptance(FREQUENCY, KINDS["acceleration"], measured="acceleration"))
    assert limit.gain * 1e3 == pytest.approx(LIMITS, rel=1e-6)
    assert set(limit.status) == {"found"}


@pytest.mark.parametrize("said", READINGS)
@pytest.mark.parametrize("true", READINGS)
def test_what_is_taken_for_another_kind_is_warned_of_with_the_arguments_that_mend_it(true, said):
    if true == said:
        return
    with pytest.warns(lobex.LobexWarning) as caught:
        lobex.Receptance(FREQUENCY, samples(*true), *said)
    (warning,) = caught
    measured, conjugate = true
    assert str(warning.message).endswith(f"measured={measured!r}" + (", conjugate=True" if conjugate else ""))
    assert warning.filename == __file__


@pytest.mark.parametrize(
    "response", [*KINDS.values(), *(kind.conj() for kind in KINDS.values()), np.abs(RECEPTANCE), RECEPTANCE.real]
)
def test_what_was_warned_of_does_not_make_every_speed_too_fast(response):
    # Of the other sign of time the first line, whatever its frequency, was taken for the resonance.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        receptance = lobex.Receptance(np.r_[0.5, FREQUENCY], np.r_[response[0], response])
        check_speed(lobex.Turning(receptance, radial=RADIAL), SPEEDS)


@pytest.mark.parametrize("noise", [0.003, 0.03])
def test_noise_and_several_modes_are_no_reason_to_warn(noise):
    random = np.random.default_rng(3)
    for _ in range(20):
        own = 2 * np.pi * random.uniform(60, 1000, (4, 1))
        modes = random.uniform(0.1, 1, (4, 1)) / (own**2 - OMEGA**2 + 2j * random.uniform(0.005, 0.1) * own * OMEGA)
        clean = modes.sum(axis=0)
        floor = noise * np.median(np.abs(clean)) * random.standard_normal((2, len(OMEGA)))
        lobex.Receptance(FREQUENCY, clean + floor[0] + 1j * floor[1])


def test_a_magnitude_is_warned_of_and_its_limit_is_not_said_to_be_absent():
    with pytest.warns(lobex.LobexWarning, match="no imaginary part, as a magnitude without phase; give complex"):
        receptance = lobex.Receptance(FREQUENCY, np.abs(RECEPTANCE))
    limit = limits(receptance)
    assert np.isnan(limit.gain).all()
    assert set(limit.status) == {"beyond the measured frequencies"}


def test_a_line_at_0_hz_is_left_out_with_a_note():
    with pytest.warns(lobex.LobexWarning, match="begins at 0 Hz.*left out"):
        receptance = lobex.Receptance(np.r_[0.0, FREQUENCY], np.r_[0.0, RECEPTANCE])
    assert receptance.frequency[0] == FREQUENCY[0]
    assert np.array_equal(receptance.response, RECEPTANCE)


def test_real_and_imaginary_columns_are_complex_samples():
    columns = np.column_stack([RECEPTANCE.real, RECEPTANCE.imag])
    assert np.array_equal(lobex.Receptance(FREQUENCY, columns).response, RECEPTANCE)


def test_where_the_measured_band_ends_the_status_says_so(tmp_path):
    # Above twice the band's end no lobe has a frequency within it.
    band = lobex.Receptance(FREQUENCY[:300], RECEPTANCE[:300])
    limit = lobex.exact_limit(lobex.Turning(band, radial=RADIAL), [100.0, 2.01 * 319])
    assert limit.status.tolist() == ["found", "beyond the measured frequencies"]
    assert "1 beyond the measured frequencies" in repr(limit)
    limit.save(tmp_path / "limit.nc")
    assert lobex.load(tmp_path / "limit.nc").status.tolist() == limit.status.tolist()
    limit.plot()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.Receptance(FREQUENCY, RECEPTANCE, "force"), "measured = 'force' is unknown; choose one of"),
        (lambda: lobex.Receptance(FREQUENCY, RECEPTANCE, conjugate=1), "conjugate = 1"),
        (lambda: lobex.Receptance([-1.0, 1.0, 2.0, 3.0, 4.0], np.ones(5)), "frequency = [-1, 1, 2, 3, …] must be"),
        (lambda: lobex.Receptance([0.0, 1.0, 2.0, 3.0], np.ones(4)), "frequency has 3 samples above 0 Hz"),
        (lambda: lobex.Receptance(FREQUENCY, np.ones((len(FREQUENCY), 3))), "or columns of real and imaginary parts"),
    ],
)
def test_bad_samples_are_refused_in_one_line(call, words):
    with refused(words):
        call()
