"""How Sphinx builds these pages: ``make docs``.

MyST, because the pages are Markdown that GitHub shows, too. Not myst-nb: its kernel would compute at build time, where
here the code of every page runs in the tests and the numbers of the validation page come from a file that tests check.
"""

import re
import sys
from pathlib import Path

import lobex

sys.path.insert(0, str(Path(__file__).parent))

project = "lobex"
project_copyright = "the authors of lobex, Apache-2.0"
release = version = lobex.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "mathml", "offline"]
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
myst_links_external_new_tab = True
# Nothing is fetched from elsewhere when a page is read, no script for formulas either.
html_math_renderer = "mathml"

html_theme = "furo"
html_title = f"lobex {version}"
html_static_path: list[str] = []
html_show_sphinx = False

autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_use_ivar = True
napoleon_custom_sections = ["Source"]


def _as_rst(app, what, name, obj, options, lines) -> None:
    """What docstrings mean and reStructuredText would read otherwise: |μ|, (*lanes, n), ``Name``s."""
    for i, line in enumerate(lines):
        parts = re.split(r"(``.+?``)", line)
        # Odd parts are literals; a letter right after one needs the empty escape between.
        for k in range(0, len(parts), 2):
            text = parts[k].replace("|", r"\|").replace("(*", r"(\*")
            parts[k] = "\\ " + text if k and text[:1].isalpha() else text
        lines[i] = "".join(parts)


def _links_within(app, document, source) -> None:
    """Measurements that are pages of the repository for its reader are a page here, too."""
    source[0] = re.sub(r"\(\.\./benchmarks/\w+\.md\)", "(benchmarks.md)", source[0])


def setup(app) -> None:
    app.connect("autodoc-process-docstring", _as_rst)
    app.connect("source-read", _links_within)
