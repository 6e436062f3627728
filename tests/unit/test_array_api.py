"""Closed forms of the plane, and of shapes in space, under the strictest array namespace there is."""

import array_api_strict as strict
import numpy as np
import pytest
from tests.unit.test_real_forms import SHAPES

import subskin as ss
from subskin.contact import functions, hertz, punch
from subskin.contact.functions import joined, shear_field
from subskin.skin.half_plane import plane_strains, plane_stresses

A = 1.3e-3
LONG = {
    "line": ss.LineLoad(1.0), "strip": ss.Strip(1.0, half_width=A), "hertz": ss.Hertz(1.0, half_width=A),
    "punch": ss.FlatPunch(1.0, half_width=A), "wedge": ss.Wedge(1.0, half_width=A),
}  # fmt: skip
Y, X = (
    np.array(v)
    for v in ([-4e-3, -A, 0.2e-3, 0.9e-3, A, 2e-3, 30e-3, 0.0], [2e-3, 1e-6, 1e-3, 0.0, 3e-4, 0.0, 9e-3, 60e-3])
)


def arrays(*values):
    return tuple(strict.asarray(np.asarray(value, dtype=float)) for value in values)


def numbers(parts):
    return np.array([np.asarray(part) for part in parts])


@pytest.mark.parametrize("kind", LONG)
def test_a_long_contact(kind):
    """Transforms, stresses and strains of a half plane are those that NumPy's classes give."""
    contact, skin, nu = LONG[kind], ss.HalfPlane(ss.Material(0.4e6, 0.4)), 0.4
    x, y = arrays(X, Y)
    f, df = contact.FORM(strict, x, y, *arrays(*contact._sizes))
    z = Y + 1j * X
    for part, whole in zip((f, df), contact.unit_transform(z), strict=True):
        np.testing.assert_allclose(joined(numbers(part)), whole, rtol=1e-12)
    h = functions.line_shear(x, f[0]) if kind == "line" else shear_field(strict, x, f, df)
    none = arrays(0 * X, 0 * X)
    for drag in (False, True):
        given = (none, none, f, df, h) if drag else (f, df, none, none, none[0])
        fields = plane_stresses(strict, x, *given)
        state = skin.state(contact.of_components([0.0, 1.0] if drag else [1.0, 0.0], **sizes(contact)), X, Y)
        near = np.abs(z) < functions.FAR * A  # farther away h is a series
        strains = numbers(plane_strains(strict, *fields, 0.4e6, nu, True))[:, near]
        want = numbers([getattr(state.strain, name) for name in ("xx", "yy", "zz", "xy")])[:, near]
        finite = np.isfinite(want)
        np.testing.assert_allclose(strains[finite], want[finite], rtol=1e-11, atol=1e-13 * np.abs(want[finite]).max())


def sizes(contact):
    return {} if isinstance(contact, ss.LineLoad) else {"half_width": contact.half_width}


def test_the_drag_of_one_that_sticks_in_its_middle():
    touch = ss.PartialSlip(1.0, 0.3, half_width=A, friction=0.6)
    c = touch.stick_half_width
    x, y = arrays(X, Y)
    given = arrays(A, touch._inset, c)
    f, df = hertz.sticking(strict, x, y, *given, strict.asarray(True))
    whole, drag = touch.transforms(Y + 1j * X), float(touch.tangential_force)
    np.testing.assert_allclose(drag * joined(numbers(f)), whole.q, rtol=1e-12)
    np.testing.assert_allclose(drag * joined(numbers(df)), whole.dq, rtol=1e-12)


def test_a_moment_on_a_punch():
    x, y = arrays(X, Y)
    tilted, straight = (ss.FlatPunch(1.0, half_width=A, moment=m).transforms(Y + 1j * X) for m in (1e-4, 0.0))
    f, df = punch.tilt(strict, x, y, *arrays(A))
    np.testing.assert_allclose(1e-4 * joined(numbers(f)), tilted.p - straight.p, rtol=1e-9)
    np.testing.assert_allclose(1e-4 * joined(numbers(df)), tilted.dp - straight.dp, rtol=1e-9, atol=1e-9)


def test_a_contact_far_away_as_its_moments():
    x, y = arrays([0.5, 1e-3, 2.0], [0.3, 0.8, -1.0])
    moments = arrays(1.0, 0.0, 0.3e-6, 0.0, 2e-13)
    with_numpy = functions.far_shear_field(np.asarray(x), np.asarray(y), [np.asarray(m) for m in moments])
    np.testing.assert_allclose(np.asarray(functions.far_shear_field(x, y, moments)), with_numpy, rtol=1e-14)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_local_contact(shape):
    contact = SHAPES[shape]
    form, (_, ty, tz) = contact.real_form(), contact.components
    x, y, z = np.array([2e-3, 1e-3]), np.array([0.5e-3, -1e-3]), np.array([0.3e-3, 0.7e-3])
    want = form.parts(np, (0, 1), x, y, z, ty, tz, *form.sizes)
    found = form.parts(strict, (0, 1), *arrays(x, y, z, ty, tz), *arrays(*form.sizes))
    np.testing.assert_allclose([numbers(pair) for pair in found], want, rtol=1e-12)


def test_a_contact_of_ones_own_gives_its_form():
    class Own(ss.contact.SpreadContact):
        SERIES, FORM = ss.Hertz.SERIES, staticmethod(hertz.hertz)

        def unit_pressure(self, y):
            return ss.Hertz(1.0, half_width=self.half_width).pressure(y)

        def unit_spectrum(self, k):
            return ss.Hertz(1.0, half_width=self.half_width).spectrum(k).p.real

    skin, given = ss.HalfPlane(ss.Material(0.4e6)), {"force": 3.0, "angle": 0.2, "half_width": A}
    np.testing.assert_array_equal(skin.strain(Own(**given), X, Y).matrix, skin.strain(ss.Hertz(**given), X, Y).matrix)


@pytest.mark.filterwarnings("ignore::subskin.errors.SingularPointWarning")
def test_along_a_long_contact_nothing_is_strained_even_where_it_is_infinite():
    strain = ss.HalfPlane(ss.Material(0.4e6)).strain(ss.LineLoad(40.0), [0.0, 1e-3], 0.0)
    assert np.isnan(strain.xx).tolist() == [True, False]
    assert strain.zz.tolist() == [0.0, 0.0]
