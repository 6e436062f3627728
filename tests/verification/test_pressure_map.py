"""`pressure_map` against what defines it: every number recomputed from dense matrices of independent readings."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar, nnls

import subskin as ss

FULL_SCALE = 3 / (2 * np.pi)  # strain beneath a unit line load at unit depth, E = 1 (memo eq. 8)
RUBBER = ss.Material(young=1.0)
SKINS = {
    "half plane": ss.HalfPlane(RUBBER),
    "compressible": ss.HalfPlane(ss.Material(young=1.0, poisson=0.3)),
    "layer": ss.Layered(ss.Layer(RUBBER, thickness=3.0)),
    "round": ss.Round(RUBBER, radius=8.0, core_radius=4.0),
}
RULES = ("evidence", "discrepancy", "gcv")


def row(skin: ss.Skin | None = None, count=25, pitch=0.25, noise=1e-3, **more) -> ss.Finger:
    array = ss.SensorArray.line(count, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE, **more)
    return ss.Finger(SKINS["half plane"] if skin is None else skin, array)


def both(count=13, pitch=0.5, noise=1e-3) -> ss.Finger:
    """Strain and pressure at each place: two functions of y."""
    y = pitch * (np.arange(count) - (count - 1) / 2)
    kinds = (ss.NormalStrain(),) * count + (ss.MeanPressure(),) * count
    sigma = noise * np.repeat([FULL_SCALE, 1 / np.pi], count)
    array = ss.SensorArray(y=np.r_[y, y], depth=1.0, transducer=kinds, noise=sigma)
    return ss.Finger(SKINS["half plane"], array)


def rollers(count, angle=0.0, half_width=1.0, seed=0) -> ss.Hertz:
    position = np.random.default_rng(seed).uniform(-0.5, 0.5, count)
    return ss.Hertz(force=np.ones(count), angle=angle, position=position, half_width=half_width)


class Dense:
    """The problem written out, with readings of the finger under each hat and none of the mapper's matrices."""

    def __init__(self, finger: ss.Finger, y: np.ndarray, least_force: float = 0.3) -> None:
        self.y, self.h, self.m = y, y[1] - y[0], len(y) - 2
        hats = np.eye(len(y))[1:-1]
        sigma = np.asarray(finger.array.noise)
        pressing = ss.PressureProfile(y, hats)
        dragging = ss.PressureProfile(y, 0 * hats, hats)
        self.p = (finger.measure(pressing) / sigma).T
        self.q = (finger.measure(dragging) / sigma).T
        slopes = np.diff(np.eye(len(y)), axis=0)[:, 1:-1] / np.sqrt(self.h)  # integral of (dp/dy)^2
        self.k = slopes.T @ slopes
        self.cost = least_force * np.linalg.norm(self.p, axis=0).max() * np.ones(self.m)

    def columns(self, t: float) -> np.ndarray:
        return self.p + t * self.q

    def hessian(self, t: float, w: float) -> np.ndarray:
        a = self.columns(t)
        return a.T @ a + w * self.k

    def solve(self, b: np.ndarray, t: float, w: float) -> tuple[np.ndarray, float]:
        """The least of J over p >= 0 by scipy's nnls, and its value."""
        hessian, g = self.hessian(t, w), self.columns(t).T @ b - self.cost
        root = np.linalg.cholesky(hessian)
        x = nnls(root.T, np.linalg.solve(root, g), maxiter=10000)[0]
        return x, 0.5 * x @ hessian @ x - g @ x


@pytest.mark.parametrize("shear", ["none", "proportional"])
@pytest.mark.parametrize("skin", SKINS)
def test_conditions_of_the_minimum_hold_on_every_skin(skin, shear):
    finger = row(SKINS[skin])
    touch = rollers(6, angle=0.4 if shear == "proportional" else 0.0)
    frames = finger.read(touch, np.random.default_rng(1))
    found = ss.pressure_map(finger, frames, shear=shear)
    assert (found.status == ss.Status.OK).all()
    assert found.optimality.max() < 1e-11
    dense = Dense(finger, found.y)
    for f, frame in enumerate(frames / finger.array.noise):
        a = dense.columns(np.tan(found.angle[f]))
        x = found.pressure[f, 1:-1]
        slope = a.T @ (a @ x - frame) + found.weight[f] * (dense.k @ x) + dense.cost
        scale = np.abs(a.T @ frame).max()
        assert np.abs(slope[x > 0]).max() < 1e-7 * scale  # 1e-9 is the accuracy of the finger's table
        assert slope[x == 0].min() > -1e-7 * scale
        assert (x >= 0).all()
        assert found.residual[f] == pytest.approx(((a @ x - frame) ** 2).sum(), rel=1e-4)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("half_width", [0.2, 1.0, 2.5])
def test_the_answer_is_that_of_nnls(rule, half_width):
    finger = row()
    mapper = ss.estimate.PressureMapper(finger, rule=rule, shear="none")
    frames = finger.read(rollers(8, half_width=half_width), np.random.default_rng(2))
    found = mapper(frames)
    a = mapper._hats(finger.array.live).columns(0).T
    dense = Dense(finger, found.y)
    np.testing.assert_allclose(a, dense.p, atol=1e-7 * np.abs(a).max())
    dense.p = a  # the same table, so that the solvers are compared and nothing else
    dense.cost = 0.3 * np.linalg.norm(a, axis=0).max() * np.ones(dense.m)
    for f, frame in enumerate(frames / finger.array.noise):
        x, _ = dense.solve(frame, 0.0, float(found.weight[f]))
        np.testing.assert_allclose(found.pressure[f, 1:-1], x, atol=1e-8 * x.max())


def test_free_shear_is_the_least_over_the_friction_cone():
    finger = both()
    touch = ss.PartialSlip(force=1.0, angle=0.4, position=0.1, half_width=1.0, friction=0.6)
    frame = finger.read(touch, np.random.default_rng(0))
    found = ss.pressure_map(finger, frame, shear="free", friction=0.8)
    p, q, w = found.pressure[1:-1], found.shear[1:-1], float(found.weight)
    assert (np.abs(q) <= 0.8 * p + 1e-12 * p.max()).all()
    dense = Dense(finger, found.y)
    # u + v = p, 0.8 (u - v) = q: the cone is u, v >= 0
    columns = np.hstack([dense.p + 0.8 * dense.q, dense.p - 0.8 * dense.q])
    zero = np.zeros_like(dense.k)
    hessian = columns.T @ columns + 2 * w * np.block([[dense.k, zero], [zero, dense.k]])
    root = np.linalg.cholesky(hessian)
    b = frame / finger.array.noise
    x = nnls(root.T, np.linalg.solve(root, columns.T @ b - np.tile(dense.cost, 2)), maxiter=10000)[0]
    u, v = x[: dense.m], x[dense.m :]
    np.testing.assert_allclose(p, u + v, atol=1e-5 * p.max())
    np.testing.assert_allclose(q, 0.8 * (u - v), atol=1e-5 * p.max())
    assert found.tangential_force == pytest.approx(dense.h * q.sum(), rel=1e-12)
    # its deviations: of the pressure from all nodes, of the forces from those that press
    full = np.linalg.inv(hessian)
    variance = np.diag(full[: dense.m, : dense.m] + full[dense.m :, dense.m :]) + 2 * np.diag(
        full[: dense.m, dense.m :]
    )
    np.testing.assert_allclose(found.pressure_std[1:-1], np.sqrt(variance), rtol=1e-5)
    on = np.r_[p > -1, p > -1] & (x > 0)
    part = np.linalg.inv(hessian[np.ix_(on, on)])
    e = dense.h * 0.8 * np.r_[np.ones(dense.m), -np.ones(dense.m)][on]
    assert found.tangential_std == pytest.approx(np.sqrt(e @ part @ e), rel=1e-4)


@pytest.mark.parametrize("angle", [-0.5, 0.0, 0.3])
def test_the_angle_is_the_one_of_least_misfit(angle):
    finger = row(count=17, pitch=0.35)
    frames = finger.read(rollers(3, angle=angle), np.random.default_rng(3))
    found = ss.pressure_map(finger, frames, shear="proportional")
    dense = Dense(finger, found.y)
    for f, frame in enumerate(frames / finger.array.noise):
        t, w = float(np.tan(found.angle[f])), float(found.weight[f])
        sigma = float(found.angle_std[f]) * (1 + t * t)
        best = minimize_scalar(
            lambda t, b=frame, w=w: dense.solve(b, t, w)[1], bounds=(t - 5 * sigma, t + 5 * sigma), method="bounded",
            options={"xatol": 1e-3 * sigma},
        )  # fmt: skip
        assert abs(best.x - t) < 0.02 * sigma
        wide = [dense.solve(frame, s, w)[1] for s in np.linspace(-1, 1, 41)]
        assert min(wide) > best.fun - 1e-6 * abs(best.fun)  # no better one in the whole cone
        # its deviation is the curvature of the misfit, with these nodes pressing
        on = found.pressure[f, 1:-1] > 0

        def value(t: float, b=frame, w=w, on=on) -> float:
            g = (dense.columns(t).T @ b - dense.cost)[on]
            return -0.5 * g @ np.linalg.solve(dense.hessian(t, w)[np.ix_(on, on)], g)

        h = 0.2 * sigma
        curve = (value(t + h) - 2 * value(t) + value(t - h)) / h**2
        assert sigma == pytest.approx(1 / np.sqrt(curve), rel=1e-3)


def test_the_angle_is_the_best_of_the_cone_for_scattered_contacts():
    """One to three humps on a sparse row, where the misfit bends both ways on the way to its least."""
    rng = np.random.default_rng(5)
    y, angle = np.linspace(-4, 4, 401), rng.uniform(-0.6, 0.6, 20)
    humps = np.zeros((20, 401))
    for row_ in humps:
        for _ in range(rng.integers(1, 4)):
            centre, half = rng.uniform(-2, 2), rng.uniform(0.2, 1.2)
            row_ += rng.uniform(0.2, 1) * np.sqrt(np.maximum(1 - ((y - centre) / half) ** 2, 0))
    humps /= np.trapezoid(humps, y)[:, None]
    finger = row(count=7, pitch=1.0, noise=1e-4)
    frames = finger.read(ss.PressureProfile(y, humps, humps * np.tan(angle)[:, None]), rng)
    found = ss.pressure_map(finger, frames)
    assert np.isfinite(found.angle_std).all()
    dense = Dense(finger, found.y)
    for f, b in enumerate(frames / finger.array.noise):
        w = float(found.weight[f])
        here = dense.solve(b, np.tan(found.angle[f]), w)[1]
        assert here < min(dense.solve(b, t, w)[1] for t in np.linspace(-1, 1, 21)) + 0.01


@pytest.mark.parametrize("rule", RULES)
def test_the_rule_is_met(rule):
    finger = row(noise=3e-3)
    frames = finger.read(rollers(10), np.random.default_rng(4))
    found = ss.pressure_map(finger, frames, rule=rule, shear="none")
    dense = Dense(finger, found.y)
    covariance = np.linalg.inv(dense.k)
    gram = dense.p @ covariance @ dense.p.T
    n = len(finger.array)

    def score(w: float, b: np.ndarray) -> float:
        influence = gram @ np.linalg.inv(gram + w * np.eye(n))
        left = ((b - influence @ b) ** 2).sum()
        if rule == "discrepancy":
            return (left - n) ** 2
        if rule == "gcv":
            return n * left / np.trace(np.eye(n) - influence) ** 2
        whole = np.eye(n) + gram / w  # of the readings, p being Gaussian with the inverse of w K
        return b @ np.linalg.solve(whole, b) + np.linalg.slogdet(whole)[1]

    for w, b in zip(found.weight, frames / finger.array.noise, strict=True):
        here = score(w, b)
        if rule == "discrepancy":
            assert here < (1e-6 * n) ** 2
        else:
            for step in (1e-2, 0.1):
                assert here < score(w * (1 + step), b)
                assert here < score(w / (1 + step), b)


def test_cross_validation_goes_no_further_than_a_quarter_of_the_freedom():
    """From the smooth side in steps of e^(-1/2): to its first minimum, or the first step that leaves less than 1/4."""
    finger, count = row(count=17, pitch=0.35, noise=3e-3), 17
    frames = finger.read(rollers(40), np.random.default_rng(4))
    found = ss.pressure_map(finger, frames, rule="gcv", shear="none")
    dense = Dense(finger, found.y)
    gram = dense.p @ np.linalg.inv(dense.k) @ dense.p.T

    def left(w: float) -> np.ndarray:
        return w * np.linalg.inv(gram + w * np.eye(count))

    def score(w: float, b: np.ndarray) -> float:
        return ((left(w) @ b) ** 2).sum() / np.trace(left(w)) ** 2

    stopped = np.array([np.trace(left(w)) < count / 4 for w in found.weight])
    assert 10 < stopped.sum() < 30
    for w, b, stop in zip(found.weight, frames / finger.array.noise, stopped, strict=True):
        if stop:
            assert np.trace(left(w * np.exp(0.5))) >= count / 4
        else:
            assert score(w, b) < min(score(w * 1.01, b), score(w / 1.01, b))


def test_deviations_are_those_of_the_quadratic():
    finger = row()
    frame = finger.read(rollers(1), np.random.default_rng(5))[0]
    found = ss.pressure_map(finger, frame, shear="none")
    dense = Dense(finger, found.y)
    hessian = dense.hessian(0.0, float(found.weight))
    np.testing.assert_allclose(found.pressure_std[1:-1], np.sqrt(np.diag(np.linalg.inv(hessian))), rtol=1e-5)
    on = found.pressure[1:-1] > 0
    part = np.linalg.inv(hessian[np.ix_(on, on)])
    e = np.full(on.sum(), dense.h)
    assert found.normal_std == pytest.approx(np.sqrt(e @ part @ e), rel=1e-5)
    arm = (found.y[1:-1][on] - found.centre) * dense.h / found.normal_force
    assert found.centre_std == pytest.approx(np.sqrt(arm @ part @ arm), rel=1e-5)


def error(found: ss.estimate.PressureMap, touch: ss.Contact) -> np.ndarray:
    true = touch.expand(1).pressure(found.y)
    return np.linalg.norm(found.pressure - true, axis=-1) / np.linalg.norm(true, axis=-1)


@pytest.mark.parametrize("angle", [-30, 0, 30])
@pytest.mark.parametrize("rule", RULES)
def test_a_roller_as_wide_as_the_depth_is_found_to_a_tenth(rule, angle):
    finger, touch = row(), rollers(200, angle=np.deg2rad(angle))
    found = ss.pressure_map(
        finger, finger.read(touch, np.random.default_rng(6)), rule=rule, shear="proportional" if angle else "none"
    )
    assert (found.status == ss.Status.OK).all()
    assert np.sqrt((error(found, touch) ** 2).mean()) < (0.065 if rule == "evidence" else 0.10)
    normal = np.cos(np.deg2rad(angle))
    assert abs(found.normal_force.mean() / normal - 1) < (2e-3 if rule == "evidence" else 0.02)
    if angle:
        assert (np.abs(found.angle - np.deg2rad(angle)) / found.angle_std).max() < 5
        assert np.abs((found.angle - np.deg2rad(angle)).mean()) < np.deg2rad(0.1)


@pytest.mark.parametrize("skin", ["compressible", "layer", "round"])
def test_other_skins_do_as_well(skin):
    finger, touch = row(SKINS[skin]), rollers(20, angle=0.3)
    found = ss.pressure_map(finger, finger.read(touch, np.random.default_rng(7)), shear="proportional")
    assert error(found, touch).mean() < 0.10
    assert np.abs(found.angle - 0.3).max() < 6 * found.angle_std.max()


@pytest.mark.parametrize(("half_width", "least"), [(0.4, 0.97), (1.0, 0.97), (2.0, 0.97)])
def test_the_band_holds_the_pressure(half_width, least):
    finger, touch = row(), rollers(60, half_width=half_width)
    found = ss.pressure_map(finger, finger.read(touch, np.random.default_rng(8)), shear="none")
    true = touch.expand(1).pressure(found.y)
    low, high = np.moveaxis(found.pressure_interval, -1, 0)
    inside = (low <= true) & (true <= high)
    assert inside[true > 0].mean() > least
    # and it is no wider than it has to be: a third of it does not hold
    third = np.abs(found.pressure - true) < found.pressure_std * 1.96 / 3
    assert third[true > 0].mean() < 0.97
    assert np.abs(found.normal_force - 1).std() < found.normal_std.mean() < 3 * (found.normal_force - 1).std()


def test_resolution_is_the_width_of_a_narrow_load():
    finger = row()
    frame = finger.read(rollers(1), np.random.default_rng(9))[0]
    found = ss.pressure_map(finger, frame, shear="none")
    dense = Dense(finger, found.y)
    hessian = dense.hessian(0.0, float(found.weight))
    for j in (40, 54, 60):
        narrow = ss.LineLoad(1.0, position=found.y[j])
        image = np.linalg.solve(hessian, dense.p.T @ (finger.measure(narrow) / finger.array.noise))
        fine = np.linspace(found.y[1], found.y[-2], 20001)
        curve = np.interp(fine, found.y[1:-1], image)
        above = fine[curve > 0.5 * curve.max()]
        assert found.resolution[j] == pytest.approx(above[-1] - above[0], rel=0.02)
        assert 0.3 < found.resolution[j] < 1.0
    even = np.linalg.solve(hessian, dense.p.T @ (dense.p @ np.ones(dense.m)))
    np.testing.assert_allclose(found.seen[1:-1], even, atol=1e-5)
    # a load beyond the sensors is smeared over more
    assert found.resolution[3] > 1.3 * found.resolution[54]
    # noise costs resolution
    noisy = row(noise=1e-2)
    again = ss.pressure_map(noisy, noisy.read(rollers(1), np.random.default_rng(9))[0], shear="none")
    assert again.resolution[54] > 1.2 * found.resolution[54]


def test_the_unit_of_length_and_of_stress_are_of_no_account():
    finger = row()
    depth, young = 2e-3, 0.4e6
    small = ss.Finger(
        ss.HalfPlane(ss.Material(young=young)),
        ss.SensorArray(y=depth * np.asarray(finger.array.y), depth=depth, noise=finger.array.noise),
    )
    frames = finger.read(rollers(4, angle=0.3), np.random.default_rng(10))
    one, two = (ss.pressure_map(f, frames, shear="proportional") for f in (finger, small))
    np.testing.assert_allclose(two.pressure, young * one.pressure, atol=1e-6 * young * one.pressure.max())
    np.testing.assert_allclose(two.normal_force, young * depth * one.normal_force, rtol=1e-6)
    np.testing.assert_allclose(two.resolution, depth * one.resolution, rtol=1e-4)


def test_two_kinds_of_sensors_see_a_shear_of_its_own():
    """Of a contact that partly slips: its shear is not in proportion to its pressure."""
    finger = both()
    position = np.random.default_rng(0).uniform(-0.5, 0.5, 40)
    touch = ss.PartialSlip(force=np.ones(40), angle=0.4, position=position, half_width=1.0, friction=0.6)
    frames = finger.read(touch, np.random.default_rng(11))
    free = ss.pressure_map(finger, frames, shear="free")
    tied = ss.pressure_map(finger, frames, shear="proportional")
    true = touch.expand(1).shear(free.y)

    def off(found: ss.estimate.PressureMap) -> np.ndarray:
        return np.linalg.norm(found.shear - true, axis=-1) / np.linalg.norm(true, axis=-1)

    assert (free.status == ss.Status.OK).all()
    assert off(free).mean() < 0.22
    assert off(free).mean() < 0.7 * np.nanmean(off(tied)) or (tied.status == ss.Status.UNEXPLAINED).mean() > 0.5
    assert np.abs(free.tangential_force - np.sin(0.4)).max() < 5 * free.tangential_std.max()
    inside = np.abs(free.shear - true) < 1.96 * free.shear_std
    assert inside[true != 0].mean() > 0.95


def test_untouched_skin_is_said_to_be_so():
    finger = row(count=9, pitch=0.5)
    noise = np.asarray(finger.array.noise) * np.random.default_rng(12).standard_normal((20000, 9))
    status = ss.pressure_map(finger, noise, false_alarm=1e-2).status
    share = (status != ss.Status.NO_CONTACT).mean()
    assert 0.5e-2 < share < 1.5e-2
