"""Several fingers as drawn and the touches of one -> which of them finds touches best that it has not seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_finger
from .._check import FloatArray
from ..errors import ConvergenceError, InvalidValueError
from ..estimate.answer import Status
from ..estimate.locate import locator
from ..finger import Finger
from .calibration import Calibration
from .fit import Fit
from .held_out import checked, kind_of, measured
from .known import fitted

__all__ = ["Choice", "Trial", "choose"]

_BLOCKS = 5
_WORST = 5.0
"""An error of so many typical ones is one in two million where errors are Gaussian: a worst error counts from there."""
_FEWEST = 5
_MARGIN = 1.1
"""Scores closer than this are a tie, which the candidate with fewer fitted numbers wins."""


@dataclass(frozen=True, eq=False)
class Trial:
    """One candidate of `choose`; its numbers are those of touches that the fit had not seen.

    Parameters
    ----------
    name : str
        Name of the candidate.
    calibration : Calibration or None
        On all touches; None where the fit failed.
    ok : float
        Share of the touches that are located and OK [-].
    median, worst, rms : float
        Error of position of these [m]; NaN where there is none.
    held : float
        Share of these whose 95 % interval holds the truth [-].
    score : float
        sqrt(rms^2 + (worst/5)^2) / ok [m]: less is better; infinite for a candidate that is out.
    reason : str
        Why it is out; "" where it is not.
    """

    name: str
    calibration: Calibration | None
    ok: float
    median: float
    worst: float
    rms: float
    held: float
    score: float
    reason: str


@dataclass(frozen=True, eq=False)
class Choice:
    """What `choose` found: its `trials`, best first, and the `reason` in words for taking the first."""

    trials: tuple[Trial, ...]
    reason: str

    @property
    def best(self) -> Trial:
        """The candidate to take."""
        return self.trials[0]


def choose(
    candidates: Mapping[str, tuple[Finger, Sequence[str]]],
    readings: npt.ArrayLike,
    positions: npt.ArrayLike,
    *,
    force: npt.ArrayLike | None = None,
    angle: npt.ArrayLike = 0.0,
    azimuth: npt.ArrayLike = 0.0,
    advance: Callable[[], object] | None = None,
    **options: Any,
) -> Choice:
    """Calibrate each candidate and compare them by the errors of positions on touches held out.

    The touches are cut into five blocks of neighbours; each block is located by the finger fitted to the others.
    Neighbours are alike, so whole blocks held out say more than every fifth touch would. A high R^2 says how well
    readings are fitted, but a few large residuals may lie just where they decide positions. So positions are compared:
    their errors, the worst error, and how many are OK. On an area an error is a distance, blocks are cut
    along the longer side of what was touched, and the skin's field alone is compared, without a response in place.

    Parameters
    ----------
    candidates : mapping
        By name, a finger as drawn and what to fit of it (`fit` of `calibrate`).
    readings, positions, force, angle, azimuth
        As in `calibrate`.
    advance : callable, optional
        Called once a candidate is done.
    **options
        Of `Finger.locator`: friction, search, false_alarm, ambiguity.

    Returns
    -------
    Choice

    Raises
    ------
    InvalidValueError
        No candidate, or fewer than ten touches.
    ConvergenceError
        No candidate fits the touches.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin, row = ss.HalfPlane(ss.Material(young=0.4e6)), {"count": 4, "pitch": 6e-3}
    >>> true = ss.Finger(skin, ss.SensorArray.line(depth=5.4e-3, noise=1e-6, **row))
    >>> positions = np.arange(-9e-3, 9e-3, 1e-3)
    >>> touches = true.read(ss.LineLoad(1.0, position=positions), rng=np.random.default_rng(0))
    >>> drawn = {kind: ss.SensorArray.line(depth=5e-3, transducer=kind(), **row)
    ...          for kind in (ss.NormalStress, ss.NormalStrain)}
    >>> found = choose({kind.__name__: (ss.Finger(skin, a), ("gain", "depth", "origin")) for kind, a in drawn.items()},
    ...                touches, positions, friction=0)
    >>> found.best.name
    'NormalStrain'
    """
    if not isinstance(candidates, Mapping) or not candidates:
        seen, fix = f"candidates = {_check.shown(candidates)}", '{"my finger": (finger, ("gain", "depth", "origin"))}'
        raise InvalidValueError(seen, "a mapping of names to at least one finger and what to fit of it is needed", fix)
    _check.function("advance", advance)
    known = _check.real("positions", positions, unit="m")
    count = len(known) if known.ndim else 0
    if count < 2 * _BLOCKS:
        seen = f"{count} touches"
        raise InvalidValueError(seen, f"at least {2 * _BLOCKS} are needed to hold some out", "more touches")
    trials = []
    for name, pair in candidates.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            rule = "a finger and what to fit of it are needed"
            raise InvalidValueError(f"{name}: {_check.shown(pair)}", rule, '(finger, ("gain", "depth", "origin"))')
        finger, fit = pair
        trials.append(_trial(name, finger, fit, (readings, positions, force, angle, azimuth), options))
        if advance is not None:
            advance()
    trials.sort(key=lambda t: t.score)
    if not np.isfinite(trials[0].score):
        rule = "; ".join(f"{t.name}: {t.reason}" for t in trials)
        raise ConvergenceError("no candidate fits", rule, "more touches, or another kind of sensor or skin")
    # of those that are as good as the best, the simplest
    tied = [t for t in trials if t.score <= _MARGIN * trials[0].score]
    best = min(tied, key=lambda t: (0 if t.calibration is None else len(t.calibration.parameters), t.score))
    trials.remove(best)
    return Choice((best, *trials), _reason(best, trials))


def _trial(
    name: str, finger: Finger, fit: Sequence[str], touches: tuple[Any, ...], options: Mapping[str, Any]
) -> Trial:
    nothing = (0.0, np.nan, np.nan, np.nan, np.nan, np.inf)
    try:
        whole = fitted(finger, *touches[:2], fit=fit, force=touches[2], angle=touches[3], azimuth=touches[4])
        found = whole.result()
        if found.misfit.wrong:
            return Trial(name, found, *nothing, found.misfit.verdict)
        found, error, std = _held_out(found, whole, options)
    except ConvergenceError as wrong:
        return Trial(name, None, *nothing, str(wrong))
    ok: npt.NDArray[np.bool_] = np.asarray(np.isfinite(error).all(axis=1))
    if ok.sum() < _FEWEST:
        return Trial(name, found, *nothing, f"{ok.sum()} of {len(ok)} touches held out are located")
    size, share = np.linalg.norm(error[ok], axis=1), float(ok.mean())
    rms, worst = float(np.sqrt(np.mean(size**2))), float(size.max())
    held = float(np.mean(np.abs(error[ok]) <= 1.96 * std[ok]))
    return Trial(
        name, found, share, float(np.median(size)), worst, rms, held, float(np.hypot(rms, worst / _WORST)) / share, ""
    )


def _held_out(found: Calibration, whole: Fit, options: Mapping[str, Any]) -> tuple[Calibration, FloatArray, FloatArray]:
    """The finger of all touches; errors of position of those held out, and their standard errors, (touches, d).

    On an area by the skin's field alone: a response in place would mend most of what a wrong candidate misses. It is
    made for the one that is taken.
    """
    positions, sizes, d = whole.positions, (1.0, 1.0), whole.forward.dim
    if d == 1:
        sizes, touches_out = measured(whole)
        found = checked(found, whole, sizes, touches_out)
    leaning = int(options.get("friction", 1.0) > 0)
    along = positions if d == 1 else positions[:, int(np.argmax(np.ptp(positions, axis=0)))]
    error, std = np.full((2, len(positions), d), np.nan)
    for block in np.array_split(np.argsort(along, kind="stable"), _BLOCKS):
        part = whole.without(block)
        truth = on_finger(positions[block], part.forward.origin(part.p, part.origin), part.forward.turn(part.p))
        at: Any = locator(part.finger_found(), **kind_of(part), **options)(whole.given[block])
        sure = at.status == Status.OK
        error[block[sure]] = (at.position - truth)[sure].reshape(-1, d)
        sigma = np.sqrt(np.diagonal(at.load.covariance, axis1=1, axis2=2))[sure, :d]
        if d == 1:
            part.uncertainty.process = whole.uncertainty.process
            sigma = sigma * (sizes[leaning] * part.uncertainty.of_positions(truth)[leaning])[sure, None]
        std[block[sure]] = sigma
    return found, error, std


def _reason(best: Trial, others: Sequence[Trial]) -> str:
    """Why the best is taken, in words."""
    said = (
        f"{best.name}: {100 * best.ok:.0f} % of the touches held out are OK, off by {1e3 * best.rms:.2g} mm (root mean "
        f"square), {1e3 * best.worst:.2g} mm at worst"
    )
    rivals = [t for t in others if np.isfinite(t.score)]
    if not rivals:
        return f"{said}; it is the only candidate that fits"
    next_ = rivals[0]
    more = "with more fitted numbers, " if next_.score < _MARGIN * best.score else ""
    said += f"; next is {next_.name}, {more}{1e3 * next_.rms:.2g} mm, {1e3 * next_.worst:.2g} mm at worst"
    top = max((best, *rivals), key=lambda t: t.calibration.r2 if t.calibration is not None else -np.inf)
    if top is not best and top.calibration is not None:
        said += f". {top.name} has the highest R^2 ({top.calibration.r2:.5f}) and does not locate better"
    return said
