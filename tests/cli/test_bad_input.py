"""Each kind of bad input gives one clear message on the error stream, exit code 2, and nothing written."""

import numpy as np
import pytest

from subskin.cli.main import main
from subskin.io.tables import write_table

TABLE = "time,x,z,position,p0,p1,p2,p3\n" + "".join(
    f"{0.02 * i:.2f},0,{z},0.00{i % 3},{1e5 + z},{1e5 + i},{1e5 - i},{1e5}\n"
    for i, z in enumerate([0] * 60 + [300] * 60 + [0] * 30)
)
COMMANDS = {
    "segment": ("segment", "finger.toml", "t.csv"),
    "calibrate": ("calibrate", "finger.toml", "t.csv"),
    "locate": ("locate", "finger.toml", "t.csv", "--truth", "position"),
}
EVERY = pytest.mark.parametrize("command", COMMANDS)


@pytest.fixture
def refused(subskin, folder):
    """Runs a command that has to refuse, and returns its message."""

    def run(command, *more):
        before = {p.name: p.read_bytes() for p in folder.iterdir()}
        arguments = COMMANDS[command] if isinstance(command, str) else command
        ran = subskin(*arguments, "-o", "out.csv", *more)
        assert ran.code == 2, ran
        assert ran.out == ""
        assert ran.err.startswith("subskin: error: ")
        assert ran.err.count("\n") == 1
        assert "Traceback" not in ran.err
        assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
        return ran.err.removeprefix("subskin: error: ").strip()

    return run


@pytest.fixture
def written(folder):
    """Writes the table and the finger, each with a change."""

    def write(table=TABLE, finger=None):
        (folder / "t.csv").write_text(table)
        if finger is not None:
            old, new = finger
            text = (folder / "finger.toml").read_text()
            assert old in text
            (folder / "finger.toml").write_text(text.replace(old, new))

    return write


def test_the_table_itself_is_good(subskin, written):
    written()
    for name in ("segment", "locate"):
        assert subskin(*COMMANDS[name], "-o", "out.csv").code == 0


@EVERY
class TestFingerFile:
    def test_negative_depth(self, refused, written, command):
        written(finger=('"5 mm"', '"-5 mm"'))
        said = refused(command)
        assert said == (
            'finger.toml, line 8: [sensors] depth = "-5 mm": has to be > 0 [m]. Fix: depth is measured into the skin.'
        )

    def test_poisson_beyond_a_half(self, refused, written, command):
        written(finger=('young = "0.4 MPa"', 'young = "0.4 MPa"\npoisson = 0.6'))
        assert refused(command).startswith("finger.toml, line 4: [skin] poisson = 0.6: has to be <= 0.5")

    def test_unknown_unit(self, refused, written, command):
        written(finger=('"6 mm"', '"6 mmm"'))
        said = refused(command)
        assert said.startswith('finger.toml, line 7: [sensors] pitch: unit "mmm": no unit "mmm" is known')
        assert 'did you mean "mm"' in said

    def test_unknown_key(self, refused, written, command):
        written(finger=("depth", "dept"))
        assert 'line 8: [sensors] key "dept": no such key is known. Fix: did you mean "depth"' in refused(command)

    def test_empty(self, refused, folder, written, command):
        written()
        (folder / "finger.toml").write_text("")
        assert refused(command).startswith("finger.toml is empty")

    def test_cut_off(self, refused, folder, written, command):
        written()
        text = (folder / "finger.toml").read_text()
        (folder / "finger.toml").write_text(text[: text.index('"p2"') + 2])
        assert refused(command).startswith("finger.toml, line 18: not TOML")

    def test_missing(self, refused, folder, written, command):
        written()
        (folder / "finger.toml").unlink()
        assert refused(command).startswith("finger.toml: there is no such file")

    def test_wrong_count_of_sensors(self, refused, written, command):
        written(finger=("count = 4", "count = 3"))
        said = refused(command)
        assert said.startswith("finger.toml, line 18: [recording] sensors names 4 columns")
        assert "each of the 3 sensors" in said


@EVERY
class TestReadings:
    def test_missing_column(self, refused, written, command):
        written(TABLE.replace("p2", "P2", 1))
        said = refused(command)
        assert said.startswith('t.csv, line 1: there is no column "p2"')
        assert "the columns are time, x, z, position, p0, p1, P2, p3" in said
        assert 'did you mean "P2"' in said

    def test_text_in_a_number(self, refused, written, command):
        lines = TABLE.splitlines()
        lines[20] = lines[20].replace("100000.0", "1OOOOO", 1)
        written("\n".join(lines) + "\n")
        assert refused(command).startswith('t.csv, line 21: column "p0" holds "1OOOOO": a number is needed')

    def test_empty(self, refused, written, command):
        written("")
        assert refused(command).startswith("t.csv is empty")

    def test_cut_off(self, refused, written, command):
        written(TABLE[: TABLE.rindex("100000.0") - 10])
        said = refused(command)
        assert said.startswith("t.csv, line 151:")
        assert "the file ends in the middle of a line" in said

    def test_parquet_cut_off(self, refused, folder, written, command):
        written()
        names = TABLE.splitlines()[0].split(",")
        write_table("t.parquet", {name: np.zeros(50) for name in names})
        whole = (folder / "t.parquet").read_bytes()
        (folder / "t.parquet").write_bytes(whole[: len(whole) // 2])
        arguments = [a.replace("t.csv", "t.parquet") for a in COMMANDS[command]]
        assert refused(arguments).startswith("t.parquet: it ends in the middle")

    def test_too_few_cells(self, refused, written, command):
        lines = TABLE.splitlines()
        lines[5] = lines[5].rsplit(",", 1)[0]
        written("\n".join(lines) + "\n")
        assert refused(command).startswith("t.csv, line 6: 7 cells where the header has 8")

    def test_semicolons_and_decimal_commas(self, refused, written, command):
        written(TABLE.replace(",", ";").replace(".", ","))
        said = refused(command)
        assert said.startswith('t.csv: a single column "time;x;z;')
        assert "separated by commas, and decimals by points" in said

    def test_no_header(self, refused, written, command):
        written(TABLE.split("\n", 1)[1].replace("0.00,", "0.07,", 1))
        said = refused(command)
        assert said.startswith("t.csv, line 1: ")

    def test_missing_file(self, refused, folder, command):
        assert refused(command).startswith("t.csv: there is no such file")


class TestPlaces:
    @pytest.mark.parametrize("command", ["calibrate", "locate"])
    @pytest.mark.parametrize("cell", ["", "nan", "inf"])
    def test_a_true_position_that_is_no_number(self, refused, written, command, cell):
        lines = TABLE.splitlines()
        lines[7] = lines[7].replace("0.000", cell)
        written("\n".join(lines) + "\n")
        assert refused(command).startswith('t.csv, line 8: column "position" = ')

    @pytest.mark.parametrize("column", ["time", "x", "z"])
    def test_a_track_with_a_gap(self, refused, written, column):
        lines = [line.split(",") for line in TABLE.splitlines()]
        lines[7][lines[0].index(column)] = "nan"
        written("\n".join(map(",".join, lines)) + "\n")
        assert refused("segment").startswith(f't.csv, line 8: column "{column}" = nan')

    def test_time_that_goes_back(self, refused, written):
        written(TABLE.replace("\n0.20,", "\n0.02,"))
        assert refused("segment").startswith("t.csv: time[10] = 0.02 s: time must not go back")

    def test_no_press(self, refused, written):
        written(TABLE.replace(",300,", ",0,"))
        assert refused("segment").startswith("t.csv: no plateau of the indenter's depth")

    def test_no_recording_table(self, refused, folder, written):
        written()
        text = (folder / "finger.toml").read_text()
        (folder / "finger.toml").write_text(text[: text.index("[recording]")])
        assert "no table [recording]" in refused("segment")


class TestOptions:
    @pytest.mark.parametrize(
        "options",
        [
            ("--count", "0"),
            ("--count", "999999999999"),
            ("--force", "40 kg"),
            ("--force", "-1 N/m"),
            ("--force", "50..40 N/m"),
            ("--position", "a..b"),
            ("--position", "1..2..3 mm"),
            ("--contact", "hertz"),
            ("--dead", "4"),
            ("--dead", "a"),
            ("--spread", "1"),
            ("--seed", "-1"),
            ("--recording", "--rate", "0 Hz"),
            ("--recording", "--hold", "1e9 s"),
            ("--recording", "--relaxation", "2"),
            ("--recording", "--force", "1..2 N/m"),
        ],
    )
    def test_simulate(self, refused, options):
        refused(("simulate", "finger.toml"), *options)

    @pytest.mark.parametrize("rows", [("--every", "0"), ("--rows", "1,x"), ("--rows", "999"), ("--rows", "5-2")])
    @pytest.mark.parametrize("command", ["calibrate", "locate"])
    def test_rows(self, refused, written, command, rows):
        written()
        refused(command, *rows)

    def test_others(self, refused, written):
        written()
        refused("locate", "--skip-used")
        refused(("locate", "finger.toml", "t.csv"), "--figure", "x.png")
        refused("locate", "--figure", "x.bmp")
        refused("calibrate", "--fit", "gain,depht")
        refused("calibrate", "--fit", ",")
        refused("calibrate", "--position-column", "place")
        refused("segment", "--early", "2")
        refused("segment", "--hold", "1 kg")

    def test_a_finger_without_noise_cannot_locate(self, refused, written):
        written(finger=("noise = 5", "noise = 0"))
        assert "finger.toml: noise = 0 of sensor 0" in refused("locate")

    def test_usage(self, subskin, folder):
        for arguments in (
            (),
            ("locat",),
            ("simulate", "finger.toml", "--contact", "finger", "--half-width", "1 mm"),
            ("locate",),
            ("locate", "a", "b", "--every", "x"),
            ("simulate", "f", "--json", "-o", "-"),
        ):
            ran = subskin(*arguments)
            assert ran.code == 2
            assert "Traceback" not in ran.err
            assert ran.err

    def test_a_folder_that_is_not_there(self, subskin, folder):
        ran = subskin("simulate", "finger.toml", "-o", "no/r.csv")
        assert (ran.code, ran.out) == (2, "")
        assert "there is no folder no. Fix: mkdir -p no." in ran.err


def test_a_missing_reading_is_not_bad_input(subskin, written, folder):
    """A NaN in the stream costs that sensor in that frame, not the frame, and not the run."""
    written(TABLE.replace("100000.0\n", "\n", 3))
    for name in ("segment", "locate"):
        assert subskin(*COMMANDS[name], "-o", "out.csv").code == 0


def test_a_table_without_rows_is_said(subskin, refused, written):
    written(TABLE[: TABLE.index("\n") + 1])
    assert refused("calibrate").startswith("readings of shape (0, 4): a finger learns from touches")
    ran = subskin("fit", "finger.toml", "t.csv", "-o", "out.csv")
    assert (ran.code, ran.err) == (0, "subskin: warning: t.csv has no rows\n")
    assert "any family would explain" not in ran.out


def test_a_misspelt_option_shows_the_usage_of_its_command(capsys):
    with pytest.raises(SystemExit) as left:
        main(["replay", "rec.parquet", "--fingr", "other.toml"])
    err = capsys.readouterr().err
    assert left.value.code == 2
    assert err.startswith("usage: subskin replay")
    assert "unrecognized arguments: --fingr other.toml; did you mean --finger?" in err
