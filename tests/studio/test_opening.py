"""The command: it says where the page is, answers there, and ends with Ctrl-C."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time

import httpx
import pytest

from subskin.cli import main
from subskin.studio.opening import bound


@pytest.mark.skipif(os.name != "posix", reason="Ctrl-C is sent as a signal")
def test_the_command_serves_until_it_is_stopped(tmp_path):
    env = {**os.environ, "XDG_STATE_HOME": str(tmp_path)}
    command = [sys.executable, "-m", "subskin", "studio", "--no-browser", "--host-port", "0"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=env) as running:
        assert running.stderr is not None
        address = re.search(r"http://127\.0\.0\.1:\d+/\?token=\w+", running.stderr.readline())
        assert address is not None
        for _ in range(100):
            try:
                page = httpx.get(address[0], follow_redirects=True)
                break
            except httpx.ConnectError:
                time.sleep(0.1)
        assert "subskin <b>studio</b>" in page.text
        running.send_signal(signal.SIGINT)
        assert running.wait(30) == 0


def test_what_cannot_be_opened_is_said(capsys):
    assert main(["studio", "nowhere.toml", "--no-browser"]) == 2
    assert "there is no such file" in capsys.readouterr().err
    with bound(0) as taken:
        taken.listen()
        assert main(["studio", "--no-browser", "--host-port", str(taken.getsockname()[1])]) == 2
    assert "another program has it" in capsys.readouterr().err
