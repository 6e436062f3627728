"""Pieces of work that do not know of each other: done by threads of this process, or by whatever takes them."""

from __future__ import annotations

import os
import pickle
import sys
from asyncio import CancelledError as _Dropped  # of Dask too
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, ThreadPoolExecutor
from functools import partial
from queue import SimpleQueue
from typing import Any, Protocol

from . import _check
from .errors import InvalidValueError, WorkersError

__all__ = ["Executor", "run_tasks"]


class Executor(Protocol):
    """What takes work: a pool of `concurrent.futures`, a `distributed.Client`, anything of the same kind.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> pool: Executor = ThreadPoolExecutor(2)
    """

    def submit(self, function: Callable[..., Any], /, *arguments: Any) -> Any:
        """Begin `function(*arguments)`; the future has `result`, `cancel` and `add_done_callback`."""


def threads(workers: int | None) -> int:
    """How many work at a time: as many as there are cores where nothing is said."""
    if workers is None:
        return os.cpu_count() or 1
    return _check.whole("workers", workers, at_least=1, at_most=4096, fix="leave it out for one on each core")


def run_tasks(
    tasks: Sequence[Callable[[], Any]],
    keep: Callable[[int, Any], object],
    *,
    executor: Executor | None = None,
    workers: int | None = None,
    passed: Callable[[int, Any], object] | None = None,
    stopping: Callable[[], object] | None = None,
) -> None:
    """Call each of `tasks`, and `keep` with the number and the result of each, in the order in which they finish.

    Parameters
    ----------
    tasks : sequence of callable
        Without arguments. For an executor in other processes they have to pickle.
    keep : callable
        Called in this thread, also for what finishes while the work is being stopped.
    executor : Executor, optional
        What does the work, and is not shut down; threads of this process, if left out.
    workers : int, optional
        How many threads; as many as there are cores if left out.
    passed : callable, optional
        Called after `keep`, with the same; not any more while the work is being stopped. What it raises stops it.
    stopping : callable, optional
        Called when the work is stopped, before running tasks are waited for.

    Raises
    ------
    InvalidValueError
        An executor without `submit`.
    WorkersError
        The executor has lost its workers, or they lack a module that the work is made of.

    Examples
    --------
    >>> from functools import partial
    >>> found = {}
    >>> run_tasks([partial(pow, 2, n) for n in range(4)], found.__setitem__)
    >>> [found[n] for n in range(4)]
    [1, 2, 4, 8]
    """
    if executor is not None and not callable(getattr(executor, "submit", None)):
        rule, fix = "something with submit is needed", "executor=concurrent.futures.ProcessPoolExecutor(4)"
        raise InvalidValueError(f"executor = {_check.shown(executor)}", rule, fix)
    own = ThreadPoolExecutor(threads(workers)) if executor is None else None
    pool = own or executor
    assert pool is not None
    finished: SimpleQueue[tuple[int, Any]] = SimpleQueue()
    waiting: dict[int, Any] = {}
    try:
        for number, task in enumerate(tasks):
            waiting[number] = pool.submit(_Packed(task))
            waiting[number].add_done_callback(partial(_put, finished, number))
        for _ in tasks:
            number, future = finished.get()
            result = future.result()
            del waiting[number]
            keep(number, result)
            if passed is not None:
                passed(number, result)
    except BaseException as error:
        for future in waiting.values():
            future.cancel()
        if stopping is not None:
            stopping()
        if own is not None:
            own.shutdown(wait=True)
        while not finished.empty():
            number, future = finished.get()
            if number in waiting and not future.cancelled() and future.exception() is None:
                keep(number, future.result())
        if (lost := _lost(error)) is not None:
            raise lost from error
        raise
    finally:
        if own is not None:
            own.shutdown(wait=True)


class _Packed:
    """A task that other processes unpack only when they call it: what they cannot load is then an error of the task.

    Dask would else lose the connection to the worker, and try again without end.
    """

    __name__ = "subskin"  # what Dask shows of it

    def __init__(self, task: Callable[[], Any]) -> None:
        self._task = task

    def __getstate__(self) -> bytes:
        packed: bytes = sys.modules.get("cloudpickle", pickle).dumps(self._task)  # Dask's, which knows scripts too
        return packed

    def __setstate__(self, packed: bytes) -> None:
        self._task = partial(_unpacked, packed)

    def __call__(self) -> Any:
        return self._task()


def _unpacked(packed: bytes) -> Any:
    try:
        task = pickle.loads(packed)
    except (ImportError, AttributeError) as error:
        rule = "what the work is made of has to be installed on every machine"
        raise WorkersError(f"a worker cannot load its work ({error})", rule, "the same environment on all") from None
    return task()


def _put(finished: SimpleQueue[tuple[int, Any]], number: int, future: Any) -> None:
    finished.put((number, future))


def _lost(error: BaseException) -> WorkersError | None:
    """What is said where the workers have died, or cannot be reached any more."""
    distributed = sys.modules.get("distributed")
    killed = () if distributed is None else (distributed.KilledWorker,)
    if not isinstance(error, (BrokenExecutor, CancelledError, _Dropped, *killed)):
        return None
    said = " ".join(str(error).split())
    return WorkersError(
        f"the workers are lost ({said.rstrip('.')[:200]})" if said else "the workers are lost",
        "what they had finished is kept, the rest needs workers that live",
        "see that they run, and have memory enough; then the same again",
    )
