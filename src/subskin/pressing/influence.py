"""How the surface answers tractions given at equally spaced nodes: an operator of FFTs, and direct sums.

A traction is drawn by straight lines between the nodes, so it is a sum of hats, and the surface moves by the sum of
the skin's answers to each. On a line that sum is a product with a Toeplitz matrix; made circulant by zeros beyond the
window, or circulant by itself where everything repeats, it is a product of spectra.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from ..skin import Skin

__all__ = ["Influence", "exact_rows", "influence"]

_ALIASES = 60
"""Most multiples of the grid's own wavenumber summed one by one in a periodic row."""
_STILL = 1e-6
"""Wavenumber times thickness at which a wave on a skin with a ground is as good as none: what is left is its square."""
_DATUM_STEPS = 256


@dataclass(frozen=True, eq=False)
class Influence(Frozen):
    """Displacement at nodes by hats at nodes: `rows[a, b, j]` at a distance of j steps towards +y [m/Pa].

    The first index is of the displacement, u_x or u_y, the second of the traction, pressure or shear. Rows of unlike
    indices are odd in j. A periodic row runs once round the period.
    """

    rows: FloatArray
    periodic: bool

    @property
    def count(self) -> int:
        """Number of nodes."""
        return int(self.rows.shape[-1])

    @cached_property
    def coupled(self) -> bool:
        """Whether a pressure also moves the surface along itself."""
        return bool(np.abs(self.rows[0, 1]).max() > 1e-13 * np.abs(self.rows[0, 0]).max())

    @property
    def longest(self) -> float:
        """Displacement per pressure of the longest wave that fits [m/Pa]."""
        return float(np.abs(self._spectra[0][0][1]))

    @property
    def size(self) -> int:
        """Length of the transforms, a power of two."""
        return self.count if self.periodic else _power(2 * self.count - 1)

    @cached_property
    def _spectra(self) -> list[list[npt.NDArray[Any]]]:
        from scipy.fft import rfft

        out: list[list[npt.NDArray[Any]]] = [[], []]
        for a in (0, 1):
            for b in (0, 1):
                row = self.rows[a, b]
                if not self.periodic:
                    wrapped = np.zeros(self.size)
                    wrapped[: self.count] = row
                    wrapped[self.size - self.count + 1 :] = (1 if a == b else -1) * row[:0:-1]
                    row = wrapped
                spectrum = rfft(row)
                # even rows have real spectra, odd ones imaginary; what is left of the other part is rounding
                out[a].append(np.ascontiguousarray(spectrum.real) if a == b else 1j * spectrum.imag)
        return out

    def apply(self, a: int, b: int, traction: FloatArray) -> FloatArray:
        """Displacement `a` at every node by the traction `b`."""
        from scipy.fft import irfft, rfft

        if (a != b and not self.coupled) or not traction.any():
            return np.zeros(self.count)
        spectrum = rfft(traction, self.size) * self._spectra[a][b]
        return np.asarray(irfft(spectrum, self.size, overwrite_x=True))[: self.count]

    def forward(self, a: int) -> tuple[FloatArray, FloatArray]:
        """Spectrum of [a, a], and the table of its transform."""
        return self._spectra[a][a], _table(self.size)

    def backward(self, a: int) -> tuple[FloatArray, FloatArray]:
        """Spectrum of a circulant that nearly undoes [a, a], of half the length, and the table of its transform."""
        size = self.size if self.periodic else _power(self.count)
        return self._inverses[a], _table(size)

    @cached_property
    def _inverses(self) -> list[FloatArray]:
        from scipy.fft import rfft

        size = self.size if self.periodic else _power(self.count)
        away = np.minimum(np.arange(size), size - np.arange(size))
        out = []
        for a in (0, 1):
            values = rfft(self.rows[a, a][away]).real
            values[0] = values[1]
            # all are positive where the row falls ever more slowly; elsewhere the few that are not are lifted
            out.append(1 / np.maximum(values, 0.2 * np.abs(values).min(initial=np.inf, where=values > 0)))
        return out

    @cached_property
    def _coarser(self) -> dict[int, Influence]:
        return {}

    def coarser(self, by: int) -> Influence:
        """The same for every `by`-th node: a wide hat is a sum of narrow ones.

        Near the end of a row that does not repeat the sum runs over what is not known, and leaves it out: a coarse
        answer is only ever a start.
        """
        if by in self._coarser:
            return self._coarser[by]
        shares = 1 - np.abs(np.arange(1 - by, by)) / by
        length = self.count
        rows = np.zeros((2, 2, -(-length // by)))
        for a in (0, 1):
            for b in (0, 1):
                row = self.rows[a, b]
                if self.periodic:
                    wide = np.concatenate([row[length - by + 1 :], row, row[: by - 1]])
                else:
                    wide = np.concatenate([(1 if a == b else -1) * row[by - 1 : 0 : -1], row, np.full(by, row[-1])])
                rows[a, b] = np.convolve(wide, shares, mode="valid")[:length:by]
        return self._coarser.setdefault(by, Influence(rows, self.periodic))

    def direct(self, a: int, b: int, traction: FloatArray, at: npt.NDArray[np.intp]) -> FloatArray:
        """Displacement `a` at the nodes `at` by the traction `b`, summed term by term."""
        n, row = self.count, self.rows[a, b]
        if not traction.any():
            return np.zeros(at.size)
        before = row[1:] if self.periodic else (1 if a == b else -1) * row[:0:-1]
        both = np.concatenate([before, row])  # distances 1 - n ... n - 1
        return np.array([both[i : i + n][::-1] @ traction for i in at])


def exact_rows(skin: Skin, step: float, count: int, periodic: bool, datum: float | None) -> FloatArray:
    """Rows of influence coefficients, shape (2, 2, count) [m/Pa].

    A skin without a ground moves by a constant that is not known: it is such that the surface rests at the distance
    `datum`, or at the window's end where there is none. Either way all is positive definite.
    """
    if periodic:
        rows = _periodic_rows(skin, step, count)
        if skin.grounded:
            # what the waves leave out: an even traction, of which a hat is one count-th
            still = skin.surface_compliance(_STILL / skin.thickness)
            rows += np.where(np.eye(2, dtype=bool), still, 0.0)[:, :, None] / count
    else:
        rows = np.array(skin.surface_influence(step, count))
        if not skin.grounded:
            rest = rows[:, :, -1]
            if datum is not None:
                wide = datum / _DATUM_STEPS  # so far away, a hat of this width is a line
                rest = skin.surface_influence(wide, _DATUM_STEPS + 1)[:, :, -1] * (step / wide)
            rows -= np.where(np.eye(2, dtype=bool), rest, 0.0)[:, :, None]
    rows.flags.writeable = False
    return rows


def _periodic_rows(skin: Skin, step: float, count: int) -> FloatArray:
    """The same where hats repeat every `count` nodes: a sum over the waves that fit, without the mean.

    On a grid a wave is known up to multiples of the grid's own wavenumber g. In the sum over those, each with the hat's
    spectrum, C(k) k soon is that of short waves; from there on it is a zeta function.
    """
    from scipy.fft import irfft
    from scipy.special import zeta

    share = np.arange(1, count // 2 + 1) / count  # of the grid's own wavenumber
    grid = 2 * np.pi / step
    order, limit = 0, _long_times_k(skin, grid * 1e4)
    while order < _ALIASES and np.abs(_long_times_k(skin, grid * (order + 0.5)) - limit).max() > 1e-14 * limit[0, 0]:
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
    turned = values * np.array([[1, 1j], [-1j, 1]])[:, :, None]
    if count % 2 == 0:
        turned[0, 1, -1] = turned[1, 0, -1] = 0.0
    return np.asarray(irfft(np.concatenate([np.zeros((2, 2, 1)), turned], axis=2), count))


def _long_times_k(skin: Skin, k: float) -> FloatArray:
    """C(k) k, which has a limit at short waves [1/Pa]."""
    return np.asarray(skin.surface_compliance(k)) * k


def _power(length: int) -> int:
    """The power of two that is not less."""
    return 1 << max(length - 1, 7).bit_length()


@lru_cache(maxsize=16)
def _table(size: int) -> FloatArray:
    """exp(-2 pi i j / size), real and imaginary part, shape (2, size)."""
    wave = np.exp(-2j * np.pi * np.arange(size) / size)
    return np.array([wave.real, wave.imag])


@lru_cache(maxsize=16)
def influence(skin: Skin, step: float, count: int, periodic: bool, datum: float | None = None) -> Influence:
    """The operator of a skin on a grid, kept for the next call."""
    return Influence(exact_rows(skin, step, count, periodic, datum), periodic)
