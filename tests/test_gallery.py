"""The thesis' figures: each is drawn, saved and held against the numbers that its claims come to."""

import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray

import lobex
import lobex.gallery
from commands import run
from lobex.gallery.numbers import save_numbers
from lobex.gallery.registry import NAMES, figure, figures
from lobex.shell.reproduce_arguments import Reproduce

# Shares of the full grids that are fine enough for the numbers below.
SHARES = {
    "fig-1.2": 0.25,
    "fig-1.3": 0.5,
    "fig-3.2": 0.08,
    "fig-4.1": 0.1,
    "fig-4.2": 0.5,
    "fig-4.3": 0.15,
    "fig-4.4": 0.5,
    "fig-4.5": 0.5,
    "fig-4.6": 0.1,
    "fig-4.7": 0.25,
    "fig-4.8": 0.1,
    "fig-4.9": 0.25,
    "fig-4.10": 0.1,
    "fig-4.11": 0.5,
    "fig-4.12": 0.2,
}
# How many of a figure's claims do not hold: what the thesis got wrong, printed wrongly or left open.
DIFFERING = {
    **{"fig-3.1": 2, "fig-3.2": 1, "fig-4.3": 2, "fig-4.4": 2},
    **{"fig-4.7": 1, "fig-4.11": 2, "fig-4.12": 1},
}


@pytest.fixture
def shown(tmp_path):
    """Compute a figure, draw and save it, answer its claims, and return the numbers and what it computed.

    One test does it all for a figure, so that several workers share no figure.
    """

    def show(name):
        one = figure(name)
        results = one.compute(SHARES.get(name, 1.0))
        with warnings.catch_warnings():
            # A layout that has no room, and a character that the font lacks.
            warnings.simplefilter("error")
            drawn = one.draw(results)
            drawn.canvas.draw()
        assert_within_edges(drawn)
        assert_read_back(one, results, tmp_path)
        findings = one.findings(results)
        assert sum(not finding.agrees for finding in findings) == DIFFERING.get(name, 0)
        for finding in findings:
            assert all((finding.claim, finding.thesis, finding.ours, finding.numbers))
            assert "nan" not in finding.ours
            assert np.isfinite(list(finding.numbers.values())).all()
            assert finding.agrees or finding.why
        return {key: value for finding in findings for key, value in finding.numbers.items()}, results

    return show


def assert_within_edges(drawn):
    """Nothing is clipped at the figure's edges, and every panel says what it shows."""
    box, (width, height) = drawn.get_tightbbox(), drawn.get_size_inches()
    assert min(box.x0, box.y0) > -0.02
    assert box.x1 < width + 0.02
    assert box.y1 < height + 0.02
    for ax in drawn.axes:
        assert ax.get_xlabel() or ax.get_ylabel() or ax.name == "polar" or not ax.axison


def assert_read_back(one, results, folder):
    """The file holds what was computed, to the bit."""
    path = folder / f"{one.name}.nc"
    save_numbers(one, results, path)
    assert not list(folder.glob(".*"))
    assert xarray.load_dataset(path, engine="h5netcdf").attrs["title"] == one.title
    for group, result in results.items():
        expected = result if isinstance(result, xarray.Dataset) else result.to_xarray()
        stored = xarray.load_dataset(path, engine="h5netcdf", group=None if len(results) == 1 else group)
        for variable, values in expected.variables.items():
            if np.iscomplexobj(values):
                whole = stored[f"{variable}_real"] + 1j * stored[f"{variable}_imag"]
                np.testing.assert_array_equal(whole, values)
            else:
                np.testing.assert_array_equal(stored[variable], values)


def test_every_figure_has_its_module_and_every_module_its_figure():
    folder = Path(lobex.gallery.__file__).parent
    modules = {path.stem for path in folder.glob("fig_*.py")}
    assert modules == {name.replace("-", "_").replace(".", "_") for name in NAMES}
    assert [f.name for f in figures()] == list(NAMES)
    assert len({f.title for f in figures()}) == len(NAMES) == 20


def test_figures_are_chosen_once_and_in_order():
    assert [f.name for f in figures(("fig-4.9", "fig-1.2", "fig-4.9"))] == ["fig-4.9", "fig-1.2"]


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    one = figure("fig-1.2")
    with pytest.raises(ValueError, match="cannot be written") as error:
        save_numbers(one, one.compute(0.1), tmp_path / "no" / "fig.nc")
    assert "\n" not in str(error.value)


def test_the_casing_comes_inwards_twice(shown):
    told, _ = shown("fig-1.2")
    assert told["perimeter"] == pytest.approx(np.pi)
    assert (told["harmonic"], told["clearance"]) == (2, 0)
    assert told["height"] == pytest.approx(1e-4)


def test_wear_peaks_lie_about_a_tenth_above_the_critical_speeds(shown):
    told, _ = shown("fig-1.3")
    assert [told[f"peak{k}"] for k in (6, 4, 2)] == pytest.approx([62, 92, 186], abs=1.5)
    assert [told[f"ratio{k}"] for k in (6, 4, 2)] == pytest.approx([1.1] * 3, abs=0.03)
    assert told["beyond"] < 0.2 < 0.5 < told["smallest_peak"]
    assert told["third"] == pytest.approx(1.1 * told["f1"] / 3, rel=0.02)
    assert [told[f"f{i}"] for i in range(1, 6)] == pytest.approx([338, 1015, 1694, 2378, 3069], abs=0.5)


def test_the_spectrum_peaks_where_an_even_order_meets_the_stiffened_mode(shown):
    told, _ = shown("fig-1.4")
    for k in (2, 4, 6):
        assert told[f"order{k}"] == pytest.approx(k, abs=0.2)
        assert 1.03 < told[f"shift{k}"] < 1.1
        assert told[f"peak{k}"] == pytest.approx({2: 187, 4: 92, 6: 61}[k], rel=0.02)


def test_turning_grows_as_its_multipliers_say_until_it_leaves_the_cut(shown):
    told, _ = shown("fig-2.5")
    assert told["stable"] < 1 < told["unstable"]
    assert told["error"] < 1e-4
    assert told["apart"] < 0.05
    assert 0.3 < told["out_of_cut"] < 0.7


def test_the_least_depth_is_the_closed_form(shown):
    told, _ = shown("fig-2.6")
    assert told["least"] == pytest.approx(told["closed_form"], rel=1e-12)
    assert told["share"] == 1
    assert told["worst"] < 1e-7


def test_the_matrix_as_printed_does_not_differentiate(shown):
    told, _ = shown("fig-3.1")
    assert told["corrected"] < 1e-11
    assert told["as_printed"] > 10
    assert told["apart"] < 1e-15
    assert told["gap"] == pytest.approx(np.tan(np.pi / 32), rel=1e-12)


def test_one_interval_over_the_jump_errs_more_than_semi_discretization(shown):
    # The range that the design gives for 40 nodes and 40 steps.
    told, _ = shown("fig-3.2")
    assert 1e-3 < told["chebyshev"] < 3e-2
    assert 1e-6 < told["semi_discretization"] < 2e-3
    assert told["ratio"] > 20
    assert told["verdict_semi_discretization"] > 0.99 > told["verdict_chebyshev"] > 0.9


def test_forty_nodes_are_enough_and_twenty_are_not(shown):
    told, results = shown("fig-4.1")
    assert told["40_against_60"] < 1e-6
    assert told["below_80_Hz"] > 0.5
    assert told["above_80_Hz"] < 0.02
    # Read from a grid of gains 21 % apart, against the closed form.
    read = results["nodes"]["critical_stiffness"].to_numpy()[2]
    exact = results["exact"]["critical_stiffness"].to_numpy()[0]
    assert read == pytest.approx(exact, rel=0.02)


def test_ten_elements_are_converged_and_five_are_good_to_four_percent(shown):
    told, _ = shown("fig-4.2")
    assert told["median10"] == pytest.approx(0.0074, abs=0.001)
    assert told["median5"] == pytest.approx(0.036, abs=0.004)
    assert told["median2"] == pytest.approx(0.21, abs=0.02)
    # Frequencies of a rod of n linear elements in closed form, clamped at one end.
    wave = [n * np.sqrt((1 - np.cos(np.pi / 2 / n)) / (2 + np.cos(np.pi / 2 / n))) for n in (5, 20)]
    assert told["frequency_ratio"] == pytest.approx(wave[0] / wave[1], rel=1e-10)


def test_the_stable_domain_grows_above_the_first_lobe_and_not_below(shown):
    told, _ = shown("fig-4.3")
    assert told["least"] == pytest.approx(327334.77, rel=1e-6)
    assert [told[f"least{i}"] / 1e6 for i in range(4)] == pytest.approx([0.327, 2.07, 3.15, 9.21], rel=0.01)
    assert told["chatter_ratio"] == pytest.approx(np.sqrt(1.06), rel=1e-3)
    assert told["first_lobe_ratio"] == pytest.approx(1.355, abs=0.005)
    assert 0.1 < told["share"] < 0.15


def test_mode_1_drives_the_lobes_feet_and_misses_their_sides(shown):
    told, _ = shown("fig-4.4")
    assert told["driven"] == 1
    assert told["least_ratio"] == pytest.approx(0.970, abs=0.001)
    assert told["within_1"] < 0.02
    assert told["within_10"] == pytest.approx(0.65, abs=0.02)
    assert told["ratio"] == pytest.approx(8.17, abs=0.01)
    assert told["overestimate"] > 2


def test_modes_converge_from_below(shown):
    told, results = shown("fig-4.5")
    assert told["median5"] == pytest.approx(0.012, abs=0.002)
    assert told["median5"] < told["median2"] / 2 < told["median1"] / 3
    # Modes that are left out are springs in series: without them the least limit is lower.
    least = results["modes"]["critical_stiffness"].min("speed").to_numpy()
    assert np.all(np.diff(least) > 0)


def test_stiffness_scales_the_limit_by_alpha_and_the_speed_by_its_root(shown):
    told = shown("fig-4.6")[0] | shown("fig-4.7")[0]
    assert told["power"] == pytest.approx(0.5, abs=1e-9)
    assert told["apart"] < 1e-10
    assert told["up"] == pytest.approx(3, rel=1e-11)
    assert told["right"] == pytest.approx(np.sqrt(3), rel=1e-9)


def test_mass_moves_the_lobes_and_leaves_their_size(shown):
    told = shown("fig-4.8")[0] | shown("fig-4.9")[0]
    assert told["power"] == pytest.approx(-0.5, abs=1e-9)
    assert told["apart"] < 1e-10
    assert told["up"] == pytest.approx(1, rel=1e-11)
    assert told["left"] == pytest.approx(1 / np.sqrt(3), rel=1e-9)


def test_damping_lifts_the_minimum_in_closed_form_and_without_it_most_speeds_have_no_limit(shown):
    told, results = shown("fig-4.10")
    assert told["apart"] < 1e-12
    assert 1 <= told["least_over"] < told["most_over"] < 1.06
    # To first order in K_e mode n gains energy where sin(ω_n τ) < 0.
    speed = results["damping_ratio"]["speed"].to_numpy()
    omega = np.asarray(lobex.Rod(5).modes().angular_frequency)
    gains = np.any(np.sin(omega / speed[:, None]) < 0, axis=1)
    undamped = results["damping_ratio"]["critical_stiffness"].to_numpy()[0]
    np.testing.assert_array_equal(undamped == 0, gains)
    assert told["undamped"] == np.mean(gains)


def test_damping_shifts_lobes_by_less_than_the_chatter_frequency(shown):
    told, _ = shown("fig-4.11")
    assert told["bound"] == pytest.approx(np.sqrt(1.08 / 1.03) - 1, rel=1e-12)
    assert told["chatter_shift"] == pytest.approx(told["bound"], rel=1e-3)
    assert 0 < told["least_shift"] < told["largest_shift"] < told["bound"]
    assert told["up"] == pytest.approx(told["closed_form"], rel=0.03)
    assert told["others_low"] > 0.1 > told["others_high"] == 0


def test_the_four_points_by_another_method(shown):
    told, results = shown("fig-4.12")
    points = results["points"]
    operator = lobex.spectral_radius(lobex.Rub(lobex.Rod(5).modes()), points.speed[:, None], points.gain)
    assert points.spectral_radius == pytest.approx(operator, rel=1e-6)
    assert max(told["stable_85"], told["stable_112"], told["caption_85"], told["caption_112"]) < 0.8
    assert told["unstable_85"] == pytest.approx(1.5194, abs=1e-4)
    assert told["unstable_112"] == pytest.approx(1.20569362, abs=1e-6)
    assert told["ratio_112"] == pytest.approx(1.19, abs=0.01)


def test_responses_grow_as_the_multipliers_say(shown):
    told, _ = shown("fig-4.13")
    assert told["error"] < 1e-3
    assert told["growth_85"] > 5 * told["growth_112"] > 5


def test_the_shell_writes_pictures_numbers_and_findings(tmp_path):
    done = run("reproduce", "fig-3.1", "fig-1.2", "--pdf", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    endings = ("nc", "pdf", "png")
    assert sorted(p.name for p in (tmp_path / "figures").iterdir()) == sorted(
        f"{name}.{ending}" for name in ("fig-3.1", "fig-1.2") for ending in endings
    )
    assert min(plt.imread(tmp_path / "figures" / "fig-3.1.png").shape[:2]) > 500
    assert (tmp_path / "figures" / "fig-3.1.pdf").read_bytes().startswith(b"%PDF")
    for part in ("fig-3.1  Chebyshev points", "differs", "agrees", "thesis: x_j", "2 figures in figures"):
        assert part in done.stdout
    assert "fig-1.2" in done.stderr


def test_the_shell_lists_the_figures_and_writes_nothing(tmp_path, shell):
    done = shell("reproduce", "--list")
    assert done.code == 0, done.err
    assert [line.split()[0] for line in done.out.splitlines()] == list(NAMES)
    assert list(tmp_path.iterdir()) == []


def test_quiet_is_quiet(tmp_path):
    done = run("reproduce", "fig-1.2", "--quiet", "--out", "here", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert sorted(p.name for p in (tmp_path / "here").iterdir()) == ["fig-1.2.nc", "fig-1.2.png"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("fig-4.33",), "did you mean fig-4.3?"),
        (("wobble",), "lobex reproduce --list"),
        (("--out", ""), "out = ''"),
        (("fig-1.2", "--out", "no/such/folder"), "cannot be made"),
        (("fig-1.2", "--out", "/dev/null"), "is not a folder"),
        (("fig-1.2", "--wobble"), "--wobble"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, shell):
    assert words in shell.refuses("reproduce", *arguments)


def test_an_interrupt_tells_what_is_done(monkeypatch, tmp_path):
    import lobex.shell.reproduce_command as shell

    def make(chosen, files):
        if chosen.name == "fig-4.3":
            raise KeyboardInterrupt
        return []

    monkeypatch.setattr(shell, "_make", make)
    monkeypatch.setattr("lobex.shell.environment.prepare_jax", lambda: None)
    with pytest.raises(KeyboardInterrupt, match="1 of 3 figures are in"):
        shell.run_reproduce(Reproduce(("fig-1.2", "fig-4.3", "fig-4.4"), out=str(tmp_path / "f"), quiet=True))
