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
from lobex.studies.processes import Children
from lobex.studies.study import Study
from shares_of_a_study import COUNT, work

# More than there are: two processes may write the same chunk.
ALL = 10 * COUNT
STUDY = Path(__file__).with_name("shares_of_a_study.py")
# Every process is a fork of one that has imported what the study needs, which takes longer than the study, and has not
# started JAX, which cannot be forked.
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(
    ["jax", "lobex", "lobex.verbs", "lobex.studies.charts", "lobex.studies.store", "h5netcdf.legacyapi"]
)


class Begun:
    """A process that works at the study, and what it has said so far."""

    def __init__(self, folder, share):
        handle, self.told = tempfile.mkstemp(suffix=".told", dir=folder.parent)
        os.close(handle)
        self.process = FORKS.Process(target=work, args=(str(folder), share, str(gate_of(folder)), self.told))
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


def begin(folder, share="0/1", chunks=ALL):
    """Start the study of this file, which may write so many chunks."""
    allow(folder, chunks)
    return Begun(folder, share)


def gate_of(folder):
    return folder.with_suffix(".gate")


def allow(folder, chunks):
    """Let so many chunks be written, all at once for whoever reads the number."""
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


def names(folder):
    """The files of a store; the names of chunks carry checksums, so that the same names are the same bits."""
    return sorted(path.name for path in folder.glob("[!.]*")) if folder.exists() else []


def wait_for(folder, least, process):
    """Until there are so many files."""
    while len(names(folder)) < least:
        ended = process.returncode is not None
        assert not ended or len(names(folder)) >= least, process.said
        time.sleep(0.005)


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


@pytest.mark.parametrize("shares", [("0/2", "1/2"), ("0/1", "0/1")], ids=["shared", "the same twice"])
def test_two_processes_make_what_one_makes(shares, uninterrupted, tmp_path):
    both = [begin(tmp_path / "s", share) for share in shares]
    for process in both:
        assert process.end() == 0, process.said
    assert names(tmp_path / "s") == uninterrupted


def test_one_of_two_completes_what_the_killed_one_leaves(uninterrupted, tmp_path):
    folder = tmp_path / "s"
    first, second = begin(folder, "0/2", chunks=COUNT // 2), begin(folder, "1/2", chunks=COUNT // 2)
    wait_for(folder, 3, second)
    second.send(signal.SIGKILL)
    second.end()
    allow(folder, ALL)
    assert first.end() == 0, first.said
    assert names(folder) == uninterrupted


def test_a_killed_share_is_completed_by_a_rerun_of_one(uninterrupted, tmp_path):
    folder = tmp_path / "s"
    process = begin(folder, "1/2", chunks=8)
    wait_for(folder, 5, process)
    process.send(signal.SIGKILL)
    process.end()
    assert "manifest.json" in names(folder)
    # It began with its own share, every second chunk.
    assert {int(name[:8]) % 2 for name in names(folder) if name != "manifest.json"} == {1}
    process = begin(folder, "0/1")
    assert process.end() == 0, process.said
    assert names(folder) == uninterrupted


def test_ctrl_c_keeps_what_is_done_and_says_so(uninterrupted, tmp_path):
    folder = tmp_path / "s"
    process = begin(folder, chunks=8)
    wait_for(folder, 4, process)
    process.send(signal.SIGINT)
    allow(folder, ALL)
    assert process.end() != 0
    done = len(names(folder)) - 1
    assert f"KeyboardInterrupt: {done} of {COUNT} chunks are in" in process.said
    assert set(names(folder)) <= set(uninterrupted)


def test_a_terminal_is_shown_the_rate_and_the_time_left(uninterrupted, tmp_path):
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 120, 0, 0))
    allow(tmp_path / "s", ALL)
    command = [sys.executable, STUDY, str(tmp_path / "s"), "0/1", str(gate_of(tmp_path / "s"))]
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


# Says when Python is up: a signal that comes before may be swallowed by what it then imports.
WAITING = """
import sys, time
from pathlib import Path
Path(sys.argv[-1].replace("/", "-of-")).touch()
while True:
    time.sleep(0.1)
"""


def test_children_end_when_this_process_fails_and_are_missed_when_they_do(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(KeyboardInterrupt), Children(["-c", WAITING], 3) as children:  # noqa: PT012
        while not {path.name for path in tmp_path.iterdir()} >= {"1-of-3", "2-of-3"}:
            assert all(child.poll() is None for child in children.running)
            time.sleep(0.005)
        raise KeyboardInterrupt
    assert [child.returncode for child in children.running] == [-signal.SIGINT] * 2
    with (
        pytest.warns(RuntimeWarning, match="process 1 of 2 ended with exit code 3; the others did its share"),
        Children(["-c", "import sys; sys.exit(3 * (sys.argv[1:] == ['--process', '1/2']))"], 2),
    ):
        pass


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

    again = shell(*LOBES, "--store", "s", "--process", "1/2", "--out", "c")
    assert again.code == 0
    assert "1 of 2 chunks" in again.err
    # Process 0 writes.
    assert not (tmp_path / "c.nc").exists()
    assert "2 chunks are sound" in shell("store", "verify", "s").out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("lobes", "rub", "--processes", "2"), "without --store"),
        (("lobes", "rub", "--process", "0/2"), "without --store"),
        (("lobes", "rub", "--store", "s", "--process", "2/2"), "give a number from 0 to 1"),
        (("lobes", "rub", "--store", "s", "--process", "half"), "process = 'half'"),
        (("lobes", "rub", "--store", "s", "--processes", "0"), "processes = 0"),
        (("lobes", "rub", "--store", "/proc/s"), "cannot be written"),
        (("limit", "rub", "--exact", "--store", "s"), "has no use with --exact"),
        (("limit", "rub", "--sensitivity", "--store", "s"), "has no use with --sensitivity"),
        (("march", "rub", "--store", "s"), "--store"),
        (("store", "status", "nowhere"), "is not a folder"),
        (("store", "verify", "."), "has no manifest.json"),
        (("store", "export", "."), "has no manifest.json"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, shell):
    assert words in shell.refuses(*arguments)


def test_wear_and_limits_go_to_stores_too(tmp_path, shell):
    march = ("wear", "--speed", "100:300:40", "--revolutions", "2", "--steps", "512", "--elements", "2", "--store", "w")
    limits = ("limit", "rub", "--speed", "200:400:5", "--gain", "1e5:2e6:5", "--elements", "1", "--nodes", "6")
    for words in (march, (*limits, "--store", "l")):
        done = shell(*words, "--quiet")
        assert done.code == 0, done.err
    assert lobex.load(tmp_path / "wear.nc").depth.shape == (40, 512)
    chunk = next((tmp_path / "l").glob("0*.nc"))
    np.testing.assert_array_equal(lobex.load(tmp_path / "rub-limit.nc").gain, lobex.load(chunk).gain)
