"""Loads far from the sensors of an area: what they could explain is bounded, and never more than the bound says."""

from __future__ import annotations

import numpy as np
import pytest
from numba import typeof

import subskin as ss
from subskin.estimate.area.far import far_from
from subskin.estimate.area.reach import may_reach

D = 2e-3  # m
RUBBER = ss.Material(young=0.4e6, poisson=0.5)
HALF = 1.5 * D  # of the array


def finger_of(transducer, noise=1.0):
    return ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid((4, 4), D, D, transducer=transducer, noise=noise))


def explained(spans, w):
    """The most of |w|^2 that a load explains, N and drag as they like; spans (m, n, 3)."""
    basis = np.linalg.qr(spans)[0]
    return ((w @ basis) ** 2).sum(axis=-1)


@pytest.mark.parametrize("friction", [0.0, 1.0])
@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
def test_no_far_load_explains_more_than_its_bound(transducer, friction):
    """Random positions between the boxes, loads there with some noise as readings: the worst case for a bound."""
    finger = finger_of(transducer)
    response, scale = finger.locator().response, np.ones(16)
    inner, outer = np.array([[-HALF, HALF]] * 2) * 1.3, np.array([[-HALF, HALF]] * 2) + 6 * D * np.array([-1, 1])
    table, left, directions = far_from(response, scale, inner, outer, D, friction)
    assert table.shape[0] > 10
    rng = np.random.default_rng(3)
    at = rng.uniform(-HALF - 6 * D, HALF + 6 * D, (20000, 2))
    at[::2] = rng.uniform(-HALF - 1.5 * D, HALF + 1.5 * D, (10000, 2))
    at = at[(np.abs(at) > 1.3 * HALF).any(axis=1)]
    spans = response(at) if friction > 0 else response(at)[..., :1]
    for k in rng.integers(0, len(at), 200):
        w = spans[k] @ rng.normal(size=spans.shape[-1])
        w = 1e3 * w / np.linalg.norm(w) + rng.normal(size=16) * rng.choice([1.0, 100.0])
        total, most = float(w @ w), float(explained(spans, w[None, None]).max())
        single = np.append(w, 0.0).astype(np.float32)
        assert may_reach(single, total, most, table, left, directions)


def test_most_touches_over_the_sensors_need_no_look_elsewhere():
    finger = finger_of(ss.NormalStrain())
    inner, outer = np.array([[-2.0, 2.0]] * 2) * D, np.array([[-11.0, 11.0]] * 2) * D
    table, left, directions = far_from(finger.locator().response, np.ones(16), inner, outer, D, 1.0)
    rng = np.random.default_rng(4)
    at = rng.uniform(-HALF, HALF, (400, 2))
    frames = finger.read(ss.PointLoad(force=np.ones(400), angle=rng.uniform(0, 0.6, 400), position=at))
    frames *= 3e3 / np.linalg.norm(frames, axis=1, keepdims=True)
    needed = [
        may_reach(np.append(w, 0.0).astype(np.float32), float(w @ w), float(w @ w) - 100.0, table, left, directions)
        for w in frames
    ]
    assert np.mean(needed) < 0.5


def test_of_no_region_anything_is_possible():
    box = np.array([[-2.0, 2.0]] * 2) * D
    far = far_from(finger_of(ss.NormalStrain()).locator().response, np.ones(16), box, box, D, 1.0)
    assert far.table.shape[0] == 0
    assert may_reach(np.zeros(17, dtype=np.float32), 0.0, 1.0, *far)


def test_no_region_and_many_are_one_compilation():
    box, response = np.array([[-2.0, 2.0]] * 2) * D, finger_of(ss.NormalStrain()).locator().response
    none, many = (far_from(response, np.ones(16), box, outer * box, D, 1.0) for outer in (1, 3))
    assert len(many.table) > len(none.table) == 0
    assert typeof(tuple(many)) == typeof(tuple(none))


def test_touches_beside_the_sensors_are_found_by_default():
    finger = finger_of(ss.MeanPressure(), noise=10.0)
    rng = np.random.default_rng(5)
    side = rng.choice([-1.0, 1.0], 200) * rng.uniform(1.0, 1.4, 200) * D
    at = np.column_stack([side + np.sign(side) * HALF, rng.uniform(-HALF, HALF, 200)])
    found = finger.locate(finger.read(ss.PointLoad(force=np.full(200, 5.0), position=at), rng))
    off = np.abs(found.position - at).max(axis=-1)
    assert found.ok.mean() > 0.9
    assert off[found.ok].max() < 0.1 * D


def test_a_rival_is_another_top():
    """Weak touches: a climb that ends early beside the top of another climb is not a second answer."""
    finger = finger_of(ss.NormalStrain())
    full = np.abs(finger.read(ss.PointLoad(force=1.0, position=(D / 2, D / 2)))).max()
    finger = finger_of(ss.NormalStrain(), noise=0.01 * full)
    rng = np.random.default_rng(0)
    at = rng.uniform(-HALF, HALF, (2000, 2))
    loads = ss.PointLoad(np.ones(2000), rng.uniform(0, 0.7, 2000), rng.uniform(0, 6, 2000), position=at)
    found = finger.locate(finger.read(loads, rng))
    assert np.mean(found.status == ss.Status.AMBIGUOUS) < 0.002
    assert np.abs(found.position - at)[found.ok].max() < 0.5 * D
