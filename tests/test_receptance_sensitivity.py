"""How limits of milling from receptances move: differences of themselves, the operator, scaling laws, scatter."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import lobex
from lobex.limits.receptance_matrix import MatrixCurve
from refusals import refused

TANGENTIAL, NORMAL = 6.79e8, 1.73824e8
PLANE = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
FLAT = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
UNEVEN = lobex.Cutter.end_mill(0.02, pitch_degrees=[75, 100, 88, 97])
PAIR = lobex.Cutter.end_mill(0.02, pitch_degrees=[160, 200])
FREQUENCY = np.arange(200.0, 1300.0, 4.0)


def milling(modes, cutter=4, immersion=0.5, direction="down"):
    return lobex.Milling(modes, cutter, TANGENTIAL, NORMAL, immersion, direction)


def sampled(modes):
    return lobex.ReceptanceMatrix(FREQUENCY, MatrixCurve(modes)(2 * np.pi * FREQUENCY))


zero_order = lobex.zero_order_limit
# Between two harmonics, so that none comes or goes as a number moves.
harmonics = partial(lobex.multi_frequency_limit, reach=2110.0)

CASES = {
    "mean force": (zero_order, milling(PLANE), 5000.0),
    "mean force of uneven teeth": (zero_order, milling(PLANE, UNEVEN), 5000.0),
    "harmonics": (harmonics, milling(PLANE, 2, 0.1, "up"), 4000.0),
    "harmonics of uneven teeth": (partial(lobex.multi_frequency_limit, reach=1290.0), milling(PLANE, PAIR), 9000.0),
    "a flip": (partial(lobex.multi_frequency_limit, reach=1100.0), milling(FLAT, 1), 5000.0),
    "modes that are not in phase": (
        zero_order,
        milling(replace(PLANE, quadrature=[[0.1, 0.0], [0.0, -0.05]], force_quadrature=[[0.05, 0.0], [0.02, 0.0]])),
        5000.0,
    ),
}


_CHEAP = {"mean force of uneven teeth"}


@pytest.mark.parametrize(
    "case", [pytest.param(name, marks=[] if name in _CHEAP else pytest.mark.slow) for name in CASES]
)
def test_they_are_the_differences_of_the_limit_itself(case):
    solve, process, rpm = CASES[case]
    limit, step = solve(process, [rpm / 60]), 1e-5
    table = limit.sensitivities()
    assert limit.kind[0] == ("flip" if case == "a flip" else "hopf")

    def difference(change):
        high, low = (solve(*change(share)).gain[0] for share in (1 + step, 1 - step))
        return (high - low) / (2 * step * limit.gain[0])

    def with_mode(name, share):
        numbers = np.array(getattr(process.modes, name))
        numbers[0] *= share
        return replace(process, modes=replace(process.modes, **{name: numbers})), limit.speed

    for name in ("tangential", "normal", "radial_immersion"):
        moved = difference(
            lambda share, name=name: (replace(process, **{name: getattr(process, name) * share}), limit.speed)
        )
        assert table[name][0] == pytest.approx(moved, rel=1e-6, abs=1e-7)
    assert table["speed"][0] == pytest.approx(difference(lambda share: (process, limit.speed * share)), rel=1e-6)
    for name in ("angular_frequency", "damping_ratio"):
        assert table[f"modes.{name}[0]"][0] == pytest.approx(difference(partial(with_mode, name)), rel=1e-6, abs=1e-7)
    # Both cutting forces by α are a depth by 1/α; and of frequencies and speed, by α² less flexible modes.
    assert table["tangential"] + table["normal"] == pytest.approx(-1, rel=1e-9)


def test_pitch_angles_move_it_as_the_limit_itself_does():
    process, rpm, step = milling(PLANE, UNEVEN), 5000.0, 1e-4
    table = zero_order(process, rpm / 60).sensitivities()
    # One tooth nearer to the next and as much farther from the one before.
    first, second = (table.derivative[0, table.names.index(f"cutter.pitch[{k}]")] for k in (0, 1))
    turned = []
    for degrees in (step, -step):
        cutter = lobex.Cutter.end_mill(0.02, pitch_degrees=[75 + degrees, 100 - degrees, 88, 97])
        turned.append(zero_order(milling(PLANE, cutter), rpm / 60).gain[0])
    assert first - second == pytest.approx((turned[0] - turned[1]) / np.deg2rad(2 * step), rel=1e-5)


@pytest.mark.slow
def test_where_the_force_is_constant_they_are_those_of_the_operator():
    process, speed = milling(PLANE, 4, 1.0, "up"), np.array([3000.0, 7000.0]) / 60
    limit = zero_order(process, speed)
    found = limit.sensitivities()
    wanted = lobex.sensitivities(process, speed, (1e-4, 2 * np.max(limit.gain)), scan=17)
    assert found.limit.gain == pytest.approx(wanted.limit.gain, rel=1e-7)
    assert found.names == wanted.names
    known = [name for name in found.names if name != "radial_immersion"]
    for name in known:
        assert found[name] == pytest.approx(wanted[name], rel=1e-5, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("cutter", [4, PAIR])
def test_with_all_harmonics_they_are_those_of_the_operator(cutter):
    process, speed = milling(PLANE, cutter), np.array([5000.0]) / 60
    limit = lobex.multi_frequency_limit(process, speed, reach=4000.0)
    found = limit.sensitivities()
    wanted = lobex.sensitivities(process, speed, (1e-4, 1.3 * limit.gain[0]), scan=17)
    assert limit.gain == pytest.approx(wanted.limit.gain, rel=1e-3)
    assert found.logarithmic == pytest.approx(wanted.logarithmic, rel=5e-3, abs=5e-3)


@pytest.fixture(scope="module")
def measured():
    """Of both solutions, with their modes'."""
    made = []
    for solve, cutter in ((zero_order, UNEVEN), (partial(lobex.multi_frequency_limit, reach=1190.0), PAIR)):
        direct, modal = (solve(milling(source, cutter), [9000 / 60]) for source in (sampled(PLANE), PLANE))
        made.append((direct.sensitivities(), modal))
    return made


def of_samples(table):
    there = [i for i, name in enumerate(table.names) if name.startswith("modes.response[")]
    return table.derivative[0, there]


@pytest.mark.slow
def test_samples_of_a_measurement_have_the_sensitivities_of_its_modes(measured):
    step = 1e-6
    for table, modal in measured:
        known = modal.sensitivities()
        for name in ("damping_ratio", "angular_frequency", "shape"):
            numbers = [np.array(getattr(PLANE, name), dtype=float) for _ in range(2)]
            for one, share in zip(numbers, (step, -step), strict=True):
                one[(0,) * one.ndim] *= 1 + share
            ends = [sampled(replace(PLANE, **{name: one})).response for one in numbers]
            change = ((ends[0] - ends[1]) / (2 * step)).ravel()
            found = of_samples(table) @ np.column_stack([change.real, change.imag]).ravel() / table.limit.gain[0]
            place = "[0,0]" if name == "shape" else "[0]"
            # What lies outside the band is not in the samples.
            assert found == pytest.approx(known[f"modes.{name}{place}"][0], rel=2e-2, abs=2e-3)


@pytest.mark.slow
def test_scaling_laws_of_a_measurement(measured):
    for table, _ in measured:
        logarithmic = table.logarithmic[0]
        by = {stem: [i for i, name in enumerate(table.names) if stem in name] for stem in ("response", "frequency")}
        # b(αG) = b(G)/α; and of all frequencies and the speed by one factor nothing changes.
        assert logarithmic[by["response"]].sum() == pytest.approx(-1, rel=1e-9)
        assert logarithmic[by["frequency"]].sum() == pytest.approx(-table["speed"][0], rel=1e-7, abs=1e-7)
    assert "modes.response[3,0,1].imag" in table.names


@pytest.mark.slow
def test_a_band_of_samples_is_the_scatter_of_limits():
    random, share, speed = np.random.default_rng(3), 1e-4, np.array([9000 / 60])
    clean, limits = sampled(PLANE), []
    for _ in range(40):
        noise = random.standard_normal((2, *clean.response.shape))
        response = clean.response + share * np.abs(clean.response) * (noise[0] + 1j * noise[1])
        limits.append(zero_order(milling(lobex.ReceptanceMatrix(FREQUENCY, response)), speed).gain)
    band = zero_order(milling(clean), speed).band({"modes.response": share})
    # Of 40 samples a standard deviation is known to 11 %.
    assert band.relative == pytest.approx(np.std(np.log(limits), axis=0, ddof=1), rel=0.35)


def build(numbers):
    """Of samples that stay as they are, and numbers that the process is made from."""
    force, immersion = numbers["force"], numbers["immersion"]
    return lobex.Milling(sampled(PLANE), PAIR, force, NORMAL / TANGENTIAL * force, immersion, "down")


@pytest.mark.slow
@pytest.mark.parametrize("verb", [zero_order, partial(lobex.multi_frequency_limit, reach=1290.0)])
def test_numbers_that_samples_stand_beside_move_the_limit(verb):
    at, speed, step = {"force": TANGENTIAL, "immersion": 0.5}, [9000 / 60], 1e-5
    table = lobex.sensitivities(build, speed, at=at, verb=verb)
    ends = [verb(build(at | {"immersion": 0.5 * share}), speed).gain[0] for share in (1 + step, 1 - step)]
    assert table["force"] == pytest.approx(-1, rel=1e-9)
    assert table["immersion"] == pytest.approx((ends[0] - ends[1]) / (2 * step * table.limit.gain[0]), rel=1e-6)


@pytest.mark.parametrize(
    ("verb", "bounds", "words"),
    [
        (zero_order, (1e-4, 1e-2), "finds the limit by itself, as a function of process and speed; give that, without"),
        ("zero order", None, "verb = 'zero order' finds the limit by itself"),
        (lambda process, speed: 3.0, None, "verb finds 3.0, and no Limit; give such as lobex.zero_order_limit"),
    ],
)
def test_what_is_no_verb_of_a_limit_is_refused(verb, bounds, words):
    with refused(words):
        lobex.sensitivities(milling(PLANE), [80.0], bounds, verb=verb)


def test_no_limit_has_no_sensitivities():
    narrow = lobex.ReceptanceMatrix(FREQUENCY[:4], sampled(PLANE).response[:4])
    table = zero_order(milling(narrow), [80.0, 90.0]).sensitivities()
    assert np.isnan(table.derivative).all()
    both = zero_order(milling(sampled(PLANE)), [80.0, 1e4])
    assert (
        np.isnan(both.gain).tolist() == np.isnan(both.sensitivities().derivative).all(axis=1).tolist() == [False, True]
    )
