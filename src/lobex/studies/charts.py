"""``sweep``, with further axes and a store: each chunk is a sweep of its own."""

from typing import Any

from lobex.characteristic.method import CharacteristicRoots
from lobex.grids import sweep as grids
from lobex.grids.choice import AUTO, AnyMethod, chosen_method
from lobex.operators.duhamel import Duhamel
from lobex.processes.plausible import implausible
from lobex.processes.process import Process
from lobex.results.chart import Chart
from lobex.studies.studied import studied
from lobex.studies.task import AnyExecutor, Over, Path, Task
from lobex.studies.variation import Variation, axes_of

# Points of a chunk: about a second's work on two cores, and slabs enough for every core.
_BY_ROOTS, _BY_DUHAMEL, _BY_OPERATORS = 2**18, 2**17, 2**14
# A point's multiplier, its modulus, its chatter frequency and its error.
_BYTES = 40


@studied(grids.sweep)
def sweep(
    process: Any,
    speed: Any,
    gain: Any,
    method: AnyMethod = AUTO,
    *,
    over: Over | None = None,
    store: Path | None = None,
    executor: AnyExecutor | None = None,
    progress: bool = False,
) -> Task:
    """The dominant Floquet multiplier and its chatter frequency over a grid: a stability lobe diagram.

    By default, where the coefficients are constant and there are one force and one delay, by the roots of the
    characteristic equation (``CharacteristicRoots()``), and else by operators with as many nodes at every point
    as its estimated error asks for (``Duhamel(tolerance=1e-8)``). Operators' multipliers come from their powers
    and are checked against the equations; points that do not settle get more powers, then the dense eigensolver.
    Runs on all cores, in float64 whatever JAX' setting.

    With ``over``, any numbers of the model are further axes and the result is a ``Study`` of shape
    (axes…, n, m)::

        lobex.sweep(rub, speed, gain, over={"modes.damping_ratio": [0.01, 0.02, 0.03]}, store="study")
        lobex.sweep(lambda p: lobex.Rub(lobex.Rod(young_modulus=p["E"]).modes()), speed, gain, over={"E": [2e9, 3e9]})

    A name is the path of a number, as ``sensitivities`` names them; without its index, it stands for all numbers of
    that array at once. Of a function ``process``, the names are those that it takes.

    With ``store``, chunks of a second or so go to that folder one by one. What ends the call, be it Ctrl-C, a full
    disk or the machine, costs the chunk in hand; the same call goes on from there. With ``executor``, other processes
    and machines compute the chunks (docs/cluster.md). A study in a store is read when asked for and never in memory as
    a whole.

    Args:
        process: a process, such as ``Rub(modes)``, or with ``over`` a function of a dictionary of numbers.
        speed: increasing speeds, Hz (revolutions per second), shape (n,).
        gain: increasing gains, shape (m,): K_e in N/m or depth of cut in m.
        method: ``Auto()``, ``CharacteristicRoots()``, ``Duhamel(…)``, ``Chebyshev(…)`` or ``SemiDiscretization(…)``.
        over: increasing values of further axes, by name.
        store: folder of the study: a new one, an empty one, or one that holds the same study.
        executor: who computes the chunks in place of this process: any ``concurrent.futures.Executor`` whose
            processes are not forked, or a ``dask.distributed.Client``. All of them must see the store's folder.
        progress: show a progress bar on standard error; with ``over`` or ``store``, if that is a terminal.

    Returns:
        A ``Chart`` of shape (n, m), or with ``over`` a ``Study``.

    Raises:
        ValueError: for a grid that is empty, not increasing, not one-dimensional or not finite, for speeds
            not above zero and gains that the process cannot have, for names that the model does not have, for a store
            of another study, a folder that cannot be written, and an executor that forks or whose workers die.

    Warns:
        SweepWarning: when points failed (they are NaN), or miss the tolerance, when the method's samples are too
            few to follow the first mode at the lowest speed, or when chunks of the store were damaged (they are
            computed again).
        LobexWarning: for numbers that can hardly be meant: speeds in rpm, damping in per cent, depths in mm.
    """
    variation = Variation({"process": process}, axes_of(over, "sweep"))
    first = variation.at(0)["process"]
    speeds, gains = grids.checked(first, speed, gain, method)
    return Task(
        verb="sweep",
        variation=variation,
        speed=speeds,
        settings={"gain": gains, "method": method},
        compute=_chart,
        implausible=lambda model: implausible(model["process"], speeds, gains),
        points=len(gains),
        lanes=max(_points_of_a_chunk(method, first, float(speeds[0])) // len(gains), 1),
        bytes=_BYTES * len(gains),
    )


def _chart(**arguments: Any) -> Chart:
    return grids.sweep(**arguments, plausible=False)


def _points_of_a_chunk(method: Any, process: Process, speed: float) -> int:
    method = chosen_method(method, process, speed)
    if isinstance(method, CharacteristicRoots):
        return _BY_ROOTS
    return _BY_DUHAMEL if isinstance(method, Duhamel) else _BY_OPERATORS
