"""How a study is cut into chunks: one combination of the further axes times a block of consecutive lanes."""

from dataclasses import dataclass

import numpy as np

from lobex._memory import available_memory
from lobex.studies.variation import Axes, shape_of

# Part of the memory left that the results of one chunk may take.
_SHARE = 1 / 8
# Lanes that the verbs work through together: smaller blocks are filled up with repeats.
_SLAB = 32


@dataclass(frozen=True)
class Plan:
    """The chunks of a study, in order: all blocks of the first combination, then of the second, and so on.

    Attributes:
        axes: the further axes, the last of which runs fastest.
        lanes: number of speeds.
        lanes_per_chunk: speeds of a block; the last one of a combination may have fewer.
    """

    axes: Axes
    lanes: int
    lanes_per_chunk: int

    @property
    def combinations(self) -> int:
        """Number of combinations of the further axes; 1 without any."""
        return int(np.prod(shape_of(self.axes), dtype=np.int64))

    @property
    def blocks(self) -> int:
        """Number of blocks of a combination."""
        return -(-self.lanes // self.lanes_per_chunk)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return self.combinations * self.blocks

    def chunk(self, number: int) -> tuple[int, slice]:
        """The combination and the lanes of a chunk."""
        combination, block = divmod(number, self.blocks)
        begin = block * self.lanes_per_chunk
        return combination, slice(begin, min(begin + self.lanes_per_chunk, self.lanes))


def plan_of(axes: Axes, lanes: int, wanted: int, bytes_per_lane: int) -> Plan:
    """Blocks of about ``wanted`` lanes and of equal size, or fewer where memory is short."""
    fitting = int(available_memory() * _SHARE / bytes_per_lane)
    most = max(min(wanted, fitting), 1)
    size = -(-lanes // -(-lanes // most))
    if size > _SLAB and size < lanes:
        size = min(-(-size // _SLAB) * _SLAB, max(most // _SLAB, 1) * _SLAB)
    return Plan(axes, lanes, size)
