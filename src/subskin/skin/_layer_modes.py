"""One wavenumber in a stack of layers: exact modes of each layer, joined without loss at any thickness.

Under p = cos(k y), or q = sin(k y), the four amplitudes Y = (u_x, u_y, sigma_x / 2Gk, tau_xy / 2Gk) of a layer obey
dY/ds = A Y in s = k x (equilibrium and Hooke's law; u_x, sigma_x and sigma_y go with cos, u_y and tau_xy with sin).
A has the double eigenvalues -1 and +1, and no singularity at nu = 1/2. Where the whole stack is thin beside the
wavelength the solution is carried up from the base by exp(s A), with the differences that would be lost taken as
series; elsewhere it is split into what decays from the top and what decays from the bottom of each layer, so that
nothing grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..material import Material

__all__ = ["Sheet", "Stack"]

_THIN = 2.0
"""Below this k H the stack is propagated: exp(2 k H) is then still a small loss, above it the modes lose none."""

_FLIP = np.diag([-1.0, 1.0, 1.0, -1.0])
_SHIFT = np.array([[1.0, -1.0], [1.0, -1.0]])  # A + 1 on the modes that decay, in terms of their tractions


class Sheet(NamedTuple):
    """What the modes need of a layer: Poisson's ratio, shear modulus [Pa], thickness [m], whether it sticks below."""

    poisson: float
    shear: float
    thickness: float
    bonded: bool

    @property
    def decaying(self) -> FloatArray:
        """Amplitudes of the half plane under unit tractions sigma_x / 2Gk and tau_xy / 2Gk, shape (4, 2)."""
        n, m = 1 - 2 * self.poisson, 2 * (1 - self.poisson)
        return np.array([[-m, n], [n, -m], [1.0, 0.0], [0.0, 1.0]])

    @property
    def generator(self) -> FloatArray:
        """The matrix A of dY/ds = A Y."""
        nu = self.poisson
        b, c, e = nu / (1 - nu), (1 - 2 * nu) / (1 - nu), 1 / (1 - nu)
        return np.array([[0, -b, c, 0], [1, 0, 0, 2], [0, 0, 0, -1], [0, e, b, 0]], dtype=np.float64)


def decay(s: FloatArray) -> FloatArray:
    """exp(s A) on the modes that decay, in terms of their tractions: exp(-s) (1 + s SHIFT), shape (..., 2, 2)."""
    s = s[..., None, None]
    return np.asarray(np.exp(-s) * (np.eye(2) + s * _SHIFT))


def propagator(layer: Sheet, s: FloatArray) -> FloatArray:
    """exp(-s A), which carries the amplitudes up by s = k x, shape (..., 4, 4)."""
    a = layer.generator
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
class Stack:
    """Layers from the surface down on a rigid base (None) or on a half plane."""

    layers: tuple[Sheet, ...]
    base: Material | None

    @property
    def tops(self) -> FloatArray:
        """Depth of the top of each layer, and of the base, shape (layers + 1,)."""
        return np.concatenate([[0.0], np.cumsum([layer.thickness for layer in self.layers])])

    def amplitudes(self, k: FloatArray, x: FloatArray, remainder: bool = False) -> FloatArray:
        """Amplitudes at the depths x under p = 1 and under q = 1 (last axis), shape (x, k, 4, 2): u, u, Pa, Pa.

        u is times 2G of the first layer [Pa m]. With `remainder`, the first layer's are less what a half plane of its
        material would have: the part that is smooth even beneath a line load.
        """
        thin = k * self.tops[-1] < _THIN
        out = np.empty((x.size, k.size, 4, 2))
        for chosen, method in ((thin, self._propagated), (~thin, self._decaying)):
            if chosen.any():
                out[:, chosen] = method(k[chosen], x, remainder)
        # amplitudes stand for sigma_x = -p, tau_xy = -q at the surface, over 2 G k of the first layer
        out[:, :, :2] /= k[:, None, None]
        return out

    def _base(self) -> tuple[Sheet, FloatArray]:
        """A layer standing for what lies beneath, and the amplitudes that it allows at its top."""
        if self.base is None:
            rigid = self.layers[-1]
            return rigid, np.concatenate([np.zeros((2, 2)), np.eye(2)])
        below = Sheet(self.base.poisson, self.base.shear, np.inf, True)
        return below, below.decaying

    def _joined(self, upper: Sheet, lower: Sheet, allowed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Amplitudes allowed above an interface, given those below, and the factor that finds those from these."""
        scaled = allowed.copy()
        scaled[..., 2:, :] *= lower.shear / upper.shear
        if upper.bonded:
            return scaled, np.broadcast_to(np.eye(2), (*scaled.shape[:-2], 2, 2))
        # no shear on either side; u_y of the upper side is free
        pair = np.stack([scaled[..., 3, 1], -scaled[..., 3, 0]], axis=-1)
        size = np.linalg.norm(pair, axis=-1, keepdims=True)
        pair = np.where(size > 0, pair / np.where(size > 0, size, 1.0), np.array([1.0, 0.0]))
        joined = np.zeros(scaled.shape)
        joined[..., :, 0] = (scaled @ pair[..., None])[..., 0]
        joined[..., 1, 0] = joined[..., 3, 0] = 0.0
        joined[..., 1, 1] = 1.0
        back = np.zeros((*scaled.shape[:-2], 2, 2))
        back[..., :, 0] = pair
        return joined, back

    def _propagated(self, k: FloatArray, x: FloatArray, remainder: bool) -> FloatArray:
        lower, allowed = self._base()
        allowed = np.broadcast_to(allowed, (k.size, 4, 2))
        bottoms: list[FloatArray] = []
        backs: list[FloatArray] = []
        for layer in reversed(self.layers):
            allowed, back = self._joined(layer, lower, allowed)
            bottoms.append(allowed)
            backs.append(back)
            allowed = propagator(layer, k * layer.thickness) @ allowed
            lower = layer
        bottoms, backs = bottoms[::-1], backs[::-1]
        share = -np.linalg.inv(allowed[:, 2:])  # tractions -p and -q
        out = np.empty((x.size, k.size, 4, 2))
        tops, positions = self.tops, self.positions(x)
        for j, layer in enumerate(self.layers):
            for i in np.flatnonzero(positions == j):
                up = propagator(layer, k * (tops[j + 1] - x[i]))
                out[i] = self._unscaled(layer, up @ bottoms[j] @ share)
                if remainder and j == 0:
                    out[i] += layer.decaying @ decay(k * x[i])
            share = backs[j] @ share
        self._fill_base(out, x, k, positions, np.asarray(share))
        return out

    def _decaying(self, k: FloatArray, x: FloatArray, remainder: bool) -> FloatArray:
        lower, allowed = self._base()
        allowed = np.broadcast_to(allowed, (k.size, 4, 2))
        falls: list[FloatArray] = []
        backs: list[FloatArray] = []
        echoes: list[FloatArray] = []
        changes: list[FloatArray] = []
        for layer in reversed(self.layers):
            down = layer.decaying
            up = _FLIP @ down
            joined, back = self._joined(layer, lower, allowed)
            both = np.linalg.inv(np.concatenate([down, up], axis=1)) @ joined
            change = np.asarray(np.linalg.inv(both[:, :2]), dtype=np.float64)
            echo = both[:, 2:] @ change  # what comes back from the bottom of what arrives there
            fall = decay(k * layer.thickness)
            allowed = down + up @ fall @ echo @ fall
            for kept, value in ((falls, fall), (backs, back), (echoes, echo), (changes, change)):
                kept.append(value)
            lower = layer
        out = np.empty((x.size, k.size, 4, 2))
        tops, positions = self.tops, self.positions(x)
        top = self.layers[0]
        back_at_top = (_FLIP @ top.decaying)[2:] @ falls[-1] @ echoes[-1] @ falls[-1]
        sent = -np.linalg.inv(np.eye(2) + back_at_top)
        extra = -back_at_top @ sent if remainder else sent  # less the half plane's: no difference is left to be small
        for j, layer in enumerate(self.layers):
            n = len(self.layers) - 1 - j
            down, up = layer.decaying, _FLIP @ layer.decaying
            risen = echoes[n] @ falls[n] @ sent
            for i in np.flatnonzero(positions == j):
                direct = down @ decay(k * (x[i] - tops[j])) @ (extra if j == 0 else sent)
                out[i] = self._unscaled(layer, direct + up @ decay(k * (tops[j + 1] - x[i])) @ risen)
            sent = backs[n] @ changes[n] @ falls[n] @ sent
        self._fill_base(out, x, k, positions, np.asarray(sent))
        return out

    def _fill_base(
        self, out: FloatArray, x: FloatArray, k: FloatArray, positions: npt.NDArray[np.intp], share: FloatArray
    ) -> None:
        for i in np.flatnonzero(positions == len(self.layers)):
            base, allowed = self._base()
            out[i] = self._unscaled(base, allowed @ decay(k * (x[i] - self.tops[-1])) @ share)

    def positions(self, x: FloatArray) -> npt.NDArray[np.intp]:
        """In which layer each depth lies; an interface belongs to the layer above it."""
        return np.asarray(np.searchsorted(self.tops[1:], x, side="left"))

    def _unscaled(self, layer: Sheet, y: FloatArray) -> FloatArray:
        """Tractions of a layer over 2Gk of the first, as they are at the surface."""
        y[..., 2:, :] *= layer.shear / self.layers[0].shear
        return y
