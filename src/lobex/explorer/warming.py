"""Programs of the sizes that a search may take next, compiled while nothing is asked for."""

from collections.abc import Iterator

import numpy as np

from lobex._float64 import at_once, widened
from lobex.explorer.curves import speeds_of
from lobex.explorer.recipes import process_of, recipe_of
from lobex.explorer.state import State
from lobex.grids.node_counts import node_counts
from lobex.limits.critical import critical_gain
from lobex.operators.duhamel import Duhamel

# Sizes beside those in use: of slower speeds and quicker modes come more nodes.
_FEWER, _MORE = 1, 2
_SPEEDS, _SCAN = 4, 5
_done: set[tuple[object, int]] = set()


def warmed(state: State) -> Iterator[None]:
    """Compile, size by size, what a search takes that needs other numbers of nodes than this state's.

    Numbers of nodes follow from numbers, and programs from them: moved far, a slider would come to a size of which
    there is no program yet.
    """
    process, speeds = process_of(state), speeds_of(state.view)
    with at_once():
        found = node_counts(
            widened(process), Duhamel(), speeds, np.full(len(speeds), state.view.scan), np.min, Duhamel().tolerance
        )
    first, last = int(found.first.min()) - _FEWER, int(found.first.max()) + _MORE
    bounds = (state.view.gain_low, state.view.gain_high)
    few = np.linspace(state.view.speed_low, state.view.speed_high, _SPEEDS)
    # Of what is alike but for its numbers, the programs are the same.
    alike = recipe_of(state).sizes
    for nodes in found.sizes[max(first, 0) : last + 1]:
        if (alike, nodes) not in _done:
            _done.add((alike, nodes))
            critical_gain(process, few, bounds, Duhamel(nodes=nodes), scan=_SCAN, plausible=False)
        yield
