"""From a local contact's families W_m to stress, strain and displacement in a half space: eight lines for all contacts.

All the Poisson's ratio there is stands here (docs/local_contacts.md).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .. import _check
from .._check import ComplexArray, FloatArray, each_read_only
from ..contact.local import LocalContact, local_potentials_of, local_transforms_of
from ..material import Material
from ..tensor import Displacements, Strain, Stress

__all__ = ["Fields", "displacements_of", "fields_of", "turns_of"]

# Points of one block: its temporaries then stay in the second-level cache.
_BLOCK = 1024


class Fields(NamedTuple):
    """What stress and strain are made of: W_0, x W_0', h = Re W_1 and x h' of the drag, shear and difference [Pa].

    `shear` is s_xy + i s_xz, `difference` s_yy - s_zz + 2 i s_yz.
    """

    w: FloatArray
    xw: FloatArray
    h: FloatArray
    xh: FloatArray
    shear: ComplexArray
    difference: ComplexArray

    def stress(self, nu: float) -> Stress:
        """Stress [Pa]."""
        w, xw, h, xh, shear, difference = self
        both = -((1 + 2 * nu) * w + xw) + 2 * (1 + nu) * h + xh
        half, turned = 0.5 * both, 0.5 * difference
        yy, zz = half + turned.real, half - turned.real
        return Stress(-w + xw - xh, yy, zz, shear.real, shear.imag, turned.imag)

    def strain(self, material: Material) -> Strain:
        """Strain [-]; at nu = 1/2 not as a difference of stresses, which are large beside it near the surface."""
        w, xw, h, xh, shear, difference = self
        nu, soft = material.poisson, 0.5 / material.shear
        xx = -(1 - 2 * nu) * w + xw - 2 * nu * h - xh
        half = 0.5 * (-((1 - 2 * nu) * w + xw) + 2 * (1 - nu) * h + xh)
        turned = 0.5 * difference
        parts = xx, half + turned.real, half - turned.real, shear.real, shear.imag, turned.imag
        return Strain(*(soft * part for part in parts))


def fields_of(contact: LocalContact, nu: float, x: FloatArray, y: FloatArray, z: FloatArray) -> Fields:
    """The fields beneath a contact at points of one shape, which broadcasts against the batch."""

    def fields(x: FloatArray, y: FloatArray, z: FloatArray) -> Fields:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # singular points are blanked by the caller
            p, dp, q, dq, r, dr, sq, t = local_transforms_of(contact, x, y, z)
            inside = x > 0
            p1, p2, p0, q1, r1, r2, r3 = (
                np.where(inside, x * d, 0.0) for d in (dp[1], dp[2], dp[0], dq[1], dr[1], dr[2], dr[3])
            )
            shear = -p1 - np.where(inside, sq, q[0]) + 0.5 * r2 - t[0]
            difference = (1 - 2 * nu) * p[2] + p2 + (2 - nu) * q[1] + nu * r[3] + 0.5 * (q1 - r3) + 2 * t[1]
        parts = p[0].real, p0.real, r[1].real, r1.real, shear, difference
        return Fields(*(np.array(part) for part in parts))

    return Fields(*_in_blocks(fields, contact, x, y, z))  # type: ignore[arg-type]


def displacements_of(
    contact: LocalContact, material: Material, x: FloatArray, y: FloatArray, z: FloatArray
) -> Displacements:
    """The displacement beneath a contact at points of one shape; infinite or NaN where there is none."""
    nu, soft = material.poisson, 0.5 / material.shear

    def moved(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, ComplexArray]:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            v, vq, vr, t = local_potentials_of(contact, x, y, z)
            p, _, q, _, r, *_ = local_transforms_of(contact, x, y, z)
            p0, p1, q0, r1, r2 = (np.where(x > 0, x * w, 0.0) for w in (p[0], p[1], q[0], r[1], r[2]))
            down = 2 * (1 - nu) * v[0].real + p0.real - r1.real - (1 - 2 * nu) * vr[1].real
            along = (1 - 2 * nu) * v[1] - p1 + (2 - nu) * vq[0] + nu * vr[2] - 0.5 * (q0 - r2) - 2 * t
        return soft * down, soft * along

    down, along = _in_blocks(moved, contact, x, y, z)
    return Displacements(*each_read_only(down, along.real, along.imag))


def turns_of(contact: LocalContact, nu: float, x: FloatArray, y: FloatArray, z: FloatArray) -> ComplexArray:
    """2 G times the tilt, y + i z [Pa], beneath a contact at points of one shape.

    With L = d/dy + i d/dz it is half of d(u_y + i u_z)/dx - L u_x; by the chain of the W_m all that has x before it
    cancels, for a rotation is harmonic: -2 (1 - nu) N W_1 - (3/2 - nu) tau W_0 + (1/2 - nu) tau* W_2.
    """

    def turned(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[ComplexArray]:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            p, _, q, _, r, *_, t = local_transforms_of(contact, x, y, z)
            return (np.asarray(-2 * (1 - nu) * p[1] - (1.5 - nu) * q[0] + (0.5 - nu) * r[2] - t[0]),)

    return np.asarray(_in_blocks(turned, contact, x, y, z)[0], dtype=np.complex128)


def _in_blocks(
    function: Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray | ComplexArray, ...]],
    contact: LocalContact,
    x: FloatArray,
    y: FloatArray,
    z: FloatArray,
) -> tuple[FloatArray | ComplexArray, ...]:
    """The function over all points; a single contact's over blocks of them."""
    if contact.shape:
        _check.broadcast(contact=np.empty(contact.shape), points=x)
    if contact.shape or x.size <= _BLOCK:
        return function(x, y, z)
    flat = [a.reshape(-1) for a in (x, y, z)]
    blocks = [function(*(a[i : i + _BLOCK] for a in flat)) for i in range(0, x.size, _BLOCK)]
    return tuple(np.concatenate(part).reshape(x.shape) for part in zip(*blocks, strict=True))
