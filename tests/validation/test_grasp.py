"""A hand that holds by its skins, in simulation: what it drops, how things slide, how hard it grips, what it learns."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss

pytest.importorskip("mujoco")

from subskin.grasp import (
    ConeHand,
    FixedHand,
    ForceHand,
    Hand,
    Phase,
    Thing,
    hand_of,
    lift,
    lifts,
    pad_finger,
    summary,
    things,
)  # fmt: skip


@pytest.fixture(scope="module")
def hand():
    made = hand_of("skin")
    made.warm_up()
    return made


@pytest.fixture(scope="module")
def lifted(hand):
    return [lift(thing, hand, i) for i, thing in enumerate(things(4, seed=11))]


def test_nothing_falls_or_slides_and_the_grip_is_near_the_least(lifted):
    came = summary(lifted)
    assert came["lifts"] == 4
    assert came["dropped"] == 0
    assert came["slid_2mm"] == 1.0
    assert came["slid_95"] < 1.6e-3
    assert 1.1 < came["grip"] < 1.5


def test_friction_is_learnt_by_slipping(lifted):
    for each in lifted:
        assert each.friction == pytest.approx(each.thing.friction, rel=0.12)


def test_a_lift_goes_through_its_phases_in_order(lifted):
    for each in lifted:
        phases = each.trace[:, 1]
        assert (np.diff(phases) >= 0).all()
        assert set(phases) == {0, 1, 2, 3, 4, 5}


def test_the_grip_follows_what_is_filled_in(lifted):
    for each in lifted:
        time, phase, asked = each.trace[:, 0], each.trace[:, 1], each.trace[:, 2]
        up = time[phase == Phase.LOWER][0] - 3.5
        quiet = asked[(time > up + 1.7) & (time < up + 1.95)].mean()
        full = asked[(time > up + 3.2) & (time < up + 3.5)].mean()
        assert full / quiet == pytest.approx(1.5, rel=0.15)


def test_a_grip_that_is_fixed_too_low_drops_and_one_too_high_wastes():
    heavy = Thing("box", (0.02, 0.02, 0.03), mass=0.5, friction=0.5)
    fingers = [pad_finger()] * 2
    least = 0.5 * 9.81 / 2 / 0.5
    assert lift(heavy, FixedHand(fingers, grip=0.8 * least)).dropped
    held = lift(heavy, FixedHand(fingers, grip=3.0 * least))
    assert not held.dropped
    assert held.waste > 2.0


def test_hands_that_know_more_grip_no_harder(lifted):
    for name in ("force", "cone"):
        told = lifts(things(4, seed=11)[::3], name)
        assert summary(told)["dropped"] == 0
        assert summary(told)["grip"] < 1.3
    assert lifts(things(1), "cone")[0].friction == things(1)[0].friction


def test_a_box_gripped_beside_its_middle_is_held_against_its_torsion(hand):
    box = Thing("box", (0.02, 0.03, 0.03), mass=0.3, friction=0.6)
    middle, beside = (lift(replace(box, off=off), hand) for off in (0.0, 8e-3))
    assert not beside.dropped
    assert beside.slid < 2e-3
    assert beside.waste > 1.3 * middle.waste


def test_the_same_seed_gives_the_same_lift(hand):
    ball = Thing("ball", (0.02, 0.02, 0.02), mass=0.1, friction=0.7)
    one, two, other = (lift(ball, hand, seed).trace for seed in (3, 3, 4))
    assert np.array_equal(one, two)
    assert not np.array_equal(one[: len(other)], other[: len(one)])


def test_the_sensors_noise_and_offsets_are_tared_away():
    finger = pad_finger()
    worn = replace(finger, array=replace(finger.array, offset=1e-4 * np.random.default_rng(0).normal(size=48)))
    box = Thing("box", (0.02, 0.02, 0.03), mass=0.2, friction=0.6)
    came = lift(box, Hand([replace(worn), replace(worn)]))
    assert not came.dropped
    assert came.slid < 2e-3


def test_readings_that_are_missing_now_and_then_do_not_matter(hand):
    ball = Thing("ball", (0.02, 0.02, 0.02), mass=0.1, friction=0.7)
    step, rng = hand.step, np.random.default_rng(0)
    hand.step = lambda frames: step([np.where(rng.random(48) < 0.05, np.nan, frame) for frame in frames])
    came = lift(ball, hand)
    del hand.step
    assert not came.dropped
    assert came.slid < 2e-3


def test_a_hand_that_holds_nothing_opens_when_it_is_lowered():
    hand = hand_of("cone")
    hand.lower()
    assert hand.step([[0.0] * 4] * 2).phase == Phase.OPEN


def test_a_hand_refuses_what_it_cannot_use():
    finger = pad_finger()
    with pytest.raises(ss.SubskinError, match="1 frames"):
        hand_of("cone").step([[0.0] * 4])
    with pytest.raises(ss.SubskinError, match="strongest"):
        ForceHand([finger] * 2, touch=1.0, strongest=0.5)
    with pytest.raises(ss.SubskinError, match="probability"):
        ConeHand([finger] * 2, probability=0.9)
    with pytest.raises(ss.SubskinError, match=r"hand.*skin"):
        hand_of("claw")
    with pytest.raises(ss.SubskinError, match="mass"):
        Thing("ball", (0.02, 0.02, 0.02), mass=-1.0, friction=0.5)
    with pytest.raises(ss.SubskinError, match="no lifts"):
        summary([])
