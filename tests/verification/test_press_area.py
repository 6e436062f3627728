"""Bodies pressed on an area, against theory: Hertz, Love, Boussinesq, Cattaneo, Jaeger; and awkward ones."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ellipe, ellipk

import subskin as ss
from subskin import pressing as on

YOUNG = 0.4e6
RUBBER = ss.Material(YOUNG, 0.5)
HALF = ss.HalfSpace(RUBBER)
STIFF, SHEAR = RUBBER.plane_strain_modulus, RUBBER.shear
LAYER = ss.Layered(ss.Layer(RUBBER, 2e-3))
BALL, FORCE, RUB = on.Sphere(8e-3), 0.3, 0.5
A = np.cbrt(0.75 * FORCE * 8e-3 / STIFF)


@pytest.fixture(autouse=True)
def gentle():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.errors.ValidityWarning)
        yield


@pytest.fixture(scope="module")
def dragged():
    return ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.08, 0.0), nodes=64)


class TestClosedForms:
    def test_hertz_and_rate(self):
        errors = []
        for nodes in (64, 128):
            pressed = ss.press(HALF, BALL, force=FORCE, nodes=nodes)
            r = np.hypot(pressed.y[:, None], pressed.z)
            exact = 1.5 * FORCE / (np.pi * A**2) * np.sqrt(np.maximum(1 - (r / A) ** 2, 0))
            errors.append(np.abs(pressed.pressure - exact).sum() / exact.sum())
            assert pressed.half_width == pytest.approx([A, A], rel=0.4 / nodes)
            assert pressed.depth == pytest.approx(A**2 / 8e-3, rel=0.2 / nodes**1.5)
        assert errors[1] < 0.0015
        assert errors[0] / errors[1] > 2.2

    def test_elliptic_hertz(self):
        # Johnson (1985), (4.26) to (4.28): from the ellipse to the radii
        a, b, top = 1.5e-3, 0.6e-3, 2e4
        m = 1 - (b / a) ** 2
        k, e = ellipk(m), ellipe(m)
        along, across = (top / STIFF * b / (m * a**2) * part for part in (k - e, (a / b) ** 2 * e - k))
        body = on.Ellipsoid(radius_y=1 / (2 * across), radius_z=1 / (2 * along))
        pressed = ss.press(HALF, body, force=2 / 3 * np.pi * a * b * top, nodes=128)
        assert pressed.half_width == pytest.approx([b, a], rel=0.012)
        assert pressed.depth == pytest.approx(top * b * k / STIFF, rel=2e-4)
        assert pressed.pressure.max() == pytest.approx(top, rel=1e-3)

    def test_cone(self):
        pressed = ss.press(HALF, on.ConeTip(slope=0.15), force=FORCE, nodes=128)
        a = np.sqrt(2 * FORCE / (np.pi * STIFF * 0.15))
        assert pressed.half_width == pytest.approx([a, a], rel=0.01)
        assert pressed.depth == pytest.approx(np.pi / 2 * a * 0.15, rel=2e-3)

    def test_punch_and_its_tilt(self):
        a = 1e-3
        pressed = ss.press(HALF, on.Pin(a), force=FORCE, moment=(0.0, 3e-5), nodes=128)
        assert pressed.depth == pytest.approx(FORCE / (2 * a * STIFF), rel=8e-3)
        assert pressed.tilt == pytest.approx([0, 3 * 3e-5 / (4 * STIFF * a**3)], rel=0.02, abs=1e-9)
        assert pressed.moment == pytest.approx([0, 3e-5], rel=1e-8, abs=1e-13)

    def test_cattaneo_and_mindlin(self, dragged):
        # they leave out the drag across, which at nu = 1/2 is of this order
        share = 1 - 0.08 / (RUB * FORCE)
        radius = np.sqrt(dragged.stick.sum() * dragged.case.cell / np.pi)
        assert radius == pytest.approx(A * np.cbrt(share), rel=0.02)
        slide = 3 * RUB * FORCE * 1.5 / (16 * SHEAR * A) * (1 - share ** (2 / 3))
        assert dragged.slide == pytest.approx([slide, 0], rel=0.01, abs=1e-9)
        assert dragged.tangential == pytest.approx([0.08, 0], rel=1e-8, abs=1e-10)
        assert dragged.status.name == "OK"

    @pytest.mark.parametrize("inner", [0.8, 0.4])
    def test_jaeger(self, inner):
        # discs that turn, from the stick zone's radius out, add up to friction times Hertz's pressure beyond it:
        # Lubkin (1951), Jaeger (1995); B(s) by Abel's inversion
        top, c = 1.5 * FORCE / (np.pi * A**2), inner * A

        def part(s):
            m = 1 - (s / A) ** 2
            return RUB * top * (ellipk(m) - ellipe(m))

        moment = 8 / 3 * (part(c) * c**3 + 3 * quad(lambda s: part(s) * s**2, c, A)[0])
        pressed = ss.press(HALF, BALL, force=FORCE, friction=RUB, torsion=moment, nodes=64)
        assert pressed.twist == pytest.approx(part(c) / (2 * SHEAR), rel=3e-3)
        assert np.sqrt(pressed.stick.sum() * pressed.case.cell / np.pi) == pytest.approx(c, rel=0.02)
        assert pressed.torsion == pytest.approx(moment, rel=1e-7)


class TestHistory:
    def test_what_is_let_go_keeps_a_shear_without_a_drag(self, dragged):
        back = ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.0, 0.0), after=dragged)
        fresh = ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.0, 0.0), nodes=64)
        assert back.status.name == fresh.status.name == "OK"
        assert np.abs(back.tangential).max() < 1e-10
        assert np.abs(fresh.shear).max() < 1e-6 * fresh.pressure.max()
        # Mindlin and Deresiewicz (1953): half the drag's cube root is the new slip's inner radius
        inner = A * np.cbrt(1 - 0.08 / (2 * RUB * FORCE))
        radius = np.sqrt(back.stick.sum() * back.case.cell / np.pi)
        assert radius == pytest.approx(inner, rel=0.03)

    def test_more_than_friction_holds(self):
        pressed = ss.press(HALF, BALL, force=FORCE, friction=RUB, tangential=(0.3, 0.4), nodes=64)
        assert pressed.status.name == "SLIDES"
        assert pressed.tangential == pytest.approx(RUB * FORCE * np.array([0.6, 0.8]), rel=1e-8)


class TestSkins:
    @pytest.mark.parametrize(
        "skin",
        [
            HALF,
            ss.Layered(ss.Layer(ss.Material(YOUNG, 0.3), 2e-3)),
            ss.Layered([ss.Layer(ss.Material(2e6, 0.4), 0.5e-3), ss.Layer(RUBBER, 3e-3)]),
        ],
        ids=["half space", "layer", "firm on soft"],
    )
    def test_the_surface_follows_the_body(self, skin):
        """Displacements by the skin's own field, not by the solver's rows; at nu < 1/2 and in layers all is coupled."""
        pressed = ss.press(
            skin, BALL, force=0.1, friction=0.4, tangential=(0.015, 0.005), nodes=32, position=(1e-3, -2e-3)
        )
        assert pressed.certificate.worst < 5e-8
        i, j = np.nonzero(pressed.pressure)
        some = slice(None, None, 40)
        y, z = pressed.y[i[some]], pressed.z[j[some]]
        moved = skin.displacement(pressed.contact, 0.0, y, z)
        body = BALL.height(y - 1e-3, z + 2e-3)
        assert moved.x + body - pressed.depth == pytest.approx(0, abs=2e-7 * pressed.depth)
        stuck = pressed.stick[i[some], j[some]]
        assert stuck.any()
        assert moved.y[stuck] - pressed.slide[0] + pressed.twist * (z + 2e-3)[stuck] == pytest.approx(
            0, abs=2e-7 * pressed.depth
        )

    def test_a_finger_reads_the_solution(self):
        array = ss.SensorArray.grid(shape=(2, 2), pitch=3e-3, depth=2e-3, transducer=ss.MeanPressure())
        finger = ss.Finger(HALF, array)
        pressed = ss.press(HALF, BALL, force=FORCE, nodes=64)
        hertz = ss.RoundHertz(force=FORCE, half_width=A)
        assert pressed.contact.components == pytest.approx([FORCE, 0, 0], rel=1e-9, abs=1e-12)
        assert finger.read(pressed.contact) == pytest.approx(finger.read(hertz), rel=1e-3)
        assert finger.read(pressed.thinned(16)) == pytest.approx(finger.read(hertz), rel=1e-2)
        assert pressed.thinned(16).components == pytest.approx([FORCE, 0, 0], rel=1e-9, abs=1e-12)


def rough():
    rng, w = np.random.default_rng(1), 3e-3
    at = np.linspace(-w / 2, w / 2, 129)
    k = np.hypot(*np.meshgrid(*2 * [np.fft.fftfreq(129, w / 128)]))
    waves = np.fft.ifft2(np.fft.fft2(rng.standard_normal((129, 129))) * (k + 300) ** -1.8).real
    return on.HeightMap(at, at, waves / waves.std() * 8e-6)


def pillow(y, z):
    return 1e-6 * np.cos(3000 * y) * np.cos(3000 * z)


FACE = np.linspace(-1e-3, 1e-3, 65)
AWKWARD = {
    "rough": (rough(), {}),
    "ridged": (on.RidgedBody(BALL, 0.25e-3, 6e-6, azimuth=0.3), {}),
    "two bodies": (on.Together([BALL, on.Sphere(3e-3)], [(-2e-3, 0), (2e-3, 5e-4)], [0, 1e-5]), {}),
    "far apart": (on.Together([BALL, BALL], [(-9e-3, 0), (9e-3, 0)]), {}),
    "full contact": (on.HeightMap.from_function(pillow, FACE, FACE), {"force": 1.0}),
    "off centre": (BALL, {"position": (3e-3, -2e-3), "window": (9e-3, 6e-3)}),
    "roller askew": (on.Roller(4e-3, 2e-3, end_radius=1e-3, azimuth=0.5), {}),
    "roller's sharp ends": (on.Roller(4e-3, 2e-3), {}),
    "tilted box": (on.Box(1e-3, 0.6e-3), {"moment": (3e-5, 2e-5)}),
    "edge": (on.BoxEdge(0.2, half_length=1e-3, edge_radius=1e-4), {}),
    "corner": (on.BoxCorner(0.3), {}),
}


@pytest.mark.parametrize("skin", [HALF, LAYER], ids=["half space", "layer"])
@pytest.mark.parametrize("name", AWKWARD)
def test_awkward_shapes_are_certified(name, skin):
    body, more = AWKWARD[name]
    pressed = ss.press(skin, body, **{"force": FORCE, "nodes": 96, "max_strain": 2.0, **more})
    assert pressed.status.name == "OK"
    assert pressed.certificate.worst < 1e-8
    if name == "far apart":
        assert pressed.half_width[0] > 9e-3
