"""How far S falls round its top, eight positions at once, against least squares by NumPy at each of them."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin._compiled import compiled
from subskin.estimate.area.fall import LANES, ROUND, beyond_near, falls
from subskin.estimate.area.point import FIT, ROWS, Point, PointModel, climb
from subskin.estimate.varpro import Ending, Limits

BOX = np.array([-5.0, 5.0, -5.0, 5.0])
ROOT = np.array([0.05, 0.01, 0.04])
NEAR = np.array([5, 6, 9, 10, 1, 2, 4, 7, 8, 11, 13, 14])  # all but the corners


def case(kind, friction, angle=0.3, noise=0.0, deepest=1.0):
    """A finger's response, whitened readings, the loop's model, and fits: the climbed top, one more, and nothing.

    Sensors of one depth read a series (`RadialResponse.series`), of two tables.
    """
    array = ss.SensorArray.grid((4, 4), 1.0, [*[1.0] * 15, deepest], transducer=kind, noise=1e-3)
    tip = ss.Finger(ss.HalfSpace(ss.Material(young=1.0)), array)
    load = ss.PointLoad(force=1.0, angle=angle, azimuth=0.7, position=(0.2, -0.3))
    locator = tip.locator()
    model = PointModel(*locator._prepare(np.ones(16, dtype=bool))[1])
    w = np.asarray(tip.read(load)) * 1e3 + noise * np.random.default_rng(5).normal(size=16)
    scratch, fits = np.zeros((ROWS, 17)), np.zeros(3, FIT)
    model = model._replace(rows=scratch, bits=scratch.view(np.int64))
    climb_to(w, model, Limits(friction), fits)
    return locator.response, w, model, fits


@compiled()
def climb_to(w, model, limits, fits):
    """Fill the first of the fits with the top."""
    climb(w, model, limits, BOX, Point(0.2, -0.3), Ending(1e-9, 1e-12, 0.0, -np.inf), fits[0], fits[1])


@compiled()
def falls_of(w, model, friction, box, reach, fits, lanes):
    return falls(w, model, friction, box, fits[0], fits[2], ROOT, reach, fits[1], lanes)


@compiled()
def beyond_near_of(w, model, limits, fits):
    beyond_near(w, model, limits, fits[0], fits[2])


def quick(w, model, friction, fits, reach=2.5, box=BOX):
    """The falls, and the highest position of the eight."""
    fits[1] = np.full(1, -np.inf).astype(FIT)[0]
    lanes = np.zeros(LANES)
    least = falls_of(w, model, friction, box, reach, fits, lanes)
    assert least == min(lanes[:8].min(), reach**2)
    return lanes[:8].copy(), fits[1].copy()


def where_is(fit):
    return np.array([fit["y"], fit["z"]])


def moves(reach):
    """From the top to the eight positions (8, 2)."""
    return reach * ROUND @ np.array([ROOT[:2], ROOT[1:]])


def by_numpy(response, w, fit, friction, reach=2.5):
    """Falls of S at the same positions: least squares, or the best of a fine turn of the cone where it binds."""
    out = []
    for away in moves(reach):
        a = response(where_is(fit) + away) * 1e3
        force = np.linalg.lstsq(a, w, rcond=None)[0]
        if force[0] < 0 or np.hypot(*force[1:]) > friction * force[0]:
            turns = np.linspace(0, 2 * np.pi, 20001)
            edge = np.stack([np.ones_like(turns), friction * np.cos(turns), friction * np.sin(turns)])
            made = a @ edge
            explained = np.maximum(w @ made, 0.0) ** 2 / (made**2).sum(axis=0)
            left = w @ w - explained.max()
        else:
            left = ((w - a @ force) ** 2).sum()
        out.append(left - fit["left"])
    return np.array(out)


@pytest.mark.parametrize(("friction", "angle"), [(1.0, 0.3), (0.5, 0.46)], ids=["free", "on the cone"])
@pytest.mark.parametrize(
    ("kind", "deepest"),
    [(ss.NormalStrain(), 1.0), (ss.NormalStrain(), 1.1), (ss.MeanPressure(), 1.0)],
    ids=["strain", "strain by tables", "pressure"],
)
def test_falls_are_those_of_least_squares(kind, deepest, friction, angle):
    response, w, model, fits = case(kind, friction, angle, noise=1.0, deepest=deepest)
    fit = fits[0]
    assert (len(model.table) == 1) == (deepest == 1.0)
    found, best = quick(w, model, friction, fits)
    np.testing.assert_allclose(found, by_numpy(response, w, fit, friction), rtol=5e-4, equal_nan=False)
    highest = np.argmin(found)
    np.testing.assert_allclose(where_is(best), where_is(fit) + moves(2.5)[highest], rtol=1e-12, equal_nan=False)
    assert best["explained"] == fit["explained"] - found[highest]


def test_outside_the_box_s_is_taken_to_fall_as_at_the_top():
    response, w, model, fits = case(ss.NormalStrain(), 1.0, noise=1.0)
    fit = fits[0]
    box = np.array([fit["y"], 5.0, -5.0, 5.0])  # half of the positions
    found, _ = quick(w, model, 1.0, fits, box=box)
    outside = moves(2.5)[:, 0] < 0
    assert 0 < outside.sum() < 8
    np.testing.assert_array_equal(found[outside], 2.5**2)
    within = by_numpy(response, w, fit, 1.0)[~outside]
    np.testing.assert_allclose(found[~outside], within, rtol=5e-4, equal_nan=False)


def test_sensors_left_out_count_as_at_the_top():
    """Their readings are straight in the move there, as the slopes of the response say; against least squares."""
    response, w, model, fits = case(ss.NormalStrain(), 1.0, noise=1.0)
    fit = fits[0]
    its_first = np.append(model.first[NEAR], model.first[-1])
    near = model._replace(sensors=np.ascontiguousarray(model.sensors[:, NEAR]), first=its_first)
    beyond_near_of(w[NEAR], near, Limits(1.0), fits)
    found, _ = quick(w[NEAR], near, 1.0, fits)
    force = np.array([fit[name] for name in ("n", "ty", "tz")])
    top, others = where_is(fit), np.setdiff1d(np.arange(16), NEAR)
    at_top = response(top) * 1e3
    steep = np.einsum("nfd,f->nd", response.slopes(top) * 1e3, force)
    for k, away in enumerate(moves(2.5)):
        a = response(top + away) * 1e3
        a[others] = at_top[others]
        rest = w - a @ force
        rest[others] -= steep[others] @ away
        rest -= a @ np.linalg.lstsq(a, rest, rcond=None)[0]
        assert found[k] == pytest.approx(rest @ rest - fit["left"], rel=5e-4)
