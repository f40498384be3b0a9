"""Commands of the tool Depth by hand."""

from __future__ import annotations

from collections.abc import Callable

from ..base.commands import command
from ..base.needs import Need
from ..tools.depth_by_hand import DepthByHandTool
from ..tools.editor import Editor

BY_HAND_COMMANDS = ("fill_by_hand", "continue_plane", "nearer_surface", "farther_surface", "remove_by_hand")
"""Their names, in the order of the tool bar."""


class ByHandCommands:
    """The commands; `choose` makes a tool the active one."""

    def __init__(self, editor: Editor, choose: Callable[[str], None]) -> None:
        self._editor = editor
        self._choose = choose

    def _tool(self) -> DepthByHandTool:
        """Return the tool, which is the active one then."""
        tool = self._editor.tools["depth_by_hand"]
        assert isinstance(tool, DepthByHandTool)
        if self._editor.tool is not tool:
            self._choose("depth_by_hand")
        return tool

    @command("fill_by_hand", "&Fill with depth", icon="ph.paint-bucket", needs=Need.SELECTION)
    def fill(self) -> None:
        """State the depth in the tool bar at all missing depth of the selected blocks."""
        self._tool().fill(self._editor)

    @command("continue_plane", "&Continue this plane", icon="ph.square-half", keys="Ctrl+Shift+U", needs=Need.SELECTION)
    def continue_plane(self) -> None:
        """Continue the plane of the known depth in the rectangle, or in the selected blocks, into their holes."""
        self._tool().propose_plane(self._editor)

    @command("nearer_surface", "&Nearer surface", icon="ph.arrow-line-down", needs=Need.SELECTION)
    def continue_nearer(self) -> None:
        """Continue the nearer of the two surfaces around a hole of the selected blocks into it."""
        self._tool().propose_surface(self._editor, nearer=True)

    @command("farther_surface", "F&arther surface", icon="ph.arrow-line-up", needs=Need.SELECTION)
    def continue_farther(self) -> None:
        """Continue the farther of the two surfaces around a hole of the selected blocks into it."""
        self._tool().propose_surface(self._editor, nearer=False)

    @command("remove_by_hand", "Remo&ve depth by hand", icon="ph.backspace", needs=Need.BY_HAND)
    def remove(self) -> None:
        """Remove depth by hand from the selected blocks, or everywhere if none is selected."""
        self._tool().erase(self._editor)
