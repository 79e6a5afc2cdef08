"""Running a study: its chunks, as they are sent to whoever computes them, until all are in memory or in a store."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import jax
import numpy as np
import xarray
from tqdm import tqdm

from lobex._memory import check_memory
from lobex._timing import timed
from lobex._warnings import LobexWarning, SweepWarning, Warned, heard, warn
from lobex.results.description import describe
from lobex.results.saving import in_this_process
from lobex.studies.assembly import assembled
from lobex.studies.engine import Call, Engine, ended, engine_of
from lobex.studies.interruption import Interruption, postponed
from lobex.studies.manifest import manifest_of
from lobex.studies.plan import Plan, plan_of
from lobex.studies.store import Place, Store
from lobex.studies.study import Study
from lobex.studies.task import AnyExecutor, Result, Task
from lobex.studies.variation import in_words, numbers_at
from lobex.studies.warned import Collected

# About so often the results of a chunk are held while it is computed and written, and those of a study.
_COPIES, _HELD = 4, 2


def computed(
    number: int, where: str, compute: Callable[..., Result], arguments: dict[str, Any], place: Place | None
) -> tuple[xarray.Dataset, list[Warned]]:
    """Compute a chunk: its dataset, empty once that is written to its place, and what was warned of.

    What depends on the hour is left out of it, so that the same chunk is the same file.

    Args:
        number: of the chunk.
        where: the combination of the further axes in words, for errors.
        compute, arguments: the verb, and what it takes by name.
        place: where it goes to; None for back to whoever asked.

    Raises:
        ValueError: what the verb refuses, and a place that cannot be written.
    """
    with heard() as warned:
        try:
            result: Any = compute(**arguments)
        except ValueError as error:
            raise ValueError(f"{error}{f'; at {where}' if where else ''}") from error
        dataset = replace(result, seconds=float("nan"), compiling=float("nan")).to_xarray()
    if place is None:
        return dataset, warned
    place.write(number, dataset)
    return xarray.Dataset(), warned


def run_study(
    task: Task,
    store: str | os.PathLike[str] | None,
    executor: AnyExecutor | None,
    progress: bool,
    further: bool,
) -> Any:
    """Compute what a store lacks of a study, or without a store all of it in memory.

    Returns:
        With ``further`` axes the ``Study``, else what the verb alone returns.

    Raises:
        ValueError: for a store that holds another study or cannot be written, an executor that is none or went away,
            and what the verb refuses.
        KeyboardInterrupt: after Ctrl-C, when the chunks in hand are stored; its text says what is there.
    """
    engine = engine_of(executor)
    with timed() as spent:
        plan = plan_of(task.variation.axes, len(task.speed), task.lanes, _COPIES * task.bytes)
        if store is None:
            check_memory(
                f"over and speed make {plan.combinations} × {plan.lanes} lanes",
                _HELD * task.bytes * plan.combinations * plan.lanes,
                "give fewer, or a store, which is never in memory as a whole: store=",
            )
            work = _Work(task, plan, engine, None, progress)
            chunks = dict(work.computed(range(plan.chunks)))
            with in_this_process():
                dataset = assembled(task.verb, plan, task.speed, chunks.__getitem__).load()
            study = Study(dataset)
        else:
            settings = {name: describe(value) for name, value in task.settings.items()}
            manifest = manifest_of(plan, task.verb, task.variation.describe(), settings, task.speed)
            shared = Store.begin(store, manifest)
            work = _Work(task, shared.plan, engine, shared, progress)
            work.complete(shared)
            study = Study.open(store)
        work.collected.say(work.plan.chunks)
        if further:
            return replace(study, seconds=spent.seconds, compiling=spent.compiling)
        check_memory(
            f"speed makes {plan.lanes} lanes, which are all in store = {str(store)!r}",
            _HELD * task.bytes * plan.lanes,
            "read parts of it by lobex.Study.open",
        )
        result: Any = study.at()
        return replace(result, seconds=spent.seconds, compiling=spent.compiling)


class _Work:
    """The chunks of one call."""

    def __init__(self, task: Task, plan: Plan, engine: Engine, store: Store | None, progress: bool) -> None:
        self.task, self.plan, self.engine, self.store = task, plan, engine, store
        self.collected = Collected()
        # Chunks come combination by combination.
        self.model_at = lru_cache(1)(self._model_at)
        # None: a terminal has a bar, and a file or a pipe none.
        self.hidden = None if progress else True

    def complete(self, store: Store) -> None:
        """Compute the chunks that a store lacks, and those that are damaged."""
        with postponed() as interruption:
            names = store.present()
            self._drop_damaged(store, names, interruption)
            missing = [number for number in range(self.plan.chunks) if number not in names]
            if missing and not interruption.asked:
                store.check_writable()
                store.tidy()
                for _ in self.computed(missing, interruption, sum(map(self._points, names))):
                    pass
                # Of those that died.
                store.tidy()
            if interruption.asked:
                raise KeyboardInterrupt(
                    f"{len(store.present())} of {self.plan.chunks} chunks are in {str(store.folder)!r}; run the same "
                    "again to go on"
                )

    def computed(
        self, numbers: Any, interruption: Interruption | None = None, done: int = 0
    ) -> Iterator[tuple[int, xarray.Dataset]]:
        """Chunks by number, as they end; empty ones if they went to the store."""
        total = self.plan.combinations * self.plan.lanes * self.task.points
        label, interruption = f"{self.task.verb}-chunk", interruption or Interruption()
        chunks = ended(self.engine, label, numbers, self._chunk, interruption)
        with tqdm(total=total, initial=done, unit="pt", unit_scale=True, disable=self.hidden, leave=False) as bar:
            for number, (dataset, warned) in chunks:
                self.collected.add(warned)
                bar.update(self._points(number))
                yield number, dataset

    def _drop_damaged(self, store: Store, names: dict[int, str], interruption: Interruption) -> None:
        """Compare all checksums: what does not agree is to be computed again."""

        def compared(number: int) -> Call:
            return partial(store.place.intact, names[number])

        found = ended(self.engine, f"{self.task.verb}-checksum", sorted(names), compared, interruption)
        damaged = sorted(number for number, sound in found if not sound)
        for number in damaged:
            store.remove(names.pop(number))
        if damaged:
            warn(
                f"{len(damaged)} of {self.plan.chunks} chunks of the store {str(store.folder)!r} were damaged and are "
                f"computed again, the first chunk {damaged[0]}",
                SweepWarning,
            )

    def _chunk(self, number: int) -> Call:
        combination, lanes = self.plan.chunk(number)
        arguments = {**self.model_at(combination), "speed": self.task.speed[lanes], **self.task.settings}
        where = in_words(numbers_at(self.plan.axes, combination))
        place = None if self.store is None else self.store.place
        return partial(computed, number, where, self.task.compute, arguments, place)

    def _model_at(self, combination: int) -> dict[str, Any]:
        model = jax.tree.map(_sent, self.task.variation.at(combination))
        self.collected.add((LobexWarning, message) for message in self.task.implausible(model))
        return model

    def _points(self, number: int) -> int:
        lanes = self.plan.chunk(number)[1]
        return (lanes.stop - lanes.start) * self.task.points


def _sent(leaf: Any) -> Any:
    """A number of a model as it is sent: to take an array of JAX would start JAX, before a worker is told how."""
    return np.asarray(leaf) if isinstance(leaf, jax.Array) else leaf
