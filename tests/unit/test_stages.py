"""Stages: however a stream is cut into batches, each stage and a whole pipeline give the same to the last bit."""

from __future__ import annotations

import pickle
from dataclasses import fields, is_dataclass, replace
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.stream.stage import join

NOISE = 1e-4
FINGER = ss.Finger(
    ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=NOISE, offset=0.3)
)
BENT = replace(FINGER, array=replace(FINGER.array, transducer=ss.VolumeResistance(exact=True)))
TARE = ss.Tare(FINGER, patience=1.0)
RUBBER = ss.Relaxation([0.06, 0.1], [0.4, 6.0])
FRAMES = 2000


def recording():
    """40 s at uneven steps with three holes in time, drift, touches, and readings that are missing, wild or frozen."""
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.uniform(0.002, 0.038, FRAMES))
    time += np.select([np.arange(FRAMES) >= k for k in (1700, 1100, 300)], [3608.5, 8.5, 0.5])
    phase = time % 10.0
    force = 40.0 * np.clip(4 * np.minimum(phase - 4.0, 8.0 - phase), 0, 1)
    raw = FINGER.read(ss.LineLoad(force, 0.2, 1.5e-3 * np.sin(time / 7)), rng)
    raw += 5e-5 * np.minimum(time, 60.0)[:, None] * rng.normal(size=6)
    raw[600:610, 2] = np.nan
    raw[800] = np.nan
    raw[900, 1] += 0.02
    raw[1200:, 4] += 40 * NOISE  # a step, so that the question is asked
    raw[1500:, 0] = raw[1500, 0]  # and one that freezes
    return raw, time


RAW, TIME = recording()
STAGES = {
    "tare": TARE,
    "apply": RUBBER.apply,
    "undo": replace(RUBBER, rest=FINGER.array.offset).undo,
    "undoing": replace(RUBBER, rest=FINGER.array.offset, doubt=0.3).undoing,
    "units": ss.Pipeline({"units": partial(np.multiply, 100.0)}),
    "locate": ss.Pipeline({"found": FINGER.locator()}),
    "locate without outliers": ss.Pipeline({"found": FINGER.locator(outliers=1)}),
    "locate, bent sensors": ss.Pipeline({"found": BENT.locator()}),
    "fit": ss.Pipeline({"found": partial(FINGER.fit, family="hertz")}),
    "decide": ss.Pipeline({"found": partial(ss.decide.contact_type, FINGER)}),
    "pressure": ss.Pipeline({"found": partial(ss.pressure_map, FINGER)}),
    "all": ss.Pipeline(
        {
            "units": partial(np.multiply, 2.0),
            "relaxation": RUBBER.undo,
            "tare": TARE,
            "found": FINGER.locator(outliers=1),
        }
    ),
    "all, in doubt": ss.Pipeline(
        {"relaxation": replace(RUBBER, doubt=0.3).undoing, "tare": TARE, "found": BENT.locator(outliers=1)}
    ),
}
COSTLY = {"fit": 300, "decide": 120, "pressure": 60}
"""Frames of those that take long."""


def same(one, other):
    """Whether two answers hold the same bits, whatever they are made of."""
    assert type(one) is type(other)
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            same(one[name], other[name])
    elif isinstance(one, tuple):
        for a, b in zip(one, other, strict=True):
            same(a, b)
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype
        np.testing.assert_array_equal(one, other)
    elif is_dataclass(one):
        for field in fields(one):
            same(getattr(one, field.name), getattr(other, field.name))
    else:
        assert one is other or one == other or (one != one and other != other)


def stretch(name):
    """The part of the recording that a stage is tried on: of the costly ones, where a sensor is missing."""
    first = 500 if name in COSTLY else 0
    part = slice(first, first + COSTLY.get(name, FRAMES))
    return RAW[part], TIME[part]


@pytest.fixture(scope="module")
def whole():
    """State and answer of each stage after the whole stream in one step, made when first asked for."""
    kept = {}

    def of(name):
        if name not in kept:
            kept[name] = STAGES[name].step(None, *stretch(name))
        return kept[name]

    return of


@pytest.mark.parametrize("name", STAGES)
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(cuts=st.lists(st.floats(0, 1), max_size=6))
def test_batches_give_the_bits_of_the_whole(name, cuts, whole):
    """Of any length, also empty ones; each state is put away and taken out again, and is left as it was."""
    stage, (raw, time) = STAGES[name], stretch(name)
    ends = sorted(int(cut * len(raw)) for cut in cuts)
    state, parts = None, []
    for a, b in zip([0, *ends], [*ends, len(raw)], strict=True):
        kept = pickle.dumps(state)
        left, out = stage.step(state, raw[a:b], time[a:b])
        assert pickle.dumps(state) == kept
        state = pickle.loads(pickle.dumps(left))
        parts.append(out)
    same(state, whole(name)[0])
    same(join(parts), whole(name)[1])


@pytest.mark.parametrize("name", STAGES)
def test_single_frames_give_the_bits_of_the_whole(name, whole):
    """Frames without an axis of their own, over a gap in the readings and, where it is quick, one in time."""
    stage, (raw, time) = STAGES[name], stretch(name)
    begin = 0 if name in COSTLY else 560
    state, out = stage.step(None, raw[:begin], time[:begin])
    parts = [out]
    for k in range(begin, min(begin + 600, len(raw))):
        state, out = stage.step(state, raw[k], time[k])
        parts.append(batched(out))
    same(join(parts), first_frames(whole(name)[1], begin + len(parts) - 1))


def batched(out):
    """The answer of a single frame as a batch of one."""
    return over(out, lambda values: values[None])


def first_frames(out, count):
    return over(out, lambda values: values[:count])


def over(out, change):
    """`change` of every array of an answer that has a row for each frame."""
    if isinstance(out, dict):
        return {name: over(part, change) for name, part in out.items()}
    if isinstance(out, np.ndarray):
        return change(out)
    rows = {"table", "used", "readings", "offset", "free", "frozen", "doubt"}
    kept = {f.name: getattr(out, f.name) for f in fields(out) if f.name in rows}
    return replace(out, **{name: change(values) for name, values in kept.items() if values is not None})


@pytest.mark.parametrize("name", STAGES)
def test_inputs_are_left_alone_and_outputs_are_closed(name):
    raw, time = np.array(RAW[:50]), np.array(TIME[:50])
    _, out = STAGES[name].step(None, raw, time)
    np.testing.assert_array_equal(raw, RAW[:50])
    np.testing.assert_array_equal(time, TIME[:50])
    last = list(out.values())[-1] if isinstance(out, dict) else out
    values = getattr(last, "table", getattr(last, "readings", last))
    assert name == "units" or not values.flags.writeable


def test_a_whole_recording_goes_in_parts_with_progress(monkeypatch, whole):
    monkeypatch.setattr("subskin.stream.stage.CHUNK", 700)
    seen = []
    out = STAGES["all"](RAW, TIME, progress=seen.append)
    assert seen == [700, 700, 600]
    same(out, whole("all")[1])


def test_stages_follow_on_one_another():
    """Each takes what the one before it makes: a finger in percent reads percent."""
    raw, time = RAW[:700], TIME[:700]
    out = STAGES["all"](raw, time)
    undone = RUBBER.undo(2.0 * raw, time)
    tared = TARE(undone, time)
    same(out["tare"], tared)
    same(out["found"], FINGER.locator(outliers=1)(tared.readings))


def test_an_estimate_can_go_on_to_a_stage():
    """What has no readings is itself what the next stage takes."""
    out = ss.Pipeline({"found": FINGER.locator(), "angle": lambda found: found.angle})(RAW[:600], TIME[:600])
    np.testing.assert_array_equal(out["angle"], out["found"].angle)


def test_where_no_stage_needs_it_there_is_no_time():
    same(STAGES["locate"](RAW[:9])["found"], FINGER.locate(RAW[:9]))

    def step(self, state, readings, time):
        return state, readings


@pytest.mark.parametrize(
    ("call", "error", "seen"),
    [
        (lambda: ss.Pipeline({}), InvalidValueError, "stages = {}"),
        (lambda: ss.Pipeline([TARE]), InvalidValueError, "by their names"),
        (lambda: ss.Pipeline({"tare": 3}), InvalidValueError, 'stage "tare" = 3'),
        (lambda: TARE(RAW[:5]), InvalidValueError, "time is missing"),
        (lambda: RUBBER.undo(RAW[:5], TIME[4::-1]), InvalidValueError, r"time\[1\] = .*go back"),
        (lambda: TARE(RAW[:5], TIME[:4]), GeometryError, "time of shape"),
        (lambda: RUBBER.undo(RAW[0, 0], 0.0), GeometryError, "readings of shape"),
        (
            lambda: STAGES["all"].step(STAGES["locate"].step(None, RAW[:2], None)[0], RAW[2:4], TIME[2:4]),
            InvalidValueError,
            "a state of found",
        ),
        (
            lambda: STAGES["all"].step(STAGES["all"].step(None, RAW[5:7], TIME[5:7])[0], RAW[:2], TIME[:2]),
            InvalidValueError,
            "go back",
        ),
    ],
)
def test_what_cannot_be_done_is_said(call, error, seen):
    with pytest.raises(error, match=seen):
        call()
