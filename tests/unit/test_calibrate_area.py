"""Calibration of sensors on an area, on touches at known (y, z)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import choose

RUBBER = ss.Material(young=0.4e6, poisson=0.5)
ORIGIN, TURN = np.array([12.3e-3, 9.1e-3]), 0.2
PITCH, DEPTH = 4e-3, 4.4e-3


def grid(skin=None, **changes):
    parameters = {"depth": DEPTH, "transducer": ss.MeanPressure(), "noise": 30.0, **changes}
    return ss.Finger(skin or ss.HalfSpace(RUBBER), ss.SensorArray.grid(shape=(3, 3), pitch=PITCH, **parameters))


def on_motor(at, turn=TURN):
    cos, sin = np.cos(turn), np.sin(turn)
    return ORIGIN + at @ np.array([[cos, sin], [-sin, cos]])


def touches(count, rng, half=7e-3):
    return rng.uniform(-half, half, (count, 2))


@pytest.fixture(scope="module")
def several():
    """Calibrations of fingers of their own, each from 30 touches of 1.5 N, and the truth."""
    out = []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        true = grid(gain=rng.uniform(0.7, 1.3, 9), offset=rng.normal(0.0, 500.0, 9))
        at = touches(30, rng)
        readings = true.read(ss.PointLoad(1.5, position=at), rng)
        out.append((ss.calibrate(grid(depth=5e-3), readings, on_motor(at), force=1.5), true))
    return out


def test_parameters_come_back_within_their_standard_errors(several):
    sigma = []
    for found, true in several:
        truth = {"origin_y": ORIGIN[0], "origin_z": ORIGIN[1], "turn": TURN, "depth": DEPTH}
        for p in found.parameters:
            expected = truth[p.name] if p.sensor is None else getattr(true.array, p.name)[p.sensor]
            sigma.append((p.value - expected) / p.std)
    assert len(sigma) == 5 * (4 + 2 * 9)
    assert 0.8 < np.sqrt(np.mean(np.square(sigma))) < 1.25
    assert np.abs(sigma).max() < 4.5


def test_where_the_model_is_right_there_is_no_response_in_place(several):
    for found, _ in several:
        assert found.finger.measured is None
        assert not found.misfit.structured
        assert found.r2 > 0.9995


def test_positions_of_the_motor_are_those_of_the_finger(several):
    found, true = several[0]
    at = touches(50, np.random.default_rng(9), half=4e-3)
    readings = true.read(ss.PointLoad(1.5, position=at), np.random.default_rng(8))
    np.testing.assert_allclose(found.on_finger(on_motor(at)), at, atol=0.1e-3)
    located = found.finger.locate(readings, friction=0)
    assert located.ok.all()
    error = np.linalg.norm(located.position - found.on_finger(on_motor(at)), axis=1)
    assert np.median(error) < 0.05e-3
    assert found.evaluate(readings, on_motor(at), force=1.5).r2 > 0.9995


def test_drags_turn_with_the_finger():
    rng = np.random.default_rng(1)
    true, at = grid(gain=rng.uniform(0.7, 1.3, 9)), touches(30, rng)
    angle, azimuth = rng.uniform(0.2, 0.7, 30), rng.uniform(-np.pi, np.pi, 30)
    readings = true.read(ss.PointLoad(1.5, angle=angle, azimuth=azimuth - TURN, position=at), rng)
    loads = {"force": 1.5, "angle": angle, "azimuth": azimuth}
    found = ss.calibrate(grid(), readings, on_motor(at), **loads, fit=("gain", "origin", "turn"))
    assert abs(found.turn - TURN) < 4 * found.parameters[2].std
    assert found.evaluate(readings, on_motor(at), **loads).r2 > 0.9999
    assert not found.misfit.structured


def test_candidates_are_compared_by_distance(several):
    """Sensors of pressure read as sensors of normal stress, and as what they are: touches held out tell."""
    true, rng = several[0][1], np.random.default_rng(5)
    at = touches(30, rng, half=5e-3)
    drawn = {kind.__name__: grid(depth=5e-3, transducer=kind()) for kind in (ss.NormalStress, ss.MeanPressure)}
    both = {name: (finger, ("gain", "offset", "depth", "origin", "turn")) for name, finger in drawn.items()}
    readings = true.read(ss.PointLoad(1.5, position=at), rng)
    found = choose(both, readings, on_motor(at), force=1.5, friction=0)
    assert found.best.name == "MeanPressure"
    best, other = found.trials
    assert best.ok > 0.95
    assert best.rms < 0.1e-3
    assert 0.85 < best.held <= 1
    assert other.reason or other.rms > 2 * best.rms


def test_thickness_and_depth_of_a_layer_come_back():
    rng = np.random.default_rng(2)
    true = grid(ss.Layered(ss.Layer(RUBBER, thickness=7e-3)), transducer=ss.NormalStress())
    start = grid(ss.Layered(ss.Layer(RUBBER, thickness=10e-3)), transducer=ss.NormalStress(), depth=4e-3)
    at = touches(40, rng)
    readings = true.read(ss.PointLoad(1.5, position=at), rng)
    fit = ("gain", "depth", "thickness", "origin", "turn")
    found = ss.calibrate(start, readings, on_motor(at), fit=fit, force=1.5, origin=ORIGIN + 0.5e-3)
    truth = {"thickness": 7e-3, "depth": DEPTH, "turn": TURN}
    named = {p.name: p for p in found.parameters if p.name in truth}
    for name, value in truth.items():
        assert abs(named[name].value - value) < 4 * named[name].std
    assert named["thickness"].std < 0.3e-3


def test_what_rounding_leaves_of_exact_readings_is_no_misfit():
    finger = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), ss.SensorArray.grid((5, 5), 2e-3, 2e-3))
    at = np.random.default_rng(14).uniform(-3e-3, 3e-3, (14, 2))
    found = ss.calibrate(finger, finger.read(ss.PointLoad(force=np.ones(14), position=at)), at)
    gains = [p for p in found.parameters if p.name == "gain"]
    assert len(gains) == 25
    assert max(max(abs(p.value - 1.0), p.std) for p in gains) < 1e-9


def test_each_sensor_has_a_position_of_its_own_where_asked():
    rng = np.random.default_rng(3)
    drawn = grid()
    moves = rng.normal(0.0, 0.3e-3, (9, 2))
    points = drawn.array.points + moves
    array = ss.SensorArray(y=points[:, 0], z=points[:, 1], depth=DEPTH, transducer=ss.MeanPressure(), noise=30.0)
    true, at = ss.Finger(ss.HalfSpace(RUBBER), array), touches(60, rng)
    readings = true.read(ss.PointLoad(1.5, position=at), rng)
    fit = ("gain", "depth", "origin", "turn", "position")
    found = ss.calibrate(drawn, readings, on_motor(at), fit=fit, force=1.5)
    # the whole has its origin and its turn: compared on the motor's axes
    cos, sin = np.cos(found.turn), np.sin(found.turn)
    of_motor = found.origin + found.finger.array.points @ np.array([[cos, sin], [-sin, cos]])
    np.testing.assert_allclose(of_motor, on_motor(points), atol=0.05e-3)
    assert sum(p.name in ("y", "z") for p in found.parameters) == 18


def test_a_finger_mounted_again_needs_three_touches():
    rng = np.random.default_rng(4)
    true = grid(gain=rng.uniform(0.7, 1.3, 9))
    at = np.array([(-3e-3, -2e-3), (4e-3, 0.0), (0.0, 4e-3)])
    readings = true.read(ss.PointLoad(1.5, position=at), rng)
    found = ss.calibrate(true, readings, on_motor(at, 0.0), fit=["origin"], force=1.5)
    np.testing.assert_allclose(found.origin, ORIGIN, atol=0.05e-3)


@pytest.fixture(scope="module")
def wrong_field():
    """A layer with sensors of stress, drawn as a half space with sensors of strain; calibrated on 25 touches of 36."""
    rng = np.random.default_rng(5)
    true = grid(ss.Layered(ss.Layer(RUBBER, thickness=6e-3)), transducer=ss.NormalStress(), noise=15.0)
    steps = np.linspace(-6e-3, 6e-3, 5)
    at = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    readings = true.read(ss.PointLoad(1.5, position=at), rng)
    drawn = grid(transducer=ss.NormalStrain(), noise=15.0)
    found = ss.calibrate(drawn, readings, on_motor(at), fit=("gain", "depth", "origin", "turn"), force=1.5)
    inside = touches(150, rng, half=4e-3)
    return found, inside, true.read(ss.PointLoad(1.5, position=inside), rng), true


def test_what_the_field_misses_is_put_right_in_place(wrong_field):
    found, at, readings, _ = wrong_field
    assert found.finger.measured is not None
    truth = found.on_finger(on_motor(at))
    located = found.finger.locate(readings, friction=0)
    before = replace(found.finger, measured=None).locate(readings, friction=0)
    error = np.linalg.norm(located.position - truth, axis=1)
    assert np.nanmedian(error) < 0.5 * np.nanmedian(np.linalg.norm(before.position - truth, axis=1))
    assert located.ok.mean() > 0.9
    corrected = found.evaluate(readings, on_motor(at), force=1.5).r2_sensor.min()
    assert corrected > 0.995


def test_the_intervals_of_a_corrected_field_hold_the_truth(wrong_field):
    found, at, readings, _ = wrong_field
    located = found.finger.locate(readings, friction=0)
    std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[:, :2])
    error = np.abs(located.position - found.on_finger(on_motor(at)))
    held = (error <= 1.96 * std)[located.ok].mean()
    assert 0.85 < held <= 1.0
    assert found.held_out[0] > 5


def test_the_table_knows_how_far_it_is_off(wrong_field):
    found, _, _, true = wrong_field
    table = found.finger.measured
    rows, columns = (np.flatnonzero(np.abs(nodes) < 6e-3)[::3] for nodes in (table.y, table.z))
    nodes = np.stack(np.meshgrid(table.y[rows], table.z[columns], indexing="ij"), axis=-1)
    off = table.values[np.ix_(rows, columns)][..., 0] - true.receptive_field(nodes)[..., 0]
    z = off / np.sqrt(table.variance[np.ix_(rows, columns)][..., 0])
    assert 0.3 < np.sqrt((z**2).mean()) < 1.5
    size = np.sqrt(table.variance[..., 0].mean(axis=2))
    assert size[0, 0] > 2 * size[len(table.y) // 2, len(table.z) // 2]  # beyond the touches less is known


TEXT = """
skin = {kind = "half_space", young = "0.4 MPa"}
sensors = {layout = "grid", shape = [3, 3], pitch = "4 mm", depth = "4.4 mm", noise = 15.0}
locate = {friction = 0}
"""


def test_a_file_answers_as_the_finger_does_to_the_last_bit(wrong_field, tmp_path):
    found, at, readings, _ = wrong_field
    file = ss.io.parse_finger(TEXT).with_finger(found.finger, found.origin, turn=found.turn)
    ss.io.save_finger(file, tmp_path / "found.toml")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["found.response.npz", "found.toml"]
    again = ss.load(tmp_path / "found.toml")
    for name in ("y", "z", "values", "variance", "offset", "noise", "correlation", "load", "common"):
        np.testing.assert_array_equal(getattr(again.finger.measured, name), getattr(found.finger.measured, name))
    located, expected = again.locate(readings), found.finger.locate(readings, friction=0)
    np.testing.assert_array_equal(located.table, expected.table)
    np.testing.assert_allclose(again.on_finger(on_motor(at)), found.on_finger(on_motor(at)), atol=1e-11)
    on_motors = again.on_touches(located.position)
    assert np.nanmedian(np.linalg.norm(on_motors - on_motor(at), axis=1)) < 0.1e-3


def test_mounted_again_a_finger_keeps_what_was_measured_in_place(wrong_field):
    """Only the origin is fitted: by the response, which errs less than the field, at the turn that is known."""
    found, _, _, true = wrong_field
    at = np.array([(4e-3, 3e-3), (5e-3, 0.0), (3e-3, 5e-3)])  # on one side, where the field errs one way
    readings = true.read(ss.PointLoad(1.5, position=at), np.random.default_rng(3))
    given = {"fit": ["origin"], "force": 1.5, "turn": 0.5}
    again = ss.calibrate(found.finger, readings, on_motor(at, 0.5), **given)
    assert again.finger.measured is found.finger.measured
    assert again.turn == 0.5
    # the response has its own small error of origin and turn: positions are compared
    off = np.linalg.norm(again.on_finger(on_motor(at, 0.5)) - found.on_finger(on_motor(at)), axis=1)
    assert off.max() < 0.1e-3
    field = ss.calibrate(replace(found.finger, measured=None), readings, on_motor(at, 0.5), **given)
    apart = np.linalg.norm(field.on_finger(on_motor(at, 0.5)) - found.on_finger(on_motor(at)), axis=1)
    assert off.max() < 0.3 * apart.max()
    row = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
    with pytest.raises(ss.errors.GeometryError, match="knows no turn"):
        ss.calibrate(row, np.ones((12, 4)), np.zeros(12), turn=0.3)


def test_what_cannot_be_is_refused():
    finger = grid()
    readings = np.ones((12, 9))
    with pytest.raises(ss.errors.GeometryError, match=r"one position \(y, z\)"):
        ss.calibrate(finger, readings, np.zeros(12))
    with pytest.raises(ss.errors.InvalidValueError, match="width"):
        ss.calibrate(finger, readings, np.zeros((12, 2)), fit=["width"])
    with pytest.raises(ss.errors.GeometryError, match="origin"):
        ss.calibrate(finger, readings, np.zeros((12, 2)), origin=0.0)
    row = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(4, pitch=6e-3, depth=5e-3))
    with pytest.raises(ss.errors.GeometryError, match="azimuth"):
        ss.calibrate(row, np.ones((12, 4)), np.zeros(12), azimuth=0.3)


def test_a_reading_that_was_lost_is_left_out_and_named():
    rng = np.random.default_rng(7)
    skin = ss.HalfSpace(ss.Material(young=0.4e6))
    grid = {"shape": (2, 3), "pitch": 5e-3, "transducer": ss.NormalStress(), "noise": 20.0}
    real = ss.Finger(skin, ss.SensorArray.grid(depth=4.5e-3, gain=[1.0, 0.9, 1.1, 1.05, 0.95, 1.0], **grid))
    drawn = ss.Finger(skin, ss.SensorArray.grid(depth=4e-3, **grid))
    at = rng.uniform([-4e-3, -7e-3], [4e-3, 7e-3], (24, 2))
    readings = np.array(real.read(ss.PointLoad(force=1.0, position=at), rng))
    fit = ("gain", "depth", "origin")
    whole = ss.calibrate(drawn, readings, at, fit=fit)
    assert whole.left_out == ()
    touch, sensor = np.unravel_index(np.argmax(np.abs(readings)), readings.shape)
    damaged, missing = readings.copy(), readings.copy()
    damaged[touch, sensor] = 0.0
    missing[touch, sensor] = np.nan
    found, expected = (ss.calibrate(drawn, given, at, fit=fit) for given in (damaged, missing))
    assert found.left_out == ((touch, sensor),)
    assert found.doubts[0].startswith(f"the reading of sensor {sensor} at touch {touch} ")
    np.testing.assert_allclose(found.finger.array.gain, expected.finger.array.gain, rtol=1e-9)
    assert not any("left out" in doubt for doubt in expected.doubts)
    # a skin that the model does not quite fit leaves no such reading
    other = ss.Finger(skin, ss.SensorArray.grid(**{**grid, "transducer": ss.NormalStrain(), "depth": 4e-3}))
    assert ss.calibrate(other, readings, at, fit=fit, accept_misfit=True).left_out == ()
