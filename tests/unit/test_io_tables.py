"""Tables come back as they were written; what is wrong with one is said with its line and column."""

import os
import stat
import warnings

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from subskin.errors import FileError, InvalidValueError, ValidityWarning
from subskin.io.files import replacing, write_bytes
from subskin.io.tables import read_table, write_table, writing


def table_of(folder, text, name="t.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path)


def message(folder, text, columns=("a", "b"), name="t.csv", **options):
    def use():
        table = table_of(folder, text, name)
        for column in columns:
            table.numbers(column, **options)

    with pytest.raises(FileError) as caught:
        use()
    return str(caught.value)


@pytest.mark.parametrize("suffix", ["csv", "parquet", "pq"])
def test_written_and_read_again(tmp_path, suffix):
    rng = np.random.default_rng(2)
    gap = np.where(rng.random(50) < 0.5, np.nan, 1.5)
    columns = {"x": rng.normal(size=50) * 1e-7, "n, of": np.arange(50), "gap": gap}
    path = tmp_path / f"t.{suffix}"
    write_table(path, columns | {"word": ['o"k', "no, contact"] * 25})
    table = read_table(path)
    assert table.columns == ("x", "n, of", "gap", "word")
    for name, values in columns.items():
        np.testing.assert_array_equal(table.numbers(name), values)
    assert table.texts("word")[:2] == ['o"k', "no, contact"]
    assert not table.numbers("x").flags.writeable


def test_an_empty_cell_is_a_missing_reading(tmp_path):
    table = table_of(tmp_path, "a,b,c\n1,,nan\n,2,NA\n")
    expected = [[1, np.nan, np.nan], [np.nan, 2, np.nan]]
    np.testing.assert_array_equal(table.readings(["a", "b", "c"]), expected)


@pytest.mark.parametrize("text", ["a,b\r\n1,2\r\n", "\ufeffa,b\n1,2\n", "a, b \n 1, 2\n", "a,b\n\n1,2\n\n"])
def test_harmless_differences(tmp_path, text):
    np.testing.assert_array_equal(table_of(tmp_path, text).readings(["a", "b"]), [[1, 2]])


def test_a_last_line_that_does_not_end_is_said(tmp_path):
    """Where a copy stopped within the last number, a shorter number is read."""
    with pytest.warns(ValidityWarning, match="t.csv: its last line does not end"):
        table = table_of(tmp_path, "a,b\n1,2.5\n1,2.")
    np.testing.assert_array_equal(table.readings(["a", "b"]), [[1, 2.5], [1, 2]])


def test_a_table_of_names_alone_has_no_rows(tmp_path):
    for text in ("a,b\n", "a,b"):
        table = table_of(tmp_path, text)
        assert table.readings(["a", "b"]).shape == (0, 2)
        assert table.numbers("a", finite=True).shape == (0,)


def test_bad_tables(tmp_path):
    assert 't.csv, line 3: column "b" holds "x7"' in message(tmp_path, "a,b\n1,2\n3,x7\n")
    assert 'line 6: column "b" holds "y"' in message(tmp_path, "a,b\n1,2\n\n\n3,4\n5,y\n")
    assert 'line 4: column "b" holds "x"' in message(tmp_path, "a,b\n1,\n2,NA\n3,x\n")
    assert "is empty" in message(tmp_path, "")
    assert "is empty" in message(tmp_path, "\n\n")
    assert "line 3: 1 cell where the header has 2: the file ends in the middle" in message(tmp_path, "a,b\n1,2\n3")
    assert "line 3: 1 cell where the header has 2: every line" in message(tmp_path, "a,b\n1,2\n3\n4,5\n")
    assert "line 2: 3 cells where the header has 2: every line" in message(tmp_path, "a,b\n1,2,3\n4,5\n")
    said = message(tmp_path, "a,B,c\n1,2,3\n")
    assert 'no column "b"' in said
    assert 'did you mean "B"' in said
    assert "the columns are a, B, c" in said
    assert "separated by commas" in message(tmp_path, "a;b\n1;2\n")
    assert "the first line has to name the columns" in message(tmp_path, "1,2\n3,4\n")
    assert 'two columns are called "a"' in message(tmp_path, "a,a\n1,2\n")
    assert "line 3: the file has to be text in UTF-8" in message(tmp_path, b"a,b\n1,2\n\xff,3\n")
    assert 'column "b" holds "true"' in message(tmp_path, "a,b\n1,true\n")
    with pytest.raises(FileError, match="there is no such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(FileError, match="cannot be read"):
        read_table(tmp_path)


def test_a_position_has_to_be_a_number_in_every_row(tmp_path):
    for cell in ("", "nan", "inf"):
        said = message(tmp_path, f"a,b\n1,2\n3,{cell}\n", finite=True, why="the touches' place")
        assert 'line 3: column "b" = ' in said
        assert "the touches' place has to be a number in every row" in said


def test_a_parquet_file_that_is_cut_off(tmp_path):
    path = tmp_path / "t.parquet"
    write_table(path, {"a": np.arange(1000.0), "b": np.arange(1000.0)})
    whole = path.read_bytes()
    for length in (5, len(whole) // 2, len(whole) - 1):
        assert "footer" in message(tmp_path, whole[:length], name="cut.parquet")
    assert "no Parquet file" in message(tmp_path, "a,b\n1,2\n", name="csv.parquet")
    pq.write_table(pa.table({"a": [1.0, 2.0], "b": ["3", "x"]}), path)
    said = message(tmp_path, path.read_bytes(), name="t.parquet")
    assert 't.parquet, row 2: column "b" holds "x"' in said


def test_nothing_is_left_half_written(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("before")

    def stopped():
        with replacing(path) as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        stopped()
    assert path.read_text() == "before"
    with pytest.raises(InvalidValueError, match="equal"):
        write_table(path, {"a": [1.0], "b": [1.0, 2.0]})
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]
    write_table(path, {"a": [1.0]})
    assert path.read_text() == "a\n1.0\n"
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]


def test_permissions_links_and_folders(tmp_path):
    path, link = tmp_path / "t.csv", tmp_path / "link.csv"
    write_bytes(path, b"1")
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~_mask()
    path.chmod(0o640)
    link.symlink_to(path)
    write_bytes(link, b"2")
    assert link.is_symlink()
    assert path.read_bytes() == b"2"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    with pytest.raises(FileError, match="is a folder"):
        write_bytes(tmp_path, b"")
    with pytest.raises(FileError, match=r"there is no folder .*mkdir -p"):
        write_bytes(tmp_path / "no" / "t.csv", b"")
    write_bytes(os.devnull, b"into nothing")
    assert not os.path.isfile(os.devnull)  # noqa: PTH113


def _mask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


def test_a_missing_value_in_a_single_column_keeps_its_row(tmp_path):
    write_table(tmp_path / "one.csv", {"s0": np.array([1.0, np.nan, 3.0, np.nan])})
    np.testing.assert_array_equal(read_table(tmp_path / "one.csv").numbers("s0"), [1.0, np.nan, 3.0, np.nan])


def test_few_rows_at_a_time_make_few_groups_of_rows(tmp_path):
    """The footer of a Parquet file, which is kept in memory, grows with its groups of rows."""
    rows = np.arange(50_000.0)
    with writing(tmp_path / "t.parquet") as table:
        for block in np.split(rows, 500):
            table.write({"a": block})
    assert pq.ParquetFile(tmp_path / "t.parquet").num_row_groups == 3
    np.testing.assert_array_equal(read_table(tmp_path / "t.parquet").numbers("a"), rows)


@pytest.mark.parametrize(
    "rows",
    [
        "1,2.5,ok,\n-0.0,1e-300,no contact,7\n", "1,nan,,\n, 2 ,a,NA\n", "9007199254740993,0.1,1,1\n3,.5,1.,+1\n",
        "inf,-inf,true,2024-01-01\n1,2,false,2024-01-02\n", "1,2,3,4",
    ],
)  # fmt: skip
def test_arrow_reads_what_the_other_readers_read(tmp_path, monkeypatch, rows):
    pytest.importorskip("pyarrow")
    (tmp_path / "a.csv").write_text(f"a,b,c,d\n{rows}")
    tables = []
    for large in (0, np.inf):
        monkeypatch.setattr("subskin.io._csv.LARGE", large)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            (part,) = read_table(tmp_path / "a.csv").parts
        tables.append(part)
    one, other = tables
    assert (one.count, list(one.lines)) == (other.count, list(other.lines))
    for mine, its in zip(one.values, other.values, strict=True):
        assert type(mine) is type(its)
        np.testing.assert_array_equal(mine, its)


def test_arrow_leaves_it_to_others_to_say_what_is_wrong(tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    monkeypatch.setattr("subskin.io._csv.LARGE", 0)
    (tmp_path / "a.csv").write_text("a,b\n1,2\n1,2,3\n")
    with pytest.raises(FileError, match="line 3: 3 cells where the header has 2"):
        read_table(tmp_path / "a.csv")
