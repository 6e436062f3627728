"""Each command does what it says, and the whole way from a raw recording to places holds together."""

import json
import math
import signal
import subprocess
import sys
from functools import partial

import numpy as np
import pytest

import subskin as ss
from subskin.io.finger_file import load
from subskin.io.tables import read_table

from .conftest import FINGER, ORIENTED

NO_OFFSET = ("--fit", "gain,depth,origin")  # presses cut from a recording have none: they are differences


def columns(path, *names):
    table = read_table(path)
    return [table.numbers(name) for name in names]


class TestSimulate:
    def test_readings_are_those_of_the_finger(self, subskin, folder):
        (folder / "finger.toml").write_text((folder / "finger.toml").read_text().replace("noise = 5", "noise = 0"))
        loads = ("--force", "10..60 N/m", "--angle", "-30..30 deg", "--position", "-9..9 mm", "--count", 200)
        ran = subskin("simulate", "finger.toml", "-o", "r.csv", "--contact", "hertz", "--half-width", "1 mm", *loads)
        assert (ran.code, ran.err) == (0, "")
        force, angle, position = columns("r.csv", "force", "angle", "position")
        for values, low, high in ((force, 10, 60), (angle, -math.pi / 6, math.pi / 6), (position, -9e-3, 9e-3)):
            assert low <= values.min() < low + 0.05 * (high - low)
            assert high >= values.max() > high - 0.05 * (high - low)
        finger = load("finger.toml").finger
        expected = finger.read(ss.Hertz(force=force, angle=angle, position=position, half_width=1e-3))
        np.testing.assert_allclose(read_table("r.csv").readings(["p0", "p1", "p2", "p3"]), expected, rtol=1e-12)

    def test_the_seed_decides(self, subskin, folder):
        for name, seed in (("a.csv", 1), ("b.csv", 1), ("c.csv", 2)):
            assert subskin("simulate", "finger.toml", "-o", name, "--count", 5, "--seed", seed).code == 0
        text = [(folder / name).read_text() for name in ("a.csv", "b.csv", "c.csv")]
        assert text[0] == text[1] != text[2]

    def test_grid_dead_and_spread(self, subskin, folder):
        ran = subskin(
            "simulate", "finger.toml", "-o", "r.csv", "--grid", "--count", 7, "--dead", "1,3", "--spread", 0.3
        )
        assert ran.code == 0
        position, p1, p3 = columns("r.csv", "position", "p1", "p3")
        np.testing.assert_allclose(position, np.linspace(-9e-3, 9e-3, 7), atol=1e-15)
        assert np.abs([p1 - 1e5, p3 - 1e5]).max() < 30  # six times the noise

    def test_table_for_people_and_json(self, subskin, folder):
        ran = subskin("simulate", "finger.toml", "--count", 3)
        assert (ran.code, "3 loads, 4 sensors" in ran.out) == (0, True)
        data = json.loads(subskin("simulate", "finger.toml", "--count", 3, "--json").out)
        assert (data["rows"], len(data["columns"]["p2"])) == (3, 3)
        csv = subskin("simulate", "finger.toml", "--count", 3, "-o", "-")
        assert csv.out.startswith("position,force,angle,p0")
        assert len(csv.out.splitlines()) == 4
        assert "3 loads" in csv.err


@pytest.fixture
def recorded(subskin, folder):
    """A recording of a finger that lies deeper than drawn, at 12.5 mm on the motor's axis, with a dead sensor."""
    real = (folder / "finger.toml").read_text().replace("5 mm", "5.6 mm", 1).replace("offset = 1e5", "offset = 2e5")
    (folder / "real.toml").write_text(real)
    options = ("--count", 41, "--origin", "12.5 mm", "--position", "1.5..23.5 mm", "--relaxation", 0.2)
    more = ("--drift", 20, "--dead", 2, "--spread", 0.2, "--seed", 3, "--recording")
    assert subskin("simulate", "real.toml", "-o", "raw.csv", *options, *more).code == 0
    return folder


class TestTheWholeWay:
    def test_from_a_raw_recording_to_positions(self, subskin, recorded):
        ran = subskin("segment", "finger.toml", "raw.csv", "-o", "presses.csv")
        assert (ran.code, ran.err) == (0, "")
        assert "41 presses" in ran.out
        np.testing.assert_allclose(*columns("presses.csv", "position"), np.linspace(1.5e-3, 23.5e-3, 41), atol=1e-9)

        drawn = (recorded / "finger.toml").read_text().replace("offset = 1e5", "offset = 0  # of a difference")
        (recorded / "finger.toml").write_text(drawn)
        ran = subskin("calibrate", "finger.toml", "presses.csv", "-o", "calibrated.toml", "--every", 2, *NO_OFFSET)
        assert (ran.code, ran.err) == (0, "")
        assert "dead: p2" in ran.out
        assert "R^2 0.999" in ran.out.split("held out")[0].splitlines()[-1]
        file = load("calibrated.toml")
        assert file.origin == pytest.approx(12.5e-3, abs=2e-5)
        shown = ran.out.split("origin")[1].split()  # to the second digit of its standard error
        assert shown[0] == f"{1e3 * file.origin:.{len(shown[1].partition('.')[2])}f}"
        np.testing.assert_allclose(file.finger.array.depth[0], 5.6e-3, rtol=5e-3)
        assert file.finger.array.gain[2] == 0
        text = (recorded / "calibrated.toml").read_text()
        assert text.startswith("# a finger of four sensors")
        assert 'dead = ["p2"]' in text

        options = ("--every", 2, "--skip-used", "--truth", "position")
        ran = subskin(
            "locate", "calibrated.toml", "presses.csv", "-o", "located.csv", *options, "--figure", "truth.png"
        )
        assert ran.code == 0
        assert ran.err == ""  # the calibration has shown which way round the sensors are
        assert "error of position" in ran.out
        assert (recorded / "truth.png").read_bytes()[:4] == b"\x89PNG"
        row, truth, error, force = columns("located.csv", "row", "truth", "error", "force")
        np.testing.assert_array_equal(row, np.arange(1, 41, 2))
        np.testing.assert_allclose(truth, columns("presses.csv", "position")[0][1::2], atol=1e-12)
        status = np.array(read_table("located.csv").texts("status"))
        ok = status == "ok"
        assert ok.sum() >= 17
        assert np.median(np.abs(error[ok])) < 0.04e-3
        assert np.abs(error[ok]).max() < 0.2e-3
        assert abs(error[ok].mean()) < 0.03e-3
        assert set(status[~ok]) <= {"ambiguous"}  # with p2 dead the last places are far from two live sensors
        np.testing.assert_allclose(force[ok], 1.0, rtol=0.05)  # multiples of the presses' load
        assert set(read_table("located.csv").texts("used")) == {"p0 p1 p3"}

    def test_the_origin_from_three_presses(self, subskin, recorded):
        drawn = (recorded / "finger.toml").read_text().replace("offset = 1e5", "offset = 0")
        (recorded / "finger.toml").write_text(drawn)
        subskin("segment", "finger.toml", "raw.csv", "-o", "presses.csv")
        subskin("calibrate", "finger.toml", "presses.csv", "-o", "calibrated.toml", "--every", 2, *NO_OFFSET)
        text = (recorded / "presses.csv").read_text().splitlines()
        header = text[0].split(",")
        at = header.index("position")
        moved = [text[0]]
        for line in text[1:]:
            cells = line.split(",")
            cells[at] = str(float(cells[at]) + 0.0401)  # the row was mounted elsewhere
            moved.append(",".join(cells))
        (recorded / "moved.csv").write_text("\n".join(moved) + "\n")
        ran = subskin(
            "calibrate", "calibrated.toml", "moved.csv", "-o", "today.toml", "--fit", "origin", "--rows", "5,20,35"
        )
        assert ran.code == 0
        before, after = load("calibrated.toml"), load("today.toml")
        assert after.origin - before.origin == pytest.approx(0.0401, abs=5e-5)
        np.testing.assert_array_equal(after.finger.array.gain, before.finger.array.gain)
        data = json.loads(
            subskin(
                "locate", "today.toml", "moved.csv", "--rows", "5,20,35", "--skip-used", "--truth", "position", "--json"
            ).out
        )
        assert abs(data["against_truth"]["ok"]["mean"]) < 0.05e-3
        assert data["against_truth"]["ok"]["count"] > 30

    def test_json_of_each_step(self, subskin, recorded):
        data = json.loads(subskin("segment", "finger.toml", "raw.csv", "-o", "presses.parquet", "--json").out)
        assert (data["presses"], len(data["columns"]["p0_std"])) == (41, 41)
        finger = (recorded / "finger.toml").read_text().replace("offset = 1e5", "")
        (recorded / "finger.toml").write_text(finger)
        data = json.loads(
            subskin("calibrate", "finger.toml", "presses.parquet", "--rows", "0-19,30", *NO_OFFSET, "--json").out
        )
        assert (data["touches"], data["held_out"], data["dead"]) == (21, 20, ["p2"])
        assert data["sensors"]["p2"] == {"state": "dead", "r2": None, "residual": 5.0}
        depth = next(p for p in data["parameters"] if p["name"] == "depth")
        assert depth["value"] == pytest.approx(5.6e-3, rel=5e-3)

    def test_without_a_depth_column(self, subskin, folder):
        positions = ("--count", 13, "--position", "-9..9 mm", "--drift", 20)
        subskin("simulate", "finger.toml", "-o", "raw.csv", "--recording", *positions)
        finger = (folder / "finger.toml").read_text()
        (folder / "finger.toml").write_text(finger.replace('press = { column = "z", unit = "1/320 mm" }\n', ""))
        ran = subskin("segment", "finger.toml", "raw.csv", "-o", "p.csv", "--before", "0.2 s")
        assert "13 presses" in ran.out
        assert "depth" not in read_table("p.csv").columns
        np.testing.assert_allclose(*columns("p.csv", "position"), np.linspace(-9e-3, 9e-3, 13), atol=1e-9)


class TestCalibrate:
    def test_loads_given_in_columns(self, subskin, folder):
        loads = ("--force", "10..60 N/m", "--angle", "-20..20 deg", "--count", 60, "--position", "-12..12 mm")
        subskin("simulate", "finger.toml", "-o", "r.csv", *loads)
        finger = (
            (folder / "finger.toml")
            .read_text()
            .replace("gain = -1e5", "gain = -7e4")
            .replace("offset = 1e5", "offset = 0")
        )
        (folder / "finger.toml").write_text(finger)
        fit = ("--fit", "gain,offset,depth,origin", "--force-column", "force", "--angle-column", "angle")
        ran = subskin("calibrate", "finger.toml", "r.csv", "-o", "c.toml", *fit)
        assert ran.code == 0
        array = load("c.toml").finger.array
        np.testing.assert_allclose(array.gain, -1e5, rtol=0.03)
        np.testing.assert_allclose(array.offset, 1e5, rtol=1e-4)

    def test_an_origin_that_is_not_fitted_is_kept(self, subskin, folder):
        (folder / "there.toml").write_text((folder / "finger.toml").read_text() + '[calibration]\norigin = "30 mm"\n')
        subskin("simulate", "there.toml", "-o", "r.csv", "--count", 40)
        subskin("calibrate", "there.toml", "r.csv", "-o", "c.toml", "--fit", "gain", "--force-column", "force")
        file = load("c.toml")
        assert file.origin == 30e-3
        np.testing.assert_allclose(file.finger.array.gain, -1e5, rtol=0.02)

    def test_what_cannot_be_reached_is_exit_code_1(self, subskin, folder):
        subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 40)
        ran = subskin("calibrate", "finger.toml", "r.csv", "-o", "c.toml", "--rows", "0")
        assert ran.code == 1
        assert ran.err.startswith("subskin: error: ")
        assert not (folder / "c.toml").exists()


class TestLocate:
    def test_status_used_and_rivals(self, subskin, folder):
        subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 6, "--grid")
        lines = (folder / "r.csv").read_text().splitlines()
        cells = [line.split(",") for line in lines]
        cells[1][5] = ""  # p2 of frame 0 is missing
        cells[2][3:] = ["nan", "nan", "nan", "100020"]  # one sensor is left
        cells[3][3:] = ["100001", "99999", "100000", "100002"]  # nothing presses
        cells[4][3:] = ["100500", "99000", "100500", "98000"]  # nothing that presses does this
        (folder / "r.csv").write_text("\n".join(",".join(c) for c in cells) + "\n")
        ran = subskin("locate", "finger.toml", "r.csv", "-o", "l.parquet", "--truth", "position")
        assert ran.code == 0
        table = read_table("l.parquet")
        status = table.texts("status")
        assert status[:4] == ["ok", "incomplete", "no_contact", "unexplained"]
        assert status[5] == "ok"
        assert table.texts("used")[:2] == ["p0 p1 p3", "p3"]
        position, std, error = (table.numbers(n) for n in ("position", "position_std", "error"))
        assert np.isnan(position[1:4]).all()
        assert abs(error[0]) < 6 * std[0]
        finger = load("finger.toml")
        found = finger.locator()(read_table("r.csv").readings(finger.names))
        np.testing.assert_array_equal(position, found.position)
        np.testing.assert_array_equal(table.numbers("second_chi2"), found.second.chi2)

    def test_what_is_said_of_the_errors_is_so(self, subskin, folder):
        subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 400, "--force", "5..60 N/m")
        ran = subskin("locate", "finger.toml", "r.csv", "--truth", "position", "--json")
        data = json.loads(ran.out)
        error = np.array([np.nan if e is None else e for e in data["columns"]["error"]])
        ok = np.array(data["columns"]["status"]) == "ok"
        for name, frames in (("ok", ok), ("placed", np.isfinite(error))):
            said, size = data["against_truth"][name], np.abs(error[frames])
            assert said["count"] == size.size > 300
            for share, key in ((0.5, "median"), (0.95, "percentile_95")):
                assert np.mean(size <= said[key]) == pytest.approx(share, abs=1.5 / size.size), key
            assert said["mean"] * size.size == pytest.approx(error[frames].sum(), rel=1e-9)
            assert size.max() == said["worst"] > said["percentile_95"] > said["median"] > 0
        shown = subskin("locate", "finger.toml", "r.csv", "--truth", "position").out
        row = next(line.split() for line in shown.splitlines() if line.strip().startswith("status ok"))
        said = data["against_truth"]["ok"]
        names = ("median", "percentile_95", "mean", "worst")
        assert [float(cell) for cell in row[-4:]] == pytest.approx([said[k] * 1e3 for k in names], rel=5e-3)

    def test_positions_are_on_the_axis_of_the_calibration(self, subskin, folder):
        leaning = (folder / "finger.toml").read_text().replace("friction = 0", "friction = 1")  # so there are rivals
        (folder / "finger.toml").write_text(leaning)
        (folder / "there.toml").write_text((folder / "finger.toml").read_text() + '[calibration]\norigin = "30 mm"\n')
        for name in ("finger", "there"):
            subskin("simulate", f"{name}.toml", "-o", f"{name}.csv", "--grid", "--count", 19)
            subskin("locate", f"{name}.toml", f"{name}.csv", "-o", f"{name}-found.csv", "--truth", "position")
        here, there = (read_table(f"{name}.csv") for name in ("finger", "there"))
        np.testing.assert_allclose(there.numbers("position"), here.numbers("position") + 30e-3)
        np.testing.assert_allclose(there.numbers("p1"), here.numbers("p1"), rtol=1e-12)
        here, there = (read_table(f"{name}-found.csv") for name in ("finger", "there"))
        for column in ("position", "second_position"):
            values = here.numbers(column)
            assert np.isfinite(values).sum() >= 5
            np.testing.assert_allclose(there.numbers(column), values + 30e-3, atol=1e-9)
        np.testing.assert_allclose(there.numbers("error"), here.numbers("error"), atol=1e-9)

    def test_chunks_make_no_difference(self, subskin, folder, monkeypatch):
        subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 57)
        subskin("locate", "finger.toml", "r.csv", "-o", "one.csv")
        monkeypatch.setattr("subskin.io._csv.BLOCK", 300)
        subskin("locate", "finger.toml", "r.csv", "-o", "many.csv")
        assert (folder / "one.csv").read_text() == (folder / "many.csv").read_text()

    def test_progress_is_shown_on_a_terminal(self, subskin, folder, monkeypatch):
        (folder / "finger.toml").write_text(FINGER + ORIENTED)
        subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 57)
        monkeypatch.setattr("subskin.io._csv.BLOCK", 300)
        assert subskin("locate", "finger.toml", "r.csv", "-o", "l.csv").err == ""
        assert "57/57" in subskin("locate", "finger.toml", "r.csv", "-o", "l.csv", terminal=True).err

    def test_no_frames(self, subskin, folder):
        (folder / "r.csv").write_text("p0,p1,p2,p3\n")
        ran = subskin("locate", "finger.toml", "r.csv", "-o", "l.csv")
        assert ran.code == 0
        assert (folder / "l.csv").read_text().startswith("row,position,force")

    def test_through_a_pipe(self, process, folder):
        made = process("simulate", "finger.toml", "--count", 4, "-o", "-")
        located = process("locate", "finger.toml", "-", "-o", "-", input=made.stdout)
        assert (located.returncode, len(located.stdout.splitlines())) == (0, 5)
        assert "status" in located.stderr


class TestFigures:
    def test_figures(self, subskin, folder):
        ran = subskin("figures", "-o", "out", "--only", "2,6", "--formats", "svg")
        assert ran.code == 0
        assert sorted(p.name for p in (folder / "out").iterdir()) == ["memo_figure_02.svg", "memo_figure_06.svg"]

    @pytest.mark.parametrize("wrong", [("--only", "5"), ("--only", "six"), ("--formats", "bmp")])
    def test_what_there_is_not(self, subskin, folder, wrong):
        ran = subskin("figures", "-o", "out", *wrong)
        assert (ran.code, ran.out, ran.err.count("\n")) == (2, "", 1)
        assert not (folder / "out").exists()


class TestProcess:
    def test_help_is_quick_and_every_command_has_examples(self, process):
        imports = "import sys; from subskin.cli import main; sys.exit(main(['--help']))"
        shown = subprocess.run(
            [sys.executable, "-X", "importtime", "-c", imports], check=False, capture_output=True, text=True
        )
        assert shown.returncode == 0
        loaded = {line.rsplit("|", 1)[1].strip() for line in shown.stderr.splitlines() if "|" in line}
        assert not loaded & {"numba", "matplotlib", "pint", "pydantic", "pyarrow", "scipy", "rich", "tomlkit"}
        for command in ("simulate", "segment", "calibrate", "locate", "figures"):
            assert command in shown.stdout
            text = process(command, "--help").stdout
            assert f"examples:\n  subskin {command}" in text

    def test_version(self, subskin):
        assert subskin("--version").out == f"subskin {ss.__version__}\n"

    @pytest.mark.parametrize("unbuffered", ["", "1"])
    def test_a_reader_that_goes_away(self, folder, monkeypatch, unbuffered):
        monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
        command = f"{sys.executable} -m subskin simulate finger.toml --count 100000 -o - | head -n 1"
        ran = subprocess.run(
            ["bash", "-c", command + "; exit ${PIPESTATUS[0]}"], check=False, capture_output=True, text=True
        )
        assert ran.stdout.startswith("position,")
        assert "Traceback" not in ran.stderr
        assert "Exception" not in ran.stderr
        assert ran.returncode == 141

    def test_stopped_with_ctrl_c(self, folder):
        """A command that waits for more of its input is stopped; nothing is written."""
        command = [sys.executable, "-m", "subskin", "locate", "finger.toml", "-", "-o", "l.csv"]
        pipe = subprocess.PIPE
        # where the tests themselves run in the background, the signal is ignored, and a child inherits that
        listen = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
        options = {"stdin": pipe, "stderr": pipe, "preexec_fn": listen}
        with subprocess.Popen(command, **options) as running:
            # a pipe holds a small part of it: when all is written, the command has begun to read
            running.stdin.write(b"p0,p1,p2,p3\n".ljust(2**20))
            running.stdin.flush()
            running.send_signal(signal.SIGINT)
            _, error = running.communicate(timeout=60)
        assert running.returncode in (130, -signal.SIGINT)  # a shell says 130 of both
        assert error.decode().strip() == "subskin: stopped"
        assert sorted(p.name for p in folder.iterdir()) == ["finger.toml"]
