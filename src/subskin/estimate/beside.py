"""Point loads that sensors in a row feel: on the row, or beside it; and whether a line or a point pressed.

Where readings are N f(u) + (Ty dy + Tz dz) g(u), u = dy^2 + dz^2 and dz = -z of every sensor, a row sees |z| by how
widely a touch spreads over it, and no side. On a half space f = depth g: a drag across the row reads like a normal
force, and what is found is N - Tz z / depth. A long contact or a touch on a point? Both are sought in every frame, and
the answer covers both (docs/locating_row.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..array import SensorArray
from ..errors import InvalidValueError
from ..finger import Finger
from ..radial import tabulate_radial
from ..response import Response
from ..skin import in_space
from .estimate import Estimate, FrameTable, Status, unit_column
from .layout import BESIDE
from .search import Locator
from .shown import Shown

__all__ = ["Either", "EitherLocator", "PointLocator", "farthest_beside", "points_beside"]

_BESIDE = 3.0
"""Depths beside the row up to which a touch is thought of where no distance is stated."""
_MOST = 6.0
_TERMS = 1e-7
"""What the last of a table's sums over the distance may be, relative to the largest reading."""
_FEW, _MANY = 16, 48
_STEEPEST, _STEEP = 0.95, 1e3
_PACE = 0.1
"""Depths from one distance beside the row to the next along which the crest of chi-square is looked at."""
_OPEN = 0.1
"""Depths: a position whose standard error is larger is left open by the readings."""


def farthest_beside(finger: Finger, beside: float | None) -> float:
    """The largest distance beside the row [m]: `beside`, or three depths of the shallowest sensor.

    Raises
    ------
    InvalidValueError
        More than six depths: nothing is felt from there.
    """
    depth = float(np.min(finger.array.depth))
    if beside is None:
        return _BESIDE * depth
    if beside > _MOST * depth * (1 + 1e-12):
        rule = f"up to {_MOST:g} depths of the shallowest sensor, {_MOST * depth:.6g} m, can be thought of"
        raise InvalidValueError(f"beside = {beside:.6g} m", rule, f"beside={_MOST * depth:.3g}")
    return beside


def points_beside(finger: Finger, search: tuple[float, float], beside: float) -> Response:
    """Readings of a row under point loads of unit N and Ty at (y, z), as a table over y and z^2; even in z.

    Raises
    ------
    GeometryError, InvalidValueError
        Sensors on an area; a skin that nobody knows in space.
    """
    finger.array.refuse_area()
    skin = in_space(finger.skin)
    if skin is None:
        rule = "a touch on a point needs a skin that is known in space"
        raise InvalidValueError(f"{finger.skin}", rule, 'HalfSpace(material), Layered(layers), or load="line"')
    finger = replace(finger, skin=skin)
    low, high = search
    away = max(high - float(np.min(finger.array.y)), float(np.max(finger.array.y)) - low)
    radial = tabulate_radial(finger, float(np.hypot(away, beside)))
    for terms in (_FEW, 24, 32, _MANY):
        shares = 0.5 * (1 + np.cos(np.pi * (np.arange(terms) + 0.5) / terms))
        z = beside * np.sqrt(shares)

        def each(y: FloatArray, z: FloatArray = z) -> FloatArray:
            """Readings at every distance, those of one distance after those of the other: (..., terms n, 2)."""
            at = np.stack(np.broadcast_arrays(y[..., None], z), axis=-1)
            return radial(at)[..., :2].reshape(*y.shape, -1, 2)

        table = Response.from_function(each, low, high, step=float(np.min(finger.array.depth)) / 4, tolerance=1e-6)
        cells, powers, _, _ = table.coefficients.shape
        values = np.moveaxis(table.coefficients.reshape(cells, powers, terms, -1, 2), 2, 0)
        matrix = np.polynomial.chebyshev.chebvander(2 * shares - 1, terms - 1)
        sums = np.linalg.solve(matrix, values.reshape(terms, -1)).reshape(values.shape)
        made = replace(table, coefficients=np.ascontiguousarray(sums), widest=beside)
        if made.blur <= max(_TERMS, table.error) or terms == _MANY:
            return made
    raise AssertionError


class PointLocator(Locator):
    """Finds point loads on a row or beside it: position along the row, |z|, and (N, Ty) of `Locator` in N.

    A drag across the row, which the readings do not tell from a normal force, is carried as uncertainty of N: every
    |Tz| <= friction N is as likely.

    Parameters
    ----------
    response : Response
        Of `points_beside`.
    array : SensorArray
        As in `Locator`.
    friction : float
        As in `Locator`. The search takes loads that lean more, by what a drag across takes off the normal force.
    **options
        As in `Locator`.

    Raises
    ------
    InvalidValueError, GeometryError
        As in `Locator`.
    """

    def __init__(self, response: Response, array: SensorArray, *, friction: float = 1.0, **options: Any) -> None:
        self.depth = float(np.max(array.depth))
        self.open = _OPEN * float(np.min(array.depth))
        self._across = friction
        lost = friction * response.widest / float(np.min(array.depth)) if friction else 0.0
        steep = friction / (1 - lost) if lost < _STEEPEST else np.inf
        super().__init__(response, array, friction=steep, **options)
        self.layout = self._layout = BESIDE

    def _run(
        self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        super()._run(frames, pattern, out, doubt)
        if doubt is None:
            from .crest import look_along

            arrays = self._arrays
            if pattern is not self._all:
                arrays = self._prepared.get(pattern.tobytes(), partial(self._prepare, pattern))
            look_along(frames, arrays[0], *arrays[-2:], _PACE * self._shallowest, BESIDE.named(out))
        at = BESIDE
        out[:, at.square[1, 1]] += self.unseen(out)
        status = out[:, at.status]
        left_open = out[:, at.covariance] > self.open**2
        status[(status == Status.OK) & left_open] = Status.AMBIGUOUS

    def unseen(self, table: FloatArray) -> FloatArray:
        """Variance of the normal force from the drag across the row, in rows (..., columns) of `BESIDE` [N^2]."""
        beside, upper = table[..., BESIDE.half_width], table[..., BESIDE.interval + 1]
        spread = np.fmax(upper, beside) / self.depth
        return np.asarray((min(self._across, _STEEP) * spread * table[..., BESIDE.components]) ** 2 / 3)


_NEGLIGIBLE = 1e-3
"""A contact that is as improbable as this beside the other one is left out of the answer."""
_DECADES = 3.0 * np.log(10.0)
_FAR = 4.0
"""Standard errors from the mean to either position from which they are two answers."""
_LEANING, _ACROSS = 10.0, 64
_POSITION, _STD, _PROBABILITY, _STATUS = range(4)


@dataclass(frozen=True, eq=False, repr=False)
class Either(FrameTable):
    """What a row reads as a line load, as a point load on it or beside it, and how probable the point is.

    Parameters
    ----------
    table : ndarray, shape (..., 4)
        Position [m], its standard deviation [m], probability of the point, status; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on.
    line, point : Estimate
        The best of each, of the batch's shape (...).
    """

    line: Estimate
    point: Estimate

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """Answers one after the other, along the first axis of the batch.

        Parameters
        ----------
        parts : sequence of Either
            At least one.
        """
        whole = super().join(parts)
        lines, points = (Estimate.join([getattr(part, name) for part in parts]) for name in ("line", "point"))
        return cls(whole.table, whole.used, lines, points)

    def __getitem__(self, index: object) -> Self:
        """Some frames of the batch."""
        part = super().__getitem__(index)
        return type(self)(part.table, part.used, self.line[index], self.point[index])

    @property
    def position(self) -> FloatArray:
        """Position along the row [m], shape (...), the mean of both by their probabilities."""
        return self.table[..., _POSITION]

    @property
    def position_std(self) -> FloatArray:
        """Standard deviation of `position` [m], shape (...); it holds how far the two lie apart."""
        return self.table[..., _STD]

    @property
    def point_probability(self) -> FloatArray:
        """Probability that a point pressed and not a line, shape (...), where both are as likely before the touch."""
        return self.table[..., _PROBABILITY]

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""
        return self.table[..., _STATUS].astype(np.int8)

    def _shown(self) -> list[Shown]:
        none = np.zeros(self.shape)
        return [
            Shown("position", 1e3 * self.position, 1e3 * self.position_std, "mm"),
            Shown("point probability", self.point_probability, none, ""),
            Shown("beside", 1e3 * self.point.beside, 1e3 * self.point.std[..., -1], "mm"),
        ]

    def _columns(self) -> dict[str, FloatArray]:
        forces = {"line_force": self.line.force, "point_force": self.point.force, "beside": self.point.beside}
        return {
            "position": self.position,
            "position_std": self.position_std,
            "point_probability": self.point_probability,
            **forces,
            **super()._columns(),
            **unit_column(self.shape, self.line.relative),
        }


class EitherLocator:
    """Finds the line load and the point load of each frame, and how probable either is.

    The probability is that of Laplace's method: chi-square, and how much of what was thought possible the readings
    leave. Before the touch every position of the search, every drag within the cone, every distance beside the row and
    every decade of the force are as likely (docs/locating_row.md).

    Parameters
    ----------
    line : Locator
        Of line loads.
    point : PointLocator
        Of point loads, on the row and beside it.
    """

    def __init__(self, line: Locator, point: PointLocator) -> None:
        self.line, self.point = line, point
        self.response = line.response

    takes_doubt = True

    def warm_up(self) -> Self:
        """The same, with all compiled and tabulated that its first frames would else wait for; as of `Locator`."""
        self.line.warm_up()
        self.point.warm_up()
        return self

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which positions lie where loads are looked for; as of `Locator`."""
        return self.line.covers(position)

    def __call__(self, readings: npt.ArrayLike, doubt: npt.ArrayLike | None = None) -> Either:
        """The contact in each frame.

        Parameters
        ----------
        readings, doubt : array_like, shape (..., n)
            As of `Locator`.

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        line, point = self.line(readings, doubt), self.point(readings, doubt)
        mu = self.line.friction
        drags = [_slid(line, mu), _leant(point, mu, self.point.depth)] if mu else [None, None]
        known = line.table[..., line.layout.square], point.table[..., point.layout.square].copy()
        known[1][..., 1, 1] -= self.point.unseen(point.table)
        evidence = np.stack(
            [_evidence(line, self.line, known[0], drags[0]), _evidence(point, self.point, known[1], drags[1])]
        )
        with np.errstate(invalid="ignore", over="ignore"):
            share = np.exp(evidence - evidence.max(axis=0))
        share = np.where(np.isfinite(share), share, 0.0)
        total = share.sum(axis=0)
        share = share / np.where(total > 0, total, 1.0)
        share = np.where(share < _NEGLIGIBLE, 0.0, share)
        share /= np.where(total > 0, share.sum(axis=0), 1.0)
        counts = share > 0
        at = np.stack([line.position, point.position])
        std = np.sqrt(np.stack([found.table[..., found.layout.covariance] for found in (line, point)]))
        table = np.full((*line.shape, 4), np.nan)
        mean = np.where(counts, share * at, 0.0).sum(axis=0)
        table[..., _STD] = np.sqrt(np.where(counts, share * (std**2 + (at - mean) ** 2), 0.0).sum(axis=0))
        table[..., _POSITION], table[..., _PROBABILITY] = mean, share[1]
        far = (counts & (np.abs(at - mean) > np.minimum(_FAR * table[..., _STD], 3 * self.point.open))).any(axis=0)
        either = np.stack([line.status, point.status])
        ok = ~(counts & (either != Status.OK)).any(axis=0) & (table[..., _STD] < self.point.open) & ~far
        # a point that takes up every reading: how probable it is, is not known
        ok &= (either[1] != Status.AMBIGUOUS) | (point.spare > 0)
        table[..., _STATUS] = np.where(ok, Status.OK, Status.AMBIGUOUS)
        none = ~counts.any(axis=0)
        nothing = (either == Status.NO_CONTACT).any(axis=0) | (either[0] == Status.INCOMPLETE)
        table[none, :_STATUS] = np.nan
        table[none, _STATUS] = np.where(nothing, either.min(axis=0), Status.UNEXPLAINED)[none]
        table[none & (either == Status.INCOMPLETE).any(axis=0), _STATUS] = Status.INCOMPLETE
        table.flags.writeable = False
        return Either(table, line.used, line, point)


def _force(found: Estimate) -> FloatArray:
    """What a force is as large as, never 0."""
    return np.asarray(np.maximum(np.hypot(*np.moveaxis(found.load.components, -1, 0)), 1e-100))


def _slid(found: Estimate, mu: float) -> FloatArray:
    """Range of the drags of a line load, all as likely [N/m]."""
    return np.asarray(2 * min(mu, _LEANING) * _force(found))


def _leant(found: Estimate, mu: float, depth: float) -> FloatArray:
    """The same of a point: the range in which the drag would be as likely everywhere as it is where it was found [N].

    Of all drags in the cone, (ty, tz) N, each as likely, the row reads T / A = ty / (1 - tz |z| / depth) and
    A = N (1 - tz |z| / depth). The best within two standard errors counts.
    """
    mu = min(mu, _LEANING)
    a, t = np.maximum(np.abs(found.load.components[..., 0]), 1e-100), np.abs(found.load.components[..., 1])
    spread = np.sqrt(found.table[..., found.layout.square[2, 2]])
    ratio = np.maximum(t - 2 * spread, 0.0) / a
    tz = mu * (np.arange(_ACROSS) + 0.5) * 2 / _ACROSS - mu
    best = np.zeros(found.shape)
    for z in (found.beside, found.beside_interval[..., 1]):
        rest = np.maximum(1 - tz * z[..., None] / depth, 0.0)
        inside = (ratio[..., None] * rest) ** 2 + tz**2 <= mu**2
        best = np.fmax(best, np.where(inside, rest, 0.0).sum(axis=-1) * (2 * mu / _ACROSS) / (np.pi * mu**2))
    return np.asarray(a / np.maximum(best, 1e-100))


def _evidence(found: Estimate, locator: Locator, covariance: FloatArray, drags: FloatArray | None) -> FloatArray:
    """Logarithm of the probability of the readings, up to what both contacts share; -inf where it explains nothing.

    `covariance` is that of what the readings tell; `drags` the range in which a drag is as likely, or none.
    """
    shape, layout = found.shape, found.layout
    cut = np.isin(found.status, (Status.OK, Status.AMBIGUOUS))
    widths = [np.full(shape, np.ptp(locator._scan)), _force(found) * _DECADES]
    if drags is not None:
        widths.append(drags)
    if layout.wide:
        widths.append(np.full(shape, np.diff(locator.half_width)[0]))
    sizes = np.stack(widths, axis=-1)
    keep = [0, 1, *([2] if drags is not None else []), *([3] if layout.wide else [])]
    square = covariance[..., keep, :][..., keep] / (sizes[..., :, None] * sizes[..., None, :])
    cut &= np.isfinite(square).all(axis=(-2, -1))
    square = np.where(cut[..., None, None], square, np.eye(len(keep)))
    # the information is that of the readings, square^-1, and that of what was possible before them, 12
    log_det = np.linalg.slogdet(np.eye(len(keep)) + 12 * square)[1] - np.linalg.slogdet(square)[1]
    with np.errstate(invalid="ignore"):
        value = -0.5 * (found.residual + log_det - len(keep) * np.log(2 * np.pi))
    return np.where(cut & np.isfinite(value), value, -np.inf)
