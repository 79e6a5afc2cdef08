"""Every method over the catalogue of problems: values, orders of convergence, and what each refuses in words."""

from dataclasses import replace
from typing import Any, ClassVar

import jax
import numpy as np
import pytest

import lobex
from lobex._pytree import pytree
from lobex.characteristic.method import CharacteristicRoots
from lobex.processes.quantity import PLAIN_GAIN, Quantity
from lobex.systems.delays import Share, WholePeriod
from lobex.systems.mesh import mesh_of
from problems import CODES, KINDS, PROBLEMS, Problem, of_kind
from refusals import refused

# Nodes of Duhamel and of Chebyshev that resolve every problem of a kind.
NODES = {
    "constant": (40, 64),
    "periodic": (24, 48),
    "jumps": (40, 64),
    "whole periods": (24, 28),
    "short delay": (16, 28),
    "long delay": (24, 36),
    "varying delay": (26, 28),
    "first order": (16, 20),
    "remembered": (14, 24),
    "velocity": (40, 64),
    "jumps of several": (12, 12),
    "sampled": (12, 15),
    "teeth": (20, 24),
    "even teeth": (24, 44),
}
ONE = {kind: next(problem for problem in of_kind(kind) if "among" not in problem.tags) for kind in KINDS}
ONE["periodic"] = next(problem for problem in PROBLEMS if problem.name == "delayed-mathieu-2")
ONE["jumps"] = next(problem for problem in PROBLEMS if problem.name.endswith("thesis-3.4-0.5-down-8000-0.003"))
ONE["varying delay"] = of_kind("varying delay")[1]
ONE["velocity"] = of_kind("velocity")[-1]
ONE["teeth"] = of_kind("teeth")[-1]
"""Of each kind one."""


# Kinds of which each program takes long to compile; the search takes them as well.
LONG = ("teeth", "even teeth")
QUICK = ("constant", "periodic", "short delay", "first order")


def with_long(every: Any, long: Any, mark: Any = pytest.mark.search) -> list[Any]:
    """Kinds, problems or the like, of which long ones are left to the search, or are as slow as the mark says."""
    return [pytest.param(one, marks=mark) if one in long else one for one in every]


# Of the thesis' kinds every problem, of any other one; further ones are slow, and of long kinds left to the search.
FIRST = [
    p for p in PROBLEMS if p.kind in ("constant", "periodic", "jumps") or (p is ONE[p.kind] and p.kind not in LONG)
]
FURTHER = [p for p in PROBLEMS if p not in FIRST]
QUICKER = [
    *FIRST,
    *with_long([p for p in FURTHER if p.kind not in LONG or p is ONE[LONG[0]]], FURTHER, pytest.mark.slow),
    *with_long([p for p in FURTHER if p.kind in LONG and p is not ONE[LONG[0]]], FURTHER),
]


def named(part: Any) -> str | None:
    return part.name if isinstance(part, Problem) else None


def radius_error(process: Any, problem: Problem, method: Any) -> float:
    return problem.error(lobex.spectral_radius(process, problem.speed, problem.gain, method))


def fitted_order(steps: Any, errors: Any) -> float:
    """The slope of log error over log step."""
    return float(-np.polyfit(np.log(steps), np.log(errors), 1)[0])


# --- values


def assert_met(problem: Problem, method: Any) -> None:
    found = lobex.multipliers(problem.process, problem.speed, problem.gain, method)
    assert problem.error(found) < problem.tolerance
    for value in problem.others:
        assert np.min(np.abs(found - value)) < problem.tolerance * max(1, abs(found[0]))


@pytest.mark.parametrize("problem", QUICKER, ids=named)
def test_duhamel_meets_every_problem(problem):
    assert_met(problem, lobex.Duhamel(nodes=NODES[problem.kind][0]))


@pytest.mark.parametrize("problem", QUICKER, ids=named)
def test_chebyshev_meets_every_problem(problem):
    assert_met(problem, lobex.Chebyshev(NODES[problem.kind][1]))


@pytest.mark.parametrize("problem", [p for p in PROBLEMS if "constant" in p.tags], ids=named)
def test_roots_meet_every_constant_problem_or_say_why_they_do_not(problem):
    roots = CharacteristicRoots()
    if why := roots.refuses(problem.process, problem.speed):
        # One delay and one contact are served.
        assert problem.kind != "constant"
        assert_refused(problem, roots, "CharacteristicRoots does not serve process = ")
        assert why.startswith("wh")
    else:
        chart = lobex.sweep(problem.process, [problem.speed], [problem.gain], roots)
        assert problem.error(chart.multiplier[0]) < problem.tolerance
        radius = lobex.spectral_radius(problem.process, problem.speed, problem.gain, roots)
        assert radius == pytest.approx(chart.spectral_radius[0, 0], rel=1e-12)


@pytest.mark.parametrize("problem", [p for p in of_kind("constant") if "among" not in p.tags], ids=named)
def test_the_default_meets_constant_problems(problem):
    assert_met_by_default(problem)


# Of the others random ones are met by default in test_general_error.py.
@pytest.mark.parametrize("kind", with_long(KINDS[1:], set(KINDS) - {"periodic"}))
def test_the_default_meets_every_kind_and_its_estimate_is_honest(kind):
    assert_met_by_default(ONE[kind])


def assert_met_by_default(problem: Problem) -> None:
    chart = lobex.sweep(problem.process, [problem.speed], [problem.gain])
    assert chart.error[0, 0] <= 1e-8
    assert problem.error(chart.multiplier[0]) < max(10 * chart.error[0, 0], problem.tolerance)


# --- orders of convergence


@pytree(static=("pieces",))
class Parted:
    """A process over a period of so many more pieces, its delays the same."""

    process: Any
    pieces: int

    gain: ClassVar[Quantity] = PLAIN_GAIN
    speed_unit: ClassVar[str] = "1"

    def system(self, speed, gain):
        system = self.process.system(speed, gain)
        terms = [replace(t, delay=Share(1.0)) if isinstance(t.delay, WholePeriod) else t for t in system.terms]
        return replace(system, terms=tuple(terms), shortest=1 / self.pieces)


# Of Duhamel with three nodes: pieces that are halved, or nearly so.
PIECES = {
    "constant": (1, 2),
    "periodic": (8, 16),
    "jumps": (12, 18),
    "whole periods": (4, 8),
    "short delay": (16, 32),
    "long delay": (4, 8),
    "varying delay": (4, 8),
    "first order": (4, 8),
    "remembered": (2, 6),
    "velocity": (8, 16),
    "jumps of several": (4, 28),
    "teeth": (37, 73),
}


# That nodes are few is said.
@pytest.mark.filterwarnings("ignore::lobex.SweepWarning")
@pytest.mark.parametrize(
    "kind",
    [
        *with_long(QUICK, QUICK, pytest.mark.slow),
        *with_long([k for k in PIECES if k not in QUICK], PIECES),
    ],
)
def test_duhamel_is_of_twice_the_order_of_its_nodes(kind):
    problem = ONE[kind]
    pieces, errors = [], []
    for few in PIECES[kind]:
        process = Parted(problem.process, few)
        pieces.append(mesh_of(process.system(problem.speed, problem.gain)).pieces)
        errors.append(radius_error(process, problem, lobex.Duhamel(nodes=3)))
    assert fitted_order(pieces, errors) > 5.5


# Of Chebyshev, where a third of the nodes would be good to rounding already.
FEW = {"constant": 4, "jumps": 6, "velocity": 12, "remembered": 6}


@pytest.mark.parametrize("kind", with_long(KINDS, set(KINDS) - set(QUICK)))
def test_chebyshev_converges_geometrically(kind):
    problem, nodes = ONE[kind], NODES[kind][1]
    few, more = (
        problem.error(lobex.multipliers(problem.process, problem.speed, problem.gain, lobex.Chebyshev(count)))
        for count in (FEW.get(kind, nodes // 3), nodes)
    )
    assert few > 1e3 * problem.tolerance
    assert more < max(few**3, problem.tolerance)


# Of semi-discretization the order of its polynomials, and steps. Where a sample falls within a delay moves a constant,
# so that it is kept nearly the same; of the golden section by Fibonacci's numbers. A delay rounded to whole steps would
# leave the first order.
STEPS = [
    ("mathieu T=2tau 3 2", 1, (40, 80)),
    ("mathieu T=tau/2 3 2", 2, (40, 80)),
    pytest.param("mathieu golden 3 2", 0, (34, 89), marks=pytest.mark.slow),
    ("mathieu tau=2.5T 3 2", 1, (40, 80)),
    pytest.param("spindle instantaneous 6000", 0, (80, 160), marks=pytest.mark.slow),
    pytest.param("spindle instantaneous 6000", 1, (80, 160), marks=pytest.mark.search),
    ("damper 1.6", 1, (20, 40)),
    ("fast turning", 1, (40, 80)),
    pytest.param("two periods 0.8", 1, (40, 80), marks=pytest.mark.search),
    pytest.param("hayes over 0.7 delays 2.0", 0, (35, 70), marks=pytest.mark.search),
    pytest.param("pitch 82-88-92-98 0.5 12000", 1, (180, 360), marks=pytest.mark.search),
]
NAMED = {problem.name: problem for problem in reversed(PROBLEMS)} | {"whole periods": ONE["whole periods"]}


@pytest.mark.parametrize(("name", "order", "steps"), STEPS, ids=lambda part: part if isinstance(part, str) else None)
def test_semi_discretization_is_of_second_order(name, order, steps):
    problem = NAMED[name]
    errors = [radius_error(problem.process, problem, lobex.SemiDiscretization(k, order)) for k in steps]
    assert fitted_order(steps, errors) == pytest.approx(2, abs=0.2 if "spindle" not in name else 0.3)


@pytest.mark.parametrize("order", with_long([0, 1, 2], [0, 2], pytest.mark.slow))
def test_semi_discretization_is_of_second_order_over_jumps_with_several_delays(order):
    # Each jump and delay is a whole number of steps, or not: the error stays below the same constant over k².
    problem = NAMED["act and wait 1.5"]
    assert max(k**2 * radius_error(problem.process, problem, lobex.SemiDiscretization(k, order)) for k in (40, 83)) < 2


SMOOTH = [p for p in PROBLEMS if p.name.startswith(("rod-rub", "delayed-mathieu"))]
RODS = [p for p in SMOOTH if p.kind == "constant"]
ONE_WAY = [p for p in PROBLEMS if p.name.startswith("milling-1dof")]
SHALLOW = next(p for p in ONE_WAY if "-0.05-down" in p.name)


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("problem", SMOOTH, ids=named)
def test_semi_discretization_is_of_second_order_on_smooth_coefficients(problem, order):
    steps = (160, 320)
    errors = [radius_error(problem.process, problem, lobex.SemiDiscretization(k, order)) for k in steps]
    assert fitted_order(steps, errors) == pytest.approx(2, abs=0.15)


@pytest.mark.parametrize("problem", RODS[:4], ids=named)
def test_semi_discretization_of_order_two_gains_an_order_on_constant_coefficients(problem):
    steps = (160, 320)
    errors = [radius_error(problem.process, problem, lobex.SemiDiscretization(k, 2)) for k in steps]
    assert fitted_order(steps, errors) > 2.5


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("problem", ONE_WAY, ids=named)
def test_semi_discretization_is_of_second_order_over_the_jumps_of_milling(problem, order):
    # Averaged coefficients keep the order; where the jump falls within a step moves the constant a little. Of the
    # shallowest cut the two leading error terms nearly cancel, and the order shows at finer steps.
    steps = (320, 450, 640) if problem is SHALLOW else (80, 104, 142)
    errors = [radius_error(problem.process, problem, lobex.SemiDiscretization(k, order)) for k in steps]
    assert fitted_order(steps, errors) == pytest.approx(2, abs=0.15)


# --- marches


def growth_error(problem: Problem, periods: int, steps: int, every: int) -> float:
    march = lobex.march_delay(problem.process, problem.speed, problem.gain, lambda t: 1e-6, periods, steps, every=every)
    return problem.error(float(march.growth))


@pytest.mark.parametrize("problem", [p for p in PROBLEMS if p.source == CODES and "repeats" in p.tags], ids=named)
def test_marches_grow_as_the_codes_say(problem):
    assert growth_error(problem, 40, 3000, 10) < 1e-4


# Steps, and what the error is below with the fewer.
MARCHES = {
    "two periods 0.8": (20, 3e-3),
    "mathieu T=tau/2 3 2": (100, 0.1),
    "spindle instantaneous 6000": (100, 1e-2),
    "hayes over 0.7 delays 2.0": (20, 3e-3),
    "damper 1.6": (20, 1e-2),
    "fast turning": (40, 0.1),
    "act and wait 1.5": (40, 3e-3),
    "pitch 82-88-92-98 0.5 12000": (90, 0.1),
}


SLOWLY = ["act and wait 1.5", "spindle instantaneous 6000", "damper 1.6"]
SEARCHED = [name for name in MARCHES if name not in SLOWLY]


@pytest.mark.parametrize("name", [*with_long(SLOWLY, SLOWLY, pytest.mark.slow), *with_long(SEARCHED, SEARCHED)])
def test_marches_are_of_second_order(name):
    steps, bound = MARCHES[name]
    errors = [growth_error(NAMED[name], 24, count, 1) for count in (steps, 4 * steps)]
    assert errors[0] < bound
    # Or it is that of the fit.
    assert errors[1] < max(errors[0] / 10, 1e-6)


# --- refusals


def assert_refused(problem: Problem, method: Any, words: str) -> None:
    for verb in (lobex.sweep, lobex.spectral_radius):
        with refused(words):
            verb(problem.process, [problem.speed], [problem.gain], method)


@pytest.mark.parametrize("kind", ["whole periods", "short delay", "jumps of several", "remembered", "teeth"])
def test_other_delays_than_the_period_refuse_whole_states_and_single_intervals(kind):
    assert_refused(ONE[kind], lobex.Chebyshev(aligned=False), "aligned = False takes systems whose only delay is the p")
    for method in (lobex.Chebyshev(full=True), lobex.SemiDiscretization(full=True)):
        assert_refused(ONE[kind], method, "full = True takes systems")


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "constant" not in ONE[kind].tags])
def test_roots_refuse_what_follows_the_time(kind):
    words = "whose delay varies" if kind in ("varying delay", "sampled") else "has periodic coefficients"
    assert_refused(ONE[kind], CharacteristicRoots(), words)


def test_what_needs_an_operator_refuses_roots():
    problem = ONE["constant"]
    point = problem.process, problem.speed, problem.gain, CharacteristicRoots()
    for verb in (
        lobex.monodromy,
        lobex.multipliers,
        lambda process, speed, gain, method: jax.grad(lambda k: lobex.spectral_radius(process, speed, k, method))(gain),
    ):
        with refused("method = CharacteristicRoots() makes no operator"):
            verb(*point)
