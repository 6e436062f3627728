"""Any bytes, cut anywhere: no error, no frame that was not sent, and the next frames found again."""

from __future__ import annotations

from contextlib import suppress
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subskin.errors import SubskinError
from subskin.live import drivers
from subskin.live.drivers import Field, Fixed
from subskin.live.ports import opened

TWO = [Field("a", "u16"), Field("b", "i24")]
MADE = {
    "end mark": lambda: Fixed(TWO, end=b"\xf1\xf2"),
    "start mark": lambda: Fixed(TWO, start=b"\xf1\xf2"),
    "both marks": lambda: Fixed([Field("n", "u8", "counter"), *TWO], start=b"\xf1\xf2\xf3", end=b"\xf4"),
    "sum of a byte": lambda: Fixed(TWO, start=b"\xf1\xf2", check="sum8"),
    "crc": lambda: Fixed([Field("t", "u32", "time", 1e-6), *TWO], start=b"\xf1", check="crc16_ccitt"),
    "crc, end mark": lambda: Fixed(TWO, end=b"\xf1\xf2", check="crc16_modbus", big_endian=True),
    "anyskin": lambda: drivers.named("anyskin", sensors=1),
    "lines": lambda: drivers.named("lines", columns=["t", "a", "b"], time="t", tick="us"),
    "checked lines": lambda: drivers.named("lines", columns=["n", "a", "b"], counter="n", check="crc16_ccitt"),
    "takktile": lambda: drivers.named("takktile", sensors=2),
    "contactile": lambda: drivers.named("contactile", sensors=1, pillars=1, slip=True),
    "xela": lambda: drivers.named("xela", taxels=1),
}
CHECKED = ("crc", "crc, end mark", "checked lines", "contactile")
"""Formats that see a changed byte."""
HELD = 300_000
"""Bytes that a driver may keep."""


def sent(name, rows):
    """Bytes of frames, one by one, and their values as the format has them: no mark in them but where they belong."""
    driver = MADE[name]()
    values = np.asarray(rows, dtype=float)[:, [0] * len(driver.channels)] + np.arange(len(driver.channels)) % 7
    if name == "contactile":
        values[:, -5:] %= 100
    one_by_one = [driver.encode(row[None], [i * 1e-3], [i]) for i, row in enumerate(values)]
    return one_by_one, values


def kept(driver):
    """Bytes that a driver holds on to."""
    parts = [vars(driver), *(vars(part) for part in vars(driver).values() if hasattr(part, "__dict__"))]
    return sum(len(value) for part in parts for value in part.values() if isinstance(value, bytes))


def fed(driver, data, cuts=()):
    ends = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    parts = [driver.feed(data[a:b]) for a, b in pairwise(ends)]
    columns = [np.concatenate([getattr(p, key) for p in parts]) for key in ("values", "device_time", "sequence")]
    return *columns, sum(p.lost for p in parts), sum(p.bad for p in parts)


FRAGMENTS = st.one_of(
    st.binary(max_size=40),
    st.sampled_from(
        [b"\xf1\xf2", b"\xf1", b"\r\n", b"\n", b"\x55\x66\x77\x88", b"\xaa\xbb\xcc\xdd", b"[[", b"1,2,3\r\n"]
    ),
    st.tuples(st.sampled_from(sorted(MADE)), st.integers(0, 200), st.integers(0, 60)).map(
        lambda given: sent(given[0], [[given[1]]])[0][0][given[2] % 40 :]
    ),
)


@pytest.mark.parametrize("name", sorted(MADE))
@settings(max_examples=12, deadline=None)
@given(parts=st.lists(FRAGMENTS, max_size=30), cuts=st.lists(st.integers(0, 10_000), max_size=12))
def test_any_bytes_in_any_pieces(name, parts, cuts):
    data = b"".join(parts)
    whole, driver = fed(MADE[name](), data), MADE[name]()
    pieces = fed(driver, data, cuts)
    for a, b in zip(whole[:3], pieces[:3], strict=True):
        assert a.tobytes() == b.tobytes()
    assert whole[3:] == pieces[3:]
    assert kept(driver) <= HELD


@pytest.mark.parametrize("name", sorted(MADE))
@pytest.mark.parametrize("noise", [b"1", b"\xf1\xf2", b"Ufw\x88", b"\r\n\x00", b"Ufw\x88\xaa\xbb\xcc\xdd"])
def test_what_is_kept_is_bounded(name, noise):
    driver = MADE[name]()
    for _ in range(40 if len(noise) == 1 else 2):  # a line that never ends, and marks without frames
        assert len(driver.feed(8192 // len(noise) * noise)) == 0
    assert kept(driver) <= HELD


DAMAGE = st.lists(
    st.tuples(
        st.sampled_from(["whole"] * 6 + ["cut", "gone", "more", "garbage", "changed"]),
        st.integers(0, 1000),
        st.integers(1, 60),
        st.integers(1, 0x6F),
    ),
    min_size=4,
    max_size=24,
)


@pytest.mark.parametrize("name", sorted(MADE))
@settings(max_examples=20, deadline=None)
@given(damage=DAMAGE, join=st.integers(0, 30), cuts=st.lists(st.integers(0, 10_000), max_size=4))
def test_damage_makes_no_false_frame_and_is_over_after_two(name, damage, join, cuts):
    frames, values = sent(name, [[20 + 3 * i] for i in range(len(damage))])
    data, good = frames[0][join % len(frames[0]) :], [False]
    for (kind, at, size, byte), frame in zip(damage[1:], frames[1:], strict=True):
        at %= len(frame)
        if name not in CHECKED and (kind == "changed" or not good[-1]):
            kind = "whole"  # such a format cannot tell, nor of two damaged frames that they are not one
        if kind == "cut":
            frame = frame[:at] + frame[at + size :]
        elif kind == "gone":
            frame = b""
        elif kind == "more":
            frame = frame[:at] + size * bytes([byte]) + frame[at:]
        elif kind == "garbage":
            frame = size * bytes([byte]) + frame
        elif kind == "changed":
            frame = frame[:at] + bytes([frame[at] ^ byte]) + frame[at + 1 :]
        good.append(kind == "whole")
        data += frame
    # numbers in a line that lost or gained a digit are numbers: only lines with a check are judged by their values
    found = fed(MADE[name](), data, cuts)[0]
    if name not in ("lines", "takktile"):
        known = {row.tobytes(): i for i, row in enumerate(values)}
        numbers = [known.get(row.tobytes()) for row in found]
        assert None not in numbers
        assert numbers == sorted(set(numbers))
    else:
        numbers = [i for i, row in enumerate(values) if row.tobytes() in {one.tobytes() for one in found}]
    for i in range(2, len(damage) - 1):
        if all(good[i - 2 : i + 2]):  # the two frames before, this one, and the next are whole
            assert i in numbers


@pytest.mark.parametrize("name", ["end mark", "start mark", "both marks", "anyskin"])
@settings(max_examples=25, deadline=None)
@given(
    rows=st.lists(
        st.tuples(st.sampled_from([0, 0xF2F1, 0xF4F3, 0x0A0D, 7]), st.integers(0, 4)), min_size=3, max_size=20
    ),
    join=st.integers(0, 20),
    cuts=st.lists(st.integers(0, 1000), max_size=5),
)
def test_marks_in_the_data_make_no_false_frame(name, rows, join, cuts):
    driver = MADE[name]()
    table = np.zeros((len(rows), len(driver.channels)))
    for i, (mark, column) in enumerate(rows):
        table[i] = i
        table[i, column % table.shape[1]] = mark
    if name == "anyskin":  # a float whose bytes hold 0d 0a
        table = np.where(table == 0x0A0D, np.array([0x42480A0D], np.uint32).view(np.float32)[0], table % 100)
    data = b"".join(driver.encode(row[None], sequence=[i]) for i, row in enumerate(table))
    found = fed(MADE[name](), data[join:], cuts)[0]
    at = -1
    for row in found:  # those sent, in their order
        at = next((i for i in range(at + 1, len(table)) if (table[i] == row).all()), None)
        assert at is not None


PLAIN = st.one_of(
    st.booleans(), st.integers(-3, 300), st.floats(), st.text(max_size=6), st.sampled_from(["u8", "0d 0a"])
)
KEYS = st.sampled_from(["name", "type", "count", "scale"])
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3), max_leaves=6
)
OPTIONS = ("sensors", "fields", "end", "start", "columns", "check", "time", "begin", "taxels", "rate", "slip")


@settings(max_examples=60, deadline=None)
@given(
    name=st.sampled_from([*sorted(drivers.kinds()), "anyskn"]),
    options=st.dictionaries(st.sampled_from(OPTIONS), VALUES, max_size=4),
)
def test_any_table_is_a_driver_or_a_readable_error(name, options):
    with suppress(SubskinError):
        assert len(drivers.from_table({"name": name, **options}).channels) > 0


@settings(max_examples=25, deadline=None)
@given(
    kind=st.sampled_from(["serial", "tcp", "udp", "demo", "", "seriall", "-"]),
    rest=st.text("/?=&:. 0aé\x00", max_size=12),
)
def test_any_port_is_a_readable_error(kind, rest):
    with pytest.raises(SubskinError):
        opened(f"{kind}:{rest}").close()


@pytest.mark.parametrize("name", CHECKED)
@settings(max_examples=20, deadline=None)
@given(marks=st.lists(st.sampled_from([0x88776655, 0xDDCCBBAA, 0xF2F1, 0xF1, 3]), min_size=1, max_size=8))
def test_marks_in_checked_data_cost_nothing(name, marks):
    driver = MADE[name]()
    width = len(driver.channels)
    values = np.array([[mark % 0x8000] * width for mark in marks], dtype=float)
    if name == "contactile":  # a float of these bytes is a mark
        floats = np.array(marks, np.uint32).view(np.float32).astype(float)
        values = np.where(np.arange(width) < 12, floats[:, None], 1.0)
    data = driver.encode(values, np.arange(len(marks)) * 1e-3, np.arange(len(marks)))
    found = fed(driver, (b"?\n" if name == "checked lines" else b"") + data)[0]
    assert found.tobytes() == values.tobytes()
