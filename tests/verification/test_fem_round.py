"""Layers under a local contact beside finite elements in Fourier modes around its axis.

Two materials, and finer meshes: benchmarks/study_fem.py.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import subskin as ss

from ._fem import along, split
from ._fem_round import RoundBody, Touched
from .test_local_contacts import tensor, vector

A = 1.25e-3  # radius [m]
SOFT, HARD = ss.Material(0.4e6, 0.5), ss.Material(0.4e6, 0.3)
SKINS = {"layer-0.5": ss.Layered(ss.Layer(SOFT, 4 * A)), "layer-0.3": ss.Layered(ss.Layer(HARD, 4 * A))}
TOUCH = ss.RoundHertz(components=(1.0, 0.375, -0.25), moment=0.3 * A, half_width=A)
PARTS = np.array([1, 2, 3])


def hertz(r):
    """Hertz's pressure of unit force."""
    return 3 / (2 * np.pi * A**2) * np.sqrt(np.maximum(1 - (r / A) ** 2, 0.0))


@lru_cache(maxsize=1)
def elements(name, parts):
    """Elements of half the contact's radius by an eighth of the thickness, cut into `parts` either way."""
    skin = SKINS[name]
    depths = split(skin.thickness * np.linspace(0, 1, 9), parts)
    bottoms = depths[np.searchsorted(depths, np.cumsum([e.thickness for e in skin.stack]) * (1 - 1e-9))]
    layers = [(d, e.material.young, e.material.poisson) for d, e in zip(bottoms, skin.stack, strict=True)]
    radii = split(along(0, A, 2, 0, 16 * skin.thickness, 1.4), parts)
    return Touched(depths, radii, layers, hertz, TOUCH.components, float(TOUCH.moment))


def differences(name, parts, x, r, theta):
    """Of strains and of displacements, at each point the largest component's, in shares of the largest anywhere."""
    state = SKINS[name].state(TOUCH, x, r * np.cos(theta), r * np.sin(theta))
    ours = tensor(state.strain), vector(state.displacement)
    theirs = elements(name, parts).at(x, r, theta)
    return [np.abs(a - b).max(axis=0) / np.abs(a).max() for a, b in zip(ours, theirs, strict=True)]


@pytest.mark.parametrize("name", SKINS)
def test_the_difference_falls_at_the_order_of_the_elements(name):
    """Strains second, third at the points where they are best; displacements third: nothing is left to level off."""
    rng = np.random.default_rng(1)
    x, r = (a.ravel() for a in np.meshgrid(A * np.linspace(0.8, 4.0, 12), A * np.linspace(0.05, 3.0, 16)))
    theta = rng.uniform(-np.pi, np.pi, x.size)
    anywhere, best, moved = [], [], []
    for parts in PARTS:
        strain, displacement = differences(name, parts, x, r, theta)
        at_best = differences(name, parts, *elements(name, parts).even.best(x, r), theta)[0]
        for errors, seen in ((anywhere, strain), (moved, displacement), (best, at_best)):
            errors.append(np.sqrt((seen**2).mean()))
    orders = [-np.polyfit(np.log(PARTS), np.log(errors), 1)[0] for errors in (anywhere, best, moved)]
    assert orders[0] > 1.7
    assert orders[1] > 2.3
    assert orders[2] > 2.7
    assert anywhere[-1] < 6e-4
    assert best[-1] < 3e-4
    assert moved[-1] < 2e-5


def test_the_elements_know_a_pressed_ball():
    """A hollow ball on a rigid core under even pressure, Lame 1852: nothing of subskin. Its clamped end is small."""
    nu, outer, core, p = 0.3, 2.0, 1.0, 1e-3
    depths, arcs = np.linspace(0, outer - core, 13), np.linspace(0, 0.995 * np.pi * outer, 41)
    body = RoundBody(depths, arcs, [(outer - core, 1.0, nu)], 0, outer)
    x, s = (a.ravel() for a in np.meshgrid(np.linspace(0.1, 0.9, 5), np.linspace(0.1, 1.0, 5)))
    x, s = body.best(x, s)
    strain = body.pull(pressure=lambda r: np.full_like(r, p)).normal(x, s)[0]
    # u = a r + b / r^2, nothing at the core
    lame, shear = nu / ((1 + nu) * (1 - 2 * nu)), 0.5 / (1 + nu)
    a = -p / (3 * lame + 2 * shear + 4 * shear * (core / outer) ** 3)
    assert strain == pytest.approx(a * (1 + 2 * (core / (outer - x)) ** 3), rel=5e-3)
