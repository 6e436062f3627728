"""Layers on a round core beside the equations themselves, solved by collocation in each ring."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss

R = 8.0
SOFT, FIRM, PLAIN = ss.Material(1.0, 0.5), ss.Material(7.0, 0.3), ss.Material(2.5, 0.45)
SKINS = {
    "epidermis": ss.Round(SOFT, R, 4.0, ss.Layer(FIRM, 0.4)),
    "sliding": ss.Round(PLAIN, R, 2.0, ss.Layer(FIRM, 1.0, bond="frictionless"), bond="frictionless"),
    "soft core": ss.Round(FIRM, R, 5.0, [ss.Layer(SOFT, 0.6), ss.Layer(PLAIN, 0.9, bond="frictionless")], core=SOFT),
}
ORDER = 28


def chebyshev(low, high):
    """Radii from high to low, even in log r, and the matrix of d/dr there (Trefethen 2000, program cheb.m)."""
    t = np.cos(np.pi * np.arange(ORDER + 1) / ORDER)
    ends = np.where(np.isin(np.arange(ORDER + 1), (0, ORDER)), 2.0, 1.0) * (-1) ** np.arange(ORDER + 1)
    apart = t[:, None] - t + np.eye(ORDER + 1)
    d = np.outer(ends, 1 / ends) / apart
    d -= np.diag(d.sum(axis=1))
    r = low * (high / low) ** (0.5 * (1 + t))
    return r, d * 2 / np.log(high / low) / r[:, None]


def collocated(skin, n):
    """u_r, u_t, srr, srt under p = cos(n phi) and under q = sin(n phi) (cos for n = 0), ring by ring, with their radii.

    Unknowns are the displacements and the pressure pi, sigma = -pi + 2 G e, so that nu = 1/2 is nothing special:
    equilibrium within, div u = -pi / lambda everywhere, traction, continuity and the core at the ends.
    """
    size, rows, rings = ORDER + 1, [], []
    radii = R - np.concatenate([[0.0], np.cumsum([layer.thickness for layer in skin.stack])])
    total = 3 * size * len(skin.stack)
    zero = np.zeros((size, size))

    def placed(j, *blocks):
        out = np.zeros((blocks[0].shape[0], total))
        out[:, 3 * size * j : 3 * size * (j + 1)] = np.hstack(blocks)
        return out

    for j, layer in enumerate(skin.stack):
        r, d = chebyshev(radii[j + 1], radii[j])
        g, nu = layer.material.shear, layer.material.poisson
        over_lame = (1 - 2 * nu) / (2 * g * nu)
        one, by_r = np.eye(size), np.diag(1 / r)
        err, ett, ert = (d, zero, zero), (by_r, n * by_r, zero), (-0.5 * n * by_r, 0.5 * (d - by_r), zero)
        srr, stt = ([2 * g * e - p for e, p in zip(parts, (zero, zero, one))] for parts in (err, ett))
        srt = [2 * g * e for e in ert]
        radial = [d @ a + by_r @ (a - b + n * c) for a, b, c in zip(srr, stt, srt)]
        around = [d @ c + by_r @ (2 * c - n * b) for b, c in zip(stt, srt)]
        for parts in (radial, around):
            rows.append(placed(j, *parts))
        rows.append(placed(j, *(a + b + c for a, b, c in zip(err, ett, (zero, zero, over_lame * one)))))
        rings.append((r, [placed(j, one, zero, zero), placed(j, zero, one, zero), placed(j, *srr), placed(j, *srt)]))
    right = [np.zeros((sum(len(block) for block in rows), 2)), np.diag([-1.0, 1.0])]
    first, last = rings[0][1], rings[-1][1]
    rows += [first[2][:1], first[3][:1]]
    for layer, (_, above), (_, below) in zip(skin.stack, rings, rings[1:]):
        held = layer.bond == "bonded" or n == 0
        rows += [above[0][-1:] - below[0][:1], above[2][-1:] - below[2][:1]]
        rows += [above[1][-1:] - below[1][:1], above[3][-1:] - below[3][:1]] if held else [above[3][-1:], below[3][:1]]
    rows += [last[0][-1:], last[1][-1:] if skin.stack[-1].bond == "bonded" or n == 0 else last[3][-1:]]
    matrix = np.vstack(rows)
    right = np.vstack([*right, np.zeros((len(matrix) - sum(map(len, right)), 2))])
    scale = np.abs(matrix).max(axis=1)
    found = np.linalg.lstsq(matrix / scale[:, None], right / scale[:, None], rcond=None)[0]
    assert np.abs((matrix @ found - right) / scale[:, None]).max() < 1e-8  # more equations than unknowns
    return [(r, np.array([part @ found for part in parts])) for r, parts in rings]


@pytest.mark.parametrize("n", [0, 1, 2, 9])
@pytest.mark.parametrize("name", SKINS)
def test_a_harmonic_of_rings_solves_the_equations(name, n):
    skin, rings = SKINS[name], collocated(SKINS[name], n)
    sizes = np.max([np.abs(fields).max(axis=(1, 2)) for _, fields in rings], axis=0)
    sizes = np.repeat(np.maximum(sizes[::2], sizes[1::2]), 2)  # of displacements and of tractions
    for r, (ur, ut, srr, srt) in rings:
        at = slice(1, -1, 5)
        wave = skin.wave([n / R], R - r[at])
        parts = zip((wave.ux[0], wave.uy[0], wave.stress.xx[0], wave.stress.xy[0]), (-ur, ut, srr, -srt), strict=True)
        for (seen, expected), size in zip(parts, sizes, strict=True):
            assert np.abs(seen - expected[at]).max() < 2e-8 * size


@pytest.mark.long
def test_a_body_pressed_on_rings_of_one_material_is_on_one_ring():
    cut = ss.Round(SOFT, R, 4.0, ss.Layer(SOFT, 0.5))
    whole, parts = (ss.press(skin, ss.pressing.Cylinder(5.0), force=0.1) for skin in (ss.Round(SOFT, R, 4.0), cut))
    assert parts.half_width == pytest.approx(whole.half_width, rel=1e-9)
    assert parts.depth == pytest.approx(whole.depth, rel=1e-9)
    stiff = ss.press(SKINS["epidermis"], ss.pressing.Cylinder(5.0), force=0.1)
    assert stiff.half_width < 0.9 * whole.half_width
