"""What real sensors do to their readings, as pure functions of arrays of one library, with a key for what is random."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt

from ._check import FloatArray
from ._declared import Noun, Real
from .errors import InvalidValueError

__all__ = ["SensorFaults", "Spoiled"]

_FAR = 1.2
"""Of the distance to the nearest sensor, up to which others are its neighbours."""


@dataclass(frozen=True, eq=False)
class SensorFaults(Noun):
    """What may be wrong with sensors; each is off at 0.

    Parameters
    ----------
    gain : float, optional
        Standard deviation of each sensor's gain, as a share of it [-].
    offset : float, optional
        Standard deviation of each sensor's offset [reading].
    drift : float, optional
        Standard deviation of the rate at which each sensor's offset drifts [reading/s]; it needs the frames' times.
    dead : float, optional
        Probability that a sensor is dead, and reads its offset [-].
    crosstalk : float, optional
        Share of a sensor's reading that it takes from the mean of its neighbours [-].
    share, time : array_like, shape (k,), optional
        What rubber forgets of a touch that is held, as of `Relaxation`: shares [-] and time constants [s] of a Prony
        series. Frames are on the last axis but one of the readings, and it needs their times.
    noise : float, optional
        Standard deviation of each reading [reading].
    resolution : float, optional
        Step to which readings are rounded [reading]. Its derivative is 0 everywhere.

    Raises
    ------
    InvalidValueError
        A value out of range; other shares than time constants.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> row = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3)
    >>> read = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row).reader()
    >>> loads = {"components": np.array([40.0, 0.0]), "position": np.array(0.0)}
    >>> readings = read(loads, faults=SensorFaults(gain=0.02, noise=1e-4), key=np.random.default_rng(0))
    >>> bool(0 < np.abs(readings - read(loads)).max() < 2e-3)
    True
    """

    gain: Annotated[float, Real(at_least=0.0)] = 0.0
    offset: Annotated[float, Real(at_least=0.0)] = 0.0
    drift: Annotated[float, Real(at_least=0.0)] = 0.0
    dead: Annotated[float, Real(at_least=0.0, at_most=1.0)] = 0.0
    crosstalk: Annotated[float, Real(at_least=0.0, at_most=1.0)] = 0.0
    share: Annotated[npt.ArrayLike, Real(at_least=0.0, at_most=1.0)] = ()
    time: Annotated[npt.ArrayLike, Real("s", above=0.0)] = ()
    noise: Annotated[float, Real(at_least=0.0)] = 0.0
    resolution: Annotated[float, Real(at_least=0.0)] = 0.0

    EXAMPLE: ClassVar = "SensorFaults(gain=0.02, noise=1e-4)"

    def __post_init__(self) -> None:
        super().__post_init__()
        shapes = np.shape(self.share), np.shape(self.time)
        if shapes[0] != shapes[1] or len(shapes[0]) > 1:
            seen = f"share of shape {shapes[0]}, time of shape {shapes[1]}"
            raise InvalidValueError(seen, "one of each a term is needed", "share=[0.1], time=[1.5]")

    def begin(self, points: FloatArray, rng: np.random.Generator) -> Spoiled:
        """Sensors at `points` (n, d) [m] with faults drawn by `rng`, for frames that come one by one.

        Examples
        --------
        >>> sensors = SensorFaults(dead=1.0).begin(np.zeros((2, 2)), np.random.default_rng(0))
        >>> sensors.step(np.ones(2), np.zeros(2), 0.0).tolist()
        [0.0, 0.0]
        """
        return Spoiled(self, points, rng)

    def spoil(self, xp: Any, readings: Any, offset: Any, points: FloatArray, key: Any, times: Any) -> Any:
        """Readings (..., n) as sensors at `points` (n, d) with such faults give them.

        The faults of a call are the same in all its frames, but for the noise. They come in this order: crosstalk,
        relaxation, gain, death, offset and drift, noise, resolution.

        Parameters
        ----------
        xp : module
            The array library.
        readings, offset : array, shapes (..., n) and (n,)
            Without self.
        points : ndarray, shape (n, d)
            Where the sensors are [m].
        key : Generator of NumPy or PyTorch, or key of JAX
            For what is random.
        times : array, shape (frames,), or None
            Of the frames [s].

        Raises
        ------
        InvalidValueError
            Random faults without a key; drift or relaxation without times.

        Examples
        --------
        >>> points = np.array([[0.0], [1.0], [2.0]])
        >>> faults, alone = SensorFaults(crosstalk=0.1), np.array([0.0, 1.0, 0.0])
        >>> faults.spoil(np, alone, np.zeros(3), points, None, None).round(3).tolist()
        [0.1, 0.9, 0.1]
        """
        n, out = readings.shape[-1], readings - offset
        timed = self.drift > 0 or np.size(self.share) > 0
        if timed and times is None:
            raise InvalidValueError("faults that take time, and no times", "they need the frames' times", "times=t")
        if any((self.gain, self.offset, self.drift, self.dead, self.noise)) and key is None:
            rule = "they need a key"
            raise InvalidValueError(
                "random faults without a key", rule, "key=numpy.random.default_rng(0), or of the library"
            )
        if self.crosstalk:
            out = out @ xp.asarray(_mixed(points, self.crosstalk).T)
        if np.size(self.share):
            out = _relaxed(xp, np.asarray(self.share), np.asarray(self.time), out, times)
        own = _normals(xp, key, [(n,)] * 4 + [tuple(readings.shape)]) if key is not None else [0.0] * 5
        return self._worn(xp, out, offset, own, times[:, None] if self.drift else 0.0)

    def _worn(self, xp: Any, elastic: Any, offset: Any, own: Any, since: Any) -> Any:
        """What gain, death, offset, drift, noise and resolution make of readings without their offset.

        own: standard normal numbers, of gain, life, offset and drift one for each sensor, and of the noise; since: for
        how long sensors drift [s].
        """
        out = elastic * (1.0 + self.gain * own[0])
        if self.dead:
            from scipy.special import ndtri

            out = xp.where(own[1] < float(ndtri(self.dead)), 0.0 * out, out)
        out = out + offset + self.offset * own[2] + self.noise * own[4]
        if self.drift:
            out = out + self.drift * own[3] * since
        return xp.round(out / self.resolution) * self.resolution if self.resolution else out


class Spoiled:
    """Sensors with faults of their own, which spoil one frame after the other: `SensorFaults.begin` makes it.

    Parameters
    ----------
    faults : SensorFaults
        What may be wrong.
    points : ndarray, shape (n, d)
        Where the sensors are [m].
    rng : Generator
        For what is random.

    Examples
    --------
    >>> rubber = SensorFaults(share=[0.2], time=[0.5])
    >>> held = rubber.begin(np.zeros((1, 2)), np.random.default_rng(0))
    >>> [round(float(held.step(np.ones(1), np.zeros(1), t)[0]), 3) for t in (0.0, 0.5, 5.0)]
    [1.0, 0.874, 0.8]
    """

    def __init__(self, faults: SensorFaults, points: FloatArray, rng: np.random.Generator) -> None:
        self._faults, self._rng, self._own = faults, rng, rng.standard_normal((4, len(points)))
        self._mixed = _mixed(points, faults.crosstalk) if faults.crosstalk else None
        self._share, self._time = (np.atleast_1d(each)[:, None] for each in (faults.share, faults.time))
        self.restart()

    def restart(self) -> None:
        """The next frame is the first: nothing has drifted, and the rubber remembers nothing."""
        self._memory, self._before = 0.0 * self._share, np.zeros(1)
        self._then, self._began = np.nan, np.nan

    def step(self, readings: FloatArray, offset: FloatArray, time: float) -> FloatArray:
        """One frame as these sensors give it, shape (n,); as of `SensorFaults.spoil`.

        Parameters
        ----------
        readings, offset : ndarray, shapes (n,)
            Without faults [reading].
        time : float
            Of the frame [s]; it may not fall.
        """
        out = readings - offset
        if self._mixed is not None:
            out = self._mixed @ out
        if np.isnan(self._began):
            self._began = self._then = time
        if len(self._share):
            ratio = (time - self._then) / self._time
            gain = -np.expm1(-ratio) / np.where(ratio > 0, ratio, 1.0) + (ratio <= 0)
            self._memory = np.exp(-ratio) * self._memory + gain * (out - self._before)
            self._before, self._then = out, time
            out = (1.0 - self._share.sum()) * out + (self._share * self._memory).sum(axis=0)
        noise = self._rng.standard_normal(out.shape) if self._faults.noise else 0.0
        return np.asarray(self._faults._worn(np, out, offset, (*self._own, noise), time - self._began))


def _mixed(points: FloatArray, share: float) -> FloatArray:
    """What each sensor takes of each, (n, n)."""
    away = np.linalg.norm(points[:, None] - points, axis=-1)
    away[away == 0] = np.inf
    near = away < _FAR * away.min(axis=1, keepdims=True)
    return np.asarray((1 - share) * np.eye(len(points)) + share * near / np.maximum(near.sum(axis=1, keepdims=True), 1))


def _relaxed(xp: Any, share: FloatArray, constants: FloatArray, elastic: Any, times: Any) -> Any:
    """As `Relaxation.apply`: each term remembers h, h' = u' - h / tau, and readings are u - sum of share (u - h)."""
    steps = times[1:] - times[:-1]
    change = xp.concat([elastic[..., :1, :], elastic[..., 1:, :] - elastic[..., :-1, :]], axis=-2)
    past = times[:, None] - times[None, :]
    out = (1.0 - share.sum()) * elastic
    for part, tau in zip(share.tolist(), constants.tolist(), strict=True):
        ratio = steps / tau
        gain = xp.where(ratio > 0, -xp.expm1(-ratio) / xp.where(ratio > 0, ratio, 1.0), 1.0)
        gain = xp.concat([xp.ones_like(times[:1]), gain], axis=-1)
        memory = xp.tril(xp.exp(-xp.where(past > 0, past, 0.0 * past) / tau)) * gain
        out = out + part * (memory @ change)
    return out


def _normals(xp: Any, key: Any, shapes: list[tuple[int, ...]]) -> list[Any]:
    """Standard normal numbers of each of the shapes."""
    if isinstance(key, np.random.Generator):
        return [xp.asarray(key.standard_normal(shape)) for shape in shapes]
    if "torch" in xp.__name__:
        return [xp.randn(shape, generator=key, dtype=xp.get_default_dtype()) for shape in shapes]
    from jax import random

    return [random.normal(each, shape) for each, shape in zip(random.split(key, len(shapes)), shapes, strict=True)]
