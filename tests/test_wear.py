"""The wear march against the thesis' own scheme, an independent integrator, its invariants and its findings."""

import jax
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks

import lobex
from cases import assert_same_fields
from lobex.shell.arguments import Output
from lobex.shell.wear_arguments import BladeFlags, ContactFlags, Wear, WearFlags
from lobex.shell.wear_command import run_wear
from refusals import refused

ROD = lobex.Rod(3).modes(0.03)
BLADE = lobex.Rod(10).modes(0.03)
RUB = lobex.Linear(4.5e6)
NEVER_WEARS = lobex.Plastic(stiffness=2e6, yield_force=1e30)
STEPS = 320
SPEEDS = np.array([62.0, 92.0, 140.0, 186.0])


def march(casing=None, law=RUB, speed=SPEEDS, revolutions=3, steps=STEPS, **options):
    """A short march of three modes: all of them share one compiled program per law and shape."""
    return lobex.march_wear(ROD, casing or lobex.Casing(), law, speed, revolutions, steps, **options)


def permanent(steps):
    """A casing that presses on the tip all the way round."""
    return lobex.Casing(surface=-1e-4 * (2 + np.cos(4 * np.pi * np.arange(steps) / steps)))


def test_the_thesis_own_scheme_gives_the_same_march():
    """(1.17) with full matrices and a loop, written out from §1.4 and design point 2."""
    mass, stiffness, damping = lobex.Rod(3).matrices(0.03)
    unworn = lobex.Casing().profile(STEPS)
    result = march()
    for lane, speed in enumerate(SPEEDS):
        dt = 1 / (speed * STEPS)
        inverse = np.linalg.inv(mass / dt**2 + damping / (2 * dt))
        before, now = np.zeros(3), np.zeros(3)
        surface, tips, touches = unworn.copy(), [], 0
        for i in range(3 * STEPS):
            cell = i % STEPS
            tips.append(now[-1])
            h = now[-1] - surface[cell]
            force = np.array([0, 0, -4.5e6 * h if h > 0 else 0.0])
            after = inverse @ (
                force + (2 * mass / dt**2 - stiffness) @ now + (damping / (2 * dt) - mass / dt**2) @ before
            )
            if h > 0:
                touches += 1
                surface[cell] = max(surface[cell], after[-1])
            before, now = now, after
        assert result.displacement[lane] == pytest.approx(tips, rel=1e-9, abs=1e-15)
        assert result.profile[lane] == pytest.approx(surface, rel=1e-9, abs=1e-15)
        assert 1 - result.separation[lane] == pytest.approx(touches / (3 * STEPS), rel=1e-12)
        assert np.abs(tips[1:]).max() <= result.peak[lane] * (1 + 1e-9)


def _integrated(history, stiffness, at):
    """Tip, stored energy and damping loss of ROD in permanent contact, by scipy at the times ``at`` of a revolution."""
    omega, ratio, shape = (np.asarray(v) for v in (ROD.angular_frequency, ROD.damping_ratio, ROD.shape[:, 0]))
    state, tips = np.zeros(7), []
    for speed in history:

        def rate(t, z, speed=speed):
            u, v = z[:3], z[3:6]
            force = stiffness * (shape @ u + 1e-4 * (2 + np.cos(4 * np.pi * speed * t)))
            lost = 2 * ratio * omega * v
            return np.r_[v, -lost - omega**2 * u - shape * force, lost @ v]

        done = solve_ivp(rate, (0, 1 / speed), state, "DOP853", np.r_[at, 1] / speed, rtol=1e-10, atol=1e-16)
        tips.append(shape @ done.y[:3, :-1])
        state = done.y[:, -1]
    stored = (state[3:6] @ state[3:6] + (omega * state[:3]) @ (omega * state[:3])) / 2
    return np.concatenate(tips), stored, state[6]


def test_contact_without_wear_converges_to_an_independent_integrator_with_order_two():
    history = np.array([[60.0] * 3, [60.0, 75.0, 70.0]])
    resolutions = np.array([512, 1024])
    at = np.arange(64) / 64
    exact = [_integrated(row, 2e6, at) for row in history]
    errors = []
    for steps in resolutions:
        result = march(permanent(steps), NEVER_WEARS, history, 3, int(steps), samples_per_revolution=1024)
        assert np.all(result.contact == 1)
        assert np.all(result.depth == 0)
        tips = result.displacement[:, :: steps // 64]
        rows = []
        for lane, (tip, stored, damping) in enumerate(exact):
            net = np.sum(result.input_energy - result.removal_energy, axis=1)[lane]
            rows.append(
                [
                    np.max(np.abs(tips[lane] - tip)) / np.max(np.abs(tip)),
                    abs(result.stored_energy[lane, -1] / stored - 1),
                    abs(np.sum(result.damping_energy[lane]) / damping - 1),
                    abs(net / (stored + damping) - 1),
                    abs(result.energy_error[lane]),
                ]
            )
        errors.append(rows)
    orders = np.polyfit(np.log(1 / resolutions), np.log(errors).reshape(2, -1), 1)[0]
    assert orders == pytest.approx(np.full(10, 2.0), abs=0.1)
    assert np.max(errors[-1]) < 3e-3


def test_the_energy_balance_closes_with_the_square_of_the_step():
    """In the thesis' set-up, where contact comes and goes and wears; root mean square over the speeds."""
    speeds, steps = np.linspace(40, 600, 15), np.array([1024, 2048, 4096])
    errors = []
    for count in steps:
        result = lobex.march_wear(BLADE, lobex.Casing(), RUB, speeds, 4, int(count))
        for part in (result.input_energy, result.removal_energy, result.damping_energy, result.stored_energy):
            assert np.all(part >= 0)
            assert np.all(np.sum(part, axis=1) > 0)
        # A march that has not died out, so that there is something to balance.
        assert np.median(result.stored_energy[:, -1] / np.sum(result.input_energy, axis=1)) > 1e-3
        errors.append(np.sqrt(np.mean(result.energy_error**2)))
    assert np.polyfit(np.log(1 / steps), np.log(errors), 1)[0] == pytest.approx(2, abs=0.1)
    assert errors[-1] < 1e-6
    whole = lobex.march_wear(BLADE, lobex.Casing(), RUB, speeds, 20, 4096)
    assert np.max(np.abs(whole.energy_error)) < 1e-7


@pytest.mark.parametrize(
    "law",
    [
        RUB,
        lobex.Cubic(width=1.0, first=4e6, second=0.0, third=1e14),
        lobex.Threshold(width=1.0, offset=20.0, slope=4e6),
        lobex.Power(width=1.0, coefficient=4e7, exponent=1.2),
        lobex.Plastic(stiffness=4.5e6, yield_force=50.0, hardening=1e6),
    ],
    ids=lambda law: type(law).__name__,
)
def test_material_only_goes(law):
    short, long = march(law=law, revolutions=2), march(law=law, revolutions=3)
    assert np.all(short.depth >= 0)
    assert np.all(long.depth >= short.depth)
    assert np.any(long.depth > short.depth)
    assert long.wear[:, :2] == pytest.approx(short.wear, rel=1e-12)
    cell = 2 * np.pi * 0.5 / STEPS
    assert np.sum(long.wear, axis=1) == pytest.approx(cell * np.sum(long.depth, axis=1), rel=1e-12)
    assert long.volume == pytest.approx(np.sum(long.wear, axis=1), rel=1e-14)
    assert np.all((long.contact > 0) & (long.contact < 1))
    assert np.max(np.abs(long.energy_error)) < 0.02


@pytest.mark.parametrize("law", [lobex.Plastic(4.5e6, 1e30), lobex.Plastic(4.5e6, 400.0)], ids=["never", "barely"])
def test_plastic_removes_nothing_below_its_yield_force(law):
    result = march(law=law)
    assert np.all(result.contact > 0)
    # The bumps press the tip with 450 N at most if it did not give way at all.
    assert np.all(result.depth == 0)


def test_a_tip_that_reaches_nothing_stays_at_rest():
    result = march(lobex.Casing(clearance=2e-4))
    assert np.all(result.displacement == 0)
    assert np.all(result.depth == 0)
    assert np.all(result.separation == 1)
    assert np.all(result.energy_error == 0)


def test_one_lane_is_that_lane_of_a_batch():
    batch = march()
    for lane in (0, 3):
        alone = march(speed=SPEEDS[lane : lane + 1])
        for name in ("depth", "displacement", "amplitude", "wear", "input_energy", "stored_energy"):
            both = getattr(alone, name)[0], getattr(batch, name)[lane]
            assert both[0] == pytest.approx(both[1], rel=1e-9, abs=1e-16), name


def test_many_lanes_in_blocks_are_the_same_lanes():
    speeds = np.linspace(60, 200, 401)
    batch = march(speed=speeds, revolutions=2)
    some = march(speed=speeds[[0, 133, 266, 400]], revolutions=2)
    assert batch.depth[[0, 133, 266, 400]] == pytest.approx(some.depth, rel=1e-9, abs=1e-16)
    assert batch.displacement[[0, 133, 266, 400]] == pytest.approx(some.displacement, rel=1e-9, abs=1e-16)


@settings(max_examples=10)
@given(st.integers(0, 12))
def test_a_casing_turned_by_whole_cells_is_worn_turned(cells):
    """One bump within the first half: the blade is still at rest before it, turned or not."""
    place = np.arange(STEPS)
    bump = -1e-4 * np.where((place > 20) & (place < 40), np.sin(np.pi * (place - 20) / 20) ** 2, 0) + 1e-7
    plain = march(lobex.Casing(surface=bump), revolutions=1)
    turned = march(lobex.Casing(surface=np.roll(bump, cells)), revolutions=1)
    # The turned march ends earlier by as many cells.
    same = place + cells < STEPS
    assert turned.depth[:, place[same] + cells] == pytest.approx(plain.depth[:, same], rel=1e-12, abs=0)
    assert np.all(turned.depth[:, :cells] == 0)


@settings(max_examples=10)
@given(st.floats(1e-3, 30.0))
def test_scaling_every_length_scales_a_linear_march(scale):
    plain = march(lobex.Casing(clearance=1e-5))
    scaled = march(lobex.Casing(amplitude=1e-4 * scale, clearance=1e-5 * scale))
    for name, power in (("depth", 1), ("displacement", 1), ("wear", 1), ("input_energy", 2), ("contact", 0)):
        left, right = getattr(scaled, name), scale**power * getattr(plain, name)
        assert left == pytest.approx(right, rel=1e-8, abs=1e-8 * np.max(right)), name


def test_a_ramp_of_equal_speeds_is_a_constant_speed_and_history_matters():
    constant, ramp = march(), march(speed=np.repeat(SPEEDS[:, None], 3, axis=1))
    assert ramp.depth == pytest.approx(constant.depth, rel=1e-12, abs=1e-18)
    rising = np.linspace(150, 200, 12)
    both = march(speed=np.stack([rising, rising[::-1]]), revolutions=12)
    assert both.speed.tolist() == [150, 200]
    assert not both.steady
    assert abs(both.volume[0] / both.volume[1] - 1) > 0.05
    with pytest.raises(ValueError, match="changes its speed"):
        both.time(0)
    assert constant.time(1)[:3] == pytest.approx(np.arange(3) / (STEPS * 92))


@pytest.fixture(scope="module")
def maps():
    """Design point 9's set-up with two and three nodal diameters, from 30 to 600 Hz."""
    speeds = np.arange(30.0, 601.0, 1.5)
    return {n: lobex.march_wear(BLADE, lobex.Casing(n), RUB, speeds, 20, 1024) for n in (2, 3)}


@pytest.mark.parametrize("diameters", [2, 3])
def test_wear_peaks_above_the_critical_speeds(maps, diameters):
    result = maps[diameters]
    first = BLADE.frequency[0]
    critical = lobex.critical_speeds(BLADE, diameters)[0]
    assert critical == pytest.approx(first / (diameters * np.array([1, 2, 3])), rel=1e-14)
    for quantity in (result.volume, result.peak):
        peaks = find_peaks(quantity)[0]
        largest = result.speed[peaks[np.argsort(quantity[peaks])[-3:]]]
        ratio = np.sort(largest) / np.sort(critical)
        assert np.all((ratio > 1.0) & (ratio < 1.15)), largest
        above = quantity[result.speed > 1.05 * first]
        assert above.max() < (0.35 if diameters == 2 else 0.45) * quantity.max()
    assert result.failed == 0


def test_ridges_lie_on_engine_orders_and_near_the_first_mode(maps):
    spectrum = maps[2].spectrum()
    first = BLADE.frequency[0]
    for speed in maps[2].speed[np.abs(maps[2].speed[:, None] / [63, 93, 186] - 1).min(axis=1) < 0.01]:
        lane = maps[2].nearest(speed)
        loudest = np.argmax(np.where(spectrum.order > 0.5, spectrum.amplitude[lane], 0))
        assert 1.0 < spectrum.frequency[lane, loudest] / first < 1.15
        assert abs(spectrum.order[loudest] - 2 * round(spectrum.order[loudest] / 2)) < 0.25


STIFF = lobex.Modes(2 * np.pi * np.array([300.0, 3000.0]), [0.03, 0.03], [[2**-0.5], [1.0]])
"""A second mode that the contact cannot feed: it asks for stable steps, and not for steps that resolve it."""


def needed_steps(modes, speed, stiffness=4.5e6):
    """Δt = 2/ω, with the highest ω of the modes held by the contact's stiffness."""
    square = np.diag(modes.angular_frequency**2) + stiffness * np.outer(modes.shape, modes.shape)
    return int(np.floor(np.sqrt(np.linalg.eigvalsh(square).max()) / (2 * speed))) + 1


SINGLE = lobex.Modes.single(frequency=300.0, damping_ratio=0.03, mass=2.0)


def test_too_few_steps_are_refused_with_the_speed_and_the_steps_needed():
    needed = needed_steps(STIFF, 10.0)
    elastic = lobex.Plastic(stiffness=4.5e6, yield_force=1e30)
    with pytest.raises(ValueError) as error:
        lobex.march_wear(STIFF, permanent(needed - 1), elastic, [20.0, 10.0], 3, needed - 1)
    assert f"steps_per_revolution = {needed - 1} is too few at speed = 10 Hz" in str(error.value)
    assert f"from {needed} on" in str(error.value)
    result = lobex.march_wear(STIFF, permanent(needed), elastic, [20.0, 10.0], 3, needed)
    assert result.failed == 0
    assert np.max(result.peak) < 1e-3


def test_a_lane_that_blows_up_is_nan_and_named(monkeypatch):
    """At the very limit of stability a contact that comes and goes pumps energy into the march."""
    monkeypatch.setattr("lobex.marches.resolved_steps.check_steps", lambda *_: None)
    steps = needed_steps(SINGLE, 10.0)
    with pytest.warns(lobex.SweepWarning, match=r"1 of 2 lanes blew up and are NaN, at speed = 10 Hz") as caught:
        result = lobex.march_wear(SINGLE, lobex.Casing(), RUB, [10.0, 400.0], 3, steps)
    assert len(caught) == 1
    assert result.failed == 1
    assert np.all(np.isnan(result.depth[0]))
    assert np.all(np.isnan(result.displacement[0]))
    assert np.isnan(result.volume[0])
    assert np.all(np.isfinite(result.depth[1]))
    assert "failed           1 lanes" in repr(result)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: march(speed=[80.0, np.nan]), "speed = [80, nan]"),
        (lambda: march(speed=[0.0, 80.0]), "speed = [0, 80]"),
        (lambda: march(speed=-80.0), "speed = -80"),
        (lambda: march(speed=80.0), "speed has shape ()"),
        (lambda: march(speed=[]), "speed has shape (0,)"),
        (lambda: march(speed=np.full((2, 4), 80.0)), "speed has shape (2, 4); give (n,) or (n, 3)"),
        (lambda: march(speed=[60 * 3000.0]), "rpm/60"),
        (lambda: march(revolutions=0), "revolutions = 0"),
        (lambda: march(revolutions=2.5), "revolutions = 2.5"),
        (lambda: march(steps=8), "steps_per_revolution = 8"),
        (lambda: march(samples_per_revolution=0), "samples_per_revolution = 0"),
        (lambda: march(lobex.Casing(surface=np.zeros(100))), "surface has 100 cells and 320"),
        (lambda: march(lobex.Casing(nodal_diameters=320)), "320 is too few for 320 nodal diameters; give 5120 or more"),
        (lambda: march(steps=200), "give 265 or more, 8 per wave of the fastest vibration that the contact can feed"),
        (lambda: march("round"), "casing = 'round'"),
        (lambda: march(law=4.5e6), "law = 4500000.0"),
        (lambda: march(law=lobex.Linear), "no contact law"),
        (lambda: lobex.march_wear("rod", lobex.Casing(), RUB, SPEEDS), "modes = 'rod'"),
        (lambda: jax.jit(lambda s: march(speed=s).depth)(SPEEDS), "traced"),
        (lambda: march(revolutions=1).spectrum(), "skip = 0 leaves 1"),
        (lambda: march(speed=[[80.0, 81.0, 82.0]]).spectrum(), "changing speed"),
        (lambda: march().spectrum(window="round"), "window = 'round'"),
        (lambda: march(speed=[80.0]).plot(), "is no map"),
        (lambda: march().plot(speed_along="z"), "speed_along = 'z'"),
        (lambda: march().nearest(-1.0), "speed = -1"),
        (lambda: march(incursion=np.nan), "incursion = nan"),
        (lambda: march(incursion=5.0), "incursion = 5 m in each of 3 revolutions"),
        (lambda: march(lobex.Casing(structure=3.0)), "casing.structure = 3.0"),
        (lambda: march(angles_degrees=[0.0, 90.0]), "angles_degrees has shape (2,)"),
        (lambda: march(tracks=(1,)), "tracks = 1"),
        (lambda: march(watched=1), "watched = 1 leaves no contact"),
        (lambda: march(speed=lambda number: number * np.nan), "speed = [nan, nan, nan]"),
        (lambda: march(speed=lambda number: 80.0), "speed(number) has shape ()"),
        (lambda: march(law=[RUB, RUB]), "law has 2 entries"),
    ],
)
def test_bad_input_is_refused_in_one_line(call, words):
    with refused(words):
        call()


def test_results_are_float64_whatever_the_setting_and_tell_what_was_done():
    assert not jax.config.jax_enable_x64
    result = march()
    assert not jax.config.jax_enable_x64
    for name, value in vars(result).items():
        if isinstance(value, np.ndarray):
            assert value.dtype == np.float64, name
    for part in ("4 speeds × 3 revolutions × 320 cells", "Linear(stiffness=4.5e+06)", "energy balance", "0 lanes"):
        assert part in repr(result)


def test_progress_is_shown_on_request(capsys):
    march(progress=True)
    assert "/3 [" in capsys.readouterr().err
    march()
    assert capsys.readouterr().err == ""


def test_saving_and_loading_returns_the_same_map(tmp_path):
    result = march()
    result.save(tmp_path / "wear.nc")
    again = lobex.load(tmp_path / "wear.nc")
    assert_same_fields(again, result)
    with xarray.open_dataset(tmp_path / "wear.nc", engine="h5netcdf") as data:
        assert data["depth"].dims == ("speed", "angle")
        assert data["depth"].attrs["units"] == "m"
        assert data["speed"].to_numpy().tolist() == SPEEDS.tolist()
    assert float(result.to_xarray()["depth"][2, 5]) == result.depth[2, 5]


def test_pictures_have_units_and_marks(maps):
    axes = maps[2].plot()
    assert axes.get_xlabel() == "rotational frequency (Hz)"
    assert axes.get_ylabel() == "casing position (°)"
    assert [text.get_text() for text in axes.texts] == ["$f_1$", "$f_1/2$", "$f_1/4$", "$f_1/6$"]
    marked = sorted(line.get_xdata()[0] for line in axes.get_lines())
    assert marked == pytest.approx(sorted(BLADE.frequency[0] / np.array([1, 2, 4, 6])))
    other = maps[2].plot(speed_along="y")
    assert other.get_ylabel() == "rotational frequency (Hz)"
    mesh = axes.collections[0].get_array()
    assert mesh.max() == pytest.approx(1e6 * np.max(maps[2].depth), rel=1e-12)
    worn = maps[2].plot_casing(92.0)
    assert "exaggerated" in worn.get_title()
    assert "Hz" in worn.get_title()
    names = [text.get_text() for text in worn.get_legend().get_texts()]
    assert names == ["removed", "casing before wear", "after 20 revolutions", "blade tip at rest"]
    history = march().plot_history()
    assert history.axes[0].get_ylabel() == "largest tip motion (µm)"
    assert len(history.axes[0].get_lines()) == 4


def shell(flags, monkeypatch, folder):
    """``lobex wear`` in this process, without its settings."""
    monkeypatch.setattr("lobex.shell.environment.prepare_jax", lambda: None)
    monkeypatch.chdir(folder)
    run_wear(Wear(flags))
    return sorted(path.name for path in folder.iterdir())


def test_the_shell_marches_and_writes_file_and_pictures(tmp_path, monkeypatch, capsys):
    flags = WearFlags(speed="62:186:4", steps=STEPS, revolutions=3, blade=BladeFlags(elements=3), output=Output("here"))
    written = shell(flags, monkeypatch, tmp_path)
    assert written == ["here-casing.png", "here-spectrum.png", "here.nc", "here.png"]
    assert min(min(plt.imread(tmp_path / name).shape[:2]) for name in written if name.endswith("png")) > 500
    expected = march(speed=np.linspace(62, 186, 4))
    assert lobex.load(tmp_path / "here.nc").depth == pytest.approx(expected.depth, rel=1e-9, abs=1e-16)
    out, err = capsys.readouterr()
    assert "most wear" in out
    assert "here-casing.png" in out
    assert "rev/s" in err


def test_a_ramp_in_the_shell_draws_its_history(tmp_path, monkeypatch, capsys):
    contact = ContactFlags(law="plastic", yield_force=50.0)
    flags = WearFlags(
        speed="62:186:4",
        steps=STEPS,
        revolutions=3,
        ramp=-4.0,
        blade=BladeFlags(elements=3),
        contact=contact,
        output=Output(quiet=True),
    )
    assert shell(flags, monkeypatch, tmp_path) == ["wear-casing.png", "wear-history.png", "wear.nc", "wear.png"]
    result = lobex.load(tmp_path / "wear.nc")
    assert result.speed_history[0].tolist() == [62, 58, 54]
    assert result.model["law"] == {"type": "Plastic", "stiffness": 4.5e6, "yield_force": 50.0, "hardening": 0.0}
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (WearFlags(speed="30:40"), "speed = '30:40'"),
        (WearFlags(speed="-30:30:5"), "speed = [-30, "),
        (WearFlags(revolutions=0), "revolutions = 0"),
        (WearFlags(ramp=-2.0), "ramp = -2 Hz takes the speed of 30 Hz to -8 Hz"),
        (WearFlags(ramp=np.nan), "ramp = nan"),
        (WearFlags(contact=ContactFlags(law="glue")), "law = 'glue'"),
        (WearFlags(contact=ContactFlags(law="power", stiffness=1.0)), "stiffness = 1.0 has no meaning"),
        (WearFlags(contact=ContactFlags(law="plastic")), "yield_force is missing"),
        (WearFlags(output=Output(out="none/wear")), "there is no folder"),
    ],
)
def test_the_shell_refuses_bad_flags_before_computing(flags, words, tmp_path, monkeypatch):
    with pytest.raises(ValueError) as error:
        shell(flags, monkeypatch, tmp_path)
    assert words in str(error.value)
    assert list(tmp_path.iterdir()) == []
