"""`Finger.fit` of rollers that stick in their middle: what `stick=` gains, with friction known, guessed, open or wrong.

    python benchmarks/study_stick.py [--frames 2000] [--json FILE]

Half plane, sensors 0.5 depth apart, noise in shares of the reading of a normal line load straight above; rollers of
half width 0.4 to 1.2 depths over the array, pressed and then dragged by |T| / (mu N) from 0 to 1 either way, mu = 0.6.
`drag` is the error of T in shares of mu N over the OK frames: its mean along the drag, its rms, and the median of the
standard deviation that is stated. `in 95 %`: how many true T and positions lie within 1.96 of these; `sure and wrong`:
the share of all frames that are OK and off by more than 5 of them in position, N, T or half width. "as slides" is the
plain fit of the same rollers when they slide, where the model has no error.
"""

from __future__ import annotations

import time

import numpy as np

import subskin as ss
from _common import arguments, show

MU = 0.6
CASES = ((5, 1e-3), (6, 1e-3), (6, 1e-2), (8, 1e-3), (8, 1e-2))
STICKS: dict[str, object] = {
    "slides (no stick)": None,
    "known, 0.6": MU,
    "guessed, 0.3 to 0.9": (0.3, 0.9),
    "open, 0.1 to 2": (0.1, 2.0),
    "wrong, 0.5": 0.5,
    "wrong, 0.8": 0.8,
}


def finger(sensors: int, noise: float) -> ss.Finger:
    """Unit depth, unit modulus."""
    array = ss.SensorArray.line(sensors, pitch=0.5, depth=1.0, noise=noise * 3 / (2 * np.pi))
    return ss.Finger(ss.HalfPlane(ss.Material(young=1.0)), array)


def row(tip: ss.Finger, frames: np.ndarray, truth: np.ndarray, stick: object) -> list[str]:
    """Statuses, errors and time of one way to fit `frames`, whose (y, N, T, a) is `truth`."""
    tip.fit(frames[:2], stick=stick)
    start = time.process_time()
    found = tip.fit(frames, stick=stick)
    took = (time.process_time() - start) / len(frames)
    error = np.column_stack([found.position, found.components, found.half_width]) - truth
    std = np.sqrt(np.stack([found.table[:, k] for k in np.diag(found.layout.square)], -1))
    ok = found.ok
    with np.errstate(invalid="ignore", divide="ignore"):
        off = np.abs(error / std)
    drag = error[ok, 2] / MU
    inside = (off[ok] < 1.96).mean(0)
    return [
        *(f"{(found.status == s).mean():.1%}" for s in (ss.Status.OK, ss.Status.AMBIGUOUS, ss.Status.UNEXPLAINED)),
        f"{(drag * np.sign(truth[ok, 2])).mean():+.4f}",
        f"{np.sqrt((drag**2).mean()):.4f}",
        f"{np.median(std[ok, 2]) / MU:.4f}",
        f"{inside[2]:.1%}",
        f"{inside[0]:.1%}",
        f"{(ok & (off > 5).any(-1)).mean():.2%}",
        f"{1e6 * took:.0f}",
    ]


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=2000)
    rows = []
    for sensors, noise in CASES:
        tip, rng, size = finger(sensors, noise), np.random.default_rng(5), options.frames
        half = float(np.asarray(tip.array.y).max())
        drag, y, a = MU * rng.uniform(-1, 1, size), rng.uniform(-half, half, size), rng.uniform(0.4, 1.2, size)
        load = {"force": np.hypot(1.0, drag), "angle": np.arctan(drag), "position": y, "half_width": a}
        errors = np.asarray(tip.array.noise) * rng.standard_normal((size, sensors))
        held, slid = tip.read(ss.PartialSlip(**load, friction=MU)) + errors, tip.read(ss.Hertz(**load)) + errors
        truth = np.column_stack([y, np.ones(size), drag, a])
        head = f"{sensors} sensors, {noise:.1%}"
        rows += [[head, name, *row(tip, held, truth, stick)] for name, stick in STICKS.items()]
        rows.append([head, "as slides", *row(tip, slid, truth, None)])
    columns = [
        "finger", "friction", "OK", "AMBIGUOUS", "UNEXPLAINED", "drag, mean", "drag, rms", "drag, std said",
        "T in 95 %", "position in 95 %", "sure and wrong", "us a frame",
    ]  # fmt: skip
    show("Rollers that stick in their middle", columns, rows, options.json)


if __name__ == "__main__":
    main()
