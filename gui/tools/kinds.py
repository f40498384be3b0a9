"""The tools there are, by name, in the order of the tool bar."""

from __future__ import annotations

from gui.tools.base import Tool
from gui.tools.border import BorderTool
from gui.tools.brush import BrushTool
from gui.tools.distrust import DistrustTool
from gui.tools.give import GiveTool
from gui.tools.outline import OutlineTool
from gui.tools.select import SelectTool
from gui.tools.split import SplitTool

TOOL_NAMES = ("select", "border", "outline", "split", "paint", "erase", "give", "distrust")


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
    )
    return dict(zip(TOOL_NAMES, tools, strict=True))
