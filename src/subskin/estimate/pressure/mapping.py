"""What a mapper of the pressure is told, works out once for the sensors that can be used, and keeps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from ... import _check
from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ...prepared import Prepared
from ..frames import Framewise, sensor_rows
from ._operator import Factors, shear_seen
from .columns import STATUS, WIDTH
from .hats import Hats
from .surface import Surface

__all__ = ["RULES", "SHEARS", "SurfaceMapper", "known"]

RULES = ("evidence", "discrepancy", "gcv")
"""Rules for the weight of smoothness."""

SHEARS = ("none", "proportional", "free")
"""What the shear may be."""

_ROOM = 256
"""Elements in the factor for which there is room at first."""

_STRIPS = (0.75, 1.5, 3.0)
"""Widths of the even strips along a row from which the search for the angle starts, in depths."""

_LEAST_SEEN, _ABOVE = (0.2, 0.25), (1e3, 100.0)
"""Share of the drag that has to be seen for it to be free, in readings so many times above the noise; row and area.

Areas that saw 0.28 or more gave images within their band, of 0.18 or less some that were wrong and sure (docs).
"""

_NEAR = (0.01, 0.05)
"""Where the search for the drag ends, in its standard deviations, along a row and on an area."""


class _Ready(NamedTuple):
    """All that is worked out once for the sensors that can be used: fields of what the compiled loop takes."""

    task: tuple[Any, ...]
    coarse: tuple[Any, ...]
    fine: tuple[Any, ...]
    nodes: tuple[Any, ...]
    idle: list[tuple[Any, ...]]  # what it fills, kept from call to call; each thread takes its own


class _Leans(Sequence[Factors]):
    """The factors at each drag, made when asked for."""

    def __init__(self, make: Callable[[int], Factors], count: int) -> None:
        self._make, self._count = make, count
        self._made: dict[int, Factors] = {}

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Factors: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Factors]: ...
    def __getitem__(self, index: int | slice) -> Factors | Sequence[Factors]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self._count))]
        if index not in self._made:
            self._made[index] = self._make(index)
        return self._made[index]


class SurfaceMapper(Framewise):
    """A mapper of the pressure, along a row or on an area.

    Parameters
    ----------
    finger : Finger
        The skin and the sensors in it.
    search, step, shear, friction, rule, least_force, false_alarm
        As in `PressureMapper` and `ImageMapper`.
    """

    def __init__(
        self,
        finger: Finger,
        *,
        search: Any = None,
        step: float | None = None,
        shear: str = "proportional",
        friction: float = 1.0,
        rule: str = "evidence",
        least_force: float = 0.3,
        false_alarm: float = 1e-6,
    ) -> None:
        known(shear, rule)
        self.finger, self.shear, self.rule = finger, shear, rule
        self._surface = Surface.of(finger, search, step)
        self.y = self._surface.y
        self._drags, prior = self._surface.drags, self._surface.prior
        self.friction = _check.scalar("friction", friction, above=0.0, fix='shear="none" for presses without a drag')
        self.least_force = _check.scalar("least_force", least_force, at_least=0.0)
        self._false_alarm = _check.scalar("false_alarm", false_alarm, above=0.0, at_most=0.5)
        heights = 1 + self._drags if shear == "free" else 1
        super().__init__(
            finger.array, needed=3 + self._drags * (shear != "none"),
            columns=WIDTH + heights * prior.shape[0] * prior.shape[1], status=STATUS,
        )  # fmt: skip
        self._factors = Prepared(64)
        if shear == "free" and not self.shear_seen >= self._least_seen:
            row = self._drags == 1
            needed = "y, not two" if row else "(y, z), not three"
            other = "sensors of another kind or depth as well" if row else "three channels a position"
            raise InvalidValueError(
                f'shear = "free" for sensors that see {self.shear_seen:.2f} of the shear beside an unknown pressure',
                f"at least {self._least_seen} is needed: sensors of one kind and depth read one function of {needed}",
                f'shear="proportional", or {other}',
            )
        self.allow_for(finger, self.friction)

    @property
    def _least_seen(self) -> float:
        return _LEAST_SEEN[self._drags - 1]

    @property
    def shear_seen(self) -> float:
        """Share of the drag's components that are seen beside an unknown pressure; of two directions the less.

        It holds for readings a thousand times above the noise along a row, where shear="free" needs 0.2, and a hundred
        times on an area, where it needs 0.25.
        """
        return self._factors.get("shear_seen", self._share_seen)

    def _share_seen(self) -> float:
        hats = self._hats(self.finger.array.live)
        parts = [hats.columns(i) for i in range(1 + self._drags)]
        return shear_seen(*parts, prior=self._surface.prior, above=_ABOVE[self._drags - 1])

    @property
    def drags(self) -> FloatArray:
        """Tangents (ty, tz) at which the factors are known, shape (leans, 2); 0 alone where no angle is sought."""
        if self.shear != "proportional":
            return np.zeros((1, 2))
        if self._drags == 1:
            tangents = np.linspace(-1, 1, 17)
            return self.friction * np.stack([tangents, np.zeros(tangents.size)], axis=1)
        turns = np.pi / 4 * np.arange(8)
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        return self.friction * np.concatenate([np.zeros((1, 2)), 0.45 * circle, 0.9 * circle])

    @property
    def _scales(self) -> npt.NDArray[np.float64]:
        """Of pressure and drags that are free, by the friction."""
        return np.array([1.0, *(self._drags * (self.friction,))])

    def factors(self, used: npt.NDArray[np.bool_]) -> Sequence[Factors]:
        """The factors for the sensors `used` (n,), one for each of `drags`, made when asked for."""

        def make(lean: int) -> Factors:
            hats, prior = self._hats(used), self._surface.prior
            if self.shear == "free":
                return Factors.of([s * hats.columns(i) for i, s in enumerate(self._scales)], prior)
            t = (1.0, *self.drags[lean])
            return Factors.of([sum(share * hats.columns(i) for i, share in enumerate(t) if share)], prior)

        return self._factors.get(used.tobytes(), lambda: _Leans(make, len(self.drags)))

    def _hats(self, used: npt.NDArray[np.bool_]) -> Hats:
        """Whitened readings per Pa of the used sensors."""
        return self._surface.hats.select(used, 1 / np.asarray(self.finger.array.noise)[used])

    def _kernel(self) -> Any:
        return self._map_frames

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """What is worked out once for the sensors of `pattern`."""
        from ._elements import Level

        surface, hats, friction = self._surface, self._hats(pattern), self.friction
        prior, times, row = surface.prior, surface.coarse, surface.drags == 1
        free, pull = self.shear == "free", self._pull(hats)
        stencil, coarse = prior.stencil, prior.coarser(times).stencil
        scales: tuple[float, ...] = (1.0,)
        if free and row:  # squares of pressure and drag are twice those of what drags to either side
            hats, stencil, coarse = hats.to_either_side(friction), 2 * stencil, 2 * coarse
        elif free:
            scales = tuple(self._scales.tolist())
        elif self.shear == "proportional":
            scales = (1 + self._drags) * (1.0,)
        ready = _Ready(
            self._task(pattern),
            tuple(Level.of(hats.coarse(times), scales, coarse, times[0] * times[1] * pull, friction)),
            tuple(Level.of(hats, scales, stencil, pull, friction)),
            self._nodes(),
            [],
        )
        return (ready,)

    def _pull(self, hats: Hats) -> float:
        """What the least force costs an element."""
        return self.least_force * float(np.linalg.norm(hats.columns(0), axis=1).max())

    def _task(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """Fields of a `_task.Task`."""
        from scipy.special import chdtri

        prior, hats, row = self._surface.prior, self._hats(pattern), self._drags == 1
        count, n = 1 if self.shear == "none" else 1 + self._drags, int(pattern.sum())
        (wide_y, wide_z), (ny, nz) = self._surface.coarse, prior.shape
        at = (
            (np.arange(ny // wide_y)[:, None] * wide_y + wide_y - 1) * nz
            + np.arange(nz // wide_z) * wide_z
            + wide_z
            - 1
        )
        columns = [hats.columns(i) for i in range(count)]
        if self.shear == "free":
            columns = [scale * part for scale, part in zip(self._scales, columns, strict=True)]
        spread = [prior.applied(part) for part in columns]
        grams = np.array([[other.T @ wide for wide in spread] for other in columns])
        if self.shear == "free":
            squares, basis = _spectra(np.einsum("aank->nk", grams)[None])
        else:
            shares = np.concatenate([np.ones((len(self.drags), 1)), self.drags], axis=1)[:, :count]
            squares, basis = _spectra(np.einsum("ta,tb,abnk->tnk", shares, shares, grams))
        starts = np.stack([wide[at.reshape(-1)] for wide in spread])
        if self.shear == "free" and row:
            starts = np.concatenate([starts[0] + starts[1], starts[0] - starts[1]])[None]
        elif self.shear == "proportional" and not row:
            starts = starts[:1]  # the search begins at no drag
        strips, gauges = np.zeros((2, 0, n)), np.zeros((0, 3))
        if self.shear == "proportional" and row:
            depth = float(np.asarray(self.finger.array.depth).min())
            strips, gauges = _strips(np.stack(columns), np.array(_STRIPS) * depth / prior.area)
        size = np.float64 if row else np.float32  # a row's weight is exact
        return (
            sensor_rows(self.finger.array.select(pattern)), float(chdtri(n, self._false_alarm)), self.friction,
            _NEAR[self._drags - 1], RULES.index(self.rule), self.drags, basis.astype(size), squares,
            starts.astype(np.float32), strips, gauges,
        )  # fmt: skip

    def _nodes(self) -> tuple[Any, ...]:
        """Fields of a `_task.Nodes`."""
        surface, prior = self._surface, self._surface.prior
        (wide_y, wide_z), (ny, nz), row = surface.coarse, prior.shape, surface.drags == 1
        sides = 2 if row and self.shear == "free" else 1  # with all the drag that friction holds, to either side
        own = self.friction * np.array([[1.0], [-1.0]]) if sides == 2 else np.zeros((1, 1))
        y, z = (surface.y[None, 1:-1], surface.z[:, None]) if row else (surface.y[1:-1, None], surface.z[None, 1:-1])
        lines, along = np.arange(ny)[:, None], np.arange(nz)
        rim = np.minimum(along, nz - 1 - along) < wide_z
        if not row:
            rim = rim | (np.minimum(lines, ny - 1 - lines) < wide_y)
        shape = (sides * ny, nz)
        maps = (np.array(np.broadcast_to(part, shape)).reshape(-1) for part in (y, z, own, rim))
        return (*maps, prior.area, wide_y, wide_z, nz // wide_z, row)

    def _map_frames(self, readings: FloatArray, ready: _Ready, out: FloatArray) -> None:
        """Fill `out`, a row for each frame."""
        from ._kernel import map_frames

        *given, idle = ready
        try:
            works = idle.pop()
        except IndexError:
            works = self._works(ready, _ROOM)
        done = 0
        while (done := map_frames(done, readings, *given, *works[:2], out)) < len(readings):
            works = self._works(ready, 2 * works[2])
        idle.append(works)

    def _works(self, ready: _Ready, room: int) -> tuple[Any, ...]:
        """Works with room for so many elements in the factor, cones of a drag that is free on an area, and the room."""
        from ._cones import Cones
        from ._elements import Level, Work

        cones, n = self.shear == "free" and self._drags > 1, ready.task[7].shape[1]
        levels = Level(*ready.coarse), Level(*ready.fine)
        works = tuple(tuple(Work.of(level, n, room, 3 if cones else 1)) for level in levels)
        return works, tuple(Cones.of(levels[1])) if cones else None, room


def known(shear: str, rule: str) -> None:
    """Refuse a kind of shear or a rule of another name."""
    for name, value, names in (("shear", shear, SHEARS), ("rule", rule, RULES)):
        _check.choice(name, value, names)


def _spectra(grams: FloatArray) -> tuple[FloatArray, FloatArray]:
    """S^2 (T, n) and U^T (T, n, n) of symmetric matrices."""
    squares, vectors = np.linalg.eigh(0.5 * (grams + grams.transpose(0, 2, 1)))
    return np.maximum(squares, 0.0), np.ascontiguousarray(vectors.transpose(0, 2, 1))


def _strips(fields: FloatArray, widths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Readings of even pressures and drags (2, m, n) over `widths` elements at all positions, and their products."""
    sums = np.concatenate([np.zeros_like(fields[:, :1]), np.cumsum(fields, axis=1)], axis=1)
    counts = [1, *(w for w in np.rint(widths).astype(int) if 1 < w < sums.shape[1])]
    strips = np.ascontiguousarray(np.concatenate([(sums[:, w:] - sums[:, :-w])[:, ::2] for w in counts], axis=1))
    products = [np.einsum("mn,mn->m", strips[i], strips[k]) for i, k in ((0, 0), (0, 1), (1, 1))]
    return strips, np.stack(products, axis=1)
