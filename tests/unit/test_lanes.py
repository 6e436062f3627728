"""Eight numbers side by side: compiled, they are what NumPy makes of each by itself."""

from __future__ import annotations

import numba as nb
import numpy as np
import pytest

from subskin._lanes import EIGHT, alike, answers, eight, fetch, first_of, nought, one_of, put, root, total, where


def reckoned(a, b, out, scale):
    """All that lanes can do, from eight numbers of a and of b on: into out (9, 8) and what is one number."""
    fetch(a, 16)
    x, y = eight(a, 3), eight(b, EIGHT)
    z = x * y + scale - x / y
    z -= -x
    z *= 2.0
    put(out, 0, z)
    put(out, EIGHT, root(x * x + 1.0))
    put(out, 2 * EIGHT, where(x < y, x, 0.0))
    put(out, 3 * EIGHT, where((x > 0.0) & (y <= 1.0), alike(scale), y))
    put(out, 4 * EIGHT, where((x >= 0.5) | (y > 1.0), y, nought(x)))
    put(out, 5 * EIGHT, 1.0 / x)
    bits = answers(x < y)
    return bits, first_of(bits), total(x), one_of(y, 5)


@pytest.mark.parametrize("kind", [np.float32, np.float64])
def test_lanes_are_numpys(kind):
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=20).astype(kind), rng.normal(size=(3, EIGHT)).astype(kind)
    plain, quick = np.zeros((6, EIGHT), dtype=kind), np.zeros((6, EIGHT), dtype=kind)
    said = reckoned(a, b, plain, kind(0.7))
    assert nb.njit(error_model="numpy")(reckoned)(a, b, quick, kind(0.7)) == pytest.approx(said, rel=1e-5)
    np.testing.assert_allclose(quick, plain, rtol=30 * np.finfo(kind).eps, equal_nan=False)
    x, y = a[3 : 3 + EIGHT], b[1]
    assert said[0] == sum(1 << k for k in range(EIGHT) if x[k] < y[k])
    assert said[1] == np.argmax(x < y)
    assert said[2] == pytest.approx(x.sum(dtype=float), rel=1e-5)
    assert said[3] == y[5]
    np.testing.assert_array_equal(plain[2], [p if p < q else 0 for p, q in zip(x, y, strict=True)])


def either(x, y):
    return answers(x < y), where(x < y, root(y), nought(x))


def test_one_number_does_as_well():
    quick = nb.njit(either)
    assert quick(1.0, 4.0) == either(1.0, 4.0) == (1, 2.0)
    assert quick(4.0, 1.0) == either(4.0, 1.0) == (0, 0.0)


def test_what_is_no_number_is_in_no_order():
    ask = nb.njit(lambda a: (answers(eight(a, 0) < 1.0), answers(eight(a, 0) >= 1.0)))
    assert ask(np.array([0.0, np.nan, 2.0, -1.0, np.inf, 1.0, np.nan, 0.5])) == (0b10001001, 0b00110100)


@pytest.mark.parametrize("bits", [1, 0b10100, 0b10000000])
def test_the_first_lane_of_some(bits):
    assert nb.njit(lambda said: first_of(said))(bits) == first_of(bits) == bin(bits)[::-1].index("1")  # noqa: PLW0108
