"""An unlabelled touch, and what it reads as a function of the finger in units of what its drawing leaves open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._check import FloatArray
from .._frozen import Frozen
from ..array import SensorArray
from ..contact import Hertz, LineLoad, RoundHertz
from ..estimate.area import AreaLocator, RoundLocator
from ..estimate.area.search import reach_of
from ..estimate.estimate import Estimate
from ..estimate.search import Locator
from ..finger import Finger
from ..radial import tabulate_radial
from ..radial_round import tabulate_round
from ..response import Response
from ._forward import Forward, slices, touches_at

__all__ = ["TERMS", "BlindModel", "Linearised", "UnknownTouch", "Whitened"]

TERMS = ("gain", "offset", "depth", "depths", "position", "poisson", "thickness")
"""What can be fitted, in the order of x."""

_STEP = 1e-5
"""Of differences, in typical sizes: what rounding and what curvature make of them is then about alike."""


class UnknownTouch(NamedTuple):
    """The kind of all touches.

    Parameters
    ----------
    dim : {1, 2}
        1 for line loads on a row, 2 for loads on an area.
    friction : float
        0 for touches that press straight down.
    half_width : float
        Of a Hertz contact [m]; 0 for a line or a point.
    """

    dim: int
    friction: float
    half_width: float = 0.0

    @property
    def loads(self) -> int:
        """How many components of force a touch has."""
        return 1 if self.friction == 0 else self.dim + 1

    @property
    def unknowns(self) -> int:
        """How many unknowns a touch has."""
        return self.dim + self.loads

    def fields(self, finger: Finger, positions: FloatArray) -> FloatArray:
        """Readings (m, n, k) under unit forces at `positions` (m, d) [m], without offsets."""
        units = np.eye(self.dim + 1)[: self.loads]
        contact = touches_at(units, positions if self.dim == 1 else positions[:, None], self.half_width)
        measured = np.swapaxes(finger.measure(contact, linear=True), -1, -2)
        out = np.asarray(finger.array.gain)[:, None] * measured
        out[..., 0] += np.asarray(finger.array.lift)
        return np.asarray(out)

    def locate(self, finger: Finger, array: SensorArray, ends: FloatArray, readings: FloatArray) -> Estimate:
        """Touches (m,) on `finger` within `ends` (d, 2) [m], by the noise of `array`."""
        widths = (self.half_width, self.half_width)
        y = (float(ends[0, 0]), float(ends[0, 1]))
        if self.dim == 1:
            response = Response.of(finger, Hertz if self.half_width else LineLoad, y, self.half_width)
            return Locator(response, array, half_width=widths, friction=self.friction)(readings)
        reach, box = reach_of(array, ends), (y, (float(ends[1, 0]), float(ends[1, 1])))
        if self.half_width:
            table = tabulate_round(finger, RoundHertz, reach, self.half_width)
            return RoundLocator(table, array, box, widths, friction=self.friction)(readings)
        return AreaLocator(tabulate_radial(finger, reach), array, box, friction=self.friction)(readings)


class Whitened(NamedTuple):
    """Readings (m, n) less the drawn offsets, over the noise; 0 where they are not `seen` (m, n)."""

    data: FloatArray
    seen: npt.NDArray[np.bool_]

    def of(self, rows: npt.NDArray[np.bool_]) -> Whitened:
        """Some of them."""
        return Whitened(self.data[rows], self.seen[rows])


@dataclass(frozen=True, eq=False)
class Linearised(Frozen):
    """Whitened readings near a finger x and touches at positions f, with the forces that fit best.

    Parameters
    ----------
    rest : ndarray, shape (m, n)
        What the forces leave of the readings.
    basis : ndarray, shape (m, n, k)
        Orthonormal columns that span what forces can explain.
    by_force, by_position, by_finger : ndarray, shapes (m, n, k), (m, n, d), (m, n, p)
        Derivatives of the readings.
    force : ndarray, shape (m, k)
        The forces [N/m], on an area [N].
    """

    rest: FloatArray
    basis: FloatArray
    by_force: FloatArray
    by_position: FloatArray
    by_finger: FloatArray
    force: FloatArray

    def free(self) -> tuple[FloatArray, FloatArray]:
        """`by_position` and `by_finger` less what a change of the forces could undo."""
        across = np.swapaxes(self.basis, 1, 2)
        position = self.by_position - self.basis @ (across @ self.by_position)
        return position, self.by_finger - self.basis @ (across @ self.by_finger)

    def information(self) -> FloatArray:
        """Fisher information of x at unit noise, every touch's position and forces being unknown, shape (p, p)."""
        position, finger = self.free()
        unit = np.linalg.qr(position)[0]
        finger = finger - unit @ (np.swapaxes(unit, 1, 2) @ finger)
        return np.asarray(np.einsum("mnp,mnq->pq", finger, finger))


class BlindModel:
    """A finger that depends on x: in each element, one standard deviation of what the drawing leaves open.

    Gains are exp(x gain_error) times the drawn ones, so that a factor common to all is one direction of x, exactly.
    The position of a sensor has as many coordinates as that of a touch, d.

    Parameters
    ----------
    finger : Finger
        As drawn, live sensors only.
    names : sequence of str
        Any of `TERMS`.
    errors : mapping of str to array_like
        Standard deviation of each: gain (a share), offset, depth, depths, position, thickness [m], poisson.
    touch : UnknownTouch
        What touches are.
    """

    def __init__(
        self, finger: Finger, names: Sequence[str], errors: Mapping[str, npt.ArrayLike], touch: UnknownTouch
    ) -> None:
        self.drawn, self.touch, self.dim = finger, touch, touch.dim
        self.forward = Forward(finger, names)
        n = len(finger.array)
        counts = {"gain": n, "offset": n, "depths": n, "position": self.dim * n}
        self.slices = slices({name: counts.get(name, 1) for name in TERMS if name in names})
        at = self.size = sum(part.stop - part.start for part in self.slices.values())
        self.prior = np.empty(at)
        for name, part in self.slices.items():
            error = np.asarray(errors[name])
            self.prior[part] = np.repeat(error, self.dim) if name == "position" and error.ndim else error
        # the terms that `Forward` knows, in its own order, and their values as drawn
        terms = [s for name in self.forward.names for s in range(*self.slices[name].indices(at))]
        self._terms = np.array(terms, dtype=np.intp)
        start = np.zeros(self.forward.size)
        if "poisson" in self.slices:
            start[self.forward.slices["poisson"]] = self.forward.poisson
        if "thickness" in self.slices:
            deepest = float(np.asarray(finger.array.depth).max())
            start[self.forward.slices["thickness"]] = finger.skin.thickness - deepest
        self._start = start
        self.low, self.high = np.full(at, -np.inf), np.full(at, np.inf)
        bounds = self.forward.bounds()
        spread = self.prior[self._terms]
        self.low[self._terms], self.high[self._terms] = ((b - start) / spread for b in bounds)
        self._steps = np.ones(at)
        self._steps[self._terms] = self.forward.scale() / spread
        self._steps *= _STEP

    def shift(self, x: FloatArray) -> FloatArray:
        """The vector of `Forward` at x."""
        return np.asarray(self._start + self.prior[self._terms] * x[self._terms])

    def finger(self, x: FloatArray) -> Finger:
        """The finger x."""
        fitted = self.forward.apply(self.shift(x))
        array = fitted.array
        if "gain" in self.slices:
            part = self.slices["gain"]
            array = replace(array, gain=np.asarray(array.gain) * np.exp(self.prior[part] * x[part]))
        if "offset" in self.slices:
            part = self.slices["offset"]
            array = replace(array, offset=np.asarray(array.offset) + self.prior[part] * x[part])
        return Finger(fitted.skin, array)

    def fit_forces(
        self, touches: Whitened, x: FloatArray, positions: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Readings under unit loads (m, n, k), an orthonormal basis of them, the best forces, and the rest (m, n)."""
        field = self._field(x, positions) * touches.seen[..., None]
        basis, triangle = np.linalg.qr(field)
        data = touches.data - self._lift(x) * touches.seen
        along = np.swapaxes(basis, 1, 2) @ data[..., None]
        force = np.linalg.solve(triangle, along)[..., 0]
        return field, basis, force, data - (basis @ along)[..., 0]

    def linearise(self, touches: Whitened, x: FloatArray, positions: FloatArray) -> Linearised:
        """The model near x and `positions` (m, d) [m].

        A skin is the same all along its surface: a sensor moved one way reads what a touch moved the other way makes.
        """
        field, basis, force, rest = self.fit_forces(touches, x, positions)

        def difference(high: FloatArray, low: FloatArray, width: FloatArray | float) -> FloatArray:
            return np.asarray(((high - low) @ force[..., None])[..., 0] / width * touches.seen)

        h = _STEP * float(np.asarray(self.drawn.array.depth).min())
        ends = ((self._field(x, positions + step), self._field(x, positions - step)) for step in h * np.eye(self.dim))
        by_position = np.stack([difference(*pair, 2 * h) for pair in ends], axis=-1)
        by_finger = np.zeros((*touches.data.shape, self.size))
        each = np.arange(touches.data.shape[1])
        for name, part in self.slices.items():
            spread = self.prior[part]
            if name == "gain":
                by_finger[:, each, part.start + each] = (field @ force[..., None])[..., 0] * spread
            elif name == "offset":
                by_finger[:, each, part.start + each] = touches.seen * spread / self._noise
            elif name == "position":
                for axis in range(self.dim):
                    own = part.start + self.dim * each + axis
                    by_finger[:, each, own] = -by_position[..., axis] * self.prior[own]
            else:  # moved together, for a sensor's reading knows no other's depth
                high, low = x.copy(), x.copy()
                high[part] = np.minimum(x[part] + self._steps[part], self.high[part])
                low[part] = np.maximum(x[part] - self._steps[part], self.low[part])
                change = difference(self._field(high, positions), self._field(low, positions), (high - low)[part])
                if name == "depths":
                    by_finger[:, each, part.start + each] = change
                else:
                    by_finger[..., part.start] = change
        return Linearised(rest, basis, field, by_position, by_finger, force)

    @property
    def _noise(self) -> FloatArray:
        return np.asarray(self.drawn.array.noise)

    def _field(self, x: FloatArray, positions: FloatArray) -> FloatArray:
        return self.touch.fields(self.finger(x), positions) / self._noise[:, None]

    def _lift(self, x: FloatArray) -> FloatArray | float:
        """What the found offsets add to the whitened readings."""
        part = self.slices.get("offset")
        return 0.0 if part is None else self.prior[part] * x[part] / self._noise

    def reported(self, x: FloatArray) -> list[tuple[str, int | None, float, str]]:
        """(name, sensor, value, unit) of each number of the finger x, in the order of `turn`'s rows."""
        array = self.finger(x).array
        out: list[tuple[str, int | None, float, str]] = []
        for name in ("gain", "offset"):
            if name in self.slices:
                out += [(name, i, float(v), "") for i, v in enumerate(np.asarray(getattr(array, name)))]
        return out + self.forward.parameters(self.shift(x), np.arange(len(array), dtype=np.intp))

    def turn(self, x: FloatArray) -> FloatArray:
        """How a change of x changes what is reported, shape (reported, p)."""
        array = self.finger(x).array
        first = [s for name in ("gain", "offset") for s in range(*self.slices.get(name, slice(0)).indices(self.size))]
        out = np.zeros((len(first) + len(self._terms), self.size))
        out[np.arange(len(first)), first] = self.prior[first]
        if "gain" in self.slices:
            gains = np.arange(len(array))
            out[gains, gains] *= np.asarray(array.gain)
        own = self.forward.expansion(self.shift(x))
        out[len(first) :, self._terms] = own * self.prior[self._terms]
        return out
