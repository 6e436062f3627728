"""What sensors read of loads, as a pure function of arrays of NumPy, JAX or PyTorch: to learn on, and to differentiate.

The formulas are those of `Finger.read` (docs/theory.md, docs/local_contacts.md), which name their array namespace.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

import numpy as np

from . import _check
from .contact import Cone, FlatPunch, Hertz, LineLoad, Patch, PointLoad, RoundHertz, RoundPunch, Strip, Wedge
from .contact.functions import FAR, far_shear_field, line_shear, shear_field
from .errors import InvalidValueError
from .faults import SensorFaults
from .finger import Finger, finger_needed
from .radial import PER_OCTAVE, tabulate_radial
from .response import tabulate
from .skin.along import strain_along, stress_along, trace_of
from .skin.half_plane import plane_strains, plane_stresses
from .transducer import MeanPressure, NormalStrain, NormalStress, Transducer

__all__ = ["Reader", "reader"]

_LONG: dict[str, type[Any]] = {"line": LineLoad, "hertz": Hertz, "strip": Strip, "punch": FlatPunch, "wedge": Wedge}
_LOCAL: dict[str, type[Any]] = {
    "point": PointLoad, "patch": Patch, "round_hertz": RoundHertz, "round_punch": RoundPunch, "cone": Cone,
}  # fmt: skip
_CLOSED = (NormalStrain, NormalStress, MeanPressure)
_PACKAGES = {"numpy": "numpy", "jax": "jax.numpy", "torch": "array_api_compat.torch"}
_BEYOND = 8.0
"""Depths beyond the sensors up to which loads are tabulated where there is no closed form."""


def _namespace(name: str) -> Any:
    """The functions of an array library: "numpy", "jax" or "torch"."""
    _check.choice("library", name, _PACKAGES)
    try:
        return import_module(_PACKAGES[name])
    except ModuleNotFoundError as error:
        raise ModuleNotFoundError(
            f'reader("{name}") needs {error.name}. Fix: pip install "subskin[{name}]"', name=error.name
        ) from None


class Reader:
    """Readings of loads by one finger: `read(loads, sensors, skin)`, a pure function of arrays of one library.

    It can be differentiated, mapped and compiled: `jax.jit(read)`, `jax.grad`, `jax.vmap`, `torch.func.grad`. Nothing
    is checked in it. JAX reckons in single precision unless `jax_enable_x64` is set. `reader` makes it.

    Parameters
    ----------
    finger, library, contact
        As in `reader`.

    Raises
    ------
    InvalidValueError
        As in `reader`.
    ModuleNotFoundError
        A library that is not installed.

    Attributes
    ----------
    sensors : dict
        What is known of the sensors, arrays of shape (n,): `y`, on an area `z`, `depth` [m], `gain`, `offset`. Where
        readings go by tables, without `depth`.
    skin : dict
        `young` [Pa] and `poisson` [-], numbers; empty where readings go by tables.
    sizes : tuple of str
        What loads have beside `components` and `position`: `half_width`, of a patch `half_widths`.
    """

    sensors: dict[str, Any]
    skin: dict[str, Any]

    def __init__(self, finger: Finger, library: str, contact: str) -> None:
        self._xp: Any = _namespace(library)
        self._local, a = contact in _LOCAL, finger.array
        self._contact = _LOCAL[contact] if self._local else _LONG[contact]
        self.sizes: tuple[str, ...] = ()
        if contact not in ("line", "point"):
            self.sizes = ("half_widths",) if contact == "patch" else ("half_width",)
        if a.lifted or np.any(np.asarray(a.width) > 0):
            seen = "sensors with a lift, or with a width"
            raise InvalidValueError(seen, "a reader knows sensors on a point, without a lift", "finger.read(contact)")
        kinds = a.transducers * (1 if len(a.transducers) == len(a) else len(a))
        closed = finger.skin.endless and all(isinstance(kind, _CLOSED) for kind in kinds)
        self._points = a.points
        where = {"y": a.y, "z": a.z} if self._local else {"y": a.y}
        own = {**where, "gain": a.gain, "offset": a.offset, **({"depth": a.depth} if closed else {})}
        self.sensors = {name: self._xp.asarray(np.array(values, dtype=np.float64)) for name, values in own.items()}
        if closed:
            material = finger.skin.materials[0]
            self.skin = {"young": self._xp.asarray(material.young), "poisson": self._xp.asarray(material.poisson)}
            self._plane = getattr(finger.skin, "plane", "strain") == "strain"
            groups = {kind: [i for i, one in enumerate(kinds) if one == kind] for kind in dict.fromkeys(kinds)}
            self._measure: Callable[..., Any] = self._by_form
            self._groups = groups
            self._order = np.argsort(np.concatenate(list(groups.values())))
            return
        if self.sizes:
            rule = "readings of that skin, or of those sensors, go by tables of line and point loads"
            raise InvalidValueError(f'contact = "{contact}"', rule, f'contact="{"point" if self._local else "line"}"')
        self.skin, gain = {}, np.asarray(a.gain)
        if not gain.all():
            raise InvalidValueError(
                "a gain of 0", "sensors that read nothing have no table", "array.select(array.live)"
            )
        if self._local:
            self._measure = self._radial(finger)
        else:
            self._measure = self._along(finger)

    def __call__(
        self,
        loads: Mapping[str, Any],
        sensors: Mapping[str, Any] | None = None,
        skin: Mapping[str, Any] | None = None,
        *,
        sum_over: int | None = None,
        faults: SensorFaults | None = None,
        key: Any = None,
        times: Any = None,
    ) -> Any:
        """Readings (..., n) of loads (...).

        Parameters
        ----------
        loads : mapping of str to array
            `components` (..., d + 1) and `position`, (...) of long contacts and (..., 2) of local ones, as of contacts
            [N/m or N, m], and the `sizes` [m].
        sensors, skin : mapping of str to array, optional
            What is to be other than in the attributes of that name.
        sum_over : int, optional
            An axis of the loads: those along it press at once.
        faults : SensorFaults, optional
            Of the sensors.
        key : Generator of NumPy or PyTorch, or key of JAX, optional
            For what is random of the faults.
        times : array, shape (frames,), optional
            Of the frames [s], on the last axis of the loads that is left, for faults that take time.

        Raises
        ------
        InvalidValueError
            Faults without the key or the times that they need.
        """
        own, parts = {**self.sensors, **(sensors or {})}, loads["components"][..., None]
        n = [parts[..., i, :] for i in range(3 if self._local else 2)]
        at = loads["position"][..., None]
        sizes = [loads[name][..., None] for name in self.sizes]
        if self._local:
            away: Any = (own["y"] - at[..., 0, :], own["z"] - at[..., 1, :])
            if self._contact is Patch:
                sizes = [sizes[0][..., 0, :], sizes[0][..., 1, :]]
        else:
            away = own["y"] - at
        values = self._measure(n, away, sizes, own, {**self.skin, **(skin or {})})
        if sum_over is not None:
            values = values.sum(sum_over if sum_over >= 0 else sum_over - 1)
        readings = own["gain"] * values + own["offset"]
        if faults is None:
            return readings
        return faults.spoil(self._xp, readings, own["offset"], self._points, key, times)

    def _by_form(self, n: Any, away: Any, sizes: Any, sensors: Mapping[str, Any], skin: Mapping[str, Any]) -> Any:
        """By closed forms, one kind of sensor after the other."""
        made = self._of_local if self._local else self._of_long
        if len(self._groups) == 1:
            return made(next(iter(self._groups)), n, away, sizes, sensors["depth"], skin)
        out = [
            made(kind, n, self._some(away, index), sizes, sensors["depth"][..., index], skin)
            for kind, index in self._groups.items()
        ]
        return self._xp.concat(out, axis=-1)[..., self._order]

    def _some(self, away: Any, index: list[int]) -> Any:
        """The distances of some sensors."""
        return tuple(part[..., index] for part in away) if self._local else away[..., index]

    def _of_local(self, kind: Transducer, n: Any, away: Any, sizes: Any, x: Any, skin: Mapping[str, Any]) -> Any:
        xp, (y, z), (press, ty, tz) = self._xp, away, n
        form, nu = self._contact.FORM(*sizes), skin["poisson"]
        orders = (0,) if isinstance(kind, MeanPressure) else (0, 1)
        parts = form.parts(xp, orders, x, y, z, ty, tz, *form.sizes)
        if form.far is not None:
            beyond = x * x + (y * y + z * z) > form.far * form.far
            far = form.parts_far(xp, orders, x, y, z, ty, tz, *form.sizes)
            parts = [
                (xp.where(beyond, w, v), xp.where(beyond, h, g)) for (w, h), (v, g) in zip(far, parts, strict=True)
            ]
        w, h = parts[0]
        if isinstance(kind, MeanPressure):
            return -trace_of(press * w, h, nu) / 3
        dw, dh = parts[1]
        if isinstance(kind, NormalStress):
            return stress_along(press * w, press * x * dw, x * dh)
        return (1 + nu) / skin["young"] * strain_along(press * w, press * x * dw, h, x * dh, nu)

    def _of_long(self, kind: Transducer, n: Any, away: Any, sizes: Any, x: Any, skin: Mapping[str, Any]) -> Any:
        xp, y, (press, drag) = self._xp, away, n
        f, df = self._contact.FORM(xp, x, y, *sizes)
        if sizes:
            a, series = sizes[0], self._contact.SERIES
            moments = [0.0 if k % 2 else series[k // 2] * a**k for k in range(2 * len(series) - 1)]
            far = x * x + y * y > (FAR * a) ** 2
            h = xp.where(far, far_shear_field(x, y, moments), shear_field(xp, x, f, df, False))
        else:
            h = line_shear(x, f[0])
        p, dp, q, dq = ((force * part[0], force * part[1]) for force in (press, drag) for part in (f, df))
        mean, half, xy = plane_stresses(xp, x, p, dp, q, dq, drag * h, False)
        nu = skin["poisson"]
        if isinstance(kind, NormalStress):
            return mean - half
        if isinstance(kind, MeanPressure):
            return -(2 + 2 * nu * self._plane) * mean / 3
        return plane_strains(xp, mean, half, xy, skin["young"], nu, self._plane)[0]

    def _radial(self, finger: Finger) -> Callable[..., Any]:
        """By the tables of point loads (`RadialResponse`)."""
        xp, depth = self._xp, np.asarray(finger.array.depth)
        radius = float(np.hypot(*np.ptp(finger.array.points, axis=0))) + _BEYOND * float(depth.max())
        table = tabulate_radial(finger, radius)
        octave, inner = np.divmod(np.arange(table.coefficients.shape[1]), PER_OCTAVE)
        low, length = 2.0**octave * (1 + inner / PER_OCTAVE), 2.0**octave / PER_OCTAVE
        ends, middle, over = (xp.asarray(v) for v in (low[1:], low + 0.5 * length, 1 / length))
        every, deep2 = xp.asarray(table.coefficients[table.kind]), xp.asarray(depth**2)
        scale, which = xp.asarray(table.gain / np.asarray(finger.array.gain)), xp.arange(len(depth))

        def measure(n: Any, away: Any, sizes: Any, sensors: Mapping[str, Any], skin: Mapping[str, Any]) -> Any:
            y, z = away
            v = 1.0 + (y * y + z * z) / deep2
            cell = xp.searchsorted(ends, v, side="right")
            c, t = every[which, cell], ((v - middle[cell]) * over[cell])[..., None]
            values = _horner(c, t)
            out = 0.0
            for component, order, part, function, sign in table.terms.tolist():
                re, im = 1.0, 0.0
                for _ in range(order):
                    re, im = re * y - im * z, re * z + im * y
                out = out + sign * n[component] * values[..., function] * (im if part else re)
            return scale * out

        return measure

    def _along(self, finger: Finger) -> Callable[..., Any]:
        """By the table of line loads (`Response`): sensors are where they are drawn."""
        xp, y = self._xp, np.asarray(finger.array.y)
        more = _BEYOND * float(np.asarray(finger.array.depth).max())
        half = min(0.5 * float(np.ptp(y)) + more, 0.5 * finger.skin.period)
        middle = 0.5 * float(y.min() + y.max())
        table = tabulate(finger, (middle - half, middle + half))
        # of a cell, sensors, normal and drag, and powers last
        values = np.moveaxis(table.coefficients, 1, -1) / np.asarray(finger.array.gain)[:, None, None]
        every, which, cells = xp.asarray(values), xp.arange(len(y)), len(values)
        ends = xp.asarray(table.start + table.step * np.arange(1, cells))
        at = xp.asarray(np.array(y))

        def measure(n: Any, away: Any, sizes: Any, sensors: Mapping[str, Any], skin: Mapping[str, Any]) -> Any:
            position = at - away
            cell = xp.searchsorted(ends, position, side="right")
            t = (position - table.start) / table.step - cell - 0.5
            both = _horner(every[cell, which], t[..., None])
            return n[0] * both[..., 0] + n[1] * both[..., 1]

        return measure


def _horner(c: Any, t: Any) -> Any:
    """Polynomials with the coefficients c (..., powers) at t."""
    total = c[..., -1]
    for k in range(c.shape[-1] - 2, -1, -1):
        total = total * t + c[..., k]
    return total


def reader(finger: Finger, library: str = "numpy", *, contact: str | None = None) -> Reader:
    """What the finger reads, as a pure function of arrays of one library; as `finger.reader("jax")` too.

    In a half plane and a half space it goes by closed forms, and strain along the depth, stress along it and mean
    pressure; depth, position and gain of the sensors and the skin's material are among its arguments. On other skins,
    and of other linear sensors, it goes by tables of point loads or line loads, to 1e-6.

    Parameters
    ----------
    finger : Finger
        The forward model.
    library : {"numpy", "jax", "torch"}, optional
        Whose arrays it takes and gives.
    contact : str, optional
        What presses. On an area, or in space: "point" (the default there), "patch", "round_hertz", "round_punch",
        "cone". Long: "line" (the default on a row), "hertz", "strip", "punch", "wedge".

    Returns
    -------
    Reader

    Raises
    ------
    InvalidValueError
        Another library or contact; sensors with a lift or a width; a contact with a size where readings go by tables.
    NotLinearError
        A transducer without a linear part.
    ModuleNotFoundError
        A library that is not installed.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> read = reader(finger, contact="patch")
    >>> loads = {"components": [1.0, 0.2, 0.0], "position": [1e-3, 0.0], "half_widths": [2e-3, 1e-3]}
    >>> readings = read({name: np.array(values) for name, values in loads.items()})
    >>> bool(np.allclose(readings, finger.read(ss.Patch(**loads)), rtol=1e-12))
    True
    """
    finger_needed(finger)
    kind = ("point" if finger.array.on_area else "line") if contact is None else contact
    _check.choice("contact", kind, {**_LONG, **_LOCAL})
    if kind in _LONG:
        finger.array.refuse_area()
    elif not finger.skin.takes_local:
        seen = f'contact = "{kind}" in {finger.skin}'
        raise InvalidValueError(seen, "it is solved in a plane, and takes long contacts", 'contact="line"')
    return Reader(finger, library, kind)
