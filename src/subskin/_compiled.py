"""How loops are compiled: one decorator, and a cache that is thrown away when what a loop is built on has changed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numba as nb

__all__ = ["compiled", "is_cached"]

_ORDERED = {"nsz", "arcp", "contract"}  # not nnan, ninf: NaN and infinity have a meaning in every loop
_FAST = _ORDERED | {"reassoc"}


def compiled(
    *, inline: bool = False, exact: bool = False, borrows: bool = False, built_on: tuple[ModuleType, ...] = ()
) -> Callable[[Any], Any]:
    """Compile a function with Numba, without the interpreter's lock, and keep the result on disk.

    Parameters
    ----------
    inline : bool, optional
        Put its body in place of each call.
    exact : bool, optional
        Keep the order in which sums are written, so that a stretch of frames gives the same bits however it is cut.
    borrows : bool, optional
        Of a function that makes no array: do not count who holds those it is given, or parts of them. Counting took
        half the time of a loop that cuts a dozen parts a frame.
    built_on : tuple of modules, optional
        Where compiled functions stand that it calls. Numba looks at the function's own file alone when it decides
        whether what it kept is still good; here the files of these modules count as well.

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
        changed = max((Path(str(m.__file__)).stat().st_mtime_ns for m in built_on), default=0)
        if any(index.stat().st_mtime_ns < changed for index in _indices(loop)):
            loop.recompile()
        return loop

    return wrap


def is_cached(loop: Any) -> bool:
    """Whether a loop need not be compiled any more."""
    return not hasattr(loop, "signatures") or bool(loop.signatures) or bool(_indices(loop))  # plain Python needs none


def _indices(loop: Any) -> list[Path]:
    """Numba's index of what it has kept of a loop where it stands now: those of other lines are never written again."""
    code = loop.py_func.__code__
    name = f"{Path(code.co_filename).stem}.{loop.py_func.__qualname__}-{code.co_firstlineno}.*.nbi"
    return list(Path(str(loop.stats.cache_path)).glob(name))
