"""Touches at known positions -> the finger's gains, offsets, depth and origin."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._check import FloatArray
from ..errors import ConvergenceError, GeometryError, InvalidValueError
from ..estimate.beside import finger_in_space
from ..estimate.locate import Load
from ..finger import Finger, finger_needed
from ._forward import LINEAR, checked_names, terms_of
from .calibration import Calibration, checked_touches
from .fit import Fit
from .held_out import checked, measured, placed
from .orient import ways

__all__ = ["another_order", "calibrate", "explained", "fitted"]

_USUAL = ("gain", "offset", "depth", "origin")
_REFUSED = "check the kind of sensor, the skin, the positions and the loads (force); or accept_misfit=True"
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
    load: Load | None = None,
) -> Calibration:
    """Fit a finger to touches at known positions: on a motor's axis along a row, or on an area by loads on a point.

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
    load : {"line", "point", "either"}, optional
        What pressed: on a row a long contact across it, or a point on it, of a ball or a blunt tip; on an area a point
        always. "either" tries both, and takes a point where it leaves less of the readings (`Calibration.load`); it is
        what is taken where the skin is known in space and nothing is said. Else it is a line.

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
    more: dict[str, Any] = {"force": force, "angle": angle, "azimuth": azimuth, "load": load}
    solution = fitted(finger, readings, positions, fit=fit, **more, origin=origin, turn=turn, gain_error=gain_error)
    found = explained(solution, accept_misfit=accept_misfit)
    if finger.array.on_area:
        return placed(found, solution)
    return checked(found, solution, *measured(solution))


def explained(solution: Fit, *, accept_misfit: bool = False) -> Calibration:
    """What was fitted, its standard errors not yet held against touches held out; parameters and errors as above."""
    found = solution.result()
    if found.misfit.wrong and not accept_misfit:
        seen, fix = "a model that is not that of the touches", _REFUSED
        if (order := another_order(solution)) is not None:
            fix = f"{order[0]}: readings[:, {order[1].tolist()}], or the names of the columns in that order"
        raise ConvergenceError(seen, found.misfit.verdict, fix)
    return found


def another_order(solution: Fit) -> tuple[str, npt.NDArray[np.intp]] | None:
    """The order of the channels by which the touches fit, where they do not as they are: in words, and by number."""
    live, more = solution.live, dict[str, Any](gain_error=solution.gain_error, points=solution.forward.points)
    for name, order in ways(solution.finger.array.points)[1:]:
        if not (live[order] == live).all():
            continue
        touches = (solution.given[:, order], solution.positions, solution.load, live, solution.origin, solution.turn)
        try:
            if not Fit(solution.finger, solution.names, *touches, scan=True, **more).solve().result().misfit.wrong:
                return f"the channels are {name}", order
        except ConvergenceError:
            continue
    return None


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
    load: Load | None = None,
) -> Fit:
    """The fit that `calibrate` makes a `Calibration` of; parameters and errors as there."""
    finger_needed(finger)
    area = finger.array.on_area
    usual = _USUAL + ("turn",) * area if fit is None else fit
    names = checked_names(usual, (*LINEAR, *terms_of(finger)))
    data, y, loads = checked_touches(finger, readings, positions, 1.0 if force is None else force, angle, azimuth)
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
    if {"offset", "lift"} <= set(names) and np.ptp(loads[:, 0]) <= _ALIKE * np.abs(loads[:, 0]).max():
        rule = "only touches of several forces tell what goes with the load from what is always there"
        raise InvalidValueError("offset and lift, of touches of one force", rule, "fit one of them: lift, if tared")
    if "gain" in names:
        finger = replace(finger, relative=force is None)

    def settled(points: bool) -> Fit:
        more: dict[str, Any] = {"scan": origin is None, "gain_error": alike, "points": points}
        alive, solution = live.copy(), None
        while alive.any():
            solution = Fit(finger, names, data, y, loads, alive, start, about, **more).solve()
            while (better := solution.without_lost()) is not None:
                solution = better
            dead = alive & solution.dead()
            if not dead.any():
                break
            alive = alive & ~dead
        if solution is None or not alive.any():
            raise ConvergenceError("no sensor responds to the touches", "at least one has to", "check the columns")
        return solution

    return _of_kind(finger, load, data, settled)


_LESS = 0.95
"""Of how far readings are off by lines, in the mean: below it points were the touches."""


def _of_kind(finger: Finger, load: str | None, data: FloatArray, settled: Callable[[bool], Fit]) -> Fit:
    """What was `settled` of lines (False) or of points on the row (True): of what is said, or of what leaves less."""
    if load is None:
        load = "point" if finger.array.on_area else "either" if finger.skin.takes_local else "line"
    _check.choice("load", load, ("line", "point", "either"))
    if finger.array.on_area:
        if load != "point":
            finger.array.refuse_area()
        return settled(False)
    if load != "line":
        finger_in_space(finger)
    if load != "either":
        return settled(load == "point")
    found: list[Fit] = []
    wrong: ConvergenceError | None = None
    for points in (False, True):
        try:
            found.append(settled(points))
        except ConvergenceError as seen:
            wrong = wrong or seen
    if not found:
        assert wrong is not None
        raise wrong
    line, other = (float(fit.off(data[:, fit.live]).mean()) for fit in (found[0], found[-1]))
    return found[-1] if other < _LESS * line else found[0]
