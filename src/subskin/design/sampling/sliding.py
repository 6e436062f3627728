"""Samples that sliding adds: where a row's readings lie on the thing touched, frame after frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._frozen import Result
from ...array import SensorArray
from ...errors import GeometryError, InvalidValueError
from .._common import index_of

__all__ = ["SlidingSamples", "sliding_samples"]

_SAME = 1e-9
"""Samples closer than this share of a step lie at one position."""


@dataclass(frozen=True, eq=False)
class SlidingSamples(Result):
    """What `sliding_samples` found.

    Attributes
    ----------
    step : float
        How far the skin slides from one frame to the next [m].
    distance : float
        How far it slides in all [m].
    position : ndarray, shape (m,)
        Different positions sampled on the stretch that every sensor passes over, one step of it [m], ascending.
    visits : float
        Mean number of samples at each of these positions: more than 1 where sensors follow in others' tracks.
    pitch : float
        The widest gap between neighbouring positions [m]: what the row's pitch is to be replaced by.
    mean_pitch : float
        Step over the number of positions [m]; smaller than `pitch` where samples come in bunches.
    noise_gain : float
        Noise of the readings recovered between the samples over that of as many samples spaced evenly, if all waves up
        to pi / mean_pitch are recovered [-]: 1 for even samples, large for bunches.
    """

    step: float
    distance: float
    position: FloatArray
    visits: float
    pitch: float
    mean_pitch: float
    noise_gain: float


def sliding_samples(array: SensorArray, speed: float, rate: float, *, sensor: int = 0) -> SlidingSamples:
    """Where on a thing that slides past the sensors sample it.

    In frame j a sensor at y samples the thing at y + j speed / rate, a step further on each time. One sensor samples
    one position a step; n sensors sample n, where their positions differ once whole steps are taken off. Sensors a
    whole number of steps apart follow in each other's tracks, and add nothing but a mean of their noise. Sensors count
    that are like the one named: of its depth, width and transducer. This takes for granted that the thing slides over
    the whole row and one step more, without sticking and without turning, at a force that stays; and that the speed is
    known: one wrong by a share e puts a sample e times the way slid off its position.

    Parameters
    ----------
    array : SensorArray
        The row.
    speed : float
        Speed of the object along the skin [m/s], not 0.
    rate : float
        Frames per second [Hz], > 0.
    sensor : int, optional
        The sensor whose like are counted.

    Raises
    ------
    InvalidValueError
        A speed of 0, a rate that is not > 0, a sensor that is not there.
    GeometryError
        A sensor that is dead, and so are its like.

    Examples
    --------
    Four sensors 1 mm apart and a step of 0.8 mm: every 0.2 mm is sampled.

    >>> import subskin as ss
    >>> row = ss.SensorArray.line(count=4, pitch=1e-3, depth=2e-3)
    >>> found = ss.design.sliding_samples(row, speed=0.08, rate=100.0)
    >>> round(found.pitch * 1e3, 6), round(found.noise_gain, 6)
    (0.2, 1.0)
    """
    pace = abs(_check.scalar("speed", speed, unit="m/s"))
    frames = _check.scalar("rate", rate, unit="Hz", above=0.0)
    if not pace > 0:
        raise InvalidValueError("speed = 0 m/s", "what does not slide adds no samples", "speed=0.05")
    _check.noun("array", array, SensorArray, "finger.array")
    sensor = index_of(array, sensor)
    kinds = [
        (kind.linear_part, float(depth), float(width))
        for kind, depth, width in zip(array.transducers, np.asarray(array.depth), np.asarray(array.width), strict=True)
    ]
    alike = np.array([kind == kinds[sensor] for kind in kinds]) & array.live
    if not alike.any():
        raise GeometryError(f"sensor {sensor}", "it is dead, of gain 0, and so are its like", "name another")
    y = np.asarray(array.y)[alike]
    step = pace / frames
    rest = np.sort(np.mod(y - y.max(), step) / step)
    rest = np.sort(np.where(rest > 1 - _SAME, 0.0, rest))
    rest = rest[np.concatenate([[True], np.diff(rest) > _SAME])]
    gaps = np.diff(np.concatenate([rest, [rest[0] + 1]]))
    # waves that the step alone confuses, told apart by the positions in it; evenly spaced, these are a Fourier matrix
    waves = np.exp(2j * np.pi * np.outer(rest, np.arange(rest.size))) / np.sqrt(rest.size)
    gain = float(np.sqrt((np.abs(np.linalg.inv(waves)) ** 2).sum() / rest.size))
    position = _check.read_only(y.max() + step * rest)
    widest, mean = step * float(gaps.max()), step / rest.size
    return SlidingSamples(step, float(np.ptp(y)) + step, position, y.size / rest.size, widest, mean, noise_gain=gain)
