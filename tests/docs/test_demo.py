"""`make demo`: the program that it runs does the main job, in seconds, and leaves what it says."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str, float]:
    out = tmp_path_factory.mktemp("demo") / "results"
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    start = time.monotonic()
    done = subprocess.run(
        ["bash", "examples/demo.sh", str(out)], cwd=ROOT, env={**os.environ, "PATH": path},
        capture_output=True, text=True, timeout=300, check=True,
    )  # fmt: skip
    return out, done.stdout, time.monotonic() - start


def test_the_presses_held_out_are_located(demo: tuple[Path, str, float]) -> None:
    with (demo[0] / "located.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [int(row["row"]) for row in rows] == list(range(1, 61, 2))
    assert {row["status"] for row in rows} == {"ok"}
    # the truth comes from the recording's motor, so this compares with what was simulated, half a millimetre apart
    error = np.array([float(row["position"]) for row in rows]) - np.arange(2.8e-3, 32.3e-3, 1e-3)
    assert np.median(np.abs(error)) < 0.03e-3
    assert np.abs(error).max() < 0.15e-3


def test_touches_on_an_area_are_located(demo: tuple[Path, str, float]) -> None:
    assert (demo[0] / "area.png").stat().st_size > 10_000
    found = re.search(r"median ([\d.]+) mm, worst ([\d.]+) mm, of (\d+) ok touches", demo[1])
    assert found is not None
    median, worst, count = (float(number) for number in found.groups())
    assert 0 < median < 0.05
    assert worst < 0.3
    assert count >= 35


def test_the_dead_sensor_is_named_and_left_out(demo: tuple[Path, str, float]) -> None:
    assert "dead: p3" in demo[1]
    with (demo[0] / "located.csv").open() as file:
        assert {row["used"] for row in csv.DictReader(file)} == {"p0 p1 p2 p4 p5"}


def test_the_origin_is_found(demo: tuple[Path, str, float]) -> None:
    line = next(line for line in (demo[0] / "calibrated.toml").read_text().splitlines() if "origin" in line)
    assert abs(float(line.split('"')[1].removesuffix(" mm")) - 17.3) < 0.02


def test_a_figure_is_drawn_and_it_all_takes_seconds(demo: tuple[Path, str, float]) -> None:
    assert (demo[0] / "truth.png").read_bytes().startswith(b"\x89PNG")
    assert demo[2] < 120  # alone on a machine: some 6 s
