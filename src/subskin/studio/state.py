"""What a page shows of a finger, as its link holds it: the file, the touch, and how they are looked at."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field

from .._check import FloatArray
from ..contact import Contact, LineLoad, LocalContact, PointLoad, families, family_of, local_families, local_family_of
from ..errors import InvalidValueError
from ..finger import Finger
from .view import FromPage

__all__ = ["FingerState", "Look", "Touch", "Window", "first_touch", "fitting", "pressing"]

_Length = Annotated[float, Field(ge=-10.0, le=10.0)]
_STEEPEST = 1.4
"""Largest angle that a page offers [rad]."""
_SHARE = 0.05
"""Force over modulus and depth of the first touch."""
_NARROW = (LineLoad, PointLoad)


class Touch(FromPage):
    """A touch as a page has it, in SI: its family, where, how hard, how it leans and how wide it is."""

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
        try:
            return not issubclass(_class_of(self.family, self.local), _NARROW)
        except InvalidValueError:
            return False

    @property
    def components(self) -> FloatArray:
        """N and T [N/m], or N, Ty and Tz [N]."""
        drag = self.force * np.sin(self.angle)
        drags = (drag * np.cos(self.azimuth), drag * np.sin(self.azimuth)) if self.local else (drag,)
        return np.array([self.force * np.cos(self.angle), *drags])

    @property
    def contact(self) -> Contact | LocalContact:
        """What presses; an unknown family raises an InvalidValueError."""
        return pressing(self.family, self.components, self.position, self.half_width if self.wide else None)


class FingerState(FromPage):
    """All that a page shows of a finger: what its link holds."""

    text: str = Field(max_length=100_000)
    touch: Touch | None = None
    show: str | None = Field(default=None, max_length=40)
    find: str = Field(default="locate", pattern="^(locate|fit)$")
    seed: Annotated[int, Field(ge=0, le=2**31)] | None = 0


class Window(NamedTuple):
    """What is seen [m]."""

    left: float
    right: float
    front: float
    back: float
    bottom: float
    level: float


class Look(FromPage):
    """How a state is looked at.

    `edits` are numbers of the finger that change, as in `form.edited`. `window` is what is seen; that of the finger if
    left out: while a hand moves sensors, the picture stays. `moving`: a hand is at it, and where the field would take
    long a coarse one is enough. `refine`: nothing moves, and one more part of a field that is coarse is worked out.
    """

    edits: list[tuple[str, float | str]] = Field(default_factory=list, max_length=8)
    window: Window | None = None
    moving: bool = False
    refine: bool = False


def pressing(family: str, components: FloatArray, position: Any, half_width: float | None) -> Contact | LocalContact:
    """A contact under two components, which is long, or three, which is local.

    Parameters
    ----------
    family : str
        Its family.
    components : ndarray, shape (2,) or (3,)
        N and T [N/m], or N, Ty and Tz [N].
    position : sequence of float
        y, or y and z [m].
    half_width : float or None
        Of a family that has one [m].

    Raises
    ------
    InvalidValueError
        An unknown family, a value out of range.
    """
    wide = {} if half_width is None else {"half_width": half_width}
    local = len(components) == 3
    kind = _class_of(family, local)
    if local:
        return kind(components=components, position=tuple(position), **wide)  # type: ignore[no-any-return]
    return kind.of_components(components, position[0], **wide)  # type: ignore[no-any-return]


@lru_cache(maxsize=64)
def _class_of(family: str, local: bool) -> Any:
    """The class of a family, kept once it is known."""
    return local_family_of(family) if local else family_of(family)


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
