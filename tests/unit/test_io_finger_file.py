"""finger.toml: what it says, how a wrong one is refused, and that writing keeps the user's comments."""

from dataclasses import replace

import numpy as np
import pytest

import subskin as ss
from subskin.errors import FileError
from subskin.io.finger_file import load, parse_finger, save_finger
from subskin.skin import Ridged
from subskin.transducer import kinds

GOOD = """\
# my finger
[skin]
young = "0.4 MPa"   # soft
poisson = 0.5

[sensors]
count = 4
pitch = "6 mm"
depth = "5 mm"      # a guess
kind = "normal_strain"
noise = 12
offset = ["1 kPa", 0, 3, 4]
low = "-1 psi"

[locate]
friction = 0
search = ["-10 mm", "10 mm"]

[recording]
sensors = ["a", "b", "c", "d"]
unit = "kPa"
position = { column = "x", unit = "1e-3 mm" }
press = { column = "z", unit = "1/320 mm" }
early = 0.3
"""
LAST = "early = 0.3\n"


def test_what_a_file_says():
    file = parse_finger(GOOD)
    array = file.finger.array
    assert file.finger.skin == ss.HalfPlane(ss.Material(0.4e6, 0.5))
    np.testing.assert_allclose(array.y, [-9e-3, -3e-3, 3e-3, 9e-3], rtol=1e-15)
    np.testing.assert_array_equal(array.depth, 5e-3)
    np.testing.assert_array_equal(array.noise, 12.0)
    np.testing.assert_array_equal(array.offset, [1000.0, 0.0, 3.0, 4.0])
    np.testing.assert_allclose(array.low, -6894.757293, rtol=1e-9)
    assert np.isinf(array.high).all()
    assert file.names == ("a", "b", "c", "d")
    assert file.search == (-10e-3, 10e-3)
    assert file.options == {"friction": 0.0}
    assert file.recording.scale == 1000.0
    assert file.recording.position.scale == 1e-6
    assert file.recording.press.scale == pytest.approx(1e-3 / 320, rel=1e-15)
    assert (file.recording.time.name, file.recording.early, file.recording.before) == ("time", 0.3, 0.3)
    assert file.origin == 0.0


def test_a_file_says_how_its_stream_is_read():
    """Counts in Pa, relaxation undone, drift taken off, a load with the options of [locate]."""
    text = GOOD.replace("noise = 12", 'noise = 12\ngain = "-100 kPa"')
    text += '[relaxation]\nshare = [0.1, "5 %"]\ntime = ["500 ms", 6]\n[tare]\ndrift = "0.002 kPa/s"\n'
    file = parse_finger(text)
    pipeline = file.pipeline(file.locator())
    assert list(pipeline.stages) == ["units", "relaxation", "tare", "found"]
    np.testing.assert_array_equal(pipeline.stages["tare"].drift, 2.0)
    np.testing.assert_array_equal(file.pipeline(drift=3.0).stages["tare"].drift, 3.0)
    kernel = ss.Relaxation([0.1, 0.05], [0.5, 6.0])
    time = np.arange(0.0, 8.0, 0.02)
    pressed = np.clip(4 * (time - 3.0), 0, 1)
    clean = file.finger.read(ss.LineLoad(40.0 * pressed, 0.0, 2e-3), np.random.default_rng(0))
    out = pipeline(kernel.apply(clean, time) / 1000, time)
    np.testing.assert_allclose(out["relaxation"], clean, rtol=1e-9)
    held = pressed == 1
    assert (out["found"].status[held] == ss.Status.OK).all()
    assert out["found"].position[held].mean() == pytest.approx(2e-3, abs=5e-5)
    assert (out["found"].angle[held] == 0).all()  # friction = 0, as [locate] says


def test_a_file_says_which_board_reads_it(tmp_path):
    table = '[live]\nport = "demo"\nchannels = ["d", "c", "b", "a"]\n'
    live = parse_finger(GOOD + table + 'driver = "anyskin"\nunit = ["Pa", "hPa", "0.5 Pa", "kPa"]').live
    assert (live.port, dict(live.driver), live.channels) == ("demo", {"name": "anyskin"}, ("d", "c", "b", "a"))
    assert live.scale.tolist() == [1.0, 100.0, 0.5, 1000.0]
    assert parse_finger(GOOD).live is None
    assert parse_finger(GOOD + table).live.scale.tolist() == 4 * [1000.0]  # the unit of [recording]
    (tmp_path / "finger.toml").write_text(GOOD + '[live]\ndriver = "board.toml"')
    assert load(tmp_path / "finger.toml").live.driver["name"] == str(tmp_path / "board.toml")


def test_positions_kinds_and_plane():
    file = parse_finger("""
        [skin]
        young = 4e5
        plane = "stress"
        [sensors]
        y = ["-2 mm", 0.001]
        depth = ["2 mm", "3 mm"]
        kind = ["volume_resistance", "mean_pressure"]
        exact = true
        high = inf
    """)
    assert file.finger.skin.plane == "stress"
    np.testing.assert_array_equal(file.finger.array.y, [-2e-3, 1e-3])
    np.testing.assert_array_equal(file.finger.array.depth, [2e-3, 3e-3])
    assert file.finger.array.transducers == (ss.VolumeResistance(exact=True), ss.MeanPressure())
    for name, kind in kinds().items():
        if name == "magnet_displacement":
            continue  # it needs a table: tests/unit/test_io_area.py
        text = f'[skin]\nyoung = 1\n[sensors]\ncount = 1\npitch = 1\ndepth = 1\nkind = "{name}"\n'
        assert parse_finger(text).finger.array.transducers == (kind(),)


def test_gain_has_the_unit_of_readings_per_measured_unit():
    strain = GOOD.replace("noise = 12", 'gain = "-30 kPa"')
    np.testing.assert_array_equal(parse_finger(strain).finger.array.gain, -30e3)
    pressure = GOOD.replace("noise = 12", "gain = 0.9").replace("normal_strain", "mean_pressure")
    np.testing.assert_array_equal(parse_finger(pressure).finger.array.gain, 0.9)
    volts = GOOD.replace('"kPa"', '"V"').replace('["1 kPa", 0, 3, 4]', '"2 mV"').replace('low = "-1 psi"', "")
    volts = volts.replace("normal_strain", "mean_pressure").replace("noise = 12", 'gain = "3 mV/kPa"')
    array = parse_finger(volts).finger.array
    np.testing.assert_allclose(array.gain, 3e-6, rtol=1e-12)
    np.testing.assert_allclose(array.offset, 2e-3, rtol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ("depth =", "deph =", 9, 'key "deph": no such key is known. Fix: did you mean "depth"'),
        ("[skin]", "[skinn]", 2, 'table "skinn": no such table is known. Fix: did you mean "skin"'),
        ('young = "0.4 MPa"', "", 2, '"young" is missing'),
        ('"0.4 MPa"', '"0.4 Mpaa"', 3, 'no unit "Mpaa" is known. Fix: did you mean "MPa"'),
        ('"0.4 MPa"', '"-0.4 MPa"', 3, 'young = "-0.4 MPa": has to be > 0'),
        ('"0.4 MPa"', "true", 3, "young = True: a number with its unit is needed"),
        ("poisson = 0.5", "poisson = 0.6", 4, "poisson = 0.6: has to be <= 0.5"),
        ("poisson = 0.5", "poisson = nan", 4, "has to be finite"),
        ('"5 mm"', '"-5 mm"', 9, 'depth = "-5 mm": has to be > 0'),
        ('"5 mm"', '"5 kg"', 9, 'depth = "5 kg": a value in m is needed'),
        ('"5 mm"', '["5 mm", "6 kg"]', 9, 'depth[1] = "6 kg": a value in m is needed'),
        ('"5 mm"', '["5 mm", "6 mm"]', 9, "one for each of the 4 sensors"),
        ('"5 mm"', "5 mm", 9, "not TOML"),
        ("[skin]", "[skin", 2, "not TOML"),
        ("count = 4", "count = 4.5", 7, "count = 4.5: a whole number is needed"),
        ("count = 4", "count = 0", 7, "count = 0: a whole number from 1 to 10000 is needed"),
        ("count = 4", "count = 99999999", 7, "from 1 to 10000"),
        ("count = 4", "count = 5", 12, "offset of shape (4,): one value, or one for each of the 5 sensors"),
        ("count = 4", 'y = ["1 mm"]', 8, "pitch beside y"),
        ("count = 4", "", 6, "count and pitch, is missing"),
        ('"6 mm"', "0", 8, "pitch = 0: has to be > 0"),
        ('"normal_strain"', '"normal_stain"', 10, 'did you mean "normal_strain"'),
        ('"normal_strain"', '["normal_strain"]', 10, "kind lists 1: one kind, or one for each of the 4"),
        ('"normal_strain"', "3", 10, "kind = 3"),
        ("noise = 12", "noise = -1", 11, "noise = -1: has to be >= 0"),
        ("noise = 12", 'noise = "3 m"', 11, 'noise = "3 m": a value in Pa is needed'),
        ("noise = 12", "exact = 1", 11, "true or false is needed"),
        ('low = "-1 psi"', "low = 2\nhigh = 1", 13, "low has to be < high"),
        ("friction = 0", "friction = -1", 16, "friction = -1: has to be >= 0"),
        ("friction = 0", "false_alarm = 0.9", 16, "false_alarm = 0.9: has to be <= 0.5"),
        ('["-10 mm", "10 mm"]', '["10 mm", "-10 mm"]', 17, "the first has to be < the second"),
        ('["-10 mm", "10 mm"]', '"10 mm"', 17, "two positions are needed"),
        (LAST, f'{LAST}[live]\nunit = "uT"', 26, "a value in Pa is needed"),
        (LAST, f'{LAST}[live]\nunit = ["Pa", "Pa"]', 26, "unit lists 2: one for each of the 4 sensors"),
        (LAST, f'{LAST}[live]\nchannels = ["p0"]', 26, "channels lists 1: one for each of the 4 sensors"),
        (LAST, f"{LAST}[live]\ndriver = {{ sensors = 4 }}", 26, "driver without a name"),
        (LAST, f'{LAST}[live]\nports = "demo"', 26, 'did you mean "port"'),
        ('"d"]', '"d", "e"]', 20, "sensors names 5 columns: one for each of the 4 sensors"),
        ('"d"]', '"a"]', 20, 'holds "a" twice'),
        ('"d"]', "4]", 20, "a list of names is needed"),
        ('unit = "kPa"', 'unit = "kPaa"', 21, 'no unit "kPaa" is known. Fix: did you mean "kPa"'),
        ('"1e-3 mm"', '"1e-3 s"', 22, 'unit = "1e-3 s": a value in m is needed'),
        ('column = "x"', 'colum = "x"', 22, 'key "colum": no such key is known. Fix: did you mean "column"'),
        ("early = 0.3", 'force = "cell"', 24, "a table of column, unit is needed. Fix: force = { column"),
        ("early = 0.3", "early = 3", 24, "early = 3: has to be <= 1"),
        ("early = 0.3", 'hold = "0 s"', 24, 'hold = "0 s": has to be > 0'),
        ("early = 0.3", "[tare]\ndrift = -1", 25, "drift = -1: has to be >= 0"),
        ("early = 0.3", '[tare]\ndrift = ["1 Pa", 2]', 25, 'drift[0] = "1 Pa": a value in Pa/s is needed'),
        ("early = 0.3", "[relaxation]\nshare = [0.6, 0.5]\ntime = [1, 2]", 25, "share in all = 1.1: has to be <="),
        ("early = 0.3", "[relaxation]\nshare = [0.6]\ntime = [0]", 26, "time[0] = 0: has to be > 0"),
        (GOOD, "", None, "is empty"),
        (GOOD, "\x00", 1, "not TOML"),
        (GOOD, "a = " + "[" * 5000, None, "not TOML"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(old, new, line, said):
    assert old in GOOD
    with pytest.raises(FileError) as caught:
        parse_finger(GOOD.replace(old, new), "my.toml")
    text = str(caught.value)
    assert said in text
    assert text.startswith("my.toml, line" if line else "my.toml")
    if line:
        assert text.startswith(f"my.toml, line {line}:"), text


def test_every_error_is_said_at_once():
    """Found by a newcomer who ran a command seven times for seven errors of one file."""
    wrong = GOOD.replace('"0.4 MPa"', '"0.4 N"').replace("count = 4", "count = 4.5").replace("noise = 12", "nose = 12")
    with pytest.raises(FileError) as caught:
        parse_finger(wrong, "my.toml")
    text = str(caught.value)
    assert text.startswith('my.toml, line 11: [sensors] key "nose": no such key is known.')
    assert 'Fix: did you mean "noise". Also' in text
    for said in ('line 3: young = "0.4 N": a value in Pa is needed', "line 7: count = 4.5: a whole number is needed"):
        assert said in text


SENSORS = """
[sensors]
count = 4
pitch = "2 mm"
depth = "2 mm"
"""
LAYERS = """\
[skin]
kind = "layers"

[[skin.layers]]       # epidermis
young = "2 MPa"
poisson = 0.48
thickness = "0.3 mm"
bond = "frictionless"

[[skin.layers]]       # dermis
young = "0.4 MPa"
thickness = "5 mm"

[skin.base]
young = "10 GPa"
poisson = 0.3
"""
ONE = '[skin]\nkind = "layers"\n[[skin.layers]]\nyoung = "0.4 MPa"\nthickness = "6 mm"\n'
ROUND = '[skin]\nkind = "round"\nyoung = "0.4 MPa"\nradius = "8 mm"\ncore_radius = "4 mm"\n'
RUBBER = ss.Material(0.4e6, 0.5)


class TestSkins:
    def test_layers(self):
        stack = [ss.Layer(ss.Material(2e6, 0.48), 0.3e-3, "frictionless"), ss.Layer(RUBBER, 5e-3)]
        skin = parse_finger(LAYERS + SENSORS).finger.skin
        assert skin == ss.Layered(stack, ss.Material(10e9, 0.3))
        assert parse_finger(ONE + SENSORS).finger.skin == ss.Layered(ss.Layer(RUBBER, 6e-3))

    def test_round(self):
        assert parse_finger(ROUND + SENSORS).finger.skin == ss.Round(RUBBER, 8e-3, 4e-3)
        softer = ROUND.replace('"4 mm"', "0.003\npoisson = 0.45")
        assert parse_finger(softer + SENSORS).finger.skin == ss.Round(ss.Material(0.4e6, 0.45), 8e-3, 3e-3)
        over = '[[skin.layers]]\nyoung = "2 MPa"\npoisson = 0.48\nthickness = "0.3 mm"\n'
        core = '[skin.core]\nyoung = "10 MPa"\npoisson = 0.3\n'
        found = parse_finger(ROUND + 'bond = "frictionless"\n' + over + core + SENSORS).finger.skin
        layer = ss.Layer(ss.Material(2e6, 0.48), 0.3e-3)
        assert found == ss.Round(RUBBER, 8e-3, 4e-3, layer, ss.Material(10e6, 0.3), "frictionless")

    def test_ridges(self):
        text = '[skin]\nyoung = "0.4 MPa"\n[skin.ridges]\npitch = "0.5 mm"\nheight = "0.3 mm"\n' + SENSORS
        file = parse_finger(text)
        assert file.finger.skin == Ridged(ss.HalfPlane(RUBBER), pitch=0.5e-3, height=0.3e-3)
        softer = file.finger.skin.with_(materials=[ss.Material(0.3e6, 0.45)])
        again = parse_finger(file.with_finger(replace(file.finger, skin=softer), 0.0).text)
        assert again.finger.skin == softer
        with pytest.raises(FileError, match="height"):
            parse_finger(text.replace('"0.3 mm"', '"-0.3 mm"'))

    def test_the_kind_may_be_left_out_only_for_a_half_plane(self):
        flat = '[skin]\nkind = "half_plane"\nyoung = "0.4 MPa"\n'
        assert parse_finger(flat + SENSORS).finger.skin == ss.HalfPlane(RUBBER)
        assert parse_finger(flat.replace('kind = "half_plane"\n', "") + SENSORS).finger.skin == ss.HalfPlane(RUBBER)

    @pytest.mark.parametrize(
        ("text", "old", "new", "line", "said"),
        [
            (
                LAYERS,
                'kind = "layers"',
                'kind = "layer"',
                2,
                'kind = "layer": no such kind of skin is known. Fix: did you mean "layers"',
            ),
            (LAYERS, 'kind = "layers"', "", 1, 'layers beside kind = "half_plane"'),
            (LAYERS, 'kind = "layers"', 'kind = "layers"\nyoung = "1 MPa"', 3, 'young beside kind = "layers"'),
            (LAYERS, '"2 MPa"', '"-2 MPa"', 5, 'young = "-2 MPa": has to be > 0'),
            (LAYERS, "0.48", "0.51", 6, "poisson = 0.51: has to be <= 0.5"),
            (LAYERS, '"0.3 mm"', '"0 mm"', 7, 'thickness = "0 mm": has to be > 0'),
            (LAYERS, '"0.3 mm"', '"0.3 kg"', 7, 'thickness = "0.3 kg": a value in m is needed'),
            (LAYERS, '"frictionless"', '"glued"', 8, "'bonded' or 'frictionless'"),
            (LAYERS, 'young = "0.4 MPa"', "", 10, '"young" is missing'),
            (LAYERS, 'young = "0.4 MPa"', "", 10, "[skin.layers]"),
            (LAYERS, 'thickness = "5 mm"', "", 10, '"thickness" is missing'),
            (LAYERS, 'thickness = "5 mm"', 'thicknes = "5 mm"', 12, 'did you mean "thickness"'),
            (LAYERS, 'young = "10 GPa"', "", 14, '"young" is missing'),
            (LAYERS, "poisson = 0.3", "poisson = -0.3", 16, "poisson = -0.3: has to be >= 0"),
            (ONE, '"6 mm"', '"1.9 mm"', 10, "the sensors have to lie in the skin, which is 0.0019 m thick"),
            (ONE[: ONE.index("[[")], "", "", 1, '"layers" is missing: kind = "layers" needs it'),
            (ROUND, 'radius = "8 mm"\n', "", 1, '"radius" is missing: kind = "round" needs it'),
            (ROUND, 'core_radius = "4 mm"', "", 1, '"core_radius" is missing'),
            (ROUND, 'core_radius = "4 mm"', 'core_radius = "9 mm"', 5, "the core has to lie within the finger"),
            (ROUND, 'core_radius = "4 mm"', 'core_radius = "0.1 mm"', 5, "at least a twentieth"),
            (ROUND, 'radius = "8 mm"', 'radius = "-8 mm"', 4, "has to be > 0"),
            (ROUND, 'core_radius = "4 mm"', 'core_radius = "7 mm"', 10, "which is 0.001 m thick"),
            (ROUND, 'young = "0.4 MPa"', 'young = "0.4 MPa"\nplane = "stress"', 4, 'plane beside kind = "round"'),
            (
                ROUND,
                'kind = "round"',
                'kind = "round"\nlayers = [{young = 2e6, thickness = "4 mm"}]',
                3,
                "thinner layers",
            ),
            (ROUND, 'kind = "round"', "", 4, 'radius beside kind = "half_plane"'),
        ],
    )
    def test_a_wrong_one_is_refused_with_its_line(self, text, old, new, line, said):
        assert old in text
        with pytest.raises(FileError) as caught:
            parse_finger(text.replace(old, new, 1) + SENSORS, "my.toml")
        told = str(caught.value)
        assert said in told
        assert told.startswith(f"my.toml, line {line}:"), told

    @pytest.mark.parametrize(
        ("text", "skin"),
        [
            (ONE, ss.Layered(ss.Layer(ss.Material(0.4e6, 0.43), 7.25e-3))),
            (ROUND, ss.Round(ss.Material(0.4e6, 0.43), 8e-3, 3.25e-3)),
        ],
        ids=["layers", "round"],
    )
    def test_a_fitted_thickness_and_poisson_are_written_back(self, text, skin):
        text = text.replace('young = "0.4 MPa"', 'young = "0.4 MPa"  # as bought') + SENSORS
        file = parse_finger(text)
        changed = file.with_finger(replace(file.finger, skin=skin), 1e-3)
        assert "# as bought" in changed.text
        again = parse_finger(changed.text).finger.skin
        assert again.single_material.poisson == pytest.approx(0.43, rel=1e-9)
        assert again.thickness == pytest.approx(skin.thickness, rel=1e-8)
        np.testing.assert_array_equal(file.finger.array.depth, parse_finger(changed.text).finger.array.depth)


def test_reading_a_file(tmp_path):
    path = tmp_path / "finger.toml"
    with pytest.raises(FileError, match="there is no such file"):
        load(path)
    path.write_bytes(b"[skin]\nyoung = \xff\n")
    with pytest.raises(FileError, match=r"line 2: the file has to be text in UTF-8"):
        load(path)
    path.write_text(GOOD.replace("\n", "\r\n"))
    assert load(path).names == ("a", "b", "c", "d")


class TestWriting:
    def changed(self, file, **fields):
        return replace(file.finger, array=replace(file.finger.array, **fields))

    def test_only_what_changed_is_written_and_comments_stay(self):
        file = parse_finger(GOOD)
        finger = self.changed(file, depth=4.2e-3, gain=[-1.0, -2.0, -3.0, 0.0], noise=[1.0, 2.0, 3.0, 4.0])
        text = file.with_finger(finger, 3e-3, {"source": "presses.csv", "std": {"origin": "1 um"}}).text
        lines = text.splitlines()
        assert lines[:8] == GOOD.splitlines()[:8]
        assert lines[8] == 'depth = "4.2 mm"      # a guess'
        assert 'count = 4\npitch = "6 mm"' in text
        assert text.index("gain =") < text.index("[locate]")
        again = parse_finger(text)
        assert again.origin == 3e-3
        assert again.search == file.search
        for name in ("y", "depth", "gain", "noise", "offset"):
            np.testing.assert_allclose(getattr(again.finger.array, name), getattr(finger.array, name), rtol=1e-8)
        assert "presses.csv" in text

    def test_moved_sensors_and_another_material(self):
        file = parse_finger(GOOD)
        finger = self.changed(file, y=np.add(file.finger.array.y, [0, 1e-4, 0, 0]), width=1e-3)
        finger = replace(finger, skin=ss.HalfPlane(ss.Material(0.4e6, 0.23456789)))
        again = parse_finger(file.with_finger(finger, 0.0).text)
        np.testing.assert_allclose(again.finger.array.y, finger.array.y, rtol=1e-8)
        np.testing.assert_allclose(again.finger.array.width, 1e-3)
        assert again.finger.skin == finger.skin

    def test_calibrating_twice_leaves_one_table(self):
        file = parse_finger(GOOD)
        twice = file.with_finger(file.finger, 1e-3).with_finger(file.finger, 2e-3)
        assert twice.text.count("[calibration]") == 1
        assert twice.origin == 2e-3

    def test_saved_whole(self, tmp_path):
        path = tmp_path / "finger.toml"
        save_finger(parse_finger(GOOD), path)
        assert path.read_text() == GOOD
        assert [p.name for p in tmp_path.iterdir()] == ["finger.toml"]


def test_single_brackets_for_layers_are_understood(tmp_path):
    path = tmp_path / "finger.toml"
    path.write_text(
        '[skin]\nkind = "layers"\n[skin.layers]\nyoung = "1 MPa"\nthickness = "4 mm"\n[sensors]\ncount = 3\n'
    )
    with pytest.raises(FileError, match=r"line 3.*\[\[skin\.layers\]\]"):
        load(path)


def test_without_a_recording_and_a_gain_readings_are_in_what_the_sensors_feel():
    text = GOOD.partition("[recording]")[0].replace('"1 kPa", 0', '"1 kPa", "2 hPa"').replace("= 12", '= "0.1 hPa"')
    text += '[tare]\ndrift = "1 hPa/s"\n'
    file = parse_finger(text.replace("normal_strain", "mean_pressure"))
    assert file.finger.array.noise[0] == pytest.approx(10.0)
    assert file.finger.array.offset[:2].tolist() == [1000.0, 200.0]
    assert file.drift == pytest.approx(100.0)
    with pytest.raises(FileError, match=r"line 13: .* says in what the sensors are read"):
        parse_finger(text.replace("normal_strain", "mean_pressure").replace("noise", "gain = 0.5\nnoise"))
    with pytest.raises(FileError, match="a plain number is needed"):  # a strain has no unit
        parse_finger(text)


def test_a_gain_that_is_new_leaves_readings_as_they_were():
    """Without one the unit of what is felt is that of the readings; with one nothing says what they are in."""
    text = """\
[skin]
young = "0.4 MPa"
[sensors]
count = 2
pitch = "6 mm"
depth = "5 mm"
kind = "mean_pressure"
noise = "20 Pa"     # as the data sheet says
low = ["1 kPa", "2 kPa"]
[tare]
drift = "3 Pa/s"
noise = "0.1 kPa"
"""
    file = parse_finger(text)
    found = file.with_finger(replace(file.finger, array=replace(file.finger.array, gain=2.0)), 0.0)
    assert found.finger.array.gain.tolist() == [2.0, 2.0]
    for name in ("noise", "low", "offset", "high"):
        assert getattr(found.finger.array, name).tolist() == getattr(file.finger.array, name).tolist()
    assert (found.drift, found.stirring) == (file.drift, file.stirring) == (3.0, 100.0)
    assert "noise = 20.0     # as the data sheet says" in found.text
    same = file.with_finger(replace(file.finger, array=replace(file.finger.array, noise=30.0)), 0.0)
    assert 'low = ["1 kPa", "2 kPa"]' in same.text


TOLD = '[tolerances]\ngain = [0.01, 0.02, 0.03, 0.04]\ndepth = 0.05  # a mould\noffset = "20 Pa"\ncommon = 0.5\n\n'


def test_tolerances_are_read_and_kept():
    file = parse_finger(GOOD.replace("[locate]", TOLD + "[locate]"))
    told = file.finger.tolerances
    assert told is not None
    np.testing.assert_array_equal(told.gain, [0.01, 0.02, 0.03, 0.04])
    assert (float(told.depth), float(told.offset), told.common, told.noise) == (0.05, 20.0, 0.5, 1.0)
    assert "tolerances  gain 0.01 to 0.04, depth 0.05, offset 20" in str(file.finger)
    assert parse_finger(GOOD).finger.tolerances is None
    moved = replace(file.finger, array=replace(file.finger.array, depth=4e-3))
    again = file.with_finger(moved, 0.0)
    assert again.finger.tolerances is not None
    assert "# a mould" in again.text
    exact = file.with_finger(replace(moved, tolerances=None), 0.0)  # as `calibrate` makes it
    assert exact.finger.tolerances is None
    assert "[tolerances]" not in exact.text


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("gain = [0.1, 0.2]", "4 sensors"),
        ("gain = -0.1", "has to be >= 0"),
        ("gian = 0.1", 'did you mean "gain"'),
        ('depth = "0.1 mm"', "a plain number is needed"),
        ('offset = "1 mm"', "offset"),
        ("noise = 0.5", "has to be >= 1"),
        ("common = 1.5", "has to be <= 1"),
    ],
)
def test_wrong_tolerances_are_refused_at_their_line(written, said):
    text = GOOD.replace("[locate]", f"[tolerances]\n{written}\n\n[locate]")
    with pytest.raises(FileError, match="tolerances") as caught:
        parse_finger(text)
    assert said in str(caught.value)
    assert f"line {text.splitlines().index(written) + 1}" in str(caught.value)
