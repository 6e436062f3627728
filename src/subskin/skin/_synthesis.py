"""From a skin's answer to each wavenumber to its answer to a contact: one sum over wavenumbers for all points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..contact.base import Contact
from ..errors import GeometryError
from ..material import Material
from ..tensor import State, Strain, Stress

__all__ = ["Answer", "layers_hooke", "of_layers", "panels", "reach", "remembered", "synthesise"]

Answer = Callable[[FloatArray], FloatArray]
"""Amplitudes at depths x, shape (x, k, 3, 2): of sigma_x, tau_xy and eps_y, under p = cos(k y) and under q = sin(k y).

sigma_x and eps_y go with cos(k y), tau_xy with sin(k y).
"""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_MOST_PANELS = 1e5
_PHASE = 12.0
"""Phase [rad] that 16 Gauss nodes integrate to rounding, with something to spare."""

_TABLE = 1 << 22
"""Most elements of a table of exp(i k y)."""

_SMALL = 1 << 16
"""Most elements of an answer that is kept."""


def panels(last: float, reach: float) -> tuple[FloatArray, FloatArray]:
    """Wavenumbers in (0, last) [1/m] and weights for integrands that oscillate like cos(k reach); finer towards 0.

    Towards 0 the panels shrink threefold each, for what a skin does at long waves depends on log k: a stiff layer on a
    soft one bends, a nearly incompressible one is squeezed.
    """
    width = _PHASE / reach
    if not last < _MOST_PANELS * width:
        seen = f"points up to {reach:.3g} m away, in a skin whose finest wave falls off within {1 / last:.3g} m"
        raise GeometryError(seen, "the sum over waves would be too long", "nearer points, or deeper ones")
    small = min(width, last) * 3.0 ** np.arange(-12, 1)
    count = max(int(np.ceil((last - small[-1]) / width)), 0)
    edges = np.concatenate([[0.0], small, np.linspace(small[-1], last, count + 1)[1:]])
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (1 + _NODES)).reshape(-1), (half * _WEIGHTS).reshape(-1)


def remembered(response: Answer) -> Answer:
    """The same, which keeps its last answer where that is small: sensors ask for the same depths again and again."""
    kept: list[FloatArray] = []

    def answer(depths: FloatArray) -> FloatArray:
        if not (kept and np.array_equal(kept[0], depths)):
            found = response(depths)
            if found.size > _SMALL:
                return found
            kept[:] = depths, found
        return kept[1]

    return answer


def reach(contact: Contact, y: FloatArray) -> float:
    """The largest distance [m] between a point of the contact and one of the positions y."""
    low, high = map(np.asarray, contact.support)
    if not y.size or not low.size:
        return 0.0
    return max(float(y.max() - low.min()), float(high.max() - y.min()), 0.0)


def synthesise(
    contact: Contact, x: FloatArray, y: FloatArray, k: FloatArray, weights: FloatArray, response: Answer
) -> FloatArray:
    """Sum over k of weight * response * spectrum * exp(i k y) / pi: sigma_x, tau_xy, eps_y, shape (3, ...).

    Points (x and y of one shape) broadcast against the contact's batch. Where an axis is the contact's alone or the
    points' alone, the sum is a matrix product.
    """
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    axes = len(shape)
    batch = (1,) * (axes - len(contact.shape)) + contact.shape
    positions = (1,) * (axes - x.ndim) + x.shape
    shared = [i for i in range(axes) if batch[i] > 1 and positions[i] > 1]
    own = [i for i in range(axes) if i not in shared and batch[i] > 1]
    free = [i for i in range(axes) if i not in shared and i not in own]
    order = shared + own + free
    together, rows, columns = (int(np.prod([shape[i] for i in part])) for part in (shared, own, free))
    spectra = []
    for part in contact.expand(1).spectrum(k):
        every = np.broadcast_to(part, (*contact.shape, k.size)).reshape(*batch, k.size)
        spectra.append(every.transpose(*order, axes).reshape(together, rows, k.size))
    xs, ys = (a.reshape(positions).transpose(order).reshape(together, columns) for a in (x, y))
    depths, which = np.unique(xs, return_inverse=True)
    which = which.reshape(xs.shape)
    out = np.empty((3, together, rows, columns))
    size = max(1, _TABLE // max(1, 6 * k.size))  # depths at a time
    for first in range(0, depths.size, size):
        answers = response(depths[first : first + size])
        for i in range(together):
            table, loads = _Waves(k, ys[i]), [_Load.of(part[i], weights) for part in spectra]
            for j in np.unique(which[i]):
                if first <= j < first + size:
                    chosen = np.flatnonzero(which[i] == j)
                    out[:, i][:, :, chosen] = _at_depth(answers[j - first], loads, rows, table, chosen)
    back = np.argsort(order)
    lengths = [shape[i] for i in order]
    return out.reshape(3, *lengths).transpose(0, *(1 + back))


def of_layers(
    contact: Contact,
    x: FloatArray,
    y: FloatArray,
    materials: tuple[Material, ...],
    positions: npt.NDArray[np.intp],
    waves: Callable[[], tuple[FloatArray, FloatArray, Answer]],
    closed: Callable[[Contact], FloatArray],
) -> State:
    """The state at points of layers: what `synthesise` makes of `waves`, and in the first layer a closed form.

    `positions` says in which of the `materials` each point lies; `closed` gives sigma_x, tau_xy and eps_y, (3, ...).
    """
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    if not np.prod(shape):
        return hooke(np.zeros((3, *shape)), materials[0])
    fields, upper = synthesise(contact, x, y, *waves()), positions == 0
    if upper.any():
        own = closed(contact)
        fields += own if upper.all() else np.where(upper, own, 0.0)
    return layers_hooke(fields, materials, np.broadcast_to(positions, shape))


class _Waves:
    """exp(i k y) at the positions y, those that occur twice evaluated once."""

    def __init__(self, k: FloatArray, y: FloatArray) -> None:
        self.k, self.y = k, y
        self.positions, self.index = np.unique(y, return_inverse=True)
        few = self.positions.size * k.size <= _TABLE and self.positions.size <= 0.5 * y.size
        self.table = self._waves(self.positions) if few else None

    def _waves(self, y: FloatArray) -> FloatArray:
        phase = self.k[:, None] * y
        return np.concatenate([np.cos(phase), np.sin(phase)])

    def blocks(self, chosen: npt.NDArray[np.intp]) -> list[tuple[slice, FloatArray]]:
        """Slices of `chosen`, and cos and sin there below each other, shape (2 k, slice)."""
        if self.table is not None:
            return [(slice(None), self.table[:, self.index[chosen]])]
        size = max(1, _TABLE // self.k.size)
        starts = range(0, chosen.size, size)
        return [(slice(s, s + size), self._waves(self.y[chosen[s : s + size]])) for s in starts]


class _Load(NamedTuple):
    """The rows of a contact that load the skin along one direction; their spectra, real beside imaginary parts."""

    rows: npt.NDArray[np.intp] | slice
    spectrum: FloatArray

    @classmethod
    def of(cls, spectrum: ComplexArray, weights: FloatArray) -> _Load:
        """Of spectra (rows, k), with the weights (k,) of their wavenumbers."""
        some = spectrum.any(axis=1)
        rows = slice(None) if some.all() else np.flatnonzero(some)
        chosen = spectrum[rows]
        both = np.empty((len(chosen), 2 * weights.size))
        np.multiply(chosen.real, weights, out=both[:, : weights.size])
        np.multiply(chosen.imag, weights, out=both[:, weights.size :])
        return cls(rows, both)


def _at_depth(
    answer: FloatArray, loads: list[_Load], count: int, waves: _Waves, chosen: npt.NDArray[np.intp]
) -> FloatArray:
    """Fields (3, count, chosen) at one depth, of `count` rows: `answer` (k, 3, 2)."""
    # sigma_x and eps_y go with cos under p and turn with q; tau_xy the other way round
    turns = np.array([[1, 1j], [-1j, 1], [1, 1j]])
    factors = (answer * turns)[..., None] / np.pi  # (k, 3, 2, 1)
    out = np.zeros((3, count, chosen.size))
    for part, both in waves.blocks(chosen):
        for i, (rows, spectrum) in enumerate(loads):
            n, columns = len(spectrum), both.shape[1]
            # the smaller of the two sides of the product takes the factors
            if n < columns:
                left = _turned(spectrum.T[:, None], factors[:, :, i]).reshape(len(both), 3 * n)
                out[:, rows, part] += (left.T @ both).reshape(3, n, columns)
            else:
                right = _turned(both[:, None], factors[:, :, i]).reshape(len(both), 3 * columns)
                out[:, rows, part] += (spectrum @ right).reshape(n, 3, columns).transpose(1, 0, 2)
    return out


def _turned(values: FloatArray, factors: ComplexArray) -> FloatArray:
    """Of (a + i b) f the real part and, below it, minus the imaginary one: `values` are a above b, (2 k, ...)."""
    a, b = np.split(values, 2)
    return np.concatenate([a * factors.real - b * factors.imag, -a * factors.imag - b * factors.real])


def hooke(fields: FloatArray, material: Material) -> State:
    """Stress and strain in plane strain from sigma_x, tau_xy [Pa] and eps_y [-], shape (3, ...): finite at nu = 1/2."""
    sx, txy, ey = fields
    nu, double = material.poisson, 2 * material.shear
    sy = (double * ey + nu * sx) / (1 - nu)
    ex = (1 - 2 * nu) / (1 - nu) * sx / double - nu / (1 - nu) * ey
    strain = Strain(ex, ey, np.zeros(ey.shape), txy / double)
    return State(Stress(sx, sy, nu * (sx + sy), txy), strain)


def layers_hooke(fields: FloatArray, materials: tuple[Material, ...], positions: npt.NDArray[np.intp]) -> State:
    """Hooke's law of the layer in which each point lies."""
    if len(materials) == 1:
        return hooke(fields, materials[0])
    states = [hooke(fields, m) for m in materials]

    def picked(tensors: Sequence[Stress | Strain]) -> list[FloatArray]:
        return [np.choose(positions, [getattr(t, c) for t in tensors]) for c in ("xx", "yy", "zz", "xy")]

    return State(Stress(*picked([s.stress for s in states])), Strain(*picked([s.strain for s in states])))
