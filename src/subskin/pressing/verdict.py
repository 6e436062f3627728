"""What to make of a solution: whether its strains are small, and whether it obeys every rule."""

from __future__ import annotations

import warnings

import numpy as np

from .. import _check
from .._check import FloatArray
from ..contact import PressureProfile
from ..errors import InvalidValueError, SingularPointWarning
from .certificate import Certificate
from .indenter import Profile
from .solution import ContactSolution, PressStatus

__all__ = ["Judgement", "believable", "judged", "not_small"]

Judgement = tuple[PressStatus, str]

_FEWEST = 12
"""Nodes in contact below which its shape is not drawn."""
_NOTABLE = 0.2
"""Strain from which the linear theory is off by more than a sensor's usual noise."""
_STEEP = 0.5
"""Slope of a circle where the parabola that stands for it is 6 % too low."""
_BOUND = 4.0
"""Times the tolerance that any rule may be broken by: each solve stops at the tolerance, and a contact is several."""
_ROUNDING = 1e-11
_DEPTHS = (0.1, 0.3, 0.6, 1.0)
_PLACES = np.linspace(-1.0, 1.0, 7)
_NODES = 32


def believable(pressed: ContactSolution, limit: float) -> None:
    """Raise where the strains are above the limit, warn where they are not small."""
    strain, slope = _greatest_strain(pressed), _slope(pressed, pressed.case.height)
    large = not_small(f"a force of {pressed.force:.6g} N/m", strain, slope, limit)
    if isinstance(pressed.indenter, Profile) and _cut_short(pressed):
        message = "the contact reaches the end of the profile, which is taken for a sharp end of the body"
        _check.warn(message)
    if large:
        _check.warn(large)


def not_small(seen: str, strain: float, slope: float, limit: float) -> str:
    """Raise where the strain is above the limit; a warning's words where strain or slope are not small, or none."""
    if strain > limit:
        raise InvalidValueError(
            seen, f"the skin would be strained by {100 * strain:.0f} %, "
            f"and small strains (here up to {100 * limit:.0f} %) are what the theory is for",
            "press less, with a blunter body, or say max_strain=np.inf to see the linear answer anyway",
        )  # fmt: skip
    large = [f"strains up to {100 * strain:.0f} %"] if strain > _NOTABLE else []
    large += [f"slopes up to {slope:.2g}"] if slope > _STEEP else []
    rule = "beneath this contact: the linear theory takes them for small"
    return f"{' and '.join(large)} {rule}" if large else ""


def judged(certificate: Certificate, tolerance: float, touching: int, slips: bool, friction: float | None) -> Judgement:
    """Status and reason: is every rule obeyed, says the certificate alone.

    Parameters
    ----------
    certificate : Certificate
        What was found.
    tolerance : float
        What was asked for.
    touching : int
        Nodes that touch.
    slips : bool
        Whether there is a drag one way, and no node that sticks.
    friction : float, optional
        Coulomb's coefficient; None where there is none.
    """
    found = {name: value for name, value in vars(certificate).items() if name != "scale"}
    name, worst = max(found.items(), key=lambda item: item[1])
    bound = max(_BOUND * tolerance, _ROUNDING)
    if worst > bound:
        return PressStatus.NOT_SETTLED, f"{name} is {worst:.2g}, and {bound:.2g} was to be reached"
    holds = f"every rule of contact holds to {worst:.1g}"
    if slips and friction:
        return PressStatus.SLIDES, f"{holds}; friction {friction:g} holds no more, all of the contact slips"
    if touching < _FEWEST:
        return PressStatus.COARSE, f"{holds}, but only {touching} nodes touch; more nodes or a narrower window"
    return PressStatus.OK, f"{holds}, on {touching} nodes that touch"


def _cut_short(pressed: ContactSolution) -> bool:
    """Whether the contact reaches an end at which the profile still rises: more of it would have touched."""
    body, step = pressed.indenter, pressed.case.step
    for edge, end, inwards in zip(pressed.edges[[0, -1], [0, 1]], body.ends, (1, -1), strict=True):
        near = end + inwards * np.array([0.0, 0.02]) * (body.ends[1] - body.ends[0])
        if abs(edge - pressed.position - end) < step and np.diff(body.height(near))[0] < 0:
            return True
    return False


def _greatest_strain(pressed: ContactSolution) -> float:
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


def _slope(pressed: ContactSolution, height: FloatArray) -> float:
    """Greatest slope of a line, such as that between the undeformed bodies, over a sixteenth of what touches."""
    span = max(1, int((pressed.pressure > 0).sum()) // 16)
    known = np.where(np.isfinite(height), height, np.nan)  # a body may have ended
    rises = np.abs(known[span:] - known[:-span])
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
