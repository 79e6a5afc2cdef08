"""Lobes of a tap test from the command line."""

from pathlib import Path

import numpy as np
import pytest

import lobex
from lobex.shell.arguments import Lobes
from lobex.shell.from_flags import process_of
from lobex.shell.limit_arguments import Limit
from lobex.shell.parser import parse

EXAMPLE = Path(__file__).parents[1] / "docs" / "howto" / "tap_test.csv"
TOOL = EXAMPLE.with_name("tool.toml")


def process_for(line):
    return process_of(parse({"lobes": Lobes, "limit": Limit}, line.split()).process)


def test_one_line_from_a_tap_test_to_lobes(shell, tmp_path):
    text = EXAMPLE.read_text().splitlines()
    one = tmp_path / "x.csv"
    one.write_text("\n".join(",".join(row.split(",")[:3]) for row in text))
    done = shell("lobes", "turning", "--frf", str(one), "--rpm", "6000:9000:3", "--gain", "0:4e-3:5", "--out", "tap")
    assert done.code == 0, done.err
    assert "563." in done.out
    assert "misfit" in done.out
    chart = lobex.load(tmp_path / "tap.nc")
    by_hand = lobex.Turning(lobex.read_frf(one).modes(), radial=2e8)
    assert chart.spectral_radius == pytest.approx(
        lobex.sweep(by_hand, chart.speed, chart.gain).spectral_radius, rel=1e-9
    )
    assert (tmp_path / "tap.png").stat().st_size > 10_000


def test_every_process_takes_measured_modes(capsys):
    modes = lobex.read_frf(EXAMPLE).modes()
    mill = process_for(f"lobes milling --frf {EXAMPLE} --teeth 4")
    np.testing.assert_array_equal(mill.modes.shape, modes.shape)
    assert mill.teeth == 4
    # The cutter and the force of a file, the modes of the measurement.
    mill = process_for(f"limit milling --frf {EXAMPLE} --tool {TOOL}")
    np.testing.assert_array_equal(mill.modes.angular_frequency, modes.angular_frequency)
    assert mill.teeth == 4
    assert mill.tangential == 679e6
    assert process_for(f"limit rub --frf {EXAMPLE} --frf-modes 1 --frf-band 400:700").modes.count == 2
    assert "400 to 700 Hz" in capsys.readouterr().out


def test_two_files_make_a_plane(tmp_path, capsys):
    columns = np.loadtxt(EXAMPLE, delimiter=",", skiprows=1)
    paths = [tmp_path / f"{axis}.csv" for axis in "xy"]
    for path, part in zip(paths, ((0, 1, 2), (0, 3, 4)), strict=True):
        np.savetxt(path, columns[:, part], delimiter=",")
    roles = "--frf-columns frequency,real,imaginary --frf-unit m/s^2/N"
    mill = process_for(f"lobes milling --frf {paths[0]} --frf-y {paths[1]} {roles}")
    modes = lobex.read_frf(EXAMPLE).modes()
    np.testing.assert_allclose(mill.modes.angular_frequency, modes.angular_frequency, rtol=1e-9)
    np.testing.assert_allclose(mill.modes.shape, modes.shape, rtol=1e-6)


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("--frf", "none.csv"), "there is no such file"),
        (("--frf", str(EXAMPLE), "--frf-unit", "N/m"), "unit = 'N/m' is no unit of a response"),
        (("--frf", str(EXAMPLE), "--frf-band", "low"), "frf_band = 'low' is not low:high"),
        (("--frf", str(EXAMPLE), "--frequency", "500"), "says what flags of tool say"),
        (("--frf", str(EXAMPLE), "--directions", "2"), "says what flags of directions say"),
        (("--frf", str(EXAMPLE), "--frf-y", str(EXAMPLE)), "has 2 directions; drop one"),
        (("--frf-band", "100:300"), "frf-band = '100:300' has no use without a file; give --frf FILE"),
    ],
)
def test_flags_of_measurements_that_cannot_be_are_refused(words, line, shell):
    assert line in shell.refuses("lobes", "milling", *words, "--rpm", "6000:9000:3", "--gain", "0:1e-3:3", "--quiet")
