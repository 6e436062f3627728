"""Pressures of bodies on a skin, by pressing: each shape is pressed once, then scaled and leaned to every load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from ..errors import SubskinError
from ..prepared import Prepared
from ..pressing import LocalIndenter, press
from ..pressing.body import Ends, points
from ..skin import Skin

__all__ = ["Foot", "Outline", "PressedFeet", "principal"]

_FINE, _FINEST = 64, 128
"""Nodes along a side of a press; and of a flat face, with its sharp rim."""
_FEW, _MANY, _WIDE = 16, 32, 8.0
"""Points along a side that stand for a pressure; for that of a curved body that ends, or of one whose half length is
more than so many depths."""
_UNIT = 1e-3
"""Half length to which outlines are scaled on a half space, which has no length of its own [m]."""
_CURVED = 100.0
"""Curvature to which bodies are scaled, their forces with them [1/m]."""
_SHAPES, _LEVELS = 0.02, 0.1
"""Steps of the logarithm of lengths, and of loads, between presses."""
_LEANS = (0.02, 0.05)
"""Steps of the centre of pressure, in half lengths, between presses of flat faces and of curved ones."""
_CORNERS = 0.005
"""Step of a corner, in half lengths."""
_LEAN = 0.1
"""Centre of pressure, in half lengths, of the presses whose difference tells how a flat face leans."""
_SHORTER, _TRIES = 0.9, 12
"""A centre of pressure that no press reaches is drawn in by this factor, so many times; the rest is moved."""
_LEAST = 1e-6
"""Of a half length, what the points of a pressure are apart at least."""
_THIN = 0.05
"""Of the longer half length, the least that a shorter one is taken for."""
_STRAIGHT, _SQUARE = 1e-3, 1e-3
"""Of the larger curvature, what is none; of a rectangle's area, what a polygon may lack to be one."""
_RIM = 0.98
"""Farthest centre of pressure, in half lengths, that is pressed."""
_FLATTENED = 4.0
"""How many half lengths a body would have to touch, so that its curvature no longer matters."""
_FEWEST = 3
"""Points of a pressure; fewer are spread."""
_KEPT = 4096


class Outline(NamedTuple):
    """Where a body may touch: half lengths (2,) along y and z about 0 [m], infinite where it does not end; and the
    corners (k, 2) [m], counterclockwise, of what is no rectangle.
    """

    half: FloatArray
    corners: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Foot(LocalIndenter):
    """A paraboloid that ends at an outline.

    Parameters
    ----------
    curvature : ndarray, shape (2,)
        Along y and along z [1/m], >= 0.
    outline : Outline
        Where it ends.

    Examples
    --------
    >>> Foot(np.array([100.0, 0.0]), Outline(np.array([1e-3, np.inf]))).height([0.0, 1.1e-3], 0.0).tolist()
    [0.0, inf]
    """

    curvature: FloatArray
    outline: Outline

    def height(self, y: npt.ArrayLike, z: npt.ArrayLike) -> FloatArray:  # noqa: D102
        ys, zs = points(y, z)
        half, corners = self.outline
        inside = (np.abs(ys) <= half[0]) & (np.abs(zs) <= half[1])
        if corners is not None:
            for start, (a, b) in zip(corners, np.roll(corners, -1, axis=0) - corners, strict=True):
                inside &= a * (zs - start[1]) - b * (ys - start[0]) >= -1e-9 * np.hypot(a, b) * half.max()
        return np.where(inside, 0.5 * (self.curvature[0] * ys**2 + self.curvature[1] * zs**2), np.inf)

    @property
    def ends(self) -> Ends:  # noqa: D102
        y, z = map(float, self.outline.half)
        return (-y, y), (-z, z)


class PressedFeet:
    """Pressures of feet on one skin, at some hundred points each, as shares of the force.

    Parameters
    ----------
    skin : Skin
        One that takes local contacts.
    depth : float
        Of the shallowest sensor [m]: points lie at most about so far apart.

    Examples
    --------
    >>> import subskin as ss
    >>> feet, ball = PressedFeet(ss.HalfSpace(ss.Material(young=0.4e6)), 2e-3), Outline(np.full(2, np.inf))
    >>> at, share = feet.of(np.array([50.0, 50.0]), ball, 0.5, np.zeros(2))
    >>> hertz = (0.75 * 0.5 * 20e-3 / (0.4e6 / 0.75)) ** (1 / 3)
    >>> round(float(share.sum()), 9), round(float(np.sqrt(share @ (at**2).sum(axis=1)) / hertz / np.sqrt(0.4)), 2)
    (1.0, 1.0)
    """

    def __init__(self, skin: Skin, depth: float) -> None:
        self.skin, self._wide, self._kept = skin, _WIDE * depth, Prepared(_KEPT)
        self._free = skin.thickness == np.inf and len(skin.materials) == 1

    def of(
        self, curvature: FloatArray, outline: Outline, force: float, centre: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Points (m, 2) [m] and shares of the force (m,), whose mean is at the `centre`.

        Parameters
        ----------
        curvature : ndarray, shape (2,)
            Along y and z [1/m], >= 0.
        outline : Outline
            Finite along an axis without curvature. It does not matter where a contact stays within it.
        force : float
            Normal force [N], > 0.
        centre : ndarray, shape (2,)
            Centre of pressure [m]; a body that is curved along an axis, and does not end there, rolls to it.
        """
        try:
            return self._of(curvature, outline, force, centre)
        except SubskinError:  # what no press reaches, such as a corner on a corner: a face of the same size
            return self._at(np.zeros(2), Outline(outline.half), force, centre)

    def _of(
        self, curvature: FloatArray, outline: Outline, force: float, centre: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        rolls = curvature > 0
        wide = self._reach(curvature, outline.half, force) / outline.half.max() if rolls.any() else 0.0
        if wide > _FLATTENED:
            curvature = np.zeros(2)
        elif rolls.any():  # as if it did not end where it is curved
            half, middle = outline.half, np.zeros(2)
            if not rolls.all():
                half, middle = _chord(outline, centre, int(np.argmin(rolls)))
            at, share = self._at(curvature, Outline(np.where(rolls, np.inf, half)), force, centre - middle)
            at += middle
            if _within(outline, centre, np.maximum(at.max(axis=0) - centre, centre - at.min(axis=0)), rolls):
                return at, share
        return self._at(curvature, outline, force, centre)

    def _reach(self, curvature: FloatArray, half: FloatArray, force: float) -> float:
        """About how far a curved body would touch if it did not end [m], by Hertz."""
        stiff = self.skin.materials[0].plane_strain_modulus
        if curvature.all():
            return float((0.75 * force / stiff / np.sqrt(curvature.prod())) ** (1 / 3))
        return float(np.sqrt(2 * force / half[int(np.argmin(curvature))] / (np.pi * stiff * curvature.max())))

    def _at(
        self, curvature: FloatArray, outline: Outline, force: float, centre: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """As `of`, where it ends where the outline says."""
        # two numbers at a time: arrays of two take longer
        own, ends = outline.half.tolist(), [each < np.inf for each in outline.half.tolist()]
        curved = float(curvature.max())
        ratio = [_stepped(k / curved, _SHAPES) for k in curvature.tolist()] if curved > 0 else [0.0, 0.0]
        half, scale = self._lengths(own)
        load = force * _CURVED / curved / (scale[0] * scale[1]) ** 1.5 if curved > 0 else 1.0
        level = 1.0 if curved == 0 or (self._free and not any(ends)) else _stepped(load, _LEVELS)
        corners = None if outline.corners is None else np.round(outline.corners / outline.half / _CORNERS) * _CORNERS
        to = [min(max(c / h, -_RIM), _RIM) if e else 0.0 for c, h, e in zip(centre.tolist(), own, ends, strict=True)]
        longest = max((h for h, e in zip(own, ends, strict=True) if e), default=0.0)
        points = _MANY if longest > self._wide or (any(ratio) and any(ends)) else _FEW
        at, share = self._leaned(ratio, half, corners, level, to, points)
        if curved > 0:  # what does not end grows with the load: as N^(1/3), across a cylinder as N^(1/2)
            grows = (load / level) ** (1 / 3 if all(ratio) else 0.5)
            scale = [by if e else by * grows for by, e in zip(scale, ends, strict=True)]
        at = at * np.array(scale)
        at += centre - share @ at
        return at, share

    def _lengths(self, half: list[float]) -> tuple[list[float], list[float]]:
        """Half lengths at which is pressed, and by what lengths of the press are multiplied for the real ones."""
        finite = [each for each in half if each < np.inf]
        if not finite:
            return half, [1.0, 1.0]
        largest = max(finite)
        pressed_largest = _UNIT if self._free else _stepped(largest, _SHAPES)
        pressed = [_stepped(each / largest, _SHAPES) * pressed_largest for each in half]
        open_ = largest / _UNIT if self._free else 1.0
        return pressed, [h / p if h < np.inf else open_ for h, p in zip(half, pressed, strict=True)]

    def _leaned(
        self,
        ratio: list[float],
        half: list[float],
        corners: FloatArray | None,
        level: float,
        to: list[float],
        points: int,
    ) -> tuple[FloatArray, FloatArray]:
        """Points and shares of a press whose centre lies at `to`, in half lengths, as nearly as it may."""
        shape = (points, *ratio, *half, None if corners is None else corners.tobytes())
        if not any(ratio):
            at, even, y, z = self._kept.get(("flat", *shape), lambda: self._flat(_foot(ratio, half, corners), points))
            share = even + to[0] * y + to[1] * z
            if share.min() >= 0:
                return at, share
        step = _LEANS[any(ratio)]
        steps = [round(each / step) * step for each in to]
        press = partial(self._pressed, to=np.array(steps), force=level, points=points)
        at, share = self._kept.get((level, *steps, *shape), lambda: press(_foot(ratio, half, corners)))
        # what the steps leave: a pressure that leans by a little
        axes = [i for i in (0, 1) if half[i] < np.inf]
        if not axes:
            return at, share
        middle = share @ at
        away = (at - middle)[:, axes]
        missing = np.array([to[i] * half[i] - middle[i] for i in axes])
        least = np.diag([(_LEAST * half[i]) ** 2 for i in axes])
        lean = 1.0 + away @ np.linalg.solve((share * away.T) @ away + least, missing)
        return at, share * lean if lean.min() >= 0.0 else share

    def _flat(self, foot: Foot, points: int) -> tuple[FloatArray, ...]:
        """Of a flat face the points, the shares when pressed evenly, and by how much they change as it leans."""
        even, *leaned = (self._maps(foot, 1.0, _LEAN * each, _FINEST, points) for each in (np.zeros(2), *np.eye(2)))
        touched = even[0] > 0
        share, *rest = (each[touched] for each in (even[0], *((each[0] - even[0]) / _LEAN for each in leaned)))
        return np.moveaxis(even[1:], 0, -1)[touched] / share[:, None], share, *rest

    def _pressed(self, foot: Foot, force: float, to: FloatArray, points: int) -> tuple[FloatArray, FloatArray]:
        """Points and shares beneath a foot with its centre of pressure at `to`, in half lengths."""
        maps = self._maps(foot, force, to, _FINE if foot.curvature.any() else _FINEST, points)
        touched = maps[0] > 0
        share = maps[0][touched]
        at = np.moveaxis(maps[1:], 0, -1)[touched] / share[:, None]
        if len(at) < _FEWEST:  # one point holds no torsion
            around = _THIN * foot.outline.half.min() * np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
            at, share = (at[:, None] + around).reshape(-1, 2), np.repeat(share / len(around), len(around))
        return at, share

    def _stretched(self, foot: Foot, nodes: FloatArray, axis: int) -> FloatArray:
        """Nodes of the grid along an axis, so that their cells end where the foot does: by up to half a step."""
        half, step = foot.outline.half[axis], nodes[1] - nodes[0]
        last = np.abs(nodes[np.abs(nodes) <= half]).max(initial=0.0)
        if foot.outline.corners is not None or half == np.inf or half - last >= step:  # the contact ends before
            return nodes
        return np.asarray(nodes * (half / (last + 0.5 * step)))

    def _maps(self, foot: Foot, force: float, to: FloatArray, nodes: int, points: int) -> FloatArray:
        """The share of the force of each point, and its first moments along y and z, shape (3, points, points)."""
        half = np.where(np.isfinite(foot.outline.half), foot.outline.half, 0.0)
        for _ in range(_TRIES):
            try:
                moment = tuple(force * to * half) if to.any() else None
                pressed = press(self.skin, foot, force=force, moment=moment, nodes=nodes, max_strain=None)
                break
            except SubskinError:
                if not to.any():
                    raise
                to = to * _SHORTER
        else:
            pressed = press(self.skin, foot, force=force, nodes=nodes, max_strain=None)
        share, by = pressed.pressure / pressed.pressure.sum(), nodes // points
        y, z = self._stretched(foot, pressed.y, 0), self._stretched(foot, pressed.z, 1)
        maps = np.stack([share, share * y[:, None], share * z])
        wide = np.pad(maps, [(0, 0), *((0, -n % by) for n in share.shape)])
        n, m = wide.shape[1] // by, wide.shape[2] // by
        return np.asarray(wide.reshape(3, n, by, m, by).sum(axis=(2, 4)))


def _foot(ratio: list[float], half: list[float], corners: FloatArray | None) -> Foot:
    """What is pressed; corners in half lengths."""
    sides = np.array(half)
    return Foot(_CURVED * np.array(ratio), Outline(sides, None if corners is None else corners * sides))


def _chord(outline: Outline, centre: FloatArray, axis: int) -> tuple[FloatArray, FloatArray]:
    """Half lengths: along an axis of the stretch of an outline across the centre; and the middle of that."""
    half, corners = outline
    middle = np.zeros(2)
    if corners is not None:
        low, high = (np.r_[each, each] for each in (corners, np.roll(corners, -1, axis=0)))
        away = low[:, 1 - axis] - centre[1 - axis], high[:, 1 - axis] - centre[1 - axis]
        crossed = away[0] * away[1] < 0
        if crossed.any():
            share = away[0][crossed] / (away[0] - away[1])[crossed]
            ends = low[crossed, axis] + share * (high - low)[crossed, axis]
            middle[axis] = 0.5 * (ends.min() + ends.max())
            half = np.where(np.arange(2) == axis, max(0.5 * np.ptp(ends), _THIN * half.max()), half)
    return half, middle


def _within(outline: Outline, centre: FloatArray, extent: FloatArray, axes: npt.NDArray[np.bool_]) -> bool:
    """Whether an ellipse about the centre stays within the outline, or within its sides across some axes."""
    if outline.corners is None or not axes.all():
        return bool((np.abs(centre) + extent <= outline.half)[axes].all())
    start, side = outline.corners, np.roll(outline.corners, -1, axis=0) - outline.corners
    inward = np.stack([-side[:, 1], side[:, 0]], axis=-1)
    return bool((((centre - start) * inward).sum(axis=1) >= np.hypot(*(inward * extent).T)).all())


def _stepped(value: float, step: float) -> float:
    """The nearest of values whose logarithms are equal steps apart; 0 and infinity stay."""
    return math.exp(round(math.log(value) / step) * step) if 0 < value < np.inf else value


def principal(curvature: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, Outline]:
    """Middle (2,), axes (2, 2), rows, curvatures along these, and the outline about the middle.

    Parameters
    ----------
    curvature : ndarray, shape (2, 2)
        Symmetric [1/m].
    corners : ndarray, shape (k, 2)
        Of a convex polygon, in order [m].

    Examples
    --------
    >>> square = np.array([(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)])
    >>> _, _, _, outline = principal(np.zeros((2, 2)), square)
    >>> outline.half.round(3).tolist(), outline.corners
    ([0.707, 0.707], None)
    """
    values, vectors = np.linalg.eigh(curvature)
    sides = np.roll(corners, -1, axis=0) - corners
    if values[1] - values[0] > _SHAPES * values[1]:
        values = np.where(values < _STRAIGHT * values[1], 0.0, values)
        axes = vectors.T
    else:  # along its longest side
        along = sides[np.argmax(np.hypot(*sides.T))]
        along = along / np.hypot(*along)
        axes, values = np.array([along, (-along[1], along[0])]), np.full(2, values.mean())
    if np.linalg.det(axes) < 0:
        axes[1] = -axes[1]
    own = corners @ axes.T
    low, high = own.min(axis=0), own.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = np.maximum(half, _THIN * half.max())
    y, z = (own - middle).T
    area = 0.5 * (y * np.roll(z, -1) - z * np.roll(y, -1)).sum()
    rectangle = half.min() <= _THIN * half.max() or abs(area) > (1 - _SQUARE) * 4 * half.prod()
    kept = None if rectangle else (own - middle)[:: 1 if area > 0 else -1]
    return middle @ axes, axes, values, Outline(half, kept)
