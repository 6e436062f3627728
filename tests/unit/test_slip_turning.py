"""Torsional slip: the limit surface of a round contact, and the probability by drag and moment together."""

from __future__ import annotations

import numpy as np
import pytest

from subskin.decide import Friction, SlipVerdict, friction_arm, least_force, slip, slipping_about
from subskin.decide.stick import drag_held, effective_drag, moment_held
from subskin.errors import InvalidValueError
from subskin.estimate import Estimate
from subskin.estimate.layout import ROUND, TWIST

A = 1.5e-3  # m
PRESSURES = {"hertz": lambda r: 1.5 / np.pi * np.sqrt(1 - r * r), "punch": lambda r: 0.5 / np.pi / np.sqrt(1 - r * r)}


def by_area(c, pressure):
    """Drag and moment of friction on the disc of radius 1 that turns about (c, 0): an area integral, straight."""
    turns, rows = 300, np.polynomial.legendre.leggauss(100)
    if c < 1:
        phi, weight = np.pi * (np.arange(turns) + 0.5) / turns, np.full(turns, 2 * np.pi / turns)
    else:
        s, w = np.polynomial.legendre.leggauss(150)
        most = np.arcsin(1 / c)
        phi = np.pi - most * np.sin(0.5 * np.pi * s)
        weight = most * np.cos(0.5 * np.pi * s) * 0.5 * np.pi * w
    phi = phi[:, None]
    root = np.sqrt(np.maximum(1 - (c * np.sin(phi)) ** 2, 0.0))
    low, high = np.maximum(-c * np.cos(phi) - root, 0.0), -c * np.cos(phi) + root
    u = 0.5 * np.pi * rows[0]
    rho = 0.5 * (low + high) + 0.5 * (high - low) * np.sin(u)
    area = weight[:, None] * rho * 0.5 * (high - low) * np.cos(u) * 0.5 * np.pi * rows[1]
    y, z = c + rho * np.cos(phi), rho * np.sin(phi)
    load = pressure(np.minimum(np.hypot(y, z), 1 - 1e-15)) * area
    return np.abs([(load * np.cos(phi)).sum(), (load * (y * np.cos(phi) + z * np.sin(phi))).sum()])


@pytest.mark.parametrize("contact", ["hertz", "punch"])
@pytest.mark.parametrize("c", [0.05, 0.5, 0.95, 1.3, 4.0])
def test_what_is_held_is_the_area_integral(contact, c):
    np.testing.assert_allclose(
        slipping_about(c, contact), by_area(c, PRESSURES[contact]), rtol=1e-9, atol=1e-10, equal_nan=False
    )


@pytest.mark.parametrize("contact", ["hertz", "punch", "wedge"])
def test_ends_and_normality(contact):
    """No drag: the friction arm; no moment: mu N; and the motion is normal to the surface (Goyal et al. 1991)."""
    assert slipping_about(1e-6, contact)[1] == pytest.approx(friction_arm(contact), rel=1e-6)
    assert slipping_about(1e5, contact)[0] == pytest.approx(1.0, rel=1e-5)
    c, h = np.array([0.2, 0.7, 2.0]), 1e-4
    drag, moment = np.moveaxis((slipping_about(c + h, contact) - slipping_about(c - h, contact)) / (2 * h), -1, 0)
    np.testing.assert_allclose(c * drag + moment, 0.0, atol=2e-4)


@pytest.mark.parametrize("contact", ["hertz", "punch", "wedge"])
def test_tables_are_the_curve(contact):
    drag, moment = np.moveaxis(slipping_about(np.geomspace(0.02, 50, 40), contact), -1, 0)
    turning, hold = 0.4 * moment / friction_arm(contact), np.full(40, 0.4)
    np.testing.assert_allclose(effective_drag(0.4 * drag, turning, contact), 0.4, rtol=1e-5)
    np.testing.assert_allclose(drag_held(hold, turning, contact), 0.4 * drag, atol=5e-5)
    np.testing.assert_allclose(moment_held(hold, 0.4 * drag, contact), turning, atol=5e-5)
    assert drag_held(hold, 0.5 * np.ones(40), contact).max() == 0.0


def estimate(loads, moments, square, layout=TWIST, low=1.4e-3):
    """An estimate of contacts of half width A with the given errors of (N, Ty, Tz, half width, moment)."""
    loads = np.atleast_2d(loads)
    table = np.zeros((len(loads), layout.columns))
    table[:, layout.components : layout.components + 3] = loads
    table[:, layout.half_width] = A
    table[:, layout.interval], table[:, layout.interval + 1] = low, 1.6e-3
    full = np.eye(layout.unknowns) * 1e-8
    full[2:, 2:] = square[: layout.unknowns - 2, : layout.unknowns - 2]
    table[:, layout.square] = full
    if layout.twist:
        table[:, 6] = moments
    return Estimate(table, np.ones((len(loads), 16), bool), np.inf, layout.unknowns, layout)


SIZES = np.array([0.06, 0.04, 0.05, 4e-5, 3e-5])
ALIKE = np.array(
    [[1, 0.2, -0.2, 0.3, 0.1], [0, 1, 0.2, 0.1, -0.3], [0, 0, 1, 0, 0.3], [0, 0, 0, 1, 0.2], [0, 0, 0, 0, 1]]
)
ALIKE = np.triu(ALIKE, 1) + np.triu(ALIKE, 1).T + np.eye(5)
SQUARE = ALIKE * np.outer(SIZES, SIZES)
LOADS = np.array([[1.0, 0.3, 0.2], [1.0, 0.05, 0.02], [1.0, -0.25, 0.42], [1.0, 0.25, 0.1], [1.0, 0.0, 0.05]])
MOMENTS = np.array([1e-4, 4.4e-4, 0.5e-4, -2.5e-4, 2e-4])  # N m; the most at mu = 0.5 is 4.4e-4


@pytest.mark.parametrize(
    ("friction", "contact"), [(Friction.known(0.5), "hertz"), (Friction.between(0.35, 0.6), "punch")]
)
def test_the_probability_is_that_of_draws(friction, contact):
    rng = np.random.default_rng(0)
    judged = slip(estimate(LOADS, MOMENTS, SQUARE), friction, contact=contact)
    edges, masses = np.asarray(friction.edges), np.asarray(friction.masses)
    for load, moment, p in zip(LOADS, MOMENTS, judged.probability, strict=True):
        n, ty, tz, a, m = rng.multivariate_normal([*load, A, moment], SQUARE, 100_000).T
        cell = rng.choice(masses.size, n.size, p=masses / masses.sum())
        mu = rng.uniform(edges[cell], edges[cell + 1])
        whole = effective_drag(np.hypot(ty, tz), np.abs(m) / (a * friction_arm(contact)), contact)
        drawn = (whole > mu * n).mean()
        assert p == pytest.approx(drawn, abs=6e-3 + 0.02 * min(drawn, 1 - drawn))
    assert np.ptp(judged.probability) > 0.5


def test_without_moment_it_is_what_it_was():
    calm = SQUARE.copy()
    calm[3:] = calm[:, 3:] = 0.0
    calm[[3, 4], [3, 4]] = 1e-16, 1e-20
    turning, plain = slip(estimate(LOADS, 0.0, calm), 0.5), slip(estimate(LOADS, 0.0, calm, ROUND), 0.5)
    np.testing.assert_allclose(turning.probability, plain.probability, atol=3e-3, equal_nan=False)
    for name in ("margin", "ratio"):
        np.testing.assert_allclose(getattr(turning, name), getattr(plain, name), rtol=1e-6, equal_nan=False)
    np.testing.assert_allclose(turning.margin_std, plain.margin_std, rtol=1e-3, equal_nan=False)
    assert np.isnan(plain.torsion).all()


def test_fields_and_what_cannot_be_told():
    judged = slip(estimate(LOADS, MOMENTS, SQUARE * 1e-4), 0.5)
    assert judged.covariance.shape == (5, 4, 4)
    assert np.isnan(judged.stick).all()
    np.testing.assert_allclose(judged.torsion, np.abs(MOMENTS) / (3 * np.pi / 16 * 0.5 * A), rtol=1e-12)
    assert judged.verdict.tolist()[::4] == [SlipVerdict.HOLDS] * 2
    # the drag alone would hold it
    assert slip(estimate(LOADS[1:2], [6e-4], SQUARE * 1e-4), 0.5).verdict == SlipVerdict.SLIPS
    assert slip(estimate(LOADS[1:2], [6e-4], SQUARE * 1e-4, ROUND), 0.5).verdict == SlipVerdict.HOLDS
    ratio = judged.ratio_interval
    assert ((ratio[:, 0] < judged.ratio) & (judged.ratio < ratio[:, 1])).all()
    assert judged.probability_at(2, 1.0, np.hypot(0.25, 0.42)) == pytest.approx(judged.probability[2], abs=1e-9)
    # friction against turning takes a harder grip than the drag alone does
    plain = least_force(estimate(LOADS, MOMENTS, SQUARE * 1e-4, ROUND), 0.5)
    assert (least_force(estimate(LOADS, MOMENTS, SQUARE * 1e-4), 0.5) > plain).all()
    narrow = slip(estimate(LOADS, MOMENTS, SQUARE, low=0.0), 0.5)
    assert (narrow.verdict == SlipVerdict.CANNOT_TELL).all()
    with pytest.raises(InvalidValueError, match='"hertz", "punch" or "wedge"'):
        slip(estimate(LOADS, MOMENTS, SQUARE), 0.5, contact="line")
