"""Messages of ROS to frames and back, with the message types of rosbags; and the node of the documents."""

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

import ilf
from ilf.stream.ros import depth_fields, frame_of_messages
from tests.ilf.bags import COLOUR, DEPTH, H, K, W

TYPES = get_typestore(Stores.ROS2_HUMBLE).types
METRES = np.where(DEPTH > 0, DEPTH / np.float32(1000), np.nan).astype(np.float32)
PAGE = Path(__file__).parents[3] / "assets" / "docs" / "robot.md"


def header() -> Any:
    return TYPES["std_msgs/msg/Header"](TYPES["builtin_interfaces/msg/Time"](3, 4), "eye")


def image(fields: dict[str, Any]) -> Any:
    return TYPES["sensor_msgs/msg/Image"](header(), **fields | {"data": np.frombuffer(fields["data"], np.uint8)})


def colour() -> Any:
    given = {"height": H, "width": W, "encoding": "rgb8", "is_bigendian": 0, "step": 3 * W, "data": COLOUR.tobytes()}
    return image(given)


def info() -> Any:
    region = TYPES["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    projection = np.insert(np.reshape(K, (3, 3)), 3, 0, axis=1).ravel()
    make = TYPES["sensor_msgs/msg/CameraInfo"]
    return make(header(), H, W, "plumb_bob", np.zeros(5), np.array(K), np.eye(3).ravel(), projection, 0, 0, region)


@pytest.mark.parametrize("encoding", ["32FC1", "16UC1"])
def test_depth_survives_the_round_trip(encoding):
    frame = frame_of_messages(colour(), image(depth_fields(METRES, encoding)), info(), "one")
    assert np.array_equal(frame.depth, METRES, equal_nan=True)
    assert np.array_equal(frame.rgb, COLOUR)
    assert frame.intrinsics == ilf.Camera(30.0, 28.0, 16.2, 10.9)
    assert frame_of_messages(colour(), image(depth_fields(METRES, encoding))).intrinsics is None


def test_missing_depth_is_what_rep_118_says():
    given = np.array([[1.0, np.nan, 70.0], [2.0, 65.5, 0.5]], np.float32)
    metres = np.frombuffer(depth_fields(given)["data"], "<f4").reshape(2, 3)
    assert np.array_equal(metres, given, equal_nan=True)
    millimetres = np.frombuffer(depth_fields(given, "16UC1")["data"], "<u2")
    assert millimetres.tolist() == [1000, 0, 0, 2000, 65500, 500]
    endless = METRES.copy()
    endless[0, :3] = np.inf, -np.inf, np.nan
    frame = frame_of_messages(colour(), image(depth_fields(endless)))
    assert not frame.known[0, :3].any()
    with pytest.raises(ilf.IlfError, match="not depth"):
        frame_of_messages(colour(), colour())


class Node:
    """In place of rclpy's: keeps what is published."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.published: list[tuple[str, Any]] = []

    def declare_parameter(self, name: str, value: Any) -> Any:
        return type("Parameter", (), {"value": value})

    def create_publisher(self, kind: Any, topic: str, depth: int) -> Any:
        return type("Publisher", (), {"publish": lambda _, message: self.published.append((topic, message))})()

    def create_subscription(self, *given: Any) -> None:
        self.subscribed = given

    def create_timer(self, *given: Any) -> None:
        self.timer = given

    def get_logger(self) -> Any:
        return type("Logger", (), {"info": lambda *_, **__: None, "warning": lambda _, text: pytest.fail(text)})()


def test_the_node_of_the_documents_publishes_completed_depth(monkeypatch):
    code = PAGE.read_text().split("```python\n")[1].split("```")[0]
    assert len(code.splitlines()) < 80
    filters = type("Filter", (), {"__init__": lambda *_, **__: None, "registerCallback": lambda *_: None})
    modules: dict[str, dict[str, Any]] = {
        "rclpy": {},
        "rclpy.node": {"Node": Node},
        "rclpy.qos": {"qos_profile_sensor_data": None},
        "sensor_msgs": {},
        "sensor_msgs.msg": {name: TYPES[f"sensor_msgs/msg/{name}"] for name in ("Image", "CameraInfo")},
        "message_filters": {"Subscriber": filters, "ApproximateTimeSynchronizer": filters},
    }
    for name, content in modules.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    names: dict[str, Any] = {"__name__": "complete_depth"}
    exec(code, names)
    node = names["CompleteDepth"]()
    try:
        node.keep_info(info())
        node.complete(colour(), image(depth_fields(METRES, "16UC1")))
    finally:
        node.stream.close()
    (topic, depth), (camera_topic, camera) = node.published
    assert (topic, camera_topic) == ("depth_completed", "depth_completed/camera_info")
    assert (depth.header.frame_id, camera.header.stamp.sec) == ("eye", 3)
    completed = np.frombuffer(depth.data, "<f4").reshape(H, W)
    assert np.isfinite(completed).all()
    assert np.array_equal(completed[DEPTH > 0], METRES[DEPTH > 0])
