"""The words and tables of answers: of a single frame its numbers with their errors, of many their counts and ranges."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from .._check import FloatArray
from .._shown import html_table, lines, many_of, span, with_error

__all__ = ["MOST_ROWS", "Shown", "as_frame", "in_html", "in_words"]

MOST_ROWS = 10
"""Frames that a table for a notebook shows."""


class Shown(NamedTuple):
    """What is shown of one quantity: its name, values and standard deviations in `unit`, all of the batch's shape."""

    name: str
    values: FloatArray
    std: FloatArray
    unit: str


def in_words(title: str, status: Any, names: Mapping[int, str], quantities: list[Shown], more: str = "") -> str:
    """What `repr` gives.

    Parameters
    ----------
    title : str
        What it is.
    status : ndarray of int, shape (...)
        Status of each frame.
    names : mapping of int to str
        What each status is called.
    quantities : list of Shown
        In the order in which they are said.
    more : str, optional
        What else is to be said of a single frame.
    """
    if status.shape == ():
        said = [f"{q.name} {with_error(float(q.values), float(q.std), q.unit)}" for q in quantities]
        known = [text for text, q in zip(said, quantities, strict=True) if np.isfinite(q.values)]
        apart = ";\n" + " " * (len(title) + 1)  # on a line of its own
        return f"{title}({apart.join([', '.join([names[int(status)], *known]), *filter(None, [more])])})"
    rows = _summary(quantities)
    head = _head(title, status, names)
    return lines(head, rows) if rows else head


def in_html(title: str, status: Any, names: Mapping[int, str], quantities: list[Shown]) -> str:
    """What a notebook shows: the first frames as a table; the arguments are those of `in_words`."""
    flat = [Shown(q.name, q.values.reshape(-1), q.std.reshape(-1), q.unit) for q in quantities]
    every = status.reshape(-1)
    rows = [
        [str(i), names[int(every[i])], *(with_error(float(q.values[i]), float(q.std[i]), "") for q in flat)]
        for i in range(min(every.size, MOST_ROWS))
    ]
    heads = ["frame", "status", *(f"{q.name} [{q.unit}]" if q.unit else q.name for q in flat)]
    if status.shape == ():
        rows, heads = [row[1:] for row in rows], heads[1:]
        return html_table(title, rows, heads)
    first = f"; the first {MOST_ROWS}" if every.size > MOST_ROWS else ""
    return html_table(_head(title, status, names) + first, rows, heads)


def _head(title: str, status: Any, names: Mapping[int, str]) -> str:
    counts = many_of((name, int((status == value).sum())) for value, name in names.items())
    shape = f"{status.size} frames" if status.ndim == 1 else f"frames of shape {status.shape}"
    return f"{title} of {shape if status.size != 1 or status.ndim > 1 else 'one frame'}: {counts or 'none'}"


def _summary(quantities: list[Shown]) -> list[list[str]]:
    """Of each quantity its range and its median error."""
    rows = []
    for q in quantities:
        if np.isfinite(q.values).any():
            error = q.std[np.isfinite(q.std) & np.isfinite(q.values)]
            typical = f"+- {np.median(error):.2g} {q.unit}".rstrip() if error.size and error.any() else ""
            rows.append([q.name, span(q.values, q.unit), f"{typical} (median)" if typical else ""])
    return rows


def as_frame(columns: Mapping[str, Any], shape: tuple[int, ...]) -> Any:
    """A pandas table of `columns` that each have the batch's `shape`: a row a frame.

    Raises
    ------
    ModuleNotFoundError
        pandas is not installed.
    """
    try:
        pandas = import_module("pandas")
    except ModuleNotFoundError:
        raise ModuleNotFoundError("to_pandas() needs pandas. Fix: pip install pandas", name="pandas") from None
    index = None if len(shape) < 2 else pandas.MultiIndex.from_product([range(size) for size in shape])
    return pandas.DataFrame({name: np.reshape(values, -1) for name, values in columns.items()}, index=index)
