"""Commands of the tool Depth by hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..base.commands import Command
from ..base.needs import Need
from ..tools.depth_by_hand import DepthByHandTool
from .context import Context

BY_HAND_COMMANDS = ("fill_by_hand", "continue_plane", "nearer_surface", "farther_surface", "remove_by_hand")
"""Their names, in the order of the tool bar."""


def by_hand_commands(context: Context, choose: Callable[[str], None]) -> Sequence[Command]:
    """Return the commands; `choose` makes a tool the active one."""
    editor = context.editor

    def with_tool(act: Callable[[DepthByHandTool], None]) -> Callable[[], None]:
        def handler() -> None:
            tool = editor.tools["depth_by_hand"]
            assert isinstance(tool, DepthByHandTool)
            if editor.tool is not tool:
                choose("depth_by_hand")
            act(tool)

        return handler

    return (
        Command(
            "fill_by_hand",
            "&Fill with depth",
            "State the depth in the tool bar at all missing depth of the selected blocks",
            icon="ph.paint-bucket",
            handler=with_tool(lambda tool: tool.fill(editor)),
            needs=Need.SELECTION,
        ),
        Command(
            "continue_plane",
            "&Continue this plane",
            "Continue the plane of the known depth in the rectangle, or in the selected blocks, into their holes",
            icon="ph.square-half",
            keys="Ctrl+Shift+U",
            handler=with_tool(lambda tool: tool.propose_plane(editor)),
            needs=Need.SELECTION,
        ),
        Command(
            "nearer_surface",
            "&Nearer surface",
            "Continue the nearer of the two surfaces around a hole of the selected blocks into it",
            icon="ph.arrow-line-down",
            handler=with_tool(lambda tool: tool.propose_surface(editor, nearer=True)),
            needs=Need.SELECTION,
        ),
        Command(
            "farther_surface",
            "F&arther surface",
            "Continue the farther of the two surfaces around a hole of the selected blocks into it",
            icon="ph.arrow-line-up",
            handler=with_tool(lambda tool: tool.propose_surface(editor, nearer=False)),
            needs=Need.SELECTION,
        ),
        Command(
            "remove_by_hand",
            "Remo&ve depth by hand",
            "Remove depth by hand from the selected blocks, or everywhere if none is selected",
            icon="ph.backspace",
            handler=with_tool(lambda tool: tool.erase(editor)),
            needs=Need.BY_HAND,
        ),
    )
