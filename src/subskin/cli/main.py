"""The parser, the exit codes, and nothing else: the module of a command is imported when it is the one to run."""

from __future__ import annotations

import argparse
import difflib
import io
import os
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

from .. import __version__
from ..errors import ConvergenceError, SubskinError, WorkersError, printable

__all__ = ["main"]

_COMMANDS = {
    "simulate": "compute the readings of a finger under random loads, or a raw recording of an indenter",
    "touches": "simulate touches to learn from, in a Zarr store",
    "segment": "cut a raw recording into presses",
    "calibrate": "fit a finger to touches at known positions, or --blind to any touches",
    "orient": "say whether cable, board, axes and sign are as the file says, by two or three presses",
    "locate": "find the load in each frame of readings",
    "fit": "find a contact of one family, and its half width, in each frame of readings",
    "decide": "say what kind of contact made each frame of readings",
    "studio": "open a page on this machine: a finger to look at and to move by hand",
    "live": "show touches of a sensor on a cable, as they happen",
    "bench": "calibrate a finger on a cable, touch by touch",
    "pressure": "find the pressure along the surface in each frame of readings",
    "check": "say what a finger cannot object to, and how wrong the half plane is for it",
    "compliance": "say how soft a skin should be to find a particle on a flat",
    "tolerances": "say what each tolerance of a finger costs in locating",
    "design": "find the fingers that meet your goals, with a report",
    "grasp": "lift things of unknown weight and friction in simulation, by what two skins tell",
    "afferents": "say which strain explains the rates of a touch receptor",
    "ports": "list the boards that are plugged in, and guess their drivers",
    "replay": "run a recording of a live stream again, or with another finger",
    "recover": "save what can be read of a recording that was not closed",
    "convert": "make a recording into Parquet, CSV, MCAP, a bag of ROS or a data set for LeRobot; or a bag into one",
    "figures": "redraw the memo's Figs. 2, 3, 6, 9 and 11 to 19",
}
"""What each command does. `run_NAME` runs it, and says what it takes: in the module of its name, or in its home."""
_HOMES = {"ports": "live", "studio": "live", "replay": "recordings", "recover": "recordings", "convert": "recordings"}

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
exit codes: 0 done, and live stopped with Ctrl-C; 1 no result; 2 bad input, nothing written; 130 stopped with Ctrl-C
"""


def _parser(chosen: str) -> argparse.ArgumentParser:
    """The parser of all commands, or of the one that is chosen."""
    parser = argparse.ArgumentParser(
        prog="subskin",
        description="Sensors beneath a compliant skin: their readings under a contact, and the contact found again.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and stop")
    commands = parser.add_subparsers(title="commands", metavar="command", required=True, parser_class=_Command)
    for name in [chosen] if chosen in _COMMANDS else _COMMANDS:
        does = _COMMANDS[name]
        commands.add_parser(name, called=name, help=does, description=f"{does[:1].upper()}{does[1:]}.")
    return parser


class _Command(argparse.ArgumentParser):
    """A command's own parser, which its module fills in when the command is chosen."""

    def __init__(self, called: str, **options: Any) -> None:
        super().__init__(**options, formatter_class=argparse.RawDescriptionHelpFormatter)
        self._called = called
        # what begins with a minus and a digit is a value: --angle "-30..30 deg", --position -5..5
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def parse_known_args(self, *given: Any, **named: Any) -> Any:
        home = import_module(f".{_HOMES.get(self._called, self._called)}", __package__)
        getattr(home, f"run_{self._called}").fill(self)
        options, left = super().parse_known_args(*given, **named)
        if left:  # with the usage of this command, and not of them all
            self.error(f"unrecognized arguments: {' '.join(left)}{self._meant(left)}")
        return options, left

    def _meant(self, left: Sequence[str]) -> str:
        """The option that the first misspelt one is probably meant to be."""
        name = next((text.partition("=")[0] for text in left if text.startswith("--")), "")
        close = difflib.get_close_matches(name, [known for known in self._option_string_actions if known != name], n=1)
        return f"; did you mean {close[0]}?" if name and close else ""


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(f"subskin {__version__}")
        parser.exit()


def _warns() -> Callable[..., None]:
    """Each warning once, in one line without the line of code; none that a library has for programmers."""
    told: set[str] = set()

    def warn(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
        text = printable(message)
        if text not in told and not issubclass(category, DeprecationWarning | PendingDeprecationWarning):
            told.add(text)
            _said(f"warning: {text}", 0)

    return warn


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.
    """
    try:
        with _ended_by(signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)), _open_streams():
            try:
                code = _run(argv)
            except SystemExit:
                sys.stdout.flush()  # of help
                raise
            sys.stdout.flush()
            return code
    except (ConvergenceError, WorkersError) as error:
        return _fail(str(error), 1)
    except SubskinError as error:
        return _fail(str(error), 2)
    except KeyboardInterrupt as interrupt:
        return _stopped(interrupt)
    except BrokenPipeError:
        return 141  # whoever read the output has what it wanted
    except OSError as error:
        return _fail(f"{error.filename or 'standard output'}: it cannot be written ({error.strerror or error}).", 2)
    except MemoryError:
        return _fail("not enough memory for this table. Fix: cut it into several files.", 2)
    except Exception as error:
        behind = _interrupt_behind(error)
        if behind is None:
            raise
        return _stopped(behind)
    finally:
        _leave_output()


def _interrupt_behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """The interrupt behind an error: a module that is stopped while it is read may raise another."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error


def _stopped(interrupt: KeyboardInterrupt) -> int:
    return _said("stopped", 128 + (interrupt.number if isinstance(interrupt, _Ended) else signal.SIGINT))


def _run(argv: Sequence[str] | None) -> int:
    given = sys.argv[1:] if argv is None else argv
    parser = _parser(given[0] if given else "")
    options = parser.parse_args(given)
    from ..io.files import apart
    from .common import check_figure
    from .options import DRAWN, inputs_of, outputs_of

    if options.json and "-" in outputs_of(options).values():
        parser.error("--json and -o - would both write to standard output: choose one")
    apart(inputs_of(options), outputs_of(options))
    with warnings.catch_warnings():
        warnings.showwarning = _warns()
        for key, said in DRAWN.items():
            if (path := getattr(options, key, None)) is not None:
                check_figure(path, said)
        code: int = options.run(options)
    return code


class _Ended(KeyboardInterrupt):
    """A signal that ends the process, so that nothing half-written is left behind."""

    def __init__(self, number: int) -> None:
        self.number = number


@contextmanager
def _ended_by(*numbers: int) -> Iterator[None]:
    """Signals raise `_Ended` where they would end the process at once."""
    here, before = os.getpid(), {}

    def stop(number: int, _: object) -> None:
        if os.getpid() == here:
            raise _Ended(number)
        signal.signal(number, signal.SIG_DFL)  # a worker of a pool
        os.kill(os.getpid(), number)

    if threading.current_thread() is threading.main_thread():
        for number in set(numbers):
            if signal.getsignal(number) is signal.SIG_DFL:
                before[number] = signal.signal(number, stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextmanager
def _open_streams() -> Iterator[None]:
    """Text for people goes nowhere where standard output or error is closed."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (io.StringIO() if stream is None else stream for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def _leave_output() -> None:
    """Python must not find standard output closed or full again when it exits, and change the exit code."""
    with suppress(AttributeError, ValueError):
        try:
            sys.stdout.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str, code: int) -> int:
    return _said(
        f"error: {' '.join(printable(message).split())}", code
    )  # one line, whatever the file that it quotes holds


def _said(text: str, code: int) -> int:
    if sys.stderr is not None:
        with suppress(OSError):
            print(f"subskin: {text}", file=sys.stderr)
    return code
