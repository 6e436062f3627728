"""The table of receptive fields that estimators work on."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss


@pytest.fixture(scope="module")
def finger():
    skin = ss.HalfPlane(ss.Material(young=0.4e6, poisson=0.4))
    kinds = [ss.NormalStrain(), ss.MeanPressure(), ss.ShearStrain()]
    array = ss.SensorArray(y=[-2e-3, 0.0, 2.5e-3], depth=[2e-3, 1.5e-3, 2e-3], transducer=kinds, gain=[1.0, 1e-6, -2.0])
    return ss.Finger(skin, array)


def test_the_table_keeps_its_tolerance_everywhere(finger):
    y = np.linspace(-8e-3, 8e-3, 4001)
    exact = finger.receptive_field(y)
    for tolerance in (1e-4, 1e-7, 1e-10):
        table = ss.response.Response.from_function(finger.receptive_field, -8e-3, 8e-3, step=2e-3, tolerance=tolerance)
        error = np.abs(table(y) - exact).max() / np.abs(exact).max()
        assert error < 3 * tolerance
        assert table.error <= tolerance


def test_its_error_falls_with_the_fifth_power_of_the_step(finger):
    y = np.linspace(-8e-3, 8e-3, 4001)
    exact = finger.receptive_field(y)
    errors = []
    for cells in (32, 64, 128):
        table = ss.response.Response.from_function(
            finger.receptive_field, -8e-3, 8e-3, step=16e-3 / cells, tolerance=np.inf
        )
        errors.append(np.abs(table(y) - exact).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(rates, 5, atol=0.6)


def test_derivatives_are_those_of_the_field(finger):
    table = finger.tabulate((-8e-3, 8e-3))
    y, h = np.linspace(-7e-3, 7e-3, 57), 1e-7
    first = (finger.receptive_field(y + h) - finger.receptive_field(y - h)) / (2 * h)
    np.testing.assert_allclose(table(y, derivative=1), first, rtol=0, atol=1e-6 * np.abs(first).max())
    h = 1e-5
    second = (table(y + h, derivative=1) - table(y - h, derivative=1)) / (2 * h)
    np.testing.assert_allclose(table(y, derivative=2), second, rtol=0, atol=2e-3 * np.abs(second).max())


@pytest.mark.parametrize("even", [True, False])
def test_a_table_of_measured_fields_is_as_good_as_its_points(finger, even):
    y = np.linspace(-8e-3, 8e-3, 161)
    if not even:
        y = y + 0.03e-3 * np.sin(2e3 * y)
    values = finger.receptive_field(y)
    table = ss.response.Response.from_table(y, values[..., 0], values[..., 1])
    between = np.linspace(-7.9e-3, 7.9e-3, 999)
    exact = finger.receptive_field(between)
    assert np.abs(table(between) - exact).max() < 1e-5 * np.abs(exact).max()


def test_select_keeps_the_chosen_sensors(finger):
    table = finger.tabulate()
    np.testing.assert_array_equal(table.select([2, 0])(1e-3), table(1e-3)[[2, 0]])
    np.testing.assert_array_equal(table.select([False, True, False])(1e-3), table(1e-3)[[1]])


@pytest.mark.parametrize(
    ("positions", "normal", "seen"),
    [
        ([0, 1, 2, 3, 4], np.zeros((5, 1)), "at least 6"),
        ([0, 1, 2, 3, 3, 4], np.zeros((6, 1)), "ascending"),
        (np.arange(6.0), np.zeros((5, 1)), "shape"),
    ],
)
def test_bad_tables_are_refused(positions, normal, seen):
    with pytest.raises(ss.errors.GeometryError, match=seen):
        ss.response.Response.from_table(positions, normal, normal)


def test_a_field_that_is_not_smooth_is_refused():
    def jump(y):
        return np.where(np.asarray(y)[..., None, None] > 0.1234, 1.0, 0.0) * np.ones((1, 2))

    with pytest.raises(ss.errors.ConvergenceError, match="smooth"):
        ss.response.Response.from_function(jump, 0.0, 1.0, step=0.1)
    with pytest.raises(ss.errors.GeometryError, match="start has to be < stop"):
        ss.response.Response.from_function(jump, 1.0, 0.0, step=0.1)
