"""Fingers that are off, calibrated by their own touches: one by one, or many at once to first order."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..._check import FloatArray
from ...calibration import calibrate_blind
from ...calibration.known import explained, fitted
from ...errors import ConvergenceError, InvalidValueError, SubskinError
from ...finger import Finger
from ._costs import Costs, joined
from ._study import Located, Study, straight, stylus
from .sources import SOURCES, Cost, Recovery, as_made, of_each_sensor

METHODS = ("known", "blind")

TERMS = {
    "gain": ("gain", "gains", "young"),
    "offset": ("offset",),
    "depth": ("depth",),
    "depths": ("depths",),
    "position": ("position",),
    "poisson": ("poisson",),
    "thickness": ("thickness",),
}
"""What a calibration can fit, and the sources that it then makes up for."""

_TOGETHER = "together"


def terms_for(finger: Finger, amounts: Mapping[str, float]) -> tuple[str, ...]:
    """What a self-calibration fits: all that has a tolerance, of what a calibration of this finger can fit."""
    off = [term for term, sources in TERMS.items() if any(name in amounts for name in sources)]
    if finger.skin.single_material is None:
        off = [term for term in off if term not in ("poisson", "thickness")]
    if "depths" in off and "depth" in off:
        off.remove("depth")
    return tuple(off) or ("gain",)


def recoveries(
    costs: Costs,
    amounts: Mapping[str, float],
    methods: Mapping[str, Sequence[str]],
    draws: int,
    touches: Mapping[str, int],
    progress: Callable[[], object],
) -> tuple[Recovery, ...]:
    """A row for each source that a calibration could remove, and one for all of them at once."""
    off = {name: amount for name, amount in amounts.items() if SOURCES[name].spread != "reading"}
    if not methods or not off:
        return ()
    study, out = costs.study, []
    for name, row in [*((name, {name: amount}) for name, amount in off.items()), (_TOGETHER, off)]:
        drawn: list[Located] = []
        after: dict[str, list[Located]] = {method: [] for method in methods}
        failed = dict.fromkeys(methods, 0)
        for draw in range(draws):
            rng = costs.rng(name, draw)
            made = _made(costs, name, row, draw, rng)
            readings = study.readings(made)
            drawn.append(study.locate(readings))
            for method, fit in methods.items():
                try:
                    found = _calibrated(costs, made, method, fit, amounts, touches[method], rng)
                    after[method].append(study.of(found).locate(readings))
                except ConvergenceError:
                    failed[method] += 1
                    after[method].append(drawn[-1])
                progress()
        amount = row.get(name, np.nan)
        done = {method: _summed(costs, name, amount, parts) for method, parts in after.items()}
        before = _summed(costs, name, amount, drawn)
        out.append(Recovery(name, before, done.get("known"), done.get("blind"), tuple(failed.items())))
    return tuple(out)


def _summed(costs: Costs, name: str, amount: float, parts: list[Located]) -> Cost:
    found = joined(parts)
    return costs.summed_up(name, amount, found, costs.largest(found.errors))


def _made(costs: Costs, name: str, off: Mapping[str, float], draw: int, rng: np.random.Generator) -> Finger:
    """A finger off by one standard deviation, to either side in turn, where it is off as a whole; else a drawn one."""
    if name != _TOGETHER and SOURCES[name].spread == "finger":
        for sign in (1, -1) if draw % 2 == 0 else (-1, 1):
            try:
                return as_made(costs.study.finger, {name: sign * off[name]})
            except SubskinError:
                continue
    return costs.finger(off, rng)


def _calibrated(
    costs: Costs,
    made: Finger,
    method: str,
    fit: Sequence[str],
    amounts: Mapping[str, float],
    count: int,
    rng: np.random.Generator,
) -> Finger:
    """The finger as drawn, with the numbers that touches of `made` tell; `amounts` say how far it can be off."""
    study = costs.study
    noise = of_each_sensor(made.array.noise, amounts["noise"]) if "noise" in amounts else made.array.noise
    made = replace(made, array=replace(made.array, noise=noise))
    if method == "known":
        positions, force = study.touches.presses(count, study.finger), study.touches.force
        readings = made.read(stylus(straight(force, study.dim, len(positions)), positions), rng)
        origin = 0.0 if study.dim == 1 else (0.0, 0.0)

        def found(terms: Sequence[str]) -> Finger:  # errors are counted, so nobody asks for standard errors
            known: dict[str, Any] = {"force": force, "origin": origin, "load": "line" if study.dim == 1 else "point"}
            return explained(fitted(study.finger, readings, positions, fit=terms, **known)).finger

        try:
            return found(fit)
        except ConvergenceError:  # normal touches do not tell Poisson's ratio from a gain to every kind of sensor
            rest = tuple(term for term in fit if term != "poisson")
            if rest in (tuple(fit), ()):
                raise
            return found(rest)
    readings = made.read(study.strokes(count, rng), rng)
    priors: dict[str, Any] = _priors(study.finger, fit, amounts)
    return calibrate_blind(
        study.finger, readings, fit=fit, friction=study.friction, search=study.search, **priors
    ).finger


def _priors(finger: Finger, fit: Sequence[str], amounts: Mapping[str, float]) -> dict[str, float]:
    """The tolerances as errors of the drawing, as `calibrate_blind` takes them; its own where there is none."""
    depth = np.asarray(finger.array.depth)
    scale = dict.fromkeys(("position", "depth", "depths"), 1 / depth.mean())
    scale["thickness"] = 1 / (finger.skin.thickness - float(depth.max()))
    out: dict[str, float] = {}
    for term in fit:
        names = ("depth", "depths") if term == "depths" else TERMS.get(term, ())
        size = float(np.sqrt(sum(amounts.get(name, 0.0) ** 2 for name in names)))
        if size > 0:
            out["depth_error" if term == "depths" else f"{term}_error"] = size * scale.get(term, 1.0)
    return out


_PRESSES = {"known": (60, 64), "blind": (200, 200)}
"""Touches of a calibration, of a row and on an area."""
_STEP = 1e-2
"""Of the differences by what a calibration fits, in amounts."""
_UNKNOWN = 1e-3
"""Weight of the tolerances where positions are known: hardly any, for `calibrate` knows none."""


def count_of(study: Study, method: str) -> int:
    """How many touches a calibration is of."""
    return len(_presses(study, method, np.random.default_rng(0))[1])


def _presses(study: Study, method: str, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Loads (c, d + 1) and positions of the touches of a calibration."""
    touches, finger, count = study.touches, study.finger, _PRESSES[method][study.dim - 1]
    if method == "known":
        position = touches.presses(count, finger)
        return straight(touches.force, study.dim, len(position)), position
    drawn = study.strokes(count, rng)
    return np.asarray(drawn.components), np.asarray(drawn.position)


def after_calibration(costs: Costs, off: Mapping[str, float], method: str) -> tuple[FloatArray, FloatArray]:
    """What a calibration leaves on fingers drawn: errors of the touches' readings (draws, p, a, n), and its misfit.

    That is, of each sensor (draws, n), the residuals of the presses over its noise, at least 1: so many times its noise
    the calibrated finger says that it has.
    """
    study, rng = costs.study, costs.rng("together", costs.draws + 1)
    array = study.finger.array
    presses = _presses(study, method, rng)
    # what a unit of each source changes, in the presses (c, n, j) and then in the touches (p * a, n, j)
    unit = {name: _change(study, name, amount, presses) for name, amount in off.items()}
    c, (p, a, n) = len(presses[1]), costs.drawn_readings.shape
    changes = np.zeros((costs.draws, c + p * a, n))
    for name, amount in off.items():
        spread, each = SOURCES[name].spread, of_each_sensor(array.noise, amount) if name == "offset" else amount
        for way in np.moveaxis(unit[name], -1, 0):
            drawn = rng.standard_normal((costs.draws, 1, n if spread == "sensor" else 1)) if spread != "fixed" else 1.0
            changes += each * drawn * way
    weight = np.where(array.live, 1 / np.where(array.live, array.noise, 1.0), 0.0)
    seen = weight * changes[:, :c] + rng.standard_normal((costs.draws, c, n))  # noise of the presses
    columns, sizes = _columns(terms_for(study.finger, off), unit, off, study, presses)
    design = weight[:, None] * columns[:c]  # (c, n, m)
    if method == "blind":
        free = study.stroke_slopes(*presses) * weight[:, None]  # left free if blind
        u, s, _ = np.linalg.svd(free / np.linalg.norm(free, axis=1, keepdims=True), full_matrices=False)
        u = u * (s > 1e-6 * s[:, :1])[:, None]
        design = design - u @ (np.swapaxes(u, 1, 2) @ design)
        seen = seen - np.einsum("cnk,dck->dcn", u, np.einsum("cnk,dcn->dck", u, seen))
    prior = np.eye(sizes.size) * (1.0 if method == "blind" else _UNKNOWN)
    whole_design = np.concatenate([design.reshape(c * n, -1) * sizes, prior])
    data = np.concatenate([seen.reshape(costs.draws, -1), np.zeros((costs.draws, sizes.size))], axis=1)
    found = sizes[:, None] * np.linalg.lstsq(whole_design, data.T, rcond=None)[0]  # (m, draws)
    rest = (seen - np.einsum("cnm,md->dcn", design, found)) ** 2
    if method == "known":
        misfit = np.sqrt(_alike(study, rest.sum(axis=1)) / max(c - sizes.size / n, 1.0))
    else:
        misfit = np.sqrt(rest.sum(axis=(1, 2))[:, None] / max(c * (n - u.shape[2]) - sizes.size, 1)) * np.ones(n)
    left = changes[:, c:] - np.einsum("tnm,md->dtn", columns[c:], found)
    return np.asarray(left.reshape(costs.draws, p, a, n)), np.maximum(misfit, 1.0)


def _alike(study: Study, rest: FloatArray) -> FloatArray:
    """Sums of squares (draws, n): each sensor's own, on an area the mean of its kind, as `calibrate` has them."""
    if study.dim == 1:
        return rest
    kinds, out = study.finger.array.transducers, rest.copy()
    for kind in set(kinds):
        same = np.array([k == kind for k in kinds]) & study.finger.array.live
        out[:, same] = rest[:, same].mean(axis=1, keepdims=True)
    return out


def _change(study: Study, name: str, amount: float, presses: tuple[FloatArray, FloatArray]) -> FloatArray:
    """What a unit of a source changes in the readings of presses and of the touches, shape (c + p * a, n, j).

    Of what a sensor has of its own, each reading is changed by that of its own sensor. A position on an area has j = 2
    ways to go, along y and along z; others have one.
    """
    finger = study.finger

    def readings(made: Finger) -> FloatArray:
        touches = study.readings(made)
        return np.concatenate([study.pressed(made, *presses), touches.reshape(-1, touches.shape[-1])])

    def difference(by: str, step: Any) -> FloatArray:
        ends = []
        for sign in (1, -1) if SOURCES[name].spread != "fixed" else (1,):
            try:
                ends.append((sign, readings(as_made(finger, {by: sign * step}))))
            except SubskinError as error:  # Poisson's ratio above 1/2
                refused = error
        if not ends:
            raise InvalidValueError(f"{name} off by {amount:.6g}", f"no such finger ({refused.seen})", "a smaller one")
        if len(ends) == 1:
            ends.append((0, readings(finger)))
        return np.asarray((ends[0][1] - ends[1][1]) / ((ends[0][0] - ends[1][0]) * np.max(step)))

    if name == "offset":
        return np.ones((1, len(finger.array), 1))
    if name in ("gain", "gains"):
        return np.asarray((readings(finger) - np.asarray(finger.array.offset))[..., None])
    by = "depths" if name == "depth" else name
    step = _STEP * amount if by in ("depths", "position") else amount
    if name == "position" and study.dim == 2:
        return np.stack([difference(by, step * along) for along in np.eye(2)[:, None]], axis=-1)
    return difference(by, step)[..., None]


def _columns(
    fit: Sequence[str],
    unit: Mapping[str, FloatArray],
    off: Mapping[str, float],
    study: Study,
    presses: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """What each fitted number changes, (c + p * a, n, m), and how far it may be off (m,)."""
    array, n = study.finger.array, len(study.finger.array)
    columns, sizes = [], []
    for term in fit:
        sources = [name for name in TERMS[term] if name in off] or [term]
        amount = float(np.sqrt(sum(off.get(name, 0.0) ** 2 for name in sources))) or 1.0
        key = next((name for name in sources if name != "young"), "gain")
        change = unit[key] if key in unit else _change(study, key, amount, presses)
        for way in np.moveaxis(change, -1, 0):
            if term in ("gain", "offset", "depths", "position"):
                columns.append(way[..., None] * np.eye(n))
                sizes.append(of_each_sensor(array.noise, amount) if term == "offset" else np.full(n, amount))
            else:
                columns.append(way[..., None])
                sizes.append(np.array([amount]))
    rows = max(len(column) for column in columns)
    return np.concatenate([np.broadcast_to(c, (rows, *c.shape[1:])) for c in columns], axis=-1), np.concatenate(sizes)
