"""A row under touches on a point, on it or beside it: what is found, what is not said, and line or point."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import subskin as ss
from subskin.skin import in_space

RUBBER = ss.Material(young=0.4e6)
ROW = ss.SensorArray.line(6, pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=30.0)
DEPTH, COUNT = 2e-3, 400


@pytest.fixture(scope="module")
def finger():
    """A half plane, as the file of a row says; touches on a point are those of the half space."""
    return ss.Finger(ss.HalfPlane(RUBBER), ROW)


@pytest.fixture(scope="module")
def space():
    return ss.Finger(ss.HalfSpace(RUBBER), ROW)


def touches(least, most, *, across=True, seed=0):
    """Loads of 1 N on points from `least` to `most` depths beside the row, leaning within 35 degrees."""
    rng = np.random.default_rng(seed)
    at = np.stack([rng.uniform(-5e-3, 5e-3, COUNT), DEPTH * rng.uniform(least, most, COUNT)], axis=-1)
    azimuth = rng.uniform(-np.pi, np.pi, COUNT) if across else np.pi * rng.integers(0, 2, COUNT)
    return ss.PointLoad(1.0, rng.uniform(0, 0.6, COUNT), azimuth, at)


def std(found):
    return np.sqrt(found.load.covariance[:, 0, 0])


def wrong(found, std, position):
    off = np.abs(found.position - position)
    return found.ok & ((off > 5 * std) | (off > 0.3 * DEPTH))


def test_position_distance_and_force_come_back_exactly(finger, space):
    touch = ss.PointLoad(components=[(1.0, 0.3, 0.0), (2.0, -0.5, 0.0)], position=[(0.7e-3, 1.5e-3), (-3e-3, -2.5e-3)])
    found = finger.locate(space.read(touch), load="point")
    assert found.ok.all()
    np.testing.assert_allclose(found.position, touch.position[:, 0], atol=1e-7)
    np.testing.assert_allclose(found.beside, np.abs(touch.position[:, 1]), atol=1e-6)
    np.testing.assert_allclose(found.load.components, touch.components[:, :2], rtol=1e-4)
    assert (found.half_width == 0).all()
    assert "beside" in repr(found)
    assert " N," in repr(found[0])
    columns = found.to_dict()
    assert (columns["beside_low"] <= columns["beside"]).all()
    assert "half_width" not in columns


def test_a_drag_across_is_carried_as_uncertainty_of_the_force(finger, space):
    """On a half space N depth - Tz z is all that is seen; 95 % intervals of N hold with any Tz in the cone."""
    touch = touches(0.5, 1.5)
    found = finger.locate(space.read(touch, np.random.default_rng(1)), load="point")
    n, seen = touch.components[:, 0], found.load.components[:, 0]
    std = np.sqrt(found.load.covariance[:, 1, 1])
    inside = (np.abs(seen - n) < 1.96 * std)[found.ok]
    assert inside.mean() > 0.93
    shift = -touch.components[:, 2] * touch.position[:, 1] / DEPTH
    assert np.median(np.abs(seen - n - shift)[found.ok]) < 0.2 * np.median(np.abs(shift))
    straight = touches(0.5, 1.5, across=False)
    alone = finger.locate(space.read(straight), load="point", friction=0.7)
    assert np.median(np.abs(alone.load.components[:, 0] - straight.components[:, 0])) < 1e-3


@pytest.mark.parametrize(("least", "most"), [(0.0, 0.5), (0.5, 1.5), (1.5, 3.0), (3.0, 5.0)])
def test_no_touch_beside_the_row_is_ok_and_wrong(finger, space, least, most):
    """Where a line load is OK and wrong for many of them."""
    touch = touches(least, most, seed=2)
    frames, y = space.read(touch, np.random.default_rng(3)), touch.position[:, 0]
    point, either, line = (finger.locate(frames, load=load) for load in ("point", "either", "line"))
    assert wrong(point, std(point), y).mean() <= 0.005
    assert wrong(either, either.position_std, y).mean() <= 0.005
    if most < 3:
        assert point.ok.mean() > 0.5
        assert least == 0 or wrong(line, std(line), y).mean() > 0.02
        inside = (np.abs(point.position - y) < 1.96 * std(point))[point.ok]
        assert 0.91 < inside.mean() < 0.99
        low, high = point.beside_interval.T
        z = touch.position[:, 1]
        assert 0.9 < ((low <= z) & (z <= high))[point.ok].mean() <= 1.0


def test_either_says_which(finger, space):
    rng = np.random.default_rng(4)
    y = rng.uniform(-5e-3, 5e-3, COUNT)
    line = finger.locate(finger.read(ss.LineLoad(150.0, rng.uniform(-0.6, 0.6, COUNT), y), rng), load="either")
    point = finger.locate(space.read(touches(0.0, 1.0), rng), load="either")
    assert line.ok.mean() > 0.9
    assert (line.point_probability < 0.05)[line.ok].mean() > 0.9
    assert point.ok.mean() > 0.8
    assert (point.point_probability > 0.95)[point.ok].mean() > 0.9
    assert 0.90 < (np.abs(line.position - y) < 1.96 * line.position_std)[line.ok].mean() < 0.985
    # what is told is calibrated: of those called a point with a probability near p, about p are
    p = np.concatenate([line.point_probability, point.point_probability])
    truth = np.repeat([0.0, 1.0], COUNT)
    known = np.isfinite(p)
    assert np.mean((p - truth)[known] ** 2) < 0.05
    one = line[5]
    assert one.shape == ()
    assert one.line.shape == ()
    assert "point probability" in repr(one)
    both = type(line).join([line[:3], line[3:6]])
    np.testing.assert_array_equal(both.position, line.position[:6])
    assert set(line.to_dict()) >= {"position", "position_std", "point_probability", "status"}


def test_nothing_and_nonsense(finger):
    rng = np.random.default_rng(5)
    free = finger.locate(rng.normal(0, 30.0, (50, 6)), load="either")
    assert (free.status == ss.Status.NO_CONTACT).all()
    assert np.isnan(free.position).all()
    pulled = finger.locate(-finger.read(ss.LineLoad(150.0, 0.0, np.linspace(-4e-3, 4e-3, 9))), load="either")
    assert not pulled.ok.any()
    few = finger.locate([[1.0, np.nan, np.nan, np.nan, np.nan, 2.0]], load="either")
    assert few.status == ss.Status.INCOMPLETE


def test_a_layer_takes_points_and_a_slice_does_not():
    layer = ss.Finger(ss.Layered(ss.Layer(RUBBER, 5e-3)), ROW)
    touch = ss.PointLoad(components=(1.0, 0.2, 0.0), position=(0.5e-3, 1e-3))
    found = layer.locate(layer.read(touch), load="point")
    assert found.ok
    assert abs(found.position - 0.5e-3) < 1e-6
    assert abs(found.beside - 1e-3) < 1e-5
    assert in_space(layer.skin) is layer.skin
    for skin in (ss.HalfPlane(RUBBER, plane="stress"), ss.Round(RUBBER, 10e-3, 5e-3)):
        assert in_space(skin) is None
        with pytest.raises(ss.errors.InvalidValueError, match="known in space"):
            ss.Finger(skin, ROW).locate(np.ones(6), load="either")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"load": "area"}, 'has to be "line", "point", "either" or "patch"'),
        ({"beside": 1e-3}, "no distance beside the row"),
        ({"load": "point", "beside": 1.0}, "up to 6 depths"),
        ({"load": "point", "beside": -1.0}, "beside"),
        ({"load": "point", "normal_force": (0.0, 1.0)}, "no such option"),
    ],
)
def test_options_are_checked(finger, options, message):
    with pytest.raises(ss.errors.InvalidValueError, match=message):
        finger.locate(np.ones(6), **options)
    with pytest.raises(ss.errors.InvalidValueError, match="a fit is of one family"):
        finger.fit(np.ones(6), "either")


def test_blind_spots_know_touches_on_points(finger):
    spots = finger.blind_spots(snr=300, count=200)
    assert spots["beside"].wrong > 0.02
    assert {"point", "beside", "far_beside"} <= {row.name for row in spots.rows}
    told = finger.blind_spots(snr=300, count=50, family="point")
    assert "beside" not in {row.name for row in told.rows}


@pytest.mark.parametrize("sensors", [4, 8])
def test_what_is_neither_a_line_nor_a_point_passes_no_more_often(sensors):
    """Two touches, wide rollers, sensors that are not as drawn: twice as many if a contact need not fit well."""
    array = ss.SensorArray.line(sensors, 2e-3, 2e-3, transducer=ss.MeanPressure(), noise=30.0)
    tip = ss.Finger(ss.HalfSpace(RUBBER), array)
    either, line = tip.blind_spots(snr=300, count=300), tip.blind_spots(snr=300, count=300, family="line")
    assert either.family == "either"
    names = {row.name for row in either.rows} - {"line"}
    assert not names & {"point", "beside"}
    mean = [np.mean([spots[name].wrong for name in names]) for spots in (either, line)]
    assert mean[0] < 0.04
    assert mean[0] < mean[1]


def test_a_drag_across_makes_the_one_along_look_steeper_than_friction(space):
    """T / (N - Tz z / depth) = 0.28 / 0.9 lies beyond mu = 0.3, and the load does not."""
    touch = ss.PointLoad(components=(1.0, 0.28, 0.1), position=(0.5e-3, DEPTH))
    found = space.locate(space.read(touch), load="point", friction=0.3, beside=1.2 * DEPTH)
    assert found.ok
    np.testing.assert_allclose(found.load.components, [0.9, 0.28], rtol=1e-3, equal_nan=False)
    assert abs(found.beside - DEPTH) < 1e-5


def test_four_sensors_take_a_line_for_the_likelier():
    """A force that is unsure because of what a row does not see is no evidence for a point."""
    four = ss.SensorArray.line(4, pitch=2e-3, depth=2e-3, transducer=ss.MeanPressure(), noise=30.0)
    rng = np.random.default_rng(7)
    row = ss.Finger(ss.HalfPlane(RUBBER), four)
    load = ss.LineLoad(150.0, rng.uniform(-0.6, 0.6, 300), rng.uniform(-3e-3, 3e-3, 300))
    found = row.locate(row.read(load, rng), load="either")
    assert np.nanmean(found.point_probability) < 0.15


def test_a_row_of_strains_with_two_tops_along_the_distance_is_never_ok_and_wrong():
    """Strains along the depth fall and rise: loads at other distances, with another drag, read nearly the same."""
    skin, full = ss.HalfSpace(ss.Material(young=1.0)), 3 / (2 * np.pi)
    tip = ss.Finger(skin, ss.SensorArray.line(5, pitch=0.9, depth=1.0, noise=1e-3 * full))
    rng = np.random.default_rng(3)
    at = np.stack([rng.uniform(-1.8, 1.8, 1500), rng.uniform(0.3, 1.0, 1500)], axis=-1)
    touch = ss.PointLoad(np.ones(1500), rng.uniform(0, 0.7, 1500), rng.uniform(-np.pi, np.pi, 1500), at)
    found = tip.locate(tip.read(touch, rng), load="point")
    off = np.abs(found.position - at[:, 0])
    assert found.ok.mean() > 0.5
    assert (found.ok & ((off > 5 * std(found)) | (off > 0.3))).sum() <= 2  # 53 by the top that the scan finds


def test_four_strains_cannot_rule_a_point_out():
    tip = ss.Finger(
        ss.HalfSpace(ss.Material(young=1.0)), ss.SensorArray.line(4, 1.0, 1.0, noise=1e-2 * 3 / (2 * np.pi))
    )
    rng = np.random.default_rng(0)
    at = np.stack([rng.uniform(-1.5, 1.5, 600), rng.uniform(0.0, 0.6, 600)], axis=-1)
    touch = ss.PointLoad(1.0, rng.uniform(0, 0.7, 600), rng.uniform(-np.pi, np.pi, 600), at)
    found = tip.locate(tip.read(touch, rng), load="either")
    off = np.abs(found.position - at[:, 0])
    # 47 where a point that takes up every reading is told from a line by the width of its top
    assert (found.ok & ((off > 5 * found.position_std) | (off > 0.3))).sum() <= 2


def test_the_doubt_of_the_distance_is_in_the_interval_of_the_position():
    """Strains with 1 % noise beside the row: a parabola's 95 % intervals hold 90 % of the positions."""
    rng = np.random.default_rng(3)
    array = ss.SensorArray.line(6, pitch=0.9, depth=1.0, noise=1e-2 * 3 / (2 * np.pi))
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)
    y, z = rng.uniform(-2.25, 2.25, 4000), rng.uniform(0.3, 1.0, 4000)
    angle, azimuth = rng.uniform(0, np.deg2rad(40), 4000), rng.uniform(-np.pi, np.pi, 4000)
    touch = ss.PointLoad(force=1.0, angle=angle, azimuth=azimuth, position=np.stack([y, z], axis=-1))
    found = tip.locate(tip.read(touch, rng), load="point")
    held = np.abs(found.position - y)[found.ok] < 1.959964 * found.std[found.ok, 0]
    assert found.ok.mean() > 0.3
    assert 0.93 < held.mean() < 0.975


def test_what_is_sought_unasked(finger, space):
    """A skin in space: a line or a point, with tolerances too. A skin in a plane, a stated force: a line."""
    touch = ss.PointLoad(components=(1.0, 0.2, 0.0), position=(0.5e-3, 1.5e-3))
    readings = space.read(touch)
    assert isinstance(space.locate(readings), ss.estimate.Either)
    assert isinstance(space.locator(), type(space.locator("either")))
    assert isinstance(dataclasses.replace(space, tolerances=ss.Tolerances()).locate(readings), ss.estimate.Either)
    for tip, options in ((finger, {}), (space, {"normal_force": (1.0, 200.0)}), (space, {"load": "line"})):
        assert isinstance(tip.locate(readings, **options), ss.Estimate)
    with pytest.raises(ss.errors.InvalidValueError, match='load="line"'):
        ss.decide.slip(space.locate(readings), 0.5)
    with pytest.raises(ss.errors.InvalidValueError, match="for points on the row"):
        space.locate(readings, load="either", beside=0.0)


def test_a_point_on_the_row_has_one_unknown_less(space):
    touch = ss.PointLoad(components=[(1.0, 0.3, 0.0), (2.0, -0.5, 0.0)], position=[(0.7e-3, 0.0), (-3e-3, 0.0)])
    found = space.locate(space.read(touch), load="point", beside=0.0)
    assert found.ok.all()
    np.testing.assert_allclose(found.position, touch.position[:, 0], atol=1e-8)
    np.testing.assert_allclose(found.load.components, touch.components[:, :2], rtol=1e-6)
    assert (found.spare == 3).all()
    assert (found.beside == 0).all()
    assert " N," in repr(found[0])
    four = dataclasses.replace(space, array=ROW.select([1, 2, 3, 4]))
    one = ss.PointLoad(components=(1.0, 0.2, 0.0), position=(0.4e-3, 0.0))
    assert four.locate(four.read(one), load="point", beside=0.0).ok
    assert not four.locate(four.read(one), load="point").ok  # nothing to spare


def test_numbers_of_either_are_those_of_the_likeliest(space):
    rng = np.random.default_rng(0)
    y = [-2e-3, 0.5e-3, 1.5e-3]
    line = ss.LineLoad(150.0, 0.2, y[0])
    points = ss.PointLoad(components=[(1.0, 0.2, 0.0), (1.0, 0.1, 0.0)], position=[(y[1], 0.0), (y[2], 2e-3)])
    found = space.locate(np.vstack([space.read(line, rng), space.read(points, rng)]))
    assert found.ok.all()
    assert found.point_probability.round(2).tolist() == [0.0, 1.0, 1.0]
    np.testing.assert_allclose(found.position, y, atol=5e-5)
    np.testing.assert_allclose(found.force, [150.0, np.hypot(1.0, 0.2), np.hypot(1.0, 0.1)], rtol=0.02)
    np.testing.assert_allclose(found.angle, [0.2, np.arctan(0.2), np.arctan(0.1)], atol=0.02)
    np.testing.assert_allclose(found.beside, [0.0, 0.0, 2e-3], atol=1e-4)
    np.testing.assert_array_equal(found.std[:, 0], found.position_std)
    assert found.components.shape == (3, 2)
    assert "N/m" in repr(found[0])
    assert " N," in repr(found[1])


@pytest.mark.parametrize("kind", [ss.MeanPressure, ss.NormalStrain])
@pytest.mark.parametrize(("sensors", "friction", "ok"), [(4, 1.0, 0.5), (4, 0.0, 0.95), (6, 1.0, 0.85)])
def test_on_the_row_it_costs_little_and_its_intervals_hold(kind, sensors, friction, ok):
    """Noise 1 %, touches that lean within 40 degrees: lines, points on the row, and points beside it."""
    tip = ss.Finger(
        ss.HalfSpace(ss.Material(young=1.0)), ss.SensorArray.line(sensors, 1.0, 1.0, transducer=kind(), noise=1.0)
    )
    full = np.abs(tip.read(ss.PointLoad(1.0, position=(float(tip.array.y[1]), 0.0)))).max()
    tip = dataclasses.replace(tip, array=dataclasses.replace(tip.array, noise=1e-2 * full))
    rng = np.random.default_rng(sensors)
    for strip in (None, 0.0, 0.3, 1.0):
        at, drag = rng.uniform(*tip.array.y[[0, -1]], 800), friction * np.tan(rng.uniform(0, 0.7, 800))
        azimuth = rng.uniform(-np.pi, np.pi, 800)
        if strip is None:
            size = full / np.abs(tip.read(ss.LineLoad(1.0, position=float(tip.array.y[1])))).max()
            force = size * np.stack([np.ones(800), drag * np.sign(azimuth)], axis=-1)
            load = ss.LineLoad.of_components(force, at)
        else:
            force = np.stack([np.ones(800), drag * np.cos(azimuth), drag * np.sin(azimuth)], axis=-1)
            load = ss.PointLoad(components=force, position=np.stack([at, rng.uniform(0, strip, 800)], axis=-1))
        found = tip.locate(tip.read(load, rng), load="either", friction=friction)
        off = np.abs(found.position - at)
        assert (found.ok & ((off > 5 * found.position_std) | (off > 0.3))).mean() <= 0.015
        if strip is None or strip < 1:
            assert found.ok.mean() > ok
            assert 0.925 < (off < 1.959964 * found.position_std)[found.ok].mean() < 0.995


def test_the_probability_is_that_of_an_integral_over_all_loads():
    """A line, a point on the row and one beside it, five readings: sums over position, distance, force and drag."""
    tip = ss.Finger(
        ss.HalfSpace(ss.Material(young=1.0)),
        ss.SensorArray.line(5, 1.0, 1.0, transducer=ss.MeanPressure(), noise=3e-2 / (2 * np.pi)),
    )
    rng, noise = np.random.default_rng(2), 3e-2 / (2 * np.pi)
    y, away = np.linspace(-3.5, 3.5, 1401), np.linspace(0.0, 3.0, 61)
    lines = tip.receptive_field(y, "line")
    points = np.stack([tip.receptive_field(np.stack([y, np.full_like(y, z)], axis=-1), "point")[..., :2] for z in away])

    def summed(fields, w):
        """Of exp(-chi-square / 2) over position and force, over all that was thought possible of them."""
        a = fields / noise
        square = np.einsum("...nk,...nl->...kl", a, a)
        best = np.linalg.solve(square, np.einsum("...nk,n->...k", a, w)[..., None])[..., 0]
        left = ((w - np.einsum("...nk,...k->...n", a, best)) ** 2).sum(axis=-1)
        inside = (best[..., 0] > 0) & (np.abs(best[..., 1]) < best[..., 0])
        value = np.exp(-0.5 * left) * 2 * np.pi / np.sqrt(np.maximum(np.linalg.det(square), 1.0)) * inside
        size2 = (best.reshape(-1, 2)[np.argmin(np.where(inside, left, np.inf))] ** 2).sum()
        return value.sum(axis=-1) * (y[1] - y[0]) / (7.0 * size2 * 3 * np.log(10) * 2)

    share, told = [], []
    for k in range(40):
        at = rng.uniform(-1.5, 1.5)
        load = ss.LineLoad(1.8, 0.1, at) if k % 2 else ss.PointLoad(1.0, 0.1, position=(at, 0.0))
        w = tip.read(load, rng) / noise
        found = tip.locate(noise * w, load="either", search=(-3.5, 3.5))
        line = 0.5 * summed(lines, w)
        on_row = 0.15 * summed(points[0], w)
        # of a drag across, and so of the angle along the row, the same share is left at each distance
        beside = 0.35 * np.mean([summed(fields, w) for fields in points])
        share.append((on_row + beside) / (line + on_row + beside))
        told.append(found.point_probability)
    odds = [np.log(np.clip(p, 1e-4, 1 - 1e-4) / (1 - np.clip(p, 1e-4, 1 - 1e-4))) for p in (share, told)]
    off = odds[1] - odds[0]
    assert np.median(np.abs(off)) < 0.5
    # a position that is in doubt along the distance beside the row makes a point likelier than it is
    assert -0.5 < off.min()
    assert off.max() < 3.0


@pytest.mark.parametrize("beyond", [False, True])
def test_a_touch_on_the_row_counts_what_reads_the_same_beside_it(beyond):
    """Four strains, touches 0.3 to 1 depth beside the row: 6.6 % wrong where points on the row count the row alone."""
    skin, full = ss.HalfSpace(ss.Material(young=1.0)), 3 / (2 * np.pi)
    tip = ss.Finger(skin, ss.SensorArray.line(4, 1.0, 1.0, noise=1e-3 * full))
    rng, count, half = np.random.default_rng(3), 3000, 1.5
    y = half + rng.uniform(0, 0.5, count) if beyond else rng.uniform(-half, half, count)
    at = np.stack([y, rng.uniform(0.3, 1.0, count)], axis=-1)
    touch = ss.PointLoad(1.0, rng.uniform(0, 0.7, count), rng.uniform(-np.pi, np.pi, count), at)
    found = tip.locate(tip.read(touch, rng))
    off = np.abs(found.position - y)
    assert found.ok.mean() > 0.2
    assert (found.ok & ((off > 5 * found.position_std) | (off > 0.3))).mean() < 0.04
    assert (off < 1.959964 * found.position_std)[found.ok].mean() > 0.55
