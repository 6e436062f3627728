"""What all estimators that go frame by frame share: sensors that are out, and the loop compiled once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._cold import at_once
from ..array import SensorArray
from ..errors import GeometryError, InvalidValueError
from ..prepared import Prepared
from ..response import Response
from .answer import Status
from .layout import Layout

if TYPE_CHECKING:
    from ..finger import Finger
    from ..spread import Spread

__all__ = ["Framewise", "check_noise", "packed", "patterns", "scan_geometry", "sensor_rows"]

_MOST_PATTERNS = 64
_CHANCE = 1e-3
"""A frame without its outlier is explained where noise would leave as much with this chance."""
_WILD = 1e100
"""Noises to a gain or to 1, from which squares overflow."""
_NONE = np.empty(0, dtype=bool)


class Framewise(ABC):
    """An estimator of frames by a compiled loop, which is prepared for each set of sensors that can be used.

    Parameters
    ----------
    array : SensorArray
        Offset, noise and range of each sensor.
    needed : int
        Least number of sensors.
    columns, status : int
        Number of columns of the packed results, and that of the status.
    layout : Layout, optional
        All columns, of an estimator that names a rival.
    outliers : int
        0, or 1: unexplained frames are tried again without each of their readings.
    ambiguity : float
        Two omissions whose chi-squares differ by less than this make the frame ambiguous.
    """

    def __init__(
        self,
        array: SensorArray,
        *,
        needed: int,
        columns: int,
        status: int,
        layout: Layout | None = None,
        outliers: int = 0,
        ambiguity: float = 0.0,
    ) -> None:
        if isinstance(outliers, bool | np.ndarray) or outliers not in (0, 1):
            rule = "has to be 0, or 1 to try unexplained frames without each one reading"
            raise InvalidValueError(f"outliers = {outliers!r}", rule, "outliers=1")
        fix = "SensorArray(..., noise=1e-4), or calibrate, which measures it"
        check_noise(array, "estimates weigh sensors by their noise", fix)
        self.array = array
        self._needed, self._columns = needed, columns
        self._status, self._layout, self._outliers, self._apart = status, layout, int(outliers), ambiguity
        self._prepared = Prepared(_MOST_PATTERNS)
        self._all = array.live
        noise, gain = np.asarray(array.noise)[self._all], np.abs(np.asarray(array.gain)[self._all])
        self._reckoned = bool((noise > 1 / _WILD).all() and (gain / _WILD < noise).all())
        self._sensors = self._all.size
        self._every = bool(self._all.all())
        self._enough = int(self._all.sum()) >= needed and self._reckoned
        self._used = np.broadcast_to(self._all, (1, self._sensors))
        self._arrays: tuple[Any, ...] = ()
        self._compiled: Any = None
        self._linear = all(t.linear for t in set(array.transducers))
        self._allowed: tuple[Spread | None, float, bool] | None = None
        self._search_ends: tuple[float, ...] = ()
        self.relative = False

    def allow_for(self, finger: Finger, friction: float) -> Self:
        """The same estimator, its standard errors widened by the finger's spread; none is OK of one without trust.

        Its forces are newtons, or not, as the finger's are.
        """
        self.relative = finger.relative
        if not finger.trusted:
            said = "the finger's model is not that of its touches, and was accepted: no frame of it is OK"
            _check.warn(said)
        usual = finger.trusted and finger.spread is None
        self._allowed = None if usual else (finger.spread, friction, finger.trusted)
        return self

    def warm_up(self) -> Self:
        """The same estimator, with all compiled and tabulated that its first frames would else wait for.

        Without it the first 16 frames after an installation go in plain Python, at up to 0.1 s each; then some seconds
        pass while the loop is compiled.

        Examples
        --------
        >>> import subskin as ss
        >>> row = ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=1e-4)
        >>> locate = ss.Finger(ss.HalfPlane(ss.Material(young=1e6)), row).locator().warm_up()
        >>> ss.Status(locate([0.0] * 6).status).name
        'NO_CONTACT'
        """
        with at_once():
            self._frames(np.asarray(self.array.offset))
        return self

    @abstractmethod
    def _kernel(self) -> Any:
        """The compiled loop, imported on first use."""

    @abstractmethod
    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Arguments of the compiled loop between the frames and the output, for the sensors of `pattern`."""

    def _frames(
        self, readings: npt.ArrayLike, doubt: npt.ArrayLike | None = None
    ) -> tuple[FloatArray, npt.NDArray[np.bool_]]:
        """Packed results (..., columns) and the sensors used (..., n); `doubt` of estimators that take one."""
        raw = _check.readings(readings)
        n = self._sensors
        if raw.ndim == 0 or raw.shape[-1] != n:
            raise GeometryError(
                f"readings of shape {raw.shape}", f"the last axis has to be the {n} sensors", f"shape (frames, {n})"
            )
        more = None if doubt is None else self._doubts(raw, doubt)
        if not self._linear:
            raw = self._linearised(raw)
        frames = np.ascontiguousarray(raw.reshape(-1, n))
        if not frames.flags.writeable:  # a loop would be compiled once more for an array that is read-only
            frames = frames.copy()
        out = np.empty((len(frames), self._columns))
        used, pending = self._used, _NONE
        if self._enough:
            live = frames if self._every else np.ascontiguousarray(frames[:, self._all])
            self._run(live, self._all, out, None if more is None else more[:, self._all])
            if len(out) != len(used):  # batches of a live loop are as long as the one before
                self._used = used = np.broadcast_to(self._all, frames.shape)
            status = out[:, self._status]
            if (status[0] if len(status) == 1 else status.min(initial=0.0)) < 0:
                pending = status < 0
        else:
            pending = np.ones(len(frames), dtype=bool)
        if pending is not _NONE:
            used = self.array.usable(frames)
            self._run_patterns(frames, used, pending, out, more)
        if self._outliers:
            used = self._without_outliers(frames, used, out, more)
        used.setflags(write=False)
        out.setflags(write=False)
        if raw.ndim == 2:
            return out, used
        return out.reshape((*raw.shape[:-1], self._columns)), used.reshape(raw.shape)

    def _linearised(self, raw: FloatArray) -> FloatArray:
        """Readings as if each transducer were its linear part; those outside the range stay outside."""
        linear = np.array(raw)
        gain, offset = np.asarray(self.array.gain), np.asarray(self.array.offset)
        for i, kind in enumerate(self.array.transducers):
            if not kind.linear and gain[i] != 0:
                inside = self.array.usable(raw)[..., i]
                value = gain[i] * kind.linearise((raw[..., i] - offset[i]) / gain[i]) + offset[i]
                linear[..., i] = np.where(inside, value, np.nan)
        return linear

    def _doubts(self, raw: FloatArray, doubt: npt.ArrayLike) -> FloatArray:
        """A doubt (f, n) of each reading: 0 where there is none, in units of the linear part of its transducer."""
        given = _check.readings(doubt, "doubt")
        if given.shape != raw.shape:
            rule = f"one of each reading, {raw.shape}, is needed"
            raise GeometryError(f"doubt of shape {given.shape}", rule, "doubt=tared.doubt")
        if (given < 0).any():
            raise InvalidValueError(
                f"doubt = {np.nanmin(given):.6g}", "has to be >= 0", "a standard deviation [reading]"
            )
        if not self._linear:
            moved = np.abs(self._linearised(raw + given) - self._linearised(raw))
            given = np.where(np.isfinite(moved), moved, given)
        return np.where(np.isfinite(given), given, 0.0).reshape(-1, self._sensors)

    def _run_patterns(
        self,
        frames: FloatArray,
        used: npt.NDArray[np.bool_],
        pending: npt.NDArray[np.bool_],
        out: FloatArray,
        doubt: FloatArray | None,
    ) -> None:
        """Frames in which a sensor is out, grouped by the sensors that are left."""
        for pattern, rows in patterns(used, pending):
            if pattern.sum() < self._needed:
                out[rows] = np.nan
                if self._layout is not None:
                    out[rows, self._layout.rival_chi2] = np.inf
                out[rows, self._status] = Status.INCOMPLETE
                continue
            out[rows] = self._part(frames[rows], pattern, None if doubt is None else doubt[rows])

    def _part(self, frames: FloatArray, pattern: npt.NDArray[np.bool_], doubt: FloatArray | None) -> FloatArray:
        """Packed results of frames by the sensors of `pattern`, all of which can be used."""
        part = np.full((len(frames), self._columns), -1.0)
        if self._reckoned:
            more = None if doubt is None else doubt[:, pattern]
            self._run(np.ascontiguousarray(frames[:, pattern]), pattern, part, more)
        # readings so many noises large that the digits of a float end before: no load explains them to the noise
        beyond = part[:, self._status] < 0
        if beyond.any():
            part[beyond] = np.nan
            part[beyond, self._status] = Status.UNEXPLAINED
            if self._layout is not None:
                part[beyond, self._layout.rival_chi2] = part[beyond, self._layout.residual] = np.inf
        return part

    def _without_outliers(
        self, frames: FloatArray, used: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None
    ) -> npt.NDArray[np.bool_]:
        """Unexplained frames once more without each one reading; fills `out`, returns the sensors used then.

        Where an omission explains a frame and no other comes within `ambiguity` of its chi-square, the answer is that
        of the rest; where one does, it is AMBIGUOUS. One reading more than unknowns has to be left to speak.
        """
        from scipy.special import chdtri

        columns = self._layout
        if columns is None:
            return used
        again = (out[:, self._status] == Status.UNEXPLAINED) & (used.sum(axis=-1) >= self._needed + 2)
        if not again.any():
            return used
        found = np.array(used)
        for pattern, rows in patterns(used, again):
            largest = float(chdtri(int(pattern.sum()) - 1 - self._needed, _CHANCE))
            sensors = np.flatnonzero(pattern)
            parts = np.empty((sensors.size, len(rows), self._columns))
            for part, sensor in zip(parts, sensors, strict=True):
                rest = pattern.copy()
                rest[sensor] = False
                part[:] = self._part(frames[rows], rest, None if doubt is None else doubt[rows])
            left = parts[..., columns.residual]
            order = np.argsort(left, axis=0)
            each = np.arange(len(rows))
            best, after = parts[order[0], each], parts[order[1], each]
            explained = (best[:, self._status] != Status.UNEXPLAINED) & (left[order[0], each] <= largest)
            with np.errstate(invalid="ignore"):  # both may be infinite
                worse = left[order[1], each] - left[order[0], each]
            tied = worse < self._apart
            # a touch with one reading lost, or none with one wild: there is no load to give
            explained &= ~(tied & np.isnan(best[:, 0] + after[:, 0]))
            best[tied, self._status] = Status.AMBIGUOUS
            nearer = tied & (worse < best[:, columns.rival_chi2])
            best[nearer, columns.rival : columns.rival_chi2] = after[nearer, : columns.unknowns]
            best[nearer, columns.rival_chi2] = worse[nearer]
            out[rows[explained]] = best[explained]
            found[rows[explained], sensors[order[0]][explained]] = False
        return found

    def _run(
        self, frames: FloatArray, pattern: npt.NDArray[np.bool_], out: FloatArray, doubt: FloatArray | None = None
    ) -> None:
        if pattern is not self._all:
            arrays = self._prepared.get(pattern.tobytes(), partial(self._prepare, pattern))
        elif not self._arrays:
            arrays = self._arrays = self._prepare(pattern)
        else:  # the shortest way for a frame by itself
            arrays = self._arrays
        if self._compiled is None:
            self._compiled = self._kernel()
        if doubt is None:
            self._fill(frames, arrays, out)
        else:
            self._doubted(frames, doubt, arrays, pattern, out)
        if self._allowed is not None:
            self._allow(out, *self._allowed, 0.0 if doubt is None else self._in_doubt(doubt, pattern))

    def _fill(self, frames: FloatArray, arrays: tuple[Any, ...], out: FloatArray) -> None:
        """What the compiled loop finds in frames, into `out` (f, columns)."""
        self._compiled(frames, *arrays, out)

    def _doubted(
        self,
        frames: FloatArray,
        doubt: FloatArray,
        arrays: tuple[Any, ...],
        pattern: npt.NDArray[np.bool_],
        out: FloatArray,
    ) -> None:
        """The loop over frames whose readings have a doubt; of the estimators that take one."""
        raise InvalidValueError(
            f"doubt of the readings of a {type(self).__name__}", "it weighs all frames by the same noise", "doubt=None"
        )

    def _in_doubt(self, doubt: FloatArray, pattern: npt.NDArray[np.bool_]) -> FloatArray:
        """Of each frame the largest share that doubt has in a reading's variance, shape (f, 1)."""
        ratio2 = (doubt / np.asarray(self.array.noise)[pattern]) ** 2
        return np.asarray((ratio2 / (1 + ratio2)).max(axis=-1, keepdims=True, initial=0.0))

    def _allow(
        self, out: FloatArray, spread: Spread | None, friction: float, trusted: bool, doubted: FloatArray | float
    ) -> None:
        """What the finger's misfit does to packed results (f, columns): covariances and intervals, and what is OK.

        A spread below 1 says that the noise is misfit, alike in neighbours. It takes nothing off the share of a
        variance that is `doubted`, (f, 1).
        """
        if spread is not None and self._layout is not None:
            at = self._layout
            ratio = spread.at(out[:, :1], friction)
            ratio = np.sqrt(ratio**2 + doubted * np.maximum(1 - ratio**2, 0.0))
            out[:, at.covariance : at.interval] *= ratio**2
            # what explains a frame nearly as well by so much larger errors: a rival, or a load at an end of the search
            y, status = out[:, 0], out[:, at.status]
            near = out[:, at.rival_chi2] < self._apart * ratio[:, 0] ** 2
            for end in self._search_ends:
                near |= (y - end) ** 2 < self._apart * out[:, at.covariance]
            status[(status == Status.OK) & near] = Status.AMBIGUOUS
            if at.wide:  # readings know the square of the half width
                interval, best = out[:, at.interval : at.residual], out[:, at.half_width, None] ** 2
                interval[:] = np.sqrt(np.maximum(best + ratio * (interval**2 - best), 0.0))
        if not trusted:
            status = out[:, self._status]
            status[status == Status.OK] = Status.AMBIGUOUS


def patterns(
    used: npt.NDArray[np.bool_], chosen: npt.NDArray[np.bool_]
) -> Iterator[tuple[npt.NDArray[np.bool_], npt.NDArray[np.intp]]]:
    """Each set of sensors in the `chosen` (f,) of the frames' `used` (f, n), and which frames have it."""
    index = np.flatnonzero(chosen)
    sets = used[index]
    if index.size and (sets == sets[0]).all():  # a sensor is dead: the same ones in all frames
        yield sets[0], index
        return
    kinds, group = np.unique(sets, axis=0, return_inverse=True)
    for g, kind in enumerate(kinds):
        yield kind, index[group.reshape(-1) == g]


def check_noise(array: SensorArray, why: str, fix: str, noise: npt.ArrayLike | None = None) -> None:
    """Refuse a live sensor without noise, which has to be the array's own, or `noise`."""
    silent = np.flatnonzero((np.asarray(array.noise if noise is None else noise) == 0) & array.live)
    if silent.size:
        raise InvalidValueError(f"noise = 0 of sensor {silent[0]}", f"{why}, so each needs one > 0", fix)


def sensor_rows(array: SensorArray) -> FloatArray:
    """Offset, 1 / noise, and the ends of the range, shape (4, n)."""
    # a sensor with an infinite range is compared with the largest float: NaN and infinity then fall outside
    big = np.finfo(np.float64).max
    low, high = np.maximum(np.asarray(array.low), -big), np.minimum(np.asarray(array.high), big)
    return np.stack([np.asarray(array.offset), 1 / np.asarray(array.noise), low, high])


def scan_geometry(
    fields: FloatArray, friction: float, whole: int = 1
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], FloatArray]:
    """Orthonormal columns of A at each position, shape (n, 2, m), and the cone's unit edges in them, shape (4, m).

    And the columns of A themselves in that basis: the length of the first, and both components of the second, (3, m).
    Zeros stand behind the first two up to a multiple of `whole` positions.
    """
    normal, tangential = fields[..., 0], fields[..., 1]
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    q1 = normal / np.where(size > 0, size, 1)
    along = np.sum(q1 * tangential, axis=1, keepdims=True)
    rest = tangential - along * q1
    across = np.linalg.norm(rest, axis=1, keepdims=True)
    q2 = rest / np.where(across > 0, across, 1)
    edges = []
    for sign in (-1.0, 1.0):
        n, t = (1.0, sign * friction) if np.isfinite(friction) else (0.0, sign)
        edge = np.stack([n * size[:, 0] + t * along[:, 0], t * across[:, 0]])
        length = np.hypot(*edge)
        edges.append(edge / np.where(length > 0, length, 1))
    basis = np.stack([q1.T, q2.T], axis=1)
    shapes = np.stack([size[:, 0], along[:, 0], across[:, 0]])
    pad = -basis.shape[-1] % whole
    basis, cone = np.pad(basis, ((0, 0), (0, 0), (0, pad))), np.pad(np.concatenate(edges), ((0, 0), (0, pad)))
    return basis.astype(np.float32, order="C"), cone.astype(np.float32, order="C"), shapes


def packed(response: Response, scale: FloatArray) -> FloatArray:
    """Coefficients times `scale` (n,), as compiled loops want them: (cells, 5, 2, n), or (cells, widths, 10 n)."""
    part = np.swapaxes(response.coefficients * scale[:, None], -1, -2)
    if response.widest:
        part = np.moveaxis(part, 0, 1).reshape(part.shape[1], part.shape[0], -1)
    return np.ascontiguousarray(part)
