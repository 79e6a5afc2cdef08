"""Pages must be readable where there is no internet: a build that needs anything from elsewhere fails."""

import re
from pathlib import Path

# What a browser fetches by itself; a link that somebody follows may lead out. Data within the page is no address.
_FETCHED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed|object|link)\b[^>]*?\b(?:src|srcset|href|data)\s*=\s*"""
    r"""["']?\s*((?:https?:)?//[^\s"'>]+)"""
    r"""|@import\s+(?:url\()?\s*["']?((?:https?:)?//[^\s"')]+)"""
    r"""|\burl\(\s*["']?((?:https?:)?//[^\s"')]+)""",
    re.IGNORECASE,
)
_RAW = re.compile(r"\\\(|\\\[|\$\$")


def fetched(text: str) -> list[str]:
    """Addresses on other hosts that a page or a style sheet has fetched when it is read."""
    return [next(filter(None, match)) for match in _FETCHED.findall(text)]


def needs(folder: Path) -> list[str]:
    """What the pages of a folder need from elsewhere, and formulas that are left in LaTeX, file by file."""
    found = []
    for path in sorted([*folder.rglob("*.html"), *folder.rglob("*.css")]):
        text = path.read_text(encoding="utf-8")
        found += [f"{path.relative_to(folder)}: {address}" for address in fetched(text)]
        if path.suffix == ".html":
            prose = re.sub(r"<(pre|code|script)\b.*?</\1>", "", text, flags=re.DOTALL)
            found += [f"{path.relative_to(folder)}: LaTeX {raw}" for raw in _RAW.findall(prose)]
    return found


def _check(app, exception) -> None:
    from sphinx.errors import ExtensionError

    if exception is None and app.builder.format == "html" and (found := needs(Path(app.outdir))):
        raise ExtensionError(f"pages that cannot be read offline: {'; '.join(found[:10])}")


def setup(app) -> None:
    app.connect("build-finished", _check)
