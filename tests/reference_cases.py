"""The cases of a file of reference numbers as processes of lobex: one small builder per group.

Conventions and equations stand in the file itself, under "conventions". What differs between cases in numbers alone is
handed to one function by ``Partial``, so that it is compiled once.
"""

from collections.abc import Iterator
from math import isclose, pi, sqrt
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

import lobex
from reference_tasks import (
    Case,
    Inexpressible,
    Multiplier,
    Numbers,
    Task,
    crossings,
    lowest,
    name,
    whole_parts,
)
from reference_tools import forced_motion, helix, process_damping, variable_pitch

# Steps of Newton's method from the delay of the speed now.
NEWTON = 12


def cases_of(reference: Case) -> Iterator[Task]:
    """Every case of a file."""
    builders = {
        **{"a": variable_pitch, "b": helix, "c": speed_variation, "d": mathieu, "e": process_damping},
        **{"f": forced_motion, "g": blade, "g3": ring},
    }
    for group, content in reference.items():
        if group in builders:
            yield from builders[group](content)
        elif group != "conventions":
            yield from unknown(group, content, "is a group without a builder")


def unknown(group: str, content: Case, reason: str) -> Iterator[Task]:
    """Of a group that cannot be expressed, every case."""
    for part, listed in content.items():
        if isinstance(listed, list):
            yield from (Inexpressible(f"{group} {part}", name(case), reason) for case in listed)


def speed_variation(content: Case) -> Iterator[Task]:
    """Group c; the speed is that of the mean spindle."""
    for part in ("mu", "critical"):
        for case in content[part]:
            ratio, omega = case.get("zeta", 0.02), 2 * pi * case.get("wn_Hz", 100.0)
            speed = case["rpm"] / 60
            mode = lobex.Modes.single(frequency=omega / (2 * pi), damping_ratio=ratio, mass=1 / omega**2)
            if case["form"] == "constant speed":
                crossing = case["crossings"][0]
                given = case | {"kind": crossing["kind"], "rel_diff": crossing["rel_diff"]}
                yield lowest("c constant speed", lobex.Rub(mode), speed, given, crossing["gain"], (0.0, 0.0), None)
                continue
            if case["form"] == "exact":
                variation = lobex.SpeedVariation(case["RVA"], case["RVF"])
                process = lobex.Turning(mode, 1.0, speed_unit="1", speed_variation=variation)
            else:
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
        process = blade_process(content, case)
        group, speed, limit = f"g {case['case']}", case["speed_Hz"], case["critical_K"]
        yield lowest(f"{group} limit", process, speed, case, limit, (1e-2 * limit, 1.1 * limit), None)
        for point in case["points"]:
            yield Multiplier(f"{group} mu", f"{name(case)} K={point['K']:g}", process, speed, point["K"], point)


def blade_process(content: Case, case: Case) -> Any:
    """The blade of a case."""
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
    across = np.concatenate([2 / sqrt(mass) * (-1.0) ** np.arange(bending), np.zeros(axial)])
    along = np.concatenate([np.zeros(bending), sqrt(2 / mass) * (-1.0) ** order])
    tip = lobex.Modes(omega, np.full(len(omega), beam["xi"]), np.stack([along, across], axis=1))
    # A negative coefficient is that of a tip that slides the other way.
    normal, along_it = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    modes = tip.in_contact(normal, -along_it if friction < 0 else along_it, abs(friction))
    if case["case"] == "casing-ring":
        waves = case.get("nodal_diameters", casing["nd"])
        own = {"frequency": casing["frequency_Hz"], "damping_ratio": casing["xi"], "mass": casing["m"]}
        return lobex.Rub(modes, casing=lobex.Ring(nodal_diameter=waves, **own))
    if case["case"] == "casing-local":
        local = lobex.Modes.single(frequency=casing["frequency_Hz"], damping_ratio=casing["xi"], mass=casing["m"])
        return lobex.Rub(modes, casing=local)
    if case["case"] == "centrifugal":
        by_speed = np.diag(case["B"])
        shapes = modes.shape, modes.loading, range(1, modes.count + 1)
        return lobex.Rub(lobex.RotatingModes(modes.angular_frequency, by_speed, None, modes.damping_ratio, *shapes))
    return lobex.Rub(modes)


def ring(content: Case) -> Iterator[Task]:
    """Group g3."""
    one = content["ring"]
    blades = int(one["N"])
    alone = lobex.Modes.single(frequency=one["f"], damping_ratio=one["xi"], mass=one["phi"] ** -2)
    for case in content["cases"]:
        kind, speed = case["case"], case["speed_Hz"]
        blading = lobex.Blading(
            alone,
            blades,
            mistuning=np.asarray(one["mistune"]) if "mistuned" in kind else None,
            spacing=np.asarray(one["gaps_deg"], dtype=float) if "unequal" in kind else None,
            coupling=one["coupling_Hz"] if "coupled" in kind else None,
        )
        process, exact = lobex.Rub(blading), "coupled" not in kind or kind == "identical-coupled"
        # Of the passing of one blade, where they are evenly spaced.
        periods = 1 if "unequal" in kind else blades
        limit = case["critical_K"]
        # Of one blade alone, the least of all speeds.
        least = 2 * one["xi"] * (2 * pi * one["f"] / one["phi"]) ** 2
        bounds = 0.2 * least, max(5 * least, 1.2 * limit)
        told = case | ({"kind": "hopf"} if abs(case["mu"][1]) > 1e-6 else {})
        yield lowest(f"g3 {kind} limit", process, speed, told, limit, bounds, None if exact else 65)
        for point in case["points"]:
            shown = f"{name(case)} K={point['K']:g}"
            yield Multiplier(f"g3 {kind} mu", shown, process, speed, point["K"], point, periods)


def part_of_a_turn(numbers: Numbers, speed: Any, gain: Any) -> Any:
    return 1 / (numbers * speed)
