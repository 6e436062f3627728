"""Strains at receptors against closed forms, and rates fitted again."""

import numpy as np
import pytest

import subskin as ss
from subskin.afferents import MEASURES, Stimulus, fit_rates, strain_at

DEEP = ss.Layered(ss.Layer(ss.Material(young=1e5), thickness=0.4))
"""So thick that bars do not feel its ground."""


def punch(width: float, at: np.ndarray, depth: float) -> np.ndarray:
    """Maximum compressive strain beneath a flat punch on a half plane, of the force that the layer's press finds."""
    plane = ss.HalfPlane(ss.Material(young=1e5))
    force = ss.press(DEEP, ss.pressing.RoundedFlat(width / 2, 0.0), depth=1e-3, max_strain=None).force
    return ss.MaxCompressiveStrain().measure(plane.at(depth, at)(ss.FlatPunch(force, half_width=width / 2)))


def test_a_bar_strains_the_skin_as_a_flat_punch_does():
    at = np.linspace(-3e-3, 3e-3, 13)
    found = strain_at(Stimulus("bar", width=2e-3), at, 0.7e-3, "max_compressive_strain", DEEP)
    expected = punch(2e-3, at, 0.7e-3)
    assert np.abs(found - expected).max() < 5e-3 * expected.max()


def test_strains_go_with_the_indentation_and_energy_with_its_square():
    for measure in MEASURES:
        one, two = (strain_at(Stimulus("bar", 1e-3, 0.0, d), 0.3e-3, 0.7e-3, measure) for d in (0.5e-3, 1e-3))
        assert two / one == pytest.approx(4.0 if measure == "energy_density" else 2.0)


def test_a_grating_repeats_and_wide_gaps_leave_single_bars():
    grating = Stimulus("grating", width=0.5e-3, gap=1e-3)
    at = np.linspace(-0.7e-3, 0.7e-3, 9)
    one, next_ = (strain_at(grating, y, 0.6e-3, "max_compressive_strain") for y in (at, at + 2 * grating.period))
    assert np.allclose(one, next_, rtol=1e-9)
    far = strain_at(Stimulus("grating", width=1e-3, gap=20e-3), at, 0.6e-3, "normal_strain")
    bar = strain_at(Stimulus("bar", width=1e-3), at, 0.6e-3, "normal_strain")
    assert np.allclose(far, bar, rtol=0.01, atol=0.01 * np.abs(bar).max())


def test_bars_of_a_grating_share_the_load_as_superposed_punches_do():
    """Two sharp bars on a half plane (Johnson, section 2.8): here by a fine grid of line loads, solved densely."""
    width, gap, depth, skin = 3e-3, 3e-3, 0.7e-3, DEEP  # 12 mm hold one bar in the middle and none beside
    assert np.allclose(
        strain_at(Stimulus("grating", width, gap + 4e-3), 0.4e-3, depth, "normal_strain", skin),
        strain_at(Stimulus("bar", width), 0.4e-3, depth, "normal_strain", skin),
        rtol=0.01,
    )
    width, gap = 2e-3, 2e-3  # three bars
    step = 20e-6
    nodes = np.concatenate([np.arange(c - 1e-3 + step / 2, c + 1e-3, step) for c in (-4e-3, 0.0, 4e-3)])
    rows = np.asarray(skin.surface_influence(step, 1001))[0, 0]
    matrix = rows[np.round(np.abs(nodes[:, None] - nodes) / step).astype(int)]
    pressure = np.linalg.solve(matrix, np.full(len(nodes), 1e-3))
    at = np.linspace(-1.5e-3, 1.5e-3, 7)
    loads = ss.LineLoad(force=pressure[:, None] * step, position=nodes[:, None])
    expected = -skin.strain(loads, x=depth, y=at).xx.sum(axis=0)
    found = strain_at(Stimulus("grating", width, gap), at, depth, "normal_strain", skin)
    assert np.abs(found - expected).max() < 0.02 * np.abs(expected).max()


def test_a_fine_grating_is_felt_as_a_plate():
    """At a depth of many periods only the mean pressure is left: it hardly varies (exp(-2 pi depth / period))."""
    fine, coarse = Stimulus("grating", width=0.2e-3, gap=0.2e-3), Stimulus("grating", width=1e-3, gap=1e-3)
    one, two = (np.ptp(strain_at(each, each.scan(), 1e-3, "normal_strain")) for each in (fine, coarse))
    assert one < 0.02 * two


def test_an_edge_is_felt_most_at_the_edge():
    at = np.linspace(-4e-3, 2e-3, 61)
    felt = strain_at(Stimulus("edge"), at, 0.7e-3, "max_compressive_strain")
    assert abs(at[np.argmax(felt)]) < 0.5e-3
    assert felt[-1] < 0.2 * felt.max()


@pytest.mark.parametrize("measure", list(MEASURES))
def test_the_strain_that_made_the_rates_is_found_first_with_its_depth(measure):
    rng = np.random.default_rng(1)
    stimuli = [Stimulus("grating", 0.5e-3, gap) for gap in (0.5e-3, 1e-3, 2e-3, 4e-3) for _ in range(6)]
    stimuli += [Stimulus("bar", 1.5e-3)] * 6 + [Stimulus("edge")] * 6
    positions = np.concatenate([rng.uniform(0, 2e-3, 24), rng.uniform(-2e-3, 2e-3, 12)])
    strains = np.array([strain_at(s, y, 0.7e-3, measure) for s, y in zip(stimuli, positions, strict=True)])
    rates = np.maximum(0, 100 * strains / strains.max() - 15)
    noisy = np.maximum(rates + rng.normal(0, 3, len(rates)), 0)
    fits = fit_rates(stimuli, noisy, positions)
    assert fits[0].measure == measure
    assert fits[0].depth == pytest.approx(0.7e-3, abs=0.11e-3)
    assert fits[0].r2 > 0.95 > fits[1].r2 - 0.04
    assert fits[0].slope * strains.max() == pytest.approx(100, rel=0.15)
    assert [fit.r2 for fit in fits] == sorted((fit.r2 for fit in fits), reverse=True)


def test_a_scan_is_the_mean_of_its_positions():
    gratings = [Stimulus("grating", 0.5e-3, gap) for gap in (0.5e-3, 1e-3, 2e-3, 3e-3, 5e-3)]
    strains = [strain_at(each, each.scan(), 0.7e-3, "max_compressive_strain") for each in gratings]
    rates = [np.maximum(0, 300 * each - 20).mean() for each in strains]
    fit = fit_rates(gratings, rates, depth=0.7e-3, measures=["max_compressive_strain"])[0]
    assert fit.r2 > 0.999999
    assert (fit.slope, fit.rest) == (pytest.approx(300, rel=1e-3), pytest.approx(-20, rel=0.02))


def test_what_cannot_be_is_refused():
    bar = Stimulus("bar", width=1e-3)
    with pytest.raises(ss.SubskinError, match="a grating of width"):
        Stimulus("grating", width=1e-3)
    with pytest.raises(ss.SubskinError, match="at least 3"):
        fit_rates([bar] * 2, [1.0, 2.0])
    with pytest.raises(ss.SubskinError, match="alike"):
        fit_rates([bar] * 3, [2.0] * 3, [0.0, 1e-3, 2e-3])
    with pytest.raises(ss.SubskinError, match="depth"):
        strain_at(bar, 0.0, 0.02, "normal_strain")
    with pytest.raises(ss.SubskinError, match="measure"):
        strain_at(bar, 0.0, 0.7e-3, "pain")
