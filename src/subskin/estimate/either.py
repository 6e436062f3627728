"""A long contact or a touch on a point? Both are sought in every frame of a row, and the answer covers both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .beside import PointLocator
from .estimate import Estimate, FrameTable, Status, unit_column
from .search import Locator
from .shown import Shown

__all__ = ["Either", "EitherLocator"]

_NEGLIGIBLE = 1e-3
"""A contact that is as improbable as this beside the other one is left out of the answer."""
_DECADES = 3.0 * np.log(10.0)
_FAR = 4.0
"""Standard errors from the mean to either position from which they are two answers."""
_STEEPEST, _ACROSS = 10.0, 64
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
        # a point that takes up every reading, and may stand elsewhere as well: how probable it is, is not known
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
    return np.asarray(2 * min(mu, _STEEPEST) * _force(found))


def _leant(found: Estimate, mu: float, depth: float) -> FloatArray:
    """The same of a point: the range in which the drag would be as likely everywhere as it is where it was found [N].

    Of all drags in the cone, (ty, tz) N, each as likely, the row reads T / A = ty / (1 - tz |z| / depth) and
    A = N (1 - tz |z| / depth). The best within two standard errors counts.
    """
    mu = min(mu, _STEEPEST)
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
    with np.errstate(invalid="ignore", divide="ignore"):
        information = np.linalg.inv(np.where(cut[..., None, None], square, np.eye(len(keep)))) + 12 * np.eye(len(keep))
        _, log_det = np.linalg.slogdet(information)
        value = -0.5 * (found.residual + log_det - len(keep) * np.log(2 * np.pi))
    return np.where(cut & np.isfinite(value), value, -np.inf)
