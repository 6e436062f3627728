"""Skins beside the half plane: tabulating a finger's receptive fields, and `locate` on them.

    python benchmarks/bench_skins.py [--frames 20000] [--repeats 20] [--json FILE]

Eight sensors at unit depth, half a depth apart, noise 0.1 % and 1 % of the strain beneath a unit load on the half
plane; unit loads over the array within 40 degrees. Asked for: tabulating in at most 1 s, then kept; the same accuracy
(rms error over the Cramer-Rao bound, coverage of the 95 % intervals) and the same speed on every skin.
"""

from __future__ import annotations

import time

import numpy as np

import subskin as ss
from _common import FULL_SCALE, arguments, bound, search, show, touches

COUNT, SPACING = 8, 0.5
RUBBER, FIRM = ss.Material(1.0), ss.Material(10.0, 0.4)
SKINS = {
    "half plane": ss.HalfPlane(RUBBER),
    "bonded layer, 2.5 depths": ss.Layered(ss.Layer(RUBBER, 2.5)),
    "bonded layer, 1.2 depths, nu 0.45": ss.Layered(ss.Layer(ss.Material(1.0, 0.45), 1.2)),
    "firm 0.2 on soft 2.5 on rigid": ss.Layered([ss.Layer(FIRM, 0.2), ss.Layer(RUBBER, 2.5)]),
    "soft 2.5 on a firm half plane": ss.Layered(ss.Layer(RUBBER, 2.5), FIRM),
    "round, radius 6, core 3": ss.Round(RUBBER, 6.0, 3.0),
    "round, radius 4, core 2.5": ss.Round(RUBBER, 4.0, 2.5),
}


def seconds(call, repeats: int) -> np.ndarray:
    """Time of each of `repeats` calls."""
    out = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        out.append(time.perf_counter() - start)
    return np.array(out)


def main() -> None:
    """Run and print."""
    options = arguments(__doc__, frames=20_000, repeats=20)
    tables, answers = [], []
    ends = search(COUNT, SPACING)
    ss.HalfPlane(RUBBER).state(ss.LineLoad(1.0), 1.0, 0.0)
    for name, skin in SKINS.items():
        for noise in (1e-3, 1e-2):
            array = ss.SensorArray.line(COUNT, pitch=SPACING, depth=1.0, noise=noise * FULL_SCALE)
            tip = ss.Finger(skin, array)
            first = seconds(lambda tip=tip: tip.tabulate(ends), 1)[0]
            table = tip.tabulate(ends)
            if noise == 1e-3:
                again = np.median(seconds(lambda tip=tip: tip.tabulate(ends), 100))
                positions = np.random.default_rng(5).uniform(*ends, 200)
                exact = tip.receptive_field(positions)
                off = np.abs(table(positions) - exact).max() / np.abs(exact).max()
                tables.append([name, f"{first:.2f}", f"{1e6 * again:.1f}", f"{off:.0e}"])
            load = touches(COUNT, SPACING, options.frames, seed=3)
            frames = tip.read(load, np.random.default_rng(1))
            locator = tip.locator(search=ends)
            found = locator(frames)
            ok = found.status == ss.Status.OK
            truth = np.stack([load.position, load.force, load.angle], -1)
            error = np.stack([found.position, found.force, found.angle], -1) - truth
            variance = np.diagonal(bound(tip, load), axis1=1, axis2=2)
            ratio = np.sqrt((error[ok] ** 2).mean(0) / variance[ok].mean(0))
            inside = (np.abs(error[ok]) < 1.959964 * found.std[ok]).mean(0)
            many, one = np.tile(frames, (5, 1)), frames[0].copy()
            batch = len(many) / np.median(seconds(lambda locator=locator, many=many: locator(many), options.repeats))
            single = np.median(seconds(lambda locator=locator, one=one: locator(one), 100 * options.repeats))
            shares = [*(f"{r:.3f}" for r in ratio), *(f"{100 * c:.1f}" for c in inside), f"{np.mean(~ok):.2%}"]
            answers.append([f"{name}, {noise:.1%}", *shares, f"{batch / 1e6:.2f}", f"{1e6 * single:.1f}"])
    show(
        "Tabulating the receptive fields of eight sensors",
        ["skin", "first, s", "kept, us", "off the skin itself"],
        tables,
        options.json,
    )
    show(
        f"locate, {options.frames} frames: rms error / bound of position y, force P and angle, share in 95 %, speed",
        ["skin, noise", "y", "P", "angle", "y, 95 %", "P", "angle", "not OK", "M frames/s", "one, us"],
        answers,
        options.json,
    )


if __name__ == "__main__":
    main()
