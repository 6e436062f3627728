"""A stack of layers under a local contact: a half space's closed form in the first layer, and what the others add.

Both are brought together as four primitive fields, of which Hooke's law of each layer makes stress and strain: finite
at Poisson's ratio 1/2, and continuous where layers are bonded.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray, each_read_only
from ..contact.local import LocalContact, RadialTerm
from ..material import Material
from ..tensor import Displacements, Strain, Stress
from ._layer_modes import Stack
from ._polar import polar_displacements, polar_fields
from ._radial import DISPLACEMENTS, FIELDS, RadialSpectrum, radial_table
from ._riesz import Fields

__all__ = ["Primitives", "added_displacements", "added_fields", "stack_displacements"]


_TRIES = np.array([0.3, 1.7, 7.1, 40.0])
"""Wavenumbers, times the first layer's thickness, at which shapes are told apart: less matters where more falls off."""


class Primitives(NamedTuple):
    """Stress on a plane of one depth, s_xx and s_xy + i s_xz [Pa], and the strain within it.

    `spread` is 2 G (eps_yy + eps_zz), `turned` 2 G (eps_yy - eps_zz + 2 i eps_yz) [Pa], G of the first layer.
    """

    xx: FloatArray
    spread: FloatArray
    shear: ComplexArray
    turned: ComplexArray

    def plus(self, closed: Fields, nu: float, where: FloatArray) -> Primitives:
        """With a half space's fields where they hold."""
        w, xw, h, xh, shear, difference = closed
        more = -w + xw - xh, -((1 - 2 * nu) * w + xw) + 2 * (1 - nu) * h + xh, shear, difference
        return Primitives(*(one + np.where(where, two, 0.0) for one, two in zip(self, more, strict=True)))

    def stress(self, poisson: FloatArray, stiff: FloatArray) -> Stress:
        """Stress [Pa] by Hooke's law; `stiff` is G of each point's layer over that of the first."""
        xx, spread, shear, turned = self
        half = (poisson * xx + 0.5 * (1 + poisson) * stiff * spread) / (1 - poisson)
        turned = 0.5 * stiff * turned
        return Stress(*each_read_only(xx, half + turned.real, half - turned.real, shear.real, shear.imag, turned.imag))

    def strain(self, poisson: FloatArray, stiff: FloatArray, shear_modulus: float) -> Strain:
        """Strain [-] by Hooke's law; `shear_modulus` is that of the first layer [Pa]."""
        xx, spread, shear, turned = self
        soft = 0.5 / shear_modulus
        down = soft * ((1 - 2 * poisson) * xx / stiff - poisson * spread) / (1 - poisson)
        half, turned, shear = 0.5 * soft * spread, 0.5 * soft * turned, soft * shear / stiff
        return Strain(*each_read_only(down, half + turned.real, half - turned.real, shear.real, shear.imag, turned.imag))


def added_fields(stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray) -> Primitives:
    """The fields in a stack, in the first layer less those of a half space; shape of contact and points together."""
    terms = contact.expand(1).radial_terms
    if terms is None:
        return Primitives(*polar_fields(stack, contact, x, y, z))
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    real, both = np.zeros((2, *shape)), np.zeros((2, *shape), dtype=np.complex128)
    for term in terms:
        f, zeta, n, tau, moment = _looked_up(stack, contact, term, x, y, z, FIELDS)
        back = np.conj(tau) * zeta
        along = back.real
        real += n * f[[0, 2]] + along * f[[1, 3]]
        both[0] += zeta * (n * f[4] + 1j * moment * f[10] + back * f[6]) + tau * f[5]
        both[1] += zeta * (zeta * (n * f[7] + 1j * moment * f[11] + back * f[9]) + tau * f[8])
    return Primitives(*real, *both)


def added_displacements(
    stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray
) -> tuple[FloatArray, ComplexArray]:
    """2 G u_x and 2 G (u_y + i u_z) [Pa m] in a stack, G of the first layer, in which a half space's are taken off."""
    terms = contact.expand(1).radial_terms
    if terms is None:
        return polar_displacements(stack, contact, x, y, z)
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    down, along = np.zeros(shape), np.zeros(shape, dtype=np.complex128)
    for term in terms:
        f, zeta, n, tau, moment = _looked_up(stack, contact, term, x, y, z, DISPLACEMENTS)
        back = np.conj(tau) * zeta
        down += n * f[0] + back.real * f[1]
        along += zeta * (n * f[2] + 1j * moment * f[5] + back * f[4]) + tau * f[3]
    return down, along


def stack_displacements(
    down: FloatArray, along: ComplexArray, closed: Displacements | None, where: FloatArray, material: Material
) -> Displacements:
    """Displacement [m] from what the layers add and a half space's where it holds."""
    soft = 0.5 / material.shear
    parts = [soft * down, soft * along.real, soft * along.imag]
    if closed is not None:
        parts = [one + np.where(where, two, 0.0) for one, two in zip(parts, (closed.x, closed.y, closed.z), strict=True)]
    return Displacements(*each_read_only(*parts))


def _looked_up(
    stack: Stack, contact: LocalContact, term: RadialTerm, x: FloatArray, y: FloatArray, z: FloatArray, which: slice
) -> tuple[FloatArray, ComplexArray, FloatArray, ComplexArray, FloatArray]:
    """The functions of a term at all points, (functions, ...); the points from its centre; N, Ty + i Tz, the moment.

    The term is that of a contact with an axis of length one behind its batch.
    """
    centre, load, moment = term.position[..., 0, :], term.components[..., 0, :], term.moment[..., 0]
    shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
    low, high = contact.support
    reach = 0.5 * float((high - low).max()) if high.size else 0.0
    zeta = np.empty(shape, dtype=np.complex128)
    zeta.real, zeta.imag = y - centre[..., 0], z - centre[..., 1]
    u = (zeta.real**2 + zeta.imag**2).reshape(-1)
    depths = np.broadcast_to(x, shape).reshape(-1)
    spectra, of = _spectra(stack, term, reach, shape)
    out = np.empty((len(range(18)[which]), u.size))
    for depth in np.unique(depths):
        for i, spectrum in enumerate(spectra):
            table = radial_table(stack, float(depth), spectrum)
            chosen = np.flatnonzero((depths == depth) & (of == i))
            out[:, chosen] = table.at(u[chosen], which)
    return out.reshape(-1, *shape), zeta, load[..., 0], load[..., 1] + 1j * load[..., 2], moment


def _spectra(
    stack: Stack, term: RadialTerm, reach: float, shape: tuple[int, ...]
) -> tuple[list[RadialSpectrum], npt.NDArray[np.intp]]:
    """The different shapes of a batch, and which of them each point of the field is under, (points,)."""
    tries = _TRIES / stack.layers[0].thickness
    seen = np.asarray(term.spectrum(tries))
    rows, first, of = np.unique(seen.reshape(-1, tries.size), axis=0, return_index=True, return_inverse=True)

    def one(values: FloatArray, at: int) -> RadialSpectrum:
        def spectrum(k: FloatArray) -> FloatArray:
            return np.asarray(term.spectrum(k)).reshape(-1, k.size)[at]

        return RadialSpectrum(values.tobytes(), reach, np.ones_like if (values == 1).all() else spectrum)

    every = np.broadcast_to(of.reshape(seen.shape[:-1]), shape)
    return [one(values, int(at)) for values, at in zip(rows, first, strict=True)], every.reshape(-1)
