"""Readings that a finger's model does not describe: other contacts, other skins, faulty sensors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..contact import Contact, FlatPunch, Hertz, LineLoad, PointLoad
from ..errors import SubskinError
from ..finger import Finger
from ..skin import Layer, Layered, in_space
from .tolerance.sources import as_made
from .touches import Touches

__all__ = ["OUTSIDE", "Drawn", "Outside", "Scene"]

Sensors: TypeAlias = npt.NDArray[np.intp]

_FULL = 0.35
"""Where a saturated sensor ends, of the largest reading that the touches make."""
_WEAK = 0.6
_FINGERS = 20
"""How many fingers share the touches where each sensor is off by an amount of its own."""


class Drawn(NamedTuple):
    """Readings (m, n) with noise, and where they come from: positions (m, k) of which any is right, normal force (m,).

    `depth` is the sensors' mean depth, in which errors of position are judged [m].
    """

    readings: FloatArray
    positions: FloatArray
    normal: FloatArray


@dataclass(frozen=True)
class Scene:
    """A finger, the touches that it is made for, and the draws of `count` of them.

    Parameters
    ----------
    finger : Finger
        As its estimators take it to be.
    touches : Touches
        Force [N/m], cone and span [m].
    count : int
        Number of touches.
    rng : numpy.random.Generator
        The random generator.
    """

    finger: Finger
    touches: Touches
    count: int
    rng: np.random.Generator

    @property
    def depth(self) -> float:
        """Mean depth of the sensors [m]."""
        return float(np.asarray(self.finger.array.depth).mean())

    def between(self, low: float, high: float) -> FloatArray:
        """One number a touch, evenly from `low` to `high`."""
        return self.rng.uniform(low, high, self.count)

    def angles(self) -> FloatArray:
        """Angles of the touches, evenly over the cone [rad]."""
        return self.between(-self.touches.cone, self.touches.cone)

    def positions(self) -> FloatArray:
        """Positions of the touches, evenly over the span [m]."""
        return self.between(*self.touches.span_on(self.finger))

    def line(self) -> LineLoad:
        """The touches that the model of a line load describes."""
        return LineLoad(self.touches.force, self.angles(), self.positions())

    def read(self, contact: Contact, finger: Finger | None = None, also: FloatArray | None = None) -> Drawn:
        """What `contact` reads on `finger`, or on the scene's own; its resultant's position, and those of `also`."""
        made = self.finger if finger is None else finger
        at = np.broadcast_to(np.asarray(getattr(contact, "position", np.nan), dtype=np.float64), contact.shape)
        positions = at[:, None] if also is None else also
        normal = np.broadcast_to(contact.normal_force, contact.shape)
        return Drawn(made.read(contact, rng=self.rng), positions, normal)

    def with_fault(self, fault: Callable[[FloatArray, Sensors], FloatArray]) -> Drawn:
        """Good touches, of which `fault(readings, one of n sensors a touch)` makes those of a faulty finger."""
        drawn = self.read(self.line())
        live = np.flatnonzero(self.finger.array.live)
        return drawn._replace(readings=fault(drawn.readings, self.rng.choice(live, self.count)))


@dataclass(frozen=True)
class Outside:
    """One thing that the model leaves out.

    Parameters
    ----------
    name : str
        A key.
    text : str
        In words, "a wide roller".
    group : {"model", "touch", "point", "skin", "sensor"}
        What differs: nothing, what presses, how long it is, the skin, or the sensors.
    draw : callable
        From a `Scene` to `Drawn`; None where the finger has no such thing.
    family : str
        Name of the family of contacts that does describe it, if any.
    """

    name: str
    text: str
    group: Literal["model", "touch", "point", "skin", "sensor"]
    draw: Callable[[Scene], Drawn | None]
    family: str = ""


def _point(scene: Scene, least: float, most: float) -> Drawn | None:
    """Touches on a point, from `least` to `most` depths beside the row, as strong as the line loads are above it."""
    skin = in_space(scene.finger.skin)
    if skin is None:
        return None
    finger, mu = replace(scene.finger, skin=skin), scene.touches.friction
    above = np.asarray(finger.array.y)[finger.array.live]
    line = np.abs(finger.receptive_field(above)[..., 0]).max()
    point = np.abs(finger.receptive_field(np.stack([above, 0 * above], axis=-1), load="point")[..., 0]).max()
    at = np.stack([scene.positions(), scene.depth * scene.between(least, most)], axis=-1)
    angle, azimuth = np.arctan(mu * np.sqrt(scene.between(0.0, 1.0))), scene.between(-np.pi, np.pi)
    touch = PointLoad(scene.touches.force * line / point, angle, azimuth, at)
    # a line load's N/m are no N: positions alone are judged
    return Drawn(finger.read(touch, rng=scene.rng), at[:, :1], np.full(scene.count, np.nan))


def _two(scene: Scene, low: float, high: float) -> Drawn:
    gap, share = scene.depth * scene.between(0.5, 3.0), scene.between(low, high)
    middle, force = scene.positions(), scene.touches.force
    first, second = middle - 0.5 * gap, middle + 0.5 * gap
    both = LineLoad(force * (1 - share), scene.angles(), first) + LineLoad(force * share, scene.angles(), second)
    return scene.read(both, also=np.stack([first, second], axis=-1))


def _wide(scene: Scene, kind: type[Hertz] | type[FlatPunch]) -> Drawn:
    half_width = scene.depth * scene.between(0.8, 2.0)
    return scene.read(kind(scene.touches.force, scene.angles(), scene.positions(), half_width=half_width))


def _tilted(scene: Scene) -> Drawn:
    half_width, angle, at = scene.depth * scene.between(0.5, 1.5), scene.angles(), scene.positions()
    lever = 0.5 * half_width * scene.between(-1.0, 1.0)  # at +-1 one edge just carries nothing
    normal = scene.touches.force * np.cos(angle)
    punch = FlatPunch(scene.touches.force, angle, at, half_width=half_width, moment=0.999 * lever * normal)
    return scene.read(punch, also=np.stack([at, at + lever], axis=-1))


def _drag(scene: Scene) -> Drawn:
    side = scene.rng.choice([-1.0, 1.0], scene.count) * scene.touches.force
    return scene.read(LineLoad.of_components(np.stack([0 * side, side], axis=-1), scene.positions()))


def _beyond_the_cone(scene: Scene) -> Drawn | None:
    mu = scene.touches.friction
    if mu == 0:
        return _drag(scene)
    angle = np.arctan(mu * scene.between(1.2, 3.0)) * scene.rng.choice([-1.0, 1.0], scene.count)
    return scene.read(LineLoad(scene.touches.force, angle, scene.positions()))


def _pull(scene: Scene) -> Drawn:
    angle = scene.angles()
    return scene.read(
        LineLoad(scene.touches.force, np.where(angle > 0, angle - np.pi, angle + np.pi), scene.positions())
    )


def _beyond_the_row(scene: Scene) -> Drawn:
    y = np.asarray(scene.finger.array.y)[scene.finger.array.live]
    away, right = scene.depth * scene.between(1.6, 4.0), scene.rng.random(scene.count) < 0.5
    at = np.where(right, y.max() + away, y.min() - away)
    return scene.read(LineLoad(scene.touches.force, scene.angles(), at))


def _on(scene: Scene, change: Callable[[Finger], Finger]) -> Drawn | None:
    try:
        made = change(scene.finger)
    except SubskinError:  # there is no such finger
        return None
    return scene.read(scene.line(), made)


def _other_thickness(finger: Finger) -> Finger:
    """Of a half plane a layer bonded to a rigid base, two depths thick; of another skin one a quarter thicker."""
    if finger.skin.endless:
        deepest = float(np.asarray(finger.array.depth).max())
        return replace(finger, skin=Layered(Layer(finger.skin.materials[0], 2 * deepest)))
    return replace(finger, skin=finger.skin.with_(thickness=1.25 * finger.skin.thickness))


def _compressible(finger: Finger) -> Finger:
    new = [replace(m, poisson=m.poisson - 0.1) for m in finger.skin.materials]
    return replace(finger, skin=finger.skin.with_(materials=new))


def _made(scene: Scene, off: str, amount: float) -> Drawn:
    """Fingers that are off in each sensor's `off` by `amount`, a standard deviation; some touches on each."""
    parts = []
    for some in np.array_split(np.arange(scene.count), _FINGERS):
        part = replace(scene, count=some.size)
        each = amount * scene.rng.standard_normal(len(scene.finger.array))
        parts.append(part.read(part.line(), as_made(scene.finger, {off: each})))
    return Drawn(*(np.concatenate(same) for same in zip(*parts, strict=True)))


def _stuck(readings: FloatArray, sensor: Sensors, at: FloatArray) -> FloatArray:
    out, rows = np.array(readings), np.arange(len(readings))
    out[rows, sensor] = at[rows, sensor]
    return out


def _weak(scene: Scene) -> Drawn:
    array = scene.finger.array

    def fault(readings: FloatArray, sensor: Sensors) -> FloatArray:
        offset = np.broadcast_to(np.asarray(array.offset), readings.shape)
        return _stuck(readings, sensor, offset + _WEAK * (readings - offset))

    return scene.with_fault(fault)


def _silent(scene: Scene) -> Drawn:
    array, rng = scene.finger.array, scene.rng

    def fault(readings: FloatArray, sensor: Sensors) -> FloatArray:
        noise = np.asarray(array.noise) * rng.standard_normal(readings.shape)
        return _stuck(readings, sensor, np.asarray(array.offset) + noise)

    return scene.with_fault(fault)


def _saturated(scene: Scene) -> Drawn:
    offset = np.asarray(scene.finger.array.offset)

    def fault(readings: FloatArray, _: Sensors) -> FloatArray:
        most = _FULL * np.abs(readings - offset).max(axis=0)
        return np.asarray(offset + np.clip(readings - offset, -most, most))

    return scene.with_fault(fault)


def _drifted(scene: Scene, by: float) -> Drawn:
    drift = by * np.asarray(scene.finger.array.noise)
    return scene.with_fault(lambda readings, _: readings + drift * scene.rng.choice([-1.0, 1.0], readings.shape))


def _noisy(scene: Scene, factor: float) -> Drawn:
    array = scene.finger.array
    made = replace(scene.finger, array=replace(array, noise=factor * np.asarray(array.noise)))
    return scene.read(scene.line(), made)


OUTSIDE = (
    Outside("line", "a line load (the model holds)", "model", lambda s: s.read(s.line())),
    Outside("two", "two touches, 0.5 to 3 depths apart", "touch", lambda s: _two(s, 0.3, 0.7)),
    Outside("two_weak", "two touches, one of them weak", "touch", lambda s: _two(s, 0.05, 0.3)),
    Outside("wide_roller", "a wide roller, half width 0.8 to 2 depths", "touch", lambda s: _wide(s, Hertz), "hertz"),
    Outside("wide_flat", "a wide flat, half width 0.8 to 2 depths", "touch", lambda s: _wide(s, FlatPunch), "punch"),
    Outside("tilted_flat", "a tilted flat, half width 0.5 to 1.5 depths", "touch", _tilted),
    Outside("drag", "a drag without a normal force", "touch", _drag),
    Outside("beyond_cone", "a drag beyond the friction cone", "touch", _beyond_the_cone),
    Outside("pull", "a pull (adhesion)", "touch", _pull),
    Outside("beyond_row", "a load 1.6 to 4 depths beyond the row", "touch", _beyond_the_row),
    Outside("thickness", "another thickness of the skin", "skin", lambda s: _on(s, _other_thickness)),
    Outside("poisson", "Poisson's ratio lower by 0.1", "skin", lambda s: _on(s, _compressible)),
    Outside("position", "sensors 5 % of a depth out of position", "sensor",
            lambda s: _made(s, "position", 0.05 * s.depth)),
    Outside("gains", "gains off by 10 %", "sensor", lambda s: _made(s, "gains", 0.1)),
    Outside("stuck", "a sensor that reads nothing", "sensor", _silent),
    Outside("held", "a sensor stuck at an earlier touch", "sensor",
            lambda s: s.with_fault(lambda r, i: _stuck(r, i, s.rng.permutation(r)))),
    Outside("weak", "a sensor at 0.6 of its gain", "sensor", _weak),
    Outside("saturated", "readings cut off at 0.35 of the largest", "sensor", _saturated),
    Outside("drift", "offsets that drifted by 5 times the noise", "sensor", lambda s: _drifted(s, 5.0)),
    Outside("noise", "noise three times as large as stated", "sensor", lambda s: _noisy(s, 3.0)),
    Outside("point", "a touch on a point of the row", "point",
            lambda s: _point(s, 0.0, 0.0), "point"),
    Outside("beside", "a touch on a point, 0.3 to 1 depths beside the row", "point",
            lambda s: _point(s, 0.3, 1.0), "point"),
    Outside("far_beside", "a touch on a point, 1 to 3 depths beside the row", "point",
            lambda s: _point(s, 1.0, 3.0), "point"),
)  # fmt: skip
"""All that is looked at, in the order of a table's rows; lengths in mean depths of the sensors."""
