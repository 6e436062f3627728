"""How loops are compiled: one decorator, and a cache that is thrown away when what a loop is built on has changed."""

from __future__ import annotations

import gc
import re
import sys
from collections.abc import Callable
from functools import cache
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

import numba as nb
from numba.core.event import Event, Listener, register

__all__ = ["compiled", "is_cached"]

_ORDERED = {"nsz", "arcp", "contract"}  # not nnan, ninf: NaN and infinity have a meaning in every loop
_FAST = _ORDERED | {"reassoc"}
_IMPORT = re.compile(r"^from (\.[\w.]*) import (\([^)]*\)|.*)$", re.MULTILINE)


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


def compiled(*, inline: bool = False, exact: bool = False, borrows: bool = False) -> Callable[[Any], Any]:
    """Compile a function with Numba, without the interpreter's lock, and keep the result on disk.

    Numba looks at the function's own file alone when it decides whether what it kept is still good. Here the files
    count as well from which this file imports its functions and constants, and the files from which those do.

    Parameters
    ----------
    inline : bool, optional
        Put its body in place of each call.
    exact : bool, optional
        Keep the order in which sums are written, so that a stretch of frames gives the same bits however it is cut.
    borrows : bool, optional
        Of a function that makes no array: do not count who holds those it is given, or parts of them. Counting took
        half the time of a loop that cuts a dozen parts a frame.

    Examples
    --------
    >>> from subskin.estimate.climb import eliminate
    >>> eliminate.py_func(2.0, 0.0, 1.0, 80.0, 10.0, 1.0)[:2]  # of `@compiled(inline=True)`
    (40.0, 10.0)
    """

    def wrap(function: Any) -> Any:
        if nb.config.DISABLE_JIT:  # type: ignore[attr-defined]
            return function
        options: dict[str, Any] = {"fastmath": _ORDERED if exact else _FAST, "inline": "always" if inline else "never"}
        options["no_cfunc_wrapper"] = True  # nothing calls them from C
        if borrows:
            options["_nrt"] = False
        loop: Any = nb.njit(cache=True, nogil=True, error_model="numpy", **options)(function)
        changed = _changed(function.__module__)
        if any(index.stat().st_mtime_ns < changed for index in _indices(loop)):
            loop.recompile()
        return loop

    return wrap


@cache
def _changed(module: str) -> int:
    """When the newest of the files changed that a file with loops is built on, itself among them [ns]."""
    path = Path(str(sys.modules[module].__file__))
    text, newest = path.read_text(encoding="utf-8"), path.stat().st_mtime_ns
    if "@compiled(" in text:  # what other files import does not get into a loop
        package = sys.modules[module].__package__
        for base, names in _IMPORT.findall(text):
            source = resolve_name(base, package)
            within = {f"{source}.{name}" for name in re.findall(r"\w+", names)} & sys.modules.keys()
            newest = max(newest, *(_changed(built_on) for built_on in within or {source}))
    return newest


def is_cached(loop: Any) -> bool:
    """Whether a loop need not be compiled any more."""
    return not hasattr(loop, "signatures") or bool(loop.signatures) or bool(_indices(loop))  # plain Python needs none


def _indices(loop: Any) -> list[Path]:
    """Numba's index of what it has kept of a loop where it stands now: those of other lines are never written again."""
    code = loop.py_func.__code__
    name = f"{Path(code.co_filename).stem}.{loop.py_func.__qualname__}-{code.co_firstlineno}.*.nbi"
    return list(Path(str(loop.stats.cache_path)).glob(name))
