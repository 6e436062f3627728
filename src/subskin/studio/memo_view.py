"""The view of the memo: a figure for its number and the values of its numbers, and what is known of its equations.

A formula goes from the LaTeX in which `ERRATA` has it to a tree that a page makes into MathML. A tree is a list [kind,
part, ...]: "row" of parts, "frac" and "sqrt", "sup", "sub" and "both" of a base, and the leaves "i" (a name), "n" (a
number), "o" (a sign), "t" (text), "s" (room).
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from pydantic import Field

from ..errors import InvalidValueError
from ..memo import ERRATA
from .memo_contacts import FIGURES as CONTACTS
from .memo_figure import Figure
from .memo_waves import FIGURES as WAVES
from .view import FromPage, StudioView, asked

__all__ = ["MemoState", "MemoView", "look", "tree_of", "words_of"]

_ALL = {f.key: f for f in sorted((*CONTACTS, *WAVES), key=lambda f: int(f.key))}
_MINUS = re.compile(r"(?<![\w.])-(?=\d)")
"""The hyphen of a negative number."""
_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[0-9][0-9.e]*|[A-Za-z]|[{}^_]|\S")
_NAMES = {"alpha": "α", "nu": "ν", "pi": "π", "rho": "ρ", "epsilon": "ε", "sigma": "σ", "theta": "θ"}
_SIGNS = {"approx": "≈", "ge": "≥", "cdot": "·", "|": "|"}
_FUNCTIONS = {"sin", "cos", "tan", "cot"}

Tree = list[Any]


class MemoState(FromPage):
    """What a page shows of the memo: the figure, and its numbers."""

    figure: str = Field(default="2", max_length=8)
    values: dict[str, float] = Field(default_factory=dict, max_length=12)


_FIRST = MemoState()


class MemoView(StudioView):
    """The figures, as a hand moves their numbers."""

    @asked
    def look(self, state: MemoState = _FIRST) -> dict[str, Any]:
        """What a page draws; as the function `look`."""
        return look(state)


def look(given: MemoState) -> dict[str, Any]:
    """What a page draws.

    Parameters
    ----------
    given : MemoState
        Which figure, with which numbers.

    Raises
    ------
    InvalidValueError
        A figure that the memo has not.
    """
    figure = _ALL.get(given.figure)
    if figure is None:
        raise InvalidValueError(f"figure {given.figure}", f"the memo has {', '.join(_ALL)}", "another figure")
    values = figure.values(given.values)
    drawn = figure.draw(**values)
    return {
        "state": {"figure": figure.key, "values": values},
        "figures": {key: one.title for key, one in _ALL.items()},
        "title": figure.title,
        "words": figure.words,
        "numbers": [{**vars(number), "value": values[number.key]} for number in figure.numbers],
        "equations": _equations(figure.key),
        **drawn,
        "told": [_MINUS.sub("\N{MINUS SIGN}", text) for text in drawn["told"]],
    }


@lru_cache(maxsize=64)
def _equations(key: str) -> list[dict[str, Any]]:
    """What is known of the figure's equations; the numbers in the findings are computed."""
    figure: Figure = _ALL[key]
    return [
        {
            "number": one.equation,
            "subject": one.subject,
            "judgement": one.judgement,
            "finding": words_of(one.finding),
            "printed": tree_of(one.published),
            "corrected": tree_of(one.corrected),
        }
        for one in ERRATA
        if one.equation in figure.equations
    ]


def tree_of(formula: str) -> Tree:
    """The tree of a formula.

    Parameters
    ----------
    formula : str
        LaTeX, of what `ERRATA` uses.

    Examples
    --------
    >>> tree_of(r"a^2/x_1")
    ['row', ['sup', ['i', 'a'], ['n', '2']], ['o', '/'], ['sub', ['i', 'x'], ['n', '1']]]
    """
    tokens = _TOKEN.findall(formula)
    tree, rest = _row(tokens, 0)
    assert rest == len(tokens), formula
    return tree


def words_of(text: str) -> list[list[Any]]:
    """Paragraphs of a finding; each a list of words and of trees of formulas. Tables are left out.

    Parameters
    ----------
    text : str
        Markdown with formulas between dollar signs.

    Examples
    --------
    >>> words_of("It is $2 a$.")
    [['It is ', ['row', ['n', '2'], ['i', 'a']], '.']]
    """
    lines = [
        line.removeprefix("- ").replace("**", "") for line in text.split("\n") if line and not line.startswith("|")
    ]
    parts = (re.split(r"\$(.+?)\$", line) for line in lines)
    return [[tree_of(part) if k % 2 else part for k, part in enumerate(line) if part] for line in parts]


def _row(tokens: list[str], at: int) -> tuple[Tree, int]:
    """Parts up to a closing brace or the end."""
    parts: Tree = ["row"]
    while at < len(tokens) and tokens[at] != "}":
        if tokens[at] in "^_":
            parts[-1], at = _raised(parts[-1], tokens, at)
        else:
            part, at = _part(tokens, at)
            if part:
                parts.append(part)
    return parts, at


def _raised(base: Tree, tokens: list[str], at: int) -> tuple[Tree, int]:
    """The part before with what stands above or below it."""
    kind = "sup" if tokens[at] == "^" else "sub"
    more, at = _part(tokens, at + 1)
    if base[0] == "sub" and kind == "sup":
        return ["both", base[1], base[2], more], at
    return [kind, base, more], at


def _part(tokens: list[str], at: int) -> tuple[Tree, int]:
    """One part."""
    token = tokens[at]
    at += 1
    if token == "{":
        tree, at = _row(tokens, at)
        return (tree[1] if len(tree) == 2 else tree), at + 1
    if not token.startswith("\\"):
        kind = "n" if token[0].isdigit() else "i" if token.isalpha() else "o"
        return [kind, "−" if token == "-" else token], at
    name = token[1:]
    if name in ("frac", "sqrt"):
        parts: Tree = [name]
        for _ in range(2 if name == "frac" else 1):
            part, at = _part(tokens, at)
            parts.append(part)
        return parts, at
    if name in ("left", "right"):
        return ["o", tokens[at]], at + 1
    if name in ("quad", ",", ";", " "):
        return ["s", 1.0 if name == "quad" else 0.17], at
    if name in _FUNCTIONS:
        return ["t", name], at
    return (["i", _NAMES[name]] if name in _NAMES else ["o", _SIGNS.get(name, name)]), at
