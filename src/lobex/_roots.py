"""Roots of many functions at once, each within a bracket."""

from collections.abc import Callable
from typing import Any

from jaxtyping import Bool, Float

from lobex._lockstep import repeated
from lobex._namespace import namespace
from lobex._shapes import AnyArray, Number

# Newton takes about five, Chandrupatla's method about eight, bisection alone the digits of the number format.
_MOST_STEPS = 80

# Functions within others say no shapes: these would be made anew by each call.


def bracketed_root(
    function: Callable[
        [Any, Float[AnyArray, " *lanes"]], tuple[Float[AnyArray, " *lanes"], Float[AnyArray, " *lanes"]]
    ],
    given: Any,
    first: Float[AnyArray, " *lanes"],
    last: Float[AnyArray, " *lanes"],
    rising: bool | Bool[AnyArray, " *lanes"],
    start: Float[AnyArray, " *lanes"],
    tolerance: Number | Float[AnyArray, " *lanes"],
    wanted: bool | Bool[AnyArray, " *lanes"] = True,
) -> Float[AnyArray, " *lanes"]:
    """A zero of a function between ``first`` and ``last``, by Newton steps, bisecting where one leaves the bracket.

    Each lane ends as soon as it has converged, and after 80 steps at the latest. Traced by JAX it is one lane, and
    ``vmap`` has many; in NumPy the lanes are an axis.

    Args:
        function: value and derivative at a place, of what is ``given`` and the place.
        given: a tree of what the function depends on, lane by lane.
        first: one end of the bracket.
        last: the other end, above or below the first.
        rising: whether the function is positive at ``last`` and negative at ``first``, else the other way.
        start: where to start, within the bracket.
        tolerance: how small a value counts as zero.
        wanted: False to do no work and return ``start``.
    """
    lib = namespace(first, last, start)

    def unfinished(_: Any, state: Any) -> Any:
        return state[0] < _MOST_STEPS

    def improve(known: tuple[Any, ...], state: tuple[Any, ...]) -> tuple[Any, ...]:
        given, rising, tolerance = known
        count, first, last, x = state
        value, slope = function(given, x)
        beyond = (value > 0) == rising
        first, last = lib.where(beyond, first, x), lib.where(beyond, x, last)
        newton = x - value / lib.where(slope == 0, lib.inf, slope)
        inside = ((newton - first) * (newton - last) <= 0) & (slope != 0)
        zero = lib.abs(value) <= tolerance
        # At a zero to rounding, Newton's step may leave the bracket by rounding: the middle would be worse.
        new = lib.where(inside, newton, lib.where(zero, x, (first + last) / 2))
        done = zero | (lib.abs(new - x) <= lib.finfo(x.dtype).eps * lib.abs(x))
        return lib.where(done, _MOST_STEPS, count + 1), first, last, new

    begin = lib.where(lib.broadcast_to(wanted, lib.shape(start)), 0, _MOST_STEPS)
    return repeated(improve, unfinished, (given, rising, tolerance), (begin, first, last, start))[3]


def sign_change(
    function: Callable[[Any, Float[AnyArray, " *lanes"]], Float[AnyArray, " *lanes"]],
    given: Any,
    first: Float[AnyArray, " *lanes"],
    last: Float[AnyArray, " *lanes"],
    wanted: bool | Bool[AnyArray, " *lanes"] = True,
) -> Float[AnyArray, " *lanes"]:
    """Where a function whose derivative is not at hand changes sign between ``first`` and ``last``, where it has two.

    Chandrupatla's method (Advances in Engineering Software 28, 1997): inverse quadratic interpolation where that can
    be trusted, else bisection, until rounding of the place or of the interval is left. Lanes and arguments as of
    ``bracketed_root``, with the value alone; without work it returns ``first``.
    """
    lib = namespace(first, last)
    eps = lib.finfo(lib.result_type(first)).eps

    def unfinished(_: Any, state: Any) -> Any:
        return state[0] < _MOST_STEPS

    def improve(known: tuple[Any, ...], state: tuple[Any, ...]) -> tuple[Any, ...]:
        given, least = known
        count, share, near, at_near, far, at_far = state
        x = near + share * (far - near)
        value = function(given, x)
        # The newest place, that beyond the change, and that which is left of the three.
        same = (value > 0) == (at_near > 0)
        old, at_old = lib.where(same, near, far), lib.where(same, at_near, at_far)
        far, at_far = lib.where(same, far, near), lib.where(same, at_far, at_near)
        width = lib.abs(far - x)
        edge = (least + 2 * eps * lib.abs(x)) / lib.where(width == 0, 1.0, width)
        along, up = (x - far) / (old - far), (value - at_far) / (at_old - at_far)
        smooth = (up**2 < along) & ((1 - up) ** 2 < 1 - along)
        turned = value / (value - at_far) * at_old / (at_old - at_far)
        turned = turned - (old - x) / (far - x) * value / (at_old - value) * at_far / (at_far - at_old)
        share = lib.clip(lib.where(smooth, turned, 0.5), edge, 1 - edge)
        done = (edge > 0.5) | (value == 0) | (width == 0)
        return lib.where(done, _MOST_STEPS, count + 1), share, x, value, far, at_far

    begin = lib.where(lib.broadcast_to(wanted, lib.shape(first)), 0, _MOST_STEPS)
    ends = first, function(given, first), last, function(given, last)
    state = begin, lib.full_like(first, 0.5), *ends
    return repeated(improve, unfinished, (given, eps * lib.abs(last - first)), state)[2]
