"""A reader's own contact on an area, in one short file: `fit`, `contact_type`, `simulate` know it by its name."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad_vec
from scipy.special import j0

import subskin as ss
from subskin.cli.main import main
from subskin.contact import LocalContact, local_families, local_family_of

D, A = 2e-3, 1.8e-3  # m
RUBBER = ss.Material(young=0.4e6, poisson=0.45)
LOAD = {"components": (1.4, 0.3, -0.2), "position": (0.5e-3, -0.4e-3)}


@pytest.fixture(autouse=True)
def ring(monkeypatch):
    """What a reader writes; what the test registers is gone after it."""
    monkeypatch.setattr(LocalContact, "_by_name", dict(LocalContact._by_name))

    class Ring(ss.contact.RoundContact, name="ring"):
        """The rim of a tube: a force spread evenly along a circle of radius a."""

        TURNS = np.exp(2j * np.pi * np.arange(96) / 96)

        def disc_pressure(self, r):
            return np.where(r == 1, np.inf, 0.0)

        def disc_spectrum(self, k):
            return j0(k)

        def disc_family(self, order, x, zeta):
            family = ss.PointLoad(force=1.0).unit_family
            return np.mean([family(order, x, zeta - t) for t in self.TURNS], axis=0)

    return Ring


@pytest.fixture
def finger():
    array = ss.SensorArray.grid((4, 4), 0.8 * D, D, transducer=ss.MeanPressure(), noise=20.0)
    return ss.Finger(ss.HalfSpace(RUBBER), array)


@pytest.mark.parametrize("skin", [ss.HalfSpace(RUBBER), ss.Layered(ss.Layer(RUBBER, 3 * D))], ids=["space", "layer"])
def test_its_field_is_that_of_its_points(ring, skin):
    """In a half space by its family, in a layer by its spectrum; beside an adaptive quadrature of point loads."""
    at = {"x": [0.6 * A, A, A], "y": [0.5e-3, 2e-3, -1e-3], "z": [-0.4e-3, 1e-3, 3e-3]}
    found = skin.stress(ring(**LOAD, half_width=A), **at)

    def of_one(turn):
        rim = LOAD["position"] + A * np.array([np.cos(turn), np.sin(turn)])
        stress = skin.stress(ss.PointLoad(components=LOAD["components"], position=rim), **at)
        return np.stack([stress.xx, stress.xy, stress.zz, stress.yz]) / (2 * np.pi)

    summed = quad_vec(of_one, 0, 2 * np.pi, epsrel=1e-10)[0]
    wanted = np.stack([found.xx, found.xy, found.zz, found.yz])
    np.testing.assert_allclose(summed, wanted, rtol=0, atol=1e-8 * np.abs(wanted).max())


def test_it_is_fitted_by_its_name(ring, finger):
    assert local_families()["ring"] is ring is local_family_of("ring")
    frames = finger.read(ring(**LOAD, half_width=[0.8 * D, 0.9 * D, 1.1 * D]), np.random.default_rng(0))
    found = finger.fit(frames, "ring")
    assert found.ok.all()
    spread = np.sqrt(np.diagonal(found.load.covariance, axis1=-2, axis2=-1))
    assert (np.abs(found.position - LOAD["position"]) < 4 * spread[:, :2]).all()
    assert (np.abs(found.load.components - LOAD["components"]) < 4 * spread[:, 2:5]).all()
    assert (spread[:, :5] < [0.01 * D, 0.01 * D, 0.01, 0.01, 0.01]).all()
    np.testing.assert_allclose(found.half_width, np.array([0.8, 0.9, 1.1]) * D, rtol=5e-3)
    assert (finger.fit(frames, "round_hertz").status == ss.Status.UNEXPLAINED).all()


def test_it_is_a_kind_among_the_others(ring, finger):
    tube = ss.decide.Kind("tube", "ring", half_width=(0.5 * D, 1.5 * D))
    kinds = (*ss.decide.usual_kinds(finger), tube)
    presses = [
        ring(**LOAD, half_width=A),
        ss.RoundHertz(**LOAD, half_width=A),
        ss.RoundPunch(**LOAD, half_width=A),
        ss.PointLoad(**LOAD),
    ]
    frames = np.stack([finger.read(touch, np.random.default_rng(0)) for touch in presses])
    said = ss.decide.contact_type(finger, frames, kinds)
    assert said.name.tolist() == ["tube", "round side", "flat side", "point"]
    assert said.half_width[0] == pytest.approx(A, rel=1e-2)


def test_its_start_has_the_second_moment_of_the_sphere(ring):
    """By hand: r^2 is a^2 on a circle, 2 a^2/5 of a sphere's pressure, 2 a^2/3 of a disc's, a^2/3 of a cone's."""
    from subskin.estimate.evidence.area import _ratio

    ratios = [_ratio(kind) for kind in (ring, ss.RoundHertz, ss.RoundPunch, ss.Cone)]
    np.testing.assert_allclose(ratios, np.sqrt([2 / 5, 1.0, 3 / 5, 6 / 5]), rtol=1e-4)


def test_it_is_simulated_by_its_name(ring, tmp_path):
    finger, table = tmp_path / "area.toml", tmp_path / "r.csv"
    array = 'layout = "grid"\nshape = [3, 3]\npitch = "2 mm"\ndepth = "2 mm"\nnoise = 1e-5\n'
    finger.write_text(f'[skin]\nkind = "half_space"\nyoung = "0.4 MPa"\n[sensors]\n{array}')
    load = ("--contact", "ring", "--half-width", "1.5 mm", "--count", "3")
    assert main(["simulate", str(finger), "-o", str(table), *load]) == 0
    assert main(["fit", str(finger), str(table), "--family", "ring"]) == 0
