"""A device that is not there, and behaves like a bad one: for work without hardware, and for tests."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Annotated, TypeAlias

import numpy as np

from ... import _check
from ..._check import FloatArray
from ..._declared import Noun, Real
from ..drivers.base import Driver
from .base import Port, PortEnded, PortLost

__all__ = ["Faults", "Simulated", "Spoilt"]

Signal: TypeAlias = Callable[[FloatArray], FloatArray]
Spoilt: TypeAlias = tuple[int, int, str]

_BANNER = b"\r\nBoard ready.\r\n"
_STEP = 0.1
"""By how much simulated time moves on where a port that is away is asked for, and nobody waits [s]."""


_Rate: TypeAlias = Annotated[float, Real(at_least=0.0)]


@dataclass(frozen=True)
class Faults(Noun):
    """Faults of a simulated device: of each kind the mean number a second [1/s], 0 for none.

    Parameters
    ----------
    dropped : float
        Frames that are not sent, some in a row [1/s].
    cut : float
        Frames that lose bytes [1/s].
    changed : float
        Frames with one byte changed [1/s].
    garbage : float
        Bytes that belong to no frame, between frames [1/s].
    stuck : float
        Sensors that hold their value for a while [1/s].
    restarted : float
        The device starts again: it is silent, says something, counts and times from 0 [1/s].
    unplugged : float
        The port is lost for a while; the device starts again then [1/s].

    Raises
    ------
    InvalidValueError
        A rate below 0.

    Examples
    --------
    >>> Faults.all(0.5).garbage
    0.5
    """

    dropped: _Rate = 0.0
    cut: _Rate = 0.0
    changed: _Rate = 0.0
    garbage: _Rate = 0.0
    stuck: _Rate = 0.0
    restarted: _Rate = 0.0
    unplugged: _Rate = 0.0

    @classmethod
    def all(cls, rate: float) -> Faults:
        """Every kind at the same rate.

        Parameters
        ----------
        rate : float
            Mean number a second of each kind [1/s].
        """
        return cls(*(rate for _ in fields(cls)))


class Simulated(Port):
    r"""Bytes as a device would send them, with faults, the same for the same seed however they are read.

    Parameters
    ----------
    signal : callable
        Values of the channels, shape (n, c), at times (n,) [s] from the start; in the units of the device.
    driver : Driver
        Whose format the device speaks.
    rate : float
        Frames a second [1/s].
    faults : Faults, optional
        What goes wrong; by default nothing.
    noise : array_like, shape () or (c,), optional
        Standard deviation of each value, in its own units.
    drift : array_like, shape () or (c,), optional
        Standard deviation of how far each value has walked after a second, in its own units.
    skew : float
        How much faster than the host's the device's clock runs, relative [-].
    seed : int
        Seed of the noise, the drift and the faults.
    duration : float
        When the bytes end [s]; they go on for ever by default.
    batch : float or None
        Simulated time: each read gives what came in so much time [s], at once. None: real time, as a device.

    Raises
    ------
    InvalidValueError
        A rate, duration or batch that is not above 0.

    Examples
    --------
    >>> import numpy as np
    >>> from subskin.live.drivers import named
    >>> flat = lambda t: np.zeros((len(t), 2))
    >>> port = Simulated(flat, named("lines", sensors=2), rate=100, batch=0.05, noise=1.0, duration=1.0)
    >>> port.read(0.0).count(b"\n"), port.clock()
    (5, 0.05)
    """

    def __init__(
        self,
        signal: Signal,
        driver: Driver,
        *,
        rate: float = 1000.0,
        faults: Faults | None = None,
        noise: np.typing.ArrayLike = 0.0,
        drift: np.typing.ArrayLike = 0.0,
        skew: float = 0.0,
        seed: int = 0,
        duration: float = math.inf,
        batch: float | None = None,
    ) -> None:
        for name, value in (("rate", rate), ("duration", duration), ("batch", 1.0 if batch is None else batch)):
            _check.scalar(name, value, above=0.0, finite=name != "duration", fix=f"{name}=1.0")
        self.name, self.driver = "simulated device", driver
        self._signal, self._device, self._rate, self._faults = signal, driver, rate, faults or Faults()
        self._noise, self._drift = (np.asarray(v, dtype=np.float64) for v in (noise, drift))
        self._skew, self._duration, self._batch = skew, duration, batch
        seeds = np.random.SeedSequence(seed).spawn(3)
        self._noises, self._drifts, self._events = (np.random.default_rng(s) for s in seeds)
        kinds = {one.name: getattr(self._faults, one.name) for one in fields(Faults)}
        self._rates = {kind: per for kind, per in kinds.items() if per > 0}
        self._next = {kind: self._events.exponential(1 / per) for kind, per in self._rates.items()}
        self.spoilt: list[Spoilt] = []
        """Frames (first, last, why) that were not sent whole, or come behind garbage; numbered from the start."""
        self._made, self._boot, self._silent, self._away = 0, 0, 0, 0.0
        self._walked = np.zeros(len(driver.channels))
        self._held: dict[int, tuple[int, float]] = {}
        self._began, self._now, self._lost, self._pending = math.nan, 0.0, False, b""

    @property
    def real_time(self) -> bool:  # noqa: D102
        return self._batch is None

    def clock(self) -> float:  # noqa: D102
        return time.monotonic() if self._batch is None else self._now

    def read(self, timeout: float) -> bytes:  # noqa: D102
        if self._lost:
            raise PortLost(self.name, "the device is gone", "plug it in again")
        if self._made >= self._duration * self._rate:
            raise PortEnded(self.name, f"it was to send for {self._duration:g} s")
        if self._began != self._began:  # real time begins when somebody listens
            self._began = time.monotonic()
        if self._batch is not None:
            self._now += self._batch
        else:
            due = (self._made + 1) / self._rate
            time.sleep(min(max(due - (time.monotonic() - self._began), 0.0), max(timeout, 0.0)))
            self._now = time.monotonic() - self._began
        last = int(min(self._now * self._rate + 1e-6, self._duration * self._rate))
        return self._until(last)

    def write(self, data: bytes) -> None:  # noqa: D102
        pass  # it takes no commands

    def close(self) -> None:  # noqa: D102
        self._lost = True

    def reopen(self) -> None:  # noqa: D102
        self._now = self._now + _STEP if self._batch is not None else time.monotonic() - self._began
        if self._now < self._away:
            raise PortLost(self.name, "it is still away", "plug it in again")
        self._lost = False
        back = int(self._now * self._rate) + 1
        if back > self._made:
            self._spoil(self._made, back - 1, "unplugged")
            self._values(back - self._made)
        self._boot = self._made

    def _until(self, last: int) -> bytes:
        """Bytes of the frames before `last` that were not made yet, up to where the device is unplugged."""
        parts = []
        while self._made < last and not self._lost:
            kind = min(self._next, key=lambda one: self._next[one], default="")
            at = math.ceil(self._next[kind] * self._rate) if kind else last
            if at >= last:
                parts.append(self._sent(last - self._made))
                break
            parts.append(self._sent(at - self._made))
            parts.append(self._fault(kind))
            self._next[kind] = max(self._next[kind], self._made / self._rate) + self._events.exponential(
                1 / self._rates[kind]
            )
        return b"".join(parts)

    def _values(self, count: int) -> FloatArray:
        """The values of the next `count` frames."""
        number = self._made + np.arange(count)
        values = np.array(self._signal(number / self._rate), dtype=np.float64)
        shape = values.shape
        if self._noise.any():
            values += self._noise * self._noises.standard_normal(shape)
        if self._drift.any():
            steps = self._drift / math.sqrt(self._rate) * self._drifts.standard_normal(shape)
            walk = np.cumsum(np.concatenate([self._walked[None], steps]), axis=0)[1:]
            values += walk
            self._walked = walk[-1] if count else self._walked
        for channel, (until, value) in list(self._held.items()):
            values[number < until, channel] = value
            if self._made + count >= until:
                del self._held[channel]
        self._made += count
        return values

    def _sent(self, count: int) -> bytes:
        """Bytes of the next `count` frames, but of those in which the device is silent."""
        if count <= 0:
            return b""
        number = self._made + np.arange(count)
        values = self._values(count)
        spoken = number >= self._silent
        since = number[spoken] - self._boot
        return self._device.encode(values[spoken], since / self._rate * (1 + self._skew), since)

    def _spoil(self, first: int, last: int, why: str) -> None:
        self.spoilt.append((first, last, why))

    def _fault(self, kind: str) -> bytes:
        """What comes of a fault at the frame that is next."""
        rng, here = self._events, self._made
        if kind == "stuck":
            channel = int(rng.integers(len(self._device.channels)))
            value = float(self._signal(np.array([here / self._rate]))[0, channel])
            self._held[channel] = (here + int(rng.uniform(0.2, 2.0) * self._rate), value)
            return b""
        if kind == "dropped":
            count = int(rng.integers(1, 6))
            self._spoil(here, here + count - 1, kind)
            self._sent(count)
            return b""
        if kind == "garbage":
            self._spoil(here, here, kind)
            return rng.bytes(int(rng.integers(1, 200)))
        if kind == "restarted":
            self._silent = here + max(int(0.3 * self._rate), 1)
            self._boot = self._silent
            self._spoil(here, self._silent - 1, kind)
            return _BANNER
        frame = self._sent(1)
        self._spoil(here, here, kind)
        at = int(rng.integers(max(len(frame), 1)))
        if kind == "cut" and frame:
            return frame[:at] + frame[at + int(rng.integers(1, len(frame) + 1)) :]
        if kind == "changed" and frame:
            return frame[:at] + bytes([frame[at] ^ int(rng.integers(1, 256))]) + frame[at + 1 :]
        if kind != "unplugged":  # it was silent
            return b""
        self._away, self._lost = self._made / self._rate + rng.uniform(0.2, 1.0), True
        return frame[:at]
