"""`subskin replay`, `recover` and `convert`: a recording run again, saved, or made into another file."""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any, TextIO

from .. import io, live
from ..errors import FileError, InvalidValueError, printable
from ..io.units import quantity
from .common import give, progress_bar, say
from .options import JSON, command, option

if TYPE_CHECKING:
    from ..live.replay import Replay
    from .live_view import View

_REPLAY = """\
  subskin replay touch.parquet                      does the chain give what was recorded, to the last bit?
  subskin replay touch.parquet --speed 1 --from 10 --to 20
  subskin replay touch.parquet --finger calibrated.toml -o again.parquet
"""
_REPLAY_NOTES = """\
The chain gets again what it got at the time of the recording: raw frames with the times of the computer, and
commands such as "zero now". Without --finger the answers are compared with those in the recording. A recording that
was not closed (.arrows) can be replayed as well.
"""


@command(
    _REPLAY,
    option("recording FILE", "the recording"),
    option("--finger FILE", "another finger.toml"),
    option("--speed X", "times as fast as it happened (as fast as it can)", type=float),
    option("--from TIME", 'show from here on, "10 s" (the beginning)', dest="begin"),
    option("--to TIME", "stop here (the end)", dest="end"),
    option("-o --out FILE", "write it as a new recording: .parquet, .csv, .mcap"),
    JSON,
    notes=_REPLAY_NOTES,
)
def run_replay(options: argparse.Namespace) -> int:
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

            view = (Bars if sys.stdout.isatty() else PlainLines)(shown.file, shown)
        quiet = options.json or options.out is not None or view is not None
        watched = _Watched(shown, None if quiet else say(options))
        with progress_bar("frames", None) if view is None else nullcontext(_nothing) as advance:
            watched.advance = advance
            if view is not None:
                _shown_at_speed(watched, view)
            elif kind is None:
                for _ in watched:
                    pass
            else:
                write(watched, options.out, kind)
        if recording.left:
            print(f"subskin: warning: {printable(recording.left)} could not be read", file=sys.stderr)
        return give(options, watched.told, watched.people, {options.out: lambda _: None})


def _time(text: str | None, name: str, usual: float) -> float:
    return usual if text is None else quantity(text, "s", name)


_BEHIND = 2.0
"""Seconds of the recording by which a picture may be late before it is said."""


def _nothing(count: int) -> None:
    """No bar: what is replayed at a speed is shown itself."""


def _shown_at_speed(watched: _Watched, view: View) -> None:
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


_RECOVER = """\
  subskin recover touch.parquet.arrows
  subskin recover touch.parquet.arrows -o saved.parquet
"""
_RECOVER_NOTES = """\
While `subskin live --record touch.parquet` records, the file is called touch.parquet.arrows. It stays behind where the
program was killed, or the power failed. Everything up to its last whole part can be read. The old file stays.
"""


@command(
    _RECOVER,
    option("recording FILE.arrows", "the recording that was not closed"),
    option("-o --out FILE", "the new recording, Parquet (the name without .arrows)"),
    JSON,
    notes=_RECOVER_NOTES,
)
def run_recover(options: argparse.Namespace) -> int:
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


_CONVERT = """\
  subskin convert touch.parquet touch.csv
  subskin convert touch.parquet touch.mcap --topic /left/finger
  subskin convert touch.parquet touch_bag --to rosbag2
  subskin convert touch.parquet touch_set --to lerobot --fps 30 --task "pick up the cup"
  subskin convert robot.mcap touch.parquet --topic /left/tactile --finger finger.toml
"""
_CONVERT_NOTES = """\
The ending of the new file names its format: .parquet, .csv, .mcap; or --to does. rosbag2 and lerobot are folders.
A bag (.mcap, .bag, .db3, or a folder of rosbag2) becomes a recording without estimates: `subskin replay` makes these.
MCAP and bags need `pip install "subskin[log]"`.
"""


@command(
    _CONVERT,
    option("recording FILE", "the recording, or a bag"),
    option("out NEW", "the new file or folder"),
    option("--to {parquet,csv,mcap,rosbag2,lerobot}", "format of the new file"),
    option("--topic NAME", "what the topics begin with (/subskin); of a bag, the one to read"),
    option("--fps RATE", "ticks a second of lerobot (30)", type=float),
    option("--task TEXT", "what was done, for lerobot (touch)"),
    option("--finger FILE", "finger.toml of the frames in a bag"),
    JSON,
    notes=_CONVERT_NOTES,
)
def run_convert(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.convert import check_kind, convert
    from ..live.sinks.bags import is_bag, read_bag

    kind = check_kind(options.out, options.to)
    told: dict[str, Any] = {"out": options.out, "kind": kind}
    if is_bag(options.recording):
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
