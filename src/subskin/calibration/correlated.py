"""Residuals that go together: a Gaussian process of them, and the standard errors that it leaves."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

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
USUAL = np.array([0.02, 0.05, 0.02, 1.0])
"""Tolerances without further knowledge: sensors' positions and depths, as `calibrate_blind` has them; loads; levels."""
_FACTOR = np.log(2.0)
"""Standard deviation of the logarithm of a tolerance: it is known to a factor of two."""
_OWN, _ALIKE = 0.2, 2.0
"""Share of a depth's variance that is the sensor's own; the rest is the skin's thickness, alike within these depths."""
_TRIED, _SETTLED, _ROUNDS = np.array([0.1, 0.3, 1.0, 3.0, 10.0]), 0.1, 6
"""Variances tried of a tolerance, of the last; gain in log likelihood with which the search ends; rounds at most."""


@dataclass(frozen=True, eq=False)
class Correlated(Frozen):
    """Covariance of residuals: noise^2 [the same] + the sum over `LENGTHS` of (own^2 [same sensor] + shared^2 w w') k.

    k = exp(-(x - x')^2 / (2 length^2)). `own` is a misfit that each sensor has for itself, `shared` the same function
    of the touch's position relative to the sensor for all of them, as a field of the wrong shape gives it, times the
    weights w; both have one value for each length, shape (4,). On an area the shared one is a function of the distance
    alone, as of every isotropic flat skin under straight loads, and both fall with it as a field does, 1 / (1 + r^2).

    On an area `tolerances` are the standard deviations of a sensor's y and z and of its depth [depth], of the load of a
    touch [of the load] and of its level, an error that all sensors have in common [stated noise]: to first order each
    changes readings by the `slopes` of the residuals. Those of a sensor are misfit, the same for every touch; what is a
    touch's own is error. Sensors near each other are off in depth alike, as a skin is whose thickness changes slowly.
    """

    noise: float
    own: FloatArray
    shared: FloatArray
    tolerances: FloatArray = field(default_factory=lambda: np.zeros(4))

    def misfit(self, a: Residuals, b: Residuals) -> FloatArray:
        """Covariance of the misfit, without the noise, of residuals `a` with `b`, shape (len(a), len(b))."""
        same, weight = a.sensor[:, None] == b.sensor, a.weight[:, None] * b.weight
        out = np.zeros(same.shape)
        if a.at.ndim == 2:
            far, near = (np.linalg.norm(part.at, axis=1) for part in (a, b))
            fall = 1.0 / ((1.0 + far[:, None] ** 2) * (1.0 + near**2))
            square = _apart2(a.at, b.at)
            apart, through = (far[:, None] - near) ** 2, (far[:, None] + near) ** 2
            for length, own, shared in zip(LENGTHS, self.own, self.shared, strict=True):
                if own:
                    out += own**2 * same * fall * np.exp(-0.5 * square / length**2)
                if shared:  # even in the distance, so that it is smooth above the sensor
                    radial = np.exp(-0.5 * apart / length**2) + np.exp(-0.5 * through / length**2)
                    out += shared**2 * weight * fall * radial
            position, depth = self.tolerances[:2] ** 2
            out += same * (position * (a.slopes[:, :2] @ b.slopes[:, :2].T))
            if depth:
                alike = _OWN * same + (1.0 - _OWN) * np.exp(-0.5 * _apart2(a.base, b.base) / _ALIKE**2)
                out += depth * alike * (a.slopes[:, 2, None] * b.slopes[:, 2])
            return np.asarray(out)
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
        return np.asarray(each / (1.0 + square) ** 2 + a.slopes**2 @ self._of_sensor)

    def of_touches(self, a: Residuals) -> FloatArray:
        """Covariance of what loads and levels that are off make of residuals `a`, shape (len(a), len(a))."""
        own = self.tolerances[2:] * a.slopes[:, 3:]
        return np.asarray((a.touch[:, None] == a.touch) * (own @ own.T))

    @property
    def _of_sensor(self) -> FloatArray:
        """Variances of a sensor's position and depth, by the columns of the slopes."""
        position, depth = self.tolerances[:2] ** 2
        return np.array([position, position, depth, 0.0, 0.0])


@dataclass(frozen=True)
class Residuals(Frozen):
    """Residuals (k,), each with its sensor, position relative to that [depth], and weight in a shared misfit.

    With the touch of each; `slopes` (k, 5), its change with the sensor's y, z and depth [1/depth], with the load, and
    with the level [1/stated noise]; and the `base`, the position of its sensor [depth].
    """

    value: FloatArray
    sensor: npt.NDArray[np.intp]
    at: FloatArray
    weight: FloatArray
    touch: npt.NDArray[np.intp]
    slopes: FloatArray
    base: FloatArray

    def __getitem__(self, rows: npt.NDArray[np.intp]) -> Residuals:
        return Residuals(*(getattr(self, part.name)[rows] for part in fields(self)))

    def thinned(self, most: int) -> npt.NDArray[np.intp]:
        """No more than `most` of them, even over the sensors and the positions."""
        order = np.lexsort((*self.at.T, self.sensor) if self.at.ndim == 2 else (self.at, self.sensor))
        return np.asarray(order[:: max(-(-len(order) // most), 1)])


def correlated(residuals: Residuals, jacobian: FloatArray, *, noise_like: bool) -> Correlated | None:
    """The process of the residuals of a fit with this `jacobian` (k, p); None where they are white.

    They are white where no process explains them much better. Where they are few and larger than noise (`noise_like`
    False) the touches cannot say so, and they are misfit. Lengths and sizes are averaged, each with its likelihood;
    tolerances are the likeliest, with what is known of them beforehand.

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
    enough = noise_like or free >= _TELLING * q.shape[1]
    # hundreds of small matrices: threads gain nothing, and wait for each other where other programs keep the cores busy
    with threadpool_limits(limits=1, user_api="blas"):
        return _Search(part, across).likeliest(_WORTH if enough else -np.inf)


class _Search:
    """Likelihoods of the residuals `part` in the directions `across` (k, free), over the process's numbers."""

    def __init__(self, part: Residuals, across: FloatArray) -> None:
        self.part, self.across, self.left = part, across, across.T @ part.value
        self.sizes = np.array([(own, shared) for own in _SIZES for shared in _SIZES])
        # along a row a misfit may have the length of a sensor's width; on an area it is the smooth field's own
        self.first = int(part.at.ndim == 2)
        self.kernels = [
            [
                across.T @ Correlated(0.0, *shares).misfit(part, part) @ across
                for shares in ((unit, 0 * unit), (0 * unit, unit))
            ]
            for unit in np.eye(len(LENGTHS))[self.first :]
        ]

    def likeliest(self, worth: float) -> Correlated | None:
        """The process, averaged over lengths and sizes; None where it gains less than `worth` over white residuals."""
        likelihood, scale = self.over_sizes(np.eye(len(self.left)))
        if likelihood.max() < likelihood[self.first, 0] + worth:
            return None
        tolerances = np.zeros(4)
        if self.part.at.ndim == 2:
            likelihood, scale, tolerances = self.over_tolerances(likelihood, scale)
        share = np.exp(likelihood - likelihood.max())
        share *= np.where(share > 0, scale, 0.0) / share.sum()
        own, shared = np.sqrt(np.einsum("ls,sk->kl", share, self.sizes))
        noise = float(np.sqrt(share.sum()))
        return Correlated(noise, own, shared, noise * tolerances)

    def over_sizes(self, base: FloatArray) -> tuple[FloatArray, FloatArray]:
        """For each length and pair of `sizes`, all on a covariance `base` (free, free): log likelihood, and scale."""
        likelihood, scale = np.full((2, len(LENGTHS), len(self.sizes)), -np.inf)
        for at, (own, shared) in enumerate(self.kernels, self.first):
            for i, (a, b) in enumerate(self.sizes):
                likelihood[at, i], scale[at, i] = _likelihood(base + a * own + b * shared, self.left)
        return likelihood, scale

    def over_tolerances(self, likelihood: FloatArray, scale: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The same at the likeliest tolerances (4,), and these over the noise; from the likelihoods without them."""
        zero, part = np.zeros(len(LENGTHS)), self.part
        each = [Correlated(0.0, zero, zero, unit) for unit in np.eye(4)]
        kernels = [one.misfit(part, part) + one.of_touches(part) for one in each]
        kernels = [self.across.T @ kernel @ self.across for kernel in kernels]
        best = np.unravel_index(np.argmax(likelihood), likelihood.shape)
        variances, top = USUAL**2 / scale[best], -np.inf  # over that of the noise
        for _ in range(_ROUNDS):
            likelihood, scale = self.over_sizes(
                np.eye(len(self.left)) + sum(v * k for v, k in zip(variances, kernels, strict=True))
            )
            likelihood = likelihood - _unusual(variances, scale)
            best = np.unravel_index(np.argmax(likelihood), likelihood.shape)
            if likelihood[best] < top + _SETTLED:
                break
            top = likelihood[best]
            own, shared = self.kernels[best[0] - self.first]
            a, b = self.sizes[best[1]]
            for k, kernel in enumerate(kernels):
                others = (v * o for m, (v, o) in enumerate(zip(variances, kernels, strict=True)) if m != k)
                base = np.eye(len(self.left)) + a * own + b * shared + sum(others)
                tried = np.tile(variances, (_TRIED.size, 1))
                tried[:, k] *= _TRIED
                found = [(*_likelihood(base + one[k] * kernel, self.left), one) for one in tried]
                values = [value - _unusual(one, np.array(size)) for value, size, one in found]
                variances = tried[int(np.argmax(values))]
        return likelihood, scale, np.sqrt(variances)


def _apart2(a: FloatArray, b: FloatArray) -> FloatArray:
    """Squares of the distances of positions (k, 2) from others (m, 2), shape (k, m)."""
    return np.asarray(np.subtract.outer(a[:, 0], b[:, 0]) ** 2 + np.subtract.outer(a[:, 1], b[:, 1]) ** 2)


def _unusual(variances: FloatArray, scale: FloatArray) -> FloatArray:
    """Minus the log prior of tolerances with these `variances` (4,) over the noise's, which is the `scale` (...)."""
    size = 0.5 * np.log(variances * np.maximum(scale, 1e-300)[..., None])
    return np.asarray((0.5 * ((size - np.log(USUAL)) / _FACTOR) ** 2).sum(axis=-1))


def scatter(process: Correlated, residuals: Residuals, jacobian: FloatArray) -> FloatArray:
    """J' C J, shape (p, p), of the covariance C of the residuals: what of it reaches the parameters."""
    rows = residuals.thinned(10 * _MOST)
    part, j = residuals[rows], jacobian[rows]
    share = len(jacobian) / len(rows)
    out = process.noise**2 * jacobian.T @ jacobian
    return np.asarray(out + share**2 * j.T @ (process.misfit(part, part) + process.of_touches(part)) @ j)


def _likelihood(covariance: FloatArray, left: FloatArray) -> tuple[float, float]:
    """Log likelihood up to a constant, at the best scale of the covariance, and that scale."""
    from scipy.linalg import solve_triangular

    root = np.linalg.cholesky(covariance)
    solved = solve_triangular(root, left, lower=True, check_finite=False)
    scale = float(solved @ solved) / left.size
    return -float(np.log(np.diag(root)).sum()) - 0.5 * left.size * np.log(max(scale, 1e-300)), scale
