"""What to make of a solution: whether its strains are small, and whether it obeys every rule."""

from __future__ import annotations

import warnings

import numpy as np

from .. import _check
from .._check import FloatArray
from ..contact import PressureProfile
from ..errors import InvalidValueError, SingularPointWarning
from .case import hats
from .certificate import Certificate
from .scanned import Profile
from .shapes import Together
from .solution import ContactSolution, LocalSolution, PressStatus

__all__ = ["Judgement", "believable", "judged"]

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


def believable(pressed: ContactSolution | LocalSolution, limit: float) -> None:
    """Raise where the strains are above the limit, warn where strains or slopes are not small."""
    if isinstance(pressed, ContactSolution):
        if isinstance(pressed.indenter, Profile) and _cut_short(pressed):
            _check.warn("the contact reaches the end of the profile, which is taken for a sharp end of the body")
        strain, span, unit = _greatest_strain(pressed), int((pressed.pressure > 0).sum()) // 16, "N/m"
    else:
        # the greatest displacement over the contact's width, or over the thickness of the skin: half of a / R beneath
        # a sphere, whose greatest strain is 0.51 a / R at nu = 1/2
        each = _widths(pressed)
        strain = max(moved / min(short, pressed.skin.thickness) for moved, short in each)
        span, unit = int(min(short for _, short in each) / pressed.case.step) // 16, "N"
    if strain > limit:
        raise InvalidValueError(
            f"a force of {pressed.force:.6g} {unit}", f"the skin would be strained by {100 * strain:.0f} %, "
            f"and small strains (here up to {100 * limit:.0f} %) are what the theory is for",
            "press less, with a blunter body, or say max_strain=np.inf to see the linear answer anyway",
        )  # fmt: skip
    slope = _slope(pressed, pressed.case.height, max(1, span))
    large = [f"strains up to {100 * strain:.0f} %"] if strain > _NOTABLE else []
    large += [f"slopes up to {slope:.2g}"] if slope > _STEEP else []
    if large:
        _check.warn(f"{' and '.join(large)} beneath this contact: the linear theory takes them for small")


def _widths(pressed: LocalSolution) -> list[tuple[float, float]]:
    """Greatest displacement, and the contact's area over its longer side, [m]; beneath each body that touches."""
    step, scale, touching = pressed.case.step, pressed.certificate.scale, pressed.pressure > 0
    if not (isinstance(pressed.indenter, Together) and touching.any()):
        long = max(2 * float(pressed.half_width.max()), step)
        return [(scale, max(pressed.area / long, step))]
    own, out = pressed.indenter.lowest(pressed.case.y[:, None], pressed.case.z), []
    for body in np.unique(own[touching]):
        at = np.argwhere(touching & (own == body))
        long = step * float((np.ptp(at, axis=0) + 1).max())
        moved = float((pressed.state.depth - pressed.case.height[tuple(at.T)]).max())
        out.append((min(max(moved, 0.0), scale), max(len(at) * pressed.case.cell / long, step)))
    return out


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
    span = max(1, int((pressed.pressure > 0).sum()) // 16)
    turned = _slope(pressed, pressed.gap - np.where(np.isfinite(pressed.gap), pressed.case.height, 0.0), span)
    return max(linear, 0.5 * turned**2)


def _slope(pressed: ContactSolution | LocalSolution, height: FloatArray, span: int) -> float:
    """Greatest slope along an axis of what touches, such as that between the undeformed bodies, over `span` nodes."""
    known = np.where(np.isfinite(height), height, np.nan)  # a body may have ended
    greatest = 0.0
    for axis in range(known.ndim):
        values, touch = (np.moveaxis(one, axis, 0) for one in (known, pressed.pressure > 0))
        rises = np.abs(values[span:] - values[:-span])
        touching = np.cumsum(np.pad(touch, [(1, 0), *[(0, 0)] * (touch.ndim - 1)]), axis=0)
        whole = touching[span + 1 :] - touching[: -span - 1] == span + 1
        greatest = max(greatest, float(rises.max(initial=0.0, where=whole & np.isfinite(rises))))
    return greatest / (span * pressed.case.step)


def _thinned(pressed: ContactSolution, low: float, high: float) -> PressureProfile:
    """The same tractions by few straight lines, of the same resultants."""
    step = pressed.case.step
    wide = max((high - low) / (_NODES - 2), step)
    nodes = np.arange(low - wide, high + 1.5 * wide, wide)
    shares = hats(nodes, wide, pressed.y) * (step / wide)
    return PressureProfile(nodes, shares @ pressed.pressure, shares @ pressed.shear)
