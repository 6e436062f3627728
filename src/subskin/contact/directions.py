"""A field of three dimensions as the mean over directions of plane fields (docs/local_contacts.md).

The projection of a shape f on the direction phi is P(t); with F = integral of P / (t - Z) dt its Cauchy transform at
Z = y cos phi + z sin phi + i x,

    W_m = -(i^m / 4 pi^2) integral over phi of e^{i m phi} F',    and so on, each derivative along x being i d/dZ.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray

__all__ = ["at_the_surface", "mean_over_directions"]

_GENTLE = ((0.6, 32), (0.3, 64))
"""Directions that half a turn needs where the nearest singularity is so far from the real directions."""

# A stretch of directions is mapped to the whole line, as in `quadrature`: a singularity above its end is pi/2 away.
_STEP = 0.27
_V = _STEP * np.arange(-140, 141)
_SHARE, _REST = 1 / (1 + np.exp(-_V)), 1 / (1 + np.exp(_V))
_WEIGHT = _STEP * _SHARE * _REST
_BLOCK = 1 << 17


class Projection(Protocol):
    """F, F' or F'' of the projections on the directions `phi` at `depth`, shape (k, n), of the k points `chosen`."""

    def __call__(self, phi: FloatArray, depth: ComplexArray, chosen: npt.NDArray[np.intp], /) -> ComplexArray:
        """The transform."""
        ...


def at_the_surface(family: Callable[[FloatArray], ComplexArray], room: FloatArray) -> ComplexArray:
    """A family's slope along x at x = 0 from depths that are small beside the `room` [m] in which it is smooth.

    There the mean over directions runs over poles.
    """
    step = 5e-4 * room
    return np.asarray(sum(share * family(k * step) for k, share in ((1, 4.0), (2, -6.0), (3, 4.0), (4, -1.0))))


def mean_over_directions(
    order: int, x: FloatArray, zeta: ComplexArray, cauchy: Projection, singular: ComplexArray
) -> ComplexArray:
    """`ShapedContact.unit_family` of a shape from its projections.

    Parameters
    ----------
    order : int
        As in `unit_family`; `cauchy` gives F, F' and F'' for -1, 0 and 1.
    x, zeta : ndarray, shape (n,)
        Points [m].
    cauchy : callable
        A `Projection`, of unit load [1/m^(2 + order)].
    singular : ndarray, shape (n, k)
        Directions, complex, where it is singular as seen from each point.
    """
    out = np.empty((3 if order == -1 else 4, x.size), dtype=np.complex128)
    turns = np.where(np.isfinite(singular), singular, 1e3j)
    room = np.abs(turns.imag).min(axis=1)
    left = np.ones(x.size, dtype=bool)
    for least, count in _GENTLE:
        chosen = np.flatnonzero(left & (room >= least))
        left[chosen] = False
        phi = np.pi / count * (np.arange(count) + 0.5)
        _add(out, order, x, zeta, cauchy, chosen, lambda at: (phi[None], np.full((1, phi.size), np.pi / phi.size)))  # noqa: B023
    chosen = np.flatnonzero(left)
    ends = np.sort(np.mod(turns.real, np.pi), axis=1)
    ends = np.concatenate([ends, ends[:, :1] + np.pi], axis=1)

    def graded(at: npt.NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        low, length = ends[at, :-1, None], np.diff(ends[at], axis=1)[..., None]
        phi = np.where(_SHARE < 0.5, low + length * _SHARE, low + length - length * _REST)
        return phi.reshape(at.size, -1), (length * _WEIGHT).reshape(at.size, -1)

    _add(out, order, x, zeta, cauchy, chosen, graded)
    return out


def _add(
    out: ComplexArray,
    order: int,
    x: FloatArray,
    zeta: ComplexArray,
    cauchy: Projection,
    chosen: npt.NDArray[np.intp],
    nodes: Callable[[npt.NDArray[np.intp]], tuple[Any, Any]],
) -> None:
    """Fill the columns `chosen`: half a turn, for the other half mirrors it."""
    if not chosen.size:
        return
    step = max(1, _BLOCK // nodes(chosen[:1])[0].size)
    factor = {-1: 1j, 0: -1.0, 1: -1j}[order] / (4 * np.pi**2)
    for first in range(0, chosen.size, step):
        at = chosen[first : first + step]
        phi, weight = nodes(at)
        depth = np.empty((at.size, phi.shape[1]), dtype=np.complex128)
        e = np.exp(1j * phi)
        depth.real, depth.imag = (np.conj(zeta[at, None]) * e).real, x[at, None]
        g = cauchy(phi, depth, at)
        for m in range(len(out)):
            # F of the direction on the other side is -F*, F' is F'*
            part = g.real if (m % 2 == 0) == (order == 0) else 1j * g.imag
            term = weight * e**m * part
            out[m, at] = 1j**m * 2 * factor * np.where(np.isfinite(term), term, 0.0).sum(axis=1)
