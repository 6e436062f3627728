"""Residuals that go together: a Gaussian process of them, and the standard errors that it leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen

__all__ = ["Correlated", "Residuals", "correlated", "scatter"]

LENGTHS = np.array([0.25, 0.5, 1.0, 2.0])
"""Lengths tried over which the misfit changes, in depths: a field changes within one, and so does its error."""
_SIZES = np.array([0.0, 0.3, 3.0, 30.0, 300.0, 3000.0])
"""Variances tried of the misfit, of that of the noise."""
_WORTH = 8.0
"""Gain in log likelihood that three more numbers have to bring; of white residuals, in one of a thousand."""
_TELLING = 4.0
"""Spare residuals for each fitted number from which misfit shows: fewer can be white by what the fit took up."""
_MOST = 200
"""Residuals from which the process is estimated, at most; and ten times as many to carry it into the errors."""


@dataclass(frozen=True, eq=False)
class Correlated(Frozen):
    """Covariance of residuals: noise^2 [the same] + the sum over `LENGTHS` of (own^2 [same sensor] + shared^2 w w') k.

    k = exp(-(x - x')^2 / (2 length^2)). `own` is a misfit that each sensor has for itself, `shared` the same function
    of the touch's position relative to the sensor for all of them, as a field of the wrong shape gives it, times the
    weights w; both have one value for each length, shape (4,). On an area the shared one is a function of the distance
    alone, as of every isotropic flat skin under straight loads, and both fall with it as a field does, 1 / (1 + r^2).
    """

    noise: float
    own: FloatArray
    shared: FloatArray

    def misfit(self, a: Residuals, b: Residuals) -> FloatArray:
        """Covariance of the misfit, without the noise, of residuals `a` with `b`, shape (len(a), len(b))."""
        same, weight = a.sensor[:, None] == b.sensor, a.weight[:, None] * b.weight
        out = np.zeros(same.shape)
        if a.at.ndim == 2:
            far, near = (np.linalg.norm(part.at, axis=1) for part in (a, b))
            fall = 1.0 / ((1.0 + far[:, None] ** 2) * (1.0 + near**2))
            square = ((a.at[:, None] - b.at) ** 2).sum(axis=-1)
            apart, through = (far[:, None] - near) ** 2, (far[:, None] + near) ** 2
            for length, own, shared in zip(LENGTHS, self.own, self.shared, strict=True):
                if own:
                    out += own**2 * same * fall * np.exp(-0.5 * square / length**2)
                if shared:  # even in the distance, so that it is smooth above the sensor
                    radial = np.exp(-0.5 * apart / length**2) + np.exp(-0.5 * through / length**2)
                    out += shared**2 * weight * fall * radial
            return out
        square = (a.at[:, None] - b.at) ** 2
        for length, own, shared in zip(LENGTHS, self.own, self.shared, strict=True):
            if own or shared:
                out += np.exp(-0.5 * square / length**2) * (own**2 * same + shared**2 * weight)
        return out

    def variance(self, a: Residuals) -> FloatArray:
        """Of the misfit of residuals `a` on an area, shape (len(a),)."""
        square = (a.at**2).sum(axis=1)
        radial = 1.0 + np.exp(-2.0 * square[:, None] / LENGTHS**2)
        each = (self.own**2 + a.weight[:, None] ** 2 * self.shared**2 * radial).sum(axis=1)
        return np.asarray(each / (1.0 + square) ** 2)


@dataclass(frozen=True)
class Residuals(Frozen):
    """Residuals (k,), each with its sensor, position relative to that [depth], and weight in a shared misfit."""

    value: FloatArray
    sensor: npt.NDArray[np.intp]
    at: FloatArray
    weight: FloatArray

    def __getitem__(self, rows: npt.NDArray[np.intp]) -> Residuals:
        return Residuals(*(getattr(self, name)[rows] for name in ("value", "sensor", "at", "weight")))

    def thinned(self, most: int) -> npt.NDArray[np.intp]:
        """No more than `most` of them, even over the sensors and the positions."""
        order = np.lexsort((*self.at.T, self.sensor) if self.at.ndim == 2 else (self.at, self.sensor))
        return np.asarray(order[:: max(-(-len(order) // most), 1)])


def correlated(residuals: Residuals, jacobian: FloatArray, *, noise_like: bool) -> Correlated | None:
    """The process of the residuals of a fit with this `jacobian` (k, p); None where they are white.

    They are white where no process explains them much better. Where they are few and larger than noise (`noise_like`
    False) the touches cannot say so, and they are misfit. Lengths and sizes are averaged, each with its likelihood.

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
    if free < 2 * len(LENGTHS):
        return None
    # what is left of the residuals in the directions that no parameter takes: white there if they are
    across = np.linalg.qr(q, mode="complete")[0][:, q.shape[1] :]
    left = across.T @ part.value
    sizes = np.array([(own, shared) for own in _SIZES for shared in _SIZES])
    likelihood, scale = np.full((2, len(LENGTHS), len(sizes)), -np.inf)
    # along a row a misfit may have the length of a sensor's width; on an area it is the field's own, which is smooth
    first = int(part.at.ndim == 2)
    for at, unit in enumerate(np.eye(len(LENGTHS))):
        if at < first:
            continue
        kernels = [
            across.T @ Correlated(0.0, *shares).misfit(part, part) @ across
            for shares in ((unit, 0 * unit), (0 * unit, unit))
        ]
        for i, (own, shared) in enumerate(sizes):
            covariance = np.eye(free) + own * kernels[0] + shared * kernels[1]
            likelihood[at, i], scale[at, i] = _likelihood(covariance, left)
    if (noise_like or free >= _TELLING * q.shape[1]) and likelihood.max() < likelihood[first, 0] + _WORTH:
        return None
    share = np.exp(likelihood - likelihood.max())
    share *= np.where(share > 0, scale, 0.0) / share.sum()
    own, shared = np.sqrt(np.einsum("ls,sk->kl", share, sizes))
    return Correlated(float(np.sqrt(share.sum())), own, shared)


def scatter(process: Correlated, residuals: Residuals, jacobian: FloatArray) -> FloatArray:
    """J' C J, shape (p, p), of the covariance C of the residuals: what of it reaches the parameters."""
    rows = residuals.thinned(10 * _MOST)
    part, j = residuals[rows], jacobian[rows]
    share = len(jacobian) / len(rows)
    out = process.noise**2 * jacobian.T @ jacobian
    return np.asarray(out + share**2 * j.T @ process.misfit(part, part) @ j)


def _likelihood(covariance: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Log likelihood up to a constant, at the best scale of the covariance, and that scale."""
    from scipy.linalg import solve_triangular

    root = np.linalg.cholesky(covariance)
    solved = solve_triangular(root, left, lower=True, check_finite=False)
    scale = float(solved @ solved) / left.size
    return -float(np.log(np.diag(root)).sum()) - 0.5 * left.size * np.log(max(scale, 1e-300)), scale
