"""Two points or one: small separations against theory, the power that is promised against noisy readings."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
from scipy.stats import norm

import subskin as ss
from subskin.design import Touches, two_point_limen
from subskin.memo.three_sensors import three_sensor

UNIT = ss.HalfPlane(ss.Material(young=1.5 / np.pi))  # strain right beneath a unit point at unit depth is -1
AT_ONE = {"test": "best", "power": float(norm.cdf(1)), "false_alarm": 0.5}  # told where the distance is 1


def row(count, pitch, noise):
    return ss.Finger(UNIT, ss.SensorArray.line(count, pitch, 1.0, noise=noise))


def normal(offset, derivative=0):
    """Derivatives of (1 - t^2)/(1 + t^2)^2, the real part of 1/(1 + i t)^2."""
    k = derivative
    return np.real((-1j) ** k * factorial(k + 1) / (1 + 1j * offset) ** (2 + k))


def tangential(offset, derivative=0):
    """Derivatives of t (1 - t^2)/(1 + t^2)^2, by the rule for products."""
    k = derivative
    return offset * normal(offset, k) + (k * normal(offset, k - 1) if k else 0)


def left_over(vector, columns):
    """Length of what of a vector is square to the columns."""
    basis, _ = np.linalg.qr(np.stack(columns, axis=-1))
    return float(np.linalg.norm(vector - basis @ (basis.T @ vector)))


def limen(finger, position, share=0.5, **options):
    touches = Touches(1.0, span=(position - 1e-9, position + 1e-9))
    return float(two_point_limen(finger, touches, positions=1, shares=share, **options).separation[0, 0, 0])


@pytest.mark.parametrize("position", [0.0, 0.11, 0.25])
@pytest.mark.parametrize("pitch", [0.5, 0.8, 1.0])
def test_three_sensors_follow_the_determinant(position, pitch):
    """FORMULAS 4.3: the residual of equal halves is k D^2, k = |det[v, v', v'']| / (8 |v x v'|)."""
    v, dv, ddv = (normal(position - pitch * np.array([-1, 0, 1]), k) for k in range(3))
    k = abs(np.linalg.det([v, dv, ddv])) / (8 * np.linalg.norm(np.cross(v, dv)))
    accuracy = 1e-5
    wanted = np.sqrt(accuracy / k)
    assert limen(row(3, pitch, accuracy), position, **AT_ONE) == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize(("pitch", "worst"), [(0.5, 0.0583), (1.0, 0.1105)])
def test_the_worst_between_the_middles_of_three_sensors(pitch, worst):
    """FORMULAS 4.3 at 0.1 % of full scale: 0.058 and 0.111 depths, for middles up to half a spacing out."""
    touches = Touches(1.0, span=(-pitch / 2, pitch / 2))
    found = two_point_limen(row(3, pitch, 1e-3), touches, positions=201, shares=0.5, largest=0.25, **AT_ONE)
    assert found.worst == pytest.approx(worst, rel=0.01)


@pytest.mark.parametrize("pitch", [0.25, 0.5, 1.0, 1.5, 2.0])
def test_three_sensors_always_have_positions_where_two_points_stay_one(pitch):
    """Where the curve of a point turns the other way, its chords meet it: the memo's Fig. 19 does not tell all."""
    y = np.linspace(0.01, 3, 3000)
    v, dv, ddv = (normal(y[:, None] - pitch * np.array([-1, 0, 1]), k) for k in range(3))
    turn = np.linalg.det(np.stack([v, dv, ddv], axis=-1))
    position = y[np.flatnonzero(turn[1:] * turn[:-1] < 0)[-1]]
    told = limen(row(3, pitch, 1e-5), position, **AT_ONE)
    beside = limen(row(3, pitch, 1e-5), position - 0.1, largest=0.2, **AT_ONE)
    assert told > 5 * beside
    # five sensors are not fooled there
    assert limen(row(5, pitch, 1e-5), position, **AT_ONE) < 0.4 * told


@pytest.mark.parametrize(("count", "pitch"), [(4, 0.7), (8, 0.75)])
@pytest.mark.parametrize("share", [0.5, 0.35])
@pytest.mark.parametrize("position", [0.13, 0.3])
def test_a_point_is_left_in_second_order(count, pitch, share, position):
    finger, noise = row(count, pitch, 1e-6), 1e-6
    v = [normal(position - np.asarray(finger.array.y), k) for k in range(3)]
    curve = 0.5 * share * (1 - share) * left_over(v[2], v[:2])
    assert limen(finger, position, share, **AT_ONE) == pytest.approx(np.sqrt(noise / curve), rel=2e-3)


@pytest.mark.parametrize(("count", "pitch"), [(5, 0.7), (8, 0.75)])
def test_a_wide_contact_is_left_in_fourth_order_or_third(count, pitch):
    """Hertz of half width D has the second moment of two halves D apart; what is left is of its fourth, or third."""
    finger, position = row(count, pitch, 1.0), 0.13
    s = np.asarray(finger.array.y)
    v = [normal(position - s, k) for k in range(5)]
    theory = {0.5: (4, left_over(v[4], v[:3]) / 384), 0.3: (3, 0.3 * 0.7 * 0.4 * left_over(v[3], v[:3]) / 6)}
    for share, (order, size) in theory.items():
        told = []
        for distance in (1e-5, 1e-4):
            fine = row(count, pitch, distance)
            told.append(limen(fine, position, share, against="wide", largest=1.5, **AT_ONE))
        assert np.log(10) / np.log(told[1] / told[0]) == pytest.approx(order, rel=0.08)
        assert told[0] == pytest.approx((1e-5 / size) ** (1 / order), rel=0.08)


@pytest.mark.parametrize(("against", "power"), [("point", 3 / 2), ("wide", 5 / 4)])
def test_at_the_same_noise_depth_costs_more_than_its_length(against, power):
    told = []
    for depth in (1.0, 2.0):
        array = ss.SensorArray.line(6, 0.6 * depth, depth, noise=2e-5)
        touches = Touches(1.0, span=(0.12 * depth, 0.14 * depth))
        found = two_point_limen(
            ss.Finger(UNIT, array), touches, against=against, positions=1, shares=0.5, largest=1.5 * depth
        )
        told.append(float(found.separation[0, 0, 0]))
    assert np.log2(told[1] / told[0]) == pytest.approx(power, abs=0.03)


@pytest.mark.parametrize(("against", "order"), [("point", 2), ("wide", 4)])
def test_with_the_angle_unknown_the_orders_stay(against, order):
    """The tangential field is one column more to mimic two equal points with."""
    position, count, pitch = 0.13, 8, 0.6
    s = np.asarray(row(count, pitch, 1.0).array.y)
    v, t = [normal(position - s, k) for k in range(5)], tangential(position - s)
    hidden = [*v[: 2 if order == 2 else 3], t]
    size = left_over(v[order], hidden) / (8 if order == 2 else 384)
    accuracy = 1e-6 if order == 2 else 1e-5
    told = limen(row(count, pitch, accuracy), position, against=against, angle="free", angles=1, largest=1.5, **AT_ONE)
    assert told == pytest.approx((accuracy / size) ** (1 / order), rel=5e-3 if order == 2 else 0.08)


@pytest.mark.parametrize("pitch", [0.5, 0.8, 1.2])
def test_three_sensors_and_an_unknown_angle_are_exactly_the_roots_of_the_memo(pitch):
    """Two points are told from one load exactly where eq. (13) has no root that presses within the cone."""
    rng = np.random.default_rng(0)
    finger, friction = row(3, pitch, 1e-3), 0.8
    s = np.asarray(finger.array.y)
    touches = Touches(1.0, friction, span=(-pitch, pitch))
    found = two_point_limen(finger, touches, angle="free", positions=6, shares=[0.35, 0.5], angles=3)
    reach, agreed, hidden = pitch + 1.5, 0, 0
    for index in rng.integers(0, [found.step.size, *found.separation.shape], (150, 4)):
        distance, (i, p, q, k) = found.distance[tuple(index)], index
        half, (low, high), share = found.step[i] / 2, found.lean[k], found.share[q]
        two = ss.LineLoad(share, low, found.position[p] - half) + ss.LineLoad(1 - share, high, found.position[p] + half)
        roots = three_sensor(finger.measure(two), s, 1.0, young=UNIT.material.young, friction=friction).accepted
        one = any(abs(root.position) < reach for root in roots)
        if 1e-4 < distance < 0.05 or any(abs(abs(r.position) - reach) < 0.02 for r in roots):
            continue  # on the border
        assert one == (distance <= 1e-4), (index, distance)
        agreed += 1
        hidden += one
    assert agreed > 100
    assert 0.3 < hidden / agreed < 1.0  # most are hidden; not all, as near a fold, or an edge of the cone


def test_four_sensors_tell_at_any_angle_what_three_do_not():
    touches = Touches(1.0, friction=0.5, span=(-0.5, 0.5))
    three, four = (
        two_point_limen(row(n, 1.0, 1e-4), touches, angle="free", positions=8, shares=[0.4, 0.5]) for n in (3, 4)
    )
    small = three.step < 0.3
    assert (three.distance[small] < 1e-3).mean() > 0.85
    assert (four.distance[small & (four.step > 0.02)] > 1e-3).mean() > 0.99
    # the three's limit is the reach of their one load, and finer sensors do not help
    assert np.median(three.with_noise(0.01).separation) > 0.9 * np.median(three.separation)
    assert np.median(four.with_noise(0.01).separation) < 0.2 * np.median(four.separation)


CASES = [
    (3, 0.5, "point", "normal"),
    (8, 0.75, "point", "normal"),
    (6, 0.6, "point", "free"),
    (6, 0.6, "wide", "normal"),
    (8, 0.5, "wide", "free"),
]


@pytest.mark.parametrize(("count", "pitch", "against", "angle"), CASES)
def test_the_power_is_as_promised(count, pitch, against, angle):
    """Noisy readings through `locate` or `fit`: UNEXPLAINED as often as promised, of two points and of one contact."""
    rng, chance, frames = np.random.default_rng(5), 0.02, 4000
    finger, friction = row(count, pitch, 1e-3), 0.6
    touches = Touches(1.0, friction, span=(-0.6, 0.6))
    found = two_point_limen(
        finger, touches, against=against, angle=angle, false_alarm=chance, power=0.8, positions=5, angles=3
    )
    options = {"friction": friction if angle == "free" else 0.0, "false_alarm": chance}

    def unexplained(contact):
        readings = finger.measure(contact) + 1e-3 * rng.standard_normal((frames, count))
        if against == "point":
            return np.mean(finger.locate(readings, **options).status == ss.Status.UNEXPLAINED)
        tried = finger.fit(readings, "hertz", half_width=(0.0, 2.5), **options)
        return np.mean(tried.status == ss.Status.UNEXPLAINED)

    told = np.argwhere(np.isfinite(found.separation))
    shares = []
    for p, q, k in told[rng.integers(0, len(told), 6)]:
        half, share, (low, high) = found.separation[p, q, k] / 2, found.share[q], found.lean[k]
        lower = ss.LineLoad(share, low, found.position[p] - half)
        shares.append(unexplained(lower + ss.LineLoad(1 - share, high, found.position[p] + half)))
    # where the nearest contact lies on the edge of the cone, or of the widths, it has a freedom less: more is told
    assert min(shares) > 0.8 - 5 * np.sqrt(0.16 / frames) - 0.01
    assert np.median(shares) == pytest.approx(0.8, abs=0.03)
    one = ss.LineLoad(1.0, 0.1 if angle == "free" else 0.0, 0.17)
    if against == "wide":
        one = ss.Hertz(1.0, one.angle, 0.17, half_width=0.9)
    assert unexplained(one) == pytest.approx(chance, abs=5 * np.sqrt(chance / frames))


@pytest.mark.parametrize(("count", "pitch"), [(4, 0.7), (8, 0.75)])
def test_no_test_does_better_than_the_best(count, pitch):
    """The likelihood ratio of exactly these two points and exactly the nearest one, on noisy readings."""
    rng, chance, frames = np.random.default_rng(6), 0.02, 40_000
    finger, position, share = row(count, pitch, 1e-3), 0.21, 0.4
    options = {"false_alarm": chance, "power": 0.8}
    apart = limen(finger, position, share, test="best", **options)
    two = finger.measure(
        ss.LineLoad(share, 0.0, position - apart / 2) + ss.LineLoad(1 - share, 0.0, position + apart / 2)
    )
    nearest = finger.locate(two, friction=0.0, false_alarm=1e-12)
    one = finger.measure(ss.LineLoad(float(nearest.force), 0.0, float(nearest.position)))
    noise = rng.standard_normal((frames, count))
    direction = (two - one) / 1e-3
    statistic = {"two": (direction + noise) @ direction, "one": noise @ direction}
    limit = np.quantile(statistic["one"], 1 - chance)
    assert np.mean(statistic["two"] > limit) == pytest.approx(0.8, abs=0.02)
    assert apart < limen(finger, position, share, **options)
