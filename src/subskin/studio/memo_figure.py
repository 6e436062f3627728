"""What a figure of the memo is to a page: numbers to move, curves, marks, equations, and words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .._check import FloatArray

__all__ = ["Figure", "Number", "curve", "drawn", "mark", "panel"]


@dataclass(frozen=True)
class Number:
    """A number that a hand moves.

    Parameters
    ----------
    key, label : str
        By which name, and what it is called.
    value, least, most, step : float
        At the beginning, and where it may lie.
    unit : str
        What it is counted in.
    """

    key: str
    label: str
    value: float
    least: float
    most: float
    step: float
    unit: str = ""


@dataclass(frozen=True)
class Figure:
    """A figure.

    Parameters
    ----------
    key, title, words : str
        Its number, what it shows, and what to look for.
    numbers : tuple of Number
        What a hand moves.
    equations : tuple of str
        Their numbers, as the memo has them: those of `subskin.memo.ERRATA` are told beside the figure.
    draw : callable
        From the numbers' values to {"panels": [...], "told": [...]}.
    """

    key: str
    title: str
    words: str
    numbers: tuple[Number, ...]
    equations: tuple[str, ...]
    draw: Callable[..., Mapping[str, Any]]

    def values(self, given: Mapping[str, Any]) -> dict[str, float]:
        """The numbers' values: those given, within their limits, and else those of the beginning.

        Parameters
        ----------
        given : mapping
            By their keys.
        """
        return {n.key: float(np.clip(given.get(n.key, n.value), n.least, n.most)) for n in self.numbers}


def curve(label: str, kind: str, x: FloatArray, y: FloatArray) -> dict[str, Any]:
    """A curve.

    Parameters
    ----------
    label : str
        What it is.
    kind : str
        How it looks: "right" (as corrected), "printed" (as the memo has it), "1" ... "4", or "area".
    x, y : ndarray, shape (n,)
        Its points.
    """
    return {"label": label, "kind": kind, "x": np.asarray(x, float).round(6), "y": _short(np.asarray(y, float))}


def mark(label: str, kind: str, x: float, y: float = 0.0) -> dict[str, Any]:
    """A point with its name; kinds are those of a curve, or "good", "bad"."""
    return {"label": label, "kind": kind, "x": x, "y": y}


def panel(title: str, x: str, y: str, curves: list[dict[str, Any]], **more: Any) -> dict[str, Any]:
    """Curves on axes; `more` are marks, and low and high of y where these are not those of the curves."""
    return {"title": title, "xlabel": x, "ylabel": y, "curves": curves, "marks": [], **more}


def drawn(told: list[str], *panels: dict[str, Any]) -> dict[str, Any]:
    """What a figure draws, and what it says."""
    return {"panels": list(panels), "told": told}


def _short(values: FloatArray) -> FloatArray:
    """Five digits of the largest are more than a screen shows."""
    finite = values[np.isfinite(values)]
    largest = float(np.abs(finite).max()) if finite.size else 0.0
    return values if largest == 0 else values.round(max(0, 5 - int(np.floor(np.log10(largest)))))
