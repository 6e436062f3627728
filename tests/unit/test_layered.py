"""What a stack of layers refuses."""

from __future__ import annotations

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
