"""Blind calibration on an area: derivatives, elimination, what cannot be known, the truth found, what is refused."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.calibration._blind_model import BlindModel, UnknownTouch, Whitened
from subskin.calibration._blind_rounds import _Step
from subskin.calibration._learning import Learning, _effects

SOFT = ss.Material(0.4e6, 0.45)
SKINS = {"half space": ss.HalfSpace(SOFT), "layer": ss.Layered(ss.Layer(SOFT, 6e-3))}
SCALE, SHIFT, TURN = "common scale of the gains", "common shift", "common turn"
LENGTH = "common scale of depths"
ERRORS = {"gain": 0.05, "offset": 5.0, "poisson": 0.02} | dict.fromkeys(("depth", "depths", "thickness"), 1e-4)
ERRORS["position"] = 6e-5


def drawn(skin="half space", shape=(3, 3), **array):
    array = {"pitch": 3e-3, "depth": 3e-3, "transducer": ss.MeanPressure(), "noise": 20.0} | array
    return ss.Finger(SKINS[skin], ss.SensorArray.grid(shape=shape, **array))


def made(finger, seed=0):
    """A real finger, as far from the drawing as `calibrate_blind` takes it to be."""
    rng, a = np.random.default_rng(seed), finger.array
    n, d = len(a), float(np.mean(a.depth))
    y, z = (np.asarray(v) + 0.02 * d * rng.standard_normal(n) for v in (a.y, a.z))
    gain, depth = np.asarray(a.gain) * np.exp(0.05 * rng.standard_normal(n)), d * (1 + 0.05 * rng.standard_normal())
    return replace(finger, array=replace(a, gain=gain, depth=depth, y=y, z=z))


def loads(finger, count, seed=1, lean=0.6, half_width=0.0):
    rng, points = np.random.default_rng(seed), finger.array.points
    at = rng.uniform(points.min(axis=0), points.max(axis=0), (count, 2))
    force, angle, azimuth = (rng.uniform(*ends, count) for ends in ((0.5, 2), (0, lean), (-np.pi, np.pi)))
    load = {"force": force, "angle": angle, "azimuth": azimuth, "position": at}
    return ss.RoundHertz(**load, half_width=half_width) if half_width else ss.PointLoad(**load)


def linearised(finger, names, touch, kind, x=None):
    """The model near readings of `touch` without noise, and its derivatives there."""
    model = BlindModel(finger, names, ERRORS, kind)
    x = np.zeros(model.size) if x is None else x
    readings = (model.finger(x).read(touch) - np.asarray(finger.array.offset)) / np.asarray(finger.array.noise)
    return model, model.linearise(Whitened(readings, np.ones_like(readings, bool)), x, np.asarray(touch.position))


def off(found, real):
    """What was found less the truth, by parameter."""
    a = real.array
    true = [float(np.asarray(getattr(a, p.name))[p.sensor or 0]) for p in found.parameters]
    return np.array([p.value for p in found.parameters]) - true


@pytest.mark.parametrize(("skin", "half_width"), [("half space", 0.0), ("layer", 0.0), ("half space", 1.2e-3)])
def test_derivatives(skin, half_width):
    """Against differences of `Finger.read`, which knows nothing of x."""
    tip = drawn(skin, (2, 3), transducer=ss.NormalStrain(), noise=1e-4)
    tip = replace(tip, array=replace(tip.array, gain=[1, -2, 0.5, 1, 1, 1], width=[0, 0, 0, 0, 0, 1e-3]))
    names = ["gain", "offset", "depth", "position", "poisson"] + ["thickness"] * (skin == "layer")
    x = np.random.default_rng(0).standard_normal(26 + (skin == "layer"))
    touch = loads(tip, 2, half_width=half_width)
    model, near = linearised(tip, names, touch, UnknownTouch(2, 1.0, half_width), x)
    assert model.size == x.size
    assert np.abs(near.rest).max() < 1e-6
    np.testing.assert_allclose(near.force, np.asarray(touch.components), rtol=1e-6, atol=1e-9, equal_nan=False)

    def slopes(high, low, width):
        return (high - low) / width / 1e-4

    for i, step in enumerate(1e-3 * np.eye(x.size)):
        slope = slopes(model.finger(x + step).read(touch), model.finger(x - step).read(touch), 2e-3)
        np.testing.assert_allclose(near.by_finger[..., i], slope, atol=3e-5 * np.abs(slope).max(), rtol=0)
    at, wide = np.asarray(touch.position), {"half_width": half_width} if half_width else {}
    for axis, step in enumerate(1e-6 * np.eye(2)):
        ends = (type(touch)(components=touch.components, position=at + s, **wide) for s in (step, -step))
        slope = slopes(*(model.finger(x).read(end) for end in ends), 2e-6)
        np.testing.assert_allclose(near.by_position[..., axis], slope, atol=3e-6 * np.abs(slope).max(), rtol=0)


def whole(near):
    """Derivatives by the finger, then all positions and forces, as one matrix; readings row by row."""
    m, n, p = near.by_finger.shape
    own = np.concatenate([near.by_position, near.by_force], axis=-1)
    blocks = np.zeros((m, n, m, own.shape[2]))
    blocks[np.arange(m), :, np.arange(m)] = own
    return np.concatenate([near.by_finger.reshape(m * n, p), blocks.reshape(m * n, -1)], axis=1)


@pytest.mark.parametrize("friction", [0.0, 1.0])
def test_elimination_is_that_of_the_whole_system(friction):
    """Information by the Schur complement, and a step by least squares of everything at once."""
    tip, kind = drawn(shape=(3, 3)), UnknownTouch(2, friction)
    touch = loads(tip, 9, lean=0.6 * friction)
    model = BlindModel(tip, ("gain", "depth", "position"), ERRORS, kind)
    x, noise = np.zeros(model.size), np.random.default_rng(0).standard_normal((9, 9))
    data = Whitened(made(tip).read(touch) / 20.0 + noise, np.ones((9, 9), bool))
    near = model.linearise(data, x, np.asarray(touch.position))
    everything, p = whole(near), model.size
    size = np.linalg.norm(everything, axis=0)
    fisher = (everything / size).T @ (everything / size)
    a, b, c = fisher[:p, :p], fisher[:p, p:], fisher[p:, p:]
    schur = (a - b @ np.linalg.solve(c, b.T)) * np.outer(size[:p], size[:p])
    np.testing.assert_allclose(near.information(), schur, atol=1e-8 * np.abs(schur).max())
    x = np.linspace(-0.5, 0.5, p)
    by_finger, by_position, _ = _Step(near, x, 0.7).solve(0.0)
    prior = np.concatenate([np.eye(p), np.zeros((p, everything.shape[1] - p))], axis=1)
    system = np.concatenate([np.sqrt(0.7) * everything, prior]) / size
    wanted = np.linalg.lstsq(system, np.append(np.sqrt(0.7) * near.rest.ravel(), -x))[0] / size
    np.testing.assert_allclose(by_finger, wanted[:p], atol=1e-7)
    each = wanted[p:].reshape(9, -1)[:, :2]
    np.testing.assert_allclose(by_position, each, atol=1e-7 * np.abs(each).max())


class TestWhatCannotBeKnown:
    @pytest.mark.parametrize(
        ("skin", "fit", "friction", "half_width", "said", "lost"),
        [
            ("half space", ("gain", "depth", "position"), 1.0, 0.0, (SCALE, SHIFT, TURN, LENGTH), 5),
            ("half space", ("gain", "depths", "position"), 0.3, 0.0, (SCALE, SHIFT, TURN, LENGTH), 5),
            ("half space", ("gain", "depth", "position"), 0.0, 0.0, (SCALE, SHIFT, TURN, LENGTH), 5),
            ("half space", ("gain", "depth", "position"), 1.0, 1e-3, (SCALE, SHIFT, TURN), 4),
            ("layer", ("gain", "depth", "position"), 1.0, 0.0, (SCALE, SHIFT, TURN), 4),
            ("layer", ("gain", "depth", "position", "thickness"), 1.0, 0.0, (SCALE, SHIFT, TURN, LENGTH), 5),
            ("half space", ("gain", "depth"), 1.0, 0.0, (SCALE,), 1),
            ("half space", ("depth",), 1.0, 0.0, (), 0),
        ],
    )
    def test_named_directions(self, skin, fit, friction, half_width, said, lost):
        tip = made(drawn(skin), 3)
        touch = loads(tip, 12, lean=0.6 * (friction > 0), half_width=half_width)
        model, near = linearised(tip, fit, touch, UnknownTouch(2, friction, half_width))
        learning = Learning(model, np.zeros(model.size), near, 1.0)
        told = learning.unknown([str(i) for i in range(model.size)])
        assert learning.null.shape[1] == lost
        assert len(told) == len(said)
        assert all(part in text for text, part in zip(told, said, strict=True))

    def test_a_sensor_of_some_width_along_y_tells_the_turn(self):
        tip = drawn(width=1.5e-3)
        model, near = linearised(tip, ("gain", "position"), loads(tip, 12), UnknownTouch(2, 1.0))
        learning = Learning(model, np.zeros(model.size), near, 1.0)
        assert [SCALE in t or SHIFT in t for t in learning.unknown([str(i) for i in range(model.size)])] == [True] * 2

    def test_pressures_of_straight_loads_hide_every_moebius_map(self):
        """x / r^3 keeps its form under maps of the half space onto itself, a sensor's gain going as its depth's root.

        Their two special directions have no name: 2 (b.r) r - b r^2 of sensors at r = (depth, y, z), b along y or z.
        """
        tip = made(drawn(), 2)
        model, near = linearised(tip, ("gain", "depths", "position"), loads(tip, 20, lean=0.0), UnknownTouch(2, 0.0))
        learning = Learning(model, np.zeros(model.size), near, 1.0)
        assert learning.null.shape[1] == 7
        told = learning.unknown([str(i) for i in range(model.size)])
        assert [text.startswith("a change of ") for text in told] == [False] * 4 + [True] * 2
        y, z, depth = (np.asarray(v) for v in (tip.array.y, tip.array.z, tip.array.depth))
        moved = np.stack([2 * y * depth, y**2 - z**2 - depth**2, 2 * y * z])  # b along y
        # a reading x / r^3 is multiplied by (x' / x)^(-1/2) and a factor of the touch, which its force takes up
        special = np.concatenate([0.5 * 2 * y / 0.05, moved[0] / 1e-4, (moved[1:] / 6e-5).T.ravel()])
        inside = learning.null @ (learning.null.T @ special)
        assert np.linalg.norm(special - inside) < 1e-4 * np.linalg.norm(special)


def test_variances_of_touches_are_those_of_the_locator():
    """Positions and tilts of the force: two routes to the same bound."""
    tip = drawn()
    touch = loads(tip, 10)
    found = tip.locate(tip.read(touch))
    assert (found.status == ss.Status.OK).all()
    _, near = linearised(tip, ("gain",), touch, UnknownTouch(2, 1.0))
    (_, position), (_, tilt) = _effects(near, 1.0)
    covariance, force = found.load.covariance, np.asarray(touch.components)
    by_position = np.diagonal(covariance, axis1=1, axis2=2)[:, :2]
    np.testing.assert_allclose(position.reshape(10, 2), by_position, rtol=1e-2, equal_nan=False)
    square = (force**2).sum(axis=1)
    across = np.eye(3) - force[:, :, None] * force[:, None] / square[:, None, None]
    by_tilt = np.einsum("mij,mji->m", across, covariance[:, 2:, 2:]) / square
    np.testing.assert_allclose(tilt.reshape(10, 2).sum(axis=1), by_tilt, rtol=1e-2, equal_nan=False)


class TestTruth:
    def test_lies_within_the_stated_errors(self):
        """Mahalanobis distances of fingers drawn from the prior are chi-square; `make long` has more of them."""
        tip, squares = drawn(), []
        for seed in range(2):
            real = made(tip, seed)
            found = ss.calibrate_blind(tip, real.read(loads(tip, 40, seed), np.random.default_rng(seed)))
            error = off(found, real)
            squares.append(error @ np.linalg.solve(found.covariance, error))
            assert found.used.mean() > 0.9
        assert found.misfit == 1.0
        assert found.touches.position.shape == (40, 2)
        assert 28 - 5 == found.rank
        assert "moment of a touch" in found.unknown[-1]
        assert found._learning.spare == 9 - 5
        (z,) = (p.value for p in found.parameters if p.called == "z of sensor 4")
        assert found.finger.array.z[4] == z != 0
        assert abs(np.mean(squares) - 28) < 4 * np.sqrt(2 * 28 / 2)
        ratio = np.asarray(found.finger.array.gain) / np.asarray(real.array.gain)
        assert np.ptp(np.log(ratio)) < 0.03 < 0.1 < np.ptp(np.log(np.asarray(real.array.gain)))
        now, more = found.error_ratio(), found.error_ratio(400 * found.used.sum())
        assert 1 < more.angle < now.angle < 1.5
        assert 1 < more.position < now.position < 1.5

    def test_round_touches_of_a_known_half_width(self):
        tip = drawn(shape=(2, 3))
        real = replace(tip, array=replace(tip.array, gain=made(tip, 5).array.gain))
        readings = real.read(loads(tip, 30, lean=0.0, half_width=1.2e-3), np.random.default_rng(0))
        near = ((-2e-3, 2e-3), (-3.5e-3, 3.5e-3))
        found = ss.calibrate_blind(tip, readings, fit="gain", half_width=1.2e-3, friction=0, search=near)
        error = off(found, real)
        assert error @ np.linalg.solve(found.covariance, error) < 2 * error.size
        assert found.misfit < 1.3
        assert (found.touches.half_width[found.used] == 1.2e-3).all()

    def test_a_dead_sensor_a_missing_reading_and_nonsense(self):
        tip = drawn(shape=(2, 4))
        real = made(tip, 4)
        real = replace(real, array=replace(real.array, gain=np.where(np.arange(8) == 2, 0, real.array.gain)))
        rng = np.random.default_rng(0)
        readings = real.read(loads(tip, 60, lean=0.0), rng)
        readings[::10, 0] = np.nan
        nonsense = np.concatenate([20.0 * rng.standard_normal((5, 8)), 4e4 * rng.standard_normal((5, 8))])
        nonsense[:, 2] = 20.0 * rng.standard_normal(10)
        found = ss.calibrate_blind(tip, np.concatenate([readings, nonsense]), friction=0)
        assert [h.name for h in found.health] == ["OK", "OK", "DEAD"] + ["OK"] * 5
        assert found.finger.array.gain[2] == 0
        assert found.finger.array.z[2] == tip.array.z[2]
        assert not found.used[60:].any()
        assert found.used[:60].mean() > 0.9
        alive = np.arange(8) != 2
        ratio = np.asarray(found.finger.array.gain)[alive] / np.asarray(real.array.gain)[alive]
        assert np.ptp(np.log(ratio)) < 0.03


class TestRefused:
    def test_too_few(self):
        tip = drawn(shape=(2, 3))
        readings = tip.read(loads(tip, 20), np.random.default_rng(0))
        few = r"6 touches.*6 readings more.*19 numbers.*at least 20 touches"
        with pytest.raises(ss.errors.ConvergenceError, match=few):
            ss.calibrate_blind(tip, readings[:6])
        small = drawn(shape=(2, 2))
        with pytest.raises(ss.errors.ConvergenceError, match=r"4 live sensors, and 5 unknowns.*friction=0"):
            ss.calibrate_blind(small, small.read(loads(small, 20)))

    def test_sensors_on_a_line_and_a_search_of_a_row(self):
        tip = drawn(shape=(3, 3))
        readings = tip.read(loads(tip, 20, lean=0.0))
        row = replace(tip, array=replace(tip.array, gain=np.where(tip.array.points[:, 0] == 0, 1.0, 0.0)))
        with pytest.raises(ss.errors.ConvergenceError, match="3 live sensors"):
            ss.calibrate_blind(row, readings, friction=0)
        line = ss.Finger(tip.skin, ss.SensorArray(1e-3 * np.arange(6), 3e-3, ss.MeanPressure(), noise=20.0, z=1e-3))
        with pytest.raises(ss.errors.GeometryError, match="one straight line"):
            ss.calibrate_blind(line, np.tile(readings[:, :6], (5, 1)))
        with pytest.raises(ss.errors.InvalidValueError, match="ends of y and those of z"):
            ss.calibrate_blind(tip, readings, search=(-1e-3, 1e-3))
        with pytest.raises(ss.errors.InvalidValueError, match="half_width"):
            ss.calibrate_blind(tip, readings, half_width=-1e-3)
