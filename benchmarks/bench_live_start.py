"""From pressing enter to a force in the terminal: `subskin live --port demo`, with no loop compiled yet, and again.

Each start is a process of its own in a terminal (a pty), with Numba's cache in a folder that is empty at first.
"""

from __future__ import annotations

import argparse
import os
import pty
import select
import sys
import tempfile
import time

from _common import show

MARKS = {"first picture [s]": b"NO_CONTACT", "first force [s]": b"force", "loops ready [s]": b"ready in"}


def started(cache: str) -> list[str]:
    """When each mark was seen, and what it cost."""
    began, seen, shown = time.monotonic(), dict.fromkeys(MARKS, float("nan")), b""
    child, terminal = pty.fork()
    if not child:
        os.environ["NUMBA_CACHE_DIR"] = cache
        command = [sys.executable, "-m", "subskin", "live", "--port", "demo", "--for", "3 s"]
        os.execv(command[0], command)
    while True:
        select.select([terminal], [], [])
        try:
            shown += os.read(terminal, 65536)
        except OSError:  # nobody holds it any more
            break
        for name, mark in MARKS.items():
            if seen[name] != seen[name] and mark in shown:
                seen[name] = time.monotonic() - began
    used = os.wait4(child, 0)[2]
    return [*(f"{at:.1f}" for at in seen.values()), f"{used.ru_utime + used.ru_stime:.1f}"]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    rows = []
    for _ in range(parser.parse_args().repeats):
        with tempfile.TemporaryDirectory() as cache:
            rows += [[name, *started(cache)] for name in ("first", "second")]
    show("subskin live --port demo", ["start", *MARKS, "CPU, 3 s shown [s]"], rows)


if __name__ == "__main__":
    main()
