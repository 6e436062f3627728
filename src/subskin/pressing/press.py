"""A rigid body pressed into a skin: which tractions hold it there (docs/pressing.md)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError, ValidityWarning
from ..skin import Skin
from ._strain import greatest_strain
from .certificate import certify, displaced
from .equilibrium import Case, Load, State, solve
from .indenter import Indenter
from .influence import influence
from .solution import ContactSolution, PressStatus
from .window import chosen_window

__all__ = ["press"]

_FEWEST = 12
"""Nodes in contact below which its shape is not drawn, unless the body itself is that narrow."""
_WIDER = 5
_NOTABLE = 0.2
"""Strain from which the linear theory is off by more than a sensor's usual noise."""


def press(
    skin: Skin,
    indenter: Indenter,
    *,
    force: float | None = None,
    depth: float | None = None,
    moment: float | None = None,
    tilt: float = 0.0,
    friction: float | None = None,
    tangential: float | None = None,
    slide: float | None = None,
    after: ContactSolution | None = None,
    position: float = 0.0,
    nodes: int = 1024,
    window: float | None = None,
    period: float | None = None,
    datum: float | None = None,
    tolerance: float = 1e-9,
    max_strain: float = 0.5,
) -> ContactSolution:
    """Press a rigid body into a skin and find the tractions, where they touch, and where they stick.

    The pressure is drawn by straight lines between equally spaced nodes, and gap and slip vanish at the nodes. With the
    spacing s of the nodes, strains beneath converge as s^2 where the bodies part smoothly, and as s beneath a sharp end
    of the body; the contact's edges converge as s. Source: docs/pressing.md.

    Parameters
    ----------
    skin : Skin
        Any skin. On a round one y runs along the arc, and its roundness is part of the gap.
    indenter : Indenter
        A shape of the catalogue (`Cylinder`, `RoundedFlat`, `RoundedWedge`, `SineRidges`, `ParticleOnFlat`, `Flat`,
        `Edge`) or a `Profile`.
    force, depth : float, optional
        Normal force [N/m] or how far the indenter goes in from first touching the tangent plane at y = 0 [m], > 0:
        one of the two.
    moment, tilt : float, optional
        Moment of the pressure about `position` [N], with the tilt to be found; or the tilt [rad], kept. Positive
        loads the side of +y. No tilt if left out.
    friction : float, optional
        Coulomb's coefficient, >= 0; np.inf for surfaces that stick wherever they touch. Without it there is no shear.
    tangential, slide : float, optional
        Tangential force on the skin [N/m] or the indenter's way along the surface [m], towards +y; with friction only.
        No tangential force if left out.
    after : ContactSolution, optional
        The state before, on which friction depends; same skin, indenter, position and grid. The start is untouched.
    position : float, optional
        Place of the indenter's centre y [m].
    nodes : int, optional
        Nodes of the grid, >= 16.
    window : float, optional
        Width of the grid about `position` [m]; about one and a half times the contact's if left out.
    period : float, optional
        Solve for a body that repeats with this period [m], all along a flat skin; force and moment are those of one
        period. The skin's mean level counts as its surface where it has no ground.
    datum : float, optional
        Distance at which the surface of a skin without a ground (a half plane, or layers on one) is taken to rest [m].
        Its displacements are known only up to a constant, so that `depth` and `slide` need it.
    tolerance : float, optional
        Greatest gap beneath the body and greatest creep where it sticks, in shares of the displacements' range.
    max_strain : float, optional
        Strain above which the theory of small strains is not believed and an error is raised; np.inf to see anyway.

    Returns
    -------
    ContactSolution
        With `contact` for `Finger.read`, a certificate, a status and a reason.

    Raises
    ------
    InvalidValueError
        A force or depth that is not positive or both or neither of them; a body that never touches; a drag without
        friction; strains above `max_strain`.
    GeometryError
        A window, period or earlier state that does not fit; a moment that no pressure beneath the body has.

    Warns
    -----
    ValidityWarning
        Strains above 20 %.

    Examples
    --------
    Hertz's cylinder: a = sqrt(4 P R / (pi E*)), E* = E / (1 - nu^2).

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> pressed = ss.press(skin, ss.Cylinder(radius=8e-3), force=40.0)
    >>> pressed.status.name, round(pressed.half_width * 1e3, 3)
    ('OK', 0.874)
    >>> finger = ss.Finger(skin, ss.SensorArray.line(4, pitch=2e-3, depth=2e-3))
    >>> finger.read(pressed.contact).shape
    (4,)
    """
    load = _load(force, depth, moment, tilt, friction, tangential, slide)
    at = _check.scalar("position", position, unit="m")
    limit = _check.scalar("tolerance", tolerance, above=0.0)
    count = int(_check.scalar("nodes", nodes, at_least=16))
    width, repeat, rest = (
        None if value is None else _check.scalar(name, value, unit="m", above=0.0)
        for name, value in (("window", window), ("period", period), ("datum", datum))
    )
    if not skin.grounded and repeat is None and rest is None and (depth is not None or slide is not None):
        given = "depth" if depth is not None else "slide"
        raise InvalidValueError(
            f"{given} = {depth if depth is not None else slide:.6g} m on a {type(skin).__name__}",
            "this skin has no ground, so its surface moves by a constant that is not known",
            "datum=, the distance at which the surface is taken to rest; or press by force",
        )

    def gap(y: FloatArray) -> FloatArray:
        return np.asarray(indenter.height(y) + skin.surface_drop(y + at))

    if after is not None:
        case = _continued(after, skin, indenter, at, load, limit)
        state = solve(case, _start(after))
    elif repeat is not None:
        case = _case(
            skin, gap, load, (-repeat / 2, repeat / 2), count, limit, periodic=_repeats(skin, repeat, load)
        )
        state = solve(case)
    else:
        ends = (
            (-width / 2, width / 2)
            if width is not None
            else chosen_window(skin, indenter, gap, load, at, rest)
        )
        for _ in range(_WIDER):
            case = _case(skin, gap, load, ends, count, limit, datum=rest)
            state = solve(case)
            if width is not None or not any(_cut_off(case, state, indenter)):
                break
            grow = 0.25 * (ends[1] - ends[0])
            ends = tuple(
                end + sign * grow * cut
                for end, sign, cut in zip(ends, (-1, 1), _cut_off(case, state, indenter))
            )  # type: ignore[assignment]
    if not case.influence.periodic and any(_cut_off(case, state, indenter)):
        raise GeometryError(
            f"a window of {case.step * case.y.size:.6g} m",
            "the contact reaches its end, and would go on beyond",
            "give a wider window" + (" to the first press" if after is not None else "") + ", or less force",
        )
    moved = displaced(case.influence, case, state, case.height, case.shift)
    known = skin.grounded or rest is not None or repeat is not None
    pressed = ContactSolution(
        skin, indenter, at, PressStatus.OK, "", certify(case, state, moved),
        depth=state.depth if known else np.nan, slide=state.slide if known and load.friction is not None else np.nan,
        case=case, state=state, gap=_check.read_only(moved.gap), slip=_check.read_only(moved.slip),
        lateral=_check.read_only(moved.lateral),
    )  # fmt: skip
    _believable(pressed, float(_check.real("max_strain", max_strain, above=0.0, finite=False)))
    status, reason = _judged(pressed)
    return replace(pressed, status=status, reason=reason)


def _load(
    force: float | None,
    depth: float | None,
    moment: float | None,
    tilt: float,
    friction: float | None,
    tangential: float | None,
    slide: float | None,
) -> Load:
    """What is prescribed, checked."""
    if (force is None) == (depth is None):
        raise InvalidValueError(f"force = {force}, depth = {depth}", "one of the two has to be given")
    if moment is not None and tilt:
        raise InvalidValueError(f"moment = {moment}, tilt = {tilt}", "one of the two can be given")
    if tangential is not None and slide is not None:
        raise InvalidValueError(f"tangential = {tangential}, slide = {slide}", "one of the two can be given")
    values = {}
    for name, value, unit in (("force", force, "N/m"), ("depth", depth, "m")):
        if value is not None and not _check.scalar(name, value, unit=unit) > 0:
            raise InvalidValueError(
                f"{name} = {float(value):.6g} {unit}",
                "the indenter never touches the skin",
                f"give a {name} > 0",
            )
        values[name] = None if value is None else float(value)
    for name, value, unit in (
        ("moment", moment, "N"),
        ("tangential", tangential, "N/m"),
        ("slide", slide, "m"),
    ):
        values[name] = None if value is None else _check.scalar(name, value, unit=unit)
    if friction is None:
        for name in ("tangential", "slide"):
            if values[name]:
                raise InvalidValueError(
                    f"{name} = {values[name]:.6g}",
                    "nothing is dragged without friction",
                    "give friction=, e.g. 0.5",
                )
        values["tangential"] = values["slide"] = None
        return Load(**values, tilt=_check.scalar("tilt", tilt, unit="rad"), friction=None)
    grip = np.inf if friction == np.inf else _check.scalar("friction", friction, at_least=0.0)
    if values["tangential"] is None and values["slide"] is None:
        values["tangential"] = 0.0
    return Load(**values, tilt=_check.scalar("tilt", tilt, unit="rad"), friction=grip)


def _case(
    skin: Skin,
    gap: Callable[[FloatArray], FloatArray],
    load: Load,
    ends: tuple[float, float],
    count: int,
    limit: float,
    *,
    periodic: bool = False,
    datum: float | None = None,
) -> Case:
    """The problem on `count` nodes, in the middle of as many equal parts of the window."""
    step = (ends[1] - ends[0]) / count
    if datum is not None and datum < ends[1] - ends[0]:
        raise GeometryError(
            f"datum = {datum:.6g} m", f"the surface rests beyond the window, {ends[1] - ends[0]:.6g} m wide"
        )
    y: FloatArray = np.asarray(ends[0] + step * (np.arange(count) + 0.5), dtype=np.float64)
    height = gap(y)
    _touchable(height, load, ends)
    op = influence(skin, step, count, periodic, datum)
    return Case(op, step, y, height, load, np.zeros(count), limit, gap, datum)


def _touchable(height: FloatArray, load: Load, ends: tuple[float, float]) -> None:
    if not np.isfinite(height).any():
        raise InvalidValueError(
            f"no part of the indenter between y = {ends[0]:.6g} and {ends[1]:.6g} m from its centre",
            "the indenter never touches the skin", "a wider window, or another position",
        )  # fmt: skip
    if load.depth is not None and not (height < load.depth).any() and not load.tilt:
        raise InvalidValueError(
            f"depth = {load.depth:.6g} m", "the indenter never touches the skin",
            f"its lowest point is {height.min():.6g} m above it",
        )  # fmt: skip


def _repeats(skin: Skin, period: float, load: Load) -> bool:
    if np.isfinite(skin.period):
        raise GeometryError(
            f"period = {period:.6g} m on a {type(skin).__name__}", "only a flat skin goes on and on"
        )
    if load.moment is not None or load.tilt:
        raise GeometryError(
            f"period = {period:.6g} m with a moment or a tilt", "a body that repeats does not turn"
        )
    return True


def _continued(
    after: ContactSolution, skin: Skin, indenter: Indenter, at: float, load: Load, limit: float
) -> Case:
    """The next state on the grid of the last; slip counts from there."""
    if after.skin != skin or after.indenter != indenter or after.position != at:
        raise GeometryError(
            "after= of another skin, indenter or position", "the history of friction is that of one contact",
            "press the same bodies at the same place",
        )  # fmt: skip
    shift = (
        after.lateral - after.state.slide
        if after.friction is not None
        else after.lateral - after.lateral.mean()
    )
    _touchable(after.case.height, load, (after.case.y[0], after.case.y[-1]))
    return replace(after.case, load=load, shift=shift, tolerance=limit)


def _start(after: ContactSolution) -> State:
    pressed = after.pressure > 0
    return replace(after.state, steps=0, touches=pressed, sticks=pressed)


def _cut_off(case: Case, state: State, indenter: Indenter) -> tuple[bool, bool]:
    """Whether the contact runs into either end of the window where the body goes on."""
    low, high = indenter.ends
    return (
        bool(state.pressure[0] > 0 and case.y[0] - 0.75 * case.step > low),
        bool(state.pressure[-1] > 0 and case.y[-1] + 0.75 * case.step < high),
    )


def _believable(pressed: ContactSolution, limit: float) -> None:
    strain = greatest_strain(pressed)
    if strain > limit:
        raise InvalidValueError(
            f"a force of {pressed.force:.6g} N/m", f"the skin would be strained by {100 * strain:.0f} %, "
            f"and small strains (here up to {100 * limit:.0f} %) are what the theory is for",
            "press less, with a blunter body, or say max_strain=np.inf to see the linear answer anyway",
        )  # fmt: skip
    if strain > _NOTABLE:
        message = f"strains up to {100 * strain:.0f} % beneath this contact: the linear theory is off by about as much"
        warnings.warn(message, ValidityWarning, stacklevel=3)


def _judged(pressed: ContactSolution) -> tuple[PressStatus, str]:
    """Status and reason, from the certificate alone."""
    case, certificate = pressed.case, pressed.certificate
    found = {name: value for name, value in vars(certificate).items() if name != "scale"}
    name, worst = max(found.items(), key=lambda item: item[1])
    bound = max(4 * case.tolerance, 1e-11)
    if worst > bound:
        return PressStatus.NOT_SETTLED, f"{name} is {worst:.2g}, and {bound:.2g} was to be reached"
    holds = f"every rule of contact holds to {worst:.1g}"
    touching = int((pressed.pressure > 0).sum())
    if case.load.friction is not None and not pressed.stick.size:
        return (
            PressStatus.SLIDES,
            f"{holds}; friction {case.load.friction:g} holds no more, all of the contact slips",
        )
    if touching < _FEWEST:
        return (
            PressStatus.COARSE,
            f"{holds}, but only {touching} nodes touch; more nodes or a narrower window",
        )
    return PressStatus.OK, f"{holds}, on {touching} nodes that touch"
