"""Round contacts on an area: tables over the half width, and `fit` beside least squares, its bound and nonsense."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import subskin as ss
from subskin.contact import local_families
from subskin.errors import GeometryError, InvalidValueError
from subskin.estimate.area.round_contact import ROWS, RoundAt, RoundModel, round_field
from subskin.radial_round import tabulate_round
from subskin.transducer import ShearStrain

D = 2e-3  # m
SKIN = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
FULL = 3 / (2 * np.pi) / (0.4e6 * D**2)  # strain beneath 1 N
COUNT, SEARCH = 300, ((-2.5 * D, 2.5 * D), (-2.5 * D, 2.5 * D))


def finger_of(shape, noise=1e-3 * FULL):
    return ss.Finger(SKIN, ss.SensorArray.grid(shape, D, D, noise=noise))


def fit(finger, frames, family="round_hertz", **options):
    return finger.fit(frames, family, search=SEARCH, **options)


@pytest.fixture(scope="module")
def finger():
    return finger_of((4, 4))


@pytest.fixture(scope="module")
def touches():
    rng = np.random.default_rng(0)
    return ss.RoundHertz(
        force=rng.uniform(0.5, 2.0, COUNT),
        angle=rng.uniform(0, 0.7, COUNT),
        azimuth=rng.uniform(-np.pi, np.pi, COUNT),
        position=rng.uniform(-1.5 * D, 1.5 * D, (COUNT, 2)),
        half_width=rng.uniform(0.02, 1.3, COUNT) * D,
    )


@pytest.fixture(scope="module")
def found(finger, touches):
    return fit(finger, finger.read(touches, np.random.default_rng(1)))


class Blunt(ss.contact.RoundContact):
    """Half a sphere's pressure and half a flat's: a contact that no file of the package knows."""

    def disc_family(self, order, x, zeta):
        return 0.5 * (ss.RoundHertz.disc_family(self, order, x, zeta) + ss.RoundPunch.disc_family(self, order, x, zeta))

    def disc_pressure(self, r):
        return 0.5 * (ss.RoundHertz.disc_pressure(self, r) + ss.RoundPunch.disc_pressure(self, r))

    def disc_spectrum(self, k):
        return 0.5 * (ss.RoundHertz.disc_spectrum(self, k) + ss.RoundPunch.disc_spectrum(self, k))


@pytest.mark.parametrize(
    ("skin", "family", "kind"),
    [
        (SKIN, ss.Cone, ss.MeanPressure()),
        (ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.3)), ss.RoundPunch, ShearStrain("xz")),
        (ss.Layered(ss.Layer(ss.Material(young=0.4e6), thickness=2 * D)), ss.RoundHertz, ss.NormalStrain()),
    ],
    ids=["half space", "harmonics", "layer"],
)
def test_tables_over_the_width_are_the_forward_model(skin, family, kind):
    array = ss.SensorArray.grid((2, 2), D, [D, D, D, 1.3 * D], transducer=kind, gain=[1.0, 2.0, -1.0, 1.0])
    finger = ss.Finger(skin, array)
    table = tabulate_round(finger, family, 4 * D, 1.5 * D)
    at = np.random.default_rng(2).uniform(-2 * D, 2 * D, (20, 2))
    for a in (0.05 * D, 0.77 * D, 1.5 * D):
        touch = family(components=np.eye(3), position=at[:, None], half_width=a)
        truth = np.swapaxes(finger.measure(touch) * array.gain, -1, -2)
        assert np.abs(table.at(a)(at) - truth).max() < max(table.error, 1e-7) * np.abs(truth).max()
    assert table.error < 5e-6
    with pytest.raises(InvalidValueError, match="depths"):
        tabulate_round(finger, family, 4 * D, 3 * D)


@pytest.mark.parametrize("pair", [True, False])
def test_compiled_columns_and_slopes_are_those_of_the_table(finger, pair):
    table = finger.locator("round_hertz", search=SEARCH).response
    sums, error = table.cubics()
    assert error < 5e-6
    cells, part, terms = sums.shape[1], table.table, table.table.terms
    sensors = np.stack([*part.points.T, part.depth**-2.0, part.gain])
    first, shares = np.append(part.kind * cells, cells - 1), np.zeros((2, sums.shape[-1]))
    sums = np.ascontiguousarray(sums.reshape(cells, -1, sums.shape[-1]))
    if pair:  # as the locator lays them out
        (f, p), (g, q) = part.pair
        sums = np.concatenate([p * sums[:, 4 * f : 4 * f + 4], q * sums[:, 4 * g : 4 * g + 4]], axis=1)
        terms = np.array([[0, 0, 0, 0, 1], [1, 1, 0, 1, 1], [2, 1, 1, 1, 1]])
    b, most = np.zeros((ROWS, 16)), (1.5 * D) ** 2
    model = RoundModel(sensors, first, sums, terms, most, sums[:0], terms[:0], shares, np.zeros((2, 3)), b)
    size = np.abs(part(np.zeros(2))).max()
    for y, z, a in np.random.default_rng(0).uniform(-1.4 * D, 1.4 * D, (5, 3)):
        square, h = a * a, 1e-4 * D
        round_field(model, RoundAt(y, z, square))

        def at(dy=0.0, dz=0.0, dq=0.0, y=y, z=z, square=square):
            return table.at(np.sqrt(square + dq))((y + dy, z + dz)).T

        assert np.abs(b[:3] - at()).max() < 1e-6 * size
        assert np.abs(b[3:6] - (at(dy=h) - at(dy=-h)) / (2 * h)).max() < 1e-3 * size / D
        assert np.abs(b[6:9] - (at(dz=h) - at(dz=-h)) / (2 * h)).max() < 1e-3 * size / D
        step = 1e-3 * square
        assert np.abs(b[9:12] - (at(dq=step) - at(dq=-step)) / (2 * step)).max() < 1e-4 * size / D**2


def test_no_worse_than_least_squares_from_the_truth(finger, touches, found):
    frames = finger.read(touches, np.random.default_rng(1))
    noise, units = np.asarray(finger.array.noise), np.array([D, D, 1.0, 1.0, 1.0, D])
    wide = np.flatnonzero(np.asarray(touches.half_width) > 0.5 * D)[:8]
    for i in wide:
        start = np.concatenate([touches.position[i], touches.components[i], touches.half_width[i : i + 1]]) / units

        def left(p, frame=frames[i]):
            p = p * units
            return (finger.measure(ss.RoundHertz(components=p[2:5], position=p[:2], half_width=p[5])) - frame) / noise

        peer = least_squares(left, start, method="lm", xtol=1e-13, ftol=1e-13)
        assert found.residual[i] < 2 * peer.cost + 1e-3
        here = np.concatenate([found.position[i], found.load.components[i], found.half_width[i : i + 1]]) / units
        square = found.table[i, found.layout.square] / np.outer(units, units)
        assert (np.abs(here - peer.x) < 0.03 * np.sqrt(np.diagonal(square))).all()
        ratio = np.linalg.eigvals(square @ (peer.jac.T @ peer.jac)).real  # of variances, in any direction
        assert np.abs(ratio - 1).max() < 0.08


def test_errors_and_intervals_hold(touches, found):
    assert found.ok.mean() > 0.98
    ok = found.ok
    truth = np.concatenate([touches.position, touches.components], -1)
    error = (np.concatenate([found.position, found.load.components], -1) - truth)[ok]
    spread = np.sqrt(np.diagonal(found.load.covariance, axis1=1, axis2=2))[ok]
    assert np.abs((error**2 / spread**2).mean(0) - 1).max() < 0.25  # 300 frames: 0.08 is one standard deviation
    low, high = np.moveaxis(found.half_width_interval, -1, 0)
    inside = (low <= touches.half_width) & (touches.half_width <= high)
    assert 0.91 < inside[ok].mean() < 0.99
    assert found.residual.mean() == pytest.approx(10, rel=0.1)
    assert found.covariance.shape == (COUNT, 6, 6)
    assert {"half_width_low", "position_z"} <= set(found.to_dict())


def test_a_width_below_what_the_noise_sees_says_so(finger):
    rng = np.random.default_rng(3)
    at = rng.uniform(-D, D, (60, 2))
    for touch in (
        ss.PointLoad(force=np.ones(60), position=at),
        ss.RoundHertz(force=np.ones(60), position=at, half_width=0.03 * D),
    ):
        seen = fit(finger, finger.read(touch, rng), "round_hertz")
        assert seen.ok.all()
        assert (seen.half_width_interval[:, 0] == 0).mean() > 0.9
        assert (seen.half_width_interval[:, 1] > 0.03 * D).mean() > 0.9
        assert seen.half_width_interval[:, 1].max() < 0.35 * D


def test_what_no_round_contact_explains(finger):
    touch = ss.RoundHertz(force=1.0, angle=0.4, azimuth=1.0, position=(0.4 * D, 0.2 * D), half_width=0.8 * D)
    frame = finger.read(touch)
    two = frame + finger.read(ss.PointLoad(force=1.0, position=(-1.4 * D, -1.2 * D)))
    flat = finger.read(ss.RoundPunch(force=1.0, position=(0.4 * D, 0.2 * D), half_width=0.9 * D))
    long = finger.read(ss.Patch(force=1.0, position=(0.0, 0.0), half_widths=(0.3 * D, 1.5 * D)))
    nonsense = FULL * np.random.default_rng(0).standard_normal(16)
    quiet = 1e-3 * FULL * np.random.default_rng(1).standard_normal(16)
    status = fit(finger, [-frame, two, flat, long, nonsense, quiet]).status
    assert [ss.Status(s).name for s in status] == ["UNEXPLAINED"] * 5 + ["NO_CONTACT"]
    lost = np.array(frame)
    lost[5] = np.nan
    seen = fit(finger, lost)
    assert seen.ok
    assert not seen.used[5]
    assert float(seen.half_width) == pytest.approx(0.8 * D, rel=1e-5)


def test_a_contact_of_ones_own_is_fitted_by_itself(finger):
    assert set(local_families()) >= {"point", "round_hertz", "round_punch", "cone"}
    touch = Blunt(force=1.0, angle=0.3, azimuth=1.0, position=(0.4 * D, 0.2 * D), half_width=0.9 * D)
    frame = finger.read(touch, np.random.default_rng(0))
    seen = fit(finger, frame, Blunt)
    assert seen.ok
    assert seen.half_width_interval[0] < 0.9 * D < seen.half_width_interval[1]
    assert fit(finger, frame, "round_hertz").residual > seen.residual + 5


def test_known_and_bounded_widths(finger):
    touch = ss.RoundHertz(force=1.0, angle=0.3, position=(0.4 * D, 0.2 * D), half_width=0.9 * D)
    frame = finger.read(touch, np.random.default_rng(0))
    known = fit(finger, frame, half_width=(0.9 * D, 0.9 * D))
    free = fit(finger, frame)
    assert known.ok
    assert known.half_width_interval.tolist() == [0.9 * D, 0.9 * D]
    assert known.load.covariance[2, 2] < free.load.covariance[2, 2]
    assert fit(finger, frame, half_width=(0.0, 0.8 * D)).status != ss.Status.OK


def test_six_readings_are_never_sure():
    small = finger_of((2, 3))
    touch = ss.RoundHertz(force=1.0, angle=0.3, position=(0.1 * D, 0.2 * D), half_width=0.9 * D)
    assert fit(small, small.read(touch)).status == ss.Status.AMBIGUOUS


def test_what_is_refused(finger):
    frame = np.zeros(16)
    for family in ("hertz", "strip", ss.Hertz, 3):
        with pytest.raises(InvalidValueError, match="round_hertz"):
            finger.fit(frame, family)
    with pytest.raises(InvalidValueError, match="half_width"):
        finger.fit(frame, "point", half_width=(0.0, 1e-3))
    with pytest.raises(InvalidValueError, match="depths"):
        finger.fit(frame, half_width=(0.0, 3 * D))
    with pytest.raises(InvalidValueError, match="stick"):
        finger.fit(frame, stick=0.5)
    row = ss.Finger(SKIN, ss.SensorArray(y=np.arange(8) * D, z=1e-3, depth=D, noise=1e-4))
    with pytest.raises(GeometryError, match="straight line"):
        row.fit(np.zeros(8), "cone")
