"""What a stack of layers refuses."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

RUBBER = ss.Material(0.4e6)


@pytest.mark.parametrize("layers", [RUBBER, [], [RUBBER], "layers", 3e-3, [ss.Layer(RUBBER, 1e-3), None]])
def test_what_is_no_layer(layers):
    with pytest.raises(ss.errors.InvalidValueError, match="one Layer or more are needed"):
        ss.Layered(layers)


def test_thicknesses_too_far_apart():
    with pytest.raises(ss.errors.GeometryError, match=r"layers of 1e-09 and 0\.003 m.*base="):
        ss.Layered([ss.Layer(RUBBER, 1e-9), ss.Layer(RUBBER, 3e-3)])
    ss.Layered([ss.Layer(RUBBER, 1e-6), ss.Layer(RUBBER, 3e-3)])


@pytest.mark.parametrize("points", [1, 9])
def test_a_batch_of_loads_reads_what_each_reads_alone(points):
    """Straight, dragged alone, both, and none; with fewer points than loads and with more."""
    skin, x, y = ss.Layered(ss.Layer(RUBBER, 4e-3)), 1.5e-3, np.linspace(-2e-3, 3e-3, points)
    components, at = np.array([[40.0, 0.0], [0.0, 0.0], [0.0, 25.0], [30.0, -10.0]]), 1e-3 * np.arange(4.0)
    together = skin.strain(ss.LineLoad.of_components(components, at).expand(1), x, y)
    for i, (load, position) in enumerate(zip(components, at, strict=True)):
        alone = skin.strain(ss.LineLoad.of_components(load, position), x, y)
        for name in ("xx", "yy", "xy"):
            expected = getattr(alone, name)
            assert getattr(together, name)[i] == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(alone.xx).max())
