"""The cases of a file of reference numbers as processes of lobex: one small builder per group.

Conventions and equations stand in the file itself, under "conventions". What differs between cases in numbers alone is
handed to one function by ``Partial``, so that it is compiled once.
"""

from collections.abc import Iterator
from math import acos, ceil, isclose, pi, sqrt
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

import lobex

Case = dict[str, Any]
Numbers = Any


class Multiplier(NamedTuple):
    """A multiplier wanted, over ``passes`` periods of the process."""

    group: str
    name: str
    process: Any
    speed: float
    gain: float
    case: Case
    passes: int = 1


class Limits(NamedTuple):
    """Changes of stability wanted: gain, what the process becomes, kind and chatter frequency (None where not told).

    ``scan`` is None where the limit has a closed form; ``lowest`` where the file tells that one alone.
    """

    group: str
    name: str
    process: Any
    speed: float
    bounds: tuple[float, float]
    scan: int | None
    changes: list[tuple[float, str, str | None]]
    frequency: float | None
    rel_diff: float
    lowest: bool = False


class Inexpressible(NamedTuple):
    """A case that no verb takes yet, and why."""

    group: str
    name: str
    reason: str


Task = Multiplier | Limits | Inexpressible


def cases_of(reference: Case) -> Iterator[Task]:
    """Every case of a file."""
    builders = {"a": variable_pitch, "c": speed_variation, "d": mathieu, "e": process_damping, "g": blade, "g3": ring}
    missing = {"b": "helix", "f": "forcing"}
    for group, content in reference.items():
        if group in builders:
            yield from builders[group](content)
        elif group in missing:
            yield from unknown(group, content, f"needs {missing[group]}")
        elif group != "conventions":
            yield from unknown(group, content, "is a group without a builder")


def unknown(group: str, content: Case, reason: str) -> Iterator[Task]:
    """Of a group that cannot be expressed, every case."""
    for part, listed in content.items():
        if isinstance(listed, list):
            yield from (Inexpressible(f"{group} {part}", name(case), reason) for case in listed)


def name(case: Case) -> str:
    """What tells a case from others: its numbers, less those that are wanted."""
    wanted = ("mu", "second", "spectral_radius", "crossings", "points", "scan", "scan_m", "changes", "kind")
    told = {k: v for k, v in case.items() if k not in wanted and not k.endswith(("rel_diff", "points", "discs"))}
    return " ".join(f"{k}={v:.6g}" if isinstance(v, float) else f"{k}={v}" for k, v in told.items())


def crossings(group: str, process: Any, speed: float, case: Case, gain: str) -> Limits:
    """The limits of a case that lists every crossing of a scan."""
    low, high, count = case.get("scan") or case["scan_m"]
    changes = [(c[gain], c["becomes"], c["kind"]) for c in case["crossings"]]
    rel_diff = max([c["rel_diff"] for c in case["crossings"]], default=0.0)
    return Limits(group, name(case), process, speed, (low, high), int(count), changes, None, rel_diff)


def lowest(
    group: str,
    process: Any,
    speed: float,
    case: Case,
    gain: float | None,
    bounds: tuple[float, float],
    scan: int | None,
) -> Limits:
    """The limit of a case that tells the lowest alone."""
    changes = [] if gain is None else [(gain, "unstable", case.get("kind"))]
    found = case.get("chatter_Hz")
    return Limits(group, name(case), process, speed, bounds, scan, changes, found, case.get("rel_diff", 0.0), True)


def whole_parts(shortest: float, longest: float) -> tuple[float, float]:
    """A range of delays that holds the one given, of few values: what is compiled depends on it."""
    parts = ceil(1 / shortest - 1e-9)
    return 1 / parts, ceil(longest * parts - 1e-9) / parts


# Steps of Newton's method from the delay of the speed now.
NEWTON = 12


# Tools: their structure, and the forces of their teeth.


def structure(modes: list[Case], axes: str, velocities: bool = False) -> dict[str, np.ndarray]:
    """A, E and C of modes along x and y; the state of each is (q, q'/omega), y is the displacement of each axis, and,
    if asked for, the velocities, over the omega of the first mode."""
    n = len(modes)
    omega = 2 * pi * np.array([mode["frequency_Hz"] for mode in modes])
    mass, ratio = (np.array([mode[key] for mode in modes]) for key in ("modal_mass_kg", "damping_ratio"))
    along = np.array([[float(mode.get("axis", axes) == axis) for mode in modes] for axis in axes])
    drift = np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -2 * np.diag(ratio * omega)]])
    inputs = np.concatenate([np.zeros((n, len(axes))), (along / (mass * omega)).T])
    outputs = np.concatenate([along, np.zeros((len(axes), n))], axis=1)
    if velocities:
        outputs = np.concatenate(
            [outputs, np.concatenate([np.zeros((len(axes), n)), along * omega / omega[0]], axis=1)]
        )
    return {"drift": drift, "inputs": inputs, "outputs": outputs}


def cut(case: Case) -> tuple[float, float]:
    """The angles between which a tooth cuts."""
    immersion = case["radial_immersion"]
    if case["direction"] == "slot" or isclose(immersion, 1.0):
        return 0.0, pi
    return (0.0, acos(1 - 2 * immersion)) if case["direction"] == "up" else (acos(2 * immersion - 1), pi)


def directions(numbers: Numbers, t: Any, speed: Any) -> tuple[Any, Any, Any]:
    """Of every tooth, (N, 2): n and t while it cuts, and its force direction Kt t + Kn n."""
    angle = 2 * jnp.pi * speed * t + numbers["angle"]
    place = jnp.mod(angle, 2 * jnp.pi)
    cutting = ((place > numbers["entry"]) & (place < numbers["exit"]))[:, None]
    normal = cutting * jnp.stack([jnp.sin(angle), jnp.cos(angle)], axis=1)
    tangent = cutting * jnp.stack([jnp.cos(angle), -jnp.sin(angle)], axis=1)
    return normal, tangent, numbers["tangential"] * tangent + numbers["normal"] * normal


def cutting_force(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    """What teeth do to a displacement, by their share, (e, r): share of b (Kt t + Kn n) nᵀ."""
    normal, _, force = directions(numbers, t, speed)
    whole = gain * jnp.einsum("j,ja,jb->ab", numbers["share"], force, normal)
    return numbers["axes"] @ whole @ numbers["axes"].T


def damped_force(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    """The same of displacement, and of velocity over omega: process damping has no past."""
    normal, tangent, _ = directions(numbers, t, speed)
    rate = numbers["omega"] * gain * numbers["damping"] / (numbers["radius"] * 2 * jnp.pi * speed)
    damping = rate * jnp.einsum("ja,jb->ab", normal + numbers["friction"] * tangent, normal)
    damping = numbers["damped"] * numbers["axes"] @ damping @ numbers["axes"].T
    return jnp.concatenate([cutting_force(numbers, t, speed, gain), damping], axis=1)


def part_of_a_turn(numbers: Numbers, speed: Any, gain: Any) -> Any:
    return 1 / (numbers * speed)


def angle_ago(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    return numbers / (2 * jnp.pi * speed)


def tool_process(tool: Case, case: Case) -> tuple[Any, int]:
    """A straight-toothed tool with any pitch, and how many of its periods are those of the file."""
    damping = tool.get("process_damping")
    axes = "".join(axis for axis in "xy" if any(mode["axis"] == axis for mode in tool["modes"]))
    pitch = np.deg2rad(np.asarray(case["pitch_deg"], dtype=float))
    teeth = len(pitch)
    # The pattern repeats so many times in a revolution.
    repeats = max(m for m in range(1, teeth + 1) if teeth % m == 0 and np.allclose(pitch, np.roll(pitch, teeth // m)))
    angle = np.concatenate([[0.0], np.cumsum(pitch)[:-1]])
    entry, leave = cut(case)
    numbers = {
        "angle": angle,
        "entry": entry,
        "exit": leave,
        "tangential": tool["Kt_N_per_m2"],
        "normal": tool["Kn_N_per_m2"],
        "axes": np.array([[float(axis == one) for one in "xy"] for axis in axes]),
    }
    function = cutting_force
    if damping:
        function = damped_force
        numbers |= {"damping": damping["C_N_per_m"], "radius": damping["radius_m"], "friction": damping["mu_f"]}
        numbers["omega"] = 2 * pi * tool["modes"][0]["frequency_Hz"]
    pitches = np.unique(np.round(pitch, 12))

    def force(share: np.ndarray, damped: float) -> Any:
        own = numbers | {"share": share} | ({"damped": damped} if damping else {})
        return Partial(function, own)

    alike = [np.abs(pitch - one) < 1e-9 for one in pitches]
    delays = [None] if repeats == teeth else [Partial(angle_ago, one) for one in pitches]
    places = np.concatenate([edge - angle for edge in (entry, leave)]) * repeats / (2 * pi)
    process = lobex.LinearDelay(
        **structure(tool["modes"], axes, velocities=bool(damping)),
        present=force(-np.ones(teeth), -1.0),
        delayed=[(force(1.0 * own, 0.0), delay) for own, delay in zip(alike, delays, strict=True)],
        period=Partial(part_of_a_turn, float(repeats)),
        breaks=np.unique(np.round(np.mod(places, 1.0), 12) % 1.0),
        delay_range=None if delays == [None] else tuple(pitches[[0, -1]] * repeats / (2 * pi)),
        speed_unit="rpm",
    )
    return process, 1 if repeats == teeth else repeats


def milling(tool: Case, case: Case) -> tuple[Any, int]:
    """The same by ``lobex.Milling`` or ``lobex.VariablePitch`` where it is exactly that: without process damping."""
    axes = {mode["axis"] for mode in tool["modes"]}
    if tool.get("process_damping") or axes != {"x", "y"}:
        return tool_process(tool, case)
    modes = lobex.Modes.plane(**{axis: along([m for m in tool["modes"] if m["axis"] == axis]) for axis in axes})
    immersion = 1.0 if case["direction"] == "slot" else case["radial_immersion"]
    direction = "down" if case["direction"] == "slot" else case["direction"]
    cutting = tool["Kt_N_per_m2"], tool["Kn_N_per_m2"], immersion, direction
    pitch = case["pitch_deg"]
    if len(set(pitch)) == 1:
        return lobex.Milling(modes, len(pitch), *cutting), 1
    return lobex.VariablePitch(modes, np.deg2rad(pitch), *cutting), 1


def along(modes: list[Case]) -> lobex.Modes:
    """The modes of one axis."""
    frequency, ratio, mass = (
        np.array([mode[key] for mode in modes]) for key in ("frequency_Hz", "damping_ratio", "modal_mass_kg")
    )
    return lobex.Modes(2 * pi * frequency, ratio, 1 / np.sqrt(mass)[:, None])


def variable_pitch(content: Case) -> Iterator[Task]:
    """Group a."""
    for case in content["mu"]:
        process, passes = milling(content["tools"][case["tool"]], case)
        yield Multiplier("a mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, passes)
    for case in content["critical"]:
        process, _ = milling(content["tools"][case["tool"]], case)
        yield crossings("a critical", process, case["rpm"] / 60, case, "depth_m")


def process_damping(content: Case) -> Iterator[Task]:
    """Group e."""
    for case in content["milling_mu"]:
        tool = content["tools"][case["tool"]]
        process, passes = milling(tool, tool)
        yield Multiplier("e milling_mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, passes)
    for case in content["milling_critical"]:
        tool = content["tools"][case["tool"]]
        yield crossings("e milling_critical", milling(tool, tool)[0], case["rpm"] / 60, case, "depth_m")
    for case in content["turning"]:
        machine = content["machines"][case["machine"]]
        keys = "K_N_per_m2", "C_N_per_m", "radius_m"
        numbers = np.array([*(machine[key] for key in keys), 2 * pi * machine["modes"][0]["frequency_Hz"]])
        process = lobex.LinearDelay(
            **structure(machine["modes"], "x", velocities=True),
            present=Partial(turning_force, numbers, np.array([-1.0, -1.0])),
            delayed=[(Partial(turning_force, numbers, np.array([1.0, 0.0])), None)],
            speed_unit="rpm",
        )
        speed = case["rpm"] / 60
        # The largest depth that anybody cuts, unless the file's limit lies above.
        bounds = 1e-6, max(3e-3, 2 * (case["depth_m"] or 0.0))
        yield lowest("e turning limit", process, speed, case, case["depth_m"], bounds, 129)
        for point in case["points"]:
            whole = f"{name(case)} depth={point['depth_m']:g}"
            yield Multiplier("e turning mu", whole, process, speed, point["depth_m"], point)


def turning_force(numbers: Numbers, share: Any, t: Any, speed: Any, gain: Any) -> Any:
    """(K b, C b/v) of displacement and velocity, over omega."""
    force, damping, radius, omega = numbers
    return gain * share * jnp.stack([force, omega * damping / (radius * 2 * jnp.pi * speed)])[None]


def speed_variation(content: Case) -> Iterator[Task]:
    """Group c; the speed is that of the mean spindle."""
    for part in ("mu", "critical"):
        for case in content[part]:
            ratio, omega = case.get("zeta", 0.02), 2 * pi * case.get("wn_Hz", 100.0)
            speed = case["rpm"] / 60
            if case["form"] == "constant speed":
                mode = lobex.Modes.single(frequency=omega / (2 * pi), damping_ratio=ratio, mass=1 / omega**2)
                crossing = case["crossings"][0]
                given = case | {"kind": crossing["kind"], "rel_diff": crossing["rel_diff"]}
                yield lowest("c constant speed", lobex.Rub(mode), speed, given, crossing["gain"], (0.0, 0.0), None)
                continue
            process = varying(case["form"], case["RVA"], case["RVF"], (2 * ratio * omega, omega**2, omega**2, 1.0))
            if part == "mu":
                yield Multiplier("c mu", name(case), process, speed, case["gain"], case)
            else:
                yield crossings("c critical", process, speed, case, "gain")
    process = varying("first-order", -0.1, 0.1, (0.1, 1.2, 1.0, 0.0))
    yield Multiplier("c oscillator", "oscillator", process, 0.3 / (2 * pi), 0.2, content["oscillator"])


def varying(form: str, amplitude: float, frequency: float, equation: tuple[float, float, float, float]) -> Any:
    """x'' + c x' + k x = gain p (x(t - tau(t)) - s x), of the numbers c, k, p and s."""
    damping, stiffness, force, now = equation
    chosen = np.array([float(form == one) for one in ("exact", "instantaneous", "first-order")])
    law = Partial(delay_by_law, {"A": amplitude, "R": frequency, "form": chosen})
    slowest = 1 - abs(amplitude)
    return lobex.LinearDelay.second_order(
        1.0,
        damping,
        Partial(stiffening, np.array([stiffness, force * now])),
        delayed=[(Partial(proportional, force), law)],
        period=Partial(part_of_a_turn, frequency),
        delay_range=whole_parts(frequency * slowest, frequency / slowest),
    )


def stiffening(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    return (numbers[0] + numbers[1] * gain)[None, None]


def proportional(factor: Any, t: Any, speed: Any, gain: Any) -> Any:
    return factor * gain


def delay_by_law(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    """All three forms, of which one is chosen."""
    amplitude, ratio = numbers["A"], numbers["R"]
    omega = 2 * jnp.pi * speed
    turned = omega * t
    change = amplitude * jnp.sin(ratio * turned)
    exact = 2 * jnp.pi / (1 + change)
    for _ in range(NEWTON):
        before = ratio * (turned - exact)
        angle = exact - amplitude / ratio * (jnp.cos(ratio * turned) - jnp.cos(before))
        exact = exact - (angle - 2 * jnp.pi) / (1 + amplitude * jnp.sin(before))
    return numbers["form"] @ jnp.stack([exact, 2 * jnp.pi / (1 + change), 2 * jnp.pi * (1 - change)]) / omega


def mathieu(content: Case) -> Iterator[Task]:
    """Group d."""
    for part in ("mu", "critical"):
        for case in content[part]:
            share = case["tau"] / (2 * pi)
            whole = isclose(share, 1.0)
            process = lobex.LinearDelay.second_order(
                1.0,
                case["a1"],
                Partial(pulsating, np.array([case["delta"], case["eps"]], dtype=float)),
                delayed=[(Partial(proportional, 1.0), None if whole else case["tau"])],
                period=2 * pi,
                delay_range=None if whole else whole_parts(share, share),
            )
            if part == "mu":
                yield Multiplier("d mu", name(case), process, 1.0, case["b"], case)
            else:
                yield crossings("d critical", process, 1.0, case, "b")


def pulsating(numbers: Numbers, t: Any, speed: Any, gain: Any) -> Any:
    return (numbers[0] + numbers[1] * jnp.cos(t))[None, None]


# Blades that rub.


def blade(content: Case) -> Iterator[Task]:
    """Group g."""
    for case in content["cases"]:
        process, exact = blade_process(content, case)
        group, speed, limit = f"g {case['case']}", case["speed_Hz"], case["critical_K"]
        bounds = (1e-2 * limit, 1.1 * limit)
        yield lowest(f"{group} limit", process, speed, case, limit, bounds, None if exact else 129)
        for point in case["points"]:
            yield Multiplier(f"{group} mu", f"{name(case)} K={point['K']:g}", process, speed, point["K"], point)


def blade_process(content: Case, case: Case) -> tuple[Any, bool]:
    """The blade of a case, and whether ``exact_limit`` takes it."""
    beam, casing = content["beam"], content["casing"]
    alone = case["case"] != "beam"
    angle = np.deg2rad(case.get("alpha_deg", casing["alpha_deg"]))
    friction = case.get("friction", casing["friction"])
    bending, axial = (3, 0) if alone else (beam["bending"], beam["axial"])
    area = beam["width"] * beam["thickness"]
    inertia = beam["width"] * beam["thickness"] ** 3 / 12
    beta = np.asarray(content["beta"][:bending])
    mass = beam["rho"] * area * beam["L"]
    order = np.arange(axial)
    omega = np.concatenate(
        [
            beta**2 / beam["L"] ** 2 * sqrt(beam["E"] * inertia / (beam["rho"] * area)),
            (2 * order + 1) * pi / (2 * beam["L"]) * sqrt(beam["E"] / beam["rho"]),
        ]
    )
    if case["case"] == "centrifugal":
        omega = np.sqrt(omega**2 + np.asarray(case["B"]) * (2 * pi * case["speed_Hz"]) ** 2)
    across = np.concatenate([2 / sqrt(mass) * (-1.0) ** np.arange(bending), np.zeros(axial)])
    along = np.concatenate([np.zeros(bending), sqrt(2 / mass) * (-1.0) ** order])
    shape = np.cos(angle) * along + np.sin(angle) * across
    loading = shape + friction * (-np.sin(angle) * along + np.cos(angle) * across)
    ratio = np.full(len(omega), beam["xi"])
    if case["case"] == "casing-ring":
        return in_ring_casing(omega, ratio, shape, loading, casing, case), False
    if case["case"] == "casing-local":
        omega = np.append(omega, 2 * pi * casing["frequency_Hz"])
        ratio = np.append(ratio, casing["xi"])
        shape, loading = (np.append(side, -1 / sqrt(casing["m"])) for side in (shape, loading))
    return lobex.Rub(lobex.Modes(omega, ratio, shape[:, None], loading[:, None])), True


def in_ring_casing(
    omega: np.ndarray, ratio: np.ndarray, shape: np.ndarray, loading: np.ndarray, casing: Case, case: Case
) -> Any:
    """Seen from the contact, which turns past the casing: p_c + i p_s = (c + i s) e^{i nd theta}."""
    n, own = len(omega), 2 * pi * casing["frequency_Hz"]
    turning = 2 * pi * case["speed_Hz"] * case.get("nodal_diameters", casing["nd"])
    turn = turning * np.array([[0.0, -1.0], [1.0, 0.0]])
    damping = 2 * np.diag(np.append(ratio * omega, [casing["xi"] * own] * 2))
    damping[n:, n:] += 2 * turn
    stiffness = np.diag(np.append(omega**2, [own**2 - turning**2] * 2))
    stiffness[n:, n:] += 2 * casing["xi"] * own * turn
    return contact_process(
        damping, stiffness, np.append(loading, [-1 / casing["m"], 0])[:, None], np.append(shape, [-1.0, 0])[None]
    )


def contact_process(
    damping: np.ndarray,
    stiffness: np.ndarray,
    loading: np.ndarray,
    seen: np.ndarray,
    delayed: Any = None,
    **others: Any,
) -> Any:
    """q'' + C q' + K q = loading f and f = -gain (seen q - what was there); the state is (q, q'/omega)."""
    p = len(damping)
    omega = sqrt(np.mean(np.diag(stiffness)))
    return lobex.LinearDelay(
        drift=np.block([[np.zeros((p, p)), omega * np.eye(p)], [-stiffness / omega, -damping]]),
        inputs=np.concatenate([np.zeros(loading.shape), loading / omega]),
        outputs=np.concatenate([seen, np.zeros(seen.shape)], axis=1),
        present=Partial(proportional, -np.eye(len(seen))),
        delayed=delayed or [(Partial(proportional, np.eye(len(seen))), None)],
        **others,
    )


def ring(content: Case) -> Iterator[Task]:
    """Group g3."""
    one = content["ring"]
    blades = int(one["N"])
    unit = np.eye(blades)
    for case in content["cases"]:
        kind, speed = case["case"], case["speed_Hz"]
        mistune = np.asarray(one["mistune"]) * ("mistuned" in kind)
        gaps = np.asarray(one["gaps_deg"]) / 360 if "unequal" in kind else np.full(blades, 1 / blades)
        omega = 2 * pi * one["f"] * (1 + mistune)
        between = (2 * pi * one["coupling_Hz"]) ** 2 * ("coupled" in kind)
        stiffness = np.diag(omega**2) + between * (2 * unit - np.roll(unit, 1, axis=0) - np.roll(unit, -1, axis=0))
        # Blade j meets what blade j - 1 left.
        before = np.roll(unit, 1, axis=0)
        if "unequal" in kind:
            delayed = [
                (Partial(proportional, np.outer(unit[j], before[j])), Partial(part_of_a_turn_ago, gaps[j]))
                for j in range(blades)
            ]
        else:
            delayed = [(Partial(proportional, before), Partial(part_of_a_turn_ago, 1 / blades))]
        process = contact_process(
            np.diag(2 * one["xi"] * omega),
            stiffness,
            one["phi"] * unit,
            one["phi"] * unit,
            delayed,
            delay_range=whole_parts(gaps.min(), gaps.max()),
        )
        limit = case["critical_K"]
        # Of one blade alone, the least of all speeds.
        least = 2 * one["xi"] * (2 * pi * one["f"] / one["phi"]) ** 2
        bounds = 0.2 * least, max(5 * least, 1.2 * limit)
        told = case | ({"kind": "hopf"} if abs(case["mu"][1]) > 1e-6 else {})
        yield lowest(f"g3 {kind} limit", process, speed, told, limit, bounds, 65)
        for point in case["points"]:
            yield Multiplier(f"g3 {kind} mu", f"{name(case)} K={point['K']:g}", process, speed, point["K"], point)


def part_of_a_turn_ago(share: Any, t: Any, speed: Any, gain: Any) -> Any:
    return share / speed
