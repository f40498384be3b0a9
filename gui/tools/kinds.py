"""The tools there are, by name: those that correct blocks in the order of the tool bar, and those that inspect."""

from __future__ import annotations

from gui.tools.base import Tool
from gui.tools.border import BorderTool
from gui.tools.brush import BrushTool
from gui.tools.distrust import DistrustTool
from gui.tools.give import GiveTool
from gui.tools.measure import MeasureTool
from gui.tools.outline import OutlineTool
from gui.tools.profile import ProfileTool
from gui.tools.rectangle import RectangleTool
from gui.tools.select import SelectTool
from gui.tools.split import SplitTool

CORRECTING = ("select", "border", "outline", "split", "paint", "erase", "give", "distrust")
INSPECTING = ("profile", "rectangle", "measure")
TOOL_NAMES = (*CORRECTING, *INSPECTING)


def make_tools() -> dict[str, Tool]:
    """One of each."""
    tools = (
        SelectTool(),
        BorderTool(),
        OutlineTool(),
        SplitTool(),
        BrushTool(erases=False),
        BrushTool(erases=True),
        GiveTool(),
        DistrustTool(),
        ProfileTool(),
        RectangleTool(),
        MeasureTool(),
    )
    return dict(zip(TOOL_NAMES, tools, strict=True))
