"""An environment of Gymnasium: lift a thing of unknown weight and friction by what two skins tell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import gymnasium
import mujoco
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from .. import _check
from .._check import FloatArray
from ..estimate import ResultantReader
from ..faults import SensorFaults
from ..finger import Finger
from ..mujoco import GeomSkin, SampledSkin
from ..prepared import prepared
from .lifting import pad_finger
from .scene import PADS, Thing, gripper_xml, things

__all__ = ["ID", "GraspEnv"]

ID = "subskin/Grasp-v0"

_PERIOD = 0.04
"""Of a step [s]."""
_STRONGEST, _SPEED, _HEIGHT = 15.0, 0.1, 0.06
"""Largest force of a finger [N], largest speed of the arm [m/s], height at which a thing is lifted [m]."""
_LONGEST = 5.0
"""Of an episode [s]."""
_LOAD, _ARM, _MOST = 5.0, 5e-3, 10.0
"""By what forces are divided in an observation [N], by what torsions beforehand [m]; and its bound."""
_PICTURE = 480, 640
"""Height and width of a picture."""
_UP, _DOWN = 0.01, 2e-3
"""Heights of a thing, or of the gripper, that is up, and of a thing that is down again [m]."""
_RISES, _HOLDS, _SLIDES, _SQUEEZES, _DROPS = 1.0, 1.0, 2.0, 0.01, 1.0
"""What the reward gives for all of the height, and for a second there, and takes for a metre of sliding, a newton for a
second, a drop."""


class GraspEnv(gymnasium.Env[npt.NDArray[np.float32], npt.NDArray[np.float32]]):
    """A gripper lifts a thing: another one in each episode, drawn by the seed.

    An action is the force of each finger, from -1 (none) to 1 (15 N), and the speed of the arm, from -1 to 1 (0.1 m/s
    upwards). An observation is what both skins tell, then the force asked for and the height of the gripper. A step is
    40 ms. The reward is what the thing rose, in shares of 60 mm, and each second its height in these shares,
    less 2 for each metre that it slid in the hand, 0.01 for each newton second of squeezing, and 1 for a drop, which
    ends the episode; else it ends after 5 s.

    Parameters
    ----------
    observation : {"estimates", "frames", "forces"}, optional
        Force, drag along y and z, and torsion of each pad, found by `resultant`; frames of readings, over 100 times
        their noise; or the true forces, without any skin.
    finger : Finger, optional
        Both pads; `pad_finger()` if left out.
    faults : SensorFaults, optional
        What the sensors do wrong.
    draw : callable, optional
        From a seed to a `Thing`; of `things` if left out.
    render_mode : {"rgb_array"}, optional
        Pictures by `render()`.

    Raises
    ------
    InvalidValueError
        Another observation.

    Examples
    --------
    >>> import gymnasium
    >>> import subskin.grasp.environment
    >>> env = gymnasium.make("subskin/Grasp-v0", observation="forces")
    >>> observation, _ = env.reset(seed=3)
    >>> observation.shape, env.action_space.shape
    ((10,), (2,))
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 25}  # noqa: RUF012 - as Gymnasium declares it

    def __init__(
        self,
        observation: Literal["estimates", "frames", "forces"] = "estimates",
        finger: Finger | None = None,
        faults: SensorFaults | None = None,
        draw: Callable[[int], Thing] | None = None,
        render_mode: str | None = None,
    ) -> None:
        _check.choice("observation", observation, ("estimates", "frames", "forces"))
        self._what, self.render_mode = observation, render_mode
        self._finger = finger = pad_finger() if finger is None else finger
        self._faults, self._draw = faults, _drawn if draw is None else draw
        known = observation == "estimates"
        self._reader = prepared(finger).get(("resultant",), lambda: ResultantReader(finger)) if known else None
        array = self._finger.array
        self._unit = 100.0 * np.asarray(array.noise)
        size = 2 * (len(array) if observation == "frames" else 4) + 2
        self.observation_space = spaces.Box(-_MOST, _MOST, (size,), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self._renderer: Any = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.float32], dict[str, Any]]:
        """Begin an episode with another thing; `options={"thing": Thing(...)}` with this one.

        Parameters
        ----------
        seed : int, optional
            Of all that is random from now on.
        options : dict, optional
            As above.
        """
        super().reset(seed=seed)
        number = int(self.np_random.integers(2**31))
        self.thing = (options or {}).get("thing") or self._draw(number)
        self._model = mujoco.MjModel.from_xml_string(gripper_xml(self.thing))
        self._data = mujoco.MjData(self._model)
        skins = [GeomSkin(self._model, pad, self._finger, face) for pad, face in PADS.items()]
        self._skins = [SampledSkin(skin, None, self._faults, seed=number + i) for i, skin in enumerate(skins)]
        self._body, self._gripper = self._model.body("thing").id, self._model.body("gripper").id
        self._target = self._force = self._best = 0.0
        self._close: float | None = None
        self._renderer = None
        mujoco.mj_forward(self._model, self._data)
        return self._seen(), {}

    def step(
        self, action: npt.NDArray[np.float32]
    ) -> tuple[npt.NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """40 ms with a force and a speed.

        Parameters
        ----------
        action : ndarray, shape (2,)
            As above.
        """
        force, speed = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        self._force, data = 0.5 * (1.0 + force) * _STRONGEST, self._data
        steps = round(_PERIOD / self._model.opt.timestep)
        for _ in range(steps):
            self._target = float(
                np.clip(self._target + speed * _SPEED * self._model.opt.timestep, -2e-3, _HEIGHT + 0.02)
            )
            data.ctrl[:] = self._target, self._force, self._force
            mujoco.mj_step(self._model, data)
        height = float(data.xpos[self._body, 2]) - self.thing.half_height
        held = float(data.xpos[self._body, 2] - data.xpos[self._gripper, 2])
        touched = data.ncon > 1
        slid = abs(held - self._close) if touched and self._close is not None else 0.0
        self._close = held if touched else None
        rise = max(min(height, _HEIGHT) - self._best, 0.0)
        self._best = max(self._best, min(height, _HEIGHT))
        dropped = self._best > _UP and height < _DOWN and float(data.qpos[0]) > _UP  # and was not put down
        gained = _RISES * rise + _HOLDS * _PERIOD * max(min(height, _HEIGHT), 0.0)
        reward = gained / _HEIGHT - _SLIDES * slid - _SQUEEZES * self._force * _PERIOD - _DROPS * dropped
        info = {
            "height": height,
            "slid": slid,
            "force": self._force,
            "dropped": dropped,
            "lifted": height > 0.9 * _HEIGHT,
        }
        return self._seen(), float(reward), dropped, bool(data.time >= _LONGEST), info

    def render(self) -> Any:
        """A picture of the scene, (480, 640, 3); it needs OpenGL (MUJOCO_GL=egl or osmesa where there is no screen)."""
        if self._renderer is None:
            self._renderer = mujoco.Renderer(self._model, *_PICTURE)
        self._renderer.update_scene(self._data, camera="front")
        return self._renderer.render()

    def close(self) -> None:
        """Let go of the renderer."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _seen(self) -> npt.NDArray[np.float32]:
        own = [self._force / _STRONGEST, float(self._data.qpos[0]) / _HEIGHT]
        seen = np.concatenate([self._told().ravel(), own])
        return np.asarray(np.clip(seen, -_MOST, _MOST), dtype=np.float32)

    def _told(self) -> FloatArray:
        """What the skins tell, a row for each, in numbers of about 1."""
        if self._what == "forces":
            felt = [sampled.skin.feel(self._data, pressed=False) for sampled in self._skins]
            return np.array([(*each.force, each.torsion / _ARM) for each in felt]) / _LOAD
        frames = np.stack([sampled.read(self._data) for sampled in self._skins])
        if self._reader is None:
            return np.asarray((frames - np.asarray(self._finger.array.offset)) / self._unit)
        found = self._reader(frames)
        loads = np.concatenate([found.components, found.torsion[:, None] / _ARM], axis=1)
        return np.asarray(np.nan_to_num(loads / _LOAD))


def _drawn(seed: int) -> Thing:
    return things(4, seed)[seed % 4]


gymnasium.register(id=ID, entry_point=f"{__name__}:GraspEnv")
