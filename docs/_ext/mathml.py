"""Formulas as MathML, converted while the pages are built: a reader needs neither network nor script."""

from __future__ import annotations

from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.writers.html5 import HTML5Translator

NAMESPACE = "http://www.w3.org/1998/Math/MathML"
ElementTree.register_namespace("", NAMESPACE)


def mathml(latex: str, display: str) -> str:
    """MathML of a formula; the source goes along as its text alternative.

    What the converter does not know it passes on as a word with its backslash: that stops the build.
    """
    tree = ElementTree.fromstring(convert(latex, display=display))
    unknown = [e.text for e in tree.iter() if (e.text or "").startswith("\\")]
    if unknown:
        raise ExtensionError(f"no MathML for {', '.join(map(str, unknown))} in: {latex}")
    for row in list(tree.iter(f"{{{NAMESPACE}}}mrow")):
        _space_functions(row)
    tree.set("alttext", latex.strip())
    return ElementTree.tostring(tree, encoding="unicode")


def _space_functions(row: ElementTree.Element) -> None:
    """A thin space on either side of sin, tan, ..., as TeX sets it; the converter leaves none."""
    children = list(row)
    for i, child in reversed(list(enumerate(children))):
        name = child if child.text else next(iter(child), child)
        if len((name.text or "").strip()) > 1 and (name.text or "").isalpha():
            if i + 1 < len(children) and children[i + 1].text != "(":
                row.insert(i + 1, ElementTree.Element(f"{{{NAMESPACE}}}mspace", width="0.17em"))
            if i and children[i - 1].tag != f"{{{NAMESPACE}}}mo":
                row.insert(i, ElementTree.Element(f"{{{NAMESPACE}}}mspace", width="0.17em"))


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
