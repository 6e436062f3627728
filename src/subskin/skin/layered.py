"""Layers on a rigid base or on a half plane: the skin of a robot's finger, where it is flat."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray, each_read_only
from .._declared import Noun, Real, Ruled
from ..contact.base import Contact
from ..contact.local import LocalContact
from ..errors import GeometryError, InvalidValueError
from ..material import Material
from ..tensor import Deferred, Displacements, State, Tilt, Wave
from . import _layer_modes as _modes
from ._area_influence import added_by, arranged, hat_spectrum, of_half_space, wave_sum
from ._layer_modes import antiplane
from ._local import Added, stack_displacements
from ._points import blank_local, local_points, wave_points
from ._radial import DISPLACEMENTS, point_table
from ._riesz import displacements_of, fields_of, turns_of
from ._synthesis import Answer, layers_hooke, of_layers, panels, reach, remembered
from .base import Materials, Skin
from .half_plane import HalfPlane
from .surface import distances, grid_of

__all__ = ["LAYERS", "SOME_LAYERS", "Layer", "Layered", "layers_of"]

_MOST = 40  # layers
_SPAN = 1e4
"""Most by which the thicknesses of a stack's layers may differ."""


@dataclass(frozen=True)
class Layer(Noun):
    """A layer of a skin.

    Parameters
    ----------
    material : Material
        Young's modulus and Poisson's ratio.
    thickness : float
        Thickness [m], > 0.
    bond : {"bonded", "frictionless"}, optional
        How it holds to what lies beneath it: it sticks, or it slides without friction and does not lift.

    Raises
    ------
    InvalidValueError
        A thickness that is not > 0, a bond of another name.

    Examples
    --------
    >>> import subskin as ss
    >>> print(ss.Layered(Layer(ss.Material(young=0.4e6), thickness=6e-3)))
    6 mm (0.4 MPa, nu 0.5) on a rigid base
    """

    material: Material
    thickness: Annotated[float, Real("m", above=0.0, fix="leave out a layer that is not there")]
    bond: Literal["bonded", "frictionless"] = "bonded"

    LOOSE: ClassVar = {"bonded": "", "frictionless": ", sliding"}

    def __str__(self) -> str:
        return f"{1e3 * self.thickness:.6g} mm ({self.material}{self.LOOSE[self.bond]})"


def layers_of(given: Any, least: int = 0) -> tuple[Layer, ...]:
    """One layer, or a sequence of `least` layers or more, as a tuple.

    Raises
    ------
    InvalidValueError, GeometryError
        Something that is no layer, or more than 40; a layer 10,000 times as thick as another.
    """
    listed = isinstance(given, Sequence) and not isinstance(given, str)
    layers = (given,) if isinstance(given, Layer) else tuple(given) if listed else ()
    if not (layers or (listed and not least)) or not all(isinstance(layer, Layer) for layer in layers):
        fix = "Layer(Material(young=0.4e6), thickness=4e-3)"
        raise InvalidValueError(f"layers = {given!r}", "one Layer or more are needed", fix)
    if len(layers) > _MOST:
        raise InvalidValueError(f"{len(layers)} layers", f"at most {_MOST} are handled", "join those that are alike")
    thin, thick = (extreme((layer.thickness for layer in layers), default=1.0) for extreme in (min, max))
    if thick > _SPAN * thin:
        seen = f"layers of {thin:.3g} and {thick:.3g} m"
        rule = f"one may be {_SPAN:.0e} times as thick as another: their waves are summed together"
        raise GeometryError(seen, rule, "leave out the thin one, or take the thick one at the bottom for base=")
    return layers


LAYERS = Ruled(lambda name, value: layers_of(value))
SOME_LAYERS = Ruled(lambda name, value: layers_of(value, least=1))


_DECAY = 42.0
"""exp(-42) is far below rounding, also with the polynomials of k that stand before it."""

_LONG = 1e-9
"""Waves so many times as long as a stack is thick stand for those without end."""

_LENGTHS = 16
"""Lengths between one and twice as long at which waves are prepared, so that they serve contacts anywhere."""


@dataclass(frozen=True)
class Layered(Skin):
    """Elastic layers, the first at the surface, on a rigid base or on a half plane; under long and local contacts.

    Poisson's ratio may be 1/2 exactly. The field is the closed form for the first layer's material, of a half plane in
    plane strain or of a half space, plus what the interfaces send back, summed over wavenumbers (docs/skins.md; a
    single bonded layer: Johnson, Contact Mechanics (1985), section 5.8). Displacements, of local contacts only, are
    absolute; a drag on layers of which one slides has none, for it moves them without end.

    Parameters
    ----------
    layers : Layer or sequence of Layer
        From the surface down.
    base : Material, optional
        The half space on which they lie; none for a rigid base.

    Raises
    ------
    InvalidValueError, GeometryError
        No layer, something that is none, or more than 40; a layer 10,000 times as thick as another.

    Examples
    --------
    Six millimetres of rubber bonded to bone, 2 mm beneath a knife edge. On a half plane it would be -0.023873.

    >>> import subskin as ss
    >>> rubber = ss.Material(young=0.4e6, poisson=0.5)
    >>> skin = ss.Layered(ss.Layer(rubber, thickness=6e-3))
    >>> strain = skin.strain(ss.LineLoad(force=40.0), x=2e-3, y=0.0)
    >>> round(float(strain.xx), 6)
    -0.025617

    A finger tip, and how far it pushes the skin sideways.

    >>> touch = ss.RoundHertz(force=1.5, angle=0.3, azimuth=0.8, half_width=1e-3)
    >>> moved = skin.displacement(touch, x=2e-3, y=[0.0, 1e-3], z=0.0)
    >>> (1e6 * moved.y).round(1).tolist()
    [61.8, 199.9]
    """

    layers: Annotated[Layer | Sequence[Layer], SOME_LAYERS]
    base: Material | None = None

    @property
    def stack(self) -> tuple[Layer, ...]:
        """The layers as a tuple."""
        return (self.layers,) if isinstance(self.layers, Layer) else tuple(self.layers)

    @property
    def materials(self) -> tuple[Material, ...]:  # noqa: D102
        return tuple(layer.material for layer in self.stack) + (() if self.base is None else (self.base,))

    @property
    def interfaces(self) -> tuple[float, ...]:  # noqa: D102
        return tuple(self.modes.tops[1 : len(self.materials)].tolist())

    @property
    def takes_local(self) -> bool:  # noqa: D102
        return True

    @property
    def thickness(self) -> float:
        """Depth of the rigid base [m]; infinite on a half plane."""
        return self._total if self.base is None else np.inf

    def with_(  # noqa: D102
        self, *, materials: Materials = None, thickness: float | None = None, radius: float | None = None
    ) -> Self:
        super().with_(thickness=None if self.single_material else thickness, radius=radius)
        new = self._one_each(materials)
        layers = [replace(layer, material=m) for layer, m in zip(self.stack, new, strict=False)]
        if thickness is not None:
            layers[0] = replace(layers[0], thickness=thickness)
        return replace(self, layers=layers, base=None if self.base is None else new[-1])

    def __str__(self) -> str:
        return (
            f"{' and '.join(map(str, self.stack))} on {'a rigid base' if self.base is None else HalfPlane(self.base)}"
        )

    @cached_property
    def modes(self) -> _modes.Stack:
        """The same layers, wavenumber by wavenumber."""
        rows = [_modes.Sheet(e.material.poisson, e.material.shear, e.thickness, e.bond == "bonded") for e in self.stack]
        return _modes.Stack(tuple(rows), self.base)

    @cached_property
    def _total(self) -> float:
        return float(self.modes.tops[-1])

    def at(  # noqa: D102
        self, x: npt.ArrayLike, y: npt.ArrayLike, z: npt.ArrayLike | None = None
    ) -> Callable[[Contact | LocalContact], State]:
        xs, ys, zs = local_points(x, y, z, self.thickness)
        first, top, positions = self.stack[0].material, self.stack[0].thickness, self.modes.positions(xs)
        flat = HalfPlane(first).at(xs, ys)

        @lru_cache(maxsize=_LENGTHS)
        def waves(far: float) -> tuple[FloatArray, FloatArray, Answer]:
            # what is summed falls at least as exp(-k times this): an echo in the first layer, all of it deeper down
            length = float(np.where(xs <= top, 2 * top - xs, xs).min())
            k, weights = panels(_DECAY / length, far)
            return k, weights, remembered(lambda depths: self._response(k, depths))

        def state(contact: Contact | LocalContact) -> State:
            if isinstance(contact, LocalContact):
                return self._local_state(contact, xs, ys, zs)
            far = max(reach(contact, ys), self._total) + 2 * self._total
            far = float(2 ** (np.ceil(_LENGTHS * np.log2(far)) / _LENGTHS))
            return of_layers(contact, xs, ys, self.materials, positions, partial(waves, far), closed)

        def closed(contact: Contact) -> FloatArray:
            whole = flat(contact)
            return np.stack([whole.stress.xx, whole.stress.xy, whole.strain.yy])

        return state

    def _local_state(self, contact: LocalContact, x: FloatArray, y: FloatArray, z: FloatArray) -> State:
        """The state beneath a local contact at points of one shape."""
        first, upper = self.stack[0].material, x <= self.stack[0].thickness
        added = Added(self.modes, contact, x, y, z)
        own = fields = added.fields()
        if upper.any():
            closed = fields_of(contact, first.poisson, x, y, z)
            if not (x > 0).all():
                blank_local(contact, x, y, z, *closed)
            fields = fields.plus(closed, first.poisson, upper)
        at = self.modes.positions(x)
        poisson, stiff = (np.array(values)[at] for values in zip(*((m.poisson, m.shear) for m in self.materials)))
        stiff = stiff / first.shear

        def moved() -> Displacements | None:
            if self._adrift and contact.tangential_force.any():
                return None
            above = displacements_of(contact, first, x, y, z) if upper.any() else None
            return stack_displacements(*added.displacements(), above, upper, first)

        def tilt() -> Tilt:
            # half of d(u_y + i u_z)/dx + L u_x is the shear; less L u_x it is the tilt
            turned = own.shear / stiff - added.slope()
            if upper.any():
                turned = turned + np.where(upper, turns_of(contact, first.poisson, x, y, z), 0.0)
            return Tilt(*each_read_only(*(part / (2 * first.shear) for part in (turned.real, turned.imag))))

        strain = partial(fields.strain, poisson, stiff, first.shear)
        return Deferred(partial(fields.stress, poisson, stiff), strain, moved, tilt)

    @property
    def _adrift(self) -> bool:
        """Whether something slides without friction: a drag then moves it without end."""
        return any(layer.bond == "frictionless" for layer in self.stack)

    def _response(self, k: FloatArray, x: FloatArray) -> FloatArray:
        """sigma_x, tau_xy and eps_y at depths x; in the first layer less those of a half plane."""
        y = self.modes.amplitudes(k, x, remainder=True)
        along = k[:, None] * y[:, :, 1] / (2 * self.stack[0].material.shear)
        return np.stack([y[:, :, 2], y[:, :, 3], along], axis=2)

    def _state(self, fields: FloatArray, x: FloatArray) -> State:
        return layers_hooke(fields, self.materials, self.modes.positions(x))

    def wave(self, k: npt.ArrayLike, x: npt.ArrayLike) -> Wave:  # noqa: D102
        waves, depths = wave_points(k, x, self.thickness)
        if not waves.all() and self._adrift:
            seen = "a wave without end, k = 0"
            raise InvalidValueError(seen, "under a layer that slides its drag has no limit", "k > 0")
        waves = np.where(waves > 0, waves, _LONG / self._total)
        y = self.modes.amplitudes(waves, depths).transpose(1, 0, 2, 3)
        double = 2 * self.stack[0].material.shear
        fields = np.stack([y[:, :, 2], y[:, :, 3], waves[:, None, None] * y[:, :, 1] / double])
        state = self._state(fields, np.broadcast_to(depths[:, None], fields.shape[1:]))
        return Wave(state.stress, state.strain, y[:, :, 0] / double, y[:, :, 1] / double)

    def wave_across(self, k: npt.ArrayLike, x: npt.ArrayLike) -> FloatArray:  # noqa: D102
        waves, depths = wave_points(k, x, self.thickness)
        out = np.moveaxis(antiplane(self.modes, waves, depths), (2, 1), (0, 1))
        first = self.stack[0]
        fall = np.where(depths <= first.thickness, np.exp(-waves[:, None] * depths), 0.0)
        stress, moved = out[0] - fall, out[1] + fall
        return np.stack([stress, moved / (first.material.shear * waves[:, None])])

    def surface_influence(self, step: float, count: int) -> FloatArray:
        """Displacement of the surface [m/Pa] about a unit hat, shape (2, 2, count), as `Skin.surface_influence`.

        On a half plane, u_x lacks a constant; so does u_y there, and where a layer slides.
        """
        h, count = distances(step, count)
        return _influence(self, h, count)

    def area_influence(  # noqa: D102
        self, step: float, shape: tuple[int, int], drag: bool = False
    ) -> FloatArray:
        step, shape = grid_of(step, shape, drag)
        if drag and self._adrift:
            seen = "friction on layers of which one slides"
            raise InvalidValueError(seen, "a drag moves them without end", 'bond="bonded", or no friction')
        first = self.stack[0]

        def added(y: FloatArray, z: FloatArray) -> FloatArray:
            u = (y * y + z * z).reshape(-1)
            which = DISPLACEMENTS if drag else slice(DISPLACEMENTS.start, DISPLACEMENTS.start + 1)
            f = point_table(self.modes, 0.0).at(u, which).reshape(-1, y.size, z.size)
            if drag:
                turned = (y * y - z * z) * f[4]
                f = np.stack([f[0], f[3] + turned, f[3] - turned, 2 * y * z * f[4], y * f[1], z * f[1]])
            return np.asarray(f / (2 * first.material.shear))

        half = of_half_space(first.material, step, shape, drag)
        return half + added_by(added, first.thickness, step, shape)


@lru_cache(maxsize=8)
def _influence(skin: Layered, step: float, count: int) -> FloatArray:
    """The half plane's influence, with its constant set at the distance `datum`, and what the interfaces add."""
    first, datum = skin.stack[0], skin.modes.tops[-1]
    half = HalfPlane(first.material)
    k, weights = panels(_DECAY / (2 * first.thickness), step * count + 2 * datum)
    own, flat = skin.surface_compliance(k), half.surface_compliance(k)
    hat = hat_spectrum(k, step) * weights / np.pi
    extra = (own - flat) * hat[:, None, None]
    even, odd = wave_sum(k, np.stack([extra[:, 0, 0], extra[:, 1, 1]]), extra[:, 1, 0], step, count)
    out = arranged(even[0], even[1], odd) + half.surface_influence(step, count)
    bonded = all(layer.bond == "bonded" for layer in skin.stack)
    for i, absolute in enumerate((skin.grounded, skin.grounded and bonded)):
        area = step * weights / np.pi
        if absolute:
            # log(distance / datum) stands for (cos(k y) - exp(-k datum)) / k: what that takes off is put back
            constant = area @ (flat[:, i, i] * np.exp(-k * datum)) + flat[0, i, i] * k[0] / np.pi * step * np.log(datum)
        else:
            constant = -area @ ((own - flat)[:, i, i] * np.exp(-((k * datum) ** 2)))
        out[i, i] += constant
    return _check.read_only(out)
