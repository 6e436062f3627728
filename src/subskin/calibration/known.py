"""Touches at known positions -> the finger's gains, offsets, depth and origin; and which candidate finds them best."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_finger
from .._check import FloatArray
from ..errors import ConvergenceError, GeometryError, InvalidValueError
from ..estimate.estimate import Status
from ..estimate.locate import locator
from ..finger import Finger, finger_needed
from ._forward import LINEAR, checked_names, terms_of
from .calibration import Calibration, checked_touches
from .fit import Fit
from .held_out import checked, measured, placed

__all__ = ["Choice", "Trial", "calibrate", "choose"]

_USUAL = ("gain", "offset", "depth", "origin")
_ALIKE = 1e-6
"""Share of themselves by which forces differ, and no more, that are alike."""


def calibrate(
    finger: Finger,
    readings: npt.ArrayLike,
    positions: npt.ArrayLike,
    *,
    fit: Sequence[str] | None = None,
    force: npt.ArrayLike | None = None,
    angle: npt.ArrayLike = 0.0,
    azimuth: npt.ArrayLike = 0.0,
    origin: npt.ArrayLike | None = None,
    turn: float = 0.0,
    gain_error: float = 0.25,
    accept_misfit: bool = False,
) -> Calibration:
    """Fit a finger to touches at known positions: by a line load on a motor's axis, on an area by a load on a point.

    Gains, offsets and lifts are linear and are eliminated at each trial of the rest. A scan over origin and depth finds
    the start, so no guess of the origin is needed. Sensors are weighted by their own residuals. Of 12 touches and more
    a single reading that is far off what all others say is left out, and `Calibration.doubts` names it.

    Parameters
    ----------
    finger : Finger
        The finger as drawn; what is not fitted is kept.
    readings : array_like, shape (m, n)
        One touch a row; NaN where a sensor gave none.
    positions : array_like, shape (m,) or (m, 2)
        Where each touch was, on the motor's axis [m]; (y, z) of sensors on an area.
    fit : sequence of str, optional
        Any of "gain", "offset" (what each sensor reads without a load), "lift" (what a load adds to each sensor
        wherever it presses), "depth" (one shift of all), "depths" (each sensor's), "origin", "position" (each sensor's
        along the row), "poisson", "width" (one for all), "thickness" (of a skin of one layer). On an area also "turn",
        and no "width". By default gain, offset, depth, origin, and turn. Readings less those of the free skin, as
        `segment` writes them, have no offset: fit "lift" instead.
    force, angle, azimuth : array_like, optional
        Load of each touch [N/m or N, rad, rad]; `azimuth`, on an area, is the motor's.
        Without `force` every touch carries the same load and the gain is the reading per
        measured unit *at that load*, taken as 1 N/m: forces found with it are multiples of the calibration's.
    origin : float or (float, float), optional
        Start (or, where "origin" is not fitted, value) of the origin [m]; by default found by the scan, or 0.
    turn : float, optional
        On an area, the same of the turn [rad].
    gain_error : float, optional
        How far gains of sensors of one kind are off their drawn ones times a common factor, a standard deviation [-].
        It decides where the touches say little of a gain; `inf` for gains that have nothing in common. A gain that the
        touches show to be more than three times as far off is one of its own.
    accept_misfit : bool, optional
        Return the finger even where its model cannot explain the touches (`Misfit.wrong`); otherwise this is an error.
        The finger is not `trusted`: none of its answers is OK.

    Returns
    -------
    Calibration

    Raises
    ------
    InvalidValueError, GeometryError
        Unknown names in `fit`, shapes that do not match, readings or positions that are not finite, a gain_error not
        above 0.
    ConvergenceError
        Fewer readings to spare than sensors, no sensor that responds, a fit that did not settle, or touches that are
        not those of an elastic skin like the one drawn.

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> true = ss.Finger(skin, ss.SensorArray.line(4, pitch=6e-3, depth=5.4e-3, gain=[80, 110, 90, 100], noise=1e-6))
    >>> positions = np.arange(0, 30e-3, 1e-3)
    >>> touches = true.read(ss.LineLoad(1.0, position=positions - 9e-3), rng=np.random.default_rng(0))
    >>> drawn = ss.Finger(skin, ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
    >>> found = ss.calibrate(drawn, touches, positions)
    >>> round(found.origin * 1e3, 2), round(float(found.finger.array.depth[0]) * 1e3, 2)
    (9.0, 5.4)
    """
    loads: dict[str, Any] = {"force": force, "angle": angle, "azimuth": azimuth}
    solution = fitted(finger, readings, positions, fit=fit, **loads, origin=origin, turn=turn, gain_error=gain_error)
    found = explained(solution, accept_misfit=accept_misfit)
    if finger.array.on_area:
        return placed(found, solution)
    return checked(found, solution, *measured(solution))


def explained(solution: Fit, *, accept_misfit: bool = False) -> Calibration:
    """What was fitted, its standard errors not yet held against touches held out; parameters and errors as above."""
    found = solution.result()
    if found.misfit.wrong and not accept_misfit:
        fix = "check the kind of sensor, the skin, the positions and the loads (force); or accept_misfit=True"
        raise ConvergenceError("a model that is not that of the touches", found.misfit.verdict, fix)
    return found


def fitted(
    finger: Finger,
    readings: npt.ArrayLike,
    positions: npt.ArrayLike,
    *,
    fit: Sequence[str] | None,
    force: npt.ArrayLike | None = None,
    angle: npt.ArrayLike = 0.0,
    azimuth: npt.ArrayLike = 0.0,
    origin: npt.ArrayLike | None = None,
    turn: float = 0.0,
    gain_error: float = 0.25,
) -> Fit:
    """The fit that `calibrate` makes a `Calibration` of; parameters and errors as there."""
    finger_needed(finger)
    area = finger.array.on_area
    usual = _USUAL + ("turn",) * area if fit is None else fit
    names = checked_names(usual, (*LINEAR, *terms_of(finger)))
    data, y, load = checked_touches(finger, readings, positions, 1.0 if force is None else force, angle, azimuth)
    start: Any = np.zeros(2) if area else 0.0
    if origin is not None:
        start = _check.real("origin", origin, unit="m") if area else _check.scalar("origin", origin, unit="m")
        if np.shape(start) != (2,) * area:
            raise GeometryError(f"origin of shape {np.shape(start)}", "(y, z) is needed", "origin=(5e-3, 5e-3)")
    about = _check.scalar("turn", turn, unit="rad")
    alike = _check.scalar("gain_error", gain_error, above=0.0, finite=False)
    if about and not area:
        raise GeometryError(f"turn = {about:g} rad", "a row of sensors knows no turn", "leave it out")
    live = np.isfinite(data).sum(axis=0) >= 2
    if "gain" not in names:
        live &= finger.array.live
    else:  # a reading that never moves is dead, however it fits
        live &= np.array([np.ptp(c[np.isfinite(c)]) > 0 if ok else False for c, ok in zip(data.T, live, strict=True)])
    if {"offset", "lift"} <= set(names) and np.ptp(load[:, 0]) <= _ALIKE * np.abs(load[:, 0]).max():
        rule = "only touches of several forces tell what goes with the load from what is always there"
        raise InvalidValueError("offset and lift, of touches of one force", rule, "fit one of them: lift, if tared")
    if "gain" in names:
        finger = replace(finger, relative=force is None)
    solution = None
    while live.any():
        solution = Fit(finger, names, data, y, load, live, start, about, scan=origin is None, gain_error=alike).solve()
        while (better := solution.without_lost()) is not None:
            solution = better
        dead = live & solution.dead()
        if not dead.any():
            break
        live &= ~dead
    if solution is None or not live.any():
        raise ConvergenceError("no sensor responds to the touches", "at least one has to", "check the columns")
    return solution


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
        at: Any = locator(part.finger_found(), "point" if d == 2 else "line", **options)(whole.given[block])
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
