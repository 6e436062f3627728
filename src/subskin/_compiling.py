"""What is done as soon as a loop has to be compiled: some seconds pass then, once after installation."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

__all__ = ["when_compiling"]


@contextmanager
def when_compiling(call: Callable[[], object]) -> Iterator[None]:
    """Within this context, `call` before Numba compiles for the first time; never where all that runs was kept.

    Parameters
    ----------
    call : callable
        Is called without arguments, in the thread that compiles.

    Examples
    --------
    >>> import numba
    >>> with when_compiling(lambda: print("compiling")):
    ...     numba.njit(lambda x: x + 1)(1)
    compiling
    2
    """
    first = _First(call)
    event.register("numba:compile", first)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister("numba:compile", first)  # type: ignore[no-untyped-call]


class _First(event.Listener):
    def __init__(self, call: Callable[[], object]) -> None:
        self._call: Callable[[], object] | None = call

    def on_start(self, _: Any) -> None:
        call, self._call = self._call, None
        if call is not None:
            call()

    def on_end(self, _: Any) -> None:
        pass
