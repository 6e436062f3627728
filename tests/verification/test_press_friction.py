"""Contacts with friction, solved and in closed form: partial slip, its history, sliding, and bonded punches."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import beta as euler

import subskin as ss

YOUNG, RADIUS, FORCE, MU = 0.4e6, 4e-3, 20.0, 0.5
RUBBER = ss.Material(YOUNG, 0.5)
HALF = ss.HalfPlane(RUBBER)
STIFF = RUBBER.plane_strain_modulus
BODY = ss.pressing.Cylinder(RADIUS)
A = np.sqrt(4 * FORCE * RADIUS / (np.pi * STIFF))
MEAN = FORCE / A
CASE = {"force": FORCE, "friction": MU}
DATUM = 0.1


def first_loading(y, share):
    """Cattaneo's shear for T = share * mu P, on a contact that was pressed first (Johnson 1985, section 7.2)."""
    if not share:
        return np.zeros_like(y)
    drag = share * MU * FORCE
    wanted = ss.PartialSlip(np.hypot(FORCE, drag), np.arctan2(drag, FORCE), half_width=A, friction=MU)
    return wanted.shear(y)


def loading_slide(share):
    """The indenter's way: mu times what the normal approach falls by with the force (Ciavarella 1998; Jaeger 1998)."""

    def approach(force):
        width = np.sqrt(4 * force * RADIUS / (np.pi * STIFF))
        return force / (np.pi * STIFF) * (2 * np.log(2 * DATUM / width) + 1)

    return MU * (approach(FORCE) - approach(FORCE * (1 - share)))


class TestPartialSlip:
    """Cattaneo (1938), Mindlin (1949), at nu = 1/2, where pressure and shear do not disturb each other."""

    @pytest.mark.parametrize("share", [0.2, -0.5, 0.8])
    def test_shear_stick_and_rate(self, share):
        size = abs(share)
        drag = size * MU * FORCE
        wanted = ss.PartialSlip(
            np.hypot(FORCE, drag), np.sign(share) * np.arctan2(drag, FORCE), half_width=A, friction=MU
        )
        c = A * np.sqrt(1 - size)
        sizes, errors = (128, 512, 2048), []
        for nodes in sizes:
            rows = []
            for window in 2.5 * A * (1 + 0.017 * np.arange(8)):
                found = ss.press(HALF, BODY, **CASE, tangential=share * MU * FORCE, nodes=nodes, window=window)
                assert found.status is ss.pressing.PressStatus.OK
                assert found.tangential == pytest.approx(share * MU * FORCE, rel=1e-8)
                assert found.stick == pytest.approx(np.array([[-c, c]]), abs=0.8 * window / nodes)
                x, y = A * np.array([[0.3], [1.0], [2.0]]), A * np.linspace(-2, 2, 9)
                one, two = HALF.strain(found.contact, x, y), HALF.strain(wanted, x, y)
                rows.append(
                    max(np.abs(getattr(one, k) - getattr(two, k)).max() for k in ("xx", "yy", "xy"))
                    / np.abs(two.xx).max()
                )
                # away from the roots at the ends of contact and of stick, where a grid is a spacing off
                at = (np.abs(np.abs(found.y) - c) > 0.1 * A) & (np.abs(found.y) < 0.9 * A)
                error = np.abs(found.shear - wanted.shear(found.y))[at].max()
                assert error < 0.1 * MEAN * (A / nodes) / A
            errors.append(np.mean(rows))
        assert np.log(errors[0] / errors[-1]) / np.log(16) > 1.7
        assert errors[-1] < 2e-6

    def test_the_pressure_is_hertz(self):
        frictionless = ss.press(HALF, BODY, force=FORCE)
        found = ss.press(HALF, BODY, **CASE, tangential=0.7 * MU * FORCE)
        assert found.pressure == pytest.approx(frictionless.pressure, abs=1e-6 * MEAN)

    @pytest.mark.parametrize("share", [0.3, 0.9])
    def test_slide(self, share):
        found = ss.press(HALF, BODY, **CASE, tangential=share * MU * FORCE, datum=DATUM)
        assert found.slide == pytest.approx(loading_slide(share), rel=1e-5)

    def test_history(self):
        """Mindlin and Deresiewicz (1953): after turning round, twice the first loading comes off."""
        start = 0.7
        state = ss.press(HALF, BODY, **CASE, datum=DATUM, nodes=1024)
        state = ss.press(HALF, BODY, **CASE, datum=DATUM, tangential=start * MU * FORCE, after=state, nodes=1024)
        turned, y = state, state.y
        slide = loading_slide(start)
        for share in (0.4, 0.0, -0.3, -start):
            state = ss.press(HALF, BODY, **CASE, datum=DATUM, tangential=share * MU * FORCE, after=state)
            back = (start - share) / 2
            wanted = first_loading(y, start) - 2 * first_loading(y, back)
            self.compare(state, wanted, [start, back])
            assert state.slide == pytest.approx(slide - 2 * loading_slide(back), abs=2e-5 * slide)
        for share in (0.1, start):
            state = ss.press(HALF, BODY, **CASE, datum=DATUM, tangential=share * MU * FORCE, after=state)
            on = (start + share) / 2
            wanted = -first_loading(y, start) + 2 * first_loading(y, on)
            self.compare(state, wanted, [start, on])
            assert state.slide == pytest.approx(-slide + 2 * loading_slide(on), abs=2e-5 * slide)
        assert state.shear == pytest.approx(turned.shear, abs=1e-6 * MEAN)
        assert state.slide == pytest.approx(turned.slide, rel=1e-6)

    @staticmethod
    def compare(state, wanted, shares):
        assert state.status is ss.pressing.PressStatus.OK
        error = np.abs(state.shear - wanted)
        assert error.max() < 8e-3 * MEAN
        for share in shares:
            error = np.where(np.abs(np.abs(state.y) - A * np.sqrt(1 - share)) < 0.05 * A, 0.0, error)
        assert error[np.abs(state.y) < 0.9 * A].max() < 2e-4 * MEAN
        # the zone that has not slipped since turning
        c = A * np.sqrt(1 - shares[-1])
        assert state.stick == pytest.approx(np.array([[-c, c]]), abs=5e-3 * A)

    def test_pressed_further_and_less_after_a_drag(self):
        """More force with the drag kept: the old shear is kept where it was, and |q| <= mu p in the new contact."""
        state = ss.press(HALF, BODY, **CASE, tangential=4.0, window=4 * A)
        before = state.shear
        more = ss.press(HALF, BODY, force=1.5 * FORCE, friction=MU, tangential=4.0, after=state)
        assert more.status is ss.pressing.PressStatus.OK
        # at nu = 1/2 pressure moves nothing sideways, so that nothing slips and no shear changes
        assert more.shear == pytest.approx(before, abs=1e-6 * MEAN)
        assert more.stick[0] == pytest.approx(A * np.sqrt(1.5) * np.array([-1, 1]), abs=2 * np.diff(more.y[:2])[0])


class TestSliding:
    @pytest.mark.parametrize("drag", [1.2, -3.0])
    def test_beyond_friction(self, drag):
        found = ss.press(HALF, BODY, **CASE, tangential=drag * MU * FORCE)
        assert found.status is ss.pressing.PressStatus.SLIDES
        assert found.stick.size == 0
        assert found.shear == pytest.approx(np.sign(drag) * MU * found.pressure, rel=1e-9, abs=1e-9 * MEAN)
        assert found.tangential == pytest.approx(np.sign(drag) * MU * FORCE, rel=1e-9)

    def test_a_slide_beyond_the_last_stick(self):
        whole = loading_slide(1 - 1e-12)
        slides = ss.press(HALF, BODY, **CASE, slide=1.01 * whole, datum=DATUM)
        holds = ss.press(HALF, BODY, **CASE, slide=0.98 * whole, datum=DATUM)
        assert slides.status is ss.pressing.PressStatus.SLIDES
        assert slides.tangential == pytest.approx(MU * FORCE, rel=1e-9)
        assert holds.status is ss.pressing.PressStatus.OK
        assert 0.9 < holds.tangential / (MU * FORCE) < 1

    def test_coupled(self):
        """At nu < 1/2 the shear shifts the contact: p of a sliding cylinder (Johnson 1985, section 7.1).

        p = (E* / (2 R cos(pi g))) (a + y)^(1/2 - g) (a - y)^(1/2 + g), tan(pi g) = mu (1 - 2 nu) / (2 (1 - nu)).
        """
        material = ss.Material(YOUNG, 0.3)
        skin = ss.HalfPlane(material)
        beta = 0.4 / (2 * 0.7)
        found = ss.press(skin, BODY, force=FORCE, friction=MU, tangential=2 * MU * FORCE, nodes=2048)
        assert found.status is ss.pressing.PressStatus.SLIDES
        gamma = np.arctan(beta * MU) / np.pi
        # the integral of the pressure is lead * B(3/2 - g, 3/2 + g) (2 a)^2
        lead = material.plane_strain_modulus * np.cos(np.pi * gamma) / (2 * RADIUS)
        a = np.sqrt(FORCE / (4 * lead * euler(1.5 - gamma, 1.5 + gamma)))
        assert found.half_width == pytest.approx(a, rel=2e-3)
        # a pressure draws the surface towards itself; so (reciprocity) a drag sinks it ahead and lifts it behind,
        # where the contact goes
        middle = -2 * gamma * a
        assert found.edges.mean() == pytest.approx(middle, abs=1e-3 * a)
        s = (found.y - middle) / a
        inside = np.abs(s) < 0.9
        wanted = lead * a * (1 + s[inside]) ** (0.5 - gamma) * (1 - s[inside]) ** (0.5 + gamma)
        assert found.pressure[inside] == pytest.approx(wanted, abs=3e-4 * MEAN)

    def test_a_wave_slides_in_full_contact(self):
        """p = mean + P1 cos(k y) + P2 sin(k y), q = mu p, so that u_x = A cos(k y) + a constant.

        q = cos(k y) gives u_x = c sin(k y), c = (1 + nu)(1 - 2 nu) / (E k): a drag lifts the surface behind it.
        """
        nu, pitch, amplitude, mu = 0.2, 0.5e-3, 2e-6, 0.8
        k = 2 * np.pi / pitch
        own, other = 2 * (1 - nu**2) / (YOUNG * k), (1 + nu) * (1 - 2 * nu) / (YOUNG * k)
        ratio = mu * other / own
        first = amplitude / own / (1 + ratio**2)
        mean = 2 * first
        found = ss.press(
            ss.HalfPlane(ss.Material(YOUNG, nu)),
            ss.pressing.SineRidges(pitch, amplitude),
            force=mean * pitch,
            period=pitch,
            friction=mu,
            tangential=2 * mu * mean * pitch,
            nodes=512,
        )
        assert found.status is ss.pressing.PressStatus.SLIDES
        wanted = mean + first * (np.cos(k * found.y) - ratio * np.sin(k * found.y))
        assert found.pressure == pytest.approx(wanted, abs=1e-4 * first)
        assert found.shear == pytest.approx(mu * wanted, abs=1e-4 * first)


class TestSlideOrForce:
    """The same state, whether the way or the force is given."""

    @pytest.mark.parametrize("share", [0.3, -0.6])
    @pytest.mark.parametrize(
        ("skin", "more"),
        [
            (HALF, {"datum": DATUM}),
            (ss.HalfPlane(ss.Material(YOUNG, 0.2)), {"datum": DATUM}),
            (ss.Layered(ss.Layer(ss.Material(YOUNG, 0.4), 1e-3)), {}),
            (ss.Round(RUBBER, 8e-3, 5e-3), {}),
        ],
        ids=["half plane", "half plane-0.2", "layer", "round"],
    )
    def test_both_ways(self, skin, more, share):
        one = ss.press(skin, BODY, **CASE, **more, tangential=share * MU * FORCE, nodes=256)
        two = ss.press(skin, BODY, **CASE, **more, slide=one.slide, nodes=256)
        three = ss.press(skin, BODY, depth=one.depth, friction=MU, **more, tangential=one.tangential, nodes=256)
        for other in (two, three):
            assert other.status is ss.pressing.PressStatus.OK
            assert other.tangential == pytest.approx(one.tangential, rel=1e-6)
            assert other.force == pytest.approx(one.force, rel=1e-7)
            assert other.shear == pytest.approx(one.shear, abs=1e-5 * MEAN)


class TestBonded:
    """A punch that sticks wherever it touches, nu < 1/2 (Johnson 1985, eq. 2.69).

    The free surface would move inwards; the punch holds it back, so that it drags the skin outwards: q > 0 at y > 0.
    """

    A = 1e-3

    def wanted(self, nu, y):
        eta = np.log(3 - 4 * nu) / (2 * np.pi)
        lead = 2 * (1 - nu) / np.sqrt(3 - 4 * nu) * FORCE / (np.pi * np.sqrt(self.A**2 - y**2))
        return lead * np.exp(1j * eta * np.log((self.A + y) / (self.A - y)))

    @pytest.mark.parametrize("nu", [0.2, 0.3, 0.45])
    def test_johnson(self, nu):
        skin, sizes, errors = ss.HalfPlane(ss.Material(YOUNG, nu)), (128, 512), []
        for nodes in sizes:
            found = ss.press(skin, ss.pressing.RoundedFlat(self.A), force=FORCE, friction=np.inf, nodes=nodes)
            assert found.status is ss.pressing.PressStatus.OK
            y = found.y[np.abs(found.y) < 0.9 * self.A]
            wanted = self.wanted(nu, y)
            assert wanted.imag[-1] > 0
            at = np.abs(found.y) < 0.9 * self.A
            errors.append([np.abs(found.pressure[at] - wanted.real).max(), np.abs(found.shear[at] - wanted.imag).max()])
        for error in np.transpose(errors) / (FORCE / self.A):
            assert error[-1] < 2.5e-3
            assert error[-1] < 0.5 * error[0]
        # a bonded body cannot be told from one whose every node sticks: no slip gradient beneath it
        y = self.A * np.linspace(-0.85, 0.85, 18)
        gradient = skin.surface_gradient(found.contact, y)
        far = np.abs(skin.surface_gradient(found.contact, 1.3 * self.A).ux)
        assert np.abs(gradient.ux).max() < 0.03 * far
        assert np.abs(gradient.uy).max() < 0.03 * far

    def test_from_no_friction_to_all(self):
        nu, a = 0.3, self.A
        skin = ss.HalfPlane(ss.Material(YOUNG, nu))
        shears, sticks = [], []
        for mu in (0.12, 0.2, 0.5, np.inf):
            found = ss.press(skin, ss.pressing.RoundedFlat(a), force=FORCE, friction=mu, nodes=512)
            assert found.status is ss.pressing.PressStatus.OK
            q = found.shear
            assert q == pytest.approx(-q[::-1], abs=1e-4 * FORCE / a)
            assert (q[found.y > 0.1 * a] > 0).all()
            sticks.append(found.stick[0, 1] - found.stick[0, 0])
            slips = found.y > found.stick[-1, 1] + np.diff(found.y[:2])[0]
            if np.isfinite(mu):
                assert q[slips] == pytest.approx(mu * found.pressure[slips], rel=1e-9)
                assert (found.slip[slips] < 0).all()  # inwards, for all that friction does
            shears.append(np.abs(q).sum())
        assert (np.diff(sticks) > 0).all()
        assert (np.diff(shears) > 0).all()
        assert sticks[-1] == pytest.approx(2 * a, rel=1e-9)
        slippery = ss.press(skin, ss.pressing.RoundedFlat(a), force=FORCE, friction=1e-6, nodes=512)
        free = ss.press(skin, ss.pressing.RoundedFlat(a), force=FORCE, nodes=512)
        assert slippery.pressure == pytest.approx(free.pressure, rel=1e-5)

    def test_cylinder(self):
        """Self-similar in mu only: the share of the contact that sticks does not depend on the force."""
        skin = ss.HalfPlane(ss.Material(YOUNG, 0.3))
        shares = []
        for force in (5.0, 20.0, 80.0):
            found = ss.press(skin, BODY, force=force, friction=0.3, nodes=512)
            assert found.status is ss.pressing.PressStatus.OK
            q = found.shear
            assert q == pytest.approx(-q[::-1], abs=1e-5 * found.pressure.max())
            assert found.stick.shape == (1, 2)
            assert found.stick[0, 0] < 0 < found.stick[0, 1]
            assert q[found.y > 0.3 * found.half_width].min() >= 0
            shares.append(found.stick[0, 1] / found.half_width)
        assert shares == pytest.approx(np.full(3, shares[0]), abs=6e-3)
        assert 0.2 < shares[0] < 0.5


class TestWorkOfFriction:
    """What friction takes: the shear times the slip, never less than nothing."""

    @staticmethod
    def spent(before, after):
        return -(0.5 * (before.shear + after.shear) * after.slip).sum() * np.diff(after.y[:2])[0]

    def test_a_cycle_of_mindlin(self):
        """The loop's area, by the fields and by force and way; both by Jaeger's closed form."""
        top, steps = 0.8, 12
        shares = top * np.concatenate([np.linspace(1, -1, steps), np.linspace(-1, 1, steps)[1:]])
        state = ss.press(HALF, BODY, **CASE, datum=DATUM, tangential=top * MU * FORCE, nodes=512)
        spent, drags, slides = 0.0, [state.tangential], [state.slide]
        for share in shares[1:]:
            after = ss.press(HALF, BODY, **CASE, datum=DATUM, tangential=share * MU * FORCE, after=state)
            assert (after.slip * after.shear <= 1e-9 * after.certificate.scale * MEAN).all()
            spent += self.spent(state, after)
            state = after
            drags.append(state.tangential)
            slides.append(state.slide)
        assert spent == pytest.approx(np.trapezoid(drags, slides), rel=1e-6)

        def loop(steps):
            """The area of a polygon within the loop: the loading curve, twice as large, once each way."""
            share = np.linspace(0, top, steps)
            loading = np.array([loading_slide(s) for s in share])
            return 8 * MU * FORCE * (np.trapezoid(share, loading) - 0.5 * top * loading[-1])

        assert spent == pytest.approx(loop(steps), rel=1e-4)
        assert spent == pytest.approx(loop(20001), rel=0.02)

    @pytest.mark.parametrize("seed", range(3))
    def test_any_walk(self, seed):
        """Pressed, dragged, pressed less: no step gives friction's work back."""
        rng = np.random.default_rng(seed)
        skin = [
            ss.HalfPlane(ss.Material(YOUNG, 0.2)),
            ss.Layered(ss.Layer(ss.Material(YOUNG, 0.4), 1e-3)),
            ss.Round(ss.Material(YOUNG, 0.3), 8e-3, 5e-3),
        ][seed]
        state = ss.press(skin, BODY, **CASE, nodes=256, window=4 * A)
        total = 0.0
        for _ in range(10):
            force = FORCE * rng.uniform(0.5, 1.4)
            drag = 1.1 * MU * force * rng.uniform(-1, 1)
            after = ss.press(skin, BODY, force=force, friction=MU, tangential=drag, after=state)
            assert after.status in (ss.pressing.PressStatus.OK, ss.pressing.PressStatus.SLIDES), after.reason
            if after.status is ss.pressing.PressStatus.OK:
                taken = -(after.shear * after.slip).sum() * np.diff(after.y[:2])[0]
                assert taken >= -1e-8 * FORCE * after.certificate.scale
                total += taken
            state = after
        assert total > 1e-3 * FORCE * state.certificate.scale
