"""How nouns and results travel: into pickles, copies and other processes without caches, their arrays closed."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from functools import cache, cached_property
from typing import Any, ClassVar, Self

import numpy as np

from .errors import InvalidValueError

__all__ = ["Frozen", "Named", "Result", "close"]

_FEW, _LONG = 4, 300


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
        close(state.values())
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


class Result(Frozen):
    """A dataclass of many numbers, of which a person sees the shapes and the ends.

    Examples
    --------
    >>> import subskin as ss
    >>> skin = ss.HalfPlane(ss.Material(young=0.4e6))
    >>> ss.design.spatial_response(ss.Finger(skin, ss.SensorArray([0.0], depth=2e-3)), [0.0, 1e2, 2e2, 3e2, 4e2])
    SpatialResponse(finger=Finger(...), wavenumber=(5,) from 0 to 400, amplitude=(5, 1, 2) of complex128)
    """

    def __init_subclass__(cls, **more: Any) -> None:
        super().__init_subclass__(**more)
        cls.__repr__ = _brief  # type: ignore[method-assign]  # which a dataclass leaves alone


def _brief(thing: Any) -> str:
    """What a dataclass shows of itself, its arrays and what else is long made short."""
    told = (f"{f.name}={_briefly(getattr(thing, f.name, None))}" for f in fields(thing) if f.repr)
    return f"{type(thing).__qualname__}({', '.join(told)})"


def _briefly(value: Any) -> str:
    """An array by its numbers where they are few, else by its shape and ends; a thing of several lines by its kind."""
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        if value.size <= _FEW:
            return repr(value.tolist()) if value.dtype.kind in "biu" else _numbers(value)
        known = value[np.isfinite(value)] if value.dtype.kind == "f" else value
        ends = dict.fromkeys(f"{end:.4g}" for end in (known.min(), known.max())) if known.size else ["nan"]
        return f"{value.shape} from {' to '.join(ends)}" if len(ends) > 1 else f"{value.shape} of {next(iter(ends))}"
    if isinstance(value, np.ndarray):
        return f"{value.shape} of {value.dtype}"
    if isinstance(value, dict) and any(isinstance(one, np.ndarray) for one in value.values()):
        return f"{{{', '.join(f'{name}: {_briefly(one)}' for name, one in value.items())}}}"
    shown = repr(value)
    return f"{type(value).__name__}(...)" if "\n" in shown or len(shown) > _LONG else shown


def _numbers(value: Any) -> str:
    """Numbers in their brackets."""
    if value.ndim == 0:
        return f"{float(value):.6g}"
    return f"[{', '.join(map(_numbers, value))}]"


@cache
def _kept(kind: Any) -> frozenset[str]:
    """Names under which instances keep what they have worked out."""
    return frozenset(
        n for base in kind.__mro__ for n, value in vars(base).items() if isinstance(value, cached_property)
    )


def close(values: Iterable[object]) -> None:
    """Close arrays to writing, also those in lists and mappings."""
    for value in values:
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        elif isinstance(value, dict):
            close(value.values())
        elif isinstance(value, list | tuple):
            close(value)
