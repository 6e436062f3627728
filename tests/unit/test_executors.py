"""Who does the work changes no bit of it: threads, another order, other processes, Dask."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib import import_module

import numpy as np
import pytest

import subskin as ss
from subskin._tasks import run_tasks
from subskin.contact import RoundHertz, contact_of
from subskin.design import Goals, Touches, search_grid
from subskin.design.search import Accuracy, Effort, Room, SensorKind, SkinChoice
from subskin.errors import GeometryError, InvalidValueError, WorkersError
from subskin.synthetic import simulate_readings, simulate_recording

from .._executors import Backwards, Dying

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
GOALS = Goals(
    touches=Touches(force=20.0, friction=0.5, span=(-3e-3, 3e-3)),
    strongest=100.0,
    accuracy=Accuracy(position=0.1e-3),
    sensors=(SensorKind("gauge", ss.NormalStrain(), 2e-4),),
    skins=(SkinChoice("silicone", SKIN),),
    room=Room(count=(4, 5), depth=(1.5e-3, 3e-3), least_pitch=1e-3, longest_row=8e-3),
    tolerances={},
    effort=Effort(depths=3, pitches=2, touches=200, keep=1),
)


class Memory(dict):
    put = dict.__setitem__


@pytest.fixture(scope="module")
def grid():
    return search_grid(GOALS, workers=1)


def assert_same(found, grid):
    for name, values in grid.values.items():
        assert found.values[name].tobytes() == values.tobytes(), name


def test_a_search_is_the_same_whoever_works_it_out(grid):
    steps, store = [], Memory()
    found = search_grid(GOALS, executor=Backwards(3), store=store, progress=lambda: steps.append(threading.get_ident()))
    assert_same(found, grid)
    assert steps == [threading.get_ident()] * 3
    assert len(store) == 3
    with ThreadPoolExecutor(2) as pool:
        assert_same(search_grid(GOALS, executor=pool), grid)
        assert pool.submit(int).result() == 0  # it was lent, and is not shut down
    assert_same(search_grid(GOALS, executor=Dying(0), store=store), grid)  # all rows are there


def test_dead_workers_are_an_error_and_what_is_finished_stays():
    store = Memory()
    with pytest.raises(WorkersError, match=r"the workers are lost \(a process was terminated abruptly\)"):
        search_grid(GOALS, executor=Dying(2), store=store)
    assert len(store) == 2


def test_what_finishes_while_a_search_is_stopped_is_kept(monkeypatch):
    """One row is stopped by Ctrl-C while the other goes on to its end."""
    begun, stopped = threading.Event(), threading.Event()

    def row(*_, **__):
        if not begun.is_set():
            begun.set()
            raise KeyboardInterrupt
        stopped.wait(5)
        return {"ambiguous": np.zeros(1), "unfelt": np.zeros(1)}

    monkeypatch.setattr("subskin.design.search.grid.study_at_depth", row)
    store = Memory()
    threading.Timer(0.1, stopped.set).start()
    with pytest.raises(KeyboardInterrupt):
        search_grid(GOALS, store=store, workers=2)
    assert store


@pytest.mark.parametrize("local", [False, True])
def test_readings_are_the_same_whoever_works_them_out(local):
    rng, count = np.random.default_rng(1), 5003
    loads = {"force": rng.uniform(10, 60, count), "angle": rng.uniform(0, 0.5, count)}
    if local:
        array = ss.SensorArray.grid(shape=(1, 2), pitch=3e-3, depth=3e-3, noise=1e-3)
        finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
        loads |= {"azimuth": rng.uniform(-3, 3, count), "position": rng.uniform(-4e-3, 4e-3, (count, 2))}
        make = partial(RoundHertz, half_width=0.5e-3)
    else:
        finger = ss.Finger(SKIN, ss.SensorArray.line(count=3, pitch=2e-3, depth=2e-3, noise=1e-3))
        loads |= {"position": rng.uniform(-4e-3, 4e-3, count)}
        make = contact_of("hertz", 0.5e-3)
    expected = finger.read(make(**loads), rng=np.random.default_rng(2))
    steps = []
    found = simulate_readings(finger, make, loads, rng=np.random.default_rng(2), progress=steps.append)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-15, equal_nan=False)
    assert steps == [5000, 3]
    again = simulate_readings(finger, make, loads, rng=np.random.default_rng(2), executor=Backwards(2))
    assert again.tobytes() == found.tobytes()
    with pytest.raises(WorkersError):
        simulate_readings(finger, make, loads, executor=Dying(1))


def test_a_recording_is_the_same_whoever_works_it_out():
    finger = ss.Finger(SKIN, ss.SensorArray.line(count=3, pitch=2e-3, depth=2e-3, noise=1e-3))
    record = partial(simulate_recording, finger, np.linspace(-3e-3, 3e-3, 50), force=40.0)
    one, other = (record(rng=np.random.default_rng(1), executor=e) for e in (None, Backwards(2)))
    assert one.readings.tobytes() == other.readings.tobytes()


def test_what_is_refused():
    with pytest.raises(InvalidValueError, match="something with submit is needed"):
        search_grid(GOALS, executor=4)
    finger = ss.Finger(SKIN, ss.SensorArray.line(count=3, pitch=2e-3, depth=2e-3))
    with pytest.raises(GeometryError, match=r"force of shape \(2,\), position of shape \(3,\)"):
        simulate_readings(finger, ss.LineLoad, {"force": [1.0, 2.0], "position": [0.0, 0.0, 0.0]})
    with pytest.warns(ss.errors.ValidityWarning, match="position = 3"):
        simulate_readings(finger, ss.LineLoad, {"force": [1.0, 2.0], "position": [0.0, 3.0]})


class Stranger:
    """Of a module that workers have not got."""

    def __reduce__(self):
        return import_module, ("no_such_module",)


def test_work_that_workers_cannot_load():
    with pytest.raises(WorkersError, match=r"a worker cannot load its work \(No module named"):
        run_tasks([partial(print, Stranger())], print, executor=Backwards(1))


@pytest.fixture
def quiet():
    """Warnings of Dask about this machine are none of ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield pytest.importorskip("distributed")


def test_dask_in_this_process(quiet, grid):
    options = {"processes": False, "n_workers": 2, "threads_per_worker": 1, "dashboard_address": None}
    with quiet.Client(**options) as client:
        assert_same(search_grid(GOALS, executor=client), grid)


@pytest.mark.long
def test_a_worker_of_dask_that_is_killed_is_survived(quiet):
    def slow(number):
        time.sleep(0.3)
        return number, os.getpid()

    found = {}

    def keep(number, result):
        found[number] = result
        if len(found) == 3:
            os.kill(result[1], signal.SIGKILL)

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 50}
    with quiet.LocalCluster(**options) as cluster, quiet.Client(cluster) as client:
        run_tasks([partial(slow, n) for n in range(12)], keep, executor=client)
        assert {n: result[0] for n, result in found.items()} == {n: n for n in range(12)}
        assert len({pid for _, pid in found.values()}) >= 2
        with pytest.raises(WorkersError, match="the workers are lost"):
            run_tasks([partial(os._exit, 1)], keep, executor=client)
        with pytest.raises(WorkersError, match="cannot load its work"):
            run_tasks([partial(print, Stranger())], keep, executor=client)
