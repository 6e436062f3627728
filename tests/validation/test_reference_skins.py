"""Layers and the round finger against amplitudes of 22 digits, found by 60-digit propagators that share no formula."""

from __future__ import annotations

import json

import numpy as np
import pytest

import subskin as ss
from subskin.skin._layer_modes import Sheet, Stack
from subskin.skin._ring_modes import Ring

TOLERANCE = 1e-10  # of the largest component at the point


def worst(seen, expected):
    """Largest error of the components over the largest of them."""
    expected = np.array([float(v) for v in expected])
    return np.abs(np.array(seen) - expected).max() / np.abs(expected).max()


@pytest.fixture(scope="module")
def bonded(shared):
    return json.loads((shared / "reference" / "09a_bonded_layer_transfer.json").read_text())["points"]


@pytest.fixture(scope="module")
def rings(shared):
    return json.loads((shared / "reference" / "10a_annulus_modes.json").read_text())["points"]


def test_bonded_layer(bonded):
    assert len(bonded) > 100
    for point in bonded:
        nu, k, height, depth = (float(point[name]) for name in ("nu", "k", "H", "d"))
        shear = 1 / (1 + nu)  # E = 2
        stack = Stack((Sheet(nu, shear, height, True),), None)
        y = stack.amplitudes(np.array([k]), np.array([depth]))[0, 0]
        for load, name in enumerate(("normal_p_cos", "tangential_q_sin")):
            expected = [point[name][key] for key in ("ux", "uy", "sx", "txy")]
            seen = [*(y[:2, load] / (2 * shear)), *y[2:, load]]
            assert worst(seen, expected) < TOLERANCE, point
            # each by itself too, in the soft directions where others are larger by orders
            for value, reference in zip(seen, expected, strict=True):
                if abs(float(reference)) > 1e-9 * max(abs(float(e)) for e in expected):
                    assert value == pytest.approx(float(reference), rel=1e-6), point


def test_layer_cut_in_two_is_the_same(bonded):
    for point in bonded[::7]:
        nu, k, height, depth = (float(point[name]) for name in ("nu", "k", "H", "d"))
        shear = 1 / (1 + nu)
        layers = tuple(Sheet(nu, shear, share * height, True) for share in (0.3, 0.45, 0.25))
        y = Stack(layers, None).amplitudes(np.array([k]), np.array([depth]))[0, 0]
        for load, name in enumerate(("normal_p_cos", "tangential_q_sin")):
            expected = [point[name][key] for key in ("ux", "uy", "sx", "txy")]
            assert worst([*(y[:2, load] / (2 * shear)), *y[2:, load]], expected) < TOLERANCE, point


def test_surface_compliance_of_a_layer(bonded):
    for point in bonded:
        if float(point["d"]) == 0:
            skin = ss.Layered(ss.Layer(ss.Material(2.0, float(point["nu"])), float(point["H"])))
            c = skin.surface_compliance(float(point["k"]))
            for load, name in enumerate(("normal_p_cos", "tangential_q_sin")):
                expected = [float(point[name][key]) for key in ("ux", "uy")]
                assert c[:, load] == pytest.approx(expected, rel=1e-9, abs=1e-13)


def test_annulus(rings):
    assert len(rings) > 50
    compared = 0
    for point in rings:
        nu, n, radius, core, r = (float(point[name]) for name in ("nu", "n", "R", "Rc", "r"))
        shear, harmonic = 1 / (1 + nu), np.array([n])
        ring = Ring((Sheet(nu, shear, radius - core, True),), radius)
        stress = ring.amplitudes(harmonic, np.array([radius - r]))[0, 0]
        for load, name in enumerate(("p_cos", "q_sin" if n else "q_cos")):
            if name in point:
                reference = point[name]
                expected = [float(reference[key]) for key in ("srr", "srt", "ett")]
                seen = [stress[0, load], -stress[1, load], stress[2, load] / (2 * shear)]
                scale = max(abs(float(v)) for v in reference.values())
                assert np.abs(np.array(seen) - expected).max() < TOLERANCE * scale, point
                if r == radius:
                    u = stress[3:, load] / (2 * shear)
                    expected = [-float(reference["ur"]), float(reference["ut"])]
                    assert np.abs(u - expected).max() < TOLERANCE * scale, point
                compared += 1
    assert compared > 100


def test_thin_annulus_does_not_depend_on_the_way(monkeypatch):
    """Where modes that decay and the propagator both hold, they agree."""
    import subskin.skin._ring_modes as module

    depths, n = np.array([0.0, 0.1, 0.2]), np.arange(6.0)
    for nu in (0.5, 0.3):
        ring, found = Ring((Sheet(nu, 1.0, 0.2, True),), 1.0), []
        for limit in (0.0, 1e9):
            monkeypatch.setattr(module, "_THIN", limit)
            found.append(ring.amplitudes(n, depths))
        assert np.abs(found[0] - found[1]).max() < 1e-13


@pytest.mark.parametrize(
    ("share", "factor"), [(0.05, 1.027), (0.1, 1.046), (0.2, 1.068), (0.25, 1.073), (0.5, 1.047), (0.75, 0.863)]
)
def test_strain_beneath_a_line_load_on_a_bonded_layer(share, factor):
    rubber, load = ss.Material(0.4e6, 0.5), ss.LineLoad(40.0)
    layer = ss.Layered(ss.Layer(rubber, 2e-3 / share)).strain(load, 2e-3, 0.0).xx
    assert layer / ss.HalfPlane(rubber).strain(load, 2e-3, 0.0).xx == pytest.approx(factor, abs=5.1e-4)


@pytest.mark.parametrize(("share", "factor"), [(1 / 16, 1.085), (1 / 8, 1.152), (1 / 4, 1.256), (3 / 8, 1.250)])
def test_strain_beneath_a_line_load_on_a_round_finger(share, factor):
    rubber, load = ss.Material(0.4e6, 0.5), ss.LineLoad(40.0)
    finger = ss.Round(rubber, 8e-3, 4e-3).strain(load, share * 8e-3, 0.0).xx
    half = ss.HalfPlane(rubber).strain(load, share * 8e-3, 0.0).xx
    assert finger / half == pytest.approx(factor, abs=5.1e-4)


def test_shallow_limit_of_a_bonded_layer():
    """FORMULAS 1: the factor tends to 1 + 0.63773 d/H."""
    rubber, load = ss.Material(0.4e6, 0.5), ss.LineLoad(40.0)
    half = ss.HalfPlane(rubber).strain(load, 1e-3, 0.0).xx
    slopes = [
        (ss.Layered(ss.Layer(rubber, height)).strain(load, 1e-3, 0.0).xx / half - 1) * height / 1e-3
        for height in (1.0, 10.0)
    ]
    assert slopes[1] == pytest.approx(0.63773, abs=2.5e-4)
    assert abs(slopes[1] - 0.63773) < 0.15 * abs(slopes[0] - 0.63773)
