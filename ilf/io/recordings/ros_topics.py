"""Which topics of a ROS recording are the colour and the depth of one camera."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

from ...errors import InputError
from .recording import Topics
from .ros_realsense import stream_of

_ALIGNED = ("aligned_depth", "depth_registered", "depth_to_rgb", "depth_to_color", "depth2color")
"""Parts of the names of topics whose depth shows the pixels of the colour."""

_TRANSPORTS = re.compile(r"/(compressed|compressedDepth)$")


@dataclass(frozen=True)
class ImageTopic:
    """A topic with images.

    Attributes
    ----------
    name : str
    is_depth, is_colour : bool
        Neither is so of infrared.
    frame_id : str
        The coordinate frame of its camera.
    size : (int, int)
        Width and height of its first image.
    count : int
        How many messages it has.
    """

    name: str
    is_depth: bool
    is_colour: bool
    frame_id: str
    size: tuple[int, int]
    count: int

    @property
    def base(self) -> str:
        """The same images, however they are sent."""
        return _TRANSPORTS.sub("", self.name)

    @property
    def infos(self) -> tuple[str, ...]:
        """Topics that may have the calibration of their camera."""
        stream = stream_of(self.name)
        beside = f"{self.base.rsplit('/', 1)[0]}/camera_info"
        return (beside,) if stream is None else (beside, f"{stream}/info/camera_info")


@dataclass(frozen=True)
class CameraTopics:
    """Colour and depth of one camera, and whether both show the same pixels."""

    colour: ImageTopic
    depth: ImageTopic

    @property
    def is_registered(self) -> bool:
        """Depth is in the coordinate frame of colour, or says so by its name, and has its size."""
        same_frame = bool(self.depth.frame_id) and self.depth.frame_id == self.colour.frame_id
        return self.depth.size == self.colour.size and (same_frame or _is_aligned(self.depth))

    @property
    def rank(self) -> tuple[object, ...]:
        """The best camera has the least."""
        steps = zip(self.colour.name.split("/"), self.depth.name.split("/"), strict=False)
        together = len(list(takewhile(lambda step: step[0] == step[1], steps)))
        sent = sum(topic.base != topic.name for topic in (self.colour, self.depth))
        fewest = min(self.colour.count, self.depth.count)
        return not self.is_registered, not _is_aligned(self.depth), -together, -fewest, sent, *self.names

    @property
    def names(self) -> Topics:
        """Of colour and depth."""
        return self.colour.name, self.depth.name


def chosen_topics(topics: Sequence[ImageTopic], wanted: Topics | None) -> tuple[CameraTopics, str]:
    """The camera to read, and what there is to say of that; "" where there is no choice.

    Aligned depth goes first, then cameras whose topics lie together.

    Raises
    ------
    InputError
        If there is none, or those that are wanted are not there; the message says what there is.
    """
    if wanted is not None:
        found = [next((topic for topic in topics if topic.name == name), None) for name in wanted]
        if found[0] is None or found[1] is None:
            missing = " and ".join(name for name, topic in zip(wanted, found, strict=True) if topic is None)
            raise InputError(f"has no images of the topic {missing}. {_described(topics)}")
        return CameraTopics(found[0], found[1]), ""
    colours = [topic for topic in topics if topic.is_colour] or [topic for topic in topics if not topic.is_depth]
    cameras = [CameraTopics(colour, depth) for colour in colours for depth in topics if depth.is_depth]
    if not cameras:
        raise InputError(f"has no colour with depth. {_described(topics)}")
    best = min(cameras, key=lambda camera: camera.rank)
    others = sorted({camera.depth.base for camera in cameras} - {best.depth.base})
    others += sorted({camera.colour.base for camera in cameras} - {best.colour.base})
    if not others:
        return best, ""
    return best, (
        f"Colour of {best.colour.name} and depth of {best.depth.name} are read; there are also {', '.join(others)} "
        "(--topics COLOUR,DEPTH)."
    )


def _is_aligned(depth: ImageTopic) -> bool:
    return any(word in depth.name for word in _ALIGNED)


def _described(topics: Sequence[ImageTopic]) -> str:
    if not topics:
        return "It has no images at all."
    return f"Its images are {', '.join(topic.name for topic in topics)}."
