"""The bench asks, waits, takes and ends; whatever the person does, no touch is taken that was none."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.live import Bench

TEXT = "[skin]\nyoung = 4e5\n[sensors]\ncount = 5\npitch = 3e-3\ndepth = 3e-3\nnoise = 1e-4"
FILE = ss.io.parse_finger(TEXT)
PLACES = np.linspace(-6e-3, 6e-3, 13)
ORIGIN = 0.4e-3


def real_finger():
    """Not as drawn: gains, depth, noise, and offsets that the bench does not know."""
    array = FILE.finger.array
    gain = np.array([0.9, 1.15, 0.85, 1.2, 1.0])
    return replace(FILE.finger, array=replace(array, gain=gain, offset=0.03, depth=array.depth * 1.1, noise=2e-4))


class Person:
    """Does what is asked, at 100 frames a second; `load` says how hard, or what else they do."""

    def __init__(self, bench, seed=1):
        self.bench, self.rng, self.time, self.finger = bench, np.random.default_rng(seed), 0.0, real_finger()
        self.state, self.said = bench.start()

    def press(self, load, frames=10):
        at = 0.0 if self.state.asked is None else self.state.asked - ORIGIN
        loads = np.broadcast_to(load, frames)
        readings = self.finger.read(ss.LineLoad(loads, position=at), self.rng)
        self.state, more = self.bench.step(self.state, readings, self.time + 0.01 * np.arange(frames))
        self.said, self.time = self.said + more, self.time + 0.01 * frames
        return [one.kind for one in more]

    def obey(self, until=lambda state: False):
        while self.state.phase != "done" and not until(self.state):
            self.press(40.0 if self.state.phase in ("touch", "hold") else 0.0)


def made(**options):
    return Bench(FILE, PLACES, **{"force": 40.0, "rest": 0.5, "hold": 0.2, "accuracy": 0.05e-3} | options)


def test_a_finger_comes_back_as_well_as_is_said():
    person = Person(made())
    person.obey()
    assert person.said[-1].kind == "reached"
    found, true = person.bench.result(person.state), person.finger.array
    assert 1e-4 < person.state.noise.mean() < 3e-4
    for parameter in found.parameters:
        truth = {"origin": ORIGIN, "depth": true.depth[0]}.get(parameter.name)
        truth = true.gain[parameter.sensor] if truth is None else truth
        assert abs(parameter.value - truth) < 4 * parameter.std
    at = np.linspace(-5e-3, 5e-3, 11)
    quiet = person.finger.measure(ss.LineLoad(40.0, position=at - ORIGIN)) * true.gain
    off = found.finger.locate(quiet).position + found.origin - at
    assert np.sqrt(np.mean(off**2)) < 3 * person.state.error


def test_however_the_frames_are_cut():
    bench, rng = made(most=3, accuracy=1e-9), np.random.default_rng(0)
    finger = real_finger()
    loads = np.concatenate([np.zeros(60), *3 * [np.full(40, 40.0), np.zeros(60)]])
    frames = finger.read(ss.LineLoad(loads, position=0.0), rng)
    ends = []
    for cuts in ([], np.arange(1, len(loads)), [7, 8, 100, 101, 250]):
        state = bench.start()[0]
        for part in np.split(np.arange(len(loads)), cuts):
            state, _ = bench.step(state, frames[part], 0.01 * part)
        ends.append(state)
    assert len(ends[0].positions) >= 2
    for other in ends[1:]:
        assert np.array_equal(other.readings, ends[0].readings)
        assert np.array_equal(other.positions, ends[0].positions)
        assert other.phase == ends[0].phase


def test_hands_on_at_the_beginning_are_noticed():
    person = Person(made())
    person.press(np.linspace(0.0, 40.0, 60), 60)
    assert person.said[-1].kind == "restless"
    person.obey(lambda state: state.phase == "touch")
    assert person.state.noise.max() < 4e-4


def test_a_touch_too_short_is_not_taken():
    person = Person(made())
    person.obey(lambda state: state.phase == "touch")
    assert person.press(40.0, 8) == ["hold"]
    assert person.press(0.0, 20) == ["short"]
    assert not len(person.state.positions)


def test_a_touch_that_still_grows_is_waited_for():
    person = Person(made())
    person.obey(lambda state: state.phase == "touch")
    person.press(np.linspace(4.0, 40.0, 100), 100)
    assert person.state.phase == "hold"
    person.press(40.0, 40)
    assert len(person.state.positions) == 1
    read = person.finger.measure(ss.LineLoad(40.0, position=person.state.positions[0] - ORIGIN))
    assert np.allclose(person.state.readings[0], read * person.finger.array.gain, atol=5e-4)


def test_offsets_that_move_between_touches_are_followed():
    person = Person(made(most=4, accuracy=1e-9))
    person.obey(lambda state: state.phase == "lift")
    person.finger = replace(person.finger, array=replace(person.finger.array, offset=0.0303))
    person.obey()
    found = person.bench.result(person.state)
    assert abs(found.finger.array.depth[0] - 3.3e-3) < 0.15e-3


def test_again_skip_and_end():
    person = Person(made())
    person.obey(lambda state: len(state.positions) == 2 and state.phase == "touch")
    first = person.state.positions[1]
    person.state, said = person.bench.again(person.state)
    assert "once more" in said[0].text
    assert person.state.asked == first
    assert len(person.state.positions) == 1
    person.state, said = person.bench.skip(person.state)
    assert said[0].kind == "touch"
    assert person.state.asked != first
    person.state, said = person.bench.end(person.state)
    assert (person.state.phase, said[0].kind) == ("done", "ended")
    with pytest.raises(ss.SubskinError, match="at least two"):
        person.bench.result(person.state)
    assert person.press(0.0) == []


@pytest.mark.parametrize("word", ["again", "skip"])
def test_a_word_while_the_skin_is_touched_waits_for_the_lift(word):
    person = Person(made(accuracy=1e-9))
    person.obey(lambda state: len(state.positions) == 2 and state.phase == "touch")
    wanted, before = person.state.asked, person.state.positions
    person.press(40.0, 8)
    assert person.state.phase == "hold"
    person.state, said = getattr(person.bench, word)(person.state)
    assert "lift" in said[0].text
    held = person.state
    for _ in range(6):  # the tip is still down where it was
        readings = person.finger.read(ss.LineLoad(np.full(10, 40.0), position=wanted - ORIGIN), person.rng)
        person.state, _ = person.bench.step(person.state, readings, person.time + 0.01 * np.arange(10))
        person.time += 0.1
    assert person.state.phase == "lift"
    assert np.array_equal(person.state.positions, before[: len(held.positions)])
    person.obey(lambda state: state.phase == "touch")
    assert (person.state.asked == before[1]) if word == "again" else (person.state.asked != wanted)


def test_nothing_to_skip_is_said():
    person = Person(made())
    person.obey(lambda state: state.phase == "lift")
    state, said = person.bench.skip(person.state)
    assert state is person.state
    assert "nothing to skip" in said[0].text


def test_a_sensor_that_stands_still_needs_a_stated_noise():
    text = TEXT.replace("noise = 1e-4", "noise = 0")
    bench = Bench(ss.io.parse_finger(text), PLACES, rest=0.3)
    state, _ = bench.start()
    frames = np.zeros((50, 5))
    frames[:, 1:] = np.random.default_rng(0).normal(0, 1e-4, (50, 4))
    with pytest.raises(InvalidValueError, match="sensor s0"):
        bench.step(state, frames, 0.01 * np.arange(50))


def test_frames_with_a_missing_reading_are_left_out():
    person = Person(made())
    frames = person.finger.read(ss.LineLoad(np.zeros(60)), person.rng)
    frames[::7, 2] = np.nan
    state, said = person.bench.step(person.state, frames, 0.01 * np.arange(60))
    assert [one.kind for one in said] == ["noise", "touch"]
    assert np.isfinite(state.noise).all()


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ({"candidates": []}, GeometryError),
        ({"candidates": [[0.0, 1.0]]}, GeometryError),
        ({"hold": 0.0}, InvalidValueError),
    ],
)
def test_what_makes_no_sense_is_refused(given, error):
    with pytest.raises(error, match=r"needed|above|> 0"):
        Bench(FILE, **{"candidates": PLACES} | given)
    bench = made()
    with pytest.raises(GeometryError, match="5 sensors"):
        bench.step(bench.start()[0], np.zeros((3, 4)), np.zeros(3))
