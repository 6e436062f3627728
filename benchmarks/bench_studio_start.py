"""From `subskin studio` to the page: on a fresh machine, and each time after that.

Installs the checkout with its extra `studio` into a virtual environment of its own, and starts it there: cold, with
no loop compiled, and then warm. Says when the page is served, when its first picture is there, and when the answer. A
picture is wanted within 15 seconds of a cold start, and 5 of a warm one. Nothing of the environment is left.
"""

from __future__ import annotations

import json
import os
import re
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request
import venv
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

HERE = Path(__file__).resolve().parent.parent
WARM = 3


def asked(socket: ClientConnection, **what: Any) -> dict[str, Any]:
    """What a page is answered."""
    socket.send(json.dumps({"id": 1, **what}))
    data = socket.recv(600)
    assert isinstance(data, bytes)
    (length,) = struct.unpack("<I", data[:4])
    said: dict[str, Any] = json.loads(data[4 : 4 + length])
    assert "error" not in said, said["error"]
    return said


class Cookie(urllib.request.HTTPRedirectHandler):
    """Keeps the cookie that the first page sets."""

    def redirect_request(self, request: Any, answer: Any, code: int, words: str, headers: Any, url: str) -> Any:
        """Go on with it."""
        self.cookie = headers["set-cookie"].partition(";")[0]
        return urllib.request.Request(url, headers={"cookie": self.cookie})


def started(command: Path, folder: Path) -> list[float]:
    """Seconds from the command to the page, to its picture, and to the answer."""
    began = time.perf_counter()
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "NUMBA"))} | {"HOME": str(folder)}
    server = subprocess.Popen(
        [command, "studio", "--no-browser"], stderr=subprocess.PIPE, text=True, cwd=folder, env=environment
    )
    times = []
    try:
        assert server.stderr is not None
        address = next(found[0] for line in server.stderr if (found := re.search(r"http://\S+", line)))
        kept = Cookie()
        opener = urllib.request.build_opener(kept)
        while True:
            try:
                opener.open(address).read()
                break
            except urllib.error.URLError:  # the socket listens, and the server does not answer yet
                time.sleep(0.02)
        times.append(time.perf_counter() - began)
        base = address.partition("/?")[0]
        with connect(
            base.replace("http", "ws") + "/socket",
            origin=base,
            additional_headers={"cookie": kept.cookie},
            max_size=None,
        ) as socket:
            text = asked(socket, view="finger", do="begin")["begin"]["text"]
            state = asked(socket, view="finger", do="look", state={"text": text})["state"]
            times.append(time.perf_counter() - began)
            assert asked(socket, view="answer", do="find", state=state)["found"]["status"] == "OK"
            times.append(time.perf_counter() - began)
    finally:
        server.terminate()
        server.wait()
    return times


def main() -> None:
    """Run it."""
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        binaries = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        began = time.perf_counter()
        install = [binaries / "python", "-m", "pip", "install", "--quiet", f"{HERE}[studio]"]
        subprocess.run(install, check=True, stdout=sys.stderr)
        print(f"installed in {time.perf_counter() - began:.0f} s")
        print("seconds to      page   picture    answer")
        for k in range(1 + WARM):
            page, picture, answer = started(binaries / "subskin", folder)
            print(f"{'warm' if k else 'cold':10s}{page:10.2f}{picture:10.2f}{answer:10.2f}", flush=True)


if __name__ == "__main__":
    main()
