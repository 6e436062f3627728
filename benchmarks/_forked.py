"""Tests run in a fork of this process, which has loaded what takes long, until one fails or a budget is spent."""

from __future__ import annotations

import multiprocessing as mp
import os
import random
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import hypothesis  # noqa: F401  loaded once, for all forks
import pytest
from numba.core import event

# A test hangs that takes so long [s of processor], or says nothing for so long [s]; most memory [bytes]
HANGS, SILENT, MEMORY = 30, 600, 8 << 30


class Compiling(event.Listener):
    """How long numba has compiled [s of processor], which is no time of the tests."""

    depth, spent = 0, 0.0

    def on_start(self, event) -> None:
        if not self.depth:
            self.spent -= time.process_time()
            signal.setitimer(signal.ITIMER_PROF, 0)
        self.depth += 1

    def on_end(self, event) -> None:
        self.depth -= 1
        if not self.depth:
            self.spent += time.process_time()
            signal.setitimer(signal.ITIMER_PROF, HANGS)


class Watch:
    """A plugin of pytest: says what happens, runs a case of each test before more cases, stops at the budget."""

    def __init__(self, pipe, tests: list[str], budget: float):
        self.pipe, self.ranks, self.budget = pipe, {test: i for i, test in enumerate(tests)}, budget
        self.compiling, self.begun = Compiling(), 0.0
        event.register("numba:compile", self.compiling)

    def pytest_collection_modifyitems(self, session, items) -> None:
        self.session, cases, place = session, Counter(), {}
        random.Random(0).shuffle(items)
        for item in items:
            test = item.nodeid.split("[")[0]
            place[item] = self.ranks.get(test, 0) + 2 * cases[test]
            cases[test] += 1
        items.sort(key=place.get)

    def used(self) -> float:
        """Processor time of this process and those it started [s]."""
        return sum(os.times()[:4]) - self.compiling.spent

    def pytest_collectreport(self, report) -> None:
        if report.failed:
            self.pipe.send(("failed", report.nodeid, 0.0))

    def pytest_runtest_logstart(self, nodeid) -> None:
        self.pipe.send(("started", nodeid, 0.0))
        self.begun = self.used()
        signal.setitimer(signal.ITIMER_PROF, HANGS)  # caught by nobody, so it ends loops in compiled code too

    def pytest_runtest_logreport(self, report) -> None:
        if report.failed or (report.when == "call" and report.passed):
            self.pipe.send((report.outcome, report.nodeid, self.used() - self.begun))

    def pytest_runtest_logfinish(self) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0)
        if self.used() > self.budget:
            self.session.shouldstop = "budget"


def child(pipe, tree: Path, tests: list[str], budget: float) -> None:
    """Run tests of a tree; does not return."""
    os.setsid()
    os.chdir(tree)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))  # a fault may ask for more than there is
    for name in [name for name in sys.modules if name.split(".")[0] == "subskin"]:
        del sys.modules[name]  # the tree's own is to be loaded
    sys.path.insert(0, str(tree / "src"))
    sys.dont_write_bytecode = False  # or each fork translates all tests again
    os.environ.update(PYTHONPATH=str(tree / "src"), TMPDIR=str(tree.parent))  # what they leave goes with the copy
    tempfile.tempdir = None
    options = ["-x", "-q", "--assert=plain", "-p", "no:cacheprovider", f"--rootdir={tree}"]
    os._exit(int(pytest.main([*options, *tests], plugins=[Watch(pipe, tests, budget)])))


def run(tree: Path, tests: list[str], budget: float) -> tuple[str, str, dict[str, float]]:
    """Survived, killed or timed out; the test that did it; those that passed, and their time [s of processor]."""
    ours, theirs = mp.Pipe(duplex=False)
    process = mp.get_context("fork").Process(target=child, args=(theirs, tree, tests, budget))
    process.start()
    theirs.close()
    verdict, test, passed = "timed out", "", {}
    try:
        while ours.poll(SILENT):
            what, test, seconds = ours.recv()
            if what == "passed":
                passed[test] = seconds
            if what == "failed":
                verdict = "killed"
                break
    except EOFError:
        process.join()
        ends = dict.fromkeys((0, 2, 5), "survived") | {-signal.SIGPROF: "timed out"}  # 2: budget spent, 5: no test
        verdict = ends.get(process.exitcode, "killed")
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.join()
    return verdict, test, passed
