"""A free drag on an area against what defines it: conditions of a minimum with dense matrices, nnls, and truths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import binary_dilation
from scipy.optimize import nnls

import subskin as ss
from subskin.estimate.pressure import _cones, _elements, _inside, mapping
from subskin.plot import pressure_image_figure
from subskin.transducer import MagnetDisplacement

D, PITCH, FRICTION, NOISE = 2e-3, 1.5e-3, 0.6, 1e-3
SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
MAGNETS = [MagnetDisplacement(axis, moment=7.9e-3, gap=3e-3) for axis in "xyz"]


def dome(y, z, at, a):
    return 5e4 * np.sqrt(np.maximum(1 - ((y - at[0]) ** 2 + (z - at[1]) ** 2) / a**2, 0))


def twist(y, z):
    """Torsion with slip at the rim: the drag turns round, and no direction is common."""
    at, a = (0.4e-3, -0.2e-3), 2.5e-3
    p, dy, dz = dome(y, z, at, a), y - at[0], z - at[1]
    r = np.maximum(np.hypot(dy, dz), 1e-9)
    size = np.minimum(2.5e4 * r / a, FRICTION * p) / r
    return p, np.stack([-dz * size, dy * size], axis=-1)


def slip(y, z):
    """Partial slip: dragged along (0.8, 0.6), at the rim alone."""
    p = dome(y, z, (0.0, 0.0), 2.5e-3)
    return p, FRICTION * (p - 0.7 * dome(y, z, (0.0, 0.0), 0.7 * 2.5e-3))[..., None] * np.array([0.8, 0.6])


def two(y, z):
    """Dragged against each other along z."""
    one, other = dome(y, z, (-2.6e-3, 0.0), 2e-3), dome(y, z, (2.6e-3, 0.0), 2e-3)
    return one + other, 0.5 * (one - other)[..., None] * np.array([0.0, 1.0])


def slide(y, z):
    p = dome(y, z, (0.0, 0.5e-3), 2.5e-3)
    return p, 0.3 * p[..., None] * np.array([0.6, -0.8])


def contact(field) -> tuple[ss.PressureGrid, np.ndarray]:
    """On fine nodes, and N, Ty, Tz and the moment about the centre of pressure."""
    at = np.linspace(-5e-3, 5e-3, 81)
    y, z = np.meshgrid(at, at, indexing="ij")
    p, q = field(y, z)
    y, z = (one - (one * p).sum() / p.sum() for one in (y, z))
    totals = np.array([p.sum(), *q.sum(axis=(0, 1)), (y * q[..., 1] - z * q[..., 0]).sum()]) * (at[1] - at[0]) ** 2
    return ss.PressureGrid(at, at, p, q), totals


class Pressed:
    """A finger with noise in shares of the touch's largest reading, and readings of the touch."""

    def __init__(self, field, side: int = 7, count: int = 1) -> None:
        array = ss.SensorArray.grid((side, side), PITCH, D, channels=MAGNETS)
        self.field, (self.contact, self.totals) = field, contact(field)
        clean = ss.Finger(SKIN, array).read(self.contact)
        sigma = NOISE * np.abs(clean).max()
        self.finger = ss.Finger(SKIN, replace(array, noise=np.full(clean.size, sigma)))
        self.frames = clean + sigma * np.random.default_rng(0).standard_normal((count, clean.size))
        self.mapper = ss.estimate.ImageMapper(self.finger, shear="free", friction=FRICTION)
        self.found = self.mapper(self.frames)

    def dense(self, frame: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Columns (3 m, n), K, b, and p, q_y / mu, q_z / mu found (3, m)."""
        hats = self.mapper._hats(self.finger.array.live)
        columns = np.concatenate([scale * hats.columns(i) for i, scale in enumerate((1.0, FRICTION, FRICTION))])
        found = self.found[frame]
        x = np.stack([found.pressure, *np.moveaxis(found.shear / FRICTION, -1, 0)])[:, 1:-1, 1:-1].reshape(3, -1)
        form = np.kron(np.eye(3), float(found.weight) * self.mapper._surface.prior.form.toarray())
        return columns, form, self.frames[frame] / np.asarray(self.finger.array.noise), x

    def truth(self) -> tuple[np.ndarray, np.ndarray]:
        return self.field(*np.meshgrid(self.found.y, self.found.z, indexing="ij"))


@pytest.fixture(scope="module")
def slipping() -> Pressed:
    return Pressed(slip, side=5)


def test_conditions_of_the_minimum(slipping):
    """x within its cone, the slope within the dual cone, and at right angles: enough for the least of a convex J."""
    columns, form, b, x = slipping.dense(0)
    cost = np.zeros(x.shape)
    cost[0] = 0.3 * np.linalg.norm(columns[: x.shape[1]], axis=1).max()
    slope = (columns @ (columns.T @ x.reshape(-1) - b) + form @ x.reshape(-1)).reshape(3, -1) + cost
    reach = np.abs((columns @ b).reshape(3, -1) - cost).max()
    p, q = x[0], np.hypot(x[1], x[2])
    assert (q <= p * (1 + 1e-9)).all()
    assert (slope[0] - np.hypot(slope[1], slope[2])).min() > -1e-8 * reach
    assert np.abs((x * slope).sum(axis=0)).max() < 1e-8 * reach * p.max()
    rim, inside = (q > p * (1 - 1e-9)) & (p > 0), q < p * (1 - 1e-9)
    assert rim.sum() > 5
    assert inside.sum() > 5
    assert (p == 0).sum() > 100
    assert slipping.found.optimality.max() < 1e-9


def test_no_generators_of_the_cones_have_less(slipping):
    """scipy's nnls on 48 edges of each pressed node's cone: what it finds is as near as edges are, and never less."""
    columns, form, b, x = slipping.dense(0)
    near, m = np.flatnonzero(x[0] > 0), x.shape[1]
    assert near.size > 8
    rows = np.concatenate([near, near + m, near + 2 * m])
    turns = 2 * np.pi / 48 * np.arange(48)
    edges = np.kron(np.stack([np.ones(48), np.cos(turns), np.sin(turns)]), np.eye(near.size))
    g = columns[rows] @ b
    g[: near.size] -= 0.3 * np.linalg.norm(columns[:m], axis=1).max()
    hessian = columns[rows] @ columns[rows].T + form[np.ix_(rows, rows)]
    root = np.linalg.cholesky(hessian)
    other = edges @ nnls(root.T @ edges, np.linalg.solve(root, g), maxiter=20_000)[0]
    mine = x[:, near].reshape(-1)
    value, least = (0.5 * one @ hessian @ one - g @ one for one in (mine, other))
    assert value <= least
    assert least - value < 1e-3 * abs(value)
    np.testing.assert_allclose(mine, other, atol=0.02 * mine.max())


def test_a_twist_comes_back():
    pressed = Pressed(twist)
    found, (_, true) = pressed.found[0], pressed.truth()
    assert found.status == ss.Status.OK
    assert abs(found.moment - pressed.totals[3]) < 4 * found.moment_std < 0.1 * pressed.totals[3]
    assert (np.abs(found.tangential_force - pressed.totals[1:3]) < 4 * found.tangential_std).all()
    assert np.linalg.norm(found.shear - true) < 0.5 * np.linalg.norm(true)
    assert (found.shear * true).sum() > 0.85 * np.linalg.norm(found.shear) * np.linalg.norm(true)
    assert "moment" in repr(found)
    figure = pressure_image_figure(found, truth=pressed.contact)
    left, right = ([c for c in axes.collections if hasattr(c, "U")] for axes in figure.axes[:2])
    for (arrows,) in (left, right):  # round the middle, on both sides
        along, across = arrows.XY[:, 0] - 0.4, arrows.XY[:, 1] + 0.2
        assert np.mean(along * arrows.V - across * arrows.U > 0) > 0.9


@pytest.mark.parametrize("field", [twist, slip, two, slide])
def test_the_band_holds_both_drags_and_the_cone_the_drag(field):
    pressed = Pressed(field)
    found, (pressure, drag) = pressed.found[0], pressed.truth()
    on = pressure > 0
    for mine, std, true in (
        (found.pressure, found.pressure_std, pressure),
        *((found.shear[..., i], found.shear_std[..., i], drag[..., i]) for i in range(2)),
    ):
        assert (np.abs(mine - true) <= 1.96 * std)[on].mean() > 0.93
        assert 3.92 * std[on].mean() < 25 * np.sqrt(((mine - true)[on] ** 2).mean())
        assert (std[~binary_dilation(found.pressure > 0, np.ones((3, 3)))] == 0).all()
    assert (np.hypot(*np.moveaxis(found.shear, -1, 0)) <= FRICTION * found.pressure * (1 + 1e-9)).all()
    assert abs(found.moment - pressed.totals[3]) < 4 * found.moment_std
    if field is two:
        left = found.y < 0
        assert found.shear[left, :, 1].sum() > 0.8 * drag[left, :, 1].sum() > 0
        assert found.shear[~left, :, 1].sum() < 0.8 * drag[~left, :, 1].sum() < 0


def test_band_with_dense_matrices(slipping):
    """Noise and smoothing of all three heights, on the elements that press and those beside them."""
    columns, form, _, x = slipping.dense(0)
    found, m = slipping.found[0], x.shape[1]
    shape = tuple(np.array(found.pressure.shape) - 2)
    near = np.flatnonzero(binary_dilation((x[0] > 0).reshape(shape), np.ones((3, 3))).reshape(-1))
    assert near.size > 8
    rows = np.concatenate([near, near + m, near + 2 * m])
    a, k, p = columns[rows].T, form[np.ix_(rows, rows)], x.reshape(-1)[rows]
    h = np.linalg.inv(a.T @ a + k)
    by_noise, left, loads = h @ a.T @ a @ h, a.T @ a @ h, k @ p
    more = loads**2 - np.diagonal(k @ by_noise @ k)
    each = left.T**2 @ more / (left.T**2 @ (left**2).sum(axis=1))
    expected = np.sqrt(np.diagonal(by_noise) + h**2 @ np.maximum(each, 0.0)).reshape(3, -1)
    parts = (found.pressure_std, *np.moveaxis(found.shear_std / FRICTION, -1, 0))
    for part, mine in zip(expected, parts, strict=True):
        np.testing.assert_allclose(mine[1:-1, 1:-1].reshape(-1)[near], part, rtol=1e-6, equal_nan=False)


def test_standard_deviations_of_the_totals():
    """The spread of 40 readings of a touch, and their mean beside the truth."""
    pressed = Pressed(twist, side=6, count=40)
    found = pressed.found
    mine = np.stack([found.normal_force, *found.tangential_force.T, found.moment], axis=1)
    std = np.stack([found.normal_std, *found.tangential_std.T, found.moment_std], axis=1)
    spread = mine.std(axis=0) / std.mean(axis=0)
    assert (spread > 0.4).all()
    assert (spread < 1.4).all()
    assert (np.abs(mine - pressed.totals) / std).mean() < 1.8


def test_a_batch_is_its_frames_and_room_is_made(slipping, monkeypatch):
    other = Pressed(twist, side=5)
    frames = np.concatenate([slipping.frames, other.frames, 0 * other.frames, -other.frames])
    frames[1, 7] = np.nan
    whole = slipping.mapper(frames)
    names = [ss.Status(s).name for s in whole.status]
    assert names[0] == "OK"
    assert names[2] == "NO_CONTACT"
    assert whole.used.sum(axis=1).tolist() == [75, 74, 75, 75]
    monkeypatch.setattr(mapping, "_ROOM", 4)
    small = ss.estimate.ImageMapper(slipping.finger, shear="free", friction=FRICTION)
    for f, frame in enumerate(frames):
        np.testing.assert_allclose(small(frame).table, whole.table[f], rtol=1e-6, atol=1e-3)


def test_from_the_inside_to_the_same_minimum(slipping):
    """The interior-point method by itself, from a third of the pressures found."""
    ready = slipping.mapper._arrays[0]
    level, (_, _, b, x) = _elements.Level(*ready.fine), slipping.dense(0)
    work, cones = _elements.Work.of(level, b.size, 10_000, 3), _cones.Cones.of(level)
    for j in range(x.shape[1]):
        _cones.settle_in(work, cones, j, x[0, j] / 3, 0.0, 0.0)
    reach = 0.1 * np.abs(np.linalg.norm(level.parts, axis=1).max() * np.linalg.norm(b))
    assert _inside.from_inside(level, float(slipping.found.weight[0]), b, work, cones, reach)
    np.testing.assert_allclose(work.x, x, atol=1e-4 * x.max())


@pytest.mark.parametrize(
    ("kinds", "noise"), [((ss.MeanPressure(),), [30.0]), ((ss.MeanPressure(), ss.NormalStrain()), [30.0, 3e-5])]
)
def test_free_drag_is_refused_where_it_is_not_seen(kinds, noise):
    array = ss.SensorArray.grid((5, 5), PITCH, D, channels=list(kinds), noise=np.tile(noise, 25))
    finger = ss.Finger(SKIN, array)
    with pytest.raises(ss.errors.InvalidValueError, match=r"see 0\.0.*at least 0\.25 .*not three.*three channels"):
        ss.estimate.ImageMapper(finger, shear="free")
    assert ss.estimate.ImageMapper(finger, shear="none").shear_seen < 0.2


@pytest.mark.parametrize("pitch", [PITCH, 1.5 * D])
def test_few_three_axis_sensors_see_a_drag(pitch):
    array = ss.SensorArray.grid((4, 4), pitch, D, channels=MAGNETS, noise=1e-9)
    assert ss.estimate.ImageMapper(ss.Finger(SKIN, array), shear="free").shear_seen > 0.3
