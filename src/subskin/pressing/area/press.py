"""A rigid body pressed into a skin on an area: which tractions hold it there (docs/pressing_area.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ... import _check
from ..._check import FloatArray
from ...errors import GeometryError, InvalidValueError
from ...skin import Skin
from ..body import LocalIndenter
from ..solution import PressStatus
from ..verdict import judged, not_small
from .balance import AreaBalance, AreaCase
from .box import AreaGrid, continued, fresh
from .certify import certified, moved_by
from .load import Asked, asked, pair
from .solution import LocalSolution

__all__ = ["press_area"]

_TOLERANCE = 1e-8


def press_area(
    skin: Skin,
    body: LocalIndenter,
    given: dict[str, Any],
    position: Any,
    grid: dict[str, Any],
    after: object,
    max_strain: float | None,
) -> LocalSolution:
    """As `press`, of a body on an area; `given` is what is prescribed, `grid` nodes, window and tolerance."""
    for name in ("period", "datum"):
        if grid[name] is not None:
            raise InvalidValueError(f"{name} = {grid[name]}", f"a body on an area takes no {name}", f"leave out {name}")
    load = asked(given.pop("friction"), **given)
    centred = np.ndim(position) == 0 and position == 0  # what is left out
    at = np.zeros(2) if centred else pair("position", position, "m")
    tolerance = _TOLERANCE if grid["tolerance"] is None else grid["tolerance"]
    box = AreaGrid.checked(grid["nodes"], grid["window"], tolerance)
    if after is None:
        case, state = fresh(skin, body, _Gap(body), load, box)
    else:
        case, state = _next(_same(after, skin, body, at, load), load, grid, box)
    moved = moved_by(case, state)
    certificate = certified(case, state, moved)
    held = load.friction is not None and bool(state.shear.any())
    for values in (state.pressure, state.shear):
        values.flags.writeable = False
    slip, lateral = np.moveaxis(moved.slip, 0, -1), moved.lateral
    pressed = LocalSolution(
        skin, body, at, PressStatus.OK, "", certificate, case, state, *map(_check.read_only, (moved.gap, slip, lateral))
    )
    if max_strain is not None:
        _believable(pressed, float(_check.real("max_strain", max_strain, above=0.0, finite=False)))
    slips = held and not pressed.stick.any()
    status, reason = judged(certificate, case.tolerance, int((state.pressure > 0).sum()), slips, load.friction)
    return replace(pressed, status=status, reason=reason)


def _same(after: object, skin: Skin, body: LocalIndenter, at: FloatArray, load: Asked) -> LocalSolution:
    """The state before, if it is one of this contact."""
    if not isinstance(after, LocalSolution):
        seen = f"after = {repr(after)[:60]}"
        raise InvalidValueError(seen, "what an earlier press on an area returned is needed", "after=press(...)")
    case = after.case
    height = body.height(case.y[:, None], case.z)
    if after.skin != skin or not np.array_equal(after.position, at) or not np.array_equal(height, case.height):
        seen, rule = "after= of another skin, indenter or position", "the history of friction is that of one contact"
        raise GeometryError(seen, rule, "press the same bodies at the same position")
    if (load.friction is None) != (after.friction is None):
        rule, fix = "the shear of the state before needs something to hold it", "friction= for each step of a history"
        raise InvalidValueError("friction in one of two presses only", rule, fix)
    return after


def _next(after: LocalSolution, load: Asked, grid: dict[str, Any], box: AreaGrid) -> tuple[AreaCase, AreaBalance]:
    """The next problem on the grid of the last, and its solution; slip counts from there."""
    for name in ("nodes", "window"):
        if grid[name] is not None:
            seen = f"{name} = {grid[name]} after another press"
            raise GeometryError(seen, "a press goes on with the grid of the one before", f"{name}= of the first press")
    before, state = after.case, after.state
    shift = after.lateral - before.rigid(state.slide, state.twist)
    case = replace(before, load=load, shift=shift, tolerance=box.tolerance)
    return case, continued(case, after.state, after.indenter)


@dataclass(frozen=True)
class _Gap:
    """The gap of the undeformed bodies, y and z from the body's centre; it pickles where the body does."""

    body: LocalIndenter

    def __call__(self, y: FloatArray, z: FloatArray) -> FloatArray:
        shape = np.broadcast_shapes(np.shape(y), np.shape(z))
        own = self.body.height(y, z)
        found: FloatArray = _check.returned(f"{type(self.body).__name__}.height", own, shape, exactly=True)
        return found


def _believable(pressed: LocalSolution, limit: float) -> None:
    """Raise where the strain is above the limit, warn where strains or slopes are not small.

    The strain is judged by the greatest displacement over the contact's width, or over the thickness of the skin: half
    of a / R beneath a sphere, whose greatest strain is 0.51 a / R at nu = 1/2.
    """
    long = max(2 * float(pressed.half_width.max()), pressed.case.step)
    short = max(pressed.area / long, pressed.case.step)
    strain = pressed.certificate.scale / min(short, pressed.skin.thickness)
    touch = pressed.pressure > 0
    span = max(1, int(short / pressed.case.step) // 16)
    slope = 0.0
    for height, on in ((pressed.case.height, touch), (pressed.case.height.T, touch.T)):
        both = on[span:] & on[:-span]
        rises = np.abs(np.where(both, height[span:], 0.0) - np.where(both, height[:-span], 0.0))
        slope = max(slope, float(rises.max(initial=0.0)) / (span * pressed.case.step))
    large = not_small(f"a force of {pressed.force:.6g} N", strain, slope, limit)
    if large:
        _check.warn(large)
