"""The relief of a frame by the usual parameters, for tools that help with editing."""

from __future__ import annotations

from ..edges.relief import Relief, find_relief
from ..frame import RGBDFrame
from ..parameters import BlockParameters
from ..per_frame import once_per_frame


@once_per_frame
def usual_relief(frame: RGBDFrame) -> Relief:
    """What the known depth says, with the default smallest jump; remembered with the frame."""
    usual = BlockParameters()
    return find_relief(frame.depth, usual.depth_jump, usual.depth_jump_share)
