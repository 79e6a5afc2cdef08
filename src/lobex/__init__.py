"""lobex: stability lobe diagrams of delayed systems, vectorised and differentiable in JAX.

Names load on first use, so that ``import lobex`` and the shell's help do not wait for JAX. Importing changes
no global setting.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lobex.grids.sweep import SweepWarning, sweep
    from lobex.limits.critical import critical_gain
    from lobex.limits.exact_limit import exact_limit, exact_lobes
    from lobex.limits.receptance import Receptance
    from lobex.operators.chebyshev import Chebyshev
    from lobex.operators.semi_discretization import SemiDiscretization
    from lobex.processes.canonical import DelayedMathieu, Scalar
    from lobex.processes.milling import Milling
    from lobex.processes.regenerative import Rub, Turning
    from lobex.processes.system import DelaySystem
    from lobex.results.chart import Chart
    from lobex.results.limit import Limit
    from lobex.results.netcdf import load
    from lobex.structures.modes import Modes
    from lobex.structures.rod import Rod
    from lobex.verbs import monodromy, multipliers, spectral_radius

__version__ = "0.1.0"

_HOME = {
    "Chart": "results.chart",
    "Chebyshev": "operators.chebyshev",
    "DelaySystem": "processes.system",
    "DelayedMathieu": "processes.canonical",
    "Limit": "results.limit",
    "Milling": "processes.milling",
    "Modes": "structures.modes",
    "Receptance": "limits.receptance",
    "Rod": "structures.rod",
    "Rub": "processes.regenerative",
    "Scalar": "processes.canonical",
    "SemiDiscretization": "operators.semi_discretization",
    "SweepWarning": "grids.sweep",
    "Turning": "processes.regenerative",
    "critical_gain": "limits.critical",
    "exact_limit": "limits.exact_limit",
    "exact_lobes": "limits.exact_limit",
    "load": "results.netcdf",
    "monodromy": "verbs",
    "multipliers": "verbs",
    "spectral_radius": "verbs",
    "sweep": "grids.sweep",
}

__all__ = [
    "Chart",
    "Chebyshev",
    "DelaySystem",
    "DelayedMathieu",
    "Limit",
    "Milling",
    "Modes",
    "Receptance",
    "Rod",
    "Rub",
    "Scalar",
    "SemiDiscretization",
    "SweepWarning",
    "Turning",
    "__version__",
    "critical_gain",
    "exact_limit",
    "exact_lobes",
    "load",
    "monodromy",
    "multipliers",
    "spectral_radius",
    "sweep",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'lobex' has no attribute {name!r}")
    value = getattr(import_module(f"lobex.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
