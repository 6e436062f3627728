"""A response on an area: readings under unit forces at a position (y, z), from functions of the distance alone.

With delta = sensor - load = r e, e = exp(i theta), readings on an isotropic flat skin are sums of a few harmonics in
theta, each times a function of r. Over r^m harmonic m is a smooth function of u = r^2, and (r e)^m = (delta_y + i
delta_z)^m: neither a root nor an angle is needed. A reading of a normal strain, a pressure or a normal stress is
N f(u) + (Ty delta_y + Tz delta_z) g(u) on any such skin (docs/locating_area.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Length, checked
from ._frozen import Frozen
from ._radial_kernel import readings_at
from .contact import LocalContact, PointLoad
from .errors import ConvergenceError, GeometryError
from .finger import Finger
from .prepared import prepared, tabulated

__all__ = ["RadialResponse", "tabulate_radial"]

DEGREE = 5
"""Degree of the polynomial in a cell."""
PER_OCTAVE = 16
"""Cells from v to 2 v, v = 1 + u / depth^2: a power of two, so that the digits of v say which cell it is in."""
CELLS = 64
"""Cells of the same octave where a cubic does (`RadialResponse.cubics`)."""


def _nodes(degree: int) -> FloatArray:
    """Where a polynomial of a degree on [-1/2, 1/2] is sampled, Chebyshev's points."""
    return np.asarray(-0.5 * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1)))


_NODES = _nodes(DEGREE)
_TO_POWERS = np.linalg.inv(np.vander(_NODES, increasing=True))
_CHECKS = np.array([-0.49, -0.17, 0.29])
_ANGLES, _FEW_ANGLES, _TURNED = 24, 9, 0.1
_HIGHEST = 8
_KEPT, _SAME = 1e-10, 1e-8
"""Shares of the largest reading: below the first a harmonic is rounding, below the second two are one."""
_FARTHEST, _MOST = 1e6, 1e-6
"""Depths to which a table may reach; and its error, relative to the largest reading."""


@dataclass(frozen=True, eq=False)
class RadialResponse(Frozen):
    """Readings under a unit normal force and unit drags along y and z, at any position (docs/locating_area.md).

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Where the sensors are, (y, z) [m].
    depth, gain : ndarray, shape (n,)
        Depth [m] of each, and what its table is multiplied by.
    kind : ndarray of int, shape (n,)
        Which table is a sensor's.
    coefficients : ndarray, shape (kinds, cells, functions, 6)
        Of t^k in a cell, readings per N over m^order; cells are of equal length in each octave of v = 1 + u / depth^2
        [1/N/m^order].
    terms : ndarray of int, shape (terms, 5)
        What the functions stand for: component (0 N, 1 Ty, 2 Tz), order m, part (0 real, 1 imaginary) of
        (delta_y + i delta_z)^m, function, sign.
    error : float
        Largest error seen between the nodes, relative to the largest reading.
    lift : ndarray, shape (n,), or 0
        What a unit normal force adds to each reading, at any distance [reading/N].
    """

    points: FloatArray
    depth: FloatArray
    gain: FloatArray
    kind: npt.NDArray[np.intp]
    coefficients: FloatArray
    terms: npt.NDArray[np.intp]
    error: float = 0.0
    lift: FloatArray | float = 0.0

    def __repr__(self) -> str:
        orders = ", ".join(str(m) for m in sorted(set(self.terms[:, 1].tolist())))
        return f"RadialResponse({self.sensors} sensors, harmonics {orders}, to {self.radius:.4g} m)"

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return len(self.points)

    @property
    def pair(self) -> tuple[tuple[int, int], tuple[int, int]] | None:
        """Function and sign of f and of g, where a reading is N f(u) + (Ty delta_y + Tz delta_z) g(u)."""
        if self.terms[:, :3].tolist() != [[0, 0, 0], [1, 1, 0], [2, 1, 1]]:
            return None
        (f, p), (g, q), other = self.terms[:, 3:].tolist()
        return ((f, p), (g, q)) if [g, q] == other else None

    def cubics(self) -> tuple[FloatArray, float]:
        """The tables in cells a quarter as long, (kinds, cells, functions, 4), and their error as of `error`.

        Four numbers instead of six are looked up in each: compiled loops want these (`estimate/area/point.py`).
        """
        share = CELLS // PER_OCTAVE
        middles = (np.arange(share)[:, None] + 0.5) / share - 0.5
        powers = np.arange(DEGREE + 1)
        nodes, between = _nodes(3), np.array([-0.5, -0.2, 0.0, 0.2, 0.5])
        fitted = np.linalg.inv(np.vander(nodes, increasing=True)) @ (middles + nodes / share)[..., None] ** powers
        kinds, cells, functions, _ = self.coefficients.shape
        finer = np.einsum("skj,gcfj->gcsfk", fitted, self.coefficients)
        missed = (middles + between / share)[..., None] ** powers - np.vander(between, 4, increasing=True) @ fitted
        wrong = np.abs(np.einsum("stj,gcfj->gcstf", missed, self.coefficients)).max(axis=(2, 3))
        weight = self.weights
        size = (np.abs(self.coefficients[..., 0]) * weight).max()
        return finer.reshape(kinds, cells * share, functions, 4), self.error + float((wrong * weight).max() / size)

    def series(self) -> tuple[FloatArray, float] | None:
        """Functions that are sums of v^(-3/2), v^(-5/2), v^(-7/2) and v^(-9/2), (functions, 4), and their error.

        So are normal strain, pressure and normal stress in a half space. None where some function is not, to as many
        digits as of `cubics`, or where sensors are not of one kind.
        """
        kinds, cells, functions, _ = self.coefficients.shape
        if kinds > 1:
            return None
        octave, inner = np.divmod(np.arange(cells), PER_OCTAVE)
        t = np.linspace(-0.5, 0.5, DEGREE + 2)[:, None]
        v = 2.0**octave * (1.0 + (inner + 0.5 + t) / PER_OCTAVE)
        powers = v[..., None] ** -(1.5 + np.arange(4))
        weight = self.weights
        size = (np.abs(self.coefficients[0, ..., 0]) * weight).max()
        out, wrong = np.empty((functions, 4)), 0.0
        for f in range(functions):
            values = (t ** np.arange(DEGREE + 1) @ self.coefficients[0, :, f].T) * weight[:, f]
            matrix = powers * weight[:, f, None]
            out[f] = np.linalg.lstsq(matrix.reshape(-1, 4), values.reshape(-1), rcond=None)[0]
            wrong = max(wrong, float(np.abs(matrix @ out[f] - values).max() / size))
        error = self.error + wrong
        return (out, error) if error <= self.cubics()[1] else None

    @property
    def weights(self) -> FloatArray:
        """What makes readings of the functions: r^order in the middle of each cell, (cells, functions)."""
        cells, functions = self.coefficients.shape[1:3]
        octave, inner = np.divmod(np.arange(cells), PER_OCTAVE)
        r = self.depth.min() * np.sqrt(2.0**octave * (1.0 + (inner + 0.5) / PER_OCTAVE) - 1.0)
        orders = np.array([self.terms[self.terms[:, 3] == f, 1].max() for f in range(functions)])
        return np.asarray(r[:, None] ** orders)

    @property
    def radius(self) -> float:
        """Distance along the surface up to which the table of the shallowest sensor reaches [m]."""
        return float(self.depth.min() * np.sqrt(2.0 ** (self.coefficients.shape[1] / PER_OCTAVE) - 1))

    def select(self, sensors: npt.ArrayLike) -> RadialResponse:
        """The response of some of the `sensors`, given by a mask or by indices."""
        at = _check.of_sensors(sensors, self.sensors)
        points, depth, gain = (_check.read_only(part[at]) for part in (self.points, self.depth, self.gain))
        lift = np.broadcast_to(self.lift, self.kind.shape)[at]
        return replace(self, points=points, depth=depth, gain=gain, kind=self.kind[at], lift=lift)

    def separate(self) -> RadialResponse:
        """The same with a table for each sensor, its lift in that: compiled loops know tables alone."""
        if not np.any(self.lift):
            return self
        terms, tables = self.lifted(self.coefficients)
        return replace(self, kind=np.arange(self.sensors), coefficients=tables, terms=terms, lift=0.0)

    def lifted(self, coefficients: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray]:
        """Terms, and tables (..., n, cells, functions, 6) of each sensor, of `coefficients` (..., kinds, ...).

        The lift is in the first of the tables, or in the only one.
        """
        terms, tables = np.array(self.terms), coefficients[..., self.kind, :, :, :]
        row = np.flatnonzero((terms[:, :3] == 0).all(axis=1))  # what N makes the same all round
        if not row.size or (terms[:, 3] == terms[row[0], 3]).sum() > 1:  # there is none, or other terms share it
            own = tables[..., terms[row, 3], :] * terms[row, 4, None] if row.size else 0.0 * tables[..., :1, :]
            terms = np.concatenate([[[0, 0, 0, tables.shape[-2], 1]], np.delete(terms, row, axis=0)])
            tables, row = np.concatenate([tables, own], axis=-2), np.zeros(1, dtype=np.intp)
        _, _, _, function, sign = terms[row[0]]
        first = tables if tables.ndim == 4 else tables[0]
        first[:, :, function, 0] += (sign * self.lift / np.where(self.gain == 0, np.inf, self.gain))[:, None]
        return terms, np.ascontiguousarray(tables)

    def __call__(self, position: npt.ArrayLike) -> FloatArray:
        """Readings per unit of (N, Ty, Tz), shape (..., n, 3).

        Parameters
        ----------
        position : array_like, shape (..., 2)
            Where the load presses, (y, z) [m].

        Raises
        ------
        GeometryError
            Positions of another shape.
        """
        at = _at(position).copy()  # one's own: a loop is compiled anew for arrays that are closed
        out = np.empty((*at.shape[:-1], self.sensors, 3))
        readings_at(
            self.points, self.depth, self.gain, self.kind, self.coefficients, self.terms, PER_OCTAVE,
            at.reshape(-1, 2), out.reshape(-1, self.sensors, 3),
        )  # fmt: skip
        out[..., 0] += self.lift
        return out

    def slopes(self, position: npt.ArrayLike) -> FloatArray:
        """How the readings change as the load moves along y and along z [1/N/m], shape (..., n, 3, 2).

        Parameters
        ----------
        position : array_like, shape (..., 2)
            As in a call, whose errors it raises.
        """
        delta, cell, t, steep = self._cells(position)
        c, powers = self.coefficients[self.kind, cell], t[..., None] ** np.arange(DEGREE + 1)
        values = np.einsum("...fk,...k->...f", c, powers)
        slope = (
            np.einsum("...fk,...k->...f", c[..., 1:] * np.arange(1, DEGREE + 1), powers[..., :-1]) * steep[..., None]
        )
        zeta, out = delta[..., 0] + 1j * delta[..., 1], np.zeros((*t.shape, 3, 2))
        for component, order, part, function, sign in self.terms.tolist():
            f, df, shape = values[..., function], slope[..., function], zeta**order
            below = order * zeta ** max(order - 1, 0)
            for along, turned in enumerate((below, 1j * below)):
                each = f * (turned.imag if part else turned.real) + df * delta[..., along] * (
                    shape.imag if part else shape.real
                )
                out[..., component, along] -= sign * each
        return out * self.gain[:, None, None]

    def _cells(self, position: npt.ArrayLike) -> tuple[FloatArray, npt.NDArray[np.intp], FloatArray, FloatArray]:
        """From the load to each sensor, the cell of that distance, how far in it, and d t / d u / 2 there."""
        delta = self.points - _at(position, finite=True)[..., None, :]
        cell, t = _cell_of(1.0 + (delta**2).sum(axis=-1) / self.depth**2, self.coefficients.shape[1])
        return delta, cell, t, 2.0 * PER_OCTAVE / 2.0 ** (cell // PER_OCTAVE) / self.depth**2


def _at(position: npt.ArrayLike, finite: bool = False) -> FloatArray:
    """Positions (..., 2): a compiled loop would read beyond others."""
    at = _check.real("position", position, unit="m", finite=finite)
    if at.shape[-1:] != (2,):
        raise GeometryError(f"position of shape {at.shape}", "(..., 2) is needed, y and z [m]", "(1e-3, 0.0)")
    return at


def _cell_of(v: FloatArray, cells: int) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Cell of v >= 1 and how far in it, t from -1/2 to 1/2; the last goes on."""
    highest = (cells - 1) // PER_OCTAVE
    octave = np.minimum(np.floor(np.log2(v)), highest + 1).astype(np.intp)
    octave -= v < 2.0**octave
    octave += v >= 2.0 ** (octave + 1)
    octave = np.minimum(octave, highest)
    share = (v / 2.0**octave - 1.0) * PER_OCTAVE
    inner = np.minimum(np.floor(share), PER_OCTAVE - 1).astype(np.intp)
    return octave * PER_OCTAVE + inner, share - inner - 0.5


@checked
def tabulate_radial(finger: Finger, radius: Length) -> RadialResponse:
    """A finger's response to point loads, to the distance `radius` from a sensor; tables are kept.

    Each kind of sensor, by transducer, depth and width, is sampled at 24 angles and six distances a cell; the error is
    that seen at other angles and distances.

    Parameters
    ----------
    finger : Finger
        The forward model, of a skin that takes local contacts.
    radius : float
        Largest distance along the surface [m].

    Raises
    ------
    NotLinearError
        Where a transducer has no linear part.
    GeometryError
        A radius of more than a million depths.
    ConvergenceError
        Readings that are no sum of harmonics up to the eighth, or not smooth to 1e-6 of the largest.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfSpace(ss.Material(young=0.4e6))
    >>> finger = ss.Finger(skin, ss.SensorArray.grid(shape=(3, 3), pitch=2e-3, depth=2e-3))
    >>> table = tabulate_radial(finger, 15e-3)
    >>> at = (0.3e-3, 1e-3)
    >>> table.pair is not None, bool(np.allclose(table(at), finger.receptive_field(at), rtol=1e-7))
    (True, True)
    """
    array, depth = finger.array, np.asarray(finger.array.depth)
    if radius > (most := _FARTHEST * float(depth.min())):
        rule = f"up to {_FARTHEST:g} depths of the shallowest sensor are tabulated"
        raise GeometryError(f"radius = {radius:.6g} m", rule, f"radius={most:.3g}")

    def make() -> RadialResponse:
        kinds = array.transducers * (1 if len(array.transducers) == len(array) else len(array))
        keys = list(zip(kinds, depth.tolist(), np.asarray(array.width).tolist(), strict=True))
        each = {key: keys.index(key) for key in keys}
        octaves = np.ceil(np.log2(1.0 + (radius / depth.min()) ** 2))
        cells = max(int(octaves), 1) * PER_OCTAVE
        every = [
            tabulated(("radial", finger.skin, *key, cells), partial(_of_one, finger, i, cells))
            for key, i in each.items()
        ]
        terms, tables, error = shared(every)
        kind = np.array([list(each).index(key) for key in keys])
        lift = np.asarray(array.lift) if array.lifted else 0.0
        return RadialResponse(array.points, depth, np.asarray(array.gain), kind, tables, terms, error, lift)

    return prepared(finger).get(("radial", float(radius)), make)


def _of_one(finger: Finger, sensor: int, cells: int) -> tuple[FloatArray, float, float]:
    """As `sampled`, at few angles where these do: a point of an isotropic skin reads no more than three harmonics."""
    if not np.asarray(finger.array.width)[sensor]:
        found = sampled(finger, sensor, cells, angles=_FEW_ANGLES)
        if found[2] <= _MOST:
            return found
    return sampled(finger, sensor, cells)


def sampled(
    finger: Finger,
    sensor: int,
    cells: int,
    load: Callable[..., LocalContact] = PointLoad,
    angles: int = _ANGLES,
    floor: float = 0.0,
) -> tuple[FloatArray, float, float]:
    """Functions of u by component, order and part, (components, orders, 2, cells, nodes); largest reading; error.

    load makes unit contacts from `components` and `position`, one of each component, or less; readings are taken at
    so many `angles`, more than twice the highest order. Where none exceeds `floor` they are taken for rounding.
    """
    one = finger.array.select([sensor])
    probe = replace(finger, array=replace(one, y=[0.0], z=[0.0], gain=1.0))
    probe.receptive_field(np.zeros(2), "point")  # refuses a transducer without a linear part
    depth = float(np.asarray(one.depth)[0])
    octave, inner = np.divmod(np.arange(cells), PER_OCTAVE)
    centres = 2.0**octave * (1.0 + (inner + 0.5) / PER_OCTAVE)
    lengths = 2.0**octave / PER_OCTAVE

    def readings(t: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
        r = depth * np.sqrt(np.maximum(centres[:, None] + lengths[:, None] * t - 1.0, 0.0))
        away = r[..., None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        touch = load(components=np.eye(3), position=-away[..., None, :])
        return r, probe.measure(touch, linear=True)[..., 0]  # (cells, t, angles, components)

    turns = 2 * np.pi * np.arange(angles) / angles
    r, values = readings(_NODES, turns)
    peak = max(float(np.abs(values).max()), floor)
    if peak == floor:
        values = np.zeros_like(values)
    waves = np.fft.rfft(values, axis=2)[:, :, : (angles - 1) // 2 + 1][:, :, : _HIGHEST + 1] * (2 / angles)
    waves[:, :, 0] /= 2
    waves = np.pad(waves, ((0, 0), (0, 0), (0, _HIGHEST + 1 - waves.shape[2]), (0, 0)))
    power = r[..., None, None] ** np.arange(_HIGHEST + 1)[:, None]
    parts = np.stack([waves.real, -waves.imag])  # of cos and sin m theta
    keep = np.abs(parts).max(axis=(1, 2)) > _KEPT * peak  # (2, orders, components)
    functions = np.where(keep[:, None, None], parts / power, 0.0)
    rc, seen = readings(_CHECKS, turns + _TURNED)
    at = np.einsum("kj,pcjmi->pcmki", _TO_POWERS, functions)
    there = np.einsum("pcmki,tk->pctmi", at, _CHECKS[:, None] ** np.arange(DEGREE + 1))
    turned = np.exp(1j * np.arange(_HIGHEST + 1)[:, None] * (turns + _TURNED))
    there = there * (rc[..., None] ** np.arange(_HIGHEST + 1))[..., None]
    model = np.einsum("ctmi,ma->ctai", there[0], turned.real) + np.einsum("ctmi,ma->ctai", there[1], turned.imag)
    return np.moveaxis(functions, (0, 3, 4), (2, 1, 0)), peak, float(np.abs(model - seen).max()) / peak if peak else 0.0


def shared(sampled: list[tuple[FloatArray, float, float]]) -> tuple[npt.NDArray[np.intp], FloatArray, float]:
    """Terms and tables in which functions that are the same, or the negative, stand once."""
    error = max(each for *_, each in sampled)
    if error > _MOST:
        rule = f"the readings have to be harmonics up to the {_HIGHEST}th, smooth in the distance, to {_MOST:g}"
        fix = "sensors narrower than their depth, not at the surface itself"
        raise ConvergenceError(f"an error of {error:.2g} of the largest reading", rule, fix)
    every = np.stack([functions for functions, *_ in sampled])  # (kinds, 3, orders, 2, cells, nodes)
    peaks = np.array([peak for _, peak, _ in sampled])[:, None, None]
    found: list[FloatArray] = []
    terms = []
    for component, order, part in np.argwhere(np.abs(every).max(axis=(0, 4, 5)) > 0).tolist():
        one = every[:, component, order, part]
        scale = np.abs(one).max(axis=(1, 2), keepdims=True)
        same = ((k, s) for k, f in enumerate(found) for s in (1, -1) if (np.abs(one - s * f) <= _SAME * scale).all())
        function, sign = next(same, (len(found), 1))
        if function == len(found):
            found.append(one)
        terms.append((component, order, part, function, sign))
    if not terms:
        raise GeometryError(f"largest reading {float(peaks.max()):.3g}", "no sensor reads anything", "other sensors")
    tables = np.einsum("kj,fgcj->gcfk", _TO_POWERS, np.stack(found))
    return np.array(terms), np.ascontiguousarray(tables), error
