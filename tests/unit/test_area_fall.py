"""How far S falls round its top, eight positions at once, against least squares by NumPy at each of them."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.estimate.area.climb import FIT, ROUND, climb
from subskin.estimate.area.fall import LANES, beyond_near, falls
from subskin.estimate.area.field import ROWS

BOX = np.array([-5.0, 5.0, -5.0, 5.0])
ROOT = np.array([0.05, 0.01, 0.04])
NEAR = np.array([5, 6, 9, 10, 1, 2, 4, 7, 8, 11, 13, 14])  # all but the corners


def case(kind, friction, angle=0.3, noise=0.0, deepest=1.0):
    """A finger's response, whitened readings, the loop's sensors and tables, and the climbed top.

    Sensors of one depth read a series (`RadialResponse.series`), of two tables.
    """
    array = ss.SensorArray.grid((4, 4), 1.0, [*[1.0] * 15, deepest], transducer=kind, noise=1e-3)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)
    load = ss.PointLoad(force=1.0, angle=angle, azimuth=0.7, position=(0.2, -0.3))
    locator = tip.locator()
    _, sensors, first, table, terms, *_ = locator._prepare(np.ones(16, dtype=bool))
    w = np.asarray(tip.read(load)) * 1e3 + noise * np.random.default_rng(5).normal(size=16)
    scratch, fit = np.zeros((ROWS, 17)), np.zeros(FIT)
    climb(
        w, sensors, first, table, terms, friction, BOX, 0.2, -0.3, 1e-9, 1e-12, 0.0, -np.inf, scratch,
        scratch.view(np.int64), fit, np.zeros(FIT),
    )  # fmt: skip
    return locator.response, w, sensors, first, table, terms, fit, scratch


def quick(w, sensors, first, table, friction, fit, scratch, lanes, reach=2.5, box=BOX):
    """The falls, and the highest position of the eight."""
    best = np.full(FIT, -np.inf)
    least = falls(
        w, sensors, first, table, friction, box, fit, ROOT, reach, scratch, scratch.view(np.int64), np.zeros(FIT), best,
        lanes,
    )  # fmt: skip
    assert least == min(lanes[:8].min(), reach**2)
    return lanes[:8].copy(), best


def moves(reach):
    """From the top to the eight positions (8, 2)."""
    return reach * ROUND @ np.array([ROOT[:2], ROOT[1:]])


def by_numpy(response, w, fit, friction, reach=2.5):
    """Falls of S at the same positions: least squares, or the best of a fine turn of the cone where it binds."""
    out = []
    for away in moves(reach):
        a = response(fit[29:31] + away) * 1e3
        force = np.linalg.lstsq(a, w, rcond=None)[0]
        if force[0] < 0 or np.hypot(*force[1:]) > friction * force[0]:
            turns = np.linspace(0, 2 * np.pi, 20001)
            edge = np.stack([np.ones_like(turns), friction * np.cos(turns), friction * np.sin(turns)])
            made = a @ edge
            explained = np.maximum(w @ made, 0.0) ** 2 / (made**2).sum(axis=0)
            left = w @ w - explained.max()
        else:
            left = ((w - a @ force) ** 2).sum()
        out.append(left - fit[17])
    return np.array(out)


@pytest.mark.parametrize(("friction", "angle"), [(1.0, 0.3), (0.5, 0.46)], ids=["free", "on the cone"])
@pytest.mark.parametrize(
    ("kind", "deepest"),
    [(ss.NormalStrain(), 1.0), (ss.NormalStrain(), 1.1), (ss.MeanPressure(), 1.0)],
    ids=["strain", "strain by tables", "pressure"],
)
def test_falls_are_those_of_least_squares(kind, deepest, friction, angle):
    response, w, sensors, first, table, _, fit, scratch = case(kind, friction, angle, noise=1.0, deepest=deepest)
    assert (len(table) == 1) == (deepest == 1.0)
    found, best = quick(w, sensors, first, table, friction, fit, scratch, np.zeros(LANES))
    np.testing.assert_allclose(found, by_numpy(response, w, fit, friction), rtol=5e-4, equal_nan=False)
    highest = np.argmin(found)
    np.testing.assert_allclose(best[29:31], fit[29:31] + moves(2.5)[highest], rtol=1e-12, equal_nan=False)
    assert best[3] == fit[3] - found[highest]


def test_outside_the_box_s_is_taken_to_fall_as_at_the_top():
    response, w, sensors, first, table, _, fit, scratch = case(ss.NormalStrain(), 1.0, noise=1.0)
    box = np.array([fit[29], 5.0, -5.0, 5.0])  # half of the positions
    found, _ = quick(w, sensors, first, table, 1.0, fit, scratch, np.zeros(LANES), box=box)
    outside = moves(2.5)[:, 0] < 0
    assert 0 < outside.sum() < 8
    np.testing.assert_array_equal(found[outside], 2.5**2)
    within = by_numpy(response, w, fit, 1.0)[~outside]
    np.testing.assert_allclose(found[~outside], within, rtol=5e-4, equal_nan=False)


def test_sensors_left_out_count_as_at_the_top():
    """Their readings are straight in the move there, as the slopes of the response say; against least squares."""
    response, w, sensors, first, table, terms, fit, scratch = case(ss.NormalStrain(), 1.0, noise=1.0)
    near, its_first = np.ascontiguousarray(sensors[:, NEAR]), np.append(first[NEAR], first[-1])
    lanes = np.zeros(LANES)
    beyond_near(w[NEAR], near, its_first, table, terms, 1.0, fit, scratch, scratch.view(np.int64), np.zeros(FIT), lanes)
    found, _ = quick(w[NEAR], near, its_first, table, 1.0, fit, scratch, lanes)
    top, others = fit[29:31], np.setdiff1d(np.arange(16), NEAR)
    at_top = response(top) * 1e3
    steep = np.einsum("nfd,f->nd", response.slopes(top) * 1e3, fit[:3])
    for k, away in enumerate(moves(2.5)):
        a = response(top + away) * 1e3
        a[others] = at_top[others]
        rest = w - a @ fit[:3]
        rest[others] -= steep[others] @ away
        rest -= a @ np.linalg.lstsq(a, rest, rcond=None)[0]
        assert found[k] == pytest.approx(rest @ rest - fit[17], rel=5e-4)
