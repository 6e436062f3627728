"""Classes of one's own: what their members give is checked as they give it, so that an error names the member."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from functools import cached_property, wraps
from typing import Any, TypeAlias

import numpy as np

from . import _check
from .errors import InvalidValueError

__all__ = [
    "Rule", "batch_shape", "check_members", "each_of", "expanded", "field", "instance", "numbers", "optional",
    "truths", "wrong",
]  # fmt: skip

Rule: TypeAlias = Callable[[str, Any, Any, tuple[Any, ...]], Any]
"""From what the member is called, whose it is, what it gave and what it was given: what it gave, as it is used."""

_OURS = __name__.partition(".")[0]


def check_members(cls: type[Any], rules: Mapping[str, Rule]) -> None:
    """Check what a class from outside this package gives by those of its own members that `rules` names.

    Fields of a dataclass are left alone: they are not known before there is an instance.

    Raises
    ------
    InvalidValueError
        A method where there has to be a property.
    """
    if cls.__module__.partition(".")[0] == _OURS:
        return
    for name, rule in rules.items():
        member = vars(cls).get(name)
        if name not in vars(cls) or name in inspect.get_annotations(cls):
            continue
        above = next((vars(base)[name] for base in cls.__mro__[1:] if name in vars(base)), None)
        if inspect.isfunction(member) and isinstance(above, property):
            raise InvalidValueError(f"{cls.__name__}.{name}, a method", "a property is needed", "@property above it")
        if not getattr(member, "__isabstractmethod__", False):
            setattr(cls, name, _checked(cls, name, member, rule))


class _Given:
    """A plain value in a class, checked when it is read; an instance may have another."""

    def __init__(self, said: str, value: Any, rule: Rule) -> None:
        self._said, self._value, self._rule = said, value, rule

    def __get__(self, owner: Any, kind: Any) -> Any:
        return self._value if owner is None else self._rule(self._said, owner, self._value, ())


def _checked(cls: type[Any], name: str, member: Any, rule: Rule) -> Any:
    """The same member, whose answers follow the rule."""
    said = f"{cls.__name__}.{name}"

    def follow(function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def ruled(own: Any, *given: Any, **named: Any) -> Any:
            return rule(said, own, function(own, *given, **named), (*given, *named.values()))

        return ruled

    if isinstance(member, property):
        return property(follow(member.fget), member.fset, member.fdel) if member.fget else member
    if isinstance(member, cached_property):
        kept = cached_property(follow(member.func))
        kept.__set_name__(cls, name)
        return kept
    if isinstance(member, classmethod):
        return classmethod(follow(member.__func__))
    return follow(member) if inspect.isfunction(member) else _Given(said, member, rule)


def wrong(said: str, given: Any, rule: str, fix: str = "") -> InvalidValueError:
    """The error of a member that gave something else."""
    gave = f"an array of shape {given.shape}" if isinstance(given, np.ndarray) else _check.shown(given)
    return InvalidValueError(f"{said} gave {gave}", rule, fix)


def field(*, before: tuple[int, ...] = (), after: tuple[int, ...] = (), real: bool = False) -> Rule:
    """Numbers of the shape of the arguments, broadcast with the batch, between axes `before` and `after` it."""

    def rule(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
        try:
            shape = np.broadcast_shapes(getattr(own, "shape", ()), *map(np.shape, args))
        except ValueError:  # arguments that do not go with the batch: the caller's fault
            return given
        found = _check.returned(said, given, (*before, *shape, *after), exactly=real)
        if np.shape(found)[: len(before)] != before:
            raise wrong(said, given, f"{before[0]} functions are needed, on the first axis", "np.stack")
        return found

    return rule


def numbers(what: str, *, last: int | None = None, ndim: int | None = None) -> Rule:
    """Real numbers, of which the last axis has so many, or of so many axes."""

    def rule(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
        try:
            array = np.asarray(given)
        except ValueError:  # rows of different lengths
            raise wrong(said, given, f"real numbers are needed, {what}") from None
        fits = (last is None or array.shape[-1:] == (last,)) and ndim in (None, array.ndim)
        if array.dtype.kind not in "biuf" or not fits:
            raise wrong(said, given, f"real numbers are needed, {what}")
        return array.astype(np.float64, copy=False)

    return rule


def each_of(rules: tuple[Rule, ...], what: str, make: Callable[..., Any] = lambda *parts: parts) -> Rule:
    """Several things, each by its own rule, out of which one is made."""

    def rule(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
        if not isinstance(given, tuple | list) or len(given) != len(rules):
            raise wrong(said, given, f"{what} are needed")
        return make(
            *(one(f"{said}[{i}]", own, part, args) for i, (one, part) in enumerate(zip(rules, given, strict=True)))
        )

    return rule


def instance(kind: type | tuple[type, ...], what: str) -> Rule:
    """A thing of that kind."""

    def rule(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
        if not isinstance(given, kind):
            raise wrong(said, given, f"{what} is needed")
        return given

    return rule


def batch_shape(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    """The shape of a batch."""
    if not isinstance(given, tuple) or not all(isinstance(n, int) and n >= 0 for n in given):
        raise wrong(said, given, "a tuple of whole numbers is needed", "leave it out: components say it")
    return given


def truths(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
    """Yes or no for each point."""
    if np.asarray(field(real=True)(said, own, given, args)).dtype != np.bool_:
        raise wrong(said, given, "True or False is needed for each point")
    return given


def expanded(kind: type[Any]) -> Rule:
    """What `expand` gives: of the kind, with as many axes more as it was given, of length 1."""

    def rule(said: str, own: Any, given: Any, args: tuple[Any, ...]) -> Any:
        shape = (*own.shape, *(1,) * (args[0] if args else 1))
        if not isinstance(given, kind) or given.shape != shape:
            raise wrong(said, given, f"a {kind.__name__} of the shape {shape} is needed")
        return given

    return rule


def optional(inner: Rule) -> Rule:
    """As `inner`, or None."""
    return lambda said, own, given, args: None if given is None else inner(said, own, given, args)
