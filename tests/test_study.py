"""Studies: further axes, labels, chunks, what is read of them, and files."""

import inspect
import re
import typing
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lobex
from cases import assert_same_fields
from lobex import _memory as memory
from lobex.results.fields import names_of
from lobex.studies import charts, plan, store
from lobex.studies.plan import Plan, plan_of
from lobex.studies.study import Study
from lobex.studies.variation import Variation, axes_of
from refusals import refused

METHOD = lobex.Chebyshev(16)
SPEED, GAIN = np.linspace(300, 700, 9), np.linspace(0, 4e6, 6)
BLADE = lobex.Rod(2).modes(0.03)
RUB = lobex.Rub(BLADE)
RATIOS = [0.01, 0.02, 0.05]
OVER = {"modes.damping_ratio": RATIOS, "modes.shape[0,0]": [-40.0, -30.0]}


@pytest.fixture(scope="module")
def study():
    return lobex.sweep(RUB, SPEED, GAIN, METHOD, over=OVER)


@pytest.fixture(scope="module")
def wear():
    arguments = (BLADE, lobex.Casing(), lobex.Linear(4.5e6), np.linspace(60, 400, 70), 3, 512)
    over = {"casing.amplitude": [1e-4, 2e-4], "law.stiffness": [3e6, 4e6]}
    return arguments, lobex.march_wear(*arguments, samples_per_revolution=64, over=over)


def test_each_chart_is_what_a_sweep_of_that_model_gives(study):
    for i, ratio in enumerate(RATIOS):
        for j, shape in enumerate(OVER["modes.shape[0,0]"]):
            shapes = np.array(BLADE.shape)
            shapes[0, 0] = shape
            model = lobex.Rub(lobex.Modes(BLADE.angular_frequency, np.full(2, ratio), shapes))
            alone = lobex.sweep(model, SPEED, GAIN, METHOD)
            chart = study.chart({"modes.damping_ratio": ratio, "modes.shape[0,0]": shape})
            np.testing.assert_array_equal(chart.multiplier, alone.multiplier)
            np.testing.assert_array_equal(study["chatter_frequency"][i, j], alone.chatter_frequency)
            assert chart.process == alone.process
            assert chart.method == alone.method


def test_arrays_are_labelled(study):
    multiplier = study["multiplier"]
    assert multiplier.dims == ("modes.damping_ratio", "modes.shape[0,0]", "speed", "gain")
    assert multiplier.shape == (3, 2, 9, 6)
    assert multiplier.dtype == np.complex128
    nearest = multiplier.sel({"modes.damping_ratio": 0.02, "modes.shape[0,0]": -30.0, "speed": 500.0, "gain": 8e5})
    assert complex(nearest) == study.chart((1, 1)).multiplier[4, 1]
    assert study["gain"].attrs["units"] == "N/m"
    assert set(study.names) == {"spectral_radius", "multiplier", "chatter_frequency", "error", "status"}
    for part in ("Study by sweep", "3 modes.damping_ratio", "9 speed", "6 gain", "0.01 to 0.05"):
        assert part in repr(study)


def test_the_cutting_force_acts_only_by_its_product_with_the_depth():
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.02, mass=2.573)
    depth = np.linspace(0, 4e-4, 9)
    study = lobex.sweep(lobex.Turning(tool, 2e8), [60.0, 90.0], depth, METHOD, over={"radial": [2e8, 4e8]})
    radius = study["spectral_radius"].to_numpy()
    assert radius[1, :, :5] == pytest.approx(radius[0, :, ::2], rel=1e-9)


def test_a_function_of_numbers_obeys_the_scaling_of_the_modulus():
    # ω ∝ √E: four times the modulus at twice the speed and four times the stiffness is the same motion.
    def blade(numbers):
        return lobex.Rub(lobex.Rod(2, young_modulus=numbers["E"]).modes(numbers["ratio"]))

    over = {"E": [1e9, 4e9], "ratio": [0.02, 0.03]}
    radius = lobex.sweep(blade, [300.0, 600.0], [5e5, 2e6], METHOD, over=over)["spectral_radius"].to_numpy()
    assert radius[1, :, 1, 1] == pytest.approx(radius[0, :, 0, 0], rel=1e-9)
    assert np.all(radius[:, 0, 0, 0] != radius[:, 1, 0, 0])


def test_what_a_process_derives_from_a_number_follows_that_number():
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.02, mass=2.573)
    parts = {"teeth": 4, "tangential": 5.5e8, "normal": 2e8}
    immersions = [0.1, 0.9]
    mill = lobex.Milling(tool, radial_immersion=0.1, **parts)
    study = lobex.sweep(mill, [40.0, 50.0], [1e-4, 1e-3], METHOD, over={"radial_immersion": immersions})
    for immersion in immersions:
        process = lobex.Milling(tool, radial_immersion=immersion, **parts)
        alone = lobex.spectral_radius(process, np.array([[40.0], [50.0]]), [1e-4, 1e-3], METHOD)
        assert study.chart({"radial_immersion": immersion}).spectral_radius == pytest.approx(alone, rel=1e-9)


def test_a_number_is_found_behind_complex_ones_and_within_them():
    model = {"one": {"before": np.array([1 + 2j, 3 + 4j]), "last": np.array([5.0, 6.0])}}
    axes = {"one.last[1]": np.array([6.0, 7.0]), "one.before[1].imag": np.array([4.0, 8.0])}
    varied = Variation(model, axes).at(3)["one"]
    assert varied["before"].tolist() == [1 + 2j, 3 + 8j]
    assert varied["last"].tolist() == [5, 7]


def test_wear_maps_over_casing_and_law(wear):
    arguments, study = wear
    modes, _, _, *others = arguments
    alone = lobex.march_wear(modes, lobex.Casing(amplitude=2e-4), lobex.Linear(4e6), *others, samples_per_revolution=64)
    one = study.at({"casing.amplitude": 2e-4, "law.stiffness": 4e6})
    np.testing.assert_array_equal(one.depth, alone.depth)
    np.testing.assert_array_equal(one.displacement, alone.displacement)
    assert study["depth"].dims == ("casing.amplitude", "law.stiffness", "speed", "angle")
    # The casing before wear differs from one amplitude to the other and not by the law.
    unworn = study["unworn"].to_numpy()
    assert unworn[1] == pytest.approx(2 * unworn[0], rel=1e-12)
    assert np.all(unworn[:, 0] == unworn[:, 1])
    with pytest.raises(ValueError, match="holds no charts"):
        study.chart((0, 0))


def test_limits_over_the_modulus_obey_its_scaling():
    def blade(numbers):
        return lobex.Rub(lobex.Rod(1, young_modulus=numbers["E"]).modes(0.03))

    over = {"E": [1e9, 4e9]}
    study = lobex.critical_gain(blade, [150.0, 300.0], (1e4, 1e7), lobex.Chebyshev(24), scan=65, over=over)
    gain = study["gain"].to_numpy()
    assert gain[1, 1] == pytest.approx(4 * gain[0, 0], rel=1e-8)
    assert study["gain"].dims == ("E", "speed")
    one = study.at({"E": 4e9})
    assert one.status[1] == "found"
    assert one.intervals[1, 0, 1] == pytest.approx(gain[1, 1])


@pytest.mark.slow
def test_more_stable_intervals_than_there_is_room_for_are_told():
    # ẋ = −x + (1 − cos 2aK) x(t − τ) turns where cos 2aK changes its sign.
    def rate(a, t, speed, gain):
        return 1 - jnp.cos(2 * a * gain)

    def equation(numbers):
        return lobex.LinearDelay([[-1.0]], [(jax.tree_util.Partial(rate, numbers["a"]), None)])

    with pytest.warns(lobex.SweepWarning, match="1 of 1 speeds have more than 4 stable intervals, of which the lowest"):
        study = lobex.critical_gain(equation, [0.5], (0.1, 12.7), METHOD, scan=7, over={"a": [0.5, 1.0]})
    assert study.to_xarray().sizes["interval"] == 4
    few, many = study.at(0), study.at(1)
    assert (few.status[0], many.status[0]) == ("found", "more intervals than kept")
    assert few.intervals[0].ravel() == pytest.approx([0.1, *(np.pi / 2 * np.array([1, 3, 5, 7])), 12.7])
    assert many.intervals[0].ravel() == pytest.approx([0.1, *(np.pi / 4 * np.arange(1, 14, 2))])
    assert many.gain == pytest.approx(np.pi / 4)


@pytest.mark.parametrize("name", ["sweep", "march_wear"])
def test_a_study_saves_and_loads(name, study, wear, tmp_path):
    whole = study if name == "sweep" else wear[1]
    whole.save(tmp_path / "study.nc")
    assert [p.name for p in tmp_path.iterdir()] == ["study.nc"]
    again = lobex.load(tmp_path / "study.nc")
    assert isinstance(again, Study)
    assert again.names == whole.names
    for array in whole.names:
        np.testing.assert_array_equal(again[array], whole[array])
        assert again[array].dims == whole[array].dims
    # NaN is no equal of NaN: the time that a chunk took is not kept.
    one, other = (vars(s.at((1, 1))) | {"seconds": 0, "compiling": 0} for s in (again, whole))
    assert_same_fields(_Bag(one), _Bag(other))


def test_the_code_of_the_documentation_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (Path(__file__).parents[1] / "docs" / "cluster.md").read_text()
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        code = compile(block, "cluster.md", "exec")
        # Scripts that start processes, and ask for more packages, are for test_study_processes.py and test_cluster.py.
        if "__main__" not in block:
            exec(code, names)
    assert {p.name for p in tmp_path.iterdir()} == {"damping-2-percent.png", "study.nc", "study"}
    assert names["study"]["multiplier"].shape == (3, 2, 41, 31)
    assert lobex.load("study.nc")["multiplier"].shape == (3, 41, 31)


class _Bag:
    def __init__(self, fields):
        vars(self).update(fields)


def test_blocks_of_speeds_give_what_the_whole_gives(tmp_path, monkeypatch):
    whole = lobex.sweep(RUB, SPEED, GAIN, METHOD)
    monkeypatch.setattr(charts, "_BY_OPERATORS", 4 * len(GAIN))
    chart = lobex.sweep(RUB, SPEED, GAIN, METHOD, store=tmp_path / "s")
    assert len(list((tmp_path / "s").glob("*.nc"))) == 3
    assert chart.multiplier == pytest.approx(whole.multiplier, rel=1e-12)
    assert chart.speed.tolist() == SPEED.tolist()
    assert chart.seconds > 0
    np.testing.assert_array_equal(chart.status, whole.status)
    study = lobex.sweep(RUB, SPEED, GAIN, METHOD, over={"modes.damping_ratio": RATIOS}, store=tmp_path / "t")
    assert study.to_xarray().chunks["speed"] == (3, 3, 3)
    middle = study["multiplier"].isel({"speed": [7, 0, 4], "gain": slice(1, 4)})
    np.testing.assert_array_equal(middle[2], study.chart((2,)).multiplier[[7, 0, 4], 1:4])


def test_a_plain_result_from_a_store_is_the_plain_result(tmp_path):
    speeds = np.linspace(60, 400, 40)
    arguments = (BLADE, lobex.Casing(), lobex.Linear(4.5e6), speeds, 2, 512)
    alone = lobex.march_wear(*arguments)
    stored = lobex.march_wear(*arguments, store=tmp_path / "s")
    np.testing.assert_array_equal(stored.depth, alone.depth)
    assert stored.model == alone.model
    assert stored.lag == alone.lag


def test_only_the_chunks_asked_for_are_read(tmp_path, monkeypatch):
    whole = lobex.sweep(RUB, SPEED, GAIN, METHOD, over=OVER, store=tmp_path / "s")
    expected = whole.chart((2, 1)).multiplier[4]
    asked = []
    read = store.Store.read
    monkeypatch.setattr(store.Store, "read", lambda self, n, names: asked.append(n) or read(self, n, names))
    labelled = Study.open(tmp_path / "s").to_xarray()
    assert asked == [0]
    one = labelled["multiplier"].sel({"modes.damping_ratio": 0.05, "speed": 500.0}).isel({"modes.shape[0,0]": 1})
    assert one.shape == (6,)
    np.testing.assert_array_equal(one.to_numpy(), expected)
    assert asked == [0, 5]


def test_failed_points_are_counted_over_all_chunks():
    def at_most_one(a, t, speed, gain):
        return jnp.where(a > 1, jnp.nan, gain)

    def fails(numbers):
        return lobex.LinearDelay([[-1.0]], [(jax.tree_util.Partial(at_most_one, numbers["a"]), None)])

    # Where the equation has no number a point has none, and a chunk warns.
    with pytest.warns(lobex.SweepWarning, match=r"failed and are NaN.*first of 2 such warnings in 3 chunks"):
        study = lobex.sweep(fails, [0.5, 0.6], [0.1, 0.2], METHOD, over={"a": [1.0, 2.0, 3.0]})
    failed = np.isnan(study["spectral_radius"]).to_numpy()
    assert not failed[0].any()
    assert failed[1:].all()
    assert study.chart((1,)).failed == 4


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"modes.damping": [1.0]}), "it has modes.angular_frequency"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={}), "one or more grids by name"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"modes.damping_ratio": [0.2, 0.1]}), "not strictly increasing"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"modes.damping_ratio": [-0.1, 0.1]}), "damping_ratio = [-0.1"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"modes.damping_ratio": [0.1, np.nan]}), "NaN"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"speed": [1.0]}), "which the result has already"),
        (lambda: lobex.sweep(lambda p: RUB, SPEED, GAIN, over={"error": [1.0]}), "which the result has already"),
        (lambda: lobex.critical_gain(lambda p: RUB, SPEED, (1, 2), over={"edge": [1.0]}), "which the result has alr"),
        (lambda: lobex.sweep(RUB, SPEED, GAIN, over={"a/b": [1.0]}), "without a slash"),
        (lambda: lobex.sweep(lambda p: RUB, SPEED, GAIN), "is no process"),
        (lambda: lobex.sweep(lambda p: 3, SPEED, GAIN, over={"a": [1.0]}), "is no process"),
        (lambda: lobex.sweep(RUB, SPEED[::-1], GAIN, over=OVER), "speed = "),
        (lambda: lobex.sweep(RUB, SPEED, [-1.0, 1.0], over=OVER), "gain = "),
        (
            lambda: lobex.sweep(RUB, SPEED, GAIN, over={"modes.damping_ratio": [0.1], "modes.damping_ratio[1]": [1.0]}),
            "the same number",
        ),
        (lambda: lobex.critical_gain(RUB, [], (0, 1), over=OVER), "speed has shape (0,)"),
        (lambda: lobex.march_wear(BLADE, lobex.Casing(), 3.0, SPEED, over={"casing.radius": [0.5]}), "law"),
    ],
)
def test_bad_axes_are_refused_in_one_line(call, words):
    with refused(words):
        call()


@pytest.mark.parametrize("verb", [lobex.sweep, lobex.critical_gain, lobex.march_wear])
def test_no_axis_is_named_like_an_array_of_any_result_of_its_verb(verb):
    handed_back = inspect.signature(verb).return_annotation
    for kind in typing.get_args(handed_back) or (handed_back,):
        for name in sorted(names_of(kind)):
            with refused(f"over names {name!r}, which the result has already"):
                axes_of({name: [1.0]}, verb.__name__)


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ({"modes.damping_ratio": 0.02}, "give a value of each of"),
        ({"modes.damping_ratio": 0.03, "modes.shape[0,0]": -30.0}, "the nearest is"),
        ((5, 0), "is no index"),
        (0, "is no index"),
    ],
)
def test_a_combination_that_is_not_there_is_refused(study, where, words):
    with pytest.raises(ValueError, match=words):
        study.at(where)
    with pytest.raises(ValueError, match="is no array of this study"):
        study["pressure"]


def test_tracing_passes_through_to_the_verb():
    traced = jax.eval_shape(lambda f: lobex.critical_gain(RUB, f, (1e5, 4e6), METHOD, scan=9).gain, 500.0)
    assert traced.shape == (1,)
    with pytest.raises(ValueError, match="traced"):
        jax.eval_shape(lambda f: lobex.sweep(RUB, f, GAIN, METHOD, over=OVER)["error"], SPEED)
    with pytest.raises(ValueError, match="traced"):
        jax.eval_shape(lambda f: lobex.critical_gain(RUB, f, (1e5, 4e6), METHOD, over=OVER)["gain"], SPEED)


@given(
    lengths=st.lists(st.integers(1, 5), max_size=3),
    lanes=st.integers(1, 200),
    wanted=st.integers(1, 300),
)
def test_chunks_cover_every_lane_of_every_combination_once(lengths, lanes, wanted):
    axes = {f"a{i}": np.arange(n, dtype=float) for i, n in enumerate(lengths)}
    made = plan_of(axes, lanes, wanted, 8)
    assert made.lanes_per_chunk <= wanted
    count = np.zeros((made.combinations, lanes), dtype=int)
    for number in range(made.chunks):
        combination, part = made.chunk(number)
        count[combination, part] += 1
    assert made.combinations == np.prod(lengths, dtype=int)
    assert np.all(count == 1)


def test_less_memory_makes_smaller_chunks(monkeypatch):
    monkeypatch.setattr(plan, "available_memory", lambda: 8 * 10 * 1000)
    assert plan_of({}, 100, 64, 1000).lanes_per_chunk == 10
    assert plan_of({}, 100, 64, 10**9) == Plan({}, 100, 1)


def test_memory_is_what_the_tightest_limit_leaves(tmp_path, monkeypatch):
    assert 0 < memory.available_memory() < 1e15
    (tmp_path / "self").mkdir()
    (tmp_path / "meminfo").write_text("MemTotal: 9000 kB\nMemAvailable: 5000 kB\n")
    (tmp_path / "self/cgroup").write_text("0::/job/step\n")
    (tmp_path / "job/step").mkdir(parents=True)
    (tmp_path / "job/memory.max").write_text("3000000\n")
    (tmp_path / "job/memory.current").write_text("1000000\n")
    (tmp_path / "job/step/memory.max").write_text("max\n")
    (tmp_path / "job/step/memory.current").write_text("900000\n")
    monkeypatch.setattr(memory, "_PROC", tmp_path)
    monkeypatch.setattr(memory, "_GROUPS", tmp_path / "none")
    assert memory.available_memory() == 5000 * 1024
    monkeypatch.setattr(memory, "_GROUPS", tmp_path)
    assert memory.available_memory() == 2000000
