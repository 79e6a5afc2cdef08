"""The documentation: its code runs, its pages say what its numbers say, and these come out again."""

import json
import re
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.io

import lobex
import references
from lobex.gallery.registry import NAMES, figure
from test_references import MOTION

DOCS = Path(__file__).parents[1] / "docs"
sys.path.insert(0, str(DOCS))

import errata  # noqa: E402
import make_blade  # noqa: E402
import make_tap_test  # noqa: E402
import offline  # noqa: E402
import pages  # noqa: E402
import reference_rows  # noqa: E402

# Their code takes longest, as every cutter and equation compiles programs of its own.
LONG = {"advice.md", "blades.md", "cutters.md", "forced_motion.md", "measured.md", "own_equation.md", "receptance.md"}
# Rendered notebooks have tests of their own (test_notebooks.py), and so has cluster.md (test_study.py).
PAGES = [p for p in sorted([*DOCS.glob("*.md"), *DOCS.glob("howto/*.md")]) if p.name != "cluster.md"]
CONTENT = pages.read(DOCS)


# A map of which no claim is made beyond that it is drawn.
COARSER = {"forced_motion.md": ("26) / 60, np.linspace(0, 3e-3, 13)", "9) / 60, np.linspace(0, 3e-3, 5)")}


def code_of(page):
    text, (fine, coarse) = page.read_text(), COARSER.get(page.name, ("", ""))
    assert fine in text
    return re.findall(r"```python\n(.*?)```", text.replace(fine, coarse) if fine else text, re.DOTALL)


def limit_of_whole_overlap(names):
    return lobex.exact_limit(lobex.Rub(names["whole"].modes), names["speeds"]).gain


def lane_of(motion, lane):
    names = ("spectral_radius", "lowest", "highest", "peak", "surface_location_error")
    return SimpleNamespace(**{name: getattr(motion, name)[lane] for name in names})


# What a page says of its numbers.
CLAIMS = {
    "own_matrices.md": lambda n: np.median(n["limit"].gain / n["every"].gain) < 1,
    "blades.md": lambda n: (
        np.all(np.diff(n["campbell"], axis=0) > 0)
        and np.all(np.abs(n["limit"].gain / n["smooth"].gain - 1) > 0.05)
        and n["turning"].divergence_speed > 1e3
        and n["limit"].gain
        == pytest.approx([lobex.exact_limit(lobex.Rub(n["turning"].at(s)), s).gain[0] for s in n["speed"]], rel=1e-12)
        and np.nanmin(n["gains"][1]) > 2 * np.nanmin(n["gains"][0])
        and np.all(n["give"].gain > 0)
        and n["same"].modes.count == 6
        and np.abs(n["touching"].at(120.0).shape)
        == pytest.approx(np.abs(make_blade.blade()[0].rotating(0.005, [1, 2, 3], **n["rubbing"]).at(120.0).shape))
    ),
    "wear_of_real_blades.md": lambda n: (
        np.all(np.abs(n["march"].energy_error) < 1e-4)
        and n["both"].wear.shape == (2, 2, 5)
        and n["follow"].wear.shape == (2, 1, 5)
        and np.all(n["stage"].blade_to_blade > 0)
    ),
    "tap_test.md": lambda n: (
        n["mill"].modes.count == 4 and n["spindle"].at(100.0).frequency == pytest.approx([(820 + 790) / 2])
    ),
    "measured.md": lambda n: (
        np.asarray(n["fit"].modes.frequency) == pytest.approx([563.6, 516.21], rel=1e-3)
        and np.asarray(n["fit"].modes.damping_ratio) == pytest.approx([0.0558, 0.025], rel=0.02)
        and np.isfinite(n["limit"].gain).all()
        and n["band"].relative[0] < 0.01
        and n["low"] < n["found"].gain < n["high"]
        and np.abs(n["multi_frequency"].gain / n["limit"].gain - 1).max() < 0.05
        and np.abs(n["zero_order"].gain / n["limit"].gain - 1).max() < 0.05
        and np.abs(n["of_modes"].gain / n["searched"].gain - 1).max() < 1e-4
        and np.abs(n["of_samples"].gain / n["searched"].gain - 1).max() < 0.04
        and np.abs(lobex.zero_order_limit(n["fitted"], n["speed"]).gain / n["searched"].gain - 1)
        == pytest.approx([0.02, 0.03], abs=0.005)
        and n["of_modes"].band(n["fit"].relative_standard_deviation, n["fit"].correlation).relative
        == pytest.approx(
            n["searched"].band(n["fit"].relative_standard_deviation, n["fit"].correlation).relative, rel=1e-3
        )
    ),
    "receptance.md": lambda n: n["off"].max() < 1e-4,
    "milling.md": lambda n: (
        set(n["limit"].kind) <= {"hopf", "flip", ""}
        and n["limit"].intervals[0].size
        and np.array_equal(
            lobex.spectral_radius(n["mill"], n["tried"][:, 0] / 60, n["tried"][:, 1] / 1e3) > 1, n["chattered"]
        )
    ),
    # Of two independent codes.
    "cutters.md": lambda n: (
        n["limit"].gain[0] == pytest.approx(3.86853673567e-3, rel=1e-9)
        and n["slow"][1] < n["slow"][0]
        and n["worn"].coefficient == pytest.approx(4.8e5)
        and list(n["told"]) == ["stable at any gain", "found"]
        and n["slot"].edge[0] == pytest.approx(0.25 * 1.6e9 * 0.08**-0.25 * 8e-5)
        and n["deepest"][1] == pytest.approx(0.171278676078 * (200 * np.pi) ** 2 / 1.5e9, rel=1e-8)
    ),
    "forced_motion.md": lambda n: (
        n["motion"].error.max() < 1e-8 and references.apart(lane_of(n["motion"], 1), MOTION["straight"][0]) < 2e-9
    ),
    "advice.md": lambda n: (
        n["advice"].power_margin.min() > 0.1 - 1e-6
        and np.nanmin(n["advice"].location_error_margin) > 0.1 - 1e-6
        and (n["score"].hits, n["score"].misses) == (3, 1)
        and n["found"].speed[0] == pytest.approx(545 / 4)
    ),
    "limits.md": lambda n: np.array_equal(n["searched"].status == "found", np.isfinite(n["searched"].gain)),
    "explore.md": lambda n: (
        n["explorer"].settle()
        and n["explorer"].limit.gain
        == pytest.approx(lobex.exact_limit(lobex.Turning(n["tool"], radial=2e8), np.linspace(35, 200, 1000)).gain)
    ),
    "boundary.md": lambda n: len(n["traced"]) > 0 and n["traced"].residual < 1e-8,
    "jax.md": lambda n: n["value"] == pytest.approx(920209.5963) and np.all(np.diff(n["gains"]) > 0),
    "own_equation.md": lambda n: np.all(n["exact"][1:3] ** 2 < 1) and n["two"][1] == pytest.approx(1.0),
    "own_process.md": lambda n: (
        limit_of_whole_overlap(n) == pytest.approx(n["limits"][0], rel=1e-10)
        and np.all(n["limits"][1] > n["limits"][0])
    ),
    "sharp_bits.md": lambda n: np.isnan(n["narrow"].gain[0]) and np.all(n["narrow"].intervals[0, 0] == [4.5e4, 5e5]),
    "index.md": lambda n: np.isfinite(n["limit"].gain).all(),
}


def test_every_page_with_code_has_its_claim():
    assert {page.name for page in PAGES if code_of(page)} == set(CLAIMS)


def with_marks(page):
    return pytest.param(page, marks=pytest.mark.slow, id=page.name) if page.name in LONG else page


@pytest.mark.parametrize("page", [with_marks(page) for page in PAGES if code_of(page)], ids=lambda page: page.name)
def test_code_of_pages_runs_in_order(page, tmp_path, monkeypatch):
    beside = [shutil.copy(path, tmp_path) for kind in ("toml", "mtx", "csv") for path in page.parent.glob(f"*.{kind}")]
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in code_of(page):
        exec(compile(block, page.name, "exec"), names)
    assert CLAIMS[page.name](names)
    wanted = re.findall(r'(?:savefig|save|mmwrite)\("([^"]+)"', page.read_text())
    assert {str(path) for path in tmp_path.iterdir()} == {*beside, *(str(tmp_path / name) for name in wanted)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_links_lead_to_files(page):
    targets = re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL))
    for target in targets:
        path, _, anchor = target.partition("#")
        assert (page.parent / path).is_file(), target
        headings = re.findall(r"^#+ (.*)$", (page.parent / path).read_text(), re.MULTILINE) if anchor else []
        assert not anchor or anchor in map(pages.slug, headings), target


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('<script async="async" src="https://cdn.example/mathjax.js"></script>', ["https://cdn.example/mathjax.js"]),
        ('<link rel="stylesheet" href="//fonts.example/css?family=Lato">', ["//fonts.example/css?family=Lato"]),
        ("<img alt='x' src=http://host.example/a.png>", ["http://host.example/a.png"]),
        ("@import 'https://host.example/a.css';", ["https://host.example/a.css"]),
        ("@font-face {src: url(https://host.example/a.woff2)}", ["https://host.example/a.woff2"]),
        ('<a href="https://doi.org/10.1000/1">source</a> and https://host.example in words', []),
        ("<script src='_static/a.js'></script> <img src='../b.png'>", []),
        ("a {background: url('data:image/svg+xml,<svg xmlns=\"http://www.w3.org/2000/svg\"/>')}", []),
    ],
)
def test_what_a_page_fetches_from_elsewhere_is_found(text, found):
    assert offline.fetched(text) == found


def test_pages_that_need_the_internet_are_named(tmp_path):
    (tmp_path / "static").mkdir()
    (tmp_path / "static" / "a.css").write_text("@import url(//host.example/b.css);")
    (tmp_path / "a.html").write_text("<p>the multiplier \\(\\mu\\)</p><code>a\\[0]</code>")
    (tmp_path / "b.html").write_text("<p>fine</p>")
    assert offline.needs(tmp_path) == ["a.html: LaTeX \\(", "static/a.css: //host.example/b.css"]


def test_the_reference_names_every_export_once():
    text = (DOCS / "api.md").read_text()
    named = re.findall(r"\.\. auto(?:class|function|exception):: lobex\.(\w+)", text)
    assert sorted(named) == sorted(set(lobex.__all__) - {"__version__"})


def test_written_pages_are_what_the_numbers_say():
    assert (DOCS / "validation.md").read_text() == pages.validation(CONTENT)
    assert (DOCS / "gallery.md").read_text() == pages.gallery(CONTENT)


def test_the_gallery_has_a_small_picture_of_every_figure():
    pictures = {path.stem: path.stat().st_size for path in (DOCS / "gallery").iterdir()}
    assert set(pictures) == set(NAMES) == set(CONTENT["figures"])
    assert max(pictures.values()) < 60_000


def test_recorded_numbers_of_two_codes_agree():
    assert max(row["difference"] for row in CONTENT["multipliers"]) < 1e-9
    assert max(row["difference"] for row in CONTENT["limits"]) < 5e-8
    for name in ("multipliers", "limits"):
        cases = json.loads((DOCS.parent / "tests" / "data" / f"{name}.json").read_text())["cases"]
        assert len(CONTENT[name]) == sum(len(np.atleast_1d(case.get("critical_depth_m", 0))) for case in cases)


def assert_same(actual, recorded):
    """Equal words; numbers to what another machine repeats, where rounding errors are as good as zero."""
    if isinstance(recorded, dict):
        assert set(actual) == set(recorded)
        for key in recorded:
            assert_same(actual[key], recorded[key])
    elif isinstance(recorded, float):
        assert actual == pytest.approx(recorded, rel=1e-7, abs=1e-9)
    else:
        assert actual == recorded


# Quick ones: no march, no operator.
@pytest.mark.parametrize("name", ["fig-1.2", "fig-3.1", "fig-4.7", "fig-4.9", "fig-4.11"])
def test_findings_come_out_as_recorded(name):
    one = figure(name)
    recorded = CONTENT["figures"][name]
    assert (one.title, one.claim) == (recorded["title"], recorded["claim"])
    for finding, wanted in zip(one.findings(one.compute(1.0)), recorded["findings"], strict=True):
        assert_same(
            {key: getattr(finding, key) for key in ("claim", "thesis", "agrees", "why", "numbers")},
            {key: wanted[key] for key in ("claim", "thesis", "agrees", "why", "numbers")},
        )


def test_matrices_of_the_example_blade_are_those_of_its_beam():
    for name, part in make_blade.parts().items():
        read = scipy.io.mmread(make_blade.HOWTO / f"blade_{name}.mtx", spmatrix=False)
        stored = read if name == "tip" else read.toarray()
        assert stored == pytest.approx(part, rel=1e-12, abs=1e-12 * np.abs(part).max()), name


def test_the_example_tap_test_is_that_of_its_modes():
    def numbers(text):
        return np.array([[float(cell) for cell in row.split(",")] for row in text.splitlines()[1:]])

    stored = make_tap_test.PATH.read_text()
    assert stored.partition("\n")[0] == make_tap_test.text().partition("\n")[0]
    # Written to four digits.
    assert numbers(stored) == pytest.approx(numbers(make_tap_test.text()), rel=2e-3, abs=1e-6)


def test_titles_and_claims_of_all_figures_are_the_recorded_ones():
    for name, recorded in CONTENT["figures"].items():
        assert (figure(name).title, figure(name).claim) == (recorded["title"], recorded["claim"])


@pytest.mark.parametrize(
    ("compute", "key", "problem"),
    [(reference_rows.limits, "limits", "rod"), (reference_rows.multipliers, "multipliers", "rod")],
)
def test_reference_rows_come_out_as_recorded(compute, key, problem):
    recorded = [row for row in CONTENT[key] if row["problem"].startswith(problem)]
    for row, wanted in zip(compute(problem), recorded, strict=True):
        assert_same(row, wanted)


def test_effects_of_errata_come_out_as_recorded():
    assert_same(errata.effects(), CONTENT["errata"])


def test_the_printed_sign_leaves_the_blade_without_rest():
    # The rod of chapter 1 carries E S/L at its tip.
    told = CONTENT["errata"]
    assert told["tip_stiffness"] == pytest.approx(210e7 * 10e-4 / 0.5)
    assert told["least_eigenvalue"] < 0
    assert told["rate_of_1_us"] == pytest.approx(2 * told["rate_of_2_us"])
    # 2 k ξ (1 + ξ) of one mode; the others add little.
    ratio = 0.0177 * 1.0177 / (0.03 * 1.03)
    assert told["least_of_the_code"] / told["least_of_the_text"] == pytest.approx(ratio, rel=0.02)
