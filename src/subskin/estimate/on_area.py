"""The locators of sensors on an area, made once for a finger and kept: points, round contacts, a response in place."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import _check
from ..contact import PointLoad, RoundContact
from ..contact.families import Family, LocalFamily, local_family_of
from ..errors import InvalidValueError
from ..finger import Finger
from ..measured import MeasuredResponse
from ..prepared import prepared
from ..radial import tabulate_radial
from ..radial_round import tabulate_round
from .area import AreaLocator, InPlaceLocator, RoundLocator
from .area.locator import reach_of, search_of, step_of
from .area.observable import moment_of, refuse_blind

__all__ = ["area_locator", "refuse"]


def refuse(options: dict[str, Any], rule: str) -> None:
    """Refuse the options that are given."""
    for name, value in options.items():
        if value is not None:
            raise InvalidValueError(f"{name} = {_check.shown(value)}", rule, "leave it out")


def area_locator(
    finger: Finger, family: str | Family | LocalFamily, search: Any, others: dict[str, Any], values: dict[str, Any]
) -> AreaLocator | InPlaceLocator:
    """The locator of point loads, or of round contacts, by sensors on an area."""
    kind: LocalFamily = PointLoad if family == "line" else local_family_of(family)
    round_kind = kind if issubclass(kind, RoundContact) else None
    if finger.measured is not None:
        if round_kind is not None:
            rule = "a response measured in place knows the contact of its touches alone"
            raise InvalidValueError(f"family = {_check.shown(family)}", rule, "finger.locate(readings)")
        return _in_place(finger, finger.measured, search, others, values)
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
            made = AreaLocator(tabulate_radial(finger, reach), finger.array, (y, z), **options)
        else:
            depth = float(np.asarray(finger.array.depth).min())
            low, high = widths or (0.0, 1.5 * depth)
            widest = max(high, 1.5 * depth)
            twist = moment_of(finger, round_kind, reach, widest, moment)
            response = tabulate_round(finger, round_kind, reach, widest)
            made = RoundLocator(response, finger.array, (y, z), (low, high), moment=twist, **options)
        return made.allow_for(finger, float(values["friction"]))

    return prepared(finger).get(("area", kind, tuple(box.reshape(-1)), beyond, widths, moment, *values.values()), make)


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
