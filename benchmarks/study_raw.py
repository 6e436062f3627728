"""How many raw frames are located OK and wrong? By what presses have in common, and by where the indenter is.

    python benchmarks/study_raw.py [--data FOLDER] [--recordings full,day,next] [--json FILE]

FOLDER (../shared/data) holds the recordings, which do not ship with this package: barotact/, three of four barometers
in a row. "full" is calibrated on every second of its own presses, as docs/recording.md does. The others are of other
days, and located by that finger: the first three of their presses that are OK, with a lift, say where the row lies.
What presses have in common at a sensor, beside the field, is taken

- "lift": to go with the load, as `calibrate` does;
- "offset": to be the same under every load that is felt, and nothing where the skin is free;
- "none": not to be there, `--fit gain,depth,origin,position`.

A frame is `down` where the indenter is 99 % of its way down or more, in the `rise` before and in the `fall` after; it
is of a `light` touch below 85 %. Frames in which it has not touched yet count too: the approach does not say when.
Wrong is an answer more than 2 mm off; sure and wrong is one that is also off by 3 of its own standard errors.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import subskin as ss
from _common import arguments, show
from study_coverage import AIR, DATA, Q95

FINGER = """
[skin]
young = "0.2 MPa"
poisson = 0.5
[sensors]
count = 4
pitch = "6 mm"
depth = "5 mm"
kind = "normal_strain"
gain = "-1 MPa"
noise = "10 Pa"
[locate]
friction = 0
search = ["-16 mm", "16 mm"]
[recording]
sensors = ["Sensor_0", "Sensor_1", "Sensor_2", "Sensor_3"]
unit = "Pa"
time = { column = "time", unit = "s" }
position = { column = "x", unit = "1/1000 mm" }
press = { column = "z", unit = "1/320 mm" }
"""
FITS = {
    "lift": ("gain", "lift", "depth", "origin", "position"),
    "offset": ("gain", "offset", "depth", "origin", "position"),
    "none": ("gain", "depth", "origin", "position"),
}
OFF, SURE, DOWN, LIGHT = 2e-3, 3.0, 0.99, 0.85


def calibrated(data: Path, common: str) -> tuple[ss.io.FingerFile, ss.Finger]:
    """The file and the finger by every second press of "full"; the file's own has no offset, which raw frames lack."""
    file = ss.io.parse_finger(FINGER).of_differences()
    own = file.segment(data / "barotact" / AIR["full"])
    found = ss.calibrate(file.finger, own.reading[::2], own.position[::2], fit=FITS[common])
    plain = replace(found.finger, array=replace(found.finger.array, offset=0.0))
    return file.with_finger(plain, found.origin), found.finger


def origin_of(data: Path, name: str) -> float:
    """Where the row lies on another day: as three presses say that are located by the finger with a lift [m]."""
    file, _ = calibrated(data, "lift")
    presses = file.segment(data / "barotact" / AIR[name])
    found = file.locate(presses.reading)
    return float(np.median((presses.position - found.position)[found.ok][:3]))


def located(data: Path, name: str, common: str) -> dict[str, np.ndarray]:
    """Of each frame: the status, the error and its standard error [m], how far down, and whether that grows."""
    file, finger = calibrated(data, common)
    origin = file.origin if name == "full" else origin_of(data, name)
    table = ss.io.read_table(data / "barotact" / AIR[name])
    tared = file.tare(table)
    found = replace(file, finger=finger).locate(tared.readings)
    status = np.where(tared.free & (common == "offset"), ss.Status.NO_CONTACT, found.status)
    truth, down = table.numbers("x") * 1e-6, table.numbers("z") / table.numbers("z").max()
    before = np.concatenate([[True], np.diff(down) >= 0])
    error = np.abs(found.position + origin - truth)
    return {"status": status, "error": error, "std": found.std[..., 0], "down": down, "rises": before}


HEADS = ("frames", "no contact", "OK", "median [mm]", "wrong", "sure and wrong", "in 95 % [%]")


def counted(frames: dict[str, np.ndarray], kept: np.ndarray) -> list[str]:
    """What `HEADS` names, of the frames that are kept."""
    status, error, std = (frames[name][kept] for name in ("status", "error", "std"))
    ok = status == ss.Status.OK
    wrong = ok & (error > OFF)
    whole = (kept, status == ss.Status.NO_CONTACT, ok, wrong, wrong & (error > SURE * std))
    frames_, none, fine, off, sure = (str(int(part.sum())) for part in whole)
    median = f"{1e3 * np.median(error[ok]):.3f}" if ok.any() else ""
    held = f"{100 * np.mean(error[ok] < Q95 * std[ok]):.0f}" if ok.any() else ""
    return [frames_, none, fine, median, off, sure, held]


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, data=DATA, recordings=",".join(AIR))
    rows = []
    for name in options.recordings.split(","):
        for common in FITS:
            frames = located(options.data, name, common)
            down, rises = frames["down"], frames["rises"]
            held, light = down >= DOWN, down < LIGHT
            moving = ~held & (down > 0)
            parts = {
                "all": down >= 0,
                "down": held,
                "rise": moving & rises & ~light,
                "fall": moving & ~rises & ~light,
                "rise, light": moving & rises & light,
                "fall, light": moving & ~rises & light,
            }
            rows += [[name, common, part, *counted(frames, kept)] for part, kept in parts.items()]
    show("Raw frames", ["recording", "in common", "indenter", *HEADS], rows, options.json)


if __name__ == "__main__":
    main()
