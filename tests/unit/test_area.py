"""Arrays on an area: where their sensors are, what they are called, what they refuse."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.errors import GeometryError, InvalidValueError
from subskin.lattice import even_grid, named_layout
from subskin.transducer import Displacement, LateralStrain, MagnetDisplacement, ShearStrain, rosette

SPACE, PLANE = ss.HalfSpace(ss.Material(0.4e6)), ss.HalfPlane(ss.Material(0.4e6))
TOUCH = ss.PointLoad(force=1.0, angle=0.3, azimuth=0.8, position=(1e-3, -2e-3))


def test_a_grid_is_in_the_order_of_its_shape():
    array = ss.SensorArray.grid(shape=(2, 3), pitch=(2e-3, 1e-3), depth=1e-3, centre=(1e-3, 5e-3))
    y, z = array.y.reshape(2, 3), array.z.reshape(2, 3)
    np.testing.assert_allclose(y, [3 * [0.0], 3 * [2e-3]], atol=1e-15)
    np.testing.assert_allclose(z, 2 * [[4e-3, 5e-3, 6e-3]])
    np.testing.assert_array_equal(array.points, np.stack([array.y, array.z], axis=-1))


@pytest.mark.parametrize("shape", [(5, 5), (4, 6), (3, 7)])
def test_a_sensor_of_a_hexagonal_grid_has_six_neighbours(shape):
    points = even_grid(shape, 2e-3, (3e-3, -1e-3), "hexagonal")
    apart = np.hypot(*(points[:, None] - points).T)
    inside = (np.abs(points - [3e-3, -1e-3]) < 0.5 * np.ptp(points, axis=0) - 1.1e-3).all(axis=1)
    assert inside.sum() > 1
    assert ((np.abs(apart - 2e-3) < 1e-12).sum(axis=1)[inside] == 6).all()
    assert apart[apart > 0].min() > 2e-3 - 1e-12
    np.testing.assert_allclose(0.5 * (points.min(axis=0) + points.max(axis=0)), [3e-3, -1e-3], atol=1e-15)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
@pytest.mark.parametrize("rows", [1, 2, 4])
def test_layouts_are_named_in_any_order(count, rows):
    shuffle = np.random.default_rng(0).permutation(count * rows)
    for layout, name in (("grid", "grid"), ("hexagonal", "hexagonal grid")):
        points = even_grid((count, rows), 2.5e-3, (1e-3, 2e-3), layout)[shuffle]
        said = named_layout(*np.repeat(points, 2, axis=0).T)
        if count * rows == 1:
            assert said == ""
        elif min(count, rows) == 1:
            assert said.startswith(f"{count} x {rows} ")
        else:
            assert said == f"{count} x {rows} {name}, pitch 2.5 mm"
            points[0] += 1e-6
            assert named_layout(*points.T) == ""


def test_channels_broadcast():
    """One value, one a channel, one a point, one for each sensor: as NumPy does."""
    kinds, points = [ss.NormalStrain(), ss.MeanPressure()], [(0.0, 0.0), (1e-3, 0.0), (0.0, 1e-3)]
    array = ss.SensorArray.at(
        points, depth=[1e-3, 2e-3], channels=kinds, noise=1e-4, gain=[[1.0], [2.0], [3.0]], offset=np.arange(6.0)
    )
    assert array.transducers == 3 * tuple(kinds)
    assert array.depth.tolist() == 3 * [1e-3, 2e-3]
    assert array.gain.tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert array.offset.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert array.points[::2].tolist() == [list(p) for p in points]
    part = array.select([1, 4])
    assert part.points.tolist() == [[0.0, 0.0], [0.0, 1e-3]]
    with pytest.raises(GeometryError, match=r"depth of shape \(4,\): it has to broadcast to \(3, 2\)"):
        ss.SensorArray.at(points, depth=[1e-3] * 4, channels=kinds)
    with pytest.raises(InvalidValueError, match="transducer beside channels"):
        ss.SensorArray.at(points, 1e-3, ss.NormalStrain(), kinds)


def test_arrays_join():
    one = ss.SensorArray.grid((2, 2), 2e-3, 1e-3, transducer=ShearStrain("xz"), noise=1e-4)
    two = ss.SensorArray.line(3, 1e-3, 2e-3, gain=2.0)
    both = ss.Finger(SPACE, one + two)
    apart = np.concatenate([ss.Finger(SPACE, array).read(TOUCH) for array in (one, two)])
    np.testing.assert_allclose(both.read(TOUCH), apart, rtol=1e-14)
    assert both.array.noise.tolist() == [1e-4] * 4 + [0.0] * 3


def test_a_row_is_what_it_was():
    """A half space reads under a long contact what a half plane reads, to the bit; at every z."""
    row = ss.SensorArray.line(5, 2e-3, 2e-3, width=1e-3)
    touch = ss.Hertz(40.0, 0.3, 0.5e-3, half_width=1e-3)
    plane = ss.Finger(PLANE, row).read(touch)
    np.testing.assert_array_equal(ss.Finger(SPACE, row).read(touch), plane)
    beside = ss.SensorArray.at(row.points + np.array([0.0, 3e-3]), 2e-3, width=1e-3)
    np.testing.assert_allclose(ss.Finger(SPACE, beside).read(touch), plane, rtol=1e-14)
    assert not row.on_area
    assert beside.on_area


def test_a_plane_refuses_an_area_and_a_local_contact():
    array = ss.SensorArray.grid((4, 4), 3e-3, 3e-3)
    with pytest.raises(GeometryError, match=r"sensors at z = -4.5 to 4.5 mm in a half plane .* Fix: HalfSpace"):
        ss.Finger(PLANE, array)
    with pytest.raises(InvalidValueError, match=r"a PointLoad on a HalfPlane: .* Fix: HalfSpace"):
        ss.Finger(PLANE, ss.SensorArray.line(4, 3e-3, 3e-3)).read(TOUCH)
    row = ss.Finger(SPACE, ss.SensorArray.line(4, 3e-3, 3e-3, transducer=Displacement()))
    with pytest.raises(InvalidValueError, match=r"Displacement\(\) under such a contact: .* Fix: a local contact"):
        row.read(ss.LineLoad(40.0))


def test_what_a_finger_shows():
    finger = ss.Finger(SPACE, ss.SensorArray.grid((4, 4), 3e-3, 3e-3, channels=rosette(), noise=1e-4))
    assert "position  4 x 4 grid, pitch 3 mm, y = -4.5 to 4.5 mm, z = -4.5 to 4.5 mm, 3 channels each" in repr(finger)
    assert "48 LateralStrain" in repr(finger)
    assert "4 x 4 grid, pitch 3 mm" in finger._repr_html_()
    loose = ss.Finger(SPACE, ss.SensorArray.at([(0.0, 0.0), (1e-3, 3e-3), (4e-3, 1e-3)], 2e-3))
    assert "position  y = 0 to 4 mm, z = 0 to 3 mm" in repr(loose)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: ShearStrain("zx"), 'plane = \'zx\': has to be "xy", "xz" or "yz"'),
        (lambda: Displacement("w"), 'axis = \'w\': has to be "x", "y" or "z"'),
        (lambda: LateralStrain("east"), "direction = 'east': a real number"),
        (lambda: MagnetDisplacement("x", 0.0, 1e-3), "moment = 0: a magnet is needed"),
        (lambda: MagnetDisplacement("x", 1.0, 0.0), "gap = 0: has to be > 0"),
        (lambda: even_grid((4,), 1e-3), r"shape = \(4,\): two counts are needed"),
        (lambda: even_grid((4, 0), 1e-3), r"shape\[1\] = 0: a whole number"),
        (lambda: even_grid((400, 400), 1e-3), "at most 10000 sensors"),
        (lambda: even_grid((4, 4), (1e-3, 2e-3), layout="hexagonal"), "one number is needed"),
        (lambda: even_grid((4, 4), 1e-3, 0.0), "a position"),
        (lambda: ss.SensorArray.at([1e-3, 2e-3], 1e-3), r"points of shape \(2,\): a position \(y, z\) for each"),
        (lambda: ss.Finger(SPACE, ss.SensorArray.grid((2, 2), 1e-3, 1e-3)).receptive_field(0.0), "a position"),
    ],
)
def test_refusals(make, said):
    with pytest.raises(ss.SubskinError, match=said):
        make()
