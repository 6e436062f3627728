"""A stack of layers under a local contact: a half space's closed form in the first layer, and what the others add.

Both are brought together as four primitive fields, of which Hooke's law of each layer makes stress and strain: finite
at Poisson's ratio 1/2, and continuous where layers are bonded.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray, each_read_only
from ..contact.local import LocalContact, LocalSpectrum, RadialTerm
from ..material import Material
from ..tensor import Displacements, Strain, Stress
from ._harmonics import SLOPE, STATE_FIELDS, HarmonicFields, HarmonicTable
from ._layer_modes import Stack
from ._radial import DISPLACEMENTS, FIELDS, STATE, TILT, Functions, RadialSpectrum, radial_table
from ._riesz import Fields

__all__ = ["Added", "Primitives", "stack_displacements"]


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

    def plus(self, closed: Fields, nu: float, where: npt.NDArray[np.bool_]) -> Primitives:
        """With a half space's fields where they hold."""
        w, xw, h, xh, shear, difference = closed
        down, along = -w + xw - xh, -((1 - 2 * nu) * w + xw) + 2 * (1 - nu) * h + xh
        xx, spread = self.xx + np.where(where, down, 0.0), self.spread + np.where(where, along, 0.0)
        return Primitives(
            xx, spread, self.shear + np.where(where, shear, 0.0), self.turned + np.where(where, difference, 0.0)
        )

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
        return Strain(
            *each_read_only(down, half + turned.real, half - turned.real, shear.real, shear.imag, turned.imag)
        )


class Added:
    """What a stack has at points of one shape, in the first layer less what a half space of its material would have.

    Parameters
    ----------
    stack : Stack
        The layers.
    contact : LocalContact
        What presses; its batch broadcasts against the points.
    x, y, z : ndarray
        Points [m], of one shape.
    """

    def __init__(self, stack: Stack, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray) -> None:
        self._stack, self._contact, self._x, self._y, self._z = stack, contact, x, y, z
        self._shape = _check.broadcast(contact=np.empty(contact.shape), points=x)
        self._wide = contact.expand(1)
        self._terms = self._wide.radial_terms
        self._tables: dict[tuple[float, int, HarmonicFields], HarmonicTable] = {}

    def fields(self) -> Primitives:
        """Stress and strain."""
        if self._terms is None:
            xx, spread, xy, xz, turned, across = self._by_harmonics(slice(0, 6))
            return Primitives(xx, spread, xy + 1j * xz, turned + 1j * across)
        real, both = np.zeros((2, *self._shape)), np.zeros((2, *self._shape), dtype=np.complex128)
        for term in self._terms:
            f, zeta, n, tau, moment = self._by_distance(term, FIELDS)
            back = np.conj(tau) * zeta
            real += n * f[[0, 2]] + back.real * f[[1, 3]]
            both[0] += zeta * (n * f[4] + 1j * moment * f[10] + back * f[6]) + tau * f[5]
            both[1] += zeta * (zeta * (n * f[7] + 1j * moment * f[11] + back * f[9]) + tau * f[8])
        return Primitives(*real, *both)

    def displacements(self) -> tuple[FloatArray, ComplexArray]:
        """2 G u_x and 2 G (u_y + i u_z) [Pa m], G of the first layer."""
        if self._terms is None:
            down, y, z = self._by_harmonics(slice(6, 9))
            return down, y + 1j * z
        down, along = np.zeros(self._shape), np.zeros(self._shape, dtype=np.complex128)
        for term in self._terms:
            f, zeta, n, tau, moment = self._by_distance(term, DISPLACEMENTS)
            back = np.conj(tau) * zeta
            down += n * f[0] + back.real * f[1]
            along += zeta * (n * f[2] + 1j * moment * f[5] + back * f[4]) + tau * f[3]
        return down, along

    def slope(self) -> ComplexArray:
        """2 G (d/dy + i d/dz) u_x [Pa], G of the first layer."""
        if self._terms is None:
            by_y, by_z = self._by_harmonics(slice(0, 2), SLOPE)
            return np.asarray(by_y + 1j * by_z)
        total = np.zeros(self._shape, dtype=np.complex128)
        for term in self._terms:
            f, zeta, n, tau, _ = self._by_distance(term, slice(0, 3), TILT)
            total += zeta * (n * f[0] + np.conj(tau) * zeta * f[2]) + tau * f[1]
        return total

    def _by_distance(
        self, term: RadialTerm, which: slice, functions: Functions = STATE
    ) -> tuple[FloatArray, ComplexArray, FloatArray, ComplexArray, FloatArray]:
        """The functions of a term, (functions, ...); points from its centre; N, Ty + i Tz and the moment.

        The term is that of a contact with an axis of length one behind its batch.
        """
        centre, load, moment = term.position[..., 0, :], term.components[..., 0, :], term.moment[..., 0]
        low, high = self._contact.support
        zeta = self._from(centre)
        u = (zeta.real**2 + zeta.imag**2).reshape(-1)
        spectra, of = _spectra(self._stack, term, 0.5 * float((high - low).max(initial=0.0)), self._shape)
        out = np.empty((len(functions.orders[which]), u.size))
        for depth, i, chosen in self._grouped(of):
            out[:, chosen] = radial_table(self._stack, depth, spectra[i], functions).at(u[chosen], which)
        return out.reshape(len(out), *self._shape), zeta, load[..., 0], load[..., 1] + 1j * load[..., 2], moment

    def _by_harmonics(self, which: slice, kind: HarmonicFields = STATE_FIELDS) -> FloatArray:
        """Fields of a contact that is not the same in all directions."""
        low, high = (np.broadcast_to(end, (*self._contact.shape, 2)) for end in self._contact.support)
        centres, sizes = (
            (0.5 * (low + high)).reshape(-1, 2),
            0.5 * np.hypot(*np.moveaxis(high - low, -1, 0)).reshape(-1),
        )
        zeta = self._from(0.5 * (low + high)).reshape(-1)
        rows = np.arange(sizes.size).reshape(self._contact.shape)
        out = np.empty((len(range(kind.fields)[which]), zeta.size))
        for depth, i, chosen in self._grouped(np.broadcast_to(rows, self._shape).reshape(-1)):
            if (depth, i, kind) not in self._tables:
                spectrum = partial(self._spectrum, i, centres[i])
                self._tables[depth, i, kind] = HarmonicTable(self._stack, depth, spectrum, float(sizes[i]), kind)
            out[:, chosen] = self._tables[depth, i, kind].at(zeta[chosen], which)
        return out.reshape(len(out), *self._shape)

    def _spectrum(self, row: int, centre: FloatArray, ky: FloatArray, kz: FloatArray) -> LocalSpectrum:
        """That of one contact of the batch, about its centre."""
        back = np.exp(1j * (ky * centre[0] + kz * centre[1]))
        each = self._wide.spectrum(ky.reshape(-1), kz.reshape(-1))
        wide = (np.broadcast_to(part, (*self._contact.shape, ky.size)).reshape(-1, *ky.shape)[row] for part in each)
        return LocalSpectrum(*(part * back for part in wide))

    def _from(self, centre: FloatArray) -> ComplexArray:
        """Points from a centre, y + i z [m]."""
        zeta = np.empty(self._shape, dtype=np.complex128)
        zeta.real, zeta.imag = self._y - centre[..., 0], self._z - centre[..., 1]
        return zeta

    def _grouped(self, of: npt.NDArray[np.intp]) -> Iterator[tuple[float, int, npt.NDArray[np.intp]]]:
        """Points of one depth and under one contact of the batch: the depth, which contact, which points."""
        depths, level = np.unique(np.broadcast_to(self._x, self._shape), return_inverse=True)
        group = level.reshape(-1) * (of.max(initial=0) + 1) + of
        order = np.argsort(group, kind="stable")
        starts = np.flatnonzero(np.diff(group[order], prepend=-1))
        for chosen in np.split(order, starts[1:]) if order.size else ():
            yield float(depths[level.reshape(-1)[chosen[0]]]), int(of[chosen[0]]), chosen


def stack_displacements(
    down: FloatArray,
    along: ComplexArray,
    closed: Displacements | None,
    where: npt.NDArray[np.bool_],
    material: Material,
) -> Displacements:
    """Displacement [m] from what the layers add and a half space's where it holds."""
    soft = 0.5 / material.shear
    parts = [soft * down, soft * along.real, soft * along.imag]
    if closed is not None:
        parts = [
            one + np.where(where, two, 0.0) for one, two in zip(parts, (closed.x, closed.y, closed.z), strict=True)
        ]
    return Displacements(*each_read_only(*parts))


def _spectra(
    stack: Stack, term: RadialTerm, reach: float, shape: tuple[int, ...]
) -> tuple[list[RadialSpectrum], npt.NDArray[np.intp]]:
    """The different shapes of a batch, and which of them each point of the field is under, (points,)."""
    tries = _TRIES / stack.layers[0].thickness
    seen = np.asarray(term.spectrum(tries))
    rows, first, of = np.unique(seen.reshape(-1, tries.size), axis=0, return_index=True, return_inverse=True)

    def one(values: FloatArray, at: int) -> RadialSpectrum:
        def spectrum(k: FloatArray) -> FloatArray:
            return np.asarray(np.asarray(term.spectrum(k)).reshape(-1, k.size)[at])

        return RadialSpectrum(values.tobytes(), reach, np.ones_like if (values == 1).all() else spectrum)

    every = np.broadcast_to(of.reshape(seen.shape[:-1]), shape)
    return [one(values, int(at)) for values, at in zip(rows, first, strict=True)], every.reshape(-1)
