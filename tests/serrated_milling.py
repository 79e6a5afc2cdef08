"""Serrated milling by brute force in NumPy: an oracle without any of lobex.

Every height by itself, at every instant, meets whatever tooth ahead leaves it least. Over a step the force is that of
the mean coefficients and of the mean of the motion at the ends of the step, now and so many pitches ago, and the
structure's answer to it exact: the error goes with the square of the step, which two of them take off.
"""

import numpy as np
from scipy.linalg import expm


def forces(tool, steps, depth, heights, instants):
    """The mean of b H of each tooth over each step of a revolution, by how many pitches ahead that is which left what
    is met, (teeth, teeth, steps, 2, 2).

    Of a dictionary with ``teeth``, ``pitch`` (rad), ``amplitude``, ``wave_length``, ``phase`` (rad), ``runout``,
    ``twist``, ``feed``, ``entry``, ``exit``, ``tangential`` and ``normal``.
    """
    count = tool["teeth"]
    height = depth * (np.arange(heights) + 0.5) / heights
    turned = 2 * np.pi * (np.arange(steps * instants) + 0.5) / (steps * instants)
    radius = tool["runout"][:, None] + tool["amplitude"] * np.cos(
        2 * np.pi * height / tool["wave_length"] + np.asarray(tool["phase"])[:, None]
    )
    tip = np.append(0.0, np.cumsum(tool["pitch"]))
    found = np.zeros((count, count, steps, 2, 2))
    for tooth in range(count):
        angle = np.mod(turned[:, None] + tip[tooth] - tool["twist"] * height, 2 * np.pi)
        sine, cosine = np.sin(angle), np.cos(angle)
        chips = []
        for ahead in range(1, count + 1):
            feed = count * tool["feed"] * since(tool, tooth, ahead) / (2 * np.pi)
            chips.append(feed * sine + radius[tooth] - radius[(tooth + ahead) % count])
        least, which = np.min(chips, axis=0), np.argmin(chips, axis=0)
        cuts = (angle > tool["entry"]) & (angle < tool["exit"]) & (least > 0)
        along = tool["tangential"] * cosine + tool["normal"] * sine
        across = tool["normal"] * cosine - tool["tangential"] * sine
        force = np.stack([along * sine, along * cosine, across * sine, across * cosine])
        for ahead in range(count):
            part = (force * (cuts & (which == ahead))).sum(axis=-1) * depth / heights
            found[tooth, ahead] = np.moveaxis(part.reshape(2, 2, steps, instants).mean(axis=-1), -1, 0)
    return found


def since(tool, tooth, ahead):
    """The angle to the tooth so many pitches ahead, rad."""
    return sum(tool["pitch"][(tooth + other) % tool["teeth"]] for other in range(ahead))


def radius(tool, speed, depth, steps, heights, instants=8):
    """max|μ| over a revolution, with as many steps to it, of which each pitch takes a whole number.

    The tool has ``omega`` (rad/s), ``ratio`` and ``mass`` of one mode along each of x and y as well.
    """
    step = 1 / (speed * steps)
    count = tool["teeth"]
    apart = [
        round(since(tool, tooth, ahead + 1) * steps / (2 * np.pi)) for tooth in range(count) for ahead in range(count)
    ]
    met = forces(tool, steps, depth, heights, instants).reshape(-1, steps, 2, 2)
    omega, ratio, mass = (np.asarray(tool[name], dtype=float) for name in ("omega", "ratio", "mass"))
    drift = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag(omega**2), -np.diag(2 * ratio * omega)]])
    push = np.vstack([np.zeros((2, 2)), np.diag(1 / mass)])
    whole = expm(step * np.block([[drift, push], [np.zeros((2, 6))]]))
    through, pushed = whole[:4, :4], whole[:4, 4:]
    # Positions at the ends of steps, the last of a revolution first, and the velocity now.
    size = 2 * (steps + 1) + 2
    history = [np.eye(2, size, 2 * back) for back in range(steps + 1)]
    speeds = np.eye(2, size, 2 * (steps + 1))
    for index in range(steps):
        now = met[:, index].sum(axis=0)
        past = sum(
            force @ (history[back] + history[back - 1]) / 2 for force, back in zip(met[:, index], apart, strict=True)
        )
        state = np.vstack([history[0], speeds])
        left = np.eye(4) + pushed @ now @ np.eye(2, 4) / 2
        state = np.linalg.solve(left, through @ state + pushed @ (past - now @ history[0] / 2))
        history, speeds = [state[:2], *history[:-1]], state[2:]
    return np.abs(np.linalg.eigvals(np.vstack([*history, speeds]))).max()
