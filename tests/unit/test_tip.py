"""What flat layers cost on a round tip: a table, looked up."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.design.tip import tip_error, tip_map
from subskin.errors import GeometryError, InvalidValueError

RUBBER = ss.Material(0.4e6)
FLAT = ss.Layered(ss.Layer(RUBBER, 4e-3))


def finger(depth=1.6e-3, kind=None, area=True):
    kind = ss.MeanPressure() if kind is None else kind
    if area:
        return ss.Finger(FLAT, ss.SensorArray.grid((4, 4), pitch=2e-3, depth=depth, transducer=kind))
    return ss.Finger(FLAT, ss.SensorArray.line(6, pitch=1.6e-3, depth=depth, transducer=kind))


def test_at_the_tables_points_it_is_the_table():
    for shape, area in (("sphere", True), ("cylinder", False)):
        table = tip_map(shape, "mean_pressure")
        i, j = list(table["radius"]).index(5.0), list(table["depth"]).index(0.4)
        found = tip_error(finger(area=area), 20e-3)
        assert found.shape == shape
        assert found.reading == pytest.approx(table["reading"][i, j], rel=1e-12)
        assert found.position == pytest.approx(1.6e-3 * table["position"][i, j], rel=1e-12)
        assert (found.force, found.angle) == pytest.approx((table["force"][i, j], table["angle"][i, j]), rel=1e-12)


def test_between_and_beyond_them():
    """Errors fall as 1 / radius where the radius is large: in the table, and beyond it."""
    for shape in ("sphere", "cylinder"):
        for kind in ("normal_strain", "mean_pressure"):
            table = tip_map(shape, kind)
            falls = table["reading"][-2] / table["reading"][-1]
            assert falls == pytest.approx(np.full(4, 2.5), rel=0.06)
    near, far = (tip_error(finger(), r).reading for r in (0.2, 0.4))
    assert near / far == pytest.approx(2.0, rel=1e-12)
    readings = [tip_error(finger(), r).reading for r in (8e-3, 9e-3, 12e-3, 14e-3, 20e-3)]
    assert (np.diff(readings) < 0).all()
    assert tip_error(finger(0.4e-3), 20e-3).reading == tip_error(finger(0.8e-3), 20e-3).reading


def test_the_cylinders_row_is_what_round_says():
    """One entry anew: readings along a row, by `Round` and by `Layered`."""
    row = finger(kind=ss.NormalStrain(), area=False)
    y = np.linspace(-4e-3, 4e-3, 41)
    true = ss.Finger(ss.Round(RUBBER, 20e-3, 16e-3), row.array).receptive_field(y)
    off = np.abs(true - row.receptive_field(y)).max(axis=(0, 1)) / np.abs(true).max(axis=(0, 1))
    assert tip_error(row, 20e-3).reading == pytest.approx(off.max(), rel=1e-3)


def test_other_sensors_get_the_worse_of_the_two():
    both = [tip_error(finger(kind=kind), 20e-3) for kind in (ss.NormalStrain(), ss.MeanPressure())]
    other = tip_error(finger(kind=ss.NormalStress()), 20e-3)
    assert other.reading == max(each.reading for each in both)
    assert other.kinds == ("mean_pressure", "normal_strain")


def test_what_it_does_not_know_is_refused():
    with pytest.raises(GeometryError, match="begins at 2 thicknesses"):
        tip_error(finger(), 7e-3)
    with pytest.raises(InvalidValueError, match="flat layer on a rigid base"):
        tip_error(ss.Finger(ss.Round(RUBBER, 8e-3, 4e-3), finger(area=False).array), 20e-3)
    with pytest.raises(InvalidValueError, match="sphere"):
        tip_error(finger(), 20e-3, "cone")
    with pytest.raises(InvalidValueError, match="mean_pressure"):
        tip_map("sphere", "shear_strain")
