"""What the smoothness prior makes of the readings of elements."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..._check import FloatArray
from ..._frozen import Frozen
from .prior import Prior

__all__ = ["Factors", "shear_seen"]


@dataclass(frozen=True, eq=False)
class Factors(Frozen):
    """The generalised singular system of sensors and smoothness: all that a weight w is found and judged with.

    With whitened columns A and the covariance C of `covariance`, A C A^T = U S^2 U^T and V = C A^T U. The smoothest
    p for readings b is V (S^2 + w)^-1 U^T b, its resolution V (S^2 + w)^-1 U^T A, its variance
    (C_jj - sum_i V_ji^2 / (S_i^2 + w)) / w.

    Parameters
    ----------
    basis, squares : ndarray, shapes (n, n) and (n,)
        U^T and S^2.
    shapes, spread : ndarray, shapes (m, n) and (m,)
        V and the diagonal of C; where the shear is free, its rows below.
    columns : ndarray, shape (m, n)
        A, row by row.
    prior : Prior
        C.
    """

    basis: FloatArray
    squares: FloatArray
    shapes: FloatArray
    spread: FloatArray
    columns: FloatArray
    prior: Prior
    _widths: dict[int, FloatArray] = field(default_factory=dict)

    @classmethod
    def of(cls, parts: list[FloatArray], prior: Prior) -> Factors:
        """Of independent tractions, one to three, each with columns of shape (m, n)."""
        spread = [prior.applied(part) for part in parts]
        gram = sum(part.T @ wide for part, wide in zip(parts, spread, strict=True))
        squares, vectors = np.linalg.eigh(gram)
        shapes = np.concatenate([wide @ vectors for wide in spread])
        diagonal = np.tile(prior.variance, len(parts))
        return cls(vectors.T.copy(), np.maximum(squares, 0.0), shapes, diagonal, np.concatenate(parts), prior)

    def resolution(self, weight: float, count: int, which: slice) -> FloatArray:
        """Columns of the resolution matrix: what a pressure at each node of `which` alone looks like, (count, k)."""
        return (self.shapes[:count] / (self.squares + weight)) @ (self.basis @ self.columns[:count][which].T)

    def seen(self, weight: FloatArray, count: int) -> FloatArray:
        """What is left at each of `count` nodes of an even pressure of 1, shape (..., count)."""
        even = self.basis @ self.columns[:count].sum(axis=0)
        return np.asarray((even / (self.squares + weight[..., None])) @ self.shapes[:count].T)

    def std(self, weight: FloatArray) -> FloatArray:
        """Standard deviations of the heights by noise and by what smoothness leaves open [Pa], shape (..., rows)."""
        known = (1 / (self.squares + weight[..., None])) @ (self.shapes**2).T
        return np.asarray(np.sqrt(np.maximum(self.spread - known, 0.0) / weight[..., None]))

    def widths(self, weight: FloatArray, count: int) -> FloatArray:
        """Full width at half height of what a narrow pressure at each node looks like [m], shape (..., count)."""
        # smooth in the weight's logarithm: read off between steps of a quarter of it
        at = 4 * np.log(weight / self.squares[-1])
        low = np.floor(at).astype(int)
        out = np.empty((*weight.shape, count))
        for k in np.unique(low):
            chosen = low == k
            share = (at[chosen] - k)[:, None]
            out[chosen] = (1 - share) * self._width(k, count) + share * self._width(k + 1, count)
        return out

    def _width(self, k: int, count: int) -> FloatArray:
        if k not in self._widths:
            weight = float(self.squares[-1] * np.exp(0.25 * k))
            self._widths[k] = self.prior.widths(partial(self.resolution, weight, count))
        return self._widths[k]


def shear_seen(pressure: FloatArray, *drags: FloatArray, prior: Prior, above: float) -> float:
    """Share of a drag's components that the sensors still see where the pressure, and any other drag, are unknown too.

    Degrees of freedom that a contact shows with readings so many times `above` the noise, down to this part of the
    largest singular value: (those of all - those of all but this drag) / those of this drag; of two drags the less.

    Sensors of one kind in one depth read one function of the position. At each wavelength that is one equation for two
    unknowns, and only what the pressure leaves dark remains, some hundredths. Two functions leave a share of 0.3 to
    0.5. On an area three are needed.
    """
    tractions = (pressure, *drags)
    largest = max(float(np.abs(field).max(initial=0.0)) for field in tractions) or 1.0  # only ratios count
    grams = [part.T @ prior.applied(part) for part in (field / largest for field in tractions)]
    if not all(np.trace(gram) > 0 for gram in grams[1:]):
        return 0.0
    level = above**-2 * float(np.linalg.eigvalsh(np.sum(grams, axis=0)).max())

    def freedom(some: list[FloatArray]) -> float:
        squares = np.maximum(np.linalg.eigvalsh(np.sum(some, axis=0)), 0.0)
        return float((squares / (squares + level)).sum())

    whole = freedom(grams)
    each = ((whole - freedom(grams[:i] + grams[i + 1 :])) / freedom([grams[i]]) for i in range(1, len(grams)))
    return min(each)
