"""--dask: the work of a command shared out to the workers of a Dask cluster."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from .. import __version__
from ..errors import InvalidValueError, WorkersError
from .options import option

__all__ = ["DASK", "cluster", "version"]

_PATIENCE = 60.0
"""Seconds for which a scheduler may have no worker yet."""
_ANSWER = 10.0
"""Seconds in which a scheduler has to answer."""


DASK = option("--dask ADDRESS", 'share the work out with Dask: "local", or the address of a scheduler, tcp://host:8786')


@contextmanager
def cluster(options: argparse.Namespace) -> Iterator[Any]:
    """The client of the cluster that --dask names, closed at the end with all that was started for it; None without it.

    Of a local one --workers says how many processes there are, where the command has that option.

    Raises
    ------
    InvalidValueError
        Dask is not installed; an address at which no scheduler answers.
    WorkersError
        No workers, or workers without this version of subskin.
    """
    address: str | None = options.dask
    if address is None:
        yield None
        return
    try:
        distributed: Any = import_module("distributed")
    except ModuleNotFoundError:
        rule, fix = "it needs distributed, which is not installed", 'pip install "subskin[dask]"'
        raise InvalidValueError(f"--dask {address}", rule, fix) from None
    for name in [name for name in logging.root.manager.loggerDict if name.split(".")[0] == "distributed"]:
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what goes wrong is said by errors
    with _deaf_thread(distributed) as loop:
        if address == "local":
            count = getattr(options, "workers", None) or os.cpu_count() or 1
            print(f"subskin: starting Dask with {count} processes, which takes some seconds", file=sys.stderr)
            with (
                distributed.LocalCluster(
                    n_workers=count, threads_per_worker=1, dashboard_address=None, silence_logs=logging.CRITICAL,
                    loop=loop,
                ) as local,
                distributed.Client(local, loop=loop) as client,
            ):  # fmt: skip
                yield client
            return
        try:
            client = distributed.Client(address, timeout=_ANSWER, loop=loop)
        except (OSError, ValueError) as error:
            said = " ".join(str(error).split())[:200]
            fix = "--dask local, or dask scheduler prints its address"
            raise InvalidValueError(f"--dask {address}", f"no scheduler answers there ({said})", fix) from None
        with client:
            _welcome(client, address)
            yield client


@contextmanager
def _deaf_thread(distributed: Any) -> Iterator[Any]:
    """The thread that starts the processes; they inherit that Ctrl-C is for the command, and not for them."""
    able = hasattr(signal, "pthread_sigmask")
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if able else None
    runner = distributed.utils.LoopRunner()
    try:
        runner.start()
    finally:
        if before is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        yield runner.loop
    finally:
        runner.stop()


def _welcome(client: Any, address: str) -> None:
    """Wait for workers, see that they compute what this process would, and say how many there are."""
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError:
        rule = f"the scheduler has had no worker for {_PATIENCE:.0f} s"
        raise WorkersError(f"--dask {address}", rule, f"on each machine: dask worker {address}") from None
    try:
        found = set(client.run(version).values())
    except ImportError as error:
        rule, fix = f"a worker has no subskin ({error})", f'on each machine: pip install "subskin[dask]=={__version__}"'
        raise WorkersError(f"--dask {address}", rule, fix) from None
    if found != {__version__}:
        rule = f"workers have subskin {', '.join(sorted(found))}, and this is {__version__}"
        raise WorkersError(f"--dask {address}", rule, f'on each machine: pip install "subskin[dask]=={__version__}"')
    threads = client.nthreads()
    print(f"subskin: {address}: {len(threads)} workers with {sum(threads.values())} threads", file=sys.stderr)


def version() -> str:
    """The version of subskin that is installed where this runs.

    Examples
    --------
    >>> import subskin
    >>> version() == subskin.__version__
    True
    """
    return __version__
