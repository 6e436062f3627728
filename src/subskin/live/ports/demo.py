"""The board of a finger file, simulated: under a touch that moves (`demo`), or a stage that is told where (`robot`)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...contact import LineLoad, PointLoad
from ...errors import InvalidValueError
from ..drivers.fixed import Fixed
from ..drivers.framing import Field
from .simulated import Faults, Simulated

if TYPE_CHECKING:
    from ...finger import Finger
    from ...io import FingerFile

__all__ = ["Demo", "Robot", "board", "channels_of", "touch", "usual_force"]

_KNOTS = 240
_ROUND = 17.0
"""Time in which the touch comes round [s]; a press takes `_PRESS` of it."""
_PRESS, _PRESSED = 3.0, 0.6
_LOUD = 300.0
"""The strongest reading, in its noise."""


def touch(finger: Finger, force: float | None = None) -> tuple[FloatArray, FloatArray]:
    """Positions of the touch on its way round, and the readings of unit components there.

    Parameters
    ----------
    finger : Finger
        Whose sensors are touched.
    force : float, optional
        Largest normal force [N/m, on an area N]; by default what the sensors read well.

    Returns
    -------
    tuple of ndarray
        Positions [m], shape (k,) or (k, 2), and readings [reading] under the largest force, of each component,
        shape (k, d + 1, n).
    """
    array, way = finger.array, 2 * np.pi * np.arange(_KNOTS) / _KNOTS
    y, z = np.asarray(array.y), np.asarray(array.z)
    along = y.mean() + 0.5 * np.ptp(y) * np.sin(way)
    pushes: list[LineLoad | PointLoad] = []
    if array.on_area:
        at = np.stack([along, z.mean() + 0.5 * np.ptp(z) * np.sin(2 * way)], axis=-1)
        pushes = [PointLoad(1.0, position=at), *(PointLoad(2**0.5, np.pi / 4, a, position=at) for a in (0, np.pi / 2))]
    else:
        at = along
        pushes = [LineLoad(1.0, position=at), LineLoad(2**0.5, np.pi / 4, position=at)]
    free = np.asarray(array.offset)
    pressed, *leant = (np.asarray(finger.read(push)) - free for push in pushes)
    unit = np.stack([pressed, *(one - pressed for one in leant)], axis=-2)
    return at, (_read_well(finger, unit) if force is None else force) * unit


def usual_force(finger: Finger) -> float:
    """The normal force that a finger's sensors read well [N/m, on an area N]."""
    return _read_well(finger, touch(finger, 1.0)[1])


def _read_well(finger: Finger, unit: FloatArray) -> float:
    noise = np.broadcast_to(np.asarray(finger.array.noise), unit.shape[-1:])
    loudest = float(np.abs(unit[:, 0] / np.where(noise > 0, noise, np.inf)).max())
    return _LOUD / loudest if loudest > 0 else 1.0


def channels_of(file: FingerFile) -> tuple[str, ...]:
    """What a simulated board calls the sensors of a file: as [live] does, or by their names."""
    return file.names if file.live is None or not file.live.channels else file.live.channels


def board(names: tuple[str, ...]) -> Fixed:
    """The format of the demo: a number, a time in us, a double for each sensor, a check."""
    head = [Field("frame", "u32", "counter"), Field("time", "u32", "time", 1e-6)]
    values = [Field(name, "f64") for name in names]
    return Fixed([*head, *values], start=b"\xa5\x5a", check="crc16_ccitt")


class Demo(Simulated, name="demo"):
    """`demo?rate=1000&faults=0.2&seed=0`: a finger's own sensors in the units of its file, in real time.

    Parameters
    ----------
    file : FingerFile or None
        The finger.
    rate : float
        Frames a second [1/s].
    faults : float
        Mean number of faults of each kind a second [1/s].
    seed : int
        Seed of noise, drift and faults.
    batch : float, optional
        Simulated time [s], as of `Simulated`; real time if left out.
    duration : float
        When it ends [s].

    Raises
    ------
    InvalidValueError
        No finger; a number out of range.
    """

    def __init__(
        self,
        file: FingerFile | None,
        rate: float = 500.0,
        faults: float = 0.0,
        seed: int = 0,
        batch: float | None = None,
        duration: float = np.inf,
    ) -> None:
        if file is None:
            rule, fix = "it needs a finger to simulate", "subskin live finger.toml --port demo"
            raise InvalidValueError("port demo", rule, fix)
        array = file.finger.array
        scale = np.broadcast_to(1.0 if file.recording is None else file.recording.scale, (len(array),))
        self._scale = scale if file.live is None else file.live.scale
        self._free = np.broadcast_to(np.asarray(array.offset), (len(array),))
        self._readings = touch(file.finger)[1]
        self._most = min(float(file.options.get("friction", 1.0)), 1.0)  # it leans as far as such touches do
        noise = np.broadcast_to(np.asarray(array.noise), (len(array),))
        noise = noise / self._scale
        super().__init__(
            self._pressed, board(channels_of(file)), rate=rate, faults=Faults.all(faults), noise=noise,
            drift=0.3 * noise, skew=37e-6, seed=seed, duration=duration, batch=batch,
        )  # fmt: skip
        self.name = "demo"

    def _pressed(self, time: FloatArray) -> FloatArray:
        """Readings at times [s]: the first press begins after 1.2 s, and each third leans until it would slip."""
        knot, share = np.divmod(time / _ROUND % 1 * _KNOTS, 1)
        low = knot.astype(np.int64) % _KNOTS
        between = share[:, None, None]
        unit = (1 - between) * self._readings[low] + between * self._readings[(low + 1) % _KNOTS]
        press, phase = np.divmod(time / _PRESS, 1)
        within = np.clip((phase - (1 - _PRESSED)) / _PRESSED, 0, 1)
        normal = np.sin(np.pi * within) ** 2
        lean = self._most * np.where(press % 3 == 2, 0.9 * within, 0.25 * np.sin(2 * np.pi * within))
        weights = np.zeros((len(time), unit.shape[1]))
        weights[:, 0] = normal
        weights[:, 1] = normal * lean
        return np.asarray((self._free + (weights[:, :, None] * unit).sum(axis=1)) / self._scale)


_GAIN, _DEPTH, _NOISE, _OFFSET, _ORIGIN = 0.15, 0.1, 1.5, 50.0, 0.1
"""By how much the real finger is not as drawn: gains and depths by such a share, noise by a factor, offsets by so many
noises, its origin by such a share of the depth."""
_WAIT, _RAMP = 0.15, 0.05
"""Time before it moves, and until it presses with its whole force [s]."""


class Robot(Simulated, name="robot"):
    r"""`robot?rate=500&seed=0`: what a board sends while a stage touches its finger, in real time.

    Parameters
    ----------
    file : FingerFile or None
        The finger as drawn.
    rate : float
        Frames a second [1/s].
    seed : int
        Seed of the noise, and of what the real finger is.
    force : float, optional
        Force of each touch [N/m, on an area N]; a force that the sensors read well if left out.

    Raises
    ------
    InvalidValueError
        No finger; a number out of range.

    Examples
    --------
    >>> import subskin as ss
    >>> text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 2e-3\ndepth = 2e-3\nnoise = 1e-4"
    >>> robot = Robot(ss.io.parse_finger(text), seed=1)
    >>> robot.press(1e-3)
    >>> robot.lift()
    """

    def __init__(self, file: FingerFile | None, rate: float = 500.0, seed: int = 0, force: float | None = None) -> None:
        if file is None:
            rule, fix = "it needs a finger to touch", "subskin bench finger.toml --port robot"
            raise InvalidValueError("port robot", rule, fix)
        seed = _check.whole("robot?seed", seed, at_least=0, at_most=2**53, fix="robot?seed=1")
        rate = _check.scalar("robot?rate", rate, above=0.0, fix="robot?rate=500")
        self.origin, self.finger = _real(file, seed)
        given = 0.0 if force is None else _check.scalar("robot?force", force, at_least=0.0, fix="robot?force=20")
        self.force = given or usual_force(file.finger)
        self._moves: list[tuple[float, Any, float]] = []
        noise = np.broadcast_to(np.asarray(self.finger.array.noise), (len(self.finger.array),))
        super().__init__(
            self._felt, board(channels_of(file)), rate=rate, noise=noise, drift=0.1 * noise, skew=20e-6, seed=seed
        )  # fmt: skip
        self.name = "robot"

    def press(self, position: Any, force: float | None = None) -> None:
        """Touch the skin, and hold the touch.

        Parameters
        ----------
        position : float or array_like of shape (2,)
            Where, on the axis of the stage [m].
        force : float, optional
            How hard [N/m, on an area N]; that of the port if left out.
        """
        self._moves.append((self._now + _WAIT, np.asarray(position, dtype=np.float64), force or self.force))

    def lift(self) -> None:
        """Leave the skin."""
        self._moves.append((self._now + _WAIT, None, 0.0))

    def _felt(self, time: FloatArray) -> FloatArray:
        """Readings at times [s]."""
        out = np.tile(np.asarray(self.finger.array.offset), (len(time), 1))
        moves = self._moves[-2:]
        for k, (begin, position, force) in enumerate(moves):
            if position is None:
                continue
            end = moves[k + 1][0] if k + 1 < len(moves) else np.inf
            share = np.clip((time - begin) / _RAMP, 0, 1) * np.clip((end - time) / _RAMP + 1, 0, 1)
            at = position - self.origin
            push = PointLoad(force, position=at) if at.shape else LineLoad(force, position=at)
            out += share[:, None] * (self.finger.measure(push) * np.asarray(self.finger.array.gain))
        return out


def _real(file: FingerFile, seed: int) -> tuple[Any, Finger]:
    """Where the real finger lies on the axis of the stage, and what it is."""
    array, rng = file.finger.array, np.random.default_rng([seed, 1])
    n, depth = len(array), np.asarray(array.depth)
    thickness = file.finger.skin.thickness
    deeper = min(1 + _DEPTH * rng.uniform(-1, 1), 0.95 * thickness / float(depth.max()))
    noise = np.asarray(array.noise)
    changes: dict[str, Any] = {
        "gain": np.asarray(array.gain) * (1 + _GAIN * rng.uniform(-1, 1, n)),
        "depth": depth * deeper,
        "noise": _NOISE * noise,
        "offset": np.asarray(array.offset) + _OFFSET * noise * rng.standard_normal(n),
    }
    origin = np.asarray(file.origin) + _ORIGIN * depth.mean() * rng.uniform(-1, 1, 2 if array.on_area else ())
    return origin, replace(file.finger, array=replace(array, **changes))
