"""Studies on a dask cluster: workers and schedulers that are killed, names, threads, interruptions, and the shell."""

import asyncio
import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import lobex
from lobex.studies.study import Study
from refusals import refused
from stored_study import COUNT, before_each_chunk, results, study

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

METHOD = lobex.Chebyshev(16)


@pytest.fixture(scope="module")
def cluster():
    # Workers are spawned, which is dask's default, and one that dies is started anew. The port is any that is free.
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as made:
        yield made


@pytest.fixture(scope="module")
def client(cluster):
    with distributed.Client(cluster) as made:
        yield made


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "s"
    study(folder)
    return results(folder)


def assert_sound(folder, uninterrupted, complete=True):
    """Every chunk holds the same bits. Dask's profiler holds on to what is being written, and HDF5 may then lay out
    the same numbers otherwise, so that the files' names need not be the same.
    """
    found = results(folder)
    assert (len(found) == COUNT) == complete
    for number, dataset in found.items():
        assert dataset.identical(uninterrupted[number])


def kill_at(numbers, victims):
    """Before one of these chunks is handed over, a process that ``victims()`` tells is killed."""

    left = set(numbers)

    def kill(number):
        # Once each: what a worker that died had in hand may be handed over again.
        if number in left:
            left.remove(number)
            os.kill(victims()[0], signal.SIGKILL)

    return before_each_chunk(kill)


@pytest.mark.slow
def test_workers_make_what_this_process_makes_and_their_tasks_say_what_they_are(client, uninterrupted, tmp_path):
    with distributed.get_task_stream(client) as stream:
        study(tmp_path / "s", client)
    assert_sound(tmp_path / "s", uninterrupted)
    told = [re.fullmatch(r"sweep-chunk-(\d+)-[0-9a-f]{8}", task["key"]) for task in stream.data]
    assert sorted(int(key[1]) for key in told if key) == list(range(COUNT))
    # What the dashboard puts together.
    assert {dask.utils.key_split(task["key"]) for task in stream.data} == {"sweep-chunk"}


@pytest.mark.slow
def test_xla_is_told_the_threads_of_a_worker(client):
    assert set(client.run(xla_threads).values()) == {1}


def xla_threads():
    return sum("XLAEigen" in path.read_text() for path in Path("/proc/self/task").glob("*/comm"))


@pytest.mark.slow
def test_functions_in_a_model_are_sent(client):
    rate = 0.5
    equation = lobex.LinearDelay([[-1.0]], [(lambda t, speed, gain: rate * gain, None)])
    over, grid = {"a": [1.0, 2.0]}, ([0.5, 0.6], [0.1, 0.2])
    there = lobex.sweep(lambda numbers: equation, *grid, METHOD, over=over, executor=client)
    here = lobex.sweep(equation, *grid, METHOD)
    np.testing.assert_array_equal(there["multiplier"][1], here.multiplier)


@pytest.mark.slow
def test_a_killed_worker_loses_no_chunk(client, uninterrupted, tmp_path):
    with kill_at((5,), lambda: list(client.run(os.getpid).values())):
        study(tmp_path / "s", client)
    assert_sound(tmp_path / "s", uninterrupted)


@pytest.mark.slow
def test_an_interruption_takes_back_what_has_not_begun(client, uninterrupted, tmp_path):
    def interrupt(number):
        if number == 12:
            signal.raise_signal(signal.SIGINT)

    folder = tmp_path / "s"
    with pytest.raises(KeyboardInterrupt, match=rf"\d+ of {COUNT} chunks are in"), before_each_chunk(interrupt):
        study(folder, client)
    assert_sound(folder, uninterrupted, complete=False)
    study(folder, client)
    assert_sound(folder, uninterrupted)


class Scheduler:
    """A scheduler and a worker, in processes of their own."""

    def __init__(self, folder):
        told = folder / "scheduler.json"
        told.unlink(missing_ok=True)
        parts = {"scheduler": ["--port", "0", "--no-dashboard"], "worker": ["--nthreads", "1", "--no-dashboard"]}
        self.running = [
            subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{part}", "--scheduler-file", told, *words],
                stderr=subprocess.DEVNULL,
                cwd=folder,
            )
            for part, words in parts.items()
        ]
        self.client = distributed.Client(scheduler_file=str(told), timeout=20)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.client.close(timeout=5)
        for process in self.running:
            process.kill()
            process.wait()


@pytest.mark.slow
def test_a_study_whose_scheduler_is_killed_is_completed_by_the_same_call(uninterrupted, tmp_path):
    folder = tmp_path / "s"
    with (
        Scheduler(tmp_path) as first,
        kill_at((12,), lambda: [first.running[0].pid]),
        refused("executor = dask Client"),
    ):
        study(folder, first.client)
    assert_sound(folder, uninterrupted, complete=False)
    with Scheduler(tmp_path) as second:
        study(folder, second.client)
    assert_sound(folder, uninterrupted)


def kill_some(running, random, killed, done):
    """Two workers and then the scheduler, at moments drawn by chance, unless the study is ``done`` before."""
    for part in ("worker", "worker", "scheduler"):
        while not workers_of(running) and not done.wait(0.01):
            pass
        if done.wait(random.uniform(0.5, 2.5)):
            return
        for victim in workers_of(running) if part == "worker" else [running.running[0].pid]:
            os.kill(victim, signal.SIGKILL)
            killed[part] += 1


def workers_of(running):
    """The processes that compute, once the scheduler knows them: a nanny gives up those that die before."""
    return list(running.client.run(os.getpid, on_error="ignore").values())


@pytest.mark.slow
def test_ten_killed_workers_and_five_killed_schedulers_lose_nothing(uninterrupted, tmp_path):
    folder, random, killed = tmp_path / "s", np.random.default_rng(11), {"worker": 0, "scheduler": 0}
    while killed["worker"] < 10 or killed["scheduler"] < 5:
        # Some chunks anew, if need be, for the next to be killed at.
        for path in sorted(folder.glob("0*.nc"))[::2]:
            path.unlink()
        with Scheduler(tmp_path) as running, before_each_chunk(lambda number: time.sleep(0.4)):
            done = threading.Event()
            murderer = threading.Thread(target=kill_some, args=(running, random, killed, done))
            murderer.start()
            with contextlib.suppress(ValueError):
                study(folder, running.client)
            done.set()
            murderer.join()
    with Scheduler(tmp_path) as running:
        study(folder, running.client)
    assert_sound(folder, uninterrupted)


# 210 speeds and 100 gains of a method by operators are two chunks.
LOBES = ("lobes", "rub", "--elements", "1", "--speed", "700:1400:210", "--gain", "0:4e6:100", "--nodes", "10")


@pytest.mark.slow
def test_the_shell_hands_its_chunks_to_a_scheduler(cluster, tmp_path, shell):
    done = shell(*LOBES, "--store", "s", "--dask", cluster.scheduler_address, "--out", "a")
    assert done.code == 0, done.err
    assert len(list((tmp_path / "s").glob("0*.nc"))) == 2
    chart = lobex.load(tmp_path / "a.nc")
    np.testing.assert_array_equal(Study.open(tmp_path / "s")["multiplier"], chart.multiplier)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--dask", "tcp://localhost:1"), "dask = 'tcp://localhost:1' has no scheduler"),
        (("--dask", "nowhere://x"), "dask = 'nowhere://x' has no scheduler"),
        (("--dask", "tcp://localhost:1", "--processes", "2"), "drop one of --processes and --dask"),
    ],
)
def test_what_is_no_scheduler_is_refused(words, told, shell):
    with dask.config.set({"distributed.comm.timeouts.connect": "1s"}):
        assert told in shell.refuses("lobes", "rub", "--store", "s", *words)


def test_without_dask_its_extra_is_named(shell, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    told = shell.refuses("lobes", "rub", "--store", "s", "--dask", "tcp://localhost:1")
    assert "pip install 'lobex[cluster]'" in told


@pytest.mark.slow
def test_an_asynchronous_client_is_refused(cluster, tmp_path):
    async def call():
        async with distributed.Client(cluster.scheduler_address, asynchronous=True) as client:
            with refused("executor is an asynchronous dask Client"):
                study(tmp_path / "s", client)

    asyncio.run(call())
