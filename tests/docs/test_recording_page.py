"""The worked example of docs/recording.md, command by command, on the recording of a real skin."""

from __future__ import annotations

import contextlib
import json
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from .._commands import subskin

ROOT = Path(__file__).parents[2]
REAL = ROOT.parent / "shared/data/barotact/test_full_20230706_175400.csv"
PAGE = (ROOT / "docs/recording.md").read_text("utf-8")

pytestmark = pytest.mark.skipif(not REAL.exists(), reason="the recording, which cannot be shipped, is not at hand")


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict]:
    """What each command of the page prints with --json; the one that simulates is replaced by the recording."""
    folder = tmp_path_factory.mktemp("page")
    shutil.copy(REAL, folder / "raw.csv")
    toml = re.search(r"<!-- file: finger.toml -->\n```toml\n(.*?)```", PAGE, re.DOTALL)
    assert toml
    (folder / "finger.toml").write_text(toml[1], encoding="utf-8")
    consoles = re.findall(r"```console\n(.*?)```", PAGE, re.DOTALL)
    lines = re.findall(r"^\$ (subskin (?:.*\\\n)*.*)$", "".join(consoles), re.MULTILINE)
    commands = [shlex.split(line.replace("\\\n", " ")) for line in lines]
    assert [c[1] for c in commands] == ["simulate", "segment", "calibrate", "locate", "calibrate", "locate"]
    printed = {}
    with contextlib.chdir(folder):
        for command in commands[1:]:
            done = subskin(*command[1:], "--json")
            assert done.code == 0, done.err
            printed[command[command.index("-o") + 1]] = json.loads(done.out)
    return printed


def test_sixty_presses_are_found(results: dict[str, dict]) -> None:
    found = results["presses.csv"]
    assert (found["presses"], found["skipped"]) == (60, 0)
    # the motor stepped half a millimetre a press
    assert np.allclose(np.diff(found["columns"]["position"]), 0.5e-3, atol=2e-6)


def test_the_fit_holds_on_presses_that_it_has_not_seen(results: dict[str, dict]) -> None:
    found = results["calibrated.toml"]
    assert (found["touches"], found["held_out"]) == (30, 30)
    assert found["r2_held_out"] >= 0.995
    assert not found["weak"]
    assert not found["dead"]


def test_the_others_are_located(results: dict[str, dict]) -> None:
    found = results["located.csv"]
    assert found["frames"] == 30
    assert found["status"]["ok"] >= 20
    assert found["against_truth"]["ok"]["median"] <= 0.06e-3
    assert found["against_truth"]["ok"]["worst"] <= 1e-3
    # what is wrong by more than 0.3 mm says so: it is ambiguous, or has such a standard error
    error, status = np.abs(np.array(found["columns"]["error"], float)), np.array(found["columns"]["status"])
    unsure = np.array(found["columns"]["position_std"], float) > error / 2
    assert set(status[(error > 0.3e-3) & ~unsure]) <= {"ambiguous"}


def test_three_presses_are_enough_for_the_origin(results: dict[str, dict]) -> None:
    assert results["today.toml"]["touches"] == 3
    moved = results["today.toml"]["origin"] - results["calibrated.toml"]["origin"]
    assert abs(moved) < 0.1e-3
    assert abs(results["today.csv"]["against_truth"]["ok"]["mean"]) <= 0.2e-3
    assert results["today.csv"]["against_truth"]["ok"]["median"] <= 0.06e-3


def test_the_numbers_on_the_page_are_those_measured(results: dict[str, dict]) -> None:
    claim = re.search(r"\$R\^2 = ([\d.]+)\$\s+on\s+the\s+(\d+)\s+presses\s+held\s+out", PAGE)
    assert claim
    assert f"{results['calibrated.toml']['r2_held_out']:.3f}" == claim[1]
    claim = re.search(r"(\d+)\s+are\s+`ok`,\s+with\s+a\s+median\s+error\s+of\s+([\d.]+)\s+mm", PAGE)
    assert claim
    ok = results["located.csv"]["against_truth"]["ok"]
    assert (ok["count"], f"{1e3 * ok['median']:.2f}") == (int(claim[1]), claim[2])
