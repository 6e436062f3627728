"""Readings of sensors on an area -> an image of the pressure, and of the drag where the array can see it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from ..._check import FloatArray
from ...errors import InvalidValueError
from ...finger import Finger
from ..estimate import Status
from ..frames import sensor_rows
from ..scan import MOST_CHI2
from . import columns as column
from ._operator import Factors
from .area_surface import COARSE, AreaSurface
from .image import PressureImage
from .mapping import RULES, SHEARS, SurfaceMapper, known
from .prior import Membrane

__all__ = ["ImageMapper"]

_AT_ONCE = 1 << 21
"""Numbers that frames handled at once may take in one array."""
_MOST_PRODUCTS = 1 << 25
"""Products of columns that are kept, a quarter of a gigabyte; of more elements they are worked out when needed."""
_SETTLED, _NEAR = 0.01, 0.03
"""Where the search for the drag ends on fine and on coarse elements, in its standard deviations."""
_BRIGHT = 0.05
"""Share of the largest height from which a coarse element is thought to be pressed."""


class _Level(NamedTuple):
    """Elements of one size, as the compiled loop wants them (`_on_area.py`)."""

    parts: FloatArray
    grams: FloatArray
    stencil: FloatArray
    sizes: npt.NDArray[np.int64]
    cost: FloatArray
    single: npt.NDArray[np.float32]
    scales: FloatArray


class _Prepared(NamedTuple):
    """All that is worked out once for the sensors that can be used."""

    fine: _Level
    coarse: _Level
    drags: FloatArray  # (leans, 2)
    basis: FloatArray  # U^T of each, (leans, n, n)
    squares: FloatArray  # S^2, (leans, n)
    spread: FloatArray  # C A^T of each traction at the coarse nodes, (1 or 3, coarse m, n)


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
    shear : {"proportional", "none"}, optional
        Drag q = p tan(angle) in one unknown direction, or none.
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
        An option out of range; shear "free", as of a row; a sensor without noise; a finger that goes by a response
        measured in place.
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
        if shear == "free":
            seen, said = 'shear = "free" for sensors on an area', "a free drag came out wrong by its own size, and sure"
            raise InvalidValueError(seen, said, 'shear="proportional", a drag in one direction')
        known(shear, rule, SHEARS[:2])
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
            finger, self._surface.reading, prior, shear=shear, friction=friction, rule=rule,
            columns=column.AREA_WIDTH + prior.shape[0] * prior.shape[1], least_force=least_force,
            false_alarm=false_alarm,
        )  # fmt: skip
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
            normal, along, across = self._columns_of(used)
            ty, tz = self.drags[lean]
            return Factors.of([normal + ty * along + tz * across], self._prior)

        return self._factors.get(used.tobytes(), lambda: _Leans(make, len(self.drags)))

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

    def _prepare(self, pattern: npt.NDArray[np.bool_]) -> tuple[Any, ...]:
        """What is worked out once for the sensors of `pattern`."""
        prior = self._prior
        assert isinstance(prior, Membrane)
        tractions = self._columns_of(pattern)
        if self.shear == "none":
            tractions = tractions[:1]
        (ny, nz), (hy, hz) = prior.shape, prior.steps
        wide = Membrane((ny // COARSE, nz // COARSE), (COARSE * hy, COARSE * hz))
        coarse = np.stack([_coarsened(part, prior.shape) for part in tractions])
        spread = np.stack([prior.applied(part) for part in tractions])
        grams = np.einsum("amn,bmk->abnk", tractions, spread, optimize=True)
        shares = np.concatenate([np.ones((len(self.drags), 1)), self.drags], axis=1)[:, : len(tractions)]
        mixed = [np.einsum("a,b,abnk->nk", t, t, grams, optimize=True) for t in shares]
        squares, vectors = np.linalg.eigh(np.stack([0.5 * (gram + gram.T) for gram in mixed]))
        pull = self.least_force * float(np.linalg.norm(tractions[0], axis=1).max())
        at = (np.arange(ny // COARSE)[:, None] * COARSE + 1) * nz + np.arange(nz // COARSE) * COARSE + 1
        ready = _Prepared(
            _level(tractions, prior, pull, COARSE, self.friction),
            _level(coarse, wide, COARSE**2 * pull, 1, self.friction), self.drags,
            np.ascontiguousarray(np.swapaxes(vectors, 1, 2)), np.maximum(squares, 0.0),
            np.ascontiguousarray(spread[:, at.reshape(-1)]),
        )  # fmt: skip
        return sensor_rows(self.finger.array.select(pattern)), ready

    def _map_frames(self, readings: FloatArray, sensors: FloatArray, ready: _Prepared, out: FloatArray) -> None:
        """Fill `out`, a row for each frame, as the compiled loop of a row of sensors does."""
        out[:] = np.nan
        offset, scale, low, high = sensors
        usable = ((low < readings) & (readings < high)).all(axis=1)
        with np.errstate(invalid="ignore", over="ignore"):
            frames = (readings - offset) * scale
            power = np.einsum("fn,fn->f", frames, frames)
        usable &= power < MOST_CHI2
        out[:, column.STATUS] = np.where(usable, Status.NO_CONTACT, -1)
        out[usable, column.RESIDUAL] = power[usable]
        most = self._most(frames.shape[1])
        touched = np.flatnonzero(usable & (power > most))
        size = max(1, _AT_ONCE // ready.fine.parts[..., 0].size)
        for first in range(0, len(touched), size):
            rows = touched[first : first + size]
            part = out[rows]
            self._touched(np.ascontiguousarray(frames[rows]), ready, most, part)
            out[rows] = part

    def _most(self, sensors: int) -> float:
        from scipy.special import chdtri

        return float(chdtri(sensors, self._false_alarm))

    def _touched(self, frames: FloatArray, ready: _Prepared, most: float, out: FloatArray) -> None:
        """The least of J in frames with a contact: on coarse elements first, from the smoothest solution."""
        from ._area_kernel import settle_frames

        seeks = len(ready.drags) > 1
        drags = np.zeros((len(frames), 2))  # of 390 touches none had a lesser J where the search began at the true drag
        nodes = self.y[1:-1], self.z[1:-1]
        lean, weights, guess = self._smoothest(frames, drags, ready)
        near = np.array([self.friction, _NEAR, np.inf, 0.0, np.inf])
        along = _along(frames, ready.coarse)
        settle_frames(frames, along, weights, drags, guess, tuple(ready.coarse), near, *nodes, out[:0])
        if seeks:
            lean, weights, _ = self._smoothest(frames, drags, ready)
        along = _along(frames, ready.fine)
        fine = _finer(guess, ready.coarse.sizes[:2], ready.fine.sizes[:2])
        for k in np.unique(lean):
            rows = np.flatnonzero(lean == k)
            top = ready.squares[k, -1]
            options = np.array([self.friction, _SETTLED, most, np.exp(-28.0) * top, np.exp(6.0) * top])
            part, level = out[rows], tuple(ready.fine)
            settle_frames(
                frames[rows], along[rows], weights[rows], drags[rows], fine[rows], level, options, *nodes, part
            )
            out[rows] = part
        out[:, column.LEAN] = lean

    def _smoothest(
        self, frames: FloatArray, drags: FloatArray, ready: _Prepared
    ) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
        """Nearest drag with factors, weight by the rule, and heights of coarse elements of any sign, of each frame."""
        from ._weight import weigh

        lean = np.square(drags[:, None] - ready.drags).sum(axis=-1).argmin(axis=1)
        weights, heights = np.empty(len(frames)), np.empty((len(frames), ready.coarse.parts.shape[1]))
        kind = RULES.index(self.rule)
        for k in np.unique(lean):
            rows = np.flatnonzero(lean == k)
            seen = frames[rows] @ ready.basis[k].T
            squares = ready.squares[k]
            weights[rows] = [np.exp(weigh(one, squares, kind)) for one in seen**2]
            inner = (seen / (squares + weights[rows, None])) @ ready.basis[k]
            every = np.stack([inner @ part.T for part in ready.spread])  # (tractions, frames, coarse m)
            heights[rows] = every[0]
            for part, t in zip(every[1:], drags[rows].T, strict=False):
                heights[rows] += t[:, None] * part
        bright = heights > _BRIGHT * heights.max(axis=1, keepdims=True)
        return lean, weights, np.where(bright, heights, 0.0)


def _level(parts: FloatArray, prior: Membrane, pull: float, rim: int, friction: float) -> _Level:
    """Elements whose traction is p + ty q_y + tz q_z, of columns by part (1 or 3, N, n)."""
    sizes = np.array([*prior.shape, rim], dtype=np.int64)
    largest = float(np.linalg.norm(parts, axis=-1).sum(axis=0).max()) * max(1.0, friction)
    scales = np.array([largest, prior.steps[0] * prior.steps[1]])
    cost = np.full(parts.shape[1], pull)
    return _Level(parts, _grams(parts), prior.stencil, sizes, cost, parts.astype(np.float32), scales)


def _along(frames: FloatArray, level: _Level) -> FloatArray:
    """Columns of pressure and drags times the readings, shape (f, 1 or 3, N)."""
    return np.ascontiguousarray(np.stack([frames @ part.T for part in level.parts], axis=1))


def _grams(parts: FloatArray) -> FloatArray:
    """Products of the columns of p + ty q_y + tz q_z, by 1, ty, tz, ty^2, ty tz, tz^2; none where they are too many."""
    count = len(parts)
    terms = 1 if count == 1 else 6
    if terms * parts.shape[1] ** 2 > _MOST_PRODUCTS:
        return np.empty((0, 1, 1))
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)][:terms]
    out = np.stack([parts[i] @ parts[k].T for i, k in pairs])
    for j, (i, k) in enumerate(pairs):
        if i != k:
            out[j] += out[j].T.copy()
    return out


def _coarsened(part: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """Columns of the coarse elements: a wide hat is a sum of narrow ones."""
    ny, nz = shape
    field = part.reshape(ny, nz, -1)
    out = np.zeros((ny // COARSE, nz // COARSE, part.shape[-1]))
    for dy in range(1 - COARSE, COARSE):
        for dz in range(1 - COARSE, COARSE):
            share = (1 - abs(dy) / COARSE) * (1 - abs(dz) / COARSE)
            near = field[COARSE - 1 + dy :: COARSE, COARSE - 1 + dz :: COARSE]
            out += share * near[: ny // COARSE, : nz // COARSE]
    return out.reshape(-1, part.shape[-1])


def _finer(coarse: FloatArray, few: npt.NDArray[np.int64], many: npt.NDArray[np.int64]) -> FloatArray:
    """Which fine elements lie at coarse ones that are > 0, or half way to one, as heights 1 and 0."""
    on = (coarse > 0).reshape(len(coarse), *few)
    out = np.zeros((len(coarse), *many))
    for dy in range(1 - COARSE, COARSE):
        for dz in range(1 - COARSE, COARSE):
            y, z = COARSE - 1 + dy, COARSE - 1 + dz
            share = (1 - abs(dy) / COARSE) * (1 - abs(dz) / COARSE)
            out[:, y : y + COARSE * few[0] : COARSE, z : z + COARSE * few[1] : COARSE] += share * on
    return (out >= 0.5).reshape(len(coarse), -1).astype(np.float64)
