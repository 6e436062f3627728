"""One wavenumber in a stack of flat layers: exact modes of each layer, and antiplane shear across the wave.

Under p = cos(k y), or q = sin(k y), the four amplitudes Y = (u_x, u_y, sigma_x / 2Gk, tau_xy / 2Gk) of a layer obey
dY/ds = A Y in s = k x (equilibrium and Hooke's law; u_x, sigma_x and sigma_y go with cos, u_y and tau_xy with sin).
A has the double eigenvalues -1 and +1, and no singularity at nu = 1/2. Where the whole stack is thin beside the
wavelength the solution is carried up from the base by exp(s A), with the differences that would be lost taken as
series; elsewhere it is split into what decays from the top and what decays from the bottom of each layer, so that
nothing grows (`Joined`).

In antiplane shear (what moves across the direction of the wave) u = D exp(-k s) p and tau = -G k D exp(-k s) m at a
depth s of a layer, with t = thickness - s above its bottom,

    p = P + rho expm1(-2 k t),   m = M - rho expm1(-2 k t),   P + M = 2,   rho = (P - M) / 2.

A rigid base has (M, P) = (2, 0), one without friction (0, 2), a half space (1, 1); from one layer to that above it
M : P = m G_below / G_above : p. All parts are >= 0: nothing cancels, nothing grows (docs/skins.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..material import Material
from ._stack import Joined, Sheet

__all__ = ["Sheet", "Stack", "antiplane"]


def antiplane(stack: Stack, k: FloatArray, x: FloatArray) -> FloatArray:
    """Shear stress tau and displacement G k u under a drag of 1 Pa across the wave, shape (x, k, 2) [Pa].

    G is the shear modulus of the first layer. The first layer's are less what a half space of its material would have:
    c exp(-k x) with c = -1 and 1.

    Parameters
    ----------
    stack : Stack
        The layers.
    k : ndarray, shape (k,)
        Wavenumbers [1/m], > 0.
    x : ndarray, shape (x,)
        Depths [m].
    """
    bottoms: list[FloatArray] = []  # M of each layer, from below
    ratios: list[FloatArray] = []  # D beneath it over D exp(-k thickness)
    one = np.ones_like(k)
    m, p, below = one, one, 0.0 if stack.base is None else stack.base.shear
    for layer in reversed(stack.layers):
        if not layer.bonded:
            low, ratio = 0 * one, 0 * one
        elif stack.base is None and not bottoms:
            low, ratio = 2 * one, 0 * one
        else:
            stiff = below / layer.shear
            ratio = 2 / (stiff * m + p)
            low = stiff * m * ratio
        fall = (1 - low) * np.expm1(-2 * k * layer.thickness)
        m, p, below = low - fall, 2 - low + fall, layer.shear
        bottoms.append(low)
        ratios.append(ratio)
    first, tops, positions = stack.layers[0], stack.tops, stack.positions(x)
    out = np.empty((x.size, k.size, 2))
    size = 1 / m  # D of the first layer; that of a half space is 1
    for j, layer in enumerate(stack.layers):
        low, h = bottoms[-1 - j], layer.thickness
        rho = 1 - low
        for i in np.flatnonzero(positions == j):
            s = x[i] - tops[j]
            echo = np.exp(-2 * k * (h - s))
            if j == 0:
                share = rho * np.exp(-k * s) * size
                out[i, :, 0] = -share * echo * np.expm1(-2 * k * s)
                out[i, :, 1] = share * (echo + np.exp(-2 * k * h))
            else:
                here, fall = size * np.exp(-k * s), rho * np.expm1(-2 * k * (h - s))
                out[i, :, 0] = -here * (low - fall) * layer.shear / first.shear
                out[i, :, 1] = here * (2 - low + fall)
        size = size * np.exp(-k * h) * ratios[-1 - j]
    for i in np.flatnonzero(positions == len(stack.layers)):
        here = size * np.exp(-k * (x[i] - tops[-1]))
        stiff = 0.0 if stack.base is None else stack.base.shear / first.shear
        out[i] = np.stack([-stiff * here, here], axis=-1)
    return out


_THIN = 2.0
"""Below this k H the stack is propagated: exp(2 k H) is then still a small loss, above it the modes lose none."""

_FLIP = np.diag([-1.0, 1.0, 1.0, -1.0])
_SHIFT = np.array([[1.0, -1.0], [1.0, -1.0]])  # A + 1 on the modes that decay, in terms of their tractions
_RISING = np.array([[1.0, 1.0], [-1.0, -1.0]])  # the same of those that decay upwards


def decaying(poisson: float) -> FloatArray:
    """Amplitudes of the half plane under unit tractions sigma_x / 2Gk and tau_xy / 2Gk, shape (4, 2)."""
    n, m = 1 - 2 * poisson, 2 * (1 - poisson)
    return np.array([[-m, n], [n, -m], [1.0, 0.0], [0.0, 1.0]])


def generator(poisson: float) -> FloatArray:
    """The matrix A of dY/ds = A Y."""
    b, c, e = poisson / (1 - poisson), (1 - 2 * poisson) / (1 - poisson), 1 / (1 - poisson)
    return np.array([[0, -b, c, 0], [1, 0, 0, 2], [0, 0, 0, -1], [0, e, b, 0]], dtype=np.float64)


def decay(s: FloatArray, shift: FloatArray = _SHIFT) -> FloatArray:
    """exp(s A) on the modes that decay, in terms of their tractions: exp(-s) (1 + s SHIFT), shape (..., 2, 2)."""
    s = s[..., None, None]
    return np.asarray(np.exp(-s) * (np.eye(2) + s * shift))


def propagator(poisson: float, s: FloatArray) -> FloatArray:
    """exp(-s A), which carries the amplitudes up by s = k x, shape (..., 4, 4)."""
    a = generator(poisson)
    b = a @ a - np.eye(4)  # b b = 0, for the eigenvalues are double
    small = s < 0.4
    square = s * s
    tail = 1 + square / 54 * (1 + square / 88 * (1 + square / 130))
    series = s**3 / 6 * (1 + square / 10 * (1 + square / 28 * tail))
    half_difference = np.where(small, series, 0.5 * (s * np.cosh(s) - np.sinh(s)))  # lost by cancellation at small s
    even, odd = np.cosh(s), np.sinh(s)
    factors = [even, -odd, 0.5 * s * odd, -half_difference]
    return np.asarray(sum(f[..., None, None] * m for f, m in zip(factors, (np.eye(4), a, b, a @ b), strict=True)))


@dataclass(frozen=True)
class Stack(Joined):
    """Layers from the surface down on a rigid base (None) or on a half plane."""

    layers: tuple[Sheet, ...]
    base: Material | None

    def amplitudes(self, k: FloatArray, x: FloatArray, remainder: bool = False) -> FloatArray:
        """Amplitudes at the depths x under p = 1 and under q = 1 (last axis), shape (x, k, 4, 2): u, u, Pa, Pa.

        u is times 2G of the first layer [Pa m]. With `remainder`, the first layer's are less what a half plane of its
        material would have: the part that is smooth even beneath a line load.
        """
        out = self._solved(k, x, remainder)
        # amplitudes stand for sigma_x = -p, tau_xy = -q at the surface, over 2 G k of the first layer
        out[:, :, :2] /= k[:, None, None]
        return out

    def _thin(self, k: FloatArray) -> npt.NDArray[np.bool_]:
        return np.asarray(k * self.tops[-1] < _THIN)

    def _base(self, k: FloatArray) -> tuple[Sheet, FloatArray]:
        if self.base is None:
            return super()._base(k)
        return Sheet(self.base.poisson, self.base.shear, np.inf, True), decaying(self.base.poisson)

    def _down(self, layer: Sheet, k: FloatArray) -> FloatArray:
        return decaying(layer.poisson)

    def _up(self, layer: Sheet, k: FloatArray) -> FloatArray:
        return np.asarray(_FLIP @ decaying(layer.poisson) @ _FLIP[2:, 2:])

    def _fall(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        return decay(k * (bottom - top))

    def _rise(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        return decay(k * (bottom - top), _RISING)

    def _carried(self, layer: Sheet, k: FloatArray, top: float, bottom: float) -> FloatArray:
        return propagator(layer.poisson, k * (bottom - top))
