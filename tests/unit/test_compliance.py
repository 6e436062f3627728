"""Which skin tells a particle on a flat: limits known by hand, the scaling by force over modulus, bad input."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import subskin as ss
from subskin.design import skin_compliance
from subskin.design.compliance import Regime
from subskin.plot import compliance_figure

RUBBER = ss.Material(0.4e6, 0.5)
SKIN = ss.Round(RUBBER, radius=8e-3, core_radius=2e-3)
PARTICLE = ss.pressing.ParticleOnFlat(half_width=0.4e-3, protrusion=30e-6)


def finger(skin=SKIN, **more):
    return ss.Finger(skin, ss.SensorArray.line(6, pitch=0.6e-3, depth=0.8e-3, **{"noise": 2e-5, **more}))


@pytest.fixture(scope="module")
def found():
    return skin_compliance(finger(), PARTICLE, [20.0, 40.0], young=[0.1e6, 0.2e6, 20e6])


def test_only_force_over_modulus_counts(found):
    for name in ("half_width", "load_share", "reading_share", "width_std"):
        values = getattr(found, name)
        assert np.allclose(values[0, 0, 0], values[0, 1, 1], rtol=1e-9), name


def test_a_stiff_skin_touches_the_particles_top_as_hertz_says(found):
    curvature = 1 / SKIN.radius + 2 * PARTICLE.protrusion / PARTICLE.half_width**2
    a = np.sqrt(4 * 20.0 / (curvature * np.pi * 20e6 / 0.75))
    assert found.half_width[0, 2, 0] == pytest.approx(a, rel=2e-3)
    assert found.load_share[0, 2, 0] == pytest.approx(1.0, abs=1e-12)
    assert found.regime[0, 2, 0] == Regime.TIP
    # a parabola's width and height show in its curvature alone
    assert found.width_std[0, 2, 0] > 1e3


def test_a_soft_skin_carries_little_on_the_particle(found):
    assert (np.diff(found.load_share[0], axis=0) > 0).all()
    assert (np.diff(found.half_width[0], axis=0) < 0).all()
    assert found.half_width[0, 0, 1] > 3 * PARTICLE.half_width


def test_shares_are_those_of_two_presses(found):
    tip = finger()
    soft = ss.Round(dataclasses.replace(RUBBER, young=0.1e6), SKIN.radius, SKIN.core_radius)
    on, off = (ss.press(soft, body, force=40.0) for body in (PARTICLE, ss.pressing.Flat()))
    readings = [ss.Finger(soft, tip.array).read(p.contact) for p in (on, off)]
    change = readings[0] - readings[1]
    largest = np.abs(readings[0]).max()
    assert found.reading_share[0, 0, 1] == pytest.approx(np.abs(change).max() / largest, rel=1e-3)
    error = np.hypot(2e-5, 0.01 * largest)
    assert found.seen[0, 0, 1] == pytest.approx(np.linalg.norm(change) / error, rel=1e-3)
    carried = on.pressure[np.abs(on.y) <= PARTICLE.half_width].sum() / on.pressure.sum()
    assert found.load_share[0, 0, 1] == pytest.approx(carried, abs=0.01)


def test_the_width_is_as_uncertain_as_a_fit_of_it_says():
    """Least squares on noisy readings, all four unknowns free, scatter as the Fisher information foretells."""
    tip, force = finger(), 20.0
    skin = ss.Round(dataclasses.replace(RUBBER, young=0.1e6), SKIN.radius, SKIN.core_radius)
    one = skin_compliance(tip, PARTICLE, force, young=0.1e6)
    own = ss.Finger(skin, tip.array)

    def read(width, height, position, load):
        body = ss.pressing.ParticleOnFlat(PARTICLE.half_width * width, PARTICLE.protrusion * height)
        contact = ss.press(skin, body, force=force * load).contact
        return own.read(ss.PressureProfile(contact.nodes + position, contact.node_pressure))

    middle = read(1, 1, 0, 1)
    error = np.hypot(2e-5, 0.01 * np.abs(middle).max())
    h = 0.03
    columns = [
        (read(1 + h, 1, 0, 1) - read(1 - h, 1, 0, 1)) / (2 * h),
        (read(1, 1 + h, 0, 1) - read(1, 1 - h, 0, 1)) / (2 * h),
        (read(1, 1, 1e-5, 1) - read(1, 1, -1e-5, 1)) / 2e-5 * PARTICLE.half_width,
        (read(1, 1, 0, 1 + h) - read(1, 1, 0, 1 - h)) / (2 * h),
    ]
    jacobian = np.stack(columns, -1) / error
    scatter = np.linalg.lstsq(jacobian, np.random.default_rng(0).normal(size=(6, 4000)), rcond=None)[0]
    assert one.width_std[0, 0, 0] == pytest.approx(scatter[0].std(), rel=0.08)


def test_without_an_error_in_proportion_a_soft_skin_loses_nothing():
    exact = skin_compliance(finger(), PARTICLE, 40.0, young=[0.05e6, 0.2e6], accuracy=0.0)
    rough = skin_compliance(finger(), PARTICLE, 40.0, young=[0.05e6, 0.2e6], accuracy=0.02)
    assert exact.seen[0, 0, 0] > 0.8 * exact.seen[0, 1, 0]
    assert rough.seen[0, 0, 0] < 0.6 * rough.seen[0, 1, 0]


def test_a_stress_grows_with_the_modulus_at_the_same_force_over_modulus():
    tip = finger(transducer=ss.NormalStress(), noise=50.0)
    both = skin_compliance(tip, PARTICLE, [20.0, 40.0], young=[0.1e6, 0.2e6], accuracy=0.0)
    assert both.seen[0, 1, 1] == pytest.approx(2 * both.seen[0, 0, 0], rel=1e-9)


def test_ends_of_the_range_and_too_soft_a_skin_are_said():
    saturated = skin_compliance(finger(low=-0.02, high=0.02), PARTICLE, 40.0, young=0.1e6)
    assert saturated.regime[0, 0, 0] == Regime.SATURATED
    strained = skin_compliance(finger(), PARTICLE, 40.0, young=[5e3, 0.2e6])
    assert strained.regime[0, 0, 0] == Regime.STRAINED
    assert np.isnan(strained.seen[0, 0, 0])


def test_the_recommendation_serves_all_forces_or_says_which_not():
    good = skin_compliance(finger(), PARTICLE, [30.0, 40.0], young=[0.05e6, 0.2e6, 0.25e6, 5e6], accuracy=0.002)
    assert good.regime[good.best].tolist() == [Regime.TOLD, Regime.TOLD]
    assert "at all of 30 to 40 N/m" in good.reason
    assert "stiffer, at 30 N/m the skin hardly touches" in good.reason
    wide = skin_compliance(finger(), PARTICLE, [5.0, 80.0], young=[0.1e6, 0.3e6], accuracy=0.002)
    assert "no skin tried serves all" in wide.reason


def test_a_thinner_skin_and_a_flat_one():
    calls = []
    both = skin_compliance(
        finger(), PARTICLE, 40.0, young=0.2e6, thickness=[1.5e-3, 6e-3], progress=lambda: calls.append(1)
    )
    assert both.half_width.shape == (2, 1, 1)
    assert both.half_width[0, 0, 0] < both.half_width[1, 0, 0]
    assert len(calls) == 2
    flat = ss.pressing.ParticleOnFlat(0.4e-3, 30e-6, flat_half_width=3e-3)
    layer = skin_compliance(finger(ss.Layered(ss.Layer(RUBBER, 4e-3))), flat, 40.0, young=0.2e6)
    assert layer.half_width[0, 0, 0] == pytest.approx(3e-3, rel=1e-2)


@pytest.mark.parametrize(
    ("tip", "particle", "rule"),
    [
        (finger(noise=0.0), PARTICLE, "depends on the noise"),
        (ss.Finger(SKIN, ss.SensorArray([0.0, 1e-3, 2e-3], depth=1e-3, noise=1e-4)), PARTICLE, "four unknowns"),
        (ss.Finger(SKIN, ss.SensorArray.line(4, 1e-3, depth=1e-3, noise=1e-4)), PARTICLE, "two different readings"),
        (finger(ss.HalfPlane(RUBBER)), PARTICLE, "touch all along"),
        (finger(transducer=ss.EnergyDensity()), PARTICLE, "linear"),
    ],
)
def test_what_cannot_be_asked(tip, particle, rule):
    with pytest.raises(ss.SubskinError, match=rule):
        skin_compliance(tip, particle, 40.0, young=0.2e6)


def test_sensors_that_are_not_alike_on_both_sides_tell_the_width_as_four():
    row = ss.SensorArray(y=[-1.2e-3, -0.5e-3, 0.1e-3, 0.7e-3], depth=0.8e-3, noise=2e-5)
    found = skin_compliance(ss.Finger(SKIN, row), PARTICLE, 40.0, young=0.2e6, accuracy=0.0)
    assert 0 < found.width_std[0, 0, 0] < 10


def test_a_flat_that_ends_is_drawn():
    flat = ss.pressing.ParticleOnFlat(0.4e-3, 30e-6, flat_half_width=3e-3)
    tip = finger(ss.Layered(ss.Layer(RUBBER, 4e-3)))
    figure = compliance_figure(skin_compliance(tip, flat, 40.0, young=[0.1e6, 0.2e6, 2e6]))
    (body,) = [line for line in figure.axes[0].lines if len(line.get_xdata()) > 2]
    known = np.isfinite(body.get_ydata())
    assert known.any()
    assert np.abs(body.get_xdata()[known]).max() <= 3.0


@pytest.mark.parametrize("bad", [{"force": 0.0}, {"force": 40.0, "young": -1.0}, {"force": 40.0, "accuracy": -0.1}])
def test_numbers_out_of_range(bad):
    with pytest.raises(ss.errors.InvalidValueError):
        skin_compliance(finger(), PARTICLE, **bad)


@pytest.mark.long
def test_neighbouring_moduli_answer_alike():
    """A thin skin bulges up to the flat far beside the particle, first here, then there: no answer may jump at that."""
    skin = ss.Layered(ss.Layer(ss.Material(0.6e6, 0.5), 6e-3))
    row = ss.SensorArray.line(5, 3.8e-3, 2.55e-3, transducer=ss.MeanPressure(), noise=2.0, width=2e-3)
    flat = ss.pressing.ParticleOnFlat(0.25e-3, 100e-6, flat_half_width=10e-3)
    near = skin_compliance(ss.Finger(skin, row), flat, 99.5, young=[1.897e6, 1.948e6])
    first, second = near.width_std[0, :, 0]
    assert first == pytest.approx(second, rel=0.3)  # 0.39 and 0.067 when each press had a grid of its own
    assert near.half_width[0, :, 0] == pytest.approx([7.93e-3, 7.45e-3], rel=0.01)
    assert near.regime[0, :, 0].tolist() == [Regime.MIXED, Regime.MIXED]
    assert "looks like a change of its height" in near.reason or "no skin tried" in near.reason
