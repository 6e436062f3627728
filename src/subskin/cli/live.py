"""`subskin live`, `ports` and `studio`: a sensor as it feels, in the terminal or on a page; what is plugged in."""

from __future__ import annotations

import argparse
import sys
import time
from contextlib import nullcontext
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, TextIO

from .. import io
from ..errors import InvalidValueError, printable
from ..io.units import quantity
from .common import give, note_orientation, show
from .options import JSON, command, option, quantity_range

if TYPE_CHECKING:
    from ..io import FingerFile
    from ..live import Live
    from .live_view import View

_LIVE = """\
  subskin live --port demo                                a simulated finger: nothing has to be plugged in
  subskin live finger.toml                                the port and the board that [live] of the file names
  subskin live finger.toml --port /dev/ttyACM0 --driver "anyskin?sensors=5" --slip 0.4..0.8
  subskin live finger.toml --record touch.parquet --for "60 s" --zero
  subskin live finger.toml --fit hertz --json | my_robot
"""
_LIVE_NOTES = """\
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


@command(
    _LIVE,
    option("finger?", "finger.toml; --port demo needs none"),
    option("--port WHERE", "/dev/ttyACM0, serial:, tcp:, udp:, ws:, file:, -, or demo"),
    option("--driver NAME", "what the device sends: anyskin, lines, ... (that of [live])"),
    option("--rate HZ", "of file: frames a second, where they have no times", type=float),
    option("--fit FAMILY", "find the half width of such contacts too: hertz, punch, ..."),
    option("--slip MU", "coefficient of friction, 0.5 or 0.4..0.8: say when it slips"),
    option("--overload FORCE", "say where a force is larger [N/m, area N]", type=float),
    option("--zero", "half a second after the first frame nothing touches"),
    option("--record FILE", "record all of it: .parquet, .csv, .mcap, .arrows"),
    option("--for TIME", 'stop after this time, such as "60 s"', dest="duration"),
    option("--json", "a line of JSON for each frame and each event"),
    notes=_LIVE_NOTES,
)
def run_live(options: argparse.Namespace) -> int:
    """Run the command."""
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
        file = io.load(options.finger)
        note_orientation(file)
        return file
    if options.port is None or options.port.partition("?")[0] != "demo":
        raise InvalidValueError(
            "no finger", "a finger.toml says what the sensors are", "subskin live finger.toml, or --port demo"
        )
    return io.parse_finger(_DEMO, "the finger of the demo")


def _opened(options: argparse.Namespace, file: FingerFile) -> tuple[Live, View, bool]:
    """The stream, prepared, what shows it, and whether --zero is still to come."""
    from ..live.chain import Chain
    from ..live.run import live
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


_PORTS = """\
  subskin ports
  subskin ports --json
"""
_PORTS_NOTES = """\
A guess rests on the USB number of who made the board. It is only a guess: another sketch may run on it. "unknown" means
that no number says it; give the driver under [live] of finger.toml. Boards that a network reaches are not listed."""


@command(_PORTS, JSON, notes=_PORTS_NOTES)
def run_ports(options: argparse.Namespace) -> int:
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


_STUDIO = """\
  subskin studio                                 a finger to play with, in the browser
  subskin studio finger.toml                     your own
  subskin studio finger.toml --port demo         with a device, live: as subskin live takes it
  subskin studio finger.toml --port robot        with a simulated stage, to calibrate (or your own device)
  subskin studio --port touch.parquet            with a recording, to play
  subskin studio finger.toml --no-browser        print the address, open nothing
"""
_STUDIO_NOTES = """\
The page answers this machine alone: the address holds a token, and the browser that opens it gets a cookie. Nothing is
fetched from elsewhere. Ctrl-C ends it. It needs pip install "subskin[studio]".
"""


@command(
    _STUDIO,
    option("finger?", "finger.toml; an example if left out"),
    option("--port WHERE", "device, demo or recording for the view Live; Calibrate needs a device"),
    option("--host-port N", "port of this machine (8771, or the next free one)", type=int),
    option("--no-browser", "print the address, and open nothing"),
    notes=_STUDIO_NOTES,
)
def run_studio(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..studio.opening import serve

    try:
        serve(options.finger, device=options.port, port=options.host_port, browser=not options.no_browser)
    except KeyboardInterrupt as stop:
        if type(stop) is not KeyboardInterrupt:
            raise  # a signal that ends the process, and not Ctrl-C
    return 0
