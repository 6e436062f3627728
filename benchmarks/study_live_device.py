"""An hour of a bad device, read by its driver: what comes out, and what the reader holds in memory.

Run: python benchmarks/study_live_device.py [minutes]. A board of 16 channels sends 1000 frames a second on simulated
time, with a fault every second on average: frames left out, cut or changed, garbage, restarts, an unplugged cable. Each
value is the number of its frame, so that a frame that was not sent shows.
"""

from __future__ import annotations

import argparse
import resource
import time

import numpy as np

from subskin.live import drivers
from subskin.live.drivers import Driver, Field, Fixed
from subskin.live.ports import Faults, PortEnded, PortLost, Simulated

RATE, CHANNELS = 1000, 16
FIELDS = [
    Field("n", "u32", "counter"),
    Field("t", "u32", "time", 1e-6),
    *(Field(f"c{i}", "f64") for i in range(CHANNELS)),
]
MADE = {
    "marks and CRC": lambda: Fixed(FIELDS, start=b"\xa5\x5a", check="crc16_ccitt"),
    "an end mark (anyskin)": lambda: drivers.named("anyskin", sensors=CHANNELS // 4),
    "lines with CRC": lambda: drivers.named("lines", sensors=CHANNELS, check="crc16_ccitt"),
}


def numbers(at: np.ndarray) -> np.ndarray:
    """The number of each frame, in each channel; exact in single precision too."""
    return np.tile(np.rint(at * RATE)[:, None] % (1 << 24), (1, CHANNELS))


def read(driver: Driver, port: Simulated, sent: int) -> dict[str, int]:
    """Read to the end, and count."""
    seen = np.zeros(sent, dtype=np.int8)
    told = {"frames": 0, "invented": 0, "out of order": 0, "bad": 0, "lost": 0}
    last = -1
    while True:
        try:
            frames = driver.feed(port.read(0.0))
        except PortLost:
            try:
                port.reopen()
                driver.reset()
            except PortLost:
                pass
            continue
        except PortEnded:
            break
        told["bad"] += frames.bad
        told["lost"] += frames.lost
        if not len(frames):
            continue
        first = frames.values[:, 0]
        true = (
            (frames.values == first[:, None]).all(axis=1) & (first >= 0) & (first < sent) & (first == np.floor(first))
        )
        told["frames"] += int(true.sum())
        told["invented"] += int((~true).sum())
        number = first[true].astype(np.int64)
        told["out of order"] += int((np.diff(number, prepend=last) <= 0).sum())
        last = int(number[-1]) if number.size else last
        seen[number] += 1
    whole = np.ones(sent, dtype=bool)
    for begin, end, why in port.spoilt:
        if why != "garbage":
            whole[begin : end + 1] = False
    return told | {
        "whole": int(whole.sum()),
        "missed": int((whole & (seen == 0)).sum()),
        "twice": int((seen > 1).sum()),
        "faults": len(port.spoilt),
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("minutes", type=float, nargs="?", default=60.0)
    minutes = parser.parse_args().minutes
    per = 1 / 6
    for name, made in MADE.items():
        checked = name != "an end mark (anyskin)"  # a changed byte is not seen without a check
        faults = Faults(per, per, per if checked else 0.0, per, 0.0, per, per)
        port = Simulated(numbers, made(), rate=RATE, faults=faults, seed=1, duration=60 * minutes, batch=0.008)
        before, began = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
        told = read(made(), port, int(60 * minutes * RATE))
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        print(f"{name}, {minutes:g} min, {time.process_time() - began:.0f} s CPU (sending too), {grown:.1f} MB more:")
        print("  " + ", ".join(f"{key} {value}" for key, value in told.items()))


if __name__ == "__main__":
    main()
