"""The wear march of ``lobex.march_wear`` for a blading as compiled loops, ``prange`` over the speeds.

The same algorithm and the same results (depth, totals and energies per blade and revolution, filtered samples of every
tip), for the linear law and blades in one track that are not coupled, without fast math.
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
    start: Array,
    profile: Array,
    stiffness: float,
    speeds: Array,
    revolutions: int,
    taps: Array,
    factor: int,
) -> tuple[Array, Array, Array]:
    """Depth (n, cells), tips (n, blades, samples) and totals (n, blades, revolutions, 8).

    Of blades with the modes ω (modes, blades), ξ and φ (modes,), which begin in the cells ``start`` (blades,). Totals
    are amplitude, contact, force, removed, input, removal, damping and stored energy.
    """
    lanes, cells, blades = len(speeds), len(profile), len(start)
    modes = len(omega)
    samples, length = cells // factor, len(taps)
    depth = np.zeros((lanes, cells))
    tip = np.zeros((lanes, blades, revolutions * samples))
    totals = np.zeros((lanes, blades, revolutions, 8))
    for lane in numba.prange(lanes):
        dt = 1 / (cells * speeds[lane])
        u, v, d = np.zeros((blades, modes)), np.zeros((blades, modes)), np.zeros((blades, modes))
        decay, restoring = np.empty((blades, modes)), np.empty((blades, modes))
        compliance, damping = np.empty((blades, modes)), np.empty((blades, modes))
        for b in range(blades):
            for k in range(modes):
                damping[b, k] = ratio[k] * omega[k, b]
                share = 1 + damping[b, k] * dt
                decay[b, k] = (1 - damping[b, k] * dt) / share
                restoring[b, k] = (omega[k, b] * dt) ** 2 / share
                compliance[b, k] = shape[k] / omega[k, b] ** 2
        signal = np.zeros((blades, length - 1 + cells))
        own = depth[lane]
        q, before = np.zeros(blades), np.zeros(blades)
        power, lost = np.zeros(blades), np.zeros(blades)
        for turn in range(revolutions):
            for b in range(blades):
                tip_now, speed_of_tip, spent = 0.0, 0.0, 0.0
                for k in range(modes):
                    tip_now += shape[k] * u[b, k]
                    speed_of_tip += shape[k] * v[b, k]
                    spent += 2 * damping[b, k] * v[b, k] ** 2
                force = stiffness * max(tip_now - profile[start[b]] - own[start[b]], 0.0)
                power[b], lost[b], q[b] = force * speed_of_tip, spent, tip_now
                back = tip_now
                for k in range(modes):
                    a = -(omega[k, b] ** 2) * u[b, k] - 2 * damping[b, k] * v[b, k] - shape[k] * force
                    d[b, k] = v[b, k] * dt - a * dt**2 / 2
                    back -= shape[k] * d[b, k]
                before[b] = back
            out = totals[lane, :, turn]
            for c in range(cells):
                for b in range(blades):
                    cell = start[b] + c
                    if cell >= cells:
                        cell -= cells
                    signal[b, length - 1 + c] = q[b]
                    surface = profile[cell] + own[cell]
                    h = q[b] - surface
                    force = stiffness * h if h > 0 else 0.0
                    after, spent = 0.0, 0.0
                    for k in range(modes):
                        new = decay[b, k] * d[b, k] - restoring[b, k] * (u[b, k] + compliance[b, k] * force)
                        spent += damping[b, k] * (new + d[b, k]) ** 2
                        d[b, k] = new
                        u[b, k] += new
                        after += shape[k] * u[b, k]
                    out[b, 6] += spent
                    out[b, 0] = max(out[b, 0], abs(after))
                    if h > 0:
                        work = force * (after - before[b])
                        out[b, 4] += max(-work, 0.0)
                        out[b, 5] += max(work, 0.0)
                        out[b, 1] += 1
                        out[b, 2] = max(out[b, 2], force)
                        more = max(after - surface, 0.0)
                        own[cell] += more
                        out[b, 3] += more
                    before[b], q[b] = q[b], after
            for b in range(blades):
                force = stiffness * max(q[b] - profile[start[b]] - own[start[b]], 0.0)
                final_tip, final_lost, stored = 0.0, 0.0, 0.0
                for k in range(modes):
                    push = omega[k, b] ** 2 * u[b, k] + shape[k] * force
                    v[b, k] = (d[b, k] / dt - push * dt / 2) / (1 + damping[b, k] * dt)
                    final_tip += shape[k] * v[b, k]
                    final_lost += 2 * damping[b, k] * v[b, k] ** 2
                    stored += (v[b, k] ** 2 + (omega[k, b] * u[b, k]) ** 2) / 2
                final = force * final_tip
                out[b, 1] /= cells
                out[b, 4] = out[b, 4] / 2 + dt / 2 * (max(-final, 0.0) - max(-power[b], 0.0))
                out[b, 5] = out[b, 5] / 2 + dt / 2 * (max(final, 0.0) - max(power[b], 0.0))
                out[b, 6] = out[b, 6] / (2 * dt) + dt / 2 * (final_lost - lost[b])
                out[b, 7] = stored
                for j in range(samples):
                    value = 0.0
                    for i in range(length):
                        value += taps[i] * signal[b, j * factor + i]
                    tip[lane, b, turn * samples + j] = value
                for i in range(length - 1):
                    signal[b, i] = signal[b, cells + i]
    return depth, tip, totals
