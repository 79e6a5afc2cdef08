"""Wall time: what of it goes into compiling, in whatever threads that happens."""

import threading
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import pytest

import lobex
from lobex import _timing
from lobex._timing import Stopwatch, carried, timed


def compiled(number):
    """Have a program made that there was none of."""
    jax.jit(lambda x: jnp.sin(x) + number)(1.0).block_until_ready()


def test_compiling_counts_and_what_is_compiled_already_does_not():
    program = jax.jit(lambda x: jnp.cos(x) * 17.5)
    with timed() as first:
        program(1.0).block_until_ready()
    with timed() as second:
        program(1.0).block_until_ready()
    assert 0 < first.compiling < first.seconds
    assert second.compiling == 0


def test_time_in_which_several_threads_compile_counts_once():
    watch = Stopwatch()
    begun = watch._begun
    # Side by side, within each other, apart, and begun before the watch.
    for span in ((1.0, 3.0), (2.0, 4.0), (2.5, 2.6), (6.0, 7.0), (-1.0, 0.5)):
        watch.add(begun + span[0], begun + span[1])
    assert watch.compiling == pytest.approx(3.0 + 1.0 + 0.5)


def test_watches_see_their_own_threads_and_no_others():
    release, compiling = threading.Event(), threading.Event()

    def stranger():
        with timed() as watch:
            compiling.wait(60)
            compiled(21.5)
            release.set()
        return watch

    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(stranger)
        with timed() as outer:
            compiling.set()
            release.wait(60)
            with timed() as inner, ThreadPoolExecutor(1) as workers:
                assert inner.compiling == outer.compiling == 0
                list(workers.map(carried(compiled), [22.5]))
        assert inner.compiling > 0
        assert outer.compiling == inner.compiling
        assert other.result().compiling > 0


@pytest.mark.slow
def test_results_say_compiling_and_computing_apart():
    # Of as many modes as no other test has, so that nothing is compiled before.
    blade = lobex.Rub(lobex.Rod(14).modes(0.03))
    first, limit = (lobex.critical_gain(blade, [85.0, 112.0], (4.5e4, 4.5e6)) for _ in range(2))
    assert 0 < first.compiling < first.seconds
    assert 0 <= limit.compiling < limit.seconds
    computing = limit.seconds - limit.compiling
    text = f"{limit.seconds:.2f} s: compiling {limit.compiling:.2f} s, computing {computing:.2f} s ("
    assert f"wall time        {text}" in repr(limit)
    assert repr(limit).count("s a speed)") == 1


def test_one_listener_serves_all():
    with timed(), timed():
        pass
    assert _timing._listen.cache_info().currsize == 1
