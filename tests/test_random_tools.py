"""Random tools against a march in time of the tests' own: growth as the multipliers say, and the motion of the orbit.

The march is in NumPy, all tools side by side: Runge-Kutta steps of order four that end where teeth enter and leave, and
cubic Hermite interpolation of the turn before. Nothing of it is of lobex but the numbers of the tools.
"""

import numpy as np
import pytest

import lobex

TURN = 2 * np.pi
TURNS, KEPT = 24, 8
# Until what decays by a fifth a turn is gone.
SETTLED = 60
# Steps a turn; the error falls with at least the third power of their length, as what is found a delay ago has kinks
# within a step.
STEPS, FALLS = 600, 6.0
# Of the difference that a halving of the steps makes, and relative to the growth, what is left of either.
EARNED, ROUNDING = 4.0, 1e-8
# Of thirty tools, the share whose growth is as good as the steps, and how far the others are at most.
MOST, FITTED = 0.8, 3e-4
# Of the tip, relative to the largest displacement, at half as many steps.
PATH = 1e-4
# What is left after a turn of what is not the orbit, of which the march tells that at most.
DECAYED = 0.8
METHOD = lobex.Duhamel(nodes=36)

# Teeth, even pitch, modes, helix: each is a program of its own.
SHAPES = [(2, False, 2, False), (3, True, 3, True), (3, False, 1, False), (5, True, 2, False)]


def random_tool(rng, teeth, even, modes, helix):
    """Numbers of a tool, a cut and a speed, with a depth around its limit."""
    omega = TURN * np.sort(rng.uniform(300, 1200, modes))
    ratio = rng.uniform(0.01, 0.06, modes)
    direction = rng.uniform(0, TURN, modes)
    stiffness = rng.uniform(5e6, 3e7, modes)
    shape = (omega / np.sqrt(stiffness))[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    pitch = np.full(teeth, TURN / teeth) if even else TURN / teeth * (1 + rng.uniform(-0.2, 0.2, teeth))
    immersion = rng.uniform(0.05, 1.0)
    entry, leave = (np.arccos(2 * immersion - 1), np.pi) if rng.random() < 0.5 else (0.0, np.arccos(1 - 2 * immersion))
    tangential = rng.uniform(5e8, 1e9)
    mean = tangential * teeth * (leave - entry) / TURN
    softness = np.max(np.sum(shape**2, axis=1) / (4 * omega**2 * ratio))
    return {
        "omega": omega,
        "ratio": ratio,
        "shape": shape,
        "pitch": pitch * TURN / pitch.sum(),
        "even": even,
        "angles": np.array([entry, leave]),
        "forces": np.array([tangential, rng.uniform(0.1, 0.5) * tangential]),
        "lag": 2 * np.tan(np.deg2rad(rng.uniform(15, 40))) / 0.016 if helix else 0.0,
        "speed": omega[0] / TURN / teeth / rng.uniform(0.4, 2.0),
        "depth": rng.uniform(0.1, 0.8) / (softness * mean),
        "feed": 1e-4,
    }


def tools(shapes, each, seed):
    rng = np.random.default_rng(seed)
    return [random_tool(rng, *shape) for shape in shapes for _ in range(each)]


def process_of(tool):
    """The same as a process; up- and down-milling as angles, so that they share a program."""
    teeth = len(tool["pitch"])
    cutter = lobex.Cutter(
        teeth,
        diameter=0.016,
        pitch=None if tool["even"] else tool["pitch"],
        helix=np.arctan(tool["lag"] * 0.008) if tool["lag"] else None,
    )
    modes = lobex.Modes(tool["omega"], tool["ratio"], tool["shape"])
    return lobex.Milling(modes, cutter, *tool["forces"], angles=tool["angles"], feed_per_tooth=tool["feed"])


class March:
    """Tools side by side, their modes and teeth filled up with ones that do nothing."""

    def __init__(self, tools, steps):
        count, self.teeth = len(tools), max(len(tool["pitch"]) for tool in tools)
        modes = max(len(tool["omega"]) for tool in tools)
        self.omega, self.ratio = np.ones((count, modes)), np.full((count, modes), 0.5)
        self.shape = np.zeros((count, modes, 2))
        self.time, self.forces, self.fed = np.zeros((count, steps + 1)), [], []
        delay = np.ones((count, self.teeth))
        for lane, tool in enumerate(tools):
            n, teeth = len(tool["omega"]), len(tool["pitch"])
            self.omega[lane, :n], self.ratio[lane, :n], self.shape[lane, :n] = (
                tool[name] for name in ("omega", "ratio", "shape")
            )
            self.time[lane] = mesh(tool, steps)
            delay[lane, :teeth] = tool["pitch"] / TURN
            forces, fed = pushes(tool, self.time[lane], self.teeth)
            self.forces.append(forces)
            self.fed.append(fed)
        self.forces, self.fed = np.stack(self.forces, axis=2), np.stack(self.fed, axis=2)
        self.period = np.array([1 / tool["speed"] for tool in tools])
        # Where a delay ago each stage of each step looks, in turns before the one at hand.
        stage = self.time[:, :-1, None] + np.diff(self.time)[:, :, None] * np.array([0, 0.5, 1])
        self.look = [[self.place(stage[:, :, c, None] - delay[:, None, :])] for c in range(3)]

    def place(self, when):
        """Steps from the beginning of this turn, and weights of values and slopes at both of their ends."""
        steps = self.time.shape[1] - 1
        turns, within = np.floor(when), when - np.floor(when)
        index = np.stack([np.searchsorted(t, w, side="right") - 1 for t, w in zip(self.time, within, strict=True)])
        index = np.clip(index, 0, steps - 1)
        lanes = np.arange(len(self.time))[:, None, None]
        length = self.time[lanes, index + 1] - self.time[lanes, index]
        x = (within - self.time[lanes, index]) / length
        weights = [(1 + 2 * x) * (1 - x) ** 2, x * (1 - x) ** 2 * length, x**2 * (3 - 2 * x), x**2 * (x - 1) * length]
        return (index + turns * steps).astype(int), np.stack(weights)

    def run(self, forced, turns, seed=1):
        """Tips and their slopes by turn at all nodes, (nodes, lanes, 2), and states at the ends of turns."""
        steps, (lanes, modes) = self.time.shape[1] - 1, self.omega.shape
        period = self.period[:, None]
        y, slope = np.zeros((2, (turns + 1) * steps + 1, lanes, 2))
        state = np.zeros((2, lanes, modes))
        if not forced:
            state[0] = np.random.default_rng(seed).normal(size=(lanes, modes)) / np.maximum(self.omega, 1) * 1e-3
        row, length = np.arange(lanes)[:, None], np.diff(self.time)

        def rate(state, step, now, c):
            index, weights = (
                part[:, step % steps] if p == 0 else part[:, :, step % steps] for p, part in enumerate(self.look[c][0])
            )
            index = index + (step // steps + 1) * steps
            before = sum(
                weight[..., None] * values[at, row]
                for weight, values, at in zip(
                    weights, (y, slope, y, slope), (index, index, index + 1, index + 1), strict=True
                )
            )
            tip = np.einsum("lm,lmr->lr", state[0], self.shape)
            force = -np.einsum("ljrs,ljs->lr", self.forces[c, step % steps], tip[:, None] - before)
            if forced:
                force = force - self.fed[c, step % steps]
            push = np.einsum("lmr,lr->lm", self.shape, force)
            return period * np.stack(
                [state[1], push - 2 * self.ratio * self.omega * state[1] - self.omega**2 * state[0]]
            )

        for step in range(turns * steps):
            node, h = step + steps, length[:, step % steps, None]
            y[node] = np.einsum("lm,lmr->lr", state[0], self.shape)
            slope[node] = period * np.einsum("lm,lmr->lr", state[1], self.shape)
            one = rate(state, step, node, 0)
            two = rate(state + h / 2 * one, step, node, 1)
            three = rate(state + h / 2 * two, step, node, 1)
            four = rate(state + h * three, step, node, 2)
            state = state + h / 6 * (one + 2 * two + 2 * three + four)
            y[node + 1] = np.einsum("lm,lmr->lr", state[0], self.shape)
            slope[node + 1] = period * np.einsum("lm,lmr->lr", state[1], self.shape)
        return y, slope


def mesh(tool, steps):
    """Nodes of a turn from 0 to 1, at all places where tips and ends of edges enter and leave."""
    tips = np.cumsum(tool["pitch"]) - tool["pitch"]
    end = tool["lag"] * tool["depth"]
    places = [(a + b - tip) / TURN for a in tool["angles"] for b in {0.0, end} for tip in tips]
    places = np.unique(np.round(np.r_[0.0, np.mod(places, 1.0), 1.0], 12))
    share = np.diff(places)
    count = np.maximum(np.floor(share * (steps - len(share))).astype(int), 1)
    while count.sum() < steps:
        count[np.argmax(share / count)] += 1
    return np.r_[
        0.0,
        np.concatenate([np.linspace(a, b, n + 1)[1:] for a, b, n in zip(places[:-1], places[1:], count, strict=True)]),
    ]


def pushes(tool, nodes, most):
    """Cutting matrices (3, steps, teeth, 2, 2), and forces of the feed, (3, steps, 2), at three places of a step."""
    tips = np.cumsum(tool["pitch"]) - tool["pitch"]
    entry, leave = tool["angles"]
    lag = tool["lag"] * tool["depth"]
    points, weights = np.polynomial.legendre.leggauss(12)
    length = np.diff(nodes)
    matrices, fed = np.zeros((3, len(length), most, 2, 2)), np.zeros((3, len(length), 2))
    for c, share in enumerate((0.0, 0.5, 1.0)):
        # From within the step, so that a jump at its end is seen from its side.
        inside = nodes[:-1] + length * np.clip(share, 1e-6, 1 - 1e-6)
        for tooth, (tip, pitch) in enumerate(zip(tips, tool["pitch"], strict=True)):
            lead = np.mod(TURN * inside + tip, TURN)
            if lag:
                # The edge covers angles from the end, behind, to the tip; twice where it lies across angle 0.
                total = 0.0
                for ahead in (lead, lead + TURN):
                    low, high = np.clip(ahead - lag, entry, leave), np.clip(ahead, entry, leave)
                    angle = low[:, None] + (high - low)[:, None] * (points + 1) / 2
                    part = (high - low)[:, None] / 2 * weights / tool["lag"]
                    total = total + outer(angle, part, tool, pitch)
            else:
                cuts = ((lead > entry) & (lead < leave)) * tool["depth"]
                total = outer(lead[:, None], cuts[:, None], tool, pitch)
            matrices[c, :, tooth] = total[..., :2]
            fed[c] += total[..., 2]
    return matrices, fed


def outer(angle, width, tool, pitch):
    """Sum over the points of (K_t t + K_n n) nᵀ, and beside it that of the chip of the feed, (steps, 2, 3)."""
    n, t = np.stack([np.sin(angle), np.cos(angle)]), np.stack([np.cos(angle), -np.sin(angle)])
    along = tool["forces"][0] * t + tool["forces"][1] * n
    chip = tool["feed"] * len(tool["pitch"]) * pitch / TURN * n[:1]
    return np.einsum("rsp,csp,sp->src", along, np.concatenate([n, chip]), width)


def snapshots(march, y, turns):
    """The motion during each of the last turns, (lanes, turns, size)."""
    steps = march.time.shape[1] - 1
    rows = y[-turns * steps - 1 : -1].reshape(turns, steps, -1, 2)
    return np.moveaxis(rows, 2, 0).reshape(len(march.omega), turns, -1)


def growth_of(march):
    """The largest factor in a turn, of the recurrence that the last turns follow."""
    y, _ = march.run(False, TURNS)
    found = []
    for rows in snapshots(march, y, KEPT + 1):
        scale = np.linalg.norm(rows[-1])
        basis, sizes, _ = np.linalg.svd(rows[:-1].T / scale, full_matrices=False)
        keep = sizes > 1e-7 * sizes[0]
        first, after = basis.T[keep] @ rows[:-1].T, basis.T[keep] @ rows[1:].T
        found.append(np.abs(np.linalg.eigvals(after @ np.linalg.pinv(first, rcond=1e-7))).max())
    return np.array(found)


def orbit_of(march, share):
    """Where the tip is at a share of the nodes of a turn, (lanes, 2), in the motion that the march tends to.

    By reduced rank extrapolation of the last turns, which takes off what decays slowest.
    """
    y, _ = march.run(True, SETTLED)
    steps = march.time.shape[1] - 1
    found = []
    for rows in snapshots(march, y, KEPT + 1):
        change = np.diff(rows, axis=0)
        gram = change @ change.T
        # What is there already is not to be extrapolated.
        moving = np.linalg.norm(change[-1]) > 1e-12 * np.linalg.norm(rows[-1])
        weight = np.linalg.lstsq(gram, np.ones(KEPT), rcond=1e-12)[0] if moving else np.eye(KEPT)[-1]
        limit = ((weight / weight.sum()) @ rows[1:]).reshape(steps, 2)
        found.append(limit[round(share * steps)])
    return np.array(found)


def compared(made):
    """How far growths of marches with few and many steps are from the multipliers, and what of it is theirs."""
    coarse, fine = March(made, STEPS // 2), March(made, STEPS)
    processes = [process_of(tool) for tool in made]
    radius = np.array(
        [
            float(lobex.spectral_radius(p, t["speed"], t["depth"], METHOD)) ** p.cutter.alike
            for p, t in zip(processes, made, strict=True)
        ]
    )
    found = [growth_of(march) for march in (coarse, fine)]
    off = [np.abs(growth / radius - 1) for growth in found]
    # What a halving still changed, of which a method of order three leaves a seventh.
    earned = np.abs(found[1] - found[0]) / radius / EARNED + ROUNDING
    assert np.median(off[0] / np.maximum(off[1], ROUNDING)) > FALLS, off
    return off[1], earned


@pytest.mark.slow
def test_a_march_grows_as_the_multipliers_say():
    off, earned = compared(tools(SHAPES, 1, 0))
    assert np.all(off < earned), (off, earned)


@pytest.mark.search
def test_thirty_marches_grow_as_the_multipliers_say():
    off, earned = compared(tools(SHAPES, 8, 1)[:30])
    # Of motions that decay fast the last turns tell the growth to fewer digits than the steps earn.
    assert np.mean(off < earned) > MOST, (off, earned)
    assert np.all(off < FITTED), off


def off_the_orbit(made):
    """How far the motions that marches of few and many steps come to are from the orbits, over the largest
    displacement, (2, tools), and what is left of anything else after a turn, (tools,)."""
    coarse, fine = March(made, STEPS // 4), March(made, STEPS // 2)
    share = 0.1
    found = [orbit_of(march, share) for march in (coarse, fine)]
    off, left = np.zeros((2, len(made))), np.zeros(len(made))
    for lane, tool in enumerate(made):
        process = process_of(tool)
        for case, march in enumerate((coarse, fine)):
            steps = march.time.shape[1] - 1
            phase = march.time[lane, round(share * steps)] * process.cutter.alike
            motion = lobex.orbit(process, tool["speed"], tool["depth"], METHOD, phase=[phase])
            off[case, lane] = np.abs(found[case][lane] - motion.displacement[0]).max() / motion.peak.max()
            left[lane] = float(motion.spectral_radius) ** process.cutter.alike
    return off, left


@pytest.mark.filterwarnings("ignore:.*leaves the cut")
@pytest.mark.slow
def test_a_march_comes_to_the_orbit():
    off, _ = off_the_orbit(tools(SHAPES[1:2], 2, 0))
    assert off[1].max() < PATH, off
    assert np.median(off[0] / np.maximum(off[1], ROUNDING)) > FALLS, off


# Every uneven pitch is a program of its own, and those of orbits take long: few of them.
@pytest.mark.filterwarnings("ignore:.*leaves the cut", "ignore:.*are unstable")
@pytest.mark.search
def test_thirty_marches_come_to_the_orbit():
    counts = zip(SHAPES, (2, 15, 2, 15), (4, 2, 5, 3), strict=True)
    off, left = off_the_orbit([tool for shape, each, seed in counts for tool in tools([shape], each, seed)])
    off = off[:, left < DECAYED]
    assert off.shape[1] >= 30
    # All of it is of the steps, of which a tool that takes many waves a turn has too few.
    assert np.all(off[1] < np.maximum(off[0] / EARNED, ROUNDING)), (off, left)
    assert np.median(off[1]) < PATH / 4, off
