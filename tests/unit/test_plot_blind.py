"""The figure of a calibration without known touches shows the numbers that the calibration has."""

import numpy as np
import pytest

import subskin as ss
from subskin.plot import blind_figure


@pytest.fixture(scope="module")
def found():
    skin, rng = ss.HalfPlane(ss.Material(0.4e6)), np.random.default_rng(0)
    row = {"pitch": 1.5e-3, "depth": 2e-3, "noise": 5e-5}
    drawn = ss.Finger(skin, ss.SensorArray.line(5, **row))
    real = ss.Finger(skin, ss.SensorArray.line(5, gain=[1.05, 0.95, 1.1, 1.0, 0.97], **row))
    touch = ss.LineLoad(rng.uniform(50, 200, 60), rng.uniform(-0.6, 0.6, 60), rng.uniform(-3e-3, 3e-3, 60))
    return ss.calibrate_blind(drawn, real.read(touch, rng))


def test_panels_hold_the_calibrations_numbers(found):
    figure = blind_figure(found, ["a", "b", "c", "d", "e"])
    left, right = figure.axes
    assert [t.get_text() for t in left.get_yticklabels()][:6] == [*(f"gain {c}" for c in "abcde"), "depth"]
    moved = next(line.get_xdata() for line in left.lines if line.get_marker() == "o")
    np.testing.assert_allclose(moved, [(p.value - p.drawn) / p.prior for p in found.parameters])
    half = np.diff([seg[:, 0] for seg in left.collections[0].get_segments()], axis=1)[:, 0] / 2
    np.testing.assert_allclose(half, [1.959964 * p.std / p.prior for p in found.parameters], rtol=1e-6)
    curves = {line.get_label(): line for line in right.lines if not line.get_label().startswith("_")}
    assert set(curves) == {"rms error of position", "rms error of angle"}
    for name, field in (("position", "position"), ("angle", "angle")):
        x, y = curves[f"rms error of {name}"].get_data()
        used = int(found.used.sum())
        here = np.exp(np.interp(np.log(used), np.log(x), np.log(y)))
        assert here == pytest.approx(getattr(found.error_ratio(), field), rel=2e-3)
    for axes in figure.axes:
        assert axes.get_xlabel()
    assert right.get_ylabel()


def test_normal_touches_have_one_curve(found):
    skin, rng = ss.HalfPlane(ss.Material(0.4e6)), np.random.default_rng(1)
    drawn = ss.Finger(skin, ss.SensorArray.line(4, pitch=1.5e-3, depth=2e-3, noise=5e-5))
    touch = ss.LineLoad(rng.uniform(50, 200, 40), 0.0, rng.uniform(-2e-3, 2e-3, 40))
    only = ss.calibrate_blind(drawn, drawn.read(touch, rng), friction=0)
    curves = [line.get_label() for line in blind_figure(only).axes[1].lines]
    assert "rms error of position" in curves
    assert "rms error of angle" not in curves


def test_names_have_to_match(found):
    with pytest.raises(ss.errors.GeometryError, match="one for each of the 5"):
        blind_figure(found, ["a"])
