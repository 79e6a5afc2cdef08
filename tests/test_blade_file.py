"""A blade from a file, and from flags of the shell."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import lobex
from lobex.contact.laws import KINDS
from lobex.shell.arguments import Lobes
from lobex.shell.from_flags import process_of
from lobex.shell.from_wear_flags import march_of
from lobex.shell.limit_arguments import Limit
from lobex.shell.parser import parse
from lobex.shell.wear_arguments import LAWS, Wear
from refusals import refused
from test_tool_file import same

HOWTO = Path(__file__).parent.parent / "docs" / "howto"
EXAMPLE, STAGE = HOWTO / "blade.toml", HOWTO / "stage.toml"


def process_for(line):
    return process_of(parse({"lobes": Lobes, "limit": Limit}, line.split()).process)


def fan_blade(elements):
    return lobex.Beam.rectangular(
        elements=elements,
        length=0.18,
        width=np.array([0.06, 0.07]),
        thickness=np.array([0.007, 0.003]),
        young_modulus=110e9,
        density=4430.0,
        hub_radius=0.12,
        stagger_degrees=20.0,
        twist_degrees=np.array([0.0, 35.0]),
    )


def test_the_example_is_the_blade_made_by_hand():
    beam = fan_blade(8)
    contact = {"normal": (0.97, 0.0, 0.24), "sliding": (0.0, 1.0, 0.0), "friction": 0.15, "chord": 0.03}
    by_hand = beam.rotating(0.005, [1, 2, 3, 4, 5, 6], **contact)
    same(lobex.read_blade(EXAMPLE)["modes"], by_hand)
    for command in ("lobes", "limit"):
        same(process_for(f"{command} rub --blade {EXAMPLE} --speed 100"), lobex.Rub(by_hand))


def stage_by_hand():
    beam = fan_blade(4)
    contact = {"normal": (0.97, 0.0, 0.24), "sliding": (0.0, 1.0, 0.0), "friction": 0.15, "chord": 0.03}
    mistuning = np.array([0.013, -0.021, 0.004, 0.017, -0.009, -0.004])
    blading = lobex.Blading(beam.rotating(0.005, [1, 2], **contact), 6, mistuning)
    ring = lobex.Ring(np.array([2.0, 3.0]), np.array([350.0, 610.0]), 0.02, 1.5)
    casing = lobex.Casing(6, 5e-5, 0.0, radius=0.3, axial_width=0.06, structure=ring)
    return blading, casing, lobex.Bilinear(1e5, 3e5, 2e-5)


def test_the_example_of_a_stage_is_the_one_made_by_hand(shell, tmp_path):
    blading, casing, law = stage_by_hand()
    found = lobex.read_wear(STAGE)
    for name, expected in (("modes", blading), ("casing", casing), ("law", law)):
        same(found[name], expected)
    told = lobex.read_blade(STAGE)
    assert sorted(told) == ["casing", "modes"]
    same(told["casing"], casing.structure)
    flags = ("wear", "rub", "--blade", str(STAGE), "--speed", "80,90", "--revolutions", "2", "--steps", "480")
    assert shell(*flags, "--incursion", "1e-6", "--out", "stage", "--quiet").code == 0, shell.err
    names = ["stage-casing.png", "stage-spectrum.png", "stage.nc", "stage.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    marched = lobex.march_wear(blading, casing, law, [80.0, 90.0], 2, 480, incursion=1e-6)
    assert np.any(marched.depth > 0)
    assert lobex.load("stage.nc").depth == pytest.approx(marched.depth, rel=1e-9, abs=1e-16)


def test_a_file_tells_what_each_of_several_contacts_meets(tmp_path):
    path = tmp_path / "edges.toml"
    laws = '[[law]]\nkind = "linear"\nstiffness = 1e5\n[[law]]\nkind = "linear"\nstiffness = 2e5\n'
    casings = "[[casing]]\namplitude = '20000 um'\n[[casing]]\nnodal_diameters = 3\n"
    path.write_text(BEAM + MODES + '[contact]\nchord = ["-20 mm", "20 mm"]\n' + laws + casings)
    found = lobex.read_wear(path)
    assert found["modes"].directions == 2
    assert [law.stiffness for law in found["law"]] == [1e5, 2e5]
    assert [(one.nodal_diameters, one.amplitude) for one in found["casing"]] == [(2, 0.02), (3, 1e-4)]


def test_what_a_file_leaves_out_flags_say(shell, tmp_path):
    path = tmp_path / "plain.toml"
    path.write_text(BEAM + MODES)
    flags = parse(
        {"wear": Wear}, f"wear --blade {path} --law threshold --offset 3 --slope 1e5 --bump-width 0.3".split()
    )
    found = march_of(flags.march)
    same(found["casing"], lobex.Casing(bump_width=0.3))
    same(found["law"], lobex.Threshold(1.0, 3.0, 1e5))
    assert found["modes"].directions == 1
    path.write_text(BEAM + MODES + "[casing]\n[law]\nkind='linear'\nstiffness=1e5\n")
    for words in ("--stiffness 3", "--clearance 1e-5", "--keep 1"):
        name = words.split()[0].strip("-")
        with refused(f"says what flags of {name} say"):
            march_of(parse({"wear": Wear}, f"wear --blade {path} {words}".split()).march)


def test_the_least_that_a_file_says(tmp_path):
    path = tmp_path / "plain.toml"
    path.write_text(BEAM + MODES)
    beam = lobex.Beam.rectangular(length=0.2, width=0.05, thickness=0.004, young_modulus=110e9, density=4430.0)
    same(lobex.read_blade(path)["modes"], beam.rotating(0.01))


BEAM = """
[beam]
length = "200 mm"
width = 0.05
thickness = "4mm"
young_modulus = 110e9
density = 4430
"""
MODES = "[modes]\ndamping_ratio = 0.01\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[beam", "is no TOML"),
        (MODES, "has no [beam]; see lobex.read_blade"),
        (BEAM, "has no [modes]; see lobex.read_blade"),
        (BEAM + MODES + "[disc]\nradius = 1\n", "has 'disc', which is none of beam, casing, contact, law, modes, ring"),
        (BEAM + MODES + "[stage]\nmistuning = [0.0]\n", "[stage]: missing 1 required positional argument: 'count'"),
        (BEAM + MODES + "[stage]\ncount = 0\n", "[stage]: count = 0"),
        (BEAM + MODES + "[stage]\ncount = 2\nspacing = [90, 90]\n", "[stage]: spacing adds up to 180°"),
        (BEAM + MODES + "[contact]\nchord = [0.0, 0.01]\n[stage]\ncount = 2\n", "[stage]: blade has 2 contact"),
        (BEAM + MODES + "[ring]\nfrequency = 300\n", "[ring]: missing 3 required positional arguments"),
        (BEAM + MODES + "[law]\nstiffness = 300\n", "[law]: kind = None is unknown; choose one of 'linear'"),
        (BEAM + MODES + "[law]\nkind = 'linear'\nslope = 1\n", "[law]: it has 'slope', which is none of stiffness"),
        (BEAM + MODES + "law = [3]\n", "[modes]: it has 'law'"),
        (BEAM + MODES + "[casing]\nstructure = 3\n", "[casing]: it has 'structure'"),
        (BEAM + MODES + "[casing]\namplitude = '1 ft'\n", "[casing]: amplitude = '1 ft' is no length"),
        (BEAM + "chord = 0.05\n" + MODES, "[beam]: it has 'chord', which is none of density"),
        (BEAM.replace("density = 4430", "") + MODES, "[beam]: missing 1 required keyword-only argument: 'density'"),
        (BEAM.replace("4mm", "4 parsec") + MODES, "[beam]: thickness = '4 parsec' is no length"),
        (BEAM + "elements = 0\n" + MODES, "[beam]: elements = 0 must be"),
        (BEAM + "[modes]\nkeep = [1]\n", "[modes]: it has no damping_ratio"),
        (BEAM + "twist_degrees = ['0 deg', '9 deg']\n" + MODES, "[beam]: twist_degrees = ['0 deg', '9 deg'] is not a"),
        (BEAM + MODES + "keep = [0]\n", "[modes]: keep = 0 must be a whole number of at least 1"),
        (BEAM + MODES + "[contact]\nnormal = [0, 0, 0]\n", "[contact]: normal is a vector of no length"),
        (BEAM + MODES + "[contact]\nfriction = 0.2\n", "[contact]: friction = 0.2 has no direction"),
        (BEAM + MODES + "[contact]\nstiffness = 0.2\n", "[contact]: it has 'stiffness', which is none of chord"),
        ("beam = 3\n" + MODES, "[beam]: it is no table; write [beam]"),
    ],
)
def test_a_file_that_is_wrong_is_told_in_one_line(tmp_path, text, words):
    path = tmp_path / "blade.toml"
    path.write_text(text)
    with refused(words):
        lobex.read_blade(path)


def test_a_march_takes_a_law(tmp_path):
    path = tmp_path / "plain.toml"
    path.write_text(BEAM + MODES)
    with refused("has no [law]; see lobex.read_wear"):
        lobex.read_wear(path)


def test_files_and_flags_know_the_same_laws():
    assert {kind: tuple(field.name for field in fields(made)) for kind, made in KINDS.items()} == LAWS


def test_flags_that_say_the_same_twice_are_told(tmp_path):
    for flags, words in (
        (f"lobes rub --blade {EXAMPLE} --elements 3", "says what flags of elements say; drop one of the two"),
        (f"lobes rub --blade {EXAMPLE} --keep 1 2", "says what flags of keep say; drop one of the two"),
        (f"limit rub --blade {EXAMPLE} --sensitivity", "has no use with --sensitivity"),
        (f"lobes rub --blade {tmp_path}/none.toml", "cannot be read"),
    ):
        with pytest.raises(ValueError, match=words):
            process_for(flags)
