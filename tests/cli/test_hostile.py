"""Careless and hostile use of the commands: outputs that are inputs, streams that are closed, signals, odd text."""

import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest

from subskin.errors import FileError
from subskin.io.files import apart
from subskin.io.tables import read_table, reading, write_table, writing

from .conftest import FINGER, ORIENTED


@pytest.fixture
def readings(subskin, folder):
    """Sixty frames."""
    assert subskin("simulate", "finger.toml", "-o", "r.csv", "--count", 60).code == 0
    (folder / "finger.toml").write_text(FINGER + ORIENTED)
    return folder


class TestOutputsThatAreInputs:
    @pytest.mark.parametrize("way", ["name", "spelling", "symlink", "hard link", "absolute"])
    def test_the_recording_is_not_replaced(self, subskin, readings, way):
        out = {"name": "r.csv", "spelling": "./x/../r.csv", "absolute": str(readings / "r.csv")}.get(way, "l.csv")
        (readings / "x").mkdir()
        if way == "symlink":
            (readings / "l.csv").symlink_to("r.csv")
        if way == "hard link":
            os.link("r.csv", "l.csv")
        before = (readings / "r.csv").read_bytes()
        for command in ("locate", "fit", "decide", "pressure"):
            ran = subskin(command, "finger.toml", "r.csv", "-o", out)
            assert (ran.code, ran.out) == (2, "")
            assert ran.err.startswith(f"subskin: error: -o {out}: it is the same file as the readings")
        assert (readings / "r.csv").read_bytes() == before

    def test_every_command_refuses(self, subskin, readings):
        before = {p.name: p.read_bytes() for p in readings.iterdir()}
        for arguments in (
            ("simulate", "finger.toml", "-o", "finger.toml"),
            ("segment", "finger.toml", "r.csv", "-o", "finger.toml"),
            ("segment", "finger.toml", "r.csv", "-o", "r.csv"),
            ("calibrate", "finger.toml", "r.csv", "-o", "finger.toml"),
            ("calibrate", "--blind", "finger.toml", "r.csv", "-o", "r.csv"),
            ("pressure", "finger.toml", "r.csv", "--totals", "r.csv"),
            ("pressure", "finger.toml", "r.csv", "-o", "b.csv", "--totals", "./b.csv"),
            ("pressure", "finger.toml", "r.csv", "-o", "-", "--totals", "-"),
            ("locate", "finger.toml", "r.csv", "-o", "a.png", "--truth", "position", "--figure", "a.png"),
        ):
            ran = subskin(*arguments)
            assert ran.code == 2, arguments
            assert "it is the same file as" in ran.err, arguments
        assert {p.name: p.read_bytes() for p in readings.iterdir()} == before

    def test_what_else_is_written(self, subskin, readings):
        for arguments in (
            ("pressure", "finger.toml", "r.csv", "-o", "a.gif", "--movie", "a.gif"),
            ("pressure", "finger.toml", "r.csv", "--movie", "r.csv"),
            ("check", "finger.toml", "--map", "a.png", "--tip-map", "./a.png"),
            ("live", "finger.toml", "--record", "finger.toml"),
        ):
            ran = subskin(*arguments)
            assert (ran.code, "it is the same file as" in ran.err) == (2, True), arguments

    def test_devices_and_streams_may_be_named_twice(self):
        apart({"a": "-", "b": "/dev/null"}, {"c": "-", "d": "/dev/null"})
        with pytest.raises(FileError, match="it is the same file as c"):
            apart({}, {"c": "/nowhere/x", "d": "/nowhere/./x"})


class TestBlocks:
    @pytest.mark.parametrize(
        ("command", "kind"),
        [("locate", "csv"), ("locate", "parquet"), ("fit", "parquet"), ("decide", "csv"), ("pressure", "csv")],
    )
    def test_the_same_however_the_table_is_cut(self, subskin, readings, monkeypatch, command, kind):
        """In blocks of a few rows, and with rows chosen, all that comes out is the same."""
        table = read_table("r.csv")
        write_table(f"t.{kind}", {name: table.numbers(name)[:9] for name in table.columns})
        runs = []
        for cut in (False, True):
            if cut:
                monkeypatch.setattr("subskin.io._csv.BLOCK", 200)
                monkeypatch.setattr("subskin.io._parquet.ROWS", 2)
                monkeypatch.setattr("subskin.cli.pressure._AT_ONCE", 3)
            ran = subskin(command, "finger.toml", f"t.{kind}", "-o", f"{cut}.csv")
            some = subskin(command, "finger.toml", f"t.{kind}", "--json", "--rows", "1-3,7")
            shown = subskin(command, "finger.toml", f"t.{kind}", "--every", "3")
            assert (ran.code, ran.err, some.err) == (0, "", "")
            runs.append(((readings / f"{cut}.csv").read_text(), some.out, shown.out))
        assert runs[0] == runs[1]
        frames = json.loads(runs[0][1])
        rows = frames.get("columns", frames.get("totals"))["row"]
        assert rows == [1, 2, 3, 7]

    def test_a_fault_in_the_last_block_leaves_nothing(self, subskin, readings, monkeypatch):
        monkeypatch.setattr("subskin.io._csv.BLOCK", 400)
        with (readings / "r.csv").open("a") as file:
            file.write("0,1,2,x,4,5,6\n")
        for out in ("o.csv", "-"):
            ran = subskin("locate", "finger.toml", "r.csv", "-o", out)
            assert (ran.code, ran.out) == (2, "")
            assert 'r.csv, line 62: column "p0" holds "x"' in ran.err
        ran = subskin("locate", "finger.toml", "r.csv", "-o", "o.csv", "--rows", "3,99")
        assert ran.code == 2
        assert sorted(p.name for p in readings.iterdir()) == ["finger.toml", "r.csv"]

    def test_rows_beyond_the_table_are_refused_at_its_end(self, subskin, readings):
        ran = subskin("locate", "finger.toml", "r.csv", "-o", "o.csv", "--rows", "3,60")
        assert ran.code == 2
        assert "--rows 60: the table has rows 0 to 59" in ran.err
        assert sorted(p.name for p in readings.iterdir()) == ["finger.toml", "r.csv"]

    def test_time_that_goes_back_between_blocks(self, subskin, readings, monkeypatch):
        table = read_table("r.csv")
        time = np.arange(60.0)
        time[30] = 28.5
        write_table("t.csv", {"time": time} | {name: table.numbers(name) for name in table.columns})
        for block in (10**6, 500):
            monkeypatch.setattr("subskin.io._csv.BLOCK", block)
            ran = subskin("locate", "finger.toml", "t.csv", "--tare")
            assert ran.code == 2
            assert "t.csv, line 32: time = 28.5 s: time must not go back (it was 29 s)" in ran.err


PIECES = ["1", "-2.5e-3", "", "nan", "x", '"a\nb"', '"1"', " 3 ", "1_0", "٣", '"', "true", "[1]", "1e999", "\r", "é"]


def test_blocks_are_cut_where_rows_end(tmp_path, monkeypatch):
    """Whatever cells hold, the table is the same in blocks of 1 to 40 bytes as whole."""
    rng = np.random.default_rng(0)
    for _ in range(60):
        rows = [",".join(rng.choice(PIECES[:10], 3)) for _ in range(rng.integers(0, 8))]
        ends = rng.choice(["\n", "\r\n"], len(rows) + 1)
        text = "".join(a + b for a, b in zip(["a,b,c", *rows], ends, strict=True))
        path = tmp_path / "t.csv"
        path.write_bytes(text.encode())
        seen = []
        for block in (10**6, 1, 7, 40):
            monkeypatch.setattr("subskin.io._csv.BLOCK", block)
            table = read_table(path)
            seen.append([[table.position(i) for i in range(len(table))]])
            for name in "abc":
                try:
                    seen[-1].append(table.numbers(name).tolist())
                except FileError as error:
                    seen[-1].append(str(error))
        assert all(str(one) == str(seen[0]) for one in seen)


@pytest.mark.parametrize("cell", PIECES)
def test_a_cell_is_a_number_or_an_error_with_its_line(tmp_path, cell):
    (tmp_path / "t.csv").write_bytes(f"a,b\n1,2\n3,{cell}\n".encode())
    numbers = {"1": 1.0, "-2.5e-3": -2.5e-3, '"1"': 1.0, " 3 ": 3.0, "1e999": np.inf}
    numbers |= dict.fromkeys(("", "nan", "\r"), np.nan)
    if cell in numbers:
        np.testing.assert_array_equal(read_table(tmp_path / "t.csv").numbers("b"), [2.0, numbers[cell]])
        return
    with pytest.raises(FileError, match=r"t.csv, line [34]"):
        read_table(tmp_path / "t.csv").numbers("b")


class TestStreams:
    """In processes of their own, by a shell."""

    @staticmethod
    def run(command):
        """In a shell, as by default: what is written waits in a buffer."""
        text = f"{sys.executable} -m subskin {command}"
        usual = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
        return subprocess.run(["bash", "-c", text], check=False, capture_output=True, text=True, timeout=120, env=usual)

    def test_closed_and_full(self, readings):
        for command, code, said in (
            ("simulate finger.toml -o o.csv --count 3 >&- 2>&-", 0, ""),
            ("simulate finger.toml -o - --count 3 >&-", 2, "standard output: it is closed"),
            ("simulate finger.toml --json --count 3 >&-", 2, "standard output: it is closed"),
            ("simulate finger.toml -o - --count 3 > /dev/full", 2, "standard output: it cannot be written"),
            ("simulate finger.toml --count 3 > /dev/full", 2, "standard output: it cannot be written"),
            ("--help > /dev/full", 2, "standard output: it cannot be written"),
            ("locate finger.toml - <&-", 2, "standard input: it"),
        ):
            ran = self.run(command)
            assert ran.returncode == code, (command, ran)
            assert "Traceback" not in ran.stderr
            assert "Exception" not in ran.stderr
            assert said in ran.stderr, command
        assert len(read_table("o.csv")) == 3
        with pytest.raises(FileError, match="/dev/full: it cannot be written"):
            write_table("/dev/full", {"a": [1.0]})
        with pytest.raises(FileError, match=r"/proc/x.csv: it cannot be written"):
            write_table("/proc/x.csv", {"a": [1.0]})

    def test_whoever_reads_has_enough(self, readings):
        """The code of a closed pipe, and not that of no result; the table is there."""
        reader, writer = os.pipe()
        os.close(reader)
        command = [sys.executable, "-m", "subskin", "locate", "finger.toml", "r.csv", "-o", "l.csv"]
        ran = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, check=False, timeout=120)
        os.close(writer)
        assert (ran.returncode, ran.stderr) == (141, b"")
        assert len(read_table("l.csv")) == 60

    @pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
    def test_a_signal_in_the_middle_leaves_nothing(self, readings, number, code):
        """The output has been begun: its temporary file is there when the signal comes, and gone afterwards."""
        command = [sys.executable, "-m", "subskin", "locate", "finger.toml", "-", "-o", "l.csv"]
        listen = partial(signal.signal, number, signal.SIG_DFL)
        pipe = subprocess.PIPE
        options = {"stdin": pipe, "stderr": pipe, "stdout": pipe, "preexec_fn": listen}
        with subprocess.Popen(command, **options) as running:
            running.stdin.write(b"p0,p1,p2,p3\n" + b"1e5,1e5,1e5,1e5\n" * 50)
            running.stdin.flush()
            for _ in range(600):
                if any(p.name.endswith(".part") for p in readings.iterdir()):
                    break
                time.sleep(0.1)
            else:
                pytest.fail("no output was begun")
            running.send_signal(number)
            _, error = running.communicate(timeout=60)
        # a shell says `code` of both: Python ends itself by the signal where that came in code run from a text, as a
        # dataclass is made (unhandled_keyboard_interrupt), although it was caught
        assert running.returncode in (code, -number)
        assert error.decode().strip() == "subskin: stopped"
        assert sorted(p.name for p in readings.iterdir()) == ["finger.toml", "r.csv"]

    @pytest.mark.parametrize("wait", [0.25, 0.6])
    def test_stopped_while_it_imports(self, readings, wait):
        program = "import sys; from subskin.cli import main; print('.', flush=True); sys.exit(main(sys.argv[1:]))"
        command = [sys.executable, "-c", program, "locate", "finger.toml", "r.csv", "-o", "l.csv"]
        listen = partial(signal.signal, signal.SIGINT, signal.default_int_handler)
        pipe = subprocess.PIPE
        options = {"stderr": pipe, "stdout": pipe, "preexec_fn": listen}
        with subprocess.Popen(command, **options) as running:
            assert running.stdout.read(2) == b".\n"
            time.sleep(wait)
            running.send_signal(signal.SIGINT)
            _, error = running.communicate(timeout=60)
        assert running.returncode in (130, -signal.SIGINT, 0), error.decode()  # 0: it was quicker
        assert error.decode().strip() in ("subskin: stopped", "")


@pytest.mark.parametrize(
    ("interrupt", "code"), [(KeyboardInterrupt(), 130), (sys.modules["subskin.cli.main"]._Ended(signal.SIGTERM), 143)]
)
def test_an_interrupt_that_an_import_turned_into_another_error(monkeypatch, subskin, interrupt, code):
    def stopped(*_):
        try:
            raise interrupt
        except KeyboardInterrupt:
            raise ImportError("cannot import name") from None

    monkeypatch.setattr(sys.modules["subskin.cli.main"], "_run", stopped)
    out = subskin("figures")
    assert (out.code, out.err) == (code, "subskin: stopped\n")


def test_stopped_before_the_command_line_is_there(monkeypatch, capsys):
    from subskin.__main__ import run

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("subskin.cli.main", stopped)
    assert run() == 130
    assert capsys.readouterr().err == "subskin: stopped\n"


def test_what_a_terminal_would_obey_is_not_shown(subskin, readings):
    escape = "\x1b]0;pwn\x07\x1b[31m"
    (readings / "e.csv").write_text(f"{escape}p0,p1\n1,2\n")
    (readings / "e.toml").write_text((readings / "finger.toml").read_text().replace("noise", '"\\u001b[31mx"'))
    (readings / "n.toml").write_text((readings / "finger.toml").read_text().replace('"p0"', '"\\u001b[31mp0"'))
    lines = (readings / "r.csv").read_text().replace("p0", "\x1b[31mp0", 1)
    (readings / "n.csv").write_text(lines)
    for arguments in (
        ("locate", "finger.toml", "e.csv"),
        ("locate", "e.toml", "r.csv"),
        ("locate", f"{escape}.toml", "r.csv"),
        ("locate", "finger.toml", "r.csv", "--truth", escape),
        ("simulate", "n.toml", "--count", "3"),
        ("calibrate", "n.toml", "n.csv"),
    ):
        ran = subskin(*arguments)
        assert "\x1b" not in ran.out + ran.err, arguments
        assert "\x07" not in ran.out + ran.err, arguments
        assert len(ran.err) < 3000


def test_long_values_are_shortened(subskin, readings):
    text = (readings / "finger.toml").read_text()
    for name, change in {
        "key": text + "\n" + "k" * 10**6 + " = 1\n",
        "search": text.replace('["-12 mm", "12 mm"]', str([1] * 10**5)),
        "dots": text + "\n" + ".".join(["a"] * 5000) + " = 1\n",
        "keys": text + "\n" + "\n".join(f"k{i} = 1" for i in range(10_000)),
        "wide": text.replace("noise = 5", 'noise = 5\nwidth = "1 m"'),
        "layers": '[skin]\nkind = "layers"\n' + '[[skin.layers]]\nyoung = 1e5\nthickness = "1 mm"\n' * 100
        + text[text.index("[sensors]"):],
    }.items():  # fmt: skip
        (readings / "long.toml").write_text(change)
        begin = time.perf_counter()
        ran = subskin("simulate", "long.toml", "-o", "x.csv")
        assert ran.code == 2, name
        assert len(ran.err) < 1000, name
        assert "Traceback" not in ran.err
        assert time.perf_counter() - begin < 20, name


def test_limits_of_a_table_are_said(tmp_path):
    path = tmp_path / "t.csv"

    def said(header, row="1"):
        path.write_text(f"{header}\n{row}\n")
        with pytest.raises(FileError) as caught:
            read_table(path)
        return str(caught.value)

    names = [f"c{i}" for i in range(10_001)]
    assert "10001 columns: at most 10000" in said(",".join(names), ",".join("1" * 10_001))
    assert 'two columns are called "c3"' in said(",".join([*names[:9_000], "c3"]), ",".join("1" * 9_001))
    assert "the name of column 2 has 2000 letters" in said("a," + "h" * 2000, "1,2")
    assert "a line of more than 4 MB" in said("h" * 9_000_000)
    assert "a byte that is 0" in said("a,b", "1,\0")
    path.write_bytes("a,b\n1,2\n".encode("utf-16-le"))
    with pytest.raises(FileError, match="line 1: a byte that is 0: the file has to be text in UTF-8"):
        read_table(path)


def test_a_spreadsheet_runs_nothing(tmp_path):
    cells = ["=cmd|' /C calc'!A0", "+1", "-x", "@a", "\t=1", "ok", "a,=b", '"=']
    write_table(tmp_path / "t.csv", {"name": np.array(cells, dtype=object), "x": np.arange(-4.0, 4.0)})
    lines = (tmp_path / "t.csv").read_text().splitlines()[1:]
    assert [line[:2] for line in lines[:5]] == ["'=", "'+", "'-", "'@", "'\t"]
    assert lines[5].startswith("ok,")
    assert lines[6:] == ['"a,=b",2.0', '"""=",3.0']
    assert read_table(tmp_path / "t.csv").numbers("x").tolist() == list(np.arange(-4.0, 4.0))  # numbers stay numbers


def test_damage_of_a_parquet_file_is_said(tmp_path):
    """Each byte of the pages is covered by a checksum: none is read with other numbers, unless it is as before."""
    path, values = tmp_path / "t.parquet", np.random.default_rng(0).normal(size=300)
    write_table(path, {"a": values})
    whole = path.read_bytes()
    for at in range(4, len(whole) - 8, 37):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        try:
            read = read_table(path).numbers("a")
        except FileError:
            continue
        np.testing.assert_array_equal(read, values)


def test_without_pyarrow(tmp_path, monkeypatch):
    """CSV needs none of it; Parquet says how to install it."""
    program = (
        "import sys; sys.modules['pyarrow'] = None\n"
        "from subskin.io.tables import read_table, write_table\n"
        "write_table('t.csv', {'a': [1.0, 2.5], 'b': ['x', 'y']})\n"
        "assert read_table('t.csv').numbers('a').tolist() == [1.0, 2.5]\n"
        "open('t.parquet', 'wb').write(b'PAR1' + bytes(20) + b'PAR1')\n"
        "for use in (lambda: read_table('t.parquet'), lambda: write_table('u.parquet', {'a': [1.0]})):\n"
        "    try: use()\n"
        "    except ValueError as error: print(error)\n"
    )
    ran = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True, cwd=tmp_path)
    assert ran.stdout.count('which is not installed. Fix: pip install "subskin[parquet]"') == 2
    assert sorted(p.name for p in tmp_path.iterdir()) == ["t.csv", "t.parquet"]


def test_a_table_in_blocks_is_written_whole_or_not_at_all(tmp_path):
    path = tmp_path / "t.csv"

    def stopped():
        with writing(path) as table:
            table.write({"a": [1.0]})
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert list(tmp_path.iterdir()) == []

    def other_columns():
        with writing(path) as table:
            table.write({"a": [1.0]})
            table.write({"b": [1.0]})

    with pytest.raises(ValueError, match="the table has a"):
        other_columns()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_memory_does_not_grow_with_the_table(tmp_path, monkeypatch, kind):
    """A table that is read and written in blocks is never held (tracemalloc sees NumPy's arrays too)."""
    import tracemalloc

    monkeypatch.setattr("subskin.io._csv.BLOCK", 20_000)
    monkeypatch.setattr("subskin.io._parquet.ROWS", 500)
    peaks = []
    for count in (4, 40):
        with writing(tmp_path / f"t.{kind}") as table:
            for _ in range(count):
                table.write({f"s{i}": np.arange(500.0) for i in range(8)})
        tracemalloc.start()
        with reading(tmp_path / f"t.{kind}") as blocks, writing(tmp_path / f"o.{kind}") as out:
            rows = 0
            for block in blocks:
                out.write({"s1": block.numbers("s1")})
                rows += len(block)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert rows == 500 * count
    assert peaks[1] < 1.5 * peaks[0]


def test_what_a_library_says_to_programmers_is_left_out(capsys):
    from subskin.cli.main import _warns
    from subskin.errors import ValidityWarning

    warn = _warns()
    warn("'oneOf' deprecated", DeprecationWarning)
    for _ in range(2):  # from two lines of code
        warn("a depth of 2 m", ValidityWarning)
    assert capsys.readouterr().err == "subskin: warning: a depth of 2 m\n"
