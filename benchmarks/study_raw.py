"""How many raw frames are located OK and wrong? By what presses have in common, and by where the indenter is.

    python benchmarks/study_raw.py [--data FOLDER] [--recordings full,day,next] [--json FILE]

FOLDER (../shared/data) holds the recordings, which do not ship with this package: barotact/, three of four barometers
in a row. "full" is calibrated on every second of its own presses, as docs/recording.md does. The others are of other
days, and located by that finger: the first three of their presses that are OK, with a lift, say where the row lies.
What presses have in common at a sensor, beside the field, is taken

- "lift": to go with the load, as `calibrate` does;
- "offset": to be the same under every load that is felt, and nothing where the skin is free;
- "none": not to be there, `--fit gain,depth,origin,position`.

A second table is of fingers with a lift, of a half plane and of a layer whose thickness is fitted too: with frames as
they were read, with what each sensor forgets of a held press undone (the [relaxation] that `io.fit_held` finds from the
presses of the calibration), and with the doubt of that as well.

A frame is `down` where the indenter is 99 % of its way down or more, in the `rise` before and in the `fall` after; it
is of a `light` touch below 85 %. Frames in which it has not touched yet count too: the approach does not say when.
Wrong is an answer more than 2 mm off; sure and wrong is one that is also off by 3 of its own standard errors.
"""

from __future__ import annotations

import json
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
LAYER = 'kind = "layers"\nlayers = [{ young = "0.2 MPa", poisson = 0.5, thickness = "15 mm" }]'
SKINS = {
    "half plane": (FINGER, FITS["lift"]),
    "layer": (FINGER.replace('young = "0.2 MPa"\npoisson = 0.5', LAYER), (*FITS["lift"], "thickness")),
}
HELD = ("as read", "undone", "undone, in doubt")
OFF, SURE, DOWN, LIGHT = 2e-3, 3.0, 0.99, 0.85


def calibrated(
    data: Path, fit: tuple[str, ...], text: str = FINGER, held: str = HELD[0]
) -> tuple[ss.io.FingerFile, ss.Finger]:
    """The file and the finger by every second press of "full"; the file's own has no offset, which raw frames lack."""
    file, path = ss.io.parse_finger(text).of_differences(), data / "barotact" / AIR["full"]
    if held != HELD[0]:
        own = ss.io.fit_held(file, path, every=2).own
        file = ss.io.with_relaxation(file, own if held == HELD[2] else replace(own, doubt=0.0))
    own = file.segment(path)
    found = ss.calibrate(file.finger, own.reading[::2], own.position[::2], fit=fit)
    plain = replace(found.finger, array=replace(found.finger.array, offset=0.0))
    return file.with_finger(plain, found.origin), found.finger


def origin_of(data: Path, name: str, file: ss.io.FingerFile) -> float:
    """Where the row lies on another day: as three presses say that are located by a finger with a lift [m]."""
    presses = file.segment(data / "barotact" / AIR[name])
    found = file.locate(presses.reading)
    return float(np.median((presses.position - found.position)[found.ok][:3]))


def located(
    data: Path, name: str, file: ss.io.FingerFile, finger: ss.Finger, origin: float, offset: bool = False
) -> dict[str, np.ndarray]:
    """Of each frame: the status, the error and its standard error [m], how far down, and whether that grows."""
    table = ss.io.read_table(data / "barotact" / AIR[name])
    tared = file.tare(table)
    found = replace(file, finger=finger).locate(tared.readings, doubt=tared.doubt)
    status = np.where(tared.free & offset, ss.Status.NO_CONTACT, found.status)
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


def parts(frames: dict[str, np.ndarray], apart: bool) -> dict[str, np.ndarray]:
    """Which frames lie in which part of a press; light touches `apart`, or in the rise and the fall."""
    down, rises = frames["down"], frames["rises"]
    held, light = down >= DOWN, down < LIGHT
    moving = ~held & (down > 0)
    whole = {"all": down >= 0, "down": held}
    if not apart:
        return {**whole, "rise": moving & rises, "fall": moving & ~rises}
    return {
        **whole,
        "rise": moving & rises & ~light,
        "fall": moving & ~rises & ~light,
        "rise, light": moving & rises & light,
        "fall, light": moving & ~rises & light,
    }


def main() -> None:
    """Print the tables."""
    options = arguments(__doc__, data=DATA, recordings=",".join(AIR))
    names, data = options.recordings.split(","), options.data
    lifted, _ = calibrated(data, FITS["lift"])
    rows = []
    for name in names:
        for common, fit in FITS.items():
            file, finger = calibrated(data, fit)
            origin = file.origin if name == "full" else origin_of(data, name, lifted)
            frames = located(data, name, file, finger, origin, common == "offset")
            rows += [[name, common, part, *counted(frames, kept)] for part, kept in parts(frames, True).items()]
    held = []
    for skin, (text, fit) in SKINS.items():
        for how in HELD:
            file, finger = calibrated(data, fit, text, how)
            for name in names:
                origin = file.origin if name == "full" else origin_of(data, name, file)
                frames = located(data, name, file, finger, origin)
                told = [[skin, name, how, part, *counted(frames, kept)] for part, kept in parts(frames, False).items()]
                held += told
    tables = [
        ("Raw frames", ["recording", "in common", "indenter", *HEADS], rows),
        ("Held presses undone", ["skin", "recording", "what a hold leaves", "indenter", *HEADS], held),
    ]
    for title, heads, told in tables:
        show(title, heads, told)
    if options.json:
        kept = {title: [dict(zip(heads, row, strict=True)) for row in told] for title, heads, told in tables}
        options.json.write_text(json.dumps(kept, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
