"""A response measured in place, without a model, and loads located by it."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.estimate.area import InPlaceLocator
from subskin.measured import MeasuredResponse, _shape_of

NOISE = 1.0


@pytest.fixture(scope="module")
def finger():
    skin, pitch = ss.HalfSpace(ss.Material(young=0.4e6)), 4e-3
    array = ss.SensorArray.grid(shape=(3, 3), pitch=pitch, depth=4e-3, transducer=ss.MeanPressure(), noise=NOISE)
    return ss.Finger(skin, replace(array, gain=0.02, offset=5.0))


def lattice(step, half=6e-3):
    nodes = np.arange(-half, half + step / 2, step)
    return np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 2)


@pytest.fixture(scope="module")
def known(finger):
    """The table of touches every 1.5 mm under forces that differ and lean, with the forces known."""
    rng = np.random.default_rng(0)
    at = np.repeat(lattice(1.5e-3), 3, axis=0)
    normal = rng.uniform(1.0, 3.0, len(at))
    forces = np.column_stack([normal, normal[:, None] * rng.uniform(-0.4, 0.4, (len(at), 2))])
    readings = finger.read(ss.PointLoad(components=forces, position=at), rng)
    return MeasuredResponse.from_touches(readings, at, components=forces, offset=5.0)


@pytest.fixture(scope="module")
def straight(finger):
    """The table of touches every 1.5 mm of one force, taken as 1."""
    at = lattice(1.5e-3)
    readings = finger.read(ss.PointLoad(2.0, position=at), np.random.default_rng(1))
    return MeasuredResponse.from_touches(readings, at)


def test_the_table_is_the_fingers_response_within_its_doubt(finger, known):
    at = lattice(1e-3, half=4.5e-3) + 0.2e-3
    field, found = finger.receptive_field(at), known(at)
    assert np.abs(found - field)[..., 0].max() < 0.04 * np.abs(field[..., 0]).max()
    assert np.abs(found - field)[..., 1:].max() < 0.05 * np.abs(field[..., 0]).max()
    rows, columns = (np.searchsorted(nodes, c) for nodes, c in ((known.y, at[:, 0]), (known.z, at[:, 1])))
    nodes = np.stack([known.y[rows], known.z[columns]], axis=-1)
    z = (known.values[rows, columns] - finger.receptive_field(nodes)) / np.sqrt(known.variance[rows, columns])
    assert np.sqrt((z**2).mean()) < 1.6
    assert 0.5 * NOISE < known.noise.mean() < 2.5 * NOISE


def test_position_and_all_three_components_are_found(finger, known):
    rng = np.random.default_rng(2)
    at = rng.uniform(-4e-3, 4e-3, (200, 2))
    forces = np.column_stack([np.full(200, 2.0), rng.uniform(-0.6, 0.6, (200, 2))])
    found = InPlaceLocator(known)(finger.read(ss.PointLoad(components=forces, position=at), rng))
    assert found.ok.mean() > 0.95
    error, std = found.position - at, np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))
    assert np.median(np.linalg.norm(error, axis=1)[found.ok]) < 0.1e-3
    both = np.column_stack([error, found.load.components - forces])[found.ok] / std[found.ok]
    assert 0.88 < (np.abs(both) < 1.96).mean() <= 1.0
    np.testing.assert_allclose(np.median(found.load.components[:, 0]), 2.0, rtol=0.02)


def test_a_force_that_is_known_is_not_looked_for(finger, straight):
    at = np.random.default_rng(3).uniform(-4e-3, 4e-3, (100, 2))
    readings = finger.read(ss.PointLoad(2.0, position=at), np.random.default_rng(4))
    found = InPlaceLocator(straight, friction=0, normal_force=(1.0, 1.0))(readings)
    assert found.ok.mean() > 0.95
    np.testing.assert_allclose(found.load.components[found.ok], [[1.0, 0.0, 0.0]] * int(found.ok.sum()))
    assert (found.load.covariance[found.ok][:, 2, 2] == 0).all()
    assert np.nanmedian(np.linalg.norm(found.position - at, axis=1)) < 0.1e-3


def test_channels_that_err_together_are_weighed_together():
    rng = np.random.default_rng(5)
    at = np.repeat(lattice(1.5e-3), 2, axis=0)
    centres = np.array([(-2e-3, 0.0), (2e-3, 0.0), (0.0, 2e-3)])

    def read(where):
        field = 100 / (1 + ((where[:, None] - centres) ** 2).sum(axis=-1) / 9e-6)
        common = rng.normal(0.0, 4.0, len(where))[:, None]  # as of a temperature, or of a device that moves
        return np.column_stack([field + common, rng.normal(0.0, 0.3, len(where)) + common[:, 0]])

    table = MeasuredResponse.from_touches(read(at), at)
    assert table.correlation[0, 3] > 0.5
    where = rng.uniform(-3e-3, 3e-3, (150, 2))
    readings = read(where)
    alone = replace(table, correlation=np.eye(4))
    known = {"friction": 0, "normal_force": (1.0, 1.0)}
    located = [InPlaceLocator(t, **known)(readings).position for t in (table, alone)]
    errors = [np.nanmedian(np.linalg.norm(at - where, axis=1)) for at in located]
    assert errors[0] < 0.7 * errors[1]


def test_errors_go_together_as_repeated_touches_say():
    """Two channels feel one field, and err against each other from touch to touch."""
    rng = np.random.default_rng(6)
    at = np.repeat(lattice(1.5e-3), 4, axis=0)
    field = 100 / (1 + (at**2).sum(axis=-1) / 9e-6)
    tilt = rng.normal(0.0, 3.0, len(at))
    table = MeasuredResponse.from_touches(np.column_stack([field + tilt, field - tilt]), at)
    assert table.correlation[0, 1] < -0.5
    # a table counts the mean of four as one touch, so that the spread left to it is that of a touch about the mean
    np.testing.assert_allclose(table.noise, 3.0, rtol=0.25)


@pytest.mark.parametrize("smooth", [1.5, 2.5])
def test_the_smoothness_of_the_readings_is_found(smooth):
    """Readings drawn from a process of known smoothness, by covariances of another source (Bessel functions)."""
    from scipy.special import gamma, kv

    at, rng = lattice(1e-3), np.random.default_rng(8)
    r = np.sqrt(2 * smooth) * np.linalg.norm(at[:, None] - at, axis=-1) / 6e-3 + 1e-9
    covariance = 2 ** (1 - smooth) / gamma(smooth) * r**smooth * kv(smooth, r)
    readings = np.linalg.cholesky(covariance + 1e-6 * np.eye(len(at))) @ rng.normal(size=(len(at), 6))
    readings += 0.05 * rng.normal(size=readings.shape)
    found, length, ratio = _shape_of(at, np.ones((len(at), 1)), readings, 1e-3)
    assert found == smooth
    np.testing.assert_allclose(length, 6e-3, rtol=0.3)
    assert 0.8e-3 < ratio < 8e-3


def test_a_response_that_changes_by_jumps_of_its_slope_has_nodes_enough():
    """As above the struts of a lattice: its length is long, and its table fine all the same."""
    at = lattice(1.5e-3)
    struts = 3e-3 * np.array([(-1.0, -0.5), (1.2, 0.3), (0.1, 1.3), (-0.4, -1.1)])
    table = MeasuredResponse.from_touches(100 - 1e4 * np.linalg.norm(at[:, None] - struts, axis=-1), at)
    assert table.y[1] - table.y[0] <= 0.75e-3
    np.testing.assert_allclose(table(at)[..., 0], 100 - 1e4 * np.linalg.norm(at[:, None] - struts, axis=-1), atol=3.0)


def test_an_error_in_common_is_told_from_the_field(finger, known):
    """As of the air's pressure: chi-square is that of the whole covariance, positions and their errors hold."""
    rng = np.random.default_rng(7)
    known = replace(known, correlation=None)
    table = replace(known, common=40.0 * NOISE)
    at = rng.uniform(-4e-3, 4e-3, (200, 2))
    readings = finger.read(ss.PointLoad(2.0, position=at), rng) + rng.normal(0.0, 40.0 * NOISE, (200, 1))
    for friction, least in ((0.0, 0.97), (1.0, 0.9)):
        found = InPlaceLocator(table, friction=friction)(readings)
        assert found.ok.mean() > least
        std = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))
        held = (np.abs(found.position - at) < 1.96 * std[:, :2])[found.ok].mean()
        assert 0.88 < held <= 1.0
        without = InPlaceLocator(known, friction=friction)(readings)
        assert without.ok.mean() < 0.5
        # by a response without a doubt chi-square follows in one line
        sure = replace(table, variance=0.0)
        felt = sure(at[:5]) @ [2.0, 0.0, 0.0] + rng.normal(0.0, NOISE, (5, 9)) + rng.normal(0.0, 40.0, (5, 1)) + 5.0
        found = InPlaceLocator(sure, friction=friction)(felt)
        covariance = np.diag(sure.noise**2) + 1600.0 * NOISE**2
        rest = felt - sure.offset - (sure(found.position) @ found.load.components[..., None])[..., 0]
        expected = np.einsum("fi,ij,fj->f", rest, np.linalg.inv(covariance), rest)
        np.testing.assert_allclose(found.residual, expected, rtol=1e-6, equal_nan=False)
        # and so do standard errors, by differences of the response
        ahead, back = (found.position[:, None] + side * 1e-5 * np.eye(2) for side in (1, -1))
        slopes = (sure(ahead) - sure(back)) @ found.load.components[:, None, :, None] / 2e-5
        columns = [slopes[..., 0].swapaxes(1, 2), sure(found.position)[..., : 1 if friction == 0 else 3]]
        jacobian = np.concatenate(columns, axis=-1)
        bound = np.linalg.inv(jacobian.swapaxes(1, 2) @ np.linalg.inv(covariance) @ jacobian)
        np.testing.assert_allclose(
            found.load.covariance[:, :2, :2], bound[:, :2, :2], rtol=2e-2, atol=1e-12, equal_nan=False
        )
    # what all have in common is taken off of the errors of none
    few = InPlaceLocator(replace(table, common=1e6), friction=0)(readings)
    apart = InPlaceLocator(replace(table, common=1e6), friction=0)(readings + 1e3)
    np.testing.assert_allclose(few.position, apart.position, atol=2e-6)


def test_each_frame_has_its_status(finger, known):
    locate = InPlaceLocator(known)
    inside = finger.read(ss.PointLoad(2.0, position=(1e-3, 1e-3)))
    frames = np.stack([inside, np.full(9, 5.0), inside * [5, -5, 5, -5, 5, -5, 5, -5, 5], np.full(9, np.nan)])
    found = locate(frames)
    assert [ss.Status(s).name for s in found.status] == ["OK", "NO_CONTACT", "UNEXPLAINED", "INCOMPLETE"]
    outside = finger.read(ss.PointLoad(2.0, position=(9e-3, 0.0)))
    assert locate(outside).status != ss.Status.OK
    part = inside.copy()
    part[4] = np.nan
    again = locate(part)
    assert again.status == ss.Status.OK
    assert np.linalg.norm(again.position - 1e-3) < 0.2e-3


def test_a_strong_touch_between_the_nodes_of_the_scan_is_found(finger):
    """Where noise is small, the valley about a touch is narrow; far away, where little is known, much is explained."""
    nodes = np.linspace(-10e-3, 10e-3, 41)
    at = np.stack(np.meshgrid(nodes, nodes, indexing="ij"), axis=-1)
    values = finger.receptive_field(at)[..., :1]
    doubt = 1e-3 * np.abs(values).max() * np.sqrt(0.01 + (np.abs(at / 8e-3) ** 4).sum(axis=-1))
    table = MeasuredResponse(nodes, nodes, values, doubt[..., None, None] ** 2 * np.ones_like(values), 5.0, 0.3)
    locate, where = InPlaceLocator(table, friction=0), np.random.default_rng(0).uniform(-4e-3, 4e-3, (200, 2))
    assert locate._stride(values) == 3
    found = locate(finger.read(ss.PointLoad(3.0, position=where)))
    assert found.ok.all()
    assert np.abs(found.position - where).max() < 0.01e-3


def test_it_travels(known):
    again = pickle.loads(pickle.dumps(known))
    np.testing.assert_array_equal(again.values, known.values)
    assert not again.values.flags.writeable


def test_what_cannot_be_is_refused(known, straight):
    at = lattice(1.5e-3)
    with pytest.raises(ss.errors.GeometryError, match="one touch a row"):
        MeasuredResponse.from_touches(np.ones((4, 2)), at)
    with pytest.raises(ss.errors.ConvergenceError, match="same at every position"):
        MeasuredResponse.from_touches(np.ones((len(at), 2)), at)
    with pytest.raises(ss.errors.GeometryError, match="on one line"):
        MeasuredResponse.from_touches(np.arange(40.0).reshape(20, 2), np.linspace(0, 1e-2, 20)[:, None] * [1.0, 0.0])
    far = np.where(np.arange(len(at))[:, None] == 0, [1e6, 0.0], at)
    with pytest.raises(ss.errors.GeometryError, match=r"to 1e\+06 m.* at most 1000 nodes"):
        MeasuredResponse.from_touches(np.arange(2.0 * len(at)).reshape(-1, 2), far)
    with pytest.raises(ss.errors.InvalidValueError, match="knows no drag"):
        InPlaceLocator(straight, friction=1.0)
    with pytest.raises(ss.errors.InvalidValueError, match="straight down"):
        InPlaceLocator(known, normal_force=(1.0, 1.0))
    with pytest.raises(ss.errors.GeometryError, match="array of 3"):
        InPlaceLocator(known, ss.SensorArray.line(3, pitch=1e-3, depth=1e-3, noise=1.0))
    with pytest.raises(ss.errors.GeometryError, match="equal steps"):
        MeasuredResponse([0, 1, 3], known.z, known.values, known.variance, known.offset, known.noise)


def test_a_position_whose_standard_error_is_too_large_is_ambiguous(finger, straight):
    at = lattice(1.1e-3, half=5.5e-3)
    readings = finger.read(ss.PointLoad(2.0, position=at), np.random.default_rng(5))
    before = InPlaceLocator(straight, friction=0)(readings)
    largest = np.sqrt(np.linalg.eigvalsh(np.nan_to_num(before.load.covariance[:, :2, :2]))[:, 1])
    limit = float(np.median(largest[before.ok]))
    found = InPlaceLocator(replace(straight, vague=limit), friction=0)(readings)
    assert (found.ok == (before.ok & (largest < limit))).all()
    assert 0 < found.ok.sum() < before.ok.sum()
    assert (found.status[before.ok & ~found.ok] == ss.Status.AMBIGUOUS).all()
    np.testing.assert_array_equal(found.position, before.position)  # it is told all the same
