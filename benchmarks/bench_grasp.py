"""Skins in MuJoCo: what a frame of a pad takes, and environments with skins beside the same without.

    python benchmarks/bench_grasp.py [--envs 64] [--steps 60] [--repeats 3] [--json FILE]

A frame: `GeomSkin.feel`, which makes a pressure of the contacts, and `read`, its readings, of a pad that holds a box, a
bottle and a ball; medians of 1000. Environments: `subskin/Grasp-v0`, half of them in each of two processes, one after
the other in each; they grip and lift. Without skins nothing is observed; the kinds take turns, and the median counts.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from concurrent.futures import ProcessPoolExecutor
from functools import partial
from time import perf_counter
from typing import Any

import mujoco
import numpy as np

import subskin as ss
from _common import arguments, show
from subskin.grasp import gripper_xml, pad_finger, things
from subskin.grasp.environment import GraspEnv
from subskin.mujoco import GeomSkin

KINDS = ("without skins", "forces", "frames", "estimates")


class Blind(GraspEnv):
    """The same without an observation."""

    def _seen(self) -> Any:
        return np.zeros(10, np.float32)


def median_us(call: Any, count: int = 1000) -> float:
    """Of a call [us]."""
    taken = []
    for _ in range(count):
        start = perf_counter()
        call()
        taken.append(perf_counter() - start)
    return 1e6 * float(np.median(taken))


def frames() -> list[list[str]]:
    """Of each thing and board."""
    strain = ss.SensorArray.grid((32, 32), 0.5e-3, depth=1e-3, noise=2e-4)
    boards = {"4 x 4 magnets, 48 readings": pad_finger(), "32 x 32 gauges": ss.Finger(pad_finger().skin, strain)}
    rows = []
    for name, finger in boards.items():
        for thing in things(3):
            model = mujoco.MjModel.from_xml_string(gripper_xml(thing))
            data = mujoco.MjData(model)
            skin = GeomSkin(model, "left_pad", finger, "+x")
            data.ctrl[1:] = 3.0
            mujoco.mj_step(model, data, 400)
            felt = skin.feel(data)
            physics = median_us(partial(mujoco.mj_step, model, mujoco.MjData(model)))
            parts = median_us(partial(skin.feel, data)), median_us(felt.read), physics
            rows.append([f"{name}, {thing.shape}", *(f"{part:.0f}" for part in parts)])
    return rows


def steps(kind: str, envs: int, count: int) -> float:
    """Steps a second of some environments in this process, resets left out."""
    made = [Blind("forces") if kind == KINDS[0] else GraspEnv(kind) for _ in range(envs)]
    for i, env in enumerate(made):
        env.reset(seed=i)
        env.step(np.array([-0.5, 0.0], np.float32))
    start = perf_counter()
    for step in range(count):
        action = np.array([-0.5, 0.0 if step < 15 else 0.3], np.float32)
        for env in made:
            env.step(action)
    return envs * count / (perf_counter() - start)


def main() -> None:
    """Both tables."""
    told = arguments(__doc__, envs=64, steps=60, repeats=3)
    heads = ["pad, thing", "feel [us]", "read [us]", "a step of the physics [us]"]
    show("A frame of one pad", heads, frames(), told.json)
    found: dict[str, list[float]] = {kind: [] for kind in KINDS}
    with ProcessPoolExecutor(2) as pool:
        for _ in range(told.repeats + 1):
            for kind in KINDS:
                halves = pool.map(partial(steps, kind, count=told.steps), [told.envs // 2] * 2)
                found[kind].append(sum(halves))
    best = {kind: float(np.median(each[1:])) for kind, each in found.items()}  # the first one prepares
    rows = [[kind, f"{each:.0f}", f"{each / best[KINDS[0]]:.2f}"] for kind, each in best.items()]
    show(f"{told.envs} environments on two cores", ["observation", "steps/s", "share"], rows, told.json)


if __name__ == "__main__":
    main()
