"""A recording as MCAP: one file for Foxglove, rosbag2 and any other reader, the definitions of its messages in it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..recording.source import RowSource
from .messages import Messages, need_log

__all__ = ["CHUNK", "write_mcap"]

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
