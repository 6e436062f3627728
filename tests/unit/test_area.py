"""Touches on an area: tables of a response, the cone of friction, and `locate` beside least squares and its bound."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.estimate.area import observable
from subskin.estimate.area.point import ROWS, Point, PointModel, point_field, read
from subskin.estimate.cone import eliminate_three, on_cone
from subskin.radial import tabulate_radial
from subskin.transducer import Displacement, LateralStrain, ShearStrain

D = 2e-3  # m
SKIN = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
FULL = 3 / (2 * np.pi) / (0.4e6 * D**2)  # strain beneath 1 N


def finger_of(shape, transducer=None, noise=1e-3 * FULL, **options):
    array = ss.SensorArray.grid(shape, D, D, transducer=transducer, noise=noise, **options)
    return ss.Finger(SKIN, array)


@pytest.fixture(scope="module")
def finger():
    return finger_of((4, 4))


@pytest.fixture(scope="module")
def touches():
    rng = np.random.default_rng(0)
    at = rng.uniform(-1.5 * D, 1.5 * D, (600, 2))
    angle, azimuth = rng.uniform(0, 0.7, 600), rng.uniform(-np.pi, np.pi, 600)
    return ss.PointLoad(force=rng.uniform(0.5, 2.0, 600), angle=angle, azimuth=azimuth, position=at)


@pytest.fixture(scope="module")
def found(finger, touches):
    return finger.locate(finger.read(touches, np.random.default_rng(1)))


@pytest.mark.parametrize(
    ("transducer", "functions"),
    [(ss.NormalStrain(), 2), (LateralStrain(0.4), 10), (ShearStrain("xz"), 5), (Displacement("y"), 5)],
    ids=["normal strain", "lateral strain", "shear strain", "displacement"],
)
def test_tables_are_the_forward_model(transducer, functions):
    skin = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.3))
    array = ss.SensorArray.grid((2, 2), D, [D, D, D, 1.3 * D], transducer=transducer, gain=[1.0, 2.0, -1.0, 1.0])
    finger = ss.Finger(skin, array)
    table = tabulate_radial(finger, 10 * D)
    at = np.random.default_rng(2).uniform(-4 * D, 4 * D, (60, 2))
    truth = finger.receptive_field(at)
    assert np.abs(table(at) - truth).max() < 2e-9 * np.abs(truth).max()
    assert table.coefficients.shape[2] <= functions
    assert (table.pair is not None) == (functions == 2)
    assert np.isnan(table([(np.nan, 0.0), (0.0, np.inf)])).all()


@pytest.mark.parametrize(
    ("transducer", "by_series"),
    [(ss.NormalStrain(), False), (ss.NormalStrain(), True), (LateralStrain(0.4), False)],
    ids=["pair", "series", "harmonics"],
)
def test_compiled_columns_and_slopes_are_those_of_the_table(transducer, by_series):
    table = tabulate_radial(finger_of((3, 3), transducer), 10 * D)
    cubics, error = table.cubics()
    if by_series:
        series, error = table.series()
        cubics = series[None, None]
    assert error < (1e-8 if by_series else 1e-7)
    sensors = np.stack([*table.points.T, table.depth**-2.0, table.gain])
    cells, terms = cubics.shape[1], table.terms if table.pair is None else table.terms[:0]
    if table.pair is not None:
        cubics = np.stack([sign * cubics[:, :, k] for k, sign in table.pair], axis=2)
    first, a = np.append(table.kind * cells, cells - 1), np.zeros((ROWS, 9))
    h = 1e-4 * D
    for y, z in np.random.default_rng(0).uniform(-4 * D, 4 * D, (20, 2)):
        model = PointModel(sensors, first, cubics.reshape(len(cubics) * cells, -1), terms, a, a.view(np.int64))
        point_field.py_func(model, Point(y, z))
        columns, by_y, by_z = np.array([read.py_func(model, 0, i) for i in range(9)]).T.reshape(3, 3, 9)
        size = np.abs(table(np.zeros(2))).max()
        assert np.abs(columns.T - table((y, z))).max() < 10 * error * size
        for slope, step in ((by_y, (h, 0.0)), (by_z, (0.0, h))):
            ahead, behind = table(np.add((y, z), step)), table(np.subtract((y, z), step))
            assert np.abs(slope.T - (ahead - behind) / (2 * h)).max() < 1e-4 * size / D


@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
def test_normal_readings_in_a_half_space_are_a_series(transducer):
    """Powers of 1 / v from 3/2 on, as Boussinesq's and Cerruti's stresses have them: x^3 / R^5 is x^-2 v^(-5/2)."""
    table = tabulate_radial(finger_of((2, 2), transducer), 10 * D)
    series, _ = table.series()
    n, _ = (series[function] * sign for function, sign in table.pair)
    young = SKIN.material.young  # under N alone sigma_x = -3 N x^3 / (2 pi R^5), and the trace -3 N x / (2 pi R^3)
    trace = -3 / (2 * np.pi * D**2)
    both = [-0.5 * trace / young, 1.5 * trace / young, 0.0, 0.0]
    truth = np.array(both if isinstance(transducer, ss.NormalStrain) else [-trace / 3, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(n, truth, rtol=0, atol=1e-7 * np.abs(truth).max(), equal_nan=False)


def test_other_readings_are_not_taken_for_a_series():
    """Strain along the surface where the skin gives in volume has 1 / (R (R + x)); sensors of two depths two tables."""
    skin = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.3))
    array = ss.SensorArray.grid((2, 2), D, D, transducer=LateralStrain(0.4))
    assert tabulate_radial(ss.Finger(skin, array), 10 * D).series() is None
    two = ss.SensorArray.grid((2, 2), D, [D, D, D, 1.3 * D])
    assert tabulate_radial(ss.Finger(SKIN, two), 10 * D).series() is None


@pytest.mark.parametrize("friction", [0.4, 1.0, 3.0])
def test_the_cone_of_friction_is_kept_from_any_drag(friction):
    """Also from one that points away from the best, from none, and from one that is no number."""
    rng = np.random.default_rng(6)
    turns = np.linspace(-np.pi, np.pi, 20001)
    edge = np.stack([np.ones_like(turns), friction * np.cos(turns), friction * np.sin(turns)], -1)
    met = 0
    for _ in range(40):
        a = rng.standard_normal((7, 3)) * [1.0, 0.1, 0.5]  # weak drags along y: the cone has a second top
        w = a @ [1.0, *(3 * friction * rng.standard_normal(2))] + rng.standard_normal(7)
        g, b = a.T @ a, a.T @ w
        theta = np.linalg.solve(g, b)
        if theta[0] >= 0 and np.hypot(*theta[1:]) <= friction * theta[0]:
            continue  # not on the cone
        best = (np.maximum(edge @ b, 0) ** 2 / np.einsum("ki,ij,kj->k", edge, g, edge)).max()
        for drag in (theta[1:], -theta[1:], rng.standard_normal(2), (0.0, 0.0), (np.nan, 1.0)):
            height = on_cone(tuple(g[np.triu_indices(3)]), tuple(b), friction, *map(float, drag), True)[3]
            assert height == pytest.approx(best, rel=1e-6, abs=1e-12)
            assert height >= best * (1 - 1e-12)
        met += 1
    assert met > 20


@pytest.mark.parametrize("friction", [0.4, 1.0])
def test_the_cone_of_friction_is_kept_exactly(friction):
    rng = np.random.default_rng(3)
    directions = rng.uniform(-np.pi, np.pi, 4000)
    steep = friction * np.sqrt(rng.uniform(0, 1, 4000))
    steep[:2000] = friction
    rays = np.stack([np.ones(4000), steep * np.cos(directions), steep * np.sin(directions)], -1)
    inside = 0
    for _ in range(60):
        a = rng.standard_normal((7, 3))
        w = a @ [2.0, *(friction * rng.standard_normal(2))] + rng.standard_normal(7)
        g, b = a.T @ a, a.T @ w
        *theta, height, free = np.array(eliminate_three(*g[np.triu_indices(3)], *b, friction))[[0, 1, 2, 3, -1]]
        assert theta[0] >= 0
        assert np.hypot(*theta[1:]) <= friction * theta[0] * (1 + 1e-9) + 1e-12
        assert height == pytest.approx(w @ w - ((w - a @ theta) ** 2).sum(), abs=1e-9)
        along = np.maximum(rays @ b, 0)
        best = (along**2 / np.einsum("ki,ij,kj->k", rays, g, rays)).max()
        assert height >= best * (1 - 1e-12)  # no load of the cone does better,
        assert height <= best * 1.02 + 1e-2  # and none much worse
        inside += free == 1
    assert 3 < inside < 57  # both cases were met


def test_no_worse_than_least_squares_from_the_truth(finger, touches, found):
    frames = finger.read(touches, np.random.default_rng(1))
    noise = np.asarray(finger.array.noise)
    units = np.array([D, D, 1.0, 1.0, 1.0])
    for i in range(12):
        start = np.concatenate([touches.position[i], touches.components[i]]) / units

        def left(p, frame=frames[i]):
            p = p * units
            return (finger.receptive_field(p[:2]) @ p[2:] - frame) / noise

        peer = least_squares(left, start, method="lm", xtol=1e-13, ftol=1e-13)
        assert found.residual[i] < 2 * peer.cost + 1e-3
        here = np.concatenate([found.position[i], found.load.components[i]]) / units
        spread = np.sqrt(np.diagonal(found.load.covariance[i])) / units
        assert (np.abs(here - peer.x) < 0.02 * spread).all()
        covariance = found.load.covariance[i] / np.outer(units, units)
        ratio = np.linalg.eigvals(covariance @ (peer.jac.T @ peer.jac)).real  # of variances, in any direction
        assert np.abs(ratio - 1).max() < 0.03


def test_errors_are_those_of_the_bound(touches, found):
    assert found.ok.mean() > 0.99
    ok = found.ok
    truth = np.concatenate([touches.position, touches.components], -1)
    error = (np.concatenate([found.position, found.load.components], -1) - truth)[ok]
    spread = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))[ok]
    assert np.abs((error**2 / spread**2).mean(0) - 1).max() < 0.15  # 600 frames: 0.06 is one standard deviation
    assert np.abs((np.abs(error) < 1.96 * spread).mean(0) - 0.95).max() < 0.03
    assert found.residual.mean() == pytest.approx(11, rel=0.08)


def misses(shape, noise, count):
    """Errors over standard deviations and in depths, and status, of touches over sensors 0.75 depths apart."""
    array = ss.SensorArray.grid(shape, 0.75 * D, D, noise=noise * FULL)
    finger, rng, half = ss.Finger(SKIN, array), np.random.default_rng(6), 0.375 * D * (np.array(shape) - 1)
    at, lean = rng.uniform(-half, half, (count, 2)), rng.uniform(0, 0.7, count)
    touch = ss.PointLoad(force=np.ones(count), angle=lean, azimuth=rng.uniform(-np.pi, np.pi, count), position=at)
    seen = finger.locate(finger.read(touch, rng), search=tuple((-h - D / 2, h + D / 2) for h in half))
    error = np.concatenate([seen.position - at, seen.load.components - touch.components], -1)
    return error / np.sqrt(np.diagonal(seen.load.covariance, axis1=1, axis2=2)), np.abs(error[:, :2]) / D, seen.ok


def test_intervals_hold_where_readings_bend_within_the_noise():
    error, _, ok = misses((4, 4), 1e-2, 6000)
    assert ok.mean() > 0.92
    inside = (np.abs(error[ok]) < 1.96).mean(0)
    assert inside.min() > 0.935  # 0.92 by the curvature at the top alone
    assert inside.max() < 0.97


def test_two_tops_near_each_other_are_both_seen():
    error, away, ok = misses((3, 3), 1e-3, 4000)
    wrong = ((np.abs(error[:, :2]) > 6) & (away > 0.1)).any(-1)
    assert ok.mean() > 0.9
    assert (wrong & ok).sum() <= 1  # 40 where the best node of the scan alone is climbed from
    assert (np.abs(error[ok]) < 1.96).mean() > 0.93


def test_many_sensors_also_see_both_tops_where_loads_near_each_other_read_alike():
    skin, noise = ss.HalfSpace(ss.Material(young=1.0, poisson=0.3)), 4e-3 * 0.4966
    tip = ss.Finger(skin, ss.SensorArray.grid((4, 4), 0.85, 1.0, noise=noise))
    rng = np.random.default_rng(1)
    angle, azimuth = rng.uniform(0, 0.7, 3000), rng.uniform(-np.pi, np.pi, 3000)
    touch = ss.PointLoad(np.ones(3000), angle, azimuth, rng.uniform(-1.27, 1.27, (3000, 2)))
    seen = tip.locate(tip.read(touch, rng))
    away, spread = np.abs(seen.position - touch.position), np.sqrt(np.diagonal(seen.covariance, axis1=1, axis2=2))
    wrong = ((away > 6 * spread[:, :2]) & (away > 0.1)).any(-1)
    assert seen.ok.mean() > 0.9
    assert (wrong & seen.ok).sum() <= 1  # 11 where only the best nodes of the scan are climbed from


def test_six_sensors_do_not_take_the_first_load_that_explains_them():
    tip = finger_of((2, 3), ss.MeanPressure(), 1e-3 / (2 * np.pi * D**2))
    rng = np.random.default_rng(14)
    angle, azimuth, across = rng.uniform(0, 0.7, 6000), rng.uniform(-np.pi, np.pi, 6000), rng.uniform(-1, 1, 6000)
    touch = ss.PointLoad(np.ones(6000), angle, azimuth, D * np.stack([0.5 * rng.uniform(-1, 1, 6000), across], -1))
    seen = tip.locate(tip.read(touch, rng))
    assert seen.ok.mean() > 0.9
    away = np.abs(seen.position - touch.position).max(axis=-1)
    assert (away[seen.ok] > D / 3).sum() <= 2  # 18 where the coarse scan is enough


def test_fields_of_an_answer(found):
    assert found.position.shape == (600, 2)
    assert found.load.components.shape == (600, 3)
    assert found.load.covariance.shape == (600, 5, 5)
    assert found.std.shape == (600, 5)
    assert found.second.position.shape == (600, 2)
    assert found.angle.min() >= 0
    assert "position z" in repr(found[0])
    assert {"position_y", "azimuth_std"} <= set(found[0].to_dict())


def test_what_no_touch_explains(finger):
    touch = ss.PointLoad(force=1.0, angle=0.4, azimuth=1.0, position=(0.4 * D, 0.2 * D))
    frame = finger.read(touch)
    two = frame + finger.read(ss.PointLoad(force=1.0, position=(-1.4 * D, -1.2 * D)))
    steep = finger.read(ss.PointLoad(components=(0.3, 1.0, 0.0), position=(0.0, 0.3 * D)))
    nonsense = FULL * np.random.default_rng(0).standard_normal(16)
    quiet = 1e-3 * FULL * np.random.default_rng(1).standard_normal(16)
    status = finger.locate([-frame, two, steep, nonsense, quiet]).status
    wanted = ["UNEXPLAINED"] * 4 + ["NO_CONTACT"]
    assert [ss.Status(s).name for s in status] == wanted


def test_missing_sensors(finger):
    touch = ss.PointLoad(force=1.0, angle=0.4, azimuth=1.0, position=(0.4 * D, 0.2 * D))
    frame = np.array(finger.read(touch))
    frame[5] = np.nan
    found = finger.locate(frame)
    assert found.ok
    assert not found.used[5]
    assert np.allclose(found.position, touch.position, atol=1e-6)
    frame[:12] = np.nan
    assert finger.locate(frame).status == ss.Status.INCOMPLETE


def test_ends_of_the_search(finger):
    search = ((-2 * D, 2 * D), (-2 * D, 2 * D))
    at = [(2.0 * D, 0.0), (2.5 * D, 0.0), (0.3 * D, -1.999 * D), (1.2 * D, 0.4 * D)]
    frames = finger.read(ss.PointLoad(force=np.ones(4), position=at))
    status = finger.locate(frames, search=search).status
    assert status[0] == status[2] == ss.Status.AMBIGUOUS
    assert status[1] != ss.Status.OK
    assert status[3] == ss.Status.OK


def test_a_touch_beyond_the_default_search_is_never_ok_and_elsewhere(finger):
    rng = np.random.default_rng(5)
    away = rng.choice([-1.0, 1.0], 400) * rng.uniform(3.1, 7.0, 400) * D
    at = np.stack([away, rng.uniform(-7, 7, 400) * D], -1)
    at[200:] = at[200:, ::-1]  # beyond each of the four sides
    touch = ss.PointLoad(force=np.full(400, 5.0), angle=0.3, azimuth=0.5, position=at)
    found = finger.locate(finger.read(touch, rng))
    assert (found.status != ss.Status.OK).all()


def test_shear_strains_locate_as_well():
    finger = finger_of((3, 3), channels=(ShearStrain("xy"), ShearStrain("xz")))
    touch = ss.PointLoad(force=1.0, angle=0.4, azimuth=1.0, position=(0.4 * D, 0.2 * D))
    found = finger.locate(finger.read(touch, np.random.default_rng(0)))
    assert found.ok
    truth = np.concatenate([touch.position, touch.components])
    error = np.concatenate([found.position, found.load.components]) - truth
    assert (np.abs(error) < 4 * np.sqrt(np.diagonal(found.load.covariance))).all()


@pytest.mark.parametrize("kind", [ss.NormalStrain(), ss.MeanPressure()])
def test_a_straight_row_tells_four_of_five(kind):
    y = np.arange(6) * D
    row = ss.Finger(SKIN, ss.SensorArray(y=y, z=0.5 * y + 1e-3, depth=D, transducer=kind, noise=1e-4))
    told = observable(row, position=(2.2 * D, 2.0 * D))
    assert told.rank == 4
    with pytest.raises(GeometryError, match="straight line"):
        row.locate(np.zeros(6))


def test_what_a_row_cannot_tell_above_itself():
    row = ss.Finger(SKIN, ss.SensorArray(y=np.arange(6) * D, z=1e-9, depth=D, noise=1e-4))
    told = observable(row, position=(2.2 * D, 0.5 * D))
    # N depth - Tz z0 is seen, so a change of N depth = Tz z0 is not (FORMULAS: four of five, docs/locating_area.md)
    assert told.rank == 4
    change = told.blind[0] / told.blind[0][4]
    assert change[:2] == pytest.approx([0, 0], abs=1e-6)
    assert change[2] == pytest.approx(0.5 - 1e-9 / D, rel=1e-8)  # the row stands 1 nm beside z = 0
    assert not np.isfinite(told.std[[2, 4]]).any()
    assert "Tz" in repr(told)


def test_options_that_belong_to_a_row(finger):
    with pytest.raises(InvalidValueError, match="half_width"):
        finger.locator(half_width=(0.0, 1e-3))
    with pytest.raises(InvalidValueError, match="search"):
        finger.locate(np.zeros(16), search=(-1e-3, 1e-3))
    with pytest.raises(InvalidValueError, match="point"):
        finger.fit(np.zeros(16), "hertz")


def test_y_and_z_are_treated_alike():
    """Mirrored touches on a square grid: the same answers with y and z exchanged, widened intervals among them."""
    array = ss.SensorArray.grid((4, 4), 1.0, 1.0, noise=1e-2 * 3 / (2 * np.pi))
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)
    rng = np.random.default_rng(6)
    at, angle, azimuth = rng.uniform(-1.5, 1.5, (400, 2)), rng.uniform(0, 0.7, 400), rng.uniform(-np.pi, np.pi, 400)
    frames = tip.read(ss.PointLoad(force=1.0, angle=angle, azimuth=azimuth, position=at), rng)
    one, other = tip.locate(frames), tip.locate(frames.reshape(-1, 4, 4).swapaxes(1, 2).reshape(-1, 16))
    np.testing.assert_array_equal(one.status, other.status)
    mirrored = np.array([1, 0, 2, 4, 3])
    seen, swapped = one.load.covariance[one.ok], other.load.covariance[one.ok][:, mirrored][:, :, mirrored]
    np.testing.assert_allclose(
        np.diagonal(seen, axis1=1, axis2=2), np.diagonal(swapped, axis1=1, axis2=2), rtol=0.02, equal_nan=False
    )
