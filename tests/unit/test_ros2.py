"""The package for ROS 2, as far as it can be tested without ROS: its messages, its node with a stub, its files."""

from __future__ import annotations

import importlib.util
import json
import re
import tomllib
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest

import subskin as ss
from subskin.live.recording import About
from subskin.live.sinks.messages import DEFINITIONS, Filled, typestore

from . import _live

ROOT = Path(__file__).parents[2]
ROS = ROOT / "ros2"


@pytest.fixture(scope="module")
def node():
    path = ROS / "subskin_ros" / "subskin_ros" / "node.py"
    spec = importlib.util.spec_from_file_location("subskin_ros_node", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class StubNode:
    """What the finger asks of a node of rclpy."""

    def __init__(self):
        self.sent = []

    def create_publisher(self, kind, topic, depth):
        assert isinstance(kind, type)
        assert depth > 0
        return SimpleNamespace(publish=lambda message: self.sent.append((topic, kind, message)))


@pytest.fixture(scope="module")
def steps():
    file = ss.io.parse_finger(_live.TEXT)
    return About.for_finger(file, _live.CHANNELS, 1.7e9, "csv"), _live.stream(file)


def test_the_node_publishes_what_was_found(node, steps):
    about, made = steps
    stub, store = StubNode(), typestore()
    finger = node.Finger(stub, about, "/left", store.types.__getitem__)
    finger.run(made)
    counts = {topic: sum(t == topic for t, *_ in stub.sent) for topic in finger.publishers}
    frames = sum(len(batch.raw) for batch in made)
    assert counts == {
        "/left/raw": frames, "/left/readings": frames, "/left/contact": frames,
        "/left/wrench": sum(int(np.isin(b.found.status, (0, 2)).sum()) for b in made if b.found is not None),
        "/left/events": 5,
    }  # fmt: skip
    for topic, kind, message in stub.sent:
        assert isinstance(message, kind)
        assert message.header.frame_id == "left", topic
        store.serialize_cdr(message, message.__msgtype__)  # each field has a value of its type
    pressed = next(batch.found for batch in made if batch.events and len(batch.raw))
    contacts = [m for topic, _, m in stub.sent if topic == "/left/contact" and m.status == m.OK]
    assert (contacts[0].position.y, contacts[0].force.x) == (pressed.position[0], pressed.components[0, 0])


def test_the_node_does_without_tactile_msgs_and_stops_when_told(node, steps):
    about, made = steps
    store = typestore()

    def types(kind):
        if kind.startswith("tactile_msgs"):
            raise ImportError(kind)
        return store.types[kind]

    stub, going = StubNode(), iter([True, True, False])
    finger = node.Finger(stub, about, types=types)
    assert set(finger.publishers) == {f"/subskin/{name}" for name in ("contact", "wrench", "events")}
    finger.run(made, lambda: next(going))
    assert sum(topic == "/subskin/contact" for topic, *_ in stub.sent) == len(made[0].raw) + len(made[1].raw)


def test_the_messages_are_those_that_bags_hold():
    for kind in ("Contact", "Event"):
        text = (ROS / "subskin_msgs" / "msg" / f"{kind}.msg").read_text()
        assert text == DEFINITIONS[f"subskin_msgs/msg/{kind}"]
        assert f'"msg/{kind}.msg"' in (ROS / "subskin_msgs" / "CMakeLists.txt").read_text()


def test_the_packages_have_the_version_of_subskin():
    for name in ("subskin_msgs", "subskin_ros"):
        package = ElementTree.parse(ROS / name / "package.xml").getroot()
        assert (package.find("name").text, package.find("version").text) == (name, ss.__version__)
        assert (
            package.find("license").text == tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["license"]
        )
    assert f'version="{ss.__version__}"' in (ROS / "subskin_ros" / "setup.py").read_text()


def test_the_layout_shows_what_there_is(steps):
    told = json.loads((ROS / "foxglove.json").read_text())
    panels = told["configById"]

    def leaves(part):
        return [part] if isinstance(part, str) else leaves(part["first"]) + leaves(part["second"])

    assert sorted(leaves(told["layout"])) == sorted(panels)
    store = typestore()
    finger = Filled(steps[0], store.types.__getitem__)
    paths = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    paths += [panel["topicPath"] for panel in panels.values() if "topicPath" in panel]
    assert len(paths) > 7
    for path in paths:
        topic, *fields = path.split(".")
        kind = finger.topics[topic]
        for field in (re.sub(r"\[.*\]", "", field) for field in fields):
            kinds = dict(store.fielddefs[kind][1])
            assert field in kinds, path
            _, of = kinds[field]
            of = of[0][1] if isinstance(of[0], tuple) else of  # of an array, what it holds
            kind = of if "/" in str(of) else kind
