"""A long contact, a touch on the row or a touch beside it? All are sought in every frame; the answer covers them all.

docs/locating_row.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._cold import at_once
from ..errors import GeometryError
from .answer import OfReadings
from .beside import OnRowLocator, PointLocator
from .estimate import Estimate
from .layout import BESIDE, LINE, ON_ROW
from .search import Locator
from .shown import Shown

__all__ = ["Either", "EitherLocator"]

_PRIORS = (0.5, 0.15, 0.35)
"""Before the touch: of a line, of a point on the row, and of one at any distance beside it, each distance as likely."""
_NEAR, _OPEN = 0.3, 0.175
"""Depths: another position is farther off; a position whose standard error is larger is left open by the readings."""
_MOST, _BELIEVED = 0.01, 0.01
"""Probability that the position may be another one; with which a contact leaves more of a frame that it explains."""
_LINE, _ON, _BESIDE = range(3)
_LAYOUTS = (LINE, ON_ROW, BESIDE)
"""Columns of each, which more may follow."""


@dataclass(frozen=True, eq=False, repr=False)
class Either(OfReadings):
    """What a row reads as a line load, as a point load on it or beside it, and how probable the point is.

    Parameters
    ----------
    table : ndarray, shape (..., 6)
        Position [m], its standard deviation [m], probability of the point, which contact is likeliest, status, and by
        how much the force of the other point may differ [N]; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on.
    line, on_row, point : Estimate
        The best line load, the best point load on the row, and the best one at any distance beside it; each of the
        batch's shape (...).
    """

    line: Estimate
    on_row: Estimate
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
        line, on_row, point = (Estimate.join([getattr(p, name) for p in parts]) for name in ("line", "on_row", "point"))
        return cls(whole.table, whole.used, line, on_row, point)

    def __getitem__(self, index: object) -> Self:
        """Some frames of the batch."""
        part = super().__getitem__(index)
        return type(self)(part.table, part.used, self.line[index], self.on_row[index], self.point[index])

    @property
    def position(self) -> FloatArray:
        """Position along the row [m], shape (...): the mean of what is likeliest and of all that lies near it."""
        return self.table[..., 0]

    @property
    def position_std(self) -> FloatArray:
        """Standard deviation of `position` [m], shape (...); it holds how far these lie apart."""
        return self.table[..., 1]

    @property
    def point_probability(self) -> FloatArray:
        """Probability that a point pressed and not a line, shape (...), where both are as likely before the touch."""
        return self.table[..., 2]

    @property
    def likeliest(self) -> FloatArray:
        """Which contact is likeliest, shape (...): 0 the line, 1 the point on the row, 2 the one beside it; or NaN."""
        return self.table[..., 3]

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers."""
        return self.table[..., 4].astype(np.int8)

    @property
    def best(self) -> Estimate:
        """The estimate of the likeliest contact of a single frame; the line where nothing explains it.

        Raises
        ------
        GeometryError
            A batch of frames.
        """
        if self.shape:
            raise GeometryError(f"frames of shape {self.shape}", "one frame has one likeliest contact", "found[0].best")
        return (self.line, self.on_row, self.point)[int(np.nan_to_num(self.likeliest))]

    @property
    def components(self) -> FloatArray:
        """Normal force and drag along the row of the likeliest contact, shape (..., 2): [N/m] of a line, else [N]."""
        return self._likeliest(self.line.components, self.on_row.components, self.point.components)

    @property
    def force(self) -> FloatArray:
        """Magnitude of the likeliest contact's load, shape (...): [N/m] of a line, [N] of a point."""
        return self._likeliest(self.line.force, self.on_row.force, self.point.force)

    @property
    def angle(self) -> FloatArray:
        """The likeliest contact's angle from the inward normal [rad], shape (...)."""
        return self._likeliest(self.line.angle, self.on_row.angle, self.point.angle)

    @property
    def std(self) -> FloatArray:
        """Standard deviations of `position`, `force` and `angle`, shape (..., 3), in the units of these.

        That of a point's force counts how much more, or less, it is if the point presses beside the row, or on it.
        """
        each = self._likeliest(self.line.std, self.on_row.std, self.point.std[..., :3])
        force = np.hypot(each[..., 1], self.table[..., 5])
        return np.stack([self.position_std, force, each[..., 2]], axis=-1)

    @property
    def beside(self) -> FloatArray:
        """How far beside the row the likeliest contact presses [m], shape (...); 0 of a line, and on the row."""
        return self._likeliest(self.line.beside, self.on_row.beside, self.point.beside)

    def _likeliest(self, *each: FloatArray) -> FloatArray:
        """Of each frame what belongs to its likeliest contact; NaN where there is none."""
        which = self.likeliest.reshape(self.shape + (1,) * (each[0].ndim - len(self.shape)))
        return np.select([which == k for k in range(3)], each, np.nan)

    def _shown(self) -> list[Shown]:
        none, point, std = np.zeros(self.shape), self.likeliest >= _ON, self.std
        line = self.likeliest == _LINE
        beside = np.where(self.likeliest == _BESIDE, self.point.beside, np.nan)
        return [
            Shown("position", 1e3 * self.position, 1e3 * self.position_std, "mm"),
            Shown("force of a line", np.where(line, self.force, np.nan), std[..., 1], self.line.force_unit),
            Shown("force of a point", np.where(point, self.force, np.nan), std[..., 1], self.point.force_unit),
            Shown("angle", np.rad2deg(self.angle), np.rad2deg(std[..., 2]), "deg"),
            Shown("beside", 1e3 * beside, 1e3 * self.point.std[..., -1], "mm"),
            Shown("point probability", self.point_probability, none, ""),
        ]

    def _columns(self) -> dict[str, FloatArray]:
        on_row, std = self.likeliest == _ON, self.std
        point = np.where(on_row, self.on_row.force, self.point.force)
        return {
            "position": self.position,
            "position_std": self.position_std,
            "point_probability": self.point_probability,
            "force": self.force,
            "force_std": std[..., 1],
            "force_unit": np.where(self.likeliest == _LINE, self.line.force_unit, self.point.force_unit),
            "angle": self.angle,
            "angle_std": std[..., 2],
            "line_force": self.line.force,
            "point_force": point,
            "beside": np.where(on_row, self.on_row.beside, self.point.beside),
            **super()._columns(),
        }


class EitherLocator:
    """Finds the line load, the point load on the row and the one beside it of each frame, and how probable each is.

    The probability is that of Laplace's method: chi-square, and how much of what was thought possible the readings
    leave. Before the touch a line and a point are as likely, every position of the search, every drag within the cone,
    and every decade of the force. Of points 3 in 10 lie on the row; the others are as likely at every distance beside
    it (docs/locating_row.md).

    Parameters
    ----------
    line : Locator
        Of line loads.
    on_row : OnRowLocator
        Of point loads on the row.
    point : PointLocator
        Of point loads, on the row and beside it.
    """

    def __init__(self, line: Locator, on_row: OnRowLocator, point: PointLocator) -> None:
        self.line, self.on_row, self.point = line, on_row, point
        self.response = line.response
        self._told: Any = None

    takes_doubt = True

    @property
    def unknowns(self) -> int:
        """Unknowns of the simplest contact, a line."""
        return self.line.unknowns

    def warm_up(self) -> Self:
        """The same, with all compiled and tabulated that its first frames would else wait for; as of `Locator`."""
        for each in (self.line, self.on_row, self.point):
            each.warm_up()
        with at_once():
            self(np.asarray(self.line.array.offset))
        return self

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which positions lie where loads are looked for; as of `Locator`."""
        return self.line.covers(position)

    def _company(self) -> Any:
        from scipy.special import chdtri

        from ._weigh import Company

        each, depth = (self.line, self.on_row, self.point), float(np.min(self.line.array.depth))
        scan = np.array([np.ptp(one._scan) for one in each])
        unknowns, free = np.array([float(one.unknowns) for one in each]), np.arange(1, len(self.line.array) + 1)
        sure = np.concatenate([[0.0], chdtri(free, _BELIEVED)])
        across = self.point.half_width[1], self.point.depth
        return Company(
            scan,
            *across,
            np.log(_PRIORS),
            unknowns,
            self.line.friction,
            _NEAR * depth,
            _MOST,
            _OPEN * depth,
            sure,
            self.line._uncertain is not None,
        )

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
        from ._weigh import ANSWER, weigh

        if self._told is None:
            self._told = self._company()
        each = (self.line, self.on_row, self.point)
        tables, kept = zip(*(one._frames(readings, doubt) for one in each), strict=True)
        rows = [at.named(t.reshape(-1, t.shape[-1])) for at, t in zip(_LAYOUTS, tables, strict=True)]
        out = np.empty((len(rows[0]), len(ANSWER.names or ())))
        sensors = np.stack([used.reshape(len(out), -1).sum(axis=-1) for used in kept])
        sized = np.zeros((3, len(out)), dtype=bool)
        if self.line._uncertain is not None:
            sized[:] = [t.reshape(len(out), -1)[:, -1] > 0.0 for t in tables]
        weigh(*rows, sensors, sized, self.line._ambiguity, self._told, np.ndarray(len(out), ANSWER, out))
        line, on_row = (
            Estimate(table, used, one.friction, one.unknowns, one.layout, one.relative)
            for table, used, one in zip(tables[:_BESIDE], kept, each, strict=False)
        )
        out = out.reshape(*tables[0].shape[:-1], out.shape[1])
        out.flags.writeable = False
        used = kept[0]
        if self.line._outliers:  # each may have left out another reading
            used = np.select([out[..., 3, None] == k for k in (_ON, _BESIDE)], kept[_ON:], used)
            used.flags.writeable = False
        return Either(out, used, line, on_row, self.point.alone(tables[_BESIDE], kept[_BESIDE]))
