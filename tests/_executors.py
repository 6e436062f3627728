"""Executors for tests: one that finishes last what it was given first, one whose workers die."""

from __future__ import annotations

import pickle
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool


class Backwards:
    """Does nothing before `count` pieces of work are there; then the last first, each as another process gets it."""

    def __init__(self, count: int) -> None:
        self.count, self.given = count, []

    def submit(self, function, /, *arguments):
        self.given.append((Future(), pickle.dumps((function, arguments))))
        if len(self.given) == self.count:
            for future, work in reversed(self.given):
                own, some = pickle.loads(work)
                try:
                    future.set_result(own(*some))
                except Exception as error:
                    future.set_exception(error)
        return self.given[-1][0]


class Dying:
    """Does `count` pieces of work; then its workers are dead."""

    def __init__(self, count: int) -> None:
        self.left = count

    def submit(self, function, /, *arguments):
        future = Future()
        self.left -= 1
        if self.left < 0:
            future.set_exception(BrokenProcessPool("a process was terminated abruptly"))
        else:
            future.set_result(function(*arguments))
        return future
