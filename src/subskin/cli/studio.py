"""`subskin studio`: a page on this machine."""

from __future__ import annotations

import argparse

from .common import describe

_EXAMPLES = """\
  subskin studio                                 a finger to play with, in the browser
  subskin studio finger.toml                     your own
  subskin studio finger.toml --port demo         with a device, live: as subskin live takes it
  subskin studio finger.toml --port robot        with a simulated stage, to calibrate (or your own device)
  subskin studio --port touch.parquet            with a recording, to play
  subskin studio finger.toml --no-browser        print the address, open nothing
"""
_NOTES = """\
The page answers this machine alone: the address holds a token, and the browser that opens it gets a cookie. Nothing is
fetched from elsewhere. Ctrl-C ends it. It needs pip install "subskin[studio]".
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("finger", nargs="?", help="finger.toml; an example if left out")
    parser.add_argument(
        "--port", metavar="WHERE", help="device, demo or recording for the view Live; Calibrate needs a device"
    )
    parser.add_argument("--host-port", type=int, metavar="N", help="port of this machine (8771, or the next free one)")
    parser.add_argument("--no-browser", action="store_true", help="print the address, and open nothing")
    parser.set_defaults(json=False)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..studio.opening import serve

    try:
        serve(options.finger, device=options.port, port=options.host_port, browser=not options.no_browser)
    except KeyboardInterrupt as stop:
        if type(stop) is not KeyboardInterrupt:
            raise  # a signal that ends the process, and not Ctrl-C
    return 0
