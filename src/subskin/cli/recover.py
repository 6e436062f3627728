"""`subskin recover`: what is left of a recording -> a recording."""

from __future__ import annotations

import argparse
from typing import TextIO

from ..errors import printable
from .common import add_json, describe, give

_EXAMPLES = """\
  subskin recover touch.parquet.arrows
  subskin recover touch.parquet.arrows -o saved.parquet
"""
_NOTES = """\
While `subskin live --record touch.parquet` records, the file is called touch.parquet.arrows. It stays behind where the
program was killed, or the power failed. Everything up to its last whole part can be read. The old file stays.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("recording", metavar="FILE.arrows", help="the recording that was not closed")
    parser.add_argument("-o", "--out", metavar="FILE", help="the new recording, Parquet (the name without .arrows)")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.recording import recover

    found = recover(options.recording, options.out)

    def people(out: TextIO) -> None:
        print(f"{found.frames} frames, {found.seconds:.1f} s -> {printable(found.path)}", file=out)
        if found.left:
            print(f"could not be read: {printable(found.left)}", file=out)

    def data() -> dict[str, object]:
        told = {name: getattr(found, name) for name in ("rows", "frames", "seconds", "left", "closed")}
        return {**told, "path": str(found.path)}

    return give(options, data, people)
