"""The smoothness of a traction as a prior: its covariance along a row, or on an area, and how wide images are there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen

__all__ = ["Bridge", "Membrane", "Prior", "half_widths"]

_BLOCK = 1 << 22

Images = Callable[[slice], FloatArray]
"""What a narrow pressure at each of some nodes looks like, shape (m, k)."""


class Prior(Protocol):
    """The covariance C of a traction, the inverse of the smoothness form in the heights of the elements."""

    @property
    def shape(self) -> tuple[int, int]:
        """Lines of inner nodes, and nodes on each; m is their product."""

    @property
    def area(self) -> float:
        """Of an element [m, or m^2]."""

    @property
    def stencil(self) -> FloatArray:
        """The form between nodes so many lines (0, 1) and so many nodes along a line (0, 1) apart, shape (2, 2)."""

    def coarser(self, times: tuple[int, int]) -> Prior:
        """That of elements so many times as wide."""

    @property
    def variance(self) -> FloatArray:
        """The diagonal of C, shape (m,)."""

    def applied(self, columns: FloatArray) -> FloatArray:
        """C times columns of shape (m, n)."""

    def widths(self, images: Images) -> FloatArray:
        """Full width at half height of each node's image [m], shape (m,)."""


@dataclass(frozen=True)
class Bridge(Frozen):
    """Of the integral of (dp/dy)^2 over hats that are 0 at both ends: that of a Brownian bridge.

    Parameters
    ----------
    count : int
        Inner nodes, m.
    step : float
        Distance of the nodes [m].
    """

    count: int
    step: float

    @property
    def shape(self) -> tuple[int, int]:  # noqa: D102
        return 1, self.count

    @property
    def area(self) -> float:  # noqa: D102
        return self.step

    @property
    def stencil(self) -> FloatArray:  # noqa: D102
        return np.array([[2.0, -1.0], [0.0, 0.0]]) / self.step

    def coarser(self, times: tuple[int, int]) -> Bridge:  # noqa: D102
        return Bridge(self.count // times[1], self.step * times[1])

    @cached_property
    def _covariance(self) -> FloatArray:
        """min(y, y') (length - max(y, y')) / length, shape (m, m)."""
        i, end = np.arange(1.0, self.count + 1), self.count + 1
        return np.asarray(self.step * np.minimum.outer(i, i) * (end - np.maximum.outer(i, i)) / end)

    @property
    def variance(self) -> FloatArray:  # noqa: D102
        return np.diagonal(self._covariance)

    def applied(self, columns: FloatArray) -> FloatArray:  # noqa: D102
        return np.asarray(self._covariance @ columns)

    def widths(self, images: Images) -> FloatArray:  # noqa: D102
        return half_widths(images(slice(None)), np.arange(self.count)) * self.step


@dataclass(frozen=True)
class Membrane(Frozen):
    """Of the integral of |grad p|^2 over bilinear hats that are 0 on the border: that of a stretched membrane.

    Parameters
    ----------
    shape : (int, int)
        Inner nodes along y and along z; m is their product.
    steps : (float, float)
        Distance of the nodes along y and along z [m].
    """

    shape: tuple[int, int]
    steps: tuple[float, float]

    @property
    def area(self) -> float:  # noqa: D102
        return self.steps[0] * self.steps[1]

    def coarser(self, times: tuple[int, int]) -> Membrane:  # noqa: D102
        counts, steps = zip(
            *((m // k, k * h) for m, h, k in zip(self.shape, self.steps, times, strict=True)), strict=True
        )
        return Membrane(counts, steps)

    @cached_property
    def stencil(self) -> FloatArray:  # noqa: D102
        (sy, my), (sz, mz) = ((np.array([2, -1]) / h, np.array([4, 1]) * h / 6) for h in self.steps)
        return np.outer(sy, mz) + np.outer(my, sz)

    @cached_property
    def form(self) -> Any:
        """The form between all nodes, a sparse matrix of shape (m, m)."""
        from scipy.sparse import diags_array, kron

        (sy, my), (sz, mz) = (
            tuple(diags_array([b, a, b], offsets=[-1, 0, 1], shape=(count, count)) for a, b in bands)
            for count, h in zip(self.shape, self.steps, strict=True)
            for bands in [((2 / h, -1 / h), (4 * h / 6, h / 6))]
        )
        return (kron(sy, mz) + kron(my, sz)).tocsr()

    @cached_property
    def _waves(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Sine waves along y and along z, orthonormal and symmetric, and the form of each product of two."""
        sines, forms = [], []
        for count, h in zip(self.shape, self.steps, strict=True):
            i = np.arange(1.0, count + 1)
            turn = np.pi * i / (count + 1)
            sines.append(np.sqrt(2 / (count + 1)) * np.sin(np.outer(i, turn)))
            forms.append(((2 - 2 * np.cos(turn)) / h, (4 + 2 * np.cos(turn)) * h / 6))
        (sy, my), (sz, mz) = forms
        return sines[0], sines[1], np.outer(sy, mz) + np.outer(my, sz)

    @cached_property
    def variance(self) -> FloatArray:  # noqa: D102
        along, across, form = self._waves
        return np.asarray((along**2 @ (1 / form) @ across**2).reshape(-1))

    def applied(self, columns: FloatArray) -> FloatArray:  # noqa: D102
        along, across, form = self._waves
        ny, nz = self.shape
        waves = across @ (along @ columns.reshape(ny, -1)).reshape(ny, nz, -1) / form[..., None]
        return np.asarray((along @ (across @ waves).reshape(ny, -1)).reshape(columns.shape))

    def widths(self, images: Images) -> FloatArray:
        """The mean (geometric) of the widths along y and along z through the peak of each image [m], shape (m,)."""
        (ny, nz), m = self.shape, self.shape[0] * self.shape[1]
        out, size = np.empty(m), max(1, _BLOCK // m)
        for first in range(0, m, size):
            part = images(slice(first, first + size))
            each = np.arange(part.shape[1])
            at_y, at_z = np.divmod(part.argmax(axis=0), nz)
            own_y, own_z = np.divmod(first + each, nz)
            field = part.reshape(ny, nz, -1)
            along = half_widths(field[:, at_z, each], own_y) * self.steps[0]
            across = half_widths(field[at_y, :, each].T, own_z) * self.steps[1]
            out[first : first + size] = np.sqrt(along * across)
        return out


def half_widths(columns: FloatArray, own: npt.NDArray[np.intp]) -> FloatArray:
    """Full width at half height of each column's peak, in rows, reaching at least to the column's `own` row.

    A load that is seen elsewhere, or not at all, is so given the distance to where it is seen.
    """
    count, many = columns.shape
    padded = np.pad(columns, ((1, 1), (0, 0)))
    own = own + 1
    peak = padded.argmax(axis=0)
    half = 0.5 * padded[peak, np.arange(many)]
    out = np.empty(many)
    for j in range(many):
        below = np.flatnonzero(padded[:, j] <= half[j])
        left, right = below[below < peak[j]], below[below > peak[j]]
        if not left.size or not right.size:
            out[j] = count + 1.0
            continue
        a, b = left[-1], right[0]
        at = padded[:, j]
        low = a + (half[j] - at[a]) / (at[a + 1] - at[a])
        high = b - (half[j] - at[b]) / (at[b - 1] - at[b])
        if (a == 0) != (b == count + 1):  # cut off by an end of the search: as wide on that side as on the other
            low, high = (2 * peak[j] - high, high) if a == 0 else (low, 2 * peak[j] - low)
        out[j] = max(high, own[j]) - min(low, own[j])
    return out
