"""Studies in processes of their own: killed, interrupted, side by side, and from the shell."""

import contextlib
import fcntl
import multiprocessing
import os
import pty
import re
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time
from pathlib import Path

import numpy as np
import pytest

import lobex
from commands import run
from lobex.studies.local_processes import Processes
from lobex.studies.study import Study
from stored_study import COUNT, before_each_chunk, names, study, work

STUDY = Path(__file__).with_name("stored_study.py")
# Every process is a fork of one that has imported what the study needs, which takes longer than the study, and has not
# started JAX, which cannot be forked.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["jax", "lobex", "lobex.verbs", "lobex.studies.charts", "lobex.studies.run", "h5netcdf.legacyapi"]
)


class Begun:
    """A process that works at the study, and what it has said so far."""

    def __init__(self, folder, processes):
        handle, self.told = tempfile.mkstemp(suffix=".told", dir=folder.parent)
        os.close(handle)
        self.process = FORKS.Process(target=work, args=(str(folder), processes, str(gate_of(folder)), self.told))
        self.process.start()

    @property
    def said(self):
        return Path(self.told).read_text()

    @property
    def returncode(self):
        return self.process.exitcode

    def send(self, number):
        os.kill(self.process.pid, number)

    def end(self):
        self.process.join(300)
        return self.returncode


def begin(folder, processes=0, chunks=COUNT):
    """Start the study of this file, by so many processes or by one alone, which may begin the first of its chunks."""
    allow(folder, chunks)
    return Begun(folder, processes)


def gate_of(folder):
    return folder.with_suffix(".gate")


def allow(folder, chunks):
    """Let the first so many chunks be begun."""
    new = folder.with_suffix(".new")
    new.write_text(str(chunks))
    new.replace(gate_of(folder))


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "s"
    process = begin(folder)
    assert process.end() == 0, process.said
    # A bar is for a terminal.
    assert "pt/s" not in process.said
    return names(folder)


@pytest.fixture(scope="module")
def pool():
    with Processes(2) as processes:
        yield processes


def wait_for(folder, least, process):
    """Until there are so many files."""
    while len(names(folder)) < least:
        ended = process.returncode is not None
        assert not ended or len(names(folder)) >= least, process.said
        time.sleep(0.005)


def children_of(process):
    """The numbers of the processes that a process has started."""
    return list(map(int, Path(f"/proc/{process}/task/{process}/children").read_text().split()))


def wait_for_end_of(processes):
    deadline = time.monotonic() + 60
    while any(Path(f"/proc/{process}").exists() for process in processes):
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_store_killed_at_random_instants_ends_the_same(uninterrupted, tmp_path):
    folder, random = tmp_path / "s", np.random.default_rng(7)
    for _ in range(2):
        wanted = len(names(folder)) + 1 + random.integers(3)
        process = begin(folder, chunks=wanted + 2)
        wait_for(folder, wanted, process)
        time.sleep(0.05 * random.random())
        process.send(signal.SIGKILL)
        assert process.end() == -signal.SIGKILL
        assert set(names(folder)) < set(uninterrupted)
    process = begin(folder)
    assert process.end() == 0, process.said
    assert names(folder) == uninterrupted
    assert not list(folder.glob(".*"))


def test_two_runs_at_once_in_one_folder_make_what_one_makes(uninterrupted, tmp_path):
    both = [begin(tmp_path / "s") for _ in range(2)]
    for process in both:
        assert process.end() == 0, process.said
    assert names(tmp_path / "s") == uninterrupted


def test_a_worker_that_is_killed_is_replaced_and_loses_no_chunk(pool, uninterrupted, tmp_path):
    killed = []

    def kill(number):
        # Once: what the worker had in hand is handed over again.
        if number == 11 and not killed:
            while len(names(tmp_path / "s")) < 4:
                time.sleep(0.005)
            killed.append(min(pool._pool._processes))
            os.kill(killed[0], signal.SIGKILL)

    with before_each_chunk(kill):
        study(tmp_path / "s", pool)
    assert killed[0] not in pool._pool._processes
    assert names(tmp_path / "s") == uninterrupted
    assert not list((tmp_path / "s").glob(".*"))
    # Without a store chunks come back by themselves, and are the same.
    whole = lobex.sweep(
        lobex.Rub(lobex.Rod(1).modes(0.03)),
        np.linspace(300, 700, 4),
        np.linspace(1e5, 4e6, 3),
        over={"modes.damping_ratio": np.linspace(0.01, 0.1, COUNT)[:2]},
        executor=pool,
    )
    np.testing.assert_array_equal(whole["multiplier"], Study.open(tmp_path / "s")["multiplier"][:2])


def test_a_killed_run_takes_its_workers_along_and_is_completed_by_one(uninterrupted, tmp_path):
    folder = tmp_path / "s"
    process = begin(folder, 2, chunks=8)
    wait_for(folder, 5, process)
    workers = children_of(process.process.pid)
    assert len(workers) >= 2
    process.send(signal.SIGKILL)
    process.end()
    wait_for_end_of(workers)
    assert "manifest.json" in names(folder)
    process = begin(folder)
    assert process.end() == 0, process.said
    assert names(folder) == uninterrupted
    assert not list(folder.glob(".*"))


@pytest.mark.parametrize("processes", [0, 2])
def test_ctrl_c_keeps_what_is_done_and_says_so(processes, uninterrupted, tmp_path):
    folder = tmp_path / "s"
    process = begin(folder, processes, chunks=8)
    wait_for(folder, 4, process)
    # A terminal tells all of them.
    workers = children_of(process.process.pid) if processes else []
    for number in workers:
        os.kill(number, signal.SIGINT)
    process.send(signal.SIGINT)
    allow(folder, COUNT)
    assert process.end() != 0
    done = len(names(folder)) - 1
    assert f"KeyboardInterrupt: {done} of {COUNT} chunks are in" in process.said
    assert set(names(folder)) < set(uninterrupted)
    assert not list(folder.glob(".*"))
    wait_for_end_of(workers)


def test_a_terminal_is_shown_the_rate_and_the_time_left(uninterrupted, tmp_path):
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 120, 0, 0))
    allow(tmp_path / "s", COUNT)
    command = [sys.executable, STUDY, str(tmp_path / "s"), "0", str(gate_of(tmp_path / "s"))]
    process = subprocess.Popen(command, stderr=theirs)
    os.close(theirs)
    shown = b""
    # At the end of the other side a terminal's reading fails.
    with contextlib.suppress(OSError):
        while part := os.read(ours, 4096):
            shown += part
    os.close(ours)
    assert process.wait(timeout=300) == 0
    assert re.search(rb"\d+%\|.*\[\d\d:\d\d<\d\d:\d\d, .*pt/s\]", shown)
    assert names(tmp_path / "s") == uninterrupted


# 210 speeds and 100 gains of a method by operators are two chunks.
LOBES = ("lobes", "rub", "--elements", "1", "--speed", "700:1400:210", "--gain", "0:4e6:100", "--nodes", "10")


def test_the_shell_shares_stores_verifies_and_exports(tmp_path, shell):
    done = run(*LOBES, "--store", "s", "--processes", "2", "--out", "a", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.nc", "a.png", "s"]
    assert len(list((tmp_path / "s").glob("0*.nc"))) == 2
    chart = lobex.load(tmp_path / "a.nc")
    np.testing.assert_array_equal(Study.open(tmp_path / "s")["multiplier"], chart.multiplier)

    status = shell("store", "status", "s")
    assert "2 of 2, 100 %" in status.out
    assert "210 speed" in status.out
    assert "all chunks are there" in status.out
    # What is in them it does not say.
    assert "not compared; lobex store verify s does that" in status.out
    export = shell("store", "export", "s", "--out", "b.nc")
    assert export.code == 0, export.err
    np.testing.assert_array_equal(lobex.load(tmp_path / "b.nc").multiplier, chart.multiplier)

    victim = sorted((tmp_path / "s").glob("0*.nc"))[1]
    victim.write_bytes(victim.read_bytes()[:-1])
    verify = shell("store", "verify", "s")
    assert verify.code == 1
    assert "1 chunks are sound, 1 damaged, 0 missing" in verify.out
    refused = shell("store", "export", "s")
    assert refused.code == 2
    assert "chunk 1" in refused.err

    again = shell(*LOBES, "--store", "s", "--out", "c")
    assert again.code == 0
    assert "1 of 2 chunks" in again.err
    np.testing.assert_array_equal(lobex.load(tmp_path / "c.nc").multiplier, chart.multiplier)
    assert "2 chunks are sound" in shell("store", "verify", "s").out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("lobes", "rub", "--processes", "2"), "without --store"),
        (("lobes", "rub", "--store", "s", "--processes", "0"), "processes = 0"),
        (("lobes", "rub", "--store", "/proc/s"), "cannot be written"),
        (("limit", "rub", "--exact", "--store", "s"), "has no use with --exact"),
        (("limit", "rub", "--sensitivity", "--store", "s"), "has no use with --sensitivity"),
        (("limit", "rub", "--exact", "--over", "modes.damping_ratio=0.1"), "over = 'modes.damping_ratio=0.1' has no"),
        (("lobes", "rub", "--over", "modes.damping_ratio"), "over = 'modes.damping_ratio' is not NAME=VALUES"),
        (("lobes", "rub", "--over", "=0.1"), "over = '=0.1' is not NAME=VALUES"),
        (("lobes", "rub", "--over", "a=1", "a=2"), "over names 'a' twice"),
        (("lobes", "rub", "--over", "damping=0.1"), "over names 'damping', no number of the model; it has modes.ang"),
        (("lobes", "rub", "--over", "modes.damping_ratio=0.2,0.1"), "over['modes.damping_ratio'] = [0.2, 0.1] is not"),
        (("wear", "--over", "law.stiffness=1e6,nan"), "over['law.stiffness'] = "),
        (("wear", "--over", "law.stiffness=stiff"), "over['law.stiffness'] = 'stiff' is not low:high:count"),
        (("lobes", "rub", "--over", "modes.damping_ratio=-0.1,0.1"), "damping_ratio = [-0.1"),
        (("march", "rub", "--store", "s"), "--store"),
        (("store", "status", "nowhere"), "is not a folder"),
        (("store", "verify", "."), "has no manifest.json"),
        (("store", "export", "."), "has no manifest.json"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, shell):
    assert words in shell.refuses(*arguments)


def test_further_axes_of_the_shell_are_those_of_python(tmp_path, shell):
    rub = lobex.Rub(lobex.Rod(1).modes(0.03))
    over, speed = {"modes.damping_ratio": [0.02, 0.04]}, np.linspace(300, 700, 4)
    flags = ("--elements", "1", "--speed", "300:700:4", "--over", "modes.damping_ratio=0.02,0.04")
    lobes = shell("lobes", "rub", *flags, "--gain", "1e5:4e6:3", "--store", "s", "--out", "lobes")
    assert lobes.code == 0, lobes.err
    assert "2 modes.damping_ratio × 4 speed × 3 gain" in lobes.out
    limit = shell("limit", "rub", *flags, "--gain", "1e4:4e6:9", "--out", "limit")
    assert limit.code == 0, limit.err
    wear = shell("wear", *flags[:4], *("--revolutions", "1", "--steps", "64"), "--over", "law.stiffness=1e5:2e5:2")
    assert wear.code == 0, wear.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["limit.nc", "lobes.nc", "s", "wear.nc"]
    chart = lobex.sweep(rub, speed, np.linspace(1e5, 4e6, 3), over=over)
    np.testing.assert_array_equal(lobex.load(tmp_path / "lobes.nc")["multiplier"], chart["multiplier"])
    np.testing.assert_array_equal(Study.open(tmp_path / "s")["multiplier"], chart["multiplier"])
    gain = lobex.critical_gain(rub, speed, (1e4, 4e6), scan=9, over=over)["gain"]
    np.testing.assert_array_equal(lobex.load(tmp_path / "limit.nc")["gain"], gain)
    assert lobex.load(tmp_path / "wear.nc").over["law.stiffness"].tolist() == [1e5, 2e5]


def test_wear_and_limits_go_to_stores_too(tmp_path, shell):
    march = ("wear", "--speed", "100:300:40", "--revolutions", "2", "--steps", "512", "--elements", "2", "--store", "w")
    limits = ("limit", "rub", "--speed", "200:400:5", "--gain", "1e5:2e6:5", "--elements", "1", "--nodes", "6")
    for words in (march, (*limits, "--store", "l")):
        done = shell(*words, "--quiet")
        assert done.code == 0, done.err
    assert lobex.load(tmp_path / "wear.nc").depth.shape == (40, 512)
    chunk = next((tmp_path / "l").glob("0*.nc"))
    np.testing.assert_array_equal(lobex.load(tmp_path / "rub-limit.nc").gain, lobex.load(chunk).gain)
