"""Messages of ROS 2 without ROS: the definitions are those of the package `rosbags`, and a field that no message has is an error."""

import numpy as np
import pytest

rosbags = pytest.importorskip("rosbags")
from rosbags.typesys import Stores, get_typestore  # noqa: E402

STORE = get_typestore(Stores.ROS2_JAZZY)
SECOND = 1_000_000_000
NUMBERS = {"bool": False, "string": "", "float32": 0.0, "float64": 0.0}


def default(kind):
    """A value of a field as rclpy begins with."""
    form, detail = int(kind[0]), kind[1]
    if form == 1:
        return NUMBERS.get(detail[0], 0)
    if form == 2:
        return blank(detail)
    inner, n = detail
    if int(inner[0]) == 1 and inner[1][0] not in ("string",):
        return np.zeros(n if form == 3 else 0, {"float64": np.float64, "float32": np.float32}.get(inner[1][0], inner[1][0]))
    return []


def blank(name):
    """An empty message, which takes no field that its type has not."""
    return message_class(name)()


CLASSES = {}


def message_class(name):
    if name not in CLASSES:
        fields = {field: kind for field, kind in STORE.fielddefs[name][1]}

        class Fields:
            __slots__ = tuple(fields)
            __msgtype__ = name

            def __init__(self):
                for field, kind in fields.items():
                    setattr(self, field, default(kind))

        CLASSES[name] = Fields
    return CLASSES[name]


def serialized(message):
    """The message as ROS 2 writes it, read back: wrong types of values are errors."""
    return STORE.deserialize_cdr(STORE.serialize_cdr(message, message.__msgtype__), message.__msgtype__)


def stamp(header, t_ns, frame="camera"):
    header.stamp.sec, header.stamp.nanosec, header.frame_id = t_ns // SECOND, t_ns % SECOND, frame


def image(t_ns, pixels, encoding, padding=0):
    message = blank("sensor_msgs/msg/Image")
    stamp(message.header, t_ns)
    rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
    rows = np.pad(rows, ((0, 0), (0, padding)))
    message.height, message.width, message.encoding, message.step = *pixels.shape[:2], encoding, rows.shape[1]
    message.data = rows.reshape(-1)
    return message
