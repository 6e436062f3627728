"""Functions of a distance as pieces of Chebyshev polynomials."""

from __future__ import annotations

import numpy as np

from .._check import FloatArray

__all__ = ["NODES", "ORDER", "TAIL", "TO_TERMS", "polynomials"]

ORDER = 32
"""Terms of a piece."""
NODES = np.cos(np.pi * (np.arange(ORDER) + 0.5) / ORDER)
TO_TERMS = np.cos(np.pi * np.arange(ORDER)[:, None] * (np.arange(ORDER) + 0.5) / ORDER) * 2 / ORDER
TO_TERMS[0] /= 2
TAIL = 1e-14
"""Last terms, beside the size of what was summed, with which a piece is fine enough."""
_BLOCK = 2048


def polynomials(terms: FloatArray, t: FloatArray) -> FloatArray:
    """Sums of Chebyshev polynomials at t, shape (columns of `terms`, n)."""
    out, rows = np.empty((terms.shape[1], t.size)), np.empty((ORDER, min(t.size, _BLOCK)))
    for first in range(0, t.size, _BLOCK):
        part = slice(first, first + _BLOCK)
        at = t[part]
        basis = rows[:, : at.size]
        basis[0], basis[1] = 1.0, at
        for n in range(2, ORDER):
            np.multiply(2 * at, basis[n - 1], out=basis[n])
            basis[n] -= basis[n - 2]
        out[:, part] = terms.T @ basis
    return out
