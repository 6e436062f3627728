"""The estimator against the Cramer-Rao bound, which is computed from the forward model alone."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

FULL_SCALE = 3 / (2 * np.pi)  # strain beneath a unit normal load: memo eq. (8) at depth 1, E = 1
FRAMES = 40_000


@pytest.mark.parametrize("sensors", [4, 8])
@pytest.mark.parametrize(("pitch", "noise"), [(0.75, 1e-3), (1.0, 1e-3), (0.75, 1e-2)])
def test_errors_reach_the_bound_and_intervals_cover(sensors, pitch, noise):
    array = ss.SensorArray.line(sensors, pitch=pitch, depth=1.0, noise=noise * FULL_SCALE)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)
    rng = np.random.default_rng(sensors)
    half = 0.5 * (sensors - 1) * pitch
    y, angle = rng.uniform(-half, half, FRAMES), rng.uniform(-0.7, 0.7, FRAMES)
    found = finger.locate(finger.read(ss.LineLoad(1.0, angle, y), rng), search=(-half - 0.5, half + 0.5))

    h = 1e-5

    def read(dy=0.0, dforce=0.0, dangle=0.0):
        return finger.read(ss.LineLoad(1.0 + dforce, angle + dangle, y + dy))

    columns = [
        (read(dy=h) - read(dy=-h)) / (2 * h),
        (read(dforce=h) - read(dforce=-h)) / (2 * h),
        (read(dangle=h) - read(dangle=-h)) / (2 * h),
    ]
    jacobian = np.stack(columns, -1) / array.noise[0]
    bound = np.linalg.inv(np.einsum("mni,mnj->mij", jacobian, jacobian))

    ok = found.status == ss.Status.OK
    assert ok.mean() > 0.99
    errors = np.stack([found.position - y, found.force - 1.0, found.angle - angle], -1)[ok]
    variance = np.diagonal(bound, axis1=1, axis2=2)[ok]
    ratio = np.sqrt((errors**2).mean(0) / variance.mean(0))
    # 1.03 asked for; a mean of squares of this many frames scatters by about 0.01
    assert (ratio < 1.04).all(), ratio
    assert (ratio > 0.97).all(), ratio
    inside = (np.abs(errors) < 1.959964 * found.std[ok]).mean(0)
    np.testing.assert_allclose(inside, 0.95, atol=4 * np.sqrt(0.95 * 0.05 / ok.sum()) + 0.002)
    gross = (np.abs(errors[:, 0]) > 6 * found.std[ok, 0]) & (np.abs(errors[:, 0]) > 0.1)
    assert not gross.any()
    np.testing.assert_allclose(found.residual[ok].mean(), sensors - 3, rtol=0.03)


def test_where_chi_square_is_no_parabola_it_is_said_and_the_intervals_widen():
    """Four sensors at half a depth, 1 % noise: wide and shouldered profiles, which the curvature alone would miss."""
    array = ss.SensorArray.line(4, pitch=0.5, depth=1.0, noise=1e-2 * FULL_SCALE)
    finger = ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)
    rng = np.random.default_rng(0)
    y, angle = rng.uniform(-0.75, 0.75, 200_000), rng.uniform(-0.7, 0.7, 200_000)
    frames = finger.read(ss.LineLoad(1.0, angle, y), rng)
    found = finger.locate(frames, search=(-1.25, 1.25))
    mirrored = finger.locate(frames[:, ::-1], search=(-1.25, 1.25))
    assert (found.status == mirrored.status).mean() > 0.9995
    ok = found.status == ss.Status.OK
    error, std = np.abs(found.position - y), found.std[:, 0]
    assert (ok & (error > 6 * std) & (error > 0.1)).mean() < 1.2e-4
    assert (error[ok] < 1.959964 * std[ok]).mean() > 0.943
