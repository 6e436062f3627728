"""Angles on a side: what is refused at the door, what is said frame by frame, shapes."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest

import subskin as ss

SKIN = ss.HalfPlane(ss.Material(0.4e6))
STATUS = ss.Status


def row(**more):
    return ss.Finger(SKIN, ss.SensorArray.line(7, pitch=1e-3, depth=2e-3, **{"noise": 2e-5, **more}))


def rows(depths=(1.6e-3, 2e-3), skin=SKIN, **more):
    y = np.tile(0.5e-3 * np.arange(-3, 4), len(depths))
    return ss.Finger(skin, ss.SensorArray(y=y, depth=np.repeat(depths, 7), **{"noise": 2e-5, **more}))


def touch(shape=(), **more):
    force = np.full(shape, 40.0)
    return ss.Hertz(**{"force": force, "angle": 0.3, "position": 0.2e-3, "half_width": 1e-3, **more})


def told(finger, readings, **more):
    return ss.side_angle(finger, readings, **{"position": 0.2e-3, "half_width": 1e-3, **more})


def by_gradient(finger, readings, **more):
    return ss.estimate.side_angle_from_gradients(finger, readings, **{"position": 0.2e-3, **more})


def from_slope(slope=-2.0, strain=-0.01, skin=SKIN, *family, **more):
    given = {"depth": 2e-3, "half_width": 1e-3, "slope_std": 0.05, "strain_std": 1e-4, **more}
    return ss.estimate.side_angle_from_slope(slope, strain, skin, *family, **given)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: told(row(), np.zeros(6)), "last axis"),
        (lambda: told(row(), 0.0), "last axis"),
        (lambda: told(row(noise=0.0), np.zeros(7)), "noise"),
        (lambda: told(row(), np.zeros(7), half_width=None), "half width is known"),
        (lambda: told(row(), np.zeros(7), half_width=0.0), "half_width"),
        (lambda: told(row(), np.zeros(7), half_width=[1e-3, -1e-3]), "half_width"),
        (lambda: told(row(), np.zeros(7), half_width=np.inf), "half_width"),
        (lambda: told(row(), np.zeros(7), position=np.inf), "position"),
        (lambda: told(row(), np.zeros(7), position_std=-1e-6), "position_std"),
        (lambda: told(row(), np.zeros(7), half_width_std=-1e-6), "half_width_std"),
        (lambda: told(row(), np.zeros(7), family="line"), "it has none"),
        (lambda: told(row(), np.zeros(7), family="line", half_width=None, half_width_std=1e-4), "it has none"),
        (lambda: told(row(), np.zeros(7), family="sphere"), "family"),
        (lambda: told(row(), np.zeros(7), sensors=2), "sensors"),
        (lambda: told(row(), np.zeros(7), sensors=3.5), "sensors"),
        (lambda: told(row(), np.zeros(7), most_std=0.0), "most_std"),
        (lambda: told(row(), np.zeros(7), most_std=np.nan), "most_std"),
        (lambda: told(row(), np.zeros(7), friction=-1.0), "friction"),
        (lambda: told(row(), np.zeros(7), false_alarm=0.0), "false_alarm"),
        (lambda: told(row(), np.zeros((3, 7)), position=np.zeros(4)), "broadcast"),
        (lambda: told(row(), np.zeros((3, 7)), half_width=np.full(4, 1e-3)), "broadcast"),
        (lambda: told(row(gain=[1, 0, 0, 0, 0, 0, 1]), np.zeros(7)), "2 live sensors"),
        (lambda: told(row(transducer=[ss.NormalStrain()] * 6 + [ss.ShearStrain()]), np.zeros(7)), "kinds"),
        (lambda: told(row(transducer=ss.EnergyDensity()), np.zeros(7)), "linear"),
        (lambda: told(rows(), np.zeros(14)), "one row"),
        (lambda: by_gradient(row(), np.zeros(7)), "1 depths"),
        (lambda: by_gradient(rows((1e-3, 2e-3, 3e-3)), np.zeros(21)), "3 depths"),
        (lambda: by_gradient(rows(transducer=ss.ShearStrain()), np.zeros(14)), "ShearStrain"),
        (lambda: by_gradient(rows(skin=ss.Round(ss.Material(1.0), 8e-3, 4e-3)), np.zeros(14)), "half plane"),
        (lambda: by_gradient(rows(), np.zeros(13)), "last axis"),
        (lambda: by_gradient(rows(), np.zeros(14), position_std=-1.0), "position_std"),
        (lambda: from_slope(depth=0.0), "depth"),
        (lambda: from_slope(slope_std=-1.0), "slope_std"),
        (lambda: from_slope(strain_std=np.nan), "strain_std"),
        (lambda: from_slope(half_width=None), "half width is known"),
        (lambda: from_slope(-2.0, -0.01, SKIN, "line"), "it has none"),
        (lambda: from_slope(slope=np.zeros(3), strain=np.zeros(4)), "broadcast"),
        (lambda: from_slope(skin=ss.Layered(ss.Layer(ss.Material(1.0), 1e-3))), "x = "),
        (lambda: ss.estimate.blind_depth(SKIN, 0.0), "half_width"),
        (lambda: ss.estimate.blind_depth(SKIN, 1e-3, "line"), "no width"),
    ],
)
def test_bad_input_is_refused_with_a_reason(call, says):
    with pytest.raises(ss.SubskinError, match=says):
        call()


def test_shapes_and_inputs():
    tip, readings = row(), row().read(touch((4, 3)))
    before = readings.copy()
    for out in (
        told(tip, readings),
        told(tip, readings.tolist(), position=np.full(3, 0.2e-3)),
        told(tip, readings[0, 0], position=np.full((4, 3), 0.2e-3)),
        told(tip, readings[:1], half_width=np.full((4, 1), 1e-3)),
        by_gradient(rows(), rows().read(touch((4, 3)))),
        from_slope(np.full((4, 1), -2), np.full(3, -0.01)),
        from_slope(-2, -0.01, half_width_std=np.zeros((4, 3))),
    ):
        assert out.shape == (4, 3)
        for field in fields(out):
            values = getattr(out, field.name)
            assert values.shape == (4, 3)
            assert not values.flags.writeable
        assert (out.status == STATUS.OK).all()
        assert out.angle == pytest.approx(np.full((4, 3), out.angle[0, 0]))
    assert (readings == before).all()
    assert told(tip, readings[0, 0]).angle.shape == ()
    assert told(tip, np.empty((0, 7))).shape == (0,)
    assert ss.estimate.blind_depth(SKIN, np.ones((2, 3))).shape == (2, 3)


def test_frame_by_frame_nothing_is_raised():
    tip, rng = row(), np.random.default_rng(0)
    good = tip.read(touch())
    noise = 2e-5 * rng.normal(size=7)
    few = np.where(np.arange(7) < 2, good, np.nan)
    frames = np.stack([good, noise, few, np.full(7, np.inf), -good, good[::-1] * 3])
    out = told(tip, frames)
    expected = [STATUS.OK, STATUS.NO_CONTACT, *[STATUS.INCOMPLETE] * 2, *[STATUS.UNEXPLAINED] * 2]
    assert out.status.tolist() == expected
    assert np.isnan(out.angle).tolist() == [False] + [True] * 5
    assert np.isnan(out.std).tolist() == [False] + [True] * 5
    single = [told(tip, frame) for frame in frames]
    assert [int(o.status) for o in single] == expected
    assert single[0].angle == pytest.approx(float(out.angle[0]), abs=1e-12)
    pairs = rows()
    good = pairs.read(touch())
    frames = np.stack([good, 2e-5 * rng.normal(size=14), np.where(np.arange(14) < 9, good, np.nan), -good])
    out = by_gradient(pairs, frames)
    expected = [STATUS.OK, STATUS.NO_CONTACT, STATUS.INCOMPLETE, STATUS.UNEXPLAINED]
    assert out.status.tolist() == expected
    assert np.isnan(out.angle).tolist() == [False] + [True] * 3
    out = from_slope([-2.0, np.nan, 0.0, 0.0, -2.0], [-0.01, -0.01, 0.0, 0.01, 0.01])
    expected = [STATUS.OK, STATUS.INCOMPLETE, STATUS.NO_CONTACT, STATUS.UNEXPLAINED, STATUS.UNEXPLAINED]
    assert out.status.tolist() == expected


def test_a_position_that_was_not_found_leaves_the_others_alone():
    tip = row()
    readings = tip.read(touch((3,)))
    out = told(tip, readings, position=[0.2e-3, np.nan, 0.2e-3], half_width=[1e-3, 1e-3, np.nan])
    assert out.status.tolist() == [STATUS.OK, STATUS.INCOMPLETE, STATUS.INCOMPLETE]
    assert out.angle[0] == pytest.approx(0.3, abs=1e-9)
    out = by_gradient(rows(), rows().read(touch((2,))), position=[0.2e-3, np.nan], position_std=[1e-6, np.nan])
    assert out.status.tolist() == [STATUS.OK, STATUS.INCOMPLETE]


@pytest.mark.parametrize("lost", [[3], [2, 4], [0, 1, 2], [6, 5, 4]])
def test_sensors_that_are_missing_saturated_or_dead(lost):
    """Those left give the same angle, with a standard deviation that is theirs."""
    tip, gone = row(low=-0.05, high=0.05), np.isin(np.arange(7), lost)
    readings = tip.read(touch())
    dead = told(row(gain=np.where(gone, 0.0, 1.0)), readings)
    for frame in (np.where(gone, np.nan, readings), np.where(gone, 0.05, readings)):
        out = told(tip, np.stack([readings, frame]))
        assert (out.status == STATUS.OK).all()
        assert out.angle == pytest.approx(np.full(2, 0.3), abs=1e-9)
        assert out.std[1] == pytest.approx(float(dead.std), rel=1e-9)
    assert dead.angle == pytest.approx(0.3, abs=1e-9)


def test_gain_offset_and_a_transducer_that_is_not_linear():
    plain, resistive = (row(), row(transducer=ss.VolumeResistance(exact=True), gain=2.5, offset=0.3, noise=1e-4))
    small = touch(force=4.0)  # the exact formula and the linear one part at large strains
    assert told(resistive, resistive.read(small)).angle == pytest.approx(0.3, abs=1e-4)
    double = row(gain=-2.0, offset=0.1, noise=4e-5)
    a, b = told(plain, plain.read(touch())), told(double, double.read(touch()))
    assert b.angle == pytest.approx(float(a.angle), abs=1e-12)
    assert b.std == pytest.approx(float(a.std), rel=1e-9)


def test_the_bound_on_the_standard_deviation_is_kept():
    tip = row()
    reading = tip.read(touch())
    std = float(told(tip, reading).std)
    bound = std / np.cos(0.3) ** 2
    assert told(tip, reading, most_std=1.001 * bound).status == STATUS.OK
    refused = told(tip, reading, most_std=0.999 * bound)
    assert refused.status == STATUS.AMBIGUOUS
    assert np.isnan(refused.angle)
    assert refused.std == pytest.approx(std)
    told_position = told(tip, reading, position_std=1e-5)
    assert told_position.std == pytest.approx(np.hypot(std, 1e-5 * told_position.per_position))
    told_width = told(tip, reading, half_width_std=1e-4)
    assert told_width.std == pytest.approx(np.hypot(std, 1e-4 * told_width.per_half_width))


def test_mirrored_contacts_lean_the_other_way():
    for finger, rule in ((row(), told), (rows(), by_gradient)):
        one = rule(finger, finger.read(touch()))
        other = rule(finger, finger.read(touch(angle=-0.3, position=-0.2e-3)), position=-0.2e-3)
        assert other.angle == pytest.approx(-float(one.angle), abs=1e-12)
        assert other.std == pytest.approx(float(one.std), rel=1e-9)
        assert other.per_position == pytest.approx(float(one.per_position), rel=1e-6)


def test_differences_too_coarse_for_the_gradient_rule_are_said_to_be():
    """Half a depth apart under a narrow contact: 8 degrees off, and refused where less is asked for."""
    y = np.tile(1e-3 * np.arange(-3, 4), 2)
    coarse = ss.Finger(SKIN, ss.SensorArray(y=y, depth=np.repeat([1.5e-3, 2e-3], 7), noise=2e-5))
    reading = coarse.read(ss.LineLoad(40.0, 0.3))
    out = by_gradient(coarse, reading, position=0.0)
    error = abs(float(out.angle) - 0.3)
    assert np.deg2rad(7) < error <= out.truncation + 0.01 * error
    refused = by_gradient(coarse, reading, position=0.0, most_std=np.deg2rad(5))
    assert refused.status == STATUS.AMBIGUOUS
    assert refused.std < np.deg2rad(5)


def curve(axes, start):
    (line,) = [line for line in axes.lines if str(line.get_label()).startswith(start)]
    return np.asarray(line.get_xdata(), dtype=float), np.asarray(line.get_ydata(), dtype=float)


def test_the_figure_shows_what_the_formulas_say():
    from subskin.plot import side_angle_figure

    printed, right, slopes, angles, spread = side_angle_figure(noise=2e-3).axes
    x, slope = curve(slopes, "corrected")
    s = np.hypot(x, 1)
    expected = 3 / np.pi * (1 - x * (x**2 + 2) / s**3)  # towards +y: the memo's alpha is minus the angle
    np.testing.assert_allclose(slope, expected, rtol=0, atol=1e-12)
    x, slope = curve(slopes, "(21)")
    memo = 3 * np.sqrt(3) / (4 * np.pi**2) * (x**2 - 1) / (x**2 + 1) ** 2
    np.testing.assert_allclose(slope, memo, rtol=0, atol=1e-12)
    # its angle: the inverse of the printed formula at the true slope, the width being 2 or 1
    for start, width in (("(21), unit of length half", 2.0), ("(21), unit of length the", 1.0)):
        x, told = curve(angles, start)
        depth, half = x * width / 2, width / 2
        true = 3 / (np.pi * half**2) * (1 - depth * (depth**2 + 2 * half**2) / np.hypot(depth, half) ** 3)
        memo = 3 * np.sqrt(3) / (2 * np.pi**2 * width) * (depth**2 - half**2) / (depth**2 + half**2) ** 2
        sine = true * np.sin(np.deg2rad(10)) / memo
        shown = np.isfinite(told)
        assert (shown == (np.abs(sine) <= 1)).mean() > 0.998
        np.testing.assert_allclose(np.sin(np.deg2rad(told[shown])), sine[shown], rtol=0, atol=1e-9)
        assert (told[shown & ((x < 0.78) | (x > 1))] < 0).all()
    # profiles: the tangent touches the corrected curve, and not the printed one
    for axes, touches in ((printed, False), (right, True)):
        y, strain = curve(axes, "α = 45")
        tangent = [line for line in axes.lines if np.array_equal(line.get_xdata(), [-0.5, 0.5])][3]
        rise = float(np.diff(tangent.get_ydata()).item())
        seen = np.gradient(strain, y)[y.size // 2]
        assert (abs(rise - seen) < 1e-3) == touches
    # the accuracy: as `fit` and `side_angle` have it
    tip = ss.Finger(ss.HalfPlane(ss.Material(1.0)), ss.SensorArray.line(7, 0.5, 1.0, noise=2e-3 * 3 / (2 * np.pi)))
    ratio, full = curve(spread, "full fit")
    _, quick = curve(spread, "slope: centre and width")
    for k in np.flatnonzero((ratio > 0.9) & (ratio < 3))[::30]:
        reading = tip.read(ss.Hertz(1.0, 0.3, half_width=1 / ratio[k]))
        assert np.rad2deg(tip.fit(reading).std[2]) == pytest.approx(full[k], rel=2e-3)
        told = ss.side_angle(tip, reading, position=0.0, half_width=1 / ratio[k], most_std=np.inf)
        assert np.rad2deg(told.std) == pytest.approx(quick[k], rel=1e-6)
    with pytest.raises(ss.errors.InvalidValueError, match="noise"):
        side_angle_figure(noise=0.0)
