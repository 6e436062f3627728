"""Bytes of real boards, however they come: the frames in them, each once, and none that was not sent.

The frames are those of the sketches and readers of raunaqbhirangi/anyskin (arduino/5X_binary_burst_stream),
robomechanics/takktile_arduino, langxin11/contactile_pts_lab (python_ws/pts_protocol.py) and mcsix/xela_server_ros2
(scripts/xela_service).
"""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from subskin.errors import InvalidValueError, SubskinError, UnknownOptionError
from subskin.live import drivers
from subskin.live.drivers import Field

ANYSKIN = bytes.fromhex(
    "0000c841000020410000a4c1002096430000d0410000a041000024c200a096430000d8410000f041000076c200209743"
    "0000e041000020420000a4c200a097430000e841000048420000cdc2002098430d0a"
)
CHIPS = [[25.0 + i, 10.0 * (i + 1), -20.5 * (i + 1), 300.25 + i] for i in range(5)]
TAKKTILE = b"[[327],[335],[331],[324],[351]]\r\n"
CONTACTILE = bytes.fromhex(
    "556677880201000d000300190004001b010700000015cd5b070000000001000400090014002e00480062007c009600b000ca"
    "00e40002000000000000000000000080bf0000000000000000000000000200cdcccc3dcdcc4c3e000000c00ad7233c0ad7a3"
    "3c8fc2f53c0200cdcc4c3ecdcccc3e000040c00ad7a33c0ad7233d8fc2753d02009a99993e9a99193f000080c08fc2f53c8f"
    "c2753dec51b83d0200cdcccc3ecdcc4c3f0000a0c00ad7233d0ad7a33d8fc2f53d02000000003f0000803f0000c0c0cdcc4c"
    "3dcdcccc3d9a99193e02009a99193f9a99993f0000e0c08fc2753d8fc2f53dec51383e02003333333f3333b33f000000c129"
    "5c8f3d295c0f3e3d0a573e0200cdcc4c3fcdcccc3f000010c10ad7a33d0ad7233e8fc2753e0100040002000000c03f000000"
    "bf000010c1000020410000a0410000f0412f5eaabbccdd"
)
XELA = (
    b'{"message": 786, "time": 1619157045.6195483, "sensors": 1, "1": {"data": "'
    + b",".join(16 * [b"7F39,7F29,7D39"])
    + b'", "sensor": "1", "taxels": 16, "model": "XR1944", "calibrated": null}}'
)
CSV = b"t_us,p0,p1,p2,p3\r\n1000,101325,101330,101321,101340\r\n2000,101326,101329,101322,101341\r\n"


def barometers():
    return drivers.named("lines", columns=["t_us", "p0", "p1", "p2", "p3"], time="t_us", tick="us")


def test_anyskin():
    driver = drivers.named("anyskin", sensors=5)
    assert driver.channels[:5] == ("t0_C", "x0_uT", "y0_uT", "z0_uT", "t1_C")
    frames = driver.feed(3 * ANYSKIN)
    assert frames.values.tolist() == 3 * [[value for chip in CHIPS for value in chip]]
    assert (frames.bad, frames.lost) == (0, 0)
    assert len(driver.feed(ANYSKIN)) == 1  # at once: it does not wait for the frame after


def test_lines_of_the_home_made_board():
    driver = barometers()
    frames = driver.feed(b"\x00\xffBarometers 1.2\r\nready\r\n" + CSV)
    assert driver.channels == ("p0", "p1", "p2", "p3")
    assert frames.values.tolist() == [[101325, 101330, 101321, 101340], [101326, 101329, 101322, 101341]]
    assert frames.device_time.tolist() == [1e-3, 2e-3]
    assert frames.bad == 2  # "ready" and the header; the first line is not judged


def test_takktile():
    frames = drivers.named("takktile", sensors=5).feed(b"4],[351]]\r\n" + TAKKTILE)
    assert frames.values.tolist() == [[327, 335, 331, 324, 351]]
    assert frames.bad == 1


@pytest.mark.parametrize("last", ["3", "3,4,5", "3,x", "3,inf", "3,1e999", "3,1_0", "3,0x10"])
def test_a_line_that_is_no_frame(last):
    frames = barometers().feed(f"first\n1000,1,2,{last}\n2000,1,nan,3,4\n".encode())
    assert (len(frames), frames.bad) == (1, 1)
    assert np.isnan(frames.values).tolist() == [[False, True, False, False]]  # a value that is missing


@pytest.mark.parametrize("name", ["anyskin", "lines", "takktile", "contactile"])
def test_any_cut_gives_the_same(name):
    made, data = {
        "anyskin": (lambda: drivers.named("anyskin", sensors=5), ANYSKIN[37:] + 3 * ANYSKIN + b"\r\n??" + 3 * ANYSKIN),
        "lines": (barometers, CSV[40:] + 3 * CSV),
        "takktile": (drivers.named("takktile").__class__, TAKKTILE[9:] + 4 * TAKKTILE),
        "contactile": (drivers.named("contactile").__class__, CONTACTILE[99:] + 3 * CONTACTILE),
    }[name]
    whole = made().feed(data)
    assert len(whole) >= 3
    for cut in range(len(data) + 1):
        driver = made()
        parts = [driver.feed(data[:cut]), driver.feed(data[cut:])]
        assert np.concatenate([part.values for part in parts]).tobytes() == whole.values.tobytes()
        assert sum(part.bad for part in parts) == whole.bad


def test_a_driver_that_cannot_be_had():
    with pytest.raises(InvalidValueError, match='did you mean "anyskin"'):
        drivers.named("anyskins")
    with pytest.raises(UnknownOptionError, match="known: sensors"):
        drivers.named("anyskin", chips=5)
    with pytest.raises(InvalidValueError, match="1 to 255"):
        drivers.named("anyskin", sensors=0)
    with pytest.raises(InvalidValueError, match="a name is needed"):
        drivers.from_table({"sensors": 5})


def test_contactile():
    driver = drivers.named("contactile", sensors=1, pillars=9)
    frames = driver.feed(CONTACTILE)
    k = np.arange(9)[:, None]
    pillars = np.hstack([0.1 * k, 0.2 * k, -1.0 - k, 0.01 * k, 0.02 * k, 0.03 * k])
    assert frames.values[0, :54].reshape(9, 6) == pytest.approx(pillars, rel=1e-6)
    assert frames.values[0, 54:].tolist() == [1.5, -0.5, -9.0, 10.0, 20.0, 30.0]
    assert (frames.sequence.tolist(), frames.device_time.tolist()) == ([7], [123.456789])
    assert driver.encode(frames.values, frames.device_time, frames.sequence) == CONTACTILE
    assert driver.channels[-6:] == ("s0_Fx_N", "s0_Fy_N", "s0_Fz_N", "s0_Tx_Nmm", "s0_Ty_Nmm", "s0_Tz_Nmm")
    later = driver.encode(frames.values, frames.device_time, [10])
    assert driver.feed(later).lost == 2


def test_contactile_says_what_it_knows_of_slip():
    plain, slip = (drivers.named("contactile", slip=slip) for slip in (False, True))
    frames = slip.feed(CONTACTILE)
    assert np.isnan(frames.values[0, -21:]).all()  # this packet says nothing of it
    told = np.concatenate([frames.values[0, :60], np.tile([1.0, 0.5], 9), [2.0, 0.75, 4.0]])
    data = slip.encode(told[None])
    assert slip.feed(data).values.tolist() == [told.tolist()]
    assert plain.feed(data).values.tolist() == [told[:60].tolist()]
    assert len(drivers.named("contactile", pillars=4).feed(data)) == 0  # of another array


def test_a_damaged_packet_of_contactile_does_not_take_the_next_with_it():
    driver = drivers.named("contactile")
    broken = CONTACTILE[:45] + b"\x10" + CONTACTILE[46:]  # one pillar count more than bytes
    frames = driver.feed(CONTACTILE + broken + CONTACTILE[:200] + CONTACTILE)
    assert (len(frames), frames.bad) == (2, 2)


def test_xela():
    driver = drivers.named("xela", sensors=1, taxels=16)
    frames = driver.feed(
        b'{"message":"Welcome"}\n' + XELA + b"\n" + XELA.replace(b"786", b"789") + b"\n" + XELA[:50] + b"\n"
    )
    assert frames.values.tolist() == 2 * [16 * [0x7F39, 0x7F29, 0x7D39]]
    assert frames.device_time.tolist() == 2 * [1619157045.6195483]
    assert (frames.sequence.tolist(), frames.lost, frames.bad) == ([786, 789], 2, 1)


def test_xela_calibrated():
    driver = drivers.named("xela", taxels=1, calibrated=True)
    message = b'{"message": 1, "time": 0.5, "sensors": 1, "1": {"data": "0,0,0", "calibrated": %s}}\n'
    told = (b"[0.1, 0.2, -1.5]", b"[[0.1, 0.2, -1.5]]", b"null", b"[0.1, 0.2, 1e999]", b"[0.1, 0.2]")
    found = driver.feed(b"".join(message % each for each in told))
    assert (found.values.tolist(), found.bad) == (2 * [[0.1, 0.2, -1.5]], 3)
    assert driver.channels == ("s1_t0_x_N", "s1_t0_y_N", "s1_t0_z_N")


def test_a_board_from_a_table_reads_what_the_class_for_it_reads():
    table = {"name": ["t_C", "x_uT", "y_uT", "z_uT"], "type": "f32", "count": 5}
    described = drivers.from_table({"name": "fixed", "fields": [table], "end": "0d 0a"})
    own = drivers.named("anyskin", sensors=5)
    assert described.channels == own.channels
    assert described.feed(2 * ANYSKIN).values.tobytes() == own.feed(2 * ANYSKIN).values.tobytes()


BOARD = """
name = "fixed"
start = "aa 55"
check = "{check}"
covers = "start"
byte_order = "big"
fields = [
    {{ name = "n", type = "u8", use = "counter" }},
    {{ name = "t", type = "u16", use = "time", scale = 1e-3 }},
    {{ name = "gap", type = "u8", use = "skip" }},
    {{ name = "p_Pa", type = "i24", count = 2, scale = 0.5, offset = 1000.0 }},
]
"""


@pytest.mark.parametrize("check", ["sum16", "crc32", "xor8"])
def test_a_board_from_a_file(tmp_path, check):
    (tmp_path / "board.toml").write_text(BOARD.format(check=check))
    driver = drivers.load(tmp_path / "board.toml")
    data = bytes.fromhex("aa55 fe 03e8 00 fffffe 000102")
    frame = data + _by_definition(check, data)
    frames = driver.feed(3 * frame)
    assert frames.values[0].tolist() == [-2 * 0.5 + 1000, 258 * 0.5 + 1000]
    assert driver.channels == ("p0_Pa", "p1_Pa")
    assert (frames.sequence[0], frames.device_time[0]) == (254, 1.0)
    assert driver.encode(frames.values[:1], [1.0], [254]) == frame


def _by_definition(check, data):
    if check == "sum16":
        return (sum(data) % 65536).to_bytes(2, "big")
    if check == "crc32":
        return zlib.crc32(data).to_bytes(4, "big")
    value = 0
    for byte in data:
        value ^= byte
    return bytes([value])


@pytest.mark.parametrize(
    ("check", "value"),  # of "123456789": the catalogue of parametrised CRC algorithms (reveng)
    [
        ("crc16_xmodem", 0x31C3),
        ("crc16_ccitt", 0x29B1),
        ("crc16_modbus", 0x4B37),
        ("crc32", 0xCBF43926),
        ("xor8", 0x31),
    ],
)
def test_checks(check, value):
    assert drivers.CHECKS[check].of(b"123456789") == value


TWO = [Field("a", "u16"), Field("b", "u16")]


def test_bytes_lost_just_where_the_next_frame_holds_a_mark():
    """Then the marks of a frame stand in their positions, though it lacks bytes: another mark is in it."""
    driver = drivers.Fixed(TWO, end=b"\xf1\xf2")
    frames = [driver.encode([[a, 7]]) for a in (1, 2, 3, 0xF2F1, 5, 6, 8)]
    found = driver.feed(b"".join([*frames[:2], frames[2][2:], *frames[3:]]))
    assert found.values[:, 0].tolist() == [1, 2, 0xF2F1, 5, 6, 8]  # not (7, 0xF2F1)
    twice = drivers.Fixed([Field("a", "u8"), Field("b", "u8")], start=b"\xaa\xaa")
    frames = [twice.encode([[a, 2]]) for a in (1, 3, 0xAA, 5, 6, 7)]
    found = twice.feed(b"".join([frames[0], frames[1][:-1], *frames[2:]]))
    assert found.values.tolist() == [[1, 2], [0xAA, 2], [5, 2], [6, 2]]  # the last waits for the mark behind it


def test_joined_where_marks_in_the_data_look_like_frames():
    driver = drivers.Fixed(TWO, end=b"\xf1\xf2")
    values = [[0xF2F1, i] for i in range(3)] + [[9, i] for i in range(3)]
    data = driver.encode(values)[2:]  # begins behind a mark that is data
    found = driver.feed(data)
    assert found.values.tolist() == values[1:]
    driver.reset()
    steady = driver.feed(driver.encode(20 * [[0xF2F1, 1]])[2:])
    assert len(steady) == 0  # nothing tells which mark is the true one
    assert steady.bad > 0
    bounded = drivers.Fixed([Field("a", "u16", high=0xF2F1), Field("b", "u16", high=9)], end=b"\xf1\xf2")
    assert bounded.feed(driver.encode(20 * [[0xF2F1, 1]])[2:]).values.tolist() == 18 * [[0xF2F1, 1]]


def test_a_counter_and_a_clock_that_begin_again():
    fields = [Field("n", "u8", "counter"), Field("t", "u16", "time", 1e-3), Field("p", "u8")]
    driver = drivers.Fixed(fields, start=b"\xf1", check="sum16")
    number = np.array([250, 251, 255, 0, 1, 0])  # three are lost, it turns over, then the board starts again
    time = np.array([65.0, 65.5, 65.535, 65.536, 66.0, 0.0])
    frames = driver.feed(driver.encode(np.zeros((6, 1)), time, number))
    assert frames.lost == 3
    assert frames.device_time == pytest.approx(time, abs=1e-9)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"fields": [{"name": "p", "type": "u16"}]}, "mark at their start or end"),
        ({"fields": [{"name": "p", "type": "u17"}], "end": "0a"}, 'type = .u17. of field p: has to be "u8", '),
        ({"fields": [{"name": "p", "type": "u16", "unit": "Pa"}], "end": "0a"}, "no such key is known"),
        (
            {"fields": [{"name": "p", "type": "u16", "scale": "2"}], "end": "0a"},
            "scale = .2. of field p: a real number",
        ),
        ({"fields": [{"name": "p", "type": "u16", "count": 0}], "end": "0a"}, "whole number from 1"),
        ({"fields": [{"name": ["p", "p"], "type": "u16"}], "end": "0a"}, "a name of its own"),
        ({"fields": [{"name": "n", "type": "i8", "use": "counter"}], "end": "0a"}, "counts up from 0"),
        ({"fields": [{"name": "n", "type": "u8", "use": "counter"}], "end": "0a"}, "one field at least is a channel"),
        ({"fields": [{"name": "p", "type": "u8"}], "end": "0x0a"}, "pairs of hexadecimal digits"),
        ({"fields": [{"name": "p", "type": "u8"}], "end": "0a", "check": "crc"}, "check = .crc.: has to be"),
        ({"fields": "p", "end": "0a"}, "a table for each"),
        ({"fields": [7], "end": "0a"}, "a table for each"),
        ({"fields": [], "end": 10}, "a text is needed"),
        ({"end": "0a"}, "fields"),
    ],
)
def test_a_table_that_describes_no_board(table, said):
    with pytest.raises(SubskinError, match=said):
        drivers.from_table({"name": "fixed", **table})
