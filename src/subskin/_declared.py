"""Input checked once, by declaration: types say what a field or an argument is, `Real` its unit and bounds."""

from __future__ import annotations

import math
import sys
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from functools import cache, wraps
from inspect import Parameter, signature
from typing import Annotated, Any, Literal, ParamSpec, TypeAlias, TypeVar, Union, Unpack, cast, get_args, get_origin

import numpy as np
import numpy.typing as npt

from . import _check
from ._check import LARGEST, SMALLEST, FloatArray, NumberBounds, NumberLimits
from ._frozen import Frozen

__all__ = [
    "Angle",
    "Extent",
    "Fix",
    "Friction",
    "Length",
    "Noun",
    "Positive",
    "Real",
    "Rule",
    "Ruled",
    "Share",
    "Whole",
    "checked",
]

P = ParamSpec("P")
R = TypeVar("R")
Rule: TypeAlias = Callable[[str, Any], Any]
"""From the name of a value, and what was given, to what is kept; it raises where that is not as declared."""

_UNIONS = (Union, types.UnionType)
_MOST = 10**15  # in magnitude, of a whole number without bounds


class Real:
    """Unit and bounds of a number, or of all numbers of an array: `Annotated[float, Real("m", above=0.0)]`.

    An int becomes a float, a quantity of pint is converted to `unit`, an array becomes a read-only copy. True and False
    are no numbers.
    """

    def __init__(self, unit: str = "", **limits: Unpack[NumberBounds]) -> None:
        self._limits: NumberLimits = {**limits, "unit": unit}
        above, at_least, at_most = limits.get("above"), limits.get("at_least"), limits.get("at_most")
        lows = [-LARGEST] if at_least is None else [-LARGEST, at_least]
        if above is not None:
            lows.append(SMALLEST if above == 0.0 else math.nextafter(above, math.inf))
        self._low, self._high = max(lows), LARGEST if at_most is None else at_most

    def one(self, name: str, value: Any) -> float:
        """A single number, as a float."""
        if type(value) is float and self._low <= value <= self._high:
            return value  # the usual case, in no time
        return _check.scalar(name, value, **self._limits)

    def several(self, name: str, value: Any) -> FloatArray:
        """Numbers as an array of any shape."""
        if type(value) in (float, np.float64) or (
            type(value) is np.ndarray and value.dtype == np.float64 and value.size
        ):
            array = np.array(value)
            if np.minimum.reduce(array, axis=None) >= self._low and np.maximum.reduce(array, axis=None) <= self._high:
                array.flags.writeable = False
                return array  # the usual case, with one look at each end
        return _check.real(name, value, **self._limits)

    def pair(self, name: str, value: Any) -> tuple[float, float]:
        """Two numbers; whether they ascend is for others to say."""
        both = _check.pair(name, value, self._limits.get("fix", ""), self._limits["unit"])
        self.several(name, both)
        return both


@dataclass(frozen=True)
class Whole:
    """Least and greatest of a whole number: `Annotated[int, Whole(1, 1024)]`."""

    at_least: int
    at_most: int
    fix: str = ""

    def one(self, name: str, value: Any) -> int:
        """The number, as an int."""
        fix = self.fix or f"{name}={self.at_least}"
        return _check.whole(name, value, at_least=self.at_least, at_most=self.at_most, fix=fix)


@dataclass(frozen=True)
class Fix:
    """What may be written instead, in an error's words: `Annotated[Skin, Fix("finger.skin")]`."""

    text: str


@dataclass(frozen=True)
class Ruled:
    """A rule of one's own in place of what the type says: `Annotated[float, Ruled(rule)]`."""

    rule: Rule


Length: TypeAlias = Annotated[float, Real("m", above=0.0)]
Extent: TypeAlias = Annotated[float, Real("m", at_least=0.0)]
"""A length that may be 0."""
Angle: TypeAlias = Annotated[float, Real("rad")]
Positive: TypeAlias = Annotated[float, Real(above=0.0)]
Share: TypeAlias = Annotated[float, Real(at_least=0.0, at_most=1.0)]
Friction: TypeAlias = Annotated[float, Ruled(lambda name, value: _check.friction(value))]
"""A coefficient of friction, which may be infinite."""


class Noun(Frozen):
    """A frozen dataclass whose fields are checked, and made what they are declared to be, when one is made.

    A type says what is needed: `float` a single finite number, `int` a whole one, `bool` True or False, `str` a text, a
    `Literal` one of its texts, a class a thing of it, a tuple or a sequence several, `ArrayLike` an array of finite
    numbers. `Annotated` adds a unit and bounds (`Real`, `Whole`), the words of the error (`Fix`), or a rule of one's
    own (`Ruled`). None passes where the type has it. A class says by `EXAMPLE` how one of it is made, for errors that
    ask for one. Where fields depend on each other, `__post_init__` calls this one first.

    Raises
    ------
    InvalidValueError
        What was given, the rule, and what to write instead.

    Examples
    --------
    >>> @dataclass(frozen=True)
    ... class Coat(Noun):
    ...     thickness: Annotated[float, Real("m", above=0.0, fix="leave out a coat that is not there")]
    ...     side: Literal["outer", "inner"] = "outer"
    >>> Coat(1), Coat(1e-3).side
    (Coat(thickness=1.0, side='outer'), 'outer')
    >>> Coat(-1e-3)
    Traceback (most recent call last):
    subskin.errors.InvalidValueError: thickness = -0.001: has to be > 0 [m]. Fix: leave out a coat that is not there.
    """

    def __post_init__(self) -> None:
        own = self.__dict__
        kind: Any = type(self)
        for name, rule in _of_class(kind):
            own[name] = rule(name, own[name])

    def _common_shape(self) -> tuple[int, ...]:
        """The shape to which the arrays of its fields broadcast; a GeometryError gives each one's."""
        own, kind = self.__dict__, type(self)
        rules = _of_class(cast(Any, kind))
        return _check.broadcast(**{name: own[name] for name, _ in rules if isinstance(own[name], np.ndarray)})


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """The function, whose arguments are checked, and made what they are declared to be, before it begins.

    The declaration is as `Noun` has it, but for arrays: one is checked where it is `Annotated`. To be put beneath
    `@classmethod` and the like. It takes about 1 us a call.

    Examples
    --------
    >>> @checked
    ... def area(width: Length, height: Annotated[float, Real("m", above=0.0)] = 1.0) -> float:
    ...     return width * height
    >>> area(2)
    2.0
    >>> area(2.0, height=True)
    Traceback (most recent call last):
    subskin.errors.InvalidValueError: height = True: a real number or an array of them is needed.
    """
    kinds = {name: one.kind for name, one in signature(function).parameters.items()}
    in_order = [n for n, kind in kinds.items() if kind in (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)]

    @cache
    def declared() -> dict[str, Rule]:
        spread = (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
        hints = _evaluated(function.__annotations__, function.__globals__, {})
        return {
            name: rule for name, hint in hints if kinds.get(name, spread[0]) not in spread and (rule := _rule(hint))
        }

    @wraps(function)
    def ruled(*args: P.args, **named: P.kwargs) -> R:
        rules, first, rest = declared(), list(args), dict(named)
        for i, name in enumerate(in_order[: len(args)]):
            if name in rules:
                first[i] = rules[name](name, args[i])
        for name in rules.keys() & rest.keys():
            rest[name] = rules[name](name, rest[name])
        return function(*first, **rest)  # type: ignore[arg-type]

    return ruled


@cache
def _of_class(kind: Any) -> tuple[tuple[str, Rule], ...]:
    """The rules of a dataclass's fields, in their order."""
    hints: dict[str, Any] = {}
    for base in reversed(kind.__mro__):
        seen = vars(sys.modules.get(base.__module__, sys))
        hints.update(_evaluated(vars(base).get("__annotations__", {}), seen, vars(base)))
    declared = ((f.name, hints.get(f.name)) for f in fields(kind) if f.init)
    found = ((name, _numbers if hint in (npt.ArrayLike, FloatArray) else _rule(hint)) for name, hint in declared)
    return tuple((name, rule) for name, rule in found if rule)


def _evaluated(
    annotations: Mapping[str, Any], seen: Mapping[str, Any], own: Mapping[str, Any]
) -> Iterator[tuple[str, Any]]:
    """Annotations as types; those of a name that only type checkers see are left out, and so not checked."""
    space, within = dict(seen), dict(own)
    for name, hint in annotations.items():
        try:
            yield name, eval(hint, space, within) if isinstance(hint, str) else hint
        except (NameError, AttributeError, TypeError):
            continue


def _rule(hint: Any, more: tuple[Any, ...] = ()) -> Rule | None:
    """The rule of a type, with what is added to it; None where it asks for nothing."""
    if get_origin(hint) is Annotated:
        hint, *added = get_args(hint)
        return _rule(hint, (*added, *more))
    own = next((one.rule for one in more if isinstance(one, Ruled)), None)
    union = get_args(hint) if get_origin(hint) in _UNIONS else ()
    if type(None) in union:
        inner = _rule(Union[tuple(one for one in union if one is not type(None))], more)  # noqa: UP007
        return inner and (lambda name, value: None if value is None else inner(name, value))
    return own or _of_numbers(hint, more) or _of_things(hint, more, union)


def _of_numbers(hint: Any, more: tuple[Any, ...]) -> Rule | None:
    """The rule of a number, a pair, or an array."""
    number = next((one for one in more if isinstance(one, Real)), None)
    if hint is float:
        return (number or Real()).one
    if hint is int:
        return next((one for one in more if isinstance(one, Whole)), Whole(-_MOST, _MOST)).one
    if hint == tuple[float, float]:
        return (number or Real()).pair
    return number.several if number else None


def _of_things(hint: Any, more: tuple[Any, ...], union: tuple[Any, ...]) -> Rule | None:
    """The rule of what is no number."""
    origin, args = get_origin(hint), get_args(hint)
    fix = next((one.text for one in more if isinstance(one, Fix)), "")
    if hint is bool:
        return _check.flag
    if origin is Literal:
        return lambda name, value: _check.choice(name, value, args, fix)
    if origin is Callable:
        return _check.function
    if origin is np.ndarray:
        return None
    if isinstance(origin, type) and issubclass(origin, Iterable) and not issubclass(origin, Mapping):
        return _of_several(args, fix) if origin is not tuple or args[1:] == (...,) else None
    kinds = tuple(get_origin(one) or one for one in union or (hint,))
    if not all(
        isinstance(one, type) and one not in (object, Any) and not getattr(one, "_is_protocol", False) for one in kinds
    ):
        return None
    said = fix or getattr(kinds[0], "EXAMPLE", "")
    return lambda name, value: value if isinstance(value, kinds) else _check.noun(name, value, kinds, said)


def _of_several(args: tuple[Any, ...], fix: str) -> Rule | None:
    """The rule of several things of a class, as a tuple, or of several that have a rule each."""
    if isinstance(args[0], type) and args[0] not in (float, int, bool):
        return lambda name, values: _check.several(name, values, args[0], fix or f"[{getattr(args[0], 'EXAMPLE', '')}]")
    rule = _rule(args[0])
    if rule is None:
        return None
    return lambda name, values: tuple(
        rule(f"{name}[{i}]", one) for i, one in enumerate(_check.several(name, values, object, fix))
    )


_numbers = Real().several
