"""Readings of sensors on an area -> an image of the pressure, and of the drag where the array can see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ..frames import sensor_rows
from . import columns as column
from ._operator import Factors, shear_seen
from .area_surface import AreaSurface
from .band import deviations
from .free_area import FreeArea
from .hats import COARSE, LANES, REGISTERS, Hats
from .image import PressureImage
from .levels import Level, level_of
from .mapping import RULES, SurfaceMapper, free_only_where_seen, known
from .prior import Membrane

__all__ = ["ImageMapper"]

_ROOM = 256
"""Elements > 0 for which there is room at first."""

_LEAST_SEEN, _ABOVE = 0.25, 100.0
"""Share of the drag that has to be seen for it to be free, in readings so many times above the noise.

Arrays that saw 0.28 or more gave images within their band, of 0.18 or less some that were wrong and sure (docs).
"""

_Work = tuple[npt.NDArray[Any], ...]


class _Prepared(NamedTuple):
    """All that is worked out once for the sensors that can be used."""

    sensors: FloatArray
    limits: FloatArray
    drags: FloatArray  # (leans, 2)
    basis: npt.NDArray[np.float32]  # U^T of each, (leans, n, n)
    squares: FloatArray  # S^2, (leans, n)
    spread: npt.NDArray[np.float32]  # C A^T of the pressure at the coarse nodes, (coarse m, n)
    coarse: Level
    fine: Level
    idle: list[tuple[_Work, _Work]]  # kept from call to call; each thread takes its own


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


class ImageMapper(SurfaceMapper):
    """Finds the pressure on an area in frames of readings; prepared once, then called on a frame or on many.

    As `PressureMapper`, in bilinear elements: the pressure p at their nodes is the one that minimises

        chi-square + weight * integral |grad p|^2 + 2 least_force * (normal force) / (its least standard deviation)

    over all p >= 0 that are 0 on the border of the search. The minimum is unique and found exactly (docs/pressure.md).

    Parameters
    ----------
    finger : Finger
        The skin, of any kind that takes local contacts, and the sensors on it.
    search : ((float, float), (float, float)), optional
        Ends of y and of z that are mapped [m]; about 1.5 depths beyond the outermost sensors if left out.
    step : float, optional
        Largest distance of the nodes [m]; if left out about a third of the shallowest sensor's depth, such that the
        sensors' distances are multiples of it.
    shear : {"proportional", "none", "free"}, optional
        Drag q = p tan(angle) in one unknown direction; none; or at every node its own, (q_y, q_z) with |q| <= friction
        * p, which asks for sensors of three kinds or directions at each position.
    friction : float, optional
        Bound of |q| / p [-]; of no account without shear.
    rule, least_force, false_alarm
        As in `PressureMapper`.

    Attributes
    ----------
    y, z : ndarray
        The nodes along y and along z [m], (ny,) and (nz,).

    Raises
    ------
    InvalidValueError
        An option out of range; shear "free" where the array cannot separate it from pressure; a sensor without noise;
        a finger that goes by a response measured in place.
    GeometryError
        More elements than can be solved for.
    NotLinearError
        A transducer without a linear part.

    Examples
    --------
    >>> import subskin as ss
    >>> array = ss.SensorArray.grid(shape=(6, 6), pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> mapper = ImageMapper(ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array), shear="none")
    >>> len(mapper.y), len(mapper.z)
    (25, 25)
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
        if finger.measured is not None:
            seen, rule = (
                "a finger with a response measured in place",
                "an image of the pressure goes by the skin's field",
            )
            raise InvalidValueError(seen, rule, "dataclasses.replace(finger, measured=None), if that field will do")
        self._surface = AreaSurface.of(finger, search, step)
        self.y, self.z = self._surface.y, self._surface.z
        prior = self._surface.prior
        super().__init__(
            finger, prior, drags=2, shear=shear, friction=friction, rule=rule,
            columns=column.AREA_WIDTH + (3 if shear == "free" else 1) * prior.shape[0] * prior.shape[1],
            least_force=least_force, false_alarm=false_alarm,
        )  # fmt: skip
        if shear == "free":
            free_only_where_seen(self.shear_seen, _LEAST_SEEN, "(y, z), not three", "three channels a position")
        self.allow_for(finger, self.friction)

    def __call__(self, readings: npt.ArrayLike) -> PressureImage:
        """The pressure in each frame.

        Parameters
        ----------
        readings : array_like, shape (..., n)
            As in `Locator`.

        Returns
        -------
        PressureImage
            Numbers of shape (...), and images of shape (..., ny, nz).

        Raises
        ------
        GeometryError
            A last axis that is not the number of sensors.
        """
        return PressureImage(*self._frames(readings), self)

    def factors(self, used: npt.NDArray[np.bool_]) -> Sequence[Factors]:
        """The factors for the sensors `used` (n,), one for each of `drags`, made when asked for."""

        def make(lean: int) -> Factors:
            hats, t = self._hats(used), (1.0, *self.drags[lean])
            if self.shear == "free":
                return Factors.of([s * hats.columns(i) for i, s in enumerate(self._scales)], self._prior)
            return Factors.of([sum(share * hats.columns(i) for i, share in enumerate(t) if share)], self._prior)

        return self._factors.get(used.tobytes(), lambda: _Leans(make, len(self.drags)))

    def std(
        self, used: npt.NDArray[np.bool_], drag: FloatArray, weight: float, heights: FloatArray
    ) -> npt.NDArray[np.float64]:
        """Standard deviations of the `heights` found with the sensors `used`, at a `drag` (2,) and a `weight`.

        Heights and deviations [Pa]: of the pressure (1, m), or where the drag is free of this and both drags (3, m).
        0 more than one element away from those that press.
        """
        from scipy.ndimage import binary_dilation
        from scipy.sparse import block_diag

        prior = self._surface.prior
        near = np.flatnonzero(binary_dilation((heights[0] > 0).reshape(prior.shape), np.ones((3, 3), dtype=bool)))
        parts = self._hats(used).among(near, 1 if self.shear == "none" else 3)
        form, out = weight * prior.form[near][:, near], np.zeros(heights.shape)
        if self.shear == "free":
            scales = self._scales[:, None]
            every = (scales[..., None] * parts).reshape(1, -1, parts.shape[2]), block_diag(3 * [form], format="csr")
            found = deviations(every[0], drag, every[1], (heights[:, near] / scales).reshape(-1))
            out[:, near] = scales * found.reshape(3, -1)
        else:
            out[0, near] = deviations(parts, drag, form, heights[0, near])
        return out

    @property
    def _scales(self) -> npt.NDArray[np.float64]:
        """Of a drag by the friction, as it is free to be (3,)."""
        return np.array([1.0, self.friction, self.friction])

    @property
    def shear_seen(self) -> float:
        """Share of the drag's components that are seen beside an unknown pressure, along y or z, the less.

        It holds for readings a hundred times above the noise; shear="free" needs 0.25.
        """
        hats = self._hats(self.finger.array.live)
        return shear_seen(*(hats.columns(i) for i in range(3)), prior=self._prior, above=_ABOVE)

    @property
    def drags(self) -> FloatArray:
        """Tangents (ty, tz) at which the factors are known, shape (leans, 2); 0 alone where no angle is sought."""
        if self.shear != "proportional":
            return np.zeros((1, 2))
        turns = np.pi / 4 * np.arange(8)
        circle = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
        return self.friction * np.concatenate([np.zeros((1, 2)), 0.45 * circle, 0.9 * circle])

    def _kernel(self) -> Any:
        return self._map_frames

    def _hats(self, used: npt.NDArray[np.bool_]) -> Hats:
        """Whitened readings per Pa of the used sensors."""
        return self._surface.hats.select(used, 1 / np.asarray(self.finger.array.noise))

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """What is worked out once for the sensors of `pattern`."""
        from scipy.special import chdtri

        prior, hats, count = self._surface.prior, self._hats(pattern), 1 if self.shear == "none" else 3
        sensors = sensor_rows(self.finger.array.select(pattern))
        limits = np.array([chdtri(hats.kind.size, self._false_alarm), self.friction, RULES.index(self.rule)])
        if self.shear == "free":
            return (FreeArea.of(sensors, limits, hats, prior, self.least_force),)
        (ny, nz), (hy, hz) = prior.shape, prior.steps
        columns = [hats.columns(i) for i in range(count)]
        at = (np.arange(ny // COARSE)[:, None] * COARSE + 1) * nz + np.arange(nz // COARSE) * COARSE + 1
        grams = np.empty((count, count, hats.kind.size, hats.kind.size))
        for k, column_ in enumerate(columns):
            spread = prior.applied(column_)
            if k == 0:
                first = spread[at.reshape(-1)].astype(np.float32)
            for i, other in enumerate(columns):
                grams[i, k] = other.T @ spread
        shares = np.concatenate([np.ones((len(self.drags), 1)), self.drags], axis=1)[:, :count]
        basis = np.empty((len(shares), *grams.shape[2:]), dtype=np.float32)
        squares = np.empty(basis.shape[:2])
        for k, t in enumerate(shares):
            gram = np.einsum("a,b,abnk->nk", t, t, grams)
            found, vectors = np.linalg.eigh(0.5 * (gram + gram.T))
            squares[k], basis[k] = np.maximum(found, 0.0), vectors.T
        pull = self.least_force * float(np.linalg.norm(columns[0], axis=1).max())
        wide = Membrane((ny // COARSE, nz // COARSE), (COARSE * hy, COARSE * hz))
        ready = _Prepared(
            sensors, limits, self.drags, basis, squares, first,
            level_of(hats.coarse(), count, wide, COARSE**2 * pull, 1, self.friction),
            level_of(hats, count, prior, pull, COARSE, self.friction), [],
        )  # fmt: skip
        return (ready,)

    def _map_frames(self, readings: FloatArray, ready: _Prepared | FreeArea, out: FloatArray) -> None:
        """Fill `out`, a row for each frame, as the compiled loop of a row of sensors does."""
        if isinstance(ready, FreeArea):
            return ready.fill(readings, self.y[1:-1], self.z[1:-1], out)
        from ._area_kernel import map_frames

        *numbers, coarse, fine, idle = ready
        levels, nodes = (tuple(coarse), tuple(fine)), (self.y[1:-1], self.z[1:-1])
        try:
            works = idle.pop()
        except IndexError:
            works = _works(ready, _ROOM)
        done = 0
        while (done := map_frames(done, readings, *numbers, *levels, *nodes, *works, out)) < len(readings):
            works = _works(ready, 2 * len(works[1][9]))
        idle.append(works)
        return None


def _works(ready: _Prepared, room: int) -> tuple[_Work, _Work]:
    """Arrays that the compiled loop fills (`_on_area.py`), with room for so many elements > 0."""
    return _work(ready.coarse, ready.squares.shape[1], room), _work(ready.fine, ready.squares.shape[1], room)


def _work(level: Level, sensors: int, room: int) -> _Work:
    total, room = level.cost.size, min(room, level.cost.size)
    return (
        np.empty(level.parts.shape[1]), np.empty(total), np.empty(total), np.empty(sensors), np.empty((room, room)),
        np.empty(total, dtype=np.int64), np.empty(total), np.empty(total),
        np.empty((len(level.parts) - 1, room, sensors), dtype=np.float32), np.empty((room, sensors)),
        np.empty((room, room)), np.empty(total + 1, dtype=np.int64), np.empty(total + 2, dtype=np.int64),
        np.empty(level.parts.shape[1], dtype=np.float32), np.empty(level.gain.size, dtype=np.float32),
        np.empty(LANES * REGISTERS, dtype=np.float32),
        np.empty((room, room)), np.empty(total, dtype=np.int64), np.empty((room, sensors), dtype=np.float32),
    )  # fmt: skip
