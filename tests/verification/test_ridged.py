"""A skin with ridges: what their bases pass on, what is found of it, and what the memo's shares say of the same."""

from __future__ import annotations

import numpy as np
import pytest

import subskin as ss
from subskin.design import Ridges, Touches, placement_quality
from subskin.design.placement import Channel, study_at_depth
from subskin.design.ridges import best_ridge_pitch, read_ridged
from subskin.skin import Ridged

from .._tables import CONTACTS, FORCE, SOFT, A
from ._contract import box, load, resultants

HALF = ss.HalfPlane(SOFT)
PITCH, HEIGHT = 0.4 * A, 0.3 * A
SKINS = {
    "half plane": Ridged(HALF, PITCH, HEIGHT, crest=0.1 * A),
    "layer": Ridged(ss.Layered(ss.Layer(SOFT, 4 * A)), PITCH, HEIGHT, width=0.5 * PITCH),
    "round": Ridged(ss.Round(SOFT, 8 * A, 4 * A), 2 * np.pi * 8 * A / 40, HEIGHT),
}
ROW = ss.SensorArray.line(6, pitch=1.2 * A, depth=A, noise=1e-4)
FINGERS = {name: ss.Finger(skin, ROW) for name, skin in SKINS.items()}


@pytest.mark.parametrize("contact", ["slip", "profile"])
@pytest.mark.parametrize("name", SKINS)
def test_the_skin_carries_the_load_and_the_moment_of_its_lever(name, contact):
    """Force, and on a flat skin the moment: that of the load at its height over the bases."""
    skin, contact = SKINS[name], CONTACTS[contact]()
    carried = resultants(skin, box(skin, contact, 2 * A, 10 * A))
    wanted = load(skin, contact)
    if skin.curvature:  # forces turn with the ridges that bear them
        assert np.abs(carried[:2] + wanted[:2]).max() < 0.05 * FORCE
        return
    wanted[2] -= HEIGHT * contact.tangential_force
    assert np.abs((carried + wanted) / [1, 1, 10 * A]).max() < 1e-5 * FORCE


def test_the_wave_is_the_mean_over_all_crests():
    """The mean of fields of line loads beneath ridges everywhere is the sum of the mean's waves."""
    k, w = np.polynomial.legendre.leggauss(200)
    k, w = (10 / A) * (1 + k), (10 / A) * w
    y, count = A * np.linspace(-2, 2, 5), 8
    wave = SKINS["half plane"].wave(k, [A]).strain.xx[:, 0]
    for i, angle in enumerate((0.0, np.pi / 2)):
        skins = [Ridged(HALF, PITCH, HEIGHT, crest=PITCH * c / count) for c in range(count)]
        mean = np.mean([skin.strain(ss.LineLoad(1.0, angle), A, y).xx for skin in skins], axis=0)
        turn = np.outer(y, k)
        summed = (-np.sin(turn) if i else np.cos(turn)) @ (wave[:, i] * w) / np.pi
        assert np.abs(summed - mean).max() < 1e-6 * np.abs(mean).max()


def test_beneath_a_wide_contact_it_is_the_memos_share():
    """Pressure on half of the skin, twice as large: to the second power of a pitch over the contact's width."""
    skin, array = Ridged(HALF, 1e-3, 0.0, width=0.5e-3), ss.SensorArray.line(9, pitch=0.25e-3, depth=0.5e-3)
    off = []
    for half in (8e-3, 16e-3):
        touch = ss.PressureProfile(
            half * np.linspace(-1, 1, 41), 1e3 * np.cos(0.5 * np.pi * np.linspace(-1, 1, 41)) ** 2
        )
        share = read_ridged(ss.Finger(HALF, array), touch, Ridges(pitch=1e-3, shape="square", duty=0.5))
        seen = ss.Finger(skin, array).read(touch)
        off.append(np.abs(seen - 2 * share).max() / np.abs(seen).max())
    assert off[0] < 2e-2
    assert off[1] < 0.4 * off[0]


@pytest.mark.parametrize("name", SKINS)
def test_it_is_located(name):
    """On crests, between them and anywhere, exactly; by the smooth skin, aside by the lever of the ridges."""
    finger = FINGERS[name]
    crest, pitch = finger.skin.ridges
    touch = ss.LineLoad(FORCE, [0.3, -0.4, 0.2], [crest, crest + 0.5 * pitch, -1.37 * A])
    found = finger.locate(finger.read(touch))
    assert found.position == pytest.approx(touch.position, abs=1e-6 * A)
    assert found.angle == pytest.approx(touch.angle, abs=1e-6)
    assert finger.tabulate().error < 1e-9


def test_a_roller_is_fitted():
    finger = FINGERS["half plane"]
    touch = ss.Hertz(FORCE, 0.3, 0.4 * A, half_width=0.7 * A)
    found = finger.fit(finger.read(touch), "hertz")
    assert found.position == pytest.approx(0.4 * A, abs=1e-5 * A)
    assert found.half_width == pytest.approx(0.7 * A, rel=1e-3)


def test_batches_and_turns():
    skin = SKINS["round"]
    x, y = A * np.array([[0.5], [1.5]]), A * np.linspace(-2, 2, 5)
    touches = ss.Hertz(np.array([10.0, 20.0, 40.0])[:, None, None], 0.3, 0.2 * A, half_width=A)
    batch = skin.strain(touches, x, y).xx
    one = skin.strain(ss.Hertz(40.0, 0.3, 0.2 * A, half_width=A), x, y).xx
    assert np.allclose(batch, one * np.array([0.25, 0.5, 1.0])[:, None, None], rtol=1e-12, atol=0)
    by = 3 * skin.pitch
    assert np.allclose(skin.strain(ss.Hertz(40.0, 0.3, 0.2 * A + by, half_width=A), x, y + by).xx, one, rtol=1e-9)


def test_placement_knows_the_ridges():
    """Low and fine ridges are none; coarse and high ones count, and where a row stands on them."""
    touches = Touches(FORCE, span=(-3 * A, 3 * A))
    fine = placement_quality(ss.Finger(Ridged(HALF, 0.05 * A, 0.0), ROW), touches, grid=(21, 5))
    smooth = placement_quality(ss.Finger(HALF, ROW), touches, grid=(21, 5))
    assert fine["position_95"] == pytest.approx(smooth["position_95"], rel=5e-3)
    coarse = [Ridged(HALF, 1.5 * A, 0.5 * A, width=0.5 * A, crest=c * A) for c in (0.0, 0.75)]
    seen = [placement_quality(ss.Finger(skin, ROW), touches, grid=(21, 5))["position_95"] for skin in coarse]
    assert abs(seen[0] / smooth["position_95"] - 1) > 0.05
    assert abs(seen[0] / seen[1] - 1) > 0.01
    sizes = {"samples": 10, "grid": (21, 5)}
    row = study_at_depth(SKINS["half plane"], Channel(ss.NormalStrain(), 1e-4), A, [1.2 * A], [6], touches, **sizes)
    own = placement_quality(FINGERS["half plane"], touches, grid=(21, 5))
    assert row["position_95"].item() == pytest.approx(own["position_95"], rel=1e-9)


def test_what_it_is_not_for_is_refused():
    ridged = SKINS["half plane"]
    for wrong, said in (
        (lambda: Ridged(ridged, 1e-3, 1e-4), "smooth skin"),
        (lambda: Ridged(HALF, 1e-3, 1e-4, width=2e-3), "at most the pitch"),
        (lambda: Ridged(ss.Round(SOFT, 8e-3, 4e-3), 1e-3, 1e-4), "do not close"),
        (lambda: best_ridge_pitch(FINGERS["half plane"]), "the same at every position"),
        (lambda: ss.press(ridged, ss.pressing.Cylinder(5e-3), force=40.0), "press the smooth skin"),
    ):
        with pytest.raises(ss.SubskinError, match=said):
            wrong()
    wider = SKINS["round"].with_(radius=9 * A)
    assert wider.period / wider.pitch == pytest.approx(40)
