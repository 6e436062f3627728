"""What a drawing and a robot leave open: sensors off their positions and depths, loads and levels not alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import correlated as process
from subskin.calibration._forward import Forward

FIT = ("gain", "depth", "origin", "turn")
DEPTH = 5e-3
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
PLATE = ss.SensorArray.grid(shape=(3, 2), pitch=8e-3, depth=DEPTH, transducer=ss.NormalStress(), noise=10.0)


def touches(count):
    """One in each of 4 x (count / 4) cells, about their middles."""
    y, z = np.meshgrid(np.linspace(-11e-3, 11e-3, count // 4), np.linspace(-8e-3, 8e-3, 4))
    at = np.stack([y, z], axis=-1).reshape(-1, 2)
    return at + np.random.default_rng(9).uniform(-1e-3, 1e-3, at.shape)


def off(rng, position=0.03, depth=0.08):
    """A finger of which no sensor lies quite where it is drawn."""
    y, z = PLATE.points.T + rng.normal(0.0, position * DEPTH, (2, len(PLATE)))
    return ss.Finger(SKIN, replace(PLATE, y=y, z=z, depth=DEPTH * (1 + rng.normal(0.0, depth, len(PLATE)))))


def table_error(found, true):
    """Of the readings per newton at nodes among the touches, and the standard deviations that the table gives."""
    table = found.finger.measured
    rows, columns = (np.flatnonzero(np.abs(nodes) < 10e-3)[::2] for nodes in (table.y, table.z))
    nodes = np.stack(np.meshgrid(table.y[rows], table.z[columns], indexing="ij"), axis=-1)
    on_motor = found.origin + nodes @ np.array(
        [[np.cos(found.turn), np.sin(found.turn)], [-np.sin(found.turn), np.cos(found.turn)]]
    )
    apart = table.values[np.ix_(rows, columns)][..., 0] - true.receptive_field(on_motor)[..., 0]
    return apart, np.sqrt(table.variance[np.ix_(rows, columns)][..., 0])


def test_slopes_are_those_of_a_finger_made_anew():
    true = ss.Finger(SKIN, replace(PLATE, depth=np.linspace(4e-3, 6e-3, 6)))
    forward, at = Forward(true, FIT), touches(8)
    load = np.tile([1.5, 0.3, -0.2], (8, 1))
    slopes = forward.slopes(forward.start(np.zeros(2)), at, load)
    step, array = 2e-6, true.array
    contact = ss.PointLoad(components=load, position=at)
    for k, name in enumerate(("y", "z", "depth")):
        ends = [
            replace(true, array=replace(array, **{name: np.asarray(getattr(array, name)) + side * step})).read(contact)
            for side in (1, -1)
        ]
        expected = (ends[0] - ends[1]) / (2 * step / DEPTH)  # for a depth, the mean of all
        np.testing.assert_allclose(slopes[..., k], expected, atol=5e-3 * np.abs(expected).max())
    np.testing.assert_allclose(slopes[..., 3], true.read(contact), rtol=1e-9, equal_nan=False)


def test_sensors_off_their_drawing_are_learned_from_few_touches(monkeypatch):
    """The table is nearer to the truth than one by a process that knows nothing of tolerances, and knows its error."""
    rng = np.random.default_rng(0)
    true, at = off(rng), touches(16)
    readings = true.read(ss.PointLoad(rng.normal(1.0, 0.03, 16), position=at), rng)
    with_them = ss.calibrate(ss.Finger(SKIN, PLATE), readings, at, fit=FIT)
    monkeypatch.setattr(process, "USUAL", np.full(4, 1e-6))
    without = ss.calibrate(ss.Finger(SKIN, PLATE), readings, at, fit=FIT)
    apart, std = table_error(with_them, true)
    other, _ = table_error(without, true)
    assert (apart**2).mean() < 0.3 * (other**2).mean()
    assert 0.3 < np.sqrt(((apart / std) ** 2).mean()) < 1.5


def test_depths_of_neighbours_go_together_and_positions_do_not():
    """By hand, of sensors 2 depths apart."""
    slopes = np.array([[0, 0, 3.0, 0, 0], [0, 0, -2.0, 0, 0]])
    two = process.Residuals(
        np.zeros(2),
        np.arange(2),
        np.zeros((2, 2)),
        np.ones(2),
        np.arange(2),
        slopes,
        np.array([(0.0, 0.0), (2.0, 0.0)]),
    )
    real = process.Correlated(1.0, np.zeros(4), np.zeros(4), np.array([0.1, 0.05, 0.0, 0.0]))
    across = 0.8 * np.exp(-0.5) * 0.05**2 * 3.0 * -2.0
    np.testing.assert_allclose(real.misfit(two, two), [[0.0225, across], [across, 0.01]])
    np.testing.assert_allclose(real.variance(two), [0.0225, 0.01])
    moved = replace(two, slopes=np.roll(slopes, 1, axis=1))
    assert real.misfit(moved, moved)[0, 1] == 0


@pytest.mark.parametrize("large", range(4))
def test_the_tolerance_that_is_large_is_found(large):
    """Residuals drawn from the process itself: each stands out where it is the large one."""
    truth = np.array([0.01, 0.02, 0.01, 0.5])
    truth[large] = [0.05, 0.15, 0.08, 4.0][large]
    rng = np.random.default_rng(3)
    true, at = ss.Finger(SKIN, PLATE), touches(24)
    touch, sensor = np.divmod(np.arange(24 * 6), 6)
    forward = Forward(true, FIT)
    slopes = forward.slopes(forward.start(np.zeros(2)), at, np.tile([1.0, 0.0, 0.0], (24, 1)))[touch, sensor] / 10.0
    slopes = np.column_stack([slopes, np.ones(144)])
    apart = (at[touch] - PLATE.points[sensor]) / DEPTH
    blank = process.Residuals(np.zeros(144), sensor, apart, np.ones(144), touch, slopes, PLATE.points[sensor] / DEPTH)
    zero = np.zeros(4)
    real = process.Correlated(1.0, zero, zero, truth)
    covariance = real.misfit(blank, blank) + real.of_touches(blank) + np.eye(144)
    jacobian = np.ones((144, 1))
    tolerances = []
    for _ in range(3):
        drawn = np.linalg.cholesky(covariance) @ rng.normal(0.0, 1.0, 144)
        found = process.correlated(replace(blank, value=drawn), jacobian, noise_like=False)
        tolerances.append(np.log(found.tolerances / process.USUAL))
    mean = np.exp(np.mean(tolerances, axis=0))
    assert np.argmax(mean) == large
    assert mean[large] * process.USUAL[large] == pytest.approx(truth[large], rel=0.5)
    expected = jacobian.T @ covariance @ jacobian
    np.testing.assert_allclose(process.scatter(real, blank, jacobian), expected, rtol=1e-9, equal_nan=False)


def test_what_is_a_touchs_own_is_no_misfit_of_touches_to_come():
    real = process.Correlated(1.0, np.zeros(4), np.zeros(4), np.array([0.0, 0.0, 0.1, 3.0]))
    slopes = np.array([[0, 0, 0, 20.0, 1.0], [0, 0, 0, 10.0, 0.5], [0, 0, 0, 5.0, 1.0]])
    three = process.Residuals(
        np.zeros(3), np.arange(3), np.zeros((3, 2)), np.ones(3), np.array([0, 0, 1]), slopes, np.zeros((3, 2))
    )
    expected = [[4.0 + 9.0, 2.0 + 4.5, 0.0], [2.0 + 4.5, 1.0 + 2.25, 0.0], [0.0, 0.0, 0.25 + 9.0]]
    np.testing.assert_allclose(real.of_touches(three), expected)
    assert not real.misfit(three, three).any()
    assert not real.variance(three).any()


def test_levels_that_drift_are_no_misfit():
    """Sensors err together from touch to touch: the finger knows by how much, and allows for it."""
    rng = np.random.default_rng(2)
    true, at = off(rng), touches(20)
    readings = true.read(ss.PointLoad(1.0, position=at), rng) + rng.normal(0.0, 60.0, (20, 1))
    found = ss.calibrate(ss.Finger(SKIN, PLATE), readings, at, fit=FIT).finger
    assert np.asarray(found.measured.common) == pytest.approx(60.0, rel=0.5)
    new = rng.uniform(-6e-3, 6e-3, (150, 2))
    drifted = true.read(ss.PointLoad(1.0, position=new), rng) + rng.normal(0.0, 60.0, (150, 1))
    still = replace(found, measured=replace(found.measured, common=0.0))
    assert found.locate(drifted, friction=0).ok.mean() > still.locate(drifted, friction=0).ok.mean()
