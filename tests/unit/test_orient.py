"""Which way round the sensors are, from presses at told positions, for fingers that are not quite their drawing."""

import numpy as np
import pytest

import subskin as ss
from subskin.calibration import orient, telling
from subskin.errors import GeometryError, InvalidValueError

DEPTH = 3e-3
RUBBER = ss.Material(young=0.4e6)
TOLD = ss.Tolerances(gain=0.02, position=0.05)
ROW = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(6, DEPTH, DEPTH, noise=4e-4))
GRID = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid((4, 4), DEPTH, DEPTH, noise=4e-4))
SQUARE = np.arange(16).reshape(4, 4)


def presses(finger, rng, sites):
    """Readings of a finger as made, pressed near some sensors."""
    array, read = finger.array, []
    made = ss.Finger(*TOLD.draw(finger.skin, array, rng))
    for i in sites:
        off, lean, turn = rng.uniform(-0.5, 0.5, 2) * DEPTH, rng.uniform(0, 0.3), rng.uniform(-np.pi, np.pi)
        force = rng.uniform(0.5, 2.0)
        if array.on_area:
            press = ss.PointLoad(force=force, angle=lean, azimuth=turn, position=array.points[i] + off)
        else:
            press = ss.LineLoad(force=40 * force, angle=lean, position=array.y[i] + off[0])
        read.append(made.read(press, rng))
    return np.array(read), array.points[sites] if array.on_area else np.asarray(array.y)[sites]


@pytest.mark.parametrize(
    ("finger", "order"),
    [
        (ROW, np.arange(6)), (ROW, np.arange(6)[::-1]),
        (GRID, SQUARE.reshape(-1)), (GRID, SQUARE[::-1, ::-1].reshape(-1)), (GRID, SQUARE[::-1].reshape(-1)),
        (GRID, SQUARE[:, ::-1].reshape(-1)), (GRID, SQUARE.T.reshape(-1)), (GRID, np.rot90(SQUARE).reshape(-1)),
    ],
    ids=["row", "row reversed", "grid", "reversed", "y mirrored", "z mirrored", "swapped", "turned"],
)  # fmt: skip
@pytest.mark.parametrize("sign", [1, -1])
def test_each_way_is_found(finger, order, sign):
    rng, sites = np.random.default_rng(5), telling(finger, 3)
    for _ in range(5):
        readings, near = presses(finger, rng, sites)
        found = orient(finger, sign * readings[:, order], near)  # sensor order[i] is read by channel i
        assert found.sure
        assert found.sign == sign
        assert (found.order == np.argsort(order)).all()
        assert found.as_drawn == (sign > 0 and (order == np.arange(order.size)).all())


def test_neighbours_that_are_swapped_beneath_a_press():
    rng = np.random.default_rng(1)
    readings, near = presses(ROW, rng, [0, 2, 5])
    swapped = readings[:, [0, 2, 1, 3, 4, 5]]
    found = orient(ROW, swapped, near)
    assert found.order.tolist() == [0, 2, 1, 3, 4, 5]
    assert "s1 and s2 are swapped" in found.name


def test_the_scale_and_its_error():
    rng = np.random.default_rng(2)
    sites = telling(GRID, 2)
    at = GRID.array.points[sites]
    found = orient(GRID, 3 * GRID.read(ss.PointLoad(force=1.0, position=at), rng), at, force=1.0)
    assert found.as_drawn
    assert abs(found.scale - 3.0) < 3 * found.scale_std
    assert np.isnan(orient(GRID, GRID.read(ss.PointLoad(force=1.0, position=at)), at).scale)


def test_a_press_on_an_axis_of_symmetry_is_not_enough():
    at = GRID.array.points[[0]]  # y and z alike
    found = orient(GRID, GRID.read(ss.PointLoad(force=1.0, position=at)), at)
    assert not found.sure
    assert found.press not in (0, 5, 10, 15)
    assert "press near" in str(found)


def test_what_no_order_explains():
    readings = np.random.default_rng(0).normal(0, 0.01, (2, 16))
    found = orient(GRID, readings, GRID.array.points[[1, 7]])
    assert (found.sure, found.as_drawn, found.probability) == (False, False, 0.0)
    assert "no order explains" in found.name


def test_several_channels_at_a_position_keep_their_order():
    one = ss.SensorArray.grid((3, 3), DEPTH, DEPTH)
    kinds = [ss.NormalStrain(), ss.ShearStrain("xy")] * 9
    both = ss.SensorArray(y=np.repeat(one.y, 2), z=np.repeat(one.z, 2), depth=DEPTH, transducer=kinds, noise=4e-4)
    finger = ss.Finger(ss.HalfSpace(RUBBER), both)
    readings, near = presses(finger, np.random.default_rng(3), [2, 10])
    assert orient(finger, readings, near).as_drawn


def test_bad_input():
    with pytest.raises(GeometryError, match="one position for each press"):
        orient(GRID, np.zeros((2, 16)), np.zeros(2))
    with pytest.raises(InvalidValueError, match="force"):
        orient(GRID, np.zeros((1, 16)), np.zeros((1, 2)), force=-1.0)
    with pytest.raises(InvalidValueError, match="presses"):
        telling(GRID, 0)


@pytest.mark.parametrize(
    ("order", "name"),
    [([5, 4, 3, 2, 1, 0], "in reversed order"), ([0, 1, 2, 3, 4, 5], None)],
    ids=["reversed", "drawn"],
)
def test_a_calibration_of_a_row_shows_the_order(order, name):
    rng, at = np.random.default_rng(0), np.linspace(-2 * DEPTH, 2 * DEPTH, 20)
    readings = ROW.read(ss.LineLoad(40.0, position=at), rng)[:, order]
    if name is None:
        assert ss.calibrate(ROW, readings, at).tells_order
        return
    with pytest.raises(ss.errors.ConvergenceError, match=name) as wrong:
        ss.calibrate(ROW, readings, at)
    assert str(order) in str(wrong.value)
    assert not ss.calibrate(ROW, readings, at, accept_misfit=True).tells_order
    narrow = np.linspace(-0.5 * DEPTH, 0.5 * DEPTH, 20)  # too narrow to tell
    found = ss.calibrate(ROW, ROW.read(ss.LineLoad(40.0, position=narrow), rng), narrow, accept_misfit=True)
    assert found.r2 > 0.9
    assert not found.tells_order


def test_a_calibration_of_an_area_names_a_mirrored_board():
    rng = np.random.default_rng(0)
    at = rng.uniform(-1.5 * DEPTH, 1.5 * DEPTH, (30, 2))
    readings = GRID.read(ss.PointLoad(1.0, position=at), rng)[:, SQUARE[::-1].reshape(-1)]
    with pytest.raises(ss.errors.ConvergenceError, match="mirrored: y has the wrong sign"):
        ss.calibrate(GRID, readings, at)
    right = ss.calibrate(GRID, readings[:, SQUARE[::-1].reshape(-1)], at)
    assert right.tells_order
