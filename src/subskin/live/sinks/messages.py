"""A recording as MCAP and as a bag of ROS 2, its messages in bytes (CDR), without ROS."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...io.files import making, needed
from ..recording.layout import About, columns_of
from ..recording.source import RowSource
from .filled import DEFINITIONS, Filled

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["CHUNK", "Messages", "need_log", "typestore", "write_bag", "write_mcap"]


def need_log(name: str) -> None:
    """Refuse bags, called `name`, where the libraries for them are not installed: raises a FileError."""
    rule = "bags need mcap and rosbags, which are not installed"
    needed(name, rule, 'pip install "subskin[log]"', "mcap", "rosbags")


def typestore() -> Any:
    """The types of ROS 2 with those of subskin."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, name))
    return store


class Messages:
    """Makes rows of a recording into messages, in bytes.

    Parameters
    ----------
    about : About
        What the recording says of itself.
    topic : str
        What the topics begin with.

    Raises
    ------
    InvalidValueError
        No name of a topic.
    """

    def __init__(self, about: About, topic: str = "/subskin") -> None:
        self.store, self._kinds = typestore(), columns_of(about)
        self._filled = Filled(about, self.store.types.__getitem__, topic)
        self.topics = self._filled.topics
        """The type of each topic."""

    def definition(self, kind: str) -> str:
        """The text of a type with all that it is made of, as bags hold it.

        Parameters
        ----------
        kind : str
            The type.
        """
        return str(self.store.generate_msgdef(kind, ros_version=2)[0])

    def of(self, rows: pa.RecordBatch) -> Iterator[tuple[str, int, bytes]]:
        """Topic, time [ns since 1970] and bytes of the messages of some rows, in their order.

        Parameters
        ----------
        rows : pyarrow.RecordBatch
            Rows of a recording.
        """
        column: dict[str, Any] = {
            name: rows.column(name).to_pylist() if kind == "string" else rows.column(name).to_numpy()
            for name, kind in self._kinds.items()
        }
        for message in self._filled.of(column):
            yield message.topic, message.time, bytes(self.store.serialize_cdr(message.content, message.type))


CHUNK = 1 << 18
"""Bytes of a chunk: what is lost where the file is cut."""


def write_mcap(recording: RowSource, path: Path, topic: str = "/subskin") -> Messages:
    """Write it, with the finger file as an attachment.

    Parameters
    ----------
    recording : RowSource
        An open recording, or another source of its rows.
    path : Path
        The file.
    topic : str, optional
        What the topics begin with.
    """
    need_log(str(path))
    from mcap.writer import Writer

    about = recording.about
    made = Messages(about, topic)
    with path.open("wb") as file:
        writer: Any = Writer(file, chunk_size=CHUNK)
        writer.start(profile="ros2", library=f"subskin {about.versions.get('subskin', '')}")
        at = max(int(about.epoch * 1e9), 0)
        writer.add_attachment(at, at, about.finger_name, "application/toml", about.finger.encode("utf-8"))
        writer.add_metadata(
            "subskin", {key: json.dumps(value) for key, value in about.document.items() if key != "finger"}
        )
        schemas = {
            kind: writer.register_schema(kind, "ros2msg", made.definition(kind).encode())
            for kind in dict.fromkeys(made.topics.values())
        }
        channels = {name: writer.register_channel(name, "cdr", schemas[kind]) for name, kind in made.topics.items()}
        for rows in recording.batches():
            for name, time, data in made.of(rows):
                writer.add_message(channels[name], time, data, time)
        writer.finish()
    return made


def write_bag(recording: RowSource, path: Path, topic: str = "/subskin") -> Messages:
    """Write it; the folder appears whole or not at all.

    Parameters
    ----------
    recording : RowSource
        An open recording, or another source of its rows.
    path : Path
        The folder; there is none yet.
    topic : str, optional
        What the topics begin with.
    """
    need_log(str(path))
    from rosbags.rosbag2 import StoragePlugin, Writer

    made = Messages(recording.about, topic)
    with making(path) as part, Writer(part, version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        writer.set_custom_data("subskin.finger", recording.about.finger)
        connections = {
            name: writer.add_connection(name, kind, typestore=made.store) for name, kind in made.topics.items()
        }
        for rows in recording.batches():
            for name, time, data in made.of(rows):
                writer.write(connections[name], time, data)
    return made
