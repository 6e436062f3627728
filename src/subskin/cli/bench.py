"""`subskin bench`: a finger calibrated as it is touched, step by step."""

from __future__ import annotations

import argparse
import json
import queue
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import io
from .._lazy import np
from ..errors import InvalidValueError
from ..io.files import check_target
from .common import said_of
from .options import command, listed, option

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..live import Bench, BenchState, Live, Said

_EXAMPLES = """\
  subskin bench finger.toml --port robot -o calibrated.toml         try it: a simulated finger and stage
  subskin bench finger.toml -o calibrated.toml                      the port and the board of [live]
  subskin bench finger.toml --port /dev/ttyACM0 --driver "anyskin?sensors=5" -o calibrated.toml --force "2 N/mm"
  subskin bench pad.toml --positions "-6 mm:6 mm:2 mm" --accuracy "0.3 mm" -o calibrated.toml --json
"""
_NOTES = """\
It measures the noise of the free skin. Then it asks for touches, each where it helps most, says after each how far
positions are off, and stops when they are near enough. Touch with the same load each time, by a thin straight edge
across the row (on an area, by a small tip), and hold until it is taken.

Type a word and Enter at any time: again (take the last touch back), skip (this position cannot be reached), end (write
the finger as it is). Touches are kept beside the finger as they come, in NAME.touches.csv. Ctrl-C stops with exit code
130 and says how `subskin calibrate` goes on from there.
"""
_WORDS = ("again", "skip", "end")
_BARS = " ▁▂▃▄▅▆▇█"


@command(
    _EXAMPLES,
    option("finger", "finger.toml as drawn"),
    option("--port WHERE", "as of subskin live; robot simulates a finger and a stage"),
    option("--driver NAME", "what the device sends (that of [live])"),
    option(
        "--positions LIST",
        "where touches can be made: first:last:step, or a list (a depth beyond the sensors, by a fourth of it)",
    ),
    option("--force FORCE", "load of each touch, N/m or N; without it all are alike"),
    option("--fit LIST", "what to fit (gain,depth,origin)", "gain,depth,origin"),
    option("--accuracy M", "wanted error of positions (0.2 mm)", "0.2 mm"),
    option("--rest S", "time at rest, for the noise (2 s)", "2 s"),
    option("--hold S", "time that a touch is held (0.5 s)", "0.5 s"),
    option("--most N", "touches after which it ends (60)", 60),
    option("--accept-misfit", "write the finger even where its model cannot explain the touches"),
    option("-o --out FILE", "the calibrated finger.toml", required=True),
    option("--json", "a line of JSON for each message"),
    notes=_NOTES,
)
def run_bench(options: argparse.Namespace) -> int:
    """Run the command."""
    from ..live.batch import BareChain
    from ..live.bench import Bench
    from ..live.connecting import connected
    from ..live.run import Live
    from ..live.session import calibrated, candidates_of

    if options.out == "-":
        raise InvalidValueError("-o -", "what happens is said on standard output", "-o calibrated.toml")
    check_target(options.out)
    file = io.load(options.finger)
    unit = "N" if file.finger.array.on_area else "N/m"
    seconds = {name: io.quantity(getattr(options, name), "s", f"--{name}") for name in ("rest", "hold")}
    bench = Bench(
        file,
        candidates_of(file, options.positions, "--positions"),
        force=None if options.force is None else io.quantity(options.force, unit, "--force"),
        fit=listed(options.fit), accuracy=io.quantity(options.accuracy, "m", "--accuracy"), most=options.most,
        **seconds,
    )  # fmt: skip
    port, driver = connected(file, options.port, options.driver)
    with Live(BareChain(file, driver.channels), port, driver) as live:
        session = _Session(options, file, bench, live)
        try:
            session.follow()
        except KeyboardInterrupt:
            session.stopped()
            raise
    found = bench.result(session.state, accept_misfit=options.accept_misfit)
    with said_of(options.out):
        io.save_finger(calibrated(file, bench.fit, found), options.out)
    if options.json:
        session.line({"said": "written", "file": options.out, "r2": found.r2, "error": session.state.error})
    else:
        print(found)
        for doubt in found.doubts:
            print(doubt)
        if bench.force is None and "gain" in bench.fit:
            print("forces found with this finger are multiples of the touches' load (no --force)")
        again = "".join(f" --{name} {value}" for name in ("port", "driver") if (value := getattr(options, name)))
        if getattr(port, "press", None) is not None:
            again = " --port demo"
        print(f"-> {options.out}; next: subskin live {options.out}{again}")
    return 0


class _Session:
    """Batches go into the bench; what it says goes to the person, and to a stage that can be told."""

    def __init__(self, options: argparse.Namespace, file: io.FingerFile, bench: Bench, live: Live) -> None:
        self.options, self.file, self.bench, self.live = options, file, bench, live
        self.kept = str(Path(options.out).with_suffix(".touches.csv"))
        self.words: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.state: BenchState
        self.state, said = bench.start()
        self._drawn = 0.0
        for one in said:
            self.tell(one)

    def follow(self) -> None:
        """Until the session is done, or the device has ended."""
        if not self.live.port.name.startswith("standard input"):
            threading.Thread(target=self._listen, daemon=True).start()
        while self.state.phase != "done" and not self.live.ended:
            for batch in self.live.take():
                if len(batch):
                    self.after(*self.bench.step(self.state, batch.readings, batch.time))
                    self._level(batch.readings[-1])
                elif batch.command:
                    self.line({"said": batch.command, "text": str(batch.values.get("text", ""))})
            while not self.words.empty():
                self._word(self.words.get())
        self._level(None)
        if self.state.phase != "done":
            self.after(*self.bench.end(self.state))

    def stopped(self) -> None:
        """Say where the touches are, and how to go on with them."""
        count = len(self.state.positions)
        self._level(None)
        if count:
            known = "" if self.bench.force is None else " --force-column force"
            more = f"--fit {','.join(self.bench.fit)}{known} -o {self.options.out}"
            said = f"subskin calibrate {self.options.finger} {self.kept} {more}"
            print(f"stopped after {count} touches, kept in {self.kept}; to go on: {said}", file=sys.stderr)
        else:
            print("stopped before a touch was taken: nothing is kept", file=sys.stderr)

    def after(self, state: BenchState, said: tuple[Said, ...]) -> None:
        """Take what a step gave."""
        more = len(state.positions) != len(self.state.positions)
        self.state = state
        if more:
            self._keep()
        for one in said:
            self.tell(one)

    def tell(self, said: Said) -> None:
        """Say it, to the person and to a stage."""
        self.line({"said": said.kind, "text": said.text, **said.values})
        press, lift = (getattr(self.live.port, name, None) for name in ("press", "lift"))
        if press is None or lift is None:
            return
        if said.kind == "touch":
            press(self.state.asked, self.bench.force)
        if self.state.phase == "lift" and said.kind in ("taken", "again", "skip"):
            lift()

    def line(self, values: dict[str, Any]) -> None:
        """A line for a person, or for a program."""
        self._level(None)
        if self.options.json:
            print(json.dumps(values, allow_nan=True), flush=True)
        elif values.get("text"):
            print(values["text"], flush=True)

    def _keep(self) -> None:
        """Write the touches so far, as `subskin calibrate` reads them."""
        state, count = self.state, np.arange(float(len(self.state.positions)))
        if not len(count):
            return
        at = state.positions
        names = {"position": at} if at.ndim == 1 else {"position_y": at[:, 0], "position_z": at[:, 1]}
        columns: dict[str, Any] = {"t_start": count, "t_end": count, **names}
        if self.bench.force is not None:
            columns["force"] = np.full(len(count), self.bench.force)
        io.write_table(self.kept, columns | dict(zip(self.file.names, state.readings.T, strict=True)))

    def _listen(self) -> None:
        """Words that are typed; the thread ends with the process."""
        with suppress(OSError, ValueError):  # nobody can type
            for line in sys.stdin or ():
                self.words.put(line.strip().lower())

    def _word(self, word: str) -> None:
        full = [name for name in _WORDS if word and name.startswith(word)]
        if len(full) == 1:
            self.after(*getattr(self.bench, full[0])(self.state))
        elif word:
            self.line({"said": "unknown", "text": f'"{word}": known are {", ".join(_WORDS)}'})

    def _level(self, readings: npt.NDArray[np.float64] | None) -> None:
        """A bar for each sensor, in a terminal, in place; None takes it away."""
        if self.options.json or not sys.stdout.isatty():
            return
        if readings is None:
            if self._drawn:
                print("\r\x1b[K", end="", flush=True)
                self._drawn = 0.0
            return
        state, now = self.state, time.monotonic()
        if state.noise is None or state.zero is None or now - self._drawn < 0.1:
            return
        level = np.log10(np.maximum(np.abs((readings - state.zero) / state.noise), 1.0)) / 3
        bars = "".join(_BARS[int(min(8 * one, 8))] for one in np.nan_to_num(level))
        print(f"\r\x1b[K  [{bars}] {state.phase}", end="", flush=True)
        self._drawn = now
