"""Loads far from the sensors of an area: what they could explain is bounded, and never more than the bound says."""

from __future__ import annotations

import numpy as np
import pytest
from numba import typeof

import subskin as ss
from subskin.estimate.area.far import crowded, far_from, nodes_of, regions_left
from subskin.estimate.area.tiles import Seen, boxes_beyond, nodes_beyond

D = 2e-3  # m
RUBBER = ss.Material(young=0.4e6, poisson=0.5)
HALF = 1.5 * D  # of the array


def finger_of(transducer, noise=1.0):
    return ss.Finger(ss.HalfSpace(RUBBER), ss.SensorArray.grid((4, 4), D, D, transducer=transducer, noise=noise))


def seen_by(finger, friction=1.0):
    return Seen(finger.locator().response, finger.array, D, friction)


def left_of(frames, least, tile, far, some=False):
    """The last regions left of up to eight frames (m, n), one list a frame."""
    (m, n), count = frames.shape, len(far.table)
    singles, wide = np.zeros((8, n + 1), dtype=np.float32), np.zeros((n, 8), dtype=np.float32)
    singles[:m, :n], wide[:, :m] = frames, frames.T
    asked = np.full((3, 8), np.inf, dtype=np.float32)
    asked[0, :m], asked[1, :m] = np.square(frames).sum(axis=1), least
    kept = np.zeros((count + 1, 2), dtype=np.int64)
    found = regions_left(singles, wide, asked, tile, far._replace(once=int(some)), kept)
    return [[int(i) for i, frames_of in kept[:found] if frames_of >> k & 1] for k in range(m)]


def may_reach(w, least, tile, far):
    """Whether a load of any region may explain `least` of one frame."""
    single, total = np.append(w, 0.0).astype(np.float32), float(w @ w)
    return not crowded.py_func(single, total, least, tile, far) and any(left_of(w[None], [least], tile, far, True))


def explained(basis, w):
    """The most of |w|^2 that a load explains, N and drag as they like; orthonormal bases (m, n, 3) of its readings."""
    return ((w @ basis) ** 2).sum(axis=-1)


@pytest.mark.parametrize(("friction", "leaves"), [(0.0, 0.03), (1.0, 0.003)])
@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
def test_no_far_load_explains_more_than_its_bound(transducer, friction, leaves):
    """Random positions between the boxes, loads there with some noise as readings: the worst case for a bound."""
    finger = finger_of(transducer)
    response = finger.locator().response
    inner, outer = np.array([[-HALF, HALF]] * 2) * 1.3, np.array([[-HALF, HALF]] * 2) + 6 * D * np.array([-1, 1])
    far, _ = far_from(seen_by(finger, friction), inner, outer, leaves)
    assert far.table.shape[0] > 10
    rng = np.random.default_rng(3)
    at = rng.uniform(-HALF - 6 * D, HALF + 6 * D, (20000, 2))
    at[::2] = rng.uniform(-HALF - 1.5 * D, HALF + 1.5 * D, (10000, 2))
    at = at[(np.abs(at) > 1.3 * HALF).any(axis=1)]
    spans = response(at) if friction > 0 else response(at)[..., :1]
    basis = np.linalg.qr(spans)[0]
    for k in rng.integers(0, len(at), 200):
        w = spans[k] @ rng.normal(size=spans.shape[-1])
        w = 1e3 * w / np.linalg.norm(w) + rng.normal(size=16) * rng.choice([1.0, 100.0])
        assert may_reach(w, float(explained(basis, w[None, None]).max()), 16, far)


def test_regions_are_ruled_out_where_their_bound_is_too_low():
    """The bound with its roots, by NumPy, of each region on the way; frames from those ruled out to those that are not.

    What directions take of w, and of what they leave the share that their loads may have there, add up by their roots.
    """
    finger = finger_of(ss.NormalStrain())
    inner, outer = np.array([[-HALF, HALF]] * 2) * 1.3, np.array([[-HALF, HALF]] * 2) + 6 * D * np.array([-1, 1])
    far, _ = far_from(seen_by(finger), inner, outer, 0.01)
    rng = np.random.default_rng(8)
    at = rng.uniform(-1.2 * HALF, 1.2 * HALF, (300, 2))
    frames = finger.read(ss.PointLoad(force=np.ones(300), angle=0.4, position=at))
    frames *= 300.0 / np.linalg.norm(frames, axis=1, keepdims=True)
    frames += rng.normal(size=frames.shape) * rng.choice([1.0, 40.0], (300, 1))
    found, shares = [], rng.uniform(0.5, 1.0, 300)
    for w, share in zip(frames, shares, strict=True):
        total, i, still = float(w @ w), 0, []
        while i < len(far.table):
            begin, count, after, last = far.table[i]
            taken = float(np.square(far.directions[begin : begin + count].astype(float) @ w).sum())
            leaves, rest = far.left[i], total - taken
            bound = total
            if rest > leaves * total:
                bound = (np.sqrt(taken * (1 - leaves)) + np.sqrt(rest * leaves)) ** 2
            if bound < share * total:
                i = after
                continue
            if last:
                still.append(i)
            i += 1
        found.append(still)
    least = shares * np.square(frames).sum(axis=1)
    for begin in range(0, 300, 8):
        some = slice(begin, begin + 8)
        assert left_of(frames[some], least[some], 16, far) == found[some]
        first = [still[:1] for still in found[some]]
        assert left_of(frames[some], least[some], 16, far, True) == first
    assert len({tuple(still) for still in found}) > 10
    assert 0.1 < np.mean([still == [] for still in found]) < 0.9


@pytest.mark.parametrize("transducer", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
def test_a_load_beyond_has_a_node_in_a_region_that_may_reach(transducer):
    """Of what a load beyond the search makes, a node that is looked at explains the share that its row says."""
    finger = finger_of(transducer)
    response = finger.locator().response
    search, outer = np.array([[-3.0, 3.0]] * 2) * D, np.array([[-11.0, 11.0]] * 2) * D
    _, nodes = nodes_beyond([seen_by(finger)], boxes_beyond(search, 8 * D))
    far, held = far_from(seen_by(finger), search, outer, 0.0032, 1.0)
    begin, members = nodes_of(held, nodes[:, :2])
    assert set(members) == set(range(len(nodes)))
    rng = np.random.default_rng(7)
    at = rng.uniform(-11 * D, 11 * D, (1000, 2))
    at[::2] = rng.uniform(-4.5 * D, 4.5 * D, (500, 2))
    at = at[(np.abs(at) > 3 * D).any(axis=1)]
    turn, lean = rng.uniform(-np.pi, np.pi, len(at)), rng.uniform(0, 1, len(at))
    force = np.column_stack([np.ones(len(at)), lean * np.cos(turn), lean * np.sin(turn)])
    made = np.einsum("pnj,pj->pn", response(at), force)
    made *= 1e3 / np.linalg.norm(made, axis=1, keepdims=True)
    basis, fewest = np.linalg.qr(response(nodes[:, :2]))[0], len(nodes)
    for w in made:
        total, looked = float(w @ w), []
        for i in left_of(w[None], [total], int(np.abs(w).argmax()), far)[0]:
            looked += list(members[begin[i] : begin[i + 1]])
        share = ((w @ basis[looked]) ** 2).sum(axis=-1) / total
        assert (share >= nodes[looked, 3]).any()
        fewest = min(fewest, len(set(looked)))
    assert fewest < 0.1 * len(nodes)  # most nodes are passed by


def test_of_no_region_all_nodes_are_looked_at():
    begin, members = nodes_of([], np.zeros((5, 2)))
    assert list(begin) == [0, 5]
    assert list(members) == [0, 1, 2, 3, 4]


def test_loads_are_asked_of_sensors_that_may_read_them_most():
    """Loads between the boxes by themselves: whichever sensor reads them most, they are never ruled out."""
    array = ss.SensorArray.grid((7, 7), D, D, transducer=ss.MeanPressure(), noise=1.0)
    finger = ss.Finger(ss.HalfSpace(RUBBER), array)
    inner, outer = np.array([[-3.7, 3.7]] * 2) * D, np.array([[-9.0, 9.0]] * 2) * D
    far, _ = far_from(seen_by(finger), inner, outer, 0.03)
    assert not far.seen[:-1].all()  # of some regions some sensors cannot be the strongest
    assert far.share[:-1].min() < 1.0
    rng = np.random.default_rng(6)
    at = rng.uniform(-9 * D, 9 * D, (3000, 2))
    at = at[(np.abs(at) > 3.7 * D).any(axis=1)]
    turn, lean = rng.uniform(-np.pi, np.pi, len(at)), rng.uniform(0, 1, len(at))
    force = np.column_stack([np.ones(len(at)), lean * np.cos(turn), lean * np.sin(turn)])
    made = np.einsum("pnj,pj->pn", finger.receptive_field(at), force)
    made *= 1e3 / np.linalg.norm(made, axis=1, keepdims=True)
    for w in made:
        assert may_reach(w, 0.99 * float(w @ w), int(np.abs(w).argmax()), far)


def test_most_touches_over_the_sensors_need_no_look_elsewhere():
    finger = finger_of(ss.NormalStrain())
    inner, outer = np.array([[-2.0, 2.0]] * 2) * D, np.array([[-11.0, 11.0]] * 2) * D
    far, _ = far_from(seen_by(finger), inner, outer, 0.01)
    rng = np.random.default_rng(4)
    at = rng.uniform(-HALF, HALF, (400, 2))
    frames = finger.read(ss.PointLoad(force=np.ones(400), angle=rng.uniform(0, 0.6, 400), position=at))
    frames *= 3e3 / np.linalg.norm(frames, axis=1, keepdims=True)
    needed = [may_reach(w, float(w @ w) - 100.0, int(np.abs(w).argmax()), far) for w in frames]
    assert np.mean(needed) < 0.3


def test_no_region_and_many_are_one_compilation():
    box, finger = np.array([[-2.0, 2.0]] * 2) * D, finger_of(ss.NormalStrain())
    none, many = (far_from(seen_by(finger), box, k * box, 0.03)[0] for k in (1, 3))
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
