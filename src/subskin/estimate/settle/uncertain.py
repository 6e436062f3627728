"""What is not known of a finger and of a touch's size, made ready for the loop that settles (`frames.py`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...finger import Finger
from ...response import Response
from ...tolerances import Tolerances
from ..answer import Status
from ..layout import Layout
from .given import Errors, SettledColumns, Settling, Variants

__all__ = ["POWERS", "SQUARES", "WITHOUT", "Uncertain", "deeper_than", "fill_settled", "in_doubt", "other_than"]

WITHOUT = "a file without [tolerances], or replace(finger, tolerances=None)"
"""What to do where tolerances are not counted."""
SQUARES = np.array([0.15, 0.4, 0.7, 1.0])
"""Squares of the half widths at which readings are compared, in those of the largest."""
POWERS = np.linalg.inv(SQUARES[:, None] ** (1 + np.arange(SQUARES.size)))
"""Of what these add to readings, for each power of the square."""
_NODES, _AREA_NODES, _SHIFT = 41, 9, 1e-4
"""Positions between the sensors at which errors are compared, on a row and along each side of an area; and the shift by
which slopes are told [depths]."""
_NOTHING = 0.05
"""Doubts less than this, of the noise, change no standard error by more than about a thousandth."""


@dataclass(frozen=True, eq=False)
class Uncertain(Frozen):
    """How readings of a load change with what is not known.

    Parameters
    ----------
    tolerances : Tolerances
        Of the finger.
    lay : callable
        From responses, noise and which is which to `Variants`.
    base : RadialResponse or Response
        Of the finger as drawn; the others cover the same positions.
    ratios : (float, float)
        How far Poisson's ratio may be off, in its deviations.
    deeper : RadialResponse or Response or None
        Of sensors that are all one deviation deeper, or all less deep, where depths are not known.
    other : RadialResponse or Response or None
        What Poisson's ratio changes, one deviation off, where it is not known.
    sizes : tuple of RadialResponse or Response
        What a touch of half width a adds, in powers of (a / widest)^2; none where touches have no size.
    widest : float
        The largest half width of a touch [m].
    aside : float
        Of point loads beside a row, whose second coordinate is z^2 / aside: the largest distance [m]; else 0.
    """

    tolerances: Tolerances
    lay: Callable[[list[Any], FloatArray, dict[str, int]], Variants]
    base: Any
    ratios: tuple[float, float]
    deeper: Any
    other: Any
    sizes: tuple[Any, ...]
    widest: float
    aside: float = 0.0

    def to_settle(
        self,
        array: SensorArray,
        pattern: npt.NDArray[np.bool_],
        layout: Layout | SettledColumns,
        nodes: FloatArray,
        **told: Any,
    ) -> tuple[Any, ...]:
        """Arguments of the loop that settles, for the sensors of `pattern`, which are `array`.

        Another load is looked for at `nodes` (nodes, P); `told` has the thresholds of `Settling` that are not made
        here.
        """
        noise, depth = np.asarray(array.noise), np.asarray(array.depth)
        every, at = [self.base], {}
        for name in ("deeper", "other"):
            one = getattr(self, name)
            at[name] = len(every) if one is not None else -1
            every += [one] if one is not None else []
        at["sizes"] = len(every) if self.sizes else -1
        every = [one.select(pattern) for one in (*every, *self.sizes)]
        variants = self.lay(every, noise, at)
        tolerances, n = self.tolerances, len(pattern)
        gain, moved, drift = (tolerances.of(k, n)[pattern] for k in ("gain", "position", "offset"))
        errors = Errors(
            still=np.hypot(tolerances.noise, drift / noise), gain=np.array(gain), position=moved * depth,
            own=float(np.sqrt(1 - tolerances.common)), common=float(np.sqrt(tolerances.common)),
            ratios=np.array(self.ratios),
        )  # fmt: skip
        read = [self._reads(one, noise) for one in every]
        share, sized = self._shares(read, at, errors, array)
        columns = SettledColumns(*(getattr(layout, name) for name in SettledColumns._fields))
        fields = np.ascontiguousarray(read[0](nodes).swapaxes(1, 2))
        settling = Settling(
            widest=self.widest, longest=0.5 * float(depth.min()), level=float((errors.still**2).mean()), share=share,
            share_sized=sized, columns=columns, aside=self.aside, forces=fields.shape[1], **told,
        )  # fmt: skip
        return variants, errors, settling, nodes, fields

    def _shares(
        self, read: list[Callable[[FloatArray], FloatArray]], at: dict[str, int], errors: Errors, array: SensorArray
    ) -> list[float]:
        """Mean squares of what errors change, of the largest reading squared: without a size, and with the largest."""
        points = array.points if array.on_area else np.asarray(array.y)[:, None]
        sides = np.linspace(points.min(axis=0), points.max(axis=0), _AREA_NODES if array.on_area else _NODES).T
        grid = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, len(sides))
        grid = np.pad(grid, ((0, 0), (0, int(self.aside > 0))))  # on the row
        normal = [one(grid)[..., 0] for one in read]
        power = normal[0] ** 2
        change = errors.gain**2 * power
        shift = _SHIFT * float(np.asarray(array.depth).min())
        for step in shift * np.eye(len(sides), grid.shape[-1]):
            slope = (read[0](grid + step) - read[0](grid - step))[..., 0] / (2 * shift)
            change = change + (errors.position * slope) ** 2
        if at["deeper"] >= 0:
            change = change + (normal[at["deeper"]] - normal[0]) ** 2
        if at["other"] >= 0:
            change = change + normal[at["other"]] ** 2
        wider = sum(normal[at["sizes"] :]) ** 2 if at["sizes"] >= 0 else 0.0
        shares = [each.mean(axis=-1) for each in (change, change + wider)]
        return [float((share / power.max(axis=-1)).mean()) for share in shares]

    def _reads(self, one: Any, noise: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Readings (..., n, F) under unit forces at positions (..., P), in units of the noise."""
        if isinstance(one, Response):
            return lambda at: one(at[..., 0]) / noise[:, None]
        if self.aside:
            return lambda at: one(self._points(at))[..., :2] / noise[:, None]
        return lambda at: np.asarray(one(at)) / noise[:, None]

    def _points(self, at: FloatArray) -> FloatArray:
        """Points (y, z) beside a row."""
        return np.stack([at[..., 0], np.sqrt(at[..., 1] * self.aside)], axis=-1)


def deeper_than(finger: Finger) -> Finger | None:
    """The finger with its sensors one deviation deeper, or less deep where the skin ends; None if depths are known."""
    assert finger.tolerances is not None
    depth, step = np.asarray(finger.array.depth), finger.tolerances.of("depth", len(finger.array))
    if not np.any(step):
        return None
    if (depth * (1 + step)).max() > finger.skin.thickness:
        step = -step
    return replace(finger, array=replace(finger.array, depth=depth * (1 + step)))


def other_than(finger: Finger) -> tuple[Finger | None, tuple[float, float]]:
    """The finger with a Poisson's ratio one deviation off, and how many of these it may be off; None if it is known.

    Ratios are between 0 and 1/2, so that one of two materials may stop there.
    """
    assert finger.tolerances is not None
    change = finger.tolerances.poisson
    if not change:
        return None, (0.0, 0.0)
    ratios = [material.poisson for material in finger.skin.materials]
    change *= -1.0 if min(ratios) >= change else 1.0
    ends = sorted(((0.0 - min(ratios)) / change, (0.5 - max(ratios)) / change))
    less = [replace(m, poisson=min(m.poisson + change, 0.5)) for m in finger.skin.materials]
    return replace(finger, skin=finger.skin.with_(materials=less)), (ends[0], ends[1])


def in_doubt(doubt: FloatArray, noise: FloatArray) -> npt.NDArray[np.bool_]:
    """Frames whose readings have doubts (f, n) that matter, beside the noise (n,)."""
    return np.asarray((doubt > _NOTHING * noise).any(axis=-1))


def fill_settled(
    loop: Any, frames: FloatArray, arrays: Sequence[Any], sized: bool, out: FloatArray, doubt: FloatArray | None = None
) -> None:
    """What a loop finds in frames, settled; where that explains nothing and touches may have a size, again with one.

    arrays: its arguments between the frames and `out`, then those of the loop that settles; doubt (f, n): standard
    deviations of single readings beside all others [reading].
    """
    status = arrays[-1][2].columns.status
    doubt = np.empty((0, frames.shape[1])) if doubt is None else np.ascontiguousarray(doubt)
    _settled(loop, frames, doubt, arrays, False, out)
    again = np.flatnonzero(out[:, status] == Status.UNEXPLAINED) if sized else np.empty(0, dtype=np.intp)
    if again.size:
        part = np.empty((again.size, out.shape[1]))
        some = doubt[again] if len(doubt) else doubt
        _settled(loop, np.ascontiguousarray(frames[again]), some, arrays, True, part)
        taken = np.isin(part[:, status], (Status.OK, Status.AMBIGUOUS))
        out[again[taken]] = part[taken]


def _settled(
    loop: Any, frames: FloatArray, doubt: FloatArray, arrays: Sequence[Any], sized: bool, out: FloatArray
) -> None:
    """A loop over frames as if the noise were that of all errors; then each settled by these."""
    from .frames import scaled_frames, settle_frames

    given, scale, scaled = arrays[-1], np.empty(len(frames)), np.empty_like(frames)
    scaled_frames(frames, doubt, arrays[0], given[2], sized, scale, scaled)
    loop(scaled, *arrays[:-1], out)
    settle_frames(frames, doubt, arrays[0], given, scale, sized, out)
