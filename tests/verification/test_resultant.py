"""Resultants of whatever presses against the loads that pressed: forces, centres, moments, and what intervals hold."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.decide import Friction, least_force, slip
from subskin.errors import InvalidValueError
from subskin.estimate import Resultant, ResultantReader
from subskin.estimate.resultants.bank import Bank, bank_of
from subskin.estimate.resultants.kernel import resultant_frames
from subskin.estimate.resultants.pressures import tractions
from subskin.transducer import ShearStrain

DEPTH = 2.5e-3
RUBBER = ss.Material(young=0.4e6)
COUNT = 40


def pad(skin=None, shape=(4, 4), pitch=4e-3, **more):
    more = {"noise": 2e-4, **more}
    return ss.Finger(skin or ss.HalfSpace(RUBBER), ss.SensorArray.grid(shape, pitch, DEPTH, **more))


@pytest.fixture(scope="module")
def square():
    return pad()


def loads(rng, count=COUNT, force=4.0, steepest=0.5):
    lean, azimuth = rng.uniform(0.0, steepest, count), rng.uniform(0.0, 2 * np.pi, count)
    return force * np.stack([np.ones(count), lean * np.cos(azimuth), lean * np.sin(azimuth)], axis=-1)


def touches(rng, count=COUNT):
    """Contacts whose shapes are given by formulas, none drawn as the guesses are, and a hollow one on nodes."""
    size = DEPTH * np.exp(rng.uniform(np.log(0.3), np.log(1.6), count))
    where = {"components": loads(rng, count), "position": rng.uniform(-5e-3, 5e-3, (count, 2))}
    sides = np.stack([size, size * rng.uniform(0.6, 1.6, count)], axis=-1)
    yield ss.RoundHertz(half_width=size, **where), where["position"]
    yield ss.RoundPunch(half_width=size, **where), where["position"]
    yield ss.Cone(half_width=size, **where), where["position"]
    yield ss.Patch(half_widths=sides, **where), where["position"]
    y = np.linspace(-6e-3, 6e-3, 49)
    r = np.hypot(*np.meshgrid(y, y, indexing="ij"))
    ring = np.exp(-(((r - 2e-3) / 0.8e-3) ** 2)) * (r < 5.5e-3)
    hollow = ss.PressureGrid(y, y, ring / (ring.sum() * (y[1] - y[0]) ** 2))
    yield hollow, np.zeros(2)


def deviates(found, load, centre):
    """Errors of (y, z, N, Ty, Tz) in their standard deviations, of frames that are OK."""
    ok = found.status == ss.Status.OK
    error = np.concatenate([found.position - centre, found.components - load], axis=-1)
    return (error / np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1)))[ok], ok


@pytest.mark.parametrize(
    ("skin", "more"),
    [
        (None, {}),
        (ss.Layered(ss.Layer(ss.Material(0.4e6, 0.48), 6e-3)), {"transducer": ss.MeanPressure(), "noise": 60.0}),
    ],
)
def test_intervals_hold_the_load_whatever_its_shape(skin, more):
    finger, rng = pad(skin, **more), np.random.default_rng(1)
    every, off, answered = [], [], []
    for touch, centre in touches(rng):
        frames = finger.read(touch, rng)
        found = finger.resultant(frames)
        z, ok = deviates(found, touch.components, centre)
        every.append(z)
        answered.append(np.mean(ok))
        off.append(np.abs(found.components[..., 0] / touch.components[..., 0] - 1)[ok])
    z = np.concatenate(every)
    assert np.mean(answered) > 0.85
    assert np.median(np.concatenate(off)) < 0.04
    held = (np.abs(z) < 1.96).mean(axis=0)
    assert (held > 0.88).all()
    assert (np.abs(z) > 4).mean() < 0.015
    assert np.sqrt((z**2).mean()) > 0.5  # nor are they wide without need


def test_a_row_of_long_contacts():
    finger = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(8, 1.5e-3, 2e-3, noise=2e-4))
    rng, every, off = np.random.default_rng(2), [], []
    for family in (ss.Hertz, ss.Strip, ss.FlatPunch, ss.Wedge):
        where = {"angle": rng.uniform(-0.4, 0.4, 60), "position": rng.uniform(-4e-3, 4e-3, 60)}
        touch = family(force=40.0, half_width=rng.uniform(0.4e-3, 3e-3, 60), **where)
        found = finger.resultant(finger.read(touch, rng))
        ok = found.status == ss.Status.OK
        load = np.stack([touch.normal_force, touch.tangential_force], axis=-1)
        error = np.concatenate([(found.centre - where["position"])[:, None], found.components - load], axis=-1)
        every.append((error / np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1)))[ok])
        off.append(np.abs(error[ok, 1]) / 40.0)
        np.testing.assert_allclose(found.moments[ok], -(found.centre * found.components[:, 0])[ok], rtol=1e-12)
        assert (found.torsion[ok] == 0).all()
        assert found.moments_covariance.shape == (60,)
    z = np.concatenate(every)
    assert len(z) > 150
    assert np.median(np.concatenate(off)) < 0.025
    assert ((np.abs(z) < 1.96).mean(axis=0) > 0.93).all()


def test_a_round_finger_is_gone_about_once():
    """Guesses reach farther than half way round; the table of a round finger does not."""
    finger = ss.Finger(
        ss.Round(ss.Material(0.4e6, 0.48), 5e-3, 2.5e-3), ss.SensorArray.line(7, 1.5e-3, 1.5e-3, noise=2e-4)
    )
    rng = np.random.default_rng(6)
    touch = ss.Hertz(
        force=40.0, angle=rng.uniform(-0.3, 0.3, 30), position=rng.uniform(-3e-3, 3e-3, 30), half_width=1e-3
    )
    found = finger.resultant(finger.read(touch, rng))
    ok = found.status == ss.Status.OK
    off = (found.components[:, 0] - touch.normal_force)[ok]
    assert ok.mean() > 0.8
    assert np.median(np.abs(off)) < 1.5
    assert (np.abs(off) < 1.96 * np.sqrt(found.load.covariance[ok, 1, 1])).mean() > 0.9


def test_the_widest_guess_goes_about_a_round_finger_once():
    """Its second moments from loads read one by one, on a finger that is less far about than a guess is wide."""
    depth = 0.9e-3
    row = ss.SensorArray.line(7, 0.4e-3, depth, noise=2e-4)
    finger = ss.Finger(ss.Round(ss.Material(0.4e6, 0.48), 2e-3, 1e-3), row)
    bank = bank_of(finger, np.ones(7, dtype=bool), np.asarray(row.noise))
    step = 0.5 * depth
    some = tractions(4.8 / 0.5, 2, 1, 120)
    count = int(np.ceil((6 * 0.4e-3 + 2 * depth) / (2 * step)))
    at = step * (count - 1) + some.nodes[:, 0] * step
    assert np.ptp(at) + 2 * step * (count - 1) > finger.skin.period
    fields = finger.receptive_field(at) / 2e-4  # of any position about the finger
    read = np.einsum("plwc,wnc->pln", some.values, fields).reshape(-1, 7)
    np.testing.assert_allclose(of_guess(bank, -1), read.T @ read / 120, rtol=1e-5, atol=1e-7 * (read**2).mean())


def test_moments_are_those_of_the_load(square):
    """About the origin: z N about y, -y N about z, and the drag's arm about x."""
    touch = ss.Patch(components=[4.0, 0.5, -0.8], position=(2e-3, -1e-3), half_widths=(2e-3, 1.5e-3))
    found = square.resultant(square.read(touch))
    y, z = found.centre
    n, along, across = found.components
    np.testing.assert_allclose(found.moments[1:], [z * n, -y * n], rtol=1e-12)
    assert found.moments[0] == pytest.approx(y * across - z * along + found.torsion, rel=1e-9)
    wanted = np.array([2e-3 * -0.8 + 1e-3 * 0.5, -1e-3 * 4.0, -2e-3 * 4.0])
    assert (np.abs(found.moments - wanted) < 2.5 * np.sqrt(np.diag(found.moments_covariance))).all()
    assert abs(found.torsion) < 2 * found.torsion_std


def test_torsion_is_told_by_sensors_of_shear_alone():
    y = np.linspace(-4e-3, 4e-3, 33)
    at = np.stack(np.meshgrid(y, y, indexing="ij"), axis=-1)
    bump = np.maximum(1 - (at**2).sum(-1) / 3.5e-3**2, 0.0) ** 0.5
    bump /= bump.sum() * (y[1] - y[0]) ** 2
    twist = 300.0 * np.stack([-at[..., 1], at[..., 0]], axis=-1) * bump[..., None]
    touch = ss.PressureGrid(y, y, 4.0 * bump, twist)
    normal = pad(shape=(3, 3))
    where = np.tile(normal.array.points, (3, 1))
    kinds = [kind for kind in (ss.NormalStrain(), ShearStrain("xy"), ShearStrain("xz")) for _ in range(9)]
    array = ss.SensorArray(where[:, 0], depth=DEPTH, z=where[:, 1], transducer=kinds, noise=2e-4)
    found = [f.resultant(f.read(touch)) for f in (normal, ss.Finger(normal.skin, array))]
    assert found[0].torsion_std > 3 * found[1].torsion_std  # normal strain reads nothing of it
    assert found[1].torsion == pytest.approx(float(touch.moment), abs=2.5 * float(found[1].torsion_std))
    assert found[1].torsion > 4 * found[1].torsion_std


def test_what_is_no_press_has_no_resultant(square):
    touch = ss.RoundHertz(force=4.0, position=(1e-3, 0.0), half_width=2e-3)
    readings = square.read(touch)
    rng = np.random.default_rng(3)
    noise = 2e-4 * rng.standard_normal((200, 16))
    nonsense = 2e-2 * rng.standard_normal((200, 16))
    assert ss.Status(square.resultant(-readings).status) == ss.Status.UNEXPLAINED
    assert (square.resultant(noise).status == ss.Status.NO_CONTACT).all()
    found = square.resultant(nonsense)
    assert (found.status == ss.Status.UNEXPLAINED).mean() > 0.95
    assert np.isnan(found.components[found.status == ss.Status.UNEXPLAINED]).all()
    few = np.full(16, np.nan)
    few[:4] = readings[:4]
    assert ss.Status(square.resultant(few).status) == ss.Status.INCOMPLETE


def test_a_missing_sensor_is_left_out(square):
    touch = ss.Patch(force=4.0, angle=0.2, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3))
    readings = square.read(touch)
    readings[5] = np.nan
    found = square.resultant(readings)
    assert found.used.sum() == 15
    z, _ = deviates(found[None], touch.components, touch.position)
    assert (np.abs(z) < 2.5).all()


def test_tolerances_count():
    """Fingers unlike their drawing: told so, intervals hold; taken as exact, they do not."""
    drawn = pad(shape=(3, 3), pitch=2.5e-3)
    told = ss.Tolerances(gain=0.02, depth=0.05, position=0.05, poisson=0.05)
    known, every = ss.Finger(drawn.skin, drawn.array, tolerances=told), {"exact": [], "told": []}
    for k in range(25):
        rng = np.random.default_rng(k)
        made = ss.Finger(*told.draw(drawn.skin, drawn.array, rng))
        touch = ss.RoundHertz(
            components=loads(rng, 12),
            position=rng.uniform(-4e-3, 4e-3, (12, 2)),
            half_width=rng.uniform(1e-3, 3e-3, 12),
        )
        readings = made.read(touch, rng)
        for name, finger in (("exact", drawn), ("told", known)):
            every[name].append(deviates(finger.resultant(readings), touch.components, touch.position)[0])
    held = {name: (np.abs(np.concatenate(z)) < 1.96).mean(axis=0) for name, z in every.items()}
    assert (held["told"] > 0.9).all()
    assert held["exact"][2] < 0.85


def test_an_estimate_knows_the_resultant_of_its_readings(square):
    touch = ss.Patch(force=4.0, angle=0.2, position=(1e-3, 0.5e-3), half_widths=(4e-3, 3e-3))
    readings = np.stack([square.read(touch), np.zeros(16), square.read(touch, np.random.default_rng(0))])
    found = square.locate(readings)
    assert ss.Status(found.status[0]) == ss.Status.UNEXPLAINED
    np.testing.assert_array_equal(found.resultant.table, square.resultant(readings).table)
    np.testing.assert_array_equal(found[2].resultant.table, square.resultant(readings[2]).table)
    given = np.array(readings)
    mine = square.locate(given)
    given[:] = 0.0  # a buffer of one's own is used again
    np.testing.assert_array_equal(mine.resultant.table, found.resultant.table)
    assert isinstance(square.fit(readings).resultant, Resultant)
    for gone in (pickle.loads(pickle.dumps(found)), square.locator()(readings)):
        with pytest.raises(InvalidValueError, match="knows no readings"):
            _ = gone.resultant
    row = ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.line(8, 1.5e-3, 2e-3, noise=2e-4))
    rolled = row.locate(row.read(ss.Hertz(force=40.0, half_width=1e-3)))
    assert rolled.resultant.force == pytest.approx(40.0, rel=0.03)


def test_a_calibrated_finger_widens_all_errors():
    """By its spread at the centre; and no frame of a finger without trust is OK."""
    row = ss.Finger(ss.HalfPlane(RUBBER), ss.SensorArray.line(8, 1.5e-3, 2e-3, noise=2e-4))
    readings = row.read(ss.Hertz(force=40.0, position=1e-3, half_width=1e-3))
    spread = ss.spread.Spread([-4e-3, 4e-3], straight=[1.0, 1.0], leaning=[2.0, 4.0])
    plain = row.resultant(readings)
    wide = replace(row, spread=spread).resultant(readings)
    ratio = float(spread.at(plain.centre)) ** 2
    assert ratio > 6
    np.testing.assert_allclose(wide.load.covariance, ratio * plain.load.covariance, rtol=1e-12)
    assert wide.moments_covariance == pytest.approx(ratio * plain.moments_covariance)
    with pytest.warns(ss.errors.ValidityWarning, match="no frame"):
        doubted = replace(row, trusted=False).resultant(readings)
    assert ss.Status(doubted.status) == ss.Status.AMBIGUOUS


def test_what_a_person_and_a_table_get(square):
    found = square.resultant(square.read(ss.Patch(force=4.0, half_widths=(2e-3, 2e-3))))
    assert repr(found).startswith("Resultant(OK, position y")
    assert "torsion" in repr(found)
    columns = found.to_dict()
    assert columns["torsion_std"] == found.torsion_std
    assert not [name for name in columns if name.startswith("second")]


def test_slip_and_grip_of_a_resultant(square):
    touch = ss.Patch(force=4.0, angle=0.3, position=(1e-3, 0.5e-3), half_widths=(3e-3, 2e-3))
    found = square.locate(square.read(touch, np.random.default_rng(0))).resultant
    friction = Friction.between(0.4, 0.8)
    judged = slip(found, friction)
    drawn = np.random.default_rng(1).multivariate_normal(found.components, found.load.covariance[2:, 2:], 400_000)
    mu = np.random.default_rng(2).uniform(0.4, 0.8, len(drawn))
    assert judged.probability == pytest.approx(np.mean(np.hypot(*drawn[:, 1:].T) > mu * drawn[:, 0]), abs=2e-3)
    force = least_force(found, friction, 0.01)
    drawn[:, 0] += force - found.components[0]
    assert np.mean(np.hypot(*drawn[:, 1:].T) > mu * drawn[:, 0]) == pytest.approx(0.01, abs=7e-4)


def run(bank, frames, most=60.0, box=((-1.0, 1.0), (-1.0, 1.0))):
    """The loop on a bank of one's own: what is asked and its covariance, and the table."""
    n, q = frames.shape[1], bank.told.shape[2]
    sensors = np.stack([np.zeros(n), np.ones(n), np.full(n, -1e300), np.full(n, 1e300)])
    out, asked = np.empty((len(frames), 33)), np.empty((len(frames), q * (q + 1)))
    resultant_frames(frames, sensors, *bank, most, np.array(box), out, asked)
    return asked[:, :q], asked[:, q:].reshape(-1, q, q), out


def factored(c, b, v, chance=0.0):
    size, basis = np.linalg.eigh(c)
    told = (basis.T @ b.T) / size[:, None]
    first = basis[:, -1] * np.sign(told[-1, 0])
    parts = (first[:, None].astype(np.float32), basis.T[None, ::-1], size[None, ::-1], told[None, ::-1], v[None])
    return Bank(*(np.ascontiguousarray(p) for p in parts), np.array([chance]))


def some_moments(rng, n=8, q=6):
    loads = rng.standard_normal((40, n + q))
    loads[:, n] = np.abs(loads[:, n]) + 3.0  # it presses
    loads[:, :n] += 4.0 * loads[:, n : n + 1]
    s = loads.T @ loads / 40
    return s[:n, :n], s[n:, :n], s[n:, n:]


def test_one_guess_is_the_best_linear_estimate():
    """s^2 B (s^2 C + 1)^-1 r and s^2 V - s^4 B (s^2 C + 1)^-1 B^T, written out."""
    rng = np.random.default_rng(4)
    c, b, v = some_moments(rng)
    size, basis = np.linalg.eigh(c)
    frame = 20.0 * basis[:, -1] * np.sign(b[0] @ basis[:, -1]) + rng.standard_normal(8)
    s2 = (basis[:, -1] @ frame) ** 2 / size[-1]
    gain = s2 * b @ np.linalg.inv(s2 * c + np.eye(8))
    mean, square, out = run(factored(c, b, v), frame[None])
    assert ss.Status(out[0, -1]) <= ss.Status.AMBIGUOUS
    np.testing.assert_allclose(mean[0], gain @ frame, rtol=1e-9)
    unlike = 0.012**2 * np.outer(mean[0], mean[0])  # of pressures that are none of the guess
    np.testing.assert_allclose(square[0], s2 * v - s2 * gain @ b.T + unlike, rtol=1e-7, atol=1e-9)
    left = frame @ np.linalg.inv(s2 * c + np.eye(8)) @ frame
    assert out[0, 20] == pytest.approx(left, rel=1e-9)
    _, _, out = run(factored(c, b, v), frame[None], most=0.99 * left)
    assert out[0, -1] == ss.Status.UNEXPLAINED
    # the centre is moments over force, and its covariance to first order
    turn = np.zeros((5, 6))
    force, centre = mean[0, 0], mean[0, 3:5] / mean[0, 0]
    turn[:2, 3:5], turn[:2, 0] = np.eye(2) / force, -centre / force
    turn[2:, :3] = np.eye(3)
    np.testing.assert_allclose(np.concatenate([centre, mean[0, :3]]), run(factored(c, b, v), frame[None])[2][0, :5])
    wanted = (turn @ square[0] @ turn.T)[np.triu_indices(5)]
    np.testing.assert_allclose(run(factored(c, b, v), frame[None])[2][0, 5:20], wanted, rtol=1e-9)


def test_guesses_weigh_by_their_evidence():
    """By its power 0.75, which stands in docs/resultant.md."""
    rng = np.random.default_rng(5)
    some = [some_moments(rng), some_moments(rng)]
    banks = [factored(*moments, chance) for moments, chance in zip(some, (0.0, 0.7), strict=True)]
    both = Bank(*(np.concatenate(parts, axis=1 if k == 0 else 0) for k, parts in enumerate(zip(*banks, strict=True))))
    top = np.linalg.eigh(some[0][0])[1][:, -1]
    frame = 20.0 * top * np.sign(some[0][1][0] @ top) + rng.standard_normal(8)
    weights, means, squares = [], [], []
    for bank, (c, _, _) in zip(banks, some, strict=True):
        size, basis = np.linalg.eigh(c)
        total = (basis[:, -1] @ frame) ** 2 / size[-1] * c + np.eye(8)
        sign, logarithm = np.linalg.slogdet(total)
        assert sign > 0
        weights.append(np.exp(-0.5 * frame @ np.linalg.solve(total, frame) - 0.5 * logarithm + bank.chance[0]))
        mean, square, _ = run(bank, frame[None])
        means.append(mean[0])
        squares.append(square[0] - 0.012**2 * np.outer(mean[0], mean[0]))
    w = np.array(weights) ** 0.75
    w /= w.sum()
    assert 0.01 < w[0] < 0.99
    mean, square, _ = run(both, frame[None])
    wanted = w @ np.array(means)
    assert np.isfinite(wanted).all()
    np.testing.assert_allclose(mean[0], wanted, rtol=1e-9)
    apart = np.array(means) - wanted
    spread = sum(a * (s + np.outer(d, d)) for a, s, d in zip(w, squares, apart, strict=True))
    spread += 0.012**2 * np.outer(wanted, wanted)
    np.testing.assert_allclose(square[0], spread, rtol=1e-7, atol=1e-9)


def test_second_moments_are_those_of_the_pressures():
    """A guess of the bank against its loads read one by one."""
    finger = pad(shape=(2, 2))
    noise = np.asarray(finger.array.noise)
    bank = bank_of(finger, np.ones(4, dtype=bool), noise)
    some = tractions(0.15 / 0.2, 1, 2, 120)  # of the smallest size, whose lattice has steps of a fifth of a depth
    low, count = -2e-3 - DEPTH, int(np.ceil((4e-3 + 2 * DEPTH) / (0.2 * DEPTH)))
    step = 0.2 * DEPTH
    centre = -0.5 * step * (count - 1)
    assert low < centre < low + step
    fields = finger.receptive_field(np.array([centre, centre]) + some.nodes * step) / noise[:, None]
    read = np.einsum("plwc,wnc->pln", some.values, fields)
    c = np.einsum("pli,plj->ij", read, read) / 120
    kept = np.einsum("k,ki,kj->ij", bank.size[0], bank.basis[0], bank.basis[0])
    np.testing.assert_allclose(kept, c, rtol=1e-6)
    force = some.values[..., 0].sum(axis=-1)
    b = np.einsum("pl,pln->n", force, read) / 120
    np.testing.assert_allclose(np.einsum("k,ki,k->i", bank.size[0], bank.basis[0], bank.told[0, :, 0]), b, rtol=1e-6)
    assert bank.spread[0, 0, 0] == pytest.approx(1.0)
    assert bank.chance[0] == pytest.approx(2 * np.log(step))


def of_guess(bank, guess=0):
    """Second moments of the readings of a guess, as it keeps them."""
    return np.einsum("k,ki,kj->ij", bank.size[guess], bank.basis[guess], bank.basis[guess])


@pytest.mark.parametrize("what", ["gain", "depth", "position", "poisson"])
def test_what_a_tolerance_adds_to_second_moments(what):
    """Written out for the smallest guess: a share in common, the rest each sensor's own."""
    told = ss.Tolerances(**{what: 0.04}, common=0.3)
    plain = pad(ss.HalfSpace(ss.Material(0.4e6, 0.4)), (2, 2))
    noise, every = np.asarray(plain.array.noise), np.ones(4, dtype=bool)
    known, exact = (bank_of(f, every, noise) for f in (replace(plain, tolerances=told), plain))
    added = of_guess(known) - of_guess(exact)
    some, step = tractions(0.15 / 0.2, 1, 2, 120), 0.2 * DEPTH
    first = -0.5 * step * (int(np.ceil((4e-3 + 2 * DEPTH) / step)) - 1)
    at = np.array([first, first]) + some.nodes * step

    def read(finger, at=at):
        return np.einsum("plwc,wnc->pln", some.values, finger.receptive_field(at) / noise[:, None]).reshape(-1, 4)

    base = read(plain)
    if what == "gain":
        changes = [0.04 * base]
    elif what == "depth":
        changes = [read(replace(plain, array=replace(plain.array, depth=1.04 * DEPTH))) - base]
    elif what == "poisson":
        changes = [read(replace(plain, skin=ss.HalfSpace(ss.Material(0.4e6, 0.36)))) - base]
    else:
        h = 1e-6
        moves = h * np.eye(2)
        changes = [0.04 * DEPTH * (read(plain, at + move) - read(plain, at - move)) / (2 * h) for move in moves]
    common = {"poisson": 1.0, "position": 0.0}.get(what, 0.3)
    wanted = sum(common * c.T @ c + (1 - common) * np.diag((c**2).sum(axis=0)) for c in changes) / 120
    np.testing.assert_allclose(added, wanted, rtol=1e-4, atol=1e-6 * np.abs(wanted).max())


def test_a_moment_turns_and_does_not_push():
    """Of each pressure: no force of the twist, and a torsion of a quarter of the root mean square radius."""
    nodes, values = tractions(3.0, 1.0, 2, 30)
    pressure, twist = values[:, 0, :, 0], values[:, -1]
    np.testing.assert_allclose(twist.sum(axis=1), 0.0, atol=1e-12)
    away = nodes - (pressure @ nodes)[:, None]
    radius = np.sqrt((pressure[..., None] * away**2).sum(axis=(1, 2)))
    torsion = (away[..., 0] * twist[..., 2] - away[..., 1] * twist[..., 1]).sum(axis=1)
    np.testing.assert_allclose(torsion, 0.25 * radius, rtol=1e-9)


def test_the_error_of_torsion_is_that_of_draws(square):
    touch = ss.Patch(components=[4.0, 1.0, -0.8], position=(3e-3, -2e-3), half_widths=(2e-3, 1.5e-3))
    found = square.resultant(square.read(touch))
    mean, covariance = found._asked
    some = np.random.default_rng(0).multivariate_normal(mean, 1e-4 * covariance, 100_000)
    n, along, across, by_y, by_z, about = some.T
    torsion = about - by_y / n * across + by_z / n * along
    assert torsion.mean() == pytest.approx(found.torsion, abs=1e-3 * found.torsion_std)
    assert 100 * torsion.std() == pytest.approx(found.torsion_std, rel=0.02)
    for way in np.random.default_rng(1).standard_normal((5, 6)) * np.sqrt(
        np.diag(covariance)
    ):  # all errors go together
        table = found.table.copy()
        table[..., -36:] = np.outer(way, way).ravel()
        alone = Resultant(table, found.used, np.inf, found.unknowns, found.layout)
        one, two = ((q := mean + sign * 1e-6 * way)[5] - (q[3] * q[2] - q[4] * q[1]) / q[0] for sign in (1, -1))
        assert alone.torsion_std == pytest.approx(abs(one - two) / 2e-6, rel=1e-4)


def test_a_response_in_place_is_refused():
    drawn = pad(shape=(2, 2))
    at = np.stack(np.meshgrid(np.linspace(-3e-3, 3e-3, 6), np.linspace(-3e-3, 3e-3, 6)), axis=-1).reshape(-1, 2)
    measured = ss.measured.MeasuredResponse.from_touches(drawn.read(ss.PointLoad(force=1.0, position=at)), at)
    finger = ss.Finger(drawn.skin, drawn.array, measured=measured)
    with pytest.raises(InvalidValueError, match="measured in place"):
        ResultantReader(finger)
