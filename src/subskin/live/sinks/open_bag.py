"""Bags of ROS, opened: their topics, and the messages of one."""

from __future__ import annotations

import contextlib
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

from ...errors import FileError
from .definitions import DEFINITIONS
from .messages import typestore

__all__ = ["Bag", "opened"]

_LARGEST = 1 << 26
"""Bytes of a record of MCAP at most, and of what is packed in one."""


class Bag(Protocol):
    """A bag that is open.

    Attributes
    ----------
    topics : dict
        The type of each topic.
    finger : str
        The finger file that subskin put in; "" where it did not.
    left : str
        What could not be read, known when the messages have ended.
    """

    topics: dict[str, str]
    finger: str
    left: str

    def messages(self, topic: str) -> Iterator[tuple[int, Any]]:
        """Time [ns since 1970] and content of each message of a topic.

        Parameters
        ----------
        topic : str
            One of `topics`.
        """


@contextlib.contextmanager
def opened(path: Path) -> Iterator[Bag]:
    """Open a bag.

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
