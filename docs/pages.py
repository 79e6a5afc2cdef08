"""The validation page and the gallery, written from validation.json: ``python docs/pages.py``."""

import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from errata import ERRATA

Content = dict[str, Any]
_FIRST = "<!-- Written by docs/pages.py from docs/validation.json: change these, not this page. -->\n"


def write(folder: Path) -> None:
    """Write validation.md and gallery.md beside the numbers."""
    content = read(folder)
    (folder / "validation.md").write_text(validation(content))
    (folder / "gallery.md").write_text(gallery(content))


def read(folder: Path) -> Content:
    """The numbers."""
    return json.loads((folder / "validation.json").read_text())


def numbers(content: Content) -> dict[str, float]:
    """All numbers by name: those of findings as "fig-4.12/caption_85", those of errata by their own."""
    found = dict(content["errata"])
    for name, figure in content["figures"].items():
        for finding in figure["findings"]:
            found |= {f"{name}/{key}": value for key, value in finding["numbers"].items()}
    return found


def gallery(content: Content) -> str:
    """Every figure with its title and what the thesis reads from it."""
    parts = [
        _FIRST,
        "# Gallery\n",
        "The figures of the thesis, made by lobex. `lobex reproduce` makes them all, larger, with their numbers as "
        "NetCDF files; `lobex reproduce fig-4.3` makes one. The pictures on this page are made by the same code: "
        "`python docs/make_validation.py`. What agrees with the thesis and what does not is in "
        "[](validation.md).\n",
    ]
    for name, figure in content["figures"].items():
        differing = sum(not finding["agrees"] for finding in figure["findings"])
        count = len(figure["findings"])
        verdict = "all agree" if not differing else f"{differing} of {count} differ"
        parts += [
            f"## {_heading(name, figure)}\n",
            f"![{figure['title']}](gallery/{name}.png)\n",
            f"The thesis reads from it: {figure['claim']} Findings: {count}, {verdict} "
            f"([numbers](validation.md#{slug(_heading(name, figure))})).\n",
        ]
    return "\n".join(parts)


def validation(content: Content) -> str:
    """Findings, reference tables and errata."""
    findings = [finding for figure in content["figures"].values() for finding in figure["findings"]]
    agreeing = sum(finding["agrees"] for finding in findings)
    made = ", ".join(f"{name} {version}" for name, version in content["made_with"].items())
    parts = [
        _FIRST,
        "# Validation\n",
        f"The thesis is *Abradable material removal in aircraft engines: a time delay approach*, McGill University, "
        f"2010. Of {len(findings)} claims that it draws from {len(content['figures'])} figures, {agreeing} hold here "
        f"and {len(findings) - agreeing} do not, each with its reason. Then the tables of reference numbers, and the "
        "errata with what each does to results.\n",
        "Every number on this page is read from `docs/validation.json`, which `python docs/make_validation.py` "
        f"computes in some minutes (last with {made}); building the documentation computes nothing. "
        "`tests/test_docs.py` asserts that the page is what that file says, computes a part of the file anew and "
        "compares it; `tests/test_gallery.py` asserts the numbers of every figure on coarser grids, and "
        "`tests/test_reference.py` the tables, by another method.\n",
        "## Figure by figure\n",
    ]
    for name, figure in content["figures"].items():
        parts.append(f"### {_heading(name, figure)}\n")
        rows = [
            ("agrees" if f["agrees"] else "**differs**", f["claim"], f["thesis"], f["ours"], f["why"])
            for f in figure["findings"]
        ]
        parts.append(_table(("", "claim", "thesis", "here", "why"), rows))
    parts += [_tables(content), _errata(content)]
    return "\n".join(parts)


def _tables(content: Content) -> str:
    """The reference tables, by problem."""
    parts = [
        "## Reference numbers\n",
        "Numbers of two or three independent codes, good to the digits given "
        "([multipliers.json](../tests/data/multipliers.json), [limits.json](../tests/data/limits.json)), beside "
        "lobex with the method that it chooses by itself. Of periodic coefficients that method promises max|μ| within "
        "1e-8; where max|μ| rises slowly with the depth of cut, the same is a little more of the depth.\n",
    ]
    for key, title, heading in (("multipliers", "Multipliers", "max|μ|"), ("limits", "Limits", "limit (N/m, m)")):
        worst = max(row["difference"] for row in content[key])
        rows = [
            (
                row["problem"],
                row["point"],
                f"{row['reference']:.11g}",
                f"{row['lobex']:.11g}",
                f"{row['difference']:.0e}",
            )
            for row in content[key]
        ]
        parts += [
            f"### {title}\n",
            f"{len(rows)} numbers, at most {worst:.0e} apart.\n",
            _table(("problem", "point", f"{heading}, reference", "lobex", "relative difference"), rows),
        ]
    return "\n".join(parts)


def _errata(content: Content) -> str:
    """The errata, those that change results first."""
    known = numbers(content)
    parts = ["## Errata of the thesis\n"]
    for matters, title in ((True, "With an effect on results"), (False, "Slips of the pen")):
        rows = [(e.place, e.printed, e.right, e.effect(known)) for e in ERRATA if e.matters is matters]
        parts += [f"### {title}\n", _table(("place", "printed", "holds, or taken here", "effect"), rows)]
    return "\n".join(parts)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [map(_cell, head), ["---"] * len(head), *(map(_cell, row) for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _cell(text: str) -> str:
    """Text within a table."""
    return text.replace("|", "\\|")


def _heading(name: str, figure: Content) -> str:
    return f"{name.replace('fig-', 'Fig. ')}: {figure['title']}"


def slug(heading: str) -> str:
    """The anchor that GitHub and MyST give a heading."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


if __name__ == "__main__":
    write(Path(__file__).parent)
