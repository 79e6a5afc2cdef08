"""Cutting at a varying spindle speed by Gauss' collocation over the angle in NumPy: an oracle without any of lobex.

Over the angle every delay is constant and jumps stand still; what varies is how fast the structure moves. Over each
part of a pass the derivative of the state by the angle is a polynomial through Gauss points (a Runge-Kutta method of
order twice their number), and what a tooth finds is the output at the same points one pass ago.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from milling_collocation import gauss

POINTS = 12


@dataclass
class Spindle:
    """n₀ (1 + Σ_k a_k cos 2πkx + b_k sin 2πkx), x = R n₀ t."""

    speed: float
    ratio: float
    cosine: Any = (0.0,)
    sine: Any = (0.0,)

    def pace(self, time):
        angle = 2 * np.pi * self.ratio * self.speed * time
        return 1 + sum(
            a * np.cos(k * angle) + b * np.sin(k * angle)
            for k, (a, b) in enumerate(zip(self.cosine, self.sine, strict=True), 1)
        )

    def turns(self, time):
        """Revolutions since t = 0."""
        rate = 2 * np.pi * self.ratio
        x = rate * self.speed * time
        ahead = sum(
            (a * np.sin(k * x) + b * (1 - np.cos(k * x))) / (k * rate)
            for k, (a, b) in enumerate(zip(self.cosine, self.sine, strict=True), 1)
        )
        return self.speed * time + ahead

    def time(self, turns):
        """By bisection."""
        # As far as it can be ahead or behind of even turning.
        reach = 2 * np.sum(np.abs([self.cosine, self.sine])) / (2 * np.pi * self.ratio)
        low, high = (turns - reach) / self.speed, (turns + reach) / self.speed
        for _ in range(80):
            middle = (low + high) / 2
            beyond = self.turns(middle) > turns
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        return (low + high) / 2


def period_map(modes, spindle, force, pass_parts, passes, per_turn, damping=None, fed=0.0):
    """U and b of a period: z and what it left last is mapped to U (z, …) + b.

    ``modes``: ω, ξ and φ, (n, r). ``force``: of the turn of the first tooth, revolutions, to H, (r, r), N/m.
    ``pass_parts``: places in a pass between which the force is smooth. ``per_turn``: passes of a revolution.
    ``damping``: of the turn to the matrix of ẏ at the mean speed. ``fed``: the feed along x, m/s.
    """
    omega, ratio, shape = (np.asarray(part, dtype=float) for part in modes)
    n, r = shape.shape
    drift = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -np.diag(2 * ratio * omega)]])
    inputs = np.vstack([np.zeros((n, r)), shape / omega[:, None]])
    outputs = np.hstack([shape.T, np.zeros((r, n))])
    rates = np.hstack([np.zeros((r, n)), shape.T * omega])
    nodes, weights, within = gauss(POINTS)
    parts = list(pairwise(pass_parts))
    size = 2 * n + len(parts) * POINTS * r
    flank = damping or (lambda turn: np.zeros((r, r)))
    # The last row is 1, for what is fed.
    known = np.eye(size + 1)
    state, left = known[: 2 * n], known[2 * n : size].reshape(len(parts), POINTS, r, size + 1)
    for number in range(passes):
        new = []
        for (start, stop), before in zip(parts, left, strict=True):
            turns = (number + start + (stop - start) * nodes) / per_turn
            length = (stop - start) / per_turn
            time = spindle.time(turns)
            since = time - spindle.time(turns - 1 / per_turn)
            # dt/dturn.
            slow = 1 / (spindle.speed * spindle.pace(time))
            acting = [force(turn) for turn in turns]
            pace = spindle.pace(time)
            now = [
                slow[k] * (drift - inputs @ (acting[k] @ outputs + flank(turns[k]) / pace[k] @ rates))
                for k in range(POINTS)
            ]
            travel = np.eye(r, 1) * fed
            pushed = np.stack(
                [slow[k] * inputs @ acting[k] @ (before[k] - since[k] * travel * known[size]) for k in range(POINTS)]
            )
            # z_k = z + L Σ_j within[k, j] (A_j z_j + p_j).
            blocks = np.eye(POINTS * 2 * n) - length * np.einsum("kj,jab->kajb", within, np.stack(now)).reshape(
                POINTS * 2 * n, POINTS * 2 * n
            )
            given = state + length * np.einsum("kj,jax->kax", within, pushed)
            inner = np.linalg.solve(blocks, given.reshape(POINTS * 2 * n, -1)).reshape(POINTS, 2 * n, -1)
            slopes = np.einsum("kab,kbx->kax", np.stack(now), inner) + pushed
            state = state + length * np.einsum("k,kax->ax", weights, slopes)
            new.append(outputs @ inner)
        left = np.stack(new)
    whole = np.concatenate([state, left.reshape(-1, size + 1)])
    return whole[:, :size], whole[:, size]


def largest(matrix):
    """The dominant multiplier, its imaginary part not negative."""
    values = np.linalg.eigvals(matrix)
    value = values[np.argmax(np.abs(values))]
    return complex(value.real, abs(value.imag))
