"""Spectra and supports of batches of contacts."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

A = 1.25e-3


def test_batches():
    waves = np.array([0.0, 0.7, 60.0]) / A
    batch = ss.Hertz(np.array([1.0, 2.0]), 0.1, np.array([0.0, 1e-3]), half_width=A)
    seen = batch.expand(1).spectrum(waves).p
    assert seen.shape == (2, waves.size)
    assert np.allclose(seen[1], ss.Hertz(2.0, 0.1, 1e-3, half_width=A).spectrum(waves).p)
    low, high = (batch + ss.LineLoad(1.0, position=5e-3)).support
    assert low.tolist() == pytest.approx([-A, -A + 1e-3])
    assert high.tolist() == [5e-3, 5e-3]
