"""Command lines that nobody means: each ends in one line and exit code 2, or is computed; never in a traceback."""

import random
import re
import signal
import subprocess
import sys

import pytest

import lobex.advice.best_cuts
import lobex.grids.sweep
import lobex.limits.critical
import lobex.limits.exact_limit
import lobex.limits.sensitivity
import lobex.marches.delay
import lobex.marches.turning
import lobex.marches.wear
import lobex.motions.forced_motion
from commands import run

LONG = "x" * 300
# What computes, once every argument was looked at.
WORK = [
    (lobex.grids.sweep, "dominant_over_grid"),
    (lobex.limits.critical, "_search"),
    (lobex.limits.exact_limit, "exact_critical"),
    (lobex.limits.sensitivity, "critical_gain"),
    (lobex.marches.delay, "_march"),
    (lobex.marches.turning, "_march"),
    (lobex.marches.wear, "_march"),
    (lobex.motions.forced_motion, "_settled"),
    (lobex.advice.best_cuts, "_scanned"),
]
COMMANDS = [
    *(("lobes", name) for name in ("rub", "milling", "turning", "mathieu")),
    *(("limit", name) for name in ("rub", "milling", "turning")),
    *(("march", name) for name in ("rub", "milling", "turning", "mathieu")),
    ("wear",),
    ("severity",),
    ("orbit", "milling"),
    ("recommend", "milling"),
]
NUMBERS = """x 0 -1 1 7 0.5 1e308 -1e308 1e-308 1e300 1e99 1e-99 1e12 1e-12 nan inf -inf 1e999 0x10 1_000 5; None
    1,2 1,,2 2,1 1e308,2 , -- -x 2147483648 -2147483648 99999999999999999999 ../.. / /proc/x no/such/x μ"""
RANGES = """: :: 1:2 1:2:3:4 1:2:x 2:1:3 1:1:3 1:2:1 1:2:0 1:2:-3 1:2:1.5 1:2:2147483648 nan:1:3 1:inf:3 0:0:2 1:2:3
    1e308:1.1e308:3 1e-308:2e-308:3 1e-300:1e-299:2 -1e308:1e308:3"""
VALUES = [*NUMBERS.split(), *RANGES.split(), "", " 5", "9" * 5000, LONG]


class Reached(Exception):
    """Computing would begin."""


@pytest.fixture
def idle(monkeypatch):
    """Nothing is computed."""

    def reached(*_, **__):
        raise Reached

    for module, name in WORK:
        monkeypatch.setattr(module, name, reached)


def flags_of(shell, command):
    """The flags that a command's help tells."""
    return sorted(set(re.findall(r"--[a-z][a-z-]+", shell(*command, "--help").out)) - {"--help", "--store"})


def try_lines(shell, seed, count):
    draw = random.Random(seed)
    flags = {command: flags_of(shell, command) for command in COMMANDS}
    for _ in range(count):
        command = draw.choice(COMMANDS)
        words = [*command]
        for flag in draw.sample(flags[command], draw.choice([1, 1, 2, 3])):
            words += [flag, draw.choice(VALUES)]
        try:
            line = shell.refuses(*words)
        except Reached:
            continue
        except BaseException as error:
            raise AssertionError(f"lobex {' '.join(words)!r}") from error
        assert len(line) < 700, words


def test_a_few_lines_are_refused_in_one_line_or_computed(shell, idle):
    try_lines(shell, seed=14, count=40)


@pytest.mark.search
@pytest.mark.parametrize("seed", range(8))
def test_many_lines_are_refused_in_one_line_or_computed(shell, idle, seed):
    try_lines(shell, seed=seed, count=250)


@pytest.mark.search
@pytest.mark.parametrize("seed", range(4))
def test_lines_that_are_computed_end_well(seed, tmp_path):
    draw = random.Random(seed)
    small = {
        "lobes": ("rub", "--speed", "100,200", "--gain", "1e5,1e6", "--elements", "2"),
        "limit": ("rub", "--speed", "100:200:4", "--gain", "1e5:1e6:5", "--elements", "2"),
        "march": ("rub", "--speed", "100", "--gain", "1e5", "--elements", "2", "--periods", "2"),
        "wear": ("--speed", "100,120", "--elements", "2", "--revolutions", "2"),
    }
    flags = ("--damping-ratio", "--young-modulus", "--density", "--length", "--area", "--speed", "--gain")
    for number in range(8):
        command = draw.choice(sorted(small))
        own = flags[:-1] if command == "wear" else flags
        folder = tmp_path / str(number)
        folder.mkdir()
        words = (command, *small[command], draw.choice(own), draw.choice(VALUES), "--quiet", "--out", "o")
        done = run(*words, cwd=folder, timeout=500)
        assert done.returncode in (0, 2), (words, done.stderr)
        assert "Traceback" not in done.stderr, (words, done.stderr)
        assert bool(list(folder.iterdir())) == (done.returncode == 0), words


@pytest.mark.parametrize(
    ("line", "words"),
    [
        *((f"{command} --out {LONG}", "File name too long") for command in ("lobes rub", "limit turning", "wear")),
        *(
            (f"{command} {LONG}", "File name too long")
            for command in ("reproduce --out", "store status", "store export")
        ),
        ("wear --speed 1e-308:2e-308:3", "at least 1e-100 in Hz"),
        ("lobes rub --speed 1e-300:1e-299:2", "at least 1e-100 in Hz"),
        ("lobes turning --gain 1e308:1.1e308:3", "at most 1e100"),
        ("lobes mathieu --speed 1e308:1.1e308:3", "at most 1e100"),
        ("lobes rub --young-modulus 1e308", "young_modulus = 1e+308"),
        ("limit rub --exact --damping-ratio 1e308", "damping_ratio = 1e+308"),
        ("march mathieu --epsilon 1e308", "epsilon = 1e+308"),
        (
            "wear --revolutions 2147483648",
            "revolutions = 2147483648 is more than can be computed; give at most 1000000",
        ),
        ("wear --revolutions 1000000", "and 20 GB are free; give fewer, or a store"),
        ("wear --steps 2147483648", "at most 1000000"),
        ("wear --nodal-diameters 2147483648", "at most 100000"),
        ("lobes rub --speed 50:400:1000000 --gain 1:5e6:1000000", "need 100 TB and 20 GB are free"),
        ("lobes turning --rpm 5e3:4e4:1000000 --gain 0:1:1000000", "in the shell --store DIR"),
        ("limit milling --rpm 5e3:4e4:1000000 --gain 0:1:1000000", "speed and scan make 1000000 × 1000000 samples"),
        ("march milling --periods 2147483648", "periods = 2147483648"),
        ("march milling --periods 1000000 --steps 1000000", "they would need 48 TB"),
        ("march turning --feed 1e-4 --periods 1000000 --steps 1000000", "they would need 144 TB"),
        ("march milling --steps 2147483648", "steps = 2147483648"),
        ("lobes milling --method sdm --steps 2147483648", "at most 5000"),
        ("lobes milling --nodes 2147483648", "at most 2000"),
        ("lobes milling --teeth 2147483648", "at most 1000"),
        ("lobes rub --elements 20000", "elements = 20000 is more than can be computed; give at most 200"),
        ("lobes rub --store s --processes 2147483648", "at most 256"),
        ("lobes rub --nodes x", "--nodes: 'x' is not a whole number"),
        ("lobes rub --steps 1.5", "--steps: '1.5' is not a whole number"),
        ("march turning --feed x", "feed = 'x' is no length"),
        ("wear --stiffness None", "--stiffness: 'None' is not a number"),
    ],
)
def test_what_is_beyond_meaning_or_memory_is_refused_with_the_number(shell, idle, monkeypatch, line, words):
    monkeypatch.setattr("lobex._memory.available_memory", lambda: 20_000_000_000)
    assert words in shell.refuses(*line.split())


# Ctrl-C at the moment at which a module is looked for.
INTERRUPTED = """
import os, signal, sys

signal.signal(signal.SIGINT, signal.default_int_handler)
module = sys.argv.pop(1)

class Interrupt:
    def find_spec(self, name, path, target=None):
        if name == module:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
from lobex.shell.main import main
main()
"""


@pytest.mark.parametrize("module", ["numpy", "tyro", "jax"])
def test_an_interruption_while_modules_are_imported_is_one_line(module, tmp_path):
    command = [sys.executable, "-c", INTERRUPTED, module, "lobes", "rub", "--speed", "100", "--gain", "1e5"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (128 + signal.SIGINT, "")
    assert done.stderr == "lobex: interrupted; nothing was written\n"
