"""Functions of the public face as methods of their first argument."""

from __future__ import annotations

from importlib import import_module
from typing import Any

__all__ = ["Verb"]


class Verb:
    """A function of the public face whose first argument is the finger, as a method: found when it is first asked for.

    So `finger.locate(readings)` is `subskin.locate(finger, readings)`, and the finger knows no estimator.
    """

    def __init__(self, room: str = "") -> None:
        self._room = room  # where the function lives, if not at the top

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, finger: object, owner: type) -> Any:
        function = getattr(import_module(f"{__package__}{self._room}"), self._name)
        setattr(owner, self._name, function)  # from now on a method like any other
        return function.__get__(finger, owner)
