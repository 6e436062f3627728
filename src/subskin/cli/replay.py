"""`subskin replay`: a recording -> the same chain again, or that of another finger."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, TextIO

from .. import io, live
from ..errors import FileError, InvalidValueError, printable
from .common import add_json, describe, give, progress_bar, say

if TYPE_CHECKING:
    from ..live.replay import Replay
    from .live_view import View

_EXAMPLES = """\
  subskin replay touch.parquet                      does the chain give what was recorded, to the last bit?
  subskin replay touch.parquet --speed 1 --from 10 --to 20
  subskin replay touch.parquet --finger calibrated.toml -o again.parquet
"""
_NOTES = """\
The chain gets again what it got at the time of the recording: raw frames with the times of the computer, and
commands such as "zero now". Without --finger the answers are compared with those in the recording. A recording that
was not closed (.arrows) can be replayed as well.
"""


def add(parser: argparse.ArgumentParser) -> None:
    """Say what the command takes."""
    describe(parser, run, _EXAMPLES, _NOTES)
    parser.add_argument("recording", metavar="FILE", help="the recording")
    parser.add_argument("--finger", metavar="FILE", help="another finger.toml")
    parser.add_argument("--speed", type=float, metavar="X", help="times as fast as it happened (as fast as it can)")
    parser.add_argument("--from", dest="begin", metavar="TIME", help='show from here on, "10 s" (the beginning)')
    parser.add_argument("--to", dest="end", metavar="TIME", help="stop here (the end)")
    parser.add_argument("-o", "--out", metavar="FILE", help="write it as a new recording: .parquet, .csv, .mcap")
    add_json(parser)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.convert import check_kind, write
    from ..live.recording import opened

    if options.out is not None and options.speed is not None:
        raise InvalidValueError("--speed with -o", "a file is written as fast as it can", "leave one out")
    kind = None if options.out is None else check_kind(options.out)
    file = None if options.finger is None else io.load(options.finger)
    window = {"begin": _time(options.begin, "--from", 0.0), "end": _time(options.end, "--to", float("inf"))}
    with opened(options.recording) as recording:
        if file is not None and str(options.out) == options.recording:
            raise FileError(f"-o {options.out}", "it is the recording itself", "name another file")
        shown = live.Replay(recording, file, speed=options.speed, **window)
        view = None
        if options.speed is not None and not options.json:
            from .live_view import Bars, PlainLines

            view = (Bars if sys.stdout.isatty() else PlainLines)(shown.file, _Played(shown))
        quiet = options.json or options.out is not None or view is not None
        watched = _Watched(shown, None if quiet else say(options))
        with progress_bar("frames", None) if view is None else nullcontext(_nothing) as advance:
            watched.advance = advance
            if view is not None:
                _follow(watched, view)
            elif kind is None:
                for _ in watched:
                    pass
            else:
                write(watched, options.out, kind)
        if recording.left:
            print(f"subskin: warning: {printable(recording.left)} could not be read", file=sys.stderr)
        return give(options, watched.told, watched.people, {options.out: lambda _: None})


def _time(text: str | None, name: str, usual: float) -> float:
    from ..io.units import quantity

    return usual if text is None else quantity(text, "s", name)


_BEHIND = 2.0
"""Seconds of the recording by which a picture may be late before it is said."""


def _nothing(count: int) -> None:
    """No bar: what is replayed at a speed is shown itself."""


def _follow(watched: _Watched, view: View) -> None:
    drawn = -float("inf")
    with view:
        for batch in watched:
            view.see(batch)
            if time.monotonic() - drawn >= view.each:
                view.draw()
                drawn = time.monotonic()
        view.draw()
        behind = 0.0 if view.latest is None else view.live.port.clock() - view.latest.host_time
    if behind > _BEHIND:
        print(f"subskin: warning: the last frame is {behind:.0f} s late: this computer is too slow for that --speed",
              file=sys.stderr)  # fmt: skip


class _Played:
    """A recording that is replayed, as a view follows it."""

    recorder = None

    def __init__(self, shown: Replay) -> None:
        self.port = self._shown = shown

    @property
    def frames(self) -> int:
        return self._shown.frames

    @property
    def lost(self) -> int:
        return self._shown.lost

    @property
    def bad(self) -> int:
        return self._shown.bad


class _Watched:
    """Counts what is replayed, and shows its events as they happen."""

    def __init__(self, shown: Replay, out: TextIO | None) -> None:
        self._shown, self._out = shown, out
        self.about, self.name = shown.about, shown.name
        self.status: Counter[str] = Counter()
        self.events: Counter[str] = Counter()
        self.advance: Any = None
        self._first: float | None = None

    def __iter__(self) -> Any:
        for batch in self._shown:
            self._see(batch)
            yield batch

    def batches(self) -> Any:
        yield from self._shown.batches(self._see)

    def _see(self, batch: Any) -> None:
        self._first = batch.host_time if self._first is None else self._first
        if batch.found is not None and len(batch.raw):
            self.status.update(batch.found.to_dict()["status"].tolist())
        for event in batch.events:
            self.events[event.kind] += 1
            if self._out is not None:
                at = event.time - self._first
                print(f"{at:10.3f} s  {printable(event.kind)}: {printable(event.text)}", file=self._out, flush=True)
        self.advance(len(batch.raw))

    def told(self) -> dict[str, Any]:
        same = self._shown.same
        found = {"frames": self._shown.frames, "status": dict(self.status), "events": dict(self.events)}
        if same is None:
            return {**found, "same": None}
        return {**found, "same": not same.others, "rows": same.rows, "different_rows": same.others,
                "different_columns": sorted(same.different)}  # fmt: skip

    def people(self, out: TextIO) -> None:
        told = self.told()
        status = ", ".join(f"{name} {count}" for name, count in sorted(self.status.items()))
        print(f"{told['frames']} frames" + (f": {status}" if status else ""), file=out)
        if told["same"] is not None and told["same"]:
            print(f"all {told['rows']} rows as they were recorded, to the last bit", file=out)
        elif told["same"] is not None:
            names = ", ".join(told["different_columns"][:8])
            print(f"{told['different_rows']} of {told['rows']} rows differ from the recording, in {names}", file=out)
