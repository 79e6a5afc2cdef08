"""Reference cases of cutters and turning tools: variable pitch and process damping, groups a and e."""

from collections.abc import Iterator
from math import acos, isclose, pi
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

import lobex
from reference_tasks import Case, Multiplier, Numbers, Task, crossings, lowest, name, part_of_a_turn


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
