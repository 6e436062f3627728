"""Fingers with sensors on an area, on recordings of real skins (see ../shared/data/README.md)."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.estimate.area import InPlaceLocator
from subskin.measured import MeasuredResponse

PSI = 6894.757
BOARDS = [
    ("DS10_atm_6.75_10_samples_cast-bond_trial1.csv", 1, 6.75e-3, 0.4, 1.0),
    ("DS20_25PSI_9.9_10_samples_cast-bond_trial1.csv", 0, 9.9e-3, 0.8, 2.0),
]


def touches_of(shared, file, header):
    """Positions [m] and readings [Pa] of a board, which do not ship with the project."""
    path = shared / "data" / "underwater" / file
    if not path.is_file():
        pytest.skip("needs the underwater recordings in ../shared/data, which do not ship with the project")
    raw = np.loadtxt(path, delimiter=",", skiprows=header)
    return 1e-3 * raw[:, :2], PSI * raw[:, 2:]


def drawn(pitch):
    y = pitch * np.repeat([0.5, -0.5], 4)
    z = pitch * np.array([-1.5, -0.5, 0.5, 1.5, 1.5, 0.5, -0.5, -1.5])
    array = ss.SensorArray(y=y, z=z, depth=6e-3, transducer=ss.NormalStrain(), noise=20.0)
    return ss.Finger(ss.HalfSpace(ss.Material(young=0.3e6)), array)


def spread_out(at, side, seed):
    """One touch in the middle half of each of side x side cells."""
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2)
    inner = np.random.default_rng(seed).uniform(0.25, 0.75, (side**2, 2))
    chosen = at.min(axis=0) + (cells + inner) / side * np.ptp(at, axis=0)
    return np.argmin(((at - chosen[:, None]) ** 2).sum(axis=-1), axis=1)


@pytest.mark.parametrize(("file", "header", "pitch", "median", "most"), BOARDS)
def test_four_touches_calibrate_a_board_that_is_not_sure_and_wrong(shared, file, header, pitch, median, most):
    at, readings = touches_of(shared, file, header)
    wrong, held = [], []
    for seed in range(3):
        used = spread_out(at, 2, seed)
        found = ss.calibrate(drawn(pitch), readings[used], at[used], fit=("gain", "depth", "origin", "turn"))
        assert not found.weak.any()  # all eight work
        rest = np.setdiff1d(np.arange(len(at)), used)[seed::12]
        located = found.finger.locate(readings[rest], friction=0)
        off, ok = located.position - found.on_finger(at[rest]), located.ok
        std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[:, :2])
        wrong.append(np.mean(ok & ((np.linalg.norm(off, axis=1) > 2e-3) | (np.abs(off) > 5 * std).any(axis=1))))
        held.append(np.abs(off[ok]) <= 1.96 * std[ok])
        assert ok.mean() > 0.05
    assert np.mean(wrong) <= 0.03
    assert np.mean(np.concatenate(held)) >= 0.88


@pytest.mark.parametrize(("file", "header", "pitch", "median", "most"), BOARDS)
def test_sixteen_touches_calibrate_a_board_of_barometers(shared, file, header, pitch, median, most):
    at, readings = touches_of(shared, file, header)
    used, finger = spread_out(at, 4, 1), drawn(pitch)
    found = ss.calibrate(finger, readings[used], at[used], fit=("gain", "depth", "origin", "turn"))
    rest = np.setdiff1d(np.arange(len(at)), used)
    assert np.median(found.evaluate(readings[rest], at[rest]).r2_sensor) > 0.985

    rest = rest[::4]
    truth, points = found.on_finger(at[rest]), found.finger.array.points
    inside = ((truth >= points.min(axis=0)) & (truth <= points.max(axis=0))).all(axis=1)
    located = found.finger.locate(readings[rest], friction=0)
    off = located.position - truth
    far, both = 1e3 * np.linalg.norm(off, axis=1), inside & (located.status == ss.Status.OK)
    std = np.sqrt(np.diagonal(located.load.covariance, axis1=1, axis2=2)[:, :2])
    assert np.nanmedian(far[inside]) < median
    assert np.quantile(far[both], 0.95) < most
    assert both.sum() > 0.5 * inside.sum()
    wrong = both & (far > 2) & (np.abs(off) > 3 * std).any(axis=1)
    assert wrong.sum() <= 0.01 * inside.sum()
    assert 0.88 <= np.mean(np.abs(off[both]) <= 1.96 * std[both])


def test_a_table_of_every_second_row_of_a_lattice_of_magnets(shared):
    path = shared / "data" / "eflesh" / "spatial_20250317" / "touches.csv"
    if not path.is_file():
        pytest.skip("needs the eflesh recordings in ../shared/data, which do not ship with the project")
    raw = np.loadtxt(path, delimiter=",", skiprows=1)
    at, readings = 1e-3 * np.round(raw[:, 1:3], 2), raw[:, 4:]
    row = np.round(1e3 * (at - at.min(axis=0))).astype(int)
    used = row[:, 0] % 2 == 0
    assert used.sum() == 1200
    table = MeasuredResponse.from_touches(readings[used], at[used])
    assert np.abs(table.correlation - np.eye(15)).max() > 0.3
    rest = np.flatnonzero(~used)[::3]
    located = InPlaceLocator(table, friction=0, normal_force=(1.0, 1.0))(readings[rest])
    far = 1e3 * np.linalg.norm(located.position - at[rest], axis=1)[located.ok]
    assert located.ok.mean() > 0.8
    assert np.median(far) < 0.32
    assert np.quantile(far, 0.95) < 1.0
