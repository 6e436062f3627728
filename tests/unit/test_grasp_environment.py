"""The environment of Gymnasium: its own checker, seeds, rewards, vectors."""

import numpy as np
import pytest

pytest.importorskip("mujoco")
gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import subskin.grasp.environment as grasping  # noqa: E402
from subskin.faults import SensorFaults  # noqa: E402
from subskin.grasp import Thing  # noqa: E402

BALL = Thing("ball", (0.02, 0.02, 0.02), mass=0.2, friction=0.6)


def run(env, force: float, lifting: float = 0.5, thing: Thing = BALL) -> tuple[float, dict]:
    """The return and the last info of: grip for .6 s, then lift."""
    _, info = env.reset(seed=0, options={"thing": thing})
    total, ended, count = 0.0, False, 0
    while not ended:
        speed = 0.0 if count < 15 else lifting
        _, reward, terminated, truncated, info = env.step(np.array([2 * force / 15 - 1, speed], np.float32))
        total, ended, count = total + reward, terminated or truncated, count + 1
    return total, info


@pytest.mark.parametrize("observation", ["forces", "frames", "estimates"])
def test_gymnasiums_checker_finds_nothing(observation):
    check_env(gymnasium.make(grasping.ID, observation=observation).unwrapped, skip_render_check=True)


def test_a_good_grip_earns_more_than_none_a_weak_and_a_hard_one():
    env = gymnasium.make(grasping.ID, observation="forces")
    earned = {force: run(env, force) for force in (0.0, 1.5, 3.0, 14.0)}
    assert earned[3.0][1]["lifted"]
    assert not earned[1.5][1]["lifted"]
    assert max(earned, key=lambda force: earned[force][0]) == 3.0
    assert earned[0.0][0] == pytest.approx(0.0, abs=1e-9)


def test_sliding_and_squeezing_cost_what_is_said():
    env = gymnasium.make(grasping.ID, observation="forces")
    env.reset(seed=0, options={"thing": BALL})
    slid = 0.0
    for i in range(40):
        _, reward, _, _, info = env.step(np.array([2 * 0.8 / 15 - 1, 0.3 * (i >= 15)], np.float32))
        assert info["height"] < 1e-4  # too weak a grip: it stays on the table
        assert reward == pytest.approx(-2.0 * info["slid"] - 0.01 * 0.8 * 0.04, abs=2e-4)
        slid += info["slid"]
    assert slid > 0.01


def test_a_drop_ends_the_episode():
    env = gymnasium.make(grasping.ID, observation="forces")
    env.reset(seed=0, options={"thing": BALL})
    for i in range(60):
        force = 4.0 if i < 30 else 0.0
        _, reward, terminated, _, info = env.step(np.array([2 * force / 15 - 1, 0.5 * (i >= 10)], np.float32))
        if terminated:
            break
    assert terminated
    assert info["dropped"]
    assert reward < -0.9


def test_what_is_put_down_is_not_dropped():
    env = gymnasium.make(grasping.ID, observation="forces")
    env.reset(seed=0, options={"thing": BALL})
    heights = []
    for i in range(70):
        speed = 0.5 * (i >= 10) - 1.0 * (i >= 35)
        _, _, terminated, _, info = env.step(np.array([-0.5, speed], np.float32))
        heights.append(info["height"])
        assert not terminated
    assert max(heights) > 0.03
    assert heights[-1] < 2e-3


def test_seeds_draw_things_and_noise():
    env = gymnasium.make(grasping.ID, observation="frames", faults=SensorFaults(gain=0.1))
    seen = []
    for seed in (1, 1, 2):
        env.reset(seed=seed)
        for _ in range(12):
            observation, *_ = env.step(np.array([-0.5, 0.0], np.float32))
        seen.append((observation, env.unwrapped.thing.mass))
    assert np.array_equal(seen[0][0], seen[1][0])
    assert seen[0][1] == seen[1][1] != seen[2][1]


def test_environments_go_side_by_side():
    envs = gymnasium.make_vec(grasping.ID, num_envs=3, vectorization_mode="sync", observation="estimates")
    first, _ = envs.reset(seed=5)
    after, reward, *_ = envs.step(np.tile(np.float32([-0.8, 0.0]), (3, 1)))
    assert first.shape == after.shape == (3, 10)
    assert reward.shape == (3,)
    assert np.isfinite(after).all()
