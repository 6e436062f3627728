"""The memo's equations against the mechanics of this package, and its errata against what they say."""

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate

from subskin import memo
from subskin.contact import FlatPunch, Hertz, LineLoad, Strip, Wedge
from subskin.errors import GeometryError, InvalidValueError
from subskin.material import Material
from subskin.memo.three_sensors import three_sensor
from subskin.skin import HalfPlane

ROOT = Path(__file__).resolve().parents[2]
SLOPES = ROOT.parent / "shared" / "reference" / "05b_hertz_centre_slope.json"

E, P, ALPHA = 0.4e6, 40.0, 0.4
SKIN = HalfPlane(Material(young=E, poisson=0.5))
X = np.array([1e-4, 1e-3, 2e-3, 5e-3])[:, None]
Y = np.array([-7e-3, -1e-3, 0.0, 0.3e-3, 2e-3, 30e-3])


def close(actual, expected, rtol=1e-12):
    """To `rtol` of the largest value in each array, which is what a field can promise."""
    actual, expected = np.broadcast_arrays(actual, expected)
    assert np.abs(actual - expected).max() <= rtol * np.abs(expected).max()


# --- Section 2 ---


def test_stress_of_a_line_load_on_the_memos_axis():
    field = SKIN.stress(LineLoad(P, -ALPHA), x=X, y=Y)  # same axis: the memo's alpha drags towards -y
    for actual, expected in zip(memo.eq4(P, ALPHA, X, Y), (field.xx, field.yy, field.xy), strict=True):
        close(actual, expected)
    mirrored = SKIN.stress(LineLoad(P, ALPHA), x=X, y=-Y)  # the project's axis is the memo's reversed
    for actual, expected in zip(memo.eq4(P, ALPHA, X, Y), (mirrored.xx, mirrored.yy, -mirrored.xy), strict=True):
        close(actual, expected)


def test_polar_and_cartesian_stress_agree():
    r, theta = np.hypot(X, Y), np.arctan2(Y, X)
    polar = memo.eq2(P, ALPHA, r, theta)
    for actual, expected in zip(memo.eq3(polar.sigma_r, theta), memo.eq4(P, ALPHA, X, Y), strict=True):
        close(actual, expected)
    close(memo.eq1(P, r, theta).sigma_r, memo.eq2(P, 0.0, r, theta).sigma_r)
    assert not polar.sigma_theta.any()
    assert not polar.tau_r_theta.any()


def test_hooke_and_plane_strain():
    stress = SKIN.stress(LineLoad(P, -ALPHA), x=X, y=Y)
    strain = SKIN.strain(LineLoad(P, -ALPHA), x=X, y=Y)
    sigma_z, eps_x, eps_y = memo.eq7(stress.xx, stress.yy, E)
    close(sigma_z, stress.zz)
    close(eps_x, strain.xx)
    close(eps_y, strain.yy)
    general = HalfPlane(Material(young=E, poisson=0.3), plane="stress")
    stress, strain = general.stress(LineLoad(P), x=X, y=Y), general.strain(LineLoad(P), x=X, y=Y)
    for actual, expected in zip(
        memo.eq6(stress.xx, stress.yy, stress.zz, E, 0.3), (strain.xx, strain.yy, strain.zz), strict=True
    ):
        close(actual, expected)
    assert memo.eq5(3.0, 4.0) == memo.eq6(3.0, 0.0, 0.0, 4.0).eps_x


def test_strain_of_a_line_load():
    close(memo.eq8(P, ALPHA, X, Y, E), SKIN.strain(LineLoad(P, -ALPHA), x=X, y=Y).xx)
    close(memo.eq8(P, ALPHA, X, Y, E), SKIN.strain(LineLoad(P, ALPHA, position=Y), x=X, y=0.0).xx)


def test_resistance_of_a_strained_block():
    e = np.array([-0.3, -0.01, 0.02, 0.2])
    close(memo.eq10(2.0, e).ratio, memo.eq9(2.0, 1 + e, 1 - e, 1.0))
    close(memo.eq11(2.0, e, 0.1, -0.2).ratio, memo.eq9(2.0, 1 + e, 1.1, 0.8))
    for share in (0.0, 0.3, 1.0):  # of the lateral strain, in the direction z; the volume is kept
        kept = memo.eq9(2.0, 1 + e, (1 + e) ** (share - 1), (1 + e) ** -share)
        close(memo.eq10_corrected(2.0, e), kept)
        close(memo.eq11_corrected(2.0, e), kept)


@pytest.mark.parametrize("exact", [memo.eq10_corrected, lambda rho, e: memo.eq10(rho, e).ratio])
def test_resistance_to_first_order_has_a_second_order_error(exact):
    e = np.array([1e-2, 1e-3])
    error = exact(1.0, e) - memo.eq10(1.0, e).first_order
    assert error[0] / error[1] == pytest.approx(100, rel=0.02)
    half = memo.eq11(1.0, e, -e / 2, -e / 2)
    close(half.first_order, memo.eq10(1.0, e).first_order, 1e-14)


# --- Section 3 ---


def test_three_sensors_read_as_the_half_plane_says():
    y, x, b = np.array([-3e-3, 0.2e-3, 1e-3])[:, None], 2e-3, np.array([1e-3, 2e-3])
    readings = memo.eq12(P, ALPHA, y, x, b, E)
    assert readings.shape == (3, 2, 3)
    for i, side in enumerate((-1, 0, 1)):
        field = SKIN.strain(LineLoad(P, ALPHA, position=y), x=x, y=side * b)
        close(readings[..., i], field.xx)


def test_polynomial_vanishes_where_the_load_is():
    rng = np.random.default_rng(4)
    y, alpha, b = rng.uniform(-2, 2, 50), rng.uniform(-1, 1, 50), rng.uniform(0.2, 3, 50)
    readings = memo.eq12(1.0, alpha, y, 1.0, b, 1.0)
    size = np.abs(readings).max(axis=-1) * (1 + (np.abs(y) + b) ** 2) ** 4
    assert (np.abs(memo.eq13(readings, y, 1.0, b)) < 1e-14 * size).all()
    assert (np.abs(memo.eq13(readings, y + 0.1, 1.0, b)) > 1e-9 * size).all()


def test_polynomial_multiplied_out():
    rng = np.random.default_rng(6)
    for _ in range(20):
        readings, x, b, y = (rng.standard_normal(3), rng.uniform(0.5, 2), rng.uniform(0.5, 2), rng.uniform(-3, 3, 9))
        coefficients = memo.eq13_coefficients(readings, x, b)
        close(np.polyval(coefficients, y), memo.eq13(readings, y, x, b), 1e-12)
        e1, e2, e3 = readings
        assert coefficients[:2] == pytest.approx((2 * e2 - e1 - e3, -2 * b * (e1 - e3)), rel=1e-12)
        real = [r.position for r in three_sensor(readings, [-b, 0, b], x, young=1.0).roots]
        roots = np.roots(coefficients)
        assert sorted(roots[np.abs(roots.imag) < 1e-7].real) == pytest.approx(real, rel=1e-6, abs=1e-6)
    assert memo.eq13_coefficients(rng.standard_normal((4, 5, 3)), 1.0, 2.0).shape == (4, 5, 9)


def test_false_root_derivatives():
    """f'(0) = -8 x^7 (eps_1 - eps_3) at b = x; and f'(x) = -64 x^7 (2 eps_2 + eps_3) at b = 2x."""
    e = np.array([0.3, -0.5, 0.2])
    for x in (1.0, 1.7):
        at_b_x = np.polyder(memo.eq13_coefficients(e, x, x))
        at_b_2x = np.polyder(memo.eq13_coefficients(e, x, 2 * x))
        assert np.polyval(at_b_x, 0) == pytest.approx(-8 * x**7 * (e[0] - e[2]), rel=1e-12)
        assert np.polyval(at_b_2x, x) == pytest.approx(-64 * x**7 * (2 * e[1] + e[2]), rel=1e-12)
        assert np.polyval(at_b_2x, -x) == pytest.approx(64 * x**7 * (e[0] + 2 * e[1]), rel=1e-12)


def test_figure_6():
    six = memo.FIGURE_6
    exact = -memo.eq12(six.P, six.alpha, six.y, six.depth, six.pitch, 1.0)
    for value, printed, digits in zip(exact, six.printed, (3, 2, 2), strict=True):
        assert round(float(value), digits) == printed
    found = three_sensor([-e for e in six.printed], [-six.pitch, 0, six.pitch], six.depth, young=1.0)
    (root,) = found.accepted
    assert root.position == pytest.approx(six.y, abs=0.01)
    assert root.angle == pytest.approx(six.alpha, abs=1e-3)
    assert root.force == pytest.approx(six.P, abs=0.01)


# --- Section 4 ---

INSIDE = np.array([-0.999e-3, -0.4e-3, 1e-6, 0.7e-3, 0.999999e-3])
OUTSIDE = np.array([-2e-3, 1.000001e-3, 1e-3])


def test_pressure_under_a_punch_and_a_cylinder():
    for equation, contact in ((memo.eq14, FlatPunch), (memo.eq16, Hertz)):
        np.testing.assert_allclose(equation(P, 1e-3, INSIDE), contact(P, half_width=1e-3).pressure(INSIDE), rtol=1e-12)
        assert not equation(P, 1e-3, OUTSIDE).any()


@pytest.mark.parametrize("nu", [0.5, 0.3])
def test_pressure_under_a_wedge(nu):
    theta = np.deg2rad(160)
    wedge = Wedge.from_angle(P, theta, Material(young=E, poisson=nu))
    a = float(wedge.half_width)
    printed = memo.eq15(memo.eq15_constant(E, nu), theta, a, INSIDE * a / 1e-3)
    np.testing.assert_allclose(printed, wedge.pressure(INSIDE * a / 1e-3), rtol=1e-9)
    assert not memo.eq15(1.0, theta, 1e-3, OUTSIDE).any()
    assert memo.eq15(1.0, theta, 1e-3, 0.0) == np.inf


@pytest.mark.parametrize("nu", [0.5, 0.3])
def test_half_width_of_a_cylinder(nu):
    radius = 8e-3
    skin = HalfPlane(Material(young=E, poisson=nu))
    hertz = Hertz.from_radius(P, radius, skin.material)
    assert memo.eq17_corrected(P, radius, E, nu) == pytest.approx(float(hertz.half_width), rel=1e-14)
    for width, fits in ((memo.eq17_corrected, 1), (memo.eq17, 4)):
        a = float(width(P, radius, E, nu))
        y = np.array([-0.7, 0.2, 0.5]) * a
        slope = skin.surface_gradient(Hertz(P, half_width=a), y).ux
        np.testing.assert_allclose(slope, -y / (fits * radius), rtol=1e-12)


# --- Section 5 ---


def test_pressure_between_edges():
    a1, a2 = 0.5e-3, 2.5e-3
    y = np.array([0.4e-3, 0.6e-3, 1.5e-3, 2.4e-3, 2.6e-3])
    np.testing.assert_allclose(
        memo.eq18_corrected(P, a1, a2, y), Hertz(P, position=1.5e-3, half_width=1e-3).pressure(y), rtol=1e-12
    )
    load = integrate.quad(lambda s: memo.eq18(P, a1, a2, s), a1, a2, epsrel=1e-12, epsabs=0)[0]
    assert load / P == pytest.approx(np.sqrt(3) / (2 * np.pi) + 1 / 3, rel=1e-10)
    edge = memo.eq18(P, a1, a2, np.nextafter(a2, 0))
    assert edge == pytest.approx(np.sqrt(3) * P / (np.pi * (a2 - a1)), rel=1e-12)


@pytest.mark.parametrize("contact", [Strip, Hertz, FlatPunch, Wedge])
def test_strain_beneath_any_pressure(contact):
    touch = contact(P, -ALPHA, 0.4e-3, half_width=1e-3)
    frictionless = contact(P, 0.0, 0.4e-3, half_width=1e-3)
    kinks = (0.4e-3,) if contact is Wedge else ()
    upright = contact(P, 0.0, 0.4e-3, half_width=1e-3)
    y = np.array([-1e-3, 0.35e-3, 1.4e-3, 4e-3])
    normal = memo.eq19(upright.pressure, X, y, 0.0, E, -0.6e-3, 1.4e-3, kinks)
    close(normal, SKIN.strain(frictionless, x=X, y=y).xx, 1e-11)
    inclined = memo.eq19(lambda s: touch.pressure(s) / np.cos(ALPHA), X, y, ALPHA, E, -0.6e-3, 1.4e-3, kinks)
    close(inclined, SKIN.strain(touch, x=X, y=y).xx, 1e-11)
    close(memo.eq23(upright.pressure, X, y, E, -0.6e-3, 1.4e-3, kinks), normal, 1e-11)


def test_strain_beneath_a_sliding_cylinder():
    x = np.array([1e-6, 1e-4, 0.7e-3, 1e-2])[:, None]
    y = np.array([-2e-3, 0.0, 0.9e-3, 2.5e-3, 2.6e-3])
    touch = Hertz(P, -ALPHA, 1.5e-3, half_width=1e-3)
    close(memo.eq20_corrected(P, x, y, ALPHA, E, 0.5e-3, 2.5e-3), SKIN.strain(touch, x=x, y=y).xx, 1e-11)


def test_printed_strain_beneath_a_sliding_cylinder_is_that_of_its_pressure():
    a1, a2, y = 0.5e-3, 2.5e-3, np.array([0.0, 1.5e-3, 2.2e-3])
    pressure = memo.eq19(lambda s: memo.eq18(P, a1, a2, s), X, y, ALPHA, E, a1, a2)
    close(memo.eq20(P, X, y, ALPHA, E, a1, a2), pressure, 1e-11)
    assert memo.eq20(P, 1.0, 0.0, 0.0, E, a1, a2) == pytest.approx(
        0.60899778 * float(memo.eq8(P, 0.0, 1.0, 0.0, E)), rel=1e-5
    )


def test_slope_beneath_the_centre():
    a, x, h = 1e-3, np.array([1e-5, 0.5e-3, 0.9e-3, 3e-3, 2e-2]), 1e-6
    touch = Hertz(P, -ALPHA, half_width=a)
    ahead, behind = (SKIN.strain(touch, x=x, y=side * h).xx for side in (1, -1))
    twice_ahead, twice_behind = (SKIN.strain(touch, x=x, y=2 * side * h).xx for side in (1, -1))
    slope = (8 * (ahead - behind) - (twice_ahead - twice_behind)) / (12 * h)
    np.testing.assert_allclose(memo.eq21_corrected(P, a, x, ALPHA, E), slope, rtol=1e-6)
    assert memo.eq22_corrected(P, a, ALPHA, E) == pytest.approx(memo.eq21_corrected(P, a, 0.0, ALPHA, E).item())
    # far beneath it is a line load's
    assert memo.eq21_corrected(P, a, 1.0, ALPHA, E) == pytest.approx(
        3 * P * np.sin(ALPHA) / (2 * np.pi * E * 1.0**2), rel=1e-5
    )


@pytest.mark.skipif(not SLOPES.exists(), reason="the reference values are not beside this checkout")
def test_slope_reference_values():
    data = json.loads(SLOPES.read_text())
    given = data["parameters"]
    p, a, alpha, young = given["P"], given["a"], given["alpha"], given["E"]
    assert len(data["points"]) >= 10
    for point in data["points"]:
        x = float(point["x"])
        slope, strain = float(point["slope_deps_x_dy_at_centre"]), float(point["eps_x_at_centre"])
        # just beside the depth where it vanishes the slope has lost digits
        scale = abs(float(memo.eq22_corrected(p, a, alpha, young))) * min(1.0, (a / x) ** 2)
        assert memo.eq21_corrected(p, a, x, alpha, young) == pytest.approx(slope, rel=1e-13, abs=1e-14 * scale)
        assert memo.eq20_corrected(p, x, 0.0, alpha, young, -a, a) == pytest.approx(strain, rel=1e-10)
        printed = float(point["memo_eq21_with_a_half_width"]), float(point["memo_eq22_with_a_half_width"])
        assert memo.eq21(p, a, x, alpha, young) == pytest.approx(printed[0], rel=1e-12, abs=1e-14)
        assert memo.eq22(p, a, alpha, young) == pytest.approx(printed[1], rel=1e-12)


# --- Section 6 ---


def test_response_and_its_spectrum():
    y = np.array([-3e-3, 0.0, 1e-3])
    close(memo.eq24(2e-3, y) * P / E, memo.eq8(P, 0.0, 2e-3, y, E))
    for s in (-0.4, -0.05, 0.05, 0.3):
        transform = integrate.quad(lambda y: memo.eq24(1.5, y), 0, np.inf, weight="cos", wvar=2 * np.pi * abs(s))
        assert memo.eq25_corrected(s, 1.5) == pytest.approx(2 * transform[0], rel=1e-7)
        assert memo.eq25(s, 1.5) == pytest.approx(np.sign(s) * memo.eq25_corrected(s, 1.5).item())


def test_density_of_sensors():
    targets = np.array([10.0, 100.0, 1e3, 1e4])
    np.testing.assert_allclose(memo.eq26(memo.eq26_corrected(targets)), targets, rtol=1e-12)
    assert (memo.eq26_corrected(targets) > 1).all()
    d, f = 1.7, 4.0  # what (26) says of (25)
    response = memo.eq25(np.array([1.0, f]) / (2 * np.pi * d), d)
    assert memo.eq26(f) == pytest.approx(response[0] / response[1], rel=1e-13)


# --- Every function ---

SAMPLE = {"alpha": 1, "theta": 1, "nu": 0, "y": 2, "y0": 2, "s": 1, "a1": -1, "a2": 2, "f": 2, "attenuation": 20}
FUNCTIONS = [getattr(memo, name) for name in memo.__all__ if re.match(r"eq\d", name)]


def arguments(function):
    names = list(inspect.signature(function).parameters)
    given = {name: SAMPLE.get(name, 3) for name in names if name not in ("kinks", "pressure")}
    if "eps_x" in names and function.__name__.startswith("eq13"):
        given["eps_x"] = [1, 3, 2]
    if "pressure" in names:
        given["pressure"] = np.ones_like
    return given


def arrays(result):
    return result if isinstance(result, tuple) else (result,)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_integers_mean_floats_and_arrays_broadcast(function):
    given = arguments(function)
    single = arrays(function(**given))
    fixed = {"pressure", "a1", "a2"} if "pressure" in given else set()
    if function.__name__ == "eq13_coefficients":
        fixed = {"x", "b"}
    floats = {k: v if k == "pressure" else np.asarray(v, dtype=float) for k, v in given.items()}
    for a, b in zip(single, arrays(function(**floats)), strict=True):
        assert a.dtype == np.float64
        np.testing.assert_array_equal(a, b)
    for name, value in given.items():
        if name in fixed:
            continue
        batch = np.array([value, value])
        kept = batch.copy()
        for a, b in zip(arrays(function(**{**given, name: batch})), single, strict=True):
            assert a.shape == (2, *b.shape)
            np.testing.assert_allclose(a, [b, b], rtol=1e-14)
        np.testing.assert_array_equal(batch, kept)


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda f: f.__name__)
def test_bad_values_are_refused(function):
    given = arguments(function)
    for name, value in given.items():
        if name == "pressure":
            continue
        bad = np.array(value, dtype=float)
        bad[...] = np.nan
        with pytest.raises(InvalidValueError, match=name):
            function(**{**given, name: bad})
        if name in memo.SYMBOLS and memo.SYMBOLS[name].positive:
            with pytest.raises(InvalidValueError, match=rf"{name} = 0: has to be > 0"):
                function(**{**given, name: 0})


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda: memo.eq4(P, 0.0, 0.0, 0.0), InvalidValueError, "infinite where the load acts"),
        (lambda: memo.eq8(P, 0.0, [1.0, 0.0], 0.0, E), InvalidValueError, "infinite where the load acts"),
        (lambda: memo.eq12(P, 0.0, 0.0, 0.0, 1.0, E), GeometryError, "beneath the surface"),
        (lambda: memo.eq13([1.0, 2.0], 0.0, 1.0, 1.0), GeometryError, "three readings"),
        (lambda: memo.eq15(1.0, np.pi, 1.0, 0.5), InvalidValueError, "between 0 and pi"),
        (lambda: memo.eq17(-1.0, 1.0, E, 0.5), InvalidValueError, "pressed"),
        (lambda: memo.eq17_corrected(-1.0, 1.0, E, 0.5), InvalidValueError, "pressed"),
        (lambda: memo.eq18(P, 1.0, 1.0, 0.0), GeometryError, "right edge"),
        (lambda: memo.eq19(np.ones_like, 1.0, 0.0, 0.0, E, 1.0, 1.0), GeometryError, "right edge"),
        (lambda: memo.eq20(P, 1.0, 0.0, 0.0, E, 2.0, 1.0), GeometryError, "right edge"),
        (lambda: memo.eq20(P, 0.0, 0.0, 0.0, E, 1.0, 2.0), GeometryError, "beneath the surface"),
        (lambda: memo.eq23(np.ones_like, 1.0, 0.0, E, 1.0, 1.0), GeometryError, "right edge"),
        (lambda: memo.eq26_corrected(0.5), InvalidValueError, "attenuation = 0.5"),
        (lambda: memo.eq8(P, 0.0, [1.0, 2.0], [1.0, 2.0, 3.0], E), GeometryError, "broadcast"),
    ],
)
def test_what_makes_no_sense_is_refused(call, error, words):
    with pytest.raises(error, match=words):
        call()


# --- Errata ---


def numbers_of(equation):
    return next(e for e in memo.ERRATA if e.equation == equation).numbers()


def test_errata_name_every_equation_once():
    covered = []
    for erratum in memo.ERRATA:
        if erratum.equation.startswith("Fig"):
            continue
        ends = [int(n) for n in re.findall(r"\d+", erratum.equation)]
        covered += range(ends[0], ends[-1] + 1) if " to " in erratum.equation else ends
    assert covered == list(range(1, 27))


def test_errata_name_functions_that_exist_and_leave_none_out():
    named = [n for e in memo.ERRATA for n in re.findall(r"\w+", e.functions) if n not in ("solved", "by")]
    for name in named:
        assert hasattr(memo, name) or name == "three_sensor", name
    assert {f.__name__ for f in FUNCTIONS} <= set(named)


def test_wrong_equations_have_both_forms():
    for erratum in memo.ERRATA:
        wrong = erratum.judgement in ("wrong", "rounded", "first order")
        assert bool(erratum.published) == bool(erratum.corrected) == ("_corrected" in erratum.functions) == wrong


def test_numbers_of_the_errata():
    """Against closed forms that the findings do not use."""
    root3, golden = np.sqrt(3), (np.sqrt(5) - 1) / 2
    expected = {
        "1 to 4": {"Fx": root3 / 2, "Fy": -0.5},
        "5": {"ratio": 0.75},
        "9, 10": {"ratio": 11 / 9, "first": 1.2, "exact": 1.21},
        "11": {"ratio": 1.1 / 0.95**2, "exact": 1.21},
        "14": {"load": 1.0},
        "15": {"load": 1.0, "slope": 1.0},
        "16": {"load": 1.0},
        "17": {"ratio": 2.0, "peak": 0.5, "radius": 4.0},
        "18": {"load": root3 / (2 * np.pi) + 1 / 3, "edge": root3 / np.pi},
        "21": {"falls": 8.0, "should": 4.0, "blind": np.sqrt(golden)},
        "22": {"limit": -1.0, "part": root3 / (2 * np.pi)},
        "25": {"printed": 0.3 * np.pi * np.exp(-0.2 * np.pi), "integral": -0.3 * np.pi * np.exp(-0.2 * np.pi)},
    }
    for equation, values in expected.items():
        found = numbers_of(equation)
        for name, value in values.items():
            assert found[name] == pytest.approx(value, rel=1e-9), (equation, name)
    thirteen = numbers_of("13")
    assert (thirteen["degree_line"], thirteen["degree_equal"], thirteen["false_roots"]) == (7, 6, "-1 and +1")
    assert numbers_of("20")["deep"] == pytest.approx(root3 / (2 * np.pi) + 1 / 3, rel=1e-6)
    f = numbers_of("26")["f"]
    assert np.exp(f - 1) / f == pytest.approx(1000, rel=1e-12)
    assert numbers_of("26")["density"] == pytest.approx(3.25739667896, rel=1e-11)


def test_the_error_over_the_middle_sensor_goes_with_a_square_root():
    positions = []
    for error in (1e-6, 1e-8):
        readings = memo.eq12(1.0, 0.0, 0.0, 1.0, 0.75, 1.0) * [1, 1 + error, 1]
        roots = three_sensor(readings, [-0.75, 0, 0.75], 1.0, young=1.0).roots
        positions.append(min(r.position for r in roots if r.position > 0))
    assert positions[0] == pytest.approx(numbers_of("13")["moved"])
    assert positions[0] / positions[1] == pytest.approx(10, rel=1e-3)


def test_page_of_errata_is_what_the_module_prints():
    printed = subprocess.run([sys.executable, "-m", "subskin.memo"], capture_output=True, text=True, check=True)
    page = (ROOT / "docs" / "errata.md").read_text(encoding="utf-8")
    assert printed.stdout == page, "python -m subskin.memo > docs/errata.md"


def test_memo_needs_scipy_only_for_its_numbers():
    code = "import sys, subskin.memo; sys.exit('scipy' in sys.modules or 'matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
