"""A response measured in place: readings under unit forces at nodes on an area, each with its doubt."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Annotated, ClassVar

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import FloatArray
from ._declared import Noun, Real
from .errors import ConvergenceError, GeometryError

__all__ = ["MeasuredResponse"]

_LENGTHS, _FINER = np.geomspace(1.0, 32.0, 6), (2**0.5, 2**0.25)
"""Lengths tried over which readings change, in distances between touches; then factors about the best."""
_SMOOTH = (1.5, 2.5)
"""Smoothness nu tried: a field in silicone has slopes that change smoothly, above the struts of a lattice they jump."""
_NOISES = np.geomspace(1e-6, 1.0, 37)
"""Variances of the noise tried, of that of what changes."""
_MOST = 300
"""Touches from which lengths and noise are found, at most."""
_FINE, _BETWEEN, _MARGIN = 6.0, 2.5, 1e-6
"""Nodes a length, and from one touch to the next, at least; how far beyond the touches nodes may stand, of a step."""
_WIDEST = 1000
"""Nodes along a side at most: one position in a wrong unit would ask for millions."""


@dataclass(frozen=True, eq=False)
class MeasuredResponse(Noun):
    """Readings under unit forces at nodes (y, z), as touches at known positions gave them, and how sure they are.

    No model is needed: magnets in a lattice, a skin with a seam. `from_touches` makes it by a Gaussian process;
    `calibrate` makes it of a skin's own field, its fitted numbers in doubt, and the process of what the field misses.

    Parameters
    ----------
    y, z : array_like, shape (k,), (l,)
        Nodes [m], rising in equal steps; at least four each.
    values : array_like, shape (k, l, n, 1) or (k, l, n, 3)
        Reading of each sensor per unit of N, or of (N, Ty, Tz), without its offset [reading/N].
    variance : array_like, shape as of `values`
        Their variances [(reading/N)^2].
    offset, noise : array_like, shape (n,)
        Reading without a load, and the standard deviation of a reading [reading].
    correlation : array_like, shape (n, n), optional
        Of the errors of sensors with each other, noise and doubt alike [-]: channels of one device err together. By
        default they do not.
    load : float, optional
        Normal force of the touches it was made from [N]: where a search for the force begins.
    common : array_like, shape () or (n,), optional
        Standard deviation of an error that all sensors of a frame have in common, such as the air's pressure since the
        last tare [reading].
    vague : float, optional
        Standard error of a position, in the direction where it is largest, from which an answer is AMBIGUOUS [m].

    Raises
    ------
    InvalidValueError, GeometryError
        Nodes that do not rise in equal steps, other shapes, noise or a variance below 0.

    Examples
    --------
    >>> import numpy as np
    >>> at = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0)), axis=-1).reshape(-1, 2) * 1e-3
    >>> sensors = np.array([(1e-3, 1e-3), (4e-3, 1e-3), (1e-3, 4e-3), (4e-3, 4e-3)])
    >>> readings = 1e6 / (1.0 + ((at[:, None] - sensors) ** 2).sum(-1) / 4e-6)
    >>> table = MeasuredResponse.from_touches(readings, at)
    >>> table
    MeasuredResponse(4 sensors, N, y = 0 to 5 mm, z = 0 to 5 mm)
    """

    y: Annotated[FloatArray, Real("m")]
    z: Annotated[FloatArray, Real("m")]
    values: FloatArray
    variance: Annotated[FloatArray, Real(at_least=0.0)]
    offset: FloatArray
    noise: Annotated[FloatArray, Real(above=0.0)]
    correlation: Annotated[FloatArray | None, Real()] = None
    load: Annotated[float, Real("N", above=0.0)] = 1.0
    common: Annotated[FloatArray | float, Real(at_least=0.0)] = 0.0
    vague: Annotated[float, Real("m", above=0.0, finite=False)] = np.inf

    EXAMPLE: ClassVar = "MeasuredResponse.from_touches(...)"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, nodes in (("y", self.y), ("z", self.z)):
            steps = np.diff(nodes) if nodes.ndim == 1 else np.zeros(0)
            if steps.size < 3 or not (steps > 0).all() or np.ptp(steps) > 1e-6 * steps[0]:
                rule = "at least four nodes, rising in equal steps, are needed"
                raise GeometryError(f"{name} of shape {nodes.shape}", rule, f"{name}=np.arange(0, 10e-3, 0.5e-3)")
        values = self.values
        if values.shape[:2] != (len(self.y), len(self.z)) or values.ndim != 4 or values.shape[3] not in (1, 3):
            rule = f"({len(self.y)}, {len(self.z)}, sensors, 1 or 3) is needed"
            raise GeometryError(f"values of shape {values.shape}", rule, self.EXAMPLE)
        own = self.__dict__
        for name in ("variance", "offset", "noise", "common"):
            shape = values.shape if name == "variance" else values.shape[2:3]
            if own[name].shape not in (shape, ()):
                raise GeometryError(f"{name} of shape {own[name].shape}", f"{shape} is needed", f"{name}=...")
            own[name] = _check.read_only(np.broadcast_to(own[name], shape).copy())
        n = values.shape[2]
        together = np.eye(n) if self.correlation is None else self.correlation
        if together.shape != (n, n) or not (np.linalg.eigvalsh(together) > 0).all():
            rule = f"a positive definite matrix of shape {(n, n)} is needed"
            raise GeometryError(f"correlation of shape {together.shape}", rule, "leave it out")
        own["correlation"] = _check.read_only(together)

    def __repr__(self) -> str:
        ends = (f"{n} = {1e3 * v[0]:.4g} to {1e3 * v[-1]:.4g} mm" for n, v in (("y", self.y), ("z", self.z)))
        forces = "N" if self.components == 1 else "(N, Ty, Tz)"
        return f"MeasuredResponse({self.sensors} sensors, {forces}, {', '.join(ends)})"

    def widened(self, factor: float) -> MeasuredResponse:
        """The same response with all its errors, noise and doubt, `factor` times as large."""
        noise, common = factor * self.noise, factor * np.asarray(self.common)
        return replace(self, noise=noise, common=common, variance=factor**2 * self.variance)

    def select(self, sensors: npt.ArrayLike) -> MeasuredResponse:
        """The response of some of the sensors.

        Parameters
        ----------
        sensors : array_like
            Their indices, or True for each that is taken, shape (n,).
        """
        index = _check.of_sensors(sensors, self.sensors)
        assert self.correlation is not None
        parts = {name: getattr(self, name)[:, :, index] for name in ("values", "variance")}
        parts |= {name: getattr(self, name)[index] for name in ("offset", "noise", "common")}
        return replace(self, **parts, correlation=self.correlation[np.ix_(index, index)])

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return int(self.values.shape[2])

    @property
    def components(self) -> int:
        """1 where only normal forces are known, 3 where drags are too."""
        return int(self.values.shape[3])

    def __call__(self, position: npt.ArrayLike) -> FloatArray:
        """Readings per unit force at positions (y, z) [m], shape (..., n, 1) or (..., n, 3); beyond, the cubic's.

        Parameters
        ----------
        position : array_like, shape (..., 2)
            Where a load presses [m]; between nodes by cubics.
        """
        at = np.asarray(position, dtype=np.float64)
        out = np.zeros((*at.shape[:-1], *self.values.shape[2:]))
        parts = []
        for i, nodes in enumerate((self.y, self.z)):
            p = (at[..., i] - nodes[0]) / (nodes[1] - nodes[0])
            second = np.clip(np.floor(p).astype(np.intp), 1, len(nodes) - 3)
            t = p - second
            low, high = t * (t - 1), (t + 1) * (t - 2)
            parts.append((second, (-low * (t - 2) / 6, high * (t - 1) / 2, -high * t / 2, low * (t + 1) / 6)))
        (j, a), (k, b) = parts
        for e in range(4):
            for f in range(4):
                out += (a[e] * b[f])[..., None, None] * self.values[j + e - 1, k + f - 1]
        return out

    @classmethod
    def from_touches(
        cls,
        readings: npt.ArrayLike,
        positions: npt.ArrayLike,
        *,
        components: npt.ArrayLike = 1.0,
        offset: npt.ArrayLike = 0.0,
        step: float | None = None,
    ) -> MeasuredResponse:
        """The response by touches at known positions alone, each sensor's by a Gaussian process over (y, z).

        All sensors share a smoothness (Matern, nu = 3/2 or 5/2), a length and a share of noise, found by likelihood;
        what changes of them has a size of its own for each and goes together: Rasmussen and Williams, Gaussian
        Processes for Machine Learning (2006), sections 2.2, 4.2, 5.4 and 9.1. The part of a reading that is the same
        everywhere is free. Touches repeated at one position tell how channels err together from touch to touch.

        Parameters
        ----------
        readings : array_like, shape (m, n)
            One touch a row.
        positions : array_like, shape (m, 2)
            Where each pressed, (y, z) [m].
        components : array_like, shape () or (m,) or (m, 3), optional
            Normal force N of each touch, or (N, Ty, Tz) [N]. By default every touch carries the same, taken as 1 N.
        offset : array_like, shape () or (n,), optional
            Readings without a load [reading]. Where they are not known and every touch carries the same force, leave
            it and locate with this `normal_force`.
        step : float, optional
            Between nodes [m]; by default a sixth of the length, and no more than 0.4 of the distance of touches.

        Returns
        -------
        MeasuredResponse
            Nodes over the rectangle of the touches.

        Raises
        ------
        InvalidValueError, GeometryError
            Shapes that do not match, numbers that are not finite, positions on one line, fewer than ten touches.
        ConvergenceError
            Readings that do not change from one position to another.
        """
        data, at = _check.real("readings", readings), _check.real("positions", positions, unit="m")
        if data.ndim != 2 or len(data) < 10 or at.shape != (len(data), 2):
            seen = f"readings of shape {data.shape}, positions of shape {at.shape}"
            raise GeometryError(seen, "shapes (m, n) and (m, 2), m at least 10, are needed", "one touch a row")
        loads = _check.real("components", components, unit="N")
        loads = np.full((len(data), 1), loads) if loads.ndim == 0 else loads[:, None] if loads.ndim == 1 else loads
        if loads.shape not in ((len(data), 1), (len(data), 3)):
            seen = f"components of shape {loads.shape}"
            raise GeometryError(seen, f"shape ({len(data)},) or ({len(data)}, 3) is needed", "components=(N, Ty, Tz)")
        load = _check.scalar("the median of the normal forces", np.median(np.abs(loads[:, 0])), unit="N", above=0.0)
        zero = _check.for_each("offset", _check.real("offset", offset), data.shape[1], "sensor")
        step = None if step is None else _check.scalar("step", step, unit="m", above=0.0)
        rest = data - zero
        if not (np.ptp(rest, axis=0) > 0).any():
            raise ConvergenceError("readings that are the same at every position", "they have to change", "the columns")
        unique = np.unique(np.round(at, 6), axis=0)
        pitch = float(np.sqrt(np.prod(np.ptp(unique, axis=0)) / len(unique)))
        if not pitch > 0:
            raise GeometryError("positions on one line", "they have to cover an area", "touches at several y and z")
        at, loads, rest, within = _merged(at, loads / load, rest)
        thin = np.arange(0, len(rest), -(-len(rest) // _MOST))
        smooth, length, ratio = _shape_of(at[thin], loads[thin], rest[thin], pitch)
        step = min(length / _FINE, pitch / _BETWEEN) if step is None else step
        y, z = (nodes_of(c.min(), c.max(), step) for c in at.T)
        values, left, square = _predicted(at, loads, rest, ratio, smooth, length, y, z)
        floor = 1e-12 * (data**2).mean(axis=0) + 1e-300
        # readings err by what a position has for itself, which goes together as what changes does, and by the touch
        errors = ratio * square + within + np.diag(floor)
        noise = np.sqrt(np.diag(errors))
        together = errors / np.outer(noise, noise)
        # of few touches the correlation is known badly
        own = data.shape[1] / (len(rest) + data.shape[1])
        together = (1 - own) * together + own * np.eye(len(together))
        np.fill_diagonal(together, 1.0)
        variance = left[:, :, None] * np.maximum(np.diag(square), floor)[:, None] / load**2
        return cls(y, z, values / load, variance, zero, noise, together, load=load)


def nodes_of(low: float, high: float, step: float) -> FloatArray:
    """Nodes from `low` to `high` [m], at most a `step` apart, at least four.

    Examples
    --------
    >>> nodes_of(0.0, 5e-3, 1e-3).tolist()
    [0.0, 0.001, 0.002, 0.003, 0.004, 0.005]
    """
    steps = (high - low) / step
    if not steps < _WIDEST:
        seen = f"touches from {low:.6g} to {high:.6g} m, for a response with nodes {step:.3g} m apart"
        rule = f"a response has at most {_WIDEST} nodes along a side"
        raise GeometryError(seen, rule, "leave out touches far from the others, or write all of them in one unit")
    return np.linspace(low, high, max(int(np.ceil(steps - _MARGIN)) + 1, 4))


def _kernel(a: FloatArray, b: FloatArray, smooth: float, length: float) -> FloatArray:
    """How alike readings at positions `a` (p, 2) and `b` (q, 2) are, (p, q); `smooth` is 3/2 or 5/2."""
    r = np.sqrt(2.0 * smooth * ((a[:, None] - b) ** 2).sum(axis=-1)) / length
    return np.asarray((1.0 + r + (smooth > 2.0) * r * r / 3.0) * np.exp(-r))


def _merged(
    at: FloatArray, loads: FloatArray, data: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Touches at one position with one load as their mean; and the covariance of a touch about it, (n, n).

    What a position has for itself, such as a cell of the lattice, no repeat takes away: a mean counts as one touch.
    """
    keys = np.column_stack([np.round(at, 6), np.round(loads, 6)])
    _, first, group, count = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    sums = np.zeros((len(count), data.shape[1]))
    np.add.at(sums, group.reshape(-1), data)
    mean = sums / count[:, None]
    apart = data - mean[group.reshape(-1)]
    within = apart.T @ apart / max(len(data) - len(count), 1)
    return at[first], loads[first], mean, within * float(np.mean(1 - 1 / count))


def _shape_of(at: FloatArray, loads: FloatArray, data: FloatArray, pitch: float) -> tuple[float, float, float]:
    """The likeliest smoothness, length [m] and variance of the noise, of that of what changes."""
    # directions in which no reading that is the same everywhere shows
    free = np.linalg.qr(loads, mode="complete")[0][:, loads.shape[1] :]
    left = free.T @ data[:, np.ptp(data, axis=0) > 0]

    def tried(smooth: float, length: float) -> tuple[float, float, float, float]:
        """The likelihood at the best of the noises; and what was tried."""
        alike = _kernel(at, at, smooth, length) * (loads @ loads.T)
        size, turn = np.linalg.eigh(free.T @ alike @ free)
        each = np.maximum(size, 0.0) + _NOISES[:, None]
        scale = np.maximum((1.0 / each) @ (turn.T @ left) ** 2 / len(left), 1e-300)
        values = -0.5 * (np.log(each).sum(axis=1) * left.shape[1] + len(left) * np.log(scale).sum(axis=1))
        k = int(np.argmax(values))
        return float(values[k]), smooth, length, float(_NOISES[k])

    best = max(tried(smooth, float(length)) for smooth, length in product(_SMOOTH, pitch * _LENGTHS))
    for factor in _FINER:
        best = max(best, tried(best[1], best[2] / factor), tried(best[1], best[2] * factor))
    return best[1:]


def _predicted(
    at: FloatArray,
    loads: FloatArray,
    data: FloatArray,
    noise: float,
    smooth: float,
    length: float,
    y: FloatArray,
    z: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """At the nodes y (k,), z (l,): values (k, l, n, c), variances (k, l, c) over what changes; and that, (n, n)."""
    from scipy.linalg import cho_factor, cho_solve

    nodes, count = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2), loads.shape[1]
    factor = cho_factor(_kernel(at, at, smooth, length) * (loads @ loads.T) + noise * np.eye(len(at)))
    solved = cho_solve(factor, loads)
    doubt = np.linalg.inv(loads.T @ solved)
    level = doubt @ solved.T @ data  # the same everywhere, (c, n)
    rest = data - loads @ level
    weights = cho_solve(factor, rest)
    square = rest.T @ weights / (len(at) - count)
    values, variance = np.empty((len(nodes), data.shape[1], count)), np.empty((len(nodes), count))
    near = _kernel(nodes, at, smooth, length)
    for j in range(count):
        known = near * loads[:, j]
        values[..., j] = known @ weights + level[j]
        away = np.eye(count)[j] - known @ solved
        left = 1.0 - (known * cho_solve(factor, known.T).T).sum(axis=1) + np.einsum("pi,ij,pj->p", away, doubt, away)
        variance[..., j] = np.maximum(left, 0.0)
    shape = (len(y), len(z))
    return values.reshape(*shape, data.shape[1], count), variance.reshape(*shape, count), square
