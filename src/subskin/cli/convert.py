"""`subskin convert`: a recording -> another file; a bag of ROS -> a recording."""

from __future__ import annotations

import argparse
import sys
from typing import Any, TextIO

from ..errors import FileError, printable
from .common import add_json, describe, give

_EXAMPLES = """\
  subskin convert touch.parquet touch.csv
  subskin convert touch.parquet touch.mcap --topic /left/finger
  subskin convert touch.parquet touch_bag --to rosbag2
  subskin convert touch.parquet touch_set --to lerobot --fps 30 --task "pick up the cup"
  subskin convert robot.mcap touch.parquet --topic /left/tactile --finger finger.toml
"""
_NOTES = """\
The ending of the new file names its format: .parquet, .csv, .mcap; or --to does. rosbag2 and lerobot are folders.
A bag (.mcap, .bag, .db3, or a folder of rosbag2) becomes a recording without estimates: `subskin replay` makes these.
MCAP and bags need `pip install "subskin[log]"`.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("recording", metavar="FILE", help="the recording, or a bag")
    parser.add_argument("out", metavar="NEW", help="the new file or folder")
    parser.add_argument("--to", choices=("parquet", "csv", "mcap", "rosbag2", "lerobot"), help="format of the new file")
    parser.add_argument(
        "--topic", metavar="NAME", help="what the topics begin with (/subskin); of a bag, the one to read"
    )
    parser.add_argument("--fps", type=float, metavar="RATE", help="ticks a second of lerobot (30)")
    parser.add_argument("--task", metavar="TEXT", help="what was done, for lerobot (touch)")
    parser.add_argument("--finger", metavar="FILE", help="finger.toml of the frames in a bag")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.convert import check_kind, convert
    from ..live.sinks.bags import is_bag, read_bag

    kind = check_kind(options.out, options.to)
    told: dict[str, Any] = {"out": options.out, "kind": kind}
    if is_bag(options.recording):
        from .. import io

        given = {name: value for name in ("fps", "task") if (value := getattr(options, name)) is not None}
        if kind != "parquet" or given:
            fix = f"subskin convert {options.recording} touch.parquet, and that one to {kind}"
            raise FileError(options.recording, "a bag becomes a recording first, Parquet", fix)
        file = None if options.finger is None else io.load(options.finger)
        told["frames"], told["left"] = read_bag(options.recording, options.out, options.topic, file)
    else:
        if options.finger is not None:
            raise FileError(f"--finger {options.finger}", "a recording has its finger", "subskin replay --finger")
        names = ("topic", "fps", "task")
        chosen = {name: value for name in names if (value := getattr(options, name)) is not None}
        convert(options.recording, options.out, kind, **chosen)
        if kind in ("mcap", "rosbag2"):
            _warn_of_newtons(options.recording)

    def people(out: TextIO) -> None:
        frames = f"{told['frames']} frames " if "frames" in told else ""
        print(f"{frames}-> {printable(options.out)}", file=out)
        if told.get("left"):
            print(f"could not be read: {printable(told['left'])}", file=out)

    return give(options, lambda: told, people)


def _warn_of_newtons(path: str) -> None:
    from ..live.recording import opened

    with opened(path) as recording:
        if not recording.about.newtons:
            relative = recording.about.relative
            said = "multiples of the load of a calibration's touches" if relative else "in N/m, of long contacts"
            what = f"forces are {said}, and no WrenchStamped is written"
            better = "touches of known force" if relative else '[touch] length = "10 mm" in the finger file'
            fix = f"{better}, and subskin replay --finger finger.toml -o new.parquet"
            print(f"subskin: warning: {printable(path)}: {what}. Fix: {fix}", file=sys.stderr)
