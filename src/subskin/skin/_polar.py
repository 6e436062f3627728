"""What a stack of layers adds to a half space under any local contact: its spectrum, wave vector by wave vector.

Along each direction by the panels of `_synthesis`, over the directions by the trapezoidal rule. n directions leave out
J_n(k R) exp(-k length), R being the distance from the far side of the contact: at most exp(-n asinh(length / R)).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from ..contact.local import LocalContact
from ..errors import GeometryError
from ._layer_modes import Stack
from ._radial import answers_at, decay_length, waves_for

__all__ = ["polar_displacements", "polar_fields"]

_DIGITS = 37.0
"""exp(-37) is left out."""
_CLASSES = 2
"""Distances between one and twice as far for which wave vectors are chosen."""
_MOST = 3e7
_BLOCK = 1 << 19


def polar_fields(
    stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray, ComplexArray, ComplexArray]:
    """The four fields of `Primitives`."""
    xx, spread, xy, xz, turned, across = _summed(stack, contact, x, y, z, False)
    return xx, spread, xy + 1j * xz, turned + 1j * across


def polar_displacements(
    stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray
) -> tuple[FloatArray, ComplexArray]:
    """2 G u_x and 2 G (u_y + i u_z) [Pa m], G of the first layer."""
    down, along, across = _summed(stack, contact, x, y, z, True)
    return down, along + 1j * across


def _summed(
    stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray, moved: bool
) -> FloatArray:
    """Fields, or displacements, at points of one shape, which broadcasts against the batch."""
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    rows = np.arange(int(np.prod(contact.shape))).reshape(contact.shape)
    row, xs, ys, zs = (np.broadcast_to(a, shape).reshape(-1) for a in (rows, x, y, z))
    low, high = (np.broadcast_to(end, (*contact.shape, 2)).reshape(-1, 2)[row] for end in contact.support)
    reach = np.hypot(
        np.maximum(ys - low[:, 0], high[:, 0] - ys), np.maximum(zs - low[:, 1], high[:, 1] - zs)
    )
    length = decay_length(stack, xs)
    grade = np.ceil(_CLASSES * np.log2(np.maximum(reach / length, 0.25)))
    out = np.zeros((3 if moved else 6, xs.size))
    for depth, step in np.unique(np.stack([xs, grade]), axis=1).T:
        chosen = np.flatnonzero((xs == depth) & (grade == step))
        far = float(length[chosen[0]] * 2 ** (step / _CLASSES))
        _add(out, stack, contact, float(depth), far, chosen, row, ys, zs, moved)
    return out.reshape(-1, *shape)


def _add(
    out: FloatArray,
    stack: Stack,
    contact: LocalContact,
    depth: float,
    far: float,
    chosen: npt.NDArray[np.intp],
    row: npt.NDArray[np.intp],
    y: FloatArray,
    z: FloatArray,
    moved: bool,
) -> None:
    """Fill the columns `chosen`: points at one depth, no farther than `far` from the far side of the contact."""
    length = float(decay_length(stack, np.array(depth)))
    half = int(np.ceil(0.5 * _DIGITS / np.arcsinh(length / far))) + 4
    k, weights = waves_for(stack, length, far)
    if half * k.size > _MOST:
        seen = f"points up to {far:.3g} m from a contact that is not round, where waves fall off within {length:.3g} m"
        raise GeometryError(seen, "the sum over wave vectors would be too long", "nearer points, or a round contact")
    phi = np.pi * (np.arange(half) + 0.5) / half
    # the other half of the directions is the conjugate
    answers = answers_at(stack, depth, k) * (weights * k / (2 * np.pi * half))
    wide = contact.expand(1)
    step = max(1, _BLOCK // (half * max(1, chosen.size + int(np.prod(contact.shape)))))
    groups = [(i, chosen[row[chosen] == i]) for i in np.unique(row[chosen])]
    for first in range(0, k.size, step):
        part = slice(first, first + step)
        ky, kz = (k[part, None] * f(phi) for f in (np.cos, np.sin))
        spectrum = np.broadcast_arrays(*wide.spectrum(ky.reshape(-1), kz.reshape(-1)))
        traction = np.stack(spectrum).reshape(3, -1, *ky.shape)
        size = k[part, None] if moved else None
        for i, points in groups:
            fields = _of_waves(answers[:, part, None], *traction[:, i], np.cos(phi), np.sin(phi), size)
            turn = ky.reshape(-1, 1) * y[points] + kz.reshape(-1, 1) * z[points]
            flat = fields.reshape(len(out), -1)
            out[:, points] += flat.real @ np.cos(turn) - flat.imag @ np.sin(turn)


def _of_waves(
    answers: FloatArray,
    p: ComplexArray,
    qy: ComplexArray,
    qz: ComplexArray,
    cos: FloatArray,
    sin: FloatArray,
    k: FloatArray | None,
) -> ComplexArray:
    """The fields of each wave vector, (6, k, directions); with `k` the displacements, (3, k, directions)."""
    an, at, cn, ct, ln, lt, un, ut, c, b = answers
    ql, qt = qy * cos + qz * sin, qz * cos - qy * sin
    along = 1j * ln * p + lt * ql  # 2 G k u_l
    if k is not None:
        across = 2 * b * qt  # 2 G k u_t
        return np.stack([un * p + 1j * ut * ql, along * cos - across * sin, along * sin + across * cos]) / k
    stretch, sheared = 1j * along, 2j * b * qt
    xl, xt = 1j * cn * p + ct * ql, c * qt
    double, twice = cos * cos - sin * sin, 2 * sin * cos
    rows = [
        an * p + 1j * at * ql,
        stretch,
        xl * cos - xt * sin,
        xl * sin + xt * cos,
        stretch * double - sheared * twice,
        stretch * twice + sheared * double,
    ]
    return np.stack(rows)
