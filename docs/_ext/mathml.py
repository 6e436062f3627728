"""Formulas as MathML, converted while the pages are built: a reader needs neither network nor script."""

from __future__ import annotations

from html import escape
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.writers.html5 import HTML5Translator


def mathml(latex: str, display: str) -> str:
    """MathML of a formula; the source goes along as its text alternative.

    What the converter does not know it passes on as a word with its backslash: that stops the build.
    """
    markup = convert(latex, display=display)
    unknown = [e.text for e in ElementTree.fromstring(markup).iter() if (e.text or "").startswith("\\")]
    if unknown:
        raise ExtensionError(f"no MathML for {', '.join(map(str, unknown))} in: {latex}")
    return markup.replace("<math ", f'<math alttext="{escape(latex.strip(), quote=True)}" ', 1)


def visit_inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(mathml(node.astext(), "inline"))
    raise nodes.SkipNode


def visit_block(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math-block"))
    if node["number"]:
        self.body.append(f'<span class="eqno">({node["number"]})</span>')
    self.body.append(mathml(node.astext(), "block") + "</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
