"""A negative control: a fluid channel in silicone, a pressure sensor at each end, is no elastic skin."""

from __future__ import annotations

import re
import zipfile

import numpy as np
import pytest

import subskin as ss

FIT = ("gain", "offset", "depth", "origin")


@pytest.fixture(scope="module")
def touches(shared):
    """Position [m], the pressures of both ends, force [N] and depth [mm] of each touch."""
    path = shared / "data" / "fluid_channel" / "1D_air_dia1_0mm.xlsx"
    if not path.is_file():
        pytest.skip("needs the fluid channel in ../shared/data, which does not ship with the project")
    sheet = zipfile.ZipFile(path).read("xl/worksheets/sheet1.xml").decode()
    rows = re.findall(r"<row [^>]*>(.*?)</row>", sheet)[1:]
    x, left, right, force, depth = np.array([[float(v) for v in re.findall(r"<v>([^<]*)</v>", row)] for row in rows]).T
    return 1e-3 * x, np.stack([left, right], axis=-1), force, depth


@pytest.mark.parametrize("kind", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
@pytest.mark.parametrize("pitch", [80e-3, 100e-3])
@pytest.mark.parametrize("which", ["all, force known", "2.5 mm deep", "3 mm deep, force known"])
def test_it_is_refused(touches, kind, pitch, which):
    positions, readings, force, depth = touches
    used = {"a": np.arange(len(depth)) % 5 == 0, "2": np.isclose(depth, 2.5), "3": np.isclose(depth, 3.0)}[which[0]]
    array = ss.SensorArray.line(2, pitch=pitch, depth=5e-3, transducer=kind, noise=0.01)
    known = {"force": 100 * force[used]} if "force" in which else {}
    with pytest.raises(
        ss.errors.ConvergenceError, match=r"this is no elastic skin like the one drawn|same load|settle"
    ):
        ss.calibrate(
            ss.Finger(ss.HalfPlane(ss.Material(0.4e6)), array), readings[used], positions[used], fit=FIT, **known
        )


@pytest.mark.parametrize("kind", [ss.NormalStrain(), ss.MeanPressure()], ids=["strain", "pressure"])
@pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")
def test_accepted_all_the_same_no_frame_is_ok(touches, kind):
    positions, readings, _, depth = touches
    used = np.isclose(depth, 2.5)
    array = ss.SensorArray.line(2, pitch=80e-3, depth=5e-3, transducer=kind, noise=0.01)
    finger = ss.Finger(ss.HalfPlane(ss.Material(0.4e6)), array)
    found = ss.calibrate(finger, readings[used], positions[used], fit=FIT, accept_misfit=True)
    assert "no elastic skin" in found.misfit.verdict
    assert not found.finger.trusted
    for friction in (0.0, 1.0):
        assert not found.finger.locate(readings[used], friction=friction).ok.any()
