"""The catalogue of test problems: every kind of delay system, and multipliers of it from elsewhere than the method."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jax.tree_util import Partial
from scipy.special import lambertw, mathieu_a, mathieu_b

import lobex
from cases import GENERAL, MULTIPLIER_CASES, label, point
from lobex._pytree import pytree
from lobex.processes.quantity import PLAIN_GAIN, Quantity
from lobex.systems.coefficients import Constant
from lobex.systems.delays import ConstantDelay
from lobex.systems.system import DelaySystem
from lobex.systems.terms import Delayed, Present
from reference_cases import varying
from reference_tools import process_damping

CODES, CLOSED = "two independent codes", "closed form"


@dataclass(frozen=True)
class Problem:
    """A process at a point, and its multiplier of largest modulus, Im μ ≥ 0, or, with ``among``, one of them.

    Attributes:
        name: of the problem, in test names.
        kind: of the delay system; problems of a kind share their programs where they can.
        process, speed, gain: of the point.
        multiplier: the value; of what ``modulus`` tells, |μ| alone.
        tolerance: relative, of the value.
        tags: ``constant`` coefficients; ``jumps`` of them; ``repeats`` where every delay is the period; ``among``;
            ``modulus``.
        source: of the value.
        others: more of its multipliers.
    """

    name: str
    kind: str
    process: Any
    speed: float
    gain: float
    multiplier: complex
    tolerance: float
    tags: frozenset[str]
    source: str
    others: tuple[complex, ...] = ()

    def error(self, found: Any) -> float:
        """Of multipliers that a method found, largest first, relative to the value."""
        found = np.atleast_1d(found)
        if "among" in self.tags:
            return float(np.min(np.abs(found - self.multiplier))) / abs(self.multiplier)
        if "modulus" in self.tags or np.isrealobj(found):
            return float(abs(np.abs(found[0]) / abs(self.multiplier) - 1))
        return float(abs(found[0].real + 1j * abs(found[0].imag) - self.multiplier)) / abs(self.multiplier)


def times(matrix: Any, t: Any, speed: Any, gain: Any) -> Any:
    """matrix · gain."""
    return gain * matrix


def around(numbers: Any, t: Any, speed: Any, gain: Any) -> Any:
    """mean + amplitude cos 2πt/T, T = 1/speed."""
    return numbers[0] + numbers[1] * jnp.cos(2 * jnp.pi * speed * t)


def swelling(numbers: Any, t: Any, speed: Any, gain: Any) -> Any:
    """The same times the gain."""
    return gain * around(numbers, t, speed, gain)


def ago(periods: Any, t: Any, speed: Any, gain: Any) -> Any:
    return periods / speed


def share_of(periods: Any, speed: Any, gain: Any) -> Any:
    return periods / speed


def first_of(functions: Any) -> complex:
    """The root of largest modulus, Im ≥ 0, of a function of ln μ with its slope, by Newton's method."""
    root = (np.linspace(-3, 2, 41)[:, None] + 1j * np.linspace(0, 15, 61)).ravel()
    with np.errstate(all="ignore"):
        for _ in range(60):
            value, slope = functions(root)
            root = root - value / slope
        good = np.abs(functions(root)[0]) < 1e-10
    largest = root[good][np.argmax(root.real[good])]
    value = complex(np.exp(largest))
    return complex(value.real, abs(value.imag))


# One delay, which is the period.


def hayes_roots(a: float, b: float, delay: float) -> np.ndarray:
    """ln μ of ẋ = a x + b x(t − τ), over one delay: by Lambert's W."""
    roots = a * delay + lambertw(b * delay * np.exp(-a * delay), np.arange(-3, 4))
    return roots[np.argsort(-roots.real)]


def scalars() -> Iterator[Problem]:
    told = "constant repeats"
    for a, b, delay in ((-1.0, 0.5, 1.0), (0.3, -1.2, 0.7), (0.0, -1.0, 2.0), (-3.0, 2.0, 1.5)):
        values = np.exp(hayes_roots(a, b, delay))[:5]
        yield closed(f"hayes {a} {b}", "constant", lobex.Scalar(a), 1 / delay, b, values, told, 1e-10)
    for theta in (0.3, 1.0, 2.0, 2.8):
        a, b = theta / np.tan(theta), -theta / np.sin(theta)
        values = np.exp([1j * theta, -1j * theta])
        yield closed(f"hayes limit {theta}", "constant", lobex.Scalar(a), 1.0, b, values, told, 1e-11)
    for a in (-2.0, -0.5, 0.9):
        yield closed(f"hayes fold {a}", "constant", lobex.Scalar(a), 1.0, -a, 1.0, f"{told} among", 1e-11)


def of_codes() -> Iterator[Problem]:
    """Rubs, milling and Mathieu's equation with the period as their delay."""
    kinds = {"rod-rub": ("constant", "constant repeats"), "delayed-mathieu": ("periodic", "repeats")}
    for case in MULTIPLIER_CASES:
        kind, tags = kinds.get(case["problem"], ("jumps", "jumps repeats"))
        told = frozenset([*tags.split(), "modulus"])
        yield Problem(label(case), kind, *point(case), case["spectral_radius"], 1e-8, told, CODES)


def undamped_mathieu() -> Iterator[Problem]:
    """On the lines where one of the multipliers is 1 or −1: characteristic values of Mathieu's own equation."""
    delta = 1.2
    for epsilon in (0.5, 1.0, 3.0):
        for index in range(4):
            sign = 1 if index % 2 == 0 else -1
            values = [mathieu_a(index, 2 * epsilon)] + ([mathieu_b(index, 2 * epsilon)] if index else [])
            for value in values:
                name = f"mathieu line {epsilon} {index} {value:.3f}"
                process = lobex.DelayedMathieu(delta=delta, epsilon=epsilon)
                gain = sign * (delta - value / 4)
                yield closed(name, "periodic", process, 1 / (2 * np.pi), gain, sign, "repeats among", 1e-7)


def periodic_scalars() -> Iterator[Problem]:
    """ẋ = a(t) x + b(t) x(t − T): ln μ = A + B/μ, of their means over a period of 1."""
    for a, b in ((-0.4, 0.8), (-0.4, -1.3)):
        process = lobex.LinearDelay(
            [[0.0]],
            [(Partial(swelling, np.array([1.0, 0.6])), None)],
            present=Partial(around, np.array([a, -1.5])),
        )
        values = b / lambertw(b * np.exp(-a), np.array([0, -1, 1]))
        values = values[np.argsort(-np.abs(values))]
        yield closed(f"periodic scalar {b}", "periodic", process, 1.0, b, values, "repeats", 1e-10)


# Other delays than the period, and several.


def scalars_of_two_periods() -> Iterator[Problem]:
    """ẋ = a(t) x + b [x(t − T) − x(t − 2T)/2]: ln μ = A + B/μ − B/2μ²."""
    for a, b in ((-0.4, 0.8), (-0.4, -1.3)):
        process = lobex.LinearDelay(
            [[0.0]],
            [(Partial(swelling, np.array([1.0, 0.6])), None), (Partial(times, -0.5 * np.eye(1)), Partial(ago, 2.0))],
            present=Partial(around, np.array([a, -1.5])),
            delay_range=(1.0, 2.0),
        )

        def functions(z: Any, a: float = a, b: float = b) -> Any:
            once, twice = b * np.exp(-z), b * np.exp(-2 * z) / 2
            return z - a - once + twice, 1 + once - 2 * twice

        yield closed(f"two periods {b}", "whole periods", process, 1.0, b, first_of(functions), "", 1e-10)


def mathieu(case: dict[str, Any]) -> Any:
    """x'' + a1 x' + (delta + eps cos t) x = b x(t − tau), T = 2π, with the gain b."""
    stiffness = Partial(around, np.array([case["delta"], case["eps"]], dtype=float))
    return lobex.LinearDelay.second_order(
        1.0, case["a1"], stiffness, [(Partial(times, np.eye(1)), case["tau"])], period=2 * np.pi
    )


def own_mathieu() -> Iterator[Problem]:
    """With periods of their own, longer and shorter than the delay: by collocation and by Hill's determinant."""
    for case in GENERAL["mathieu"]:
        kind = "short delay" if case["tau"] < 2 * np.pi else "long delay"
        name = f"mathieu {case['ratio']} {case['delta']} {case['eps']}"
        speed = 1 / (2 * np.pi)
        yield Problem(name, kind, mathieu(case), speed, case["b"], complex(*case["mu"]), 1e-10, frozenset(), CODES)


def speed_variation() -> Iterator[Problem]:
    """A mode of 100 Hz that cuts with a spindle whose speed varies."""
    omega = 200 * np.pi
    for case in GENERAL["speed_variation"]:
        law = case["form"], case["RVA"], case["RVF"]
        process = varying(*law, (0.04 * omega, omega**2, omega**2, 1.0))
        name, speed = f"spindle {case['form']} {case['rpm']}", case["rpm"] / 60
        yield Problem(
            name, "varying delay", process, speed, case["gain"], complex(*case["mu"]), 1e-9, frozenset(), CODES
        )


def first_order(a: float) -> Any:
    """ẋ = a x + gain x(t − 1/speed), seen over a period of 0.7/speed: μ = exp(λ T), whatever T is."""
    return lobex.LinearDelay(
        drift=a,
        delayed=[(Partial(times, np.eye(1)), Partial(ago, 1.0))],
        period=Partial(share_of, 0.7),
        delay_range=(1 / 0.7, 1 / 0.7),
    )


def first_orders() -> Iterator[Problem]:
    for a, b, speed in ((-1.0, -3.0, 0.5), (-1.0, 2.0, 1.0)):
        value = np.exp(0.7 * hayes_roots(a, b, 1 / speed)[0])
        yield closed(f"hayes over 0.7 delays {b}", "first order", first_order(a), speed, b, value, "constant", 1e-10)


@pytree()
class Damper:
    """ẍ + c ẋ + k x = −d ẋ − p x + b x(t − 0.8) − 0.5 b x(t − 1.7), with a period of 1/speed.

    What acts now, which holds a velocity, is not what is remembered.
    """

    stiffness: Any = 2.0
    damping: Any = 0.2
    pull: Any = 0.1
    brake: Any = 0.3

    gain: ClassVar[Quantity] = PLAIN_GAIN
    speed_unit: ClassVar[str] = "1"

    def system(self, speed: Any, gain: Any) -> DelaySystem:
        gain = jnp.reshape(gain, (1, 1))
        stiffness, damping, pull, brake = map(jnp.asarray, (self.stiffness, self.damping, self.pull, self.brake))
        return DelaySystem(
            blocks=jnp.stack([jnp.array([0.0, 1.0]), jnp.stack([-stiffness, -damping])])[None],
            inputs=jnp.array([[[0.0], [1.0]]]),
            outputs=jnp.eye(2)[None],
            period=1 / speed,
            terms=(
                Present(Constant(-jnp.stack([pull, brake])[None])),
                Delayed(Constant(gain), ConstantDelay(0.8)),
                Delayed(Constant(-0.5 * gain), ConstantDelay(1.7)),
            ),
            remembered=jnp.array([[[1.0, 0.0]]]),
            longest=1.7,
            shortest=0.8,
        )


def dampers() -> Iterator[Problem]:
    for b in (-1.2, 1.6):

        def functions(z: Any, b: float = b) -> Any:
            one, two = b * np.exp(-0.8 * z), 0.5 * b * np.exp(-1.7 * z)
            return z**2 + 0.5 * z + 2.1 - one + two, 2 * z + 0.5 + 0.8 * one - 1.7 * two

        yield closed(f"damper {b}", "remembered", Damper(), 1.0, b, first_of(functions), "constant", 1e-11)


def turned(machine: dict[str, Any], rpm: float) -> Any:
    """Turning with process damping: what is seen is place and velocity."""
    case = {"machine": "one", "rpm": rpm, "depth_m": None, "points": []}
    content = {"milling_mu": [], "milling_critical": [], "machines": {"one": machine}, "turning": [case]}
    return next(iter(process_damping(content))).process


def turning() -> Iterator[Problem]:
    told = frozenset(["constant", "repeats"])
    mode = {"frequency_Hz": 450.0, "damping_ratio": 0.0316, "modal_mass_kg": 0.8106}
    machine = {"modes": [mode], "K_N_per_m2": 1.5e9, "C_N_per_m": 611000.0, "radius_m": 0.0175}
    for case in GENERAL["turning"]:
        name, speed, value = f"turning {case['depth_m']}", case["rpm"] / 60, complex(*case["mu"])
        process = turned(machine, case["rpm"])
        yield Problem(name, "velocity", process, speed, case["depth_m"], value, 1e-10, told, CODES)
    speed, depth, omega = 400.0, 5e-4, 900 * np.pi
    free, force = 2 * 0.0316 * omega / speed, depth * 1.5e9 / 0.8106 / speed**2
    rub = depth * 611000.0 / (0.8106 * 0.0175 * 2 * np.pi * speed) / speed

    def functions(z: Any) -> Any:
        before = force * np.exp(-z)
        return z**2 + (free + rub) * z + (omega / speed) ** 2 + force - before, 2 * z + free + rub + before

    value = first_of(functions)
    yield closed(
        "fast turning", "velocity", turned(machine, 60 * speed), speed, depth, value, "constant repeats", 1e-10
    )


# Several delays, over jumps.


def working(t: Any, speed: Any, gain: Any) -> Any:
    return jnp.where(t >= 0.55, gain, 0.0).reshape(1, 1)


def working_less(t: Any, speed: Any, gain: Any) -> Any:
    return -0.4 * working(t, speed, gain)


ACT_AND_WAIT = lobex.LinearDelay([[0.7]], [(working, 0.3), (working_less, 0.45)], period=1.0, breaks=[0.0, 0.55])
"""ẋ = 0.7 x + g(t) b [x(t − 0.3) − 0.4 x(t − 0.45)], where g = 0 until t = 0.55 of a period of 1 and then 1."""


def acting_and_waiting() -> Iterator[Problem]:
    """Of e^{−0.7 t} x(t), which is 1, then a straight line, from t = 0.85 on a parabola."""
    for b in (-2.5, 1.5):
        one, two = b * np.exp(-0.7 * 0.3), -0.4 * b * np.exp(-0.7 * 0.45)
        value = np.exp(0.7) * (1 + (one + two) * 0.45 + one * (one + two) * 0.15**2 / 2)
        yield closed(f"act and wait {b}", "jumps of several", ACT_AND_WAIT, 1.0, b, value, "jumps", 1e-12)


def since_sample(late, t, speed, gain):
    """A value taken at t = 0 and 0.37 of a period of 1, and held from then on, comes into force by ``late``."""
    return late + jnp.where(t < 0.37, t, t - 0.37)


def sampling() -> Iterator[Problem]:
    """ẋ = a x + b x(t_k − 0.2) between samples t_k at 0 and 0.37 of a period of 1: exact from sample to sample."""
    for a, b in ((1.4, -2.2), (0.4, -1.1)):
        process = lobex.LinearDelay(
            a,
            [(Partial(times, np.eye(1)), Partial(since_sample, 0.2))],
            period=1.0,
            breaks=[0.0, 0.37],
            delay_range=(0.2, 0.83),
        )

        def held(time: float, a: float = a, b: float = b) -> list[float]:
            return [np.exp(a * time), b * np.expm1(a * time) / a]

        # Of x at a sample, and 0.2 before it.
        whole = np.array([held(0.63), held(0.63 - 0.2)]) @ np.array([held(0.37), held(0.37 - 0.2)])
        values = np.linalg.eigvals(whole)
        values = values[np.argsort(-np.abs(values))]
        yield closed(f"sampled {b}", "sampled", process, 1.0, b, values, "jumps", 1e-12)


KT, KN = 6.79e8, 1.73824e8
PLANE = lobex.Modes.plane(
    x=lobex.Modes.single(frequency=563.6, damping_ratio=0.0558, mass=1.4986),
    y=lobex.Modes.single(frequency=516.21, damping_ratio=0.025, mass=1.199),
)
"""Of the cutter "A" of the reference."""


def pitched(degrees: Any, immersion: float = 0.5, direction: str = "down", modes: Any = PLANE) -> Any:
    return lobex.Milling(modes, lobex.Cutter.end_mill(pitch_degrees=degrees), KT, KN, immersion, direction)


def cutters() -> Iterator[Problem]:
    """One delay a tooth: by a method of steps of order eight."""
    for case in GENERAL["variable_pitch"]:
        process = pitched(case["pitch_deg"], case["radial_immersion"])
        pitch = "-".join(map(str, case["pitch_deg"]))
        name = f"pitch {pitch} {case['radial_immersion']} {case['rpm']}"
        told, value = frozenset(["jumps"]), complex(*case["mu"])
        # Of the period until the teeth repeat, its modulus alone.
        if (alike := process.cutter.alike) > 1:
            told, value = told | {"modulus"}, abs(value) ** (1 / alike)
        yield Problem(name, "teeth", process, case["rpm"] / 60, case["depth_m"], value, 1e-9, told, CODES)


def even_pitch() -> Iterator[Problem]:
    """With runout, one delay a tooth: the multiplier of a tooth period taken as often as there are teeth."""
    for case in MULTIPLIER_CASES:
        if "2dof" in case["problem"] and case["radial_immersion"] == 0.5:
            even, speed, depth = point(case)
            forces = even.tangential, even.normal, even.radial_immersion, even.direction
            cutter = lobex.Cutter(even.teeth, runout=np.eye(even.teeth)[0] * 1e-6)
            process = lobex.Milling(even.modes, cutter, *forces)
            value, told = case["spectral_radius"] ** even.teeth, frozenset(["jumps", "modulus"])
            yield Problem(f"even pitch {depth}", "even teeth", process, speed, depth, value, 2e-8, told, CODES)


def closed(
    name: str, kind: str, process: Any, speed: float, gain: float, values: Any, tags: str, tolerance: float
) -> Problem:
    first, *others = np.atleast_1d(values).astype(complex)
    value = complex(first.real, abs(first.imag))
    return Problem(
        name, kind, process, speed, gain, value, tolerance, frozenset(tags.split()), CLOSED, tuple(map(complex, others))
    )


GROUPS = (scalars, of_codes, undamped_mathieu, periodic_scalars, scalars_of_two_periods, own_mathieu)
GROUPS += (speed_variation, first_orders, dampers, turning, acting_and_waiting, sampling, cutters, even_pitch)
PROBLEMS = tuple(problem for group in GROUPS for problem in group())
KINDS = tuple(dict.fromkeys(problem.kind for problem in PROBLEMS))


def of_kind(kind: str) -> list[Problem]:
    return [problem for problem in PROBLEMS if problem.kind == kind]
