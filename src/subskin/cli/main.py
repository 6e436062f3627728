"""The parser, the exit codes, and nothing else: each command is a module, imported when it is the one to run."""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from ..errors import ConvergenceError, SubskinError

__all__ = ["main"]

_COMMANDS = {
    "simulate": "compute the readings of a finger under random loads, or a raw recording of an indenter",
    "segment": "cut a raw recording into presses",
    "calibrate": "fit a finger to touches at known positions, or --blind to any touches",
    "locate": "find the load in each frame of readings",
    "fit": "find a contact of one family, and its width, in each frame of readings",
    "decide": "tell what kind of contact made each frame of readings",
    "pressure": "find the pressure along the surface in each frame of readings",
    "check": "say how wrong the half plane is for a finger",
    "compliance": "say how soft a skin should be to tell a particle on a flat",
    "tolerances": "say what each tolerance of a finger costs in locating",
    "design": "find the fingers that do what is wanted, with a report",
    "figures": "redraw the memo's Figs. 2, 3, 6, 9 and 11 to 19",
}
"""What each command does. Its module, of its name, has `add`, which says what it takes, and `run`."""

_EPILOG = """\
a recording of your own, from raw pressures to positions:
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
    commands = parser.add_subparsers(title="commands", metavar="command", required=True, parser_class=_Command)
    for name, does in _COMMANDS.items():
        commands.add_parser(name, module=name, help=does, description=f"{does[:1].upper()}{does[1:]}.")
    return parser


class _Command(argparse.ArgumentParser):
    """A command's own parser, which its module fills in when the command is chosen."""

    def __init__(self, module: str, **options: Any) -> None:
        super().__init__(**options, formatter_class=argparse.RawDescriptionHelpFormatter)
        self._module = module

    def parse_known_args(self, *given: Any, **named: Any) -> Any:
        import_module(f".{self._module}", __package__).add(self)
        return super().parse_known_args(*given, **named)


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from .. import __version__

        print(f"subskin {__version__}")
        parser.exit()


def _warn(message: Warning | str, *_: object, **__: object) -> None:
    """A warning in one line, without the line of code that raised it."""
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
        print("subskin: error: not enough memory for this table. Fix: cut it into several files.", file=sys.stderr)
        return 2
    return code


def _fail(error: SubskinError, code: int) -> int:
    text = " ".join(str(error).split())  # one line, whatever the file that it quotes holds
    print(f"subskin: error: {text}", file=sys.stderr)
    return code
