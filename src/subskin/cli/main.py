"""The parser, the exit codes, and nothing else: each command is a module of its own."""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence

from ..errors import ConvergenceError, SubskinError
from . import (
    calibrate,
    check,
    compliance,
    decide,
    design,
    figures,
    fit,
    locate,
    pressure,
    segment,
    simulate,
    tolerances,
)

__all__ = ["main"]

_EPILOG = """\
a recording of your own, from raw pressures to places:
  subskin segment   finger.toml raw.csv -o presses.csv
  subskin calibrate finger.toml presses.csv -o calibrated.toml --every 2
  subskin locate    calibrated.toml presses.csv -o located.csv --every 2 --skip-used --truth position

what touched, and how, from readings of a finger as drawn or as calibrated:
  subskin fit       finger.toml readings.csv --family hertz -o widths.csv
  subskin decide    finger.toml readings.csv -o kinds.csv
  subskin pressure  finger.toml readings.csv -o map.csv --figure map.png

Files may hold units ("2 mm", "0.4 MPa"); results are in SI: m, N/m, rad, s.
exit codes: 0 done; 1 a result that could not be reached; 2 bad input, nothing written; 130 stopped with Ctrl-C
"""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="subskin",
        description="What sensors beneath a compliant skin read under a contact, and the contact found from it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and stop")
    commands = parser.add_subparsers(title="commands", metavar="command", required=True)
    for module in (
        simulate,
        segment,
        calibrate,
        locate,
        fit,
        decide,
        pressure,
        check,
        compliance,
        tolerances,
        design,
        figures,
    ):
        module.add(commands)
    return parser


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from .. import __version__

        print(f"subskin {__version__}")
        parser.exit()


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    """A warning in one line, without the place in the code that raised it."""
    print(f"subskin: warning: {message}", file=sys.stderr)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.
    """
    try:
        parser = _parser()
        options = parser.parse_args(argv)
        if options.json and getattr(options, "out", None) == "-":
            parser.error("--json and -o - would both write to standard output: choose one")
        with warnings.catch_warnings():
            warnings.showwarning = _warn
            code: int = options.run(options)
        sys.stdout.flush()
    except ConvergenceError as error:
        return _fail(error, 1)
    except SubskinError as error:
        return _fail(error, 2)
    except KeyboardInterrupt:
        print("subskin: stopped", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # whoever read the output has what it wanted; Python must not find the pipe closed again when it exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except MemoryError:
        print(
            "subskin: error: not enough memory for this table. Fix: cut it into several files.",
            file=sys.stderr,
        )
        return 2
    return code


def _fail(error: SubskinError, code: int) -> int:
    text = " ".join(str(error).split())  # one line, whatever the file that it quotes holds
    print(f"subskin: error: {text}", file=sys.stderr)
    return code
