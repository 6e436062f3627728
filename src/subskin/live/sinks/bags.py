"""A bag of ROS made into a recording: the messages of one topic are the frames of a finger."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._check import FloatArray
from ..._path import path_of
from ...errors import FileError
from ...io.files import replacing
from ...io.finger_file import FingerFile, parse_finger
from ..batch import Batch
from ..recording.about import About, versions
from ..recording.parquet import write_parquet
from ..recording.rows import Counted
from .filled import TACTILE
from .messages import need_log
from .open_bag import opened

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["is_bag", "read_bag"]

_AT_ONCE = 2000
_READ: dict[str, Callable[[Any], FloatArray]] = {
    TACTILE: lambda m: np.concatenate(
        [np.empty(0), *(np.asarray(sensor.values, dtype=np.float64) for sensor in m.sensors)]
    ),
    "std_msgs/msg/Float32MultiArray": lambda m: np.asarray(m.data, dtype=np.float64),
    "std_msgs/msg/Float64MultiArray": lambda m: np.asarray(m.data, dtype=np.float64),
}
"""The numbers in a message, by its type."""


def is_bag(path: str | Path) -> bool:
    """Whether the name is that of a bag: .mcap, .db3, .bag, or a folder with metadata.yaml.

    Parameters
    ----------
    path : path-like
        A file or folder.
    """
    given = path_of(path)
    return given.suffix.lower() in (".mcap", ".db3", ".bag") or (given / "metadata.yaml").is_file()


def read_bag(
    path: str | Path, target: str | Path, topic: str | None = None, file: FingerFile | None = None
) -> tuple[int, str]:
    """Make a topic of a bag into a recording, Parquet, without estimates: `replay` makes these.

    Parameters
    ----------
    path : path-like
        The bag: .mcap, or a folder of ROS 2, or .bag of ROS 1. An MCAP file that was cut off gives what is in it.
    target : path-like
        The recording.
    topic : str, optional
        The topic; the only one that can be read if left out.
    file : FingerFile, optional
        The finger; the one that subskin put into the bag, or none, if left out.

    Returns
    -------
    (int, str)
        How many frames there were, and what could not be read.

    Raises
    ------
    FileError
        The bag cannot be read, or has no such topic.
    """
    need_log(str(path))
    name = str(path)
    try:
        with opened(path_of(path)) as bag:
            chosen = _chosen(name, bag.topics, topic)
            known = file or (parse_finger(bag.finger, f"the finger in {name}") if bag.finger else None)
            made = _Made(bag.messages(chosen), bag.topics[chosen], known)
            if made.first is None:
                raise FileError(name, f"topic {chosen} has no frame", "name another one with --topic")
            with replacing(target) as part:
                about = made.about(known, chosen)
                write_parquet(part, about, made.rows(about), "yes")
            return made.count, bag.left
    except FileError:
        raise
    except Exception as error:  # what the libraries raise of a damaged bag is not said anywhere
        said = (str(error).splitlines() or [""])[0][:100]
        raise FileError(name, f"it cannot be read as a bag ({type(error).__name__}: {said})", "copy it again") from None


def _chosen(name: str, topics: dict[str, str], topic: str | None) -> str:
    """The topic that is read."""
    can = sorted(known for known, kind in topics.items() if kind in _READ)
    listed = f"it has {', '.join(can[:20])}" if can else f"it has no topic with {', '.join(_READ)}"
    if topic is None and len(can) == 1:
        return can[0]
    if topic is None:
        raise FileError(name, listed, f"--topic {can[0]}" if can else "name another bag")
    if topic not in can:
        raise FileError(f"{name}: topic {topic}", listed, f"--topic {can[0]}" if can else "name another bag")
    return topic


class _Made:
    """Frames made of messages, all with as many numbers as the first one has."""

    def __init__(self, messages: Iterator[tuple[int, Any]], kind: str, file: FingerFile | None) -> None:
        self.count, self._bad, self._kind = 0, 0, kind
        self._messages = messages
        self._epoch, self._width = 0, 0
        self._sensors = 0 if file is None else len(file.names)
        self.first = next(self._frames(), None)

    def about(self, file: FingerFile | None, topic: str) -> About:
        """What the recording says of itself."""
        usual = tuple(f"c{i}" for i in range(self._width))
        if file is None:
            return About("", (), usual, "y", self._epoch * 1e-9, driver=f"bag {topic}", versions=versions())
        channels = file.names if len(file.names) == self._width else usual
        return About.for_finger(file, channels, self._epoch * 1e-9, f"bag {topic}")

    def rows(self, about: About) -> Iterator[pa.RecordBatch]:
        """The rows of all frames."""
        counted, held = Counted(about), [] if self.first is None else [self.first]
        for frame in self._frames():
            held.append(frame)
            if len(held) >= _AT_ONCE:
                yield counted.rows(held)
                held = []
        yield counted.rows(held)

    def _frames(self) -> Iterator[Batch]:
        for time, message in self._messages:
            values = _READ[self._kind](message).reshape(-1)
            if not self._width and values.size:
                self._width, self._epoch = values.size, time
            if values.size != self._width or not values.size:
                self._bad += 1
                continue
            at = np.array([(time - self._epoch) * 1e-9])
            readings = np.full((1, self._sensors), np.nan)
            bad, self._bad = self._bad, 0
            self.count += 1
            none, no = np.full(1, -1), np.zeros(1, dtype=bool)
            yield Batch(at, self._sent(message), none, values[None], readings, no, bad=bad, host_time=float(at[0]))

    def _sent(self, message: Any) -> FloatArray:
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        if stamp is None or not (stamp.sec or stamp.nanosec):
            return np.full(1, np.nan)
        return np.array([(stamp.sec * 10**9 + stamp.nanosec - self._epoch) * 1e-9])
