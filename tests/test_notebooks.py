"""The notebooks run as they stand, show what their texts say, and their rendered pages are those of this code."""

import re
from pathlib import Path
from typing import Any

import jax
import matplotlib.pyplot as plt
import numpy as np
import pytest

import lobex

ROOT = Path(__file__).parents[1]
NAMES = (
    "1_quickstart",
    "2_blade_rub",
    "3_milling",
    "4_gradients",
    "5_own_matrices",
    "6_catalogue",
    "7_pitch_by_gradient",
    "8_fan_blade",
)
RENDERED = ROOT / "docs" / "notebooks"


def executed(name, **coarser):
    """The names that a notebook leaves behind, some of its numbers given; its pictures must all be drawable."""
    code = (ROOT / "notebooks" / f"{name}.py").read_text()
    for number, value in coarser.items():
        code, found = re.subn(rf"^{number} = .*$", f"{number} = {value}", code, flags=re.MULTILINE)
        assert found == 1
    result: dict[str, Any] = {}
    figures = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plt, "show", lambda: figures.extend(plt.figure(number) for number in plt.get_fignums()))
        exec(compile(code, f"{name}.py", "exec"), result)
    for figure in figures:
        figure.canvas.draw()
    assert figures
    plt.close("all")
    return result


def test_the_quickstart_s_march_grows_as_its_multipliers_say():
    seen = executed("1_quickstart")
    assert seen["radius"][0] < 1 < seen["radius"][1]
    assert seen["march"].growth == pytest.approx(seen["radius"], rel=1e-3)
    assert seen["limit"].gain == pytest.approx(lobex.exact_limit(seen["rub"], seen["chart"].speed).gain, rel=1e-9)
    # The better speed is the slower one, and its limit is above the stiffness at hand; the other's is below.
    at = np.interp(seen["SPEEDS"], seen["limit"].speed, seen["limit"].gain)
    assert at[0] > seen["STIFFNESS"] > at[1]
    assert np.nanmax(seen["gap"]) < 0.01
    assert np.array_equal(seen["again"].spectral_radius, seen["chart"].spectral_radius)


def test_the_blade_rub_s_two_lists_of_speeds_differ_as_its_text_says():
    seen = executed("2_blade_rub")
    critical, bottoms, resonance = (np.asarray(seen[n]) for n in ("critical", "bottoms", "resonance"))
    assert critical == pytest.approx(seen["f1"] / np.array([2, 4, 6]), rel=1e-12)
    # The rule of one mode is not the limit of five, which help to stiffen the tip.
    assert seen["rule"] == pytest.approx(seen["least"].gain, rel=0.05)
    assert np.interp(bottoms, seen["SPEED"], seen["limit"].gain) == pytest.approx(float(seen["least"].gain), rel=0.02)
    # Critical speeds: near the peaks of the limit, little worn; wear peaks a tenth above, beside a lobe's bottom.
    peaks = local_maxima(seen["SPEED"], seen["limit"].gain)
    assert all(np.min(np.abs(peaks / speed - 1)) < 0.02 for speed in critical)
    assert np.all(seen["at_critical"] > 1.5)
    assert resonance / critical == pytest.approx(1.1, abs=0.02)
    assert all(np.min(np.abs(bottoms / speed - 1)) < 0.06 for speed in resonance)
    speed, two, three = seen["SPEED"], seen["two"], seen["three"]
    assert np.all(np.interp(critical, speed, two) < 0.2)
    # Not every bottom is worn, and another casing wears others.
    assert np.interp([73.4, 126.6], speed, two).max() < 0.2
    assert np.interp(resonance[:2], speed, three).max() < 0.2
    assert 113 < speed[(speed > 100)][np.argmax(three[speed > 100])] < 135
    # Largest lines: near f1, just below whole orders.
    order = seen["spectrum"].order[seen["lines"]]
    assert np.all((np.array([2, 4, 6]) - order > 0.05) & (np.array([2, 4, 6]) - order < 0.2))
    assert order * resonance == pytest.approx(seen["f1"], rel=0.1)
    assert np.abs(seen["wear"].energy_error).max() < 1e-5


def local_maxima(x, y):
    """Where y is above both neighbours."""
    return x[1:-1][(y[1:-1] > y[:-2]) & (y[1:-1] > y[2:])]


def test_the_recommended_milling_point_holds():
    seen = executed(
        "3_milling",
        RPM="np.linspace(8500, 14500, 61)",
        chart="lobex.sweep(mill, speed, np.linspace(0, 14e-3, 36))",
        island="lobex.sweep(mill, np.linspace(11500, 12500, 21) / 60, np.linspace(2e-3, 6e-3, 17))",
    )
    limit, best, peak = (seen[n] for n in ("limit", "best", "peak"))
    assert set(limit.status) <= {"found", "tie"}
    # The independent codes' three depths at 12,000 rpm.
    low_high = limit.intervals[seen["shown"]]
    expected = [1e-4, 0.0031801762108573588, 0.004514895124331333, 0.004857372477035402]
    assert low_high[:2].ravel() == pytest.approx(expected, rel=1e-6)
    assert seen["again"].mean() > 5 / 121
    halves = 2 * seen["waves"][seen["flips"]]
    assert halves == pytest.approx(np.round(halves), abs=1e-6)
    assert set(np.round(halves)) <= {5, 7}
    # Held by nearly all of the drawn tools, at the limit and at the peak by far fewer.
    held = list(seen["held"].values())
    assert held[0] >= 0.9 * seen["TOOLS"]
    assert max(held[1:]) < 0.8 * seen["TOOLS"]
    assert seen["depth"] < seen["edge"][best] < limit.gain[best] < limit.gain[peak]
    # What the others get wrong.
    assert seen["error"].max() > 1e-2
    assert seen["pieces"].max() < 1e-7
    assert 0.02 < np.nanmedian(seen["off"]) < 0.1
    assert np.nanmean(seen["naive"].gain > limit.gain[seen["few"]]) > 0.9
    assert seen["radius"] > 1
    assert seen["verdict"] > 0.1


def test_gradients_agree_with_scaling_sampling_and_differences():
    seen = executed("4_gradients")
    assert seen["scaling"] < 1e-9
    assert np.median(seen["inside"]) == pytest.approx(0.68, abs=0.07)
    assert seen["inside"].min() < 0.5
    # Mass is kept, the bounds are, and the worst limit of the range has grown by much.
    areas = seen["areas"]
    assert areas.mean() == pytest.approx(seen["NOMINAL"]["area"], rel=1e-9)
    assert areas.max() / areas.min() < seen["HEAVIEST"] / seen["LIGHTEST"]
    assert np.argmin(areas) == len(areas) - 1
    assert 2 <= np.argmax(areas) <= 5
    assert seen["after"].min() > 1.15 * seen["before"].min()
    assert seen["after"][0] == pytest.approx(seen["after"][-1], rel=0.05)
    assert seen["natural"] > seen["first"]
    # The uniform blade is the rod of as many elements.
    rod = lobex.Rub(lobex.Rod(seen["SECTIONS"]).modes(seen["NOMINAL"]["damping_ratio"]))
    assert seen["before"] == pytest.approx(lobex.exact_limit(rod, seen["RANGE"]).gain, rel=1e-9)
    with jax.enable_x64(True):
        step = 1e-5 * np.eye(seen["SECTIONS"])[2]
        rise = seen["soft_minimum"](seen["UNIFORM"] + step) - seen["soft_minimum"](seen["UNIFORM"] - step)
    assert float(rise) / 2e-5 == pytest.approx(seen["slopes"][0, 2], rel=1e-5)


def test_own_matrices_are_the_handbook_s_beam():
    seen = executed("5_own_matrices", SPEED="np.linspace(30.0, 150.0, 151)")
    assert seen["deviation"].max() < 5e-4
    full, one, two = (seen["limits"][n].gain for n in (5, 1, 2))
    # The bottoms are those of one mode; where it promises most too much, the second mode chatters.
    assert one.min() == pytest.approx(full.min(), rel=0.02)
    assert one[seen["wrong"]] > 2 * full[seen["wrong"]]
    assert np.abs(two / full - 1).max() < 0.1
    chatter = seen["limits"][5].chatter_frequency[seen["wrong"]]
    assert chatter == pytest.approx(seen["modes"].frequency[1], rel=0.05)
    assert seen["modes"].frequency[0] * 2 < chatter


# Its three cutters and their motions are programs of their own, which take a minute.
@pytest.mark.search
def test_the_cut_of_the_catalogue_holds_in_time_and_its_neighbour_does_not():
    seen = executed("6_catalogue", CUTS="1", **{"SPEEDS, SCAN": "6, 9", "STEPS, SLICES, TURNS": "720, 1, 40"})
    # As the linear march grows so do the multipliers say, to the error of its steps.
    assert seen["growth"] == pytest.approx(seen["expected"], rel=5e-3)
    assert seen["expected"][0] < 1 < seen["expected"][1]
    assert seen["apart"] < 0.03 * seen["size"]
    # Chatter is somewhere else every turn; at the next speed it is gone, and the forced motion is large.
    assert seen["scatter"] > 20 > 20 * seen["once"]
    assert seen["swung"] > seen["scatter"]
    assert not np.any(np.array(seen["advice"].stability_margin) < seen["MARGIN"] - 1e-3)
    assert seen["advice"].mean_power[0] <= (1 - seen["MARGIN"]) * seen["POWER"] * (1 + 1e-3)


# Its limits and their derivatives by pitch are programs of a minute.
@pytest.mark.search
def test_the_pitch_angles_by_gradient_hold_in_time_where_the_first_do_not():
    seen = executed("7_pitch_by_gradient")
    assert seen["derivative"] == pytest.approx(seen["difference"], rel=1e-4)
    assert seen["pitch"].sum() == pytest.approx(360, rel=1e-12)
    assert np.abs(seen["pitch"] - 90).max() < seen["FARTHEST"] * (1 + 1e-9)
    # It ends where first order promises no more, and what the last steps promised was kept.
    assert seen["promise"] - seen["after"].min() < seen["ENOUGH"]
    assert seen["least"][1:] == pytest.approx(seen["promises"], rel=0.1)
    assert np.all(np.diff(seen["least"]) > 0)
    assert seen["after"].min() > 1.4 * seen["before"].min()
    # As more nodes have it.
    limit = lobex.critical_gain(
        seen["milling"](seen["pitch"]), seen["RPM"][::5] / 60, seen["BOUNDS"], scan=seen["SCAN"]
    )
    assert seen["after"][::5] == pytest.approx(1e3 * limit.gain, rel=1e-7)
    # As the march grows so do the multipliers say, to the error of its steps.
    assert seen["growth"] == pytest.approx(seen["expected"], rel=2e-3)
    assert seen["expected"][0] > 1 > seen["expected"][1]
    # Elsewhere it costs.
    assert seen["change"].min() < -0.3


@pytest.mark.slow
def test_the_fan_blade_s_pattern_holds_in_time():
    seen = executed("8_fan_blade", STEPS=6)
    assert {1, 3} <= set(seen["limits"]["smooth"].mode)
    assert seen["ratio"].min() < 1 < seen["ratio"].max()
    assert seen["gain"] > 1.5
    assert np.abs(seen["shares"]).max() <= seen["MOST"]
    motion, expected = seen["motion"], seen["expected"]
    assert expected[0.7] < 1 < expected[1.2]
    # Over ten revolutions while all blades are in contact, to what other multipliers leave of theirs.
    for share in (0.7, 1.2):
        assert (motion[share][24] / motion[share][14]) ** 0.1 == pytest.approx(expected[share], abs=0.03)


@pytest.mark.parametrize("name", NAMES)
def test_the_rendered_page_is_that_of_the_code(name):
    page = (RENDERED / f"{name}.md").read_text()
    shown = [block.strip() for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL)]
    cells = re.split(r"^# %%", (ROOT / "notebooks" / f"{name}.py").read_text(), flags=re.MULTILINE)[1:]
    assert shown == [cell.strip() for cell in cells if not cell.startswith(" [markdown]")]
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", page)
    assert pictures
    assert {RENDERED / p for p in pictures} == set((RENDERED / f"{name}_files").glob("*"))
    assert all((RENDERED / p).stat().st_size < 80_000 for p in pictures)
