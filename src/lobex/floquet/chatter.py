"""The frequency at which the motion of a multiplier goes on."""

from typing import Any

import jax.numpy as jnp

from lobex.operators.operator import MonodromyOperator

Array = Any


def chatter_frequency(operator: MonodromyOperator, delay: Array, value: Array, vector: Array) -> Array:
    """Of the frequencies arg μ/(2πτ) + k/τ, the one that carries most of the motion, Hz, not negative.

    The motion of a multiplier is y(t) = μ^{t/τ} p(t/τ) with p of period 1: its Fourier coefficients are the
    amplitudes at those frequencies (Insperger et al., Multiple chatter frequencies in milling processes,
    J. Sound Vib. 262, 2003). The largest |k| looked at is half the number of samples.
    """
    phase = operator.phase - operator.phase[0]
    motion = jnp.einsum("srn,n->sr", operator.motion, vector)
    exponent = jnp.log(value)
    periodic = operator.weight[:, None] * motion * jnp.exp(-exponent * phase)[:, None]
    most = jnp.shape(phase)[0] // 2
    order = jnp.arange(-most, most + 1)
    amplitude = jnp.exp(-2j * jnp.pi * order[:, None] * phase) @ periodic
    carrier = order[jnp.argmax(jnp.sum(jnp.abs(amplitude) ** 2, axis=-1))]
    return jnp.abs(jnp.angle(value) / (2 * jnp.pi) + carrier) / delay
