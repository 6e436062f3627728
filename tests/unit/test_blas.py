"""Linear algebra of many small matrices goes in one thread, and what comes after it in as many as before."""

from __future__ import annotations

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

import subskin as ss
from subskin.calibration import correlated

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=1e-4))
AT = np.linspace(-4e-3, 4e-3, 12)


@pytest.mark.parametrize("fails", [False, True])
def test_a_calibration_and_what_comes_after_it(monkeypatch, fails):
    seen = []

    def likelihood(covariance, left):
        seen.append(threads())
        return 1 / (not fails), 1.0

    def threads() -> list[int]:
        return [library.get_num_threads() for library in libraries.lib_controllers]

    monkeypatch.setattr(correlated, "_likelihood", likelihood)
    libraries = ThreadpoolController().select(user_api="blas")
    with libraries.limit(limits=2):
        before = threads()
        readings = FINGER.read(ss.LineLoad(40.0, position=AT), np.random.default_rng(0))
        try:
            ss.calibrate(FINGER, readings, AT, force=40.0)
        except ZeroDivisionError:
            assert fails
        assert threads() == before
    assert seen
    assert all(one == [1] * len(before) for one in seen)
