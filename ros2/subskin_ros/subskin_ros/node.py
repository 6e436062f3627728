"""A thin node: what a live stream of subskin finds, published. It makes no numbers of its own.

Everything of ROS is handed in, so that the node runs, and is tested, without it: `node` (an rclpy Node, or whatever has
`create_publisher`), and `types`, which gives the class of a message by its name.
"""

from __future__ import annotations

import importlib
import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

from subskin.live.recording import About
from subskin.live.recording.rows import table_of
from subskin.live.sinks.messages import Filled

DEPTH = 10
"""Messages that wait for a slow reader."""


def class_of(kind: str) -> Any:
    """The class of a message of ROS: "geometry_msgs/msg/Vector3" is geometry_msgs.msg.Vector3."""
    package, _, name = kind.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def has(types: Callable[[str], Any], kind: str) -> bool:
    """Whether there is such a message: tactile_msgs is a package of others."""
    try:
        types(kind)
    except ImportError:
        return False
    return True


class Finger:
    """Publishes batches: contact, wrench and events, and raw values and readings where `tactile_msgs` is there.

    Parameters
    ----------
    node : Node
        Has `create_publisher(type, topic, depth)`.
    about : About
        The finger, and what the device calls its channels.
    topic : str
        What the topics begin with.
    types : callable
        Gives the class of a message by its type.
    """

    def __init__(
        self, node: Any, about: About, topic: str = "/subskin", types: Callable[[str], Any] = class_of
    ) -> None:
        self.about = about
        without = () if has(types, "tactile_msgs/msg/TactileState") else ("raw", "readings")
        self.filled = Filled(about, types, topic, without)
        self.publishers = {
            name: node.create_publisher(types(kind), name, DEPTH) for name, kind in self.filled.topics.items()
        }

    def publish(self, batch: Any) -> int:
        """Publish what came out of a step of a chain; returns how many messages that were."""
        count = 0
        for message in self.filled.of(table_of(self.about, [batch])):
            self.publishers[message.topic].publish(message.content)
            count += 1
        return count

    def run(self, stream: Iterable[Any], going: Callable[[], bool] = lambda: True) -> None:
        """Publish all batches of a stream, as long as it is `going`."""
        for batch in stream:
            if not going():
                break
            self.publish(batch)


def main() -> None:
    """`ros2 run subskin_ros finger --ros-args -p finger:=finger.toml -p port:=serial:/dev/skin`."""
    import rclpy
    from std_srvs.srv import Trigger

    import subskin as ss

    rclpy.init()
    node = rclpy.create_node("subskin")
    for name, usual in (("finger", "finger.toml"), ("port", ""), ("topic", "/subskin")):
        node.declare_parameter(name, usual)
    given = {name: node.get_parameter(name).value for name in ("finger", "port", "topic")}
    stream = ss.live(given["finger"], port=given["port"] or None)

    def zero(_: Any, answer: Any) -> Any:
        stream.zero()
        answer.success, answer.message = True, "what is read now is the zero"
        return answer

    epoch = time.time() - stream.port.clock()
    about = About.for_finger(stream.chain.file, stream.chain.channels, epoch, type(stream.driver).__name__)
    node.create_service(Trigger, f"{given['topic']}/zero", zero)
    finger = Finger(node, about, given["topic"])
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()  # for the service alone
    try:
        finger.run(stream, rclpy.ok)
    finally:
        stream.close()
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
