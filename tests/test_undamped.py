"""Without any damping: where the limit is zero, where it is that of the next lobe, and where it is undefined."""

import numpy as np
import pytest

import lobex

FREQUENCY, MASS, RADIAL = 146.5, 2.573, 2e8
OWN = 2 * np.pi * FREQUENCY
FREE = lobex.Turning(lobex.Modes.single(frequency=FREQUENCY, damping_ratio=0.0, mass=MASS), radial=RADIAL)
WHOLE = FREQUENCY / np.array([1.0, 2.0, 3.0, 7.0])


def closed_form(speed):
    """Of m ẍ + k x = −κ (x − x(t − τ)): 0 where sin ω_nτ < 0, else κ = m (ω² − ω_n²)/2 with ωτ = (2j − 1)π, ω > ω_n."""
    waves = FREQUENCY / speed
    if waves % 1 > 0.5:
        return 0.0
    half_waves = np.floor(waves) + 0.5
    return MASS * ((2 * np.pi * half_waves * speed) ** 2 - OWN**2) / 2 / RADIAL


@pytest.mark.parametrize("waves", [0.3, 0.7, 1.2, 1.8, 3.4, 3.6, 12.1])
def test_a_mode_without_damping_has_no_limit_on_one_side_of_its_frequency_and_one_on_the_other(waves):
    limit = lobex.exact_limit(FREE, FREQUENCY / waves)
    assert limit.gain[0] == pytest.approx(closed_form(FREQUENCY / waves), rel=1e-11, abs=1e-15)
    assert limit.status.tolist() == ["found"]


def test_at_whole_numbers_of_waves_the_limit_is_undefined_and_jumps():
    limit = lobex.exact_limit(FREE, WHOLE)
    assert np.isnan(limit.gain).all()
    assert np.isnan(limit.chatter_frequency).all()
    assert set(limit.status) == {"undefined"}
    assert "4 undefined" in repr(limit)
    # The reason: s = jω_n is a root at every gain, as the mode meets its own track in phase.
    s, tau = 1j * OWN, 1 / WHOLE
    assert np.abs(1 - np.exp(-s * tau)) == pytest.approx(0, abs=1e-13)
    below, above = (lobex.exact_limit(FREE, WHOLE * (1 + shift)).gain for shift in (-1e-9, 1e-9))
    assert below == pytest.approx([closed_form(speed * (1 - 1e-9)) for speed in WHOLE], rel=1e-9)
    assert above == pytest.approx(0, abs=1e-15)


def test_the_least_damping_defines_it_and_an_unseen_mode_does_not_matter():
    damped = lobex.Turning(lobex.Modes.single(frequency=FREQUENCY, damping_ratio=1e-12, mass=MASS), radial=RADIAL)
    limit = lobex.exact_limit(damped, WHOLE)
    assert set(limit.status) == {"found"}
    assert limit.gain == pytest.approx([closed_form(speed * (1 - 1e-9)) for speed in WHOLE], rel=1e-6)
    two = lobex.Modes(np.array([OWN, 2.2 * OWN]), [0.0, 0.03], [[0.0], [MASS**-0.5]])
    assert lobex.exact_limit(lobex.Turning(two, RADIAL), WHOLE).status.tolist() == ["found"] * 4
    seen = lobex.Modes(np.array([OWN, 2.2 * OWN]), [0.0, 0.03], [[MASS**-0.5], [MASS**-0.5]])
    assert lobex.exact_limit(lobex.Turning(seen, RADIAL), WHOLE).status.tolist() == ["undefined"] * 4


@pytest.mark.slow
def test_critical_gain_says_the_same():
    bounds = (1e-5, 2e-2)
    speeds = np.r_[WHOLE, 0.98 * WHOLE, 1.02 * WHOLE]
    limit = lobex.critical_gain(FREE, speeds, bounds)
    whole = np.isin(speeds, WHOLE)
    assert np.isnan(limit.gain[whole]).all()
    assert set(limit.status[whole]) == {"undefined"}
    gain, status = limit.gain[~whole], limit.status[~whole]
    expected = np.array([closed_form(speed) for speed in speeds[~whole]])
    assert gain == pytest.approx(np.where(expected > 0, expected, np.nan), rel=1e-9, nan_ok=True)
    assert set(status[expected == 0]) == {"unstable at the lower bound"}
