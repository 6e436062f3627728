"""A raw recording of an indenter that steps along a skin -> its presses, one row each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError

__all__ = ["Column", "Presses", "RecordingFormat", "segment"]

IndexArray = npt.NDArray[np.intp]

_LEVEL = 0.01  # a plateau holds its depth to this share of the stroke
_FREE = 0.1  # the skin is free, and the indenter no press, up to this share of the stroke above the rest
_TOUCH = 0.15  # without a depth: readings beyond this share of the largest change tell of contact
_HELD = 0.9  # and the plateau begins where this share of the press's own peak is reached
_FEWEST = 3  # frames in a plateau


@dataclass(frozen=True)
class Column:
    """A column of a recording: its name, and what one count of it is worth in SI."""

    name: str
    scale: float = 1.0


@dataclass(frozen=True)
class RecordingFormat:
    """How to read a raw recording.

    Parameters
    ----------
    sensors : tuple of str
        Columns of the sensors, in the order of the row.
    scale : float
        SI reading per count.
    time : Column
        Time of each frame.
    position, press : Column or None
        Place of the indenter along the row; how deep it has gone.
    early : float
        Share of a plateau, from its beginning, that is averaged: rubber relaxes.
    before : float
        Time before a press over which the free skin's reading is averaged [s].
    hold : float
        A plateau lasts at least this long [s].
    """

    sensors: tuple[str, ...]
    scale: float = 1.0
    time: Column = Column("time")
    position: Column | None = None
    press: Column | None = None
    early: float = 0.4
    before: float = 0.3
    hold: float = 0.5

    def __post_init__(self) -> None:
        _check.scalar("early", self.early, above=0.0, at_most=1.0, fix="early = 0.4 averages the first 40 %")
        _check.scalar("before", self.before, unit="s", above=0.0)
        _check.scalar("hold", self.hold, unit="s", above=0.0)


@dataclass(frozen=True)
class Presses:
    """The presses of a recording; arrays of shape (presses,) or (presses, n).

    Parameters
    ----------
    start, stop : ndarray
        First and last time of the plateau [s].
    position : ndarray or None
        Mean place of the indenter on the plateau [m].
    depth : ndarray or None
        Mean depth of the indenter on the plateau, from the rest [m].
    reading : ndarray, shape (presses, n)
        Early mean on the plateau less the mean just before the press.
    std : ndarray, shape (presses, n)
        Standard error of the reading, from the scatter from frame to frame.
    skipped : int
        Plateaus left out because the recording shows no free skin before them.
    """

    start: FloatArray
    stop: FloatArray
    position: FloatArray | None
    depth: FloatArray | None
    reading: FloatArray
    std: FloatArray
    skipped: int = 0

    def __len__(self) -> int:
        return len(self.start)


def segment(
    readings: npt.ArrayLike,
    time: npt.ArrayLike,
    *,
    position: npt.ArrayLike | None = None,
    press: npt.ArrayLike | None = None,
    early: float = 0.4,
    before: float = 0.3,
    hold: float = 0.5,
) -> Presses:
    """Find the presses in a recording and take each one's reading.

    With `press`, the indenter's depth, a press is a plateau of it: depth that stays within 1 % of the whole stroke for
    at least `hold`, more than 10 % of the stroke above the lowest depth. Up to these 10 % the skin is free; the
    last `before` seconds of that are the base from which the reading is taken.

    Without `press` the readings tell: contact is where a sensor has moved from where it began by more than 15 % of
    the largest such change in the recording, and the plateau begins where 90 % of the press's own peak are
    reached. Drift and a skin that does not come back have to stay below these 15 %, and so are presses that are weaker
    overlooked.

    Parameters
    ----------
    readings : array_like, shape (m, n)
        One frame a row; NaN is a missing reading.
    time : array_like, shape (m,)
        Time of each frame [s], not decreasing.
    position, press : array_like, shape (m,), optional
        Place along the row and depth of the indenter [m], larger when deeper.
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
        Shapes that do not match, times that go back, a place, depth or time that is not finite, no press at all.

    Examples
    --------
    >>> t = np.arange(0.0, 6.0, 0.01)
    >>> z = 2e-3 * np.clip(np.minimum(t - 1, 5 - t), 0, 1)
    >>> found = segment(1e5 + 3e6 * z[:, None], t, press=z)
    >>> len(found), round(float(found.reading[0, 0]), 3), round(float(found.depth[0]) * 1e3, 3)
    (1, 6000.0, 2.0)
    """
    data = _check.real("readings", readings, finite=False)
    if data.ndim != 2 or not data.size:
        raise GeometryError(f"readings of shape {data.shape}", "one frame a row, one sensor a column")
    seconds = _check.real("time", time, unit="s")
    tracks = {"time": seconds}
    tracks |= {
        name: _check.real(name, values, unit="m")
        for name, values in (("position", position), ("press", press))
        if values is not None
    }
    for name, values in tracks.items():
        if values.shape != data.shape[:1]:
            raise GeometryError(f"{name} of shape {values.shape}", f"one for each of the {len(data)} frames")
    back = np.flatnonzero(np.diff(seconds) < 0)
    if back.size:
        i = int(back[0]) + 1
        seen = f"time[{i}] = {seconds[i]:.6g}"
        raise InvalidValueError(
            seen, f"time must not go back (it was {seconds[i - 1]:.6g})", "sort the recording"
        )
    RecordingFormat(("",), early=early, before=before, hold=hold)  # checks the options
    z = tracks.get("press")
    free, first, stop = _from_readings(data, seconds, hold) if z is None else _from_depth(z, seconds, hold)
    base = _last_free(free, first)
    kept = base >= 0
    skipped = int((~kept).sum())
    first, stop, base = first[kept], stop[kept], base[kept]
    if not first.size:
        what = "no plateau of the indenter's depth" if z is not None else "no contact in the readings"
        raise InvalidValueError(
            what, "a recording needs a press with free skin before it", _fix(z is not None)
        )
    # the early part by time, not by frames: the rate may change
    until = seconds[first] + early * (seconds[stop - 1] - seconds[first])
    early_stop = np.maximum(np.searchsorted(seconds, until, side="right"), first + 1)
    early_stop = np.minimum(early_stop, stop)
    since = np.searchsorted(seconds, seconds[base] - before, side="left")
    since = np.maximum(since, _run_start(free, base))
    loaded, loaded_var = _mean(data, first, early_stop)
    rest, rest_var = _mean(data, since, base + 1)
    place = tracks.get("position")
    return Presses(
        start=_check.read_only(seconds[first]),
        stop=_check.read_only(seconds[stop - 1]),
        position=None if place is None else _check.read_only(_mean(place[:, None], first, stop)[0][:, 0]),
        depth=None
        if z is None
        else _check.read_only(_mean(z[:, None], first, stop)[0][:, 0] - float(z.min())),
        reading=_check.read_only(loaded - rest),
        std=_check.read_only(np.sqrt(loaded_var + rest_var)),
        skipped=skipped,
    )


def _fix(by_depth: bool) -> str:
    if by_depth:
        return "check the column and the sign of press (deeper is larger; a negative unit turns it round), and hold"
    return "give [recording] press, the indenter's depth, if it was recorded"


def _from_depth(
    z: FloatArray, time: FloatArray, hold: float
) -> tuple[npt.NDArray[np.bool_], IndexArray, IndexArray]:
    """Which frames are free, and first and past-the-last frame of each plateau."""
    low = float(z.min())
    stroke = float(z.max()) - low
    free = z <= low + _FREE * stroke
    if stroke == 0:
        return free, np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp)
    # From each frame, how far the depth stays within the level: frames are cut into runs greedily, deepest level
    # first would miss a slow approach, so a run is anchored at the frame from which it lasts `hold`.
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    step = float(np.median(np.diff(time))) if z.size > 1 else 0.0
    width = max(int(round(hold / step)) if step > 0 else _FEWEST, _FEWEST)
    if width > z.size:
        return free, np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp)
    # origin: the window of frame i reaches from i to i + width - 1
    shift = -((width - 1) // 2) if width % 2 else -(width // 2)
    del shift
    windows = z.size - width + 1
    centre = width // 2
    span = (
        maximum_filter1d(z, width)[centre : centre + windows]
        - minimum_filter1d(z, width)[centre : centre + windows]
    )
    level = span <= _LEVEL * stroke
    edges = np.diff(np.concatenate([[0], level.astype(np.int8), [0]]))
    first, last = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    stop = last - 1 + width
    held = z[(first + stop) // 2] > low + _FREE * stroke
    return free, first[held], stop[held]
