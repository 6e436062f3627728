"""How the surface answers tractions given at equally spaced nodes: products by Fourier transforms, and direct sums.

A traction is drawn by straight lines between the nodes, on an area bilinear, so it is a sum of hats, and the surface
moves by the sum of the skin's answers to each: a product with a Toeplitz matrix (of blocks on an area). Made circulant
by zeros beyond the window, or circulant by itself where everything repeats, it is a product of spectra.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from ..skin import Skin
from ._area_kernel import scaled, turned
from .quarter import Signs, inverted, lateral_inverse, quick, spectrum

__all__ = ["Influence", "influence"]

_ALIASES = 60
"""Most multiples of the grid's own wavenumber summed one by one in a periodic row."""
_STILL = 1e-6
"""Wavenumber times thickness at which a wave on a skin with a ground is as good as none: what is left is its square."""
_DATUM_STEPS = 256

Maps = npt.NDArray[Any]

_SIGNS: dict[int, tuple[Signs, ...]] = {1: ((1,), (1,), (-1,)), 2: ((1, 1), (1, 1), (1, 1), (-1, -1), (-1, 1), (1, -1))}
"""Whether rows are even or odd along each axis."""


@dataclass(frozen=True, eq=False)
class Influence(Frozen):
    """Displacement at nodes by hats at nodes: `rows` at distances of whole steps [m/Pa], on a row or on an area.

    On a row, shape (3, n), they are u_x by pressure, u_y by shear, u_x by shear. On an area they are those of
    `Skin.area_influence`, shape (1 or 6, n, k). A periodic row runs once round the period.
    """

    rows: FloatArray
    periodic: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of nodes along each axis."""
        return self.rows.shape[1:]

    @property
    def signs(self) -> tuple[Signs, ...]:
        """Whether each of the rows is even or odd along each axis."""
        return _SIGNS[len(self.shape)][: len(self.rows)]

    @property
    def drags(self) -> bool:
        """Whether it is known what a drag does."""
        return len(self.rows) > 1

    @property
    def own(self) -> float:
        """What a node's own pressure moves it beyond its neighbours [m/Pa]."""
        return float(self.rows[0].flat[0] - self.rows[0].flat[1])

    @property
    def own_lateral(self) -> float:
        """The same along the surface."""
        return float(self.rows[1].flat[0] - self.rows[1].flat[1])

    @cached_property
    def coupled(self) -> bool:
        """Whether a pressure also moves the surface along itself: by the last rows, one for each axis."""
        d = len(self.shape)
        return bool(self.drags and np.abs(self.rows[-d:]).max() > 1e-13 * np.abs(self.rows[0]).max())

    @property
    def longest(self) -> float:
        """Displacement per pressure of the longest wave that fits on a row [m/Pa]."""
        return float(np.abs(self._spectra[0][1]))

    @cached_property
    def _padded(self) -> tuple[int, ...]:
        return self.shape if self.periodic else quick([2 * count - 1 for count in self.shape])

    @cached_property
    def _tiled(self) -> tuple[int, ...]:
        return self.shape if self.periodic else quick(self.shape)

    @cached_property
    def _spectra(self) -> list[FloatArray]:
        """Of every row; of those that are odd one way, the imaginary part."""
        return [spectrum(row, self._padded, signs) for row, signs in zip(self.rows, self.signs, strict=True)]

    @cached_property
    def _single(self) -> list[npt.NDArray[np.float32]]:
        return [spectrum.astype(np.float32) for spectrum in self._spectra]

    def _of(self, values: Maps) -> list[Any]:
        """The spectra, in the precision of `values`."""
        return self._single if values.dtype == np.float32 else self._spectra

    def _waves(self, values: Maps) -> Maps:
        """Transform of maps with zeros beyond the grid, in their own precision: no row of zeros is done."""
        from scipy.fft import fft, rfft

        waves = rfft(values, self._padded[-1])
        if len(self.shape) > 1:
            waves = fft(waves, self._padded[0], axis=-2, overwrite_x=True)
        return np.asarray(waves)

    def _map(self, waves: Maps) -> Maps:
        """The way back, on the grid's rows alone, with more columns than the grid has. `waves` is overwritten."""
        from scipy.fft import ifft, irfft

        if len(self.shape) > 1:
            waves = ifft(waves, axis=-2, overwrite_x=True)[..., : self.shape[0], :]
        return np.asarray(irfft(waves, self._padded[-1], overwrite_x=True))

    def _cut(self, wide: Maps) -> Maps:
        return wide[..., : self.shape[-1]]

    def normal(self, pressure: Maps) -> Maps:
        """u_x at every node under a pressure [m], in single precision if that is given so."""
        return self._cut(self.normal_wide(pressure))

    def normal_wide(self, pressure: Maps) -> Maps:
        """The same with more columns, which mean nothing: what is cut off is no longer in one piece."""
        return self._map(_scaled(self._waves(pressure), self._of(pressure)[0]))

    def lateral(self, shear: Maps) -> Maps:
        """U along each axis under a drag, both of shape (d, ...), in single precision if that is given so."""
        return self._cut(self.lateral_wide(shear))

    def lateral_wide(self, shear: Maps) -> Maps:
        """The same with more columns, as of `normal_wide`."""
        return self._map(_turned(self._waves(shear), self._of(shear)[1 : 4 if len(shear) > 1 else 2]))

    def lifted(self, shear: FloatArray) -> FloatArray:
        """u_x under a drag."""
        if not self.coupled or not shear.any():
            return np.zeros(self.shape)
        waves = self._waves(shear) * self._coupling
        return self._cut(self._map(waves[0] if len(waves) == 1 else waves[0] + waves[1]))

    def dragged(self, pressure: FloatArray) -> FloatArray:
        """U along each axis under a pressure."""
        if not self.coupled:
            return np.zeros((len(self.shape), *self.shape))
        return np.negative(self._cut(self._map(self._waves(pressure) * self._coupling)))

    @cached_property
    def _coupling(self) -> Maps:
        """Of the rows by which pressure and drag move each other's surface, whose spectra are imaginary."""
        return np.multiply(1j, self._spectra[-len(self.shape) :])

    def nearly_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """What pressure nearly makes a displacement: that of a grid which repeats. It may be larger than the grid."""
        return self._repeated(residual, lambda waves: _scaled(waves, self._inverse))

    def nearly_lateral_wide(self, residual: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """As `nearly_wide`, of drags (2, n, k)."""
        return self._repeated(residual, lambda waves: _turned(waves, self._lateral_inverse))

    def _repeated(self, residual: npt.NDArray[np.float32], times: Any) -> npt.NDArray[np.float32]:
        from scipy.fft import irfft2, rfft2

        return np.asarray(irfft2(times(rfft2(residual, self._tiled)), self._tiled, overwrite_x=True))

    @cached_property
    def _inverse(self) -> npt.NDArray[np.float32]:
        return inverted(spectrum(self.rows[0], self._tiled, self.signs[0])).astype(np.float32)

    @cached_property
    def _lateral_inverse(self) -> npt.NDArray[np.float32]:
        return lateral_inverse(*(spectrum(self.rows[i], self._tiled, self.signs[i]) for i in (1, 2, 3)))

    @cached_property
    def circulants(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """On a row, of the pressure and of the drag: spectra of the operator, and of one that nearly undoes it."""
        near = [inverted(spectrum(row, self._tiled, (1,))) for row in self.rows[:2]]
        return tuple(zip(self._spectra, near, strict=False))

    @cached_property
    def typical(self) -> float:
        """What nearly makes a node's own unit displacement along the surface, at that node [Pa/m]."""
        unit = np.zeros((2, *self.shape), dtype=np.float32)
        unit[0, 0, 0] = 1.0
        return float(self.nearly_lateral_wide(unit)[0, 0, 0])

    @property
    def by(self) -> int:
        """Nodes of this grid to a node of a coarser one, along each axis."""
        return 4 if len(self.shape) == 1 else 2

    @cached_property
    def coarser(self) -> Influence:
        """The same for every `by`-th node: a wide hat is a sum of narrow ones.

        Near the end of a row that does not repeat the sum runs over what is not known, and repeats the last: a coarse
        answer is only ever a start.
        """
        rows = [self._thinned(row, signs) for row, signs in zip(self.rows, self.signs, strict=True)]
        return Influence(np.ascontiguousarray(rows), self.periodic)

    def _thinned(self, row: FloatArray, signs: Signs) -> FloatArray:
        shares = 1 - np.abs(np.arange(1 - self.by, self.by)) / self.by
        for axis, sign in enumerate(signs):
            row = np.moveaxis(row, axis, -1)
            count, more = row.shape[-1], self.by - 1
            before = row[..., count - more :] if self.periodic else sign * row[..., more:0:-1]
            after = row[..., :more] if self.periodic else np.repeat(row[..., -1:], more, axis=-1)
            wide = np.concatenate([before, row, after], axis=-1)
            parts = [share * wide[..., i : i + count : self.by] for i, share in enumerate(shares)]
            row = np.moveaxis(np.sum(parts, axis=0), -1, axis)
        return row

    @cached_property
    def _cropped(self) -> dict[tuple[int, ...], Influence]:
        return {}

    @cached_property
    def quarters(self) -> dict[tuple[bool, bool], Any]:
        """Operators on a quarter of the grid, by parity (quarter.py)."""
        return {}

    def cropped(self, shape: tuple[int, int]) -> Influence:
        """The same on a part of the grid."""
        if shape == self.shape:
            return self
        if shape not in self._cropped:
            self._cropped[shape] = Influence(np.ascontiguousarray(self.rows[:, : shape[0], : shape[1]]))
        return self._cropped[shape]

    def direct(self, pressure: FloatArray, shear: FloatArray, at: tuple[int, ...]) -> FloatArray:
        """u_x at a node and, where drags are known, u along each axis, summed term by term."""
        out = np.zeros(1 + self.drags * len(shear))
        out[0] = self._summed(0, pressure, at)
        if not self.drags:
            return out
        rubs = [(i, q) for i, q in enumerate(shear) if q.any()]
        first = len(self.rows) - len(shear)  # of the rows by which pressure and drag move each other's surface
        for i, q in rubs:
            out[1 + i] += self._summed(1 + i, q, at)
            if len(shear) > 1:
                out[2 - i] += self._summed(3, q, at)
        if self.coupled:
            out[0] += sum(self._summed(first + i, q, at) for i, q in rubs)
            # what a pressure moves along the surface is minus what a drag along there lifts
            out[1:] -= [self._summed(i, pressure, at) for i in range(first, len(self.rows))]
        return out

    def _summed(self, i: int, traction: FloatArray, at: tuple[int, ...]) -> float:
        row, total, every = self.rows[i], 0.0, list(range(traction.ndim))
        for parts in product(*map(_halves, row.shape, at, self.signs[i])):
            near, along, turns = zip(*parts, strict=True)
            total += prod(turns) * float(np.einsum(row[near], every, traction[along], every, []))
        return total


def _scaled(waves: Maps, by: Maps) -> Maps:
    """A spectrum times a real one, in place."""
    if waves.ndim == 1:
        waves *= by
    else:
        scaled(waves.view(by.dtype), by)
    return waves


def _turned(waves: Maps, by: Any) -> Maps:
    """Spectra of a drag's components times a symmetric matrix of real ones, in place."""
    if len(waves) == 1:
        waves *= by[0]
    else:
        turned(waves.view(by[0].dtype), *by)
    return waves


def _halves(count: int, i: int, sign: int) -> Iterator[tuple[slice, slice, int]]:
    """Parts of a row, of the nodes on either side of node i, and by what they are turned: odd rows have no middle."""
    first = int(sign < 0)
    yield slice(first, count - i), slice(i + first, count), sign
    yield slice(1, i + 1), slice(i - 1, None, -1) if i else slice(0, 0), 1


@lru_cache(maxsize=32)
def influence(
    skin: Skin,
    step: float,
    shape: tuple[int, ...],
    drag: bool = True,
    periodic: bool = False,
    datum: float | None = None,
) -> Influence:
    """The operator of a skin on a grid, kept for the next call; what a `drag` does is always known on a row.

    A skin without a ground moves by a constant that is not known: along a row it is such that the surface rests at the
    distance `datum`, or at the window's end where there is none. Either way all is positive definite.
    """
    if len(shape) == 2:
        rows = np.ascontiguousarray(skin.area_influence(step, shape, drag))
    else:
        (count,) = shape
        every = _repeated(skin, step, count) if periodic else _plain(skin, step, count, datum)
        rows = every[[0, 1, 0], [0, 1, 1]]
    rows.flags.writeable = False
    return Influence(rows, periodic)


def _plain(skin: Skin, step: float, count: int, datum: float | None) -> FloatArray:
    """Influence coefficients, shape (2, 2, count) [m/Pa]: displacement u_x or u_y by a pressure or a shear."""
    rows = np.array(skin.surface_influence(step, count))
    if not skin.grounded:
        rest = rows[:, :, -1]
        if datum is not None:
            wide = datum / _DATUM_STEPS  # so far away, a hat of this width is a line
            rest = skin.surface_influence(wide, _DATUM_STEPS + 1)[:, :, -1] * (step / wide)
        rows -= _diagonal(rest)
    return rows


def _repeated(skin: Skin, step: float, count: int) -> FloatArray:
    """The same where hats repeat every `count` nodes; without a ground, without the mean."""
    rows = _waves_that_fit(skin, step, count)
    if skin.grounded:
        # what the waves leave out: an even traction, of which a hat is one count-th
        rows += _diagonal(skin.surface_compliance(_STILL / skin.thickness)) / count
    return rows


def _waves_that_fit(skin: Skin, step: float, count: int) -> FloatArray:
    """Influence where hats repeat every `count` nodes: a sum over the waves that fit.

    The mean is left out. On a grid a wave is known up to multiples of the grid's own wavenumber
    g. In the sum over those, each with the hat's spectrum, C(k) k soon is that of short waves; from there on it is a
    zeta function.
    """
    from scipy.fft import irfft
    from scipy.special import zeta

    def compliance(k: float) -> FloatArray:
        """C(k) k, which has a limit at short waves [1/Pa]."""
        return np.asarray(skin.surface_compliance(k)) * k

    share = np.arange(1, count // 2 + 1) / count  # of the grid's own wavenumber
    grid = 2 * np.pi / step
    order, limit = 0, compliance(grid * 1e4)
    while order < _ALIASES and np.abs(compliance(grid * (order + 0.5)) - limit).max() > 1e-14 * limit[0, 0]:
        order = 2 * order + 1
    hat = (np.sin(np.pi * share) / np.pi) ** 2
    above, below = zeta(3, order + 1 + share), zeta(3, order + 1 - share)
    values = limit[:, :, None] * np.stack([above + below, above - below])[[[0, 1], [1, 0]]]
    for i in range(-order, order + 1):
        waves = share + i
        c = np.moveaxis(skin.surface_compliance(grid * np.abs(waves)), 0, -1) * grid / waves**2
        values += c * np.where(np.eye(2, dtype=bool)[:, :, None], 1.0, np.sign(waves))
    values = values * (hat / grid)
    # a pressure cos makes u_y a sine, -i sgn(k); a shear makes u_x a cosine of a sine, +i sgn(k)
    waves = values * np.array([[1, 1j], [-1j, 1]])[:, :, None]
    if count % 2 == 0:
        waves[0, 1, -1] = waves[1, 0, -1] = 0.0
    return np.asarray(irfft(np.concatenate([np.zeros((2, 2, 1)), waves], axis=2), count))


def _diagonal(matrix: FloatArray) -> FloatArray:
    return np.where(np.eye(2, dtype=bool), matrix, 0.0)[:, :, None]
