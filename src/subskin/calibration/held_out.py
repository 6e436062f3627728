"""How far positions are really off: standard errors of a calibrated finger held against touches held out.

Of a row they are a spread along it. On an area the finger gets its response in place: its skin's field, the doubt of
what was fitted, and what it misses. Readings at a position are those of the fitted field, plus what a change of its
numbers makes of them, plus a Gaussian process of the misfit (`correlated.py`), plus noise. Given the residuals of the
touches all of it has a mean and a variance everywhere: universal kriging (Rasmussen and Williams, Gaussian Processes
for Machine Learning (2006), section 2.7), with a model's discrepancy (Kennedy and O'Hagan, J. R. Stat. Soc. B 63, 425
(2001)).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from .._axes import turned
from .._check import FloatArray
from ..errors import ConvergenceError
from ..estimate.answer import Status
from ..estimate.area import InPlaceLocator
from ..estimate.locate import locator
from ..finger import Finger
from ..measured import MeasuredResponse, nodes_of
from ..spread import Spread
from .calibration import Calibration
from .correlated import Correlated
from .fit import Fit

__all__ = ["checked", "kind_of", "measured", "placed", "size_of"]

_FOLDS = 5
_FEWEST = 5
"""Touches held out and OK from which a spread is measured: with fewer it is not known to a half."""
_LEANING = (0.0, 1.0)
"""Friction of loads that press straight down, and of loads that may lean."""
_SHARE = 0.95
_KNOWN = 4.0
"""Ratio of two gains of a sensor, with and without some touches, above which only these touches knew it."""
_ROW_REACH, _ROW_STEP = 3.0, 0.5
"""How far beyond the row, and how finely, the spread is written down [depth]: misfit changes within a depth."""
_STEP, _REACH, _NEAR = 0.125, 1.5, 1.0
"""Between nodes, beyond the outermost sensor or touch, and about a touch held out [depth]."""
_VAGUE = 0.175
"""Standard error from which a position on an area is AMBIGUOUS [depth]: twice as much is 0.3 depths, and a miss."""
_USUAL, _WORTH = 1.4, 10
"""Errors over their standard errors, of a board of which nothing is known, and how many touches held out that is worth:
the root mean square of calibrations on 8 to 64 touches of two boards (`benchmarks/study_area_recordings.py`)."""
_MOST, _MOST_TOUCHES = 1000, 60
"""Residuals that correct the field, and touches held out, at most."""


def checked(found: Calibration, fit: Fit, sizes: tuple[float, float], touches: tuple[int, int]) -> Calibration:
    """What was `found` by the `fit`, its finger with the spread of its standard errors and whether it is to be trusted.

    `sizes` and `touches` are what `measured` says of the fit. Of residuals that look like noise, of no more than its
    stated size, the standard errors are right as they are. A finger of which only some numbers are fitted anew (its
    origin, say) stays as it was where the touches do not tell.
    """
    spread = None if fit.anew else fit.finger.spread
    if fit.uncertainty.process is not None and (fit.anew or all(touches)):
        spread = _along(found, fit, sizes)
    trusted = not found.misfit.wrong and (fit.anew or fit.finger.trusted)
    if trusted and spread is None:
        return found
    return replace(found, finger=replace(found.finger, spread=spread, trusted=trusted), held_out=touches)


def _along(found: Calibration, fit: Fit, sizes: tuple[float, float]) -> Spread:
    """Standard errors of positions along the row: those of the process of the misfit, times the measured `sizes`."""
    y, depth = np.asarray(found.finger.array.y), float(np.mean(np.asarray(found.finger.array.depth)))
    first, last = y.min() - _ROW_REACH * depth, y.max() + _ROW_REACH * depth
    nodes = np.linspace(first, last, int(np.ceil((last - first) / (_ROW_STEP * depth))) + 1)
    straight, leaning = fit.uncertainty.of_positions(nodes) * np.array(sizes)[:, None]
    return Spread(nodes, straight, leaning)


def measured(fit: Fit) -> tuple[tuple[float, float], tuple[int, int]]:
    """Errors of positions over the standard errors of the process of the misfit, of touches located by the others.

    Every fifth touch is left out in turn, then each of five
    blocks of neighbours: the first stand for new touches among those of the calibration, the second for touches in a
    gap. A fold in which the fit cannot do without its touches counts for nothing: it does not settle, or the gain of a
    sensor that no other touch came near goes astray, and no such finger is used. With the size for straight and leaning
    loads comes the number of touches that it rests on; where they are too few, or residuals are noise, it is 1, and the
    number 0.
    """
    if fit.uncertainty.process is None:
        return (1.0, 1.0), (0, 0)
    order = np.argsort(fit.positions, kind="stable")
    errors: tuple[list[float], list[float]] = ([], [])
    for rows in [*(order[k::_FOLDS] for k in range(_FOLDS)), *np.array_split(order, _FOLDS)]:
        try:
            _held_out(fit, rows, errors)
        except ConvergenceError:
            continue
    enough = [len(kept) >= _FEWEST for kept in errors]
    sizes = [size_of(np.array(kept)) if told else 1.0 for kept, told in zip(errors, enough, strict=True)]
    counts = [len(kept) * told for kept, told in zip(errors, enough, strict=True)]
    return (sizes[0], sizes[1]), (counts[0], counts[1])


def _held_out(fit: Fit, rows: npt.NDArray[np.intp], errors: tuple[list[float], list[float]]) -> None:
    """Add to `errors`, of straight and of leaning loads, those of the touches `rows`, located by the others."""
    part = fit.without(rows)
    gains = np.abs(part.gain / fit.gain)
    if not ((gains > 1 / _KNOWN) & (gains < _KNOWN)).all():
        return
    part.uncertainty.process = fit.uncertainty.process  # of all touches it is known best
    finger, origin = part.finger_found(), part.forward.origin(part.p, part.origin)
    truth = fit.positions[rows] - origin
    ratio = part.uncertainty.of_positions(truth)
    for i, friction in enumerate(_LEANING):
        found: Any = locator(finger, **kind_of(fit), friction=friction)(fit.given[rows])
        sure = (found.status == Status.OK) & (found.std[..., 0] > 0)
        sure &= (friction > 0) | (fit.load[rows, 1] == 0)
        errors[i].extend((np.abs(found.position - truth) / (ratio[i] * found.std[..., 0]))[sure].tolist())


def kind_of(fit: Fit) -> dict[str, Any]:
    """The options of a `locator` for touches like those of the fit: long ones, points on the row, points on an area."""
    if fit.forward.dim == 2:
        return {"family": "point"}
    return {"family": "point", "beside": 0.0} if fit.forward.points else {"family": "line"}


def size_of(errors: FloatArray) -> float:
    """Standard deviation of a normal distribution of which 95 % is no larger than 95 % of the `errors` (n,), |e|.

    The error of rank i of n new ones stands for the share i/(n + 1) of all: Vovk, Gammerman and Shafer, Algorithmic
    Learning in a Random World (2005), section 2. The rank nearest above 95 % is taken; of few, the largest.

    Examples
    --------
    >>> round(size_of(np.arange(1, 20) / 10), 3)  # the 19th of 19 stands for 95 %
    0.969
    """
    from scipy.special import ndtri

    n = len(errors)
    rank = min(int(np.ceil(_SHARE * (n + 1) - 1e-9)), n)
    return float(np.sort(errors)[rank - 1] / ndtri(0.5 + 0.5 * rank / (n + 1)))


def placed(found: Calibration, fit: Fit) -> Calibration:
    """What was `found` by the `fit` on an area, its finger with the response in place where residuals are no noise.

    A finger that was only moved, and whose response was known, stays as it was.
    """
    trusted = not found.misfit.wrong and (fit.anew or fit.finger.trusted)
    if fit.in_place:
        return replace(found, finger=replace(fit.finger, trusted=trusted))
    finger, touches = replace(found.finger, trusted=trusted), 0
    process = fit.uncertainty.process
    if process is not None:
        with threadpool_limits(limits=1, user_api="blas"):  # small matrices, as in `correlated`
            known = _Kriging(fit, process)
            size, touches = known.held_out()
            finger = replace(finger, measured=known.response(finger).widened(size))
    return replace(found, finger=finger, held_out=(touches, 0))


class _Kriging:
    """The response given the residuals of a fit, all of them or some."""

    def __init__(self, fit: Fit, process: Correlated) -> None:
        self.fit, self.unsure, self.process = fit, fit.uncertainty, process
        rows = self.unsure.residuals.thinned(_MOST)
        self.seen, self.jacobian = self.unsure.residuals[rows], self.unsure.jacobian[rows]
        self.touch = np.nonzero(fit.seen)[0][rows]
        self.alike = self.process.misfit(self.seen, self.seen) + self.process.of_touches(self.seen)
        self.alike += self.process.noise**2 * np.eye(len(rows))
        self.array = fit.forward.apply(fit.p).array
        self.depth = float(np.mean(np.asarray(self.array.depth)))
        force = np.hypot(fit.load[:, 0], np.hypot(fit.load[:, 1], fit.load[:, 2]))
        self.force = float(np.median(force))
        self.noise = np.maximum(self.process.noise * fit.noise, fit.stated)
        self.common = self.process.tolerances[3] * self.unsure.level

    def at(
        self, y: FloatArray, z: FloatArray, kept: npt.NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """At nodes y (k,), z (l,) of live sensors by the residuals `kept`: values, variances (k l, n), offsets' change.

        Per unit of a normal force.
        """
        from scipy.linalg import cho_factor, cho_solve

        fit, unsure, n = self.fit, self.unsure, len(self.array)
        seen, jacobian = self.seen[np.flatnonzero(kept)], self.jacobian[kept]
        factor = cho_factor(self.alike[np.ix_(kept, kept)])
        solved = cho_solve(factor, jacobian)
        doubt = np.linalg.pinv(jacobian.T @ solved + unsure.prior, hermitian=True)
        # of the numbers fitted, in their sizes
        change = doubt @ (solved.T @ seen.value - unsure.known.T @ unsure.known_rest)
        weights = cho_solve(factor, seen.value - jacobian @ change)
        nodes = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
        straight = np.tile([self.force, 0.0, 0.0], (len(nodes), 1))
        of_numbers, shift = self._jacobian_at(nodes, straight) / unsure.size, np.zeros(n)
        if "offset" in fit.names:
            lifts = n * ("lift" in fit.names)  # which come after them
            own = slice(len(change) - lifts - n, len(change) - lifts)
            shift = (change / unsure.size)[own]
            of_numbers[..., own] = 0.0  # a load's reading is without it
        values, variance = fit.gain * fit.forward.unit(fit.p, nodes, straight / self.force), np.empty((len(nodes), n))
        values += fit.lift
        scale, slopes = fit.noise / self.force, unsure.slopes(nodes, straight)
        for i in range(n):
            here = unsure.of_model(np.zeros(len(nodes)), nodes, np.full(len(nodes), i), slopes[:, i])
            known = self.process.misfit(here, seen)
            away = of_numbers[:, i] - known @ solved
            left = self.process.variance(here) - (known * cho_solve(factor, known.T).T).sum(axis=1)
            left = np.maximum(left, 0.0) + np.einsum("ip,pq,iq->i", away, doubt, away)
            values[:, i] += scale[i] * (of_numbers[:, i] @ change + known @ weights)
            variance[:, i] = scale[i] ** 2 * left
        return values, variance, shift

    def _jacobian_at(self, positions: FloatArray, load: FloatArray) -> FloatArray:
        """As `Fit.jacobian`, for loads on the finger, at `positions` of its own."""
        forward, p = self.fit.forward, self.fit.p
        out = turned(forward.turn(p)).T
        on_motor = positions @ out + forward.origin(p, self.fit.origin)
        return np.asarray(self.fit.jacobian(on_motor, np.column_stack([load[:, :1], load[:, 1:] @ out])))

    def response(self, finger: Finger) -> MeasuredResponse:
        """By all residuals, of all sensors of the `finger` found."""
        fit, live = self.fit, np.flatnonzero(self.fit.live)
        ends, beyond = np.concatenate([self.array.points, self.unsure.moved]), _REACH * self.depth
        y, z = (nodes_of(c.min() - beyond, c.max() + beyond, _STEP * self.depth) for c in ends.T)
        normal, doubt, shift = self.at(y, z, np.ones(len(self.touch), dtype=bool))
        nodes = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1).reshape(-1, 2)
        values, variance = np.zeros((2, len(nodes), len(finger.array), 3))
        values[:, live, 0], variance[:, live, 0] = normal, doubt
        for j in (1, 2):
            drag = np.tile(np.eye(3)[j], (len(nodes), 1))
            values[:, live, j] = fit.gain * fit.forward.unit(fit.p, nodes, drag)
        slopes = self.unsure.slopes(nodes, np.tile([self.force, 0.0, 0.0], (len(nodes), 1)))
        for i, sensor in enumerate(live):  # of what the field misses under drag, touches here are not asked
            here = self.unsure.of_model(np.zeros(len(nodes)), nodes, np.full(len(nodes), i), slopes[:, i])
            alone = (fit.noise[i] / self.force) ** 2 * self.process.variance(here)
            variance[:, sensor, 1:] = alone[:, None]
        shape = (len(y), len(z), len(finger.array), 3)
        offset, noise, common = np.array(finger.array.offset), np.ones(len(finger.array)), np.zeros(len(finger.array))
        offset[live] += shift
        noise[live], common[live] = self.noise, self.common
        return MeasuredResponse(
            y, z, values.reshape(shape), variance.reshape(shape), offset, noise, load=self.force, common=common,
            vague=_VAGUE * self.depth,
        )  # fmt: skip

    def held_out(self) -> tuple[float, int]:
        """Errors of positions over their standard errors, of touches each located by the others; and of how many.

        The doubts of sensors are taken as independent, but share what the field misses. Each touch is looked for near
        where it was: not whether it is found is asked, but how well.
        """
        squares: list[float] = []
        straight = np.flatnonzero((self.fit.load[:, 1:] == 0).all(axis=1) & self.fit.seen.all(axis=1))
        for t in straight[:: max(-(-len(straight) // _MOST_TOUCHES), 1)]:
            truth = self.unsure.moved[t]
            steps = np.arange(-_NEAR, _NEAR + _STEP / 2, _STEP) * self.depth
            y, z = truth[0] + steps, truth[1] + steps
            values, variance, shift = self.at(y, z, self.touch != t)
            shape = (len(y), len(z), len(self.array), 1)
            near = MeasuredResponse(
                y, z, values.reshape(shape), variance.reshape(shape), self.fit.offset + shift, self.noise,
                load=self.force, common=self.common,
            )  # fmt: skip
            found = InPlaceLocator(near, friction=0)(self.fit.data[t])
            if found.status == Status.OK:
                assert found.load.covariance is not None
                std = np.sqrt(np.diag(found.load.covariance)[:2])
                squares.append(float(np.mean(((found.position - truth) / std) ** 2)))
        # a few touches tell little of it, whether they happen to be found well or badly
        size = np.sqrt((_WORTH * _USUAL**2 + sum(squares)) / (_WORTH + len(squares)))
        return max(float(size), 1.0), len(squares)
