"""What stands in which column of an answer, and answers indexed and joined."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError
from subskin.estimate import Layout

SKIN = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.45))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=1e-3))
READINGS = FINGER.read(ss.Hertz(40.0, 0.3, np.linspace(-2e-3, 2e-3, 6), 1e-3), np.random.default_rng(0)).reshape(
    2, 3, 6
)


def fitted(readings):
    return FINGER.fit(readings, "hertz")


@pytest.fixture(scope="module", params=[FINGER.locate, fitted], ids=["line", "wide"])
def estimator(request):
    return request.param


@pytest.fixture(scope="module")
def found(estimator):
    return estimator(READINGS)


@pytest.mark.parametrize("dim", [1, 2])
@pytest.mark.parametrize("wide", [False, True])
def test_each_column_has_one_meaning(dim, wide):
    layout = Layout(dim, wide)
    unknowns = dim + dim + 1 + wide
    count = unknowns * (unknowns + 1) // 2
    starts = {
        "position": (0, dim), "components": (layout.components, dim + 1), "covariance": (layout.covariance, count),
        "interval": (layout.interval, 2 * wide), "residual": (layout.residual, 1), "rival": (layout.rival, unknowns),
        "rival_chi2": (layout.rival_chi2, 1), "status": (layout.status, 1),
    }  # fmt: skip
    if wide:
        starts["half_width"] = (layout.half_width, 1)
    taken = sorted(at + i for at, size in starts.values() for i in range(size))
    assert taken == list(range(layout.columns))
    assert layout.unknowns == unknowns
    square = layout.square
    assert np.array_equal(square, square.T)
    by_rows = [column for i in range(unknowns) for column in square[i, i:]]
    assert by_rows == list(range(layout.covariance, layout.covariance + count))


def test_the_covariance_of_the_polar_form_beside_that_of_the_components(found):
    k = found.layout.unknowns
    assert found.load.covariance.shape == (2, 3, 3, 3)
    assert found.covariance.shape == (2, 3, k, k)
    force, angle = found.force[..., None], found.angle[..., None]
    np.testing.assert_allclose(
        found.load.components, np.concatenate([force * np.cos(angle), force * np.sin(angle)], axis=-1), rtol=1e-12
    )
    # of the components from that of force and angle: the way back, by its own derivative
    back = np.zeros((2, 3, 3, 3))
    back[..., 0, 0] = 1.0
    back[..., 1, 1], back[..., 1, 2] = np.cos(found.angle), -found.force * np.sin(found.angle)
    back[..., 2, 1], back[..., 2, 2] = np.sin(found.angle), found.force * np.cos(found.angle)
    again = back @ found.covariance[..., :3, :3] @ np.swapaxes(back, -1, -2)
    np.testing.assert_allclose(again, found.load.covariance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.std**2, np.diagonal(found.covariance, axis1=-2, axis2=-1))


def test_some_frames_of_an_answer(found, estimator):
    alone = estimator(READINGS[1, 2])
    for index, shape in (((1, 2), ()), (1, (3,)), ((slice(None), 0), (2,)), (found.status >= 0, (6,))):
        part = found[index]
        assert part.shape == shape == part.force.shape
        assert np.array_equal(part.table, found.table[index], equal_nan=True)
    assert np.array_equal(found[1, 2].table, alone.table, equal_nan=True)
    assert len(found) == 2
    assert [row.shape for row in found] == [(3,), (3,)]
    with pytest.raises(ValueError, match="read-only"):
        found[0].table[:] = 0.0
    with pytest.raises(TypeError, match="no length"):
        len(alone)


def test_parts_of_a_stream_joined():
    flat = FINGER.locate(READINGS.reshape(6, 6))
    joined = ss.Estimate.join([flat[:2], flat[2:]])
    assert np.array_equal(joined.table, flat.table, equal_nan=True)
    assert np.array_equal(joined.used, flat.used)
    for parts in ([], [flat, fitted(READINGS[0])]):
        with pytest.raises(GeometryError, match="one layout"):
            ss.Estimate.join(parts)
