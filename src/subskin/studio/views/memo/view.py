"""The view of the memo: a figure for its number and the values of its numbers."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from ....errors import InvalidValueError
from ....memo import ERRATA
from .contacts import FIGURES as CONTACTS
from .figure import Figure
from .formula import tree_of, words_of
from .lines import FIGURES as LINES
from .particle import FIGURES as PARTICLE
from .waves import FIGURES as WAVES

__all__ = ["MemoState", "look"]

_ALL = {f.key: f for f in sorted((*LINES, *CONTACTS, *WAVES, *PARTICLE), key=lambda f: int(f.key))}
_MINUS = re.compile(r"(?<![\w.])-(?=\d)")
"""The hyphen of a negative number."""


class MemoState(BaseModel):
    """What a page shows of the memo: the figure, and its numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    figure: str = Field(default="2", max_length=8)
    values: Annotated[dict[str, float], Field(max_length=12)] = {}


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
