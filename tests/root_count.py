"""An oracle of its own for one contact with constant feedback: how many roots lie to the right of a line.

F(z) = 1 + K Σ φ²τ²/(z² + 2ξωτz + (ωτ)²) (1 − e^{−z}) is sampled up the line, ever finer where its argument turns, and
its turns are counted (the argument principle). It shares no code with the package.
"""

import numpy as np


class Feedback:
    """1 + K G (1 − e^{−z}) = 0 for a rub of modes (n,) with residues (n,), 1/kg, at a delay."""

    def __init__(self, omega, damping, residue, delay, gain):
        self.a = np.asarray(omega) * delay
        self.b = np.asarray(damping) * self.a
        self.c = gain * np.asarray(residue) * delay**2

    def __call__(self, z):
        """F."""
        return 1 + self.loop(z)

    def loop(self, z):
        """F − 1."""
        z = np.asarray(z)
        response = sum(c / (z * z + 2 * b * z + a * a) for a, b, c in zip(self.a, self.b, self.c, strict=True))
        return response * (1 - np.exp(-z))

    def slope(self, z):
        """F′."""
        response, change = 0, 0
        for a, b, c in zip(self.a, self.b, self.c, strict=True):
            denominator = z * z + 2 * b * z + a * a
            response, change = response + c / denominator, change - c * 2 * (z + b) / denominator**2
        return change * (1 - np.exp(-z)) + response * np.exp(-z)

    @property
    def poles(self):
        """Of F, where the structure vibrates free."""
        root = np.sqrt(self.b**2 - self.a**2 + 0j)
        return np.concatenate([-self.b + root, -self.b - root])

    def height(self, level):
        """Above it, on Re z = level, F stays close to 1."""
        return np.max(np.abs(self.poles)) + np.sqrt(4 * np.sum(np.abs(self.c)) * (1 + np.exp(-level))) + 10


def polished(function, z, steps=4):
    """A root beside z, and how far the last of Newton's steps went."""
    step = np.inf
    for _ in range(steps):
        step = -function(z) / function.slope(z)
        z = z + step
    return z, abs(step)


def roots_beyond(function, level, per_turn=16):
    """The number of roots to the right of Re z = level."""
    poles = function.poles
    top = function.height(level)
    turns = top / (2 * np.pi)
    if turns * per_turn > 4e6:
        raise ValueError("too many turns to count")
    y = _heights(poles, level, top, int(turns * per_turn))
    value = function(level + 1j * y)
    # Where F turns by much between two samples, more are taken there.
    for _ in range(60):
        step = np.angle(value[1:] / value[:-1])
        coarse = np.flatnonzero(np.abs(step) > 0.6)
        if not coarse.size:
            break
        middle = (y[coarse] + y[coarse + 1]) / 2
        y = np.insert(y, coarse + 1, middle)
        value = np.insert(value, coarse + 1, function(level + 1j * middle))
    turned = np.sum(np.angle(value[1:] / value[:-1]))
    return int(np.sum(poles.real > level)) - round(2 * turned / (2 * np.pi))


def least_limit(omega, damping, residue, delay):
    """The least K > 0 at which a root stands on the imaginary axis: D-subdivision by sign changes and bisection."""
    function = Feedback(omega, damping, residue, delay, 1.0)
    poles = function.poles
    top = 2 * np.max(np.abs(poles)) + 50
    y = _heights(poles, 0.0, top, int(40 * top / (2 * np.pi)))[1:]
    value = function.loop(1j * y)
    low, high = (a[value.imag[:-1] * value.imag[1:] < 0] for a in (y[:-1], y[1:]))
    rising = function.loop(1j * high).imag > 0
    for _ in range(80):
        middle = (low + high) / 2
        beyond = (function.loop(1j * middle).imag > 0) == rising
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    value = function.loop(1j * low)
    # At a pole or a zero of 1 − e^{−z} the sign changes, too: there the value is no root's.
    real = value.real[(value.real < 0) & (np.abs(value.imag) < 1e-6 * np.abs(value.real))]
    return np.min(-1 / real, initial=np.inf)


def _heights(poles, level, top, count):
    edges = [np.linspace(0, top, count + 64)]
    for pole in poles[poles.imag >= 0]:
        width = max(abs(pole.real - level), 1e-7)
        edges.append(pole.imag + width * np.sinh(np.linspace(-18, 18, 300)))
    return np.unique(np.clip(np.concatenate(edges), 0, top))
