"""The touch that a page shows: its family, where, how hard, how it leans and how wide it is."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from ...contact import Contact, LineLoad, LocalContact, PointLoad, contact_of, families, local_families, local_family_of
from ...finger import Finger

__all__ = ["Touch", "first_touch", "fitting"]

_Length = Annotated[float, Field(ge=-10.0, le=10.0)]
_STEEPEST = 1.4
"""Largest angle that a page offers [rad]."""
_SHARE = 0.05
"""Force over modulus and depth of the first touch."""


class Touch(BaseModel):
    """A touch as a page has it, in SI."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    family: str = Field(max_length=40)
    force: float = Field(gt=0.0, le=1e7)
    angle: float = Field(ge=-_STEEPEST, le=_STEEPEST)
    azimuth: float = Field(default=0.0, ge=-7.0, le=7.0)
    position: Annotated[list[_Length], Field(min_length=1, max_length=2)]
    half_width: float = Field(gt=0.0, le=1.0)

    @property
    def local(self) -> bool:
        """Whether it ends along z."""
        return len(self.position) == 2

    @property
    def wide(self) -> bool:
        """Whether its family has a width."""
        kind: Any = local_families().get(self.family) if self.local else families().get(self.family)
        return kind is not None and not issubclass(kind, LineLoad | PointLoad)

    def contact(self) -> Contact | LocalContact:
        """What presses.

        Raises
        ------
        InvalidValueError
            An unknown family, a value out of range.
        """
        if not self.local:
            make = contact_of(self.family, self.half_width if self.wide else None)
            return make(force=self.force, angle=self.angle, position=self.position[0])
        local: Any = local_family_of(self.family)
        more = {"half_width": self.half_width} if self.wide else {}
        lean = abs(self.angle)
        turned = self.azimuth if self.angle >= 0 else self.azimuth + np.pi
        return local(force=self.force, angle=lean, azimuth=turned, position=tuple(self.position), **more)  # type: ignore[no-any-return]


def first_touch(finger: Finger) -> Touch:
    """A touch that strains the skin by some per cent where the sensors lie."""
    depth, area = float(np.asarray(finger.array.depth).mean()), finger.array.on_area
    middle = finger.array.points.mean(axis=0)
    where = [float(middle[0] + 0.4 * depth), float(middle[1] - 0.3 * depth)]
    young = min(material.young for material in finger.skin.materials)
    return Touch(
        family="round_hertz" if area else "hertz",
        force=_rounded(_SHARE * young * depth * (4 * depth if area else 1.0)),
        angle=float(np.deg2rad(15.0)),
        azimuth=float(np.deg2rad(45.0)) if area else 0.0,
        position=where if area else where[:1],
        half_width=_rounded((0.15 if area else 0.3) * depth),
    )


def fitting(touch: Touch | None, finger: Finger) -> Touch:
    """The touch, changed where this finger needs one of another kind: long for a row, local for an area."""
    if touch is None:
        return first_touch(finger)
    if touch.local == finger.array.on_area and touch.family in (local_families() if touch.local else families()):
        return touch
    first = first_touch(finger)
    where = (touch.position + first.position[1:])[: len(first.position)]
    return first.model_copy(update={"position": where, "angle": touch.angle, "half_width": touch.half_width})


def _rounded(value: float) -> float:
    return float(f"{value:.2g}")
