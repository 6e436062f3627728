"""Residuals that go together: a Gaussian process of them, and the standard errors that it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen

__all__ = ["Correlated", "Residuals", "correlated", "scatter"]

_LENGTHS = np.array([0.25, 0.5, 1.0, 2.0])
"""Lengths tried over which the misfit changes, in depths: a field changes within one, and so does its error."""
_SIZES = np.array([0.0, 0.3, 1.0, 3.0, 10.0, 30.0])
"""Variances tried of the misfit, of that of the noise."""
_WORTH = 8.0
"""Gain in log likelihood that three more numbers have to bring; of white residuals, in one of a thousand."""
_MOST = 200
"""Residuals from which the process is estimated, at most; and ten times as many to carry it into the errors."""


@dataclass(frozen=True)
class Correlated:
    """Covariance of residuals, in units of their own: noise^2 [the same] + own^2 k + shared^2 w w' k, k over `length`.

    `own` is a misfit that each sensor has for itself, `shared` the same function of the touch's position relative to
    the sensor for all of them, as a field of the wrong shape gives it, times the weights w.
    """

    noise: float
    own: float
    shared: float
    length: float

    def misfit(self, a: Residuals, b: Residuals) -> FloatArray:
        """Covariance of the misfit, without the noise, of residuals `a` with `b`, shape (len(a), len(b))."""
        near = np.exp(-0.5 * ((a.at[:, None] - b.at) / self.length) ** 2)
        same = a.sensor[:, None] == b.sensor
        return np.asarray(near * (self.own**2 * same + self.shared**2 * a.weight[:, None] * b.weight))


@dataclass(frozen=True)
class Residuals(Frozen):
    """Residuals (k,), each with its sensor, position relative to that [depth] and weight in a shared misfit."""

    value: FloatArray
    sensor: npt.NDArray[np.intp]
    at: FloatArray
    weight: FloatArray

    def __getitem__(self, rows: npt.NDArray[np.intp]) -> Residuals:
        return Residuals(*(getattr(self, name)[rows] for name in ("value", "sensor", "at", "weight")))

    def thinned(self, most: int) -> npt.NDArray[np.intp]:
        """No more than `most` of them, even over the sensors and the positions."""
        order = np.lexsort((self.at, self.sensor))
        return np.asarray(order[:: max(-(-len(order) // most), 1)])


def correlated(residuals: Residuals, jacobian: FloatArray) -> Correlated | None:
    """The process that explains the residuals of a fit with this `jacobian` (k, p) best; None where they are white.

    By restricted maximum likelihood, which allows for what the fitted parameters have taken away: Patterson and
    Thompson, Biometrika 58, 545 (1971). The process for a model's misfit: Kennedy and O'Hagan, J. R. Stat. Soc. B 63,
    425 (2001).
    """
    rows = residuals.thinned(_MOST)
    part, j = residuals[rows], jacobian[rows]
    size = np.linalg.norm(j, axis=0)
    q, r = np.linalg.qr(j[:, size > 0] / size[size > 0])
    q = q[:, np.abs(np.diag(r)) > 1e-8]
    free = len(rows) - q.shape[1]
    if free < 2 * len(_LENGTHS):
        return None
    # what is left of the residuals in the directions that no parameter takes: white there if they are
    across = np.linalg.qr(q, mode="complete")[0][:, q.shape[1] :]
    left = across.T @ part.value
    white = _likelihood(np.eye(free), left)[0]
    best, found = white + _WORTH, None
    for length in _LENGTHS:
        kernels = [
            across.T @ Correlated(0.0, *shares, float(length)).misfit(part, part) @ across
            for shares in ((1.0, 0.0), (0.0, 1.0))
        ]
        for own in _SIZES:
            for shared in _SIZES:
                likelihood, scale = _likelihood(np.eye(free) + own * kernels[0] + shared * kernels[1], left)
                if likelihood > best:
                    sizes = [float(np.sqrt(scale * share)) for share in (1.0, own, shared)]
                    best, found = likelihood, Correlated(sizes[0], sizes[1], sizes[2], float(length))
    return found


def scatter(process: Correlated, residuals: Residuals, jacobian: FloatArray) -> FloatArray:
    """J' C J, shape (p, p), of the covariance C of the residuals: what of it reaches the parameters."""
    rows = residuals.thinned(10 * _MOST)
    part, j = residuals[rows], jacobian[rows]
    share = len(jacobian) / len(rows)
    out = process.noise**2 * jacobian.T @ jacobian
    return np.asarray(out + share**2 * j.T @ process.misfit(part, part) @ j)


def _likelihood(covariance: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Log likelihood up to a constant, at the best scale of the covariance, and that scale."""
    root = np.linalg.cholesky(covariance)
    solved = np.linalg.solve(root, left)
    scale = float(solved @ solved) / left.size
    return -float(np.log(np.diag(root)).sum()) - 0.5 * left.size * np.log(max(scale, 1e-300)), scale
