"""What members of classes of one's own give is checked as they give it: the error names the member, not an array."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pytest

import subskin as ss
from subskin.errors import InvalidValueError

RUBBER = ss.Material(young=0.4e6)
SKIN, SPACE = ss.HalfPlane(RUBBER), ss.HalfSpace(RUBBER)
LAYER = ss.Layered(ss.Layer(RUBBER, 6e-3))
WRONG = {
    "nothing": None,
    "a text": "x",
    "one number": 1.0,
    "another shape": np.ones((7, 5)),
    "an object": object(),
    "texts": np.array(["a", "b"]),
    "rows of different lengths": [[1.0], [2.0, 3.0]],
}


class Bar(ss.Contact):
    """1 kPa on 2 mm."""

    components, support = [2.0, 0.0], (-1e-3, 1e-3)

    def pressure(self, y):
        return np.where(np.abs(y) <= 1e-3, 1e3, 0.0)

    def shear(self, y):
        return 0.0

    def spectrum(self, k):
        return 2.0 * np.sinc(1e-3 * k / np.pi), np.zeros_like(k)


class Pad(ss.LocalContact):
    """1 MPa on a square of 2 mm."""

    components, moment, position, support = [4.0, 0.0, 0.0], 0.0, (0.0, 0.0), ((-1e-3, -1e-3), (1e-3, 1e-3))

    def pressure(self, y, z):
        return np.where(np.maximum(np.abs(y), np.abs(z)) <= 1e-3, 1e6, 0.0)

    def shear(self, y, z):
        return np.zeros(2)

    def spectrum(self, ky, kz):
        p = 4.0 * np.sinc(1e-3 * ky / np.pi) * np.sinc(1e-3 * kz / np.pi)
        return p, 0.0 * p, 0.0 * p


def with_member(base, name, value):
    """A class of which one member gives `value`."""
    usual = vars(base).get(name, getattr(base, name, None))
    return type("Mine", (base,), {name: (lambda *_, **__: value) if callable(usual) else value})


def test_plain_numbers_and_tuples_are_as_good_as_arrays():
    strip, patch = ss.Strip(2.0, half_width=1e-3), ss.Patch(4.0, half_widths=(1e-3, 1e-3))
    for skin in (SKIN, LAYER):
        np.testing.assert_allclose(
            skin.stress(Bar(), 2e-3, [0, 1e-3]).xx, skin.stress(strip, 2e-3, [0, 1e-3]).xx, rtol=1e-6, equal_nan=False
        )
    for skin in (SPACE, LAYER):
        np.testing.assert_allclose(
            skin.stress(Pad(), 2e-3, 0.0, 0.0).xx, skin.stress(patch, 2e-3, 0.0, 0.0).xx, rtol=1e-3, equal_nan=False
        )


def asked(name):
    """Reads a member that is no method."""
    return lambda mine, *_: getattr(mine, name)


def pressed(skin, verb="stress"):
    """Presses a local contact on a skin."""
    return lambda mine: getattr(skin, verb)(mine, 1e-3, [0.0, 1e-3, 2e-3], 0.0)


LONG = {
    "components": asked("components"), "support": asked("support"), "shape": asked("shape"), "pressure": SKIN,
    "shear": SKIN, "spectrum": LAYER, "transforms": SKIN, "singular_points": SKIN, "expand": LAYER,
}  # fmt: skip
LOCAL = {
    "pressure": pressed(SPACE), "shear": pressed(SPACE), "spectrum": pressed(LAYER), "transforms": pressed(SPACE),
    "potentials": pressed(SPACE, "displacement"), "radial_terms": pressed(LAYER), "expand": pressed(LAYER),
    "singular": lambda mine: mine.singular(np.zeros(3), np.zeros(3)),
    **{name: asked(name) for name in ("components", "position", "moment", "support", "OUTLINE")},
}  # fmt: skip


@pytest.mark.parametrize("gave", WRONG)
@pytest.mark.parametrize("member", LONG)
def test_a_long_contact_of_ones_own(member, gave):
    mine = with_member(Bar, member, WRONG[gave])()
    if (member, gave) in {("pressure", "one number"), ("shear", "one number")}:
        return  # a number for all points
    at = 0.0 if member == "singular_points" else 1e-3
    with pytest.raises(InvalidValueError, match=rf"Mine\.{member}.*(gave|has to be)"):
        LONG[member](mine, at) if callable(LONG[member]) else LONG[member].stress(mine, at, [0.0, 1e-3, 2e-3])


@pytest.mark.parametrize("gave", WRONG)
@pytest.mark.parametrize("member", LOCAL)
def test_a_local_contact_of_ones_own(member, gave):
    mine = with_member(Pad, member, WRONG[gave])()
    if gave == "one number" and member in {"pressure", "shear", "moment"}:
        return
    if (member, gave) == ("support", "rows of different lengths"):
        return  # two corners, each of which NumPy can spread
    if gave == "nothing" and member in {"transforms", "potentials", "radial_terms"}:
        return  # it has none
    with pytest.raises(InvalidValueError, match=rf"Mine\.{member}.*(gave|has to be)"):
        LOCAL[member](mine)


@pytest.mark.parametrize("gave", ["a text", "one number", "another shape", "rows of different lengths"])
@pytest.mark.parametrize(
    "member", ["disc_slope", "unit_slope", "unit_family", "disc_family", "drag_family", "unit_core"]
)
def test_a_round_contact_of_ones_own(member, gave):
    mine = with_member(ss.RoundHertz, member, WRONG[gave])(1.0, 0.2, 0.0, half_width=1e-3, moment=1e-4)
    if gave == "one number" and member in {"disc_slope", "unit_core"}:
        return
    with pytest.raises(InvalidValueError, match=rf"Mine\.{member}.*gave"):
        mine.shear([0.0, 1e-4, 2e-4], 0.0) if "slope" in member else SPACE.stress(mine, 1e-3, [0.0, 1e-3, 2e-3], 0.0)


@pytest.mark.parametrize("gave", WRONG)
def test_line_loads_of_ones_own(gave):
    kind = type("Mine", (ss.Hertz,), {"as_line_loads": classmethod(lambda _: WRONG[gave])})
    with pytest.raises(InvalidValueError, match=r"Mine\.as_line_loads.*gave"):
        kind.as_line_loads()


class OwnLayer(ss.Skin):
    """A layer that says what it is."""

    materials, thickness, takes_local, interfaces, curvature, ridges = (RUBBER,), 6e-3, True, (), 0, None

    def at(self, x, y, z=None):
        return LAYER.at(x, y, z)

    def wave(self, k, x):
        return LAYER.wave(k, x)

    def surface_influence(self, step, count):
        return LAYER.surface_influence(step, count).tolist()

    def area_influence(self, step, shape, drag=False):
        return LAYER.area_influence(step, shape, drag)


BALL, ROLLER = ss.pressing.Sphere(8e-3), ss.pressing.Cylinder(8e-3)
ASKED = {
    "at": lambda skin: skin.stress(ss.LineLoad(40.0), 1e-3, [0.0, 1e-3]),
    "wave": lambda skin: skin.surface_compliance([100.0, 200.0, 300.0]),
    "surface_influence": lambda skin: skin.surface_influence(1e-4, 8),
    "area_influence": lambda skin: skin.area_influence(1e-4, (4, 4), False),
    **{name: asked(name) for name in ("materials", "thickness", "interfaces", "curvature", "ridges", "takes_local")},
}


def test_a_skin_of_ones_own_is_as_good():
    mine = OwnLayer()
    np.testing.assert_array_equal(
        mine.stress(ss.LineLoad(40.0), 1e-3, 0.0).xx, LAYER.stress(ss.LineLoad(40.0), 1e-3, 0.0).xx
    )
    assert ss.press(mine, ROLLER, force=40.0).depth == ss.press(LAYER, ROLLER, force=40.0).depth
    assert ss.press(mine, BALL, force=0.1).depth == ss.press(LAYER, BALL, force=0.1).depth


@pytest.mark.parametrize("gave", WRONG)
@pytest.mark.parametrize("member", ASKED)
def test_what_a_skin_of_ones_own_gives(member, gave):
    if (member, gave) in {("thickness", "one number"), ("curvature", "one number"), ("ridges", "nothing")}:
        return
    with pytest.raises(InvalidValueError, match=rf"Mine\.{member}.*gave"):
        ASKED[member](with_member(OwnLayer, member, WRONG[gave])())


def test_a_state_and_waves_of_another_kind():
    """What `at` gives is called with a contact, and answers with a State."""
    with pytest.raises(InvalidValueError, match=r"Mine\.at\(\.\.\.\)\(contact\) gave None: a State is needed"):
        with_member(OwnLayer, "at", lambda _: None)().stress(ss.LineLoad(40.0), 1e-3, 0.0)
    short = LAYER.wave([1.0], [0.0])
    with pytest.raises(InvalidValueError, match=r"Mine\.wave\.stress gave .* a Stress of the shape \(2, 1, 2\)"):
        with_member(OwnLayer, "wave", short)().wave([1.0, 2.0], [0.0])


def test_a_property_that_was_written_as_a_method():
    def materials(self):
        return (RUBBER,)

    with pytest.raises(InvalidValueError, match=r"Mine\.materials, a method: a property is needed\. Fix: @property"):
        type("Mine", (ss.Skin,), {"materials": materials})


def test_properties_are_seen_too():
    class Kept(Bar):
        @cached_property
        def components(self):
            return "x"

    class Said(Bar):
        @property
        def support(self):
            return (0.0,)

    with pytest.raises(InvalidValueError, match=r"Kept\.components gave 'x'"):
        LAYER.stress(Kept(), 1e-3, 0.0)
    with pytest.raises(InvalidValueError, match=r"Said\.support gave \(0\.0,\): two ends are needed"):
        SKIN.stress(Said(), 1e-3, 0.0)
