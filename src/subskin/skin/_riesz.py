"""From a local contact's families W_m to stress, strain and displacement in a half space: eight lines for all contacts.

All the Poisson's ratio there is stands here (docs/local_contacts.md).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, partial
from itertools import chain
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from .. import _check
from .._check import ComplexArray, FloatArray, each_read_only, read_only
from .._frozen import Frozen
from ..contact import LocalContact, ShapedContact, local_potentials_of, local_transforms_of
from ..contact.kernels import RealForm
from ..material import Material
from ..tensor import Displacements, Strain, Stress
from ._points import blank_local
from .along import strain_along, stress_along, trace_of

__all__ = [
    "DeferredStrain",
    "DeferredStress",
    "Fields",
    "RealFields",
    "displacements_of",
    "fields_of",
    "tensors_of",
    "turns_of",
]


class _Deferred(Frozen):
    """A tensor in space whose components are worked out when asked for: `xx` and the trace alone, or all of them."""

    def __init__(
        self, whole: Callable[[], Stress | Strain], xx: Callable[[], FloatArray], trace: Callable[[], FloatArray]
    ) -> None:
        self.__dict__.update(_made=whole, _xx=xx, _trace=trace)

    def _as_said(self) -> tuple[Any, ...]:
        """It travels as what it has to say: functions stay behind."""
        kind = Stress if isinstance(self, Stress) else Strain
        return kind, (self.xx, self.yy, self.zz, self.xy, self.xz, self.yz)

    @cached_property
    def _all(self) -> Stress | Strain:
        made: Stress | Strain = self.__dict__["_made"]()
        return made

    @cached_property
    def xx(self) -> FloatArray:
        return read_only(self.__dict__["_xx"]())

    @cached_property
    def trace(self) -> FloatArray:
        return read_only(self.__dict__["_trace"]())

    yy, zz, xy, xz, yz = (property(attrgetter(f"_all.{name}")) for name in ("yy", "zz", "xy", "xz", "yz"))

    @property
    def is_plane(self) -> bool:
        return False


class DeferredStress(_Deferred, Stress):
    """Stress whose components are worked out when asked for."""

    __reduce__ = _Deferred._as_said


class DeferredStrain(_Deferred, Strain):
    """Strain whose components are worked out when asked for."""

    __reduce__ = _Deferred._as_said


# Points of one block: its temporaries then stay in the second-level cache.
_BLOCK = 1024
_BATCH = 1 << 12


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
        return Stress(stress_along(w, xw, xh), yy, zz, shear.real, shear.imag, turned.imag)

    def strain(self, material: Material) -> Strain:
        """Strain [-]; at nu = 1/2 not as a difference of stresses, which are large beside it near the surface."""
        w, xw, h, xh, shear, difference = self
        nu, soft = material.poisson, 0.5 / material.shear
        xx = strain_along(w, xw, h, xh, nu)
        half = 0.5 * (-((1 - 2 * nu) * w + xw) + 2 * (1 - nu) * h + xh)
        turned = 0.5 * difference
        parts = xx, half + turned.real, half - turned.real, shear.real, shear.imag, turned.imag
        return Strain(*(soft * part for part in parts))


class RealFields:
    """Stress and strain along x, and the mean pressure, of a shape with a `RealForm`: nothing else is worked out.

    Parameters
    ----------
    contact : ShapedContact
        What presses.
    form : RealForm
        Its real form.
    x, y, z : ndarray
        Points [m] of one shape, x > 0, which broadcasts against the batch.
    """

    def __init__(self, contact: ShapedContact, form: RealForm, x: FloatArray, y: FloatArray, z: FloatArray) -> None:
        centre, load = contact.position, contact.components
        self._form = form
        self._shape = np.broadcast_shapes(contact.shape, x.shape)
        self._arrays = [x, y, z, centre[..., 0], centre[..., 1], *(load[..., i] for i in range(3)), *form.sizes]
        if form.far is not None:
            self._arrays.append(form.far)

    def stress_xx(self) -> FloatArray:
        """s_xx [Pa]."""
        return self._each((0, 1), lambda x, n, w, h, dw, dh: stress_along(n * w, n * x * dw, x * dh))

    def strain_xx(self, material: Material) -> FloatArray:
        """eps_xx [-]."""
        nu, soft = material.poisson, 0.5 / material.shear
        return self._each((0, 1), lambda x, n, w, h, dw, dh: soft * strain_along(n * w, n * x * dw, h, x * dh, nu))

    def trace(self, nu: float) -> FloatArray:
        """The sum of the normal stresses [Pa]."""
        return self._each((0,), lambda x, n, w, h: trace_of(n * w, h, nu))

    def _each(self, orders: tuple[int, ...], make: Callable[..., FloatArray]) -> FloatArray:
        """What `make` gives of x, N and the parts of the orders, block by block along the first axis."""
        out, shape = np.empty(self._shape), self._shape
        rows = max(1, _BATCH // max(1, int(np.prod(shape[1:]))))
        for first in range(0, shape[0] if shape else 1, rows):
            part = slice(first, first + rows)
            block = [a[part] if a.ndim == len(shape) > 0 and a.shape[0] > 1 else a for a in self._arrays]
            self._fill(out[part] if shape else out, orders, make, block)
        return out

    def _fill(
        self, out: FloatArray, orders: tuple[int, ...], make: Callable[..., FloatArray], block: list[FloatArray]
    ) -> None:
        form, (x, y, z, at_y, at_z, *rest) = self._form, block
        y, z = y - at_y, z - at_z
        if form.far is None:
            out[...] = self._made(form.parts, orders, make, x, y, z, *rest)
            return
        beyond = x * x + (y * y + z * z) > rest.pop() ** 2
        if not beyond.any():
            out[...] = self._made(form.parts, orders, make, x, y, z, *rest)
            return
        wide = np.broadcast_arrays(x, y, z, *rest, beyond)[:-1]
        for parts, chosen in ((form.parts_far, beyond), (form.parts, ~beyond)):
            out[chosen] = self._made(parts, orders, make, *(a[chosen] for a in wide))

    @staticmethod
    def _made(
        parts: Any, orders: tuple[int, ...], make: Callable[..., FloatArray], x: Any, y: Any, z: Any, n: Any, *rest: Any
    ) -> FloatArray:
        return make(x, n, *chain.from_iterable(parts(np, orders, x, y, z, *rest)))


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


def tensors_of(
    contact: LocalContact, material: Material, x: FloatArray, y: FloatArray, z: FloatArray
) -> tuple[Callable[[], Stress], Callable[[], Strain]]:
    """Stress and strain beneath a contact at points of one shape, when they are asked for."""
    if contact.shape:
        _check.broadcast(contact=np.empty(contact.shape), points=x)
    nu = material.poisson
    form = contact.known_form if isinstance(contact, ShapedContact) and (x > 0).all() else None
    if not isinstance(contact, ShapedContact) or form is None:
        fields = fields_of(contact, nu, x, y, z)
        blank_local(contact, x, y, z, *fields)
        return partial(fields.stress, nu), partial(fields.strain, material)
    whole = cache(lambda: fields_of(contact, nu, x, y, z))
    real = RealFields(contact, form, x, y, z)
    share = (1 - 2 * nu) / material.young  # of the trace of the stress is that of the strain
    stress = DeferredStress(lambda: whole().stress(nu), real.stress_xx, lambda: real.trace(nu))
    strain = DeferredStrain(
        lambda: whole().strain(material), lambda: real.strain_xx(material), lambda: share * stress.trace
    )
    return lambda: stress, lambda: strain


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
