"""A report of a screen as one HTML file that needs nothing else: no script runs in it, and nothing is fetched."""

from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from lobex.explorer.addresses import query_of
from lobex.explorer.drawn_columns import in_words
from lobex.explorer.files_taken import picture
from lobex.explorer.recipes import recipe_of
from lobex.explorer.script import script_of

if TYPE_CHECKING:
    from lobex.explorer.page import Explorer

_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:900px;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse}td,th{padding:2px 12px 2px 0;text-align:left;vertical-align:top}"
    "pre{background:#f6f6f6;padding:1em;overflow:auto;font-size:13px}svg{max-width:100%;height:auto}"
)


def report_of(page: "Explorer") -> str:
    """What is on a page: pictures, numbers, and the script that makes them again."""
    import lobex

    limit: Any = page.limit
    recipe = recipe_of(page.state)
    parts = [f"<h1>Stability limit of {page.state.kind}</h1>", f"<pre>{escape(repr(limit))}</pre>"]
    parts.append(_drawn(limit.plot if page.band is None else page.band.plot))
    rows = "".join(
        f"<tr><td>{escape(in_words(name))}</td><td>{escape(_shown(value))}</td></tr>" for name, value in recipe.numbers
    )
    parts.append(f"<h2>Numbers</h2><p>In SI units.</p><table>{rows}</table>")
    if page.slopes is not None and page.slopes.table.limit is limit:
        parts.append("<h2>What matters</h2>")
        parts.append(_drawn(page.slopes.table.plot))
    if page.band is not None:
        parts.append(f"<pre>{escape(repr(page.band))}</pre>")
    if page.there is not None:
        parts.append(f"<h2>At a point</h2><pre>{escape(repr(page.there.march))}</pre>")
        parts.append(_drawn(page.there.march.plot))
        if page.there.orbit is not None:
            parts.append(f"<pre>{escape(repr(page.there.orbit))}</pre>")
    parts.append(f"<h2>To make it again</h2><pre>{escape(script_of(page.state, page.there))}</pre>")
    parts.append(
        f"<p>lobex {lobex.__version__}; the page's address ends in</p><pre>/?{escape(query_of(page.state))}</pre>"
    )
    body = "\n".join(parts)
    head = f'<meta charset="utf-8"><title>Stability limit of {page.state.kind}</title><style>{_STYLE}</style>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n{body}\n</body></html>\n'


def _drawn(plot: Any) -> str:
    """A picture as part of the page, without the lines that a file of it begins with."""
    svg = picture(plot, "svg").decode()
    return svg[svg.index("<svg") :]


def _shown(value: Any) -> str:
    return ", ".join(f"{number:.8g}" for number in np.ravel(value))
