"""A kind of contact that may have pressed: a family and its widths, two touches at once, or none of these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ... import _check
from ...contact import Hertz, LineLoad, LocalContact, PointLoad
from ...contact.families import Family, LocalFamily, checked_family, family_of, local_families, local_family_of
from ...errors import InvalidValueError
from ..answer import Status

__all__ = ["NONE", "PAIR", "RECTANGLES", "Kind"]

PAIR, NONE, RECTANGLES = "pair", "none", ("edge", "patch")
"""In place of a family's name: two line loads at once; what is near to one of the others, and none of them; a
rectangle on an area, by either name."""
_SAID = ("cannot tell", *(status.name.lower().replace("_", " ") for status in Status))


@dataclass(frozen=True)
class Kind:
    """A kind of contact that may have pressed, and what is known of it before a reading is seen.

    Parameters
    ----------
    name : str
        What the answer calls it.
    family : {"line", "wedge", "hertz", "strip", "punch", "pair", "none"} or subclass of SpreadContact
        Its pressure's shape; on an area "point", "cone", "round_hertz", "round_punch", or a subclass of
        RoundContact, and "edge" or "patch": a force spread evenly over a rectangle that is turned anyhow. "pair": two
        line loads, of which `half_width` is half the distance. "none": near to one of the other kinds, but off by a
        model error of 1 to 30 % of the readings, or in a plane of another shape (docs/deciding.md).
    half_width : (float, float)
        Least and largest half width [m], all between being as probable; both 0 for a line, left out for "none".
    prior : float
        How probable it is, relative to the other kinds.
    stick : float
        Share of such contacts that stick in their middle, in [0, 1): of "hertz" alone.
    half_length : (float, float)
        Least and largest half length of an "edge" or a "patch" [m], all between being as probable; of no other family.

    Raises
    ------
    InvalidValueError
        An unknown family, widths out of order or of a line, a prior that is not > 0, a share that sticks of another
        family, half lengths out of order or of another family.

    Examples
    --------
    >>> import subskin as ss
    >>> ss.decide.Kind("edge", "wedge", half_width=(0.2e-3, 0.7e-3)).prior
    1.0
    """

    name: str
    family: str | Family | LocalFamily
    half_width: tuple[float, float] = (0.0, 0.0)
    prior: float = 1.0
    stick: float = 0.0
    half_length: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InvalidValueError(
                f"name = {_check.shown(self.name)}", "a kind needs a name", 'Kind("vertex", "wedge", ...)'
            )
        if self.name in _SAID:
            raise InvalidValueError(f'name = "{self.name}"', "answers without a kind are called so", "another name")
        checked_family(self.family)
        named = self.family in (PAIR, NONE, *RECTANGLES)
        narrow = self.family == NONE or (not named and issubclass(self._class(), LineLoad | PointLoad))
        ends = _check.real("half_width", self.half_width, unit="m", at_least=0.0)
        if ends.shape != (2,) or not ends[0] <= ends[1]:
            raise InvalidValueError(
                f"half_width = {self.half_width!r}",
                "two half widths, ascending, are needed",
                "half_width=(0.1e-3, 1e-3)",
            )
        seen = f"half_width = {self.half_width!r} of a {'line or point load' if narrow and not named else self.family}"
        if narrow and ends[1] > 0:
            raise InvalidValueError(seen, "it has none", "leave out half_width")
        if not narrow and not ends[1] > 0 and self.family not in RECTANGLES:
            raise InvalidValueError(seen, "its largest half width has to be > 0", "half_width=(0.1e-3, 1e-3)")
        _check.scalar("prior", self.prior, above=0.0)
        share = _check.scalar("stick", self.stick, at_least=0.0)
        if not share < 1 or (share > 0 and (named or not issubclass(self._class(), Hertz))):
            rule = 'a share in [0, 1), of the family "hertz" alone, can stick'
            raise InvalidValueError(f"stick = {self.stick!r} of {self.family!r}", rule, "stick=0.0")
        self._check_length()

    def _check_length(self) -> None:
        ends = _check.real("half_length", self.half_length, unit="m", at_least=0.0)
        seen = f"half_length = {self.half_length!r} of {self.family!r}"
        if self.family not in RECTANGLES:
            if ends.any():
                raise InvalidValueError(seen, "only an edge or a patch has a length", "leave out half_length")
        elif ends.shape != (2,) or not 0 < ends[0] <= ends[1]:
            rule = "an edge, or a patch, needs two half lengths > 0, ascending"
            raise InvalidValueError(seen, rule, "half_length=(1e-3, 4e-3)")

    def _class(self) -> Family | LocalFamily:
        """The family's class, of long contacts or of those on an area."""
        family: Any = self.family
        if isinstance(family, str) and family in local_families():
            return local_families()[family]
        if isinstance(family, type) and issubclass(family, LocalContact):
            return local_family_of(family)  # type: ignore[arg-type]
        return family_of(family)

    def unknowns(self, friction: float) -> int:
        """Number of unknowns of such a contact, its drag among them where there is friction; 0 of "none".

        Parameters
        ----------
        friction : float
            As in `contact_type`.

        Examples
        --------
        >>> import subskin as ss
        >>> ss.decide.Kind("edge", "wedge", half_width=(0.2e-3, 0.7e-3)).unknowns(1.0)
        4
        """
        friction = _check.friction(friction)
        if self.family == NONE:
            return 0
        if self.family in RECTANGLES:
            open_ends = sum(high > low for low, high in (self.half_width, self.half_length))
            return 4 + 2 * (friction > 0) + open_ends
        if self.family != PAIR and issubclass(self._class(), LocalContact):
            return 3 + 2 * (friction > 0) + (self.half_width[1] > self.half_width[0])
        touches = 1 + (self.family == PAIR)
        return touches * (2 + (friction > 0)) + (self.family != PAIR and self.half_width[1] > self.half_width[0])
