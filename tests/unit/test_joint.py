"""Joint 95 % regions of all unknowns hold where few sensors feel a touch and chi-square is no parabola."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.special import chdtri

import subskin as ss

RUBBER = ss.Material(young=1.0)


def with_noise(finger, touch, share):
    """Noise as a share of the reading of a unit touch."""
    full = np.abs(finger.read(touch)).max()
    return dataclasses.replace(finger, array=dataclasses.replace(finger.array, noise=share * full))


def held(found, truth):
    """Shares of the OK frames whose joint region, and whose interval of each unknown, holds the truth (m, k)."""
    ok, load = found.ok, found.load
    at = np.reshape(load.position, (len(truth), -1))
    off, c = (truth - np.concatenate([at, load.components], axis=-1))[ok], load.covariance[ok]
    joint = np.einsum("fi,fij,fj->f", off, np.linalg.inv(c), off) < chdtri(truth.shape[1], 0.05)
    each = np.abs(off) < 1.959964 * np.sqrt(np.diagonal(c, axis1=1, axis2=2))
    return joint.mean(), each.mean(axis=0)


@pytest.mark.parametrize(
    ("kind", "shape", "noise", "ok"),
    [
        (ss.NormalStrain, (2, 3), 1e-2, 0.12), (ss.NormalStrain, (2, 3), 1e-3, 0.7),
        (ss.MeanPressure, (2, 3), 1e-2, 0.5), (ss.NormalStrain, (3, 3), 1e-2, 0.7),
    ],
)  # fmt: skip
def test_of_a_point_on_few_sensors(kind, shape, noise, ok):
    """By the curvature at the top the first holds 66 %, the others 88 to 90 %."""
    tip = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid(shape, 1.0, 1.0, transducer=kind(), noise=1.0))
    tip = with_noise(tip, ss.PointLoad(1.0, position=tuple(tip.array.points[0])), noise)
    rng, count = np.random.default_rng(4), 4000
    at = rng.uniform(tip.array.points.min(axis=0), tip.array.points.max(axis=0), (count, 2))
    force = rng.uniform(0.5, 1.5, count)
    angle, azimuth = rng.uniform(0, np.deg2rad(40), count), rng.uniform(-np.pi, np.pi, count)
    touch = ss.PointLoad(force, angle, azimuth, at)
    found = tip.locate(tip.read(touch, rng))
    assert found.ok.mean() > ok
    joint, each = held(found, np.concatenate([at, touch.components], axis=-1))
    assert 0.92 < joint < 0.965
    assert (each > 0.91).all()
    assert (each < 0.98).all()


@pytest.mark.parametrize(("sensors", "noise"), [(4, 1e-2), (4, 3e-2), (6, 1e-2), (6, 3e-2)])
def test_of_a_line_on_sensors_far_apart(sensors, noise):
    """Strains 1.5 depths apart: by the curvature 65 to 86 %."""
    tip = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(sensors, 1.5, 1.0, noise=1.0))
    tip = with_noise(tip, ss.LineLoad(1.0, position=float(tip.array.y[1])), noise)
    rng, count = np.random.default_rng(4), 6000
    at, force, angle = (
        rng.uniform(*tip.array.y[[0, -1]], count),
        rng.uniform(0.5, 1.5, count),
        rng.uniform(-0.6, 0.6, count),
    )
    touch = ss.LineLoad(force, angle, at)
    found = tip.locate(tip.read(touch, rng))
    assert found.ok.mean() > 0.5
    joint, each = held(found, np.column_stack([at, force * np.cos(angle), force * np.sin(angle)]))
    assert 0.88 < joint < 0.965
    assert (each > 0.92).all()
    assert (each < 0.98).all()


@pytest.mark.parametrize(("shape", "kind", "share"), [((2, 3), ss.MeanPressure, 1e-2), ((3, 3), ss.NormalStrain, 3e-3)])
def test_moments_are_those_of_an_integral(shape, kind, share):
    """Sums of exp(-chi-square / 2) over a fine grid of positions, forces in closed form; curvature is off by 0.4."""
    tip = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid(shape, 1.0, 1.0, transducer=kind(), noise=1.0))
    tip = with_noise(tip, ss.PointLoad(1.0, position=tuple(tip.array.points[0])), share)
    noise, rng = float(tip.array.noise[0]), np.random.default_rng(0)
    touch = ss.PointLoad(components=(1.0, 0.1, 0.05), position=(0.2, -0.3))
    for _ in range(4):
        found = tip.locate(readings := tip.read(touch, rng))
        assert found.ok
        best = np.concatenate([found.position, found.load.components])
        deviation = np.sqrt(np.diag(found.load.covariance))[:2]
        axes = [best[i] + deviation[i] * np.linspace(-6, 6, 121) for i in range(2)]
        at = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        a, w = tip.receptive_field(at, "point") / noise, readings / noise
        own = np.linalg.inv(np.einsum("mnk,mnl->mkl", a, a))
        force = np.einsum("mkl,mnl,n->mk", own, a, w)
        left = ((w - np.einsum("mnk,mk->mn", a, force)) ** 2).sum(axis=1)
        within = (force[:, 0] > 0) & (np.hypot(force[:, 1], force[:, 2]) < force[:, 0])
        weight = np.exp(-0.5 * (left - left.min())) * np.sqrt(np.linalg.det(own)) * within
        weight /= weight.sum()
        away = np.concatenate([at, force], axis=1) - best
        wanted = np.einsum("m,mi,mj->ij", weight, away, away)
        wanted[2:, 2:] += np.einsum("m,mkl->kl", weight, own)
        size = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        np.testing.assert_allclose(found.load.covariance / size, wanted / size, atol=0.01)
