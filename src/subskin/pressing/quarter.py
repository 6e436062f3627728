"""Spectra of rows that nearly undo each other, and a quarter of a grid instead of all of it.

A quarter stands for all of it where bodies and loads are alike, or opposite, on either side of both axes.

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

__all__ = [
    "Parity",
    "Quarter",
    "Signs",
    "centred",
    "corner",
    "inverted",
    "lateral_inverse",
    "quarter",
    "quick",
    "spectrum",
    "unfolded",
    "with_parity",
]

Parity = tuple[bool, bool]
"""Whether a map is odd along y and along z."""
Signs = tuple[int, ...]
"""Whether a row is even (1) or odd (-1) along each axis."""
Maps = npt.NDArray[Any]

_LEAST = 0.1
"""A direction in which the drag's own circulant falls beneath this share of the other is lifted to it."""
_EVEN: Parity = (False, False)
_APART = 1e-3
"""Share of a step by which nodes that stand in pairs may differ."""


def spectrum(row: FloatArray, size: tuple[int, ...], signs: Signs) -> FloatArray:
    """Real spectrum of a row put round a torus; of a row that is odd one way the imaginary part."""
    from scipy.fft import rfftn

    nearest, shares = [], []
    for count, length, sign in zip(row.shape, size, signs, strict=True):
        j = np.arange(length)
        away = np.minimum(j, length - j)
        share = np.where(j <= length - j, 1.0, sign) * (away < count)
        if sign < 0:
            share[(2 * j) % length == 0] = 0.0
        nearest.append(np.minimum(away, count - 1))
        shares.append(share)
    values = row[np.ix_(*nearest)]
    for share in np.ix_(*shares):
        values = values * share
    waves = rfftn(values)
    return np.ascontiguousarray(waves.real if np.prod(signs) > 0 else waves.imag)


def inverted(values: FloatArray) -> FloatArray:
    """What undoes a real spectrum, nearly. `values` is overwritten."""
    _mean_mended(values)
    # all are positive where the row falls ever more slowly; elsewhere the few that are not are lifted
    return np.asarray(1 / np.maximum(values, 0.2 * np.abs(values).min(initial=np.inf, where=values > 0)))


def _mean_mended(values: FloatArray) -> None:
    """The mean is poorly known, and mended by the sums: as the longest wave."""
    values.flat[0] = values[1] if values.ndim == 1 else min(values[0, 1], values[1, 0])


def lateral_inverse(yy: FloatArray, zz: FloatArray, yz: FloatArray) -> npt.NDArray[np.float32]:
    """What undoes the symmetric matrix of three real spectra, nearly. They are overwritten."""
    for part in (yy, zz):
        _mean_mended(part)
    mean, half = 0.5 * (yy + zz), 0.5 * (yy - zz)
    size = np.hypot(half, yz)
    least = np.abs(mean).min(initial=np.inf, where=mean > 0)
    mean = np.maximum(mean, least)
    keep = np.minimum(1.0, (1 - _LEAST) * mean / np.maximum(size, 1e-300))
    half, yz, size = half * keep, yz * keep, size * keep
    det = (mean - size) * (mean + size)
    return np.stack([(mean - half) / det, (mean + half) / det, -yz / det]).astype(np.float32)


def quick(least: Any) -> tuple[int, ...]:
    """Lengths that are quick to transform and not less: of a row the powers of two, by which its own loop goes."""
    from scipy.fft import next_fast_len

    if len(least) == 1:
        return (1 << max(least[0] - 1, 7).bit_length(),)
    return tuple(next_fast_len(length, True) for length in least)


def corner(values: Maps) -> Maps:
    """The quarter with the greatest y and z, the last two axes being of even length."""
    return np.ascontiguousarray(values[..., values.shape[-2] // 2 :, values.shape[-1] // 2 :])


def unfolded(values: Maps, odd: Parity = _EVEN) -> Maps:
    """The whole of a map by its quarter, or of two components, of which the second has the other parity."""
    if values.ndim == 3:
        return np.stack([unfolded(values[0], odd), unfolded(values[1], _other(odd))])
    for axis, turns in zip((-2, -1), odd, strict=True):
        other = np.flip(values, axis)
        values = np.concatenate([-other if turns else other, values], axis=axis)
    return values


def with_parity(values: Maps, odd: Parity, most: float) -> bool:
    """Whether a map, or that of two components of which the second has the other parity, has this but for `most`."""
    if values.ndim == 3:
        return with_parity(values[0], odd, most) and with_parity(values[1], _other(odd), most)
    n, k = values.shape[0] // 2, values.shape[1] // 2
    ends = (values[n:], values[n - 1 :: -1], odd[0]), (values[:, k:], values[:, k - 1 :: -1], odd[1])
    if values.dtype == np.bool_:
        return not any((one != other).any() for one, other, _ in ends)
    return all(bool(np.abs(one + other if turns else one - other).max() <= most) for one, other, turns in ends)


def centred(nodes: tuple[FloatArray, ...]) -> bool:
    """Whether nodes stand in pairs on either side of both axes."""
    return all(at.size % 2 == 0 and np.abs(at + at[::-1]).max() <= _APART * (at[1] - at[0]) for at in nodes)


def _other(odd: Parity) -> Parity:
    return not odd[0], not odd[1]


@dataclass(frozen=True, eq=False)
class Quarter(Frozen):
    """As `Influence`, of tractions given on a quarter; `odd` is the parity of q_y, and q_z has the other."""

    whole: Any
    odd: Parity = _EVEN

    @property
    def own(self) -> float:
        """As of the whole [m/Pa]."""
        return float(self.whole.own)

    @property
    def own_lateral(self) -> float:
        """As of the whole [m/Pa]."""
        return float(self.whole.own_lateral)

    @property
    def typical(self) -> float:
        """As of the whole [Pa/m]."""
        return float(self.whole.typical)

    @cached_property
    def _tiled(self) -> tuple[int, ...]:
        n, k = self.whole.shape
        return quick((n // 2, k // 2))

    @cached_property
    def _padded(self) -> tuple[int, ...]:
        return quick(self.whole.shape)

    def _spectrum(self, row: int, size: tuple[int, ...]) -> FloatArray:
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

    def _turned(self, maps: Maps, size: tuple[int, ...], by: Maps) -> Maps:
        parities = (self.odd, _other(self.odd))
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


def quarter(whole: Any, odd: Parity = _EVEN) -> Quarter:
    """The operator on a quarter, kept with that of the whole."""
    if odd not in whole.quarters:
        whole.quarters[odd] = Quarter(whole, odd)
    return whole.quarters[odd]  # type: ignore[no-any-return]


def _forward(values: Maps, size: tuple[int, ...], odd: Parity) -> Maps:
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
