"""`subskin live`: a sensor as it feels, in the terminal."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

from .. import io
from ..errors import InvalidValueError, printable
from .common import describe

if TYPE_CHECKING:
    from ..io import FingerFile
    from ..live import Live
    from .live_view import View

_EXAMPLES = """\
  subskin live --port demo                                a simulated finger: nothing has to be plugged in
  subskin live finger.toml                                the port and the board that [live] of the file names
  subskin live finger.toml --port /dev/ttyACM0 --driver "anyskin?sensors=5" --slip 0.4..0.8
  subskin live finger.toml --record touch.parquet --for "60 s" --zero
  subskin live finger.toml --fit hertz --json | my_robot
"""
_NOTES = """\
Ctrl-C ends it: the device gets its word to stop, the recording is closed, and the exit code is 0. The stream begins
with the skin free, or --zero after it has begun. Piped, it prints each event, and a line a second; with --json a line
for each frame, and one for each event. The first start after installation compiles for some seconds; a preview shows
the force meanwhile, and no frame is lost.
"""
_DEMO = """\
[skin]
young = "0.4 MPa"

[sensors]
count = 8
pitch = "1.5 mm"
depth = "2 mm"
noise = 2e-4

[touch]
length = "10 mm"
"""
"""The finger of `--port demo` where no file names one."""
_WAIT = 0.1
_ZERO = 0.5
"""Seconds after the first frame at which --zero takes what is read for nothing."""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("finger", nargs="?", help="finger.toml; --port demo needs none")
    parser.add_argument("--port", metavar="WHERE", help="/dev/ttyACM0, serial:, tcp:, udp:, ws:, file:, -, or demo")
    parser.add_argument("--driver", metavar="NAME", help="what the device sends: anyskin, lines, ... (that of [live])")
    parser.add_argument("--rate", metavar="HZ", type=float, help="of file: frames a second, where they have no times")
    parser.add_argument("--fit", metavar="FAMILY", help="find the half width of such contacts too: hertz, punch, ...")
    parser.add_argument("--slip", metavar="MU", help="coefficient of friction, 0.5 or 0.4..0.8: say when it slips")
    parser.add_argument("--overload", metavar="FORCE", type=float, help="say where a force is larger [N/m, area N]")
    parser.add_argument("--zero", action="store_true", help="half a second after the first frame nothing touches")
    parser.add_argument("--record", metavar="FILE", help="record all of it: .parquet, .csv, .mcap, .arrows")
    parser.add_argument("--for", dest="duration", metavar="TIME", help='stop after this time, such as "60 s"')
    parser.add_argument("--json", action="store_true", help="a line of JSON for each frame and each event")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..io.units import quantity

    file = _finger(options)
    duration = float("inf") if options.duration is None else quantity(options.duration, "s", "--for")
    if not duration > 0:
        raise InvalidValueError(f'--for "{options.duration}"', "has to be > 0 [s]", '--for "10 s"')
    live, shown, zero = _opened(options, file)
    stopped: BaseException | None = None
    try:
        with shown:
            _follow(live, shown, duration, zero)
    except KeyboardInterrupt as stop:
        stopped = stop
    finally:
        live.close()
    shown.end()
    if live.recorder is not None:
        print(f"-> {printable(live.recorder.failed or options.record)}", file=sys.stderr)
    if stopped is None and not live.frames:
        said = f"no frame came; {live.bad} were broken" if live.bad else "no frame came"
        print(f"subskin: {said}. Is {type(live.driver).__name__} the driver of this board? --driver", file=sys.stderr)
        return 1
    if stopped is not None and type(stopped) is not KeyboardInterrupt:
        raise stopped  # a signal that ends the process, and not Ctrl-C
    return 1 if live.recorder is not None and live.recorder.failed else 0


def _finger(options: argparse.Namespace) -> FingerFile:
    if options.finger is not None:
        return io.load(options.finger)
    if options.port is None or options.port.partition("?")[0] != "demo":
        raise InvalidValueError(
            "no finger", "a finger.toml says what the sensors are", "subskin live finger.toml, or --port demo"
        )
    return io.parse_finger(_DEMO, "the finger of the demo")


def _opened(options: argparse.Namespace, file: FingerFile) -> tuple[Live, View, bool]:
    """The stream, prepared, what shows it, and whether --zero is still to come."""
    from ..live.chain import Chain
    from ..live.run import live
    from .common import quantity_range
    from .live_preview import Preview
    from .live_view import Bars, JsonLines, PlainLines

    slip = None if options.slip is None else quantity_range(options.slip, "", "--slip")
    chosen: dict[str, Any] = {"fit": options.fit, "overload": options.overload}
    if slip is not None:
        chosen["slip"] = slip[0] if slip[0] == slip[1] else slip
    print("subskin: preparing tables and loops ...", file=sys.stderr, flush=True)
    began = time.monotonic()
    made = live(file, options.port, options.driver, rate=options.rate, prepare=False, **chosen)
    view = JsonLines if options.json else Bars if sys.stdout.isatty() else PlainLines
    preview = Preview(made, view is Bars, _ZERO if options.zero else None)
    try:
        with preview if made.port.real_time and not options.json else nullcontext():
            assert isinstance(made.chain, Chain)
            made.chain.prepare()
        if options.record is not None:
            made.record(options.record)
    except BaseException:
        made.close()
        raise
    print(f"subskin: ready in {time.monotonic() - began:.1f} s; Ctrl-C stops", file=sys.stderr, flush=True)
    shown = view(file, made, made.port.clock()) if preview.shown else view(file, made)
    return made, shown, preview.zero is not None


def _follow(live: Live, shown: View, duration: float, zero: bool) -> None:
    """Take batches until the time is over: first what a batch says, then, where there is time, a picture."""
    end, zero_at = time.monotonic() + duration, float("inf")
    drawn = 0.0
    while not live.ended and time.monotonic() < end:
        for batch in live.take(min(_WAIT, max(end - time.monotonic(), 0.0))):
            shown.see(batch)
        now = time.monotonic()
        if zero and live.frames:
            zero, zero_at = False, now + _ZERO
        if now >= zero_at:
            zero_at = float("inf")
            live.zero()
        if now - drawn >= shown.each:
            shown.draw()
            drawn = time.monotonic()
