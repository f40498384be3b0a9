"""All tools, one record each: those that correct blocks, in the order of the tool column, and those that inspect."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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


@dataclass(frozen=True)
class ToolKind:
    """A tool as a command of the window.

    Attributes
    ----------
    name : str
    text : str
        Its name for the user, with & before the mnemonic letter of the menu.
    hint : str
        What it is for.
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
    hint: str
    icon: str
    key: str
    make: Callable[[], Tool]
    inspects: bool = False


KINDS = (
    ToolKind("select", "&Select", "Select blocks", "ph.cursor", "A", SelectTool),
    ToolKind(
        "smart_select",
        "S&mart select",
        "Select a surface or object by clicks, strokes or a box: a new block, or a change of the selected one",
        "ph.magic-wand",
        "W",
        SmartSelectTool,
    ),
    ToolKind(
        "border",
        "&Border",
        "Draw a border between two blocks anew; the blocks on both sides follow",
        "ph.pencil-line",
        "D",
        BorderTool,
    ),
    ToolKind(
        "refine",
        "&Refine edge",
        "Brush along a border: only the pixels under the brush are divided anew, by edges, colour and depth",
        "ph.waves",
        "R",
        RefineTool,
    ),
    ToolKind(
        "outline",
        "&Outline",
        "Outline pixels to make them a new block, or to add them to the selected one",
        "ph.scribble-loop",
        "L",
        OutlineTool,
    ),
    ToolKind("split", "Sp&lit", "Cut a block along a line", "ph.scissors", "S", SplitTool),
    ToolKind("paint", "&Paint", "Add pixels to the selected block with the brush", "ph.paint-brush", "B", PaintTool),
    ToolKind("erase", "&Erase", "Remove pixels from the selected block", "ph.eraser", "E", EraseTool),
    ToolKind("give", "&Give", "Give pieces of other blocks to the selected block", "ph.puzzle-piece", "G", GiveTool),
    ToolKind(
        "mark_invalid",
        "Mark &invalid",
        "Mark measured depth as invalid, for example behind glass: it counts as missing",
        "ph.shield-slash",
        "I",
        MarkInvalidTool,
    ),
    ToolKind(
        "depth_by_hand",
        "&Depth by hand",
        "State depth where it is missing: paint it, fill a hole, or continue a surface",
        "ph.hand-pointing",
        "H",
        DepthByHandTool,
    ),
    ToolKind(
        "profile",
        "&Profile line",
        "Draw a line across the image and plot the depth along it",
        "ph.chart-line-up",
        "P",
        ProfileTool,
        inspects=True,
    ),
    ToolKind(
        "rectangle",
        "&Rectangle",
        "Draw a rectangle for statistics and errors",
        "ph.bounding-box",
        "T",
        RectangleTool,
        inspects=True,
    ),
    ToolKind(
        "measure",
        "&Measure",
        "Measure distances, heights and angles between points",
        "ph.ruler",
        "M",
        MeasureTool,
        inspects=True,
    ),
)


class Tools(dict[str, Tool]):
    """One tool of each kind by its name, made when it is first used."""

    def __missing__(self, name: str) -> Tool:
        tool = self[name] = next(kind.make() for kind in KINDS if kind.name == name)
        return tool
