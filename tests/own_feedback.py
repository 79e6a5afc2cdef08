"""Equations of one force, written by hand: modes in a row, and what the force sees."""

import numpy as np

import lobex


def seen(rows, t, speed, gain):
    return gain * rows


def held(numbers, t, speed, gain):
    return numbers[0] - gain * numbers[1:]


def modal(omega, ratio, mass, **others):
    """Modes in a row under one force; the state is (q, q'/omega), and it is seen by displacement and velocity."""
    omega, ratio, mass = (np.asarray(part, dtype=float) for part in (omega, ratio, mass))
    none = np.zeros_like(omega)
    return lobex.LinearDelay(
        drift=np.block([[np.diag(none), np.diag(omega)], [-np.diag(omega), -2 * np.diag(ratio * omega)]]),
        inputs=np.concatenate([none, 1 / (mass * omega)])[:, None],
        outputs=np.stack([np.concatenate([none + 1, none]), np.concatenate([none, omega])]),
        **others,
    )
