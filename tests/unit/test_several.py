"""Several touches on an area: their number, where each is, and that the sum of two is never taken for one."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError
from subskin.estimate.on_area import moved

DEPTH, PEAK, HALF = 3e-3, 0.04, 4.5e-3
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))


def pad(noise: float = 1e-3, tolerances: ss.Tolerances | None = None, **more: object) -> ss.Finger:
    array = ss.SensorArray.grid(shape=(4, 4), pitch=DEPTH, depth=DEPTH, noise=noise * PEAK, **more)  # type: ignore[arg-type]
    return ss.Finger(SKIN, array, tolerances=tolerances)


def loads(rng: np.random.Generator, frames: int, touches: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (f, touches, 2) at least a depth apart, and components; the first is the hardest."""
    at = rng.uniform(-HALF, HALF, (20 * frames, touches, 2))
    apart = np.linalg.norm(at[:, :, None] - at[:, None], axis=-1) + 1e3 * np.eye(touches)
    at = at[apart.min(axis=(1, 2)) > DEPTH][:frames]
    normal = rng.uniform(0.8, 1.2, (frames, 1)) * np.sort(rng.uniform(0.5, 1.0, (frames, touches)))[:, ::-1]
    lean, turn = rng.uniform(0, 0.4, normal.shape), rng.uniform(-np.pi, np.pi, normal.shape)
    return at, normal[..., None] * np.stack([np.ones_like(lean), lean * np.cos(turn), lean * np.sin(turn)], axis=-1)


def read(finger: ss.Finger, at: np.ndarray, force: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    parts = [
        finger.read(ss.PointLoad(position=at[:, t], components=force[:, t])) - np.asarray(finger.array.offset)
        for t in range(at.shape[1])
    ]
    return sum(parts) + np.asarray(finger.array.offset) + rng.normal(0, np.asarray(finger.array.noise), parts[0].shape)


def off_and_std(found: object, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of two touches, matched: errors of the positions (f, 2, 2) and their standard deviations."""
    place = found.each.position  # type: ignore[attr-defined]
    swap = np.linalg.norm(place - at[:, ::-1], axis=-1).max(axis=-1) < np.linalg.norm(place - at, axis=-1).max(axis=-1)
    true = np.where(swap[:, None, None], at[:, ::-1], at)
    return place - true, found.each.std[..., :2]  # type: ignore[attr-defined]


@pytest.mark.parametrize(("noise", "ok"), [(1e-3, 0.9), (1e-2, 0.2)])
def test_two_touches_are_two_and_stand_within_their_intervals(noise: float, ok: float) -> None:
    rng, finger = np.random.default_rng(1), pad(noise)
    at, force = loads(rng, 150, 2)
    found = finger.locate(read(finger, at, force, rng), touches=2)
    off, std = off_and_std(found, at)
    assert (found.count == 2).mean() > 0.97
    assert found.ok.mean() > ok
    good = found.ok
    assert (np.abs(off) < 5 * std)[good].all(axis=(1, 2)).mean() > 0.99
    assert (np.linalg.norm(off, axis=-1) < 0.3 * DEPTH)[good].all(axis=1).mean() > 0.98
    assert (np.abs(off) < 1.96 * std)[good].mean() > 0.9


def test_one_touch_is_one_and_as_locate_has_it() -> None:
    rng, finger = np.random.default_rng(2), pad()
    at, force = loads(rng, 100, 1)
    readings = read(finger, at, force, rng)
    found, single = finger.locate(readings, touches=2), finger.locate(readings)
    assert (found.count == 1).mean() > 0.97
    both = found.ok & single.ok
    assert both.mean() > 0.9
    moved = np.abs(found.each.position[both, 0] - single.position[both]) / single.std[both, :2]
    assert np.median(moved) < 1e-3
    assert moved.max() < 0.3  # either stops where a step gains little
    assert np.isnan(found.each.position[found.count == 1, 1]).all()


def test_the_sum_of_two_is_never_one_touch_that_is_ok() -> None:
    rng, finger = np.random.default_rng(3), pad()
    at, force = loads(rng, 100, 2)
    readings = read(finger, at, force, rng)
    found, single = finger.locate(readings, touches=2), finger.locate(readings)
    assert not (found.ok & (found.count == 1)).any()
    assert single.ok.mean() < 0.02


def test_three_touches_of_eight_by_eight() -> None:
    rng = np.random.default_rng(4)
    array = ss.SensorArray.grid(shape=(8, 8), pitch=DEPTH, depth=DEPTH, noise=1e-3 * PEAK)
    finger = ss.Finger(SKIN, array)
    at, force = loads(rng, 20, 3)
    found = finger.locate(read(finger, 2 * at, force, rng), touches=3)
    assert (found.count == 3).mean() > 0.9
    assert np.asarray(found.covariance).shape == (20, 15, 15)
    near = np.linalg.norm(found.each.position[:, :, None] - 2 * at[:, None], axis=-1).min(axis=1)
    assert (near[found.ok] < 0.1 * DEPTH).all()


def test_tolerances_widen_what_is_said_of_two() -> None:
    rng, told = np.random.default_rng(5), ss.Tolerances(gain=0.02, offset=0.005 * PEAK)
    finger = pad(tolerances=told)
    at, force = loads(rng, 100, 2)
    frames = [
        read(ss.Finger(*told.draw(finger.skin, finger.array, rng)), at[i : i + 1], force[i : i + 1], rng)[0]
        for i in range(100)
    ]
    found, exact = finger.locate(frames, touches=2), pad().locate(frames, touches=2)
    off, std = off_and_std(found, at)
    two = found.count == 2
    assert two.mean() > 0.9
    assert (np.abs(off) < 1.96 * std)[two].mean() > 0.9
    assert exact.ok.mean() < 0.5  # the noise alone does not explain them


def test_forces_are_told_with_their_covariance_whole() -> None:
    rng, finger = np.random.default_rng(6), pad()
    at, force = loads(rng, 1, 2)
    found = finger.locate(read(finger, at.repeat(200, 0), force.repeat(200, 0), rng), touches=2)
    total = found.each.load.components[..., 0].sum(axis=-1)[found.ok]
    square = np.asarray(found.covariance)[found.ok]
    std = np.sqrt(square[:, 2, 2] + square[:, 7, 7] + 2 * square[:, 2, 7])
    assert np.std(total) == pytest.approx(np.median(std), rel=0.25)
    assert np.mean(total) == pytest.approx(force[0, :, 0].sum(), abs=3 * np.median(std) / np.sqrt(total.size) + 1e-3)


def test_frames_without_a_touch_without_an_answer_and_without_readings() -> None:
    rng, finger = np.random.default_rng(7), pad()
    at, force = loads(rng, 1, 2)
    good = read(finger, at, force, rng)[0]
    missing = np.where(np.arange(16) == 3, np.nan, good)
    few = np.where(np.arange(16) > 3, np.nan, good)
    wild = np.where(np.arange(16) == 5, good + 1.0, good)
    found = finger.locate([np.zeros(16), missing, few, -good, wild], touches=2)
    names = [ss.Status(s).name for s in found.status]
    assert names == ["NO_CONTACT", "OK", "INCOMPLETE", "UNEXPLAINED", "UNEXPLAINED"]
    assert np.isnan(found.each.position[[0, 2, 3, 4]]).all()
    assert found.count.tolist() == [0, 2, 0, 0, 0]


def test_without_friction_both_press_straight_down() -> None:
    finger = pad()
    at, normal = np.array([[-2e-3, 1e-3], [3e-3, 0.0]]), np.array([1.0, 0.6])
    readings = sum(finger.read(ss.PointLoad(force=n, position=p)) for n, p in zip(normal, at, strict=True))
    found = finger.locate(readings, touches=2, friction=0.0)
    assert int(found.count) == 2
    assert found.each.load.components == pytest.approx(np.stack([normal, 0 * normal, 0 * normal], axis=-1), abs=1e-3)


def test_a_frame_is_told_in_words_and_columns() -> None:
    rng, finger = np.random.default_rng(1), pad()
    at, force = loads(rng, 3, 2)
    found = finger.locate(read(finger, at, force, rng), touches=2)
    assert "touches" in repr(found[0])
    assert found[1:].each.position.shape == (2, 2, 2)
    columns = found.to_dict()
    assert columns["touches"].tolist() == found.count.tolist()
    assert columns["position_y_2"] == pytest.approx(found.each.position[:, 1, 0])
    assert not [name for name in columns if name.startswith("second")]  # a rival is that of the whole frame
    assert columns["probability_1"] + columns["probability_2"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"touches": 0}, "from 1 to 3"), ({"touches": 2.0}, "from 1 to 3"), ({"touches": True}, "from 1 to 3"),
        ({"touches": 2, "doubt": np.zeros(16)}, "no such option"), ({"touches": 2, "outliers": 1}, "one of both"),
        ({"touches": 2, "load": "either"}, "no such option"),
        ({"touches": 2, "normal_force": (0.5, 1.0)}, "no such option"),
    ],
)  # fmt: skip
def test_what_several_touches_refuse(options: dict[str, object], words: str) -> None:
    with pytest.raises(InvalidValueError, match=words):
        pad().locate(np.zeros(16), **options)  # type: ignore[call-overload]


def test_a_row_has_one_touch() -> None:
    row = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(6, 1e-3, 2e-3, noise=1e-4))
    with pytest.raises(InvalidValueError, match="on a row"):
        row.locate(np.zeros(6), touches=2)


def test_the_spread_of_a_calibrated_finger_widens_both() -> None:
    from subskin.spread import Spread

    rng, finger = np.random.default_rng(9), pad()
    at, force = loads(rng, 20, 2)
    readings = read(finger, at, force, rng)
    wider = ss.Finger(SKIN, finger.array, spread=Spread([0.0, 1e-3], straight=[3.0, 3.0], leaning=[3.0, 3.0]))
    found, wide = finger.locate(readings, touches=2), wider.locate(readings, touches=2)
    assert wide.covariance == pytest.approx(9 * found.covariance, nan_ok=True)


def test_errors_in_common_and_forces_of_others_are_taken_out_of_the_readings() -> None:
    """w^T C^-1 w of C = W^-1 + the errors in common, and as well of what no force of the loads explains."""
    from subskin.estimate.settle.elsewhere import whiten
    from subskin.estimate.settle.normal import room_of

    rng = np.random.default_rng(10)
    room, w, along = room_of(2, 3, 3, np.zeros(2), 16), rng.normal(size=16), np.empty((6, 17))
    room.rows[:], room.weight[:] = rng.normal(size=room.rows.shape), rng.uniform(0.5, 2.0, 16)
    common, loads = room.rows[6:], room.rows[2:5]
    inverse = np.linalg.inv(np.diag(1 / room.weight) + common.T @ common)
    assert whiten(w, room, False, along) == (pytest.approx(w @ inverse @ w), 3)
    best = np.linalg.solve(loads @ inverse @ loads.T, loads @ inverse @ w)
    rest = w - best @ loads
    assert whiten(w, room, True, along) == (pytest.approx(rest @ inverse @ rest), 6)


def test_a_sensor_that_stands_elsewhere_errs_by_the_slope_of_both_loads() -> None:
    from subskin.estimate.on_area import several_locator
    from subskin.estimate.settle.normal import room_of
    from subskin.estimate.settle.variants import case_of, lay_out

    finger = pad(tolerances=ss.Tolerances(position=0.05, common=0.0))
    options = {"friction": 1.0, "scan_step": None, "false_alarm": 1e-6, "ambiguity": 13.8, "outliers": 0}
    locator = several_locator(finger, 2, None, options)
    variants, errors, told, _, _ = locator._prepare(finger.array.live)[1]
    at, force = loads(np.random.default_rng(11), 1, 2)
    room = room_of(4, 6, 0, errors.ratios, 16)
    room.at[:], room.load[:] = at.reshape(-1), force.reshape(-1)
    noise, step = np.asarray(finger.array.noise), 1e-6
    parts = [finger.read(ss.PointLoad(position=at[0] + move, components=force[0])).sum(axis=0)
             for move in step * np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])[:, None]]  # fmt: skip
    slope = np.stack([parts[0] - parts[1], parts[2] - parts[3]]) / (2 * step * noise)
    lay_out(np.zeros(16), case_of(variants, errors, told, 2, 16), False, room)
    moved = (0.05 * DEPTH) ** 2 * (slope**2).sum(axis=0)
    assert room.weight == pytest.approx(1 / (1 + moved), rel=1e-3)


def test_several_touches_on_other_axes_are_those_of_single_ones() -> None:
    finger, rng = pad(), np.random.default_rng(11)
    at, force = loads(rng, 6, 2)
    one, two = read(finger, at[:, :1], force[:, :1], rng), read(finger, at, force, rng)
    search = finger.locator(touches=2)
    assert search.covers([[0.0, 0.0], [1.0, 0.0]]).tolist() == [True, False]
    found = search(np.concatenate([one, two]))
    origin, turn = np.array([10e-3, -4e-3]), 0.7
    there = found.moved(origin, turn)
    singly = moved(found.each, origin, turn)
    np.testing.assert_allclose(there.each.position, singly.position, rtol=1e-12)
    np.testing.assert_allclose(there.each.load.components, singly.load.components, rtol=1e-12)
    np.testing.assert_allclose(there.each.load.covariance, singly.load.covariance, rtol=1e-9, atol=1e-18)
    (c, s), pair = (np.cos(turn), np.sin(turn)), there.count == 2
    assert pair.sum() >= 5
    whole = np.zeros((5, 5))
    whole[2, 2] = 1.0
    whole[:2, :2] = whole[3:, 3:] = [[c, -s], [s, c]]
    want = whole @ found.covariance[pair][:, :5, 5:] @ whole.T  # how errors of one touch go with the other's
    np.testing.assert_allclose(there.covariance[pair][:, :5, 5:], want, rtol=1e-9, atol=1e-18)


def test_noise_alone_is_no_contact() -> None:
    array = ss.SensorArray.grid((4, 4), 2e-3, 2e-3, transducer=ss.MeanPressure(), noise=30.0)
    finger, rng = ss.Finger(SKIN, array), np.random.default_rng(1)
    frames = rng.normal(0.0, 30.0, (2000, 16))  # of the free skin: of some no pressing load explains anything
    assert (finger.locate(frames, touches=2).status == ss.Status.NO_CONTACT).all()
