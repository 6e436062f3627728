"""A rigid body pressed into a skin: which tractions hold it there (docs/pressing.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeAlias, overload

import numpy as np

from .. import _check
from .._check import FloatArray
from ..errors import GeometryError, InvalidValueError
from ..skin import Skin
from .body import LocalIndenter
from .case import Asked, along_axes, asked
from .certificate import certify, displaced
from .grid import Grid, continued, fresh
from .indenter import Indenter
from .solution import ContactSolution, LocalSolution, PressStatus
from .verdict import believable, judged

__all__ = ["press"]

Pair: TypeAlias = Any
"""One number of a long body, two along (y, z) of one that presses on an area."""

_FARTHEST = 1e6
"""Positions beyond it [m] are no bodies', and take the digits of the grid."""


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
    if not isinstance(indenter, LocalIndenter):
        _check.noun("indenter", indenter, Indenter, "Cylinder(radius=8e-3), Sphere(radius=8e-3), or a Profile")
        _check.pair(f"{type(indenter).__name__}.ends", indenter.ends, "return -np.inf, np.inf", "m")
    kind: Any = LocalSolution if isinstance(indenter, LocalIndenter) else ContactSolution
    axes = 2 if kind is LocalSolution else 1
    load = asked(
        axes, force=force, depth=depth, moment=moment, tilt=tilt, tangential=tangential, slide=slide, torsion=torsion,
        twist=twist, friction=friction,
    )  # fmt: skip
    asked_of = Grid.checked(axes, nodes, window, period, datum, tolerance)
    centred = np.ndim(position) == 0 and position == 0  # what is left out
    at = (
        np.zeros(axes)
        if centred
        else along_axes("position", position, "m", axes, at_least=-_FARTHEST, at_most=_FARTHEST)
    )
    if abs(at[0]) > 0.25 * skin.period:
        seen = f"position = {at[0]:.6g} m on a finger of {skin.period:.6g} m about"
        rule = "a body comes from above, and reaches the quarter on either side of y = 0"
        raise GeometryError(seen, rule, "turn the finger: put its sensors, not the body, elsewhere")
    gap, here = _Gap(skin, indenter, float(at[0])), at if axes == 2 else float(at[0])
    if after is not None:
        _same(after, kind, skin, here, gap, load)
    known = axes == 2 or skin.grounded or asked_of.period is not None or asked_of.datum is not None
    if not (known or (after is not None and after.known)) and (load.depth is not None or load.slide is not None):
        name, far = ("slide", load.slide) if load.depth is None else ("depth", load.depth)
        raise InvalidValueError(
            f"{name} = {np.ravel(np.asarray(far))[0]:.6g} m on a {type(skin).__name__}",
            "this skin has no ground, so its surface moves by a constant that is not known",
            "datum=, the distance at which the surface is taken to rest; or press by force",
        )
    if after is not None:
        case, state = continued(after.case, after.state, after.lateral, asked_of, load, indenter)
    else:
        case, state = fresh(skin, indenter, gap, load, asked_of)
    moved = displaced(case, state)
    certificate = certify(case, state, moved)
    slip = _check.read_only(moved.slip[0] if axes == 1 else np.moveaxis(moved.slip, 0, -1))
    fields = case, state, _check.read_only(moved.gap), slip, _check.read_only(moved.lateral)
    pressed = kind(skin, indenter, here, PressStatus.OK, "", certificate, *fields)
    if max_strain is not None:
        believable(pressed, _check.scalar("max_strain", max_strain, above=0.0, finite=False))
    drag = state.shear.reshape(axes, -1).compress((state.pressure > 0).ravel(), axis=1)
    one_way = axes == 2 or (drag > 0).all() or (drag < 0).all()
    slips = bool(drag.any() and one_way and not pressed.stick.any())
    status, reason = judged(certificate, case.tolerance, drag.shape[1], slips, load.friction)
    return replace(pressed, status=status, reason=reason)  # type: ignore[no-any-return]


@dataclass(frozen=True)
class _Gap:
    """The gap of the undeformed bodies, from the indenter's centre; on a row with what the skin itself drops."""

    skin: Skin
    indenter: Any
    at: float

    def __call__(self, *mesh: FloatArray) -> FloatArray:
        shape = np.broadcast_shapes(*map(np.shape, mesh))
        said, own = f"{type(self.indenter).__name__}.height", self.indenter.height(*mesh)
        found: FloatArray = _check.returned(said, own, shape, exactly=True)
        return np.asarray(found + self.skin.surface_drop(mesh[0] + self.at)) if len(mesh) == 1 else found


def _same(after: Any, kind: Any, skin: Skin, at: Pair, gap: _Gap, load: Asked) -> None:
    """Refuse a state before that is not one of this contact."""
    area = kind is LocalSolution
    if not isinstance(after, kind):
        rule = f"what an earlier press{' on an area' * area} returned is needed"
        raise InvalidValueError(f"after = {repr(after)[:60]}", rule, "after=press(...)")
    height = gap(*after.case.mesh)
    if after.skin != skin or not np.array_equal(after.position, at) or not np.array_equal(height, after.case.height):
        seen, rule = "after= of another skin, indenter or position", "the history of friction is that of one contact"
        raise GeometryError(seen, rule, "press the same bodies at the same position")
    rule = "the shear of the state before needs something to hold it"
    if area and (load.friction is None) != (after.friction is None):
        raise InvalidValueError("friction in one of two presses only", rule, "friction= for each step of a history")
    if load.friction is None and after.shear.any():
        raise InvalidValueError("no friction after a press with friction", rule, f"friction={after.friction:g}")
