"""Touches to learn from: what they are, their store, stopping and going on."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import subskin as ss
from subskin.contact import Cone, FlatPunch, Hertz, PointLoad, RoundHertz
from subskin.errors import FileError, InvalidValueError, WorkersError
from subskin.io import (
    cost_of_touches,
    load_touches,
    parse_finger,
    parse_touches,
    save_touches,
    shards_done,
    write_touches,
)
from subskin.synthetic import FAULTS, ContactShare, RandomTouches

from .._commands import subskin
from .._executors import Backwards, Dying

FINGER = "[skin]\nyoung = 4e5\n[sensors]\ncount = 4\npitch = 2e-3\ndepth = 2e-3\nnoise = 1e-4\n"
TOUCHES = """\
finger = "finger.toml"
touches = 2500
shard = 1000
seed = 7
[load]
force = ["5 N/m", "60 N/m"]
angle = ["-30 deg", "30 deg"]
noise = [0.5, 2]
[[contact]]
family = "line"
[[contact]]
family = "hertz"
share = 2
half_width = ["0.2 mm", "2 mm"]
[fault]
dead = 0.1
weak = 0.1
shifted = 0.1
"""


@pytest.fixture
def file():
    return parse_touches(TOUCHES, finger=parse_finger(FINGER))


def drawn(local, **options):
    skin = ss.HalfSpace(ss.Material(young=4e5)) if local else ss.HalfPlane(ss.Material(young=4e5))
    more = {"offset": 3.0, "gain": [-2.0, 5.0, 0.0, 1.0], "noise": [1e-3, 2e-3, 1e-3, 5e-3]}
    array = ss.SensorArray(y=[-2e-3, 0.0, 2e-3, 3e-3], z=[0.0, 1e-3, 0.0, 0.0] if local else 0.0, depth=2e-3, **more)
    names = ("point", "round_hertz", "cone") if local else ("line", "hertz", "punch")
    width = (0.3e-3, 1e-3)
    kinds = [ContactShare(names[0]), ContactShare(names[1], 2.0, width), ContactShare(names[2], 1.0, width)]
    more = {"azimuth": (-3.0, 3.0), "across": (-2e-3, 1e-3)} if local else {}
    given = {"position": (-3e-3, 3e-3), "angle": (0.1, 0.6), "shard": 2000, **more, **options}
    return RandomTouches(ss.Finger(skin, array), kinds, 4000, force=(1.0, 2.0), **given)


@pytest.mark.parametrize("local", [False, True])
def test_the_readings_are_those_of_the_parameters(local):
    touches = drawn(local, noise=(0.0, 0.0))
    readings, parameters, labels = touches.shard_of(1, 300)
    column = dict(zip(touches.parameters, parameters.T, strict=True))
    kinds = (PointLoad, RoundHertz, Cone) if local else (ss.LineLoad, Hertz, FlatPunch)
    drag = np.stack([column[n] for n in column if n.startswith("tangential")])
    force, angle = np.hypot(column["normal"], np.hypot(*np.resize(drag, (2, 300)))) if local else None, None
    if local:
        force = np.sqrt(column["normal"] ** 2 + (drag**2).sum(axis=0))
        load = {"azimuth": np.arctan2(drag[1], drag[0]), "position": parameters[:, :2]}
    else:
        force, load = np.hypot(column["normal"], drag[0]), {"position": column["position"]}
    angle = np.arccos(column["normal"] / force)
    for i, kind in enumerate(kinds):
        own = labels[:, 0] == i
        assert own.sum() > 30
        of = {name: values[own] for name, values in {**load, "force": force, "angle": angle}.items()}
        of |= {"half_width": column["half_width"][own]} if i else {}
        np.testing.assert_allclose(
            readings[own], touches.finger.read(kind(**of)), rtol=1e-6, atol=1e-9, equal_nan=False
        )
        assert (column["half_width"][own] > 0).all() == bool(i)
    # even over their ranges: mean and spread of a uniform draw, at 5 standard errors
    for values, (low, high) in (
        (force, (1.0, 2.0)),
        (angle, (0.1, 0.6)),
        (column[touches.parameters[0]], (-3e-3, 3e-3)),
    ):
        assert (low - 1e-9 <= values).all()
        assert (values <= high + 1e-9).all()
        assert abs(values.mean() - (low + high) / 2) < 5 * (high - low) / np.sqrt(12 * values.size)
    assert abs((labels[:, 0] == 1).mean() - 0.5) < 5 * np.sqrt(0.25 / 300)


def test_noise_and_faults():
    usual = {"faults": {"dead": 0.2, "weak": 0.3, "shifted": 0.4}, "noise": (0.5, 2.0)}
    quiet, touches = drawn(False, noise=(0.0, 0.0)), drawn(False, **usual)
    array = touches.finger.array
    clean, (readings, parameters, labels) = quiet.shard_of(0).readings, touches.shard_of(0)
    m, noise, fault, sensor = len(clean), parameters[:, -1], labels[:, 1], labels[:, 2]
    assert [abs((fault == i).mean() - p) < 5 * np.sqrt(p / m) for i, p in enumerate((0.1, 0.2, 0.3, 0.4))] == [True] * 4
    assert (sensor[fault == 0] == -1).all()
    assert set(sensor[fault > 0]) == {0, 1, 3}  # the third is dead anyway
    off = (readings - clean) / np.asarray(array.noise)
    faulty = np.arange(4) == sensor[:, None]
    z = np.where(faulty, np.nan, off / noise[:, None])
    assert abs(np.nanstd(z) - 1) < 5 / np.sqrt(2 * z.size)
    assert abs(np.nanmean(z)) < 5 / np.sqrt(z.size)

    def at(kind, values):
        rows = np.flatnonzero(fault == FAULTS.index(kind))
        return values[rows, sensor[rows]]

    assert np.abs(at("dead", (readings - 3.0) / np.asarray(array.noise))).max() < 2 * 5  # offset and noise alone
    moved = at("shifted", off)
    assert ((np.abs(moved) > 3 - 2 * 5) & (np.abs(moved) < 20 + 2 * 5)).all()
    assert np.abs(np.abs(moved).mean() - 11.5) < 1
    assert (moved > 0).mean() == pytest.approx(0.5, abs=0.1)
    left, size = at("weak", readings - 3.0), at("weak", clean - 3.0)
    slope = (left * size).sum() / (size * size).sum()
    assert 0.5 < slope < 0.7  # 0.3 to 0.9


def test_a_shard_is_drawn_by_its_own_seed():
    touches = drawn(False)
    again = replace(touches, count=3000).shard_of(1, 1000)
    for one, other in zip(touches.shard_of(1, 1000), again, strict=True):  # of a last shard that is smaller
        assert one.shape == other.shape
    assert touches.shard_of(1, 10).readings.tobytes() == touches.shard_of(1).readings[:10].tobytes()
    assert (touches.shard_of(0).readings != touches.shard_of(1).readings).any()
    assert (touches.shard_of(0).readings != replace(touches, seed=1).shard_of(0).readings).any()
    with pytest.raises(InvalidValueError, match="shard = 2"):
        touches.shard_of(2)


def whole(store):
    """Every file of a store."""
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def test_the_store_opens_in_xarray_to_the_last_bit(file, tmp_path):
    xarray, steps = pytest.importorskip("xarray"), []
    exact = replace(file, precision="double")
    assert save_touches(exact, tmp_path / "t.zarr", progress=steps.append).tolist() == [0, 1, 2]
    assert (steps[0], sorted(steps[1:])) == (0, [500, 1000, 1000])
    found = xarray.open_zarr(tmp_path / "t.zarr", chunks=None)
    assert found.readings.dims == ("touch", "sensor")
    assert found.sensor.values.tolist() == ["s0", "s1", "s2", "s3"]
    assert found.parameter.values.tolist() == list(file.touches.parameters)
    assert found.parameters.attrs["units"] == ["m", "N/m", "N/m", "m", ""]
    assert found.labels.attrs == {"contact": ["line", "hertz"], "fault": list(FAULTS)}
    for k in range(3):
        rows = file.touches.rows(k)
        for name, values in file.touches.shard_of(k)._asdict().items():
            assert found[name][rows.start : rows.stop].values.tobytes() == values.tobytes()
    save_touches(file, tmp_path / "single.zarr")
    single = xarray.open_zarr(tmp_path / "single.zarr", chunks=None)
    assert single.readings.values.tobytes() == found.readings.values.astype("f4").tobytes()
    force = single.parameters.sel(parameter="normal").values
    assert (force > 4).all()


def test_stopped_and_gone_on(file, tmp_path):
    save_touches(file, tmp_path / "one.zarr")

    def stop(count):
        if count:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):  # what had finished is kept
        save_touches(file, tmp_path / "two.zarr", executor=Backwards(3), progress=stop)
    assert whole(tmp_path / "one.zarr") == whole(tmp_path / "two.zarr")
    for expected in (1, 2):
        with pytest.raises(WorkersError, match="lost"):
            save_touches(file, tmp_path / "three.zarr", executor=Dying(1))
        assert shards_done(tmp_path / "three.zarr").tolist() == [k < expected for k in range(3)]
        # what a kill leaves: part of a file, and of a shard that is not done a file that is cut off
        (tmp_path / "three.zarr" / "readings" / "c" / "2").mkdir(exist_ok=True)
        (tmp_path / "three.zarr" / "readings" / "c" / "2" / "0").write_bytes(b"cut off")
        (tmp_path / "three.zarr" / "readings" / "c" / "2" / "0.abc.partial").write_bytes(b"cut")
    assert save_touches(file, tmp_path / "three.zarr").tolist() == [2]
    assert whole(tmp_path / "one.zarr") == whole(tmp_path / "three.zarr")


def test_workers_that_write_elsewhere_are_found_out(file, tmp_path):
    class Elsewhere(Dying):
        def submit(self, function, /, *arguments):
            return super().submit(int)

    with pytest.raises(WorkersError, match="workers have to write into the same folder"):
        save_touches(file, tmp_path / "t.zarr", executor=Elsewhere(3))
    assert not shards_done(tmp_path / "t.zarr").any()


def test_a_damaged_store_is_said(file, tmp_path):
    """Any byte of what the store says of itself, and of what is finished, changed or cut off: an error, or no harm."""
    store, rng = tmp_path / "touches.zarr", np.random.default_rng(0)
    save_touches(file, store)
    said = set()
    for path in (store / "zarr.json", store / "done" / "c" / "0"):
        whole = path.read_bytes()
        for at in (0, *rng.integers(len(whole), size=25)):
            for broken in (whole[:at], whole[:at] + bytes([whole[at] ^ 0x15]) + whole[at + 1 :]):
                path.write_bytes(broken)
                try:
                    save_touches(file, store)
                except FileError as error:
                    said.add(str(error).partition(":")[2][:14])
        path.write_bytes(whole)
    assert " it is damaged" in said


def test_shards_whose_files_are_lost_are_computed_again(file, tmp_path):
    store = tmp_path / "touches.zarr"
    save_touches(file, store)
    before = whole(store)
    (store / "readings" / "c" / "0" / "0").unlink()
    (store / "labels" / "c" / "2" / "0").write_bytes(b"")
    assert shards_done(store).tolist() == [False, True, False]
    assert save_touches(file, store).tolist() == [0, 2]
    assert whole(store) == before


def test_another_file_is_refused(file, tmp_path, monkeypatch):
    store, other = tmp_path / "t.zarr", parse_finger(FINGER.replace("1e-4", "2e-4"))
    small = parse_touches(TOUCHES.replace("2500", "100"), finger=file.finger)
    save_touches(small, store)
    same = parse_touches(
        f"# a remark\ntitle = 'Another'\n{small.text}", finger=parse_finger(f"{FINGER}[locate]\nfriction=0")
    )
    assert save_touches(same, store).size == 0
    for changed, said in (
        (file, "touches was 100 and is 2500"),
        (
            parse_touches(small.text.replace("0.5, 2", "0.5, 3"), finger=file.finger),
            r"load.noise was \[0.5, 2\] and is",
        ),
        (parse_touches(small.text, finger=other), "its finger.sensors.noise was 0.0001 and is 0.0002"),
        (parse_touches(small.text.replace("seed = 7\n", ""), finger=file.finger), "seed was 7 and is not there"),
    ):
        with pytest.raises(FileError, match=said):
            save_touches(changed, store)
    monkeypatch.setattr("subskin.io.touch_store.__version__", "9.9")
    with pytest.raises(FileError, match="began it, and this is 9"):
        save_touches(small, store)
    with pytest.raises(FileError, match="it holds no touches"):
        save_touches(small, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("touches = 2500", "touches = 0", 2, "touches = 0"),
        ("shard = 1000", "shard = 1500", 3, "a multiple of 1000"),
        ('family = "line"', 'family = "lime"', 10, 'family = "lime"'),
        ('family = "hertz"', 'family = "cone"', 9, "all have to be long"),
        ('"5 N/m", "60 N/m"', '"60 N/m", "5 N/m"', 6, "swap them"),
        ('"5 N/m", "60 N/m"', '"0 N/m", "5 N/m"', 6, "has to be > 0"),
        ('["-30 deg", "30 deg"]', '"95 deg"', 7, "has to be <= 1.5708"),
        ("noise = [0.5, 2]", 'across = "1 mm"', 8, "the same at every z"),
        ("share = 2", "share = 0", 13, "share = 0"),
        ("share = 2\nhalf", "half", 11, ""),
        ("dead = 0.1", "dead = 0.9", 15, "at most 1 together"),
        ("dead = 0.1", "deaf = 0.1", 16, 'did you mean "dead"'),
    ],
)
def test_what_is_wrong_is_said_with_its_line(old, new, line, said):
    text, finger = TOUCHES.replace(old, new), parse_finger(FINGER)
    assert text != TOUCHES
    if not said:
        assert parse_touches(text, finger=finger).touches.contacts[1].share == 1.0
        return
    with pytest.raises(FileError) as error:
        parse_touches(text, finger=finger)
    assert f"touches.toml, line {line}:" in str(error.value)
    assert said in str(error.value)


def test_forces_in_newtons_where_the_length_is_known():
    finger = parse_finger(f'{FINGER}[touch]\nlength = "20 mm"')
    file = parse_touches(TOUCHES.replace('"5 N/m", "60 N/m"', '"0.1 N", "60 N/m"'), finger=finger)
    assert file.touches.force == (5.0, 60.0)


def test_what_it_will_cost(file, tmp_path):
    save_touches(file, tmp_path / "t.zarr")
    cost = cost_of_touches(file)
    written = sum(p.stat().st_size for p in tmp_path.rglob("c/*/*"))
    assert (cost.touches, cost.shards, cost.measured) == (2500, 3, 1000)
    assert cost.size == pytest.approx(written, rel=0.1)
    assert 0 < cost.core_hours < 1


def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("touches.toml").write_text(subskin("touches", "--example").out)
    Path("finger.toml").write_text(FINGER)
    assert load_touches("touches.toml").touches.count == 1_000_000
    Path("touches.toml").write_text(TOUCHES)
    plan = json.loads(subskin("touches", "touches.toml", "--plan", "--json").out)
    assert (plan["touches"], plan["shards"]) == (2500, 3)
    assert "bytes a touch" in subskin("touches", "touches.toml", "--plan").out
    done = subskin("touches", "touches.toml", "-o", "t.zarr", terminal=True)
    assert (done.code, done.out.splitlines()[0]) == (0, "2500 touches, 4 sensors -> t.zarr")
    assert "2500/2500" in done.err
    again = json.loads(subskin("touches", "touches.toml", "-o", "t.zarr", "--json").out)
    assert (again["shards"], again["computed"]) == (3, 0)
    monkeypatch.setattr("subskin.cli.touches.io.save_touches", Mock(side_effect=KeyboardInterrupt))
    stopped = subskin("touches", "touches.toml", "-o", "t.zarr")
    said = "subskin: stopped; 3 of 3 shards are in t.zarr, the same command goes on from there\n"
    assert (stopped.code, stopped.err) == (130, said)
    for module, command in (("zarr", ("--plan",)), ("distributed", ("-o", "t.zarr", "--dask", "local"))):
        monkeypatch.setitem(sys.modules, module, None)
        missing = subskin("touches", "touches.toml", *command)
        assert missing.code == 2
        assert f'pip install "subskin[{"touches" if module == "zarr" else "dask"}]"' in missing.err


@pytest.mark.long
def test_killed_at_any_moment(file, tmp_path):
    (tmp_path / "finger.toml").write_text(FINGER)
    text = TOUCHES.replace("2500", "60_000")
    (tmp_path / "touches.toml").write_text(text)
    save_touches(parse_touches(text, finger=file.finger), tmp_path / "whole.zarr")
    command = [sys.executable, "-m", "subskin", "touches", "touches.toml", "-o", "killed.zarr"]
    rng, done = np.random.default_rng(0), []
    for _ in range(8):
        run = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        before = time.monotonic()
        while not (tmp_path / "killed.zarr").exists() and time.monotonic() < before + 60:
            time.sleep(0.01)
        time.sleep(rng.uniform(0.0, 1.0))
        run.kill()
        run.communicate()
        done.append(int(shards_done(tmp_path / "killed.zarr").sum()))
        if done[-1] == 60:
            break
    assert done == sorted(done)
    assert 0 < done[0] or len(set(done)) > 1
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=True).returncode == 0
    assert whole(tmp_path / "killed.zarr").keys() == whole(tmp_path / "whole.zarr").keys()
    for name, data in whole(tmp_path / "whole.zarr").items():
        if not name.endswith("zarr.json"):
            assert (tmp_path / "killed.zarr" / name).read_bytes() == data, name


@pytest.mark.parametrize("ending", ["parquet", "csv"])
def test_one_table_holds_the_touches_of_the_store(file, tmp_path, ending):
    """Each in its row, however the shards come out of the threads; readings, parameters, and names of the labels."""
    told = []
    write_touches(file, tmp_path / f"touches.{ending}", workers=3, progress=told.append)
    assert sum(told) == 2500
    table = ss.io.read_table(tmp_path / f"touches.{ending}")
    shards = [file.touches.shard_of(k) for k in range(file.touches.shards)]
    readings, parameters, labels = (np.concatenate(each) for each in zip(*shards, strict=True))
    single = {"rtol": 1e-6, "atol": 1e-12}
    found = np.stack([table.numbers(name) for name in file.finger.names], axis=-1)
    np.testing.assert_allclose(found, readings, **single)
    found = np.stack([table.numbers(name) for name in file.touches.parameters], axis=-1)
    np.testing.assert_allclose(found, parameters, **single)
    assert [str(v) for v in table.texts("contact")] == [("line", "hertz")[k] for k in labels[:, 0]]
    assert [str(v) for v in table.texts("fault")] == [FAULTS[k] for k in labels[:, 1]]
    sensors = [*file.finger.names, ""]
    assert [str(v) for v in table.texts("faulty_sensor")] == [sensors[k] for k in labels[:, 2]]


def test_the_command_writes_a_table(tmp_path):
    (tmp_path / "finger.toml").write_text(FINGER)
    (tmp_path / "touches.toml").write_text(TOUCHES)
    run = subskin("touches", tmp_path / "touches.toml", "-o", tmp_path / "touches.parquet")
    assert run.code == 0, run.err
    assert "2500 touches, 4 sensors -> " in run.out
    refused = subskin("touches", tmp_path / "touches.toml", "-o", tmp_path / "missing" / "touches.csv")
    assert refused.code != 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["finger.toml", "touches.parquet", "touches.toml"]
