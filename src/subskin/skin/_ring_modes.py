"""One harmonic n of an annulus bonded to a rigid core: Michell's solution, without loss at any thickness.

Under p = cos(n phi), or q = sin(n phi) towards +phi, the stresses of radius r are built of four terms (docs/skins.md;
Michell 1899). What the core sends back is kept apart from the full disk's share, so that the part which is smooth
even beneath a line load is never a difference. Where the annulus is thin beside the wavelength all four terms are
nearly equal, and the harmonic is carried out from the core instead, by the exponential of the equations in log r.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from .._check import FloatArray

__all__ = ["Ring"]

_THIN = 1.0
"""Below this (n + 1) log(R / Rc) the harmonic is propagated: a power series then loses less than two digits."""

_TERMS = 40
_LOADS = np.eye(2)  # p and q


class _Parts(NamedTuple):
    """srr + stt, X and Y with srr = sum / 2 - X - Y, stt = sum / 2 + X + Y, srt = X - Y; then 2G u_r and 2G u_t."""

    sum: FloatArray
    x: FloatArray
    y: FloatArray
    radial: FloatArray
    along: FloatArray


@dataclass(frozen=True)
class Ring:
    """An annulus core < r < radius of Poisson's ratio `poisson`, held at the core."""

    poisson: float
    radius: float
    core: float

    @property
    def _kappa(self) -> float:
        return 3 - 4 * self.poisson

    @property
    def _eps(self) -> float:
        return self.core / self.radius

    def amplitudes(self, n: FloatArray, depth: FloatArray, remainder: bool = False) -> FloatArray:
        """sigma_x, tau_xy, 2G eps_y, 2G u_x and 2G u_y at depths x = R - r, shape (x, n, 5, 2); last axis p = 1, q = 1.

        x points inwards, so tau_xy = -srt. With `remainder` less the full disk's (`_disk`).
        """
        thin = (n + 1) * np.log(1 / self._eps) < _THIN
        out = np.empty((depth.size, n.size, 5, 2))
        for i, r in enumerate(self.radius - depth):
            disk = self._shown(self._disk(n, r))
            if thin.any():
                out[i, thin] = self._carried(n[thin], r) - remainder * disk[thin]
            if (~thin).any():
                out[i, ~thin] = self._shown(self._echo(n[~thin], r)) + (not remainder) * disk[~thin]
        return out

    def _shown(self, parts: _Parts) -> FloatArray:
        """sigma_x, tau_xy, 2G eps_y, 2G u_x and 2G u_y, by Hooke's law in plane strain: shape (n, 5, 2)."""
        difference = parts.x + parts.y
        radial = 0.5 * parts.sum - difference
        along = 0.5 * (1 - 2 * self.poisson) * parts.sum + difference
        return np.stack([radial, parts.y - parts.x, along, -parts.radial, parts.along], axis=1)

    def _disk(self, n: FloatArray, r: float) -> _Parts:
        """The part of a full disk: where it has a closed form in real space, it is taken from there.

        At n = 0 and n = 1, where a disk has no support, the same formula is no solution; `_echo` makes up for it.
        """
        rho, m = r / self.radius, n[:, None]
        p, q = _LOADS
        power = rho**m
        x = power / rho**2 * (q + 0.5 * m * (q - p) * (rho**2 - 1))
        high = np.where(n > 1, n, 2.0)[:, None]
        a, c = (q - p) / (2 * (high + 1)), (q - 0.5 * high * (q - p)) / (high - 1)
        one, two = r * self._kappa * a * power, -r * power * ((high + 1) * a + c / rho**2)
        moved = (np.where(m > 1, total, 0.0) for total in (one + two, one - two))
        return _Parts(2 * (q - p) * power, x, np.zeros_like(x), *moved)

    def _echo(self, n: FloatArray, r: float) -> _Parts:
        """What the core adds to `_disk`."""
        parts = [np.zeros((n.size, 2)) for _ in range(5)]
        for chosen, solve in ((n > 1, self._high), (n == 1, self._first), (n == 0, self._mean)):
            if chosen.any():
                values = solve(n[chosen], r)
                for part, value in zip(parts, values, strict=True):
                    part[chosen] = value
        return _Parts(*parts)

    def _high(self, n: FloatArray, r: float) -> _Parts:
        m, kappa, eps, rho = n[:, None], self._kappa, self._eps, r / self.radius
        p, q = _LOADS
        # unknowns: g of the disk's kind and b of the core's; rows: srr + srt = q - p and srt = q at the surface
        e = eps ** (2 * m)
        g_y, b_y = -(m + 1) * e * eps**2 * kappa, m * (m - 1) * e / eps**2 - (m + 1) * (m - 1) * e
        g_s, b_s = 2 * (m + 1) - 2 * g_y, -2 * (m - 1) * e / eps**2 - 2 * b_y
        g_t = m * (m + 1) - (m * m - 1) * eps**2 - g_y
        b_t = (m - 1) * kappa - b_y
        det = g_s * b_t - b_s * g_t
        g, b = ((q - p) * b_t - b_s * q) / det, (g_s * q - g_t * (q - p)) / det
        top = g_y * g + b_y * b  # Y at the surface
        extra = ((m - 1) * b * e / eps**2 + top) / (m + 1)  # g less the disk's
        power, back = rho**m, (eps * eps / rho) ** m
        second = b * back / eps**2
        inner = power / rho**2 * (top - m * (m + 1) * extra)
        d = back / rho**2 * (kappa * g * eps**2 + (m - 1) * b)
        one = r * (kappa * extra * power + (m - 1) * second - d)
        two = r * (kappa * second - (m + 1) * extra * power - inner / (m - 1))
        return _Parts(
            4 * ((m + 1) * extra * power - (m - 1) * second),
            m * (m + 1) * extra * power + inner,
            m * (m - 1) * second - (m + 1) * d,
            one + two,
            one - two,
        )

    def _first(self, n: FloatArray, r: float) -> _Parts:
        """N = 1: the load has a resultant, which the core bears; phi = a z^2 + b log z."""
        kappa, core, p, q = self._kappa, self.core, *_LOADS

        def parts(r: float) -> tuple[FloatArray, ...]:
            """Coefficients of a and b in sum, X, Y, A1, A2."""
            d = np.array([kappa * core**4, -(core**2)])
            return (
                np.array([8 * r, 4 / r]),
                np.array([2 * r, -kappa / r]),
                np.array([0.0, -1 / r]) - 2 * d / r**3,
                np.array([kappa * r**2, -1.0]) - d / r**2,
                np.array([-2 * (r**2 - core**2), 2 * kappa * np.log(r / core)]),
            )

        total, x, y, *_ = parts(self.radius)
        ab = np.linalg.solve(np.stack([0.5 * total - x - y, x - y]), np.stack([-p, q]))
        total, x, y, one, two = (np.atleast_2d(c @ ab) for c in parts(r))
        disk = self._disk(n, r)
        return _Parts(total - disk.sum, x - disk.x, y, one + two, one - two)

    def _mean(self, n: FloatArray, r: float) -> _Parts:
        """N = 0: uniform pressure, and a torsion that the core bears."""
        kappa, core, p, q = self._kappa, self.core, *_LOADS
        a = -p / (2 + (kappa - 1) * self._eps**2)
        d = (kappa - 1) * a * core**2
        shear = q * (self.radius / r) ** 2  # 2 X = stt - srr + 2 srt, 2 Y = stt - srr - 2 srt
        disk = self._disk(n, r)
        parts = (
            4 * a - disk.sum[0],
            0.5 * (shear - d / r**2) - disk.x[0],
            -0.5 * (shear + d / r**2),
            (kappa - 1) * a * r - d / r,
            -q * self.radius**2 * (1 / r - r / core**2),
        )
        return _Parts(*(np.atleast_2d(part) for part in parts))

    def _carried(self, n: FloatArray, r: float) -> FloatArray:
        """What `_shown` has, of waves carried out from the core."""
        y = self._propagated(n, r)
        along = (y[:, 0] + n[:, None] * y[:, 1]) / r
        return np.stack([y[:, 2], -y[:, 3], along, -y[:, 0], y[:, 1]], axis=1)

    def _propagated(self, n: FloatArray, r: float) -> FloatArray:
        """2G u_r, 2G u_t, srr and srt at r, shape (n, 4, 2), carried out from the core."""
        surface = self._exponential(n, self.radius)
        scale = np.maximum(n, 1.0)[:, None, None]
        tractions = np.linalg.inv(surface[:, 2:, 2:]) @ (self.radius / scale * np.diag([-1.0, 1.0]))
        y = (surface if r == self.radius else self._exponential(n, r))[:, :, 2:] @ tractions
        y[:, 2:] *= scale / r
        return np.asarray(y)

    def _exponential(self, n: FloatArray, r: float) -> FloatArray:
        """exp(M log(r / core)) of Y = (2G u_r, 2G u_t, r srr / m, r srt / m), m = max(n, 1), shape (n, 4, 4)."""
        nu, m = self.poisson, np.maximum(n, 1.0)
        b, c, e = nu / (1 - nu), (1 - 2 * nu) / (1 - nu), 1 / (1 - nu)
        zero, one = np.zeros(n.size), np.ones(n.size)
        rows = [
            [-b * one, -b * n, c * m, zero],
            [n, one, zero, 2 * m],
            [e / m, e * n / m, b * one, -n],
            [e * n / m, e * n * n / m, b * n, -one],
        ]
        step = np.log(r / self.core) * np.array(rows).transpose(2, 0, 1)
        total = term = np.broadcast_to(np.eye(4), step.shape)
        for k in range(1, _TERMS):
            term = term @ step / k
            total = total + term
        return total
