"""What the 95 % band of an image of the pressure holds, beneath random touches, by the array's size, drag and noise.

    python benchmarks/study_pressure_band.py [--touches 40] [--largest 32] [--json FILE]

Barometers on a square grid 0.75 depths apart, beneath round Hertz contacts, even rectangular patches (half widths 1
and 0.5 to 1), and two round contacts of other sizes; half widths of 1 to 4 pitches, in the array as far as they fit.
Noise in shares of each touch's largest reading; a drag of 17 degrees in a random direction. Told by the sort of touch:
the error's rms beneath the touch, in shares of its largest pressure; the mean width of the band over this rms, 3.9 of a
Gaussian error; and the share of the pressed nodes, whose true pressure is in the band. Frames without an image (of
status UNEXPLAINED) are left out of these; OK is the share of the frames with this status. The last column is the
processor time of the band, which comes when it is asked for.

Another version's band is measured by PYTHONPATH=TREE/src.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time

import numpy as np

import subskin as ss
from _common import arguments, show

DEPTH = 2e-3
PITCH = 0.75 * DEPTH
LARGEST = 1e4  # reading, Pa
SORTS = ("round", "patch", "two")


def touch(sort: str, side: int, rng: np.random.Generator, angle: float) -> ss.contact.Contact:
    """One touch of a sort within the array."""
    lean = {"angle": angle, "azimuth": rng.uniform(-np.pi, np.pi)}
    half = 0.5 * (side - 1) * PITCH

    def place(width: float) -> np.ndarray:
        return rng.uniform(-1, 1, 2) * max(half - width, 0.0)

    a, b = rng.uniform(1, 4, 2) * PITCH
    if sort == "round":
        return ss.RoundHertz(1.0, position=place(a), half_width=a, **lean)
    if sort == "patch":
        return ss.Patch(1.0, position=place(a), half_widths=a * rng.uniform(0.5, 1.0, 2), **lean)
    a, b = min(a, 0.45 * half), min(b, 0.45 * half)
    one, other = place(a), place(b)
    while np.hypot(*(one - other)) < a + b:
        one, other = place(a), place(b)
    force = rng.uniform(0.3, 1.0) * (b / a) ** 2
    return ss.RoundHertz(1.0, position=one, half_width=a, **lean) + ss.RoundHertz(
        force, position=other, half_width=b, **lean
    )


def study(side: int, shear: str, noise: float, sort: str, count: int) -> dict[str, float]:
    """The shares and sizes of one sort of touch."""
    rng, pad = np.random.default_rng(0), finger(side, noise)
    drawn = [touch(sort, side, rng, 0.3 * (shear != "none")) for _ in range(count)]
    clean = np.stack([pad.read(one) for one in drawn])
    scale = LARGEST / np.abs(clean).max(axis=1)
    frames = clean * scale[:, None] + noise * LARGEST * rng.standard_normal(clean.shape)
    found = ss.pressure_map(pad, frames, shear=shear)
    start = time.process_time()
    low, high = np.moveaxis(found.pressure_interval, -1, 0)
    took = (time.process_time() - start) / count
    at = np.meshgrid(found.y, found.z, indexing="ij")
    true = np.stack([one.pressure(*at) for one in drawn]) * scale[:, None, None]
    there, peak = np.isfinite(found.normal_force), true.max(axis=(1, 2), keepdims=True)
    on, held = (true > 0) & there[:, None, None], (low <= true) & (true <= high)
    return {
        "ok": float((found.status == ss.Status.OK).mean()),
        "rms": float(np.sqrt((((found.pressure - true) / peak)[on] ** 2).mean())),
        "width": float(((high - low) / peak)[on].mean()),
        "held": float(held[on].mean()),
        "beside": float(held[(true == 0) & there[:, None, None]].mean()),
        "ms": 1e3 * took,
    }


_FINGERS: dict[tuple[int, float], ss.Finger] = {}


def finger(side: int, noise: float) -> ss.Finger:
    """Kept, with its mapper."""
    if (side, noise) not in _FINGERS:
        _FINGERS.clear()
        array = ss.SensorArray.grid((side, side), PITCH, DEPTH, transducer=ss.MeanPressure(), noise=noise * LARGEST)
        _FINGERS[side, noise] = ss.Finger(ss.HalfSpace(ss.Material(young=0.4e6)), array)
    return _FINGERS[side, noise]


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, touches=40, largest=32)
    rows = []
    for side in (8, 16, 32):
        for shear in ("none", "proportional"):
            for noise in (1e-3, 1e-2):
                if side <= options.largest:
                    rows.append(row(side, shear, noise, options.touches))
    head = ["sensors", "shear", "noise", "OK", "rms: round, patch, two", "width / rms", "in band", "all: width / rms"]
    show("band of the pressure on an area", [*head, "in band", "not pressed, in band", "band, ms"], rows)


def row(side: int, shear: str, noise: float, count: int) -> list[str]:
    """All sorts of touch on one array."""
    each = [study(side, shear, noise, sort, count) for sort in SORTS]
    mean = {name: float(np.mean([one[name] for one in each])) for name in each[0]}
    whole = mean["width"] / float(np.sqrt(np.mean([one["rms"] ** 2 for one in each])))
    return [
        f"{side} x {side}", shear, f"{100 * noise:g} %", f"{mean['ok']:.2f}",
        ", ".join(f"{one['rms']:.3f}" for one in each),
        ", ".join(f"{one['width'] / one['rms']:.1f}" for one in each),
        ", ".join(f"{one['held']:.3f}" for one in each),
        f"{whole:.1f}", f"{mean['held']:.3f}", f"{mean['beside']:.3f}", f"{mean['ms']:.1f}",
    ]  # fmt: skip


if __name__ == "__main__":
    main()
