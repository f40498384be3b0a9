"""The relief of a frame by the usual parameters, for tools that help with editing."""

from __future__ import annotations

from ..edges.frame_edges import relief_of
from ..edges.relief import Relief
from ..frame import RGBDFrame
from ..parameters import BlockParameters


def usual_relief(frame: RGBDFrame) -> Relief:
    """What the known depth says, with the default smallest jump; remembered with the frame."""
    return relief_of(frame, BlockParameters())
