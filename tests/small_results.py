"""A small result of every kind, of made-up numbers: what files and pictures do is the same for all of them."""

from dataclasses import fields
from typing import Any

import numpy as np

import lobex
from lobex.processes.quantity import CONTACT_STIFFNESS, DEPTH_OF_CUT
from lobex.results.boundary import BoundaryCurve
from lobex.results.codes import Kind, Status
from lobex.results.description import describe
from lobex.studies.assembly import assembled
from lobex.studies.plan import Plan

MODES = lobex.Modes.single(frequency=146.5, damping_ratio=0.03, mass=2.573)
SPEED, GAIN = np.array([50.0, 60.0, 70.0]), np.array([1e5, 2e5])
_TIME = {"seconds": 6.17, "compiling": 5.77}
_SAID = {"quantity": CONTACT_STIFFNESS, "speed_unit": "Hz", "process": describe(lobex.Rub(MODES)), **_TIME}
_METHOD = describe(lobex.Duhamel())


def chart(factor: float = 1.0) -> lobex.Chart:
    """Three speeds by two gains, with one point that failed."""
    multiplier = factor * np.exp(1j * np.arange(6.0).reshape(3, 2)) * np.linspace(0.8, 1.2, 6).reshape(3, 2)
    multiplier[2, 1] = np.nan
    radius = np.abs(multiplier)
    status = np.array([[0, 0], [1, 2], [0, 3]], dtype=np.int8)
    return lobex.Chart(SPEED, GAIN, radius, multiplier, 100 * radius, 1e-9 * radius, status, method=_METHOD, **_SAID)


def limit() -> lobex.Limit:
    """Three speeds: a limit that comes back, none, and a tie."""
    return lobex.Limit(
        speed=SPEED,
        gain=np.array([1.5e5, np.nan, 1.2e5]),
        chatter_frequency=np.array([150.0, np.nan, 160.0]),
        kind_code=np.array([Kind.HOPF, Kind.NONE, Kind.FLIP], dtype=np.int8),
        status_code=np.array([Status.FOUND, Status.NONE_IN_RANGE, Status.TIE], dtype=np.int8),
        intervals=np.array([[[1e5, 1.5e5], [1.8e5, 2e5]], [[1e5, 2e5], [np.nan] * 2], [[1e5, 1.2e5], [np.nan] * 2]]),
        mode=np.array([2, 0, 1]),
        nodal_diameter=np.array([-1, -1, 3]),
        error=np.array([1e-3, np.nan, 2e-3]),
        bounds=(1e5, 2e5),
        method=_METHOD,
        **_SAID,
    )


def sensitivities() -> lobex.Sensitivities:
    """Of two numbers."""
    value = np.column_stack([np.full(3, 0.03), SPEED])
    return lobex.Sensitivities(("modes.damping_ratio[0]", "speed"), value, 1e5 * value, limit())


def boundary() -> lobex.Boundary:
    """A line and a closed curve."""

    def curve(points: int, closed: bool) -> BoundaryCurve:
        return BoundaryCurve(
            np.linspace(50, 70, points),
            np.linspace(1e5, 2e5, points),
            np.full(points, 150.0),
            np.full(points, Kind.HOPF, dtype=np.int8),
            closed,
        )

    return lobex.Boundary(
        (curve(4, False), curve(3, True)), 1e-9, 0, 1, 0.1, 146.5, (50.0, 70.0, 1e5, 2e5), method=_METHOD, **_SAID
    )


def march() -> lobex.March:
    """Two lanes of two outputs, three samples each."""
    samples = np.arange(12.0).reshape(2, 3, 2) * 1e-6
    return lobex.March(
        speed=SPEED[:2],
        gain=GAIN,
        delay=1 / SPEED[:2],
        phase=np.array([0.0, 0.5, 1.0]),
        displacement=samples,
        state=np.arange(4.0).reshape(2, 2),
        multiplier=np.array([0.9 + 0.1j, 1.1 - 0.2j]),
        growth_error=np.array([1e-6, 1e-7]),
        steps_per_period=2,
        **_SAID,
    )


def orbit() -> lobex.Orbit:
    """Two lanes of two outputs, three samples each; one is unstable."""
    samples = np.arange(12.0).reshape(2, 3, 2) * 1e-6
    samples[1] = np.nan
    return lobex.Orbit(
        speed=SPEED[:2],
        gain=GAIN,
        period=1 / SPEED[:2],
        phase=np.array([0.0, 0.5, 1.0]),
        displacement=samples,
        lowest=samples[:, 0],
        highest=samples[:, 2],
        spectral_radius=np.array([0.9, 1.1]),
        error=np.array([1e-9, np.nan]),
        status_code=np.array([0, 2], dtype=np.int8),
        method=_METHOD,
        **_SAID,
    )


def cutting_orbit() -> lobex.CuttingOrbit:
    """The same of two teeth at three heights."""
    known = {f.name: getattr(orbit(), f.name) for f in fields(lobex.Orbit)}
    return lobex.CuttingOrbit(
        **known,
        height=np.array([0.0, 0.5, 1.0]),
        force=1e7 * known["displacement"],
        torque=1e5 * known["displacement"][..., 0],
        highest_torque=np.array([0.4, np.nan]),
        mean_torque=np.array([0.2, np.nan]),
        chip_thickness=np.abs(known["displacement"]),
        pulled=np.array([[0.0, 0.1], [np.nan, np.nan]]),
        surface_location_error=1e-6 * np.arange(12.0).reshape(2, 2, 3),
    )


def orbit_map() -> lobex.OrbitMap:
    """Three speeds by two gains of two outputs, one of them unstable."""
    peak = np.arange(12.0).reshape(3, 2, 2) * 1e-6
    peak[2, 1] = np.nan
    radius = np.linspace(0.5, 1.1, 6).reshape(3, 2)
    status = np.array([[0, 0], [0, 4], [1, 2]], dtype=np.int8)
    return lobex.OrbitMap(
        speed=SPEED,
        gain=GAIN,
        peak=peak,
        spectral_radius=radius,
        error=1e-3 * peak[..., 0],
        status_code=status,
        method=_METHOD,
        **_SAID,
    )


def cutting_map() -> lobex.CuttingMap:
    """The same of a cutter."""
    known = {f.name: getattr(orbit_map(), f.name) for f in fields(lobex.OrbitMap)}
    names = ("location_error", "mean_power", "highest_torque", "pulled")
    return lobex.CuttingMap(**known, **dict.fromkeys(names, known["peak"][..., 1]))


def recommendation() -> lobex.Recommendation:
    """Two cuts of four speeds."""
    two = np.array([2.0, 1.0])
    return lobex.Recommendation(
        speed=50 * two,
        depth=1e-3 * two,
        removal_rate=1e-6 * two,
        stability_margin=np.array([0.1, np.nan]),
        mean_power=100 * two,
        highest_torque=two,
        location_error=-1e-6 * two,
        binding_code=np.array([0, 3], dtype=np.int8),
        status_code=np.array([0, 4], dtype=np.int8),
        scanned_speed=np.arange(4.0) + 50,
        scanned_depth=np.array([1e-3, 2e-3, np.nan, 1e-3]),
        scanned_binding_code=np.array([0, 1, 2, 4], dtype=np.int8),
        power=300.0,
        torque=np.inf,
        location_error_limit=1e-5,
        margin=0.1,
        **_SAID,
    )


def next_speeds() -> lobex.NextSpeeds:
    """Two speeds, one of them without a limit."""
    return lobex.NextSpeeds(
        lobe=np.array([2.0, 1.0]),
        speed=np.array([50.0, 100.0]),
        limit=np.array([np.nan, 1e-3]),
        status_code=np.array([1, 0], dtype=np.int8),
        chatter_frequency=200.0,
        teeth=2,
        quantity=DEPTH_OF_CUT,
        speed_unit="rpm",
    )


def comparison() -> lobex.Comparison:
    """Two cuts over the chart."""
    return chart().compare([(55.0, 1.5e5, 1), (51.0, 1.2e5, 0)])


def cut() -> lobex.Cut:
    """Two lanes of three samples."""
    samples = np.arange(6.0).reshape(2, 3) * 1e-6
    said = {"modes": describe(MODES), "law": describe(lobex.Linear(2e8))}
    return lobex.Cut(
        speed=SPEED[:2],
        depth=np.array([1e-3, 2e-3]),
        feed=1e-4,
        phase=np.array([0.0, 0.5, 1.0]),
        displacement=samples,
        chip_thickness=samples + 1e-4,
        force=1e6 * samples,
        state=np.arange(4.0).reshape(2, 2),
        steps_per_revolution=2,
        **said,
        **_TIME,
    )


_CASING = {
    "samples_per_revolution": 4,
    "lag": 0,
    "usable_orders": 1,
    "natural_frequency": np.array([146.5]),
    "nodal_diameters": 2,
    "radius": 0.5,
    "axial_width": 0.02,
    "failed": 0,
    **_TIME,
}


def wear_map() -> lobex.WearMap:
    """Two lanes of three revolutions over four cells."""
    turns = np.arange(1.0, 7.0).reshape(2, 3)
    said = {"modes": describe(MODES), "casing": describe(lobex.Casing()), "law": describe(lobex.Linear(4.5e6))}
    energies = dict.fromkeys(("input_energy", "removal_energy", "damping_energy", "stored_energy"), turns)
    energies |= dict.fromkeys(("friction_energy", "speeding_energy"), turns / 8)
    return lobex.WearMap(
        speed=SPEED[:2],
        speed_history=np.repeat(SPEED[:2, None], 3, axis=1),
        angle=np.arange(4) * np.pi / 2,
        unworn=np.full(4, 1e-4),
        depth=np.arange(8.0).reshape(2, 4) * 1e-6,
        wear=1e-8 * turns,
        displacement=np.arange(24.0).reshape(2, 12) * 1e-6,
        amplitude=1e-5 * turns,
        casing_amplitude=1e-6 * turns,
        contact=turns / 10,
        force=100 * turns,
        watched=np.arange(24.0).reshape(2, 1, 12),
        watched_amplitude=turns[:, None],
        **energies,
        **_CASING,
        model=said,
    )


def blading_wear() -> lobex.BladingWear:
    """Two lanes of three revolutions over four cells: two blades with two contacts each in tracks of their own."""
    turns = np.arange(1.0, 7.0).reshape(2, 3)
    touching, bladed = (np.repeat(turns[:, None], count, axis=1) for count in (4, 2))
    said = {"modes": describe(MODES), "casing": describe(lobex.Casing()), "law": describe(lobex.Linear(4.5e6))}
    return lobex.BladingWear(
        speed=SPEED[:2],
        speed_history=np.repeat(SPEED[:2, None], 3, axis=1),
        angle=np.arange(4) * np.pi / 2,
        blade=np.array([0, 0, 1, 1]),
        track=np.array([0, 1, 0, 1]),
        place=np.array([0.0, 0.0, 3.0, 3.0]),
        unworn=np.full((2, 4), 1e-4),
        depth=np.arange(16.0).reshape(2, 2, 4) * 1e-6,
        wear=1e-8 * bladed,
        displacement=np.arange(96.0).reshape(2, 4, 12) * 1e-6,
        amplitude=1e-5 * touching,
        casing_amplitude=1e-6 * touching,
        contact=touching / 10,
        force=100 * touching,
        **dict.fromkeys(("input_energy", "removal_energy", "friction_energy"), touching),
        **dict.fromkeys(("damping_energy", "stored_energy", "speeding_energy"), bladed),
        **dict.fromkeys(("casing_damping_energy", "casing_stored_energy", "casing_speeding_energy"), turns),
        watched=np.arange(48.0).reshape(2, 2, 1, 12),
        watched_amplitude=bladed[:, :, None],
        **_CASING,
        model=said,
    )


def spectrum() -> lobex.SpectrumMap:
    """Three speeds by four orders."""
    amplitude = np.arange(12.0).reshape(3, 4) * 1e-6
    return lobex.SpectrumMap(SPEED, np.arange(4) / 2, amplitude, np.array([146.5, 800.0]), 2, "flattop")


def study() -> lobex.Study:
    """Two charts along an axis."""
    plan = Plan({"modes.damping_ratio": np.array([0.01, 0.02])}, 3, 3)
    return lobex.Study(assembled("sweep", plan, SPEED, lambda number: chart(1 + number).to_xarray()).load())


def study_of_limits() -> lobex.Study:
    """Two limits along an axis."""
    plan = Plan({"tool": np.array([1.0, 2.0])}, 3, 3)
    return lobex.Study(assembled("critical_gain", plan, SPEED, lambda number: limit().to_xarray()).load())


def study_of_wear() -> lobex.Study:
    """Two wear maps along an axis."""
    plan = Plan({"casing.amplitude": np.array([1e-4, 2e-4])}, 2, 2)
    return lobex.Study(assembled("march_wear", plan, SPEED[:2], lambda number: wear_map().to_xarray()).load())


RESULTS: dict[str, Any] = {
    "chart": chart,
    "limit": limit,
    "sensitivities": sensitivities,
    "boundary": boundary,
    "march": march,
    "cut": cut,
    "orbit": orbit,
    "cutting orbit": cutting_orbit,
    "orbit map": orbit_map,
    "cutting map": cutting_map,
    "recommendation": recommendation,
    "next speeds": next_speeds,
    "comparison": comparison,
    "wear map": wear_map,
    "blading wear": blading_wear,
    "spectrum": spectrum,
    "study": study,
    "study of limits": study_of_limits,
    "study of wear": study_of_wear,
}

DEPTH = DEPTH_OF_CUT
