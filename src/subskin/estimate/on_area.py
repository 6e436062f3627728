"""Contacts on an area: their locators, made once for a finger and kept; and what they found, on the axes of touches."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _check
from .._axes import on_touches, turned_square
from .._check import FloatArray
from ..contact import Patch, PointLoad, RoundContact
from ..contact.families import Family, LocalFamily, local_family_of
from ..errors import InvalidValueError
from ..finger import Finger
from ..measured import MeasuredResponse
from ..prepared import prepared
from ..radial import tabulate_radial
from ..radial_round import tabulate_round
from .area import AreaLocator, InPlaceLocator, RoundLocator
from .area.observable import moment_of, refuse_blind
from .area.search import reach_of, search_of, step_of
from .area.uncertain import exactly, on_area
from .estimate import Estimate
from .layout import Layout
from .patches import PatchLocator
from .settle.uncertain import WITHOUT
from .several import SeveralLocator

__all__ = ["area_locator", "moved", "refuse", "refuse_tolerances", "several_locator"]


def refuse_tolerances(finger: Finger, where: str) -> None:
    """Raise an error where a finger has tolerances that an estimator does not count."""
    if finger.tolerances is not None:
        rule = "`locate` counts them, of lines and points"
        raise InvalidValueError(f"tolerances of a finger in {where}", rule, WITHOUT)


def refuse(options: dict[str, Any], rule: str) -> None:
    """Refuse the options that are given."""
    for name, value in options.items():
        if value is not None:
            raise InvalidValueError(f"{name} = {_check.shown(value)}", rule, "leave it out")


def area_locator(
    finger: Finger, family: str | Family | LocalFamily, search: Any, others: dict[str, Any], values: dict[str, Any]
) -> AreaLocator | InPlaceLocator | PatchLocator:
    """The locator of point loads, of round contacts, or of patches, by sensors on an area."""
    if family in ("patch", Patch):
        return _patches(finger, search, dict(others), dict(values))
    refuse({name: others.pop(name) for name in ("turn", "pressure")}, 'it belongs to a "patch"')
    sized = family == "line"  # nothing was said of the touch
    kind: LocalFamily = PointLoad if sized else local_family_of(family)
    round_kind = kind if issubclass(kind, RoundContact) else None
    if finger.measured is not None:
        if round_kind is not None:
            rule = "a response measured in place knows the contact of its touches alone"
            raise InvalidValueError(f"family = {_check.shown(family)}", rule, "finger.locate(readings)")
        return _in_place(finger, finger.measured, search, others, values)
    if round_kind is not None:
        refuse_tolerances(finger, "a fit")
    given = dict(others)
    widths, moment = None, None
    if round_kind is not None:
        widths = _check.ends("half_width", given.pop("half_width"), "half_width=(0.0, 3e-3)")
        moment = given.pop("moment")
    refuse(given, "it belongs to sensors in a row; contacts on an area know no such option")
    refuse_blind(finger)
    box, beyond = search_of(finger.array, search)

    def make() -> AreaLocator:
        step_of(finger.array, box, values["scan_step"])  # before tables so wide are made
        reach = reach_of(finger.array, box, beyond)
        (y, z) = (tuple(ends) for ends in box.tolist())
        options: dict[str, Any] = {"beyond": beyond, **values}
        if round_kind is None:
            points = tabulate_radial(finger, reach)
            options["uncertain"] = on_area(finger, points, reach, sized=sized)
            made = AreaLocator(points, finger.array, (y, z), **options)
        else:
            depth = float(np.asarray(finger.array.depth).min())
            low, high = widths or (0.0, 1.5 * depth)
            widest = max(high, 1.5 * depth)
            twist = moment_of(finger, round_kind, reach, widest, moment)
            response = tabulate_round(finger, round_kind, reach, widest)
            made = RoundLocator(response, finger.array, (y, z), (low, high), moment=twist, **options)
        return made.allow_for(finger, float(values["friction"]))

    return prepared(finger).get(
        ("area", kind, sized, tuple(box.reshape(-1)), beyond, widths, moment, *values.values()), make
    )


def _patches(finger: Finger, search: Any, others: dict[str, Any], values: dict[str, Any]) -> PatchLocator:
    """The locator of patches."""
    if finger.measured is not None:
        rule = "a response measured in place knows the contact of its touches alone"
        raise InvalidValueError('family = "patch"', rule, "finger.locate(readings)")
    refuse_tolerances(finger, "a fit")
    refuse_blind(finger)
    sides, turn, pressure = (others.pop(name) for name in ("half_width", "turn", "pressure"))
    refuse({**others, "scan_step": values.pop("scan_step")}, "a patch on an area knows no such option")
    key = [None if value is None else np.asarray(value, float).tobytes() for value in (search, sides, turn)]

    def make() -> PatchLocator:
        found = PatchLocator(finger, search, sides, turn, pressure or "even", **values)
        return found.allow_for(finger, float(values["friction"]))

    return prepared(finger).get(("patch", *key, pressure, *values.values()), make)


def several_locator(finger: Finger, most: int, search: Any, values: dict[str, Any]) -> SeveralLocator:
    """The locator of up to so many point loads at once."""
    fix = "touches=1"
    if not finger.array.on_area:
        raise InvalidValueError(f"touches = {most} on a row", "sensors on an area are needed", fix)
    if finger.measured is not None:
        raise InvalidValueError(f"touches = {most} by a response measured in place", "it knows one touch alone", fix)
    if values["outliers"]:
        raise InvalidValueError(f"outliers with touches = {most}", "one of both is looked for", "outliers=0")
    refuse_blind(finger)
    box, beyond = search_of(finger.array, search)

    def make() -> SeveralLocator:
        step_of(finger.array, box, values["scan_step"])
        (y, z), reach = (tuple(ends) for ends in box.tolist()), reach_of(finger.array, box, beyond)
        points = tabulate_radial(finger, reach)
        uncertain = on_area(finger, points, reach, sized=False) or exactly(points)
        one = AreaLocator(points, finger.array, (y, z), beyond=beyond, uncertain=uncertain, **values)
        return SeveralLocator(one, most).allow_for(finger, float(values["friction"]))

    return prepared(finger).get(("several", most, tuple(box.reshape(-1)), beyond, *values.values()), make)


def _in_place(
    finger: Finger, response: MeasuredResponse, search: Any, others: dict[str, Any], values: dict[str, Any]
) -> InPlaceLocator:
    """The locator by a response measured in place."""
    given = {**others, "scan_step": values["scan_step"]}
    force = given.pop("normal_force")
    refuse(given, "a response measured in place knows no such option")
    box = None if search is None else tuple(tuple(ends) for ends in search_of(finger.array, search)[0].tolist())
    options = {**values, "normal_force": force, "search": box}
    del options["scan_step"]

    def make() -> InPlaceLocator:
        return InPlaceLocator(response, finger.array, **options).allow_for(finger, float(values["friction"]))

    return prepared(finger).get(("in place", *options.values()), make)


def moved(found: Estimate, origin: npt.ArrayLike, turn: float = 0.0) -> Estimate:
    """The same contacts on the axes of the touches: positions, drags, their covariance, and the rivals.

    Parameters
    ----------
    found : Estimate
        Of sensors on an area, on their own axes.
    origin : array_like, shape (2,)
        Where the finger's (0, 0) lies on the other axes [m].
    turn : float, optional
        By how much the finger's y lies turned from theirs, towards z [rad].

    Examples
    --------
    >>> import numpy as np, subskin as ss
    >>> array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    >>> finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    >>> touch = ss.PointLoad(force=1.5, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))
    >>> found = moved(finger.locate(finger.read(touch)), origin=(10e-3, 20e-3), turn=np.pi / 2)
    >>> (found.position * 1e3).round(3).tolist(), round(float(found.load.azimuth - np.pi / 2), 3)
    ([12.0, 21.0], 0.8)
    """
    layout, table = found.layout, np.array(found.table)
    k, first = layout.unknowns, layout.components
    for at in (0, layout.rival):
        table[..., at : at + 2] = on_touches(table[..., at : at + 2], np.asarray(origin), turn)
        drag = slice(at + first + 1, at + first + 3)
        table[..., drag] = on_touches(table[..., drag], np.zeros(2), turn)
    if turn:
        out = turned_square(table[..., layout.square], (0, first + 1), turn)
        if layout.sides:
            named = [_named(table[..., at : at + k], layout, turn) for at in (0, layout.rival)]
            out = named[0] @ out @ np.swapaxes(named[0], -1, -2)
        upper = np.triu_indices(k)
        table[..., layout.covariance : layout.covariance + k * (k + 1) // 2] = out[(..., *upper)]
    return Estimate(table, found.used, found.friction, found.unknowns, layout, found.relative)


def _named(values: FloatArray, layout: Layout, turn: float) -> FloatArray:
    """Turn the patches in `values` (..., k), the side nearest y being the first again; how others go with that, k by k.

    Of a quarter of a turn the sides change their names, and slopes along them perhaps their signs.
    """
    half = layout.components + 3
    swap = np.eye(layout.unknowns)
    quarter = [half + 1, half]
    swap[half : half + 2] = swap[quarter]
    if layout.leaning:
        slope = half + 3
        swap[slope, slope], swap[slope, slope + 1] = 0.0, -1.0
        swap[slope + 1, slope], swap[slope + 1, slope + 1] = 1.0, 0.0
    away = values[..., half + 2] + turn
    times = np.rint(np.nan_to_num(away) / (0.5 * np.pi))
    by = np.stack([np.linalg.matrix_power(swap, n) for n in range(4)])[times.astype(int) % 4]
    values[...] = np.einsum("...ij,...j->...i", by, values)
    values[..., half + 2] = away - 0.5 * np.pi * times
    return np.asarray(by)
