"""What is not known of a finger and of a touch's size, made ready for the loop that settles (`settle.py`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ..._frozen import Frozen
from ...array import SensorArray
from ...contact import RoundHertz
from ...finger import Finger
from ...radial import RadialResponse, tabulate_radial
from ...radial_round import tabulate_round
from ...tolerances import Tolerances
from ..estimate import Status
from ..layout import SIZED
from ..settle import Errors
from .judge import Settings
from .point import laid_out
from .variants import Settling, Variants

__all__ = ["Uncertain", "fill_settled"]

_STEP = 0.05
"""By how much sensors are deeper, and Poisson's ratio is less, where readings are compared."""
_SQUARES = np.array([0.15, 0.4, 0.7, 1.0])
"""Squares of the half widths at which readings are compared, in those of the largest."""


@dataclass(frozen=True, eq=False)
class Uncertain(Frozen):
    """How readings of a point load change with what is not known.

    Parameters
    ----------
    tolerances : Tolerances
        Of the finger.
    step : float
        By how much deeper sensors are those of `deeper` [depths].
    deeper : RadialResponse or None
        Of the same sensors deeper in the skin, where depths are not known.
    other : RadialResponse or None
        What another Poisson's ratio changes, .05 off, where it is not known.
    sizes : tuple of RadialResponse
        What a touch of half width a adds, in powers of (a / widest)^2; none where touches are points.
    widest : float
        The largest half width of a touch [m].
    """

    tolerances: Tolerances
    step: float
    deeper: RadialResponse | None
    other: RadialResponse | None
    sizes: tuple[RadialResponse, ...]
    widest: float

    @classmethod
    def of(cls, finger: Finger, response: RadialResponse, reach: float, *, sized: bool) -> Uncertain | None:
        """That of a finger whose `response` reaches so far; None where the finger is exact."""
        told, array = finger.tolerances, finger.array
        if told is None:
            return None
        depth, step = np.asarray(array.depth), _STEP
        deeper: RadialResponse | None = None
        other: RadialResponse | None = None
        sizes: tuple[RadialResponse, ...] = ()
        if np.any(told.depth):
            if float(depth.max()) * (1 + step) > finger.skin.thickness:
                step = -_STEP
            made = replace(finger, array=replace(array, depth=depth * (1 + step)))
            deeper = tabulate_radial(made, reach * (1 + step))
        if told.poisson:
            ratios = [material.poisson for material in finger.skin.materials]
            change = -_STEP if min(ratios) >= _STEP else _STEP
            less = [replace(m, poisson=min(m.poisson + change, 0.5)) for m in finger.skin.materials]
            there = tabulate_radial(replace(finger, skin=finger.skin.with_(materials=less)), reach)
            other = _difference(response, [(1.0, there)])
        widest = float(depth.min())
        if sized:
            table = tabulate_round(finger, RoundHertz, reach, 1.5 * widest)
            wider = [table.at(float(np.sqrt(q)) * widest) for q in _SQUARES]
            powers = np.linalg.inv(_SQUARES[:, None] ** (1 + np.arange(_SQUARES.size)))
            sizes = tuple(_difference(response, list(zip(row, wider, strict=True))) for row in powers)
        return cls(told, step, deeper, other, sizes, widest)

    def to_settle(
        self, response: RadialResponse, array: SensorArray, pattern: npt.NDArray[np.bool_], settings: Settings,
        beyond: float, nodes: FloatArray, step: float,
    ) -> tuple[Any, ...]:  # fmt: skip
        """Arguments of the loop that settles, for the sensors of `pattern`, whose are `response` and `array`.

        Another load is looked for on a grid of so long steps in the search and, at `nodes` (nodes, 2), as far beyond.
        """
        y, z = (np.arange(low, high + 0.5 * step, step) for low, high in settings.box.reshape(2, 2))
        nodes = np.concatenate([np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2), nodes])
        variants, errors, (share, share_sized) = self.prepared(response, array, pattern)
        told = Settling(
            friction=settings.limits.friction, largest=settings.largest, ambiguity=settings.ambiguity,
            apart=settings.apart, widest=self.widest, box=settings.box,
            beyond=settings.box + beyond * np.array([-1.0, 1.0, -1.0, 1.0]),
            longest=0.5 * float(np.asarray(array.depth).min()), level=float((errors.still**2).mean()), share=share,
            share_sized=share_sized,
        )  # fmt: skip
        fields = np.ascontiguousarray((response(nodes) / np.asarray(array.noise)[:, None]).swapaxes(1, 2))
        return variants, errors, told, nodes, fields

    def prepared(
        self, response: RadialResponse, array: SensorArray, pattern: npt.NDArray[np.bool_]
    ) -> tuple[Variants, Errors, FloatArray]:
        """What the loop goes by, for the sensors of `pattern`; and the squared errors of a unit force, as `shares`.

        `response` and `array` are those of these sensors.
        """
        every, at = [response], {}
        for name in ("deeper", "other"):
            one = getattr(self, name)
            at[name] = len(every) if one is not None else -1
            every += [one.select(pattern)] if one is not None else []
        at["sizes"] = len(every) if self.sizes else -1
        every += [one.select(pattern) for one in self.sizes]
        alone = len(response.coefficients) == len(array)  # a table for each sensor
        every = [_alone(one.separate()) if alone else one for one in every]
        pairs = all(one.pair is not None for one in every)
        noise, depth = np.asarray(array.noise), np.asarray(array.depth)
        made = [laid_out(one, one.cubics()[0], pairs) for one in every]
        numbers = max(table.shape[1] for table, _, _ in made)
        most = max(len(terms) for _, terms, _ in made)
        table = np.stack([np.pad(table, ((0, 0), (0, numbers - table.shape[1]))) for table, _, _ in made])
        terms = np.stack([np.pad(terms, ((0, most - len(terms)), (0, 0))) for _, terms, _ in made]).astype(np.int64)
        sensors = np.stack([np.stack([*one.points.T, one.depth**-2.0, one.gain / noise]) for one in every])
        cells = made[0][2]
        first = np.append(response.kind * cells, cells - 1).astype(np.int64)
        variants = Variants(np.ascontiguousarray(sensors), np.ascontiguousarray(table), first, terms, **at)
        told, n = self.tolerances, len(pattern)
        gain, deep, moved, drift = (told.of(name, n)[pattern] for name in ("gain", "depth", "position", "offset"))
        errors = Errors(
            still=np.hypot(told.noise, drift / noise), gain=np.array(gain), depth=deep / abs(self.step),
            position=moved * depth, own=float(np.sqrt(1 - told.common)), common=float(np.sqrt(told.common)),
            poisson=told.poisson / _STEP,
        )  # fmt: skip
        return variants, errors, self._shares(every, at, errors, noise, array)

    @staticmethod
    def _shares(
        every: list[RadialResponse], at: dict[str, int], errors: Errors, noise: FloatArray, array: SensorArray
    ) -> FloatArray:
        """Mean squares of what errors change, of the largest reading squared: without a size, and with the largest.

        Each reading counts by its square: the strong ones are those that errors change.
        """
        ends = np.stack([array.points.min(axis=0), array.points.max(axis=0)])
        grid = np.stack(np.meshgrid(*np.linspace(ends[0], ends[1], 9).T, indexing="ij"), axis=-1).reshape(-1, 2)
        read = [one(grid)[..., 0] / noise for one in every]
        power = read[0] ** 2
        change = errors.gain**2 * power
        change = change + errors.position**2 * ((every[0].slopes(grid)[..., 0, :] / noise[:, None]) ** 2).sum(axis=-1)
        if at["deeper"] >= 0:
            change = change + (errors.depth * (read[at["deeper"]] - read[0])) ** 2
        if at["other"] >= 0:
            change = change + (errors.poisson * read[at["other"]]) ** 2
        wider = sum(read[at["sizes"] :]) ** 2 if at["sizes"] >= 0 else 0.0
        shares = [each.mean(axis=-1) for each in (change, change + wider)]
        return np.array([float((share / power.max(axis=-1)).mean()) for share in shares])


def fill_settled(loop: Any, frames: FloatArray, arrays: Sequence[Any], sized: bool, out: FloatArray) -> None:
    """What a loop finds in frames, settled; where that explains nothing and touches may have a size, again with one.

    arrays: its arguments between the frames and `out`, then those of the loop that settles.
    """
    status = SIZED.status
    _settled(loop, frames, arrays, False, out)
    again = np.flatnonzero(out[:, status] == Status.UNEXPLAINED) if sized else np.empty(0, dtype=np.intp)
    if again.size:
        part = np.empty((again.size, out.shape[1]))
        _settled(loop, np.ascontiguousarray(frames[again]), arrays, True, part)
        taken = np.isin(part[:, status], (Status.OK, Status.AMBIGUOUS))
        out[again[taken]] = part[taken]


def _settled(loop: Any, frames: FloatArray, arrays: Sequence[Any], sized: bool, out: FloatArray) -> None:
    """A loop over frames as if the noise were that of all errors; then each settled by these."""
    from .settle import scaled_frames, settle_frames

    settling, scale, scaled = arrays[-1], np.empty(len(frames)), np.empty_like(frames)
    scaled_frames(frames, arrays[0], settling[2], sized, scale, scaled)
    loop(scaled, *arrays[:-1], out)
    settle_frames(frames, arrays[0], *settling, scale, sized, out)


def _alone(one: RadialResponse) -> RadialResponse:
    """The same response with a table for each sensor."""
    return replace(one, kind=np.arange(one.sensors), coefficients=np.ascontiguousarray(one.coefficients[one.kind]))


def _difference(base: RadialResponse, parts: list[tuple[float, RadialResponse]]) -> RadialResponse:
    """Sums of so much of responses less that of `base`, as a response of its own."""
    if all(np.array_equal(one.terms, base.terms) for _, one in parts):
        total = sum(share * (one.coefficients - base.coefficients) for share, one in parts)
        return replace(base, coefficients=np.ascontiguousarray(total), lift=0.0)
    every = [(-sum(share for share, _ in parts), base), *parts]
    terms, tables, count = [], [], 0
    for share, one in every:
        terms.append(one.terms + np.array([0, 0, 0, count, 0]))
        tables.append(share * one.coefficients)
        count += one.coefficients.shape[2]
    return replace(base, terms=np.concatenate(terms), coefficients=np.concatenate(tables, axis=2), lift=0.0)
