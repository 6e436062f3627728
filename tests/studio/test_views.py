"""What the views answer, without a browser: fields against the library's own, forms, programs, the memo, a stream."""

from __future__ import annotations

import json
import os
import re
import threading
import time
from dataclasses import replace
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from types import SimpleNamespace

import httpx
import numpy as np
import pytest

import subskin as ss
from subskin.design import search_grid
from subskin.design.ridges import read_ridged
from subskin.errors import SubskinError
from subskin.io.goals_file import parse_goals
from subskin.live import Bench
from subskin.live.ports import Robot
from subskin.memo import ERRATA
from subskin.studio.answer import FingerAnswers
from subskin.studio.calibrate import CalibrateView
from subskin.studio.client import framed
from subskin.studio.design import DesignView
from subskin.studio.fields import QUANTITIES, RANGE, nice, window_of
from subskin.studio.finger import EXAMPLE, FingerView, script_of
from subskin.studio.form import edited, finger_of, form_of
from subskin.studio.memo_view import MemoState, look, tree_of, words_of
from subskin.studio.state import FingerState, Look, Touch, first_touch
from subskin.studio.touches import BenchFeed, fit_told

AREA = EXAMPLE.replace("count = 8", 'layout = "grid"\nshape = [3, 3]').replace("[skin]", '[skin]\nkind = "half_space"')
LAYER = """\
[skin]
kind = "layers"
[[skin.layers]]
young = "0.4 MPa"
thickness = "5 mm"
[sensors]
count = 6
pitch = "1.5 mm"
depth = "2 mm"
noise = 5e-4
"""


def plain(said):
    """As a page hears it."""
    return json.loads(framed({"said": said})[4:])["said"]


@pytest.fixture(scope="module")
def view():
    return FingerView(FingerAnswers())


def values(meta, field):
    """What the bytes stand for, and how far they may be off by being bytes."""
    steep = (field.astype(float) - 127.5) / 127.5 * np.arcsinh(RANGE)
    exact = np.sinh(steep) * meta["most"] / RANGE
    off = 0.51 / 127.5 * np.arcsinh(RANGE) * np.cosh(steep) * meta["most"] / RANGE
    return exact, off


@pytest.mark.parametrize(
    ("text", "touch", "show"),
    [
        (EXAMPLE, Touch(family="hertz", force=40.0, angle=0.4, position=[8e-4], half_width=6e-4), "strain.xx"),
        (EXAMPLE, Touch(family="punch", force=40.0, angle=-0.9, position=[-3e-3], half_width=6e-4), "stress.xy"),
        (LAYER, Touch(family="line", force=20.0, angle=0.2, position=[2e-3], half_width=1e-3), "stress.yy"),
        (
            AREA,
            Touch(family="point", force=0.5, angle=0.5, azimuth=2.0, position=[1e-3, -2e-3], half_width=1e-3),
            "strain.xy",
        ),
        pytest.param(
            AREA,
            Touch(family="round_hertz", force=0.5, angle=-0.4, azimuth=1.0, position=[0.0, 1e-3], half_width=8e-4),
            "displacement.z",
            marks=pytest.mark.long,
        ),
    ],
    ids=["roller", "punch", "layer", "point", "ball"],
)
def test_a_field_is_that_of_the_skin_coarse_or_fine(view, text, touch, show):
    state = FingerState(text=text, touch=touch, show=show, seed=None)
    skin, quantity, level = finger_of(text).finger.skin, QUANTITIES[show], window_of(finger_of(text).finger).level
    coarse, _ = view.look(state, Look(moving=True))
    for how in ("coarse", "fine"):
        if how == "fine":
            while coarse["coarse"]:
                coarse, _ = view.look(state, Look(refine=True))
        said, fields = view.look(state, Look(moving=how == "coarse"))
        assert [meta["name"] for meta in said["fields"]] == (["section", "above"] if said["area"] else ["section"])
        for meta, field in zip(said["fields"], fields, strict=True):
            rows, columns = meta["shape"]
            y = meta["x"][0] + (np.arange(columns) + 0.5) * meta["x"][1] / columns
            down = meta["y"][0] + (np.arange(rows) + 0.5) * meta["y"][1] / rows
            rows_, columns_ = slice(3, None, 9), slice(1, None, 13)
            x, at = (down[rows_, None], y[columns_]) if meta["name"] == "section" else (level, y[columns_])
            z = () if not said["area"] else (touch.position[1] if meta["name"] == "section" else down[rows_, None],)
            true = quantity.scale * quantity.of(skin.state(touch.contact, x, at, *z))
            seen, off = values(meta, field[rows_, columns_])
            inside = np.abs(true) < meta["most"]
            assert inside.mean() > 0.8
            assert (np.abs(seen - true) <= off + 1e-6 * meta["most"])[inside].all()


def test_what_is_seen_is_what_the_library_says_the_picture_first():
    touch = Touch(family="hertz", force=40.0, angle=0.3, position=[8e-4], half_width=4e-4)
    state, answers = FingerState(text=EXAMPLE, touch=touch, seed=3), FingerAnswers()
    view = FingerView(answers)
    first, fields = view.look(state)
    assert first["found"]["pending"]
    assert fields[0].std() > 10
    later = answers.find(state)["found"]
    said, _ = view.look(state)
    assert plain(said["found"]) == plain(later)
    assert view.look(state.model_copy(update={"find": "fit"}))[0]["found"]["pending"]  # another estimator
    assert view.look(state, Look(edits=[("sensors.depth", 2.1e-3)]))[0]["found"]["pending"]  # another finger
    finger = finger_of(EXAMPLE).finger
    readings = finger.read(ss.Hertz(40.0, 0.3, 8e-4, half_width=4e-4), np.random.default_rng(3))
    found = finger.locate(readings)
    rows = {row["name"]: row for row in said["found"]["rows"]}
    np.testing.assert_allclose(said["readings"], readings, equal_nan=False)
    assert rows["position"]["value"] == pytest.approx(1e3 * float(found.position))
    assert rows["angle"]["std"] == pytest.approx(np.degrees(float(found.std[2])))
    assert rows["force"]["truth"] == 40.0
    assert said["found"]["status"] == "OK"
    np.testing.assert_allclose(said["found"]["ellipse"]["covariance"], found.covariance[:2, :2], equal_nan=False)
    np.testing.assert_allclose(
        said["found"]["fitted"], finger.read(ss.LineLoad.of_components(found.components, found.position))
    )
    assert said["found"]["rival"]["worse"] == pytest.approx(float(found.second.chi2))


def test_the_field_of_a_skin_with_ridges_is_that_of_its_position(view):
    text = EXAMPLE.replace("poisson = 0.5\n", 'poisson = 0.5\nridges = {pitch = "2 mm", height = "0.2 mm"}\n')
    skin = finger_of(text).finger.skin
    assert skin.ridges is not None
    touch = Touch(family="hertz", force=40.0, angle=0.1, position=[7e-4], half_width=1.5e-3)
    said, fields = view.look(FingerState(text=text, touch=touch, show="strain.xx", seed=None))
    meta, (rows, columns) = said["fields"][0], said["fields"][0]["shape"]
    y = meta["x"][0] + (np.arange(columns) + 0.5) * meta["x"][1] / columns
    x = meta["y"][0] + (np.arange(rows) + 0.5) * meta["y"][1] / rows
    true = 100 * skin.strain(touch.contact, x[8::9, None], y[::13]).xx
    seen, off = values(meta, fields[0][8::9, ::13])
    assert (np.abs(seen - true) <= off + 1e-6 * meta["most"]).all()


def test_a_touch_is_kept_in_sight_and_made_fit_for_the_finger(view):
    far = Touch(family="hertz", force=40.0, angle=0.3, position=[9.0], half_width=0.5)
    said, _ = view.look(FingerState(text=EXAMPLE, touch=far))
    assert said["state"]["touch"]["position"] == [said["window"]["right"]]
    assert said["state"]["touch"]["half_width"] < said["window"]["right"]
    area, _ = view.look(FingerState(text=AREA, touch=far), Look(moving=True))
    assert len(area["state"]["touch"]["position"]) == 2
    assert area["units"]["force"] == "N"


def test_noise_that_is_none_is_said_and_nothing_fails():
    found = FingerAnswers().find(FingerState(text=EXAMPLE.replace("5e-4", "0")))["found"]
    assert found["status"] == ""
    assert "noise" in found["words"]
    assert plain(found)["ellipse"] is None


@pytest.mark.parametrize(
    ("key", "value", "seen"),
    [
        ("sensors.depth", 3e-3, lambda f: float(f.finger.array.depth[0]) == 3e-3),
        ("sensors.pitch", 2e-3, lambda f: float(np.diff(f.finger.array.y)[0]) == pytest.approx(2e-3)),
        ("sensors.count", 5, lambda f: len(f.finger.array) == 5),
        ("sensors.noise", 1e-3, lambda f: float(f.finger.array.noise[0]) == 1e-3),
        ("sensors.kind", "mean_pressure", lambda f: f.finger.array.transducers[0] == ss.MeanPressure()),
        ("sensors.layout", "hexagonal", lambda f: f.finger.array.on_area and f.finger.skin.takes_local),
        ("skin.young", 1e6, lambda f: f.finger.skin.materials[0].young == 1e6),
        ("skin.kind", "layers", lambda f: f.finger.skin.thickness == pytest.approx(6e-3)),
        ("skin.kind", "round", lambda f: f.finger.skin.curvature > 0),
    ],
)
def test_a_number_that_is_changed_is_in_the_file(key, value, seen):
    text = edited(EXAMPLE, key, value)
    assert seen(finger_of(text))
    assert "# A finger of silicone rubber" in text  # comments stay
    assert (
        {one["key"]: one["value"] for one in form_of(finger_of(text))}[key] == pytest.approx(value)
        if isinstance(value, float)
        else True
    )
    back = edited(text, "sensors.layout", "row") if key == "sensors.layout" else text
    assert finger_of(back).finger.locate(np.zeros(len(finger_of(back).finger.array))).status == ss.Status.NO_CONTACT


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("sensors.depth", -1.0),
        ("sensors.depth", "deep"),
        ("sensors.count", 10**6),
        ("skin.kind", "wood"),
        ("skin.plane", "stress"),
    ],
)
def test_a_number_that_cannot_be_is_refused(key, value):
    with pytest.raises(SubskinError):
        edited(EXAMPLE, key, value)


def test_a_sensor_beneath_the_skin_is_said(view):
    with pytest.raises(SubskinError, match="thick"):
        view.look(FingerState(text=LAYER), Look(edits=[("sensors.depth", 9e-3)]))


def test_the_program_finds_what_the_page_shows(view, tmp_path, monkeypatch, capsys):
    state = FingerState(text=EXAMPLE, find="fit", seed=5, show="stress.xx")
    said, _ = view.look(state, Look(moving=True))
    program = script_of(state)
    monkeypatch.chdir(tmp_path)
    exec(compile(program, "program", "exec"), {})
    printed = capsys.readouterr().out
    assert printed.startswith(f"Estimate({said['found']['status']}")
    for row in said["found"]["rows"]:
        assert row["text"].split(" ±")[0].replace("−", "-") in printed
    assert (tmp_path / "finger.svg").read_bytes().startswith(b"<?xml")


def test_a_picture_is_a_file(running):
    headers = {"cookie": f"{running.keys.name}={running.keys.cookie}", "origin": running.url}
    for text, kind, start in ((EXAMPLE, "svg", b"<?xml"), (AREA, "png", b"\x89PNG")):
        state = FingerState(
            text=text,
            touch=first_touch(finger_of(text).finger).model_copy(
                update={"family": "point" if text is AREA else "line"}
            ),
        )
        made = httpx.post(
            f"{running.url}/picture.{kind}", headers=headers, content=state.model_dump_json(), timeout=60, verify=False
        )
        assert made.status_code == 200
        assert made.content.startswith(start)
    assert httpx.post(f"{running.url}/picture.exe", headers=headers, content="{}", verify=False).status_code == 400
    assert httpx.post(f"{running.url}/picture.svg", headers=headers, content="{}", verify=False).status_code == 400


FIGURES = tuple(look(MemoState())["figures"])


@pytest.mark.parametrize("figure", FIGURES)
def test_each_figure_of_the_memo_moves(figure):
    first = look(MemoState(figure=figure))
    assert [one["number"] for one in first["equations"]] == [
        one.equation for one in ERRATA if one.equation in {e["number"] for e in first["equations"]}
    ]
    for number in first["numbers"]:
        step = 0.37 * (number["most"] - number["value"]) or 0.37 * (number["least"] - number["value"])
        step = step if abs(step) >= number["step"] else np.copysign(number["step"], step)
        moved = look(MemoState(figure=figure, values={number["key"]: number["value"] + step}))
        assert plain(moved["panels"]) != plain(first["panels"]) or moved["told"] != first["told"]
        assert all(np.isfinite(np.asarray(c["y"], float)).any() for p in moved["panels"] for c in p["curves"])


def test_the_memo_as_printed_stands_beside_the_corrected():
    panels = look(MemoState(figure="11"))["panels"]
    right, printed = (np.asarray(curve["y"]) for curve in panels[0]["curves"])
    assert printed.max() == pytest.approx(0.5 * right.max(), rel=1e-3)  # errata, eq. (17)
    slopes = {c["kind"]: np.asarray(c["y"]) for c in look(MemoState(figure="13"))["panels"][1]["curves"]}
    assert slopes["right"][0] == pytest.approx(
        3 * np.sin(np.deg2rad(30.0)) / np.pi, rel=1e-3
    )  # eq. (22) corrected, dragged to +y
    assert slopes["printed"][0] * slopes["right"][0] < 0


def test_a_roller_that_is_dragged_has_the_strain_of_the_library():
    panel = look(MemoState(figure="13", values={"alpha": 25.0, "depth": 0.7}))["panels"][0]
    y, strain = (np.asarray(panel["curves"][0][axis]) for axis in "xy")
    true = ss.HalfPlane(ss.Material(1.0)).strain(ss.Hertz(1.0, np.deg2rad(25.0), half_width=1.0), x=0.7, y=y).xx
    np.testing.assert_allclose(strain, true, atol=1e-5)


def test_ridges_read_as_the_library_reads_them():
    panels = look(MemoState(figure="16", values={"pitch": 5.0, "half_width": 7.0}))["panels"]
    y, ridged = (np.asarray(panels[1]["curves"][1][axis])[::24] for axis in "xy")
    row = ss.Finger(ss.HalfPlane(ss.Material(1.0)), ss.SensorArray(y=y, depth=1.0))
    true = read_ridged(row, ss.Hertz(0.5 * np.pi * 7.0, half_width=7.0), ss.design.Ridges(5.0))
    np.testing.assert_allclose(ridged, true, atol=2e-5)


def test_a_particle_is_pressed_as_the_design_of_a_skin_presses_it():
    skin = ss.Round(ss.Material(0.4e6), radius=8e-3, core_radius=4e-3)
    finger = ss.Finger(skin, ss.SensorArray.line(count=8, pitch=0.5e-3, depth=0.8e-3, noise=2e-5))
    particle = ss.pressing.ParticleOnFlat(half_width=0.4e-3, protrusion=30e-6)
    true = ss.design.skin_compliance(finger, particle, force=40.0, young=[0.2e6])
    seen = look(MemoState(figure="17", values={"young": 0.2}))
    wide, share = 2e3 * float(true.half_width.squeeze()), 100 * float(true.load_share.squeeze())
    said = [float(one) for one in re.findall(r"[\d.]+(?= mm wide| %)", seen["told"][1])]
    assert said == pytest.approx([wide, share], rel=0.01)
    curves = {c["label"]: (c["x"], np.asarray(c["y"])) for c in seen["panels"][2]["curves"]}
    at, shares = curves["share of the force on the particle"]
    assert np.interp(np.log10(0.2), at[::-1], shares[::-1]) == pytest.approx(share, abs=1.5)
    pressure = seen["panels"][1]["curves"]
    for one in pressure:  # each carries the same force [N/m], but what lies beyond the picture
        inside = np.trapezoid(1e3 * one["y"], 1e-3 * one["x"])
        assert inside < 40.1
    assert np.trapezoid(1e3 * pressure[0]["y"], 1e-3 * pressure[0]["x"]) == pytest.approx(40.0, rel=0.01)


def test_every_formula_of_the_errata_is_a_tree():
    def leaves(tree):
        return [tree] if isinstance(tree[1], str | float) else [leaf for part in tree[1:] for leaf in leaves(part)]

    for one in ERRATA:
        for formula in (one.published, one.corrected):
            assert "\\" not in str(leaves(tree_of(formula))) if formula else tree_of(formula) == ["row"]
        assert all("$" not in str(line) for line in words_of(one.finding))
    assert tree_of(r"\frac{a_2 - a_1}{2}")[1][:1] == ["frac"]


def test_a_live_stream_is_told_recorded_and_played_again(running, asked, tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    monkeypatch.chdir(tmp_path)

    def news(socket, until, seconds=30.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            said, _ = asked.heard(socket)
            if said.get("news"):
                asked.sent(socket, "page", "drawn")
                if until(said):
                    return said
        raise AssertionError("it was not told")

    def sent(socket, view, do, **given):
        socket.send(json.dumps({"id": 0, "view": view, "do": do, **given}))

    asked.sent = sent
    with running.connect() as socket, running.connect() as other:
        assert asked(socket, "live", "begin")[0]["first"] == "robot?seed=3"
        for one in (socket, other):
            sent(one, "page", "watch", of="live")
        sent(socket, "live", "start", start={"port": "demo?rate=200", "slip": "0.4..0.8"})
        news(socket, lambda said: said["run"] == "running")
        sent(socket, "live", "record", on=True)
        news(socket, lambda said: said.get("recording"))
        sent(socket, "live", "mark", text="here")
        news(socket, lambda said: (said.get("found") or {}).get("status") == "OK" and said["steps"])
        told = news(socket, lambda said: any(event["kind"] == "mark" for event in said["events"]))
        assert [event["text"] for event in told["events"] if event["kind"] == "mark"] == ["here"]
        assert told["slip"]["words"]
        assert told["lost"] == 0
        assert len(told["readings"]) == 8
        assert news(other, lambda said: said["run"] == "running")["name"] == "demo?rate=200"  # both pages see it
        time.sleep(0.5)  # a quick machine is here at once, and the recording has to be longer than is asked below
        sent(socket, "live", "record", on=False)
        told = news(socket, lambda said: said.get("recorded"))
        kept = told["recorded"]
        sent(socket, "live", "stop")
        news(socket, lambda said: said["run"] == "ended")
        sent(socket, "live", "start", start={"port": kept, "speed": 50})
        played = news(socket, lambda said: said["kind"] == "recording" and said["run"] == "ended")
        assert played["whole"] > 0.3
        assert played["at"] == pytest.approx(played["whole"], abs=1e-6)
        sent(socket, "live", "start", start={"port": "/dev/nowhere"})
        assert "nowhere" in news(socket, lambda said: said["run"] == "failed")["fault"]
        refused = asked(socket, "live", "zero")[0]
        assert "error" in refused or refused.get("news") or refused["done"]
    running.studio.answer("live", "stop", {})


def test_a_finger_is_calibrated_touch_by_touch(running, asked, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def until(test, seconds=60.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if test(told := running.studio.news("calibrate")[0]):
                return told
            time.sleep(0.01)
        raise AssertionError(f"{told['run']}, {told.get('phase')}: {told.get('said')}")

    with running.connect() as socket:

        def ask(do, **given):
            return asked(socket, "calibrate", do, **given)[0]

        begun = ask("begin")
        assert begun["port"] == "robot?seed=3"
        assert len(begun["sensors"]["depth"]) == 8
        for given in ({"accuracy": "much"}, {"rest": "-1 s"}, {"positions": "3 mm:1 mm:1 mm"}):
            assert "error" in ask("start", start=given)
        assert "no session runs" in ask("skip")["error"]
        ask("start", start={"force": "40 N/m", "accuracy": "0.05 mm", "rest": "0.2 s", "hold": "0.1 s"})

        def made_where_the_person_says(told):
            if told.get("phase") == "touch" and told["asked"] != -1.2e-3:
                ask("at", position="-1.2 mm")
            return -1.2e-3 in np.asarray(told["touches"])

        until(made_where_the_person_says)
        until(lambda told: told["r2"] is not None)
        ask("again")
        told = until(lambda told: told["run"] == "ended")
        assert told["phase"] == "done"
        assert "reached" in told["said"][-1]
        assert any("taken back" in line or "once more" in line for line in told["said"])
        assert told["error"] <= told["wanted"] == 5e-5
        assert set(told["health"]) == {"ok"}
        for name in ("../out.toml", "out.txt", ""):
            assert "without a folder" in ask("accept", name=name)["error"]
        kept = ask("accept", name="out.toml")
        assert "such a file already" in ask("accept", name="out.toml")["error"]
    drawn, found = finger_of(EXAMPLE), ss.load(tmp_path / "out.toml")
    robot = Robot(drawn, seed=3)
    true = np.asarray(robot.finger.array.gain)
    assert found.differences
    assert kept["text"] == (tmp_path / "out.toml").read_text("utf-8")
    gains = np.array([[float(now), float(error)] for what, _, now, error in told["changes"] if what.startswith("gain")])
    assert gains[:, 0] == pytest.approx(np.asarray(found.finger.array.gain), abs=0.51 * gains[:, 1].max())
    assert (np.abs(gains[:, 0] - true) < 6 * gains[:, 1]).all()  # as many touches as the machine had time for
    assert (gains[:, 1] < 0.3).all()
    assert running.studio.answer("calibrate", "back", {})[0] == {"done": True}
    assert running.studio.news("calibrate")[0] == {"run": "idle"}


def test_the_weak_and_the_dead_sensor_are_told():
    file, positions = finger_of(EXAMPLE), np.linspace(-5e-3, 5e-3, 15)
    readings = file.finger.read(ss.LineLoad(np.full(15, 40.0), position=positions), np.random.default_rng(1))
    readings[:, 2] *= 0.0
    readings[:, 5] *= 0.3
    feed = BenchFeed(Bench(file, positions, force=40.0), "robot", lambda: None)
    assert feed.told()["health"] == 8 * ["ok"]
    feed.bench_state = replace(feed.bench_state, found=ss.calibrate(file.finger, readings, positions, force=40.0))
    told = feed.told()
    assert told["health"] == ["ok", "ok", "dead", "ok", "ok", "weak", "ok", "ok"]
    found = {what: float(now) for what, _, now, _ in told["changes"] if what.startswith("gain")}
    assert found["gain of s2"] == 0.0
    assert found["gain of s5"] == pytest.approx(0.3, rel=0.1)


def test_touches_made_before_are_fitted_as_the_library_fits_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    file, positions = finger_of(EXAMPLE), np.linspace(-5e-3, 5e-3, 15)
    true = replace(file.finger, array=replace(file.finger.array, gain=np.linspace(0.8, 1.2, 8)))
    readings = true.read(ss.LineLoad(np.full(15, 40.0), position=positions), np.random.default_rng(1))
    columns = {"position": positions, "force": np.full(15, 40.0), **dict(zip(file.names, readings.T, strict=True))}
    ss.io.write_table("presses.csv", columns)
    text = Path("presses.csv").read_text("utf-8")
    view = CalibrateView(lambda: None, lambda text: file)

    def fitted(**given):
        view.answer("file", {"file": {"name": "presses.csv", "text": text} | given})
        while (told := view.told())["run"] in ("starting", "running"):
            time.sleep(0.01)
        return told

    told = fitted(fit="gain, origin")
    found = ss.calibrate(file.finger, readings, positions, force=40.0, fit=("gain", "origin"))
    assert (told["run"], told["fault"], told["r2"]) == ("ended", "", pytest.approx(found.r2))
    np.testing.assert_allclose(told["touches"], positions, equal_nan=False)
    errors = [p.std for p in found.parameters if p.name == "gain"]
    errors += [1e3 * p.std for p in found.parameters if p.name == "origin"]
    assert [float(row[3].split()[0]) for row in told["changes"] if row[3]] == pytest.approx(errors, rel=0.17)  # a digit
    view.answer("accept", {"name": "felt.toml"})
    np.testing.assert_allclose(
        ss.load("felt.toml").finger.array.gain, found.finger.array.gain, rtol=1e-5, equal_nan=False
    )
    assert "presses.csv, line 2" in fitted(text=text.replace("-0.00", "wide", 1))["fault"]
    assert "force" in fitted(fit="force")["fault"]  # what is fitted is not among what can be
    assert "s7" in fitted(text=text.replace("s7", "more"))["fault"]


def test_gains_of_the_mean_have_the_spread_of_drawn_ones():
    """Errors of ratios by their slopes, against ratios of gains drawn with the covariance of the fit."""
    file, positions = finger_of(EXAMPLE), np.linspace(-5e-3, 5e-3, 15)
    readings = file.finger.read(ss.LineLoad(np.full(15, 40.0), position=positions), np.random.default_rng(1))
    found = ss.calibrate(file.finger, readings, positions, force=40.0, fit=("gain", "depth"))
    at = [i for i, p in enumerate(found.parameters) if p.name == "gain"]
    covariance = found.covariance.copy()
    covariance[np.ix_(at, at)] += 0.1**2  # what moves all gains at once is no error of their ratios
    found = replace(found, covariance=covariance)
    drawn = np.random.default_rng(2).multivariate_normal(
        np.asarray(found.finger.array.gain), found.covariance[np.ix_(at, at)], 20_000
    )
    spread = (drawn / drawn.mean(axis=1, keepdims=True)).std(axis=0)
    told = fit_told(file, found, relative=True)["changes"]
    errors = [float(error) for what, *_, error in told if what.startswith("gain")]
    assert errors == pytest.approx(spread, rel=0.17)  # one digit
    assert spread.max() < 0.03


@pytest.mark.parametrize("port", [None, "demo?rate=200", "touch.parquet"])
def test_where_no_one_can_touch_nothing_is_calibrated(port):
    view = CalibrateView(lambda: None, lambda text: finger_of(EXAMPLE), port)
    assert view.answer("begin", {})["port"] == ""
    with pytest.raises(SubskinError, match="no session"):
        view.answer("start", {"start": {}})


GOALS = """\
touch = {force = "20 N/m", span = "8 mm"}
accuracy = {position = "0.5 mm"}
room = {count = [3, 4], depth = ["2 mm", "3 mm"], least_pitch = "2 mm", longest_row = "9 mm"}
sensor = [{name = "gauge", kind = "normal_strain", noise = 1e-4}]
skin = [{name = "soft", young = "0.4 MPa"}]
tolerances = {none = true}
search = {depths = 2, pitches = 3}
"""


@pytest.mark.long  # a process is started for it
def test_a_search_is_followed_mapped_held_and_stopped():
    view = DesignView(lambda: None)
    try:
        keys = {field["key"] for field in view.answer("begin", {})["form"]}
        assert keys >= {"touch.force", "room.count", "search.depths"}
        form = view.answer("edit", {"text": GOALS, "key": "search.depths", "value": "3"})
        assert "depths = 3" in form["text"]
        with pytest.raises(SubskinError):
            view.answer("edit", {"text": GOALS, "key": "room.depth", "value": "3 mm .. 2 mm"})
        view.answer("start", {"text": GOALS})
        end = time.monotonic() + 60
        while "map" not in view.told() and time.monotonic() < end:
            time.sleep(0.05)
        assert view.told()["map"]["layouts"] == ["3 sensors", "4 sensors"]
        seen = view.answer("map", {"skin": 0, "sensor": 0, "layout": 1})
        excess = np.asarray(seen["excess"])
        assert excess.shape == (2, 3)
        held = {"skin": 0, "sensor": 0, "layout": 1, "depth": 0, "pitch": 1}
        array = finger_of(view.answer("hold", held)["text"]).finger.array
        assert float(array.depth[0]) == pytest.approx(2e-3)
        assert np.ptp(array.points[:, 0]) == pytest.approx(3 * seen["pitches"][1], rel=1e-3)
        assert len(array) == 4
        for wrong, said in (({"layout": 2}, "from 0"), ({"pitch": -1}, "from 0"), ({"skin": 0.5}, "valid integer")):
            with pytest.raises(SubskinError, match=said):
                view.answer("hold", held | wrong)
        began = time.monotonic()
        view.answer("stop", {})
        assert time.monotonic() - began < 5
        assert view.told()["run"] == "stopped"
        assert view._rows  # what was finished is kept
    finally:
        view.close()


PAD = """\
touch = {force = "1 N", area = ["8 mm", "6 mm"]}
accuracy = {position = "0.3 mm"}
room = {count = [4, 5], depth = "3 mm", least_pitch = "2.5 mm", layouts = ["grid", "hexagonal"]}
skin = [{name = "silicone", kind = "half_space", young = "1 MPa"}]
search = {depths = 1, pitches = 2, touches = 100, keep = 2}
[[sensor]]
name = "barometer"
kind = "mean_pressure"
noise = "20 Pa"
"""
MIXED = (
    PAD
    + """\
[[sensor]]
name = "gauge"
kind = {name = "shear_strain", plane = "xy"}
noise = 3e-4
[[mix]]
name = "both"
kinds = ["barometer", "gauge"]
together = false
"""
)


class Beside(threading.Thread):
    """The search in a thread: a process costs seconds to start."""

    def __init__(self, target, args, daemon):
        pipe, *more = args
        super().__init__(target=target, args=(Connection(os.dup(pipe.fileno())), *more), daemon=daemon)

    def terminate(self):
        self.join(60)


def test_goals_on_an_area_are_searched_and_each_design_is_held(monkeypatch):
    context = SimpleNamespace(Pipe=Pipe, Process=Beside)
    monkeypatch.setattr("subskin.studio.design.get_context", lambda _: context)
    view = DesignView(lambda: None)
    assert {f["key"]: f["value"] for f in view.answer("check", {"text": PAD})["form"]}["touch.area"] == "8 mm .. 6 mm"
    view.answer("start", {"text": PAD})
    end = time.monotonic() + 60
    while view.told()["run"] in ("searching", "ranking") and time.monotonic() < end:
        time.sleep(0.02)
    told = view.told()
    view.close()
    assert (told["run"], told["fault"]) == ("done", "")
    assert "layout" in told["study"]["columns"]
    for i, one in enumerate(view._study.fingers):
        array = finger_of(view.answer("hold", {"finger": i})["text"]).finger.array
        assert len(array) == one.row.count
        where = told["study"]["fingers"][i]
        assert (where["skin"], where["sensor"], where["layout"]) == one.row.which(view._grid.goals)
    view._file = parse_goals(MIXED)
    view._grid = grid = search_grid(view._file.goals, workers=1)
    seen = view.told()["map"]
    assert seen["sensors"] == ["barometer", "gauge", "both"]
    assert seen["layouts"][0].startswith("4 sensors, ")
    assert len(set(seen["layouts"])) == len(seen["layouts"]) == len(grid.goals.layouts)
    for n, layout in enumerate(grid.goals.layouts):
        file = finger_of(view.answer("hold", {"skin": 0, "sensor": 2, "layout": n, "depth": 0, "pitch": 1})["text"])
        points = layout.points(float(grid.pitches[1]), grid.goals.middle)
        off = np.linalg.norm(file.finger.array.points[:, None] - points, axis=-1).min(axis=1)
        assert len(file.finger.array) == len(points)
        assert off.max() < 1e-6
        assert len(set(file.finger.array.transducers)) == 2
        assert np.shape(view.answer("map", {"skin": 0, "sensor": 2, "layout": n})["excess"]) == (1, 2)


def test_round_ends_of_bars():
    for value in (3.0e-7, 0.9, 1.0, 1.01, 7.3, 1.2e5):
        assert value <= nice(value) * 1.002
        assert nice(value) <= 1.7 * value


@pytest.mark.parametrize("text", ["count =", "[skin]", 'kind = "line"\nkind = "line"', EXAMPLE.replace("[skin]", "")])
def test_a_text_that_is_no_file_is_said_as_the_files_error(text):
    """A page's link can hold anything: its errors are those of the file, and not of what parses it."""
    for edit in (lambda: edited(text, "skin.young", 1e5), lambda: DesignView(lambda: None).answer("edit", {
        "text": text, "key": "touch.force", "value": "1"}),
    ):  # fmt: skip
        with pytest.raises(SubskinError):
            edit()


def test_a_window_that_is_held_while_sensors_go_deep_is_drawn(view):
    deep = EXAMPLE.replace('depth = "2 mm"', 'depth = "80 mm"')
    window = window_of(finger_of(EXAMPLE).finger)
    said, fields = view.look(FingerState(text=deep), Look(window=window, moving=True))
    assert fields[0].size
    assert said["fields"][0]["most"] > 0
