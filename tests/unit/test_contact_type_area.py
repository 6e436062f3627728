"""Kinds of contact on an area: their evidence beside plain sums, names, and what is none of them."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.decide import Kind, contact_type, usual_kinds
from subskin.errors import GeometryError, InvalidValueError

D = 2e-3  # m
KIND, EACH = 1, 11


@pytest.fixture(scope="module")
def finger():
    noise = 1e-3 / (2 * np.pi) / D**2  # a thousandth of the pressure beneath 1 N
    array = ss.SensorArray.grid((4, 4), 0.8 * D, D, transducer=ss.MeanPressure(), noise=noise)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)


LOAD = {"force": 1.0, "angle": 0.3, "azimuth": 1.0, "position": (0.3 * D, -0.4 * D)}
TOUCHES = {
    "point": ss.PointLoad(**LOAD),
    "vertex": ss.Cone(**LOAD, half_width=0.47 * D),
    "flat side": ss.RoundPunch(**LOAD, half_width=0.9 * D),
    "round side": ss.RoundHertz(**LOAD, half_width=1.2 * D),
}


@pytest.fixture(scope="module")
def said(finger):
    rng = np.random.default_rng(1)
    return contact_type(finger, np.stack([finger.read(touch, rng) for touch in TOUCHES.values()]))


def test_kinds_are_named(finger, said):
    assert said.names == ("point", "vertex", "flat side", "round side", "edge", "none of these")
    assert said.name.tolist() == list(TOUCHES)
    assert (said.probability[np.arange(4), np.arange(4)] > 0.95).all()
    np.testing.assert_allclose(said.position, np.tile(LOAD["position"], (4, 1)), atol=0.02 * D)
    np.testing.assert_allclose(said.force, 1.0, atol=0.02)
    np.testing.assert_allclose(said.azimuth, 1.0, atol=0.05)
    np.testing.assert_allclose(said.half_width, np.array([0.0, 0.47, 0.9, 1.2]) * D, atol=0.1 * D)
    assert said.spare.tolist() == [11, 10, 10, 10]
    assert {"kind", "p_flat_side", "position_z", "azimuth"} <= set(said.to_dict())
    assert contact_type(finger, finger.read(ss.PointLoad(**LOAD))).shape == ()


@pytest.mark.parametrize(
    ("name", "family"),
    [("point", None), pytest.param("vertex", ss.Cone, marks=pytest.mark.long), ("round side", ss.RoundHertz)],
)
def test_the_evidence_is_the_plain_average_of_the_likelihood(finger, name, family):
    """By importance sampling in all unknowns, of the closed form: the rule, Laplace's method, and the tables."""
    rng = np.random.default_rng(2)
    kinds = usual_kinds(finger)
    which = [kind.name for kind in kinds].index(name)
    low, high = kinds[which].half_width
    frame = finger.read(TOUCHES[name], rng)
    seen = contact_type(finger, frame)
    part = seen.table[KIND + which * EACH : KIND + (which + 1) * EACH]
    best = part[2:7] if family is None else part[2:8]
    units, noise = np.array([D, D, 1.0, 1.0, 1.0, D])[: best.size], np.asarray(finger.array.noise)

    def chi2(x):
        x = x * units
        width = {} if family is None else {"half_width": np.maximum(x[:, 5], 1e-6)}
        make = ss.PointLoad if family is None else family
        readings = finger.measure(make(components=x[:, 2:5], position=x[:, :2], **width))
        return (((readings - frame) / noise) ** 2).sum(axis=1)

    at, h = best / units, 1e-4
    steps = np.eye(at.size) * h
    ends = [np.concatenate([at + steps, at - steps])]
    make = ss.PointLoad if family is None else family
    width = {} if family is None else {"half_width": ends[0][:, 5] * D}
    felt = finger.measure(make(components=ends[0][:, 2:5], position=ends[0][:, :2] * D, **width)) / noise
    jacobian = (felt[: at.size] - felt[at.size :]) / (2 * h)
    root = np.linalg.cholesky(np.linalg.inv(jacobian @ jacobian.T)) * 1.2
    z = rng.standard_normal((6000, at.size))
    x = at + z @ root.T
    inside = np.ones(len(x), bool) if family is None else (x[:, 5] * D > low) & (x[:, 5] * D < high)
    density = -0.5 * (z**2).sum(1) - np.log(np.diag(root)).sum() - 0.5 * at.size * np.log(2 * np.pi)
    force = np.linalg.norm(x[:, 2:5], axis=1)
    log = -0.5 * chi2(x) - 3 * np.log(force) - density
    log = np.where(inside, log - (0 if family is None else np.log((high - low) / D)), -np.inf)
    plain = np.log(np.mean(np.exp(log - log.max()))) + log.max() + 2 * np.log(D)
    assert seen.log_evidence[which] == pytest.approx(plain, abs=0.06)


def test_none_of_these_and_nothing(finger):
    ball = finger.read(TOUCHES["round side"])
    two = finger.read(ss.PointLoad(**LOAD)) + finger.read(ss.PointLoad(force=0.7, position=(-0.9 * D, 0.9 * D)))
    oblong = finger.read(ss.Patch(force=0.1, half_widths=(0.9 * D, 0.2 * D)))
    quiet = np.zeros(16)
    lost = np.array(ball)
    lost[3] = np.nan
    seen = contact_type(finger, [two, oblong, quiet, -ball, lost, np.full(16, np.nan)])
    assert seen.name[0] in ("unexplained", "none of these")
    assert seen.name[1] == "edge"  # so it reads, though its pressure is even across as well
    assert np.sin(seen.direction[1]) == pytest.approx(0, abs=1e-3)
    assert seen.name.tolist()[2] == "no contact"
    assert seen.name.tolist()[3] in ("no contact", "unexplained")
    assert seen.name.tolist()[5] == "incomplete"
    assert seen.used[4].sum() == 15
    assert np.isfinite(seen.probability[4]).all()
    alone = contact_type(finger, ball + 30 * np.asarray(finger.array.noise) * np.cos(np.arange(16) ** 2), sure=0.9)
    assert alone.name in ("none of these", "unexplained")


def test_kinds_of_ones_own_and_what_is_refused(finger):
    frame = finger.read(TOUCHES["flat side"], np.random.default_rng(0))
    own = (Kind("coin", "round_punch", (0.5 * D, 1.2 * D)), Kind("ball", ss.RoundHertz, (0.5 * D, 1.4 * D), 4.0))
    assert str(contact_type(finger, frame, own).name) == "coin"
    assert own[0].unknowns(1.0) == 6
    for kinds, text in (
        ((Kind("two", "pair", (D, 2 * D)), own[0]), "two touches"),
        ((Kind("none", "none"),), "at least one"),
        ((Kind("edge", "wedge", (0.1 * D, D)),), "on an area"),
        ((own[0], Kind("coin", "cone", (0.0, D))), "name"),
    ):
        with pytest.raises(InvalidValueError, match=text):
            contact_type(finger, frame, kinds)
    row = ss.Finger(finger.skin, ss.SensorArray(y=np.arange(8) * D, z=1e-3, depth=D, noise=1e-4))
    with pytest.raises(GeometryError, match="straight line"):
        contact_type(row, np.zeros(8))
