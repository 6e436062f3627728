"""How fast the drivers find frames, beside a plain loop of struct: 16 channels, read in batches.

Run: python benchmarks/bench_live_parse.py. Times are CPU time of this process, best of several runs, so that a busy
machine changes them little. "share of a core" is that of a device that sends 8000 frames a second.
"""

from __future__ import annotations

import struct
import time

import numpy as np

from subskin.live import drivers
from subskin.live.drivers import Driver, Field, Fixed

CHANNELS, RATE, FRAMES = 16, 8000, 4000


def struct_loop() -> list[tuple[float, ...]]:
    """What a reader of one's own does: unpack frame by frame, and believe that no byte is ever missing."""
    unpack = struct.Struct("<16f2x").unpack_from
    return [unpack(PLAIN, at) for at in range(0, len(PLAIN) - 65, 66)]


def cpu(run: object, repeat: int = 7) -> float:
    """Least CPU time of a call [s]."""
    best = np.inf
    for _ in range(repeat):
        began = time.process_time()
        run()  # type: ignore[operator]
        best = min(best, time.process_time() - began)
    return best


def fed(driver: Driver, pieces: list[bytes]) -> int:
    """Frames that are found in pieces."""
    driver.reset()
    return sum(len(driver.feed(piece)) for piece in pieces)


VALUES = np.random.default_rng(0).normal(100.0, 10.0, (FRAMES, CHANNELS)).astype(np.float32).astype(float)
TIMES, NUMBERS = np.arange(FRAMES) / RATE, np.arange(FRAMES)
HEAD = [Field("n", "u32", "counter"), Field("t", "u32", "time", 1e-6)]
FIELDS = [*HEAD, *(Field(f"c{i}", "f32") for i in range(CHANNELS))]
MADE = {
    "anyskin: 4 chips, an end mark": drivers.named("anyskin", sensors=4),
    "fixed: number, time, CRC": Fixed(FIELDS, start=b"\xa5\x5a", check="crc16_ccitt"),
    "lines": drivers.named("lines", sensors=CHANNELS),
    "contactile: 18 pillars (120 channels)": drivers.named("contactile", sensors=2),
    "xela: 16 taxels (48 channels)": drivers.named("xela", taxels=16),
}
PLAIN = MADE["anyskin: 4 chips, an end mark"].encode(VALUES)


def main() -> None:
    """Print the table."""
    own = cpu(struct_loop) / FRAMES
    print(f"{'format':40s} {'frames a read':>13s} {'us a frame':>10s} {'share of a core':>16s}")
    print(f"{'struct loop, no marks looked at':40s} {'-':>13s} {1e6 * own:10.2f} {100 * own * RATE:15.1f} %")
    for name, driver in MADE.items():
        values = np.resize(np.abs(VALUES), (FRAMES, len(driver.channels)))
        one_by_one = [driver.encode(values[i : i + 1], TIMES[i : i + 1], NUMBERS[i : i + 1]) for i in range(FRAMES)]
        for size in (1, 8, 64):
            pieces = [b"".join(one_by_one[i : i + size]) for i in range(0, FRAMES, size)]
            found = fed(driver, pieces)
            if found < FRAMES - 1:
                raise SystemExit(f"{name}: {found} of {FRAMES} frames were found")
            each = cpu(lambda d=driver, p=pieces: fed(d, p)) / FRAMES
            print(f"{name:40s} {size:13d} {1e6 * each:10.2f} {100 * each * RATE:15.1f} %")


if __name__ == "__main__":
    main()
