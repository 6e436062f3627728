"""How far a command, and a drag in the studio, walk through the house: files, functions, calls, moves between files.

    python benchmarks/study_trace.py [--frames 100] [--json FILE]

The command is `subskin locate finger.toml readings.csv -o out.csv`, of a finger of 6 sensors. The drag is one move of
the touch on the studio's page, from the message of the page to the frame that answers it. Counted by `sys.setprofile`
are calls of functions of subskin, when its modules have been read and the loops compiled by one run before; a move is a
call from one of its files to another. Asked for: of the command at most 28 files and 150 moves, of the drag 18 and 110.
The last column says how few files of at most 400 lines could hold these ones, whatever belongs together.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections import Counter
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from _common import arguments, show

_LONGEST = 400
FINGER = """
[skin]
kind = "half_plane"
young = "0.4 MPa"

[sensors]
count = 6
pitch = "1.5 mm"
depth = "2 mm"
noise = 5e-4
"""


def traced(run: Any, root: str) -> tuple[Counter[str], Counter[str], int]:
    """Calls by file and by function, and moves between files."""
    files: Counter[str] = Counter()
    functions: Counter[str] = Counter()
    moves, stack = 0, [""]

    def profile(frame: FrameType, event: str, _: Any) -> None:
        nonlocal moves
        name = frame.f_code.co_filename
        if event not in ("call", "return") or not name.startswith(root) or frame.f_code.co_name == "<module>":
            return
        name = name.removeprefix(root).lstrip("/")
        if event == "call":
            files[name] += 1
            functions[f"{name}:{frame.f_code.co_qualname}"] += 1
            moves += name != stack[-1]
            stack.append(name)
        elif len(stack) > 1:
            stack.pop()

    sys.setprofile(profile)
    try:
        run()
    finally:
        sys.setprofile(None)
    return files, functions, moves


def drag() -> tuple[Any, Any]:
    """What a move of the hand runs, and what ends the studio."""
    from subskin.studio.client import answered, framed, request_of
    from subskin.studio.finger import EXAMPLE
    from subskin.studio.studio import Studio

    studio = Studio()
    touch = {"family": "hertz", "force": 40.0, "angle": 0.2, "position": [1e-3], "half_width": 6e-4}
    asked = {"id": 7, "view": "finger", "do": "look", "state": {"text": EXAMPLE, "touch": touch}}
    text = json.dumps({**asked, "how": {"moving": True}})
    studio.answer("answer", "find", {"state": asked["state"]})

    def run() -> bytes:
        request = request_of(text)
        said, fields = answered(studio.answer, request)
        if "error" in said:
            raise SystemExit(said["error"])
        return framed({**said, "id": request.number, "view": request.view}, fields)

    return run, studio.close


def told(title: str, found: tuple[Counter[str], Counter[str], int], root: str, target: Path | None) -> None:
    """Print what was counted."""
    files, functions, moves = found
    lines = sum(len((Path(root) / name).read_text(encoding="utf-8").splitlines()) for name in files)
    full = -(-lines // _LONGEST)
    show(
        title,
        ["files", "functions", "calls", "moves between files", "lines of the files", f"files of {_LONGEST} lines"],
        [[str(n) for n in (len(files), len(functions), files.total(), moves, lines, full)]],
        target,
    )
    show(f"{title}: calls by file", ["file", "calls"], [[name, str(n)] for name, n in files.most_common()], target)


def main() -> None:
    """Run and print."""
    import subskin
    from subskin.cli import main as subskin_main
    from subskin.io.finger_file import load

    options = arguments(__doc__, frames=100)
    root = str(Path(subskin.__file__).parent)
    with tempfile.TemporaryDirectory() as folder:
        toml, table, out = (Path(folder) / name for name in ("finger.toml", "readings.csv", "out.csv"))
        toml.write_text(FINGER)
        finger = load(toml)
        finger = getattr(finger, "finger", finger)
        position = np.random.default_rng(0).uniform(-3e-3, 3e-3, options.frames)
        readings = finger.read(subskin.LineLoad(20.0, angle=0.2, position=position), rng=np.random.default_rng(1))
        head = ",".join(f"s{i}" for i in range(readings.shape[1]))
        np.savetxt(table, readings, delimiter=",", header=head, comments="")
        command = ["locate", str(toml), str(table), "-o", str(out)]
        if subskin_main(command):
            raise SystemExit("subskin locate failed")
        found = traced(lambda: subskin_main(command), root)
    told(f"subskin locate, {options.frames} frames", found, root, options.json)
    run, end = drag()
    run()
    told("A drag in the studio", traced(run, root), root, options.json)
    end()


if __name__ == "__main__":
    main()
