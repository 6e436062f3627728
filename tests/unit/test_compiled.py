"""Machine code that Numba keeps is made anew when what it was made of changes.

Numba looks at the text of the file that a function stands in, and not at the files it imports from: code that was kept
would go on calling the functions, and holding the constants, as they were.
"""

import gc
import importlib.util
import json
import logging
import math
import os
import subprocess
import sys

import numba as nb
import numpy as np
import pytest
from numba.core.event import Listener, install_listener

import subskin as ss
from subskin import _cold
from subskin._cold import at_once
from subskin._compiled import is_cached

FILES = {
    "__init__": "",
    "constants": "FACTOR = 2\n",
    "below": "from subskin._compiled import compiled\n\n@compiled()\ndef number():\n    return 1\n",
    "between": "from subskin._compiled import compiled\nfrom . import constants\nfrom .below import number\n\n"
    "@compiled()\ndef twice():\n    return constants.FACTOR * number()\n",
    "above": "from subskin._compiled import compiled, is_cached\nfrom .between import (\n    twice as double,\n)\n\n"
    "@compiled()\ndef again():\n    return 2 * double()\n\nprint(is_cached(again), again())\n",
}


def test_a_loop_in_plain_python_need_not_be_compiled():
    assert is_cached(lambda: None)


def test_what_was_kept_is_used_until_what_it_is_built_on_changes(tmp_path):
    (tmp_path / "room").mkdir()
    for name, source in FILES.items():
        (tmp_path / "room" / f"{name}.py").write_text(source)

    def run():
        command = [sys.executable, "-m", "room.above"]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip()

    assert [run(), run()] == ["False 4", "True 4"]
    for changed, text, other, seen in (("below", "1", "5", "20"), ("constants", "2", "10", "100")):
        path = tmp_path / "room" / f"{changed}.py"
        before = path.stat().st_mtime
        path.write_text(path.read_text().replace(text, other))
        later = path.stat().st_mtime + 5  # clocks of files are coarse
        os.utime(path, (later, later))
        assert run().split()[-1] == seen
        os.utime(path, (before, before))  # so that the next change is not seen by this one
    path = tmp_path / "room" / "below.py"
    path.write_text(path.read_text().replace("compiled()", "compiled(exact=True)"))
    assert run() == "False 100"  # how a function is compiled counts too


class _Seen(Listener):
    """Whether Python searches for garbage when the compiling of a loop begins and has ended."""

    def __init__(self):
        self.searched = []

    def on_start(self, event):
        self.searched.append(gc.isenabled())

    on_end = on_start


@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize(("module", "meanwhile"), [("subskin.room", False), ("subskinned", True)])
def test_no_search_for_garbage_while_a_loop_of_ours_is_compiled(module, meanwhile, before):
    def below(x):
        return x + 1

    def above(x):
        return 2 * inner(x)

    def wrong(x):
        return inner(x).no_such_part

    for function in (below, above, wrong):
        function.__module__ = module
    was, seen, inner = gc.isenabled(), _Seen(), nb.njit(below)
    (gc.enable if before else gc.disable)()
    try:
        with install_listener("numba:compile", seen):
            with pytest.raises(nb.TypingError):
                nb.njit(wrong)(1)
            assert gc.isenabled() == before
            assert nb.njit(above)(1) == 4
            assert gc.isenabled() == before
    finally:
        (gc.enable if was else gc.disable)()
    during = before and meanwhile
    assert seen.searched == [during, during, during, before, during, before]  # wrong, below within it; above


def first_answers():
    """What a new installation is asked first, a few frames each: statuses and numbers."""
    rng, rubber = np.random.default_rng(0), ss.Material(young=0.4e6)
    row = ss.Finger(ss.HalfPlane(rubber), ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=2e-5))
    line = row.read(ss.LineLoad(force=[30.0, 20.0], angle=0.2, position=[0.0, 1e-3]), rng)
    hertz = row.read(ss.Hertz(force=[30.0, 20.0], half_width=1.5e-3), rng)
    fine = ss.Finger(ss.HalfPlane(rubber), ss.SensorArray.line(count=25, pitch=0.5e-3, depth=2e-3, noise=2e-5))
    mapped = ss.pressure_map(fine, fine.read(ss.Hertz(force=[40.0, 30.0], half_width=2e-3), rng))
    grid = ss.SensorArray.grid(shape=(3, 3), pitch=1.5e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=10.0)
    pad = ss.Finger(ss.HalfSpace(rubber), grid)
    point = pad.read(ss.PointLoad(force=[1.0, 2.0], angle=0.2, position=[(0.0, 0.2e-3), (0.5e-3, 0.0)]), rng)
    ball = pad.read(ss.RoundHertz(force=[1.0, 2.0], half_width=1e-3), rng)
    touch = row.locate(line)
    found = [touch, row.locate(line, load="either"), row.fit(hertz), row.fit(hertz, stick=0.6), pad.locate(point)]
    found.append(pad.fit(ball, "round_hertz"))
    doubted = row.locate(line, doubt=np.full(line.shape, 1e-4))
    slip = ss.decide.slip(touch, ss.decide.Friction.between(0.4, 0.6))
    kinds = [ss.decide.contact_type(row, line), ss.decide.contact_type(pad, ball)]
    numbers = [each.table[..., :3].tolist() for each in found[:5]] + [
        doubted.force.tolist(),
        slip.probability.tolist(),
    ]  # of nothing like 1e-264 the digits are lost
    numbers += [found[5].position.tolist(), found[5].force.tolist(), mapped.pressure.tolist()]
    numbers += [each.probability.tolist() for each in kinds]
    return [each.status.tolist() for each in (*found, doubted, mapped)], numbers


FIRST = """
import json, logging
from numba.core.event import install_recorder
from tests.unit.test_compiled import first_answers

logging.basicConfig()
with install_recorder("numba:compile") as seen:
    answers = first_answers()
names = [event.data["dispatcher"].py_func.__name__ for _, event in seen.buffer]
print(json.dumps([answers, names]))
"""


def test_the_first_frames_after_an_installation_wait_for_no_loop_over_frames(tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", FIRST], capture_output=True, text=True, check=True,
        env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)},
    )  # fmt: skip
    (statuses, numbers), compiled_then = json.loads(run.stdout)
    assert "compiling" not in run.stderr
    assert not {name for name in compiled_then if name.endswith(("_frames", "_round")) or name.startswith("weigh")}
    with at_once():
        wanted = first_answers()
    assert statuses == wanted[0]
    for one, other in zip(numbers, wanted[1], strict=True):
        np.testing.assert_allclose(np.array(one), np.array(other), rtol=1e-6, atol=1e-12)


@pytest.fixture
def inverse(tmp_path, monkeypatch):
    """A loop of which nothing was kept."""
    monkeypatch.setattr(_cold, "_FEW", [16])
    path = tmp_path / "inverse.py"
    path.write_text(
        "from subskin._compiled import compiled\n\n@compiled(frames='frames')\ndef inverse(frames, out):\n"
        "    for i in range(len(frames)):\n        out[i] = 1.0 / float(frames[i])\n"
    )
    spec = importlib.util.spec_from_file_location("inverse", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.inverse


def test_a_loop_is_compiled_once_its_first_frames_are_over(inverse, caplog):
    ways = []
    with install_listener("numba:compile", _Seen()) as seen, caplog.at_level(logging.WARNING, "subskin"):
        for count in (15, 1, 1, 30):
            out = np.zeros(count)
            inverse(np.arange(1.0, count + 1.0), out)
            assert out.tolist() == [1.0 / (i + 1) for i in range(count)]
            ways.append((len(seen.searched) > 0, len(caplog.records)))
    assert ways == [(False, 0), (False, 0), (True, 1), (True, 1)]


def test_what_plain_python_refuses_is_compiled(inverse):
    out = np.ones(2)
    inverse(np.array([0.0, 2.0]), out)
    assert out.tolist() == [math.inf, 0.5]


def test_what_is_warmed_up_does_not_begin_in_plain_python(inverse):
    with at_once():
        inverse(np.ones(1), np.ones(1))
    assert inverse.signatures
