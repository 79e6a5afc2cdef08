"""Whatever an analyser's file holds: read as what it is, and warned of where it is taken for something else."""

import itertools
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
    first = str(warning.message).partition(" is read by ")[2].partition(", or ")[0]
    assert first == f"measured={measured!r}" + (", conjugate=True" if conjugate else "")
    assert warning.filename == __file__


def test_a_resonance_narrower_than_the_lines_is_called_nothing_by_its_phase():
    for own in 2 * np.pi * np.linspace(146.0, 147.0, 21):
        response = 1 / MASS / (own**2 - OMEGA**2 + 2e-3j * own * OMEGA)
        assert lobex.Receptance(FREQUENCY, response).response == pytest.approx(response)


KINDS_OF = "displacement", "velocity", "acceleration"
MISTAKES = [
    reading
    for reading in itertools.product(KINDS_OF, KINDS_OF, (False, True), (False, True))
    if reading[0] != reading[1] or reading[2] or reading[3]
]


@pytest.fixture(scope="module")
def structures():
    """Accelerances and the like of structures at random, with noise and bands as tap tests have them."""
    random, made = np.random.default_rng(19), []
    for noise in (0.0, 0.01, 0.03):
        for _ in range(8):
            low, high = random.choice([1.0, 20.0, 50.0]), random.choice([800.0, 1600.0])
            omega = 2 * np.pi * np.arange(low, high, 1.0)
            own = 2 * np.pi * random.uniform(max(1.5 * low, 60), 0.8 * high, (random.integers(1, 5), 1))
            ratio, shape = random.uniform(0.005, 0.05, own.shape), random.uniform(0.3, 1, own.shape)
            clean = (shape**2 / (own**2 - omega**2 + 2j * ratio * own * omega)).sum(axis=0)
            of_kind = {}
            for power, kind in enumerate(KINDS_OF):
                of_kind[kind] = (1j * omega) ** power * clean
                white = random.standard_normal((2, len(omega))) / np.sqrt(2)
                of_kind[kind] += noise * np.abs(of_kind[kind]).max() * (white[0] + 1j * white[1])
            made.append((omega / (2 * np.pi), of_kind))
    return made


def told(samples, said):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        lobex.Receptance(*samples, measured=said)
    return " ".join(str(one.message) for one in caught)


def test_measurements_as_they_are_are_no_reason_to_warn(structures):
    for frequency, of_kind in structures:
        for kind, samples in of_kind.items():
            assert told((frequency, samples), kind) == ""


@pytest.mark.parametrize(("true", "said", "conjugate", "against"), MISTAKES)
def test_every_mistake_is_warned_of_with_what_mends_it(true, said, conjugate, against, structures):
    sign = -1 if against else 1
    wanted = ("-response and " if against else "") + f"measured={true!r}" + (", conjugate=True" if conjugate else "")
    seen = mended = 0
    for frequency, of_kind in structures:
        samples = sign * (of_kind[true].conj() if conjugate else of_kind[true])
        message = told((frequency, samples), said)
        seen += bool(message)
        mended += wanted in [way.rpartition("by ")[2] for way in message.split(", or ")]
    if {true, said} == {"displacement", "acceleration"} and against and not conjugate:
        # Twice a derivative by time is a change of sign, which the other takes back.
        assert seen == 0
    else:
        assert seen >= len(structures) - 2
        assert mended >= seen - 1


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
