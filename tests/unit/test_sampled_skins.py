"""Skins that are sampled: their rate, their faults one frame at a time, and how an MJCF names them."""

from itertools import pairwise

import numpy as np
import pytest

import subskin as ss
from subskin.faults import SensorFaults

mujoco = pytest.importorskip("mujoco")

from subskin.mujoco import GeomSkin, SampledSkin, skins_of  # noqa: E402

FINGER = """
[skin]
young = "0.4 MPa"
kind = "half_space"

[sensors]
layout = "grid"
shape = [4, 4]
pitch = "4 mm"
depth = "2.5 mm"
noise = 2e-4
"""


def world(text: str = ""):
    custom = f'<custom><text name="skin:pad" data="{text}"/></custom>' if text else ""
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="0.001"/>{custom}<worldbody><geom name="pad" type="box" size=".01 .01 .005"/>'
        '<body pos="0 0 .0249"><freejoint/><geom type="sphere" size=".02" mass=".1"/></body></worldbody></mujoco>'
    )
    return model, mujoco.MjData(model)


def pad(noise: float = 0.0) -> ss.Finger:
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), ss.SensorArray.grid((4, 4), 4e-3, 2.5e-3, noise=noise))


def test_a_skin_keeps_its_sample_until_the_next_is_due():
    model, data = world()
    sampled = SampledSkin(GeomSkin(model, "pad", pad(), "+z"), rate=250.0)
    frames = []
    for _ in range(12):
        mujoco.mj_step(model, data)
        frames.append(sampled.read(data))
    fresh = [i for i in range(1, 12) if not np.array_equal(frames[i], frames[i - 1])]
    assert fresh == [4, 8]


def test_a_skin_that_is_asked_at_other_times_keeps_its_rate():
    model, data = world()
    sampled = SampledSkin(GeomSkin(model, "pad", pad(), "+z"), rate=250.0)
    frames = []
    for _ in range(100):
        mujoco.mj_step(model, data, 3)
        frames.append(sampled.read(data))
    fresh = sum(not np.array_equal(one, two) for one, two in pairwise(frames))
    assert fresh == pytest.approx(75, abs=2)


def test_a_clock_that_goes_back_gives_a_sample():
    model, data = world()
    sampled = SampledSkin(GeomSkin(model, "pad", pad(), "+z"), rate=100.0)
    mujoco.mj_step(model, data, 300)
    before = sampled.read(data)
    mujoco.mj_resetData(model, data)
    assert before.any()
    assert not sampled.read(data).any()


def test_the_same_seed_gives_the_same_frames_and_copies_differ():
    model, data = world()
    mujoco.mj_step(model, data, 200)
    skin = GeomSkin(model, "pad", pad(2e-4), "+z")
    faults = SensorFaults(gain=0.1, offset=1e-3)
    one, two, other = (SampledSkin(skin, None, faults, envs=2, seed=seed).read_all([data, data]) for seed in (3, 3, 4))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
    assert np.abs(one[0] - one[1]).max() > 1e-3


def test_faults_frame_by_frame_are_those_of_a_series():
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(1e-3, 0.2, 200))
    elastic = np.cumsum(rng.normal(size=(200, 5)), axis=0)
    points, offset = np.linspace(0, 1, 5)[:, None], np.arange(5.0)
    faults = SensorFaults(share=[0.1, 0.2], time=[0.3, 4.0], crosstalk=0.1, resolution=1e-3)
    series = faults.spoil(np, elastic + offset, offset, points, None, times)
    begun = faults.begin(points, np.random.default_rng(1))
    steps = np.stack([begun.step(frame, offset, time) for frame, time in zip(elastic + offset, times, strict=True)])
    assert np.abs(steps - series).max() <= 1.001e-3
    assert (steps == series).mean() > 0.99
    begun.restart()
    assert np.abs(begun.step(elastic[0] + offset, offset, 99.0) - series[0]).max() <= 1.001e-3


def test_random_faults_have_the_size_that_is_asked_for():
    n = 4000
    points, zero, one = np.arange(n)[:, None] * 1.0, np.zeros(n), np.ones(n)
    for faults, frame, time, expected in (
        (SensorFaults(gain=0.1), one, 0.0, 0.1),
        (SensorFaults(offset=0.2), one, 0.0, 0.2),
        (SensorFaults(noise=0.3), one, 0.0, 0.3),
        (SensorFaults(drift=0.1), one, 3.0, 0.3),
    ):
        begun = faults.begin(points, np.random.default_rng(5))
        begun.step(frame, zero, 0.0)
        assert begun.step(frame, zero, time).std() == pytest.approx(expected, rel=0.05)
    dead = SensorFaults(dead=0.25).begin(points, np.random.default_rng(5)).step(one, zero, 0.0)
    assert set(dead) == {0.0, 1.0}
    assert (dead == 0).mean() == pytest.approx(0.25, abs=0.03)


def test_an_mjcf_names_its_skins(tmp_path):
    (tmp_path / "pad.toml").write_text(FINGER)
    model, data = world("finger=pad.toml face=+z rate=500 gain=0.05 share=0.1,0.05 time=0.5,5")
    skins = skins_of(model, tmp_path, envs=2, seed=1)
    assert list(skins) == ["pad"]
    mujoco.mj_step(model, data, 300)
    frames = skins["pad"].read_all([data, data])
    truth = GeomSkin(model, "pad", ss.load(tmp_path / "pad.toml").finger, "+z").feel(data).read()
    assert skins["pad"].period == pytest.approx(2e-3)
    assert frames.shape == (2, 16)
    assert 0.01 < np.abs(frames - truth).max() / np.abs(truth).max() < 0.3


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("face=+z", "finger=FILE"),
        ("finger=pad.toml colour=red", "colour"),
        ("finger=pad.toml face=+z rate=fast", "SI units"),
    ],
)
def test_a_text_that_says_something_else_is_refused(tmp_path, text, said):
    (tmp_path / "pad.toml").write_text(FINGER)
    with pytest.raises(ss.SubskinError, match=said):
        skins_of(world(text)[0], tmp_path)
