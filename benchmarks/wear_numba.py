"""The wear march of ``lobex.march_wear`` as compiled loops: one speed after the other, ``prange`` over the speeds.

The same algorithm and the same results (depth, totals and energies per revolution, filtered samples of the tip),
for the linear law, without fast math.
"""

from typing import Any

import numba
import numpy as np

Array = Any


@numba.njit(parallel=True, fastmath=False, error_model="numpy")
def march(
    omega: Array,
    ratio: Array,
    shape: Array,
    profile: Array,
    stiffness: float,
    speeds: Array,
    revolutions: int,
    taps: Array,
    factor: int,
) -> tuple[Array, Array, Array]:
    """Depth (n, cells), tip (n, samples) and totals (n, revolutions, 7).

    Totals are amplitude, contact, removed, input, removal, damping and stored energy.
    """
    lanes, cells, modes = len(speeds), len(profile), len(omega)
    samples, length = cells // factor, len(taps)
    depth = np.zeros((lanes, cells))
    tip = np.zeros((lanes, revolutions * samples))
    totals = np.zeros((lanes, revolutions, 7))
    for lane in numba.prange(lanes):
        dt = 1 / (cells * speeds[lane])
        u, v, d = np.zeros(modes), np.zeros(modes), np.zeros(modes)
        decay, restoring, compliance, damping = np.empty(modes), np.empty(modes), np.empty(modes), np.empty(modes)
        for k in range(modes):
            damping[k] = ratio[k] * omega[k]
            share = 1 + damping[k] * dt
            decay[k] = (1 - damping[k] * dt) / share
            restoring[k] = (omega[k] * dt) ** 2 / share
            compliance[k] = shape[k] / omega[k] ** 2
        signal = np.zeros(length - 1 + cells)
        own = depth[lane]
        for turn in range(revolutions):
            q, speed_of_tip, lost = 0.0, 0.0, 0.0
            for k in range(modes):
                q += shape[k] * u[k]
                speed_of_tip += shape[k] * v[k]
                lost += 2 * damping[k] * v[k] ** 2
            force = stiffness * max(q - profile[0] - own[0], 0.0)
            power = force * speed_of_tip
            before = q
            for k in range(modes):
                a = -(omega[k] ** 2) * u[k] - 2 * damping[k] * v[k] - shape[k] * force
                d[k] = v[k] * dt - a * dt**2 / 2
                before -= shape[k] * d[k]
            amplitude, contact, removed, given, taken, damped = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            for c in range(cells):
                signal[length - 1 + c] = q
                surface = profile[c] + own[c]
                h = q - surface
                force = stiffness * h if h > 0 else 0.0
                after, spent = 0.0, 0.0
                for k in range(modes):
                    new = decay[k] * d[k] - restoring[k] * (u[k] + compliance[k] * force)
                    spent += damping[k] * (new + d[k]) ** 2
                    d[k] = new
                    u[k] += new
                    after += shape[k] * u[k]
                damped += spent
                amplitude = max(amplitude, abs(after))
                if h > 0:
                    work = force * (after - before)
                    given += max(-work, 0.0)
                    taken += max(work, 0.0)
                    contact += 1
                    more = max(after - surface, 0.0)
                    own[c] += more
                    removed += more
                before, q = q, after
            force = stiffness * max(q - profile[0] - own[0], 0.0)
            final_tip, final_lost, stored = 0.0, 0.0, 0.0
            for k in range(modes):
                push = omega[k] ** 2 * u[k] + shape[k] * force
                v[k] = (d[k] / dt - push * dt / 2) / (1 + damping[k] * dt)
                final_tip += shape[k] * v[k]
                final_lost += 2 * damping[k] * v[k] ** 2
                stored += (v[k] ** 2 + (omega[k] * u[k]) ** 2) / 2
            final = force * final_tip
            out = totals[lane, turn]
            out[0], out[1], out[2] = amplitude, contact / cells, removed
            out[3] = given / 2 + dt / 2 * (max(-final, 0.0) - max(-power, 0.0))
            out[4] = taken / 2 + dt / 2 * (max(final, 0.0) - max(power, 0.0))
            out[5] = damped / (2 * dt) + dt / 2 * (final_lost - lost)
            out[6] = stored
            for j in range(samples):
                value = 0.0
                for i in range(length):
                    value += taps[i] * signal[j * factor + i]
                tip[lane, turn * samples + j] = value
            for i in range(length - 1):
                signal[i] = signal[cells + i]
    return depth, tip, totals
