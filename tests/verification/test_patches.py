"""Fits of patches against the rectangles that pressed: forces, sides, turns, what intervals hold; and pressed boxes."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError
from subskin.estimate.area.point import ROWS as POINT_ROWS
from subskin.estimate.area.point import PointModel
from subskin.estimate.area.rectangle import FIELD_ERROR, FIT, ROWS, RectangleAt, RectangleModel, rectangle_field, rules
from subskin.estimate.layout import LEANING
from subskin.estimate.patches import PatchLocator
from subskin.estimate.patches.kernel import FOUND, SHAPE, UNKNOWNS, _bowl
from subskin.estimate.patches.locator import _as_patch
from subskin.plot.style import MM
from subskin.pressing import Box
from subskin.transducer import ShearStrain

DEPTH, FORCE = 2.5e-3, 4.0
RUBBER = ss.Material(young=0.4e6)
OK, AMBIGUOUS, UNEXPLAINED = ss.Status.OK, ss.Status.AMBIGUOUS, ss.Status.UNEXPLAINED


def board(skin=None, shape=(4, 4), pitch=4e-3, **more):
    more = {"noise": 2e-4, **more}
    return ss.Finger(skin or ss.HalfSpace(RUBBER), ss.SensorArray.grid(shape, pitch, DEPTH, **more))


@pytest.fixture(scope="module")
def finger():
    return board()


def pads(rng, half, count=40, turned=True):
    """Rectangles of about one half side, every other one dragged."""
    ratio = np.exp(rng.uniform(-0.3, 0.3, count)) if turned else np.ones(count)
    reach = min(4e-3, 8e-3 - half)
    return ss.Patch(
        force=np.full(count, FORCE), angle=np.where(np.arange(count) % 2, 0.3, 0.0),
        azimuth=rng.uniform(0, 2 * np.pi, count), position=rng.uniform(-reach, reach, (count, 2)),
        half_widths=half * np.stack([ratio, 1 / ratio], axis=-1),
        turn=rng.uniform(-0.7, 0.7, count) if turned else np.zeros(count),
    )  # fmt: skip


def off(found, pad):
    """Errors of (y, z, N, Ty, Tz) in their standard deviations."""
    error = np.concatenate([found.position - pad.position, found.components - pad.components], axis=-1)
    return error / np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))


@pytest.mark.parametrize(("half", "most"), [(1e-3, 0.012), (2e-3, 0.008), (3e-3, 0.004), (4e-3, 0.004), (5e-3, 0.005)])
@pytest.mark.parametrize("turned", [False, True])
def test_force_and_drag_of_pads_are_found_with_intervals_that_hold(finger, half, most, turned):
    rng = np.random.default_rng(round(1e4 * half) + turned)
    pad = pads(rng, half, turned=turned)
    found = finger.fit(finger.read(pad, rng), "patch")
    ok, z = found.status == OK, off(found, pad)
    assert ok.mean() > 0.8
    assert set(found.status[~ok].tolist()) <= {AMBIGUOUS, UNEXPLAINED}
    error = np.abs(found.components - pad.components)[ok] / FORCE
    assert np.median(error[:, 0]) < most
    assert np.quantile(error, 0.95) < 0.05
    for part in (slice(0, 2), slice(2, 3), slice(3, 5)):
        assert np.mean(np.abs(z[ok, part]) < 1.96) > 0.8
    assert np.mean(np.abs(z[ok]).max(axis=-1) > 5) <= 0.03


def test_sides_and_turn_are_those_that_pressed(finger):
    rng = np.random.default_rng(3)
    pad = pads(rng, 3e-3, 30)
    found = finger.fit(finger.read(pad), "patch")  # without noise
    assert (found.status == OK).all()
    assert found.residual.max() < 1e-2
    np.testing.assert_allclose(found.components, pad.components, atol=2e-4 * FORCE)
    oblong = np.abs(np.log(pad.half_widths[:, 0] / pad.half_widths[:, 1])) > 0.1
    np.testing.assert_allclose(found.turn[oblong], pad.turn[oblong], atol=2e-2)
    np.testing.assert_allclose(found.half_widths[oblong], pad.half_widths[oblong], rtol=1e-2)
    again = ss.Patch(
        components=found.components, position=found.position, half_widths=found.half_widths, turn=found.turn
    )
    np.testing.assert_allclose(finger.read(again), finger.read(pad), atol=0.1 * 2e-4)


@pytest.mark.parametrize(
    ("skin", "more"),
    [
        (None, {"transducer": ss.MeanPressure(), "noise": 60.0}),
        (None, {"transducer": ShearStrain(), "noise": 2e-4}),
        (ss.Layered(ss.Layer(ss.Material(0.4e6, 0.48), 6e-3)), {"noise": 2e-4}),
    ],
)
def test_other_sensors_and_skins(skin, more):
    """Of shear alone the force is the sensors' weaker part, and a layer's field is a table's."""
    tip, rng = board(skin, **more), np.random.default_rng(8)
    pad = pads(rng, 2.5e-3, 12)
    found = tip.fit(tip.read(pad, rng), "patch")
    ok = found.status == OK
    assert ok.sum() >= 8
    assert np.abs(off(found, pad)[ok]).max() < 5


def test_the_pressure_may_be_linear(finger):
    rng = np.random.default_rng(4)
    slopes = np.array([[120.0, -60.0, 0.0], [-100.0, 0.0, 0.0], [0.0, 150.0, 0.0], [80.0, 80.0, 0.0]])
    turn = np.array([0.3, -0.5, 0.7, 0.0])
    pad = ss.Patch(
        force=np.full(4, FORCE), angle=0.2, azimuth=1.0, position=rng.uniform(-1e-3, 1e-3, (4, 2)),
        half_widths=(4e-3, 3e-3), slopes=slopes, turn=turn,
    )  # fmt: skip
    found = finger.fit(finger.read(pad), "patch", pressure="linear")
    np.testing.assert_allclose(found.slopes, slopes, atol=3.0)
    np.testing.assert_allclose(found.turn, turn, atol=2e-2)
    np.testing.assert_allclose(found.components, pad.components, atol=2e-3)
    even = finger.fit(finger.read(pad), "patch")
    assert (even.status == UNEXPLAINED).all()
    assert found.unknowns == 10
    noisy = finger.fit(finger.read(pad, rng), "patch", pressure="linear")
    std = np.sqrt(np.diagonal(noisy.table[..., noisy.layout.square], axis1=-2, axis2=-1))
    known = noisy.status == OK
    assert known.any()
    assert (np.abs(noisy.slopes[:, :2] - slopes[:, :2]) < 5 * std[:, -2:])[known].all()


def test_a_box_that_is_pressed_is_found_as_a_punch(finger):
    """The pressure is that of the contact solved for, not of the family."""
    rng, error, held, told = np.random.default_rng(5), [], [], []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # strains of a fifth
        for half, radius in (((2e-3, 2e-3), 1e-3), ((3e-3, 2e-3), 0.5e-3), ((2.5e-3, 3.5e-3), 0.8e-3)):
            pressed = ss.press(finger.skin, Box(*half, edge_radius=radius), force=FORCE).contact
            frames = np.stack([finger.read(pressed, rng) for _ in range(6)])
            found = finger.fit(frames, "patch", pressure="punch")
            error.append(found.components[:, 0] / FORCE - 1)
            held.append(np.abs(off(found, ss.PointLoad(components=(FORCE, 0, 0)))[:, 2]) < 1.96)
            told.append(found.status == OK)
            assert np.median(found.hollow) > 0.3  # the edges bear more
            even = finger.fit(frames, "patch")
            assert (np.abs(even.components[:, 0] / FORCE - 1) > 0.03)[even.status == OK].all()
    assert np.mean(told) > 0.9
    assert np.nanmedian(np.abs(error)) < 0.025
    assert np.mean(held) > 0.85


def test_a_pad_over_the_whole_board_whose_outline_is_known(finger):
    rng = np.random.default_rng(6)
    half = 9e-3  # 3 mm beyond the outermost sensors, on all sides
    pad = ss.Patch(
        force=np.full(40, FORCE), angle=0.2, azimuth=rng.uniform(0, 6, 40), position=rng.uniform(-1e-3, 1e-3, (40, 2)),
        half_widths=(half, half),
    )  # fmt: skip
    frames = finger.read(pad, rng)
    known = finger.fit(frames, "patch", half_width=(half, half), turn=0.0)
    ok = known.status == OK
    assert ok.mean() > 0.6
    assert known.unknowns == 5
    assert np.abs(known.components[ok, 0] / pad.components[ok, 0] - 1).max() < 0.03
    assert np.mean(np.abs(off(known, pad)[ok]) < 1.96) > 0.85
    assert (known.half_widths == half).all()
    assert (known.std[..., -3:] == 0).all()
    free = finger.fit(frames, "patch")
    assert np.mean(free.status == AMBIGUOUS) > 0.8  # the edges are where no sensor sees them


def test_a_known_turn_tells_one_side_from_the_other(finger):
    rng = np.random.default_rng(7)
    pad = ss.Patch(force=FORCE, position=(0.5e-3, 0.0), half_widths=(2e-3, 4e-3), turn=1.2)
    frame = finger.read(pad, rng)
    for turn in (1.2, (1.0, 1.4)):
        found = finger.fit(frame, "patch", turn=turn)
        assert found.status == OK
        assert found.turn == pytest.approx(1.2, abs=0.05)
        np.testing.assert_allclose(found.half_widths, [2e-3, 4e-3], rtol=0.03)
    held = finger.fit(frame, "patch", turn=1.2, half_width=((1e-3, 3e-3), (4e-3, 4e-3)))
    assert held.half_widths[1] == 4e-3
    # a turn that cannot be leaves the readings unexplained
    assert finger.fit(frame, "patch", turn=0.4).status == UNEXPLAINED


def test_the_field_is_that_of_the_closed_form_and_its_slopes_are_those_of_differences(finger):
    locator = PatchLocator(finger, pressure="linear")
    points = locator._prepare(np.ones(16, bool))[2][0][0]
    scratch = np.empty((POINT_ROWS, 17))
    model = RectangleModel(
        PointModel(*points[:4], scratch, scratch.view(np.int64)), rules(5e-3, DEPTH), rules(5e-3, DEPTH), DEPTH, 1.0,
        np.empty((ROWS, 16)),
    )  # fmt: skip

    def field(*at):
        rectangle_field(model, RectangleAt(*at))
        return model.rows.copy()

    at = np.array([0.7e-3, -0.4e-3, 0.6, 3e-3, (2e-3) ** 2, 0.3, -0.2, 0.0])
    rows = field(*at)
    slopes = (at[5] / at[3], at[6] / 2e-3, 0.0)
    patch = ss.Patch(components=np.eye(3), position=at[:2], half_widths=(3e-3, 2e-3), slopes=slopes, turn=at[2])
    np.testing.assert_allclose(
        rows[:3], finger.measure(patch) / 2e-4, rtol=0, atol=FIELD_ERROR * np.abs(rows[:3]).max()
    )
    for k, step in enumerate((1e-6, 1e-6, 1e-4, 1e-6, 1e-9, 1e-3, 1e-3, 1e-3)):
        move = step * np.eye(8)[k]
        change = (field(*(at + move))[:3] - field(*(at - move))[:3]) / (2 * step)
        np.testing.assert_allclose(
            rows[3 * (k + 1) : 3 * (k + 2)], change, rtol=0, atol=1e-4 * np.abs(change).max(), err_msg=str(k)
        )


def test_a_contact_that_is_no_rectangle_and_none(finger):
    rng = np.random.default_rng(9)
    two = finger.read(ss.PointLoad(force=2.0, position=(4e-3, 0))) + finger.read(
        ss.PointLoad(force=2.0, position=(-4e-3, 2e-3))
    )
    assert finger.fit(two + 2e-4 * rng.standard_normal(16), "patch").status == UNEXPLAINED
    assert finger.fit(-finger.read(ss.Patch(force=FORCE, half_widths=(2e-3, 2e-3))), "patch").status == UNEXPLAINED
    assert finger.fit(2e-4 * rng.standard_normal(16), "patch").status == ss.Status.NO_CONTACT
    sparse = np.full(16, np.nan)
    sparse[:7] = 0.0
    assert finger.fit(sparse, "patch").status == ss.Status.INCOMPLETE


def test_missing_and_wild_readings(finger):
    rng = np.random.default_rng(10)
    pad = ss.Patch(force=FORCE, angle=0.2, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3), turn=0.3)
    frame = finger.read(pad, rng)
    frame[5] = np.nan
    found = finger.fit(frame, "patch")
    assert found.status == OK
    assert found.spare == 7
    assert abs(found.components[0] / pad.components[0] - 1) < 0.02
    frame[0] += 200 * 2e-4
    assert finger.fit(frame, "patch").status == UNEXPLAINED
    assert finger.fit(frame, "patch", outliers=1).status == OK


def test_locate_takes_a_patch_and_its_resultant_agrees(finger):
    rng = np.random.default_rng(11)
    pad = ss.Patch(force=FORCE, angle=0.2, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3), turn=0.3)
    frame = finger.read(pad, rng)
    found, same = finger.locate(frame, load="patch"), finger.fit(frame, "patch")
    np.testing.assert_array_equal(found.table, same.table)
    load = found.resultant
    away = np.abs(load.components - found.components) / np.sqrt(np.diag(load.load.covariance))[2:]
    assert (away < 4).all()
    held = ss.decide.slip(found, ss.decide.Friction.between(0.4, 0.6))
    assert held.probability < 0.01
    assert "turn" in repr(found)
    assert {"half_width_y", "half_width_z", "turn", "turn_std"} <= set(found.to_dict())


def test_options_that_cannot_be(finger):
    row = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(count=6, pitch=1e-3, depth=2e-3, noise=1e-4))
    frame = np.zeros(16)
    for tip, family, more, said in (
        (finger, "patch", {"turn": (1.0, 0.0)}, "turn"),
        (finger, "patch", {"turn": (0.0, 2.0)}, "quarter"),
        (finger, "patch", {"half_width": (3e-3, 1e-3)}, "half_width"),
        (finger, "patch", {"pressure": "round"}, "pressure"),
        (finger, "patch", {"scan_step": 1e-3}, "scan_step"),
        (finger, "patch", {"moment": True}, "moment"),
        (finger, "cone", {"turn": 0.1}, "turn"),
        (row, "patch", {}, "area"),
        (replace(finger, tolerances=ss.Tolerances(gain=0.02)), "patch", {}, "tolerances"),
    ):
        with pytest.raises(InvalidValueError, match=said):
            tip.fit(frame if tip is not row else frame[:6], family, **more)


def test_the_search_starts_from_the_second_moments_of_the_pressure(finger):
    sides, turn = np.array([3e-3, 1.5e-3]), 0.6
    pad = ss.Patch(force=FORCE, position=(1e-3, -0.5e-3), half_widths=sides, turn=turn)
    starts = PatchLocator(finger)._starts
    asked = starts._frames(finger.read(pad))[0][starts.layout.columns :]
    at = asked[3:5] / asked[0]
    about = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    wanted = about @ np.diag(sides**2 / 3) @ about.T
    told = asked[[6, 7, 7, 8]].reshape(2, 2) / asked[0] - np.outer(at, at)
    np.testing.assert_allclose(told, wanted, atol=0.3 * wanted.max())
    assert told[0, 1] > 0.3 * wanted[0, 1]


def test_its_figure_shows_the_rectangle(finger):
    pad = ss.Patch(force=FORCE, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3), turn=0.3)
    found = finger.fit(finger.read(pad), "patch")
    inside = pad.pressure(*(found.position + 0.99 * (found.corners - found.position)).T)
    outside = pad.pressure(*(found.position + 1.01 * (found.corners - found.position)).T)
    assert (inside > 0).all()
    assert (outside == 0).all()
    axes = found.plot().axes[0]
    low, high = (MM * end(found.corners, axis=0) for end in (np.min, np.max))
    assert axes.get_xlim()[0] < low[0] < high[0] < axes.get_xlim()[1]
    assert axes.get_ylim()[0] < low[1] < high[1] < axes.get_ylim()[1]
    assert finger.fit(finger.read(pad), "cone").corners is None


def test_a_rectangle_is_the_same_by_all_its_names():
    """Each quarter of a turn names the sides anew; the pressure at points of the skin stays."""
    lean, tilt, long, wide, direction = 0.3, -0.2, 4e-3, 3e-3, 0.2
    found = np.zeros(4, FOUND)
    found["n"], found["direction"] = 1.0, direction + 0.5 * np.pi * np.arange(4)
    found["length"], found["q"] = [long, wide, long, wide], np.square([wide, long, wide, long])
    found["lean"], found["tilt"] = [lean, tilt, -lean, -tilt], [tilt, -lean, -tilt, lean]
    values, slopes = _as_patch(found, "", LEANING, 0.0)
    at = np.random.default_rng(1).uniform(-2e-3, 2e-3, (2, 9))
    along, across = np.cos(0.2) * at[0] + np.sin(0.2) * at[1], np.cos(0.2) * at[1] - np.sin(0.2) * at[0]
    wanted = (1 + lean * along / long + tilt * across / wide) / (4 * long * wide)
    for row in values:
        named = ss.Patch(force=1.0, half_widths=row[5:7], turn=row[7], slopes=(*row[8:], 0.0))
        np.testing.assert_allclose(named.pressure(*at), wanted, rtol=1e-12)
    for name, step in (("length", 1e-7), ("q", 1e-10), ("direction", 1e-4), ("lean", 1e-4), ("tilt", 1e-4)):
        moved = found.copy()
        moved[name] += step
        change = (_as_patch(moved, "", LEANING, 0.0)[0] - values) / step
        own = slopes[:, :, UNKNOWNS.index(name)]
        np.testing.assert_allclose(own, change, rtol=1e-3, atol=1e-6 * np.abs(change).max())


def test_a_side_as_long_as_was_looked_for_is_not_sure(finger):
    pad = ss.Patch(force=FORCE, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3), turn=0.3)
    frame = finger.read(pad, np.random.default_rng(12))
    assert finger.fit(frame, "patch", half_width=(1e-3, 3.5e-3)).status == OK
    assert finger.fit(frame, "patch", half_width=(1e-3, 3.02e-3)).status == AMBIGUOUS


def test_errors_of_sides_are_as_large_as_they_are_said(finger):
    rng = np.random.default_rng(13)
    pad = ss.Patch(force=np.full(80, FORCE), position=(1e-3, 0.5e-3), half_widths=(3.5e-3, 2.5e-3), turn=0.3)
    found = finger.fit(finger.read(pad, rng), "patch")
    z = (found.half_widths - pad.half_widths) / found.std[:, 5:7]
    assert 0.8 < np.sqrt(np.mean(z**2)) < 1.2
    assert 0.8 < np.std((found.turn - 0.3) / found.std[:, 7]) < 1.2
    punch = finger.fit(finger.read(pad, rng), "patch", pressure="punch")
    assert (np.sqrt(punch.load.covariance[:, 2, 2]) > 0.012 * FORCE).all()


def test_a_hollow_pressure_of_the_same_second_moments():
    top, shape = np.zeros(1, FIT)[0], np.zeros(1, SHAPE)[0]
    top.length, top.q, top.hollow = 3e-3, 4e-6, 0.5
    _bowl(top, -0.5, shape)
    t, w = np.polynomial.legendre.leggauss(4)
    spread = [
        np.einsum("i,j,ij,i->", w, w, 1 + h * (t[:, None] ** 2 + t**2 - 2 / 3), t**2) * long**2
        for h, long in ((0.5, top.length), (-0.5, shape.length))
    ]
    assert spread[1] == pytest.approx(spread[0])
    assert shape.q / top.q == pytest.approx((shape.length / top.length) ** 2)
