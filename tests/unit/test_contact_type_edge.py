"""Edges on an area: their length and direction beside a fit of the closed form, their evidence beside plain sums."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.special import ive

import subskin as ss
from subskin.decide import Kind, contact_type, usual_kinds
from subskin.errors import InvalidValueError
from subskin.estimate.evidence._area_kernel import _log_turned

D = 2e-3  # m
T, W = np.polynomial.legendre.leggauss(16)
EDGE, FIRST, EACH = 4, 1, 11
BOX = Kind("box", "edge", half_length=(0.6 * D, 2 * D))
BAR = Kind("bar", "edge", half_width=(0.0, 0.8 * D), half_length=(0.6 * D, 2 * D))
TIP = Kind("tip", "cone", half_width=(0.1 * D, 0.5 * D))
FORCE = np.array([1.0, 0.2, -0.1])


@pytest.fixture(scope="module")
def finger():
    noise = 1e-3 / (2 * np.pi) / D**2  # a thousandth of the pressure beneath 1 N
    array = ss.SensorArray.grid((4, 4), 0.8 * D, D, transducer=ss.MeanPressure(), noise=noise)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)


def edge(finger, position, direction, length, force=FORCE, width=None):
    """Readings of point loads side by side, or of rectangles, in closed form; batches of (...,) edges."""
    position, direction, length = (np.asarray(v, float) for v in (position, direction, length))
    if width is not None:
        sides = np.stack(np.broadcast_arrays(length, np.asarray(width, float)), axis=-1)
        return finger.measure(ss.Patch(components=force, position=position, half_widths=sides, turn=direction))
    along = np.stack([np.cos(direction), np.sin(direction)], axis=-1)[..., None, :]
    load = {
        "components": np.asarray(force)[..., None, :],
        "position": position[..., None, :] + (T * length[..., None])[..., None] * along,
    }
    return 0.5 * np.einsum("k,...kn->...n", W, finger.measure(ss.PointLoad(**load)))


def apart(one, other):
    """Angle between two directions that are the same after half a turn."""
    return (one - other + np.pi / 2) % np.pi - np.pi / 2


def test_edges_are_named_and_their_direction_is_told(finger):
    turns = np.array([0.0, 0.4, 1.2, np.pi / 2, 2.0, 3.1])
    lengths = np.linspace(0.8, 1.6, 6) * D
    felt = edge(finger, (0.2 * D, -0.3 * D), turns, lengths)
    rng = np.random.default_rng(0)
    said = contact_type(finger, felt + np.asarray(finger.array.noise) * rng.standard_normal(felt.shape))
    assert said.names == ("point", "vertex", "flat side", "round side", "edge", "none of these")
    assert said.name.tolist() == 6 * ["edge"]
    assert (said.direction >= 0).all()
    assert (said.direction < np.pi).all()
    assert (np.abs(apart(said.direction, turns)) < 4 * said.direction_std).all()
    assert (said.direction_std < 0.02).all()
    np.testing.assert_allclose(said.half_length, lengths, rtol=0.06)
    np.testing.assert_allclose(said.position, np.tile([0.2 * D, -0.3 * D], (6, 1)), atol=0.03 * D)
    assert said.spare.tolist() == 6 * [8]
    table = said.to_dict()
    np.testing.assert_array_equal(table["direction"], said.direction)
    assert {"p_edge", "half_length", "direction_std"} <= set(table)


def test_a_wide_edge_has_its_width(finger):
    said = contact_type(finger, edge(finger, (0.1 * D, 0.2 * D), 0.7, 1.2 * D, width=0.35 * D))
    assert said.name == "edge"
    np.testing.assert_allclose([said.half_width, said.half_length], [0.35 * D, 1.2 * D], rtol=1e-3, equal_nan=False)
    assert said.direction == pytest.approx(0.7, abs=2e-3)
    assert said.residual < 1e-3


@pytest.mark.parametrize(("direction", "length"), [(0.3, 0.9 * D), (2.2, 1.5 * D)])
def test_it_is_the_fit_of_the_closed_form_over_all_unknowns(finger, direction, length):
    noise, rng = np.asarray(finger.array.noise), np.random.default_rng(3)
    felt = edge(finger, (0.3 * D, 0.1 * D), direction, length)
    felt = felt + noise * rng.standard_normal(felt.shape)
    said = contact_type(finger, felt, (BOX, TIP))

    def rest(x):
        return (edge(finger, x[:2] * D, x[2], x[3] * D, x[4:]) - felt) / noise

    start = [0.3, 0.1, direction, length / D, *FORCE]
    fit = least_squares(rest, start, x_scale="jac", xtol=1e-12, ftol=1e-12, gtol=1e-12)
    std = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
    assert said.residual == pytest.approx(2 * fit.cost, abs=0.02)
    assert np.abs(said.position / D - fit.x[:2]).max() < 0.05 * std[:2].max()
    assert abs(apart(said.direction, fit.x[2])) < 0.2 * std[2]
    assert abs(said.half_length / D - fit.x[3]) < 0.05 * std[3]
    assert np.abs(said.load.components - fit.x[4:]).max() < 0.05 * std[4:].max()
    assert said.direction_std == pytest.approx(std[2], rel=0.05)


@pytest.mark.parametrize("noises", [1.0, pytest.param(10.0, marks=pytest.mark.long)])
def test_the_evidence_is_the_plain_average_of_the_likelihood(finger, noises):
    """By importance sampling in all unknowns, of the closed form; and the mean direction with its spread."""
    size = noises * np.asarray(finger.array.noise)[0]
    array = ss.SensorArray.grid((4, 4), 0.8 * D, D, transducer=ss.MeanPressure(), noise=size)
    loud, noise, rng = ss.Finger(finger.skin, array), np.full(16, size), np.random.default_rng(5)
    frame = edge(loud, (0.3 * D, 0.1 * D), 1.0, 1.1 * D, width=0.4 * D) + noise * rng.standard_normal(16)
    seen = contact_type(loud, frame, (BAR, TIP))
    part = seen.table[FIRST : FIRST + EACH]
    best = np.array([*part[2:4] / D, part[9], part[8] / D, part[7] / D, *part[4:7]])

    def readings(x):
        wide = np.maximum(x[:, 4], 1e-3) * D
        return edge(loud, x[:, :2] * D, x[:, 2], x[:, 3] * D, x[:, 5:], wide) / noise

    steps = 1e-4 * np.eye(8)
    jacobian = (readings(best + steps) - readings(best - steps)) / 2e-4
    known = np.diag([0, 0, 0, 1, 1 / 0.2**2, 0, 0, 0])  # the ranges
    root = np.linalg.cholesky(np.linalg.inv(jacobian @ jacobian.T + known)) * 1.2
    z = rng.standard_normal((500, 8))
    x = best + z @ root.T
    inside = (x[:, 3] > 0.6) & (x[:, 3] < 2.0) & (x[:, 4] > 0) & (x[:, 4] < 0.8)
    density = -0.5 * (z**2).sum(1) - np.log(np.diag(root)).sum() - 4 * np.log(2 * np.pi)
    log = -0.5 * ((readings(x) - frame / noise) ** 2).sum(1) - 3 * np.log(np.linalg.norm(x[:, 5:], axis=1)) - density
    log = np.where(inside, log - np.log(np.pi) - np.log(2.0 - 0.6) - np.log(0.8), -np.inf)
    share = np.exp(log - log.max())
    plain = np.log(share.mean()) + log.max() + 2 * np.log(D)
    assert seen.log_evidence[0] == pytest.approx(plain, abs=0.15)
    turn = np.average(x[:, 2], weights=share)
    std = np.sqrt(np.average((x[:, 2] - turn) ** 2, weights=share))
    assert seen.direction == pytest.approx(turn, abs=0.2 * std)
    assert seen.direction_std == pytest.approx(std, rel=0.15)


def test_a_quarter_turn_turns_the_direction_by_a_quarter(finger):
    rng = np.random.default_rng(1)
    points = finger.array.points
    felt = edge(finger, (0.2 * D, -0.4 * D), 0.5, 1.1 * D) + np.asarray(finger.array.noise) * rng.standard_normal(16)
    turned = np.stack([points[:, 1], -points[:, 0]], axis=-1)  # where each sensor's reading comes from
    source = np.abs(turned[:, None] - points).sum(-1).argmin(axis=1)
    one, other = contact_type(finger, felt), contact_type(finger, felt[source])
    assert apart(other.direction, one.direction + np.pi / 2) == pytest.approx(0, abs=1e-5)
    np.testing.assert_allclose(other.position, [-one.position[1], one.position[0]], atol=1e-5 * D)
    np.testing.assert_allclose(other.probability, one.probability, atol=1e-4)
    assert other.direction_std == pytest.approx(float(one.direction_std), rel=1e-3)


def test_round_contacts_and_two_touches_are_no_edges(finger):
    load = {"components": FORCE, "position": (0.3 * D, -0.2 * D)}
    touches = [
        ss.PointLoad(**load),
        ss.Cone(**load, half_width=0.4 * D),
        ss.RoundPunch(**load, half_width=0.8 * D),
        ss.RoundHertz(**load, half_width=1.0 * D),
    ]
    rng = np.random.default_rng(2)
    felt = [finger.read(touch, rng) for touch in touches]
    felt.append(finger.read(ss.PointLoad(**load), rng) + finger.measure(ss.PointLoad(force=0.9, position=(-D, D))))
    said = contact_type(finger, felt)
    assert (np.nan_to_num(said.probability[:, EDGE]) < 1e-3).all()
    assert np.isnan([said.direction, said.direction_std, said.half_length]).all()


def test_what_readings_do_not_tell_has_a_wide_error(finger):
    """A direction goes round: in loud noise it is anything, and its error that of an even chance over half a turn."""
    size = 100 * np.asarray(finger.array.noise)[0]  # a tenth of the reading
    array = ss.SensorArray.grid((4, 4), 0.8 * D, D, transducer=ss.MeanPressure(), noise=size)
    loud, rng = ss.Finger(finger.skin, array), np.random.default_rng(0)
    short = Kind("nail", "edge", half_length=(0.05 * D, 0.1 * D))
    felt = edge(loud, np.zeros((40, 2)), np.full(40, 1.0), np.full(40, 0.08 * D))
    said = contact_type(loud, felt + size * rng.standard_normal(felt.shape), (short,))
    most = np.pi / np.sqrt(12)
    assert (said.direction_std > 0.9 * most).all()
    assert (said.direction_std <= most * (1 + 1e-12)).all()


def test_usual_edges_and_kinds_of_ones_own(finger):
    usual = usual_kinds(finger)[EDGE]
    assert usual.family == "edge"
    assert usual.half_length[0] / usual.half_width[1] == pytest.approx(2**0.5)  # times as long as wide, at least
    assert (usual.unknowns(1.0), usual.unknowns(0.0), BOX.unknowns(1.0)) == (8, 6, 7)
    for more, text in (
        ({"family": "edge"}, "half lengths"),
        ({"family": "edge", "half_length": (2.0, 1.0)}, "ascending"),
        ({"family": "cone", "half_width": (0.0, D), "half_length": (D, 2 * D)}, "only an edge"),
    ):
        with pytest.raises(InvalidValueError, match=text):
            Kind("a kind", **more)
    row = ss.Finger(
        ss.HalfPlane(ss.Material(young=0.4e6)), ss.SensorArray.line(count=6, pitch=D / 2, depth=D, noise=1e-5)
    )
    with pytest.raises(InvalidValueError, match="on an area"):
        contact_type(row, np.zeros(6), (BOX,))
    said = contact_type(row, row.read(ss.LineLoad(force=10.0)))
    assert np.isnan([said.direction, said.half_length, said.direction_std]).all()
    assert "direction" not in said.to_dict()


@pytest.mark.parametrize("k", [0.0, 0.1, 1.0, 3.7, 3.8, 20.0, 1e3])
def test_a_direction_is_spread_over_as_much_of_half_a_turn_as_the_bessel_function_says(k):
    assert math.exp(_log_turned(4 * k)) == pytest.approx(ive(0, k), rel=1e-6)
