"""Logarithmic sensitivities of the limit: scaling laws, closed forms, separate searches, labels, files, pictures."""

from dataclasses import replace
from functools import partial

import jax
import matplotlib.pyplot as plt
import numpy as np
import pytest

import lobex
from cases import LIMIT_TOOLS, MILL, ROD, milling
from lobex.limits.receptance import receptance
from refusals import refused

SPEEDS = np.array([85.0, 112.0, 150.0, 200.0])
SEARCH = lobex.Chebyshev(44)
TURNING = lobex.Turning(ROD.modes, radial=3e8)


def blade(numbers):
    rod = lobex.Rod(5, numbers["young_modulus"], numbers["density"], numbers["length"], numbers["area"])
    return lobex.Rub(rod.modes(numbers["damping_ratio"]))


AT = {"young_modulus": 210e7, "density": 4600.0, "length": 0.5, "area": 10e-4, "damping_ratio": 0.03}


def at_one_speed(limit):
    names = ("speed", "gain", "chatter_frequency", "kind_code", "status_code", "intervals", "error")
    return replace(limit, **{name: getattr(limit, name)[:1] for name in names})


@pytest.fixture(scope="module")
def rod():
    return lobex.sensitivities(ROD, SPEEDS)


@pytest.fixture(scope="module")
def designed():
    return lobex.sensitivities(blade, SPEEDS, at=AT)


@pytest.fixture(scope="module")
def searched():
    return lobex.sensitivities(ROD, SPEEDS, (4.5e4, 2e6), SEARCH, scan=9)


def test_every_number_has_a_name(rod):
    each = [f"modes.{name}[{i}]" for name in ("angular_frequency", "damping_ratio") for i in range(5)]
    assert rod.names == (*each, *(f"modes.shape[{i},0]" for i in range(5)), "speed")
    assert rod.value[2].tolist() == [*np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(ROD)]), 150.0]
    assert rod["speed"].tolist() == rod.logarithmic[:, -1].tolist()
    with pytest.raises(KeyError, match="none of the numbers"):
        rod["speed of light"]


def test_scaling_laws_of_the_modes(rod):
    table = rod.logarithmic
    frequency, shape = table[:, :5].sum(axis=1), table[:, 10:15].sum(axis=1)
    # Stiffness: ω → √α ω, f → √α f, K → αK. Mass: φ → φ/√β with ω and f as they are, K → βK.
    assert (frequency + rod["speed"]) / 2 == pytest.approx(1, rel=1e-10)
    assert -shape / 2 == pytest.approx(1, rel=1e-10)


def test_scaling_laws_of_the_rod(designed):
    # K(αK, f) = α K(K, f/√α) at constant mass, K(βM; f) = K(M; f√β); the area scales both, the length M and 1/K.
    by_speed = designed["speed"]
    assert designed["young_modulus"] == pytest.approx(1 - by_speed / 2, rel=1e-8)
    assert designed["density"] == pytest.approx(by_speed / 2, rel=1e-8)
    assert designed["area"] == pytest.approx(1, rel=1e-8)
    assert designed["length"] == pytest.approx(by_speed - 1, rel=1e-8)


def test_a_number_that_all_modes_share_has_the_sum_of_their_sensitivities(rod, designed):
    assert designed["damping_ratio"] == pytest.approx(rod.logarithmic[:, 5:10].sum(axis=1), rel=1e-10)


def test_the_search_gives_the_sensitivities_of_the_closed_form(rod, searched):
    assert searched.names == rod.names
    assert searched.logarithmic == pytest.approx(rod.logarithmic, rel=1e-7, abs=1e-9)
    verb = partial(lobex.critical_gain, bounds=(4.5e4, 2e6), method=SEARCH, scan=9)
    np.testing.assert_array_equal(lobex.sensitivities(ROD, SPEEDS, verb=verb).derivative, searched.derivative)


def test_turning_depends_on_the_cutting_force_by_minus_one():
    table = lobex.sensitivities(TURNING, SPEEDS)
    assert table["radial"] == pytest.approx(-1, rel=1e-12)
    assert table.limit.gain * 3e8 == pytest.approx(lobex.exact_limit(ROD, SPEEDS).gain, rel=1e-12)


def test_derivatives_by_the_real_part_of_the_receptance_at_the_minimum():
    # dK/dp = ∂_p Re G / (2 (Re G)²) at the minimum over ω, for every number of all five modes.
    least = lobex.exact_lobes(ROD, 4).minimum
    table = lobex.sensitivities(ROD, least.speed)
    assert table.limit.gain == pytest.approx(float(least.gain), rel=1e-11)
    assert table["speed"] == pytest.approx(0, abs=1e-6)
    omega = float(least.angular_frequency)

    def real(modes):
        own, ratio = modes.angular_frequency, modes.damping_ratio
        terms = modes.shape[:, 0] ** 2 / (own**2 - omega**2 + 2j * ratio * own * omega)
        return jax.numpy.sum(terms).real

    with jax.enable_x64(True):
        modes = jax.tree.map(jax.numpy.asarray, ROD.modes)
        slope = np.concatenate([np.ravel(leaf) for leaf in jax.tree.leaves(jax.grad(real)(modes))])
        expected = slope / (2 * float(real(modes)) ** 2)
    logarithmic = expected * table.value[0, :-1] / float(least.gain)
    for row in table.logarithmic[:, :-1]:
        assert row == pytest.approx(logarithmic, rel=1e-6, abs=1e-8)


FREQUENCY = np.linspace(280.0, 1600.0, 264)


@pytest.fixture(scope="module")
def measured():
    samples = receptance(ROD.modes, 2 * np.pi * FREQUENCY)
    return lobex.sensitivities(lobex.Rub(lobex.Receptance(FREQUENCY, samples)), SPEEDS)


def of_samples(table):
    """Derivatives by the samples, (n, 2 · 264), real and imaginary parts side by side."""
    there = [i for i, name in enumerate(table.names) if name.startswith("modes.response[")]
    return table.derivative[:, there]


@pytest.mark.slow
def test_samples_of_a_measurement_have_the_sensitivities_of_its_modes(measured, rod):
    # dK/dp = Σ Re(dK/dG* dG/dp) over the samples.
    step = 1e-6
    for name in ("modes.damping_ratio[0]", "modes.angular_frequency[0]", "modes.shape[0,0]"):
        stem = name.removeprefix("modes.").partition("[")[0]
        ends = []
        for share in (step, -step):
            numbers = np.array(getattr(ROD.modes, stem), dtype=float)
            numbers[0] *= 1 + share
            ends.append(receptance(replace(ROD.modes, **{stem: numbers}), 2 * np.pi * FREQUENCY))
        change = (ends[0] - ends[1]) / (2 * step)
        found = of_samples(measured) @ np.column_stack([change.real, change.imag]).ravel() / measured.limit.gain
        assert found == pytest.approx(rod[name], rel=1e-4, abs=1e-5)


@pytest.mark.slow
def test_scaling_laws_of_a_measurement(measured):
    table = measured.logarithmic
    by = {stem: [i for i, name in enumerate(measured.names) if stem in name] for stem in ("response", "frequency")}
    # K(αG) = K(G)/α; and of all frequencies and the speed by one factor nothing changes.
    assert table[:, by["response"]].sum(axis=1) == pytest.approx(-1, rel=1e-10)
    assert table[:, by["frequency"]].sum(axis=1) == pytest.approx(-measured["speed"], rel=1e-8)
    assert measured.names[264:266] == ("modes.response[0].real", "modes.response[0].imag")


def test_numbers_that_samples_stand_beside_have_sensitivities_of_their_own():
    samples = lobex.Receptance(FREQUENCY, receptance(ROD.modes, 2 * np.pi * FREQUENCY))
    table = lobex.sensitivities(lambda p: lobex.Turning(samples, radial=p["force"]), SPEEDS, at={"force": 2e8})
    assert table["force"] == pytest.approx(-1, rel=1e-9)
    with jax.enable_x64(True):
        known = jax.jit(lambda omega: receptance(samples, omega))(3000.0)
    assert known == pytest.approx(receptance(samples, 3000.0), rel=1e-13)


@pytest.mark.slow
def test_a_band_of_samples_is_the_scatter_of_limits(measured):
    random, share, limits = np.random.default_rng(5), 1e-4, []
    clean = receptance(ROD.modes, 2 * np.pi * FREQUENCY)
    for _ in range(40):
        noise = share * np.abs(clean) * (random.standard_normal((2, len(clean))) * [[1], [1j]]).sum(axis=0)
        limits.append(lobex.exact_limit(lobex.Rub(lobex.Receptance(FREQUENCY, clean + noise)), SPEEDS).gain)
    band = measured.limit.band({"modes.response": share})
    # Of 40 samples a standard deviation is known to 11 %.
    assert band.relative == pytest.approx(np.std(np.log(limits), axis=0, ddof=1), rel=0.35)
    assert band.relative == pytest.approx(measured.band({"modes.response": share}).relative, rel=1e-12)


def test_milling_against_separate_searches():
    # Angles, forces, damping, speed: central differences of critical_gain itself, along each.
    process, method, bounds = milling(LIMIT_TOOLS["Insperger-Stepan"], 0.1, "down"), lobex.Chebyshev(24), (0, 2e-3)
    speed, step = 8000 / 60, 2e-4
    table = lobex.sensitivities(process, speed, bounds, method, scan=9)

    def gain(process, speed):
        return lobex.critical_gain(process, speed, bounds, method, scan=9).gain[0]

    def difference(change):
        high, low = (gain(*change(share)) for share in (1 + step, 1 - step))
        return (high - low) / (2 * step * table.limit.gain[0])

    def damped(share):
        modes = process.modes
        return replace(modes, damping_ratio=modes.damping_ratio * share)

    assert table.limit.gain[0] == pytest.approx(gain(process, speed), rel=1e-12)
    for name in ("tangential", "normal", "radial_immersion"):
        moved = difference(lambda share, name=name: (replace(process, **{name: getattr(process, name) * share}), speed))
        assert table[name][0] == pytest.approx(moved, rel=1e-6)
    assert table["speed"][0] == pytest.approx(difference(lambda share: (process, speed * share)), rel=1e-6)
    moved = difference(lambda share: (replace(process, modes=damped(share)), speed))
    assert table["modes.damping_ratio[0]"][0] == pytest.approx(moved, rel=1e-6)
    # Both cutting forces by α are a depth by 1/α; the mode's mass by α is φ by α^(−1/2).
    assert table["tangential"] + table["normal"] == pytest.approx(-1, rel=1e-8)
    assert table["modes.shape[0,0]"] == pytest.approx(-2, rel=1e-8)


@pytest.mark.slow
def test_full_immersion_against_one_sided_differences_of_separate_searches():
    # 1 − a goes with the square of the angle: one-sided differences miss by c √h, and by n/√h with the error of the
    # nodes, and three of them tell both apart.
    speeds, method, bounds = [30.0, 60.0, 90.0], lobex.Duhamel(nodes=24), (1e-7, 2e-2)

    def search(immersion):
        return replace(MILL, cutter=lobex.Cutter(2), radial_immersion=immersion), speeds, bounds, method

    table = lobex.sensitivities(*search(1.0), scan=17)
    one, two, three = (
        (1 - lobex.critical_gain(*search(1 - h), scan=17).gain / table.limit.gain) / h for h in (1e-7, 4e-7, 1.6e-6)
    )
    assert table["radial_immersion"] == pytest.approx(-2 * one + 5 * two - 2 * three, rel=1e-3)
    assert table["radial_immersion"] == pytest.approx([-4.632, -6.6015, -3.633], rel=2e-4)
    # Both cutting forces by α are a depth by 1/α.
    assert table["tangential"] + table["normal"] == pytest.approx(-1, rel=1e-8)
    assert table.band({"radial_immersion": 0.01}).relative == pytest.approx([0.046318, 0.066015, 0.03633], rel=2e-4)


def test_no_limit_has_no_sensitivities(searched):
    table = lobex.sensitivities(ROD, SPEEDS, (4.5e4, 9e5), SEARCH, scan=9)
    missing = searched.limit.gain > 9e5
    assert missing.tolist() == [True, True, False, False]
    assert np.isnan(table.logarithmic[missing]).all()
    assert table.logarithmic[~missing] == pytest.approx(searched.logarithmic[~missing], rel=1e-7, abs=1e-9)
    none = lobex.sensitivities(ROD, SPEEDS, (1e4, 2e4), SEARCH, scan=9)
    assert np.isnan(none.logarithmic).all()
    assert "nan" in repr(none)


def test_hayes_equation():
    table = lobex.sensitivities(lobex.Scalar(-1.5), [0.5, 2.0])
    assert table["a"] == pytest.approx(1)
    assert table["speed"] == pytest.approx(0, abs=1e-12)


def test_tables_print_save_and_load(rod, designed, tmp_path):
    text = repr(designed).splitlines()
    assert text[0] == "Sensitivities of the limit of Rub: 4 speeds × 6 numbers, d ln K_e / d ln p"
    # In the units of pictures.
    assert [line.split()[:2] for line in text[1:3]] == [["speed", "(Hz)"], ["limit", "(MN/m)"]]
    assert float(text[2].split()[2]) == pytest.approx(designed.limit.gain[0] / 1e6, rel=1e-5)
    assert text[1].split() == ["speed", "(Hz)", "85", "112", "150", "200"]
    assert [line.split()[0] for line in text[3:]] == [*sorted(AT), "speed"]
    dataset = rod.to_xarray()
    picked = dataset["logarithmic"].sel(parameter="modes.damping_ratio[1]", speed=112.0)
    assert float(picked) == rod["modes.damping_ratio[1]"][1]
    rod.save(tmp_path / "table.nc")
    again = lobex.load(tmp_path / "table.nc")
    assert again.names == rod.names
    np.testing.assert_array_equal(again.derivative, rod.derivative)
    np.testing.assert_array_equal(again.logarithmic, rod.logarithmic)
    assert again.limit.status.tolist() == rod.limit.status.tolist()


def test_pictures(rod):
    axes = rod.plot()
    assert axes.get_ylabel() == r"d ln $K_{e}$ / d ln $p$"
    assert len(axes.get_legend().get_texts()) == 6
    assert axes.get_legend().get_texts()[0].get_text() == "speed"
    first = lobex.Sensitivities(rod.names, rod.value[:1], rod.derivative[:1], at_one_speed(rod.limit))
    bars = first.plot(plt.figure().add_subplot())
    assert len(bars.patches) == 16
    assert "85 Hz" in bars.get_xlabel()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.sensitivities(blade, 85.0), "is no process"),
        (lambda: lobex.sensitivities(ROD, 85.0, at=AT), "with at, give a function"),
        (lambda: lobex.sensitivities(blade, 85.0, at={}), "at = {}"),
        (lambda: lobex.sensitivities(blade, 85.0, at={"young_modulus": np.nan}), "at['young_modulus']"),
        (lambda: lobex.sensitivities(lambda p: p["a"], 85.0, at={"a": 1.0}), "is no process"),
        (lambda: lobex.sensitivities(MILL, 85.0), "Milling has no exact limit"),
        (lambda: lobex.sensitivities(ROD, 85.0, (2e6, 1e5)), "must be increasing"),
        (lambda: lobex.sensitivities(ROD, -85.0), "speed = -85"),
        (
            lambda: lobex.sensitivities(
                lobex.Rub(lobex.Receptance(np.arange(1.0, 9), -np.arange(1.0, 9) - 9j)), 3.0, (1e3, 1e5)
            ),
            "a measured receptance serves exact_limit",
        ),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()
