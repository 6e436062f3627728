"""Readings that a finger's model does not describe: other contacts, other skins, faulty sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._declared import checked
from ..contact import Contact, FlatPunch, Hertz, LocalContact, PointLoad, RoundHertz, RoundPunch
from ..errors import SubskinError
from ..finger import Finger
from ..skin import Layer, Layered, in_space
from .tolerance.sources import as_made
from .touches import Touches

__all__ = ["OUTSIDE", "Outside", "outside_of"]

_FULL = 0.35
"""Where a saturated sensor ends, of the largest reading that the touches make."""
_WEAK = 0.6
_RINGS, _TURNS, _ALONG = 5, 12, 12
"""Points that stand for a flat disc, and for an edge."""
_RADII = 10
_FINGERS = 20
"""How many fingers share the touches where each sensor is off by an amount of its own."""


Sensors: TypeAlias = npt.NDArray[np.intp]


class Drawn(NamedTuple):
    """Readings (m, n) with noise, and where they come from: positions (m, k, d) of which any is right, normal (m,) [N].

    The normal force of line loads is per length [N/m]; NaN where it is not to be judged.
    """

    readings: FloatArray
    positions: FloatArray
    normal: FloatArray


@dataclass(frozen=True)
class Scene:
    """A finger as its estimators take it to be, the touches that it is made for, and the draws of `count` of them."""

    finger: Finger
    touches: Touches
    count: int
    rng: np.random.Generator

    @property
    def dim(self) -> int:
        """Coordinates of a position: 1 of line loads, 2 on an area."""
        return self.touches.dim

    @property
    def depth(self) -> float:
        """Mean depth of the sensors [m]."""
        return float(np.asarray(self.finger.array.depth).mean())

    def between(self, low: float, high: float) -> FloatArray:
        """One number a touch, evenly from `low` to `high`."""
        return self.rng.uniform(low, high, self.count)

    def leaning(self, angle: FloatArray) -> FloatArray:
        """Components (m, d + 1) of loads at angles (m,) to the normal; on an area to any side."""
        parts = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        if self.dim == 2:
            parts = np.concatenate([parts[:, :1], parts[:, 1:] * self.sides()], axis=1)
        return self.touches.force * parts

    def sides(self) -> FloatArray:
        """Directions along the surface, (m, d): to either side, or on an area to all."""
        if self.dim == 1:
            return self.rng.choice([-1.0, 1.0], self.count)[:, None]
        turn = self.between(-np.pi, np.pi)
        return np.stack([np.cos(turn), np.sin(turn)], axis=-1)

    def loads(self) -> FloatArray:
        """Components of the touches, (m, d + 1), evenly over the cone."""
        return self.leaning(self.between(-self.touches.cone, self.touches.cone))

    def positions(self) -> FloatArray:
        """Positions of the touches, (m, d), evenly over the span or the area [m]."""
        if self.dim == 1:
            return self.between(*self.touches.span_on(self.finger))[:, None]
        box = np.asarray(self.touches.area)
        return self.rng.uniform(box[:, 0], box[:, 1], (self.count, 2))

    def touch(self, load: FloatArray, position: FloatArray) -> Contact | LocalContact:
        """A touch of the model with components (m, d + 1) at positions (m, d)."""
        return self.touches.contact(load, position[:, 0] if self.dim == 1 else position)

    def model(self) -> Contact | LocalContact:
        """The touches that the model describes."""
        load = self.loads()
        return self.touch(load, self.positions())

    def read(
        self, contact: Contact | LocalContact, finger: Finger | None = None, also: FloatArray | None = None
    ) -> Drawn:
        """What `contact` reads on `finger`, or on the scene's own; its resultant's position, and those of `also`."""
        positions = also
        if positions is None:
            at = np.asarray(getattr(contact, "position", np.nan), dtype=np.float64).reshape(-1, self.dim)
            positions = np.broadcast_to(at, (self.count, self.dim))[:, None]
        normal = np.broadcast_to(contact.normal_force, contact.shape)
        return Drawn((finger or self.finger).read(contact, rng=self.rng), positions, normal)

    def with_fault(self, fault: Callable[[FloatArray, Sensors], FloatArray]) -> Drawn:
        """Good touches, of which `fault(readings, one of n sensors a touch)` makes those of a faulty finger."""
        drawn = self.read(self.model())
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
    dim : int, optional
        1 or 2 where it is of rows, or of an area, alone.
    """

    name: str
    text: str
    group: Literal["model", "touch", "point", "skin", "sensor"]
    draw: Callable[[Scene], Drawn | None]
    family: str = ""
    dim: int | None = None


def _point(scene: Scene, least: float, most: float) -> Drawn | None:
    """Touches on a point, from `least` to `most` depths beside the row, as strong as the line loads are above it."""
    skin = in_space(scene.finger.skin)
    if skin is None:
        return None
    finger, mu = replace(scene.finger, skin=skin), scene.touches.friction
    above = np.asarray(finger.array.y)[finger.array.live]
    line = np.abs(finger.receptive_field(above)[..., 0]).max()
    point = np.abs(finger.receptive_field(np.stack([above, 0 * above], axis=-1), load="point")[..., 0]).max()
    at = np.concatenate([scene.positions(), scene.depth * scene.between(least, most)[:, None]], axis=-1)
    angle, azimuth = np.arctan(mu * np.sqrt(scene.between(0.0, 1.0))), scene.between(-np.pi, np.pi)
    touch = PointLoad(scene.touches.force * line / point, angle, azimuth, at)
    # a line load's N/m are no N: positions alone are judged
    return Drawn(finger.read(touch, rng=scene.rng), at[:, None, :1], np.full(scene.count, np.nan))


def _two(scene: Scene, low: float, high: float) -> Drawn:
    gap, share = scene.depth * scene.between(0.5, 3.0), scene.between(low, high)[:, None]
    middle = scene.positions()
    half = 0.5 * gap[:, None] * (1.0 if scene.dim == 1 else scene.sides())
    first, second = middle - half, middle + half
    both = scene.touch((1 - share) * scene.loads(), first) + scene.touch(share * scene.loads(), second)
    return scene.read(both, also=np.stack([first, second], axis=1))


def _wide(scene: Scene, kind: type[Hertz] | type[FlatPunch]) -> Drawn:
    half_width, load, at = scene.depth * scene.between(0.8, 2.0), scene.loads(), scene.positions()
    return scene.read(kind.of_components(load, at[:, 0], half_width=half_width))


def _wide_disc(scene: Scene, kind: type[RoundHertz] | type[RoundPunch]) -> Drawn:
    """Of a few radii, for in layers each has a spectrum of its own."""
    parts = []
    for i, some in enumerate(np.array_split(np.arange(scene.count), min(_RADII, scene.count))):
        part, half_width = replace(scene, count=some.size), scene.depth * (0.8 + 1.2 * (i + 0.5) / _RADII)
        parts.append(part.read(kind(components=part.loads(), position=part.positions(), half_width=half_width)))
    return _joined(parts)


def _joined(parts: Sequence[Drawn]) -> Drawn:
    return Drawn(*(np.concatenate(same) for same in zip(*parts, strict=True)))


def _tilted(scene: Scene) -> Drawn:
    half_width, load, at = scene.depth * scene.between(0.5, 1.5), scene.loads(), scene.positions()
    share = scene.between(-1.0, 1.0)  # at +-1 one edge just carries nothing
    if scene.dim == 1:
        lever = 0.5 * half_width * share
        moment = 0.999 * lever * load[:, 0]
        punch: Any = FlatPunch.of_components(load, at[:, 0], half_width=half_width, moment=moment)
        return scene.read(punch, also=np.stack([at, at + lever[:, None]], axis=1))
    side = scene.sides()
    points, weights = _disc(half_width)  # of a flat; tilted, 1 + share r / a times as much presses towards the side
    tilt = 1 + share * np.einsum("kmi,mi->km", points, side) / half_width
    lever = (half_width * share / 3)[:, None] * side
    return _points(scene, load, at + points, weights[:, None] * tilt, np.stack([at, at + lever], axis=1))


def _disc(half_width: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (k, m, 2) about the centre and weights (k,) that press as flat discs of half widths (m,) do.

    Gauss's rule in sqrt(1 - r^2 / a^2), in which a flat's pressure is even, and as many directions.
    """
    s, w = np.polynomial.legendre.leggauss(_RINGS)
    turn = 2 * np.pi * (np.arange(_TURNS) + 0.5) / _TURNS
    ring = np.sqrt(1 - (0.5 * (s + 1)) ** 2)
    at = ring[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return at.reshape(-1, 1, 2) * half_width[:, None], np.repeat(0.5 * w / _TURNS, _TURNS)


def _edge(scene: Scene) -> Drawn:
    """A straight edge, evenly loaded, of which any point is right."""
    half, load, middle = 0.5 * scene.depth * scene.between(1.0, 4.0), scene.loads(), scene.positions()
    t, w = np.polynomial.legendre.leggauss(_ALONG)
    along = half[:, None] * scene.sides()
    share = np.broadcast_to(0.5 * w[:, None], (_ALONG, scene.count))
    ends = np.linspace(-1.0, 1.0, 41)[:, None]
    return _points(scene, load, middle + t[:, None, None] * along, share, middle[:, None] + ends * along[:, None])


def _points(scene: Scene, load: FloatArray, at: FloatArray, share: FloatArray, positions: FloatArray) -> Drawn:
    """Touches that press as points at (k, m, 2) do, of which each carries its share (k, m)."""
    parts = [PointLoad(components=s[:, None] * load, position=points) for s, points in zip(share, at, strict=True)]
    return scene.read(sum(parts[1:], parts[0]), also=positions)


def _drag(scene: Scene) -> Drawn:
    side = scene.touches.force * scene.sides()
    return scene.read(scene.touch(np.concatenate([0 * side[:, :1], side], axis=1), scene.positions()))


def _beyond_the_cone(scene: Scene) -> Drawn | None:
    if scene.touches.friction == 0:
        return _drag(scene)
    angle = np.arctan(scene.touches.friction * scene.between(1.2, 3.0)) * scene.rng.choice([-1.0, 1.0], scene.count)
    return scene.read(scene.touch(scene.leaning(angle), scene.positions()))


def _pull(scene: Scene) -> Drawn:
    load = -scene.loads()
    return scene.read(scene.touch(load, scene.positions()))


def _beyond_the_sensors(scene: Scene) -> Drawn:
    points = scene.finger.array.points[scene.finger.array.live, : scene.dim]
    away, low, high = scene.depth * scene.between(1.6, 4.0), points.min(axis=0), points.max(axis=0)
    at, rows = np.full((scene.count, scene.dim), np.nan), np.arange(scene.count)
    axis: Any = 0
    if scene.dim == 2:
        at, axis = scene.rng.uniform(low, high, at.shape), scene.rng.integers(2, size=scene.count)
    right = scene.rng.random(scene.count) < 0.5
    at[rows, axis] = np.where(right, high[axis] + away, low[axis] - away)
    return scene.read(scene.touch(scene.loads(), at))


def _on(scene: Scene, change: Callable[[Finger], Finger]) -> Drawn | None:
    try:
        made = change(scene.finger)
    except SubskinError:  # there is no such finger
        return None
    return scene.read(scene.model(), made)


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
        shape = (len(scene.finger.array), 2) if off == "position" and scene.dim == 2 else len(scene.finger.array)
        each = amount * scene.rng.standard_normal(shape)
        parts.append(part.read(part.model(), as_made(scene.finger, {off: each})))
    return _joined(parts)


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
    return scene.read(scene.model(), made)


OUTSIDE = (
    Outside("line", "a line load (the model holds)", "model", lambda s: s.read(s.model()), dim=1),
    Outside("touch", "a touch (the model holds)", "model", lambda s: s.read(s.model()), dim=2),
    Outside("two", "two touches, 0.5 to 3 depths apart", "touch", lambda s: _two(s, 0.3, 0.7)),
    Outside("two_weak", "two touches, one of them weak", "touch", lambda s: _two(s, 0.05, 0.3)),
    Outside("wide_roller", "a wide roller, half width 0.8 to 2 depths", "touch",
            lambda s: _wide(s, Hertz), "hertz", dim=1),
    Outside("wide_ball", "a wide ball, radius of the contact 0.8 to 2 depths", "touch",
            lambda s: _wide_disc(s, RoundHertz), "round_hertz", dim=2),
    Outside("wide_flat", "a wide flat, half width 0.8 to 2 depths", "touch",
            lambda s: _wide(s, FlatPunch), "punch", dim=1),
    Outside("wide_disc", "a wide flat disc, radius 0.8 to 2 depths", "touch",
            lambda s: _wide_disc(s, RoundPunch), "round_punch", dim=2),
    Outside("tilted_flat", "a tilted flat, half width 0.5 to 1.5 depths", "touch", _tilted),
    Outside("edge", "an edge, 1 to 4 depths long", "touch", _edge, dim=2),
    Outside("drag", "a drag without a normal force", "touch", _drag),
    Outside("beyond_cone", "a drag beyond the friction cone", "touch", _beyond_the_cone),
    Outside("pull", "a pull (adhesion)", "touch", _pull),
    Outside("beyond_row", "a load 1.6 to 4 depths beyond the row", "touch", _beyond_the_sensors, dim=1),
    Outside("beyond_area", "a load 1.6 to 4 depths beyond the sensors", "touch", _beyond_the_sensors, dim=2),
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
            lambda s: _point(s, 0.0, 0.0), "point", dim=1),
    Outside("beside", "a touch on a point, 0.3 to 1 depths beside the row", "point",
            lambda s: _point(s, 0.3, 1.0), "point", dim=1),
    Outside("far_beside", "a touch on a point, 1 to 3 depths beside the row", "point",
            lambda s: _point(s, 1.0, 3.0), "point", dim=1),
)  # fmt: skip
"""All that is looked at, in the order of a table's rows; lengths in mean depths of the sensors."""


@checked
def outside_of(touches: Touches) -> tuple[Outside, ...]:
    """What of `OUTSIDE` there is of such `touches`: along a row, or on an area."""
    return tuple(each for each in OUTSIDE if each.dim in (None, touches.dim))
