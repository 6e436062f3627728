"""Rows of a recording as messages of ROS 2: what is filled into them, MCAP and bags in bytes (CDR), without ROS.

The folder `ros2/subskin_msgs` of the repository holds the text of the messages of subskin as files.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import InvalidValueError
from ...io.files import making, needed
from ...loads import force_unit
from ..recording.layout import EVENT, FRAME, About, columns_of, unknowns_of
from ..recording.source import RowSource

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = [
    "CHUNK",
    "DEFINITIONS",
    "SLIP",
    "STATUS",
    "TACTILE",
    "Filled",
    "Message",
    "Messages",
    "need_log",
    "typestore",
    "write_bag",
    "write_mcap",
]

WRENCH, TACTILE = "geometry_msgs/msg/WrenchStamped", "tactile_msgs/msg/TactileState"
CONTACT, HAPPENED = "subskin_msgs/msg/Contact", "subskin_msgs/msg/Event"
DEFINITIONS = {
    CONTACT: """\
# What touched the skin in one frame, as subskin found it.
# Frame, right-handed: x into the skin, y along its surface, z across it; x = 0 is the surface.
# NaN: not known.

# status
uint8 OK=0
uint8 AMBIGUOUS=1        # another contact explains the readings nearly as well
uint8 NO_CONTACT=2
uint8 UNEXPLAINED=3      # no contact explains the readings
uint8 INCOMPLETE=4       # too few sensors could be used
uint8 NOT_SOUGHT=255

# slip
uint8 HOLDS=0
uint8 AT_RISK=1
uint8 SLIPS=2
uint8 CANNOT_TELL=3
uint8 NOT_ASKED=255

std_msgs/Header header
uint8 status
geometry_msgs/Point position      # where it presses [m]
geometry_msgs/Vector3 force       # on the skin [unit]: x presses in, y and z drag
string unit                       # "N"; "N/m" of a long contact: times length it is in N
float64 length                    # of a long contact [m]
float64 half_width                # of a long contact [m]
float64 beside                    # how far a point presses beside a row of sensors, |z| [m]
string[] covariance_of            # what the covariance is of: y and z of the position [m], n, ty and tz of the force
float64[] covariance              # row by row
float64 residual                  # chi-square
uint8 slip
float64 slip_ratio                # drag / (friction * normal force)
float64 slip_probability
int64 sequence                    # the device's number of the frame; -1 where it counts none
""",
    HAPPENED: """\
# Something that happened: contact_on, contact_off, slip_risk, slip, overload, sensor_lost, gap, zeroed, ...
std_msgs/Header header
string kind
string text
string values                     # JSON
""",
    TACTILE: """\
std_msgs/Header header
sensor_msgs/ChannelFloat32[] sensors
""",
}
"""Text of each message by its type."""

STATUS = {"ok": 0, "ambiguous": 1, "no_contact": 2, "unexplained": 3, "incomplete": 4, "": 255}
SLIP = {"holds": 0, "at_risk": 1, "slips": 2, "cannot_tell": 3, "": 255}
"""What a recording calls them, and what a message does."""


_NONE = (0.0, 0.0, 0.0)
_LAST = (1 << 31) - 1
"""The last second that a message of ROS can tell."""


@dataclass(frozen=True)
class Message:
    """One message.

    Parameters
    ----------
    topic, type : str
        Its topic, and its type.
    time : int
        When [ns since 1970].
    content : object
        The message.
    """

    topic: str
    type: str
    time: int
    content: Any


class Filled:
    """Fills messages with what stands in rows of a recording: those of any library, or of ROS itself.

    Parameters
    ----------
    about : About
        What the recording says of itself.
    types : callable
        Gives the class of a message by its type, as "geometry_msgs/msg/Vector3".
    topic : str
        What the topics begin with; `frame_id` is the same with _ between its parts.
    without : collection of str, optional
        Topics that are not wanted: "raw", "readings", "contact", "wrench", "events".

    Raises
    ------
    InvalidValueError
        No name of a topic.
    """

    def __init__(
        self, about: About, types: Callable[[str], Any], topic: str = "/subskin", without: Collection[str] = ()
    ) -> None:
        if not re.fullmatch(r"(/[A-Za-z][A-Za-z0-9_]{0,80}){1,8}", topic):
            raise InvalidValueError(f'topic "{topic}"', "it has to look like /left/finger", 'topic="/subskin"')
        self.about, self.topic, self.frame_id = about, topic, topic[1:].replace("/", "_")
        self._type = types
        self._unknown = unknowns_of(about.axes)
        told = {"raw": TACTILE, "readings": TACTILE, "contact": CONTACT, "wrench": WRENCH, "events": HAPPENED}
        left = {*without, *(() if about.names else ("readings",)), *(() if about.newtons else ("wrench",))}
        self.topics = {f"{topic}/{name}": kind for name, kind in told.items() if name not in left}
        """The type of each topic; a long contact without a length has no force in N, and no wrench."""

    def of(self, column: Mapping[str, Any]) -> Iterator[Message]:
        """The messages of some rows, in their order.

        Parameters
        ----------
        column : mapping of str to sequence
            The columns of the rows, by their names.
        """
        tables = {
            topic: np.column_stack([column[f"{prefix}.{name}"] for name in names]).astype(np.float32)
            for topic, prefix, names in (("raw", "raw", self.about.channels), ("readings", "reading", self.about.names))
            if f"{self.topic}/{topic}" in self.topics
        }
        for i, kind in enumerate(column["kind"]):
            if kind not in (FRAME, EVENT):
                continue
            time = column["time"][i]
            stamp = self._stamp(time if np.isfinite(time) else column["host_time"][i])
            if kind == EVENT:
                if f"{self.topic}/events" not in self.topics:
                    continue
                told = {"kind": column["name"][i], "text": column["text"][i], "values": column["values"][i]}
                yield self._message("events", stamp, **told)
                continue
            for topic, table in tables.items():
                channel = self._type("sensor_msgs/msg/ChannelFloat32")(name=topic, values=table[i])
                yield self._message(topic, stamp, sensors=[channel])
            if column["status"][i]:
                row = {name: values[i] for name, values in column.items()}
                if f"{self.topic}/contact" in self.topics:
                    yield self._message("contact", stamp, **self._contact(row))
                wrench = self._wrench(row) if f"{self.topic}/wrench" in self.topics else None
                if wrench is not None:
                    yield self._message("wrench", stamp, wrench=wrench)

    def _stamp(self, time: float) -> int:
        """Nanoseconds since 1970: whole numbers, for a float has not got that many digits."""
        if not np.isfinite(time) or abs(time) > _LAST:
            return 0
        return min(max(round(self.about.epoch * 1e9) + round(time * 1e9), 0), _LAST * 10**9)

    def _message(self, name: str, stamp: int, **fields: Any) -> Message:
        topic = f"{self.topic}/{name}"
        kind = self.topics[topic]
        at = self._type("builtin_interfaces/msg/Time")(sec=stamp // 10**9, nanosec=stamp % 10**9)
        header = self._type("std_msgs/msg/Header")(stamp=at, frame_id=self.frame_id)
        return Message(topic, kind, stamp, self._type(kind)(header=header, **fields))

    def _vector(self, values: Any, kind: str = "Vector3") -> Any:
        x, y, z = map(float, values)
        return self._type(f"geometry_msgs/msg/{kind}")(x=x, y=y, z=z)

    def _position(self, row: dict[str, Any]) -> tuple[float, float, float]:
        """A row of sensors does not tell z: of a long contact it is 0, of a point its size is `beside`."""
        z = row["position_z"] if self.about.axes == "yz" else 0.0 if row["load"] == "line" else np.nan
        return (0.0 if row["load"] else np.nan), row["position_y"], z

    def _force(self, row: dict[str, Any]) -> tuple[float, float, float]:
        return row["normal"], row["drag_y"], row["drag_z"] if self.about.axes == "yz" else 0.0 * row["normal"]

    def _contact(self, row: dict[str, Any]) -> dict[str, Any]:
        square = np.empty((len(self._unknown),) * 2)
        for i, a in enumerate(self._unknown):
            for j, b in enumerate(self._unknown[i:], i):
                square[i, j] = square[j, i] = row[f"cov.{a}.{b}"]
        long = row["load"] == "line"
        numbers = ("beside", "residual", "slip_ratio", "slip_probability")
        return {
            "status": STATUS.get(row["status"], 255),
            "position": self._vector(self._position(row), "Point"),
            "force": self._vector(self._force(row)),
            "unit": force_unit(row["load"] == "point", self.about.relative) if row["load"] in ("line", "point") else "",
            "length": float(self.about.length) if long and self.about.length is not None else np.nan,
            "half_width": float(row["half_width"]) if long else np.nan,
            "covariance_of": self._unknown,
            "covariance": square.reshape(-1),
            "slip": SLIP.get(row["slip"], 255),
            "sequence": int(row["sequence"]),
            **{name: float(row[name]) for name in numbers},
        }

    def _wrench(self, row: dict[str, Any]) -> Any:
        """Force on the skin [N] and its moment about the frame's origin [N m]; None where they are not sure."""
        if row["status"] == "no_contact":
            return self._type("geometry_msgs/msg/Wrench")(force=self._vector(_NONE), torque=self._vector(_NONE))
        if row["status"] != "ok":
            return None
        scale = float(self.about.length or np.nan) if row["load"] == "line" else 1.0
        fx, fy, fz = (scale * float(part) for part in self._force(row))
        _, y, z = self._position(row)
        z = z if np.isfinite(z) else 0.0  # beside a row: on which side is not known
        torque = self._vector((y * fz - z * fy, z * fx, -y * fx))
        return self._type("geometry_msgs/msg/Wrench")(force=self._vector((fx, fy, fz)), torque=torque)


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
