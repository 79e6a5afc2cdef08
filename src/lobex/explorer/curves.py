"""From a state to its limit, in closed form or by a search, and what is predicted while that goes on."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from jaxtyping import Float

from lobex.explorer.recipes import Recipe, process_of, recipe_of
from lobex.explorer.state import BladingNumbers, Mode, RubNumbers, State, TurningNumbers, View
from lobex.grids.choice import AUTO, operator_of
from lobex.limits.critical import critical_gain
from lobex.limits.exact_limit import exact_limit
from lobex.limits.parameters import number_names
from lobex.limits.sensitivity import at_limit
from lobex.results.limit import Limit
from lobex.results.sensitivities import Sensitivities

# A first look is taken at each so-many-th speed, with so few gains.
_EACH, _FEW = 6, 17
# ln K is predicted to change by no more.
_FARTHEST = 1.5


def in_closed_form(state: State) -> bool:
    """Whether the limit of a state has a closed form."""
    numbers = state.numbers
    if isinstance(numbers, BladingNumbers):
        return not numbers.coupling or (numbers.tuned and numbers.even)
    return isinstance(numbers, RubNumbers) or (isinstance(numbers, TurningNumbers) and not numbers.damping_coefficient)


def slopes_in_closed_form(state: State) -> bool:
    """Whether those of its limit are, too: blades that differ have them by the operator."""
    numbers = state.numbers
    alike = not isinstance(numbers, BladingNumbers) or (numbers.tuned and numbers.even)
    return alike and in_closed_form(state)


def speeds_of(view: View) -> Float[np.ndarray, " n"]:
    """Hz."""
    return np.linspace(view.speed_low, view.speed_high, view.speeds)


def limit_of(state: State, response: Any = None) -> Limit:
    """The limit at all speeds of a state, as the script of the state finds it.

    Args:
        state: of which.
        response: the ``lobex.Receptance``, where the structure is measured.
    """
    process, speed = process_of(state, response), speeds_of(state.view)
    if in_closed_form(state):
        return exact_limit(process, speed)
    return critical_gain(process, speed, (state.view.gain_low, state.view.gain_high), scan=state.view.scan)


def first_look(state: State) -> Limit:
    """A limit that is searched for, at fewer speeds and with fewer gains."""
    view = replace(state.view, speeds=max(state.view.speeds // _EACH, 2), scan=min(_FEW, state.view.scan))
    return limit_of(replace(state, view=view))


@dataclass(frozen=True, eq=False)
class Slopes:
    """How the limit of a state moves with its numbers.

    Attributes:
        recipe: of the state.
        table: the sensitivities of its limit, to the recipe's numbers.
    """

    recipe: Recipe
    table: Sensitivities


def slopes_of(state: State, limit: Limit) -> Slopes:
    """Those of a limit that was found of a state; not of a measured structure, whose samples are no numbers."""
    recipe = recipe_of(state)
    method = None if slopes_in_closed_form(state) else operator_of(AUTO)
    # Calls that are alike are equal, so that JAX compiles for the first of them alone.
    return Slopes(recipe, at_limit(limit, recipe.call, recipe.arrays, method))


@dataclass(frozen=True, eq=False)
class Predicted:
    """Where a limit is thought to be: speeds, Hz, and gains, (n,); NaN where there is none."""

    speed: Float[np.ndarray, " n"]
    gain: Float[np.ndarray, " n"]


def predicted(slopes: Slopes, state: State) -> Predicted | None:
    """The limit of a state near another, by the derivatives of that one's; None where the models are not alike.

    What vibrates at a limit keeps its waves between two passes: where the frequency of the mode next to the chatter
    moves, the speed moves as it does.
    """
    recipe, table = recipe_of(state), slopes.table
    limit = table.limit
    if recipe.sizes != slopes.recipe.sizes or not _same_view(state.view, limit):
        return None
    before, after = (_flat(one) for one in (slopes.recipe, recipe))
    names = table.names[:-1]
    gain, speed = np.asarray(limit.gain, float), np.asarray(limit.speed, float)
    with np.errstate(divide="ignore", invalid="ignore"):
        change = np.zeros(len(gain))
        for name in names:
            old, new = before[name], after[name]
            slope = table.derivative[:, table.names.index(name)]
            # Of what keeps its sign, the logarithm is the straighter one.
            step = old * np.log(new / old) if old * new > 0 else new - old
            change += np.nan_to_num(slope * step / gain)
        stretch = _stretch(limit, before, after)
        by_speed = table.derivative[:, table.names.index("speed")] * speed / gain
        change += np.nan_to_num(by_speed * stretch)
    return Predicted(speed * np.exp(stretch), gain * np.exp(np.clip(change, -_FARTHEST, _FARTHEST)))


def _stretch(limit: Limit, before: dict[str, float], after: dict[str, float]) -> Float[np.ndarray, " n"]:
    """By how much the logarithm of each speed moves."""
    rows = [name for name in before if name.startswith(f"{Mode.columns[0]}[")]
    if not rows:
        return np.zeros(len(limit.speed))
    old, new = (np.array([numbers[name] for name in rows]) for numbers in (before, after))
    chatter = np.nan_to_num(np.asarray(limit.chatter_frequency, float), nan=old[0])
    nearest = np.argmin(np.abs(chatter[:, None] - old), axis=1)
    return np.log(new / old)[nearest]


def _flat(recipe: Recipe) -> dict[str, float]:
    """Every number of a recipe by its name."""
    arrays = recipe.arrays
    names = number_names(arrays)
    values = np.concatenate([np.ravel(arrays[name]) for name in sorted(arrays)])
    return dict(zip(names, values.tolist(), strict=True))


def _same_view(view: View, limit: Limit) -> bool:
    same_gains = limit.method["type"] == "DSubdivision" or limit.bounds == (view.gain_low, view.gain_high)
    return same_gains and np.array_equal(limit.speed, speeds_of(view))
