"""How far a contact strains the skin, for the theory is one of small strains."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from .._check import FloatArray
from ..contact import PressureProfile
from ..errors import SingularPointWarning

if TYPE_CHECKING:
    from .solution import ContactSolution

__all__ = ["greatest_slope", "greatest_strain"]

_DEPTHS = (0.1, 0.3, 0.6, 1.0)
_PLACES = np.linspace(-1.0, 1.0, 7)
_NODES = 32


def greatest_strain(pressed: ContactSolution) -> float:
    """Greatest principal strain (its size) at a few depths beneath the contact, or what its slope squared adds up to.

    Not at the surface itself: beneath a sharp end it is infinite there, however gently one presses. The slope s is that
    of the surface over a sixteenth of the contact; it strains by s^2 / 2, which the linear theory leaves out.
    """
    if pressed.case.influence.periodic:
        # waves on a flat skin: u k is the slope of the surface, and of the order of the strain beneath it
        k = 2 * np.pi / (pressed.case.step * pressed.case.y.size)
        return float(0.5 * k * pressed.certificate.scale)
    low, high = float(pressed.edges[0, 0]), float(pressed.edges[-1, 1])
    a = max(0.5 * (high - low), pressed.case.step)
    depth = np.minimum(np.array(_DEPTHS) * a, pressed.skin.thickness)
    positions = 0.5 * (low + high) + a * _PLACES
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SingularPointWarning)
        strain = pressed.skin.strain(_thinned(pressed, low, high), depth[:, None], positions)
    mean, half = 0.5 * (strain.xx + strain.yy), 0.5 * (strain.xx - strain.yy)
    linear = float(np.nanmax(np.abs(mean) + np.hypot(half, strain.xy)))
    turned = _slope(pressed, pressed.gap - np.where(np.isfinite(pressed.gap), pressed.case.height, 0.0))
    return max(linear, 0.5 * turned**2)


def greatest_slope(pressed: ContactSolution) -> float:
    """Greatest slope between the undeformed bodies where they touch, over a sixteenth of the contact."""
    return _slope(pressed, pressed.case.height)


def _slope(pressed: ContactSolution, height: FloatArray) -> float:
    """Greatest slope of a line over a sixteenth of the contact, within any one place that touches."""
    span = max(1, int((pressed.pressure > 0).sum()) // 16)
    rises = np.abs(height[span:] - height[:-span])
    touching = np.concatenate([[0], np.cumsum(pressed.pressure > 0)])
    whole = touching[span + 1 :] - touching[: -span - 1] == span + 1
    return float(rises.max(initial=0.0, where=whole & np.isfinite(rises))) / (span * pressed.case.step)


def _thinned(pressed: ContactSolution, low: float, high: float) -> PressureProfile:
    """The same tractions by few straight lines, of the same resultants."""
    step = pressed.case.step
    wide = max((high - low) / (_NODES - 2), step)
    nodes = np.arange(low - wide, high + 1.5 * wide, wide)
    parts = []
    for values in (pressed.pressure, pressed.shear):
        share = (pressed.y - nodes[0]) / wide
        at = np.clip(np.floor(share).astype(np.intp), 0, nodes.size - 2)
        part = np.clip(share - at, 0.0, 1.0)
        total = np.bincount(at, values * (1 - part), nodes.size) + np.bincount(at + 1, values * part, nodes.size)
        parts.append(total * step / wide)
    return PressureProfile(nodes, *parts)
