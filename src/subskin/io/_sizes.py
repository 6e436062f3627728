"""Sizes in files whose unit was probably forgotten, of what a `Finger` by itself does not doubt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .. import _check
from ..finger import DEEPEST, LARGEST, SOFTEST

if TYPE_CHECKING:
    from ..finger import Finger
    from . import _goals_schema, _schema

__all__ = ["doubt_goals", "doubt_sizes"]

_LONGEST = 1.0  # m, of radii and of contacts
_RIDGE = 0.1  # m, of ridges, and of what is to be told apart
_WIDEST = 1.6  # rad, an error of an angle that leaves nothing known


def doubt_sizes(document: _schema.FingerDocument, finger: Finger) -> None:
    """Warn of millimetres and megapascals written as bare numbers; a modulus of 1 stands for units of one's own."""
    softest = min(material.young for material in finger.skin.materials)
    deepest = float(np.asarray(finger.array.depth).max())
    if softest < SOFTEST:
        if softest != 1.0 and deepest >= DEEPEST:  # a finger in units of its own, in Python; in a file both forgotten
            _check.doubt("young", softest, "Pa", 1e6, "MPa")
            _check.doubt("the largest depth", deepest, "m", 1e-3, "mm")
        return
    tip = document.tip
    sizes = [*_of_skin(document.skin), ("radius of [tip]", None if tip is None else tip.radius, _LONGEST)]
    _doubt([*sizes, ("length of [touch]", document.touch.length, _LONGEST)])


def doubt_goals(document: _goals_schema.GoalsDocument) -> None:
    """The same of goals: what is wanted, the room, and what is at hand."""
    for skin in document.skin:
        for young in (skin.young, *(layer.young for layer in skin.layers or ())):
            if young is not None and young < SOFTEST and young != 1.0:
                _check.doubt("young", young, "Pa", 1e6, "MPa")
    touch, wanted, room = document.touch, document.accuracy, document.room
    sizes = [size for skin in document.skin for size in _of_skin(skin)]
    sizes += [("length of [touch]", touch.length, _LONGEST), ("feature", touch.feature, _RIDGE)]
    sizes += [("position of [accuracy]", wanted.position, _RIDGE), ("longest_row", room.longest_row, _LONGEST)]
    sizes += [("the largest depth", float(np.max(room.depth)), LARGEST), ("least_pitch", room.least_pitch, _RIDGE)]
    _doubt([*sizes, *(("width of [[sensor]]", sensor.width, _RIDGE) for sensor in document.sensor)])
    if wanted.angle is not None and wanted.angle > _WIDEST:
        _check.doubt("angle of [accuracy]", wanted.angle, "rad", np.pi / 180, "deg")


def _of_skin(skin: _schema.SkinTable) -> list[tuple[str, float | None, float]]:
    """Lengths of a skin, and the largest that is not doubted [m]."""
    sizes: list[tuple[str, float | None, float]] = [("radius of [skin]", skin.radius, _LONGEST)]
    sizes += [("thickness", layer.thickness, LARGEST) for layer in skin.layers or ()]
    return [*sizes, ("pitch of ridges", None if skin.ridges is None else skin.ridges.pitch, _RIDGE)]


def _doubt(sizes: Sequence[tuple[str, float | None, float]]) -> None:
    for name, value, largest in sizes:
        if value is not None and value > largest:
            _check.doubt(name, value, "m", 1e-3, "mm")
