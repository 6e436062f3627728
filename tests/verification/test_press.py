"""Contacts without friction, solved and in closed form: Hertz, punch, wedge, waves, thick and thin layers."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest
from scipy.integrate import simpson

import subskin as ss
from subskin.pressing.certificate import certify, displaced

YOUNG = 0.4e6
RUBBER = ss.Material(YOUNG, 0.5)
HALF = ss.HalfPlane(RUBBER)
STIFF = RUBBER.plane_strain_modulus  # E* = E / (1 - nu^2)
WINDOWS = 2.5 * (1 + 0.0071 * np.arange(24))
"""Widths of the grid in half widths of the contact: its edges then fall anywhere between two nodes."""
DEPTHS, PLACES = np.array([[0.5], [1.0], [2.0]]), np.linspace(-2, 2, 9)


def strain_error(skin, found, wanted, a):
    """Greatest difference of the strains beneath two contacts of half width a, in shares of the greatest."""
    one, two = (skin.strain(c, a * DEPTHS, a * PLACES) for c in (found, wanted))
    scale = np.abs(two.xx).max()
    return max(np.abs(getattr(one, k) - getattr(two, k)).max() for k in ("xx", "yy", "xy")) / scale


def halving(errors, sizes):
    """Powers of the spacing by which the errors fall, from the first grid to the last."""
    first, last = np.asarray(errors)[[0, -1]]
    return np.log(first / last) / np.log(sizes[-1] / sizes[0])


def second_moment(solution):
    return (solution.pressure * solution.y**2).sum() * np.diff(solution.y[:2])[0]


def smooth_cases():
    """Indenter, force, half width and contact in closed form: P = pi E* a^2 / (4 R), P = E* slope a."""
    for force in (11.0, 16.0, 23.0):
        for radius in (4e-3, 9e-3):
            a = np.sqrt(4 * force * radius / (np.pi * STIFF))
            yield ss.pressing.Cylinder(radius), force, a, ss.Hertz(force, half_width=a), 0.25
        for slope in (0.1, 0.17):
            a = force / (STIFF * slope)
            yield ss.pressing.RoundedWedge(slope), force, a, ss.Wedge(force, half_width=a), 1 / 6


class TestSmoothBodies:
    """`Cylinder` against Hertz, a sharp `RoundedWedge` against `Wedge`."""

    @pytest.mark.parametrize("kind", [ss.pressing.Cylinder, ss.pressing.RoundedWedge])
    def test_closed_form_and_rate(self, kind):
        cases = [case for case in smooth_cases() if isinstance(case[0], kind)]
        sizes, errors = (64, 256, 1024), []
        for nodes in sizes:
            rows = []
            for at, window in enumerate(WINDOWS):
                indenter, force, a, wanted, share = cases[at % len(cases)]
                found = ss.press(HALF, indenter, force=force, nodes=nodes, window=window * a)
                assert found.status is ss.pressing.PressStatus.OK
                step = window * a / nodes
                assert abs(found.half_width - a) < 0.25 * step
                moment = second_moment(found) / (share * force * a**2)
                rows.append([strain_error(HALF, found.contact, wanted, a), abs(moment - 1)])
            errors.append(np.mean(rows, axis=0))
        strain, moment = np.transpose(errors)
        assert halving(strain, sizes) > 1.8
        assert halving(moment, sizes) > 1.3
        assert strain[-1] < 4e-6
        assert moment[-1] < 1.2e-4

    def test_pressure(self):
        for indenter, force, a, wanted, _ in smooth_cases():
            found = ss.press(HALF, indenter, force=force)
            y = found.y[np.abs(found.y) < 0.9 * a]
            error = np.abs(found.contact.pressure(y) - wanted.pressure(y))
            tip = np.abs(y) < 0.1 * a  # where a wedge's pressure has no end
            assert error[~tip].max() < 4e-5 * force / a

    def test_plane_stress(self):
        """The thin slice is softer: E instead of E / (1 - nu^2)."""
        found = ss.press(ss.HalfPlane(RUBBER, "stress"), ss.pressing.Cylinder(4e-3), force=5.0)
        assert found.half_width == pytest.approx(np.sqrt(4 * 5.0 * 4e-3 / (np.pi * YOUNG)), rel=1e-3)

    def test_depth_from_a_datum(self):
        """u(0) - u(D) of Hertz: P / (pi E*) (2 ln(2 D / a) + 1) (Johnson 1985, eq. 5.57, for D >> a)."""
        force, radius, datum = 20.0, 4e-3, 0.3
        a = np.sqrt(4 * force * radius / (np.pi * STIFF))
        wanted = force / (np.pi * STIFF) * (2 * np.log(2 * datum / a) + 1)
        found = ss.press(HALF, ss.pressing.Cylinder(radius), force=force, datum=datum)
        assert found.depth == pytest.approx(wanted, rel=1e-6)
        back = ss.press(HALF, ss.pressing.Cylinder(radius), depth=found.depth, datum=datum)
        assert back.force == pytest.approx(force, rel=1e-7)


class TestPunch:
    A, FORCE = 1.3e-3, 20.0

    @pytest.mark.parametrize("share", [0.0, 0.2, -0.35])
    def test_centred_or_with_a_moment(self, share):
        moment = share * self.FORCE * self.A
        wanted = ss.FlatPunch(self.FORCE, half_width=self.A, moment=moment)
        sizes, strain, tilt = (64, 256, 1024), [], []
        for nodes in sizes:
            found = ss.press(HALF, ss.pressing.RoundedFlat(self.A), force=self.FORCE, moment=moment, nodes=nodes)
            assert found.status is ss.pressing.PressStatus.OK
            assert found.edges == pytest.approx(np.array([[-self.A, self.A]]), rel=1e-12)
            assert found.moment == pytest.approx(moment, abs=1e-9 * self.FORCE * self.A)
            strain.append(strain_error(HALF, found.contact, wanted, self.A))
            tilt.append(abs(found.tilt - 4 * moment / (np.pi * STIFF * self.A**2)))
        assert halving(strain, sizes) == pytest.approx(1.0, abs=0.03)
        assert strain[-1] < 9e-4
        if share:
            assert halving(tilt, sizes) == pytest.approx(1.0, abs=0.03)
            assert tilt[-1] < 6e-4 * abs(4 * moment / (np.pi * STIFF * self.A**2))
        else:
            assert max(tilt) < 1e-12

    def test_a_tilt_kept_is_a_moment(self):
        moment = 0.2 * self.FORCE * self.A
        body = ss.pressing.RoundedFlat(self.A)
        by_moment = ss.press(HALF, body, force=self.FORCE, moment=moment)
        by_tilt = ss.press(HALF, body, force=self.FORCE, tilt=by_moment.tilt)
        assert by_tilt.moment == pytest.approx(moment, rel=1e-7)

    def test_a_moment_that_lifts_one_side(self):
        """b = 2 (a - M/P): one end is still sharp, at the other the bodies part smoothly."""
        share = 0.7
        b = 2 * self.A * (1 - share)
        sizes, errors = (128, 512, 2048), []
        for nodes in sizes:
            found = ss.press(
                HALF, ss.pressing.RoundedFlat(self.A), force=self.FORCE, moment=share * self.FORCE * self.A, nodes=nodes
            )
            step = 2 * self.A / nodes
            assert found.edges[0] == pytest.approx([self.A - 2 * b, self.A], abs=0.5 * step)
            s = found.y - (self.A - b)
            inside = np.abs(s) < 0.8 * b
            wanted = self.FORCE / (np.pi * b) * np.sqrt((b + s[inside]) / (b - s[inside]))
            pressure = np.abs(found.pressure[inside] - wanted).max() / wanted.max()
            errors.append([pressure, abs(found.tilt * np.pi * STIFF * b / (2 * self.FORCE) - 1)])
        for error in np.transpose(errors):
            assert halving(error, sizes) > 0.9
            assert error[-1] < 1.5e-3

    def test_a_tilt_moves_a_cylinder_not_its_contact(self):
        """A parabola that is turned is the same parabola, its lowest point at R tilt."""
        radius, tilt = 4e-3, 0.02
        straight, turned = (ss.press(HALF, ss.pressing.Cylinder(radius), force=10.0, tilt=t) for t in (0.0, tilt))
        assert turned.edges == pytest.approx(straight.edges + radius * tilt, abs=2e-6)
        assert turned.moment == pytest.approx(10.0 * radius * tilt, rel=1e-4)


class TestWaves:
    """Westergaard (1939): a half plane and a rigid wave A (1 - cos(2 pi y / pitch)); p* = pi E* A / pitch."""

    PITCH, AMPLITUDE = 0.5e-3, 2e-6
    FULL = np.pi * STIFF * AMPLITUDE / PITCH
    BODY = ss.pressing.SineRidges(PITCH, AMPLITUDE)

    def test_in_part(self):
        sizes, errors = (64, 256, 1024), []
        for nodes in sizes:
            rows = []
            for a in self.PITCH * np.linspace(0.08, 0.45, 16):
                peak = np.sin(np.pi * a / self.PITCH)
                found = ss.press(
                    HALF, self.BODY, force=self.FULL * peak**2 * self.PITCH, period=self.PITCH, nodes=nodes
                )
                assert found.half_width == pytest.approx(a, abs=0.5 * self.PITCH / nodes)
                psi = np.pi * found.y / self.PITCH
                inside = np.abs(found.y) < 0.85 * a
                wanted = 2 * self.FULL * np.cos(psi) * np.sqrt(np.maximum(peak**2 - np.sin(psi) ** 2, 0.0))
                rows.append(np.abs(found.pressure - wanted)[inside].max() / wanted.max())
            errors.append(np.mean(rows))
        assert halving(errors, sizes) > 1.5
        assert errors[-1] < 4e-5

    def test_full_contact(self):
        mean = 1.5 * self.FULL
        found = ss.press(HALF, self.BODY, force=mean * self.PITCH, period=self.PITCH, nodes=256)
        wanted = mean + self.FULL * np.cos(2 * np.pi * found.y / self.PITCH)
        assert found.pressure == pytest.approx(wanted, abs=1e-4 * self.FULL)
        assert found.depth == pytest.approx(self.AMPLITUDE, rel=1e-9)  # mean level to mean level

    @pytest.mark.parametrize(
        ("nodes", "load"), [(300, "force"), (500, "force"), (96, "force"), (512, "depth"), (2048, "depth")]
    )
    def test_any_number_of_nodes_by_force_or_depth(self, nodes, load):
        wanted = ss.press(HALF, self.BODY, force=0.2, period=self.PITCH)
        values = {"force": wanted.force, "depth": wanted.depth}
        found = ss.press(HALF, self.BODY, **{load: values[load]}, period=self.PITCH, nodes=nodes)
        assert found.status is ss.pressing.PressStatus.OK
        assert found.force == pytest.approx(wanted.force, rel=5e-3)
        assert found.depth == pytest.approx(wanted.depth, rel=5e-3)

    def test_one_period_is_as_good_as_two(self):
        one = ss.press(HALF, self.BODY, force=0.2, period=self.PITCH, nodes=128)
        two = ss.press(HALF, self.BODY, force=0.4, period=2 * self.PITCH, nodes=256)
        assert two.pressure.max() == pytest.approx(one.pressure.max(), rel=1e-6)
        assert two.depth == pytest.approx(one.depth, rel=1e-8)

    @pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
    def test_a_flat_all_along_a_bonded_layer(self, nu):
        thickness, mean = 1e-3, 4e3
        skin = ss.Layered(ss.Layer(ss.Material(YOUNG, nu), thickness))
        found = ss.press(
            skin, ss.pressing.SineRidges(self.PITCH, 0.0), force=mean * self.PITCH, period=self.PITCH, nodes=64
        )
        softness = thickness * (1 + nu) * (1 - 2 * nu) / (YOUNG * (1 - nu))
        assert found.depth == pytest.approx(mean * softness, rel=1e-9)
        assert found.pressure == pytest.approx(np.full(64, mean), rel=1e-9)


@pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")
class TestBondedLayers:
    RADIUS = 4e-3
    BODY = ss.pressing.Cylinder(RADIUS)

    @pytest.mark.parametrize("nu", [0.5, 0.3, 0.0])
    def test_thick_is_hertz(self, nu):
        material, force = ss.Material(YOUNG, nu), 5.0
        a = np.sqrt(4 * force * self.RADIUS / (np.pi * material.plane_strain_modulus))
        y = a * np.linspace(-0.8, 0.8, 9)
        wanted = ss.Hertz(force, half_width=a).pressure(y)
        sizes, errors = (8, 16, 32), []
        for size in sizes:
            found = ss.press(ss.Layered(ss.Layer(material, size * a)), self.BODY, force=force, window=2.5 * a)
            errors.append(np.abs(found.contact.pressure(y) / wanted - 1).max())
        assert halving(errors, sizes) == pytest.approx(2.0, abs=0.05)
        assert errors[-1] < 6e-4

    def test_thin_and_incompressible(self):
        """Lubrication: p = G (a^2 - y^2)^2 / (8 R h^3), P = 2 G a^5 / (15 R h^3), depth = a^2 / (6 R)."""
        a, shear = 1e-3, YOUNG / 3
        y = a * np.linspace(-0.8, 0.8, 9)
        sizes, errors = (20, 40), []
        for size in sizes:
            h = a / size
            found = ss.press(
                ss.Layered(ss.Layer(RUBBER, h)),
                self.BODY,
                force=2 * shear * a**5 / (15 * self.RADIUS * h**3),
                max_strain=None,
            )
            wanted = shear * (a**2 - y**2) ** 2 / (8 * self.RADIUS * h**3)
            errors.append(
                [
                    np.abs(found.contact.pressure(y) - wanted).max() / wanted.max(),
                    abs(found.depth / (a**2 / (6 * self.RADIUS)) - 1),
                    abs(found.half_width / a - 1),
                ]
            )
        pressure, depth, width = np.transpose(errors)
        assert halving(pressure, sizes) > 1.8
        assert halving(depth, sizes) > 1.8
        assert halving(width, sizes) == pytest.approx(1.0, abs=0.05)
        assert pressure[-1] < 3e-3
        assert depth[-1] < 4e-3
        assert width[-1] < 0.04

    @pytest.mark.parametrize("nu", [0.0, 0.3, 0.4])
    def test_thin_and_compressible(self, nu):
        """Winkler: p = (depth - y^2 / (2 R)) / C, C = h (1 + nu) (1 - 2 nu) / (E (1 - nu))."""
        a = 1e-3
        depth, y = a**2 / (2 * self.RADIUS), a * np.linspace(-0.8, 0.8, 9)
        sizes, errors = (10, 40), []
        for size in sizes:
            softness = a / size * (1 + nu) * (1 - 2 * nu) / (YOUNG * (1 - nu))
            found = ss.press(
                ss.Layered(ss.Layer(ss.Material(YOUNG, nu), a / size)), self.BODY, depth=depth, max_strain=None
            )
            wanted = (depth - self.BODY.height(y)) / softness
            force = 2 * a**3 / (3 * self.RADIUS * softness)
            pressure = np.abs(found.contact.pressure(y) - wanted).max() / wanted.max()
            errors.append([pressure, abs(found.force / force - 1), abs(found.half_width / a - 1)])
        for error, most in zip(np.transpose(errors), (1.2e-3, 1.2e-3, 1e-2), strict=True):
            assert error[-1] < most
            assert error[-1] < 0.35 * error[0]


@pytest.mark.parametrize(
    ("skin", "indenter", "more"),
    [
        (HALF, ss.pressing.SineRidges(0.5e-3, 4e-6), {"period": 0.5e-3, "nodes": 1024}),
        (HALF, ss.pressing.Cylinder(4e-3), {"datum": 0.1}),
        (ss.Layered(ss.Layer(RUBBER, 1e-3)), ss.pressing.RoundedFlat(0.3e-3, 1e-3), {}),
        (ss.Layered(ss.Layer(ss.Material(YOUNG, 0.3), 1e-3)), ss.pressing.RoundedWedge(0.1, 1e-3), {}),
        (ss.Round(RUBBER, 8e-3, 5e-3), ss.pressing.Flat(), {}),
    ],
    ids=["waves", "half plane", "layer-0.5", "layer-0.3", "round"],
)
def test_the_work_of_pressing_is_the_energy_stored(skin, indenter, more):
    """dU = F d(depth), U being half the pressure times the displacement."""
    depths = np.linspace(1e-6, 3.5e-6, 9) if "period" in more else np.linspace(5e-5, 9e-5, 9)
    force, energy = [], []
    for depth in depths:
        found = ss.press(skin, indenter, depth=depth, max_strain=None, **{"nodes": 512, **more})
        sunk = depth - indenter.height(found.y) - skin.surface_drop(found.y)
        force.append(found.force)
        energy.append(0.5 * (found.pressure * sunk).sum() * np.diff(found.y[:2])[0])
    assert energy[-1] - energy[0] == pytest.approx(simpson(force, x=depths), rel=2e-4 if "period" in more else 2e-5)


class TestCertificate:
    """A certificate has to see what is wrong."""

    @staticmethod
    def again(found, **changes):
        state = dataclasses.replace(found.state, **changes)
        case = found.case
        return certify(case, state, displaced(case, state))

    @pytest.fixture
    def rubbed(self):
        return ss.press(
            ss.Layered(ss.Layer(ss.Material(YOUNG, 0.4), 2e-3)),
            ss.pressing.Cylinder(4e-3),
            force=5.0,
            friction=0.4,
            tangential=1.0,
            moment=0.4e-3,
        )

    def test_of_the_solution(self, rubbed):
        assert rubbed.status is ss.pressing.PressStatus.OK
        assert rubbed.certificate.worst < 4e-9
        assert self.again(rubbed).worst == pytest.approx(rubbed.certificate.worst, abs=1e-12)

    def test_of_spoiled_ones(self, rubbed):
        state = rubbed.state
        p, q, moment = state.pressure, state.shear, 0.4e-3
        more = self.again(rubbed, pressure=1.01 * p)
        assert more.force_error == pytest.approx(0.01, rel=1e-6)
        assert more.gap > 3e-3
        width = np.diff(rubbed.y[:2])[0] * (p > 0).sum()
        assert more.moment_error == pytest.approx(0.01 * moment / (5.05 * width), rel=1e-4)
        assert self.again(rubbed, pressure=0.99 * p).penetration > 3e-3
        assert self.again(rubbed, depth=state.depth * 1.01).penetration > 5e-3
        assert self.again(rubbed, depth=state.depth * 0.99).complementarity > 5e-3
        assert self.again(rubbed, shear=1.01 * q).tangential_error == pytest.approx(0.01 * 1.0 / 5, rel=1e-4)
        assert self.again(rubbed, shear=1.01 * q).cone > 1e-3
        assert self.again(rubbed, shear=0.99 * q).creep > 1e-4
        assert self.again(rubbed, slide=state.slide * 0.9).wrong_way > 1e-3
        assert self.again(rubbed, tilt=state.tilt + 1e-3).worst > 1e-3
        assert self.again(rubbed, pressure=p - 1e-3 * p.max()).tension == pytest.approx(1e-3 / (1 - 1e-3), rel=1e-6)

    @pytest.mark.parametrize("way", [1.0, -1.0])
    def test_pressure_across_a_gap_counts_whichever_sign_the_gap_has(self, rubbed, way):
        """Sum of p |gap| over P scale: d / scale for a body moved by d, and for one turned by d / (mean arm of p)."""
        state, scale = rubbed.state, rubbed.certificate.scale
        moved = self.again(rubbed, depth=state.depth + way * 1e-2 * scale)
        assert moved.complementarity == pytest.approx(1e-2, rel=1e-6)
        arm = (state.pressure * np.abs(rubbed.case.y)).sum() / state.pressure.sum()
        turned = self.again(rubbed, tilt=state.tilt + way * 1e-2 * scale / arm)
        assert turned.complementarity == pytest.approx(1e-2, rel=1e-6)

    @pytest.mark.parametrize("drag", [1.0, -1.0])
    def test_slip_along_the_friction_is_wrong_where_it_slips_and_a_creep_where_it_sticks(self, drag):
        """The drag takes the skin along, which lags behind: slip is against the shear, or nothing."""
        found = ss.press(HALF, ss.pressing.Cylinder(4e-3), force=5.0, friction=0.4, tangential=drag)
        state, case, scale = found.state, found.case, found.certificate.scale
        pressed = np.flatnonzero(state.pressure)
        sticks = (found.y[pressed] > found.stick[0, 0]) & (found.y[pressed] < found.stick[0, 1])
        held, slides = pressed[sticks][5], pressed[~sticks][5]
        moved = displaced(case, state)
        for node, along, creep, wrong in (
            (held, 1, 0.1, 0), (held, -1, 0.1, 0), (slides, 1, 0, 0.1), (slides, -1, 0, 0),
        ):  # fmt: skip
            slip = np.zeros_like(moved.slip)
            slip[0, node] = 0.1 * along * np.sign(drag) * scale
            seen = certify(case, state, dataclasses.replace(moved, slip=slip))
            assert (seen.creep, seen.wrong_way) == pytest.approx((creep, wrong), rel=1e-9)

    def test_refined_shrinks(self):
        """Beneath a smooth body as s^1.5 nearly; on the grid itself the rules hold to the tolerance."""
        sizes, worst = (64, 256, 1024), []
        for nodes in sizes:
            rows = []
            for window in WINDOWS[::2]:
                a = np.sqrt(4 * 10.0 * 4e-3 / (np.pi * STIFF))
                found = ss.press(HALF, ss.pressing.Cylinder(4e-3), force=10.0, nodes=nodes, window=window * a)
                assert found.certificate.worst < 4e-9
                rows.append(found.refined().worst)
            worst.append(np.mean(rows))
        assert halving(worst, sizes) > 1.3
        assert 1e-6 < worst[-1] < 1e-4


def random_case(rng):
    """A skin, a body and a load, of lengths about 1 mm, with strains of some per cent."""

    def material():
        return ss.Material(10 ** rng.uniform(5, 7), rng.choice([0.0, 0.2, 0.3, 0.45, 0.49, 0.5]))

    def layer(low, high, **more):
        return ss.Layer(material(), 10 ** rng.uniform(low, high), **more)

    radius = 10 ** rng.uniform(-2.4, -1.6)
    skin = [
        lambda: ss.HalfPlane(material()),
        lambda: ss.Layered(layer(-3.5, -2)),
        lambda: ss.Layered([layer(-4.3, -3.3), layer(-3.3, -2.3)]),
        lambda: ss.Layered(layer(-3.7, -2.3), base=material()),
        lambda: ss.Layered(layer(-3.7, -2.5, bond="frictionless")),
        lambda: ss.Round(material(), radius, radius * rng.uniform(0.2, 0.85)),
    ][rng.integers(6)]()
    y = np.linspace(-3e-3, 3e-3, 151)
    bumps = np.cumsum(rng.normal(size=y.size)) * 1e-6 + y**2 / (2 * 0.01)
    body = [
        lambda: ss.pressing.Cylinder(10 ** rng.uniform(-2.7, -1.7)),
        lambda: ss.pressing.RoundedFlat(10 ** rng.uniform(-3.5, -2.7)),
        lambda: ss.pressing.RoundedFlat(0.7e-3, 10 ** rng.uniform(-3.5, -2.3)),
        lambda: ss.pressing.RoundedWedge(rng.uniform(0.03, 0.2), rng.choice([0.0, 1e-3])),
        lambda: ss.pressing.SineRidges(0.5e-3, 10 ** rng.uniform(-6, -5), 0.02),
        lambda: ss.pressing.ParticleOnFlat(0.2e-3, 10 ** rng.uniform(-5.7, -4.5), 2e-3),
        lambda: ss.pressing.Profile(y, bumps),
    ][rng.integers(7)]()
    top = skin.stack[0].material if isinstance(skin, ss.Layered) else skin.single_material
    load = {"force": top.plane_strain_modulus * 1e-3 * 10 ** rng.uniform(-2.3, -1.2)}
    if rng.random() < 0.6:
        load["friction"] = float(rng.choice([0.1, 0.3, 0.6, 1.0, 2.0]))
        load["tangential"] = load["force"] * rng.uniform(-0.95, 0.95) * min(load["friction"], 1.0)
    elif isinstance(body, ss.pressing.RoundedFlat):
        load["moment"] = load["force"] * rng.uniform(-0.8, 0.8) * body.half_width
    return skin, body, load, int(rng.choice([128, 300, 1024]))


@pytest.mark.parametrize("seed", range(40))
def test_any_skin_any_body(seed):
    skin, body, load, nodes = random_case(np.random.default_rng(seed))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ss.errors.ValidityWarning)
        found = ss.press(skin, body, **load, nodes=nodes, max_strain=None)
    assert found.status in (ss.pressing.PressStatus.OK, ss.pressing.PressStatus.COARSE), found.reason
    p, q, gap = found.pressure, found.shear, found.gap
    assert (p >= 0).all()
    assert found.force == pytest.approx(load["force"], rel=1e-8)
    assert np.abs(q).max() == 0 if "friction" not in load else (np.abs(q) <= load["friction"] * p).all()
    assert found.tangential == pytest.approx(load.get("tangential", 0.0), abs=1e-8 * load["force"])
    if "moment" in load:
        assert found.moment == pytest.approx(load["moment"], abs=1e-8 * load["force"] * 1e-2)
    scale = found.certificate.scale
    assert np.abs(gap[p > 0]).max() < 4e-9 * scale
    assert gap.min() > -4e-9 * scale
