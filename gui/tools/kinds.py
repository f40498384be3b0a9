"""All tools by name: those that correct blocks, in the order of the tool bar, and those that inspect."""

from __future__ import annotations

from .base import Tool
from .border import BorderTool, OutlineTool
from .brush import BrushTool, MarkInvalidTool
from .depth_by_hand import DepthByHandTool
from .give import GiveTool
from .inspect import MeasureTool, ProfileTool, RectangleTool
from .refine import RefineTool
from .select import SelectTool
from .smart_select import SmartSelectTool
from .split import SplitTool

CORRECTING = (
    *("select", "border", "refine", "outline", "smart_select", "split", "paint", "erase", "give"),
    *("mark_invalid", "depth_by_hand"),
)
INSPECTING = ("profile", "rectangle", "measure")
TOOL_NAMES = (*CORRECTING, *INSPECTING)


def make_tools() -> dict[str, Tool]:
    """Return one tool of each kind, by name."""
    tools = (
        SelectTool(),
        BorderTool(),
        RefineTool(),
        OutlineTool(),
        SmartSelectTool(),
        SplitTool(),
        BrushTool(erases=False),
        BrushTool(erases=True),
        GiveTool(),
        MarkInvalidTool(),
        DepthByHandTool(),
        ProfileTool(),
        RectangleTool(),
        MeasureTool(),
    )
    return dict(zip(TOOL_NAMES, tools, strict=True))
