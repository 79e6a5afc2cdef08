"""Fewer samples without aliasing: a low-pass filter on the device, revolution by revolution.

The filter is a Kaiser-windowed sinc of 80 dB, as long as ten output samples. It passes the lower half of the
band that the output can hold, and stops what would alias into that half; the upper half is not to be used.
"""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from lobex._shapes import AnyArray

LENGTH = 10
"""Length of the filter, in output samples; the output lags by half of it."""
_ATTENUATION = 80.0
_TILE = 16


def factor_for(steps: int, samples: int) -> int:
    """The largest divisor of ``steps`` that leaves at least ``samples`` of them."""
    return max(m for m in range(1, max(steps // samples, 1) + 1) if steps % m == 0)


def usable_orders(steps: int, factor: int) -> int:
    """Engine orders up to which samples taken every ``factor`` of ``steps`` per revolution are right."""
    return steps // (4 * factor) if factor > 1 else steps // 2


def lag_of(factor: int) -> int:
    """How many output samples the output is late."""
    return LENGTH // 2 if factor > 1 else 0


def filter_matrix(steps: int, factor: int) -> np.ndarray:
    """The filter as a matrix from a stretch of input to a tile of output samples."""
    from scipy.signal import firwin, kaiser_beta

    window: Any = ("kaiser", kaiser_beta(_ATTENUATION))
    taps = np.asarray(firwin(LENGTH * factor + 1, 1 / factor, window=window))
    tile = max(t for t in range(1, _TILE + 1) if (steps // factor) % t == 0)
    matrix = np.zeros((tile, (tile - 1) * factor + len(taps)))
    for row in range(tile):
        matrix[row, row * factor : row * factor + len(taps)] = taps
    return matrix


def decimate(
    matrix: Float[AnyArray, "tile stretch"],
    factor: int,
    tail: Float[AnyArray, "tail lanes"],
    signal: Float[AnyArray, "steps lanes"],
) -> Float[Array, "samples lanes"]:
    """Every ``factor``-th sample of the filtered ``signal`` (steps, lanes) that follows ``tail``.

    ``tail`` is (LENGTH · factor, lanes), the end of the signal before. Sample j is centred LENGTH/2 samples before
    step j · factor.
    """
    rows = matrix.shape[0]
    extended = jnp.concatenate([tail, signal])
    starts = jnp.arange(signal.shape[0] // (rows * factor)) * (rows * factor)
    tiles = jax.lax.map(partial(_tile, matrix, extended), starts)
    return tiles.reshape(-1, signal.shape[1])


def _tile(
    matrix: Float[AnyArray, "tile stretch"], extended: Float[Array, "steps lanes"], start: Int[Array, ""]
) -> Float[AnyArray, "tile lanes"]:
    return matrix @ jax.lax.dynamic_slice_in_dim(extended, start, matrix.shape[1])
