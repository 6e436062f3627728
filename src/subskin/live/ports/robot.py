"""A simulated finger that is not as drawn, and a stage that touches it where it is told: `--port robot`."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...contact import LineLoad, PointLoad
from ...errors import InvalidValueError
from .demo import board, channels_of, usual_force
from .simulated import Simulated

if TYPE_CHECKING:
    from ...finger import Finger
    from ...io import FingerFile

__all__ = ["Robot"]

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

    def __init__(
        self, file: FingerFile | None, rate: float = 500.0, seed: int = 0, force: float | None = None
    ) -> None:
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
