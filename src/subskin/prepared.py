"""What is made once of a finger, or of a skin, and kept: tables, locators; bounded in number, never pickled."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import Lock
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

from .finger import Finger

__all__ = ["Prepared", "prepared", "tabulated"]

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
        self._changing = Lock()

    def __reduce__(self) -> tuple[type[Prepared], tuple[int]]:
        """Travel empty: what is kept is made again where it is wanted."""
        return Prepared, (self._most,)

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
            with self._changing:
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


_tables = Prepared(most=256)


def tabulated(key: tuple[Any, ...], make: Callable[[], T]) -> T:
    """A table of a skin, kept by the value of its `key`, for all fingers of such a skin.

    What `make` returns has to follow from the key alone, down to its last bit: then no result depends on what was asked
    for before. It is made each time where the key has no hash, as with a skin of one's own that can be changed.

    Parameters
    ----------
    key : tuple
        What the table is made from: its name, the skin, the transducer, lengths [m].
    make : callable
        Makes it.

    Examples
    --------
    >>> import subskin as ss
    >>> one, same = (ss.HalfPlane(ss.Material(young=0.4e6)) for _ in range(2))
    >>> tabulated(("example", one), lambda: "made"), tabulated(("example", same), lambda: "made anew")
    ('made', 'made')
    """
    try:
        hash(key)
    except TypeError:
        return make()
    return _tables.get(key, make)
