"""What is known of the coefficient of friction: a density, made narrower by slips and holds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Self, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from .._declared import Noun, Real, Whole, checked
from ..errors import GeometryError, InvalidValueError
from ..estimate import Estimate
from ._cone import Forces, cells_beyond, forces_of, of_frames, picked, widths

__all__ = ["Friction", "density_of", "friction_of", "rows_of"]

_Shares: TypeAlias = Annotated[npt.ArrayLike, Real(at_least=0.0)]
_Cells: TypeAlias = Annotated[int, Whole(1, 10**6)]
_Std: TypeAlias = Annotated[float, Real(above=0.0, fix="Friction.known(0.5) for a value without error")]

_CELLS = 64
_NORMAL_REACH = 6.0
_LOST = 1e-12
"""Mass at either end that a narrower grid may leave out."""
_APART = 6.0
"""Standard deviations beyond all that was believed at which something seen is refused."""


@dataclass(frozen=True, eq=False)
class Friction(Noun):
    """The coefficient of friction mu as a density: constant in each cell of a grid, the cells' masses summing to 1.

    Here there is one mu. Most surfaces have two: sliding takes a little less drag than starting to slide. A slip gives
    the lower mu, so a grip by it holds by more than is stated. A range has to reach down to the lower mu.

    Parameters
    ----------
    edges : array_like, shape (..., k + 1)
        Edges of the cells [-], >= 0, ascending. A cell of no width is a value that is known.
    masses : array_like, shape (..., k)
        Their probabilities, >= 0; scaled to the sum 1. Leading axes are frictions of their own, one for each frame.

    Raises
    ------
    InvalidValueError, GeometryError
        Values out of range, no mass, edges that do not ascend, shapes that do not match.

    Examples
    --------
    >>> rubber = Friction.between(0.4, 0.8)
    >>> round(float(rubber.mean), 3), round(float(rubber.std), 3), round(float(rubber.quantile(0.025)), 3)
    (0.6, 0.115, 0.41)
    """

    edges: _Shares
    masses: _Shares

    def __post_init__(self) -> None:
        super().__post_init__()
        edges, masses = np.asarray(self.edges), np.asarray(self.masses)
        if not masses.ndim or not masses.shape[-1] or edges.ndim == 0 or edges.shape[-1] != masses.shape[-1] + 1:
            seen = f"edges of shape {edges.shape}, masses of shape {masses.shape}"
            raise GeometryError(seen, "k cells have k + 1 edges", "Friction.between(0.4, 0.8)")
        if (np.diff(edges) < 0).any():
            seen = f"edges = {edges.tolist()}"
            raise InvalidValueError(seen, "the edges of the cells have to ascend", "np.sort(edges)")
        total = masses.sum(axis=-1, keepdims=True)
        if not (total > 0).all():
            raise InvalidValueError("masses that are all 0", "some friction has to be possible", "a mass > 0")
        _check.broadcast(edges=edges[..., 0], masses=masses[..., 0])
        object.__setattr__(self, "masses", _check.read_only(masses / total))

    @classmethod
    def known(cls, value: npt.ArrayLike) -> Self:
        """A coefficient `value` that is known, or one for each frame.

        Examples
        --------
        >>> float(Friction.known(0.5).mean), float(Friction.known(0.5).std)
        (0.5, 0.0)
        """
        mu = _check.real("friction", value, at_least=0.0, fix="rubber on glass: 1; a dry finger: 0.5")
        _check.no_degrees("friction", mu)
        return cls(np.stack([mu, mu], axis=-1), np.ones((*mu.shape, 1)))

    @classmethod
    @checked
    def between(cls, low: _Shares, high: _Shares, cells: _Cells = _CELLS) -> Self:
        """Anything from `low` to `high`, all equally likely, on a grid of so many `cells`.

        Raises
        ------
        InvalidValueError
            A range that does not ascend, or reaches below 0.

        Examples
        --------
        >>> Friction.between(0.4, 0.8).quantile([0.0, 0.25, 1.0]).round(6).tolist()
        [0.4, 0.5, 0.8]
        """
        start, end = np.asarray(low), np.asarray(high)
        _check.no_degrees("high", end)
        _check.broadcast(low=start, high=end)
        start, end = np.broadcast_arrays(start, end)
        if not (start < end).all():
            seen = f"low = {start.tolist()}, high = {end.tolist()}"
            raise InvalidValueError(seen, "a range ascends", "known(0.5) for one value")
        # in the order in which the loops want it: each other order would be compiled anew
        edges = np.ascontiguousarray(np.linspace(start, end, cells + 1, axis=-1))
        return cls(edges, np.ones((*start.shape, cells)))

    @classmethod
    @checked
    def normal(cls, mean: Annotated[float, Real(at_least=0.0)], std: _Std, cells: _Cells = 2 * _CELLS) -> Self:
        """A normal density of `mean` and standard deviation `std`, to 6 of these and above 0, in so many `cells`.

        Examples
        --------
        >>> measured = Friction.normal(mean=0.6, std=0.05)
        >>> round(float(measured.mean), 4), round(float(measured.quantile(0.025)), 3)
        (0.6, 0.502)
        """
        from scipy.special import ndtr

        edges = np.linspace(max(mean - _NORMAL_REACH * std, 0.0), mean + _NORMAL_REACH * std, cells + 1)
        z = (edges - mean) / std
        lower = np.minimum(z, 0.0)
        # each half from its own tail, so that small masses keep their digits
        masses = np.diff(ndtr(lower)) + np.diff(-ndtr(-np.maximum(z, 0.0)))
        return cls(edges, masses)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Shape of the batch: () for one friction."""
        return np.broadcast_shapes(np.shape(self.edges)[:-1], np.shape(self.masses)[:-1])

    def __repr__(self) -> str:
        if self.shape:
            return f"Friction(of shape {self.shape})"
        low, high = self.quantile([0.025, 0.975])
        return f"Friction({float(self.mean):.3g} +- {float(self.std):.2g}, 95 % in {low:.3g} to {high:.3g})"

    @property
    def _centres(self) -> FloatArray:
        edges = np.asarray(self.edges)
        return np.asarray(0.5 * (edges[..., 1:] + edges[..., :-1]))

    @cached_property
    def mean(self) -> FloatArray:
        """Mean, shape (...)."""
        return _check.read_only((self._centres * np.asarray(self.masses)).sum(axis=-1))

    @cached_property
    def std(self) -> FloatArray:
        """Standard deviation, shape (...)."""
        away = self._centres - self.mean[..., None]
        within = np.diff(np.asarray(self.edges)) ** 2 / 12
        return _check.read_only(np.sqrt(((away**2 + within) * np.asarray(self.masses)).sum(axis=-1)))

    @cached_property
    def high(self) -> FloatArray:
        """The largest coefficient that is possible at all, shape (...)."""
        ends = np.asarray(self.edges)[..., 1:]
        return _check.read_only(np.where(np.asarray(self.masses) > 0, ends, -np.inf).max(axis=-1))

    @cached_property
    def facts(self) -> FloatArray:
        """Mean, standard deviation and `high`, shape (..., 3)."""
        return _check.read_only(np.stack(np.broadcast_arrays(self.mean, self.std, self.high), axis=-1))

    @cached_property
    def row(self) -> tuple[FloatArray, FloatArray, FloatArray] | None:
        """Edges, masses and `facts` of a friction that serves all frames, each of shape (1, ...); else None."""
        if self.shape:
            return None
        return np.asarray(self.edges)[None], np.asarray(self.masses)[None], self.facts[None]

    @checked
    def quantile(self, probability: Annotated[npt.ArrayLike, Real(at_least=0.0, at_most=1.0)]) -> FloatArray:
        """The coefficient below which it lies with a `probability`; shape (...) and then the probability's.

        Examples
        --------
        >>> float(Friction.known(0.5).quantile(0.01))
        0.5
        """
        p = np.asarray(probability)
        edges, masses = self._rows()
        rows = [_quantile(e, m, p.reshape(-1)) for e, m in zip(edges, masses, strict=True)]
        return _check.read_only(np.array(rows).reshape((*self.shape, *p.shape)))

    def _rows(self) -> tuple[FloatArray, FloatArray]:
        """Edges and masses with all frictions along the first axis."""
        edges, masses = np.asarray(self.edges), np.asarray(self.masses)
        return (
            np.broadcast_to(edges, (*self.shape, edges.shape[-1])).reshape(-1, edges.shape[-1]),
            np.broadcast_to(masses, (*self.shape, masses.shape[-1])).reshape(-1, masses.shape[-1]),
        )

    def updated(self, *, slips: Estimate | None = None, holds: Estimate | None = None) -> Friction:
        """What is known after slips and holds.

        A slip at the estimated load says mu = |T|/N, a hold says mu >= |T|/N, both within the estimate's error and
        with nothing known before of N (Bayes; docs/slip.md). Each frame counts as a load of its own, tried without
        knowing mu. Of a load that is held for a while give one estimate, from the mean of its readings: the largest of
        many readings of one load is larger than the load. Frames without a load, and those at the edge of
        the estimator's own cone, say nothing. The grid is drawn anew where the density has become narrow; it leaves
        out less than 1e-12 at either end.

        Parameters
        ----------
        slips, holds : Estimate, optional
            Loads at which a slip began or went on, and loads that held. Their leading axes are this friction's, all
            further ones are counted together.

        Raises
        ------
        InvalidValueError
            A slip or hold that no friction of this density could have shown.
        GeometryError
            Shapes that do not match.

        Examples
        --------
        >>> import numpy as np, subskin as ss
        >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
        >>> finger = ss.Finger(skin, ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4))
        >>> slid = finger.locate(finger.read(ss.LineLoad(40.0, angle=np.arctan(0.5), position=0.4e-3)))
        >>> learned = Friction.between(0.3, 0.9).updated(slips=slid)
        >>> round(float(learned.mean), 2), bool(learned.std < 0.02)
        (0.5, True)
        """
        events = [(e, slid) for e, slid in ((slips, True), (holds, False)) if e is not None]
        loads = [(*self._events(e), slid) for e, slid in events]
        edges, before = (np.array(v) for v in self._rows())
        for load, tells, slid in loads:
            _check_possible(load, tells, slid, edges)
        masses = before
        for _ in range(6):
            masses = _posterior(edges, before, loads)
            ends = np.array([_kept(e, m) for e, m in zip(edges, masses, strict=True)])
            narrow = (ends[:, 1] - ends[:, 0] < 0.5 * (edges[:, -1] - edges[:, 0])) & (ends[:, 0] < ends[:, 1])
            if not narrow.any():
                break
            for row in np.flatnonzero(narrow):
                grid = np.linspace(ends[row, 0], ends[row, 1], masses.shape[-1] + 1)
                share = np.concatenate([[0.0], np.cumsum(before[row])])
                before[row] = np.diff(np.interp(grid, edges[row], share))
                edges[row] = grid
        return Friction(edges.reshape((*self.shape, -1)), masses.reshape((*self.shape, -1)))

    def _events(self, estimate: Estimate) -> tuple[Forces, npt.NDArray[np.bool_]]:
        """Loads and which of them tell, shape (frictions, events)."""
        load, told, edge = forces_of(estimate)
        if load.on_area:
            rule = "friction is learned from loads with one component of drag"
            raise InvalidValueError("an estimate on an area", rule, "Friction.between(0.4, 0.8)")
        if estimate.shape[: len(self.shape)] != self.shape:
            seen = f"estimates of shape {estimate.shape}, frictions of shape {self.shape}"
            rule = "the first axes of the estimates have to be the frictions'"
            raise GeometryError(seen, rule, "one friction for all: Friction.between(0.4, 0.8)")
        rows = int(np.prod(self.shape, dtype=np.intp))
        return Forces(load.mean.reshape(rows, -1, 2), load.covariance.reshape(rows, -1, 2, 2)), (told & ~edge).reshape(
            rows, -1
        )


def _quantile(edges: FloatArray, masses: FloatArray, p: FloatArray) -> FloatArray:
    """Inverse of the cumulative, which rises in straight lines; where it is flat, where it began to be."""
    some = masses > 0
    share = np.cumsum(masses[some])
    share /= share[-1]
    low, high = edges[:-1][some], edges[1:][some]
    cell = np.minimum(np.searchsorted(share, p), share.size - 1)
    before = np.concatenate([[0.0], share])[cell]
    return np.asarray(low[cell] + (high - low)[cell] * (p - before) / (share[cell] - before))


def _kept(edges: FloatArray, masses: FloatArray) -> tuple[float, float]:
    """The part of the grid that holds all but a trifle of the mass."""
    lower, upper = np.cumsum(masses), np.cumsum(masses[::-1])[::-1]
    first, last = int(np.argmax(lower > _LOST)), int(np.flatnonzero(upper > _LOST)[-1])
    return float(edges[first]), float(edges[last + 1])


def friction_of(friction: Friction | float) -> Friction:
    """A friction as it is given, or a number that is known."""
    return friction if isinstance(friction, Friction) else Friction.known(friction)


def rows_of(friction: Friction, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Edges, masses, and (mean, std, high) for each frame, (frames, ...), or the one row that serves all, (1, ...)."""
    if friction.row is not None:
        return friction.row
    edges, masses, facts = np.asarray(friction.edges), np.asarray(friction.masses), friction.facts
    rows = [of_frames(np.moveaxis(v, -1, 0), (v.shape[-1], *shape)) for v in (edges, masses, facts)]
    first, second, third = (np.moveaxis(v, 0, -1).reshape(-1, v.shape[0]) for v in rows)
    return first, second, third


def density_of(
    friction: Friction, shape: tuple[int, ...], index: npt.NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """Edges and masses for the frames of a flat index, (frames, ...), or the one row that serves all, (1, ...)."""
    edges, masses, _ = rows_of(friction, shape)
    return picked(edges, index), picked(masses, index)


def _posterior(
    edges: FloatArray, before: FloatArray, loads: list[tuple[Forces, npt.NDArray[np.bool_], bool]]
) -> FloatArray:
    """Masses after the events, shape (frictions, k)."""
    with np.errstate(divide="ignore"):
        logs = np.log(before)
        for load, tells, slid in loads:
            for event in range(tells.shape[1]):
                some = tells[:, event, None]
                mean, covariance = load.mean[:, event], load.covariance[:, event]
                here = Forces(np.where(some, mean, 1.0), np.where(some[..., None], covariance, 1.0))
                density = _slip_density(here, edges) if slid else np.maximum(1 - cells_beyond(here, edges), 0.0)
                logs = logs + np.where(some, np.log(density), 0.0)
    top = logs.max(axis=-1, keepdims=True)
    if not np.isfinite(top).all():
        row = int(np.argmin(np.isfinite(top[:, 0])))
        seen = f"slips and holds that no one friction from {edges[row, 0]:.3g} to {edges[row, -1]:.3g} would show"
        rule = "what was seen has to be possible under what was believed"
        raise InvalidValueError(seen, rule, "a wider range, or the status and the noise of the estimates")
    masses = np.exp(logs - top)
    return np.asarray(masses / masses.sum(axis=-1, keepdims=True))


def _check_possible(load: Forces, tells: npt.NDArray[np.bool_], slid: bool, edges: FloatArray) -> None:
    """Raise where a slip or a hold lies more than _APART standard deviations from all that was believed."""
    for mu, steeper in ((edges[:, -1:], True), *([(edges[:, :1], False)] if slid else [])):
        away = np.abs(load.tangential) - mu * load.normal
        spread = widths(load, mu[..., None], np.sign(load.tangential)[..., None])[..., 0]
        with np.errstate(invalid="ignore"):
            bad = tells & ((away if steeper else -away) > _APART * spread + 1e-9 * np.abs(load.tangential))
        if bad.any():
            row, event = (int(i) for i in np.argwhere(bad)[0])
            seen = abs(load.tangential[row, event]) / load.normal[row, event]
            raise InvalidValueError(
                f"a {'slip' if slid else 'hold'} at |T|/N = {seen:.3g}",
                f"no friction from {edges[row, 0]:.3g} to {edges[row, -1]:.3g} would show it, "
                f"to {_APART:g} standard deviations",
                "a wider range, or a look at the status and the noise of the estimates",
            )


def _slip_density(load: Forces, edges: FloatArray) -> FloatArray:
    """Mean over each cell of mu of the density of what was measured, had it slid: T = mu N to either side, any N."""
    from scipy.special import ndtr

    total: FloatArray = np.zeros(())
    for side in (1.0, -1.0):
        spread = widths(load, edges, side)
        z = (side * load.tangential[..., None] - edges * load.normal[..., None]) / spread
        low, high = z[..., 1:], z[..., :-1]
        # from the nearer tail, so that small differences keep their digits
        flip = np.where(low + high > 0, -1.0, 1.0)
        a, b = np.minimum(flip * low, flip * high), np.maximum(flip * low, flip * high)
        close = b - a < 1e-6
        bell = np.exp(-0.5 * np.minimum(np.abs(0.5 * (a + b)), 40.0) ** 2) / np.sqrt(2 * np.pi)
        mean = np.where(close, bell, (ndtr(b) - ndtr(a)) / np.where(close, 1.0, b - a))
        total = total + mean / (0.5 * (spread[..., 1:] + spread[..., :-1]))
    return np.asarray(total)
