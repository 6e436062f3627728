"""A moment about the normal, fitted with a round contact where the sensors tell it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.estimate.area.observable import moment_of
from subskin.estimate.layout import ROUND, TWIST
from subskin.estimate.on_area import moved
from subskin.transducer import ShearStrain

D, COUNT = 2e-3, 200  # m
SKIN = ss.HalfSpace(ss.Material(young=0.4e6, poisson=0.5))
FULL = 3 / (2 * np.pi) / (0.4e6 * D**2)  # normal strain beneath 1 N
SEARCH = ((-2.5 * D, 2.5 * D), (-2.5 * D, 2.5 * D))
UNITS = np.array([D, D, 1.0, 1.0, 1.0, D, 1.0 * D])


def finger_of(shape, kind=None):
    kind = ShearStrain("yz") if kind is None else kind
    return ss.Finger(SKIN, ss.SensorArray.grid(shape, D, D, transducer=kind, noise=1e-3 * FULL))


@pytest.fixture(scope="module")
def finger():
    return finger_of((4, 4))


@pytest.fixture(scope="module")
def touches():
    rng = np.random.default_rng(0)
    force, width = rng.uniform(0.5, 2.0, COUNT), rng.uniform(0.3, 1.3, COUNT) * D
    return ss.RoundHertz(
        force=force,
        angle=rng.uniform(0, 0.6, COUNT),
        azimuth=rng.uniform(-np.pi, np.pi, COUNT),
        position=rng.uniform(-1.5 * D, 1.5 * D, (COUNT, 2)),
        half_width=width,
        moment=rng.uniform(-0.5, 0.5, COUNT) * force * width,
    )


@pytest.fixture(scope="module")
def frames(finger, touches):
    return finger.read(touches, np.random.default_rng(1))


@pytest.fixture(scope="module")
def found(finger, frames):
    return finger.fit(frames, search=SEARCH)


def answers(found):
    return np.column_stack([found.position, found.load.components, found.half_width, found.load.moment])


def test_no_worse_than_least_squares_and_as_sure(finger, touches, frames, found):
    """Seven unknowns, moment included, beside scipy's: the top, and the covariance in any direction."""
    truth = np.column_stack([touches.position, touches.components, touches.half_width, touches.moment])
    noise = np.asarray(finger.array.noise)
    for i in np.flatnonzero(np.asarray(touches.half_width) > 0.6 * D)[:6]:

        def left(p, frame=frames[i]):
            p = p * UNITS
            touch = ss.RoundHertz(components=p[2:5], position=p[:2], half_width=p[5], moment=p[6])
            return (finger.measure(touch) - frame) / noise

        peer = least_squares(left, truth[i] / UNITS, method="lm", xtol=1e-13, ftol=1e-13)
        assert found.residual[i] < 2 * peer.cost + 1e-3
        square = found.table[i, found.layout.square] / np.outer(UNITS, UNITS)
        here = answers(found)[i] / UNITS
        assert (np.abs(here - peer.x) < 0.03 * np.sqrt(np.diagonal(square))).all()
        ratio = np.linalg.eigvals(square @ (peer.jac.T @ peer.jac)).real
        assert np.abs(ratio - 1).max() < 0.1


def test_errors_are_those_that_are_said(touches, found):
    assert found.ok.mean() > 0.98
    ok, square = found.ok, found.load.covariance
    error = np.column_stack(
        [found.position - touches.position, found.load.components - touches.components, found.moment - touches.moment]
    )[ok]
    spread = np.sqrt(np.diagonal(square, axis1=1, axis2=2))[ok]
    assert np.abs((error**2 / spread**2).mean(0) - 1).max() < 0.35  # 200 frames: 0.1 is one standard deviation
    whole = np.einsum("mi,mij,mj->m", error, np.linalg.inv(square[ok]), error)  # with what they have in common
    assert whole.mean() == pytest.approx(6, rel=0.15)
    assert found.residual.mean() == pytest.approx(9, rel=0.12)


def test_fields_and_columns(finger, frames, found):
    assert found.layout is TWIST
    assert found.unknowns == 7
    assert found.covariance.shape == (COUNT, 7, 7)
    assert found.load.covariance.shape == (COUNT, 6, 6)
    assert np.allclose(found.std[:, 6], np.sqrt(found.load.covariance[:, 5, 5]))
    assert np.allclose(found.load.std[:, 5], found.std[:, 6])
    assert found.load[3].moment == found.load.moment[3]
    columns = found.to_dict()
    assert np.array_equal(columns["moment"], found.load.moment)
    assert {"moment_std", "half_width_low"} <= set(columns)
    assert "moment_low" not in columns
    assert "moment" in repr(found[3])
    assert found.second.moment.shape == (COUNT,)
    one = [finger.fit(frame, search=SEARCH).table for frame in frames[:6]]
    assert np.array_equal(np.stack(one), found.table[:6], equal_nan=True)


def test_a_turned_array_finds_the_same_moment(found):
    turned = moved(found, (1e-3, 0.0), 0.7)
    assert np.array_equal(turned.load.moment, found.load.moment)
    axes = np.eye(6)
    axes[:2, :2] = axes[3:5, 3:5] = [[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]]
    assert np.allclose(turned.load.covariance, axes @ found.load.covariance @ axes.T, rtol=1e-9, atol=0)


def test_without_the_moment_a_twisted_contact_is_unexplained(finger, touches, frames):
    plain = finger.fit(frames[:40], search=SEARCH, moment=False)
    assert plain.layout is ROUND
    assert plain.load.moment is None
    strong = np.abs(np.asarray(touches.moment))[:40] > 2e-4  # N m
    assert strong.sum() > 10
    assert (plain.status[strong] == ss.Status.UNEXPLAINED).all()


def test_sensors_that_do_not_tell_it_say_so():
    for kind in (ss.NormalStrain(), ss.MeanPressure()):
        blind = finger_of((3, 3), kind)
        assert moment_of(blind, ss.RoundHertz, 4 * D, 1.5 * D, None) is None
        with pytest.raises(GeometryError, match="no sensor reads it"):
            blind.fit(np.zeros(9), moment=True)
    mixed = ss.SensorArray(
        y=np.tile([-D, 0, D], 4), z=np.repeat([-1.5 * D, -0.5 * D, 0.5 * D, 1.5 * D], 3), depth=D, noise=1e-3 * FULL,
        transducer=(ss.NormalStrain(), ShearStrain("yz"), ss.NormalStrain()) * 4,
    )  # fmt: skip
    both = ss.Finger(SKIN, mixed)
    touch = ss.RoundHertz(force=1.0, angle=0.3, position=(0.2 * D, 0.1 * D), half_width=D, moment=2e-4)
    seen = both.fit(both.read(touch), search=SEARCH)
    assert seen.moment == pytest.approx(2e-4, rel=1e-3)
    # as many readings as unknowns fit anything: it is left out unless it is asked for, and then never sure
    few = ss.Finger(SKIN, both.array.select(np.arange(7)))
    assert moment_of(few, ss.RoundHertz, 4 * D, 1.5 * D, None) is None
    frame = both.read(touch)
    frame[7:] = np.nan
    assert both.fit(frame, search=SEARCH).status == ss.Status.AMBIGUOUS


def test_what_is_refused(finger):
    with pytest.raises(InvalidValueError, match="moment"):
        finger.fit(np.zeros(16), moment=2.0)
    with pytest.raises(InvalidValueError, match="moment"):
        finger.fit(np.zeros(16), "point", moment=True)
    row = ss.Finger(ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(6, D, D, noise=1e-4))
    with pytest.raises(InvalidValueError, match="round contact on an area"):
        row.fit(np.zeros(6), moment=True)
    with pytest.raises(GeometryError, match="long one has none"):
        ss.Load(0.0, [1.0, 0.0], moment=1.0)


@pytest.mark.long
def test_on_a_layer_and_with_shear_across_the_depth():
    """Another skin, channels at one position, a flat disc: without noise the truth comes back."""
    skin = ss.Layered(ss.Layer(ss.Material(young=0.4e6, poisson=0.45), thickness=2 * D))
    at = np.repeat(np.stack(np.meshgrid([-D, 0.0, D], [-D, 0.0, D]), -1).reshape(-1, 2), 2, axis=0)
    pairs = (ShearStrain("xy"), ShearStrain("xz")) * 9
    array = ss.SensorArray(y=at[:, 0], z=at[:, 1], depth=D, transducer=pairs, noise=1e-3 * FULL)
    finger = ss.Finger(skin, array)
    touch = ss.RoundPunch(components=(1.0, 0.2, -0.1), position=(0.3 * D, -0.2 * D), half_width=0.8 * D, moment=-3e-4)
    seen = finger.fit(finger.read(touch), "round_punch", search=SEARCH)
    assert seen.ok
    assert float(seen.moment) == pytest.approx(-3e-4, rel=1e-3)
    assert float(seen.half_width) == pytest.approx(0.8 * D, rel=1e-3)
