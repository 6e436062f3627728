"""How near `Finger.locate` comes to the Cramer-Rao bound, beside multi-start least squares on the same frames.

    python benchmarks/bench_accuracy.py [--frames 400000] [--peer 400] [--json FILE]

Errors over the frames of status OK: rms error / rms bound, the share inside the 95 % interval, the share of frames
said to be ambiguous, and gross errors (beyond 6 standard deviations and 0.1 depth) that were not. Asked for: at most
1.03, 94 to 96 %, and at most 1e-4.
"""

from __future__ import annotations

import numpy as np

import subskin as ss
from _common import arguments, bound, finger, multi_start, search, show, touches


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=400_000, peer=400)
    rows, peers = [], []
    for sensors in (4, 8):
        for pitch in (0.5, 0.75, 1.0):
            for noise in (1e-3, 1e-2):
                tip, ends = finger(sensors, pitch, noise), search(sensors, pitch)
                load = touches(sensors, pitch, options.frames, seed=sensors)
                frames = tip.read(load, np.random.default_rng(1))
                found = tip.locate(frames, search=ends)
                ok = found.status == ss.Status.OK
                truth = np.stack([load.position, load.force, load.angle], -1)
                error = np.stack([found.position, found.force, found.angle], -1) - truth
                variance = np.diagonal(bound(tip, load), axis1=1, axis2=2)
                ratio = np.sqrt((error[ok] ** 2).mean(0) / variance[ok].mean(0))
                inside = (np.abs(error[ok]) < 1.959964 * found.std[ok]).mean(0)
                gross = (np.abs(error[:, 0]) > 6 * found.std[:, 0]) & (np.abs(error[:, 0]) > 0.1)
                name = f"{sensors}, {pitch} depth, {noise:.1%}"
                rows.append(
                    [
                        name,
                        *(f"{r:.3f}" for r in ratio),
                        *(f"{100 * c:.2f}" for c in inside),
                        f"{(found.status == ss.Status.AMBIGUOUS).mean():.2%}",
                        f"{(gross & ok).mean():.1e}",
                    ]
                )
                peer = np.array([multi_start(tip, f, ends) for f in frames[: options.peer]])
                theirs, ours, few = peer - truth[: options.peer], error[: options.peer], ok[: options.peer]
                scale = np.sqrt(variance[: options.peer].mean(0))
                peers.append(
                    [name]
                    + [f"{v:.3f}" for v in np.sqrt((ours[few] ** 2).mean(0)) / scale]
                    + [f"{v:.3f}" for v in np.sqrt((theirs[few] ** 2).mean(0)) / scale]
                    + [f"{(np.abs(theirs[:, 0]) > 0.1).mean():.2%}"]
                )
    heads = ["position", "force", "angle"]
    columns = [
        "OK frames",
        *(f"{h} / bound" for h in heads),
        *(f"{h} in 95 %" for h in heads),
        "ambiguous",
        "gross, unflagged",
    ]
    show(f"Accuracy of locate, {options.frames} frames each", columns, rows, options.json)
    columns = [
        "the same OK frames",
        *(f"locate: {h}" for h in heads),
        *(f"8 starts: {h}" for h in heads),
        "8 starts: off by > 0.1 depth",
    ]
    show(
        f"rms error / rms bound beside least_squares from 8 starts, {options.peer} frames each",
        columns,
        peers,
        options.json,
    )


if __name__ == "__main__":
    main()
