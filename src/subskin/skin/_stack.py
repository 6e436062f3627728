"""Layers joined from the base up, wave by wave, without loss at any thickness: flat ones and rings alike.

The four amplitudes Y = (u_x, u_y, sigma_x, tau_xy), the tractions over 2 G of the layer and the wavenumber, are two
modes that decay from the top of a layer and two that decay from its bottom, each known by its tractions there. Where
the whole stack is thin beside the wavelength these are nearly equal, and the solution is carried up from the base.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray

__all__ = ["Joined", "Sheet"]


class Sheet(NamedTuple):
    """What the modes need of a layer: Poisson's ratio, shear modulus [Pa], thickness [m], whether it sticks below."""

    poisson: float
    shear: float
    thickness: float
    bonded: bool


class Joined(ABC):
    """Layers from the surface down; k are wavenumbers, `top` and `bottom` depths [m]."""

    layers: tuple[Sheet, ...]

    @property
    def tops(self) -> FloatArray:
        """Depth of the top of each layer, and of the base, shape (layers + 1,)."""
        return np.concatenate([[0.0], np.cumsum([layer.thickness for layer in self.layers])])

    def positions(self, x: FloatArray) -> npt.NDArray[np.intp]:
        """In which layer each depth lies; an interface belongs to the layer above it."""
        return np.asarray(np.searchsorted(self.tops[1:], x, side="left"))

    @abstractmethod
    def _thin(self, k: FloatArray) -> npt.NDArray[np.bool_]:
        """For which waves the solution is carried up from the base."""

    @abstractmethod
    def _down(self, layer: Sheet, k: FloatArray) -> FloatArray:
        """Amplitudes of the modes that decay downwards under unit tractions, shape (4, 2) or (k, 4, 2)."""

    @abstractmethod
    def _up(self, layer: Sheet, k: FloatArray) -> FloatArray:
        """Amplitudes of the modes that decay upwards under unit tractions, shape (4, 2) or (k, 4, 2)."""

    @abstractmethod
    def _fall(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        """Tractions at the bottom of the modes that have unit ones at the top and decay downwards, shape (k, 2, 2)."""

    @abstractmethod
    def _rise(self, k: FloatArray, top: float, bottom: float) -> FloatArray:
        """Tractions at the top of the modes that have unit ones at the bottom and decay upwards, shape (k, 2, 2)."""

    @abstractmethod
    def _carried(self, layer: Sheet, k: FloatArray, top: float, bottom: float) -> FloatArray:
        """What takes the amplitudes from the bottom up to the top, shape (k, 4, 4)."""

    def _base(self, k: FloatArray) -> tuple[Sheet, FloatArray]:
        """A layer standing for what lies beneath, and the amplitudes that it allows at its top: a rigid base."""
        return self.layers[-1], np.concatenate([np.zeros((2, 2)), np.eye(2)])

    def _sticks(self, upper: Sheet, k: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether a layer holds to what lies beneath it, for each wave."""
        return np.full(k.shape, upper.bonded)

    def _solved(self, k: FloatArray, x: FloatArray, remainder: bool) -> FloatArray:
        """Amplitudes under tractions -1 at the surface, shape (x, k, 4, 2); tractions over 2Gk of the first layer.

        With `remainder`, the first layer's are less what the modes would be that decay from the surface alone.
        """
        thin = self._thin(k)
        out = np.empty((x.size, k.size, 4, 2))
        for chosen, method in ((thin, self._propagated), (~thin, self._decaying)):
            if chosen.any():
                out[:, chosen] = method(k[chosen], x, remainder)
        return out

    def _joined(self, upper: Sheet, lower: Sheet, allowed: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Amplitudes allowed above an interface, given those below, and the factor that finds those from these."""
        scaled = allowed.copy()
        scaled[..., 2:, :] *= lower.shear / upper.shear
        one = np.broadcast_to(np.eye(2), (*scaled.shape[:-2], 2, 2))
        sticks = self._sticks(upper, k)
        if sticks.all():
            return scaled, one
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
        held = sticks[:, None, None]
        return np.where(held, scaled, joined), np.where(held, one, back)

    def _propagated(self, k: FloatArray, x: FloatArray, remainder: bool) -> FloatArray:
        lower, allowed = self._base(k)
        allowed = np.broadcast_to(allowed, (k.size, 4, 2))
        bottoms: list[FloatArray] = []
        backs: list[FloatArray] = []
        tops, positions = self.tops, self.positions(x)
        for j, layer in reversed(list(enumerate(self.layers))):
            allowed, back = self._joined(layer, lower, allowed, k)
            bottoms.append(allowed)
            backs.append(back)
            allowed = self._carried(layer, k, tops[j], tops[j + 1]) @ allowed
            lower = layer
        bottoms, backs = bottoms[::-1], backs[::-1]
        share = -_inverse(allowed[:, 2:])  # tractions -p and -q
        out = np.empty((x.size, k.size, 4, 2))
        for j, layer in enumerate(self.layers):
            for i in np.flatnonzero(positions == j):
                up = self._carried(layer, k, x[i], tops[j + 1])
                out[i] = self._unscaled(layer, up @ bottoms[j] @ share)
                if remainder and j == 0:
                    out[i] += self._down(layer, k) @ self._fall(k, 0.0, x[i])
            share = backs[j] @ share
        self._fill_base(out, x, k, positions, np.asarray(share))
        return out

    def _decaying(self, k: FloatArray, x: FloatArray, remainder: bool) -> FloatArray:
        lower, allowed = self._base(k)
        allowed = np.broadcast_to(allowed, (k.size, 4, 2))
        falls: list[FloatArray] = []
        backs: list[FloatArray] = []
        echoes: list[FloatArray] = []
        changes: list[FloatArray] = []
        tops, positions = self.tops, self.positions(x)
        for j, layer in reversed(list(enumerate(self.layers))):
            down, up = self._down(layer, k), self._up(layer, k)
            joined, back = self._joined(layer, lower, allowed, k)
            both = np.linalg.inv(np.concatenate([down, up], axis=-1)) @ joined
            change = _inverse(both[:, :2])
            echo = both[:, 2:] @ change  # what comes back from the bottom of what arrives there
            fall, rise = self._fall(k, tops[j], tops[j + 1]), self._rise(k, tops[j], tops[j + 1])
            allowed = down + up @ rise @ echo @ fall
            for kept, value in ((falls, fall), (backs, back), (echoes, echo), (changes, change)):
                kept.append(value)
            lower = layer
        out = np.empty((x.size, k.size, 4, 2))
        back_at_top = rise @ echoes[-1] @ falls[-1]
        sent = -_inverse(np.eye(2) + back_at_top)
        extra = -back_at_top @ sent if remainder else sent  # less the surface's own: no difference is left to be small
        for j, layer in enumerate(self.layers):
            n = len(self.layers) - 1 - j
            down, up = self._down(layer, k), self._up(layer, k)
            risen = echoes[n] @ falls[n] @ sent
            for i in np.flatnonzero(positions == j):
                direct = down @ self._fall(k, tops[j], x[i]) @ (extra if j == 0 else sent)
                out[i] = self._unscaled(layer, direct + up @ self._rise(k, x[i], tops[j + 1]) @ risen)
            sent = backs[n] @ changes[n] @ falls[n] @ sent
        self._fill_base(out, x, k, positions, np.asarray(sent))
        return out

    def _fill_base(
        self, out: FloatArray, x: FloatArray, k: FloatArray, positions: npt.NDArray[np.intp], share: FloatArray
    ) -> None:
        for i in np.flatnonzero(positions == len(self.layers)):
            base, allowed = self._base(k)
            out[i] = self._unscaled(base, allowed @ self._fall(k, self.tops[-1], x[i]) @ share)

    def _unscaled(self, layer: Sheet, y: FloatArray) -> FloatArray:
        """Tractions of a layer over 2Gk of the first, as they are at the surface."""
        y[..., 2:, :] *= layer.shear / self.layers[0].shear
        return y


def _inverse(m: FloatArray) -> FloatArray:
    """Inverses of matrices (k, 2, 2), in a tenth of the time of `np.linalg.inv`."""
    out = np.empty(m.shape)
    out[:, 0, 0], out[:, 1, 1] = m[:, 1, 1], m[:, 0, 0]
    out[:, 0, 1], out[:, 1, 0] = -m[:, 0, 1], -m[:, 1, 0]
    out /= (m[:, 0, 0] * m[:, 1, 1] - m[:, 0, 1] * m[:, 1, 0])[:, None, None]
    return out
