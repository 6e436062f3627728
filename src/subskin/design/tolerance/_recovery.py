"""Fingers that are off, calibrated by their own touches, and what is left of their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ... import _check
from ...calibration import calibrate_blind
from ...calibration.known import explained, fitted
from ...errors import ConvergenceError, SubskinError
from ...finger import Finger
from ._costs import Costs, joined
from ._study import Located, straight, stylus
from .cost import Cost, Recovery
from .sources import SOURCES, as_made, of_each_sensor

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


def checked_method(name: str, what: str) -> None:
    """Refuse a calibration that there is not."""
    _check.choice(what, name, METHODS)


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
            return explained(fitted(study.finger, readings, positions, fit=terms, force=force, origin=origin)).finger

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
