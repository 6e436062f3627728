"""A rigid body pressed into a skin: which tractions hold it there (docs/pressing.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, overload

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..skin import Skin
from .area.press import press_area
from .area.solution import LocalSolution
from .body import LocalIndenter, pressing
from .certificate import certify, displaced
from .equilibrium import Prescribed
from .grid import Grid, continued, fresh
from .indenter import Indenter
from .solution import ContactSolution, PressStatus
from .verdict import believable, judged

__all__ = ["press"]

Pair: TypeAlias = Any
"""One number of a long body, two along (y, z) of one that presses on an area."""

_FARTHEST = 1e6
"""Positions beyond it [m] are no bodies', and take the digits of the grid."""
_UNITS = {"force": "N/m", "depth": "m", "moment": "N", "tangential": "N/m", "slide": "m"}


@overload
def press(skin: Skin, indenter: Indenter, **given: Any) -> ContactSolution: ...


@overload
def press(skin: Skin, indenter: LocalIndenter, **given: Any) -> LocalSolution: ...


def press(  # type: ignore[misc]  # each takes the names that are listed
    skin: Skin,
    indenter: Indenter | LocalIndenter,
    *,
    force: float | None = None,
    depth: float | None = None,
    moment: Pair | None = None,
    tilt: Pair | None = None,
    friction: float | None = None,
    tangential: Pair | None = None,
    slide: Pair | None = None,
    torsion: float | None = None,
    twist: float | None = None,
    after: ContactSolution | LocalSolution | None = None,
    position: Pair = 0.0,
    nodes: int | None = None,
    window: Pair | None = None,
    period: float | None = None,
    datum: float | None = None,
    tolerance: float | None = None,
    max_strain: float | None = 0.5,
) -> ContactSolution | LocalSolution:
    """Press a rigid body into a skin and find the tractions, where they touch, and where they stick.

    The pressure is drawn by straight lines between equally spaced nodes, and gap and slip vanish at the nodes. With the
    step s of the nodes, strains beneath converge as s^2 where the bodies part smoothly, and as s beneath a sharp end
    of the body; the contact's edges converge as s. Source: docs/pressing.md. A body that presses on an area has forces
    in N, and pairs along (y, z) where a long one has one number; its nodes are those of a grid of square cells, the
    pressure bilinear between them (docs/pressing_area.md).

    Parameters
    ----------
    skin : Skin
        Any skin. On a round one y runs along the arc, and its roundness is part of the gap. A body on an area presses
        into a `HalfSpace` or `Layered`.
    indenter : Indenter or LocalIndenter
        A long shape of the catalogue (`Cylinder`, `RoundedFlat`, `RoundedWedge`, `SineRidges`, `ParticleOnFlat`,
        `Flat`, `Edge`) or a `Profile`; or one that presses on an area (`Sphere`, `Ellipsoid`, `Roller`, `ConeTip`,
        `Pin`, `Box`, `BoxEdge`, `BoxCorner`, `RidgedBody`, `Together`) or a `HeightMap`.
    force, depth : float, optional
        Normal force [N/m; N on an area] or how far the indenter goes in from first touching the tangent plane at y = 0
        [m], > 0: one of the two.
    moment, tilt : float or pair, optional
        Moment of the pressure about `position` [N; N m on an area], with the tilt to be found; or the tilt [rad], kept.
        Positive loads the side of +y, or of +z. No tilt if left out.
    friction : float, optional
        Coulomb's coefficient [-], >= 0; without it there is no shear. np.inf for surfaces glued wherever they touch, as
        beneath a punch; where the extent of the contact has to be found, gluing asks for pulls, and seldom settles.
    tangential, slide : float or pair, optional
        Tangential force on the skin [N/m; N on an area] or the indenter's way along the surface [m], towards +y (and
        +z); with friction only. No tangential force if left out.
    torsion, twist : float, optional
        On an area: moment about x at `position` [N m] or the turn about it [rad], from y towards z; with friction only.
        No moment if left out, and no turn where the `slide` is given.
    after : ContactSolution or LocalSolution, optional
        The state before, on which friction depends; same skin, indenter and position. It brings its grid along.
    position : float or pair, optional
        Position of the indenter's centre, y or (y, z) [m].
    nodes : int, optional
        Nodes of the grid, >= 16, 1024 if left out; with a period, the power of two that is not less. On an area those
        along the longer side, a multiple of 32, 256 if left out.
    window : float or pair, optional
        Width of the grid about `position` [m]; about one and a half times the contact's if left out.
    period : float, optional
        Solve for a body that repeats with this period [m], all along a flat skin; force and moment are those of one
        period. The skin's mean level counts as its surface where it has no ground.
    datum : float, optional
        Distance at which the surface of a skin without a ground (a half plane, or layers on one) is taken to rest [m].
        Its displacements are known only up to a constant, so that `depth` and `slide` need it.
    tolerance : float, optional
        Greatest gap beneath the body and greatest creep where it sticks, in shares of the displacements; >= 1e-12.
        1e-9 if left out, on an area 1e-8.
    max_strain : float or None, optional
        Strain [-] above which the theory of small strains is not believed and an error is raised; np.inf to see anyway.
        None looks at no strain and warns of none, which saves time where a body is pressed many times.

    Returns
    -------
    ContactSolution or LocalSolution
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
        Strains above 20 %, slopes between the bodies in contact above 0.5.

    Examples
    --------
    Hertz's cylinder: a = sqrt(4 P R / (pi E*)), E* = E / (1 - nu^2).

    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.5))
    >>> pressed = ss.press(skin, ss.pressing.Cylinder(radius=8e-3), force=40.0)
    >>> pressed.status.name, round(pressed.half_width * 1e3, 3)
    ('OK', 0.874)
    >>> finger = ss.Finger(skin, ss.SensorArray.line(4, pitch=2e-3, depth=2e-3))
    >>> finger.read(pressed.contact).shape
    (4,)
    """
    _check.noun("skin", skin, Skin, "HalfPlane(Material(young=0.4e6))")
    if isinstance(indenter, LocalIndenter):
        given = {"force": force, "depth": depth, "moment": moment, "tilt": tilt, "friction": friction}
        given |= {"tangential": tangential, "slide": slide, "torsion": torsion, "twist": twist}
        area = {"nodes": nodes, "window": window, "period": period, "datum": datum, "tolerance": tolerance}
        return press_area(skin, indenter, given, position, area, after, max_strain)
    _check.noun("indenter", indenter, Indenter, "Cylinder(radius=8e-3), Sphere(radius=8e-3), or a Profile")
    for name, value in (("torsion", torsion), ("twist", twist)):
        if value is not None:
            raise InvalidValueError(f"{name} = {value}", "a long body does not turn about x", f"leave out {name}")
    _check.pair(f"{type(indenter).__name__}.ends", indenter.ends, "return -np.inf, np.inf", "m")
    load = _load(tilt, friction, force=force, depth=depth, moment=moment, tangential=tangential, slide=slide)
    grid = Grid.checked(nodes, window, period, datum, 1e-9 if tolerance is None else tolerance)
    return _press_long(skin, indenter, load, position, grid, after, max_strain)


def _press_long(
    skin: Skin, indenter: Indenter, load: Prescribed, position: float, grid: Grid, after: Any, max_strain: float | None
) -> ContactSolution:
    """`press`, in a plane."""
    at = _check.scalar("position", position, unit="m", at_least=-_FARTHEST, at_most=_FARTHEST)
    if abs(at) > 0.25 * skin.period:
        seen = f"position = {at:.6g} m on a finger of {skin.period:.6g} m about"
        rule = "a body comes from above, and reaches the quarter on either side of y = 0"
        raise GeometryError(seen, rule, "turn the finger: put its sensors, not the body, elsewhere")
    gap = _Gap(skin, indenter, at)
    if after is not None and isinstance(after, ContactSolution) and after.shear.any() and load.friction is None:
        rule, fix = "the shear of the state before needs something to hold it", f"friction={after.friction:g}"
        raise InvalidValueError("no friction after a press with friction", rule, fix)
    known = skin.grounded or grid.period is not None or grid.datum is not None
    if after is not None:
        _same(after, skin, at, gap)
        known = known or after.case.influence.periodic or after.case.datum is not None
    if not known and (load.depth is not None or load.slide is not None):
        given = "depth" if load.depth is not None else "slide"
        raise InvalidValueError(
            f"{given} = {load.depth if load.depth is not None else load.slide:.6g} m on a {type(skin).__name__}",
            "this skin has no ground, so its surface moves by a constant that is not known",
            "datum=, the distance at which the surface is taken to rest; or press by force",
        )
    if after is not None:
        case, state = continued(after.case, after.state, after.lateral, grid, load, indenter)
    else:
        case, state = fresh(skin, indenter, gap, load, grid)
    moved = displaced(case.influence, case, state, case.height, case.shift)
    fields = (_check.read_only(values) for values in (moved.gap, moved.slip, moved.lateral))
    depth = state.depth if known else np.nan
    slide = state.slide if known and load.friction is not None else np.nan
    certificate = certify(case, state, moved)
    pressed = ContactSolution(skin, indenter, at, PressStatus.OK, "", certificate, depth, slide, case, state, *fields)
    if max_strain is not None:
        believable(pressed, _check.scalar("max_strain", max_strain, above=0.0, finite=False))
    drag = pressed.shear[pressed.pressure > 0]
    one_way = bool((drag > 0).all() or (drag < 0).all())
    slips = one_way and not pressed.stick.size
    status, reason = judged(certificate, case.tolerance, drag.size, slips, load.friction)
    return replace(pressed, status=status, reason=reason)


@dataclass(frozen=True)
class _Gap:
    """The gap of the undeformed bodies, y from the indenter's centre."""

    skin: Skin
    indenter: Indenter
    at: float

    def __call__(self, y: FloatArray) -> FloatArray:
        own = _check.returned(f"{type(self.indenter).__name__}.height", self.indenter.height(y), y.shape, exactly=True)
        return np.asarray(own + self.skin.surface_drop(y + self.at))


def _same(after: ContactSolution, skin: Skin, at: float, gap: Callable[[FloatArray], FloatArray]) -> None:
    if not isinstance(after, ContactSolution):
        raise InvalidValueError(
            f"after = {repr(after)[:60]}", "what an earlier press returned is needed", "after=press(...)"
        )
    case = after.case
    if after.skin != skin or after.position != at or not np.array_equal(gap(case.y), case.height):
        seen, rule = "after= of another skin, indenter or position", "the history of friction is that of one contact"
        raise GeometryError(seen, rule, "press the same bodies at the same position")


def _load(tilt: float | None, friction: float | None, **given: float | None) -> Prescribed:
    """What is prescribed, checked."""
    if (given["force"] is None) == (given["depth"] is None):
        raise InvalidValueError(
            f"force = {given['force']}, depth = {given['depth']}",
            "one of the two has to be given",
            "force=40.0, or depth=0.1e-3",
        )
    turned = 0.0 if tilt is None else _check.scalar("tilt", tilt, unit="rad")
    grip = None if friction is None else _check.scalar("friction", friction, at_least=0.0, finite=False)
    asked = {**given, "tilt": turned or None}
    for one, other in (("moment", "tilt"), ("tangential", "slide")):
        if asked[one] is not None and asked[other] is not None:
            seen = f"{one} = {asked[one]}, {other} = {asked[other]}"
            raise InvalidValueError(seen, "one of the two can be given", "leave out one of them")
    values = {}
    for name, value in given.items():
        values[name] = None if value is None else _check.scalar(name, value, unit=_UNITS[name])
        if name in ("force", "depth"):
            pressing(name, values[name], _UNITS[name])
    if grip is None:
        for name in ("tangential", "slide"):
            if values[name]:
                seen = f"{name} = {values[name]:.6g}"
                raise InvalidValueError(seen, "nothing is dragged without friction", "give friction=, e.g. 0.5")
        values["tangential"] = values["slide"] = None
        return Prescribed(**values, tilt=turned, friction=None)
    if grip == 0 and values["tangential"]:
        seen = f"tangential = {values['tangential']:.6g} N/m at friction = 0"
        raise InvalidValueError(seen, "nothing holds that drag", "friction > 0")
    if values["tangential"] is None and values["slide"] is None:
        values["tangential"] = 0.0
    return Prescribed(**values, tilt=turned, friction=grip)
