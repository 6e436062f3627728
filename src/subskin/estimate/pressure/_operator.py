"""The surface in elements: what each makes the sensors read, and what the smoothness prior makes of that."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Frozen
from ...errors import GeometryError, InvalidValueError
from ...finger import Finger
from ...response import Response, tabulate
from .prior import Prior

__all__ = ["COARSE", "Factors", "Surface", "shear_seen"]

COARSE = 3
"""Elements of the surface in one of the coarse surface, from which each search starts."""

_FINEST = 12
_MOST_NODES = 4096
_POINTS = 4


@dataclass(frozen=True, eq=False)
class Surface(Frozen):
    """Hat elements along the surface: a traction that is straight between nodes and 0 at the first and last.

    Parameters
    ----------
    y : ndarray, shape (m + 2,)
        Nodes, of equal distance [m].
    reading : ndarray, shape (m, n, 2)
        Reading per Pa of normal and of tangential traction at each inner node.
    """

    y: FloatArray
    reading: FloatArray

    @property
    def step(self) -> float:
        """Distance of the nodes [m]."""
        return float(self.y[-1] - self.y[0]) / (len(self.y) - 1)

    @classmethod
    def of(cls, finger: Finger, search: tuple[float, float] | None, step: float | None) -> Surface:
        """Cut the search into elements of at most `step` [m], a twelfth of the least depth if left out."""
        table = tabulate(finger, search)
        depth = float(np.asarray(finger.array.depth).min())
        if step is None:
            step = depth / _FINEST
        else:
            step = _check.scalar("step", step, unit="m", above=0.0)
            if step > depth / 4:
                rule = f"elements have to be much finer than the depth, here at most {depth / 4:.6g} m"
                raise InvalidValueError(f"step = {step:.6g} m", rule, "leave out step")
        length = table.stop - table.start
        cells = COARSE * max(int(np.ceil(length / (COARSE * step) * (1 - 1e-12))), 2)
        if cells > _MOST_NODES:
            rule = f"at most {_MOST_NODES} can be solved for"
            fix = "a narrower search or a larger step"
            raise GeometryError(f"{cells} elements of {length / cells:.3g} m", rule, fix)
        y = np.linspace(table.start, table.stop, cells + 1)
        return cls(_check.read_only(y), _check.read_only(_hats(table, y)))


def _hats(table: Response, y: FloatArray) -> FloatArray:
    """Readings per Pa of the hats at the inner nodes, by quadrature of the line loads' table."""
    # the fields are analytic within a depth: four points in an element of a quarter of it leave 1e-9
    t, weight = np.polynomial.legendre.leggauss(_POINTS)
    share, weight = 0.5 * (1 + t), 0.5 * weight * (y[1] - y[0])
    left, right = y[:-1], y[1:]
    rising = falling = np.zeros((len(left), *table.coefficients.shape[2:]))
    for s, w in zip(share, weight, strict=True):
        values = table(left + s * (right - left))
        rising, falling = rising + w * s * values, falling + w * (1 - s) * values
    return np.asarray(rising[:-1] + falling[1:])


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
    prior : Bridge or Membrane
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
