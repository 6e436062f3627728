"""The angle on a side in noise: scatter against the stated std, where it is blind, and what is not believed."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

from ._side_angle import AMBIGUOUS, EXACT, OK, SKINS, UNEXPLAINED, integrals, row, slope, two_rows


@pytest.mark.parametrize(("skin", "half_width"), [("half plane", 0.4), ("half plane", 1.8), ("layer", 0.8)])
def test_slope_std_is_the_scatter(skin, half_width):
    """Of noise, and of errors of the centre and the half width."""
    rng, count = np.random.default_rng(1), 4000 if skin == "half plane" else 1000
    tip = row(skin=SKINS[skin], noise=2e-3)
    off, wider = 0.004 * rng.normal(size=count), 0.02 * rng.normal(size=count)
    frames = tip.read(ss.Hertz(np.ones(count), 0.3, 0.1, half_width=half_width), rng)
    for position_std, half_width_std in ((0.0, 0.0), (0.004, 0.0), (0.0, 0.02), (0.004, 0.02)):
        told = ss.side_angle(
            tip,
            frames,
            position=0.1 + (position_std > 0) * off,
            half_width=half_width + (half_width_std > 0) * wider,
            position_std=position_std,
            half_width_std=half_width_std,
            most_std=1.0,
        )
        assert (told.status == OK).mean() > 0.998
        scaled = (told.angle - 0.3) / told.std
        scaled = scaled[np.isfinite(scaled)]
        assert np.sqrt((scaled**2).mean()) == pytest.approx(1.0, abs=0.06)
        assert (np.abs(scaled) < 1.959964).mean() == pytest.approx(0.95, abs=0.015)


def test_std_from_a_slope_is_the_scatter():
    rng, count = np.random.default_rng(2), 20_000
    skin, touch = SKINS["soft"], ss.Strip(1.0, 0.4, half_width=0.5)
    stds = {"slope_std": 2e-3, "strain_std": 3e-3, "position_std": 2e-3, "half_width_std": 5e-3}
    off, wider = (stds[key] * rng.normal(size=count) for key in ("position_std", "half_width_std"))
    strain = skin.strain(touch, 1.0, off).xx
    rise = slope(lambda h: skin.strain(touch, 1.0, off + h).xx, 0.02)
    told = ss.estimate.side_angle_from_slope(
        rise + stds["slope_std"] * rng.normal(size=count),
        strain + stds["strain_std"] * rng.normal(size=count),
        skin,
        "strip",
        depth=1.0,
        half_width=0.5 + wider,
        **stds,
    )
    scaled = (told.angle - 0.4) / told.std
    assert (told.status == OK).all()
    assert scaled.std() == pytest.approx(1.0, abs=0.03)
    assert abs(scaled.mean()) < 0.05


@pytest.mark.parametrize("half_width", [0.4, 0.9, 1.8])
def test_gradient_std_is_the_scatter(half_width):
    rng, count = np.random.default_rng(3), 4000
    tip = two_rows(pitch=0.125, count=9, depths=(0.9, 1.1), noise=3e-4)
    frames = tip.read(ss.Hertz(np.ones(count), 0.3, 0.05, half_width=half_width), rng)
    still = ss.estimate.side_angle_from_gradients(
        tip, tip.read(ss.Hertz(1.0, 0.3, 0.05, half_width=half_width)), position=0.05
    )
    assert still.status == OK
    assert abs(still.angle - 0.3) <= still.truncation  # what differences cut off, and no more than is said
    assert still.truncation < np.deg2rad(0.6)
    for std in (0.0, 0.01):
        told = ss.estimate.side_angle_from_gradients(
            tip, frames, position=0.05 + std * rng.normal(size=count), position_std=std, most_std=1.0
        )
        assert (told.status == OK).all()
        assert (told.angle - still.angle).std() == pytest.approx(np.median(told.std), rel=0.06)


def test_changes_with_position_and_width_are_what_they_say():
    tip = row(noise=1e-6)
    reading = tip.read(ss.Hertz(1.0, 0.3, 0.1, half_width=0.7))
    given = {"position_std": 1.0, "half_width_std": 1.0, "most_std": np.inf}
    told = ss.side_angle(tip, reading, position=0.1, half_width=0.7, **given)
    h = 1e-5
    ends = ss.side_angle(tip, reading, position=[0.1 + h, 0.1 - h], half_width=0.7, **given).angle
    assert told.per_position == pytest.approx(np.diff(ends[::-1]).item() / (2 * h), rel=1e-4)
    assert np.rad2deg(told.per_position) * 0.01 == pytest.approx(-3.4, abs=0.2)
    ends = ss.side_angle(tip, reading, position=0.1, half_width=[0.7 + h, 0.7 - h], **given).angle
    assert told.per_half_width == pytest.approx(np.diff(ends[::-1]).item() / (2 * h), rel=1e-4)
    rows = two_rows(noise=1e-6)
    reading = rows.read(ss.Hertz(1.0, 0.3, 0.1, half_width=0.7))
    told = ss.estimate.side_angle_from_gradients(rows, reading, position=0.1, position_std=1.0, most_std=np.inf)
    ends = ss.estimate.side_angle_from_gradients(rows, reading, position=[0.1 + h, 0.1 - h], most_std=np.inf).angle
    assert told.per_position == pytest.approx(np.diff(ends[::-1]).item() / (2 * h), rel=1e-4)


def test_changes_from_a_slope_are_what_they_say():
    skin, touch, h = SKINS["soft"], ss.Strip(1.0, 0.5, half_width=0.5), 1e-4
    at = np.array([0.0, h, -h])
    measured = slope(lambda y: skin.strain(touch, 1.0, at + y).xx, 0.02), skin.strain(touch, 1.0, at).xx
    told = ss.estimate.side_angle_from_slope(*measured, skin, "strip", depth=1.0, half_width=0.5, **EXACT)
    assert told.per_position[0] == pytest.approx((told.angle[1] - told.angle[2]) / (2 * h), rel=1e-4)
    widths = 0.5 + at
    there = measured[0][0], measured[1][0]
    told = ss.estimate.side_angle_from_slope(*there, skin, "strip", depth=1.0, half_width=widths, **EXACT)
    assert told.per_half_width[0] == pytest.approx((told.angle[1] - told.angle[2]) / (2 * h), rel=1e-4)


def test_at_the_blind_depth_nothing_is_told():
    skin = SKINS["half plane"]
    blind = float(ss.estimate.blind_depth(skin, 1.0))
    told = ss.estimate.side_angle_from_slope(1e-9, -0.4, skin, depth=blind, half_width=1.0, **EXACT)
    assert told.status == AMBIGUOUS
    assert np.isnan(told.angle)
    assert told.std == np.inf
    # in proportion to the distance from it, the slope is worth more and more; the bound decides
    x = blind * (1 + np.array([-0.3, -0.2, -0.03, -0.01, 0.01, 0.03, 0.2, 0.3]))
    touch = ss.Hertz(1.0, 0.3, half_width=1.0)
    strain = skin.strain(touch, x, 0.0).xx
    rise = slope(lambda y: skin.strain(touch, x, y).xx, 0.02)
    told = ss.estimate.side_angle_from_slope(
        rise, strain, skin, depth=x, half_width=1.0, slope_std=5e-3, strain_std=0.0
    )
    per_drag = [integrals("hertz", d, 0.5, "strain")[1] for d in x]
    assert told.std == pytest.approx(np.cos(0.3) * 5e-3 / np.abs(per_drag), rel=1e-6)
    accepted = told.std / np.cos(0.3) ** 2 <= np.deg2rad(10)
    assert accepted.tolist() == [True, True, False, False, False, False, True, True]
    assert (told.status == np.where(accepted, OK, AMBIGUOUS)).all()
    assert told.angle[told.status == OK] == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize("rule", ["slope", "gradient"])
def test_no_plausible_angle_near_the_blind_depth(rule):
    """Sweep the half width through it: what is given is right within its std, and near it nothing is given."""
    rng, widths = np.random.default_rng(4), np.repeat(np.linspace(0.6, 2.0, 57), 200)
    touch = ss.Hertz(np.ones(widths.size), 0.4, 0.07, half_width=widths)
    if rule == "slope":
        tip = row(9)
        told = ss.side_angle(tip, tip.read(touch, rng), position=0.07, half_width=widths)
        blind, allowed = 1 / 0.786, 0.0
    else:
        tip = two_rows()
        told = ss.estimate.side_angle_from_gradients(tip, tip.read(touch, rng), position=0.07)
        blind, allowed = 0.875 / 0.786, told.truncation
    given = told.status == OK
    assert (np.abs(told.angle - 0.4) < 5.5 * told.std + allowed)[given].all()
    assert np.isnan(told.angle[~given]).all()
    share = given.reshape(57, 200).mean(axis=1)
    off = np.abs(widths[::200] / blind - 1)
    assert share.min() == 0
    assert off[share == 0].max() < 0.05
    assert (share[off > 0.12] == 1).all()
    assert (told.status[~given] == AMBIGUOUS).mean() > 0.99


def test_readings_of_something_else_are_unexplained():
    tip = row(noise=1e-3)
    told = ss.side_angle(tip, tip.read(ss.Hertz(1.0, 0.3, 0.1, half_width=1.4)), position=0.1, half_width=0.6)
    assert told.status == UNEXPLAINED
    told = ss.side_angle(tip, tip.read(ss.Hertz(1.0, 0.3, 0.4, half_width=0.6)), position=0.1, half_width=0.6)
    assert told.status == UNEXPLAINED
    two = ss.LineLoad(1.0, 0.0, -0.9) + ss.LineLoad(1.0, 0.3, 0.9)
    assert ss.side_angle(tip, tip.read(two), "line", position=0.0).status == UNEXPLAINED
    for steep in (1.2, -1.2, 2.5):  # beyond the cone of friction 1, and pulling
        reading = tip.read(ss.Hertz(1.0, steep, 0.1, half_width=0.6))
        assert ss.side_angle(tip, reading, position=0.1, half_width=0.6).status == UNEXPLAINED
        rows = two_rows(noise=1e-3)
        reading = rows.read(ss.Hertz(1.0, steep, 0.1, half_width=0.6))
        assert ss.estimate.side_angle_from_gradients(rows, reading, position=0.1).status == UNEXPLAINED
    pulled = rows.read(ss.Hertz(1.0, np.pi - 0.3, 0.1, half_width=0.6))
    assert ss.estimate.side_angle_from_gradients(rows, pulled, position=0.1).status == UNEXPLAINED


@pytest.mark.parametrize(("half_width", "mu", "degrees"), [(0.5, 0.5, 14.8), (1.0, 0.5, -4.3)])
def test_a_contact_that_sticks_misleads(half_width, mu, degrees):
    """Its drag is mu times the pressure, less the same within the zone that sticks: another slope per drag."""
    stuck = 1 - np.tan(0.3) / mu  # (c/a)^2
    touch = ss.PartialSlip(1.0, 0.3, half_width=half_width, friction=mu)
    assert float(touch.stick_half_width) == pytest.approx(half_width * np.sqrt(stuck))

    def per_drag(a):
        return integrals("hertz", 1 / a, 0.5, "strain")[1] / a**2

    c = half_width * np.sqrt(stuck)
    sticking = (per_drag(half_width) - stuck * per_drag(c)) / (1 - stuck)
    expected = np.arctan(np.tan(0.3) * sticking / per_drag(half_width))
    skin = SKINS["half plane"]
    rise = slope(lambda y: skin.strain(touch, 1.0, y).xx, 0.02)
    told = ss.estimate.side_angle_from_slope(
        rise, skin.strain(touch, 1.0, 0.0).xx, skin, depth=1.0, half_width=half_width, **EXACT
    )
    assert told.angle == pytest.approx(expected, abs=1e-6)
    tip = row(noise=1e-2)  # where the noise hides that the readings do not fit
    told = ss.side_angle(tip, tip.read(touch), position=0.0, half_width=half_width)
    assert told.status == OK
    assert np.rad2deg(told.angle) == pytest.approx(degrees, abs=0.1)
    pair = two_rows(depths=(0.9, 1.1))
    told = ss.estimate.side_angle_from_gradients(pair, pair.read(touch), position=0.0)
    assert told.status == OK
    assert abs(np.rad2deg(told.angle) - 17.2) > 4
    close = row(noise=1e-4)
    assert ss.side_angle(close, close.read(touch), position=0.0, half_width=half_width).status == UNEXPLAINED


def test_beside_the_full_fit():
    """What is told of place and width is worth most where the row is short; a long row needs no telling."""
    touch = ss.Hertz(1.0, 0.3, 0.1, half_width=0.5)
    ratios = []
    for count in (5, 9):
        tip = row(count, noise=1e-3)
        fit = tip.fit(tip.read(touch))
        told = ss.side_angle(tip, tip.read(touch), position=0.1, half_width=0.5)
        assert fit.angle == pytest.approx(0.3, abs=1e-3)
        ratios.append(float(told.std / fit.std[2]))
    assert ratios[0] < 0.6
    assert ratios[1] > 1.5
