"""Classes that are found by name: one is registered by being defined."""

from __future__ import annotations

from typing import Any, ClassVar

from ._frozen import Frozen
from .errors import InvalidValueError

__all__ = ["Named"]


class Named(Frozen):
    """What keeps its subclasses by the name that they are defined with: `class Hertz(SpreadContact, name="hertz")`.

    A class that is not found by name gives none, and does not inherit one.
    """

    _by_name: ClassVar[dict[str, type[Any]]]

    def __init_subclass__(cls, *, name: str = "", **more: Any) -> None:
        super().__init_subclass__(**more)
        if Named in cls.__bases__:
            cls._by_name = {}
        if not name:
            return
        other = cls._by_name.get(name, cls)
        if (other.__module__, other.__qualname__) != (cls.__module__, cls.__qualname__):
            rule = f"{other.__module__}.{other.__qualname__} has that name"
            raise InvalidValueError(f'name="{name}" of {cls.__qualname__}', rule, "another name")
        cls._by_name[name] = cls
