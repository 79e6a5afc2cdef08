"""Responses of a structure that is known, and files of them as analysers write them."""

import struct

import numpy as np

FREQUENCY = np.arange(50.0, 1200.0, 2.5)
OMEGA = 2 * np.pi * FREQUENCY
OWN, RATIO = np.array([180.0, 450.0, 900.0]), np.array([0.02, 0.03, 0.015])
# Of two directions, x and y, 1/√kg.
SHAPE = np.array([[0.5, 0.1], [0.35, -0.5], [0.3, 0.6]])
_NATURAL = 2 * np.pi * OWN
RECEPTANCE = np.einsum(
    "nk,ki,kj->nij",
    1 / (_NATURAL**2 - OMEGA[:, None] ** 2 + 2j * RATIO * _NATURAL * OMEGA[:, None]),
    SHAPE,
    SHAPE,
)
ACCELERANCE = -(OMEGA[:, None, None] ** 2) * RECEPTANCE
POINT = RECEPTANCE[:, 0, 0]


def noisy(values, noise, seed=0):
    """With noise of so large a share of the largest of each response, in the root mean square over all lines."""
    random = np.random.default_rng(seed)
    white = (random.standard_normal((2, *values.shape)) / np.sqrt(2)).astype(float)
    return values + noise * np.abs(values).max(axis=0) * (white[0] + 1j * white[1])


def table(*columns, head="", separator=",", decimal="."):
    """A text file of columns to nine digits."""
    rows = [separator.join(f"{value:.9e}".replace(".", decimal) for value in row) for row in zip(*columns, strict=True)]
    return head + "\n".join(rows) + "\n"


def dataset(
    values, *, response=1, reference=1, binary=False, node=1, function=4, kind=12, labels=("m/s^2", "N"), **other
):
    """A universal dataset 58, or 58b, of complex values over even frequencies, by its definition."""
    count = other.get("count", len(values))
    spacing = (
        f"{other.get('code', 6):10d}{count:10d}{1:10d}{FREQUENCY[0]:13.5e}{FREQUENCY[1] - FREQUENCY[0]:13.5e}{0:13.5e}"
    )
    first = f"{58:6d}" + (f"b{1:6d}{2:6d}{11:12d}{16 * len(values):12d}{0:6d}{0:6d}{0:12d}{0:12d}" if binary else "")
    lines = [
        f"{-1:6d}",
        first.ljust(80),
        *("NONE".ljust(80) for _ in range(5)),
        f"{function:5d}{0:10d}{0:5d}{0:10d} {'NONE':<10}{node:10d}{response:4d} {'NONE':<10}{1:10d}{reference:4d}",
        spacing,
        f"{18:10d}{0:5d}{0:5d}{0:5d} {'Frequency':<20} {other.get('axis', 'Hz'):<20}",
        f"{kind:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {labels[0]:<20}",
        f"{13:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {labels[1]:<20}",
        f"{0:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {'NONE':<20}",
    ]
    numbers = np.column_stack([np.real(values), np.imag(values)]).ravel()
    if binary:
        body = struct.pack(f"<{len(numbers)}d", *numbers)
    else:
        parts = [numbers[i : i + 4] for i in range(0, len(numbers), 4)]
        body = "".join("".join(f"{x:20.12e}" for x in part) + "\n" for part in parts).encode()
    return "\n".join(lines).encode() + b"\n" + body + f"{-1:6d}\n".encode()


def units(length, force):
    """Universal dataset 164 of factors from SI."""
    rows = [f"{-1:6d}", f"{164:6d}", f"{9:10d}{'own units':<20}{2:10d}"]
    rows += ["".join(f"{x:25.16E}".replace("E", "D") for x in (length, force, 1.0)), f"{0.0:25.16E}".replace("E", "D")]
    return "\n".join([*rows, f"{-1:6d}", ""]).encode()
