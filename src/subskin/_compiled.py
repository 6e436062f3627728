"""How loops are compiled: one decorator, and a cache that is thrown away when what a loop is built on has changed.

Some seconds pass while a loop is compiled, once after installation. A loop over frames does not wait for them: it goes
over its first few in plain Python.
"""

from __future__ import annotations

import gc
import inspect
import logging
from collections.abc import Callable, Iterator
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import CodeType, FunctionType, ModuleType, SimpleNamespace
from typing import Any

import numba as nb
import numpy as np
from numba.core.caching import IndexDataCacheFile
from numba.core.event import Event, Listener, register

from ._cold import few

__all__ = ["compiled", "formula", "is_cached"]

_ORDERED = {"nsz", "arcp", "contract"}  # not nnan, ninf: NaN and infinity have a meaning in every loop
_FAST = _ORDERED | {"reassoc"}


class _NoSearch(Listener):
    """Python does not search for garbage while a loop of ours is compiled: nearly all that is made then is in use.

    The search took a sixth of the time.
    """

    def __init__(self) -> None:
        self._depth, self._searched = 0, False

    def on_start(self, event: Event) -> None:
        if _is_ours(event):
            if self._depth == 0:
                self._searched = gc.isenabled()
                gc.disable()
            self._depth += 1

    def on_end(self, event: Event) -> None:
        if _is_ours(event):
            self._depth -= 1
            if self._depth == 0 and self._searched:
                gc.enable()


def _is_ours(event: Event) -> bool:
    return str(event.data["dispatcher"].py_func.__module__).startswith(f"{__package__}.")


register("numba:compile", _NoSearch())  # type: ignore[no-untyped-call]


def compiled(
    *, inline: bool = False, exact: bool = False, borrows: bool = False, merged: bool = False, frames: str = ""
) -> Callable[[Any], Any]:
    """Compile a function with Numba, without the interpreter's lock, and keep the result on disk.

    Numba looks at the text of the function's own file when it decides whether what it kept is still good. Here the
    function itself counts, the constants it reads, and the functions it calls, wherever they stand.

    Parameters
    ----------
    inline : bool, optional
        Put its body in place of each call.
    exact : bool, optional
        Keep the order in which sums are written, so that a stretch of frames gives the same bits however it is cut.
    borrows : bool, optional
        Of a function that makes no array and returns none: do not count who holds those it is given, or parts of them.
        Counting took half the time of a loop that cuts a dozen parts a frame. An array that it returned would be given
        back twice.
    merged : bool, optional
        Put its machine code in place of each call, which the compiler else decides by its length.
    frames : str, optional
        Of a loop over frames: the argument whose first axis they are. As long as nothing was kept, the first 16 of
        them go in plain Python, and agree with the compiled ones to rounding.

    Examples
    --------
    >>> from subskin.estimate.cone import eliminate_one
    >>> eliminate_one.py_func(2.0, 80.0, 0.0, 50.0)[:2]  # of `@compiled(inline=True)`
    (40.0, 3200.0)
    """

    def wrap(function: Any) -> Any:
        if nb.config.DISABLE_JIT:  # type: ignore[attr-defined]
            return function
        options: dict[str, Any] = {"fastmath": _ORDERED if exact else _FAST, "inline": "always" if inline else "never"}
        options["no_cfunc_wrapper"] = True  # nothing calls them from C
        options["forceinline"] = merged
        if borrows:
            options["_nrt"] = False
        loop: Any = nb.njit(cache=True, nogil=True, error_model="numpy", **options)(function)
        _STAMPS[function], function.compiled_with = None, (inline, exact, borrows, merged)
        if (kept := _kept(loop)) is not None:
            kept.__class__, kept.function = _Kept, function
        if frames:
            loop._compile_for_args = _Plain(loop, inspect.getfullargspec(function).args.index(frames))
        return loop

    return wrap


def formula(function: Any) -> Any:
    """A pure function of an array namespace, `f(xp, ...)`, as loops call it with NumPy, put in place of its calls.

    So do those of the package that it calls.

    Examples
    --------
    >>> from subskin.contact.functions import line
    >>> formula(line).py_func(np, 2.0, 0.0)  # F and F' of a line load, two deep
    ((-0.0, 0.5), (-0.25, -0.0))
    """
    known = dict(function.__globals__)
    for name in function.__code__.co_names:
        called = known.get(name)
        if isinstance(called, FunctionType) and called.__module__.startswith(f"{__package__}."):
            known[name] = formula(called)
    return compiled(inline=True)(FunctionType(function.__code__, known, function.__name__, function.__defaults__))


_log = logging.getLogger("subskin")


class _Plain:
    """What a loop over frames is to be called as, where Numba has found no machine code for its arguments."""

    def __init__(self, loop: Any, at: int) -> None:
        self._loop, self._at, self._gone = loop, at, 0
        self._compile = loop._compile_for_args
        self._plain: Any = None

    def __call__(self, *given: Any) -> Any:
        if not is_cached(self._loop):
            self._gone += len(given[self._at])
            if self._gone <= few():
                return self._plainly
            _log.warning("subskin: compiling the estimator, once after installation; this takes some seconds")
        return self._compile(*given)

    def _plainly(self, *given: Any) -> Any:
        if self._plain is None:
            self._plain = _plain(self._loop.py_func, {})
        try:
            with np.errstate(all="ignore"):
                return self._plain(*given)
        except (ArithmeticError, ValueError):  # compiled, x / 0 is infinite, and the root of a negative number NaN
            return self._compile(*given)(*given)


def _plain(function: Any, made: dict[Any, Any]) -> Any:
    """The function in plain Python, and all that it calls."""
    if function not in made:
        known = dict(function.__globals__)
        made[function] = FunctionType(
            function.__code__, known, function.__name__, function.__defaults__, function.__closure__
        )
        for name in {*known} & {*function.__code__.co_names}:
            known[name] = _plainly(known[name], made)
    return made[function]


def _plainly(value: Any, made: dict[Any, Any]) -> Any:
    """What a function reads: a loop in plain Python, and those of a module of ours."""
    if (called := getattr(value, "py_func", None)) in _STAMPS:
        return _plain(called, made)
    if isinstance(value, ModuleType) and value.__name__.startswith(f"{__package__}."):
        return SimpleNamespace(
            **{name: _plainly(part, made) for name, part in vars(value).items() if not isinstance(part, ModuleType)}
        )
    return value


_STAMPS: dict[Any, bytes | None] = {}
"""Of each loop, once it has been asked for."""


class _Kept(IndexDataCacheFile):
    """Numba's file of a loop, with the loop's own stamp: taken when it is asked for, as a loop may call later ones."""

    function: Any

    @property
    def _source_stamp(self) -> bytes:
        stamp = _STAMPS[self.function] or _stamp(self.function)
        _STAMPS[self.function] = stamp
        return stamp

    def _load_index(self) -> Any:
        try:
            return super()._load_index()  # type: ignore[no-untyped-call]
        except (AttributeError, ImportError):  # it was made for a named tuple that is no more
            return {}


def _stamp(function: Any) -> bytes:
    """A digest of what its machine code depends on: how it is compiled, its bytecode, its constants, what it calls.

    Of a module of its package, and of a function that Numba is told how to compile, the text of the file counts.
    """
    given, parts = inspect.getclosurevars(function), [*_bytecode(function.__code__)]
    parts.append(repr(function.compiled_with).encode())
    package = function.__module__.partition(".")[0]
    for name, value in sorted({**given.globals, **given.nonlocals}.items()):
        parts.append(name.encode())
        if (called := getattr(value, "py_func", None)) in _STAMPS:
            parts.append(b"" if called is function else _STAMPS[called] or _stamp(called))
        elif isinstance(value, FunctionType | ModuleType):
            at = value.__name__ if isinstance(value, ModuleType) else value.__module__
            parts.append(_text(str(inspect.getsourcefile(value))) if at.partition(".")[0] == package else b"")
        else:
            fields = getattr(value, "_fields", None)  # of a class of named tuples
            parts.append(value.tobytes() if isinstance(value, np.ndarray) else repr((value, fields)).encode())
    return sha256(b"|".join(parts)).digest()


def _bytecode(code: CodeType) -> Iterator[bytes]:
    yield code.co_code + repr((code.co_names, code.co_varnames)).encode()
    for value in code.co_consts:
        yield from _bytecode(value) if isinstance(value, CodeType) else (repr(value).encode(),)


@cache
def _text(file: str) -> bytes:
    return sha256(Path(file).read_bytes()).digest()


def is_cached(loop: Any) -> bool:
    """Whether a loop need not be compiled any more."""
    if not hasattr(loop, "signatures") or loop.signatures:  # plain Python needs none
        return True
    kept = _kept(loop)
    return kept is not None and bool(kept._load_index())


def _kept(loop: Any) -> Any:
    """What Numba keeps of a loop on disk: nothing where no folder can be written."""
    return getattr(loop._cache, "_cache_file", None)
