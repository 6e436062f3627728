"""A skin that nobody knows: every tool treats it as it treats the layer that it answers like."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

import subskin as ss
from subskin import design
from subskin.design.search import Accuracy, Effort, Room, SensorKind, SkinChoice
from subskin.errors import GeometryError, InvalidValueError
from subskin.io.finger_file import parse_finger
from subskin.plot import density_figure, finger_section, response_figure

RUBBER = ss.Material(0.4e6, 0.45)
LAYER = ss.Layered(ss.Layer(RUBBER, 5e-3))
STACK = ss.Layered([ss.Layer(ss.Material(2e6, 0.48), 0.5e-3), ss.Layer(RUBBER, 4e-3)], base=ss.Material(1e9, 0.3))
RING = ss.Round(RUBBER, 8e-3, 4e-3)
HALF = ss.HalfPlane(RUBBER)
ROW = ss.SensorArray.line(6, pitch=1.5e-3, depth=2e-3, noise=5e-5)
TOUCH = ss.Hertz(30.0, 0.3, 0.7e-3, half_width=0.8e-3)
TOUCHES = design.Touches(30.0, 0.8, (-2e-3, 2e-3))


@dataclass(frozen=True)
class Mine(ss.Skin):
    """Answers as `inner` does."""

    inner: ss.Skin

    @property
    def materials(self):
        return self.inner.materials

    def at(self, x, y):
        return self.inner.at(x, y)

    def wave(self, k, x):
        return self.inner.wave(k, x)

    def surface_influence(self, step, count):
        return self.inner.surface_influence(step, count)

    def with_(self, **numbers):
        return Mine(self.inner.with_(**numbers))

    @property
    def interfaces(self):
        return self.inner.interfaces

    @property
    def thickness(self):
        return self.inner.thickness

    @property
    def curvature(self):
        return self.inner.curvature

    @property
    def plane(self):
        return self.inner.plane

    def __str__(self):
        return str(self.inner)


def numbers(found, name="result"):
    """All numbers and words in a result, by their names."""
    if isinstance(found, ss.Skin):
        return numbers((found.materials, found.thickness, str(found)), name)
    if isinstance(found, Figure):
        return numbers([([line.get_xydata() for line in a.lines], a.get_xlabel()) for a in found.axes], name)
    if isinstance(found, Mapping):
        parts = list(found.items())
    elif is_dataclass(found):
        parts = [(field.name, getattr(found, field.name)) for field in fields(found)]
    elif isinstance(found, list | tuple):
        parts = list(enumerate(found))
    else:
        return {name: found}
    return {key: value for part, inner in parts for key, value in numbers(inner, f"{name}.{part}").items()}


@cache
def fingers(skin):
    """On the skin and on its stranger: tools share what each prepares."""
    return ss.Finger(skin, ROW), ss.Finger(Mine(skin), ROW)


def same(tool, skin=LAYER, array=None):
    """The tool's result on a skin and on the stranger that answers like it are the same to the last bit."""
    pair = fingers(skin) if array is None else (ss.Finger(skin, array), ss.Finger(Mine(skin), array))
    known, own = (numbers(tool(finger)) for finger in pair)
    assert known.keys() == own.keys()
    compared = 0
    for name, value in known.items():
        if isinstance(value, np.ndarray | float | int | str | bool | np.generic | None):
            np.testing.assert_array_equal(own[name], value, err_msg=name)
            compared += np.size(value)
    assert compared


def frames(finger):
    return finger.read(ss.Hertz(30.0, [0.3, -0.2], [0.7e-3, -1e-3], half_width=0.8e-3))


def _slip(finger):
    found = finger.locate(frames(finger), load="line")
    return ss.decide.slip(found, 0.6, skin=finger.skin, indenter=ss.pressing.Cylinder(5e-3))


def presses(finger, count):
    """Line loads at even positions, at angles that vary."""
    y = np.linspace(-3e-3, 3e-3, count)
    return y, finger.read(ss.LineLoad(30.0, 0.4 * np.sin(9e3 * y), y))


def known(finger):
    y = np.linspace(-3e-3, 3e-3, 16)
    fit = ("gain", "depth", "poisson", "thickness")
    return ss.calibrate(finger, finger.read(ss.LineLoad(30.0, 0.4, y)), y, fit=fit, force=30.0, angle=0.4, origin=0.0)


def blind(finger):
    more = {"thickness_error": 0.05, "poisson_error": 0.01}
    data = finger.array.digitise(
        finger.measure(ss.LineLoad(30.0, 0.3, np.linspace(-3e-3, 3e-3, 60))), np.random.default_rng(0)
    )
    return ss.calibrate_blind(finger, data, fit=("gain", "poisson", "thickness"), **more)


def softer(finger):
    bump = ss.pressing.ParticleOnFlat(half_width=0.4e-3, protrusion=20e-6, flat_half_width=3e-3)
    return design.skin_compliance(finger, bump, force=20.0, young=[0.2e6], thickness=[4e-3])


def searched(finger):
    goals = design.Goals(
        touches=TOUCHES, strongest=60.0, accuracy=Accuracy(position=0.2e-3), largest_strain=0.3,
        sensors=(SensorKind("gauge", ss.NormalStrain(), noise=5e-5),),
        skins=(SkinChoice("pad", finger.skin),), room=Room((4, 5), (1.5e-3, 2.5e-3), 1e-3, 8e-3),
        effort=Effort(depths=2, pitches=2, touches=200),
    )  # fmt: skip
    grid = design.search_grid(goals, workers=1)
    return grid.depths, grid.pitches, grid.values


TOOLS = {
    "read": frames,
    "locate": lambda f: f.locate(frames(f), load="line"),
    "fit": lambda f: f.fit(frames(f), "hertz"),
    "pressure": lambda f: ss.pressure_map(f, frames(f)[0]),
    "contact type": lambda f: ss.decide.contact_type(f, frames(f)[0]),
    "slip": _slip,
    "side angle": lambda f: ss.side_angle(f, frames(f), position=[0.7e-3, -1e-3], half_width=0.8e-3),
    "blind depth": lambda f: ss.estimate.blind_depth(f.skin, 1e-3),
    "calibrate": known,
    "calibrate blind": blind,
    "check": design.half_plane_error,
    "response": design.spatial_response,
    "density": design.sensor_density,
    "aliasing": lambda f: design.aliasing_error(f, TOUCH, shifts=3),
    "tolerances": lambda f: design.tolerance_budget(f, TOUCHES, positions=3, angles=2, draws=6),
    "placement": lambda f: design.placement_quality(f, TOUCHES, grid=(5, 3)),
    "two points": lambda f: design.two_point_limen(f, TOUCHES, positions=3, shares=[0.5], angles=1),
    "ridge pitch": design.best_ridge_pitch,
    "ridges": lambda f: design.ridge_gain(f, TOUCH, design.Ridges(1e-3)),
    "ridges closed": lambda f: design.ridges.closing_pressure(f.skin, [1e-3, 2e-3], 2e-5),
    "compliance": softer,
    "search": searched,
    "press": lambda f: ss.press(f.skin, ss.pressing.Cylinder(5e-3), force=30.0, friction=0.5, slide=1e-5),
    "section": lambda f: finger_section(f, TOUCH, f.locate(frames(f)[0], load="line")),
    "response drawn": lambda f: response_figure(design.spatial_response(f)),
    "density drawn": lambda f: density_figure(design.sensor_density(f)),
}


@pytest.mark.parametrize("tool", TOOLS.values(), ids=TOOLS)
def test_a_tool_treats_it_as_the_layer(tool):
    same(tool)


@pytest.mark.parametrize("name", ["check", "response", "density", "aliasing", "section", "density drawn"])
def test_and_as_a_ring(name):
    same(TOOLS[name], RING)


@pytest.mark.parametrize("name", ["check", "response", "aliasing"])
def test_and_as_layers_on_a_half_plane(name):
    same(TOOLS[name], STACK)


def test_a_budget_has_all_rows_that_it_has_of_the_skin():
    for skin, more in ((LAYER, {"thickness"}), (RING, {"thickness", "radius"}), (STACK, set())):
        usual = design.usual_tolerances(ss.Finger(Mine(skin), ROW))
        assert usual == design.usual_tolerances(ss.Finger(skin, ROW))
        assert set(usual) >= {"young", "poisson"} | more
    same(
        lambda f: design.tolerance_budget(f, TOUCHES, {"radius": 1e-4, "young": 0.1}, positions=2, angles=2, draws=3),
        RING,
    )


def test_what_holds_on_a_half_plane_alone_holds_on_its_like():
    y = np.tile(0.5e-3 * np.arange(-3, 4), 2)
    two_rows = ss.SensorArray(y=y, depth=np.repeat([1.6e-3, 2e-3], 7), noise=2e-5)
    same(lambda f: ss.estimate.side_angle_from_gradients(f, f.read(TOUCH), position=0.7e-3), HALF, two_rows)
    with pytest.raises(InvalidValueError, match="a half plane"):
        design.half_plane_error(ss.Finger(Mine(HALF), ROW))
    with pytest.raises(InvalidValueError, match="a Mine skin"):
        ss.estimate.side_angle_from_gradients(ss.Finger(Mine(LAYER), two_rows), np.zeros(14), position=0.0)


def test_a_skin_without_with_is_told_which_number_cannot_be_changed():
    class Fixed(Mine):
        with_ = ss.Skin.with_

    with pytest.raises(InvalidValueError, match="materials of a Fixed"):
        design.tolerance_budget(ss.Finger(Fixed(LAYER), ROW), TOUCHES)
    rows = design.tolerance_budget(
        ss.Finger(Fixed(LAYER), ROW), TOUCHES, {"depth": 1e-4}, positions=2, angles=2, draws=2
    ).rows
    assert [row.source for row in rows] == ["depth"]
    with pytest.raises(InvalidValueError, match="thickness of a Fixed"):
        softer(ss.Finger(Fixed(LAYER), ROW))


FILE = """
[skin]
kind = "layers"
[[skin.layers]]
young = "2 MPa"   # epidermis
thickness = "0.5 mm"
[[skin.layers]]
young = "0.4 MPa"
thickness = "4 mm"

[sensors]
count = 4
pitch = "2 mm"
depth = "2 mm"
"""


def test_a_file_refuses_a_skin_that_it_has_no_words_for():
    """And one that would need other keys, instead of a file that describes something else."""
    file = parse_finger(FILE)
    skins = Mine(file.finger.skin), HALF, LAYER, replace(file.finger.skin, base=RUBBER)
    for skin in skins:
        with pytest.raises(InvalidValueError, match=r"the file describes 0\.5 mm"):
            file.with_finger(replace(file.finger, skin=skin), 0.0)


def test_a_file_takes_all_numbers_of_a_stack():
    file = parse_finger(FILE)
    stack = file.finger.skin.with_(materials=[ss.Material(2.2e6, 0.48), ss.Material(0.3e6, 0.5)])
    changed = file.with_finger(replace(file.finger, skin=stack), 0.0)
    assert changed.finger.skin == stack
    assert 'young = "2.2 MPa"   # epidermis' in changed.text


class TestWith:
    @pytest.mark.parametrize("skin", [HALF, LAYER, STACK, RING], ids=["half", "layer", "stack", "ring"])
    def test_materials_in_their_order(self, skin):
        new = [ss.Material(1e5 * (i + 1), 0.1 * i) for i in range(len(skin.materials))]
        other = skin.with_(materials=new)
        assert other.materials == tuple(new)
        assert other.with_(materials=skin.materials) == skin == skin.with_()
        assert (other.thickness, other.interfaces) == (skin.thickness, skin.interfaces)
        for depth in (0.0, 0.3e-3, 0.5e-3, 0.6e-3, 4e-3):  # each is where the stress is
            strain = other.state(TOUCH, depth, 1e-3).strain.xy
            shear = other.state(TOUCH, depth, 1e-3).stress.xy
            assert shear == pytest.approx(2 * other.material_at(depth).shear * strain, rel=1e-12)
        with pytest.raises(InvalidValueError, match="0 materials"):
            skin.with_(materials=[])

    def test_thickness_and_radius(self):
        assert LAYER.with_(thickness=4e-3) == ss.Layered(ss.Layer(RUBBER, 4e-3))
        thinner = RING.with_(thickness=3e-3)
        assert (thinner.radius, thinner.thickness) == (8e-3, pytest.approx(3e-3))
        wider = RING.with_(radius=9e-3)
        assert (wider.radius, wider.thickness) == (9e-3, pytest.approx(4e-3))
        both = RING.with_(radius=9e-3, thickness=3e-3)
        assert (both.radius, both.core_radius) == (9e-3, pytest.approx(6e-3))

    def test_rings(self):
        firm = ss.Material(2e6, 0.48)
        rings = ss.Round(RUBBER, 8e-3, 4e-3, ss.Layer(firm, 1e-3), core=firm)
        assert rings.materials == (firm, RUBBER, firm)
        assert rings.interfaces == pytest.approx((1e-3, 4e-3))
        assert rings.with_() == rings
        changed = rings.with_(materials=[RUBBER, firm, RUBBER], radius=9e-3)
        assert changed == ss.Round(firm, 9e-3, changed.core_radius, ss.Layer(RUBBER, 1e-3), core=RUBBER)
        assert changed.core_radius == pytest.approx(5e-3)
        with pytest.raises(InvalidValueError, match="thickness of a Round"):
            rings.with_(thickness=5e-3)

    @pytest.mark.parametrize(
        ("skin", "given", "error", "said"),
        [
            (HALF, {"thickness": 1e-3}, InvalidValueError, "thickness of a HalfPlane"),
            (HALF, {"radius": 1e-3}, InvalidValueError, "radius of a HalfPlane"),
            (STACK, {"thickness": 1e-3}, InvalidValueError, "thickness of a Layered"),
            (LAYER, {"radius": 1e-3}, InvalidValueError, "radius of a Layered"),
            (LAYER, {"thickness": -1e-3}, InvalidValueError, "thickness"),
            (RING, {"thickness": 8e-3}, GeometryError, "thickness"),
            (RING, {"radius": 3e-3}, InvalidValueError, "core_radius"),
        ],
    )
    def test_what_there_is_not_is_refused(self, skin, given, error, said):
        with pytest.raises(error, match=said):
            skin.with_(**given)
