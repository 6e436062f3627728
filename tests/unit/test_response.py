"""The response to waves: shapes, phase, what is refused, and what its figures draw."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.design import spatial_response
from subskin.plot import memo_figure, response_figure

SKIN = ss.HalfPlane(ss.Material(young=0.4e6))
FINGER = ss.Finger(SKIN, ss.SensorArray.line(count=4, pitch=1e-3, depth=2e-3, gain=[1.0, 2.0, -1.0, 0.0]))


@pytest.mark.parametrize("shape", [(), (5,), (2, 3), (0,)])
def test_shapes(shape):
    k = np.full(shape, 400.0)
    found = spatial_response(FINGER, k)
    assert found.amplitude.shape == (*shape, 4, 2)
    assert found.wavenumber.shape == found.frequency.shape == found.wavelength.shape == shape
    assert found.magnitude.shape == found.phase.shape == (*shape, 4, 2)
    for values in (found.amplitude, found.magnitude, found.phase, found.frequency, found.wavelength):
        assert not values.flags.writeable


def test_integers_are_numbers_and_the_input_is_left_alone():
    k = np.array([0, 300])
    found = spatial_response(FINGER, k)
    np.testing.assert_array_equal(found.amplitude, spatial_response(FINGER, [0.0, 300.0]).amplitude)
    assert k.dtype.kind == "i"
    assert found.frequency[1] == pytest.approx(300 / (2 * np.pi))
    assert found.wavelength.tolist() == [np.inf, pytest.approx(2 * np.pi / 300)]


def test_gain_multiplies_and_a_dead_sensor_reads_nothing():
    found = spatial_response(FINGER, 500.0)
    assert found.magnitude[:, 0] == pytest.approx(found.magnitude[0, 0] * np.array([1.0, 2.0, 1.0, 0.0]), rel=1e-14)
    assert found.phase[:, 0].tolist() == pytest.approx([np.pi, np.pi, 0.0, 0.0], abs=1e-12)


def test_phase_says_where_the_crest_is_that_is_read_most():
    """A wave cos(k (y - c)) reads Re(amplitude exp(-i k c)); by the finger itself, under many line loads."""
    k, c = 500.0, np.linspace(-6e-3, 6e-3, 25)
    y = np.linspace(-0.4, 0.4, 40001)
    ends = 0.5 * (1 + np.cos(np.pi * np.clip((np.abs(y) - 0.2) / 0.2, 0, 1)))  # falls off slowly
    field = FINGER.receptive_field(y)
    wave = np.cos(k * (y - c[:, None])) * ends * (y[1] - y[0])
    read = np.einsum("cy,ynl->cnl", wave, field)
    found = spatial_response(FINGER, k)
    turned = (found.amplitude * np.exp(-1j * k * c)[:, None, None]).real
    assert np.abs(read - turned).max() < 2e-4 * np.abs(turned).max()
    # seen from the sensor: cos(k (y - c) + phase)
    at = k * (np.asarray(FINGER.array.y) - c[:, None])[..., None]
    assert np.abs(found.magnitude * np.cos(at + found.phase) - turned).max() < 1e-12 * np.abs(turned).max()


def test_without_wavenumbers_it_takes_those_worth_drawing():
    found = spatial_response(FINGER)
    assert found.wavenumber.max() == pytest.approx(12 / 2e-3)
    assert found.wavenumber.size == 240
    assert found.wavenumber.min() > 0
    tip = ss.Round(ss.Material(0.4e6), 8e-3, 4e-3)
    waves = spatial_response(ss.Finger(tip, FINGER.array)).wavenumber * 8e-3
    np.testing.assert_allclose(waves, np.arange(waves.size), atol=1e-9)
    assert waves[-1] >= 48


@pytest.mark.parametrize("k", [-1.0, np.nan, np.inf, "many"])
def test_no_such_wavenumber(k):
    with pytest.raises(ss.errors.InvalidValueError, match="wavenumber"):
        spatial_response(FINGER, k)


def test_waves_that_do_not_close_are_refused():
    tip = ss.Finger(ss.Round(ss.Material(0.4e6), 8e-3, 4e-3), FINGER.array)
    with pytest.raises(ss.errors.InvalidValueError, match="whole number"):
        spatial_response(tip, 2.5 / 8e-3)


def test_a_layer_that_slides_has_no_limit_of_long_waves():
    loose = ss.Layered(ss.Layer(ss.Material(0.4e6), 6e-3, "frictionless"))
    with pytest.raises(ss.errors.InvalidValueError, match="slides"):
        spatial_response(ss.Finger(loose, FINGER.array), [0.0, 100.0])
    assert np.isfinite(spatial_response(ss.Finger(loose, FINGER.array), 100.0).magnitude).all()


def test_what_is_not_linear_is_made_so_or_refused():
    def finger(kind):
        return ss.Finger(SKIN, ss.SensorArray(y=[0.0], depth=2e-3, transducer=kind))

    exact, first = (spatial_response(finger(ss.VolumeResistance(exact=e)), 400.0) for e in (True, False))
    np.testing.assert_array_equal(exact.amplitude, first.amplitude)
    with pytest.raises(ss.errors.NotLinearError):
        spatial_response(finger(ss.EnergyDensity()), 400.0)


def test_figure_draws_each_kind_of_sensor_once():
    array = ss.SensorArray(y=[0.0, 1e-3, 2e-3], depth=[2e-3, 2e-3, 1e-3])
    found = spatial_response(ss.Finger(SKIN, array))
    axes = response_figure(found).axes
    for load, upper in enumerate(axes[:2]):
        curves = [line for line in upper.lines if len(line.get_xdata()) > 2]
        assert len(curves) == 2
        for line, sensor in zip(curves, (0, 2), strict=True):
            np.testing.assert_allclose(line.get_xdata(), found.frequency / 1e3)
            np.testing.assert_allclose(np.nan_to_num(line.get_ydata()), found.magnitude[:, sensor, load] * 1e3)
    (mark,) = [line for line in axes[0].lines if len(line.get_xdata()) == 2]
    assert mark.get_xdata()[0] == pytest.approx(0.5)  # two spacings of 1 mm
    phase = np.asarray(axes[3].lines[0].get_ydata())
    assert set(np.unique(phase[np.isfinite(phase)]).round(9)) == {-90.0, 90.0}
    with pytest.raises(ss.errors.GeometryError, match="three or more"):
        response_figure(spatial_response(FINGER, 400.0))


def test_figure_15_is_eq_25_and_its_companion():
    amplitude, phase, skirts = memo_figure(15).axes
    lines = {line.get_label(): line.get_xydata().T for line in amplitude.lines}
    s, press = lines["pressure, half plane"]
    _, shear = lines["shear, half plane"]
    kd = 2 * np.pi * s
    np.testing.assert_allclose(press, -1.5 * kd * np.exp(-kd), atol=1e-13)
    np.testing.assert_allclose(shear, -1.5 * (1 - kd) * np.exp(-kd), atol=1e-13)
    marks = [line for line in skirts.lines if line.get_marker() == "o"]
    for mark, size in zip(marks, (lambda f: f * np.exp(1 - f), lambda f: (f - 1) * np.exp(-f)), strict=True):
        at, height = mark.get_xdata()[0], mark.get_ydata()[0]
        assert size(2 * np.pi * at) == pytest.approx(1e-3, rel=1e-9)
        assert f"{at:.3f}" in [text.get_text() for text in skirts.texts]
        assert height == pytest.approx(1.5e-3 / (np.e if mark is marks[0] else 1), rel=1e-9)
    flat = np.asarray(phase.lines[0].get_ydata())
    assert np.nanmin(flat) == np.nanmax(flat) == pytest.approx(180)


def test_figure_14_samples_the_strain_and_joins_the_samples():
    pressure, strain, samples, recovered, skin, comb, low = memo_figure(14).axes
    y, eps = strain.lines[0].get_xydata().T
    p_y, p = pressure.lines[0].get_xydata().T
    # the strain is the pressure convolved with eq. (24)
    step = p_y[1] - p_y[0]
    for position in (-1.0, 0.4, 1.4):
        t = position - p_y
        kernel = -3 * (1 - t**2) / (2 * np.pi * (1 + t**2) ** 2)
        assert np.interp(position, y, eps) == pytest.approx((p * kernel).sum() * step, abs=2e-3)
    at, values = samples.lines[0].get_xydata().T
    np.testing.assert_allclose(np.diff(at), 1.0)
    np.testing.assert_allclose(values, np.interp(at, y, eps), atol=1e-12)
    grey, found = (line.get_xydata().T for line in recovered.lines[:2])
    np.testing.assert_allclose(grey[1], eps)
    np.testing.assert_allclose(np.interp(at, *found), values, atol=1e-3)  # it goes through the samples
    assert np.abs(found[1] - eps).max() > 0.02  # but leaves the strain between them
    edge = low.lines[0].get_xydata()
    assert edge[:, 0].tolist() == [0.0, 0.5, 0.5, 1.2]
    s, h = skin.lines[0].get_xydata().T
    np.testing.assert_allclose(h, 3 * np.pi * s * np.exp(-2 * np.pi * s), atol=1e-13)
    assert comb.get_xlim() == samples.get_xlim()
