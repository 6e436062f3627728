"""How the surface answers tractions at the nodes of a square grid: products by padded Fourier transforms.

A traction is bilinear between the nodes, so it is a sum of hats, and the surface moves by the sum of the skin's answers
to each: a product of a block Toeplitz matrix, of spectra once zeros are put beyond the grid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...skin import Skin
from ._spectral import scaled, turned

__all__ = ["SIGNS", "AreaInfluence", "area_influence", "inverted", "lateral_inverse", "spectrum"]

_LEAST = 0.1
"""A direction in which the drag's own circulant falls beneath this share of the other is lifted to it."""


@dataclass(frozen=True, eq=False)
class AreaInfluence(Frozen):
    """Displacement at nodes by hats at nodes: the rows of `Skin.area_influence` [m/Pa], shape (1 or 6, n, k)."""

    rows: FloatArray

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of nodes along y and along z."""
        return int(self.rows.shape[1]), int(self.rows.shape[2])

    @property
    def own(self) -> float:
        """What a node's own pressure moves it beyond its neighbours [m/Pa]."""
        return float(self.rows[0, 0, 0] - self.rows[0, 0, 1])

    @property
    def own_lateral(self) -> float:
        """The same along the surface."""
        return float(self.rows[1, 0, 0] - self.rows[1, 0, 1])

    @cached_property
    def coupled(self) -> bool:
        """Whether a pressure also moves the surface along itself."""
        return bool(len(self.rows) > 1 and np.abs(self.rows[4:]).max() > 1e-13 * np.abs(self.rows[0]).max())

    @cached_property
    def _padded(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        return next_fast_len(2 * self.shape[0] - 1, True), next_fast_len(2 * self.shape[1] - 1, True)

    @cached_property
    def _tiled(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        return next_fast_len(self.shape[0], True), next_fast_len(self.shape[1], True)

    @cached_property
    def _spectra(self) -> list[FloatArray]:
        """Of every row; of the last two, which are odd, the imaginary part."""
        return [spectrum(row, self._padded, SIGNS[i]) for i, row in enumerate(self.rows)]

    @cached_property
    def _single(self) -> list[npt.NDArray[np.float32]]:
        return [spectrum.astype(np.float32) for spectrum in self._spectra]

    def _waves(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Transform of maps (..., n, k) with zeros beyond the grid, in their own precision: no row of zeros is done."""
        from scipy.fft import fft, rfft

        return np.asarray(fft(rfft(values, self._padded[1]), self._padded[0], axis=-2, overwrite_x=True))

    def _map(self, waves: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The way back, on the grid's rows alone, with more columns than the grid has. `waves` is overwritten."""
        from scipy.fft import ifft, irfft

        rows = ifft(waves, axis=-2, overwrite_x=True)[..., : self.shape[0], :]
        return np.asarray(irfft(rows, self._padded[1], overwrite_x=True))

    def normal(self, pressure: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """u_x at every node under a pressure [m], (n, k), in single precision if that is given so."""
        return self.normal_wide(pressure)[:, : self.shape[1]]

    def normal_wide(self, pressure: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The same with more columns, which mean nothing: what is cut off is no longer in one piece."""
        waves = self._waves(pressure)
        single = pressure.dtype == np.float32
        scaled(waves.view(pressure.dtype), (self._single if single else self._spectra)[0])
        return self._map(waves)

    def lateral(self, shear: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """u_y and u_z under a drag, both of shape (2, n, k), in single precision if that is given so."""
        return self.lateral_wide(shear)[..., : self.shape[1]]

    def lateral_wide(self, shear: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """The same with more columns, as of `normal_wide`."""
        waves = self._waves(shear)
        single = shear.dtype == np.float32
        turned(waves.view(shear.dtype), *(self._single if single else self._spectra)[1:4])
        return self._map(waves)

    def lifted(self, shear: FloatArray) -> FloatArray:
        """u_x under a drag."""
        if not self.coupled or not shear.any():
            return np.zeros(self.shape)
        y, z = self._waves(shear)
        return self._map(1j * (self._spectra[4] * y + self._spectra[5] * z))[:, : self.shape[1]]

    def dragged(self, pressure: FloatArray) -> FloatArray:
        """u_y and u_z under a pressure."""
        if not self.coupled:
            return np.zeros((2, *self.shape))
        waves = -1j * self._waves(pressure)
        return self._map(np.stack([waves * row for row in self._spectra[4:]]))[..., : self.shape[1]]

    def nearly_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """What pressure nearly makes a displacement: that of a grid which repeats. It may be larger than the grid."""
        from scipy.fft import irfft2, rfft2

        waves = rfft2(residual, self._tiled)
        scaled(waves.view(np.float32), self._inverse)
        return np.asarray(irfft2(waves, self._tiled, overwrite_x=True))

    @cached_property
    def _inverse(self) -> npt.NDArray[np.float32]:
        return inverted(spectrum(self.rows[0], self._tiled, (1, 1)))

    def nearly_lateral_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """As `nearly_wide`, of drags (2, n, k)."""
        from scipy.fft import irfft2, rfft2

        waves = rfft2(residual, self._tiled)
        turned(waves.view(np.float32), *self._lateral_inverse)
        return np.asarray(irfft2(waves, self._tiled, overwrite_x=True))

    @cached_property
    def typical(self) -> float:
        """What nearly makes a node's own unit displacement along the surface, at that node [Pa/m]."""
        unit = np.zeros((2, *self.shape), dtype=np.float32)
        unit[0, 0, 0] = 1.0
        return float(self.nearly_lateral_wide(unit)[0, 0, 0])

    @cached_property
    def _lateral_inverse(self) -> npt.NDArray[np.float32]:
        return lateral_inverse(*(spectrum(self.rows[i], self._tiled, SIGNS[i]) for i in (1, 2, 3)))

    @cached_property
    def coarser(self) -> AreaInfluence:
        """The same for every other node: a wide hat is a sum of narrow ones.

        Near the end of a row the sum runs over what is not known, and repeats the last: a coarse answer is only ever a
        start.
        """
        rows = np.stack([_halved(row, SIGNS[i]) for i, row in enumerate(self.rows)])
        return AreaInfluence(np.ascontiguousarray(rows))

    @cached_property
    def _cropped(self) -> dict[tuple[int, int], AreaInfluence]:
        return {}

    @cached_property
    def quarters(self) -> dict[tuple[bool, bool], Any]:
        """Operators on a quarter of the grid, by parity (quarter.py)."""
        return {}

    def cropped(self, shape: tuple[int, int]) -> AreaInfluence:
        """The same on a part of the grid."""
        if shape == self.shape:
            return self
        if shape not in self._cropped:
            self._cropped[shape] = AreaInfluence(np.ascontiguousarray(self.rows[:, : shape[0], : shape[1]]))
        return self._cropped[shape]

    def direct(self, tractions: Sequence[FloatArray], at: Sequence[tuple[int, int]]) -> FloatArray:
        """u_x, u_y and u_z at a few nodes, summed term by term, shape (nodes, 1 or 3), of p, q_y and q_z."""
        out = []
        for i, j in at:
            if len(self.rows) == 1:
                out.append([_summed(self.rows[0], (1, 1), tractions[0], i, j)])
                continue
            p, a, b = tractions
            pairs = ((0, p), (4, a), (5, b)), ((1, a), (3, b), (4, p)), ((3, a), (2, b), (5, p))
            sums = [[_summed(self.rows[row], SIGNS[row], part, i, j) for row, part in line] for line in pairs]
            # what a pressure moves along the surface is minus what a drag along there lifts
            out.append([sums[0][0] + sums[0][1] + sums[0][2], *(one + two - three for one, two, three in sums[1:])])
        return np.array(out)


SIGNS = ((1, 1), (1, 1), (1, 1), (-1, -1), (-1, 1), (1, -1))
"""Whether rows are even or odd along y and along z."""


def spectrum(row: FloatArray, size: tuple[int, int], signs: tuple[int, int]) -> FloatArray:
    """Real spectrum of a row put round a torus; of a row that is odd one way the imaginary part."""
    from scipy.fft import rfft2

    axes = []
    for count, length, sign in zip(row.shape, size, signs, strict=True):
        j = np.arange(length)
        away = np.minimum(j, length - j)
        turned = np.where(j <= length - j, 1.0, sign) * (away < count)
        if sign < 0:
            turned[(2 * j) % length == 0] = 0.0
        axes.append((np.minimum(away, count - 1), turned))
    (i, a), (j, b) = axes
    waves = rfft2(row[np.ix_(i, j)] * a[:, None] * b)
    return np.ascontiguousarray(waves.real if signs[0] == signs[1] else waves.imag)


def _summed(row: FloatArray, signs: tuple[int, int], traction: FloatArray, i: int, j: int) -> float:
    """Displacement at a node, term by term."""
    total = 0.0
    for kernel_y, along_y, turn_y in _halves(row.shape[0], i, signs[0]):
        for kernel_z, along_z, turn_z in _halves(row.shape[1], j, signs[1]):
            total += turn_y * turn_z * float(np.einsum("ij,ij", row[kernel_y, kernel_z], traction[along_y, along_z]))
    return total


def _halves(count: int, i: int, sign: int) -> list[tuple[slice, slice, int]]:
    """Parts of a row, of the nodes on either side of node i, and by what they are turned: odd rows have no middle."""
    first = int(sign < 0)
    below = slice(i - 1, None, -1) if i else slice(0, 0)
    return [(slice(first, count - i), slice(i + first, count), sign), (slice(1, i + 1), below, 1)]


def inverted(values: FloatArray) -> npt.NDArray[np.float32]:
    """What undoes a real spectrum, nearly. `values` is overwritten."""
    values[0, 0] = min(values[0, 1], values[1, 0])  # the mean is poorly known, and mended by the sums
    # all are positive where the row falls ever more slowly; elsewhere the few that are not are lifted
    least = 0.2 * np.abs(values).min(initial=np.inf, where=values > 0)
    return np.asarray(1 / np.maximum(values, least), dtype=np.float32)


def lateral_inverse(yy: FloatArray, zz: FloatArray, yz: FloatArray) -> npt.NDArray[np.float32]:
    """What undoes the symmetric matrix of three real spectra, nearly. They are overwritten."""
    for part in (yy, zz):
        part[0, 0] = min(part[0, 1], part[1, 0])
    mean, half = 0.5 * (yy + zz), 0.5 * (yy - zz)
    size = np.hypot(half, yz)
    least = np.abs(mean).min(initial=np.inf, where=mean > 0)
    mean = np.maximum(mean, least)
    keep = np.minimum(1.0, (1 - _LEAST) * mean / np.maximum(size, 1e-300))
    half, yz, size = half * keep, yz * keep, size * keep
    det = (mean - size) * (mean + size)
    return np.stack([(mean - half) / det, (mean + half) / det, -yz / det]).astype(np.float32)


def _halved(row: FloatArray, signs: tuple[int, int]) -> FloatArray:
    for axis, sign in zip((0, 1), signs, strict=True):
        row = np.moveaxis(row, axis, -1)
        wide = np.concatenate([sign * row[:, 1:2], row, row[:, -1:]], axis=-1)
        row = np.moveaxis((0.5 * wide[:, :-2] + wide[:, 1:-1] + 0.5 * wide[:, 2:])[:, ::2], -1, axis)
    return row


@lru_cache(maxsize=16)
def area_influence(skin: Skin, step: float, shape: tuple[int, int], drag: bool) -> AreaInfluence:
    """The operator of a skin on a grid, kept for the next call."""
    rows = np.ascontiguousarray(skin.area_influence(step, shape, drag))
    rows.flags.writeable = False
    return AreaInfluence(rows)
