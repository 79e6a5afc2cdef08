"""Reference cases of cutters and turning tools: variable pitch, process damping and motion, groups a, e and f."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial

import lobex
from lobex.processes.quantity import DEPTH_OF_CUT
from lobex.systems.coefficients import Framed
from lobex.systems.mesh import places_that_matter
from lobex.systems.system import DelaySystem, Places
from lobex.systems.terms import Delayed, Present
from reference_tasks import Case, Motion, Multiplier, Numbers, Task, crossings, lowest, name

# No friction; a process takes numbers above zero.
NONE = 1e-99


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Damped:
    """A cutter with process damping, -b C/v sum g (n + mu_f t)(n.r'): cutting forces of mu_f and 1 on the velocity."""

    cutter: Any
    rubbing: Any
    damping: Any
    radius: Any
    places: Places | None = field(default=None, metadata={"static": True})

    gain: ClassVar = DEPTH_OF_CUT
    speed_unit: ClassVar[str] = "rpm"

    def system(self, speed: Any, gain: Any) -> DelaySystem:
        cut = self.cutter.system(speed, gain)
        omega = cut.blocks[:, 0, 1]
        # Velocities over the omega of the first mode, so that they are of the size of displacements.
        rub = self.rubbing.system(speed, gain * omega[0] * self.damping / (self.radius * 2 * jnp.pi * speed))
        shape = cut.outputs[:, :, 0]
        rate = jnp.stack([jnp.zeros_like(shape), shape * (omega / omega[0])[:, None]], axis=2)
        unit, none = jnp.eye(cut.output_size), jnp.zeros((cut.output_size, cut.output_size))
        place, velocity = jnp.concatenate([unit, none], axis=1), jnp.concatenate([none, unit], axis=1)
        now = [Present(Framed(-unit, term.coefficient, place)) for term in cut.terms]
        now += [Present(Framed(-unit, term.coefficient, velocity)) for term in rub.terms]
        before = [Delayed(term.coefficient, term.delay) for term in cut.terms]
        return replace(
            cut,
            outputs=jnp.concatenate([cut.outputs, rate], axis=1),
            remembered=cut.outputs,
            terms=(*now, *before),
            places=self.places,
        )


def cutter(tool: Case, case: Case) -> Any:
    """The tool of a case."""
    modes = tool["modes"]
    frequency, ratio, mass = (
        np.array([mode[key] for mode in modes]) for key in ("frequency_Hz", "damping_ratio", "modal_mass_kg")
    )
    along = np.array([[float(mode["axis"] == axis) for axis in "xy"] for mode in modes])
    immersion = 1.0 if case["direction"] == "slot" else case["radial_immersion"]
    direction = "down" if case["direction"] == "slot" else case["direction"]
    pushed = {"feed_per_tooth": case["feed_per_tooth_m"]} if "feed_per_tooth_m" in case else {}
    helix = np.atleast_1d(case.get("helix_deg") or 0.0)
    geometry = lobex.Cutter.end_mill(
        (tool | case).get("diameter_m"),
        pitch_degrees=(tool | case)["pitch_deg"],
        helix_degrees=helix[0] if len(set(helix)) == 1 else helix,
        runout=case.get("runout_m"),
    )
    structure = lobex.Modes(2 * pi * frequency, ratio, along / np.sqrt(mass)[:, None])

    def make(tangential: float, normal: float, **others: Any) -> Any:
        return lobex.Milling(structure, geometry, tangential, normal, immersion, direction, **others)

    process = make(tool["Kt_N_per_m2"], tool["Kn_N_per_m2"], **pushed)
    if not (damping := tool.get("process_damping")):
        return process
    rubbing = make(damping["mu_f"] or NONE, 1.0)
    with jax.enable_x64(True):
        damped = Damped(process, rubbing, damping["C_N_per_m"], damping["radius_m"])
        return replace(damped, places=places_that_matter(damped.system(1.0, 1e-3)))


def periods(cutter: lobex.Cutter) -> int:
    """Of how many periods of the process the file tells a multiplier: of a tooth's where all are alike, else of a
    revolution's."""
    return 1 if cutter.alike == cutter.teeth else cutter.alike


def variable_pitch(content: Case) -> Iterator[Task]:
    """Group a."""
    for case in content["mu"]:
        process = cutter(content["tools"][case["tool"]], case)
        told = periods(process.cutter)
        yield Multiplier("a mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, told)
    for case in content["critical"]:
        process = cutter(content["tools"][case["tool"]], case)
        yield crossings("a critical", process, case["rpm"] / 60, case, "depth_m")


def helix(content: Case) -> Iterator[Task]:
    """Group b."""
    for part in ("mu", "variable_mu", "critical", "variable_critical"):
        for case in content.get(part, []):
            tool = content["tools"][case["tool"]] | case.get("changes", {})
            process, speed = cutter(tool, tool | case), case["rpm"] / 60
            if part.endswith("mu"):
                told = periods(process.cutter)
                yield Multiplier(f"b {part}", name(case), process, speed, case["depth_m"], case, told)
            else:
                yield crossings(f"b {part}", process, speed, case, "depth_m")


def forced_motion(content: Case) -> Iterator[Task]:
    """Group f; y is wanted where each tooth passes the finished wall."""
    for part in ("straight", "helix"):
        for case in content.get(part, []):
            tool = content["tools"][case["tool"]]
            process, pitch = cutter(tool, case), np.array(tool["pitch_deg"])
            wall = 0.0 if case["direction"] == "up" else 180.0
            if part == "helix":
                # The edge lags behind its tip by that much.
                angles = wall + np.rad2deg(process.cutter.twist * np.array(case["heights_m"]))
            else:
                angles = wall - np.cumsum(pitch) + pitch
            walls = np.mod(angles / 360 * process.cutter.alike, 1.0)
            yield Motion(f"f {part}", name(case), process, case["rpm"] / 60, case["depth_m"], walls, case)


def process_damping(content: Case) -> Iterator[Task]:
    """Group e."""
    for case in content["milling_mu"]:
        tool = content["tools"][case["tool"]]
        process = cutter(tool, tool)
        told = periods(process.cutter.cutter)
        yield Multiplier("e milling_mu", name(case), process, case["rpm"] / 60, case["depth_m"], case, told)
    for case in content["milling_critical"]:
        tool = content["tools"][case["tool"]]
        yield crossings("e milling_critical", cutter(tool, tool), case["rpm"] / 60, case, "depth_m")
    for case in content["turning"]:
        machine = content["machines"][case["machine"]]
        keys = "K_N_per_m2", "C_N_per_m", "radius_m"
        numbers = np.array([*(machine[key] for key in keys), 2 * pi * machine["modes"][0]["frequency_Hz"]])
        process = lobex.LinearDelay(
            **turning_structure(machine["modes"]),
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


def turning_structure(modes: list[Case]) -> dict[str, np.ndarray]:
    """A, E and C of modes in a row; the state of each is (q, q'/omega), and outputs are x and x' over the first
    omega."""
    n = len(modes)
    omega = 2 * pi * np.array([mode["frequency_Hz"] for mode in modes])
    mass, ratio = (np.array([mode[key] for mode in modes]) for key in ("modal_mass_kg", "damping_ratio"))
    none = np.zeros(n)
    return {
        "drift": np.block([[np.zeros((n, n)), np.diag(omega)], [-np.diag(omega), -2 * np.diag(ratio * omega)]]),
        "inputs": np.concatenate([none, 1 / (mass * omega)])[:, None],
        "outputs": np.stack([np.concatenate([none + 1, none]), np.concatenate([none, omega / omega[0]])]),
    }
