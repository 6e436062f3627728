"""Sizes in a finger file whose unit was probably forgotten, of what a `Finger` by itself does not doubt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import _check
from ..finger import DEEPEST, LARGEST, SOFTEST

if TYPE_CHECKING:
    from ..finger import Finger
    from . import _schema

__all__ = ["doubt_sizes"]

_LONGEST = 1.0  # m, of radii and of contacts
_RIDGE = 0.1  # m, of ridges


def doubt_sizes(document: _schema.FingerDocument, finger: Finger) -> None:
    """Warn of millimetres and megapascals written as bare numbers; a modulus of 1 stands for units of one's own."""
    softest = min(material.young for material in finger.skin.materials)
    deepest = float(np.asarray(finger.array.depth).max())
    if softest < SOFTEST:
        if softest != 1.0 and deepest >= DEEPEST:  # a finger in units of its own, in Python; in a file both forgotten
            _check.doubt("young", softest, "Pa", 1e6, "MPa")
            _check.doubt("the largest depth", deepest, "m", 1e-3, "mm")
        return
    skin, tip = document.skin, document.tip
    sizes = [("thickness", layer.thickness, LARGEST) for layer in skin.layers or ()]
    sizes += [("radius of [skin]", skin.radius or 0.0, _LONGEST)]
    sizes += [("pitch of ridges", 0.0 if skin.ridges is None else skin.ridges.pitch, _RIDGE)]
    sizes += [("radius of [tip]", 0.0 if tip is None else tip.radius, _LONGEST)]
    sizes += [("length of [touch]", document.touch.length or 0.0, _LONGEST)]
    for name, value, largest in sizes:
        if value > largest:
            _check.doubt(name, value, "m", 1e-3, "mm")
