"""Bags of ROS, opened, and made into recordings: the messages of one topic are the frames of a finger."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._check import FloatArray
from ...errors import FileError
from ...io.files import path_of, replacing
from ...io.finger_file import FingerFile, parse_finger
from ..batch import Batch
from ..recording.files import write_parquet
from ..recording.layout import About, versions
from ..recording.rows import Counted
from .messages import DEFINITIONS, TACTILE, need_log, typestore

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["is_bag", "opened", "read_bag"]

_LARGEST = 1 << 26
"""Bytes of a record of MCAP at most, and of what is packed in one."""


@contextlib.contextmanager
def opened(path: Path) -> Iterator[_Reader | _Mcap]:
    """Open a bag: `topics` has the type of each, `messages(topic)` gives time [ns since 1970] and content of each.

    `finger` is the finger file that subskin put in, or "", and `left` what could not be read, when messages have ended.

    Parameters
    ----------
    path : Path
        A file, or a folder.

    Raises
    ------
    FileError
        There is none.
    """
    if not path.exists():
        raise FileError(str(path), "there is no such file", "check the name and the folder")
    if path.suffix.lower() == ".mcap" and path.is_file():
        yield _Mcap(path)
        return
    from rosbags.highlevel import AnyReader

    with AnyReader([path], default_typestore=typestore()) as reader:
        yield _Reader(reader)


class _Reader:
    """Any other bag, through rosbags, which refuses one that was cut off."""

    def __init__(self, reader: Any) -> None:
        self._reader, self.left = reader, ""
        self.topics = {c.topic: c.msgtype for c in reader.connections}
        told = [getattr(getattr(getattr(r, "storage", None), "metadata", None), "custom", None) for r in reader.readers]
        self.finger = next((str(d["subskin.finger"]) for d in told if d and "subskin.finger" in d), "")

    def messages(self, topic: str) -> Iterator[tuple[int, Any]]:
        connections = [c for c in self._reader.connections if c.topic == topic]
        for connection, time, data in self._reader.messages(connections):
            yield time, self._reader.deserialize(data, connection.msgtype)


class _Mcap:
    """An MCAP file, read from its beginning: one that was cut off gives what is in it."""

    def __init__(self, path: Path) -> None:
        from mcap.records import Attachment, Channel, Schema

        self._path, self.left, self.finger = path, "", ""
        self._channels: dict[int, Any] = {}
        self._schemas: dict[int, Any] = {}
        for record in self._records():
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record
            elif isinstance(record, Attachment) and record.media_type == "application/toml" and not self.finger:
                self.finger = record.data.decode("utf-8")
        self.topics = {
            c.topic: self._schemas[c.schema_id].name
            for c in self._channels.values()
            if c.schema_id in self._schemas and c.message_encoding == "cdr"
        }

    def messages(self, topic: str) -> Iterator[tuple[int, Any]]:
        from mcap.records import Message

        ids = {number for number, channel in self._channels.items() if channel.topic == topic}
        store = self._store(self.topics[topic], next(iter(ids)))
        for record in self._records():
            if isinstance(record, Message) and record.channel_id in ids:
                yield record.log_time, store.deserialize_cdr(record.data, self.topics[topic])

    def _store(self, kind: str, number: int) -> Any:
        """The types with those that the bag defines."""
        from rosbags.typesys import get_types_from_msg

        store = typestore()
        schema = self._schemas[self._channels[number].schema_id]
        if kind not in DEFINITIONS and kind not in store.types and schema.encoding == "ros2msg":
            store.register(get_types_from_msg(schema.data.decode("utf-8"), kind))
        return store

    def _records(self) -> Iterator[Any]:
        from mcap.exceptions import McapError
        from mcap.records import Chunk
        from mcap.stream_reader import StreamReader, breakup_chunk

        self.left, skipped = "", 0
        with self._path.open("rb") as file:
            records = iter(StreamReader(file, emit_chunks=True, record_size_limit=_LARGEST).records)
            while True:
                try:
                    record = next(records, None)
                except (McapError, struct.error, ValueError, OverflowError, MemoryError) as error:
                    self.left = f"what comes after byte {file.tell()} ({type(error).__name__})"
                    return
                if record is None:
                    break
                if not isinstance(record, Chunk):
                    yield record
                elif record.uncompressed_size > _LARGEST:
                    raise FileError(str(self._path), f"a chunk is larger than {_LARGEST} bytes", "write it again")
                else:
                    try:
                        inside = breakup_chunk(record, validate_crc=True)
                    except Exception:  # each packer has its own errors
                        skipped += 1
                        continue
                    yield from inside
        if skipped:
            self.left = f"{skipped} damaged chunks"


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
