"""All tools, one record each: those that correct blocks, in the order of the tool column, and those that inspect."""

from __future__ import annotations

from typing import NamedTuple

from ..base.commands import first_paragraph
from .base import Tool
from .border import BorderTool, OutlineTool
from .brush import EraseTool, MarkInvalidTool, PaintTool
from .depth_by_hand import DepthByHandTool
from .give import GiveTool
from .inspect import MeasureTool, ProfileTool, RectangleTool
from .refine import RefineTool
from .select import SelectTool
from .smart_select import SmartSelectTool
from .split import SplitTool


class ToolKind(NamedTuple):
    """A tool as a command of the window.

    Attributes
    ----------
    name : str
    text : str
        Its name for the user, with & before the mnemonic letter of the menu.
    icon : str
    key : str
        The letter that takes it.
    make : callable
        Returns the tool.
    inspects : bool
        Whether it changes nothing, and stands in the menu *Inspect*.
    """

    name: str
    text: str
    icon: str
    key: str
    make: type[Tool]
    inspects: bool = False

    @property
    def hint(self) -> str:
        """What it is for: the first paragraph of the docstring."""
        return first_paragraph(self.make)


KINDS = (
    ToolKind("select", "&Select", "ph.cursor", "A", SelectTool),
    ToolKind("smart_select", "S&mart select", "ph.magic-wand", "W", SmartSelectTool),
    ToolKind("border", "&Border", "ph.pencil-line", "D", BorderTool),
    ToolKind("refine", "&Refine edge", "ph.waves", "R", RefineTool),
    ToolKind("outline", "&Outline", "ph.scribble-loop", "L", OutlineTool),
    ToolKind("split", "Sp&lit", "ph.scissors", "S", SplitTool),
    ToolKind("paint", "&Paint", "ph.paint-brush", "B", PaintTool),
    ToolKind("erase", "&Erase", "ph.eraser", "E", EraseTool),
    ToolKind("give", "&Give", "ph.puzzle-piece", "G", GiveTool),
    ToolKind("mark_invalid", "Mark &invalid", "ph.shield-slash", "I", MarkInvalidTool),
    ToolKind("depth_by_hand", "&Depth by hand", "ph.hand-pointing", "H", DepthByHandTool),
    ToolKind("profile", "&Profile line", "ph.chart-line-up", "P", ProfileTool, inspects=True),
    ToolKind("rectangle", "&Rectangle", "ph.bounding-box", "T", RectangleTool, inspects=True),
    ToolKind("measure", "&Measure", "ph.ruler", "M", MeasureTool, inspects=True),
)


class Tools(dict[str, Tool]):
    """One tool of each kind by its name, made when it is first taken."""

    def __missing__(self, name: str) -> Tool:
        self[name] = made = next(kind for kind in KINDS if kind.name == name).make()
        return made
