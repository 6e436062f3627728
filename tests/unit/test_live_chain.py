"""The chain: the same answers as the pipeline, each event once and in time, and no stream ends for a bad device."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import subskin as ss
from subskin.cli.live_view import PlainLines
from subskin.io import parse_finger
from subskin.live import Chain, DeviceFrames, Event, RingBuffer

RATE, NOISE = 500.0, 2e-4
FINGER = ss.Finger(
    ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(8, pitch=1.5e-3, depth=2e-3, noise=NOISE, high=0.05)
)
KINDS = ("contact_on", "contact_off", "slip_risk", "slip")


def clock(seconds):
    return np.arange(int(seconds * RATE)) / RATE


def readings(time, force, angle=0.1, seed=0, position=0.4e-3):
    return FINGER.read(ss.LineLoad(force, angle, np.full(time.size, position)), np.random.default_rng(seed))


def played(chain, raw, device, host=None, batch=1, state=None, **more):
    """All batches of a stream; the host gets each a millisecond late."""
    host = device + 100.001 if host is None else host
    out = []
    for k in range(0, len(raw), batch):
        part = slice(k, k + batch)
        state, one = chain.step(state, DeviceFrames(raw[part], device[part], **more), float(host[part][-1]))
        out.append(one)
    return state, out


def told(batches, *kinds):
    return [event for batch in batches for event in batch.events if not kinds or event.kind in kinds]


@pytest.fixture(scope="module")
def chain():
    made = Chain(FINGER, slip=(0.4, 0.8))
    made.prepare()
    return made


@pytest.fixture(scope="module")
def touched(chain):
    """Three touches, the second dragged until it slips."""
    time = clock(4.0)
    phase = time % 1.25
    force = np.where((phase > 0.5) & (phase < 1.0), 40.0, 0.0)
    angle = np.where((time > 1.25) & (time < 2.5), np.clip(2.2 * (phase - 0.5), 0.05, 0.75), 0.05)
    return time, force, readings(time, force, angle)


@pytest.mark.parametrize("batch", [1, 13])
def test_a_chain_answers_as_the_pipeline_of_the_file_does(chain, touched, batch):
    time, _, raw = touched
    _, batches = played(chain, raw, time, batch=batch)
    mapped = np.concatenate([one.time for one in batches])
    out = chain.file.run(raw, mapped)
    np.testing.assert_array_equal(np.concatenate([one.readings for one in batches]), out["tare"].readings)
    np.testing.assert_array_equal(np.concatenate([one.found.table for one in batches]), out["found"].table)
    judged = ss.decide.slip(out["found"], ss.decide.Friction.between(0.4, 0.8))
    np.testing.assert_array_equal(np.concatenate([one.decision.verdict for one in batches]), judged.verdict)
    assert [one.first for one in batches] == list(range(0, time.size, batch))


@pytest.mark.parametrize("batch", [1, 7])
def test_contact_begins_and_ends_within_five_frames_of_the_truth_and_is_told_once(chain, touched, batch):
    time, force, raw = touched
    _, batches = played(chain, raw, time, batch=batch)
    events = told(batches, "contact_on", "contact_off")
    turns = np.flatnonzero(np.diff(force) != 0) + 1
    assert [event.kind for event in events] == ["contact_on", "contact_off"] * 3
    late = np.array([event.frame for event in events]) - turns
    assert late.min() >= 0
    assert late.max() <= 5
    assert events[0].values["position"] == pytest.approx(0.4e-3, abs=0.1e-3)
    assert events[0].time == pytest.approx(100.001 + time[events[0].frame], abs=1e-3)
    # the tare itself is sure half a second later
    free = np.concatenate([one.free for one in batches])
    assert not free[turns[1] + 5 : turns[1] + 100].any()


def test_a_drag_that_grows_is_at_risk_and_then_slips_and_one_that_holds_is_neither(chain, touched):
    time, _, raw = touched
    events = told(played(chain, raw, time, batch=5)[1], "slip_risk", "slip")
    assert [event.kind for event in events] == ["slip_risk", "slip"]
    assert 1.25 < time[events[0].frame] < time[events[1].frame] < 2.5
    assert events[1].values["ratio"] > events[0].values["ratio"]


@pytest.mark.parametrize("seed", range(2))
def test_an_untouched_skin_and_a_touch_near_the_noise_do_not_chatter(chain, seed):
    time = clock(15.0)
    quiet = played(chain, readings(time, 0.0 * time, seed=seed), time, batch=300)[1]
    assert told(quiet) == []
    light = np.where(time > 1.0, 1.7, 0.0)  # its frames are as often told from noise as not
    found = played(chain, readings(time, light, 0.0, seed), time, batch=300)[1]
    status = np.concatenate([one.found.status for one in found])[600:]
    assert 0.1 < (status == ss.Status.NO_CONTACT).mean() < 0.9
    assert len(told(found, *KINDS[:2])) <= 11  # 150 by three frames of no contact alone


def test_a_device_that_begins_again_keeps_its_offsets_and_the_stream_goes_on(chain):
    time = clock(3.0)
    raw = readings(time, np.where(time > 2.6, 40.0, 0.0)) + 0.01
    device = np.where(time < 2.1, 7.0 + time, time - 2.1)
    state, batches = played(chain, raw, device, 100.0 + time, batch=8)
    events = told(batches)
    assert [event.kind for event in events] == ["reset", "contact_on"]
    assert events[0].frame == int((time < 2.1).sum())
    assert events[0].values["to"] == 0.0
    assert (np.diff(np.concatenate([one.time for one in batches])) >= 0).all()
    assert batches[-1].found.status[-1] == ss.Status.OK
    assert sum(len(one) for one in batches) == time.size
    # offsets and how surely they are known live on: the first frames after it are no first frames of a stream
    std = chain._tare.resumed(state.pipeline["tare"]).std
    np.testing.assert_array_equal(std, state.pipeline["tare"].std)
    assert std.max() < 0.5 * NOISE


def test_a_touch_held_over_a_reset_is_not_taken_for_the_free_skin(chain):
    time = clock(4.0)
    raw = readings(time, np.where((time > 1.0) & (time < 3.0), 40.0, 0.0))
    device = np.where(time < 2.0, 7.0 + time, time - 2.0)
    _, batches = played(chain, raw, device, 100.0 + time, batch=8)
    status = np.concatenate([one.found.status for one in batches])
    assert (status[(time > 1.02) & (time < 3.0)] == ss.Status.OK).all()
    assert [event.kind for event in told(batches)] == ["contact_on", "reset", "contact_off"]


def test_what_is_lost_is_named(chain):
    time = clock(2.0)
    raw = readings(time, 0.0 * time)
    kept = (time < 0.8) | (time > 1.0)
    _, batches = played(chain, raw[kept], time[kept], batch=4)
    (gap,) = told(batches)
    assert gap.kind == "gap"
    assert gap.values["seconds"] == pytest.approx(0.202, abs=0.005)
    state, _ = chain.step(None, DeviceFrames(raw[:2], time[:2]), 100.0)
    _, batch = chain.step(state, DeviceFrames(raw[2:4], time[2:4], lost=3, bad=1), 100.01)
    assert [event.text for event in batch.events] == ["3 frames are lost, 1 came broken"]
    _, batch = chain.step(state, DeviceFrames(np.empty((0, 8)), bad=2), 100.01)
    assert len(batch) == 0
    assert batch.events[0].values["bad"] == 2


def test_a_sensor_that_is_lost_and_one_beyond_its_range_are_told_and_the_others_go_on(chain):
    time = clock(3.0)
    raw = readings(time, np.where(time > 0.5, 20.0, 0.0))
    raw[(time > 1.0) & (time < 1.5), 1] = np.nan
    raw[1100, 2] = np.nan  # one reading is no loss
    raw[time > 2.5, 4] = 0.06
    events = told(played(chain, raw, time, batch=3)[1])
    assert [event.kind for event in events] == ["contact_on", "sensor_lost", "sensor_back", "overload"]
    assert "s1" in events[1].text
    assert events[-1].values["sensors"] == ["s4"]
    assert events[1].frame - 500 <= 5


def test_zero_now_takes_what_is_read_for_the_offsets(chain):
    """A weight that lies on the finger: zeroed, it is nothing; what presses then is found as if it were alone."""
    time = clock(3.0)
    weight = FINGER.read(ss.LineLoad(10.0, 0.0, -3e-3)) - FINGER.read(ss.LineLoad(0.0))
    raw = readings(time, np.where(time > 2.0, 20.0, 0.0)) + np.where(time > 0.5, 1.0, 0.0)[:, None] * weight
    state, first = played(chain, raw[time < 1.5], time[time < 1.5], batch=5)
    state, batch = chain.step(state, DeviceFrames(np.empty((0, 8))), 101.6, "zero")
    _, after = played(chain, raw[time >= 1.5], time[time >= 1.5], batch=5, state=state)
    assert [event.kind for event in batch.events] == ["contact_off", "zeroed"]
    assert [event.kind for event in told(first) + told(after)] == ["contact_on", "contact_on"]
    assert after[-1].found.position[-1] == pytest.approx(0.4e-3, abs=0.1e-3)
    assert after[-1].found.force[-1] == pytest.approx(20.0, rel=0.03)
    moved = np.array(batch.events[1].values["changed"])
    np.testing.assert_allclose(moved, weight, atol=0.5 * NOISE)


def test_a_state_pickles_and_the_same_steps_give_the_same_bits(chain, touched):
    time, _, raw = touched
    state, _ = played(chain, raw[:700], time[:700], batch=3)
    again = pickle.loads(pickle.dumps(state))
    one = played(chain, raw[700:900], time[700:900], batch=3, state=state)[1]
    other = played(chain, raw[700:900], time[700:900], batch=3, state=again)[1]
    for a, b in zip(one, other, strict=True):
        assert (a.found.table.tobytes(), a.time.tobytes()) == (b.found.table.tobytes(), b.time.tobytes())
    assert [e.text for e in told(one)] == [e.text for e in told(other)]


def test_channels_are_found_by_their_names_and_units_are_those_of_the_recording():
    text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 3e-3\ndepth = 2e-3\nnoise = 1e-4\n"
    file = parse_finger(text + '[recording]\nsensors = ["a", "b", "c", "d"]\nunit = "percent"\n')
    chain = Chain(file, channels=("t", "d", "c", "b", "a"))
    values = np.array([[25.0, 4.0, 3.0, 2.0, 1.0]])
    _, batch = chain.step(None, DeviceFrames(values), 1.0)
    np.testing.assert_allclose(batch.readings, 0.0, atol=1e-12)  # the first frame is the offset
    _, batch = chain.step(_, DeviceFrames(values + np.eye(5)[4]), 1.01)
    np.testing.assert_allclose(batch.readings[0], [0.01, 0, 0, 0], atol=1e-12)
    with pytest.raises(ss.SubskinError, match="not found: d"):
        Chain(file, channels=("a", "b", "c"))


def test_a_misspelt_channel_is_no_reason_to_take_another():
    text = "[skin]\nyoung = 4e5\n[sensors]\ncount = 3\npitch = 3e-3\ndepth = 2e-3\nnoise = 1e-4\n"
    live = "[live]\ndriver = {{name = 'lines', sensors = 3}}\nchannels = [{}]\n"
    swapped = parse_finger(text + live.format("'c2', 'c1', 'c0'"))
    _, batch = Chain(swapped, channels=("c0", "c1", "c2")).step(None, DeviceFrames([[1.0, 2.0, 3.0]]), 1.0)
    assert np.isfinite(batch.readings).all()
    with pytest.raises(ss.SubskinError, match="C2: the device has the channels c0, c1, c2"):
        Chain(parse_finger(text + live.format("'C2', 'c1', 'c0'")), channels=("c0", "c1", "c2"))


def test_a_load_on_an_area_and_a_width_go_through_the_same_chain():
    time = clock(1.2)
    raw = readings(time, np.where(time > 0.8, 40.0, 0.0))
    events = told(played(Chain(FINGER, fit="hertz"), raw, time, batch=20)[1])
    assert [event.kind for event in events] == ["contact_on"]
    array = ss.SensorArray.grid(shape=(4, 4), pitch=3e-3, depth=3e-3, transducer=ss.MeanPressure(), noise=20.0)
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    time = clock(9.0)[::5]
    touch = finger.read(ss.PointLoad(1.5, 0.3, 0.8, position=(1e-3, -2e-3)))
    raw = np.where(((time > 1) & (time < 8))[:, None], touch, 0.0)
    raw = raw + 20.0 * np.random.default_rng(0).standard_normal(raw.shape)
    chain = Chain(finger, slip=0.9)
    _, batches = played(chain, raw, time, batch=30)
    # held for longer than the tare's patience, when it asks whether this is a touch
    assert [event.kind for event in told(batches, "contact_on", "contact_off")] == ["contact_on", "contact_off"]
    held = next(one for one in batches if 7.0 < one.device_time[0] < 7.8)
    np.testing.assert_allclose(held.found.position.mean(axis=0), [1e-3, -2e-3], atol=0.05e-3)
    assert (held.decision.ratio < 0.6).all()


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: Chain(FINGER, slip=(0.4, 0.5, 0.6)), "a range"),
        (lambda: Chain(FINGER).step(None, DeviceFrames(np.ones((1, 3))), 0.0), "8 channels"),
        (
            lambda: Chain(FINGER).step(None, DeviceFrames(np.empty((0, 8))), 0.0, "tare"),
            r"command = .tare.: has to be \"zero\"",
        ),
        (lambda: Chain(FINGER).step(None, DeviceFrames(np.ones((1, 8))), 0.0, "zero"), "step of its own"),
    ],
)
def test_what_cannot_be_is_refused(call, match):
    with pytest.raises(ss.SubskinError, match=match):
        call()


def test_a_ring_keeps_the_last_seconds_in_order_and_no_more_memory_than_it_may():
    ring = RingBuffer(seconds=1.0)
    for k in range(0, 5000, 3):
        time = (k + np.arange(3)) / RATE
        ring.put(time=time, readings=np.stack([time, -time], axis=-1))
    last = ring.last()
    assert last["time"][-1] == time[-1]
    np.testing.assert_allclose(np.diff(last["time"]), 1 / RATE)
    np.testing.assert_array_equal(last["readings"][:, 1], -last["time"])
    assert last["time"][0] == pytest.approx(time[-1] - 1.0, abs=1e-9)
    assert len(ring) <= 1024
    wide = RingBuffer(seconds=1e9)
    for _ in range(40):
        wide.put(time=np.zeros(1000), readings=np.zeros((1000, 500)))
    assert sum(v.nbytes for v in wide._columns.values()) <= 64 << 20


def test_an_event_is_closed_and_travels():
    event = pickle.loads(pickle.dumps(Event("mark", 1.0, 3, "here", {"a": 1})))
    assert (event.kind, event.frame, event.values) == ("mark", 3, {"a": 1})


def test_a_point_on_a_row_is_told_by_its_own_force():
    """It explains what no line does: position, force and overload are those of the point [N]."""
    row = ss.SensorArray.line(6, pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=30.0)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), row)
    made, time = Chain(tip, overload=1.5), clock(3.0)
    made.prepare()
    force = np.select([(time > 1.0) & (time < 1.5), (time > 2.0) & (time < 2.5)], [1.0, 2.0], 0.0)
    at = np.broadcast_to([0.7e-3, 1e-3], (time.size, 2))
    raw = tip.read(ss.PointLoad(force, position=at), np.random.default_rng(0))
    _, batches = played(made, raw, time, batch=25)
    begun = told(batches, "contact_on")
    assert len(begun) == 2
    for event, wanted in zip(begun, (1.0, 2.0), strict=True):
        assert abs(event.values["position"] - 0.7e-3) < 5e-5
        assert abs(event.values["force"] - wanted) < 0.5  # a drag across the row is not told from it
    (much,) = told(batches, "overload")
    assert 2.0 < much.time - batches[0].time[0] < 2.1
    view = PlainLines(made.file, None)
    view.latest = next(one for one in batches if (one.found.force > 1.5).all())
    assert " N  " in view.said()
    assert "N/m" not in view.said()
