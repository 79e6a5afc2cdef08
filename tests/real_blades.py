"""Blades, casings and bladings that march, small enough to be computed often, and the growth that a march shows."""

import numpy as np

import lobex
from lobex.marches.growth_fit import fit_growth

BEAM = lobex.Beam.rectangular(
    elements=3,
    length=0.2,
    width=0.05,
    thickness=0.008,
    young_modulus=110e9,
    density=4430.0,
    stagger_degrees=30.0,
    hub_radius=0.2,
)
PLAIN = lobex.Modes([2000.0, 3300.0], [0.03, 0.02], [[1.0], [0.5]])
RUBBING = lobex.Modes([2000.0, 3300.0], [0.03, 0.02], [[1.0, 0.3], [0.4, -0.8]]).in_contact((1, 0), (0, 1), 0.3)
TURNING = BEAM.rotating(0.03, [1, 2, 3], normal=(0.9, 0.1, 0.3), sliding=(0.0, 3.0, -1.0), friction=0.2)
TWO = lobex.Modes([2000.0, 3300.0], [0.03, 0.02], [[1.0, 0.3], [0.4, -0.8]])
# Two contacts of one tip, each with a normal, a sliding and a friction of its own.
EACH = TWO.in_contact([(1, 0), (0.6, 0.8)], [(0, 1), (0.8, -0.6)], [0.3, 0.1])
CASING = lobex.Modes([2600.0, 4100.0], [0.02, 0.02], [[0.5], [0.3]])


def grown(march, revolutions=10):
    """The dominant multiplier per revolution of every lane, from what the last revolutions changed, (n,).

    What a march of permanent contact settles at falls out of the differences of successive revolutions.
    """
    turns = march.displacement.reshape(len(march.speed), -1, march.revolutions, march.samples_per_revolution)
    by_turn = np.moveaxis(turns, 2, 1).reshape(len(march.speed), march.revolutions, -1)
    return fit_growth(np.diff(by_turn, axis=1)[:, -revolutions:]).multiplier


def in_permanent_contact(modes, stiffness, speed, steps, revolutions=40, structure=None, **options):
    """A march over a smooth casing that comes closer all the time, so that no contact is ever lost."""
    casing = lobex.Casing(amplitude=0.0, structure=structure)
    options = {"incursion": 1e-5, "samples_per_revolution": steps, **options}
    law = stiffness if hasattr(stiffness, "force") else lobex.Linear(stiffness)
    march = lobex.march_wear(modes, casing, law, [speed], revolutions, steps, **options)
    assert np.all(march.contact[..., 1:] == 1)
    return march


def multiplier(modes, stiffness, speed, steps, passes=1):
    """|μ| per revolution of contacts that come to their track a step early, where so many pass in a revolution."""
    rub = lobex.Rub(modes)
    faster = speed / (1 - passes / steps)
    period = float(rub.system(faster, stiffness).period)
    return float(lobex.spectral_radius(rub, faster, stiffness)) ** (1 / (speed * period))


def family_multiplier(modes, mistuning, stiffness, speed, steps):
    """|μ| per revolution of blades that are not coupled, ∏(1 + K Gⱼ) = e^{−sT} ∏ K Gⱼ, each a step early."""
    delay = (1 - len(mistuning) / steps) / speed

    def equation(s):
        response = np.stack([stiffness * receptance(modes, s, 1 + share) for share in mistuning])
        return np.prod(1 + response, axis=0) - np.exp(-s * delay) * np.prod(response, axis=0)

    return largest_root(equation, modes, speed)


def viscous_multiplier(modes, law, speed, steps):
    """|μ| per revolution with F = K h + C ẏ: 1 + G (K − K e^{−sT} + C s) = 0, a step early."""
    delay = (1 - 1 / steps) / speed

    def equation(s):
        force = law.stiffness * (1 - np.exp(-s * delay)) + law.viscosity * s
        return 1 + receptance(modes, s) * force

    return largest_root(equation, modes, speed)


def ring_multiplier(modes, mistuning, ring, stiffness, speed, steps):
    """|μ| per revolution of blades on one ring: det(I + K G (I − P)) = 0, with P from each to the blade before it."""
    blades = len(mistuning)
    gap = (1 / blades - 1 / steps) / speed
    apart = 2 * np.pi * (np.arange(blades) - np.arange(blades)[:, None]) / blades
    before = np.roll(np.eye(blades), 1, axis=0)

    def wave(s):
        return s**2 + 2 * ring.damping_ratio[0] * own * s + own**2

    own, waves = 2 * np.pi * ring.frequency[0], ring.nodal_diameter[0]
    swept = 2j * np.pi * waves * speed

    def equation(s):
        s = s[:, None, None]
        casing = np.exp(1j * waves * apart) / wave(s - swept) + np.exp(-1j * waves * apart) / wave(s + swept)
        own_motion = np.stack([receptance(modes, s.ravel(), 1 + share) for share in mistuning], axis=1)
        whole = own_motion[:, None] * np.eye(blades) + casing / (2 * ring.mass[0])
        return np.linalg.det(np.eye(blades) + stiffness * whole @ (np.eye(blades) - before * np.exp(-s * gap)))

    return largest_root(equation, modes, speed, 300)


def receptance(modes, s, higher=1.0):
    """G(s) of modes that are not complex, their frequencies times ``higher``."""
    omega, residue = modes.angular_frequency * higher, (modes.shape * modes.loading)[:, 0]
    return np.sum(residue / (s[:, None] ** 2 + 2 * modes.damping_ratio * omega * s[:, None] + omega**2), axis=1)


def largest_root(equation, modes, speed, starts=1500):
    """e^{Re s/f} of the rightmost root s, by Newton's iteration from everywhere around the modes."""
    omega = np.linspace(0.7 * modes.angular_frequency.min(), 1.6 * modes.angular_frequency.max(), starts)
    s = (np.log([[0.6], [1.0], [1.5]]) * speed + 1j * omega).ravel()
    with np.errstate(all="ignore"):
        for _ in range(60):
            s = s - equation(s) * 2e-3 / (equation(s + 1e-3) - equation(s - 1e-3))
        found = np.isfinite(s) & (np.abs(equation(s)) < 1e-9)
    return float(np.exp(np.max(s[found].real) / speed))
