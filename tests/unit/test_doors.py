"""What comes in at the doors: quantities of pint, magnitudes that are off, values of the wrong kind."""

from __future__ import annotations

import inspect
import warnings

import numpy as np
import pint
import pytest

import subskin as ss
from subskin.errors import InvalidValueError, SubskinError, ValidityWarning, printable
from subskin.lattice import even_grid
from subskin.radial import tabulate_radial
from subskin.radial_round import tabulate_round
from subskin.response import Response

U = pint.UnitRegistry()
RUBBER = ss.Material(young=0.4e6)
SKIN = ss.HalfPlane(RUBBER)
LAYER = ss.Layered(ss.Layer(RUBBER, 6e-3))
ARRAY = ss.SensorArray.line(count=5, pitch=1.5e-3, depth=2e-3, noise=1e-4)
FINGER = ss.Finger(SKIN, ARRAY)
AREA = ss.Finger(LAYER, ss.SensorArray.grid((3, 3), pitch=2e-3, depth=2e-3, noise=1e-3))
TOUCHES = ss.design.Touches(force=20.0)
TOUCHES_ON_AREA = ss.design.Touches(force=1.0, area=((-2e-3, 2e-3), (-2e-3, 2e-3)))
GOOD = {"start": -5e-3, "stop": 5e-3, "step": 1e-4}
HUGE = 10**400
LONG = 10**5000  # which Python does not even write out


def test_quantities_are_converted():
    assert ss.Material(young=U.Quantity(0.4, "MPa")) == RUBBER
    assert ss.Layer(RUBBER, U.Quantity(6, "mm")).thickness == pytest.approx(6e-3)
    array = ss.SensorArray.line(count=5, pitch=U.Quantity(1.5, "mm"), depth=U.Quantity(0.2, "cm"), noise=1e-4)
    np.testing.assert_allclose(array.y, ARRAY.y)
    np.testing.assert_allclose(array.depth, ARRAY.depth)
    listed = ss.SensorArray(y=[U.Quantity(-1, "mm"), U.Quantity(0.1, "cm")], depth=U.Quantity([2.0, 3.0], "mm"))
    np.testing.assert_allclose(listed.y, [-1e-3, 1e-3])
    np.testing.assert_allclose(listed.depth, [2e-3, 3e-3])
    touch = ss.Hertz(
        force=U.Quantity(40, "N/m"), angle=U.Quantity(30, "deg"), position=U.Quantity(0.8, "mm"),
        half_width=U.Quantity(400, "um"),
    )  # fmt: skip
    plain = ss.Hertz(force=40.0, angle=np.pi / 6, position=0.8e-3, half_width=0.4e-3)
    np.testing.assert_allclose(FINGER.read(touch), FINGER.read(plain), rtol=1e-12)
    given = SKIN.stress(plain, U.Quantity(2, "mm"), U.Quantity([0.0, 1.0], "mm"))
    np.testing.assert_allclose(given.xx, SKIN.stress(plain, 2e-3, [0.0, 1e-3]).xx, rtol=1e-12)
    ends = (U.Quantity(-4, "mm"), U.Quantity(4, "mm"))
    assert FINGER.locator(search=ends).response.stop == pytest.approx(4e-3)
    relaxing = ss.Relaxation(share=U.Quantity(20, "percent"), time=U.Quantity(150, "ms"))
    assert (relaxing.share.tolist(), relaxing.time.tolist()) == ([0.2], [0.15])


@pytest.mark.parametrize(
    "make",
    [
        lambda: ss.Material(young=U.Quantity(0.4, "mm")),
        lambda: ss.Material(young=0.4e6, poisson=U.Quantity(0.5, "m")),
        lambda: ss.SensorArray.line(count=4, pitch=U.Quantity(2, "s"), depth=2e-3),
        lambda: ss.SensorArray.line(count=U.Quantity(4, "m"), pitch=2e-3, depth=2e-3),
        lambda: ss.LineLoad(force=U.Quantity(40, "kg")),
        lambda: ss.LineLoad(force=40.0, angle=U.Quantity(1, "m")),
        lambda: SKIN.stress(ss.LineLoad(40.0), U.Quantity(2, "Pa"), 0.0),
        lambda: FINGER.locator(search=(U.Quantity(-4, "Pa"), U.Quantity(4, "Pa"))),
        lambda: FINGER.locator(friction=U.Quantity(1, "N")),
        lambda: FINGER.locate(U.Quantity(np.zeros(5), "Pa")),
        lambda: ss.Relaxation(share=0.2, time=U.Quantity(1, "m")),
        lambda: ss.Relaxation(share=U.Quantity(0.2, "Pa"), time=1.0),
        lambda: FINGER.blind_spots(count=10, friction=U.Quantity(0.5, "N")),
    ],
)
def test_a_quantity_of_another_dimension_is_refused(make):
    with pytest.raises(SubskinError):
        make()


def test_forgotten_units_are_said():
    with pytest.warns(ValidityWarning, match=r"young = 0.4 Pa: if 0.4 MPa was meant, write 400000\."):
        ss.Finger(ss.HalfPlane(ss.Material(young=0.4)), ss.SensorArray.line(count=4, pitch=1.5e-3, depth=2e-3))
    with pytest.warns(ValidityWarning, match=r"the largest depth = 2 m: if 2 mm was meant, write 0.002\."):
        ss.Finger(SKIN, ss.SensorArray.line(count=4, pitch=1.5e-3, depth=2))
    with pytest.warns(ValidityWarning, match=r"the largest depth = 0\.5 m: if 0\.5 mm was meant, write 0\.0005\."):
        ss.Finger(SKIN, ss.SensorArray.line(count=4, pitch=0.6, depth=0.5))
    with pytest.warns(ValidityWarning, match=r"the largest y = 9 m: if 9 mm was meant"):
        ss.Finger(SKIN, ss.SensorArray.line(count=4, pitch=6, depth=5e-3))
    with pytest.warns(ValidityWarning, match=r"position = 0.8 m: if 0.8 mm was meant"):
        ss.Finger(SKIN, FINGER.array).read(ss.LineLoad(40.0, position=0.8))
    with pytest.warns(ValidityWarning, match=r"half_width = 0.4 m: if 0.4 mm was meant"):
        ss.Finger(SKIN, FINGER.array).read(ss.Hertz(40.0, half_width=0.4))


def test_usual_and_dimensionless_ones_pass_in_silence():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ss.Material(young=1e3)
        ss.Finger(SKIN, ss.SensorArray.line(count=8, pitch=5e-3, depth=30e-3))
        ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), ss.SensorArray.line(count=3, pitch=2.5, depth=3.0))
        own = ss.SensorArray.line(count=8, pitch=0.75, depth=1.0)
        ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), own).read(ss.Hertz(1.0, position=2.0, half_width=0.5))
        FINGER.read(ss.LineLoad(40.0, position=[-20e-3, 20e-3]))


@pytest.mark.parametrize(
    "make",
    [
        lambda: ss.Material(young=HUGE),
        lambda: ss.Material(young=LONG),
        lambda: ss.SensorArray(y=[0.0, HUGE], depth=2e-3),
        lambda: ss.LineLoad(force=LONG),
        lambda: ss.LineLoad(force=np.array([40.0 + 1j])),
        lambda: ss.Material(young=np.datetime64("2020-01-01")),
        lambda: FINGER.locate(LONG),
        lambda: FINGER.locate(np.zeros(5) + 1j),
        lambda: FINGER.locate(np.zeros(5, dtype="M8[s]")),
        lambda: FINGER.locator(scan_step=1e-300),
        lambda: AREA.locator(scan_step=1e-300),
        lambda: AREA.locator(search=((-1e9, 1e9), (-1e9, 1e9))),
        lambda: ss.Finger(LAYER, ss.SensorArray.grid((3, 3), 2.0, 2e-3, noise=1e-3)).locate(np.zeros(9)),
        lambda: ss.pressure_map(AREA, np.zeros(9), step=1e-300),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=40.0, position=1e30),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=40.0, window=1e-300),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=40.0, tilt=np.ones(2)),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=40.0, friction=np.ones(2)),
        lambda: ss.design.placement_quality(AREA, TOUCHES_ON_AREA, samples=1e300),
        lambda: ss.design.placement_quality(AREA, TOUCHES_ON_AREA, rng=-1),
        lambda: ss.design.placement_quality(AREA, TOUCHES_ON_AREA, grid=[1, [2]]),
        lambda: ss.calibration.choose(np.ones(2), np.ones((9, 5)), np.zeros(9)),
        lambda: ss.calibration.choose({"mine": FINGER}, np.ones((40, 5)), np.zeros(40)),
        lambda: ss.design.aliasing_error(FINGER, sensor=np.ones(2)),
        lambda: ss.design.search_grid("goals.toml"),
        lambda: ss.synthetic.simulate_recording(FINGER, [0.0], force=40.0, rate=1e300),
        lambda: FINGER.array.usable(None),
        lambda: FINGER.array.usable("x"),
        lambda: FINGER.array.usable(np.zeros(4)),
        lambda: ss.pressing.Cylinder(radius=np.zeros((0, 3))),
        lambda: ss.pressing.ParticleOnFlat(4e-4, 3e-5, flat_half_width=[1e-2, 2e-2]),
        lambda: ss.Tare(FINGER)(np.zeros((3, 5)), 1.0),
        lambda: ss.Tare(FINGER)(np.zeros((3, 5)), {}),
        lambda: ss.Tare(FINGER)(np.zeros((3, 5)), np.ma.masked_array(np.arange(3.0), [False, True, False])),
        lambda: ss.SensorArray.line(count=np.nan, pitch=1e-3, depth=2e-3),
        lambda: ss.SensorArray.line(count="x", pitch=1e-3, depth=2e-3),
        lambda: ss.SensorArray.line(count=1e9, pitch=1e-3, depth=2e-3),
        lambda: ss.SensorArray.line(count=[3], pitch=1e-3, depth=2e-3),
        lambda: ss.SensorArray.line(count=True, pitch=1e-3, depth=2e-3),
        lambda: ss.SensorArray.line(count=3, pitch=1e-3, depth=2e-3, width=1.0),
        lambda: FINGER.locator(friction=[1.0]),
        lambda: FINGER.locator(friction=LONG),
        lambda: FINGER.locator(outliers=[1]),
        lambda: FINGER.locator(outliers=np.array([1])),
        lambda: FINGER.locator(search=[[1], [2, 3]]),
        lambda: FINGER.locator(search=(0.0, HUGE)),
        lambda: FINGER.locate(np.zeros(5), friction=[1.0]),
        lambda: FINGER.fit(np.zeros(5), outliers=[1]),
        lambda: ss.pressure_map(FINGER, np.zeros(5), friction=[1.0]),
        lambda: ss.pressure_map(FINGER, np.zeros(5), search=[[1], [2, 3]]),
        lambda: LAYER.strain(ss.LineLoad(40.0), x=2e-3, y=1e9),
        lambda: ss.Layered([ss.Layer(RUBBER, 1e-3)] * 41),
        lambda: ss.Finger(LAYER, ss.SensorArray.line(5, 1.5e-3, depth=1e-9, noise=1e-4)).locate(np.zeros(5)),
        lambda: ss.Finger(SKIN, ss.SensorArray.line(5, 1.5e-3, depth=1e-300, noise=1e-4)).locate(np.zeros(5)),
        *(
            (lambda given=given: Response.from_function(FINGER.receptive_field, **(GOOD | given)))
            for given in (
                {"start": "x"}, {"start": np.nan}, {"stop": np.inf}, {"stop": [1.0]}, {"step": 0.0}, {"step": -1e-4},
                {"step": np.nan}, {"step": 1e-300}, {"step": None}, {"tolerance": 0.0}, {"tolerance": "x"},
            )
        ),
        lambda: Response.from_function(3.0, -5e-3, 5e-3, step=1e-4),
        lambda: Response.from_function(lambda y: y, -5e-3, 5e-3, step=1e-4),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")
def test_values_of_the_wrong_kind_are_refused(make):
    with pytest.raises(SubskinError) as caught:
        make()
    assert len(str(caught.value)) < 700


FIELD, PLACED = tabulate_radial(AREA, 5e-3), ss.tabulate(FINGER)
TARE, PIPELINE = ss.Tare(FINGER), ss.Pipeline({"tare": ss.Tare(FINGER)})


@pytest.mark.parametrize(
    "make",
    [
        lambda: FIELD(np.ones((2, 3, 4))),  # a compiled loop would write beyond what it has
        lambda: FIELD(0.0),
        lambda: ss.HalfSpace(RUBBER).map(ss.RoundHertz(1.0, half_width=1e-3), 1e-300, [0.0, 1e-3], [0.0, 1e-3]),
        lambda: ss.HalfSpace(RUBBER).map(ss.RoundHertz(1.0, half_width=1e-3), 1e300, [0.0, 1e-3], [0.0, 1e-3]),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=1e308),
        lambda: ss.press(SKIN, ss.pressing.Cylinder(8e-3), force=1e-308),
        lambda: ss.press(ss.HalfSpace(RUBBER), ss.pressing.Sphere(8e-3), force=1e308),
        lambda: ss.press(ss.HalfSpace(RUBBER), ss.pressing.Sphere(8e-3), depth=1e-308),
        lambda: FIELD.slopes([np.nan, 0.0]),
        lambda: FIELD.select("x"),
        lambda: tabulate_radial(AREA, 1e300),
        lambda: tabulate_round(None, ss.RoundHertz, 5e-3, 2e-3),
        lambda: tabulate_round(AREA, ss.Hertz, 5e-3, 2e-3),
        lambda: tabulate_round(AREA, ss.RoundHertz, "x", 2e-3),
        lambda: PLACED("x"),
        lambda: PLACED(0.0, derivative=3),
        lambda: PLACED.select(np.ones((2, 2), dtype=int)),
        lambda: PLACED.averaged("x"),
        lambda: Response("x", 1.0, PLACED.coefficients),
        lambda: Response.of(None, ss.Hertz, (-5e-3, 5e-3), 1e-3),
        lambda: Response.of(FINGER, "hertz", (-5e-3, 5e-3), 1e-3),
        lambda: Response.of(FINGER, ss.Hertz, None, 1e-3),
        lambda: ss.estimate.Locator(None, ARRAY),
        lambda: ss.estimate.Locator(PLACED, None),
        lambda: FINGER.locator().covers("x"),
        lambda: ARRAY.digitise("x"),
        lambda: ARRAY.digitise(np.ones(4)),
        lambda: TARE.step("x", np.zeros(5), 0.0),
        lambda: TARE.step(None, np.zeros(5), 0.0, doubt=np.ones(3)),
        lambda: TARE.zeroed({}),
        lambda: TARE.resumed(1.0),
        lambda: PIPELINE.step([1.0], np.zeros(5), 0.0),
        lambda: PIPELINE.resumed("x"),
        lambda: ss.Relaxation(0.2, 1.0).undo.step("x", np.zeros(5), 0.0),
        lambda: ss.Tare(FINGER, differences=np.ones(2)),
        lambda: FINGER.locate(np.zeros(5)).load.within("x"),
        lambda: ss.estimate.blind_depth(None, 1e-3),
        lambda: SKIN.surface_influence(1e-4, -3),
        lambda: LAYER.surface_influence(1e-4, "x"),
        lambda: LAYER.area_influence(1e-4, 8),
        lambda: ss.HalfSpace(RUBBER).area_influence("x", (4, 4)),
        lambda: ss.pressure_map(AREA, np.zeros(9), search=0.0),
        lambda: FINGER.locator(search=0.0),
    ],
)
def test_what_tables_stages_and_skins_are_asked(make):
    with pytest.raises(SubskinError):
        make()


def test_a_load_beyond_all_tables_ends_nothing():
    """The share of its last cell is beyond all whole numbers: no cell of another place may be read."""
    assert FIELD([1e60, 0.0]).shape == FIELD([np.nan, 0.0]).shape == (9, 3)
    steps = FIELD([[30.0 - 5e-6, 0.0], [30.0 + 5e-6, 0.0]])
    slopes = (steps[1] - steps[0]) / 1e-5
    assert (slopes[:, 0] != 0).all()
    np.testing.assert_allclose(FIELD.slopes([30.0, 0.0])[..., 0], slopes, rtol=1e-3, equal_nan=False)


@pytest.mark.parametrize(
    "make",
    [
        lambda: ss.design.outside.outside_of(None),
        lambda: ss.FromProjections(lambda phi: phi, 1.0),
        lambda: ss.synthetic.simulate_readings(FINGER, ss.LineLoad, "x"),
        lambda: ss.synthetic.simulate_readings(FINGER, ss.LineLoad, {"force": [1.0]}, progress="x"),
        lambda: ss.pressing.HeightMap.from_function(lambda y, z: "x", np.arange(3.0), np.arange(3.0)),
        lambda: ss.pressing.HeightMap.from_function(lambda y, z: y + z, 0.0, np.arange(3.0)),
        lambda: ss.design.Ridges(1e-3, shape=lambda u: "x").share([0.0, 1e-4]),
        lambda: ss.press(ss.HalfSpace(RUBBER), type("Mine", (ss.pressing.Sphere,), {"centre": "x"})(8e-3), force=1.0),
        lambda: Twice()(np.zeros((3, 5)), np.arange(3.0)),
    ],
)
def test_what_functions_of_ones_own_are(make):
    with pytest.raises(SubskinError):
        make()


class Twice(ss.stream.Stage):
    """A stage that forgets to hand on its state."""

    def step(self, state, readings, time):
        return 2 * readings


def test_a_stage_that_gives_no_state_is_told():
    with pytest.raises(InvalidValueError, match=r"Twice\.step gave .*a state and what comes out are needed"):
        ss.Pipeline({"twice": Twice()}).step(None, np.zeros((3, 5)), np.arange(3.0))


def test_forty_layers_work():
    many = ss.Layered([ss.Layer(RUBBER, 0.25e-3)] * 40)
    one = ss.Layered(ss.Layer(RUBBER, 10e-3))
    touch = ss.LineLoad(40.0, 0.2)
    np.testing.assert_allclose(many.strain(touch, 2e-3, 1e-3).xx, one.strain(touch, 2e-3, 1e-3).xx, rtol=1e-6)


def test_what_a_terminal_would_obey_is_written_out():
    assert printable("a\x1b]0;pwn\x07b\u202ec\ud800") == r"a\x1b]0;pwn\x07b\u202ec\ud800"
    assert printable("µ °C – ✓\n") == "µ °C – ✓\n"
    said = str(SubskinError("x" * 10**6, "y" * 10**6))
    assert len(said) < 4000
    assert "\x1b" not in str(SubskinError("\x1b[31m", "\x1b[0m", "\x1b"))


def functions_of_a_finger():
    """Public functions whose first argument is a finger."""
    for room in (ss, ss.estimate, ss.calibration, ss.decide, ss.design, ss.design.placement, ss.synthetic):
        for name in room.__all__:
            door = getattr(room, name)
            if inspect.isfunction(inspect.unwrap(door)):
                first, *others = inspect.signature(door).parameters.values()
                if first.annotation == "Finger":
                    yield pytest.param(door, [p for p in others if p.default is p.empty], id=name)


@pytest.mark.parametrize(("function", "others"), list(functions_of_a_finger()))
def test_what_is_no_finger_is_refused(function, others):
    given = {p.name: 1 for p in others if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}
    for wrong in (None, SKIN, "finger.toml", ss.Finger):
        with pytest.raises(SubskinError, match=r"finger = .*: a Finger is needed\. Fix: Finger\(skin, array\)"):
            function(wrong, **given)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: SKIN.stress(None, 1e-3, 0.0), "contact = None: a Contact or LocalContact is needed"),
        (lambda: SKIN.displacement(ss.Hertz, 1e-3, 0.0), "contact = <class"),
        (lambda: SKIN.surface_gradient(1.0, 0.0), "contact = 1.0: a Contact is needed"),
        (lambda: FINGER.read("Hertz"), "contact = 'Hertz': a Contact or LocalContact is needed"),
        (lambda: FINGER.read(ss.LineLoad(40.0), 0), "rng = 0: a Generator is needed"),
        (lambda: ss.press(SKIN, None, force=1.0), "indenter = None: an Indenter is needed"),
        (lambda: ss.Hertz.from_radius(40.0, radius=1e-3, material=4e5), "material = 400000.0: a Material is needed"),
        (lambda: SKIN.with_(materials=4e5), "materials = 400000.0: a list is needed, each of it a Material"),
        (lambda: ss.SensorArray.line(3, pitch=1e-3, depth=1e-3, transducer="strain"), "each of it a Transducer"),
        (lambda: ss.SensorArray.line(3, pitch=1e-3, depth=1e-3, channels=3.0), "each of it a Transducer"),
        (lambda: ss.Finger(SKIN, ss.SensorArray.line(3, pitch=1e4, depth=1e-3)), "sensors lie at most 100000 depths"),
        (lambda: ARRAY.select(0.5), "sensors = 0.5: indices from 0 to 4"),
        (lambda: ARRAY.select([5]), "indices from 0 to 4"),
        (lambda: ARRAY.select(2), r"sensors of shape \(\): a row of indices"),
        (lambda: ss.calibrate(FINGER, np.ones((9, 5)), np.zeros(9), fit=1.0), "fit = 1.0: a list is needed"),
        (lambda: ss.calibrate(FINGER, np.ones((9, 5)), np.zeros(9), force=np.ones(8)), "one for each touch"),
        (lambda: ss.calibrate(FINGER, np.full((9, 5), 1e300), np.zeros(9)), r"readings\[0, 0\] = 1e\+300: no sensor"),
        (lambda: FINGER.blind_spots(snr="high"), "snr = 'high'"),
        (lambda: FINGER.blind_spots(rng=None), "rng = None: a seed >= 0 or a Generator is needed"),
    ],
)
def test_another_noun_or_shape_is_said(make, words):
    with pytest.raises(SubskinError, match=words):
        make()


OPTIONS = {
    "plane": lambda value: ss.HalfPlane(RUBBER, plane=value),
    "bond": lambda value: ss.Layer(RUBBER, 6e-3, bond=value),
    "layout": lambda value: even_grid((2, 2), pitch=2e-3, layout=value),
    "axis": lambda value: ss.transducer.Displacement(axis=value),
    "load": lambda value: FINGER.locate(np.zeros(5), load=value),
    "load of a field": lambda value: FINGER.receptive_field(0.0, load=value),
    "family": lambda value: FINGER.fit(np.zeros(5), value),
    "family on an area": lambda value: ss.locator(AREA, value),
    "kind": lambda value: ss.decide.Kind("mine", value),
    "shear": lambda value: ss.pressure_map(FINGER, np.zeros(5), shear=value),
    "shear on an area": lambda value: ss.pressure_map(AREA, np.zeros(9), shear=value),
    "rule": lambda value: ss.pressure_map(FINGER, np.zeros(5), rule=value),
    "contact": ss.decide.friction_arm,
    "angle": lambda value: ss.design.two_point_limen(FINGER, TOUCHES, angle=value),
    "lattice": lambda value: ss.design.aliasing_error(FINGER, lattice=value),
    "calibrated": lambda value: ss.design.search.Accuracy(position=1e-4, calibrated=value),
    "family of blind spots": lambda value: FINGER.blind_spots(TOUCHES, family=value),
    "pattern": lambda value: ss.design.placement.Arrangement(value, (3, 3)),
    "ridges": lambda value: ss.design.ridges.Ridges(3e-3, shape=value),
    "sensor": ss.transducer.class_of,
    "component": lambda value: ss.plot.finger_section(FINGER, ss.LineLoad(40.0), component=value),
}


@pytest.mark.parametrize("value", [np.array(["free", "none"]), np.ones(2), ["line"], {"line": 1}, 3.0, b"line", "lime"])
@pytest.mark.parametrize("name", OPTIONS)
def test_what_is_no_text_of_an_option_is_said(name, value):
    with pytest.raises(InvalidValueError, match=r"(has to be|is needed|no such)"):
        OPTIONS[name](value)


GAVE = {
    "nothing": lambda _: None,
    "a text": lambda _: "x",
    "another shape": lambda _: np.ones((7, 5)),
    "too few": lambda _: np.ones(3),
    "an object": lambda _: object(),
}
TIP = {"force": 1.0, "half_width": 1e-3, "position": (0.0, 0.0)}


def own(base, hook, gave):
    """A class of one's own, of which one method gives something else."""
    return type("Mine", (base,), {hook: lambda self, *a, **k: gave(getattr(base, hook)(self, *a, **k))})


def some(value):
    """A value where None would be an answer."""
    return "x" if value is None else value


HOOKS = {
    "measure": lambda gave: ss.Finger(
        SKIN, ss.SensorArray.line(5, 1.5e-3, depth=2e-3, transducer=own(ss.NormalStrain, "measure", gave)())
    ).read(ss.LineLoad([40.0, 20.0])),
    "unit_pressure": lambda gave: own(ss.Hertz, "unit_pressure", gave)(40.0, half_width=1e-3).pressure([0.0, 1e-4]),
    "unit_transform": lambda gave: SKIN.stress(
        own(ss.Hertz, "unit_transform", lambda value: some(gave(value)))(40.0, half_width=1e-3), 1e-3, [0.0, 1e-3]
    ),
    "unit_shear_field": lambda gave: SKIN.stress(
        own(ss.Hertz, "unit_shear_field", gave)(40.0, half_width=1e-3), 1e-3, [0.0, 1e-3]
    ),
    "unit_spectrum": lambda gave: LAYER.stress(
        own(ss.Hertz, "unit_spectrum", gave)(40.0, half_width=1e-3), 1e-3, [0.0, 1e-3]
    ),
    "disc_pressure": lambda gave: own(ss.RoundHertz, "disc_pressure", gave)(**TIP).pressure([0.0, 1e-4], 0.0),
    "unit_drag": lambda gave: own(ss.RoundHertz, "unit_drag", gave)(**TIP).shear([0.0, 1e-4], 0.0),
    "disc_spectrum": lambda gave: own(ss.RoundHertz, "disc_spectrum", gave)(**TIP).spectrum([1.0, 2.0], [0.0, 0.0]),
    "disc_family": lambda gave: ss.HalfSpace(RUBBER).stress(
        own(ss.RoundHertz, "disc_family", lambda value: some(gave(value)))(**TIP), 1e-3, 0.0, 0.0
    ),
    "height": lambda gave: ss.press(SKIN, own(ss.pressing.Cylinder, "height", gave)(8e-3), force=40.0),
    "height of a body": lambda gave: ss.press(
        ss.HalfSpace(RUBBER), own(ss.pressing.Sphere, "height", gave)(8e-3), force=1.0
    ),
    "at": lambda gave: ss.Finger(
        own(ss.HalfPlane, "at", lambda value: lambda contact: gave(value(contact)))(RUBBER), ARRAY
    ).read(ss.LineLoad(40.0)),
}  # fmt: skip


@pytest.mark.parametrize("gave", GAVE.values(), ids=GAVE.keys())
@pytest.mark.parametrize("hook", HOOKS)
def test_what_methods_of_ones_own_give_is_checked(hook, gave):
    """The method is named, and what it gave: NumPy's words about shapes would point into this package."""
    with pytest.raises(InvalidValueError, match=rf"(Mine|lambda).*{hook.partition(' ')[0]}.*(gave|is needed)"):
        HOOKS[hook](gave)


def test_a_number_for_all_is_as_good_as_an_array():
    even = own(ss.NormalStrain, "measure", lambda _: 0.25)
    array = ss.SensorArray.line(3, 1.5e-3, depth=2e-3, transducer=even())
    assert ss.Finger(SKIN, array).read(ss.LineLoad([40.0, 20.0])).tolist() == [[0.25] * 3] * 2


RECORDED, SECONDS = np.zeros((50, 5)), np.arange(50.0)
KIND = ss.decide.Kind("mine", "hertz", half_width=(0.0, 1e-3))


@pytest.mark.parametrize("number", [1e308, 1e80])
def test_what_is_beyond_all_powers_is_refused(number):
    with pytest.raises(InvalidValueError, match=r"young = .*: has to be at most 1e\+75 in magnitude"):
        ss.Material(young=number)
    with pytest.raises(InvalidValueError, match=r"force\[1\] = .*: has to be at most 1e\+75 in magnitude"):
        ss.LineLoad(force=[1.0, number])
    with pytest.raises(InvalidValueError, match=r"friction = .*: has to be at most"):
        FINGER.locate(np.zeros(5), friction=number)  # which may be infinite


def test_what_is_too_small_to_be_squared_is_refused_but_for_a_chance():
    with pytest.raises(InvalidValueError, match=r"young = 1e-308: has to be at least 1e-75 \[Pa\]"):
        ss.Material(young=1e-308)
    assert FINGER.locate(np.zeros(5), false_alarm=1e-300).status == ss.Status.NO_CONTACT
    assert FINGER.locate(FINGER.read(ss.LineLoad(40.0)), friction=1e-308).load.tangential == 0.0


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "make",
    [
        lambda: ss.stream.segment(RECORDED, SECONDS, hold=1e308),
        lambda: ss.stream.segment([[1.0], [2.0, 3.0]], SECONDS),
        lambda: ss.stream.RecordingFormat(("a",), early=None),
        lambda: ss.stream.Column("a", "x"),
        lambda: ss.stream.Tared.join([]),
        lambda: ss.stream.Undone.join(None),
        lambda: ss.Relaxation(0.2, 1.0).of_sensors("x"),
        lambda: ss.Relaxation(0.2, 1.0, doubt=np.ones((1, 1))),
        lambda: KIND.unknowns("x"),
        lambda: ss.decide.slip(FINGER.locate(np.zeros((2, 5))), 0.8).probability_at(None, 1.0, 0.0),
        lambda: ss.side_angle(FINGER, np.zeros(5), position=2**70, half_width=1e-3),
        lambda: ss.synthetic.simulate_readings(FINGER, None, {"force": [1.0]}),
        lambda: ss.synthetic.simulate_recording(FINGER, [0.0], force=40.0, turn=None),
        lambda: ss.synthetic.RandomTouches(FINGER, (ss.synthetic.ContactShare("line"),), 9, (1, 2)).shard_of(0, "x"),
        lambda: ss.calibration.choose({"a": (FINGER, ("gain",))}, np.ones((40, 5)), np.zeros(40), advance="x"),
        lambda: ss.io.format_quantity("x", "m"),
        lambda: ss.io.save_finger(None, "finger.toml"),
        lambda: ss.io.with_relaxation(None, ss.Relaxation(0.2, 1.0)),
        lambda: ss.io.FolderStore("a\0b"),
        lambda: TOUCHES.sample("x", np.random.default_rng(0), FINGER),
        lambda: TOUCHES.sample(3, None, FINGER),
        lambda: ss.design.two_point_study(FINGER, TOUCHES, noise=()),
        lambda: ss.design.two_point_study(FINGER, TOUCHES, progress="x"),
        lambda: ss.design.skin_compliance(FINGER, None, 40.0),
        lambda: ss.design.skin_compliance(FINGER, ss.pressing.ParticleOnFlat(4e-4, 3e-5, 1e-2), []),
        lambda: ss.design.placement.layouts(None, (4, 9)),
        lambda: ss.design.placement.layouts(("grid",), (4, 1e308)),
        lambda: ss.design.placement.Arrangement("grid", (3, 3)).points(None),
        lambda: ss.design.Ridges(1e-3).breaks(None, np.array(1e-3)),
        lambda: ss.design.search.Accuracy(position=1e-3, unsure=None),
        lambda: ss.design.tolerance_budget(FINGER, TOUCHES, {"depth": 5e-5}, self_calibration=None),
    ],
)
def test_options_of_rooms_are_checked_at_the_door(make):
    with pytest.raises(SubskinError):
        make()


def test_a_recording_shorter_than_a_hold_has_no_press():
    press = np.where((SECONDS > 10) & (SECONDS < 40), 1e-3, 0.0)
    for hold in (1e3, 1e60):
        with pytest.raises(InvalidValueError, match="no plateau of the indenter's depth"):
            ss.stream.segment(RECORDED, SECONDS, press=press, hold=hold)
