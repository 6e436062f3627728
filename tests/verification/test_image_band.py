"""The band of an image of the pressure: its formula against random contacts of its own kind, and what it holds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array

import subskin as ss
from subskin.estimate.pressure.band import deviations
from subskin.estimate.pressure.prior import Membrane

D, PITCH = 2e-3, 1.5e-3


def problem(components: int) -> tuple[np.ndarray, np.ndarray]:
    """Smooth columns (components, 30, 40) and the form of a membrane of 5 x 6 nodes, of like size."""
    rng = np.random.default_rng(0)
    at, sensors = np.stack(np.divmod(np.arange(30), 6), axis=-1), rng.uniform(-2, 8, (40, 2))
    away = at[:, None] - sensors
    spread = 3.0 / (1.0 + (away**2).sum(axis=-1)) ** 1.5
    parts = np.stack([spread, *(spread * away[..., i] for i in range(2))])[:components]
    return parts, Membrane((5, 6), (1.0, 1.2)).form.toarray()


def test_the_form_is_that_of_the_stencil():
    prior = Membrane((4, 5), (0.7, 1.1))
    form = prior.form.toarray()
    for a in range(20):
        for b in range(20):
            apart = abs(a // 5 - b // 5), abs(a % 5 - b % 5)
            assert form[a, b] == pytest.approx(prior.stencil[apart] if max(apart) < 2 else 0.0, abs=1e-12)


def test_deviations_are_those_of_pressures_with_random_loads():
    """Contacts drawn with independent loads, readings with noise, found by least squares, 400 times."""
    parts, form = problem(1)
    rng, columns, w = np.random.default_rng(1), parts[0], 2.0
    told, off = np.zeros(30), np.zeros(30)
    for _ in range(400):
        true = np.linalg.solve(w * form, 3.0 * rng.standard_normal(30))
        felt = columns.T @ true + rng.standard_normal(40)
        found = np.linalg.solve(columns @ columns.T + w * form, columns @ felt)
        told += deviations(parts, np.zeros(2), csr_array(w * form), found) ** 2
        off += (found - true) ** 2
    np.testing.assert_allclose(np.sqrt(told / off), 1.0, atol=0.12)
    assert np.sqrt(told.sum() / off.sum()) == pytest.approx(1.0, abs=0.03)


def test_a_drag_that_is_found_adds_what_it_does_beside_the_heights():
    """The heights' block in the inverse of the Hessian of heights and tangents, less that of the heights alone."""
    parts, form = problem(3)
    t, heights = np.array([0.2, -0.3]), np.random.default_rng(2).uniform(0.0, 2.0, 30)
    columns = parts[0] + t[0] * parts[1] + t[1] * parts[2]
    rows = np.concatenate([columns, np.einsum("akn,k->an", parts[1:], heights)])
    smooth = np.pad(form, ((0, 2), (0, 2)))
    added = np.diagonal(np.linalg.inv(rows @ rows.T + smooth))[:30]
    added = added - np.diagonal(np.linalg.inv(columns @ columns.T + form))
    one, three = (deviations(p, t, csr_array(form), heights) ** 2 for p in (columns[None], parts))
    np.testing.assert_allclose(three - one, added, rtol=1e-6)
    assert added.min() > 0


def touches(side: int, rng: np.random.Generator) -> list[ss.contact.Contact]:
    """Round ones and patches, half widths of 1 to 4 pitches, in the array."""
    out = []
    for k in range(24):
        wide = rng.uniform(1, 4) * PITCH
        at = rng.uniform(-1, 1, 2) * max(0.5 * (side - 1) * PITCH - wide, 0.0)
        out.append(
            ss.RoundHertz(1.0, position=at, half_width=wide)
            if k % 2
            else ss.Patch(1.0, position=at, half_widths=wide * rng.uniform(0.5, 1.0, 2))
        )
    return out


@pytest.mark.parametrize("side", [8, 16])
def test_the_band_holds_the_pressure_however_large_the_array(side):
    """The band of the weight's own prior held 0.78 of the patches at 16 x 16, and was 9.4 rms wide at 8 x 8."""
    rng, kind = np.random.default_rng(3), ss.MeanPressure()
    skin = ss.HalfSpace(ss.Material(young=0.4e6))
    drawn = touches(side, rng)
    pad = ss.Finger(skin, ss.SensorArray.grid((side, side), PITCH, D, transducer=kind, noise=1.0))
    clean = np.stack([pad.read(touch) for touch in drawn])
    scale = 1e3 / np.abs(clean).max(axis=1)
    found = ss.pressure_map(pad, clean * scale[:, None] + rng.standard_normal(clean.shape), shear="none")
    at = np.meshgrid(found.y, found.z, indexing="ij")
    true = np.stack([touch.pressure(*at) for touch in drawn]) * scale[:, None, None]
    low, high = np.moveaxis(found.pressure_interval, -1, 0)
    held, peak = (low <= true) & (true <= high), true.max(axis=(1, 2), keepdims=True)
    for patches in (True, False):
        on = (true > 0) & (np.arange(24) % 2 != patches)[:, None, None]
        assert held[on].mean() > 0.9
        off = np.sqrt((((found.pressure - true) / peak)[on] ** 2).mean())
        assert 3.0 < ((high - low) / peak)[on].mean() / off < 9.0
    assert held[true == 0].mean() > 0.99
    far = found.pressure_std[(true == 0) & (found.pressure == 0)]
    assert (far == 0).mean() > 0.5
