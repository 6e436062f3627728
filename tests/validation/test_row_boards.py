"""Columns of real boards (see ../shared/data/README.md): what a row says of touches above it and beside it, unasked."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

PSI = 6894.757
FILE = "DS10_atm_6.75_10_samples_cast-bond_trial1.csv"


@pytest.mark.parametrize(("column", "sensors"), [(17.45, [0, 1, 2, 3]), (10.45, [7, 6, 5, 4])])
def test_touches_beside_the_row_are_not_sure_and_wrong_and_those_above_it_are_found(shared, column, sensors):
    path = shared / "data" / "underwater" / FILE
    if not path.is_file():
        pytest.skip("needs the underwater recordings in ../shared/data, which do not ship with the project")
    raw = np.loadtxt(path, delimiter=",", skiprows=1)
    aside, along, readings = np.abs(raw[:, 0] - column), 1e-3 * raw[:, 1], PSI * raw[:, 2:][:, sensors]
    above = np.flatnonzero(aside < 0.1)
    used = above[np.argsort(along[above], kind="stable")][1::4]
    row = ss.SensorArray.line(4, 6.75e-3, 5e-3, transducer=ss.NormalStrain(), noise=10.0)
    drawn = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), row)
    found = ss.calibrate(drawn, readings[used], along[used], fit=("gain", "lift", "depth", "origin", "position"))
    assert found.load == "point"
    located, truth = found.finger.locate(readings), found.on_finger(along)
    off, std = np.abs(located.position - truth), located.position_std
    free = np.ones(len(along), dtype=bool)
    free[used] = False
    wrong = located.ok & ((off > 2e-3) | (off > 5 * std)) & free
    y = np.asarray(found.finger.array.y)
    over = free & (aside < 0.6) & (truth > y.min()) & (truth < y.max())
    assert located.ok[over].mean() > 0.8
    assert np.median(off[over & located.ok]) < 0.3e-3
    assert (off < 1.96 * std)[over & located.ok].mean() > 0.8
    assert not wrong[over].any()
    assert wrong.sum() <= 0.002 * free.sum()  # of all touches, up to 12 mm beside the row and beyond its ends
    beside = free & (aside > 2) & (aside < 8)
    assert located.ok[beside].sum() > 20
