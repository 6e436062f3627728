"""What tolerances cost, against closed forms, against the Fisher information, and against one sensor at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.design import Touches, tolerance_budget
from subskin.design.tolerance import SOURCES

RUBBER = ss.Material(0.4e6, 0.5)
FLAT = ss.HalfPlane(RUBBER)
SOFTER = ss.HalfPlane(ss.Material(0.4e6, 0.4))
SKINS = {
    "half plane": SOFTER,
    "layer": ss.Layered(ss.Layer(ss.Material(0.4e6, 0.45), 5e-3)),
    "round": ss.Round(ss.Material(0.4e6, 0.45), 10e-3, 4e-3),
}
TOUCHES = Touches(20.0, 0.8)
COLUMNS = ("position", "angle", "force")


def row_of(skin=SOFTER, count=6, pitch=1.5e-3, noise=1e-5, **more):
    return ss.Finger(skin, ss.SensorArray.line(count, pitch=pitch, depth=2e-3, noise=noise, **more))


def one(finger, tolerances, touches=TOUCHES, **more):
    (row,) = tolerance_budget(finger, touches, tolerances, **{"draws": 1, **more}).rows
    return row


def gauges(nu, y):
    """Strain eps_x times pi E at the depth 1 beneath unit loads at 0, normal and tangential: Flamant and Hooke."""
    q = 1 + y**2
    even, odd = (1 - y**2) / q**2, 2 * y / q**2
    return (1 + nu) * np.stack([-(1 - 2 * nu) / q - even, 2 * nu * y / q - odd], axis=-1)


@pytest.mark.parametrize("nu", [0.45, 0.3])
def test_poissons_ratio_against_least_squares_on_the_closed_form(nu):
    finger = row_of(FLAT, count=7, pitch=2e-3)
    touches = Touches(20.0, 1.0)
    position, angle = touches.grid(8, 6, finger)
    shifts, h = [], 1e-5
    for f in position:
        y = (np.asarray(finger.array.y) - f) / 2e-3
        for a in angle:
            load = np.array([np.cos(a), np.sin(a)])
            moved = (gauges(0.5, y - h) - gauges(0.5, y + h)) / (2 * h) @ load
            jacobian = np.concatenate([moved[:, None], gauges(0.5, y)], axis=1)
            change = (gauges(nu, y) - gauges(0.5, y)) @ load
            shift, n, t = np.linalg.lstsq(jacobian, change, rcond=None)[0]
            shifts.append([2e-3 * shift, load[0] * t - load[1] * n, load[0] * n + load[1] * t])
    expected = np.sqrt((np.array(shifts) ** 2).mean(axis=0))
    row = one(finger, {"poisson": 0.5 - nu}, touches, positions=8, angles=6)
    np.testing.assert_allclose([getattr(row, f"{name}_linear") for name in COLUMNS], expected, rtol=1e-6)


def test_poissons_ratio_of_045_costs_66_degrees():
    """Eight gauges of strain one depth apart, loads within 45 degrees: rms to first order; the median of four."""
    eight = row_of(FLAT, count=8, pitch=2e-3)
    row = one(eight, {"poisson": 0.05}, Touches(20.0, 1.0), positions=60, angles=30)
    assert np.rad2deg(row.angle_linear) == pytest.approx(6.6, abs=0.05)
    assert 5.5 < np.rad2deg(row.angle_rms) < 6.6
    four = row_of(FLAT, count=4, pitch=2e-3)
    assert np.rad2deg(one(four, {"poisson": 0.05}).angle_rms) > 1.2 * np.rad2deg(row.angle_rms)


def test_a_modulus_only_scales_the_force_of_strain_gauges():
    row = one(row_of(), {"young": 0.1})
    assert row.position_rms < 1e-9
    assert row.angle_rms < 1e-6
    off = np.array([1 / 1.1 - 1, 1 / 0.9 - 1])
    assert row.force_rms == pytest.approx(np.sqrt((off**2).mean()), rel=1e-6)
    assert row.lost == 0.0


@pytest.mark.parametrize("kind", [ss.NormalStress(), ss.MeanPressure()])
def test_a_modulus_costs_sensors_of_stress_nothing(kind):
    row = one(row_of(transducer=kind, noise=1.0), {"young": 0.1})
    assert row.position_rms < 1e-9
    assert row.angle_rms < 1e-6
    assert row.force_rms < 1e-6
    assert row.force_linear < 1e-14


def test_poissons_ratio_costs_stress_along_the_depth_nothing():
    row = one(row_of(transducer=ss.NormalStress(), noise=1.0), {"poisson": 0.05})
    assert max(row.force_rms, row.angle_rms) < 1e-6


def test_a_gain_that_all_share_is_a_force():
    row = one(row_of(), {"gain": 0.05})
    assert row.force_rms == pytest.approx(0.05, rel=1e-6)
    assert row.force_worst == pytest.approx(1.959964 * 0.05, rel=1e-5)
    assert max(row.position_rms, row.angle_rms) < 1e-6


@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
def test_depths_positions_and_gains_one_sensor_at_a_time(skin):
    """To first order the variances of the sensors add up: each is moved by itself, and the touches located."""
    finger, n = row_of(skin, noise=1e-6), 6
    position, angle = TOUCHES.grid(6, 4, finger)
    amounts = {"position": 2e-7, "depths": 2e-7, "gains": 1e-4, "offset": 1e-7}
    fields = {"position": "y", "depths": "depth", "gains": "gain", "offset": "offset"}
    budget = tolerance_budget(finger, TOUCHES, amounts, positions=6, angles=4, draws=1)
    for row in budget.rows:
        total = np.zeros(3)
        for i in range(n):
            values = np.array(getattr(finger.array, fields[row.source]))
            values[i] += amounts[row.source]
            made = replace(finger, array=replace(finger.array, **{fields[row.source]: values}))
            found = finger.locate(made.read(ss.LineLoad(20.0, angle, position[:, None])), friction=0.8)
            errors = np.stack([found.position - position[:, None], found.angle - angle, found.force / 20.0 - 1])
            total += (errors**2).mean(axis=(1, 2))
        linear = [getattr(row, f"{name}_linear") for name in COLUMNS]
        np.testing.assert_allclose(linear, np.sqrt(total), rtol=2e-3, err_msg=row.source)


def test_noise_to_first_order_is_the_fisher_information():
    finger = row_of(noise=[1e-5, 2e-5, 1e-5, 3e-5, 1e-5, 1e-5])
    position, angle = TOUCHES.grid(8, 6, finger)
    found = finger.locate(finger.read(ss.LineLoad(20.0, angle, position[:, None])), friction=0.8)
    expected = np.sqrt((found.std**2).mean(axis=(0, 1))) / [1, 20.0, 1]
    size = float(np.sqrt(np.mean(np.asarray(finger.array.noise) ** 2)))
    row = one(finger, {"noise": size}, positions=8, angles=6, draws=300)
    np.testing.assert_allclose([row.position_linear, row.force_linear, row.angle_linear], expected, rtol=1e-4)
    np.testing.assert_allclose([row.position_rms, row.force_rms, row.angle_rms], expected, rtol=0.05)


@pytest.mark.parametrize("skin", SKINS.values(), ids=SKINS)
def test_locating_and_first_order_agree_where_little_is_off(skin):
    finger = row_of(skin)
    small = {
        "position": 2e-7, "depth": 4e-7, "depths": 2e-7, "poisson": 1e-4, "gains": 2e-4, "offset": 1e-7, "width": 5e-5,
        "young": 1e-4, "gain": 1e-4, "noise": 1e-7,
    }  # fmt: skip
    if np.isfinite(skin.thickness):
        small["thickness"] = 1e-6
    if isinstance(skin, ss.Round):
        small["radius"] = 2e-6
    draws, loose = (200, 0.12) if skin is SOFTER else (50, 0.25)  # other skins take their time
    budget = tolerance_budget(finger, TOUCHES, small, positions=6, angles=4, draws=draws)
    assert [row.source for row in budget.rows] == [name for name in SOURCES if name in small]
    for row in budget.rows:
        # 200 draws of six sensors know a root mean square to some 4 %, 50 to 8 %
        close = loose if row.spread in ("sensor", "reading") else 0.01
        for name in COLUMNS:
            linear, rms = getattr(row, f"{name}_linear"), getattr(row, f"{name}_rms")
            assert rms == pytest.approx(linear, rel=close, abs=1e-9), (row.source, name)
        assert row.lost == 0.0
    for name in COLUMNS:
        total, together = (getattr(row, f"{name}_rms") for row in (budget.total, budget.together))
        assert together == pytest.approx(total, rel=2 * loose), name


def test_a_wide_sensor_averages():
    """To first order in its square a width w adds w^2 / 24 times the field's second derivative."""
    finger = row_of()
    w, h = 1e-4, 1e-5
    position, angle = TOUCHES.grid(6, 4, finger)
    load = 20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    fields = [finger.receptive_field(position + s * h) for s in (-1, 0, 1)]
    change = np.einsum("pnl,al->pan", (fields[0] - 2 * fields[1] + fields[2]) / h**2, load) * w**2 / 24
    base = finger.read(ss.LineLoad(20.0, angle, position[:, None]))
    found = finger.locate(base + change, friction=0.8)
    row = one(finger, {"width": w}, positions=6, angles=4)
    assert row.position_rms == pytest.approx(np.sqrt(np.mean((found.position - position[:, None]) ** 2)), rel=5e-3)
    assert row.angle_rms == pytest.approx(np.sqrt(np.mean((found.angle - angle) ** 2)), rel=5e-3)
