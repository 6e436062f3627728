"""A gripper with two pads over a table in MuJoCo, and things to lift: boxes, bottles, balls and eggs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
import numpy.typing as npt

from .._declared import Noun, Positive, Real

__all__ = ["PADS", "Thing", "gripper_xml", "things"]

PADS = {"left_pad": "+x", "right_pad": "-x"}
"""Geoms with skins, and where their outward normals point."""

_PAD = 8e-3
"""Half side of a pad [m]."""
_GAP = 5e-3
"""Between a thing and each pad at first [m]."""
_TORSION = 0.003
"""Torsional friction over the sliding one [m]: of a round contact of half width a it is about 0.6 a."""

_GEOMS = {"box": "box", "bottle": "cylinder", "ball": "sphere", "egg": "ellipsoid"}


@dataclass(frozen=True, eq=False)
class Thing(Noun):
    """Something to lift.

    Parameters
    ----------
    shape : {"box", "bottle", "ball", "egg"}
        A bottle is a cylinder that stands, an egg an ellipsoid that stands on its end.
    size : array_like, shape (3,)
        Half lengths along x, between the pads, y and z, upwards [m]. A bottle and a ball are round: the first is their
        radius.
    mass : float
        [kg], > 0.
    friction : float
        Coulomb's coefficient with the pads [-], > 0.
    off : float, optional
        How far from its middle it is gripped, along y [m].

    Examples
    --------
    >>> Thing("box", (0.02, 0.03, 0.04), mass=0.2, friction=0.5).geom()
    'type="box" size="0.02 0.03 0.04"'
    """

    shape: Literal["box", "bottle", "ball", "egg"]
    size: Annotated[npt.ArrayLike, Real("m", above=0.0)]
    mass: Annotated[float, Real("kg", above=0.0)]
    friction: Positive
    off: Annotated[float, Real("m")] = 0.0

    EXAMPLE: ClassVar = 'Thing("ball", (0.03, 0.03, 0.03), mass=0.1, friction=0.6)'

    def geom(self) -> str:
        """Its type and size in an MJCF."""
        x, y, z = np.asarray(self.size)
        sizes = {"box": (x, y, z), "bottle": (x, z), "ball": (x,), "egg": (x, y, z)}[self.shape]
        return f'type="{_GEOMS[self.shape]}" size="{" ".join(f"{v:.9g}" for v in sizes)}"'

    @property
    def half_height(self) -> float:
        """Height of its middle above what it stands on [m]."""
        return float(np.asarray(self.size)[0 if self.shape == "ball" else 2])


def gripper_xml(thing: Thing, timestep: float = 1e-3) -> str:
    """The MJCF of a gripper above a table, its pads on either side of the thing.

    Actuators: `lift` holds the height of the gripper above its first [m]; `left` and `right` press the fingers [N].

    Parameters
    ----------
    thing : Thing
        What stands between the pads.
    timestep : float, optional
        [s]

    Examples
    --------
    >>> import mujoco
    >>> scene = gripper_xml(Thing("ball", (0.03, 0.03, 0.03), mass=0.1, friction=0.6))
    >>> mujoco.MjModel.from_xml_string(scene).nu
    3
    """
    high = thing.half_height
    out = float(np.asarray(thing.size)[0]) + _GAP
    fingers = "".join(
        f'<body name="{side}" pos="{sign * (out + 5e-3):.9g} 0 0" gravcomp="1">'
        f'<joint name="{side}" type="slide" axis="{-sign} 0 0" damping="10"/>'
        f'<geom name="{side}_pad" type="box" size="0.005 {_PAD} {_PAD}" mass="0.08" friction="0.01 1e-4 1e-5" '
        f'condim="4" contype="1" conaffinity="1" rgba=".2 .5 .8 1"/></body>'
        for side, sign in (("left", -1), ("right", 1))
    )
    mu = thing.friction
    return f"""<mujoco model="lift">
  <option timestep="{timestep}" cone="elliptic" impratio="20" integrator="implicitfast" noslip_iterations="3"/>
  <visual><global offwidth="640" offheight="480"/></visual>
  <worldbody>
    <light pos="0.2 -0.4 0.8" dir="-0.2 0.4 -0.8"/>
    <camera name="front" pos="0 -0.45 0.12" xyaxes="1 0 0 0 0.1 1"/>
    <geom name="table" type="plane" size="1 1 0.1" friction="0.5 0.005 1e-4" rgba=".85 .85 .82 1"/>
    <body name="gripper" pos="0 0 {high:.9g}" gravcomp="1">
      <joint name="lift" type="slide" axis="0 0 1" damping="20"/>
      <geom type="box" size="{out + 0.03:.9g} 0.01 0.005" pos="0 0 {high + 0.06:.9g}" mass="0.5" contype="0"
        conaffinity="0" rgba=".5 .5 .5 1"/>
      {fingers}
    </body>
    <body name="thing" pos="0 {-thing.off:.9g} {high:.9g}">
      <freejoint/>
      <geom name="thing" {thing.geom()} mass="{thing.mass:.9g}" condim="4"
        friction="{mu:.9g} {mu * _TORSION:.9g} 1e-5" rgba=".85 .5 .3 1"/>
    </body>
  </worldbody>
  <equality><joint joint1="left" joint2="right" polycoef="0 1 0 0 0" solref="0.004 1"/></equality>
  <actuator>
    <position name="lift" joint="lift" kp="4000" kv="200"/>
    <motor name="left" joint="left" ctrlrange="-40 40"/>
    <motor name="right" joint="right" ctrlrange="-40 40"/>
  </actuator>
</mujoco>"""


def things(count: int, seed: int = 0) -> list[Thing]:
    """Things of unknown weight and friction, boxes, bottles, balls and eggs in turn.

    Parameters
    ----------
    count : int
        How many.
    seed : int, optional
        Of the random numbers.

    Examples
    --------
    >>> [thing.shape for thing in things(5)]
    ['box', 'bottle', 'ball', 'egg', 'box']
    """
    rng = np.random.default_rng([34, seed])
    return [_thing(list(_GEOMS)[i % len(_GEOMS)], rng) for i in range(count)]


def _thing(shape: Any, rng: np.random.Generator) -> Thing:
    friction = rng.uniform(0.4, 0.9)
    if shape == "box":
        return Thing(shape, rng.uniform((0.012, 0.012, 0.02), (0.035, 0.035, 0.06)), rng.uniform(0.05, 0.6), friction)
    if shape == "bottle":
        radius = rng.uniform(0.015, 0.035)
        return Thing(shape, (radius, radius, rng.uniform(0.04, 0.08)), rng.uniform(0.05, 0.6), friction)
    if shape == "ball":
        radius = rng.uniform(0.015, 0.035)
        return Thing(shape, np.full(3, radius), rng.uniform(0.05, 0.4), friction)
    scale = rng.uniform(0.9, 1.1)
    return Thing(shape, scale * np.array([0.022, 0.022, 0.028]), rng.uniform(0.045, 0.09), friction)
