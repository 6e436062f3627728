"""Messages of ROS 2 in bytes (CDR) and the texts that define them, without ROS."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ...errors import FileError
from ..recording.about import About
from ..recording.table import columns_of
from .definitions import DEFINITIONS
from .filled import Filled

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = ["Messages", "need_log", "typestore"]


def need_log(name: str) -> None:
    """Refuse bags where the libraries for them are not installed.

    Raises
    ------
    FileError
        They are not.
    """
    try:
        import mcap
        import rosbags  # noqa: F401
    except ImportError:
        rule = "bags need mcap and rosbags, which are not installed"
        raise FileError(name, rule, 'pip install "subskin[log]"') from None
    del mcap


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
