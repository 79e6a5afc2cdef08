"""A blade from a file, and from flags of the shell."""

from pathlib import Path

import numpy as np
import pytest

import lobex
from lobex.shell.arguments import Lobes
from lobex.shell.from_flags import process_of
from lobex.shell.limit_arguments import Limit
from lobex.shell.parser import parse
from refusals import refused
from test_tool_file import same

EXAMPLE = Path(__file__).parent.parent / "docs" / "howto" / "blade.toml"


def process_for(line):
    return process_of(parse({"lobes": Lobes, "limit": Limit}, line.split()).process)


def test_the_example_is_the_blade_made_by_hand():
    beam = lobex.Beam.rectangular(
        elements=8,
        length=0.18,
        width=np.array([0.06, 0.07]),
        thickness=np.array([0.007, 0.003]),
        young_modulus=110e9,
        density=4430.0,
        hub_radius=0.12,
        stagger_degrees=20.0,
        twist_degrees=np.array([0.0, 35.0]),
    )
    contact = {"normal": (0.97, 0.0, 0.24), "sliding": (0.0, 1.0, 0.0), "friction": 0.15, "chord": 0.03}
    by_hand = beam.rotating(0.005, [1, 2, 3, 4, 5, 6], **contact)
    same(lobex.read_blade(EXAMPLE)["modes"], by_hand)
    for command in ("lobes", "limit"):
        same(process_for(f"{command} rub --blade {EXAMPLE} --speed 100"), lobex.Rub(by_hand))


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
        (BEAM + MODES + "[disc]\nradius = 1\n", "blade.toml' has 'disc', which is none of beam, contact, modes"),
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


def test_flags_that_say_the_same_twice_are_told(tmp_path):
    for flags, words in (
        (f"lobes rub --blade {EXAMPLE} --elements 3", "says what flags of elements say; drop one of the two"),
        (f"lobes rub --blade {EXAMPLE} --keep 1 2", "says what flags of keep say; drop one of the two"),
        (f"limit rub --blade {EXAMPLE} --sensitivity", "has no use with --sensitivity"),
        (f"lobes rub --blade {tmp_path}/none.toml", "cannot be read"),
    ):
        with pytest.raises(ValueError, match=words):
            process_for(flags)
