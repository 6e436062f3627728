"""Maps by fast Fourier transforms beside the field point by point."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError

from .._tables import LOCAL, SKINS, SOFT, A
from .test_local_contacts import tensor, vector

HALF_SPACE = SKINS["half space"]
Y, Z = A * np.linspace(-3, 4, 15), A * np.linspace(-2, 5, 8)
CASES = [
    *(("half space", name, 1.3) for name in LOCAL),
    ("half space", "patch", 0.6),
    ("layer-0.5", "slip", 3.0),
    ("loose layer", "twisted", 1.3),
    ("on a half plane", "patch", 1.3),
]


def agree(skin, contact, x, y, z, bar=1e-11):
    """All components at all points, beside the largest of the map."""
    found, expected = skin.map(contact, x, y, z), skin.state(contact, x, np.reshape(y, (-1, 1)), z)
    pairs = [(tensor(found.stress), tensor(expected.stress)), (tensor(found.strain), tensor(expected.strain))]
    if expected.displacement is not None:
        pairs.append((vector(found.displacement), vector(expected.displacement)))
    else:
        assert found.displacement is None
    for seen, wanted in pairs:
        assert seen.shape == wanted.shape
        assert np.abs(seen - wanted).max() < bar * np.abs(wanted).max()


@pytest.mark.parametrize(("skin", "name", "depth"), CASES)
def test_a_map_is_the_field_at_its_points(skin, name, depth):
    agree(SKINS[skin], LOCAL[name](), depth * A, Y, Z)


def test_no_image_is_left_where_the_field_falls_slowest():
    """Displacement, which falls as 1/R, of a contact beside a map, on points farther apart than the map is deep."""
    touch = ss.PointLoad(components=(1.0, 0.4, -0.3), position=(9 * A, -7 * A))
    agree(HALF_SPACE, touch, 0.9 * A, A * np.array([-2.0, 0.0, 2.0]), A * np.array([0.3]))


def test_frames_are_as_one_by_one():
    y, z = A * np.linspace(-1, 1, 4), A * np.linspace(-0.8, 0.8, 3)
    pressure = np.random.default_rng(0).uniform(0, 1e4, (2, 1, 4, 3))
    shear = np.stack([0.3 * pressure, -0.2 * pressure], axis=-1)
    frames = HALF_SPACE.map(ss.PressureGrid(y, z, pressure, shear), A, Y, Z)
    assert frames.stress.xx.shape == (2, 1, Y.size, Z.size)
    for i in range(2):
        one = HALF_SPACE.map(ss.PressureGrid(y, z, pressure[i, 0], shear[i, 0]), A, Y, Z)
        np.testing.assert_allclose(tensor(frames.stress)[:, i, 0], tensor(one.stress), rtol=0, atol=1e-9)
    none = HALF_SPACE.map(ss.PressureGrid(y, z, np.zeros((4, 3))), A, Y, Z)
    assert not tensor(none.stress).any()


class Bare(ss.PointLoad):
    """A contact whose class says no spectrum."""

    spectrum = ss.LocalContact.spectrum


@pytest.mark.parametrize(
    ("skin", "contact", "x", "y", "error", "words"),
    [
        (HALF_SPACE, ss.LineLoad(1.0), A, Y, InvalidValueError, "same at every z"),
        (ss.HalfPlane(SOFT), ss.PointLoad(1.0), A, Y, InvalidValueError, "solved in a plane"),
        (HALF_SPACE, Bare(1.0), A, Y, InvalidValueError, "maps need it"),
        (HALF_SPACE, ss.PointLoad(1.0), 0.0, Y, InvalidValueError, "points of the surface"),
        (SKINS["layer-0.5"], ss.PointLoad(1.0), 5 * A, Y, GeometryError, "thick"),
        (HALF_SPACE, ss.PointLoad(1.0), A, A * np.array([0.0, 1.0, 3.0]), GeometryError, "ascend evenly"),
        (HALF_SPACE, ss.PointLoad(1.0), A, Y[::-1], GeometryError, "ascend evenly"),
        (HALF_SPACE, ss.PointLoad(1.0), A, Y[:, None], GeometryError, "row of points"),
        (HALF_SPACE, ss.PointLoad(1.0), 1e-3 * A, Y, GeometryError, "a smaller map"),
    ],
)
def test_doors(skin, contact, x, y, error, words):
    with pytest.raises(error, match=words):
        skin.map(contact, x, y, Z)
