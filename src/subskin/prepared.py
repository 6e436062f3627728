"""What is made once of a finger and kept: tables, locators and their like, bounded in number, never pickled."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from .finger import Finger

__all__ = ["Prepared", "prepared"]

T = TypeVar("T")


class Prepared:
    """Things by what they were made from.

    Parameters
    ----------
    most : int, optional
        How many are kept; the one that was made first leaves.
    """

    def __init__(self, most: int = 32) -> None:
        self._kept: dict[Hashable, Any] = {}
        self._most = most

    def get(self, key: Hashable, make: Callable[[], T]) -> T:
        """What `make` returned when `key` was first asked for.

        Parameters
        ----------
        key : hashable
            What the thing is made from, by value; the first of it names the thing.
        make : callable
            Makes it.

        Examples
        --------
        >>> kept = Prepared()
        >>> kept.get(("square", 3), lambda: 9), kept.get(("square", 3), lambda: 1)
        (9, 9)
        """
        try:
            found: T = self._kept[key]
        except KeyError:
            found = make()
            if len(self._kept) >= self._most:
                self._kept.pop(next(iter(self._kept)))
            self._kept[key] = found
        return found


_fingers: WeakKeyDictionary[Finger, Prepared] = WeakKeyDictionary()


def prepared(finger: Finger) -> Prepared:
    """What is kept of a finger; it goes with the finger.

    Parameters
    ----------
    finger : Finger
        Never pickled with what is kept of it.

    Examples
    --------
    >>> import subskin as ss
    >>> finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(4, 2e-3, 2e-3))
    >>> prepared(finger) is prepared(finger)
    True
    """
    try:
        return _fingers[finger]
    except KeyError:
        return _fingers.setdefault(finger, Prepared())
