"""A quarter of a grid stands for all of it where bodies and loads are alike, or opposite, on either side of both axes.

The transforms are then of cosines and sines, a quarter as long: a product takes a quarter of the time. A map that is
even along an axis has frequencies 0, 1, ..., an odd one 1, 2, ...
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from .influence import Influence, inverted, lateral_inverse, spectrum

__all__ = ["Parity", "Quarter", "corner", "quarter", "unfolded", "with_parity"]

Parity = tuple[bool, bool]
"""Whether a map is odd along y and along z."""
Maps = npt.NDArray[Any]

_EVEN: Parity = (False, False)


def corner(values: Maps) -> Maps:
    """The quarter with the greatest y and z, the last two axes being of even length."""
    return np.ascontiguousarray(values[..., values.shape[-2] // 2 :, values.shape[-1] // 2 :])


def unfolded(values: Maps, odd: Parity = _EVEN) -> Maps:
    """The whole of a map by its quarter."""
    for axis, turns in zip((-2, -1), odd, strict=True):
        other = np.flip(values, axis)
        values = np.concatenate([-other if turns else other, values], axis=axis)
    return values


def with_parity(values: FloatArray, odd: Parity, most: float) -> bool:
    """Whether a map has this parity but for `most`."""
    n, k = values.shape[0] // 2, values.shape[1] // 2
    along_y, along_z = ((-1.0 if turns else 1.0) for turns in odd)
    return bool(
        np.abs(values[n:] - along_y * values[n - 1 :: -1]).max() <= most
        and np.abs(values[:, k:] - along_z * values[:, k - 1 :: -1]).max() <= most
    )


@dataclass(frozen=True, eq=False)
class Quarter(Frozen):
    """As `Influence`, of tractions given on a quarter; `odd` is the parity of q_y, and q_z has the other."""

    whole: Influence
    odd: Parity = _EVEN

    @property
    def own(self) -> float:
        """As of the whole [m/Pa]."""
        return self.whole.own

    @property
    def own_lateral(self) -> float:
        """As of the whole [m/Pa]."""
        return self.whole.own_lateral

    @property
    def typical(self) -> float:
        """As of the whole [Pa/m]."""
        return self.whole.typical

    @cached_property
    def _tiled(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        n, k = self.whole.shape
        return next_fast_len(n // 2, True), next_fast_len(k // 2, True)

    @cached_property
    def _padded(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        n, k = self.whole.shape
        return next_fast_len(n, True), next_fast_len(k, True)

    def _spectrum(self, row: int, size: tuple[int, int]) -> FloatArray:
        found = spectrum(self.whole.rows[row], (2 * size[0], 2 * size[1]), self.whole.signs[row])
        return np.ascontiguousarray(found[: size[0] + 1, : size[1] + 1])

    @cached_property
    def _normal(self) -> dict[Any, Maps]:
        values = np.ascontiguousarray(self._spectrum(0, self._padded)[:-1, :-1])
        return {np.dtype(np.float64): values, np.dtype(np.float32): values.astype(np.float32)}

    @cached_property
    def _inverse(self) -> npt.NDArray[np.float32]:
        return np.ascontiguousarray(inverted(self._spectrum(0, self._tiled))[:-1, :-1], np.float32)

    @cached_property
    def _lateral(self) -> dict[Any, Maps]:
        values = np.stack([self._spectrum(row, self._padded) for row in (1, 2, 3)])
        values[2] *= self._sign
        return {np.dtype(np.float64): values, np.dtype(np.float32): values.astype(np.float32)}

    @cached_property
    def _lateral_inverse(self) -> npt.NDArray[np.float32]:
        values = lateral_inverse(*(self._spectrum(row, self._tiled) for row in (1, 2, 3)))
        values[2] *= np.float32(self._sign)
        return values

    @property
    def _sign(self) -> float:
        # a sine's wave is -i times that of a cosine, and sines both ways make -1
        return -1.0 if self.odd[0] == self.odd[1] else 1.0

    def normal_wide(self, pressure: Maps) -> Maps:
        """u_x on the quarter under a pressure that is even both ways [m]."""
        waves = _forward(pressure, self._padded, _EVEN)
        waves *= self._normal[pressure.dtype]
        return _back(waves, pressure.shape, _EVEN)

    def nearly_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """What pressure nearly makes a displacement."""
        waves = _forward(residual, self._tiled, _EVEN)
        waves *= self._inverse
        return _back(waves, residual.shape, _EVEN)

    def lateral_wide(self, shear: Maps) -> Maps:
        """u_y and u_z on the quarter under a drag."""
        return self._turned(shear, self._padded, self._lateral[shear.dtype])

    def nearly_lateral_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """What drag nearly makes a displacement."""
        return self._turned(residual, self._tiled, self._lateral_inverse)

    def _turned(self, maps: Maps, size: tuple[int, int], by: Maps) -> Maps:
        parities = (self.odd, (not self.odd[0], not self.odd[1]))
        at = [np.s_[odd[0] : odd[0] + size[0], odd[1] : odd[1] + size[1]] for odd in parities]
        waves = np.zeros((2, size[0] + 1, size[1] + 1), maps.dtype)
        for part, values, here, odd in zip(waves, maps, at, parities, strict=True):
            part[here] = _forward(values, size, odd)
        yy, zz, yz = by
        moved = (yy * waves[0] + yz * waves[1], yz * waves[0] + zz * waves[1])
        out = np.empty_like(maps)
        for answer, part, here, odd in zip(out, moved, at, parities, strict=True):
            answer[...] = _back(part[here], maps.shape[1:], odd)[:, : maps.shape[2]]
        return out


def quarter(whole: Influence, odd: Parity = _EVEN) -> Quarter:
    """The operator on a quarter, kept with that of the whole."""
    if odd not in whole.quarters:
        whole.quarters[odd] = Quarter(whole, odd)
    return whole.quarters[odd]  # type: ignore[no-any-return]


def _forward(values: Maps, size: tuple[int, int], odd: Parity) -> Maps:
    """Transform of a map with zeros beyond the quarter."""
    from scipy.fft import dct, dst

    along_y, along_z = (dst if turns else dct for turns in odd)
    return np.asarray(along_y(along_z(values, 2, size[1], axis=1), 2, size[0], axis=0, overwrite_x=True))


def _back(waves: Maps, shape: tuple[int, ...], odd: Parity) -> Maps:
    """The way back, with more columns than the quarter has."""
    from scipy.fft import idct, idst

    along_y, along_z = (idst if turns else idct for turns in odd)
    rows = along_y(waves, 2, axis=0)[: shape[0]]
    return np.asarray(along_z(rows, 2, axis=1, overwrite_x=True))
