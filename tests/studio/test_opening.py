"""The command: it says where the page is, answers there, and ends with Ctrl-C."""

from __future__ import annotations

import os
import re
import signal
import threading
import time

import httpx
import pytest

from subskin.cli import main
from subskin.studio.opening import bound


@pytest.mark.skipif(os.name != "posix", reason="Ctrl-C is sent as a signal")
def test_the_command_serves_until_it_is_stopped(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    heard, pages = [], []

    def visit():
        """What a browser does, and then Ctrl-C."""
        for _ in range(600):
            heard.append(capsys.readouterr().err)
            if address := re.search(r"http://127\.0\.0\.1:\d+/\?token=\w+", "".join(heard)):
                break
            time.sleep(0.05)
        for _ in range(100):
            try:
                pages.append(httpx.get(address[0], follow_redirects=True, verify=False).text)
                break
            except httpx.ConnectError:
                time.sleep(0.1)
        signal.raise_signal(signal.SIGINT)

    visitor = threading.Thread(target=visit, daemon=True)
    visitor.start()
    assert main(["studio", "--no-browser", "--host-port", "0"]) == 0
    visitor.join(10)
    assert "subskin <b>studio</b>" in pages[0]


def test_what_cannot_be_opened_is_said(capsys):
    assert main(["studio", "nowhere.toml", "--no-browser"]) == 2
    assert "there is no such file" in capsys.readouterr().err
    with bound(0) as taken:
        taken.listen()
        assert main(["studio", "--no-browser", "--host-port", str(taken.getsockname()[1])]) == 2
    assert "another program has it" in capsys.readouterr().err
