"""Formulas as MathML, which browsers draw by themselves: pages are readable where there is no internet."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.writers.html5 import HTML5Translator

# Names of functions that the converter does not know.
_FUNCTIONS = re.compile(r"\\(arg)(?![a-zA-Z])")


def mathml(latex: str, display: str) -> str:
    """A formula, "inline" or "block". ValueError where a part of it would be left in LaTeX."""
    made = convert(_FUNCTIONS.sub(r"\\operatorname{\1}", latex), display=display)
    if "\\" in made:
        raise ValueError(f"the formula {latex!r} has a command that MathML is not made of; name it in docs/mathml.py")
    return made


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def _block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f"<p>{mathml(node.astext(), 'block')}</p>\n")
    raise nodes.SkipNode


def setup(app) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
