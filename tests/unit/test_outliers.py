"""A wild reading is left out where the rest shows which it is, and is said to be one of several where not."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

SKINS = {
    "half plane": ss.HalfPlane(ss.Material(young=0.4e6)),
    "layer": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 4e-3)),
    "round": ss.Round(ss.Material(0.4e6), 8e-3, 4e-3),
}
NOISE = 2e-4


def finger(count=8, skin="half plane", **more):
    return ss.Finger(SKINS[skin], ss.SensorArray.line(count, pitch=1.5e-3, depth=2e-3, **{"noise": NOISE, **more}))


def touches(count, reach, seed=0):
    rng = np.random.default_rng(seed)
    return ss.LineLoad(rng.uniform(30, 50, count), rng.uniform(-0.6, 0.6, count), rng.uniform(-reach, reach, count))


def spoilt(tip, load, seed=1, least=0.1):
    """Readings with one of each frame's off by 10 to 100 % of the full scale, and which."""
    rng = np.random.default_rng(seed)
    readings = tip.read(load, rng)
    frames, count = readings.shape
    which = rng.integers(0, count, frames)
    size = rng.choice([-1, 1], frames) * rng.uniform(least, 1, frames) * np.ptp(readings)
    readings[np.arange(frames), which] += size
    return readings, which


@pytest.mark.parametrize("skin", SKINS)
def test_the_wild_reading_is_left_out_and_the_load_found(skin):
    tip, load = finger(skin=skin), touches(2000, 4e-3)
    readings, which = spoilt(tip, load)
    without, found = (tip.locate(readings, load="line", outliers=n) for n in (0, 1))
    assert (without.status == ss.Status.UNEXPLAINED).mean() > 0.85
    again = (without.status == ss.Status.UNEXPLAINED) & (found.status == ss.Status.OK)
    assert again.mean() > 0.8
    assert ((~found.used).sum(axis=1)[again] == 1).all()
    right = ~found.used[np.arange(2000), which]
    assert right[again].mean() > 0.999
    # and then it is the estimate that the others alone give
    holed = readings.copy()
    holed[np.arange(2000), which] = np.nan
    alone = tip.locate(holed, load="line")
    np.testing.assert_array_equal(found.table[again & right], alone.table[again & right])
    score = ((found.position - load.position) / found.std[:, 0])[again & right]
    assert 0.9 < score.std() < 1.1


def test_frames_that_are_explained_are_not_touched():
    tip = finger()
    readings = tip.read(touches(500, 5e-3), np.random.default_rng(0))
    readings[:100] = NOISE * np.random.default_rng(1).standard_normal((100, 8))
    readings[100:150, 3] = np.nan
    a, b = tip.locate(readings), tip.locate(readings, outliers=1)
    assert (a.status != ss.Status.UNEXPLAINED).all()
    np.testing.assert_array_equal(a.table, b.table)
    np.testing.assert_array_equal(a.used, b.used)


def test_the_best_omission_by_brute_force():
    """Every statement about a frame follows from the chi-squares of its omissions, each located by itself."""
    from scipy.stats import chi2

    tip = finger(6)
    readings, _ = spoilt(tip, touches(300, 3.5e-3), least=0.02)
    found, before = tip.locate(readings, outliers=1), tip.locate(readings)
    kinds = set()
    for k in np.flatnonzero(before.status == ss.Status.UNEXPLAINED):
        holes = np.where(np.eye(6, dtype=bool), np.nan, readings[k])
        each = tip.locate(holes)
        order = np.argsort(each.residual)
        one, two = order[:2]
        ahead = each.residual[two] - each.residual[one]
        kinds.add(int(found.status[k]))
        if found.status[k] == ss.Status.UNEXPLAINED:
            told = each.residual[one] <= chi2.isf(1e-3, 2) and each.status[one] != ss.Status.UNEXPLAINED
            # a touch with one reading lost, or none with one wild: that is no load to give
            assert not told or (ahead < 13.8 and np.isnan(each.position[one] + each.position[two]))
            assert found.used[k].all()
            assert np.isnan(found.position[k])
            continue
        assert np.flatnonzero(~found.used[k]).tolist() == [one]
        assert found.residual[k] == each.residual[one] <= chi2.isf(1e-3, 2)
        assert found.position[k] == each.position[one]
        if found.status[k] == ss.Status.OK:
            assert ahead >= 13.8
        elif each.status[one] == ss.Status.OK:
            assert ahead < 13.8
            assert found.second.chi2[k] == min(ahead, each.second.chi2[one])
    assert kinds == {ss.Status.OK, ss.Status.AMBIGUOUS, ss.Status.UNEXPLAINED}


def test_a_touch_with_a_wild_reading_is_refused_as_rarely_as_noise_would_have_it():
    """The rest of a frame leaves more than one in a thousand of such frames do: then nothing is left out."""
    tip, load = finger(6), touches(20_000, 3e-3)
    readings = tip.read(load, np.random.default_rng(2))
    readings[:, 3] += 1.0  # so wild that no other omission comes near
    refused = (tip.locate(readings, outliers=1).status == ss.Status.UNEXPLAINED).sum()
    assert abs(refused - 20) < 4 * np.sqrt(20)


def test_a_wild_reading_of_free_skin_is_no_contact():
    tip = finger()
    readings = NOISE * np.random.default_rng(0).standard_normal((500, 8))
    readings[np.arange(500), np.arange(500) % 8] += 0.03
    without, found = tip.locate(readings), tip.locate(readings, outliers=1)
    assert (without.status == ss.Status.UNEXPLAINED).mean() > 0.9
    assert (found.status == ss.Status.NO_CONTACT).mean() > 0.9
    assert np.isnan(found.position[found.status == ss.Status.NO_CONTACT]).all()


@pytest.mark.parametrize(("count", "friction"), [(4, 1.0), (3, 0.0)])
def test_without_a_reading_to_spare_nothing_is_left_out(count, friction):
    tip = finger(count)
    readings, _ = spoilt(tip, touches(300, 2e-3))
    a, b = tip.locate(readings, friction=friction), tip.locate(readings, friction=friction, outliers=1)
    np.testing.assert_array_equal(a.table, b.table)
    assert b.used.all()


@pytest.mark.parametrize(("count", "friction"), [(5, 1.0), (4, 0.0)])
def test_with_one_to_spare_it_is(count, friction):
    tip = finger(count)
    angle = 0.3 * friction
    load = ss.LineLoad(40.0, angle, np.linspace(-2.5e-3, 2.5e-3, 300))
    readings, which = spoilt(tip, load)
    found = tip.locate(readings, friction=friction, outliers=1)
    sure = (found.status == ss.Status.OK) & ~found.used.all(axis=1)
    assert sure.mean() > 0.3
    assert (~found.used[np.arange(300), which])[sure].mean() > 0.98


def test_a_reading_that_is_missing_is_missing_still():
    tip, load = finger(), touches(400, 4e-3)
    readings, which = spoilt(tip, load)
    lost = (which + 3) % 8
    readings[np.arange(400), lost] = np.nan
    found = tip.locate(readings, outliers=1)
    sure = (found.status == ss.Status.OK) & ((~found.used).sum(axis=1) == 2)
    assert sure.mean() > 0.7
    assert (~found.used[np.arange(400), lost]).all()
    assert (~found.used[np.arange(400), which])[sure].mean() > 0.995


def test_a_single_frame_is_as_one_of_many():
    tip = finger()
    readings, _ = spoilt(tip, touches(60, 4e-3))
    many = tip.locate(readings, outliers=1)
    shaped = tip.locate(readings.reshape(3, 20, 8), outliers=1)
    np.testing.assert_array_equal(shaped.table.reshape(60, -1), many.table)
    np.testing.assert_array_equal(shaped.used.reshape(60, 8), many.used)
    for k, frame in enumerate(readings):
        one = tip.locate(frame, outliers=1)
        np.testing.assert_array_equal(one.table, many.table[k])
        np.testing.assert_array_equal(one.used, many.used[k])
    with pytest.raises(ValueError, match="read-only"):
        many.used[0, 0] = False


def test_two_touches_are_rarely_taken_for_one_and_a_wild_reading():
    """Rarely: where two readings are left to speak against it. With one to spare, one such frame in ten."""
    rng = np.random.default_rng(0)
    m, shares = 2000, {}
    for count in (5, 8):
        reach = 0.75e-3 * (count - 1)
        near = rng.uniform(-reach, reach - 3e-3, m)
        tip = finger(count)
        both = tip.read(ss.LineLoad(40.0, rng.uniform(-0.5, 0.5, m), near), rng)
        both += tip.read(ss.LineLoad(40.0, rng.uniform(-0.5, 0.5, m), near + 3e-3))
        for outliers in (0, 1):
            shares[count, outliers] = (tip.locate(both, outliers=outliers).status == ss.Status.OK).mean()
    assert shares[5, 1] - shares[5, 0] < 0.25
    assert shares[8, 1] - shares[8, 0] < 0.03


def test_a_fit_leaves_out_a_reading_too():
    tip = finger(8)
    rng = np.random.default_rng(0)
    load = ss.Hertz(40.0, rng.uniform(-0.4, 0.4, 150), rng.uniform(-3e-3, 3e-3, 150), half_width=1.5e-3)
    readings, which = spoilt(tip, load)
    without, found = tip.fit(readings, "hertz"), tip.fit(readings, "hertz", outliers=1)
    sure = (without.status == ss.Status.UNEXPLAINED) & (found.status == ss.Status.OK)
    assert sure.mean() > 0.5
    assert (~found.used[np.arange(150), which])[sure].mean() > 0.99
    assert (found.spare[sure] == 3).all()
    low, high = np.moveaxis(found.half_width_interval, -1, 0)
    inside = (low <= 1.5e-3) & (high >= 1.5e-3)
    assert 0.85 < inside[sure & ~found.used[np.arange(150), which]].mean() < 1.0
    rival = found.second
    tied = (found.status == ss.Status.AMBIGUOUS) & (rival.chi2 < 13.8)
    assert np.isfinite(rival.half_width[tied]).all()


def test_a_fit_of_five_sensors_has_none_to_spare():
    tip = finger(5)
    readings = tip.read(ss.Hertz(40.0, 0.1, 0.0, half_width=1.5e-3))
    readings[2] += 0.01
    found = tip.fit(readings, "hertz", outliers=1)
    assert found.used.all()


@pytest.mark.parametrize("value", [2, -1, 0.5, True, "1"])
def test_none_or_one(value):
    with pytest.raises(ss.errors.InvalidValueError, match="outliers"):
        finger().locate(np.zeros(8), outliers=value)
