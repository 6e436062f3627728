"""What to make of a solution: whether its strains are small, and whether it obeys every rule."""

from __future__ import annotations

import warnings

import numpy as np

from ..errors import InvalidValueError, ValidityWarning
from ._strain import greatest_slope, greatest_strain
from .indenter import Profile
from .solution import ContactSolution, PressStatus

__all__ = ["believable", "judged"]

_FEWEST = 12
"""Nodes in contact below which its shape is not drawn."""
_NOTABLE = 0.2
"""Strain from which the linear theory is off by more than a sensor's usual noise."""
_STEEP = 0.5
"""Slope of a circle where the parabola that stands for it is 6 % too low."""
_BOUND = 4.0
"""Times the tolerance that any rule may be broken by: each solve stops at the tolerance, and a contact is several."""
_ROUNDING = 1e-11


def believable(pressed: ContactSolution, limit: float) -> None:
    """Raise where the strains are above the limit, warn where they are not small."""
    strain, slope = greatest_strain(pressed), greatest_slope(pressed)
    if strain > limit:
        raise InvalidValueError(
            f"a force of {pressed.force:.6g} N/m", f"the skin would be strained by {100 * strain:.0f} %, "
            f"and small strains (here up to {100 * limit:.0f} %) are what the theory is for",
            "press less, with a blunter body, or say max_strain=np.inf to see the linear answer anyway",
        )  # fmt: skip
    if isinstance(pressed.indenter, Profile) and _cut_short(pressed):
        message = "the contact reaches the end of the profile, which is taken for a sharp end of the body"
        warnings.warn(message, ValidityWarning, stacklevel=3)
    large = [f"strains up to {100 * strain:.0f} %"] if strain > _NOTABLE else []
    large += [f"slopes up to {slope:.2g}"] if slope > _STEEP else []
    if large:
        message = f"{' and '.join(large)} beneath this contact: the linear theory takes them for small"
        warnings.warn(message, ValidityWarning, stacklevel=3)


def judged(pressed: ContactSolution) -> tuple[PressStatus, str]:
    """Status and reason: is every rule obeyed, says the certificate alone."""
    case, certificate = pressed.case, pressed.certificate
    found = {name: value for name, value in vars(certificate).items() if name != "scale"}
    name, worst = max(found.items(), key=lambda item: item[1])
    bound = max(_BOUND * case.tolerance, _ROUNDING)
    if worst > bound:
        return PressStatus.NOT_SETTLED, f"{name} is {worst:.2g}, and {bound:.2g} was to be reached"
    holds = f"every rule of contact holds to {worst:.1g}"
    touching = int((pressed.pressure > 0).sum())
    if _slides(pressed):
        return (PressStatus.SLIDES, f"{holds}; friction {case.load.friction:g} holds no more, all of the contact slips")
    if touching < _FEWEST:
        return (PressStatus.COARSE, f"{holds}, but only {touching} nodes touch; more nodes or a narrower window")
    return PressStatus.OK, f"{holds}, on {touching} nodes that touch"


def _slides(pressed: ContactSolution) -> bool:
    """Whether all of the contact is dragged one way by all that friction gives."""
    friction, q = pressed.friction, pressed.shear[pressed.pressure > 0]
    one_way = bool((q > 0).all() or (q < 0).all())
    return friction is not None and friction > 0 and one_way and not pressed.stick.size


def _cut_short(pressed: ContactSolution) -> bool:
    """Whether the contact reaches an end at which the profile still rises: more of it would have touched."""
    body, step = pressed.indenter, pressed.case.step
    for edge, end, inwards in zip(pressed.edges[[0, -1], [0, 1]], body.ends, (1, -1), strict=True):
        near = end + inwards * np.array([0.0, 0.02]) * (body.ends[1] - body.ends[0])
        if abs(edge - pressed.position - end) < step and np.diff(body.height(near))[0] < 0:
            return True
    return False
