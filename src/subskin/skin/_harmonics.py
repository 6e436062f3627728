"""What a stack of layers adds to a half space under a contact of any outline: harmonics about its centre, as tables.

The spectrum on circles of wave vectors is a sum of exp(i l phi), the answer to it one of i^l exp(i l theta) J_l(k r).
A contact within a of its centre has, where waves fall off as exp(-k length), harmonics up to 37 / asinh(length / a):
then J_l(k a) exp(-k length) < exp(-37) at any k. Each is kept over the distance r in pieces of Chebyshev polynomials.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import ComplexArray, FloatArray
from ..contact.local import LocalSpectrum
from ._layer_modes import Stack
from ._radial import NODES, ORDER, TAIL, TO_TERMS, decay_length, polynomials, wave_answers, waves_for

__all__ = ["SLOPE", "STATE_FIELDS", "HarmonicFields", "HarmonicTable"]

_DIGITS = 37.0
"""exp(-37) is left out."""
_FINEST = 1 / 32
_BLOCK = 1 << 21


class HarmonicFields(NamedTuple):
    """How many fields there are, and what they are on circles of wave vectors."""

    fields: int
    of: Callable[[FloatArray, FloatArray, LocalSpectrum, FloatArray, FloatArray], list[ComplexArray]]


class HarmonicTable:
    """Some real fields about a contact's centre, at one depth of a stack, as far as they were asked for.

    `STATE_FIELDS`: the six of `Primitives` (xx, spread, real and imaginary part of shear and turned), then 2 G u_x, u_y
    and u_z. `SLOPE`: 2 G du_x/dy and 2 G du_x/dz.

    Parameters
    ----------
    stack : Stack
        The layers.
    depth : float
        Where [m].
    spectrum : callable
        That of a single contact about its centre.
    size : float
        Distance of the contact's farthest point from its centre [m].
    kind : HarmonicFields
        Which fields.
    """

    def __init__(
        self,
        stack: Stack,
        depth: float,
        spectrum: Callable[[FloatArray, FloatArray], LocalSpectrum],
        size: float,
        kind: HarmonicFields,
    ) -> None:
        self._stack, self._depth, self._spectrum, self._size, self._kind = stack, depth, spectrum, size, kind
        self._length = float(decay_length(stack, np.array(depth)))
        count = 0 if size == 0 else int(np.ceil(_DIGITS / np.arcsinh(self._length / size)))
        self._count = count + 5
        self._pieces: dict[tuple[float, float], FloatArray | None] = {}
        self._known: tuple[FloatArray, FloatArray, FloatArray] | None = None

    def at(self, zeta: ComplexArray, which: slice) -> FloatArray:
        """Fields at y + i z about the centre [m], shape (fields, n)."""
        r = np.abs(zeta)
        e = np.asarray(np.where(r > 0, zeta, 1.0) / np.where(r > 0, r, 1.0), dtype=np.complex128)
        out = np.empty((len(range(self._kind.fields)[which]), r.size))
        low, high, farthest = 0.0, 0.75 * self._length, r.max(initial=0.0)
        while low <= farthest:
            chosen = np.flatnonzero((low <= r) & (r < high))
            if chosen.size:
                self._fill(out, chosen, r, e, low, high, which)
            low, high = high, high + self._length + max(high - self._size, 0.0)
        return out

    def _fill(
        self,
        out: FloatArray,
        chosen: npt.NDArray[np.intp],
        r: FloatArray,
        e: ComplexArray,
        low: float,
        high: float,
        which: slice,
    ) -> None:
        """Columns `chosen` of `out`, which lie between two distances."""
        if (low, high) not in self._pieces and chosen.size < ORDER:
            values = self._harmonics(r[chosen], high)[0][..., which, :]
        else:
            terms = self._piece(low, high)
            if terms is None:
                middle = 0.5 * (low + high)
                for start, end in ((low, middle), (middle, high)):
                    part = chosen[(start <= r[chosen]) & (r[chosen] < end)]
                    if part.size:
                        self._fill(out, part, r, e, start, end, which)
                return
            start = low if low > 0 else -high
            values = polynomials(
                terms[:, :, :, which].reshape(ORDER, -1), (2 * r[chosen] - start - high) / (high - start)
            )
            values = values.reshape(-1, 2, len(out), chosen.size)
        total, turn = np.zeros((len(out), chosen.size)), np.ones(chosen.size, dtype=np.complex128)
        for real, imaginary in values:
            total += turn.real * real - turn.imag * imaginary
            turn = turn * e[chosen]
        out[:, chosen] = total

    def _piece(self, low: float, high: float) -> FloatArray | None:
        """Chebyshev terms, (order, harmonics, 2, fields); None where they have to be finer.

        The first goes on beyond the centre, where harmonics are even or odd as their number is.
        """
        if (low, high) not in self._pieces:
            start = low if low > 0 else -high
            r = 0.5 * (start + high) + 0.5 * (high - start) * NODES
            values, size = self._harmonics(np.abs(r), high)
            values[1::2, :, :, r < 0] *= -1
            terms = np.moveaxis(values @ TO_TERMS.T, -1, 0)
            coarse = (np.abs(terms[-3:]).max(axis=(0, 1, 2)) > TAIL * size).any()
            self._pieces[low, high] = None if coarse and high - low > _FINEST * self._length else terms
        return self._pieces[low, high]

    def _harmonics(self, r: FloatArray, far: float) -> tuple[FloatArray, FloatArray]:
        """Real and imaginary part of each, (harmonics, 2, fields, n), at distances up to `far`; the size of the sum."""
        k, weights = waves_for(self._stack, self._length, far + self._size)
        fields = self._kind.fields
        values, size = np.zeros((self._count, 2 * fields, r.size)), np.zeros(fields)
        step = max(1, _BLOCK // (fields * self._count), _BLOCK // (self._count * r.size))
        for first in range(0, k.size, step):
            part = slice(first, first + step)
            waves, more = self._waves(k[part], weights[part], k.size)
            values += waves @ _bessel(self._count, k[part, None] * r)
            size += more
        parts = values.reshape(-1, 2, fields, r.size)
        parts[1:] *= 2
        turn = np.array([-1.0, 1.0])[:, None, None]  # times i
        parts[1::4], parts[2::4], parts[3::4] = parts[1::4, ::-1] * turn, -parts[2::4], -parts[3::4, ::-1] * turn
        return parts, size

    def _waves(self, k: FloatArray, weights: FloatArray, total: int) -> tuple[FloatArray, FloatArray]:
        """Real and imaginary parts of the waves' harmonics, weighed, (harmonics, 2 fields, k), and sums; kept."""
        if self._known is not None and np.array_equal(k, self._known[0]):
            return self._known[1:]
        answers = wave_answers(self._stack, k, np.array([self._depth]))[:, 0]
        waves = _on_circles(self._kind, answers, k, self._spectrum, self._count) * (k * weights / (2 * np.pi))[:, None]
        size = np.abs(waves).sum(axis=(1, 2))
        both = np.ascontiguousarray(np.concatenate([waves.real, waves.imag]).transpose(2, 0, 1))
        if k.size == total:
            self._known = k, both, size
        return both, size


def _on_circles(
    kind: HarmonicFields,
    answers: FloatArray,
    k: FloatArray,
    spectrum: Callable[[FloatArray, FloatArray], LocalSpectrum],
    count: int,
) -> ComplexArray:
    """Harmonics 0 ... count - 1 of the fields on circles of wave vectors, (fields, k, count)."""
    phi = np.pi * np.arange(count) / count
    cos, sin = np.cos(phi), np.sin(phi)
    p, qy, qz = spectrum(k[:, None] * cos, k[:, None] * sin)
    ql, qt = qy * cos + qz * sin, qz * cos - qy * sin
    half = np.stack(kind.of(answers[..., None], k[:, None], LocalSpectrum(p, ql, qt), cos, sin))
    # the other half of the circle is the conjugate
    return np.fft.fft(np.concatenate([half, np.conj(half)], axis=-1), axis=-1)[..., :count] / (2 * count)


def _of_state(
    answers: FloatArray, k: FloatArray, loads: LocalSpectrum, cos: FloatArray, sin: FloatArray
) -> list[ComplexArray]:
    """Under loads of which the drag is along the wave and across it."""
    an, at, cn, ct, ln, lt, un, ut, c, b = answers
    p, ql, qt = loads
    along, across = 1j * ln * p + lt * ql, 2 * b * qt  # 2 G k u_l and u_t
    stretch, sheared = 1j * along, 1j * across
    xl, xt = 1j * cn * p + ct * ql, c * qt
    double, twice = cos * cos - sin * sin, 2 * sin * cos
    return [
        an * p + 1j * at * ql,
        stretch,
        xl * cos - xt * sin,
        xl * sin + xt * cos,
        stretch * double - sheared * twice,
        stretch * twice + sheared * double,
        (un * p + 1j * ut * ql) / k,
        (along * cos - across * sin) / k,
        (along * sin + across * cos) / k,
    ]


def _of_slope(
    answers: FloatArray, k: FloatArray, loads: LocalSpectrum, cos: FloatArray, sin: FloatArray
) -> list[ComplexArray]:
    """2 G u_x times i k, along y and along z."""
    down = 1j * answers[6] * loads.p - answers[7] * loads.qy
    return [down * cos, down * sin]


STATE_FIELDS, SLOPE = HarmonicFields(9, _of_state), HarmonicFields(2, _of_slope)


def _bessel(count: int, x: FloatArray) -> FloatArray:
    """J_l(x) for l = 0 ... count - 1, shape (count, ...)."""
    from scipy.special import j0, j1

    from ._bessel_kernel import bessel

    out, at = np.empty((count, x.size)), x.reshape(-1)
    bessel(at, j0(at), j1(at), out)
    return out.reshape(count, *x.shape)
