"""Several touches on an area at once: where each is and how hard, and how many there are, by evidence."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import lgamma
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_touches, turned_square
from .._check import FloatArray
from ..errors import InvalidValueError
from .answer import FrameTable, Status
from .area import AreaLocator
from .area.judge import Settings
from .estimate import Estimate
from .frames import Framewise
from .layout import AREA
from .shown import Shown

if TYPE_CHECKING:
    from ..spread import Spread

__all__ = ["SeveralLocator", "TouchSet", "checked_touches"]

MOST = 3
"""Touches at once."""
_SURE, _WIDE = 0.99, 0.1
"""Probability from which the number of touches is known, and the standard deviation of a position [least depths] from
which it is not."""
_STEEPEST = 10.0
_COUNT, _RESIDUAL, _RIVAL, _STATUS, _FIRST = range(5)
_LEFT, _VOLUME, _WORSE, _STRETCH, _AT = range(5)
"""Columns of a block of `settle_several`; from the last on, position, components and covariances."""
_DIM, _FORCES, _EACH = 2, 3, 5


@dataclass(frozen=True, eq=False, repr=False)
class TouchSet(FrameTable):
    """The touches found in each frame, and how many there are; every field has the batch's shape (...).

    Parameters
    ----------
    table : ndarray, shape (..., columns)
        The packed results; read them by name.
    used : ndarray of bool, shape (..., n)
        Which sensors each frame's answer rests on.
    friction : float
        The cone that was searched, of each touch [-].
    most : int
        The most touches that were thought of.
    relative : bool
        As in `Estimate`.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, noise=2e-5)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> here, there = ss.PointLoad(force=1.0, position=(-2e-3, 1e-3)), ss.PointLoad(force=0.6, position=(4e-3, 5e-4))
    >>> found = finger.locate(finger.read(here) + finger.read(there), touches=2)
    >>> int(found.count), (1e3 * found.each.position).round(2).tolist(), found.each.force.round(2).tolist()
    (2, [[-2.0, 1.0], [4.0, 0.5]], [1.0, 0.6])
    """

    friction: float
    most: int
    relative: bool = False

    @property
    def count(self) -> npt.NDArray[np.int64]:
        """How many touches there are, the most probable number, shape (...); 0 where none is known."""
        return np.asarray(np.nan_to_num(self.table[..., _COUNT]).astype(np.int64))

    @property
    def probability(self) -> FloatArray:
        """Probability of one touch, of two, and so on, shape (..., most), each being as likely before the frame."""
        return self.table[..., _FIRST : _FIRST + self.most]

    @property
    def residual(self) -> FloatArray:
        """Chi-square of the fit, as of `Estimate`."""
        return self.table[..., _RESIDUAL]

    @property
    def status(self) -> npt.NDArray[np.int8]:
        """`Status` of each frame, as integers: OK where number and touches are known."""
        return self.table[..., _STATUS].astype(np.int8)

    @cached_property
    def covariance(self) -> FloatArray:
        """Of (y, z, N, Ty, Tz) of the first touch, of the second and so on, shape (..., 5 most, 5 most) [m, N]."""
        size = _EACH * self.most
        return _check.read_only(self.table[..., _FIRST + self.most + size :].reshape(*self.shape, size, size))

    @cached_property
    def each(self) -> Estimate:
        """The touches one by one, the hardest first, shape (..., most); NaN for those that are not there."""
        first, size = _FIRST + self.most, _EACH * self.most
        out = np.full((*self.shape, self.most, AREA.columns), np.nan)
        out[..., : AREA.covariance] = self.table[..., first : first + size].reshape(*self.shape, self.most, _EACH)
        upper = np.triu_indices(_EACH)
        for t in range(self.most):
            part = slice(_EACH * t, _EACH * (t + 1))
            out[..., t, AREA.covariance : AREA.residual] = self.covariance[..., part, part][..., *upper]
        out[..., AREA.residual], out[..., AREA.status] = self.residual[..., None], self.status[..., None]
        out[..., AREA.rival_chi2] = self.table[..., _RIVAL, None]
        there = np.arange(self.most) < self.count[..., None]
        out[..., AREA.status] = np.where(there | (self.count[..., None] == 0), out[..., AREA.status], Status.NO_CONTACT)
        used = np.repeat(self.used[..., None, :], self.most, axis=-2)
        return Estimate(_check.read_only(out), used, self.friction, _EACH, AREA, self.relative)

    def moved(self, origin: npt.ArrayLike, turn: float = 0.0) -> Self:
        """The same touches on other axes, as of `moved` of one touch: positions, drags and their covariance.

        Parameters
        ----------
        origin : array_like, shape (2,)
            Where the finger's (0, 0) lies on the other axes [m].
        turn : float, optional
            By how much the finger's y lies turned from theirs, towards z [rad].
        """
        table, first, size = np.array(self.table), _FIRST + self.most, _EACH * self.most
        for at in range(first, first + size, _EACH):
            table[..., at : at + _DIM] = on_touches(table[..., at : at + _DIM], np.asarray(origin), turn)
            drag = slice(at + _DIM + 1, at + _EACH)
            table[..., drag] = on_touches(table[..., drag], np.zeros(_DIM), turn)
        pairs = [k for at in range(0, size, _EACH) for k in (at, at + _DIM + 1)]
        table[..., first + size :] = turned_square(self.covariance, pairs, turn).reshape(*self.shape, size**2)
        return replace(self, table=_check.read_only(table))

    def _shown(self) -> list[Shown]:
        each, none = self.each, np.zeros(self.shape)
        shown = [Shown("touches", np.where(self.count > 0, self.count, np.nan), none, "")]
        for t in range(self.most):
            one = each[..., t]
            std = one.std
            for j, name in enumerate("yz"):
                shown.append(Shown(f"{name} of touch {t + 1}", 1e3 * one.position[..., j], 1e3 * std[..., j], "mm"))
            shown.append(Shown(f"force of touch {t + 1}", one.force, std[..., _DIM], one.force_unit))
        return shown

    def _columns(self) -> dict[str, Any]:
        columns: dict[str, Any] = {"touches": self.count}
        for t in range(self.most):
            own = self.each[..., t].to_dict()
            names = [n for n in own if n not in ("status", "residual", "spare") and not n.startswith("second")]
            columns |= {f"{name}_{t + 1}": own[name] for name in names}
        columns |= {f"probability_{t + 1}": self.probability[..., t] for t in range(self.most)}
        return columns | super()._columns() | {"residual": self.residual}


class SeveralLocator(Framewise):
    """Finds up to `most` point loads that press an area at once; prepared once, then called on frames.

    For each number of touches the best are searched as `AreaLocator` does for one: globally, by all errors of the
    finger. Numbers are compared by Laplace's method: every position of the search, and every force up to the sum of
    those found, within the cone, is as likely before the frame (docs/locating_area.md).

    Parameters
    ----------
    one : AreaLocator
        Of one point load, and of what is not known of the finger.
    most : int
        The most touches, 2 or 3.

    Raises
    ------
    InvalidValueError
        A number of touches that is not 2 or 3.
    """

    def __init__(self, one: AreaLocator, most: int) -> None:
        self.one, self.most, self.friction = one, most, one.friction
        size = _EACH * most
        super().__init__(
            one.array, needed=one.unknowns, columns=_FIRST + most + size + size**2, status=_STATUS,
            ambiguity=one._ambiguity,
        )  # fmt: skip

    def covers(self, position: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Which positions lie where loads are looked for; as of `AreaLocator`."""
        return self.one.covers(position)

    def __call__(self, readings: npt.ArrayLike) -> TouchSet:
        """The touches in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As of `AreaLocator`.

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        table, used = self._frames(readings)
        return TouchSet(table, used, self.friction, self.most, self.relative)

    def _kernel(self) -> Any:
        from .settle.several import settle_several

        return settle_several

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        arrays = self.one._prepare(pattern)
        variants, errors, told, nodes, fields = arrays[-1]
        inside = self.one.covers(nodes)
        given = variants, errors, told, np.ascontiguousarray(nodes[inside]), np.ascontiguousarray(fields[inside])
        return arrays[0], given, Settings(*arrays[-2])

    def _allow(
        self, out: FloatArray, spread: Spread | None, friction: float, trusted: bool, doubted: FloatArray | float
    ) -> None:
        if spread is not None:  # the widest of the touches: their errors belong together
            first, size = _FIRST + self.most, _EACH * self.most
            ratio = np.nan_to_num(spread.at(out[:, first : first + size : _EACH], friction)).max(axis=-1, keepdims=True)
            out[:, first + size :] *= ratio**2
            near = out[:, _RIVAL] < self._apart * ratio[:, 0] ** 2
            out[near & (out[:, _STATUS] == Status.OK), _STATUS] = Status.AMBIGUOUS
        super()._allow(out, None, friction, trusted, doubted)

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        rows, given, settings = arrays
        every = _EACH * self.most
        blocks = np.empty((len(frames), self.most, _AT + every + every * (every + 1) // 2))
        self._compiled(frames, rows, given, blocks)
        self._judge(frames, blocks, rows, settings, out)

    def _judge(
        self, frames: FloatArray, blocks: FloatArray, rows: FloatArray, settings: Settings, out: FloatArray
    ) -> None:
        """Number, probabilities and status of each frame, from the blocks of `settle_several`."""
        n, most = frames.shape[1], self.most
        left, there = blocks[:, :, _LEFT], np.isfinite(blocks[:, :, _LEFT])
        evidence = np.stack([self._evidence(blocks[:, k], k + 1) for k in range(most)], axis=-1)
        chosen = np.where(there.any(axis=-1), evidence.argmax(axis=-1), 0)
        share = np.exp(evidence - evidence.max(axis=-1, keepdims=True, initial=-1e300))
        share /= np.maximum(share.sum(axis=-1, keepdims=True), 1e-300)
        largest = np.array([self._most_left(n, k + 1) for k in range(most)])
        w = (frames - rows[0]) * rows[1]
        out[:] = np.nan
        for k in range(most):
            index = np.flatnonzero(chosen == k)
            if not index.size:
                continue
            block, part = blocks[index, k], out[index]
            size = _EACH * (k + 1)
            at, force, covariance = _parts(block, k + 1)
            covariance = covariance * np.fmin(block[:, _STRETCH], 1e9)[:, None, None]
            order = np.argsort(-force[..., 0], axis=-1)
            each = np.concatenate([at, force], axis=-1)
            where = (_EACH * order[..., None] + np.arange(_EACH)).reshape(len(index), size)
            first = _FIRST + most
            part[:, first : first + size] = np.take_along_axis(each.reshape(len(index), size), where, axis=-1)
            square = np.full((len(index), _EACH * most, _EACH * most), np.nan)
            square[:, :size, :size] = covariance[
                np.arange(len(index))[:, None, None], where[:, :, None], where[:, None]
            ]
            part[:, first + _EACH * most :] = square.reshape(len(index), -1)
            part[:, _COUNT], part[:, _RESIDUAL], part[:, _RIVAL] = k + 1, block[:, _LEFT], block[:, _WORSE]
            part[:, _FIRST:first] = share[index]
            box, margin = settings.box.reshape(2, 2), 2 * settings.apart
            known = (np.linalg.eigvalsh(_of_positions(covariance)) < (_WIDE * self._depth) ** 2).all(axis=(-2, -1))
            known &= ((at > box[:, 0] + margin) & (at < box[:, 1] - margin)).all(axis=(-2, -1))
            known &= (share[index, k] >= _SURE) & (block[:, _WORSE] >= settings.ambiguity) & (n > size)
            part[:, _STATUS] = np.where(known, Status.OK, Status.AMBIGUOUS)
            none = ~(block[:, _LEFT] <= largest[k])
            heard = (w[index] ** 2).sum(axis=-1)  # where no load fits, noise alone has to explain all of it
            quiet = np.where(
                there[index, 0], heard - left[index, 0] < settings.detection, heard <= self._most_left(n, 0)
            )
            part[none | quiet] = np.nan
            part[none, _STATUS], part[none, _RESIDUAL] = Status.UNEXPLAINED, block[none, _LEFT]
            part[quiet, _STATUS] = Status.NO_CONTACT
            out[index] = part
        out[left[:, 0] < 0, _STATUS] = -1.0

    @property
    def _depth(self) -> float:
        return float(np.asarray(self.array.depth).min())

    def _most_left(self, sensors: int, count: int) -> float:
        from scipy.special import chdtri

        return float(chdtri(max(sensors - self.one.unknowns * count, 1), self.one._false_alarm))

    def _evidence(self, block: FloatArray, count: int) -> FloatArray:
        """Logarithm of the probability of the readings by so many touches (f,), up to what all numbers share."""
        _, force, free = _parts(block, count)
        there = np.isfinite(block[:, _LEFT])
        with np.errstate(invalid="ignore"):
            total = np.maximum(force[..., 0].sum(axis=-1), 1e-100)
        mu = min(self.friction, _STEEPEST)
        width = np.ones((len(block), count, _EACH))
        width[..., :_DIM] = np.ptp(np.asarray(self.one.search), axis=-1)
        width[..., _DIM] = total[:, None]
        width[..., _DIM + 1 :] = (np.sqrt(np.pi) * max(mu, 1e-100) * total)[:, None, None]
        keep = np.flatnonzero(np.arange(_EACH * count) % _EACH < (_EACH if mu > 0 else _DIM + 1))
        width = width.reshape(len(block), -1)[:, keep]
        square = free[:, keep][:, :, keep] / (width[:, :, None] * width[:, None])
        there = there & np.isfinite(square).all(axis=(-2, -1))
        square = np.where(there[:, None, None], square, np.eye(keep.size))
        information = np.linalg.inv(square) + 12 * np.eye(keep.size)
        log_det = np.linalg.slogdet(information)[1]
        value = -0.5 * (block[:, _LEFT] + block[:, _VOLUME] + log_det - keep.size * np.log(2 * np.pi))
        return np.where(there & np.isfinite(value), value + lgamma(count + 1), -np.inf)


def _parts(block: FloatArray, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Positions (f, count, 2), components (f, count, 3) and the covariance of all, touch by touch, of a block."""
    positions = _AT + _DIM * count
    at = block[:, _AT:positions].reshape(-1, count, _DIM)
    force = block[:, positions : positions + _FORCES * count].reshape(-1, count, _FORCES)
    return at, force, _square(block, count)


def _square(block: FloatArray, count: int) -> FloatArray:
    """The covariance with touch after touch, of a block that has positions first."""
    every = _EACH * count
    triangle = every * (every + 1) // 2
    begin = _AT + every
    square = np.zeros((len(block), every, every))
    rows, columns = np.triu_indices(every)
    square[:, rows, columns] = square[:, columns, rows] = block[:, begin : begin + triangle]
    touch = np.arange(count)[:, None]
    order = np.concatenate(
        [_DIM * touch + np.arange(_DIM), _DIM * count + _FORCES * touch + np.arange(_FORCES)], axis=1
    ).reshape(-1)
    return square[:, order][:, :, order]


def _of_positions(covariance: FloatArray) -> FloatArray:
    """Of the covariance of all (f, 5 count, 5 count) that of each touch's position (f, count, 2, 2)."""
    count = covariance.shape[-1] // _EACH
    parts = covariance.reshape(-1, count, _EACH, count, _EACH)
    return np.stack([parts[:, t, :_DIM, t, :_DIM] for t in range(count)], axis=1)


def checked_touches(touches: Any) -> int:
    """A number of touches that can be looked for."""
    if isinstance(touches, bool) or not isinstance(touches, int | np.integer) or not 1 <= touches <= MOST:
        rule = f"a whole number from 1 to {MOST} is needed"
        raise InvalidValueError(f"touches = {_check.shown(touches)}", rule, "touches=2")
    return int(touches)
