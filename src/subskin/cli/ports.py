"""`subskin ports`: the boards that are plugged in, and the drivers that may read them."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TextIO

from .common import add_json, describe, give, show

_EXAMPLES = """\
  subskin ports
  subskin ports --json
"""
_NOTES = """\
A guess rests on the USB number of who made the board. It is only a guess: another sketch may run on it. "unknown" means
that no number says it; give the driver under [live] of finger.toml. Boards that a network reaches are not listed."""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.ports import listed

    found = listed()

    def people(out: TextIO) -> None:
        if not found:
            print("no serial port was found: plug the board in, by a cable that carries data", file=out)
            return
        rows = [[one.port, one.driver, one.usb, one.says] for one in found]
        show(out, "serial ports", ["port", "driver, guessed", "USB", "says that it is"], rows, left=4)
        for why in dict.fromkeys(f"{one.driver}: {one.why}" for one in found if one.why):
            print(why, file=out)

    return give(options, lambda: {"ports": [asdict(one) for one in found]}, people)
