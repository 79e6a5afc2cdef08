"""What a short piece makes of forces, by the structure's kernel at a few points of it.

While the modes turn by little over a piece, exp(A t) is a polynomial to the last digits, and Duhamel's integral a sum
over its values at Gauss points, with weights that are the same for any structure and any length.
"""

from functools import lru_cache
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray, Number
from lobex.operators.exponential import exponential
from lobex.operators.moments import legendre_values
from lobex.systems.coefficients import gauss_nodes


class Kernel(NamedTuple):
    """exp(A t) at K Gauss points of a piece with q nodes.

    Attributes:
        duration: of the piece, s.
        free: exp(A t), (K, n, s, s).
        through: the same at the end, (n, s, s).
        forced: exp(A t) E, (K, n, s, e).
        nodes: q.
    """

    duration: Number
    free: Float[Array, "K n s s"]
    through: Float[Array, "n s s"]
    forced: Float[Array, "K n s e"]
    nodes: int

    def seen(
        self, outputs: Float[AnyArray, "n r s"], points: np.ndarray
    ) -> tuple[Float[Array, "pr d"], Float[Array, "pr qe"]]:
        """Outputs at points, from 0 to 1, of the start state and of the forces at the nodes."""
        count, n, s, e = jnp.shape(self.forced)
        between, weights = _weights(self.nodes, tuple(points), count)
        rows = len(points) * jnp.shape(outputs)[1]
        free = jnp.einsum("pk,krna->prna", between, jnp.einsum("nrs,knsa->krna", outputs, self.free))
        forced = jnp.einsum("pjk,kre->prje", weights, jnp.einsum("nrs,knse->kre", outputs, self.forced))
        return free.reshape(rows, n * s), jnp.multiply(self.duration, forced.reshape(rows, self.nodes * e))

    def end(self) -> tuple[Float[Array, "n s s"], Float[Array, "d qe"]]:
        """The end state, of the start state mode by mode, and of the forces."""
        count, n, s, e = jnp.shape(self.forced)
        (weights,) = _weights(self.nodes, (1.0,), count)[1]
        pushed = jnp.multiply(self.duration, jnp.einsum("jk,knse->nsje", weights, self.forced))
        return self.through, pushed.reshape(n * s, self.nodes * e)


def kernel_over(
    blocks: Float[AnyArray, "n s s"], inputs: Float[AnyArray, "n s e"], duration: Number, nodes: int, samples: int
) -> Kernel:
    """The kernel of a structure over a duration, s, at so many samples."""
    phases = np.append(gauss_nodes(samples)[0], 1.0)
    flights = exponential((duration * phases)[:, None, None, None] * blocks)
    free, through = flights[:-1], flights[-1]
    return Kernel(duration, free, through, free @ inputs, nodes)


@lru_cache(maxsize=64)
def _weights(nodes: int, points: tuple[float, ...], samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Of polynomials k(t) through ``samples`` and f(t) through ``nodes`` Gauss points of [0, 1], the values k(t) at
    points, from samples, (p, samples), and ∫₀ᵗ k(t − s) f(s) ds, from both, (p, nodes, samples).
    """
    end = np.array(points)
    inside, weights = gauss_nodes((samples + nodes) // 2 + 1)
    place = end[:, None] * inside
    kernel, force = _lagrange(samples, end[:, None] - place), _lagrange(nodes, place)
    return _lagrange(samples, end), np.einsum("pg,pgk,pgj->pjk", end[:, None] * weights, kernel, force, optimize=True)


def _lagrange(nodes: int, x: np.ndarray) -> np.ndarray:
    """Values at x of the polynomials through the nodes, along a new last axis, by Legendre's, to which Gauss' rule is
    exact.
    """
    places, weights = gauss_nodes(nodes)
    terms = (2 * np.arange(nodes) + 1)[:, None] * (weights[:, None] * legendre_values(places, nodes)).T
    return (legendre_values(x.ravel(), nodes) @ terms).reshape(*x.shape, nodes)
