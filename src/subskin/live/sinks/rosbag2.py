"""A recording as a bag of ROS 2: a folder with an MCAP file and metadata.yaml."""

from __future__ import annotations

from pathlib import Path

from ..recording.source import RowSource
from .folders import making
from .messages import Messages, need_log

__all__ = ["write_bag"]


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
