"""A stretch of a live stream as a chain hands it to a recorder, made without a chain."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

import subskin as ss

TEXT = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 4
pitch = "2 mm"
depth = "2 mm"
noise = 1e-4

[touch]
length = "10 mm"
"""
CHANNELS = ("p0", "p1", "p2", "p3")
BOARD = SimpleNamespace(channels=CHANNELS, name="csv")


def step(host_time, raw=None, **told):
    """What comes out of a chain for some frames, or of a step without any."""
    raw = np.empty((0, len(CHANNELS))) if raw is None else np.asarray(raw, dtype=float)
    n = len(raw)
    usual = {
        "host_time": host_time, "command": "", "values": {}, "time": host_time - 1e-3 * np.arange(n)[::-1],
        "device_time": np.full(n, np.nan), "sequence": np.full(n, -1), "raw": raw, "readings": raw - 5.0,
        "free": np.zeros(n, dtype=bool), "lost": 0, "bad": 0, "found": None, "decision": None, "events": (),
    }  # fmt: skip
    return SimpleNamespace(**{**usual, **told})


def event(kind, time, **values):
    return SimpleNamespace(kind=kind, time=time, frame=3, text=f"{kind} at {time}", values=values)


def stream(file: ss.io.FingerFile, steps: int = 12, frames: int = 5):
    """Steps with frames, of which every third presses; one without frames; a command; events; what is no number."""
    rng = np.random.default_rng(3)
    locate = file.locator()
    out = []
    for i in range(steps):
        force = 40.0 * (i % 3 == 2)
        readings = file.finger.read(ss.LineLoad(np.full(frames, force), position=0.4e-3), rng)
        raw = readings + 5.0
        told = {"events": (event("contact_on", 0.01 * i, force=np.float64(force), far=np.inf),)} if force else {}
        made = step(10.0 + 0.01 * i, raw, readings=readings, found=locate(readings), lost=i % 2, bad=i % 5, **told)
        made.sequence, made.free = np.arange(frames) + frames * i, np.full(frames, not force)
        out.append(made)
    out[1].raw[0, :2] = np.nan, -0.0
    out[1].device_time = np.arange(frames) / 3
    out.insert(4, step(10.035, lost=2))
    out.insert(7, step(10.065, command="zero", values={"why": "asked"}, events=(event("zeroed", 10.065),)))
    return out
