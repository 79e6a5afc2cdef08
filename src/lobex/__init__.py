"""lobex: stability lobe diagrams of delayed systems, vectorised and differentiable in JAX.

Names load on first use, so that ``import lobex`` and the shell's help do not wait for JAX. Importing changes
no global setting.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lobex._warnings import LobexWarning, SweepWarning
    from lobex.advice.best_cuts import recommend
    from lobex.advice.next_try import next_speed
    from lobex.characteristic.method import CharacteristicRoots
    from lobex.contact.casing import Casing
    from lobex.contact.laws import Bilinear, Cubic, KelvinVoigt, Linear, Plastic, Power, Threshold
    from lobex.explorer.notebook import explore
    from lobex.files import load
    from lobex.grids.choice import Auto
    from lobex.limits.adaptive import limit_curve
    from lobex.limits.boundary_tracing import boundary
    from lobex.limits.exact_limit import exact_limit, exact_lobes
    from lobex.limits.multi_frequency import multi_frequency_limit, zero_order_limit
    from lobex.limits.receptance import Receptance
    from lobex.limits.receptance_matrix import ReceptanceMatrix
    from lobex.limits.sensitivity import sensitivities
    from lobex.marches.delay import march_delay
    from lobex.marches.start import growing_history
    from lobex.marches.turning import simulate_turning
    from lobex.measured.cuts_file import read_cuts
    from lobex.measured.frf import Frf
    from lobex.measured.frf_file import read_frf
    from lobex.measured.modal_fit import ModalFit
    from lobex.measured.modes_file import read_modes
    from lobex.motions.forced_motion import orbit
    from lobex.motions.over_grid import orbits
    from lobex.operators.chebyshev import Chebyshev
    from lobex.operators.duhamel import Duhamel
    from lobex.operators.semi_discretization import SemiDiscretization
    from lobex.plots.campbell import campbell
    from lobex.plots.severity import severity
    from lobex.processes.blade_file import read_blade, read_wear
    from lobex.processes.canonical import DelayedMathieu, Scalar
    from lobex.processes.cutter import Cutter
    from lobex.processes.cutting_force import CuttingForce
    from lobex.processes.linear_delay import LinearDelay
    from lobex.processes.milling import Milling
    from lobex.processes.process_damping import ProcessDamping
    from lobex.processes.regenerative import Rub, Turning
    from lobex.processes.serration import Serration
    from lobex.processes.speed_variation import SpeedVariation
    from lobex.processes.tool_file import read_tool
    from lobex.results.band import Band
    from lobex.results.blading_wear import BladingWear
    from lobex.results.boundary import Boundary
    from lobex.results.chart import Chart
    from lobex.results.comparison import Comparison
    from lobex.results.cut import Cut
    from lobex.results.cutting_orbit import CuttingOrbit
    from lobex.results.growth_rate import GrowthRate
    from lobex.results.limit import Limit
    from lobex.results.march import March
    from lobex.results.next_speeds import NextSpeeds
    from lobex.results.orbit import Orbit
    from lobex.results.orbit_map import CuttingMap, OrbitMap
    from lobex.results.recommendation import Recommendation
    from lobex.results.sensitivities import Sensitivities
    from lobex.results.spectrum_map import SpectrumMap, critical_speeds
    from lobex.results.wear_map import WearMap
    from lobex.structures.beam import Beam
    from lobex.structures.blading import Blading
    from lobex.structures.matrix_market import read_matrix_market
    from lobex.structures.modes import Modes
    from lobex.structures.modes_over_speed import ModesOverSpeed
    from lobex.structures.nastran_dmig import read_dmig
    from lobex.structures.ring import Ring
    from lobex.structures.rod import Rod
    from lobex.structures.rotating_modes import RotatingModes
    from lobex.studies.charts import sweep
    from lobex.studies.limits import critical_gain
    from lobex.studies.study import Study
    from lobex.studies.wear_marches import march_wear
    from lobex.systems.system import DelaySystem
    from lobex.verbs import monodromy, multipliers, spectral_radius

__version__ = "0.1.0"

_HOME = {
    "Auto": "grids.choice",
    "Band": "results.band",
    "Beam": "structures.beam",
    "Bilinear": "contact.laws",
    "Blading": "structures.blading",
    "BladingWear": "results.blading_wear",
    "Boundary": "results.boundary",
    "Casing": "contact.casing",
    "CharacteristicRoots": "characteristic.method",
    "Chart": "results.chart",
    "Chebyshev": "operators.chebyshev",
    "Comparison": "results.comparison",
    "Cubic": "contact.laws",
    "Cut": "results.cut",
    "Cutter": "processes.cutter",
    "CuttingForce": "processes.cutting_force",
    "CuttingMap": "results.orbit_map",
    "CuttingOrbit": "results.cutting_orbit",
    "DelaySystem": "systems.system",
    "DelayedMathieu": "processes.canonical",
    "Duhamel": "operators.duhamel",
    "Frf": "measured.frf",
    "GrowthRate": "results.growth_rate",
    "KelvinVoigt": "contact.laws",
    "Limit": "results.limit",
    "Linear": "contact.laws",
    "LinearDelay": "processes.linear_delay",
    "LobexWarning": "_warnings",
    "March": "results.march",
    "Milling": "processes.milling",
    "ModalFit": "measured.modal_fit",
    "Modes": "structures.modes",
    "ModesOverSpeed": "structures.modes_over_speed",
    "NextSpeeds": "results.next_speeds",
    "Orbit": "results.orbit",
    "OrbitMap": "results.orbit_map",
    "Plastic": "contact.laws",
    "Power": "contact.laws",
    "ProcessDamping": "processes.process_damping",
    "Receptance": "limits.receptance",
    "ReceptanceMatrix": "limits.receptance_matrix",
    "Recommendation": "results.recommendation",
    "Ring": "structures.ring",
    "Rod": "structures.rod",
    "RotatingModes": "structures.rotating_modes",
    "Rub": "processes.regenerative",
    "Scalar": "processes.canonical",
    "SemiDiscretization": "operators.semi_discretization",
    "Sensitivities": "results.sensitivities",
    "SpectrumMap": "results.spectrum_map",
    "Serration": "processes.serration",
    "SpeedVariation": "processes.speed_variation",
    "Study": "studies.study",
    "SweepWarning": "_warnings",
    "Threshold": "contact.laws",
    "Turning": "processes.regenerative",
    "WearMap": "results.wear_map",
    "boundary": "limits.boundary_tracing",
    "campbell": "plots.campbell",
    "critical_gain": "studies.limits",
    "critical_speeds": "results.spectrum_map",
    "exact_limit": "limits.exact_limit",
    "exact_lobes": "limits.exact_limit",
    "explore": "explorer.notebook",
    "growing_history": "marches.start",
    "limit_curve": "limits.adaptive",
    "load": "files",
    "march_delay": "marches.delay",
    "march_wear": "studies.wear_marches",
    "monodromy": "verbs",
    "multi_frequency_limit": "limits.multi_frequency",
    "multipliers": "verbs",
    "next_speed": "advice.next_try",
    "orbit": "motions.forced_motion",
    "read_blade": "processes.blade_file",
    "read_cuts": "measured.cuts_file",
    "read_dmig": "structures.nastran_dmig",
    "read_frf": "measured.frf_file",
    "read_matrix_market": "structures.matrix_market",
    "read_modes": "measured.modes_file",
    "read_tool": "processes.tool_file",
    "read_wear": "processes.blade_file",
    "orbits": "motions.over_grid",
    "recommend": "advice.best_cuts",
    "sensitivities": "limits.sensitivity",
    "severity": "plots.severity",
    "simulate_turning": "marches.turning",
    "spectral_radius": "verbs",
    "sweep": "studies.charts",
    "zero_order_limit": "limits.multi_frequency",
}

__all__ = [
    "Auto",
    "Band",
    "Beam",
    "Bilinear",
    "Blading",
    "BladingWear",
    "Boundary",
    "Casing",
    "CharacteristicRoots",
    "Chart",
    "Chebyshev",
    "Comparison",
    "Cubic",
    "Cut",
    "Cutter",
    "CuttingForce",
    "CuttingMap",
    "CuttingOrbit",
    "DelaySystem",
    "DelayedMathieu",
    "Duhamel",
    "Frf",
    "GrowthRate",
    "KelvinVoigt",
    "Limit",
    "Linear",
    "LinearDelay",
    "LobexWarning",
    "March",
    "Milling",
    "ModalFit",
    "Modes",
    "ModesOverSpeed",
    "NextSpeeds",
    "Orbit",
    "OrbitMap",
    "Plastic",
    "Power",
    "ProcessDamping",
    "Receptance",
    "ReceptanceMatrix",
    "Recommendation",
    "Ring",
    "Rod",
    "RotatingModes",
    "Rub",
    "Scalar",
    "SemiDiscretization",
    "Sensitivities",
    "Serration",
    "SpectrumMap",
    "SpeedVariation",
    "Study",
    "SweepWarning",
    "Threshold",
    "Turning",
    "WearMap",
    "__version__",
    "boundary",
    "campbell",
    "critical_gain",
    "critical_speeds",
    "exact_limit",
    "exact_lobes",
    "explore",
    "growing_history",
    "limit_curve",
    "load",
    "march_delay",
    "march_wear",
    "monodromy",
    "multi_frequency_limit",
    "multipliers",
    "next_speed",
    "orbit",
    "orbits",
    "read_blade",
    "read_cuts",
    "read_dmig",
    "read_frf",
    "read_matrix_market",
    "read_modes",
    "read_tool",
    "read_wear",
    "recommend",
    "sensitivities",
    "severity",
    "simulate_turning",
    "spectral_radius",
    "sweep",
    "zero_order_limit",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'lobex' has no attribute {name!r}")
    value = getattr(import_module(f"lobex.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
