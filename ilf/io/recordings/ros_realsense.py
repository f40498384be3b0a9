"""What recordings of the RealSense library say in words of their own: depth units, and where its cameras stand.

Until 2.58 it wrote bags of ROS 1, whose images have no coordinate frame that says anything; since then .db3 of ROS 2.
"""

from __future__ import annotations

import math
import re
from typing import Any

from ...errors import FormatError

_STREAM = re.compile(r"((?:/device_\d+)/sensor_\d+)/[^/]+_\d+(?=/image/data)")


def stream_of(topic: str) -> str | None:
    """The stream that a topic has images of; None if it is of another program.

    Examples
    --------
    >>> stream_of("/device_0/sensor_0/Depth_0/image/data")
    '/device_0/sensor_0/Depth_0'
    """
    found = _STREAM.match(topic)
    return None if found is None else found[0]


def unit_topics(topic: str) -> tuple[str, ...]:
    """Topics that may have the depth units of a topic's images; none if it is of another program."""
    found = _STREAM.match(topic)
    names = ("Depth Units", "Depth_Units")
    return () if found is None else tuple(f"{found[1]}/option/{name}/value" for name in names)


def units_of(option: Any) -> float:
    """Units per metre, by the message of one of these topics; raises FormatError if it has no length in metres."""
    try:
        metres = float(option.data)
    except (AttributeError, TypeError, ValueError):
        metres = math.nan
    if not (0 < metres < 1):
        raise FormatError(f"its depth units are {option!s:.80}, which is no length.")
    return float(f"{1 / metres:.6g}")  # the option is a float32
