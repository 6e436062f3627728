"""A round finger: an elastic annulus, or several, on a core, pressed from outside."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Annotated, Literal, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import ComplexArray, FloatArray
from .._declared import Length
from ..contact.base import Contact, Transforms, sum_of
from ..contact.local import LocalContact
from ..errors import GeometryError, InvalidValueError
from ..material import Material
from ..tensor import State, Wave
from ._area_influence import arranged, hat_mean, hat_spectrum, wave_sum
from ._points import blank_singular, complex_points, not_local, points, wave_points
from ._ring_modes import Ring
from ._stack import Sheet
from ._synthesis import layers_hooke, of_layers, remembered
from .base import Materials, Skin
from .half_plane import HalfPlane
from .layered import LAYERS, Layer, layers_of
from .surface import distances

__all__ = ["DEEPEST", "Round", "periodic_transforms"]

DEEPEST = 3.0
"""Largest log(R / r) at which the sines hold."""

_IMAGES = 2
_BLOCK = 1 << 13
"""Points times frequencies taken at a time."""
_FREQUENCIES = 0.125 * np.arange(1, 17)


def periodic_transforms(contact: Contact, z: ComplexArray, radius: float) -> Transforms:
    """Transforms of the contact repeated round the circle, at z = y + i R log(R / r), |y - contact| <= pi R."""
    images = (0, *(side * m for m in range(1, _IMAGES + 1) for side in (-1, 1)))
    total = sum_of([contact.transforms(z + m * 2 * np.pi * radius) for m in images])
    shape = np.broadcast_shapes(contact.shape, z.shape)
    sums = [np.zeros(shape, dtype=np.complex128) for _ in range(4)]
    every: FloatArray = np.stack([_FREQUENCIES, _shares()]) / radius
    waves, shares = every.reshape(2, -1, *(1,) * len(shape))
    step = max(1, _BLOCK // max(1, int(np.prod(shape))))
    for first in range(0, len(waves), step):
        wave, share = waves[first : first + step], shares[first : first + step]
        turn = np.exp(1j * wave * z)
        back = 1 / turn
        for part, value, slope in zip(contact.spectrum(wave), sums[::2], sums[1::2], strict=True):
            # sin(w (t - z)) integrated over the contact, and its derivative in z
            there, here = np.conj(part) * back, part * turn
            value += (share / 2j * (there - here)).sum(axis=0)
            slope -= (share * wave / 2 * (there + here)).sum(axis=0)
    p, dp, q, dq = sums
    hq = total.hq + q.imag + z.imag * dq.real
    return Transforms(total.p + p, total.dp + dp, total.q + q, total.dq + dq, np.asarray(hq))


@lru_cache(maxsize=1)
def _shares() -> FloatArray:
    """Shares of the sines in cot(u/2)/2 less its five nearest poles, |Re u| <= 2.2 pi, |Im u| <= 3.

    Fitted on the edge of that rectangle: what is analytic is nowhere larger within.
    """
    side, t = 2.2 * np.pi, np.linspace(-1, 1, 400)
    edge = np.concatenate([side + 1j * DEEPEST * t, side * t + 1j * DEEPEST])  # the function is odd
    value = 0.5 / np.tan(0.5 * edge)
    for m in range(-_IMAGES, _IMAGES + 1):
        value = value - 1 / (edge - 2 * np.pi * m)
    sines = np.sin(edge[:, None] * _FREQUENCIES)
    rows, right = np.concatenate([sines.real, sines.imag]), np.concatenate([value.real, value.imag])
    size = np.abs(rows).max(axis=0)
    return np.asarray(np.linalg.lstsq(rows / size, right, rcond=1e-13)[0] / size)


_DECAY = 42.0
"""exp(-42) is far below rounding."""

_AXLE = 0.05
"""Radius of the axle within a core that gives, of the finger's."""

_SHARE = 1e-9
"""What has to be left between the layers and the core, of all that lies over the core."""

_FARTHEST = 0.9
"""Share of the circumference over which influences are given: its whole is a distance of 0 again."""


@dataclass(frozen=True)
class Round(Skin):
    """A round finger: rubber between a core and a circular surface, with or without layers over it; plane strain.

    Depth is x = radius - r, and y = radius * phi runs along the surface; a contact's pressure acts along the local
    normal. Strains along x and y are the radial one and that along the circle. The field is a full disk's closed form,
    plus what the core and the interfaces send back, summed over harmonics (docs/skins.md; Michell 1899). What slides
    bears a torque evenly, for nothing else could hold a ring that is turned.

    Parameters
    ----------
    material : Material
        What fills the finger beneath the layers, down to the core: Young's modulus and Poisson's ratio, up to 1/2
        exactly.
    radius : float
        Outer radius R [m], > 0.
    core_radius : float
        Radius of the core [m], from R/20 to R.
    layers : Layer or sequence of Layer, optional
        Over the material, from the surface down; none by default.
    core : Material, optional
        What the core is made of, bonded to a rigid axle of R/20; without one the core is rigid.
    bond : {"bonded", "frictionless"}, optional
        How the material holds to the core: it sticks, or it slides without friction and does not lift.

    Raises
    ------
    InvalidValueError, GeometryError
        A radius that is not > 0, a core that is too thin or not within the finger, layers as thick as what is over the
        core; as `Layered`.

    Examples
    --------
    A finger of 8 mm radius on a core of 4 mm, 2 mm beneath a knife edge. On a half plane it would be -0.023873.

    >>> import subskin as ss
    >>> rubber = ss.Material(young=0.4e6)
    >>> skin = ss.Round(rubber, radius=8e-3, core_radius=4e-3)
    >>> strain = skin.strain(ss.LineLoad(force=40.0), x=2e-3, y=0.0)
    >>> round(float(strain.xx), 6)
    -0.029992

    The same with an epidermis.

    >>> epidermis = ss.Layer(ss.Material(young=2e6, poisson=0.48), thickness=0.3e-3)
    >>> skin = ss.Round(rubber, radius=8e-3, core_radius=4e-3, layers=epidermis)
    >>> round(float(skin.strain(ss.LineLoad(force=40.0), x=2e-3, y=0.0).xx), 6)
    -0.029569
    """

    material: Material
    radius: Length
    core_radius: Length
    layers: Annotated[Layer | Sequence[Layer], LAYERS] = ()
    core: Material | None = None
    bond: Literal["bonded", "frictionless"] = "bonded"

    def __post_init__(self) -> None:
        super().__post_init__()
        outer, inner = self.radius, self.core_radius
        if not np.exp(-DEEPEST) * outer < inner < outer:
            seen = f"core_radius = {inner:.6g} m, radius = {outer:.6g} m"
            rule = "the core has to lie within the finger and have at least a twentieth of its radius"
            raise GeometryError(seen, rule, f"core_radius between {0.05 * outer:.3g} and {outer:.3g} m")
        room = outer - inner - sum(layer.thickness for layer in layers_of(self.layers))
        if not room > _SHARE * (outer - inner):
            seen = f"layers of {outer - inner - room:.6g} m together"
            rule = f"they lie over the material, and over the core there are only {outer - inner:.6g} m"
            raise GeometryError(seen, rule, "thinner layers, or a smaller core_radius")
        layers_of(self.stack)

    @cached_property
    def stack(self) -> tuple[Layer, ...]:
        """All layers, from the surface down to what is rigid."""
        return self._over_core + (() if self.core is None else (Layer(self.core, self.core_radius - self._axle),))

    @property
    def _over_core(self) -> tuple[Layer, ...]:
        over = layers_of(self.layers)
        filled = self.radius - self.core_radius - sum(layer.thickness for layer in over)
        return (*over, Layer(self.material, filled, self.bond))

    @property
    def _axle(self) -> float:
        """Radius of what is rigid [m]."""
        return self.core_radius if self.core is None else _AXLE * self.radius

    @property
    def thickness(self) -> float:
        """Depth of what is rigid [m]: of the core, or of the axle within a core that gives."""
        return self.radius - self._axle

    @property
    def curvature(self) -> float:  # noqa: D102
        return 1 / self.radius

    @property
    def materials(self) -> tuple[Material, ...]:  # noqa: D102
        return tuple(layer.material for layer in self.stack)

    @property
    def interfaces(self) -> tuple[float, ...]:  # noqa: D102
        return tuple(self._ring.tops[1:-1].tolist())

    def with_(  # noqa: D102
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        if not self.single_material:
            super().with_(thickness=thickness)
        outer = self.radius if radius is None else _check.scalar("radius", radius, unit="m", above=0.0)
        thickness = None if thickness is None else _check.scalar("thickness", thickness, unit="m")
        if thickness is not None and not 0 < thickness < outer:
            raise GeometryError(
                f"thickness = {thickness:.6g} m",
                f"has to be > 0 and < the radius, {outer:.6g} m",
                "a smaller thickness",
            )
        inner = self.core_radius + (outer - self.radius) if thickness is None else outer - thickness
        new = self._one_each(materials)
        over = layers_of(self.layers)
        layers = [replace(layer, material=m) for layer, m in zip(over, new, strict=False)]
        core = None if self.core is None else new[-1]
        return replace(
            self, material=new[len(layers)], radius=outer, core_radius=inner, layers=tuple(layers), core=core
        )

    def __str__(self) -> str:
        core = f"a rigid core of {1e3 * self.core_radius:.6g} mm"
        if self.core is not None:
            core = f"a core of {1e3 * self.core_radius:.6g} mm ({self.core})"
        whole = f" ({self.material}{Layer.LOOSE[self.bond]})"
        filled = f": {' and '.join(map(str, self._over_core))}" if layers_of(self.layers) else whole
        return f"a radius of {1e3 * self.radius:.6g} mm{filled} on {core}"

    @cached_property
    def _ring(self) -> Ring:
        rows = [Sheet(e.material.poisson, e.material.shear, e.thickness, e.bond == "bonded") for e in self.stack]
        return Ring(tuple(rows), self.radius)

    def _harmonics(self, shortest: float) -> FloatArray:
        """All harmonics but those that fall below exp(-42) over `shortest`, a logarithm of radii."""
        return np.arange(np.ceil(_DECAY / shortest) + 8)

    def at(  # noqa: D102
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        xs, ys = points(x, y, self.thickness, z=z)
        xs = np.minimum(xs, self._ring.tops[-1])
        first, top = self.stack[0].material, self.stack[0].thickness
        upper, positions = xs <= top, self._ring.positions(xs)
        # an echo in the first layer falls over the way there and back, all of it deeper down over the way there
        down, bottom = (-np.log1p(-depth / self.radius) for depth in (xs, top))
        n = self._harmonics(float(np.min(np.where(upper, 2 * bottom - down, down), initial=2 * bottom)))
        weights = np.where(n == 0, 0.5, 1.0) / self.radius

        @remembered
        def response(depths: FloatArray) -> FloatArray:
            answer = self._ring.amplitudes(n, depths, remainder=True)[:, :, :3]
            answer[:, :, 2] /= 2 * first.shear
            return answer

        def state(contact: Contact | LocalContact) -> State:
            if isinstance(contact, LocalContact):
                raise not_local(contact, self)
            self._refuse_wide(contact)
            known = n / self.radius, weights, response
            return of_layers(contact, xs, ys, self.materials, positions, lambda: known, closed)

        def closed(contact: Contact) -> FloatArray:
            return self._disk(contact, np.minimum(xs, top), ys)

        return state

    def _state(self, fields: FloatArray, x: FloatArray) -> State:
        return layers_hooke(fields, self.materials, self._ring.positions(x))

    def _refuse_wide(self, contact: Contact) -> None:
        low, high = contact.support
        wide, turn = float(np.max(high - low, initial=0.0)), self.period
        if wide > 0.5 * turn:
            rule = f"it reaches round the finger, {turn:.6g} m about"
            raise GeometryError(f"a contact {wide:.6g} m wide", rule, "a narrower contact")

    def _disk(self, contact: Contact, x: FloatArray, y: FloatArray) -> FloatArray:
        """sigma_x, tau_xy and eps_y of a full disk: the half plane's formulas at a depth of R log(R / r)."""
        low, high = contact.support
        centre, turn = 0.5 * (low + high), self.period
        # whole turns only: a point on a contact's edge stays exactly there
        around = y - turn * np.round((y - centre) / turn)
        rho = 1 - x / self.radius
        depth = -self.radius * np.log(rho)
        factor = 0.5 * self.radius * (1 - rho) * (1 + rho)
        with np.errstate(divide="ignore", invalid="ignore"):  # singular points are blanked, and warned of, below
            z = complex_points(np.broadcast_to(depth, around.shape), around)
            t = periodic_transforms(contact, z, self.radius)
            surface = z.imag == 0
            gp, gq = (np.where(surface, 0.0, factor * d) for d in (t.dp, t.dq))
            rest = np.where(surface, 0.0, (factor - depth) * t.dq.real)
            mean = np.asarray((t.q.real - t.p.imag) / np.pi)
            difference = np.asarray((t.q.real - gq.imag - gp.real) / np.pi) / rho**2
            shear = np.asarray((gp.imag - t.hq - rest) / np.pi) / rho**2
        blank_singular(contact, depth, around, mean, difference, shear)
        material = self.stack[0].material
        nu, young = material.poisson, material.young
        along = (1 + nu) / young * ((1 - 2 * nu) * mean + difference)
        return np.stack([mean - difference, shear, along])

    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:  # noqa: D102
        waves, depths = wave_points(k, x, self.thickness)
        depths = np.minimum(depths, self._ring.tops[-1])
        n = np.round(waves * self.radius)
        if (np.abs(waves * self.radius - n) > 1e-9 * np.maximum(n, 1)).any():
            seen = f"k * radius = {(waves * self.radius).tolist()}"
            rule = "waves on a round finger close: k has to be a whole number over the radius"
            raise InvalidValueError(seen, rule, "k = n / skin.radius")
        parts = self._ring.amplitudes(n, depths).transpose(2, 1, 0, 3)
        along, ux, uy = parts[2:] / (2 * self.stack[0].material.shear)
        fields = np.stack([*parts[:2], along])
        state = self._state(fields, np.broadcast_to(depths[:, None], fields.shape[1:]))
        return Wave(state.stress, state.strain, ux, uy)

    def surface_influence(self, step: float, count: int) -> FloatArray:  # noqa: D102
        h, count = distances(step, count)
        if h * count > _FARTHEST * self.period:
            seen = f"distances of up to {h * count:.6g} m"
            raise GeometryError(seen, f"the finger is only {self.period:.6g} m about", "a narrower window")
        return _influence(self, h, count)


@lru_cache(maxsize=8)
def _influence(skin: Round, step: float, count: int) -> FloatArray:
    """The half plane's influence, the difference between it and a full disk's, and what the core adds.

    A disk's compliance (R/4G) (kappa/(n + 1) + 1/(n - 1)) and its like sum to logarithms: sum of exp(i n t)/n =
    -log(2 sin(t/2)) + i (pi - t)/2, turned by one wave either way.
    """
    first, radius = skin.stack[0].material, skin.radius
    kappa, shear = 3 - 4 * first.poisson, first.shear

    def disk(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """4 pi G times u_x of a pressure and u_y of a pressure, less the half plane's, at the distance y."""
        t = np.abs(y) / radius
        log = -np.log(2 * np.sin(0.5 * t)) + 0.5j * (np.pi - t)
        before, after = np.exp(1j * t) * log, np.exp(-1j * t) * log - 1 - 0.5 * np.exp(1j * t)
        even = kappa * after.real + before.real + (kappa + 1) * np.log(np.abs(y))
        odd = before.imag - kappa * after.imag - (1 - kappa) * 0.5 * np.pi
        return np.asarray(even), np.asarray(np.sign(y) * odd)

    n = skin._harmonics(-np.log1p(-skin.stack[0].thickness / radius))
    extra = skin.surface_compliance(n / radius)
    high = np.where(n > 1, n, 2.0)
    straight, across = kappa / (high + 1) + 1 / (high - 1), 1 / (high - 1) - kappa / (high + 1)
    known = radius / (4 * shear) * np.array([[straight, across], [across, straight]]).transpose(2, 0, 1)
    extra = extra - np.where(n > 1, 1.0, 0.0)[:, None, None] * known
    weights = hat_spectrum(n / radius, step) * np.where(n == 0, 0.5, 1.0) / (np.pi * radius)
    extra = extra * weights[:, None, None]
    even, odd = wave_sum(n / radius, np.stack([extra[:, 0, 0], extra[:, 1, 1]]), extra[:, 1, 0], step, count)
    scale = 4 * np.pi * shear
    bent = [hat_mean(lambda y, i=i: disk(y)[i] / scale, step, count) for i in (0, 1)]
    half = HalfPlane(first).surface_influence(step, count)
    return _check.read_only(arranged(even[0] + bent[0], even[1] + bent[0], odd + bent[1]) + half)
