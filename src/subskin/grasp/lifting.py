"""Lifts in simulation: a thing is gripped, lifted, shaken, filled, put down; and what came of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, TypeAlias

import numpy as np

from .._check import FloatArray
from .._frozen import Frozen
from .._shown import Drawing
from ..array import SensorArray
from ..finger import Finger
from ..material import Material
from ..mujoco import Felt, GeomSkin
from ..mujoco.installed import engine
from ..skin import HalfSpace
from ..transducer import Displacement
from .hand import Hand, HandCommand, Phase
from .peers import ConeHand
from .scene import PADS, Thing, gripper_xml

__all__ = ["Lifted", "lift", "pad_finger"]

_HEIGHT, _CLEAR = 0.08, 0.03
"""How high a thing is lifted, and where it counts as lifted at the least [m]."""
_EVERY = 2
"""Steps of the physics between frames."""
_SHAKE, _FILL, _HELD = (0.5, 1.5), (2.0, 3.0), 3.5
"""When a thing is shaken and filled after it came up, and when it is put down [s]."""
_SHAKEN, _FREQUENCY, _FILLED = 3.0, 6.0, 0.5
"""Acceleration [m/s2] and frequency [Hz] of the shaking; what is filled in, of the mass."""
_LONGEST = 9.0
"""A lift that has not ended by then is given up [s]."""

Watch: TypeAlias = Callable[[Any, list[Felt], float], object]


@lru_cache(maxsize=1)
def pad_finger() -> Finger:
    """A pad of silicone with 4 x 4 magnets in it, 5 mm apart and 2.5 mm deep, whose displacement is read along 3 axes.

    Examples
    --------
    >>> pad_finger().array.layout
    '4 x 4 grid, pitch 5 mm'
    """
    at = (np.arange(4) - 1.5) * 5e-3
    y, z = (np.repeat(each.ravel(), 3) for each in np.meshgrid(at, at, indexing="ij"))
    kinds = tuple(Displacement(axis) for axis in ("x", "y", "z")) * 16
    array = SensorArray(y=y, z=z, depth=2.5e-3, noise=2e-6, transducer=kinds)
    return Finger(HalfSpace(Material(young=1e6)), array)


@dataclass(frozen=True, eq=False)
class Lifted(Frozen):
    """What came of a lift.

    Attributes
    ----------
    thing : Thing
        What was lifted.
    dropped : bool
        It came down, or never up.
    slid : float
        The farthest that it moved in the hand, from the first pull until it was put down [m].
    waste : float
        Median, over the time in which it was held, of the normal force over the least one: drag over friction [-].
    friction : float
        What the hand learnt of it [-].
    seconds, wall, slowest : float
        Simulated time, time it took, and the 99th percentile of a step with its frame [s].
    trace : ndarray, shape (frames, 7)
        Time [s], phase, force asked for, true normal force and drag of a pad [N], height of the thing and of the
        gripper [m].
    """

    thing: Thing
    dropped: bool
    slid: float
    waste: float
    friction: float
    seconds: float
    wall: float
    slowest: float
    trace: FloatArray

    plot = Drawing("lift_figure")


def lift(thing: Thing, hand: Hand, seed: int = 0, watch: Watch | None = None) -> Lifted:
    """Lift a thing with a hand, shake it, fill it, and put it down.

    Parameters
    ----------
    thing : Thing
        What is lifted.
    hand : Hand
        Or anything like it, such as `FixedHand`.
    seed : int, optional
        Of the noise.
    watch : callable, optional
        Called at each frame with MuJoCo's state, what both skins feel, and the force that the hand asks for.

    Examples
    --------
    >>> from subskin.grasp import Thing, lift, pad_finger, Hand
    >>> lifted = lift(Thing("ball", (0.02, 0.02, 0.02), mass=0.1, friction=0.7), Hand([pad_finger()] * 2))
    >>> lifted.dropped
    False
    """
    mujoco = engine()
    model = mujoco.MjModel.from_xml_string(gripper_xml(thing))
    data, rng = mujoco.MjData(model), np.random.default_rng([34, seed])
    skins = [GeomSkin(model, pad, finger, face) for (pad, face), finger in zip(PADS.items(), hand.fingers, strict=True)]
    body, gripper = model.body("thing").id, model.body("gripper").id
    rest, mass = float(data.qpos[0]), float(model.body_mass[body])
    inertia = model.body_inertia[body].copy()
    if isinstance(hand, ConeHand):
        hand.knows(thing.friction)
    hand.restart()
    command, target, up, down = HandCommand(0.0, 0.0, Phase.TARE), rest, np.inf, False
    trace, taken, began = [], [], perf_counter()
    speed, step = 0.0, model.opt.timestep
    while data.time < _LONGEST:
        start = perf_counter()
        for _ in range(_EVERY):
            wanted = np.clip(command.speed, -np.inf, (_HEIGHT - target) / 0.1)
            speed += np.clip(wanted - speed, -step, step)  # 1 m/s2
            target += speed * step
            data.ctrl[:] = max(target, -2e-3), command.force, command.force
            _disturb(model, data, body, data.time - up, mass, inertia)
            mujoco.mj_step(model, data)
        felt = [skin.feel(data) for skin in skins]
        command = hand.step([np.append(e.force, e.torsion) if hand.sees_forces else e.read(rng) for e in felt])
        taken.append(perf_counter() - start)
        if watch is not None:
            watch(data, felt, command.force)
        if np.isinf(up) and command.phase == Phase.HOLD and target > _HEIGHT - 2e-3:
            up = data.time
        if data.time - up >= _HELD and not down:
            hand.lower()
            down = True
        force = np.array([each.force for each in felt])
        drag = np.hypot(force[:, 1], force[:, 2]).max()
        heights = data.xpos[[body, gripper], 2]
        trace.append((data.time, command.phase, command.force, force[:, 0].mean(), drag, *heights))
        if command.phase == Phase.OPEN and command.force == 0:
            break
    return _judged(thing, hand, np.array(trace), np.array(taken), perf_counter() - began, data.time)


def _disturb(model: Any, data: Any, body: int, since: float, mass: float, inertia: FloatArray) -> None:
    """Shake the thing, in a circle along the pads, and fill it, by the time since it came up."""
    data.xfrc_applied[body] = 0.0
    if _SHAKE[0] <= since < _SHAKE[1]:
        phase, grown = 2 * np.pi * _FREQUENCY * (since - _SHAKE[0]), min(1.0, 5 * (since - _SHAKE[0]))
        data.xfrc_applied[body, 1:3] = mass * _SHAKEN * grown * np.array([np.cos(phase), np.sin(phase)])
    if _FILL[0] <= since < _FILL[1]:
        share = 1.0 + _FILLED * (since - _FILL[0]) / (_FILL[1] - _FILL[0])
        model.body_mass[body], model.body_inertia[body] = mass * share, inertia * share


def _judged(thing: Thing, hand: Hand, trace: FloatArray, taken: FloatArray, wall: float, seconds: float) -> Lifted:
    held = np.isin(trace[:, 1], (Phase.HOLD, Phase.LOWER))
    pulled = trace[:, 1] >= Phase.LOAD
    moved = (trace[:, 5] - trace[:, 6])[pulled & (trace[:, 1] < Phase.OPEN)]
    high = trace[:, 5] - thing.half_height
    up = trace[:, 1] == Phase.HOLD
    # it came up, and was up at the end of the holding
    dropped = not (up.any() and high.max() > _CLEAR and high[np.flatnonzero(up)[-1]] > _CLEAR)
    least = trace[held, 4] / thing.friction
    waste = float(np.median(trace[held, 3] / np.maximum(least, 1e-9))) if held.any() else np.nan
    slid = float(np.abs(moved - moved[0]).max()) if moved.size else np.inf
    return Lifted(
        thing, dropped, slid, waste, float(hand.friction), seconds, wall, float(np.quantile(taken, 0.99)), trace
    )
