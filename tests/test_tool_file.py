"""A tool from a file, and from the flags that say the same."""

from pathlib import Path

import jax
import numpy as np
import pytest

import lobex
from lobex._lengths import metres
from lobex.shell.arguments import Lobes
from lobex.shell.from_flags import process_of
from lobex.shell.parser import parse

EXAMPLE = Path(__file__).parent.parent / "docs" / "howto" / "tool.toml"
BY_HAND = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)


def same(one, other):
    assert jax.tree.structure(one) == jax.tree.structure(other)
    for a, b in zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-14)


def process_for(line):
    return process_of(parse({"lobes": Lobes}, line.split()).process)


def test_the_example_is_the_tool_made_by_hand():
    cutter = lobex.Cutter.end_mill(0.01905, pitch_degrees=[70, 110, 70, 110])
    by_hand = lobex.Milling(BY_HAND, cutter, 6.79e8, 1.73824e8, 0.25, "up")
    same(lobex.Milling(**lobex.read_tool(EXAMPLE), radial_immersion=0.25, direction="up"), by_hand)
    same(process_for(f"lobes milling --tool {EXAMPLE} --radial-immersion 0.25 --direction up"), by_hand)


def test_flags_make_the_same_cutter():
    flags = "--pitch 70,110,70,110 --helix 30 --diameter 19.05mm --directions 2"
    cutter = process_for(f"lobes milling {flags}").cutter
    same(cutter, lobex.Cutter.end_mill(0.01905, pitch_degrees=[70, 110, 70, 110], helix_degrees=30))
    assert process_for("lobes milling").cutter == lobex.Cutter(1)
    same(process_for("lobes milling --helix 30,35 --teeth 2 --diameter 0.016").cutter.helix, np.deg2rad([30, 35]))


def test_flags_and_files_make_the_same_serrated_cutter(tmp_path):
    flags = "--teeth 2 --diameter 16mm --serration 0.3mm,2mm --serration-phase 0,180 --feed 0.1mm --directions 2"
    process = process_for(f"lobes milling {flags}")
    wave = lobex.Serration(0.3e-3, 2e-3, np.array([0.0, 180.0]))
    same(process.cutter, lobex.Cutter.end_mill(0.016, teeth=2, serration=wave))
    assert process.feed_per_tooth == pytest.approx(1e-4)
    path = tmp_path / "rougher.toml"
    table = 'serration = { amplitude = "0.3 mm", wave_length = "2 mm", phase_degrees = [0, 180] }'
    path.write_text(EXAMPLE.read_text().replace("pitch_degrees = [70, 110, 70, 110]", f"teeth = 2\n{table}"))
    same(lobex.read_tool(path)["cutter"].serration, wave)
    assert process_for(f"lobes milling --tool {path} --feed 0.1mm").cutter.serrated


def test_all_that_a_file_can_say(tmp_path):
    path = tmp_path / "all.toml"
    path.write_text(
        """
        [cutter]
        shape = "bull_nose"
        diameter = "16 mm"
        corner_radius = "0.5mm"
        teeth = 2
        runout = ["5 um", 0.0]
        [[modes]]
        axis = "x"
        frequency = 900
        damping_ratio = 0.02
        stiffness = 2e7
        [[modes]]
        axis = "x"
        of = "workpiece"
        frequency = 400
        damping_ratio = 0.01
        stiffness = 5e7
        [force]
        law = "kienzle"
        chip = "0.1 mm"
        tangential = [1.8e9, 0.25]
        normal = [0.6e9, 0.4]
        [process_damping]
        coefficient = 2e4
        [speed_variation]
        amplitude = 0.1
        frequency_ratio = 0.5
        """
    )
    found = lobex.read_tool(path)
    modes = [
        lobex.Modes.single(frequency=900, damping_ratio=0.02, stiffness=2e7),
        lobex.Modes.single(frequency=400, damping_ratio=0.01, stiffness=5e7),
    ]
    wanted = {
        "cutter": lobex.Cutter.bull_nose(0.016, 5e-4, teeth=2, runout=[5e-6, 0.0]),
        "modes": lobex.Modes.relative(tool=modes[0], workpiece=modes[1]),
        "force": lobex.CuttingForce.kienzle(1e-4, tangential=(1.8e9, 0.25), normal=(0.6e9, 0.4)),
        "process_damping": lobex.ProcessDamping(2e4),
        "speed_variation": lobex.SpeedVariation(0.1, 0.5),
    }
    assert found.keys() == wanted.keys()
    for name, part in wanted.items():
        same(found[name], part)


def test_the_wear_land_of_a_file_is_a_length(tmp_path):
    path = tmp_path / "worn.toml"
    modes = '[[modes]]\naxis = "x"\nfrequency = 450\ndamping_ratio = 0.03\nmass = 0.8\n[force]\ntangential = 2e9\n'
    worn = 'normal = 1e9\n[process_damping]\nindentation_coefficient = 1.5e14\nwear_land = "0.08 mm"\n'
    path.write_text(f"{modes}{worn}friction = 0.3\n")
    same(lobex.read_tool(path)["process_damping"], lobex.ProcessDamping(4.8e5, 0.3))
    path.write_text(f"{modes}{worn}coefficient = 5e4\n")
    with pytest.raises(ValueError, match=r"\[process_damping\]: it has 'coefficient', which is none of friction, ind"):
        lobex.read_tool(path)


def test_a_turning_tool_takes_modes_and_the_normal_force(tmp_path):
    path = tmp_path / "bar.toml"
    modes = '[[modes]]\naxis = "x"\nfrequency = 450\ndamping_ratio = 0.03\nmass = 0.8\n'
    path.write_text(f"{modes}[force]\ntangential = 2e9\nnormal = 1.5e9\n")
    mode = lobex.Modes.single(frequency=450, damping_ratio=0.03, mass=0.8)
    same(process_for(f"lobes turning --tool {path}"), lobex.Turning(mode, 1.5e9))
    with pytest.raises(ValueError, match=r"has no \[cutter\]"):
        process_for(f"lobes milling --tool {path}")


@pytest.mark.parametrize(("text", "wanted"), [("19.05mm", 0.01905), (" 5 µm", 5e-6), ("0.75in", 0.01905), (0.02, 0.02)])
def test_lengths_have_units(text, wanted):
    assert metres("diameter", text) == pytest.approx(wanted, rel=1e-15)


@pytest.mark.parametrize("text", ["19.05 ft", "mm", "", "1e", True, None, [1.0]])
def test_what_is_no_length_is_told(text):
    with pytest.raises(ValueError, match=r"diameter = .* is no length"):
        metres("diameter", text)


MODE = '[[modes]]\naxis = "x"\nfrequency = 900\ndamping_ratio = 0.02\nmass = 0.5\n'
FORCE = "[force]\ntangential = 6e8\nnormal = 2e8\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[force", "is no TOML"),
        (FORCE, r"has no \[modes\]"),
        (MODE, r"has no \[force\]"),
        (MODE + FORCE + "[spindle]\n", "'spindle', which is none of cutter, force, modes"),
        (MODE + FORCE + "[cutter]\ndiamter = 0.02\n", r"\[cutter\]: it has 'diamter'"),
        (MODE + FORCE + "[cutter]\nteeth = 2\ndiameter = '2 parsec'\n", "is no length"),
        (MODE + FORCE + "[cutter]\npitch_degrees = [100, 100]\n", "pitch_degrees sum to 200"),
        (MODE + FORCE + "[cutter]\nteeth = 2\nhelix_degrees = 90\n", "helix_degrees = 90"),
        (MODE + FORCE + "[cutter]\nshape = 'drill'\n", "shape = 'drill'"),
        (MODE.replace('"x"', '"u"') + FORCE, "axis = 'u'"),
        (MODE.replace("mass = 0.5", "") + FORCE, "mass"),
        (MODE + "[force]\ntangential = 6e8\n", r"\[force\]: .*normal"),
        ("modes = 3\n" + FORCE, r"write \[\[modes\]\]"),
        ("modes = []\n" + FORCE, r"write \[\[modes\]\] above each mode"),
        ("modes = [3]\n" + FORCE, r"write \[\[modes\]\] above each mode"),
        (MODE + FORCE + "[speed_variation]\namplitude = 1.0\nfrequency_ratio = 0.1\n", "of its mean"),
    ],
)
def test_a_file_that_is_wrong_is_told_in_one_line(tmp_path, text, message):
    path = tmp_path / "tool.toml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as error:
        lobex.read_tool(path)
    assert len(str(error.value).splitlines()) == 1


def test_flags_that_say_the_same_twice_are_told(tmp_path):
    for flags, message in (
        (f"--tool {EXAMPLE} --teeth 3", "drop one of the two"),
        (f"--tool {EXAMPLE} --helix 30", "drop one of the two"),
        (f"--tool {tmp_path}/none.toml", "cannot be read"),
        ("--teeth 2 --serration 0.3mm", "serration = '0.3mm'; give amplitude and wave length, such as 0.3mm,2mm"),
        ("--teeth 2 --serration-phase 0,180", r"serration_phase = \(0.0, 180.0\) without a serration"),
        ("--teeth 2 --serration 0.3mm,2mm", "feed_per_tooth = None with a serrated cutter"),
        ("--teeth 3 --pitch 180,180", "teeth = 3 with 2 pitch angles"),
        ("--helix 30", "diameter = None with a helix"),
        ("--diameter 19.05cm", "is no length"),
    ):
        with pytest.raises(ValueError, match=message):
            process_for(f"lobes milling {flags}")
