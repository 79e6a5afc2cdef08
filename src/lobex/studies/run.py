"""Running a study: chunk after chunk, into memory or into a store, until all are there."""

import os
import time
import warnings
from dataclasses import replace
from typing import Any

import xarray
from tqdm import tqdm

from lobex._memory import check_memory
from lobex._timing import timed
from lobex._warnings import SweepWarning, warn
from lobex.results.saving import in_parts
from lobex.studies.blocks import InMemory, InStore
from lobex.studies.interruption import Interruption, postponed
from lobex.studies.manifest import manifest_of
from lobex.studies.plan import Plan, order_of_share, place_of_next, plan_of
from lobex.studies.processes import share_of
from lobex.studies.slabs import plain
from lobex.studies.store import Store
from lobex.studies.study import Study
from lobex.studies.task import COPIES, Task
from lobex.studies.variation import in_words, numbers_at
from lobex.studies.warned import Collected

# Frames between a user's call of a verb and what warns here.
_STACK = 3
# Looking up what is there may take a tenth of the time.
_PATIENCE = 10


def run_study(
    task: Task,
    store: str | os.PathLike[str] | None,
    processes: tuple[int, int] | None,
    progress: bool,
    further: bool,
) -> Any:
    """Compute what a store lacks of a study, or without a store all of it in memory.

    Returns:
        With ``further`` axes the ``Study``, else what the verb alone returns.

    Raises:
        ValueError: for a store that holds another study or cannot be written, and what the verb refuses.
        KeyboardInterrupt: after Ctrl-C, when the chunk in hand is stored; its text says what is there.
    """
    if processes is not None and store is None:
        raise ValueError(f"processes = {processes!r} share a study by its store; give store=, too")
    with timed() as spent:
        plan = plan_of(task.variation.axes, len(task.speed), task.lanes, task.bytes)
        collected = Collected()
        if store is None:
            check_memory(
                f"over and speed make {plan.combinations} × {plan.lanes} lanes",
                task.bytes / COPIES * plan.combinations * plan.lanes,
                "give fewer, or a store, which is never in memory as a whole: store=",
            )
            blocks: Any = InMemory(plan, _Work(task, plan, collected, progress).all())
        else:
            share = share_of(processes)
            manifest = manifest_of(plan, task.verb, task.variation.describe(), task.settings, task.speed)
            shared = Store.begin(store, manifest)
            _Work(task, shared.plan, collected, progress).missing_of(shared, *share)
            blocks = InStore(shared)
        collected.say(plan.chunks, _STACK)
        study = Study(task.verb, blocks, spent.seconds, spent.compiling)
        if further:
            return study
        check_memory(
            f"speed makes {plan.lanes} lanes, which are all in store = {str(store)!r}",
            2 * task.bytes / COPIES * plan.lanes,
            "read parts of it by lobex.Study.open",
        )
        result: Any = study.at()
        return replace(result, seconds=spent.seconds, compiling=spent.compiling)


class _Work:
    """The chunks of one call."""

    def __init__(self, task: Task, plan: Plan, collected: Collected, progress: bool) -> None:
        self.task, self.plan, self.collected = task, plan, collected
        self.models: dict[int, Any] = {}
        # None: a terminal has a bar, and a file or a pipe none.
        self.hidden = None if progress else True

    def all(self) -> dict[int, xarray.Dataset]:
        """Every chunk."""
        datasets = {}
        with self._bar(0) as bar:
            for number in range(self.plan.chunks):
                datasets[number] = plain(self._compute(number))
                bar.update(self._points(number))
        return datasets

    def missing_of(self, store: Store, process: int, processes: int) -> None:
        """The chunks of this process' share that the store lacks, then all that others have left."""
        names = store.present()
        self._drop_damaged(store, names, process, processes)
        if len(names) == self.plan.chunks:
            return
        store.check_writable()
        store.tidy()
        share = order_of_share(self.plan.chunks, process, processes)
        with postponed() as interruption, self._bar(sum(map(self._points, names))) as bar:
            for number in share:
                if number not in names:
                    names[number] = self._store(store, number, interruption, bar)
            self._rest(store, process, processes, interruption, bar)

    def _rest(self, store: Store, process: int, processes: int, interruption: Interruption, bar: Any) -> None:
        """What is missing when the own share is done, looked up again and again while others are at it as well."""
        missing: list[int] = []
        looked, cost = 0.0, 0.0
        while True:
            if not missing or time.perf_counter() - looked > _PATIENCE * cost:
                begun = time.perf_counter()
                names = store.present()
                missing = [number for number in range(self.plan.chunks) if number not in names]
                bar.n = sum(map(self._points, names))
                looked = time.perf_counter()
                cost = looked - begun
            if not missing:
                return
            self._store(store, missing.pop(place_of_next(len(missing), process, processes)), interruption, bar)

    def _store(self, store: Store, number: int, interruption: Interruption, bar: Any) -> str:
        name = store.write(number, self._compute(number))
        bar.update(self._points(number))
        if interruption.asked:
            done = len(store.present())
            interruption.stop(
                f"{done} of {self.plan.chunks} chunks are in {str(store.folder)!r}; run the same again to go on"
            )
        return name

    def _drop_damaged(self, store: Store, names: dict[int, str], process: int, processes: int) -> None:
        """Compare the checksums of this process' share: what does not agree is to be computed again."""
        damaged = [n for n in order_of_share(self.plan.chunks, process, processes) if n in names]
        damaged = [n for n in damaged if not store.intact(n, names[n])]
        for number in damaged:
            store.remove(names.pop(number))
        if damaged:
            warnings.warn(
                f"{len(damaged)} of {self.plan.chunks} chunks of the store {str(store.folder)!r} were damaged and are "
                f"computed again, the first chunk {damaged[0]}",
                SweepWarning,
                stacklevel=_STACK + 2,
            )

    def _compute(self, number: int) -> xarray.Dataset:
        """A chunk's dataset; what depends on the hour is left out, so that the same chunk is the same file."""
        combination, lanes = self.plan.chunk(number)
        if combination not in self.models:
            self.models = {combination: self.task.variation.at(combination)}
            with self.collected.listening():
                for message in self.task.implausible(self.models[combination]):
                    warn(message)
        try:
            with self.collected.listening():
                result: Any = self.task.compute(self.models[combination], self.task.speed[lanes])
        except ValueError as error:
            where = in_words(numbers_at(self.plan.axes, combination))
            raise ValueError(f"{error}{f'; at {where}' if where else ''}") from error
        return in_parts(replace(result, seconds=float("nan"), compiling=float("nan")).to_xarray())

    def _points(self, number: int) -> int:
        lanes = self.plan.chunk(number)[1]
        return (lanes.stop - lanes.start) * self.task.points

    def _bar(self, done: int) -> Any:
        total = self.plan.combinations * self.plan.lanes * self.task.points
        return tqdm(total=total, initial=done, unit="pt", unit_scale=True, disable=self.hidden, leave=False)
