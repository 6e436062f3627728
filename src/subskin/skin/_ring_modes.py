"""One harmonic n of rings bonded to each other on a rigid core: exact modes of each ring.

Under p = cos(n phi), or q = sin(n phi), the amplitudes Y = (u_x, u_y, sigma_x, tau_xy) of the radius r, the tractions
times r / (2G m) with m = max(n, 1), obey dY/dt = -M Y in t = log(R / r), M constant, with the eigenvalues n + 1, n - 1,
1 - n and -n - 1 (Michell 1899; docs/skins.md). Where n >= 2, u_y +- u_x and tau_xy -+ sigma_x fall apart into pairs, so
that nothing is lost where the eigenvalues are nearly equal. A solid disk has no support at n = 0 and 1, which are
carried up from the core.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ._stack import Joined, Sheet

__all__ = ["Ring"]

_THIN = 1.0
"""Below this n log(R / core) the harmonic is carried up from the core."""

_PAIR = np.array([[1.0, -1.0], [-1.0, -1.0]])
"""sigma_x - tau_xy and -sigma_x - tau_xy of (sigma_x, tau_xy); its square is 2."""

_TERMS = 9
_SIGNS = np.diag([-1.0, 1.0, 1.0, -1.0])  # from u_r, u_t, srr, srt to u_x, u_y, sigma_x, tau_xy


@dataclass(frozen=True)
class Ring(Joined):
    """Rings from the surface, of a `radius`, down to a rigid core."""

    layers: tuple[Sheet, ...]
    radius: float

    def amplitudes(self, n: FloatArray, depth: FloatArray, remainder: bool = False) -> FloatArray:
        """sigma_x, tau_xy, 2G eps_y, 2G u_x and 2G u_y at depths x = R - r, shape (x, n, 5, 2); last axis p = 1, q = 1.

        G is that of the first layer. With `remainder`, the first layer's are less those of a full disk, `_disk`.
        """
        m, r = np.maximum(n, 1.0)[:, None, None], (self.radius - depth)[:, None, None]
        y = self._solved(n, depth, remainder)
        y[:, :, :2] *= self.radius / m
        y[:, :, 2:] *= self.radius / r[..., None]
        along = (n[:, None] * y[:, :, 1] - y[:, :, 0]) / r
        few = n < 2
        if remainder and few.any():
            top = self.positions(depth) == 0
            along[np.ix_(top, few)] -= self._stretch(n[few, None], 1 - depth[top, None, None] / self.radius)
        return np.stack([y[:, :, 2], y[:, :, 3], along, y[:, :, 0], y[:, :, 1]], axis=2)

    def _stretch(self, n: FloatArray, rho: FloatArray) -> FloatArray:
        """2G eps_y that a full disk's closed form in real space has at n = 0 and 1, where it is no solution."""
        p, q = np.eye(2)
        mean = (1 - 2 * self.layers[0].poisson) * (q - p) * rho**n
        return mean + rho ** (n - 2) * (q + 0.5 * n * (q - p) * (rho**2 - 1))

    def _thin(self, k: FloatArray) -> npt.NDArray[np.bool_]:
        return np.asarray((k < 2) | (k * self._apart(0.0, self.tops[-1]) < _THIN))

    def _apart(self, top: float, bottom: float) -> float:
        """log(r / r') of two depths."""
        return float(np.log1p((bottom - top) / (self.radius - bottom)))

    def _sticks(self, upper: Sheet, k: FloatArray) -> npt.NDArray[np.bool_]:
        # nothing else could hold a ring that is turned
        return np.asarray(super()._sticks(upper, k) | (k == 0))

    def _down(self, layer: Sheet, k: FloatArray) -> FloatArray:
        n = np.maximum(k, 2.0)
        sides = _sides((3 - 4 * layer.poisson) / (n + 1), 1 / (n - 1), n)
        sides[k < 2, :2] = 0.0  # of these only the tractions are asked for
        return sides

    def _up(self, layer: Sheet, k: FloatArray) -> FloatArray:
        return _sides(-1 / (k + 1), -(3 - 4 * layer.poisson) / (k - 1), k)

    def _fall(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        t = self._apart(top, bottom)
        slow = np.exp(-(k - 1) * t)
        change = (k - 1) * slow * np.expm1(-2 * t)
        return _paired(slow * np.exp(-2 * t), np.zeros_like(k), change, slow)

    def _rise(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        t = self._apart(top, bottom)
        slow = np.exp(-(k - 1) * t)
        change = (k + 1) * slow * np.expm1(-2 * t)
        return _paired(slow * np.exp(-2 * t), change, np.zeros_like(k), slow)

    def _carried(self, layer: Sheet, k: FloatArray, top: float, bottom: float) -> FloatArray:
        """exp(M t), M M having the eigenvalues (n + 1)^2 and (n - 1)^2: a polynomial in M of the third degree."""
        t, n = self._apart(top, bottom), k
        a = _generator(layer.poisson, n)
        b = a @ a - (n * n + 1)[:, None, None] * np.eye(4)
        share = np.where(n > 0, np.sinh(n * t) / np.where(n > 0, 2 * n, 1.0), 0.5 * t) * np.sinh(t)
        mean, difference = _sines(n, t)
        factors = np.cosh(n * t) * np.cosh(t), share, mean, difference
        return np.asarray(sum(f[:, None, None] * m for f, m in zip(factors, (np.eye(4), b, a, a @ b), strict=True)))


def _sides(plus: FloatArray, minus: FloatArray, n: FloatArray) -> FloatArray:
    """Amplitudes of modes whose u_y -+ u_x are `plus` and `minus` times n and their tractions, shape (n, 4, 2)."""
    straight, across = -0.5 * n * (plus + minus), 0.5 * n * (plus - minus)
    one, none = np.ones_like(n), np.zeros_like(n)
    rows = [[straight, across], [across, straight], [one, none], [none, one]]
    return np.array(rows).transpose(2, 0, 1)


def _paired(*entries: FloatArray) -> FloatArray:
    """A matrix of sigma_x - tau_xy and -sigma_x - tau_xy, as one of tractions, shape (n, 2, 2)."""
    return np.asarray(0.5 * _PAIR @ np.stack(entries, axis=-1).reshape(-1, 2, 2) @ _PAIR)


def _generator(poisson: float, n: FloatArray) -> FloatArray:
    """The matrix M, shape (n, 4, 4): equilibrium and Hooke's law in plane strain."""
    b, c, e = poisson / (1 - poisson), (1 - 2 * poisson) / (1 - poisson), 1 / (1 - poisson)
    m, zero, one = np.maximum(n, 1.0), np.zeros_like(n), np.ones_like(n)
    rows = [
        [-b * one, -b * n, c * m, zero],
        [n, one, zero, 2 * m],
        [e / m, e * n / m, b * one, -n],
        [e * n / m, e * n * n / m, b * n, -one],
    ]
    return np.asarray(_SIGNS @ np.array(rows).transpose(2, 0, 1) @ _SIGNS)


def _sines(n: FloatArray, t: float) -> tuple[FloatArray, FloatArray]:
    """Mean of sinh(l t) / l for l = n + 1 and n - 1, and their difference over 4 n, at small t by its series."""
    more, less = n + 1, np.where(n == 1, 1.0, np.abs(n - 1))
    high, low = np.sinh(more * t) / more, np.where(n == 1, t, np.sinh(less * t) / less)
    square, fewer = (n + 1) ** 2, (n - 1) ** 2
    size, ratio = t**3 / 6, np.ones_like(n)  # (square^j - fewer^j) / (square - fewer)
    series = size * ratio
    for j in range(2, _TERMS):
        size *= t * t / (2 * j * (2 * j + 1))
        ratio = square * ratio + fewer ** (j - 1)
        series = series + size * ratio
    direct = (high - low) / np.where(n > 0, 4 * n, 1.0)
    return 0.5 * (high + low), np.where(more * t < 1.0, series, direct)
