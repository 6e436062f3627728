"""Whatever is in a file: either it is used, or the documented error comes, and nothing is written."""

import math
import string

import numpy as np
import pytest
import tomlkit
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from subskin.cli import main
from subskin.errors import FileError
from subskin.io.finger_file import parse_finger
from subskin.io.tables import write_table

from .conftest import FINGER

QUICK = settings(
    max_examples=75, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
FEW = settings(QUICK, max_examples=60)

UNITS = st.sampled_from(
    ["mm", "m", "kPa", "deg", "", "%", "N/m", "mmm", "°C", "m**9", "kg*m/s**2", "/", "1", "dB", "Δ"]
)
VALUES = st.one_of(
    st.none().map(lambda _: ""),
    st.booleans(),
    st.integers(-(10**20), 10**20),
    st.floats(),
    st.text(max_size=12),
    st.builds(lambda x, u: f"{x} {u}", st.floats(allow_nan=False), UNITS),
    st.lists(st.one_of(st.floats(), st.text(max_size=4), st.just("2 mm")), max_size=5),
    st.dictionaries(
        st.sampled_from(["column", "unit", "x"]), st.one_of(st.text(max_size=4), st.just("mm")), max_size=2
    ),
    st.datetimes(),
)


def exit_code(*arguments):
    try:
        return main([str(a) for a in arguments])
    except SystemExit as leave:
        return leave.code


@st.composite
def changed_files(draw):
    """The good file with some values, keys and tables changed."""
    document = tomlkit.parse(FINGER)
    for _ in range(draw(st.integers(1, 3))):
        table = document[draw(st.sampled_from(list(document)))]
        if not isinstance(table, dict) or not table:
            continue
        action = draw(st.sampled_from(["value", "value", "value", "rename", "remove", "add", "table"]))
        key = draw(st.sampled_from(list(table)))
        if action == "value":
            table[key] = draw(VALUES)
        elif action == "rename":
            table[draw(st.text(string.ascii_lowercase, min_size=1, max_size=6))] = table[key]
        elif action == "remove":
            del table[key]
        elif action == "add":
            known = ["y", "width", "high", "resolution", "exact", "kind", "centre", "plane", "early", "hold", "origin"]
            table[draw(st.sampled_from(known))] = draw(VALUES)
        else:
            document[draw(st.sampled_from(["skin", "locate", "calibration", "other"]))] = draw(VALUES)
    return tomlkit.dumps(document)


@QUICK
@pytest.mark.filterwarnings("ignore::subskin.errors.ValidityWarning")  # of a unit that was lost
@given(text=changed_files())
def test_a_changed_finger_file(text):
    file = parsed(text)
    if file is None:
        return
    array = file.finger.array
    assert len(file.names) == len(array)
    assert (np.asarray(array.depth) > 0).all()
    assert np.isfinite(array.y).all()
    assert math.isfinite(file.origin)
    again = parse_finger(file.with_finger(file.finger, 1e-3).text)
    assert again.origin == 1e-3
    for name in ("y", "depth", "gain", "offset", "noise", "low", "high"):
        np.testing.assert_array_equal(getattr(again.finger.array, name), getattr(array, name))


def parsed(text):
    """The file, or None where it is refused as documented."""
    try:
        return parse_finger(text)
    except FileError as error:
        said = str(error)
    assert said.startswith("finger.toml")
    return None


@QUICK
@given(at=st.integers(0, len(FINGER)), piece=st.binary(max_size=6), cut=st.integers(0, 30))
def test_a_finger_file_with_other_bytes(tmp_path, at, piece, cut):
    path, out = tmp_path / "finger.toml", tmp_path / "out.csv"
    data = FINGER.encode()
    path.write_bytes(data[:at] + piece + data[at + cut :])
    out.unlink(missing_ok=True)
    code = exit_code("simulate", path, "-o", out, "--count", 2)
    assert code in (0, 2)
    assert out.exists() == (code == 0)


TABLE = "position,p0,p1,p2,p3\n" + "".join(
    f"{1e-3 * (i - 6):.3f},{1e5 + 900 / (1 + (i - 2) ** 2):.2f},{1e5 + 900 / (1 + (i - 6) ** 2):.2f},1e5,{1e5 - i}\n"
    for i in range(13)
)


@FEW
@given(at=st.integers(0, len(TABLE)), piece=st.binary(max_size=6), cut=st.integers(0, 300), command=st.booleans())
def test_a_table_with_other_bytes(tmp_path, at, piece, cut, command):
    data = TABLE.encode()
    run(tmp_path, data[:at] + piece + data[at + cut :], "r.csv", command)


@FEW
@given(cells=st.lists(st.lists(st.text(max_size=4), max_size=6), max_size=5), command=st.booleans())
def test_a_table_of_anything(tmp_path, cells, command):
    text = "position,p0,p1,p2,p3\n" + "\n".join(",".join(row) for row in cells)
    run(tmp_path, text.encode("utf-8", errors="replace"), "r.csv", command)


@FEW
@given(data=st.data(), command=st.booleans())
def test_a_parquet_file_with_other_bytes(tmp_path, data, command):
    rows = np.arange(13.0)
    write_table(tmp_path / "good.parquet", dict.fromkeys(("position", "p0", "p1", "p2", "p3"), rows))
    whole = (tmp_path / "good.parquet").read_bytes()
    if data.draw(st.booleans()):
        broken = whole[: data.draw(st.integers(0, len(whole)))]
    else:
        at = data.draw(st.integers(0, len(whole) - 1))
        broken = whole[:at] + data.draw(st.binary(min_size=1, max_size=4)) + whole[at + 4 :]
    run(tmp_path, broken, "r.parquet", command)


def run(folder, data, name, calibrate):
    """Calibrate or locate on the bytes; only the documented ends are allowed."""
    (folder / "finger.toml").write_text(FINGER)
    (folder / name).write_bytes(data)
    out = folder / ("out.toml" if calibrate else "out.csv")
    out.unlink(missing_ok=True)
    if calibrate:
        code = exit_code("calibrate", folder / "finger.toml", folder / name, "-o", out, "--fit", "gain,offset")
    else:
        code = exit_code("locate", folder / "finger.toml", folder / name, "-o", out)
    assert code in ((0, 1, 2) if calibrate else (0, 2))
    assert out.exists() == (code == 0)
    assert not [p for p in folder.iterdir() if p.name.endswith(".part")]
