"""Families of contacts by name, and what makes a contact of one."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import numpy.typing as npt

from .. import _check
from ..errors import InvalidValueError
from .base import Contact
from .line import LineLoad
from .local import LocalContact
from .round_contact import PointLoad, RoundContact
from .spread import ProportionalContact, SpreadContact

__all__ = ["Family", "LocalFamily", "contact_of", "families", "family_of", "local_families", "local_family_of"]

Family: TypeAlias = type[SpreadContact] | type[LineLoad]
"""A class of contacts that force, angle, position and, but for a line, a half width describe."""

LocalFamily: TypeAlias = type[RoundContact] | type[PointLoad]
"""A class of local contacts that components, position and, but for a point, a half width describe."""


def families() -> dict[str, Family]:
    """The families by name, one's own among them: what `fit`, `decide` and `simulate` take.

    A class joins by its definition, `class Mine(SpreadContact, name="mine")`.

    Examples
    --------
    >>> sorted(families())[:3]
    ['hertz', 'line', 'punch']
    """
    known = sorted(Contact._by_name.items())
    return {name: kind for name, kind in known if issubclass(kind, SpreadContact | LineLoad)}


def family_of(family: str | Family) -> Family:
    """The class of a named family, or one's own.

    Parameters
    ----------
    family : str or subclass of SpreadContact
        A name of `families`, or the class itself.

    Raises
    ------
    InvalidValueError
        An unknown name, something that is no contact of one width.

    Examples
    --------
    >>> family_of("line").__name__
    'LineLoad'
    """
    known = families()
    if isinstance(family, str):
        if family not in known:
            _check.choice("family", family, known, 'family="hertz"')
        return known[family]
    if isinstance(family, type) and issubclass(family, SpreadContact | LineLoad):
        return family
    seen = f"family = {_check.shown(family)}"
    raise InvalidValueError(seen, "a name or a subclass of SpreadContact is needed", f"one of {', '.join(known)}")


def checked_family(family: object) -> None:
    """Refuse what is neither a name nor a class: an array has no single answer to `==`."""
    if not isinstance(family, str | type):
        rule = "the name of a family, or a subclass of SpreadContact, on an area of RoundContact, is needed"
        raise InvalidValueError(f"family = {_check.shown(family)}", rule, '"hertz" on a row, "round_hertz" on an area')


def local_families() -> dict[str, LocalFamily]:
    """The families on an area by name, one's own among them: what `fit` takes of sensors on an area.

    A class joins by its definition, `class Mine(RoundContact, name="mine")`.

    Examples
    --------
    >>> sorted(local_families())
    ['cone', 'point', 'round_hertz', 'round_punch']
    """
    known = sorted(LocalContact._by_name.items())
    return {name: kind for name, kind in known if issubclass(kind, RoundContact | PointLoad)}


def local_family_of(family: str | Family | LocalFamily) -> LocalFamily:
    """The class of a named family on an area, or one's own.

    Parameters
    ----------
    family : str or subclass of RoundContact
        A name of `local_families`, or the class itself; any other is refused.

    Raises
    ------
    InvalidValueError
        An unknown name, the name of a long contact, something that is no contact on a disc.

    Examples
    --------
    >>> local_family_of("cone").__name__
    'Cone'
    """
    known = local_families()
    if isinstance(family, str) and family in known:
        return known[family]
    if isinstance(family, type) and issubclass(family, RoundContact | PointLoad):
        return family
    seen = f"family = {_check.shown(family)}"
    rule = f"on an area it has to be one of {', '.join(known)}, patch, or a subclass of RoundContact"
    raise InvalidValueError(seen, rule, 'family="round_hertz"')


def contact_of(family: str | Family, half_width: npt.ArrayLike | None = None) -> Callable[..., ProportionalContact]:
    """What makes contacts of a family from force, angle and position.

    Parameters
    ----------
    family : str or subclass of SpreadContact
        As in `family_of`.
    half_width : array_like, optional
        Half the width of the contacts [m]; a line has none.

    Raises
    ------
    InvalidValueError
        An unknown family, a width that is missing or that a line has not.

    Examples
    --------
    >>> touch = contact_of("hertz", 0.6e-3)(force=40.0, position=0.8e-3)
    >>> round(float(touch.pressure(0.8e-3)), 1)
    42441.3
    """
    kind = family_of(family)
    if issubclass(kind, LineLoad):
        if half_width is not None:
            raise InvalidValueError("a half width of a line", "a line load has none", 'a contact such as "hertz"')
        return kind
    if half_width is None:
        raise InvalidValueError(f"a {kind.__name__} without a width", "it needs a half width", "half_width=1e-3")
    return partial(kind, half_width=_check.real("half_width", half_width, unit="m", above=0.0))
