"""What a finger file means by numbers without their unit, and how a slip of the writer is answered."""

import warnings
from importlib.resources import files

import pytest

from subskin.errors import FileError, ValidityWarning
from subskin.io import parse_finger, parse_goals, read_table

GOOD = """\
[skin]
young = "0.4 MPa"
[sensors]
count = 4
pitch = "3 mm"
depth = "2 mm"
noise = 1e-4
"""
LAYERS = GOOD.replace('young = "0.4 MPa"', 'kind = "layers"\n[[skin.layers]]\nyoung = "0.4 MPa"\nthickness = {}')
ROUND = GOOD.replace('young = "0.4 MPa"', 'kind = "round"\nyoung = "0.4 MPa"\nradius = {}\ncore_radius = {}')
RIDGES = GOOD.replace("[sensors]", "[skin.ridges]\npitch = {}\nheight = {}\n[sensors]")
FORCE = """\
[recording]
sensors = ["a", "b", "c", "d"]
force = { column = "cell"UNIT }
[touch]
length = "20 mm"
"""


def said(text):
    """The finger of the text, and the warnings on the way."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        file = parse_finger(text)
    assert {each.category for each in caught} <= {ValidityWarning}
    return file, [str(each.message) for each in caught]


@pytest.mark.parametrize(
    ("text", "seen"),
    [
        (LAYERS.format("6"), "thickness = 6 m: if 6 mm was meant, write 0.006"),
        (ROUND.format("8", "3"), "radius of [skin] = 8 m: if 8 mm"),
        (RIDGES.format("1", "0.1"), "pitch of ridges = 1 m: if 1 mm"),
        (GOOD + "[tip]\nradius = 9", "radius of [tip] = 9 m: if 9 mm"),
        (GOOD + "[touch]\nlength = 20", "length of [touch] = 20 m: if 20 mm was meant, write 0.02"),
    ],
)
def test_millimetres_without_a_unit_are_said_once(text, seen):
    _, told = said(text)
    assert [seen in each for each in told] == [True]


def test_millimetres_and_megapascals_all_through_the_file_are_said():
    bare = GOOD.replace('"0.4 MPa"', "0.4").replace('"3 mm"', "3").replace('"2 mm"', "2")
    _, told = said(bare)
    assert len(told) == 2
    assert "young = 0.4 Pa: if 0.4 MPa was meant" in told[0]
    assert "depth = 2 m: if 2 mm was meant" in told[1]
    assert said(bare.replace("0.4", "1"))[1] == []  # units of one's own


@pytest.mark.parametrize(
    "text",
    [
        GOOD + '[touch]\nlength = "20 mm"\n[tip]\nradius = "9 mm"',
        LAYERS.format('"6 mm"'),
        ROUND.format('"8 mm"', '"3 mm"'),
        RIDGES.format('"1 mm"', '"0.1 mm"'),
    ],
)
def test_sizes_of_fingers_pass_in_silence(text):
    assert said(text)[1] == []


def test_a_load_cell_says_whether_it_reads_newtons():
    with pytest.raises(FileError, match=r'line 10: \[recording.force\] .*N or in N/m.*unit = "N"'):
        parse_finger(GOOD + FORCE.replace("UNIT", ""))
    assert parse_finger(GOOD + FORCE.replace("UNIT", ', unit = "N"')).recording.force.scale == 50.0


def test_what_stands_twice_is_said():
    for more in ("noise = 2e-4\n", '[skin]\nyoung = "1 MPa"\n'):
        with pytest.raises(FileError, match=r"may stand once\. Fix: leave out one") as caught:
            parse_finger(GOOD + more)
        assert "line 8" in str(caught.value)


def test_brackets_without_end_are_said():
    with pytest.raises(FileError, match="nested too deep"):
        parse_finger("a = " + "[" * 5000 + "]" * 5000)


@pytest.mark.parametrize("written", ['"4"', "4.0"])
def test_a_count_is_a_whole_number(written):
    with pytest.raises(FileError, match=r"a whole number is needed\. Fix: write count = 4\."):
        parse_finger(GOOD.replace("count = 4", f"count = {written}"))


@pytest.mark.parametrize("start", [b"PK\x03\x04", b"\xd0\xcf\x11\xe0"])
def test_a_spreadsheet_is_called_that(tmp_path, start):
    path = tmp_path / "raw.csv"
    path.write_bytes(start + bytes(range(256)))
    with pytest.raises(FileError, match=r"spreadsheet.*Fix: export it as CSV"):
        read_table(path)


@pytest.mark.parametrize(
    ("old", "new", "seen"),
    [
        ('young = "0.4 MPa"\n', "young = 0.4\n", "young = 0.4 Pa: if 0.4 MPa"),
        ('thickness = "5 mm"', "thickness = 5", "thickness = 5 m: if 5 mm"),
        ('position = "0.2 mm"', "position = 0.2", "position of [accuracy] = 0.2 m: if 0.2 mm"),
        ('angle = "4 deg"', "angle = 4", "angle of [accuracy] = 4 rad: if 4 deg was meant, write 0.0698132"),
        ('depth = ["0.8 mm", "4 mm"]', "depth = [0.8, 4]", "depth = 4 m: if 4 mm"),
        ('longest_row = "14 mm"', "longest_row = 14", "longest_row = 14 m: if 14 mm"),
        ('width = "0.3 mm"', "width = 0.3", "width of [[sensor]] = 0.3 m: if 0.3 mm"),
        ('feature = "3 mm"', "feature = 3", "feature = 3 m: if 3 mm"),
    ],
)
def test_goals_without_units_are_said_once(old, new, seen):
    text = files("subskin.io").joinpath("goals_example.toml").read_text()
    assert text.count(old) == 1
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parse_goals(text)
        assert not caught
        parse_goals(text.replace(old, new))
    assert [seen in str(each.message) for each in caught] == [True]
