"""Two points or one: metamers and least separations against closed forms and brute force; scaling; bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import ncx2, norm

import subskin as ss
from subskin.design import Touches, metamers, two_point_limen, two_point_study
from subskin.errors import GeometryError, InvalidValueError

UNIT = ss.HalfPlane(ss.Material(young=1.5 / np.pi))  # strain right beneath a unit point at unit depth is -1
ROUND = ss.Round(ss.Material(young=0.4e6), radius=8e-3, core_radius=4e-3)
LAYER = ss.Layered(ss.Layer(ss.Material(young=0.4e6, poisson=0.49), thickness=4e-3))


def row(count, pitch=0.5, noise=1e-3, skin=UNIT, depth=1.0, **more):
    return ss.Finger(skin, ss.SensorArray.line(count, pitch * depth, depth, noise=noise, **more))


def response(offset):
    """Compression beneath a unit point, closed form (memo eq. 8)."""
    return (1 - offset**2) / (1 + offset**2) ** 2


# metamers


def test_two_equal_points_read_as_one_in_their_middle():
    same = metamers(row(2, 1.0), [-0.5, 0.5], [1.0, 1.0])
    assert same.position.tolist() == pytest.approx([0.0], abs=1e-12)
    # above its sensor a point reads 1, above the other 0; in the middle each reads response(0.5)
    assert same.force.tolist() == pytest.approx([1 / response(0.5)], rel=1e-8)


@pytest.mark.parametrize("skin", [UNIT, ROUND, LAYER], ids=["half plane", "round", "layer"])
@pytest.mark.parametrize("kind", [ss.NormalStrain(), ss.NormalStress(), ss.LateralStrain()])
@pytest.mark.parametrize("angle", [0.0, 0.4])
def test_a_metamer_reads_the_same(skin, kind, angle):
    depth = 1.0 if skin is UNIT else 1.5e-3
    finger = row(2, 0.9, skin=skin, depth=depth, transducer=kind)
    rng = np.random.default_rng(0)
    position, force = depth * rng.uniform(-1, 1, (40, 2)), rng.uniform(0.5, 2, (40, 2))
    same = metamers(finger, position, force, angle=angle)
    two = ss.LineLoad(force[:, 0], angle, position[:, 0]) + ss.LineLoad(force[:, 1], angle, position[:, 1])
    assert same.reading == pytest.approx(finger.measure(two), rel=1e-12)
    assert same.exist.sum() > 20
    for k in range(same.position.shape[1]):
        some = np.isfinite(same.position[:, k])
        one = ss.LineLoad(same.force[some, k], angle, same.position[some, k])
        size = np.abs(same.reading[some]).max(axis=1, keepdims=True)
        assert finger.measure(one) / size == pytest.approx(same.reading[some] / size, abs=1e-6)


def test_there_is_a_metamer_exactly_where_the_ratio_of_the_readings_occurs():
    finger = row(2, 1.0)
    position = np.random.default_rng(1).uniform(-2.5, 2.5, (500, 2))
    near = metamers(finger, position, search=(-0.8, 1.1))
    assert np.array_equal(near.exist, near.in_reach)
    assert 50 < near.exist.sum() < 450
    angles = [np.arctan2(-response(y - 0.5), -response(y + 0.5)) % (2 * np.pi) for y in (1.1, -0.8)]
    assert np.sort(np.mod(near.reach, 2 * np.pi)) == pytest.approx(np.sort(angles), abs=1e-7)


def test_two_sensors_nearer_than_two_depths_always_have_a_metamer():
    """Midway both read compression, far off both extension: the curve of one point goes once around the origin."""
    position = np.random.default_rng(2).uniform(-2, 2, (300, 2))
    for pitch in (0.3, 1.0, 1.9):
        assert metamers(row(2, pitch), position, search=(-30, 30)).exist.all()
    apart = metamers(row(2, 2.5), position, search=(-30, 30))
    both = (apart.reading < 0).all(axis=1)
    assert both.sum() > 5
    assert not apart.exist[both].any()  # no one point presses on both


def test_every_metamer_is_found():
    """As many as the sign of r1 v2 - r2 v1, on a grid of the closed form, changes where the force presses."""
    position = np.random.default_rng(3).uniform(-2, 2, (200, 2))
    same = metamers(row(2, 1.0), position, search=(-4.0, 4.0))
    y = np.linspace(-4, 4, 100_001)
    v = -np.stack([response(y + 0.5), response(y - 0.5)])
    for reading, found in zip(same.reading, same.position, strict=True):
        across, along = reading[0] * v[1] - reading[1] * v[0], reading @ v
        at = np.flatnonzero((across[1:] * across[:-1] < 0) & (along[1:] > 0))
        assert y[at] == pytest.approx(found[np.isfinite(found)], abs=2e-4)


def test_bad_metamers():
    with pytest.raises(GeometryError, match="3 live sensors"):
        metamers(row(3), [-0.5, 0.5])
    with pytest.raises(InvalidValueError, match="force"):
        metamers(row(2), [-0.5, 0.5], [1.0, -1.0])
    with pytest.raises(GeometryError, match="without force"):
        metamers(row(2), [[-0.5, 0.5]], 0.0)
    with pytest.raises(GeometryError, match="has to press"):
        metamers(row(2), [-0.5, 0.5], angle=2.0)
    with pytest.raises(GeometryError, match="broadcast"):
        metamers(row(2), [-0.5, 0.5], [1.0, 1.0, 1.0])
    one_dead = row(3, gain=[1.0, 0.0, 1.0])
    assert metamers(one_dead, [-0.2, 0.2]).exist.all()


# the least separation


def nearest(readings, columns, starts):
    """Brute force: the least distance to N columns(u), N >= 0, over u, from a grid and then by Nelder and Mead."""

    def residual(u):
        a = columns(u)
        n = max(a @ readings / (a @ a), 0.0)
        return float(np.linalg.norm(readings - n * a))

    best = sorted(starts, key=residual)[:4]
    options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000}
    return min(minimize(residual, u, method="Nelder-Mead", options=options).fun for u in best)


@pytest.mark.parametrize("count", [3, 5])
def test_distance_to_one_point_is_that_of_brute_force(count):
    finger = row(count, 0.6)
    found = two_point_limen(finger, Touches(1.0, span=(-0.9, 0.9)), positions=4, shares=[0.35, 0.5])
    s = np.asarray(finger.array.y)
    for i, p, q in ((20, 0, 0), (30, 1, 1), (40, 2, 0), (len(found.step) - 1, 3, 0)):
        low, high = (found.position[p] + sign * found.step[i] / 2 for sign in (-1, 1))
        share = found.share[q]
        two = (share * response(low - s) + (1 - share) * response(high - s)) / 1e-3
        starts = [[u] for u in np.linspace(-2.5, 2.5, 200)]
        wanted = nearest(two, lambda u: response(u[0] - s) / 1e-3, starts)
        assert found.distance[i, p, q, 0] == pytest.approx(wanted, rel=1e-5, abs=1e-4)


def test_distance_to_a_wide_contact_is_that_of_brute_force():
    finger = row(5, 0.6)
    found = two_point_limen(
        finger, Touches(1.0, span=(-0.9, 0.9)), against="wide", positions=3, shares=[0.35], largest=1.5
    )
    s = np.asarray(finger.array.y)
    grid = [[y, a] for y in np.linspace(-1.2, 1.2, 13) for a in (0.05, 0.4, 0.8, 1.2)]
    for i, p in ((12, 0), (20, 1), (len(found.step) - 1, 2)):
        low, high = (found.position[p] + sign * found.step[i] / 2 for sign in (-1, 1))
        two = (0.35 * response(low - s) + 0.65 * response(high - s)) / 1e-3

        def columns(u):
            hertz = ss.Hertz(1.0, 0.0, u[0], half_width=np.clip(abs(u[1]), 1e-6, 1.875))
            return -UNIT.strain(hertz, x=1.0, y=s).xx / 1e-3

        wanted = nearest(two, columns, grid)
        assert found.distance[i, p, 0, 0] == pytest.approx(wanted, rel=1e-3, abs=2e-3)


def test_needed_is_what_the_power_asks_for():
    finger, touches = row(6), Touches(1.0)
    for against, degrees in (("point", 4), ("wide", 3)):
        fit = two_point_limen(finger, touches, against=against, positions=1, shares=0.5, power=0.8)
        assert ncx2.sf(ncx2.isf(0.01, degrees, 1e-12), degrees, fit.needed**2) == pytest.approx(0.8, abs=1e-6)
    free = two_point_limen(finger, touches, angle="free", positions=1, shares=0.5, angles=1)
    assert ncx2.sf(ncx2.isf(0.01, 3, 1e-12), 3, free.needed**2) == pytest.approx(0.9, abs=1e-6)
    best = two_point_limen(finger, touches, positions=1, shares=0.5, test="best", false_alarm=0.05)
    assert best.needed == pytest.approx(norm.isf(0.05) + norm.ppf(0.9), rel=1e-12)


def test_a_separation_is_where_the_distance_is_what_is_needed():
    finger, touches = row(5, 0.6), Touches(1.0, span=(-1.0, 1.0))
    found = two_point_limen(finger, touches, positions=5, shares=[0.4, 0.5])
    s = np.asarray(finger.array.y)
    for p, q in np.ndindex(5, 2):
        half, share = found.separation[p, q, 0] / 2, found.share[q]
        middle = found.position[p]
        two = share * response(middle - half - s) + (1 - share) * response(middle + half - s)
        starts = [[u] for u in middle + np.linspace(-0.3, 0.3, 61)]
        assert nearest(two / 1e-3, lambda u: response(u[0] - s) / 1e-3, starts) == pytest.approx(found.needed, rel=2e-3)


def test_a_larger_separation_that_is_lost_again_counts():
    """Three sensors, at a place where points told at half a depth are one point's again at about a depth."""
    finger = row(3, 0.5, noise=1e-4)
    touches = Touches(1.0, span=(0.66, 0.68))
    found = two_point_limen(finger, touches, positions=1, shares=0.5)
    short = found.distance[:, 0, 0, 0] < found.needed
    first = found.step[np.flatnonzero(~short)[0]]
    assert first < 0.35
    assert found.separation[0, 0, 0] > 0.9
    # and it is found where it falls between two steps as well
    steps = two_point_limen(finger, touches, positions=1, shares=0.5, largest=2.1).separation[0, 0, 0]
    assert steps == pytest.approx(found.separation[0, 0, 0], rel=2e-3)


@pytest.mark.parametrize("against", ["point", "wide"])
def test_lengths_go_with_the_depth_and_nothing_with_the_modulus(against):
    """Twice the depth at twice the force: the same strains, and the same in depths; memo: E has no effect."""
    small = two_point_limen(row(5, 0.6), Touches(1.0), against=against, positions=4)
    stiff = ss.HalfPlane(ss.Material(young=30e6))
    share = 1.5 / np.pi * 100.0 / (30e6 * 2e-3)  # of the strain beneath 100 N/m at 2 mm
    large = two_point_limen(row(5, 0.6, 1e-3 * share, stiff, 2e-3), Touches(100.0), against=against, positions=4)
    assert large.separation / 2e-3 == pytest.approx(small.separation, rel=1e-4)


def test_noise_scales_as_if_it_had_been_given():
    finger = row(4, 0.7)
    touches = Touches(1.0)
    scaled = two_point_limen(finger, touches, positions=5).with_noise(0.5).with_noise(6.0)
    noisy = replace(finger, array=replace(finger.array, noise=3e-3))
    given = two_point_limen(noisy, touches, positions=5)
    assert scaled.separation == pytest.approx(given.separation, rel=1e-6)
    assert scaled.distance == pytest.approx(given.distance, rel=1e-4, abs=1e-3)
    assert np.asarray(scaled.finger.array.noise).tolist() == pytest.approx([3e-3] * 4)
    with pytest.raises(InvalidValueError, match="factor"):
        scaled.with_noise(0.0)


def test_gain_offset_range_and_dead_sensors_change_nothing():
    plain = two_point_limen(row(4), Touches(1.0, span=(-1, 1)), positions=5)
    gained = row(4, noise=2e-3, gain=-2.0, offset=0.3, low=-0.1, high=0.4)
    assert two_point_limen(gained, Touches(1.0, span=(-1, 1)), positions=5).separation == pytest.approx(
        plain.separation, rel=1e-6
    )
    y = [*np.asarray(row(4).array.y), 0.1]
    dead = ss.Finger(UNIT, ss.SensorArray(y, 1.0, gain=[1, 1, 1, 1, 0], noise=[1e-3] * 4 + [0.0]))
    assert two_point_limen(dead, Touches(1.0, span=(-1, 1)), positions=5).separation == pytest.approx(
        plain.separation, rel=1e-6
    )


@pytest.mark.parametrize(
    ("count", "against", "angle", "told"),
    [
        (1, "point", "normal", False),
        (2, "point", "free", False),
        (3, "wide", "free", False),
        (3, "point", "normal", True),
        (4, "point", "free", True),
        (5, "wide", "free", True),
    ],
)
def test_fewer_sensors_than_unknowns_tell_nothing(count, against, angle, told):
    found = two_point_limen(
        row(count), Touches(1.0, span=(-0.1, 0.1)), against=against, angle=angle, positions=2, angles=2
    )
    assert np.isfinite(found.separation).any() == told
    assert np.isinf(found.worst) or told


def test_known_angles_are_those_of_the_loads():
    """Loads at a known angle are told from one at that angle: the field along it, by brute force."""
    finger, touches = row(4, 0.7), Touches(1.0, friction=0.8, span=(-0.8, 0.8))
    found = two_point_limen(finger, touches, angle="known", positions=3, shares=[0.4], angles=3)
    assert np.array_equal(found.lean[:, 0], found.lean[:, 1])
    assert found.lean[:, 0] == pytest.approx(np.arctan(0.8) * np.array([-1, 0, 1]))
    s = np.asarray(finger.array.y)
    for p, k in ((0, 0), (1, 2), (2, 2)):
        angle, i = found.lean[k, 0], 35

        def along(y, angle=angle):
            return response(y - s) * (np.cos(angle) - np.sin(angle) * (y - s)) / 1e-3

        low, high = (found.position[p] + sign * found.step[i] / 2 for sign in (-1, 1))
        wanted = nearest(
            0.4 * along(low) + 0.6 * along(high), lambda u: along(u[0]), [[u] for u in np.linspace(-2, 2, 200)]
        )
        assert found.distance[i, p, 0, k] == pytest.approx(wanted, rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("skin", [ROUND, LAYER], ids=["round", "layer"])
@pytest.mark.parametrize("kind", [ss.NormalStrain(), ss.VolumeResistance()])
def test_any_skin_and_transducer(skin, kind):
    finger = row(5, 0.6, 1e-4, skin, 1.5e-3, transducer=kind, width=0.3e-3)
    found = two_point_limen(finger, Touches(20.0), positions=5, shares=0.5)
    assert found.median < 1.5e-3


def test_a_ring_of_sensors_has_no_seam():
    skin = ss.Round(ss.Material(young=0.4e6), radius=3e-3, core_radius=1e-3)
    array = ss.SensorArray.line(12, skin.period / 12, 1e-3, noise=1e-4)
    round_about = Touches(20.0, span=(-0.5 * skin.period, 0.5 * skin.period))
    found = two_point_limen(ss.Finger(skin, array), round_about, positions=24, shares=0.5)
    assert found.worst < 1e-3
    assert found.separation[:, 0, 0] == pytest.approx(np.full(24, found.worst), rel=1e-3)
    apart = found.distance[:, :, 0, 0]
    assert apart[-10:] == pytest.approx(np.broadcast_to(apart[-10:, 11:12], (10, 24)), rel=1e-3)


def test_result_is_closed_to_writing_and_says_itself():
    found = two_point_limen(row(5), Touches(1.0), positions=3)
    for name in ("position", "share", "lean", "step", "distance", "separation"):
        assert not getattr(found, name).flags.writeable, name
    assert found.separation.shape == (3, 5, 1)
    assert found.distance.shape == (found.step.size, 3, 5, 1)
    assert found.worst == found.separation.max()
    assert "read as two from" in found.summary()
    blind = two_point_limen(row(1), Touches(1.0, span=(-1, 1)), positions=3)
    assert "read as one within 2e+03 mm in 100% of touches" in blind.summary()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"against": "two"}, "against"),
        ({"angle": "any"}, "angle"),
        ({"test": "t"}, "test"),
        ({"power": 1.0}, "power"),
        ({"power": 0.005}, "power"),
        ({"false_alarm": 0.0}, "false_alarm"),
        ({"positions": 0}, "positions"),
        ({"angles": 1.5}, "angles"),
        ({"shares": [0.0]}, "shares"),
        ({"shares": [1.0]}, "shares"),
        ({"shares": [[0.5]]}, "shares"),
        ({"largest": 0.0}, "largest"),
    ],
)
def test_bad_options(options, match):
    with pytest.raises((GeometryError, InvalidValueError), match=match):
        two_point_limen(row(4), Touches(1.0), **options)


def test_sensors_without_noise_are_refused():
    with pytest.raises(InvalidValueError, match="noise"):
        two_point_limen(row(4, noise=0.0), Touches(1.0))


# the study


def test_a_study_is_the_limen_of_each_row():
    finger = row(2, width=0.2, gain=-3.0)
    touches = Touches(2.0, span=(-1.0, 1.0))
    options = {"positions": 5, "shares": [0.4, 0.5], "power": 0.8}
    calls = []
    study = two_point_study(
        finger,
        touches,
        count=[4, 6],
        pitch=[0.5, 1.0],
        depth=[1.0, 1.3],
        noise=[1e-3, 4e-3],
        progress=lambda: calls.append(1),
        **options,
    )
    assert study.worst.shape == study.median.shape == (2, 2, 2, 2)
    assert len(calls) == 8
    # full scale: what one such sensor, 0.2 wide, reads at most, right beneath the whole force
    full = 2.0 * abs(float(row(1, width=0.2, gain=-3.0, depth=1.3).receptive_field(0.0)[0, 0]))
    array = ss.SensorArray.line(6, 1.3, 1.3, width=0.2, gain=-3.0, noise=4e-3 * full)
    one = two_point_limen(ss.Finger(UNIT, array), touches, **options)
    assert study.worst[1, 1, 1, 1] == pytest.approx(one.worst, rel=1e-5)
    assert study.median[1, 1, 1, 1] == pytest.approx(one.median, rel=1e-5)


def test_best_is_the_least_and_its_neighbours_without_a_gap():
    study = two_point_study(row(2), Touches(1.0, span=(-1, 1)), count=5, pitch=[0.5, 1.0], positions=2)
    worst = np.array([3.0, 1.2, 1.0, 1.24, np.inf, 1.1]).reshape(1, 1, 6, 1)
    made = replace(study, pitch=np.arange(1.0, 7.0), worst=worst, noise=np.ones(1))
    assert made.best()[0, 0, 0].tolist() == [3.0, 2.0, 4.0]
    assert made.best(0.1)[0, 0, 0].tolist() == [3.0, 3.0, 3.0]
    never = replace(made, worst=np.full_like(worst, np.inf))
    assert np.isnan(never.best()).all()


@pytest.mark.parametrize(
    ("options", "match"),
    [({"count": 1}, "count"), ({"count": 2.5}, "count"), ({"pitch": [1.0, 0.5]}, "pitch"), ({"noise": 0}, "noise")],
)
def test_bad_studies(options, match):
    with pytest.raises(InvalidValueError, match=match):
        two_point_study(row(2), Touches(1.0, span=(-1, 1)), **options)
