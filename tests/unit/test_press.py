"""`press`: what it refuses and how it says so, statuses, strains, and what it gives back."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import subskin as ss

RUBBER = ss.Material(0.4e6, 0.5)
HALF = ss.HalfPlane(RUBBER)
LAYER = ss.Layered(ss.Layer(RUBBER, 1e-3))
ROUND = ss.Round(RUBBER, 8e-3, 4e-3)
BODY = ss.pressing.Cylinder(4e-3)
PUNCH = ss.pressing.RoundedFlat(1e-3)
RIDGES = ss.pressing.SineRidges(1e-3, 1e-5)


class TestRefused:
    @pytest.mark.parametrize(
        ("skin", "body", "load", "words"),
        [
            (HALF, BODY, {}, r"force = None, depth = None: one of the two has to be given"),
            (LAYER, BODY, {"force": 1, "depth": 1e-5}, "force = 1, depth = 1e-05: one of the two"),
            (HALF, BODY, {"force": 0}, "force = 0 N/m: the indenter never touches the skin.*force > 0"),
            (HALF, BODY, {"force": -2.5}, "force = -2.5 N/m: the indenter never touches"),
            (LAYER, BODY, {"depth": -1e-4}, "depth = -0.0001 m: the indenter never touches.*depth > 0"),
            (HALF, BODY, {"force": np.nan}, "force = nan: has to be finite"),
            (HALF, BODY, {"force": [1, 2]}, r"force of shape \(2,\): a single number"),
            (HALF, BODY, {"force": "5 N"}, "force = '5 N'"),
            (HALF, BODY, {"depth": 1e-5}, "depth = 1e-05 m on a HalfPlane.*no ground.*Fix: datum="),
            (HALF, BODY, {"force": 1, "friction": 1, "slide": 1e-5}, "slide = 1e-05 m on a HalfPlane.*Fix: datum="),
            (HALF, PUNCH, {"force": 1, "moment": 1e-4, "tilt": 0.1}, "moment = 0.0001, tilt = 0.1: one of the two"),
            (
                LAYER,
                BODY,
                {"force": 1, "friction": 1, "tangential": 0.1, "slide": 1e-5},
                "tangential = 0.1, slide = 1e-05: one of the two",
            ),
            (HALF, BODY, {"force": 1, "tangential": 0.1}, "tangential = 0.1: nothing is dragged.*friction=, e.g. 0.5"),
            (LAYER, BODY, {"force": 1, "slide": 1e-5}, "slide = 1e-05: nothing is dragged without friction"),
            (HALF, BODY, {"force": 1, "friction": -0.1}, "friction = -0.1: has to be >= 0"),
            (HALF, BODY, {"force": 1, "friction": np.nan}, "friction = nan"),
            (HALF, BODY, {"force": 1, "position": np.inf}, "position = inf"),
            (HALF, BODY, {"force": 1, "tilt": np.nan}, "tilt = nan"),
            (HALF, BODY, {"force": 1, "nodes": 8}, "nodes = 8: has to be >= 16"),
            (HALF, BODY, {"force": 1, "window": 0}, r"window = 0: has to be > 0 \[m\]"),
            (
                HALF,
                RIDGES,
                {"depth": 2e-5, "period": 1e-3},
                "depth = 2e-05 m: pressed in to the profile's mean.*Fix: less than 1e-05 m, or a force",
            ),
            (HALF, RIDGES, {"force": 1, "period": -1}, "period = -1: has to be > 0"),
            (HALF, BODY, {"force": 1, "datum": 0}, "datum = 0: has to be > 0"),
            (HALF, BODY, {"force": 1, "tolerance": 0}, "tolerance = 0: has to be >= 1e-12"),
            (HALF, BODY, {"force": 1, "max_strain": 0}, "max_strain = 0: has to be > 0"),
            (
                HALF,
                ss.pressing.Profile([3e-3, 5e-3], [0, 0]),
                {"force": 1, "window": 1e-3},
                "no part of the indenter between y = -0.0005 and 0.0005 m.*never touches.*wider window",
            ),
            (
                ROUND,
                ss.pressing.Edge(),
                {"depth": 1e-6, "position": -1e-3, "window": 2e-3},
                r"depth = 1e-06 m: the indenter never touches the skin\. Fix: its lowest point is 6.*e-05 m above it",
            ),
        ],
    )
    def test_values(self, skin, body, load, words):
        with pytest.raises(ss.errors.InvalidValueError, match=words):
            ss.press(skin, body, **load)

    @pytest.mark.parametrize(
        ("skin", "body", "load", "words"),
        [
            (HALF, BODY, {"force": 5, "window": 1e-4}, "a window of 0.0001 m: the contact reaches its end.*wider"),
            (HALF, BODY, {"force": 5, "datum": 1e-4}, "datum = 0.0001 m: the surface rests beyond the window"),
            (ROUND, BODY, {"force": 5, "window": 0.1}, "0.1 m: the finger is only 0.0502655 m about.*narrower"),
            (ROUND, BODY, {"force": 1, "period": 1e-3}, "period = 0.001 m on a Round: only a flat skin"),
            (HALF, RIDGES, {"force": 1, "period": 1e-3, "moment": 1e-4}, "period = 0.001 m with a moment"),
            (HALF, RIDGES, {"force": 1, "period": 1e-3, "tilt": 1e-4}, "period = 0.001 m with a moment or a tilt"),
            (
                HALF,
                PUNCH,
                {"force": 10, "moment": 0.02},
                "moment = 0.02 N at force = 10 N/m.*through the body, from -0.001 to 0.001 m",
            ),
            (HALF, ss.pressing.Flat(), {"force": 1}, "on a flat skin: they would touch all along.*a body that ends"),
            (LAYER, ss.pressing.Flat(), {"depth": 1e-5}, "they would touch all along"),
            (HALF, ss.pressing.SineRidges(1e-3, 0.0), {"force": 1}, "they would touch all along.*period="),
            (HALF, PUNCH, {"force": 10, "moment": 10 * PUNCH.half_width}, "pass through the body"),
            (ROUND, BODY, {"force": 1, "position": 0.7 * np.pi * ROUND.radius}, "comes from above"),
            (ROUND, BODY, {"force": 1, "position": 10.0}, "comes from above"),
        ],
    )
    def test_geometry(self, skin, body, load, words):
        with pytest.raises(ss.errors.GeometryError, match=words):
            ss.press(skin, body, **load)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"indenter": ss.pressing.Cylinder(5e-3)}, "after= of another skin, indenter or position.*same bodies"),
            ({"skin": LAYER}, "after= of another skin"),
            ({"position": 1e-3}, "after= of another .* position"),
            ({"force": 60.0}, "a window of .* reaches its end.*wider window to the first press"),
        ],
    )
    def test_another_past(self, change, words):
        start = ss.press(HALF, BODY, force=5, friction=0.5)
        call = {"skin": HALF, "indenter": BODY, "force": 5.0, "friction": 0.5, "after": start} | change
        with pytest.raises(ss.errors.GeometryError, match=words):
            ss.press(**call)


class TestCorners:
    """What is easily asked for by mistake, or by accident of the numbers."""

    @pytest.mark.parametrize("pair", [(RUBBER, BODY), (HALF, lambda y: y**2), (BODY, HALF)])
    def test_what_is_no_skin_or_no_indenter(self, pair):
        with pytest.raises(ss.errors.InvalidValueError):
            ss.press(*pair, force=1)

    def test_a_body_beside_its_own_origin(self):
        body = ss.pressing.Profile.from_function(lambda y: (y - 4e-3) ** 2 / 8e-3, 3e-3, 5e-3)
        found = ss.press(HALF, body, force=5)
        assert found.edges.mean() == pytest.approx(4e-3, abs=1e-6)

    def test_tractions_are_read_only(self):
        found = ss.press(HALF, BODY, force=5)
        for name in ("pressure", "shear"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(found, name)[0] = 1.0

    def test_a_datum_is_part_of_the_past(self):
        start = ss.press(HALF, BODY, force=5, friction=0.5, datum=0.1)
        after = ss.press(HALF, BODY, force=5, friction=0.5, tangential=1, after=start)
        assert after.depth == pytest.approx(start.depth, rel=1e-6)

    @pytest.mark.parametrize("change", [{"nodes": 64}, {"window": 0.1}, {"datum": 1.0}, {"period": 1e-2}])
    def test_a_grid_that_is_not_that_of_the_past(self, change):
        start = ss.press(HALF, BODY, force=5, friction=0.5)
        with pytest.raises(ss.SubskinError):
            ss.press(HALF, BODY, force=5, friction=0.5, after=start, **change)

    def test_a_depth_that_never_touches_a_round_finger(self):
        with pytest.raises(ss.errors.InvalidValueError, match="never touches"):
            ss.press(ROUND, ss.pressing.Edge(), depth=1e-5, position=-3e-3)

    @pytest.mark.parametrize("friction", [0.0, 0.1])
    def test_nothing_slides_undragged(self, friction):
        skin = ss.HalfPlane(ss.Material(0.4e6, 0.0))
        assert ss.press(skin, PUNCH, force=10, friction=friction, nodes=512).status is ss.pressing.PressStatus.OK

    def test_glued_at_nu_0_pulls_at_the_ends(self):
        """Nearer the ends than 2e-4 a Johnson's (2.69) pulls: on a fine grid nothing else settles, and it says so."""
        skin = ss.HalfPlane(ss.Material(0.4e6, 0.0))
        coarse, fine = (ss.press(skin, PUNCH, force=10, friction=np.inf, nodes=n) for n in (256, 2048))
        assert coarse.status is ss.pressing.PressStatus.OK
        assert fine.status is ss.pressing.PressStatus.NOT_SETTLED

    def test_an_equal_profile_is_the_same_body(self):
        def scanned():
            return ss.pressing.Profile(np.linspace(-3e-3, 3e-3, 61), np.linspace(-3e-3, 3e-3, 61) ** 2 / 16e-3)

        start = ss.press(HALF, scanned(), force=5, friction=0.5)
        assert ss.press(HALF, scanned(), force=5, friction=0.5, tangential=1, after=start).tangential > 0.99

    def test_a_body_that_repeats_does_not_turn_later(self):
        start = ss.press(HALF, RIDGES, force=1, friction=0.5, period=RIDGES.pitch)
        with pytest.raises(ss.errors.GeometryError, match="does not turn"):
            ss.press(HALF, RIDGES, force=1, friction=0.5, moment=1e-5, after=start)

    def test_steep_slopes_are_said(self):
        with pytest.warns(ss.errors.ValidityWarning, match="slopes up to 0.6"):
            ss.press(HALF, ss.pressing.RoundedWedge(0.6), force=1, max_strain=np.inf)

    @pytest.mark.parametrize(
        ("change", "words"), [({"after": 3}, "after = 3"), ({"nodes": 64.7}, "nodes = 64.7: a whole number")]
    )
    def test_things_of_another_kind(self, change, words):
        with pytest.raises(ss.errors.InvalidValueError, match=words):
            ss.press(HALF, BODY, force=1, **change)


class TestBeyondTheWindow:
    """What a narrow grid does not see touches all the same."""

    PAD = ss.Layered(ss.Layer(ss.Material(0.5e6), 4e-3))

    def test_the_flat_around_a_particle_is_found(self):
        found = ss.press(self.PAD, ss.pressing.ParticleOnFlat(0.4e-3, 30e-6, 20e-3), force=20)
        wide = ss.press(self.PAD, ss.pressing.ParticleOnFlat(0.4e-3, 30e-6, 20e-3), force=20, window=40e-3, nodes=8192)
        assert len(found.edges) == len(wide.edges) == 3
        assert found.depth == pytest.approx(wide.depth, rel=2e-3)

    def test_a_flat_without_end_is_refused(self):
        with pytest.raises(ss.errors.GeometryError, match="the bodies touch beyond it"):
            ss.press(self.PAD, ss.pressing.ParticleOnFlat(0.4e-3, 30e-6), force=20)
        with pytest.raises(ss.errors.GeometryError, match="the bodies touch beyond it"):
            ss.press(self.PAD, ss.pressing.SineRidges(1e-3, 20e-6), force=10)

    @pytest.mark.parametrize("skin", [PAD, ss.Round(ss.Material(0.4e6), 9e-3, 5e-3)], ids=["pad", "round"])
    def test_ridges_beside_the_first(self, skin):
        body = ss.pressing.SineRidges(1e-3, 20e-6, radius=50e-3)
        found, wide = (ss.press(skin, body, force=20, **more) for more in ({}, {"window": 8e-3, "nodes": 4096}))
        assert len(found.edges) == len(wide.edges) == 3
        assert found.depth == pytest.approx(wide.depth, rel=2e-3)

    def test_a_tooth_far_away(self):
        y = np.linspace(-2e-3, 12e-3, 1401)
        teeth = np.minimum(y**2 / 4e-3, 20e-6 + (y - 10e-3) ** 2 / 4e-3)
        found = ss.press(self.PAD, ss.pressing.Profile(y, np.minimum(teeth, 0.2e-3)), force=20)
        assert found.edges[-1, 1] > 9.9e-3

    def test_a_window_that_hides_it_is_refused(self):
        with pytest.raises(ss.errors.GeometryError, match=r"beyond it, at y = .*overlap"):
            ss.press(self.PAD, ss.pressing.ParticleOnFlat(0.4e-3, 30e-6, 20e-3), force=20, window=0.8e-3)

    def test_two_teeth_are_not_a_slope(self):
        y = np.linspace(-7e-3, 7e-3, 2801)
        teeth = np.minimum((np.abs(y) - 6e-3) ** 2 / 4e-3, 5e-3)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            assert len(ss.press(self.PAD, ss.pressing.Profile(y, teeth), force=5).edges) == 2

    def test_a_scan_that_is_cut_short_is_said(self):
        y = np.linspace(-0.2e-3, 0.2e-3, 201)
        with pytest.warns(ss.errors.ValidityWarning, match="end of the profile"):
            ss.press(self.PAD, ss.pressing.Profile(y, y**2 / 10e-3), force=20, max_strain=np.inf)

    @pytest.mark.parametrize(
        ("body", "period"), [(RIDGES, 1.3e-3), (RIDGES, 0.5e-3), (ss.pressing.RoundedFlat(1e-3), 1.5e-3)]
    )
    def test_a_period_that_the_body_has_not(self, body, period):
        with pytest.raises(ss.errors.GeometryError, match="period = "):
            ss.press(self.PAD, body, force=1, period=period)

    def test_nothing_is_dragged_at_no_friction(self):
        with pytest.raises(ss.errors.InvalidValueError, match="friction = 0"):
            ss.press(self.PAD, BODY, force=10, friction=0, tangential=1)
        start = ss.press(self.PAD, BODY, force=10, friction=0.5, tangential=1)
        with pytest.raises(ss.errors.InvalidValueError, match=r"friction=0\.5"):
            ss.press(self.PAD, BODY, force=10, after=start)


class TestStatus:
    def test_ok(self):
        found = ss.press(HALF, BODY, force=5)
        assert found.status is ss.pressing.PressStatus.OK
        touching = int((found.pressure > 0).sum())
        assert found.reason.startswith("every rule of contact holds to")
        assert found.reason.endswith(f"on {touching} nodes that touch")
        assert found.certificate.worst < 4e-9

    def test_coarse(self):
        found = ss.press(HALF, BODY, force=5, window=1e-2, nodes=128)
        assert found.status is ss.pressing.PressStatus.COARSE
        assert f"only {(found.pressure > 0).sum()} nodes touch; more nodes or a narrower window" in found.reason
        assert ss.press(HALF, BODY, force=5, window=1e-2, nodes=1024).status is ss.pressing.PressStatus.OK

    def test_slides(self):
        found = ss.press(HALF, BODY, force=5, friction=0.3, tangential=2)
        assert found.status is ss.pressing.PressStatus.SLIDES
        assert "friction 0.3 holds no more" in found.reason
        assert found.tangential == pytest.approx(1.5, rel=1e-9)

    def test_not_settled(self, monkeypatch):
        """Stopped early, the answer says so, and which rule is broken most."""
        monkeypatch.setattr("subskin.pressing.case._ROUNDS", 1)
        found = ss.press(ss.HalfPlane(ss.Material(0.4e6, 0.2)), BODY, force=5, friction=0.5, nodes=256)
        assert found.status is ss.pressing.PressStatus.NOT_SETTLED
        rules = {k: v for k, v in vars(found.certificate).items() if k != "scale"}
        name = max(rules, key=rules.get)
        assert rules[name] == found.certificate.worst > 4e-9
        assert found.reason == f"{name} is {rules[name]:.2g}, and 4e-09 was to be reached"

    def test_the_tolerance_is_that_of_the_call(self):
        rough, fine = (ss.press(HALF, BODY, force=5, tolerance=t) for t in (1e-3, 1e-11))
        assert rough.status is fine.status is ss.pressing.PressStatus.OK
        assert fine.certificate.worst < 4e-11 < rough.certificate.worst < 4e-3
        assert rough.iterations < fine.iterations


class TestStrains:
    def test_small_ones_are_not_spoken_of(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            ss.press(HALF, BODY, force=100)

    def test_warned_of(self):
        with pytest.warns(ss.errors.ValidityWarning, match=r"strains up to 2\d % .* linear theory") as caught:
            ss.press(HALF, BODY, force=1000)
        assert caught[0].filename == __file__

    def test_refused(self):
        """The message says how large the strain would be, and the limit."""
        sharp = ss.pressing.Cylinder(1e-3)
        with pytest.raises(
            ss.errors.InvalidValueError, match=r"a force of 1000 N/m.*strained by .*up to 50 %"
        ) as caught:
            ss.press(HALF, sharp, force=1000)
        with pytest.raises(ss.errors.InvalidValueError, match="up to 5 %"):
            ss.press(HALF, BODY, force=100, max_strain=0.05)
        told = float(str(caught.value).split("strained by ")[1].split(" %")[0])
        with pytest.warns(ss.errors.ValidityWarning, match=f"up to {told:.0f} %"):
            asked = ss.press(HALF, sharp, force=1000, max_strain=np.inf)
        unasked = ss.press(HALF, sharp, force=1000, max_strain=None)  # a warning is an error here
        assert unasked.pressure.tobytes() == asked.pressure.tobytes()

    def test_on_an_area(self):
        skin, ball = ss.HalfSpace(ss.Material(young=0.4e6)), ss.pressing.Sphere(radius=1e-3)
        with pytest.raises(ss.errors.InvalidValueError, match="strained by"):
            ss.press(skin, ball, force=5.0, nodes=64)
        assert ss.press(skin, ball, force=5.0, nodes=64, max_strain=None).status == ss.pressing.PressStatus.OK

    @pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")
    def test_bodies_together_are_judged_one_by_one(self):
        skin, ball = ss.HalfSpace(ss.Material(young=0.4e6)), ss.pressing.Sphere(4e-3)
        pair = ss.pressing.Together([ball, ball], [(-8e-3, 0.0), (8e-3, 0.0)])
        one = ss.press(skin, ball, force=0.05)
        strain = one.depth / (np.pi / 2 * float(one.half_width[0]))
        two = ss.press(skin, pair, force=0.1, max_strain=1.1 * strain)
        assert two.status == ss.pressing.PressStatus.OK
        assert two.depth == pytest.approx(one.depth + 0.05 * 0.75 / (np.pi * 0.4e6 * 16e-3), rel=5e-3)
        with pytest.raises(ss.errors.InvalidValueError, match="strained by"):
            ss.press(skin, pair, force=0.1, max_strain=0.9 * strain)
        # the lesser one, as deep as the other, is strained more
        unlike = ss.pressing.Together([ball, ss.pressing.Sphere(1e-3)], [(-8e-3, 0.0), (8e-3, 0.0)])
        with pytest.raises(ss.errors.InvalidValueError, match="strained by"):
            ss.press(skin, unlike, force=0.07, max_strain=1.3 * strain)

    @pytest.mark.parametrize(
        ("body", "load"), [(PUNCH, 80.0), (BODY, 100.0), (ss.pressing.RoundedFlat(3e-4, 1e-3), 30.0)]
    )
    def test_the_strain_is_that_beneath(self, body, load):
        """Against the exact field of the solution, on a fine grid a tenth of the half width down and deeper."""
        found = ss.press(HALF, body, force=load)
        a = found.half_width
        x, y = a * np.linspace(0.1, 1, 19)[:, None], a * np.linspace(-1, 1, 41)
        greatest = np.abs(HALF.strain(found.contact, x, y).principal).max()
        with pytest.raises(ss.errors.InvalidValueError) as caught:
            ss.press(HALF, body, force=load, max_strain=0.8 * greatest)
        told = float(str(caught.value).split("strained by ")[1].split(" %")[0])
        assert told == pytest.approx(100 * greatest, rel=0.2)  # sampled at a few places
        assert caught.value.seen == f"a force of {load:.6g} N/m"
        ss.press(HALF, body, force=load, max_strain=1.1 * greatest)


class TestGivenBack:
    CALLS = (
        (HALF, BODY, {"force": 5.0}),
        (HALF, PUNCH, {"force": 5.0, "moment": 1e-3, "position": 2e-3}),
        (LAYER, BODY, {"force": 5.0, "friction": 0.5, "tangential": -1.0, "position": -1e-3}),
        (ROUND, ss.pressing.Edge(), {"force": 5.0}),
        (HALF, ss.pressing.SineRidges(0.4e-3, 3e-6, 8e-3), {"force": 5.0}),
    )

    @pytest.fixture(params=CALLS, ids=["hertz", "punch", "dragged", "edge", "ridges"])
    def found(self, request):
        skin, body, load = request.param
        return ss.press(skin, body, **load), load

    def test_resultants(self, found):
        found, load = found
        assert found.force == pytest.approx(load["force"], rel=1e-10)
        assert found.tangential == pytest.approx(load.get("tangential", 0.0), abs=1e-9)
        if "moment" in load:
            assert found.moment == pytest.approx(load["moment"], rel=1e-7)
        contact = found.contact
        assert isinstance(contact, ss.PressureProfile)
        assert float(contact.normal_force) == pytest.approx(found.force, rel=1e-12)
        assert float(contact.tangential_force) == pytest.approx(found.tangential, abs=1e-12)
        np.testing.assert_allclose(contact.pressure(found.y), found.pressure, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(contact.shear(found.y), found.shear, rtol=1e-9, atol=1e-6)

    def test_positions(self, found):
        found, load = found
        at = load.get("position", 0.0)
        assert found.position == at
        assert found.y.size == found.pressure.size == 1024
        np.testing.assert_allclose(np.diff(found.y), np.diff(found.y)[0], rtol=1e-6)
        step, touching = np.diff(found.y[:2])[0], found.y[found.pressure > 0]
        inside = np.any((found.edges[:, 0] <= touching[:, None]) & (touching[:, None] <= found.edges[:, 1]), axis=1)
        assert inside.all()
        assert np.diff(found.edges).sum() <= step * (touching.size + len(found.edges))
        assert (found.edges[1:, 0] > found.edges[:-1, 1]).all()
        assert found.half_width == pytest.approx((found.edges[-1, 1] - found.edges[0, 0]) / 2)
        assert (len(found.edges) > 1) == isinstance(found.indenter, ss.pressing.SineRidges)
        if found.friction is None:
            assert found.stick.shape == (0, 2)
            assert not found.shear.any()
        else:
            assert found.stick.shape == (1, 2)

    def test_read_only(self, found):
        for name in ("y", "gap", "slip", "edges", "stick"):
            with pytest.raises(ValueError, match="read-only"):
                getattr(found[0], name)[...] = 0.0

    def test_a_finger_reads_it(self):
        pressed = ss.press(HALF, BODY, force=5.0, position=0.3e-3)
        finger = ss.Finger(HALF, ss.SensorArray.line(5, pitch=1e-3, depth=1e-3))
        a = float(np.sqrt(4 * 5.0 * 4e-3 / (np.pi * RUBBER.plane_strain_modulus)))
        wanted = finger.read(ss.Hertz(5.0, position=0.3e-3, half_width=a))
        read = finger.read(pressed.contact)
        assert read.shape == (5,)
        np.testing.assert_allclose(read, wanted, rtol=0, atol=2e-5 * np.abs(wanted).max())

    def test_depth_is_known_only_from_a_ground(self):
        for skin, more, known in ((HALF, {}, False), (HALF, {"datum": 0.1}, True), (LAYER, {}, True)):
            found = ss.press(skin, BODY, force=5.0, friction=0.5, tangential=1.0, **more)
            assert np.isfinite(found.depth) == np.isfinite(found.slide) == known
        assert np.isnan(ss.press(LAYER, BODY, force=5.0).slide)

    def test_the_past_is_untouched(self):
        start = ss.press(HALF, BODY, force=5.0, friction=0.5, tangential=1.0)
        kept = {name: getattr(start, name).copy() for name in ("pressure", "shear", "gap", "slip", "stick")}
        ss.press(HALF, BODY, force=4.0, friction=0.5, tangential=-1.0, after=start)
        for name, values in kept.items():
            np.testing.assert_array_equal(getattr(start, name), values)
        again = ss.press(HALF, BODY, force=5.0, friction=0.5, tangential=1.0)
        np.testing.assert_array_equal(again.pressure, start.pressure)

    def test_ints_are_floats(self):
        one = ss.press(HALF, BODY, force=5, friction=1, tangential=2, position=0)
        two = ss.press(HALF, BODY, force=5.0, friction=1.0, tangential=2.0, position=0.0)
        np.testing.assert_array_equal(one.pressure, two.pressure)
        np.testing.assert_array_equal(one.shear, two.shear)


class TestProfilesAgree:
    """A shape of the catalogue, the same as a function, and as points."""

    @pytest.mark.parametrize("skin", [HALF, LAYER, ROUND], ids=["half plane", "layer", "round"])
    def test_cylinder(self, skin):
        window = 1.2e-3
        one = ss.press(skin, BODY, force=5.0, window=window)
        two = ss.press(skin, ss.pressing.Profile.from_function(BODY.height, -1e-2, 1e-2), force=5.0, window=window)
        y = np.linspace(-1e-2, 1e-2, 200_001)
        three = ss.press(skin, ss.pressing.Profile(y, 3.0 + BODY.height(y)), force=5.0, window=window)
        for other in (two, three):
            np.testing.assert_allclose(other.pressure, one.pressure, rtol=0, atol=2e-5 * one.pressure.max())
        np.testing.assert_allclose(two.edges, one.edges, rtol=1e-9)

    def test_punch(self):
        by_points = ss.press(HALF, ss.pressing.Profile([-1e-3, 1e-3], [0.0, 0.0]), force=5.0)
        np.testing.assert_allclose(by_points.pressure, ss.press(HALF, PUNCH, force=5.0).pressure, rtol=1e-8)

    def test_several_positions(self):
        """Two bumps apart: two contacts, which carry the same, mirrored."""
        body = ss.pressing.Profile.from_function(lambda y: (np.abs(y) - 1e-3) ** 2 / 4e-3, -2e-3, 2e-3)
        found = ss.press(HALF, body, force=4.0)
        assert found.edges.shape == (2, 2)
        np.testing.assert_allclose(found.edges[1], -found.edges[0, ::-1], rtol=1e-6)
        assert found.edges[1].mean() == pytest.approx(1e-3, rel=0.05)
        assert found.pressure[np.abs(found.y) < 0.3e-3].max() == 0
        assert found.gap[np.abs(found.y) < 0.3e-3].min() > 1e-5
