"""Parts of the image of the pressure: tables of hats, room for elements, both ways to the drag, and how it is drawn."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin._axes import on_touches
from subskin.estimate.pressure import _elements, _solver, mapping
from subskin.estimate.pressure._kernel import map_frames
from subskin.plot import pressure_image_figure

SKIN = ss.HalfSpace(ss.Material(young=0.4e6))
DEPTH = 2e-3


def pad(side: int = 6, noise: float = 30.0) -> ss.Finger:
    array = ss.SensorArray.grid((side, side), 0.75 * DEPTH, DEPTH, transducer=ss.MeanPressure(), noise=noise)
    return ss.Finger(SKIN, array)


@pytest.fixture(scope="module")
def uneven() -> ss.estimate.ImageMapper:
    """Sensors of two kinds at places that share no lattice, and two that do."""
    array = ss.SensorArray(
        y=np.array([0.0, 1.7e-3, -2.9e-3, 3.1e-3, 1.4e-3, 0.2e-3]),
        z=np.array([0.0, -1.1e-3, 0.4e-3, 2.3e-3, 2.1e-3, -2.6e-3]),
        depth=np.array([2e-3, 2e-3, 2e-3, 2.5e-3, 2e-3, 2e-3]),
        transducer=[*[ss.MeanPressure()] * 5, ss.NormalStrain()],
        gain=np.array([1.0, 1.0, 2.0, 1.0, -1.0, 1.0]),
        noise=np.array([*[30.0] * 5, 2e-4]),
    )
    return ss.estimate.ImageMapper(ss.Finger(SKIN, array), search=2 * ((-7e-3, 7e-3),), step=0.7e-3)


@pytest.mark.parametrize("times", [1, 2], ids=["fine", "coarse"])
def test_tables_hold_what_the_finger_reads_of_a_hat(uneven, times):
    hats = uneven._surface.hats if times == 1 else uneven._surface.hats.coarse((2, 2))
    y, z = (axis[::times] for axis in (uneven.y, uneven.z))
    assert hats.shape == (len(y) - 2, len(z) - 2)
    assert len(hats.tables) == 4 + times  # two sensors stand alike to the fine lattice, not to the coarse one
    columns = np.stack([hats.columns(i) for i in range(3)])
    for at in ((0, 0), (3, 5), (len(y) - 3, 2)):
        one = np.zeros((len(y), len(z)))
        one[at[0] + 1, at[1] + 1] = 1.0
        for i, (p, q) in enumerate(((1.0, (0.0, 0.0)), (0.0, (1.0, 0.0)), (0.0, (0.0, 1.0)))):
            felt = uneven.finger.read(ss.PressureGrid(y, z, p * one, one[..., None] * q))
            mine = columns[i, at[0] * hats.shape[1] + at[1]]
            np.testing.assert_allclose(mine, felt, rtol=1e-4, atol=1e-5 * np.abs(felt).max(), equal_nan=False)


def test_more_elements_than_there_was_room_for(monkeypatch):
    finger = pad()
    touch = ss.RoundHertz(force=[1.0, 3.0], angle=0.2, half_width=[1.5e-3, 3e-3])
    frames = finger.read(touch, np.random.default_rng(0))
    expected = ss.estimate.ImageMapper(finger)(frames)
    monkeypatch.setattr(mapping, "_ROOM", 4)
    small = ss.estimate.ImageMapper(finger)
    np.testing.assert_array_equal(small(frames).table, expected.table)
    (works,) = small._arrays[0].idle
    fine = _elements.Work(*works[0][1])
    assert (expected.pressure > 0).sum(axis=(1, 2)).max() <= len(fine.columns) < 300


@pytest.mark.parametrize("side", [6, 8])  # products in single precision at first: from 64 sensors
def test_set_and_drag_together_end_where_they_do_in_turn(side):
    finger = pad(side)
    touch = ss.RoundHertz(force=1.5, angle=0.3, azimuth=-1.0, position=(0.5e-3, 0.0), half_width=2e-3)
    mapper = ss.estimate.ImageMapper(finger)
    frame = finger.read(touch, np.random.default_rng(1))
    found = mapper(frame)
    level = _elements.Level(*mapper._arrays[0].fine)
    work = _elements.Work.of(level, side**2, level.cost.size, 1)
    t, on = np.zeros(2), np.ones(level.cost.size, dtype=bool)
    turned = _solver.Turn(np.empty((2, side**2)), np.empty((2, on.size)), np.zeros(2), np.zeros(3), np.zeros(2))
    b = frame / np.asarray(finger.array.noise)
    count, _ = _solver.in_turn(level, t, 1.0, float(found.weight), b, on, 1e-3, work, turned)
    assert count == on.sum() > 20
    drag = found.tangential_force / found.normal_force
    assert np.hypot(*(drag - t)) < 0.1 * float(found.tangential_std.max() / found.normal_force)
    assert (on == (found.pressure[1:-1, 1:-1].reshape(-1) > 0)).mean() > 0.99


def test_no_search_ends_at_a_drag_that_explains_nothing():
    """Four of these forty frames did, while a drag near the true one left a chi-square of 60."""
    rng = np.random.default_rng(0)
    where = rng.uniform(-0.5, 0.5, (40, 2)) * DEPTH
    touch = ss.RoundHertz(force=np.ones(40), angle=0.3, azimuth=0.8, position=where, half_width=DEPTH)
    clean = pad(8).read(touch)
    noise = 1e-3 * np.abs(clean).max()
    found = ss.pressure_map(pad(8, noise), clean + noise * rng.standard_normal(clean.shape))
    assert (found.status == ss.Status.OK).all()
    assert np.abs(found.angle - 0.3).max() < 0.02
    assert np.abs(found.azimuth - 0.8).max() < 0.06
    assert found.residual.max() < 64 + 6 * np.sqrt(128)


def test_a_frame_beyond_single_precision_is_judged():
    found = ss.pressure_map(pad(), np.full((2, 36), [[1e60], [np.inf]]))
    assert [ss.Status(s).name for s in found.status] == ["UNEXPLAINED", "INCOMPLETE"]


def test_the_figure_stands_as_the_array():
    finger = pad()
    found = ss.pressure_map(finger, finger.read(ss.RoundHertz(1.0, angle=0.3, half_width=2e-3)))
    origin, turn = (3e-3, -1e-3), 0.7
    axes = pressure_image_figure(found, origin=origin, turn=turn).axes[0]
    np.testing.assert_allclose(axes.lines[0].get_xydata(), 1e3 * on_touches(finger.array.points, origin, turn))
    mesh = axes.collections[0].get_coordinates()
    nodes = np.stack(np.meshgrid(found.y, found.z), axis=-1)
    np.testing.assert_allclose(mesh, 1e3 * on_touches(nodes, origin, turn))
    (arrows,) = [c for c in axes.collections if hasattr(c, "U")]
    assert np.arctan2(arrows.V, arrows.U) == pytest.approx(float(found.azimuth) + turn)


def test_the_loop_is_compiled_once_for_both_shears():
    finger = pad()
    frame, before = finger.read(ss.RoundHertz(1.0, half_width=2e-3)), len(map_frames.signatures)
    for shear in ("none", "proportional"):
        assert np.isfinite(ss.pressure_map(finger, frame, shear=shear).normal_force)
    assert len(map_frames.signatures) <= before + 1
    assert len(map_frames.signatures) <= 3  # a row, an area, and a drag that is free there
