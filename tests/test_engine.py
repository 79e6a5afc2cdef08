"""Who computes the chunks of a study: threads, executors that lose workers, and what is no executor."""

import multiprocessing
import random
import signal
import threading
import warnings
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lobex
from lobex._warnings import heard, warn
from lobex.studies.engine import Engine, ended
from lobex.studies.interruption import Interruption, postponed
from refusals import refused

METHOD = lobex.Chebyshev(16)
SPEED, GAIN = np.linspace(300, 700, 5), np.linspace(0, 4e6, 4)
RUB = lobex.Rub(lobex.Rod(2).modes(0.03))
OVER = {"modes.damping_ratio": [0.01, 0.02, 0.03, 0.05]}


class Mortal(Executor):
    """Calls that end in an order drawn by chance, and at times with all that are under way lost."""

    def __init__(self, seed, deaths, likely=0.3):
        self.random, self.deaths, self.likely = random.Random(seed), deaths, likely
        self.under_way, self.lock, self.thread = [], threading.Lock(), ThreadPoolExecutor(1)

    def submit(self, fn, /, *arguments):
        future = Future()
        with self.lock:
            self.under_way.append((future, fn, arguments))
        self.thread.submit(self.step)
        return future

    def step(self):
        """End one of the calls or lose all: there are never more of them than steps to come."""
        with self.lock:
            lost = []
            if self.deaths and self.random.random() < self.likely:
                self.deaths -= 1
                lost, self.under_way = self.under_way, []
            ended = [self.under_way.pop(self.random.randrange(len(self.under_way)))] if self.under_way else []
        for future, *_ in lost:
            future.set_exception(BrokenExecutor("a worker died"))
        for future, fn, arguments in ended:
            future.set_result(fn(*arguments))


@given(calls=st.integers(0, 40), ahead=st.integers(1, 8), deaths=st.integers(0, 3), seed=st.integers(0, 2**32))
def test_every_call_ends_once_whatever_dies(calls, ahead, deaths, seed):
    pool = Mortal(seed, deaths)
    engine = Engine(pool)
    engine.ahead = ahead
    found = dict(ended(engine, "square", range(calls), lambda n: partial(pow, n, 2), Interruption()))
    pool.thread.shutdown()
    assert found == {number: number**2 for number in range(calls)}
    assert pool.under_way == []


def test_calls_whose_workers_always_die_end_the_study():
    with refused("executor = Mortal lost its workers 4 times in a row, the last time at root 0 (a worker died)"):
        list(ended(Engine(Mortal(0, 10**6, 1.0)), "root", [0], lambda n: partial(abs, n), Interruption()))


def test_threads_make_what_this_process_makes():
    alone = lobex.sweep(RUB, SPEED, GAIN, METHOD, over=OVER)
    with ThreadPoolExecutor(2) as pool:
        shared = lobex.sweep(RUB, SPEED, GAIN, METHOD, over=OVER, executor=pool)
        chart = lobex.sweep(RUB, SPEED, GAIN, METHOD, executor=pool)
    for name in alone.names:
        np.testing.assert_array_equal(shared[name], alone[name])
    np.testing.assert_array_equal(chart.multiplier, lobex.sweep(RUB, SPEED, GAIN, METHOD).multiplier)


@pytest.mark.slow
def test_warnings_of_threads_are_said_once_and_the_others_are_left():
    def at_most_one(a, t, speed, gain):
        return jnp.where(a > 1, jnp.nan, gain)

    def fails(numbers):
        return lobex.LinearDelay([[-1.0]], [(jax.tree_util.Partial(at_most_one, numbers["a"]), None)])

    over = {"a": [1.0, 2.0, 3.0]}
    with (
        ThreadPoolExecutor(3) as pool,
        pytest.warns(lobex.SweepWarning, match=r"failed and are NaN.*first of 2 such warnings in 3 chunks"),
    ):
        lobex.sweep(fails, [0.5, 0.6], [0.1, 0.2], METHOD, over=over, executor=pool)
    filters, show = list(warnings.filters), warnings.showwarning
    with heard() as first, ThreadPoolExecutor(1) as pool:
        warn("to the first")
        with heard() as second:
            warn("to the second")
        # Nobody listens in this thread.
        with pytest.raises(UserWarning, match="aside"):
            pool.submit(warnings.warn, "aside", UserWarning).result()
    assert [text for _, text in first] == ["to the first"]
    assert [text for _, text in second] == ["to the second"]
    assert (warnings.filters, warnings.showwarning) == (filters, show)


def test_an_interruption_begins_no_more_calls():
    begun = []

    def interrupted(number):
        begun.append(number)
        if number == 3:
            signal.raise_signal(signal.SIGINT)
        return partial(abs, number)

    with postponed() as interruption, ThreadPoolExecutor(1) as pool:
        engine = Engine(pool)
        engine.ahead = 2
        found = [number for number, _ in ended(engine, "n", range(9), interrupted, interruption)]
    assert begun == [0, 1, 2, 3]
    assert set(found) <= {0, 1, 2, 3}


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: 4, "executor = 4 is none; give a concurrent.futures.Executor"),
        (lambda: (0, 2), "executor = (0, 2) is none"),
        (lambda: ProcessPoolExecutor(1, multiprocessing.get_context("fork")), "ProcessPoolExecutor forks"),
    ],
)
def test_what_is_no_executor_for_jax_is_refused(make, words):
    with refused(words):
        lobex.sweep(RUB, SPEED, GAIN, METHOD, executor=make())


def test_a_pool_that_is_closed_and_a_model_that_cannot_be_sent_are_refused_in_one_line():
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with refused("executor = ThreadPoolExecutor takes no more work (cannot schedule new futures after shutdown)"):
        lobex.sweep(RUB, SPEED, GAIN, METHOD, executor=pool)
    equation = lobex.LinearDelay([[-1.0]], [(lambda t, speed, gain: gain, None)])
    with (
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool,
        refused("executor = ProcessPoolExecutor cannot send the model to another process"),
    ):
        lobex.sweep(equation, [0.5, 0.6], [0.1, 0.2], METHOD, executor=pool)
