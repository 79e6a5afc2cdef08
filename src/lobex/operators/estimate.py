"""The error of a multiplier by its nodes: what they leave of its motion, and what they cannot see at all."""

from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from lobex._shapes import AnyArray
from lobex.operators.moments import legendre_values
from lobex.operators.response import followed_turn, gauss_nodes, quickness
from lobex.systems.delays import varies
from lobex.systems.mesh import seen_to_bend
from lobex.systems.system import DelaySystem

# The error in terms of what lies beyond the nodes of y: its square (superconvergence), but only in proportion to it
# through modes that turn too quickly for the nodes. Bounds fitted to blade rub, milling of even and uneven pitch, and
# Mathieu's equation.
_SMOOTH, _ROUGH = 20.0, 0.4
# Where what is remembered is met between the nodes, what they leave of the force bends it at the ends of pieces: so
# much of what they leave of y, over the cube of their number, and in proportion to what they leave of both. Bounds
# fitted to several delays, delays apart from the period, and delays that vary (tests/test_general_error.py).
_BETWEEN, _BOTH = 0.5, 1.0
# A delay that varies makes waves of the force shorter than those of y: so much of what the nodes leave of the force,
# over the square of their number, as it moves the structure. A bound fitted to variations of the spindle's speed.
_VARYING = 0.25
# A bend of the force within a piece, in the derivative 2g + 2 after g generations of images of its jumps: of what it
# adds to the last terms the nodes take the share that lies beyond twice their number, 2^−(2g + 1), for something else.
_BENT = 0.25
# Of a coefficient that stands for one which bends within pieces multipliers miss the product of what the nodes leave of
# it and of y. A bound fitted to serrated teeth (tests/test_serration.py).
_BENDING = 3.0
# Above this the last terms tell nothing of the rest.
_UNKNOWN = 0.1


class InContact(NamedTuple):
    """What a motion is over a piece in contact, or, stacked, over all of them.

    Attributes:
        length: of the piece, in periods.
        missed: how much of each mode's vibration lies beyond the nodes, (n,).
        force: norms of the coefficients of the present and of the delayed force at the nodes, (2, q), of outputs that
            are each of size 1, see ``sizes_of``.
        unresolved: squares of what lies beyond the nodes of y, of the last that they hold with it, and of all, (3,).
        unresolved_force: squares of the last that they hold of the force, which is known there alone, and of all, (2,).
        unmet: square of by how much y misses its equations at the nodes.
        terms: squares of the terms of which the end state and y are sums, (2,).
    """

    length: Float[AnyArray, " *M"]
    missed: Float[AnyArray, "*M n"]
    force: Float[AnyArray, "*M 2 q"]
    unresolved: Float[AnyArray, "*M 3"]
    unresolved_force: Float[AnyArray, "*M 2"]
    unmet: Float[AnyArray, " *M"]
    terms: Float[AnyArray, "*M 2"]


@lru_cache(maxsize=32)
def _analysis(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """From samples at the nodes to the last four Legendre terms, normed, (4, q), and to the ends of the piece, (2, q).

    A wave of which the nodes miss the term q alone, normed, is off by the root of 2q + 1 at the ends: the second
    matrix is less by that factor.
    """
    points, weights = gauss_nodes(nodes)
    norms = np.sqrt(2 * np.arange(nodes) + 1)
    terms = norms[:, None] * (weights[:, None] * legendre_values(points, nodes)).T
    ends = legendre_values(np.array([0.0, 1.0]), nodes) * norms
    return terms[-4:], ends @ terms / np.sqrt(2 * nodes + 1)


def unresolved(samples: Float[Array, "q r p"], ends: Float[Array, "2 r p"]) -> Float[Array, "3"]:
    """Squares of what lies beyond the nodes of y over a piece, of the last that they hold with it, and of all, (3,).

    The last two Legendre terms are less than the two before by a share, and those beyond are less than the last by
    that share at least. By how much the polynomial through the nodes misses y at both ends of the piece, which are
    known from the structure's state, tells of them too: a wave that turns more quickly than the nodes tell may look
    smooth at them, but not between them.

    Args:
        samples: y at the nodes, (q, r, …).
        ends: y at the start and the end of the piece, (2, r, …).
    """
    nodes = jnp.shape(samples)[0]
    terms, to_ends = _analysis(nodes)
    flat = samples.reshape(nodes, -1)
    before, last = (jnp.sum((pair @ flat) ** 2) for pair in (terms[:-2], terms[-2:]))
    missed = jnp.sum((to_ends @ flat - ends.reshape(2, -1) / np.sqrt(2 * nodes + 1)) ** 2)
    beyond = last * last / (jnp.maximum(before, last) + jnp.finfo(flat.dtype).tiny)
    return jnp.stack([beyond + missed, last + missed, jnp.sum(gauss_nodes(nodes)[1][:, None] * flat**2)])


def unresolved_force(samples: Float[AnyArray, "q e p"]) -> Float[Array, "2"]:
    """Squares of the last two Legendre terms of a force over a piece, from its nodes (q, e, …), and of all, (2,)."""
    nodes = jnp.shape(samples)[0]
    flat = samples.reshape(nodes, -1)
    last = jnp.sum((_analysis(nodes)[0][-2:] @ flat) ** 2)
    return jnp.stack([last, jnp.sum(gauss_nodes(nodes)[1][:, None] * flat**2)])


def estimated_error(system: DelaySystem, contacts: InContact, value: Float[Array, "2"]) -> Float[Array, ""]:
    """The estimated relative error of a multiplier μ, (2,), of a well conditioned state; infinite where unknown.

    It is not known where what the nodes leave is so much that the last terms tell nothing of the rest, and where
    they might have missed a larger multiplier. That needs a vibration s = σ + jω, e^{στ} ≥ |μ|, quicker than what the
    nodes follow, that the force keeps up. Slower modes answer it as they stand, |G(s)| of each, and with
    (p + q/|μ|) |G| of 1 they might do so alone: the loop then turns more quickly than the structure. A quicker mode
    grows at most at the rate −ξω + (p + q/|μ|) φ²/2ω, with p and q the means over the period of the present force
    that can do work and of the delayed one; a constant force of one
    output is a spring, which does none unless that holds velocities.
    """
    blocks, inputs = jnp.asarray(system.blocks), jnp.asarray(system.inputs)
    outputs = jnp.asarray(system.outputs) / sizes_of(system.outputs)[:, None]
    tiny = jnp.finfo(blocks.dtype).tiny
    (beyond, tail), (force_tail,) = (_shares(part, tiny) for part in (contacts.unresolved, contacts.unresolved_force))
    mobility = jnp.sqrt(jnp.sum(inputs**2, axis=(1, 2)) * jnp.sum(outputs**2, axis=(1, 2)))
    quick = quickness(blocks)
    compliance = mobility / (quick + tiny)
    rough = jnp.sum(jnp.max(contacts.missed, axis=0) * compliance) / (jnp.sum(compliance) + tiny)
    nodes = jnp.shape(contacts.force)[-1]
    error = beyond * (_SMOOTH * beyond + _ROUGH * rough)
    if not system.to_nodes:
        error = error + tail * (_BOTH * force_tail + _BETWEEN / nodes**3)
    elif system.bends:
        error = error + _BENDING * tail * force_tail
    if any(map(varies, system.delays)):
        error = error + _VARYING * force_tail / nodes**2
    generations = seen_to_bend(system)
    if generations is not None:
        error = error + _BENT * force_tail / 2 ** (2 * generations + 1)

    size = jnp.sqrt(jnp.sum(value**2))
    growth = jnp.log(size) / system.period
    followed = 2 * followed_turn(nodes) / (system.period * jnp.max(contacts.length))
    quicker = quick > followed
    answer: Array = jnp.where(quicker, 0.0, _receptance(blocks, inputs, outputs, growth, followed))
    most = jnp.max(contacts.force, axis=(0, 2))
    # What was a delay ago is larger by so much.
    before = 1 / size if system.repeats else jnp.maximum(size**-system.longest, size**-system.shortest)
    looped = (most[0] + most[1] * before) * jnp.sum(answer)
    mean = contacts.length @ (contacts.force @ gauss_nodes(nodes)[1])
    spring = system.constant and system.output_size == system.force_size == 1
    works = jnp.sum(jnp.abs(jnp.einsum("nrs,nse->re", outputs, inputs))) > 0 if spring else True
    drive = jnp.where(works, mean[0], 0.0) + mean[1] * before
    decay = growth - jnp.trace(blocks, axis1=1, axis2=2) / jnp.shape(blocks)[-1]
    alone = quicker & (drive * mobility / 2 > (1 - looped) * decay)
    unknown = (tail > _UNKNOWN) if system.to_nodes else (jnp.maximum(tail, force_tail) > _UNKNOWN)
    return jnp.where(unknown | (looped >= 1) | jnp.any(alone), jnp.inf, error)


def sizes_of(outputs: Float[AnyArray, "n r s"]) -> Float[Array, " r"]:
    """|C| of each output, from columns per block (n, r, s), shape (r,): what it is divided by to have no unit."""
    sizes = jnp.sqrt(jnp.sum(jnp.asarray(outputs) ** 2, axis=(0, 2)))
    return jnp.where(sizes > 0, sizes, 1.0)


def _shares(squares: Float[AnyArray, "M k"], tiny: Any) -> list[Float[Array, ""]]:
    """Of all contacts, whose squares come last, (M, k), the parts before."""
    *parts, whole = jnp.sum(squares, axis=0)
    return [jnp.sqrt(part / (whole + tiny)) for part in parts]


def rounding(
    system: DelaySystem, contacts: InContact, unmet: Float[Array, "2"], held: Float[Array, "2"]
) -> Float[Array, "2"]:
    """By how much start state and history miss their equations, (2,), relative to each, or might by rounding alone.

    Every product is off by an ulp of its terms, and a wave's phase by an ulp of the radians that it turns through.

    Args:
        system: the delay system.
        contacts: the motion.
        unmet: squares of what the two miss, (2,).
        held: squares of the two one period later, (2,).
    """
    turned = jnp.max(quickness(jnp.asarray(system.blocks))) * system.period
    part = held + jnp.finfo(held.dtype).tiny
    ulps = jnp.finfo(held.dtype).eps * (1 + turned + jnp.sqrt(jnp.sum(contacts.terms, axis=0) / part))
    return jnp.sqrt(unmet / part) + ulps


def _receptance(
    blocks: Float[Array, "n s s"],
    inputs: Float[Array, "n s e"],
    outputs: Float[Array, "n r s"],
    growth: Float[AnyArray, ""],
    turning: Float[AnyArray, ""],
) -> Float[Array, " n"]:
    """|C (s − A)⁻¹ E| at s = growth + j turning, rad/s, of each block, (n,)."""
    size = jnp.shape(blocks)[-1]
    if size != 2:
        still = jax.lax.complex(growth, turning) * jnp.eye(size) - blocks
        moved = outputs @ jnp.linalg.solve(still, inputs + 0j)
        return jnp.sqrt(jnp.sum(moved.real**2 + moved.imag**2, axis=(1, 2)))
    (a, b), (c, d) = ((blocks[:, i, j] for j in (0, 1)) for i in (0, 1))
    adjugate = jnp.stack([jnp.stack([-d, b], -1), jnp.stack([c, -a], -1)], -2)
    direct = jnp.einsum("nrs,nsp->nrp", outputs, inputs)
    passed = jnp.einsum("nrs,nst,ntp->nrp", outputs, adjugate, inputs)
    # C adj(s − A) E = s CE + C(−adj A)E, by its real and imaginary parts, over det(s − A).
    above = jnp.sum((growth * direct + passed) ** 2 + (turning * direct) ** 2, axis=(1, 2))
    real = growth**2 - turning**2 - growth * (a + d) + a * d - b * c
    return jnp.sqrt(above / (real**2 + (turning * (2 * growth - a - d)) ** 2))
