"""Every kind of result by the format of its files."""

import xarray

from lobex.results.blading_wear import BladingWear
from lobex.results.boundary import Boundary
from lobex.results.chart import Chart
from lobex.results.comparison import Comparison
from lobex.results.cut import Cut
from lobex.results.cutting_orbit import CuttingOrbit
from lobex.results.fields import read
from lobex.results.limit import Limit
from lobex.results.march import March
from lobex.results.next_speeds import NextSpeeds
from lobex.results.orbit import Orbit
from lobex.results.orbit_map import CuttingMap, OrbitMap
from lobex.results.recommendation import Recommendation
from lobex.results.result import Result
from lobex.results.sensitivities import Sensitivities
from lobex.results.spectrum_map import SpectrumMap
from lobex.results.stored import Stored
from lobex.results.wear_map import WearMap

_KINDS: tuple[type[Result], ...] = (
    *(Chart, Limit, WearMap, BladingWear, SpectrumMap, Boundary, Sensitivities, March, Cut),
    *(Orbit, CuttingOrbit, OrbitMap, CuttingMap, Recommendation, NextSpeeds, Comparison),
)
_BY_FORM = {kind.form: kind for kind in _KINDS}


def result_of(dataset: xarray.Dataset, source: str, *others: str) -> Result:
    """The result that a file's dataset stands for; ``source`` says in messages where it is from, and what
    ``others`` can be read beside the forms of results.
    """
    form = dataset.attrs.get("format")
    if not isinstance(form, str) or not form.startswith("lobex "):
        raise ValueError(f"{source} is not a lobex result; give a file that a result's save wrote")
    if form not in _BY_FORM:
        known = ", ".join(map(repr, (*_BY_FORM, *others)))
        raise ValueError(f"{source} has format {form!r}, and this version of lobex reads {known}; compute it again")
    return read(_BY_FORM[form], Stored(dataset, source))
