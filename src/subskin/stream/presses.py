"""A raw recording of an indenter that steps along a skin -> its presses, one row each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Fix, Noun, Real, checked
from .._frozen import Frozen
from .._shown import Tabled, span
from ..errors import GeometryError, InvalidValueError
from .stage import in_order

__all__ = ["Column", "Presses", "RecordingFormat", "segment"]

IndexArray = npt.NDArray[np.intp]

_LEVEL = 0.01  # a plateau holds its depth to this share of the stroke
_SHALLOW = 0.1  # a plateau no further above the lowest depth than this share of the stroke is no press
_TOUCH = 0.15  # without a depth: readings beyond this share of the largest change tell of contact
_HELD = 0.9  # and the plateau begins where this share of the press's own peak is reached
_FEWEST = 3  # frames in a plateau


@dataclass(frozen=True)
class Column(Noun):
    """A column of a recording by its `name`, and the SI value of one of its units, `scale`.

    Examples
    --------
    >>> Column("x", 1e-3)  # in mm
    Column(name='x', scale=0.001)
    """

    name: Annotated[str, Fix('Column("time")')]
    scale: float = 1.0


@dataclass(frozen=True)
class RecordingFormat(Noun):
    """How to read a raw recording.

    Parameters
    ----------
    sensors : tuple of str
        Columns of the sensors, in their order.
    scale : float
        SI reading per count.
    time : Column
        Time of each frame.
    position : Column or (Column, Column) or None
        Position of the indenter along the row, or on an area its y and z.
    press, force : Column or None
        How deep it has gone; the load that it presses with.
    early : float
        Share of a plateau, from its beginning, that is averaged: rubber relaxes.
    before : float
        Time before a press over which the free skin's reading is averaged [s].
    hold : float
        A plateau lasts at least this long [s].

    Examples
    --------
    >>> both = RecordingFormat(("s0", "s1"), position=(Column("y"), Column("z")))
    >>> [column.name for column in both.tracks["position"]]
    ['y', 'z']
    """

    sensors: tuple[str, ...]
    scale: float = 1.0
    time: Column = Column("time")
    position: Column | tuple[Column, Column] | None = None
    press: Column | None = None
    force: Column | None = None
    early: Annotated[float, Real(above=0.0, at_most=1.0, fix="early = 0.4 averages the first 40 %")] = 0.4
    before: Annotated[float, Real("s", above=0.0)] = 0.3
    hold: Annotated[float, Real("s", above=0.0)] = 0.5

    @property
    def tracks(self) -> dict[str, tuple[Column, ...]]:
        """The columns of position, press and force, of those that the recording has."""
        each = {"position": self.position, "press": self.press, "force": self.force}
        return {k: c if isinstance(c, tuple) else (c,) for k, c in each.items() if c is not None}


@dataclass(frozen=True, repr=False)
class Presses(Tabled, Frozen):
    """The presses of a recording; arrays of shape (presses,) or (presses, n).

    Parameters
    ----------
    start, stop : ndarray
        First and last time of the plateau [s].
    position : ndarray or None
        Mean position of the indenter on the plateau [m]; on an area (y, z), shape (presses, 2).
    depth : ndarray or None
        Mean depth of the indenter on the plateau, from the rest [m].
    force : ndarray or None
        Load, mean over the same frames as the reading, less that before the press [N/m or N].
    reading : ndarray, shape (presses, n)
        Early mean on the plateau less the mean just before the press, in the unit of the readings.
    std : ndarray, shape (presses, n)
        Standard error of the reading, from the scatter from frame to frame, in the same unit.
    skipped : int
        Plateaus left out because the recording shows no free skin before them.
    """

    start: FloatArray
    stop: FloatArray
    position: FloatArray | None
    depth: FloatArray | None
    force: FloatArray | None
    reading: FloatArray
    std: FloatArray
    skipped: int = 0

    def __len__(self) -> int:
        return len(self.start)

    def _title(self) -> str:
        left_out = f", {self.skipped} plateaus left out" if self.skipped else ""
        return f"{len(self)} presses of {self.reading.shape[1]} sensors{left_out}"

    def _shown(self) -> list[tuple[str, str]]:
        told = [("time", span([*self.start, *self.stop], "s"))]
        if self.position is not None:
            axes = ("position",) if self.position.ndim == 1 else ("position y", "position z")
            told += [(a, span(1e3 * v, "mm")) for a, v in zip(axes, np.atleast_2d(self.position.T), strict=True)]
        told += [] if self.depth is None else [("depth", span(1e3 * self.depth, "mm"))]
        told += [] if self.force is None else [("force", span(self.force))]
        return [*told, ("readings", span(self.reading)), ("std. error", span(self.std))]


@checked
def segment(
    readings: npt.ArrayLike,
    time: npt.ArrayLike,
    *,
    position: Annotated[npt.ArrayLike, Real("m")] | None = None,
    press: Annotated[npt.ArrayLike, Real("m")] | None = None,
    force: Annotated[npt.ArrayLike, Real("N/m")] | None = None,
    early: float = 0.4,
    before: float = 0.3,
    hold: float = 0.5,
) -> Presses:
    """Find the presses in a recording and take each one's reading.

    With `press`, the indenter's depth, a press is a plateau of it: depth that stays within 1 % of the whole stroke for
    at least `hold`, more than 10 % of the stroke above the lowest depth. Within 1 % of the lowest depth the skin is
    free; the last `before` seconds of that (or as many as there are) are the base that is taken off.

    Without `press` the readings decide. Contact is where a sensor has moved from where it began, the way it goes under
    its strongest press, by more than 15 % of the largest such move of any, for at least `hold`. The plateau begins
    where 90 % of the press's own peak is reached and ends where it falls for good below half of it. The base is the
    calmest stretch of `before` since the press before. So weaker presses are overlooked, and drift has to stay below
    these 15 %.

    Parameters
    ----------
    readings : array_like, shape (m, n)
        One frame a row; NaN is a missing reading.
    time : array_like, shape (m,)
        Time of each frame [s], not decreasing.
    position : array_like, shape (m,) or (m, 2), optional
        Position of the indenter along the row, or on an area (y, z) [m].
    press : array_like, shape (m,), optional
        Depth of the indenter [m], larger when deeper.
    force : array_like, shape (m,), optional
        Load that the indenter presses with [N/m or N], in the way that the readings are: from any zero.
    early : float, optional
        Share of the plateau, from its beginning, that is averaged.
    before, hold : float, optional
        Length of the base, and least length of a plateau [s].

    Returns
    -------
    Presses

    Raises
    ------
    InvalidValueError, GeometryError
        Shapes that do not match, times that go back, a position, depth or time that is not finite, no press at all.

    Examples
    --------
    >>> t = np.arange(0.0, 6.0, 0.01)
    >>> z = 2e-3 * np.clip(np.minimum(t - 1, 5 - t), 0, 1)
    >>> found = segment(1e5 + 3e6 * z[:, None], t, press=z)
    >>> len(found), round(float(found.reading[0, 0]), 1), round(float(found.depth[0]) * 1e3, 3)
    (1, 6000.0, 2.0)
    """
    readings = _check.readings(readings)
    if readings.ndim != 2 or not readings.size:
        seen = f"readings of shape {readings.shape}"
        raise GeometryError(seen, "one frame a row, one sensor a column", "shape (frames, sensors)")
    data, seconds = in_order(readings, time)
    given = {"position": position, "press": press, "force": force}
    tracks = {name: np.asarray(values) for name, values in given.items() if values is not None}
    for name, values in tracks.items():
        if values.shape != data.shape[:1] and not (name == "position" and values.shape == (len(data), 2)):
            seen = f"{name} of shape {values.shape}"
            raise GeometryError(seen, f"one for each of the {len(data)} frames", f"shape ({len(data)},)")
    options = RecordingFormat(("",), early=early, before=before, hold=hold)
    early, before, hold = options.early, options.before, options.hold
    z = tracks.get("press")
    found = _from_readings(data, seconds, before, hold) if z is None else _from_depth(z, seconds, before, hold)
    kept = found.base_stop > found.base_start
    first, stop, base_start, base_stop = (part[kept] for part in found)
    if not first.size:
        what = "no plateau of the indenter's depth" if z is not None else "no contact in the readings"
        raise InvalidValueError(what, "a recording needs a press with free skin before it", _fix(z is not None))
    # the early part by time, not by frames: the rate may change
    until = seconds[first] + early * (seconds[stop - 1] - seconds[first])
    early_stop = np.clip(np.searchsorted(seconds, until, side="right"), first + 1, stop)
    loaded, loaded_var = _mean(data, first, early_stop)
    rest, rest_var = _mean(data, base_start, base_stop)
    return Presses(
        start=_check.read_only(seconds[first]),
        stop=_check.read_only(seconds[stop - 1]),
        position=_level(tracks.get("position"), first, stop),
        depth=None if z is None else _level(z - z.min(), first, stop),
        force=None if force is None else _change(tracks["force"], first, early_stop, base_start, base_stop),
        reading=_check.read_only(loaded - rest),
        std=_check.read_only(np.sqrt(loaded_var + rest_var)),
        skipped=int((~kept).sum()),
    )


def _level(track: FloatArray | None, first: IndexArray, stop: IndexArray) -> FloatArray | None:
    """Mean of a track on each plateau, to a picometre: a sum of equal values does not end on quite that value."""
    if track is None:
        return None
    each = _mean(track.reshape(len(track), -1), first, stop)[0].round(12)
    return _check.read_only(each.reshape(len(first), *track.shape[1:]))


def _change(track: FloatArray, first: IndexArray, stop: IndexArray, before: IndexArray, end: IndexArray) -> FloatArray:
    """Mean of a track over some frames less that over others."""
    loaded, rest = (_mean(track[:, None], *frames)[0][:, 0] for frames in ((first, stop), (before, end)))
    return _check.read_only(loaded - rest)


def _fix(by_depth: bool) -> str:
    if by_depth:
        return "check the column, hold, and the sign of press: deeper is larger, a negative unit turns it round"
    return "give [recording] press, the indenter's depth, if it was recorded"


class _Plateaus(NamedTuple):
    """First and past-the-last frame of each plateau, and of the free skin before it."""

    first: IndexArray
    stop: IndexArray
    base_start: IndexArray
    base_stop: IndexArray


def _from_depth(z: FloatArray, time: FloatArray, before: float, hold: float) -> _Plateaus:
    low = float(z.min())
    stroke = float(z.max()) - low
    level = _span(z[:, None], _frames(time, hold))
    begin, end = _runs(level <= _LEVEL * stroke)
    stop = end + _frames(time, hold) - 1
    held = z[(begin + stop) // 2] > low + _SHALLOW * stroke
    first, stop = begin[held], stop[held]
    frames = np.arange(z.size)
    free = z <= low + _LEVEL * stroke
    last = np.maximum.accumulate(np.where(free, frames, -1))[first]
    # the free run that holds the last free frame begins after the frame that was last not free
    run = np.maximum.accumulate(np.where(free, -1, frames))[last] + 1
    since = np.searchsorted(time, time[last] - before, side="left")
    return _Plateaus(first, stop, np.maximum(run, since), last + 1)


def _from_readings(data: FloatArray, time: FloatArray, before: float, hold: float) -> _Plateaus:
    begin = max(int(np.searchsorted(time, time[0] + hold, side="right")), 1)
    seen = np.isfinite(data)
    start = np.array([np.median(c[ok][:begin]) if ok.any() else 0.0 for c, ok in zip(data.T, seen.T, strict=True)])
    move = np.where(seen, np.where(seen, data, 0.0) - start, 0.0)
    # each sensor's own way under a press; the recoil of relaxed rubber goes the other way
    largest = np.take_along_axis(move, np.abs(move).argmax(axis=0)[None, :], axis=0)
    moved = np.maximum(np.sign(largest) * move, 0.0).max(axis=1)
    if moved.size > 2:  # a single wild frame is no contact
        moved[1:-1] = np.median(np.stack([moved[:-2], moved[1:-1], moved[2:]]), axis=0)
    onset, end = _runs(moved > _TOUCH * moved.max())
    long = time[end - 1] - time[onset] >= hold
    onset, end = onset[long], end[long]
    first, stop, base = onset.copy(), end.copy(), np.zeros_like(onset)
    count = _frames(time, before)
    calm = _span(np.where(seen, data, start), count)
    previous = 0
    for k, (a, e) in enumerate(zip(onset, end, strict=True)):
        part = moved[a:e]
        first[k] = a + int(np.argmax(part >= _HELD * part.max()))
        stop[k] = e - int(np.argmax(part[::-1] >= 0.5 * part.max()))
        room = calm[previous : max(a - count, previous)]
        base[k] = previous + int(np.argmin(room)) if room.size else -1
        previous = int(e)
    return _Plateaus(first, stop, np.maximum(base, 0), np.where(base < 0, 0, base + count))


def _frames(time: FloatArray, seconds: float) -> int:
    """How many frames last so long, at the usual rate; where it is more than there are, one more."""
    step = float(np.median(np.diff(time))) if time.size > 1 else 0.0
    return max(round(min(seconds / step, time.size + 1)) if step > 0 else _FEWEST, _FEWEST)


def _span(data: FloatArray, width: int) -> FloatArray:
    """Largest less smallest value over `width` frames, summed over sensors, for each frame they may begin at."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    windows = len(data) - width + 1
    if windows < 1:
        return np.empty(0)
    high, low = (f(data, width, axis=0) for f in (maximum_filter1d, minimum_filter1d))
    return np.asarray((high - low).sum(axis=1)[width // 2 : width // 2 + windows])


def _runs(flags: npt.NDArray[np.bool_]) -> tuple[IndexArray, IndexArray]:
    """First and past-the-last index of each run of true."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)


def _mean(data: FloatArray, start: IndexArray, stop: IndexArray) -> tuple[FloatArray, FloatArray]:
    """Mean of the frames start to stop of each sensor and the variance of that mean; NaN counts as missing.

    The variance is that of successive differences, which a slow trend (drift, relaxation) does not inflate.
    """
    seen = np.isfinite(data)
    # sums of what is left of the largest value keep the digits that absolute pressures would use up
    level = np.where(seen.any(axis=0), np.where(seen, data, -np.inf).max(axis=0), 0.0)
    away = np.where(seen, data - level, 0.0)
    total, count = _sums(away, start, stop), _sums(seen.astype(np.float64), start, stop)
    pair = seen[1:] & seen[:-1]
    jump = np.where(pair, away[1:] - away[:-1], 0.0) ** 2
    jumps, pairs = _sums(jump, start, stop - 1), _sums(pair.astype(np.float64), start, stop - 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = total / count
        variance = jumps / (2 * pairs) / count
    return np.where(count > 0, mean + level, np.nan), variance


def _sums(values: FloatArray, start: IndexArray, stop: IndexArray) -> FloatArray:
    """Sum over the frames start to stop, past-the-last; 0 over none."""
    padded = np.concatenate([values, np.zeros((1, values.shape[1]))])
    pairs = np.stack([start, np.maximum(stop, start)], axis=-1).reshape(-1)
    total = np.add.reduceat(padded, pairs, axis=0)[::2]
    return np.where((stop > start)[:, None], total, 0.0)
