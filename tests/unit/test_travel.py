"""Nouns and results travel: pickled, copied, sent to a pool; without caches, and with their arrays closed."""

from __future__ import annotations

import ast
import copy
import functools
import pickle
import pkgutil
import subprocess
import sys
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import subskin as ss
from subskin import decide, pressing, stream
from subskin._frozen import Frozen
from subskin.tensor import State

ROOT = Path(ss.__file__).parent
SENDS = {"pickle": lambda thing: pickle.loads(pickle.dumps(thing)), "deepcopy": copy.deepcopy, "copy": copy.copy}


def all_classes():
    """Every class of the package that holds arrays or keeps what it has worked out."""
    for module in pkgutil.walk_packages([str(ROOT)], "subskin."):
        if not module.name.endswith("__main__") and ".io._" not in module.name:
            yield from (
                kind for kind in vars(import_module(module.name)).values()
                if isinstance(kind, type) and kind.__module__ == module.name
            )  # fmt: skip


CLASSES = sorted(set(all_classes()), key=lambda kind: (kind.__module__, kind.__qualname__))
EDGE = ("subskin.io", "subskin.cli", "subskin.report", "subskin.plot")
OWN = "__reduce__"  # a way of its own to travel
TOO_FEW = "__abstractmethods__"
STATED = [k for k in CLASSES if issubclass(k, Frozen) and OWN not in vars(k) and not getattr(k, TOO_FEW, ())]


def holds_arrays(kind):
    kept = any(isinstance(value, functools.cached_property) for value in vars(kind).values())
    notes = [str(note) for note in vars(kind).get("__annotations__", {}).values()]
    arrays = [note for note in notes if any(w in note for w in ("FloatArray", "NDArray", "ArrayLike"))]
    return kept or (is_dataclass(kind) and any("Callable" not in note for note in arrays))


def test_each_class_that_holds_arrays_travels_closed():
    """One mechanism for all of them."""
    holders = [kind for kind in CLASSES if holds_arrays(kind) and not kind.__module__.startswith(EDGE)]
    assert len(holders) > 50
    assert [kind.__qualname__ for kind in holders if not issubclass(kind, Frozen)] == []


@pytest.mark.parametrize("send", SENDS)
def test_arrays_stay_closed_and_caches_stay_behind(send):
    assert len(STATED) > 60
    for kind in STATED:
        thing = object.__new__(kind)
        names = {field.name for field in fields(kind)} if is_dataclass(kind) else {"value"}
        kept = {n for base in kind.__mro__ for n, v in vars(base).items() if isinstance(v, functools.cached_property)}
        for name in names | kept:
            thing.__dict__[name] = np.arange(3.0)
            if send == "copy":  # which shares what it is a copy of
                thing.__dict__[name].flags.writeable = False
        came = SENDS[send](thing)
        assert type(came) is kind
        assert set(came.__dict__) == names, kind
        for value in came.__dict__.values():
            np.testing.assert_array_equal(value, np.arange(3.0))
            assert not value.flags.writeable, kind


def test_arrays_in_lists_and_mappings_are_closed_too():
    thing = object.__new__(ss.Finger)
    thing.__dict__.update(skin=[np.ones(2), {"a": (np.ones(2),)}], array=None)
    came = copy.deepcopy(thing)
    assert not came.skin[0].flags.writeable
    assert not came.skin[1]["a"][0].flags.writeable


@pytest.fixture(scope="module")
def finger():
    array = ss.SensorArray.line(count=5, pitch=1.5e-3, depth=2e-3, noise=1e-4)
    return ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), array)


@pytest.fixture(scope="module")
def results(finger):
    """Real ones of every sort."""
    touch = ss.LineLoad(force=[40.0, 20.0], angle=0.1, position=[0.0, 1e-3])
    readings = finger.read(touch, np.random.default_rng(0))
    time = np.arange(2.0)
    pressed = ss.press(finger.skin, pressing.Cylinder(radius=8e-3), force=40.0, nodes=257)
    return {
        "material": finger.skin.material,
        "skin": finger.skin,
        "layered": ss.Layered(ss.Layer(finger.skin.material, 5e-3)),
        "array": finger.array,
        "finger": finger,
        "contact": touch,
        "strip": ss.Strip(40.0, half_width=1e-3),
        "state": finger.skin.state(ss.Strip(40.0, half_width=1e-3), 1e-3, [0.0, 1e-3]),
        "stress": finger.skin.stress(touch, 1e-3, 0.0),
        "estimate": finger.locate(readings),
        "rival": finger.locate(readings).second,
        "load": finger.locate(readings).load,
        "locator": finger.locator(),
        "pressed": pressed,
        "certificate": pressed.certificate,
        "tared": stream.Tare(finger)(readings, time),
        "friction": decide.Friction.known(0.5),
    }


def arrays_in(value, seen=None):
    seen = set() if seen is None else seen
    if id(value) in seen:
        return
    seen.add(id(value))
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, dict):
        for item in value.values():
            yield from arrays_in(item, seen)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from arrays_in(item, seen)
    elif isinstance(value, Frozen):
        yield from arrays_in(value.__dict__, seen)


@pytest.mark.parametrize("send", ["pickle", "deepcopy"])
def test_results_arrive_as_they_were(results, send):
    for name, sent in results.items():
        came = SENDS[send](sent)
        assert isinstance(came, State if name == "state" else type(sent)), name
        assert repr(came) == repr(sent) or "object at" in repr(sent) or name == "state", name
        for array in arrays_in(came):
            assert not array.flags.writeable, name
    np.testing.assert_array_equal(SENDS[send](results["estimate"]).position, results["estimate"].position)
    again, pressed = SENDS[send](results["pressed"]), results["pressed"]
    assert again.force == pressed.force
    np.testing.assert_array_equal(again.contact.pressure(again.y), pressed.contact.pressure(pressed.y))


def test_a_used_finger_weighs_as_much_as_a_new_one(finger, results):
    """It was 73 MB where a new one is 1 kB."""
    fresh = ss.Finger(finger.skin, finger.array)
    assert len(pickle.dumps(finger)) == len(pickle.dumps(fresh)) < 5000


def test_caches_are_bounded():
    """Whatever a module keeps says how much at most; `cached_property` goes with its owner."""
    unbounded = []
    for path in ROOT.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            for mark in getattr(node, "decorator_list", ()):
                text = ast.unparse(mark)
                takes = getattr(node, "args", None) is not None and (node.args.args or node.args.vararg)
                if takes and (text in ("cache", "lru_cache", "functools.cache") or "maxsize=None" in text):
                    unbounded.append(f"{path.name}: {node.name}")
    a_module_a_class_a_folder_each = [
        "_compiled.py: _text",
        "_declared.py: _of_class",
        "_frozen.py: _kept",
        "_lazy.py: _files",
        "shaped.py: _keeps_its_family",
    ]
    assert sorted(unbounded) == a_module_a_class_a_folder_each


# in a program of its own: this one may hold the threads of a library to learn with, which no fork takes along
POOL = """
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
import subskin as ss


def locate(job):
    finger, readings = job
    found = finger.locate(readings)
    return found, found.load


row = ss.SensorArray.line(count=6, pitch=1.5e-3, depth=2e-3, noise=1e-4)
finger = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), row)
readings = finger.read(ss.LineLoad(40.0, 0.1, 0.3e-3))
with ProcessPoolExecutor(1, mp_context=get_context("fork")) as pool:
    found, load = pool.submit(locate, (finger, readings)).result(timeout=120)
assert found.position == finger.locate(readings).position
assert load.force == found.force
"""


def test_a_pool_takes_fingers_and_gives_results():
    subprocess.run([sys.executable, "-c", POOL], check=True, timeout=240)
