"""Each kind's tables, one after the other in a few arrays, so that any number of kinds is one compilation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._compiled import compiled
from ..scan import scan
from ._integrals import KindField, Survey

START, STEP, SQUARE, ENDS = range(4)
"""Columns of `Tables.geometry`; the ends are the last four."""


class Starts(NamedTuple):
    """Where each kind's part of the `Tables` begins, (kinds,) each."""

    bases: npt.NDArray[np.int64]
    edges: npt.NDArray[np.int64]
    squares: npt.NDArray[np.int64]
    tables: npt.NDArray[np.int64]
    fines: npt.NDArray[np.int64]
    nodes: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]


class Sizes(NamedTuple):
    """Of each kind, the number of squares, of the table's cells and widths, and of the survey's widths."""

    squares: npt.NDArray[np.int64]
    cells: npt.NDArray[np.int64]
    widths: npt.NDArray[np.int64]
    surveyed: npt.NDArray[np.int64]


class Tables(NamedTuple):
    """What the sensors read of each kind, and then of each that is climbed to without a scan.

    bases, edges, squares, tables as in `project_frames`, and fines, nodes, rows as in `Survey`: all kinds' one after
    the other, so that any number of kinds is one compilation. positions (m,): of the scans, with so many steps of the
    survey to each; geometry (kinds, 7): start and step of the table, the square of its widest, and the ends of y and q.
    """

    bases: npt.NDArray[np.float32]
    edges: npt.NDArray[np.float32]
    positions: FloatArray
    squares: FloatArray
    tables: FloatArray
    fines: FloatArray
    nodes: FloatArray
    rows: FloatArray
    geometry: FloatArray
    starts: Starts
    sizes: Sizes
    steps: int


@compiled(inline=True)
def field_of(tables, k, n):
    """What the sensors read of a kind."""
    cells, wides, t = tables.sizes.cells[k], tables.sizes.widths[k], tables.starts.tables[k]
    g = tables.geometry[k]
    table = tables.tables[t : t + cells * wides * 10 * n].reshape(cells, wides, 10 * n)
    return KindField(table, g[START], g[STEP], g[SQUARE], g[ENDS:])


@compiled()
def scanned(w, tables, k, n, sums, s):
    """The scan of a kind, (squares, m), and its squares."""
    m, rows = tables.positions.size, tables.sizes.squares[k]
    b, e, q = tables.starts.bases[k], tables.starts.edges[k], tables.starts.squares[k]
    basis = tables.bases[b : b + 2 * n * rows * m].reshape(n, 2, rows * m)
    edges = tables.edges[e : e + 4 * rows * m].reshape(4, rows * m)
    scan(w, basis, edges, sums[: 2 * rows * m].reshape(2, rows * m), s[: rows * m])
    return s[: rows * m].reshape(rows, m), tables.squares[q : q + rows]


@compiled(inline=True)
def survey_of(tables, k, n):
    """The survey of a kind."""
    wide, fine = tables.sizes.surveyed[k], tables.steps * (tables.positions.size - 1) + 1
    f, e, r = tables.starts.fines[k], tables.starts.nodes[k], tables.starts.rows[k]
    return Survey(
        tables.fines[f : f + 2 * n * wide * fine].reshape(n, 2, wide, fine),
        tables.nodes[e : e + 4 * wide * fine].reshape(4, wide, fine),
        tables.rows[r : r + 3 * wide].reshape(3, wide),
        (tables.positions[-1] - tables.positions[0]) / (fine - 1),
    )
