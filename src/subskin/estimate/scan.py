"""Compiled: chi-square explained on a grid of positions (and widths), and the highest points of it.

For a load at y the whitened readings are w = A(y) theta + noise, theta = (N, T), A of shape (n, 2). With the forces
eliminated, the explained part of chi-square is S(y) = max over admissible theta of |w|^2 - |w - A theta|^2; theta is
admissible in the cone N >= 0, |T| <= mu N. Here S comes from A in an orthonormal basis, in single precision: it only
says where to climb from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._compiled import compiled
from .cone import eliminate_two

FEW = 4
"""Maxima along a line that are climbed."""
MOST_CHI2 = 1e30
"""Sum of the squared readings, in noises, from which the digits of a float end before the noise begins."""


class Heights(NamedTuple):
    """S at each node of the scan, and what it takes to find it.

    basis, edges, shapes: as of `project_frames`; size: nodes within the search; w (n,), sums (2, padded): scratch.
    nodes (padded + 2,): S, with -1 before and behind; beyond (k,): of the nodes beyond the search; words, peak: as of
    `peaks`.
    """

    basis: npt.NDArray[np.float32]
    edges: npt.NDArray[np.float32]
    shapes: npt.NDArray[np.float64]
    size: int
    w: npt.NDArray[np.float32]
    sums: npt.NDArray[np.float32]
    nodes: npt.NDArray[np.float32]
    beyond: npt.NDArray[np.float32]
    words: npt.NDArray[np.uint64]
    peak: npt.NDArray[np.uint8]


@compiled(inline=True)
def room_for(basis, edges, shapes, size, beyond):
    """The `Heights` of a scan with so many nodes within the search, and beyond it."""
    n, _, padded = basis.shape
    nodes, words = np.empty(padded + 2, dtype=np.float32), np.empty(padded // 8, dtype=np.uint64)
    nodes[0] = nodes[-1] = np.float32(-1)
    w, sums = np.empty(n, dtype=np.float32), np.empty((2, padded), dtype=np.float32)
    return Heights(
        basis, edges, shapes, size, w, sums, nodes, np.empty(beyond, dtype=np.float32), words, words.view(np.uint8)
    )  # fmt: skip


@compiled(inline=True)
def survey(w, heights, told):
    """Fill `heights` for a frame w (n,), within the ends of N if there are any; gives the highest beyond the search."""
    single, beyond = heights.w, heights.beyond
    for i in range(w.size):
        single[i] = w[i]
    s, size, top = heights.nodes, heights.size, np.float32(0.0)
    scan(single, heights.basis, heights.edges, heights.sums, s[1:-1])
    for k in range(beyond.size):
        beyond[k] = s[size + 1 + k]
        top = max(top, beyond[k])
    for k in range(size + 1, s.size - 1):
        s[k] = np.float32(-1)
    if heights.shapes.shape[1] > 0:
        between(heights.sums, heights.shapes, told.friction, told.least, told.most, s[1 : size + 1])
    return top


@compiled()
def scan(w, basis, edges, c, s):
    """S at each node into s (m,).

    w (n,); basis (n, 2, m): orthonormal columns of A; edges (4, m): unit edges of the cone in them; c (2, m): scratch.
    """
    n, _, m = basis.shape
    for k in range(m):
        c[0, k] = np.float32(0)
        c[1, k] = np.float32(0)
    i = 0
    while i + 4 <= n:  # four sensors a pass: the running sums go through memory less often
        w0, w1, w2, w3 = w[i], w[i + 1], w[i + 2], w[i + 3]
        for k in range(m):
            c[0, k] += (w0 * basis[i, 0, k] + w1 * basis[i + 1, 0, k]) + (
                w2 * basis[i + 2, 0, k] + w3 * basis[i + 3, 0, k]
            )
            c[1, k] += (w0 * basis[i, 1, k] + w1 * basis[i + 1, 1, k]) + (
                w2 * basis[i + 2, 1, k] + w3 * basis[i + 3, 1, k]
            )
        i += 4
    while i < n:
        for k in range(m):
            c[0, k] += w[i] * basis[i, 0, k]
            c[1, k] += w[i] * basis[i, 1, k]
        i += 1
    for k in range(m):
        c1, c2 = c[0, k], c[1, k]
        m1, m2, p1, p2 = edges[0, k], edges[1, k], edges[2, k], edges[3, k]
        low, high = c1 * m1 + c2 * m2, c1 * p1 + c2 * p2
        along = low if low > high else high
        along = along if along > 0 else np.float32(0)
        left, right = m1 * c2 - m2 * c1, c1 * p2 - c2 * p1
        inside = left if left < right else right
        s[k] = c1 * c1 + c2 * c2 if inside > 0 else along * along


@compiled()
def between(c, shapes, mu, low, high, s):
    """The same where the normal force is to lie in low <= N <= high, from what `scan` left in c; into s (m,).

    shapes (3, m): the length of A's first column, and the second column in the basis.
    """
    for k in range(s.size):
        if not s[k] > 0:
            continue  # it can only become less
        size, along, across = shapes[0, k], shapes[1, k], shapes[2, k]
        b1, b2 = size * c[0, k], along * c[0, k] + across * c[1, k]
        square = along * along + across * across
        height = eliminate_two(size * size, size * along, square, b1, b2, mu, low, high)[2]
        s[k] = np.float32(max(height, 0.0))


@compiled()
def peaks(s, first, step, words, peak, score, at):
    """Maxima of S along a line of equal steps, the best first, FEW at most: their number.

    s (m + 2,), whose ends are -1; words (at least m / 8,) and peak, the same as bytes: scratch; score and at: the
    height of the parabola through a maximum and its neighbours, and its position.
    """
    m = s.size - 2
    for k in range(m):
        peak[k] = (s[k + 1] > s[k]) & (s[k + 1] >= s[k + 2])
    count = 0
    for word in range(words.size):
        if words[word] == 0:
            continue
        for k in range(8 * word, min(8 * word + 8, m)):
            if peak[k] == 0 or not s[k + 1] > 0:
                continue
            left, here, right = s[k], s[k + 1], s[k + 2]
            shift, height = 0.0, float(here)
            if left >= 0 and right >= 0:
                shift = 0.5 * (left - right) / (left - 2 * here + right)
                height = here - 0.25 * (left - right) * shift
            count = _ranked(height, first + (k + shift) * step, 0.0, count, FEW, score, at)
    return count


@compiled()
def highest(s, first, step, squares, score, at):
    """The same on a grid of widths and positions, s (widths, m): nodes above their eight neighbours, as they stand."""
    rows, m = s.shape
    count = 0
    for j in range(rows):
        for k in range(m):
            here = s[j, k]
            if not here > 0.0 or (k > 0 and s[j, k - 1] >= here) or (k + 1 < m and s[j, k + 1] > here):
                continue  # most nodes
            top = True
            for dj in range(-1, 2):
                for dk in range(-1, 2):
                    a, b = j + dj, k + dk
                    if (dj != 0 or dk != 0) and 0 <= a < rows and 0 <= b < m:
                        before = dj < 0 or (dj == 0 and dk < 0)
                        top &= not (s[a, b] > here or (before and s[a, b] == here))
            if top:
                count = _ranked(float(here), first + k * step, squares[j], count, score.size, score, at)
    return count


@compiled(inline=True)
def _ranked(height, y, q, count, most, score, at):
    """Put a node among the `most` best, and give back how many there are now."""
    rank = count
    while rank > 0 and score[rank - 1] < height:
        rank -= 1
    if rank < most:
        for e in range(min(count, most - 1), rank, -1):
            score[e] = score[e - 1]
            at[e, 0], at[e, 1] = at[e - 1, 0], at[e - 1, 1]
        score[rank] = height
        at[rank, 0], at[rank, 1] = y, q
        return min(count + 1, most)
    return count
