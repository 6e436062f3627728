"""How nouns and results travel: into pickles, copies and other processes without caches, their arrays closed."""

from __future__ import annotations

from functools import cache, cached_property
from typing import Any, Self

import numpy as np

__all__ = ["Frozen"]


class Frozen:
    """Base of what holds arrays or keeps what it has worked out.

    A copy is as good as what it was made of: its arrays are closed to writing, and what `cached_property` kept is left
    behind, to be worked out again where it is wanted.

    Examples
    --------
    >>> import copy, subskin as ss
    >>> array = copy.deepcopy(ss.SensorArray.line(count=4, pitch=2e-3, depth=2e-3))
    >>> array.y.flags.writeable
    False
    """

    def __getstate__(self) -> dict[str, Any]:
        kind: Any = type(self)
        kept = _kept(kind)
        return {name: value for name, value in self.__dict__.items() if name not in kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        _close(state)
        self.__dict__.update(state)

    @classmethod
    def filled(cls, values: dict[str, Any]) -> Self:
        """An instance with `values` by their names, which are right for certain, and closed.

        It skips the checks of the class, and the way by which a frozen dataclass sets its fields: that takes 2 us for
        ten of them, for which each frame of a live loop would wait.
        """
        made = object.__new__(cls)
        made.__dict__.update(values)
        return made

    def altered(self, **values: Any) -> Self:
        """A copy with other values, which are right for certain: unlike `replace`, it checks, and warns of, nothing."""
        made = object.__new__(type(self))
        made.__setstate__({**self.__getstate__(), **values})
        return made


@cache
def _kept(kind: Any) -> frozenset[str]:
    """Names under which instances keep what they have worked out."""
    return frozenset(
        n for base in kind.__mro__ for n, value in vars(base).items() if isinstance(value, cached_property)
    )


def _close(value: object) -> None:
    """Close arrays to writing, also those in lists and mappings."""
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, dict):
        for item in value.values():
            _close(item)
    elif isinstance(value, list | tuple):
        for item in value:
            _close(item)
