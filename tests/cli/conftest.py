"""The command line run as its users run it, in this process or in one of its own."""

import os
import subprocess
import sys

import pytest

from .. import _commands

FINGER = """\
# a finger of four sensors
[skin]
young = "0.4 MPa"

[sensors]
count = 4
pitch = "6 mm"
depth = "5 mm"
gain = -1e5
offset = 1e5
noise = 5

[locate]
friction = 0
search = ["-12 mm", "12 mm"]

[recording]
sensors = ["p0", "p1", "p2", "p3"]
unit = "Pa"
time = { column = "time", unit = "s" }
position = { column = "x", unit = "1e-3 mm" }
press = { column = "z", unit = "1/320 mm" }
"""

ORIENTED = '\n[oriented]\ndate = "2026-11-27"\npresses = 2\n'
"""What `subskin orient` writes, without which some commands say that it is missing."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder with a finger.toml, which is the current one."""
    (tmp_path / "finger.toml").write_text(FINGER)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def subskin():
    """Runs the command line in this process."""
    return _commands.subskin


@pytest.fixture
def process():
    """Runs the command line in a process of its own."""

    def run(*arguments, **options):
        command = [sys.executable, "-m", "subskin", *map(str, arguments)]
        environment = {**os.environ, "PYTHONWARNINGS": "error"}
        return subprocess.run(
            command, check=False, capture_output=True, text=True, env=environment, timeout=120, **options
        )

    return run
