"""What must be true of sensors under local contacts: one body for the skins that take them, by tests/_tables.py."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import subskin as ss
from subskin.estimate import Status
from subskin.transducer import Displacement, MagnetDisplacement, rosette

from .._tables import LOCAL, LOCAL_TRANSDUCERS, SKINS, SOFT, A
from ._contract import panels

LOOSE = ("loose layer", "sliding epidermis")
"""Skins that a drag moves without end: sensors of displacement do not read it."""
TAKING = {name: skin for name, skin in SKINS.items() if skin.takes_local and name not in LOOSE}
KINDS = list(LOCAL_TRANSDUCERS.values())
LINEAR = [kind for kind in KINDS if kind.linear]
rng = np.random.default_rng(5)
POINTS = A * rng.uniform(-2.0, 2.0, (6, 2))
DEPTHS = A * rng.uniform(0.5, 2.2, 6)

each_skin = pytest.mark.parametrize("skin", TAKING)
each_contact = pytest.mark.parametrize("contact", LOCAL)
some = pytest.mark.parametrize("contact", ["twisted", "patch"])


@cache
def felt(skin, contact, p=1.0):
    return TAKING[skin].state(LOCAL[contact](p=p), DEPTHS, *POINTS.T)


def sensors(skin, kinds, turn=0.0, **more):
    """All kinds at each of the points; turned about the origin from +y to +z, the gauges with them [rad]."""
    c, s = np.cos(turn), np.sin(turn)
    array = ss.SensorArray.at(POINTS @ [[c, s], [-s, c]], np.minimum(DEPTHS, skin.thickness)[:, None], channels=kinds)
    return ss.Finger(
        skin, array if not more else ss.SensorArray.at(array.points, array.depth, array.transducers, **more)
    )


@each_skin
@some
@pytest.mark.parametrize("kind", LOCAL_TRANSDUCERS)
def test_a_transducer_and_its_linear_part(kind, skin, contact):
    """Linear is what grows with the load and turns with its sign; else its linear part is its slope at no load."""
    kind = LOCAL_TRANSDUCERS[kind]
    full = kind.measure(felt(skin, contact))
    if kind.linear:
        for share in (2.0, -1.0):
            np.testing.assert_allclose(kind.measure(felt(skin, contact, share)), share * full, rtol=1e-12)
        assert kind.linear_part == kind
        return
    if not kind.linear_part.linear:
        with pytest.raises(ss.errors.NotLinearError, match=type(kind).__name__):
            sensors(TAKING[skin], [kind]).receptive_field((0.0, 0.0))
        return
    slope = kind.linear_part.measure(felt(skin, contact))
    up, down = (kind.measure(felt(skin, contact, p)) for p in (1e-3, -1e-3))
    assert np.abs((up - down) / 2e-3 - slope).max() < 1e-4 * np.abs(slope).max()
    assert np.abs(kind.measure(felt(skin, contact, 0.2)) - 0.2 * slope).max() > 1e-4 * np.abs(slope).max()


@each_skin
@each_contact
def test_a_finger_reads_what_its_transducers_measure_where_they_are(skin, contact):
    finger, state = sensors(TAKING[skin], KINDS), felt(skin, contact, 0.1)
    assert len(finger.array) == len(POINTS) * len(KINDS)
    read = finger.read(LOCAL[contact](p=0.1)).reshape(len(POINTS), -1)
    for kind, seen in zip(KINDS, read.T, strict=True):
        expected = kind.measure(state)
        np.testing.assert_allclose(seen, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("skin", LOOSE)
def test_a_drag_on_a_layer_that_slides_is_read_as_strain_but_not_as_displacement(skin):
    touch = ss.PointLoad(components=(1.0, 0.3, 0.1))
    strains = [kind for kind in KINDS if not isinstance(kind, Displacement | MagnetDisplacement)]
    assert np.isfinite(sensors(SKINS[skin], strains).read(touch)).all()
    for kind in (Displacement("y"), MagnetDisplacement("x", 5e-3, 4e-3)):
        with pytest.raises(ss.errors.InvalidValueError, match="moves without end"):
            sensors(SKINS[skin], [kind]).read(touch)
        assert np.isfinite(sensors(SKINS[skin], [kind]).read(ss.PointLoad(1.0))).all()


@each_skin
def test_a_wide_sensor_reads_the_mean_along_y(skin):
    skin, contact, kinds = TAKING[skin], LOCAL["round hertz"](p=0.1), LINEAR
    finger = sensors(skin, kinds, width=0.8 * A)
    t, weight = panels(np.linspace(-0.5, 0.5, 5))
    state = skin.state(contact, DEPTHS[:, None], POINTS[:, :1] + 0.8 * A * t, POINTS[:, 1:])
    for kind, seen in zip(kinds, finger.read(contact).reshape(len(POINTS), -1).T, strict=True):
        expected = kind.measure(state) @ weight
        np.testing.assert_allclose(seen, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


@each_skin
def test_receptive_fields_are_what_readings_change_by(skin):
    """And readings of two contacts, of a batch of them, are those of each."""
    finger, components = sensors(TAKING[skin], LINEAR, gain=2.0, offset=0.5), np.array([0.7, -0.2, 0.4])
    at = A * np.array([[(0.3, -0.2), (1.0, 0.4)], [(0.0, 0.0), (-1.2, 2.0)]])
    fields = finger.receptive_field(at, load="point")
    assert fields.shape == (2, 2, len(finger.array), 3)
    change = finger.read(ss.PointLoad(components=components, position=at)) - 0.5
    size = np.abs(fields).max(axis=(0, 1, 3))
    assert np.abs(fields @ components - change).max(axis=(0, 1)) / size == pytest.approx(0.0, abs=1e-12)
    one, two = LOCAL["ellipse"](), LOCAL["patch"]()
    alone, beside, together = (finger.read(c) - 0.5 for c in (one, two, one + two))
    assert np.abs(together - alone - beside) / size == pytest.approx(0.0, abs=1e-11)


@each_skin
def test_what_turns_with_its_touch_reads_the_same(skin):
    """An isotropic skin knows no direction: contact, sensors, gauges and axes turned together."""
    skin, turn = TAKING[skin], 0.6
    scalars = [k for k in KINDS if type(k) not in (ss.LateralStrain, ss.ShearStrain, Displacement, MagnetDisplacement)]
    scalars += [Displacement("x"), MagnetDisplacement("x", 5e-3, 4e-3, exact=True)]
    build = LOCAL["twisted"]
    here = sensors(skin, [*scalars, *rosette(), Displacement("y"), Displacement("z")]).read(build(p=0.3))
    gauges = [ss.LateralStrain(k.direction + turn) for k in rosette()]
    there = sensors(skin, [*scalars, *gauges, Displacement("y"), Displacement("z")], turn=turn).read(
        build(turn=turn, p=0.3)
    )
    here, there = (a.reshape(len(POINTS), -1) for a in (here, there))
    np.testing.assert_allclose(there[:, :-2], here[:, :-2], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(there[:, -2:] @ [1, 1j], here[:, -2:] @ [1, 1j] * np.exp(1j * turn), rtol=1e-9)


@each_skin
def test_gauges_stretch_as_the_skin_moves(skin):
    """Strain along a direction and shear in a plane, by differences of the displacement of the eighth order."""
    state = felt(skin, "twisted")
    skin, contact, h = TAKING[skin], LOCAL["twisted"](), 0.02 * A
    steps, weights = h * np.arange(-4, 5), np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / (840 * h)

    def along(x, y, z):
        """d u_i / d s along a direction, shape (6, 3)."""
        shift = np.outer([x, y, z], steps)
        moved = skin.displacement(
            contact, DEPTHS[:, None] + shift[0], POINTS[:, :1] + shift[1], POINTS[:, 1:] + shift[2]
        )
        return np.stack([moved.x, moved.y, moved.z], axis=-1).swapaxes(1, 2) @ weights

    for t in (0.0, 0.7, 2.0):
        direction = np.array([0.0, np.cos(t), np.sin(t)])
        np.testing.assert_allclose(
            ss.LateralStrain(t).measure(state), along(*direction) @ direction, rtol=1e-7, atol=1e-9
        )
    by = [along(*axis) for axis in np.eye(3)]
    for plane in ("xy", "xz", "yz"):
        i, j = ("xyz".index(axis) for axis in plane)
        np.testing.assert_allclose(
            ss.ShearStrain(plane).measure(state), by[i][:, j] + by[j][:, i], rtol=1e-7, atol=1e-9
        )
    for j, seen in ((1, state.tilt.y), (2, state.tilt.z)):  # and how far it turns: half the curl
        np.testing.assert_allclose(seen, 0.5 * (by[0][:, j] - by[j][:, 0]), rtol=1e-7, atol=1e-9)


def test_the_field_of_a_magnet_is_that_of_two_poles():
    """A dipole is two poles close together: mu_0 / 4 pi times q r / r^3 of each, m = q times their distance."""
    moment, gap, apart = 5e-3, 4e-3, 1e-6
    state = felt("half space", "point", 2.0)
    moved = np.stack([state.displacement.x, state.displacement.y, state.displacement.z], axis=-1)
    assert np.abs(moved).max() > 0.05 * gap  # far from linear
    upright = np.array([1.0, 0.0, 0.0])

    def field(u, way):
        out = np.zeros(np.shape(u))
        for sign in (1, -1):
            r = np.array([gap, 0.0, 0.0]) - 0.5 * sign * apart * way - u
            out = out + sign * 1e-7 * moment / apart * r / np.linalg.norm(r, axis=-1, keepdims=True) ** 3
        return out

    turn = np.stack([0 * state.tilt.y, -state.tilt.z, state.tilt.y], axis=-1)  # what turns x towards y and z
    assert np.abs(turn).max() > 0.1
    leaning = Rotation.from_rotvec(turn).apply(upright)
    for way, tilts in ((upright, False), (leaning, True)):
        expected = field(moved, way) - field(np.zeros(3), upright)
        for k, axis in enumerate("xyz"):
            seen = MagnetDisplacement(axis, moment, gap, exact=True, tilts=tilts).measure(state)
            np.testing.assert_allclose(seen, expected[:, k], rtol=1e-6, atol=1e-6 * np.abs(expected).max())
    below = MagnetDisplacement("x", moment, gap=0.1 * float(moved[:, 0].min()), exact=True).measure(state)
    assert np.isnan(below).all()


@each_skin
def test_a_magnet_that_tilts(skin):
    """What is linear is the slope of the whole at no load; on an array it is what is measured where the sensors are."""
    kinds = [MagnetDisplacement(axis, 5e-3, 4e-3, exact=True, tilts=True) for axis in "xyz"]
    for whole in kinds:
        up, down = (whole.measure(felt(skin, "twisted", p)) for p in (1e-3, -1e-3))
        slope, upright = (
            kind.linear_part.measure(felt(skin, "twisted")) for kind in (whole, replace(whole, tilts=False))
        )
        assert np.abs((up - down) / 2e-3 - slope).max() < 1e-4 * np.abs(slope).max()
        assert (np.abs(slope - upright).max() > 0.1 * np.abs(slope).max()) == (whole.axis != "x")
    kinds = [kind.linear_part for kind in kinds]
    read = sensors(TAKING[skin], kinds).read(LOCAL["twisted"]()).reshape(len(POINTS), -1)
    expected = np.stack([kind.measure(felt(skin, "twisted")) for kind in kinds], axis=1)
    np.testing.assert_allclose(read, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())


def test_magnets_locate_a_touch():
    """Three axes beneath each of four magnets that tilt: errors as large as the covariance says, none gross."""
    kinds = [MagnetDisplacement(axis, 5e-3, 4e-3, tilts=True) for axis in "xyz"]
    array = ss.SensorArray.grid((2, 2), pitch=3e-3, depth=2e-3, channels=kinds, noise=1e-5)
    rng, count = np.random.default_rng(0), 400
    at, drag = 1.5e-3 * rng.uniform(-1, 1, (count, 2)), rng.uniform(-0.4, 0.4, (count, 2))
    touch = ss.PointLoad(components=np.column_stack([np.ones(count), drag]), position=at)
    finger = ss.Finger(ss.HalfSpace(SOFT), array)
    found = finger.locate(finger.read(touch, rng=rng))
    assert (found.status == Status.OK).all()
    off = np.concatenate([found.position - at, found.load.components - touch.components], axis=1)
    squares = np.einsum("ni,nij,nj->n", off, np.linalg.inv(found.load.covariance), off)
    assert squares.mean() == pytest.approx(5, abs=4 * np.sqrt(10 / count))
    assert (np.hypot(*off[:, :2].T) < 0.3e-3).all()


def rank(finger, z):
    """Of the five unknowns of a point force (N, Ty, Tz, y, z), how many the readings tell."""
    load, h = np.array([1.0, 0.3, -0.2]), 1e-5
    at = np.array([0.2e-3, z])
    moves = [(finger.receptive_field(at + d, "point") - finger.receptive_field(at - d, "point")) @ load / (2 * h)
             for d in h * np.eye(2)]  # fmt: skip
    columns = np.column_stack([finger.receptive_field(at, "point"), *moves])
    return np.linalg.matrix_rank(columns / np.linalg.norm(columns, axis=0), tol=1e-6)


def test_mixed_sensors_tell_all_five_unknowns():
    """Memo section 8 asks for sensors that combine surface shear, depth strain and deflection.

    On one straight line all strains together tell four of five (docs: theory); the deflection tells the fifth.
    """
    skin = ss.HalfSpace(SOFT)
    kinds, depths = [ss.ShearStrain("xy"), ss.ShearStrain("xz"), ss.NormalStrain()], [0.5e-3, 0.5e-3, 2e-3]
    for count in (3, 5):
        strains = ss.SensorArray.line(count, 2e-3, [2e-3, 2e-3, 2e-3], channels=kinds)
        mixed = ss.SensorArray.line(count, 2e-3, [*depths, 1e-3], channels=[*kinds, Displacement("z")])
        assert rank(ss.Finger(skin, strains), z=0.8e-3) == 4
        assert rank(ss.Finger(skin, mixed), z=0.8e-3) == 5
    area = ss.SensorArray.grid((2, 2), 2e-3, [*depths, 1e-3], channels=[*kinds, Displacement()])
    assert rank(ss.Finger(skin, area), z=0.8e-3) == 5
    assert rank(ss.Finger(skin, ss.SensorArray.grid((2, 3), 2e-3, 2e-3)), z=0.3e-3) == 5
