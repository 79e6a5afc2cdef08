"""A march as text, file, picture and shell command."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray

import lobex
from cases import ROD
from lobex.marches.delay import march_delay
from lobex.marches.start import growing_history
from lobex.shell import march_arguments as shell
from lobex.shell.arguments import Output
from lobex.shell.march_command import run_march
from refusals import refused


def pulse(time):
    """A displacement that excites all modes."""
    return 1e-5 * np.cos(40 * time / np.min(time))


def test_a_march_survives_its_file(tmp_path):
    march = march_delay(ROD, [[85.0], [112.0]], [4.5e5, 1.35e6], pulse, 4, 300, every=3)
    march.save(tmp_path / "march.nc")
    back = lobex.load(tmp_path / "march.nc")
    for name in ("speed", "gain", "delay", "phase", "displacement", "state", "multiplier", "growth_error"):
        assert np.array_equal(getattr(back, name), getattr(march, name)), name
    assert repr(back) == repr(march)
    assert "4 lanes, 4 periods of 300 steps" in repr(march)
    assert "85 to 112 Hz\n  gain             0.45 to 1.35 MN/m (contact stiffness K_e)" in repr(march)


def test_a_march_plots_its_lanes():
    march = march_delay(ROD, 112.0, [4.5e5, 1.35e6], pulse, 4, 300)
    axes = march.plot()
    lines = [line for line in axes.get_lines() if len(line.get_xdata()) > 2]
    assert len(lines) == 2
    assert axes.get_xlabel() == "revolutions"
    assert "µm" in axes.get_ylabel()
    assert march.plot(plt.subplots()[1]).get_legend() is not None


# --- the shell


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder to run a command in, with JAX left as it is."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(tmp_path))
    return tmp_path


def test_the_shell_marches_what_the_library_marches(here, capsys):
    run_march(shell.March(shell.MarchRub(speed="112", gain="4.5e5,1.35e6", steps=600, periods=12)))
    assert sorted(p.name for p in here.iterdir()) == ["rub-march.nc", "rub-march.png"]
    assert min(plt.imread(here / "rub-march.png").shape[:2]) > 500
    march = lobex.load("rub-march.nc")
    history, state = growing_history(lobex.Rod(5), [112.0, 112.0])
    exact = march_delay(ROD, 112.0, [4.5e5, 1.35e6], history, 12, 600, state=state)
    assert march.displacement == pytest.approx(exact.displacement, rel=1e-9)
    printed = capsys.readouterr().out
    radius = lobex.spectral_radius(ROD, 112.0, 1.35e6)
    assert f"K_e = 1.35 MN/m: growth {march.growth[1]:.6f} per period, predicted max|μ| {radius:.6f}" in printed
    assert "unstable" in printed


def test_the_shell_simulates_turning_with_a_feed(here, capsys):
    flags = shell.MarchTurning(rpm="5000", gain="5e-5", feed=1e-4, periods=5, steps=100, output=Output(quiet=True))
    run_march(shell.March(flags))
    with xarray.open_dataset("turning-march.nc", engine="h5netcdf") as stored:
        assert {"force", "chip_thickness"} <= set(stored)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (shell.MarchRub(speed="fast"), "speed = 'fast'"),
        (shell.MarchRub(speed="0"), "speed = [0] must be positive"),
        (shell.MarchRub(speed="80,nan"), "speed = [80, nan]"),
        (shell.MarchRub(speed="1,2,3,4"), "make 8 points; give at most 6"),
        (shell.MarchRub(gain=""), "gain = ''"),
        (shell.MarchRub(periods=0), "periods = 0"),
        (shell.MarchMilling(steps=1), "steps = 1"),
        (shell.MarchMathieu(output=Output(out="no/such/folder")), "out = "),
    ],
)
def test_bad_flags_are_refused_in_one_line(flags, words, here):
    with refused(words):
        run_march(shell.March(flags))
    assert list(here.iterdir()) == []
