"""What `subskin live` shows: bars in a terminal, lines on a pipe, JSON for programs."""

from __future__ import annotations

import json
import math
import sys
from collections import Counter, deque
from types import TracebackType
from typing import Any, Self

import numpy as np

from .._shown import with_error
from ..decide import SlipVerdict
from ..errors import printable
from ..io.files import plain
from ..io.finger_file import FingerFile
from ..live.batch import Batch
from ..live.events import Event
from ..loads import force_unit
from .answers import Answers, estimate_columns
from .common import number

__all__ = ["Bars", "JsonLines", "PlainLines", "View"]

_REACH = 1.0
"""Seconds over which the rate and the latency are told."""
_EVENTS = 8
_WIDE, _MOST = 24, 32
"""Letters of a bar, and sensors that have one."""
_UNITS = {"position": (1e3, "mm"), "position_y": (1e3, "mm"), "position_z": (1e3, "mm"), "half_width": (1e3, "mm"),
          "beside": (1e3, "mm"), "angle": (180 / math.pi, "deg"), "azimuth": (180 / math.pi, "deg")}  # fmt: skip
_SILENT = {"no_contact": "nothing touches", "incomplete": "too few sensors can be used"}


class View:
    """Counts what comes, and says at the end what came.

    Parameters
    ----------
    file : FingerFile
        The finger.
    live : Live or Replay
        What is followed: it counts `frames`, `lost` and `bad`, and has a `port` with a clock and a `recorder`.
    since : float, optional
        Batches that came before say nothing of rate and latency: they have waited [s].
    """

    each = 1.0
    """Seconds between two pictures."""

    def __init__(self, file: FingerFile, live: Any, since: float = -math.inf) -> None:
        self.file, self.live, self._since = file, live, since
        self.events: Counter[str] = Counter()
        self.latest: Batch | None = None
        self._late: deque[tuple[float, int, float]] = deque()
        self._first: float | None = None
        self._last = 0.0
        self._latency: list[int] = [0] * 400

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        return None

    def see(self, batch: Batch) -> None:
        """Take a batch.

        Parameters
        ----------
        batch : Batch
            What came out of the chain just now.
        """
        now = self.live.port.clock()
        for event in batch.events:
            self.events[event.kind] += 1
            self.tell(event)
        if not len(batch):
            return
        self.latest = batch
        self._first = float(batch.time[0]) if self._first is None else self._first
        self._last = batch.host_time
        if self._last < self._since:
            return
        late = max(now - batch.host_time, 1e-6)
        self._late.append((now, len(batch), late))
        self._latency[min(int(40 * math.log10(late / 1e-6)), 399)] += 1
        while self._late and self._late[0][0] < now - _REACH:
            self._late.popleft()

    def tell(self, event: Event) -> None:
        """Show an event.

        Parameters
        ----------
        event : Event
            What happened.
        """

    def draw(self) -> None:
        """Show how it stands now."""

    def rate(self) -> float:
        """Frames a second, over the last second [1/s]."""
        frames, seen = sum(frames for _, frames, _ in self._late), self._last - (self._first or self._last)
        return frames / _REACH if seen > _REACH else max(self.live.frames - 1, 0) / seen if seen > 0 else math.nan

    def latency(self) -> tuple[float, float]:
        """From the last byte to the answer: median and largest of the last second [s]."""
        late = sorted(late for *_, late in self._late)
        return (late[len(late) // 2], late[-1]) if late else (math.nan, math.nan)

    def answer(self, index: int = -1) -> dict[str, Any]:
        """What was found in one frame of the latest batch, by the names of the tables, in SI.

        Parameters
        ----------
        index : int, optional
            Number of the frame in the batch; the last one if left out.
        """
        batch = self.latest
        if batch is None:
            return {}
        at = range(len(batch))[index]
        return {name: values[at] for name, values in columns_of(self.file, batch).items()}

    def said(self) -> str:
        """The answer for people, on a line."""
        answer = self.answer()
        if not answer:
            return "no frame yet"
        status = str(answer["status"])
        parts = [status.upper()]
        if status in _SILENT:
            return f"{parts[0]}: {_SILENT[status]}"
        area = "position_y" in answer
        of_forces = str(answer.get("force_unit", force_unit(area, self.file.finger.relative)))
        for name in ("position", "position_y", "position_z", "force", "angle", "azimuth", "half_width", "beside"):
            value = answer.get(name)
            if value is None or not math.isfinite(value):
                continue
            scale, unit = _UNITS.get(name, (1.0, of_forces))
            std = answer.get(f"{name}_std", math.nan)
            told = f"{name.replace('_', ' ')} {with_error(scale * value, scale * std, unit)}"
            whole = answer.get("newtons", math.nan) if name == "force" else math.nan
            parts.append(told + (f" ({number(whole, 3)} N)" if math.isfinite(whole) else ""))
        batch = self.latest
        if batch is not None and batch.decision is not None:
            verdict = SlipVerdict(int(batch.decision.verdict[-1])).name.lower().replace("_", " ")
            ratio = float(batch.decision.ratio[-1])
            share = f", {number(100 * ratio, 3)} % of what friction holds" if math.isfinite(ratio) else ""
            parts.append(f"slip: {verdict}{share}")
        return "  ".join(parts)

    def state(self) -> str:
        """Rate, losses and latency, on a line."""
        middle, worst = self.latency()
        lost = f"{self.live.lost} lost, {self.live.bad} broken"
        if not self._late and self._first is not None:
            silent = "no frames" if self._last >= self._since else "catching up"
            return f"{silent}  ({self.live.frames} so far, {lost})"
        return (
            f"{number(self.rate(), 4)} frames/s, {lost}, answer after {1e3 * middle:.2f} ms (at most {1e3 * worst:.1f})"
        )

    def end(self) -> None:
        """Say what came in all."""
        print(self.summary(), file=sys.stderr if isinstance(self, JsonLines) else sys.stdout, flush=True)

    def summary(self) -> str:
        """What came in all, in words."""
        seconds = 0.0 if self._first is None else self._last - self._first
        told = [f"{self.live.frames} frames in {seconds:.1f} s, {self.live.lost} lost, {self.live.bad} broken"]
        total, below, quantiles = sum(self._latency), 0, {}
        for k, count in enumerate(self._latency):
            below += count
            for share in (0.5, 0.99):
                if count and share not in quantiles and below >= share * total:
                    quantiles[share] = 1e3 * 1e-6 * 10 ** ((k + 0.5) / 40)
        if quantiles:
            told.append(f"answers after {quantiles[0.5]:.2g} ms (median), {quantiles[0.99]:.2g} ms (99 %)")
        happened = ", ".join(f"{count} {kind}" for kind, count in self.events.items())
        return "\n".join([*told, f"events: {happened or 'none'}"])


class PlainLines(View):
    """A line for each event and one a second, for a pipe or a log."""

    def tell(self, event: Event) -> None:
        """Print it."""
        print(f"{self._at(event.time)}  {event.kind}: {printable(event.text)}", flush=True)

    def draw(self) -> None:
        """Print how it stands."""
        if self._first is None:
            print("no frame yet", flush=True)
        else:
            print(f"{self._at(self._last)}  {self.said()}  |  {self.state()}", flush=True)

    def _at(self, time: float) -> str:
        return f"{time - (time if self._first is None else self._first):9.3f} s"


class JsonLines(View):
    """A line of JSON for each frame and for each event."""

    each = math.inf

    def see(self, batch: Batch) -> None:
        """Print what is in it."""
        super().see(batch)
        lines = []
        if len(batch):
            columns = {"time": batch.time, **columns_of(self.file, batch), "free": batch.free}
            if batch.decision is not None:
                names = [SlipVerdict(v).name.lower() for v in batch.decision.verdict.tolist()]
                columns |= {"slip": names, "slip_ratio": batch.decision.ratio, "readings": batch.readings}
            else:
                columns["readings"] = batch.readings
            lists = [value.tolist() if isinstance(value, np.ndarray) else value for value in columns.values()]
            for row in zip(*lists, strict=True):
                lines.append({"kind": "frame", **dict(zip(columns, row, strict=True))})
        for event in batch.events:
            told = {"event": event.kind, "time": event.time, "row": event.frame, "text": event.text}
            lines.append({"kind": "event", **told, "values": dict(event.values)})
        text = "".join(json.dumps(plain(line), allow_nan=False) + "\n" for line in lines)
        sys.stdout.write(text)
        sys.stdout.flush()


class Bars(View):
    """The readings as bars, redrawn ten times a second at most."""

    each = 0.1
    stays = True
    """Whether the last picture is left where it stands."""

    def __enter__(self) -> Self:
        from rich.console import Console
        from rich.live import Live as Screen

        self._told: deque[str] = deque(maxlen=_EVENTS)
        self._console = Console(highlight=False)
        self._screen = Screen(console=self._console, auto_refresh=False, transient=not self.stays)
        self._full = 20.0
        self._screen.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._screen.stop()

    def tell(self, event: Event) -> None:
        """Keep it for the picture."""
        at = event.time - (event.time if self._first is None else self._first)
        self._told.append(f"{at:9.3f} s  {event.kind}: {printable(event.text, 100)}")

    def draw(self) -> None:
        """Draw."""
        from rich.console import Group
        from rich.text import Text

        parts = [self._bars(), Text(self.said(), style="bold"), Text(self.state())]
        if self.live.recorder is not None:
            failed = self.live.recorder.failed
            parts.append(Text(failed or f"recording to {self.live.recorder.path}", style="red" if failed else ""))
        parts += [Text(line, style="dim", no_wrap=True, overflow="ellipsis") for line in self._told]
        self._screen.update(Group(*parts), refresh=True)

    def _bars(self) -> Any:
        from rich.table import Table
        from rich.text import Text

        table = Table.grid(padding=(0, 1))
        batch = self.latest
        if batch is None:
            return Text("no frame yet")
        array = self.file.finger.array
        own = np.asarray(array.offset)
        noise = np.asarray(array.noise)
        away = (batch.readings[-1] - own) / np.where(noise > 0, noise, np.inf)
        largest = float(np.nanmax(np.abs(away), initial=0.0))
        self._full = max(0.98 * self._full, 1.1 * largest, 20.0)
        names = self.file.names[:_MOST]
        columns = max(1, min(self._console.width // (_WIDE + 24), -(-len(names) // 8)))
        rows = -(-len(names) // columns)
        for k in range(rows):
            cells = []
            for i in range(k, len(names), rows):
                cells += [Text(printable(names[i], 12)), self._bar(float(away[i])), Text(_value(batch.readings[-1, i]))]
            table.add_row(*cells)
        if len(self.file.names) > _MOST:
            table.add_row(Text(f"and {len(self.file.names) - _MOST} more"))
        return table

    def _bar(self, away: float) -> Any:
        """From the middle to the right where a reading rose, to the left where it fell."""
        from rich.text import Text

        half = _WIDE // 2
        if not math.isfinite(away):
            return Text("out".center(_WIDE), style="red")
        mark = "#" if (self._console.encoding or "").lower().replace("-", "") != "utf8" else "\u2588"
        length = min(round(half * abs(away) / self._full), half)
        filled = (mark * length).ljust(half) if away > 0 else (mark * length).rjust(half)
        text = " " * half + "|" + filled if away > 0 else filled + "|" + " " * half
        return Text(text, style="green" if length else "dim")


def columns_of(file: FingerFile, batch: Batch) -> dict[str, Any]:
    """The columns of the command line's tables for the frames of a batch.

    Parameters
    ----------
    file : FingerFile
        The finger.
    batch : Batch
        With a frame at least.
    """
    every = np.arange(len(batch))
    answers = Answers(file, None, batch.first + every, every, batch.found)  # type: ignore[arg-type]
    return estimate_columns(answers)


def _value(reading: float) -> str:
    return number(float(reading), 3).rjust(10)
