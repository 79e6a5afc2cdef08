"""The command line, run as a user runs it."""

import os
import subprocess
import sys

import jax
import matplotlib.pyplot as plt
import numpy as np
import pytest
import scipy.linalg

import lobex
from commands import run
from lobex.shell import environment
from lobex.shell.arguments import Lobes
from lobex.shell.from_flags import process_of
from lobex.shell.limit_arguments import Limit
from lobex.shell.parser import parse
from lobex.shell.values import in_metres, parse_grid, parse_values

SMALL = {
    "rub": ("--speed", "60:400:5", "--gain", "4.5e4:4.5e6:7", "--elements", "3", "--keep", "1", "2"),
    "milling": ("--rpm", "5000:25000:4", "--gain", "0:5e-3:6", "--teeth", "2", "--directions", "2", "--nodes", "20"),
    "turning": ("--rpm", "4000:9000:4", "--gain", "0:4e-4:5", "--method", "sdm", "--steps", "30", "--order", "1"),
    "mathieu": ("--speed", "0.1:0.3:4", "--gain", "-1:1:5", "--delta", "2", "--nodes", "24"),
}


@pytest.mark.parametrize("name", SMALL)
def test_each_process_writes_its_file_picture_and_summary(name, shell, tmp_path):
    done = shell("lobes", name, *SMALL[name], "--out", "here")
    assert done.code == 0, done.err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["here.nc", "here.png"]
    chart = lobex.load(tmp_path / "here.nc")
    assert np.isfinite(chart.spectral_radius).all()
    assert min(plt.imread(tmp_path / "here.png").shape[:2]) > 500
    # A gain of two signs begins nowhere.
    for part in ("speeds ×", "method", "wall time", "stable" if name == "mathieu" else "smallest limit", "here.nc"):
        assert part in done.out
    assert ("limit" in done.out) == (name != "mathieu")


def test_limit_writes_its_file_table_and_picture(tmp_path):
    arguments = ("--speed", "120:400:6", "--gain", "1e5:2e6:9", "--elements", "2", "--nodes", "30", "--refine", "5")
    done = run("limit", "rub", *arguments, "--out", "k", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["k.csv", "k.nc", "k.png"]
    limit = lobex.load(tmp_path / "k.nc")
    assert len(limit.speed) == 11
    assert np.all(np.isin(np.linspace(120, 400, 6), limit.speed))
    found = np.isfinite(limit.gain)
    assert found.sum() >= 3
    process = lobex.Rub(lobex.Rod(2).modes(0.03))
    radius = lobex.spectral_radius(process, limit.speed[found], limit.gain[found], lobex.Chebyshev(30))
    assert radius == pytest.approx(1, abs=1e-9)
    header, *rows = (tmp_path / "k.csv").read_text().splitlines()
    assert header.split(",")[:3] == ["speed_Hz", "gain_N/m", "chatter_frequency_Hz"]
    table = np.array([[float(cell) for cell in row.split(",")[:3]] for row in rows])
    assert table[:, 1] == pytest.approx(limit.gain, rel=1e-11, nan_ok=True)
    assert "smallest limit" in done.stdout


def test_exact_limit_in_the_shell(shell, tmp_path):
    done = shell("limit", "rub", "--speed", "60:400:35", "--exact")
    assert done.code == 0, done.err
    limit = lobex.load(tmp_path / "rub-limit.nc")
    assert limit.gain == pytest.approx(lobex.exact_limit(lobex.Rub(lobex.Rod(5).modes()), limit.speed).gain, rel=1e-13)
    assert min(plt.imread(tmp_path / "rub-limit.png").shape[:2]) > 500


def test_sensitivities_of_the_exact_limit_in_the_shell(shell, tmp_path):
    done = shell("limit", "rub", "--speed", "60:400:35", "--exact", "--sensitivity", "--out", "s")
    assert done.code == 0, done.err
    names = sorted(p.name for p in tmp_path.iterdir())
    assert names == ["s-sensitivity.csv", "s-sensitivity.png", "s.csv", "s.nc", "s.png"]
    header, *rows = (tmp_path / "s-sensitivity.csv").read_text().splitlines()
    columns = header.split(",")
    numbers = ["area", "damping_ratio", "density", "length", "young_modulus", "speed"]
    assert columns == ["speed_Hz", "gain_N/m", *(f"dlnK_dln_{name}" for name in numbers)]
    table = dict(zip(columns, np.array([row.split(",") for row in rows], dtype=float).T, strict=True))
    # K(αK; f) = α K(K; f/√α); stiffness and mass are proportional to the area.
    by_speed = table["dlnK_dln_speed"]
    assert table["dlnK_dln_young_modulus"] == pytest.approx(1 - by_speed / 2, rel=1e-6, abs=1e-6)
    assert table["dlnK_dln_area"] == pytest.approx(1, rel=1e-8)
    assert min(plt.imread(tmp_path / "s-sensitivity.png").shape[:2]) > 500
    assert "young_modulus" in done.out
    assert lobex.load(tmp_path / "s.nc").limit.gain == pytest.approx(table["gain_N/m"], rel=1e-11)


def test_sensitivities_of_a_search_in_the_shell(shell, tmp_path):
    arguments = ("--rpm", "8500:8700:3", "--gain", "0:2e-3:9", "--teeth", "2", "--radial-immersion", "0.1")
    done = shell("limit", "milling", *arguments, "--nodes", "20", "--sensitivity", "--quiet")
    assert done.code == 0, done.err
    assert done.out == ""
    header, *rows = (tmp_path / "milling-limit-sensitivity.csv").read_text().splitlines()
    table = dict(zip(header.split(","), np.array([row.split(",") for row in rows], dtype=float).T, strict=True))
    found = np.isfinite(table["gain_m"])
    assert found.any()
    forces = table["dlnK_dln_tangential"] + table["dlnK_dln_normal"]
    assert forces[found] == pytest.approx(-1, rel=1e-6)
    assert np.isfinite(table["dlnK_dln_radial_immersion"][found]).all()
    # ω ∝ f_n, φ² ∝ 1/m: at fixed damping b(m) ∝ m.
    assert table["dlnK_dln_tool.mass"][found] == pytest.approx(1, rel=1e-6)


def process_for(line):
    """The process that the words of a command describe."""
    return process_of(parse({"lobes": Lobes, "limit": Limit}, line.split()).process)


TOOL = "--frequency 146.5,920 --damping-ratio .0032,.01 --mass 2.573,5"


@pytest.mark.parametrize("command", ["lobes turning", "limit turning", "lobes milling --directions 1"])
def test_several_modes_of_a_tool_are_lists(command):
    modes = process_for(f"{command} {TOOL}").modes
    np.testing.assert_allclose(modes.frequency, [146.5, 920], rtol=1e-15)
    np.testing.assert_array_equal(modes.damping_ratio, [0.0032, 0.01])
    np.testing.assert_allclose(modes.shape, [[2.573**-0.5], [5**-0.5]], rtol=1e-15)


def test_modes_across_the_feed_are_those_along_it_but_for_what_is_said():
    across = "--frequency-y 200,300,400 --damping-ratio-y .02 --mass-y 3"
    modes = process_for(f"lobes milling --directions 2 {TOOL} {across}").modes
    np.testing.assert_allclose(modes.frequency, [146.5, 920, 200, 300, 400], rtol=1e-15)
    np.testing.assert_array_equal(modes.damping_ratio, [0.0032, 0.01, 0.02, 0.02, 0.02])
    x, y = np.array([2.573, 5]) ** -0.5, np.full(3, 3**-0.5)
    np.testing.assert_allclose(modes.shape, scipy.linalg.block_diag(x[:, None], y[:, None]), rtol=1e-15)
    softer = process_for("lobes milling --directions 2 --frequency-y 120").modes
    np.testing.assert_allclose(softer.frequency, [146.5, 120], rtol=1e-15)
    np.testing.assert_array_equal(softer.shape[0, 0], softer.shape[1, 1])


@pytest.mark.parametrize("text", ["5000:7000:3", "5000,6000,7000"])
def test_ranges_and_lists_are_the_same_grid(text):
    np.testing.assert_array_equal(parse_grid("rpm", text, "rpm"), [5000, 6000, 7000])
    np.testing.assert_array_equal(parse_values("rpm", text, "rpm"), [5000, 6000, 7000])


@pytest.mark.parametrize("text", ["1e-4:6e-3:3", "0.1:6mm:3", "0.1mm:6 mm:3", "100um:6mm:3", "0.1mm,3.05mm,6mm"])
def test_depths_have_units_of_which_one_is_that_of_all(text):
    assert parse_grid("gain", in_metres("gain", text), "") == pytest.approx([1e-4, 3.05e-3, 6e-3], rel=1e-15)


def test_a_turning_march_with_a_feed_takes_the_force_of_its_file(shell, tmp_path):
    modes = '[[modes]]\naxis = "x"\nfrequency = 146.5\ndamping_ratio = 0.03\nmass = 2.573\n'
    (tmp_path / "bar.toml").write_text(f"{modes}[force]\ntangential = 2e9\nnormal = 1.5e9\n")
    points = ("--rpm", "5000", "--gain", "0.1mm", "--periods", "2", "--steps", "128", "--quiet")
    assert shell("march", "turning", "--tool", "bar.toml", "--feed", "0.1mm", *points).code == 0
    mode = lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2.573)
    wanted = lobex.simulate_turning(mode, lobex.Linear(1.5e9), 5000 / 60, 1e-4, 1e-4, 2, 128)
    found = lobex.load(tmp_path / "turning-march.nc")
    np.testing.assert_allclose(found.displacement[0], wanted.displacement, rtol=1e-12)


def test_one_value_will_do():
    np.testing.assert_array_equal(parse_grid("rpm", "6000", "rpm"), [6000])


def test_the_shell_computes_what_the_library_computes(shell, tmp_path):
    arguments = ("--rpm", "6000:8000:3", "--gain", "1e-3:3e-3:3", "--teeth", "1", "--radial-immersion", "0.5")
    done = shell("lobes", "milling", *arguments, "--direction", "down", "--nodes", "32", "--quiet")
    assert done.code == 0, done.err
    assert done.out == ""
    assert done.err == ""
    tool = lobex.Modes.single(frequency=146.5, damping_ratio=0.0032, mass=2.573)
    process = lobex.Milling(tool, teeth=1, tangential=5.5e8, normal=2e8, radial_immersion=0.5)
    speeds = np.linspace(6000, 8000, 3)[:, None] / 60
    exact = lobex.spectral_radius(process, speeds, np.linspace(1e-3, 3e-3, 3), lobex.Chebyshev(32))
    assert lobex.load(tmp_path / "milling.nc").spectral_radius == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("lobes", "rub", "--speed", "50:nan:10"), "speed = "),
        (("lobes", "rub", "--speed", "0:50:10"), "speed = [0, "),
        (("lobes", "rub", "--speed", "-5:50:10"), "speed = [-5, "),
        (("lobes", "rub", "--speed", "50:90"), "speed = '50:90'"),
        (("lobes", "rub", "--speed", "90,50"), "not strictly increasing"),
        (("limit", "rub", "--gain", "1e5"), "the scan takes three or more"),
        (("lobes", "turning", "--mass", "1,2"), "mass has 2 values for 1 natural frequencies"),
        (("lobes", "milling", "--mass-y", "2"), "give --directions 2 or drop mass_y"),
        (("march", "rub", "--speed", "50:90:9"), "18 points; give at most 6"),
        (("march", "rub", "--speed", "1e-12"), "speed = 1e-12 Hz leaves rate"),
        (("lobes", "rub", "--speed", "90:50:10"), "not strictly increasing"),
        (("lobes", "rub", "--speed", "50:90:2.5"), "speed = '50:90:2.5'"),
        (("lobes", "rub", "--gain", "-1:5:10"), "gain = [-1, "),
        (("lobes", "rub", "--speed", "50:90:1000000000"), "at most 1000000"),
        (("lobes", "rub", "--out", ""), "out = ''"),
        (("lobes", "rub", "--elements", "abc"), "--elements"),
        (("lobes", "rub", "--elements", "0"), "elements = 0"),
        (("lobes", "rub", "--damping-ratio", "-0.1"), "damping_ratio = -0.1"),
        (("lobes", "rub", "--keep", "9"), "mode 9 of 5"),
        (("lobes", "rub", "--nodes", "1"), "nodes = 1"),
        (("lobes", "rub", "--steps", "9"), "steps = 9"),
        (("lobes", "rub", "--method", "euler"), "method = 'euler'"),
        (("lobes", "rub", "--wobble", "9"), "--wobble"),
        (("lobes", "rub", "--out", "no/such/folder/rub"), "out = "),
        (("lobes", "rub", "--out", "/proc/rub"), "cannot be written"),
        (("lobes", "milling", "--teeth", "0"), "teeth = 0"),
        (("lobes", "milling", "--radial-immersion", "1.5"), "radial_immersion = 1.5"),
        (("lobes", "milling", "--direction", "sideways"), "direction = 'sideways'"),
        (("lobes", "milling", "--directions", "3"), "directions = 3"),
        (("lobes", "milling", "--rpm", "6e5:8e5:9"), "rpm/60"),
        (("lobes", "turning", "--radial", "0"), "radial = 0"),
        (("limit", "rub", "--gain", "5:1:10"), "gain = [5, "),
        (("limit", "milling", "--out", "no/such/x"), "out = "),
        (("limit", "rub", "--sensitivity", "--exact", "--damping-ratio", "-0.1"), "damping_ratio = -0.1"),
        (("limit", "mathieu"), "mathieu"),
        (("lobes",), "rub"),
        (("wobble",), "wobble"),
        (("orbit",), "milling"),
        (("orbit", "turning"), "turning"),
        (("lobes", "milling", "--gain", "0:5ft:3"), "gain = '5ft' is no length"),
        (("recommend", "milling", "--gain", "6mm"), "gain = '6mm' is not low:high"),
        (("orbit", "milling", "--feed", "0"), "feed_per_tooth = 0"),
        (("orbit", "milling", "--feed", "0.1 parsec"), "feed = '0.1 parsec' is no length"),
        (("orbit", "milling", "--rpm", "5e3:6e3:9"), "9 points; give at most 6"),
        (("recommend", "milling", "--rpm", "5000"), "rpm = '5000' is not low:high"),
        (("recommend", "milling", "--rpm", "6000:5000", "--diameter", "10mm"), "speed = "),
        (("recommend", "milling", "--power", "-1", "--diameter", "10mm"), "power = -1"),
        (("recommend", "milling"), "diameter = None where a removal rate is asked for"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(shell, arguments, words):
    assert words in shell.refuses(*arguments)


def test_bad_input_in_a_process_of_its_own(tmp_path):
    done = run("lobes", "rub", "--speed", "50:nan:10", cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert done.stderr.startswith("lobex: error: speed = ")


IMPORTING = """
import os, sys
class Watch:
    def find_spec(self, name, *rest):
        if name == "numpy":
            print(os.environ.get("OPENBLAS_NUM_THREADS"))
sys.meta_path.insert(0, Watch())
sys.argv = ["lobex", "lobes", "rub", "--gain", "x"]
from lobex.shell.main import main
main()
"""


def test_numpy_is_told_of_its_thread_before_it_is_imported():
    # Beside busy cores small eigenvalue problems took seventy times as long with two.
    told = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run([sys.executable, "-c", IMPORTING], capture_output=True, text=True, env=told, timeout=60)
    assert done.stdout == "1\n", done.stderr


@pytest.mark.parametrize("arguments", [(), ("--help",), ("lobes", "--help")])
def test_help_names_the_commands(shell, arguments):
    assert shell(*arguments).code == 0
    assert "lobes" in shell.out


def test_version(shell):
    assert shell("--version").code == 0
    assert shell.out == f"lobex {lobex.__version__}\n"


def test_a_closed_pipe_is_no_error():
    command = f"{sys.executable} -m lobex.shell.main lobes --help | head -1"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("usage: lobex lobes")
    assert done.stderr == ""


@pytest.mark.parametrize("name", SMALL)
def test_each_help_has_an_example_and_units(shell, name):
    assert shell("lobes", name, "--help").code == 0
    for words in (f"Example: lobex lobes {name}", "--gain", "default:"):
        assert words in shell.out


def test_warnings_are_one_line(tmp_path):
    done = run("lobes", "rub", "--speed", "8:9:2", "--gain", "1e5:2e5:2", "--nodes", "40", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr.count("lobex: warning: at speed = 8 Hz") == 1
    assert "Traceback" not in done.stderr


# What every command does before it computes, and one program.
PROGRAM = """
from lobex.shell.environment import prepare_jax

prepare_jax()
import jax
import jax.numpy as jnp

hits = []
jax.monitoring.register_event_listener(lambda name, **_: hits.append(name.endswith("/cache_hits")))
print(jax.jit(lambda x: jnp.linalg.solve(x @ x.T + jnp.eye(3), x).sum())(jnp.ones((3, 3))), sum(hits))
"""


def compute():
    """Run that program in a process of its own: its number, and how many programs were there already."""
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    number, hits = done.stdout.split()
    return float(number), int(hits)


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """The programs kept in a cache folder of the test's own, without the settings that the tests make for theirs."""
    for name in ("JAX_COMPILATION_CACHE_DIR", "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "TF_CPP_MIN_LOG_LEVEL"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return lambda: sorted((tmp_path / "lobex").rglob("*-cache"))


@pytest.mark.slow
def test_programs_are_kept_for_the_next_run_which_finds_them_in_silence(kept):
    number, hits = compute()
    files = kept()
    assert hits == 0
    assert len(files) > 0
    assert jax.__version__ in files[0].parent.name
    assert compute() == (number, len(files))
    assert kept() == files


def test_programs_that_another_process_is_still_writing_are_compiled_in_silence(kept):
    number, _ = compute()
    for path in kept():
        path.write_bytes(path.read_bytes()[:-40])
    assert compute()[0] == number


def test_no_programs_are_kept_where_that_is_switched_off(kept, monkeypatch):
    monkeypatch.setenv("JAX_ENABLE_COMPILATION_CACHE", "false")
    assert compute()[1] == 0
    assert kept() == []


def test_the_cache_is_one_for_each_kind_of_processor(tmp_path, monkeypatch):
    folders = []
    monkeypatch.setattr(environment, "_PROCESSORS", tmp_path / "cpuinfo")
    for name, flags, clock in (("A", "avx avx2", 1), ("A", "avx", 1), ("B", "avx", 1), ("B", "avx", 2)):
        (tmp_path / "cpuinfo").write_text(f"model name: {name}\ncpu MHz: {clock}\nflags: {flags}\n\nmodel name: C\n")
        folders.append(environment.cache_folder())
    assert len(set(folders)) == 3
    assert folders[2] == folders[3]


@pytest.mark.search
def test_orbit_and_recommend_write_what_python_finds(shell, tmp_path):
    tool = ("--frequency", "900", "--damping-ratio", "0.02", "--mass", "0.2")
    flags = ("milling", "--teeth", "2", "--diameter", "20mm", "--directions", "2", *tool, "--quiet")
    assert shell("orbit", *flags, "--rpm", "12000", "--gain", "2e-4").code == 0
    assert shell("recommend", *flags, "--rpm", "9000:15000", "--gain", "5e-5:1e-3", "--power", "300").code == 0
    names = [f"milling-{name}" for name in ("orbit", "recommendation")]
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.{kind}" for name in names for kind in ("nc", "png")}
    mode = lobex.Modes.single(frequency=900, damping_ratio=0.02, mass=0.2)
    cutter = lobex.Cutter.end_mill(0.02, teeth=2)
    process = lobex.Milling(lobex.Modes.plane(x=mode, y=mode), cutter, 5.5e8, 2e8, 0.5, feed_per_tooth=1e-4)
    motion, cuts = (lobex.load(f"{name}.nc") for name in names)
    wanted = lobex.orbit(process, 200.0, 2e-4)
    np.testing.assert_allclose(motion.displacement[0], wanted.displacement, rtol=1e-9, atol=1e-12)
    radius = lobex.spectral_radius(process, cuts.speed, cuts.depth)
    assert np.all(radius < 1)
    assert np.all(cuts.mean_power <= 300 * (0.9 + 1e-6))
