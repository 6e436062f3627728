"""Bytes of real boards, however they come: the frames in them, each once, and none that was not sent.

The frames are those of the sketches and readers of raunaqbhirangi/anyskin (arduino/5X_binary_burst_stream) and
robomechanics/takktile_arduino.
"""

from __future__ import annotations

import numpy as np
import pytest

from subskin.errors import InvalidValueError, UnknownOptionError
from subskin.live import drivers

ANYSKIN = bytes.fromhex(
    "0000c841000020410000a4c1002096430000d0410000a041000024c200a096430000d8410000f041000076c200209743"
    "0000e041000020420000a4c200a097430000e841000048420000cdc2002098430d0a"
)
CHIPS = [[25.0 + i, 10.0 * (i + 1), -20.5 * (i + 1), 300.25 + i] for i in range(5)]
TAKKTILE = b"[[327],[335],[331],[324],[351]]\r\n"
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


@pytest.mark.parametrize("name", ["anyskin", "lines", "takktile"])
def test_any_cut_gives_the_same(name):
    made, data = {
        "anyskin": (lambda: drivers.named("anyskin", sensors=5), ANYSKIN[37:] + 3 * ANYSKIN + b"\r\n??" + 3 * ANYSKIN),
        "lines": (barometers, CSV[40:] + 3 * CSV),
        "takktile": (drivers.named("takktile").__class__, TAKKTILE[9:] + 4 * TAKKTILE),
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
