"""The tools in the window: their commands, options, keys and messages."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from PySide6.QtCore import Qt

from ilf._runtime.formatting import counted

from ..base.commands import Command, command, commands_of
from ..base.needs import Need
from ..state.parts import Part
from ..tools.keys import ToolKeys
from ..tools.kinds import KINDS
from ..tools.options_row import OptionsRow
from ..views.interaction import PointerEvent
from .by_hand import BY_HAND_COMMANDS, ByHandCommands
from .context import Context, Feature

_SWITCHES = (
    Command("only_icons", "Tools &without names", "Leave out the names beside the icons of the tools", checkable=True),
    Command(
        "similar_only",
        "&Similar only",
        "Limit strokes to pixels of similar colour and depth, up to strong edges",
        icon="ph.eyedropper",
        keys="Ctrl+Shift+K",
        checkable=True,
        needs=Need.FRAME,
    ),
    Command(
        "to_no_block",
        "Erase to &no block",
        "Assign pixels that are taken away to no block instead of the best-fitting neighbour",
        icon="ph.selection-slash",
        keys="Ctrl+Shift+E",
        checkable=True,
        needs=Need.FRAME,
    ),
)
"""Commands that others look at."""


class ToolsFeature(Feature):
    """Connects the editor, which hosts the tools, with the window."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._editor = editor = context.editor
        actions, notes = context.actions, context.notes
        actions.add((*self._choices(), *_SWITCHES))
        actions.add(commands_of(ByHandCommands(editor, self._choose)))
        by_amount = [actions[name] for name in ("grow_blocks", "shrink_blocks", "smooth_blocks")]
        by_hand = [actions[name] for name in BY_HAND_COMMANDS]
        self.options = OptionsRow(
            actions["similar_only"], actions["to_no_block"], actions["new_block"], by_amount, by_hand
        )
        self.options.changed.connect(editor.set_option)
        self.keys = ToolKeys(context.window, editor, context.views)
        context.views.navigation.set_handler(self._point)
        context.loader.extracted.connect(editor.edge_data_source.hold)
        editor.message.connect(notes.show_message)
        editor.slivers_left.connect(lambda left: notes.offer(f"{counted(left, 'sliver')} left.", actions["clean_up"]))
        editor.failed.connect(lambda error: notes.report("Edges of the frame", error))
        changed = editor.tool_changed, editor.options_changed
        context.refresh.add("tools", self.show, on=Part.FRAME, also=changed)

    def begin(self) -> None:
        """Connect the keys that switch commands on while held."""
        actions = self.context.actions
        for name, one in actions.commands.items():
            if one.held:
                self.keys.hold(Qt.Key[f"Key_{one.held}"], actions[name])

    def show(self) -> None:
        """Show the active tool and its options."""
        self.context.actions[f"tool_{self._editor.tool_name}"].setChecked(True)
        self.options.show_options(self._editor.tool.options, self._editor.options)

    def _choices(self) -> Iterator[Command]:
        """Return the commands that take a tool."""
        for kind in KINDS:
            handler = partial(self._choose, kind.name)
            yield Command(
                f"tool_{kind.name}",
                kind.text,
                kind.hint,
                kind.icon,
                kind.key,
                group="tool",
                handler=handler,
                needs=Need.FRAME,
            )

    @command("next_tool", "Next tool", keys=".", needs=Need.FRAME)
    def _take_next(self) -> None:
        self._editor.cycle_tool(1)

    @command("previous_tool", "Previous tool", keys=",", needs=Need.FRAME)
    def _take_previous(self) -> None:
        self._editor.cycle_tool(-1)

    @command("brush_smaller", "Smaller brush or selection", keys="[", needs=Need.FRAME)
    def _shrink_brush(self) -> None:
        self._step_size(-1)

    @command("brush_larger", "Larger brush or selection", keys="]", needs=Need.FRAME)
    def _grow_brush(self) -> None:
        self._step_size(1)

    @command("cancel_stroke", "Ca&ncel stroke", keys="Esc")
    def _cancel_stroke(self) -> None:
        """Cancel the stroke or line in progress, or clear the selection."""
        self._editor.escape()

    def _step_size(self, steps: int) -> None:
        if self._editor.has_size:
            self._editor.step_brush(steps)
        elif self._editor.tool.wheel:
            self.context.notes.show_message("Point at a view first: the keys size the selection under the pointer.")
        else:
            self.context.notes.show_message("This tool has no size. Choose a brush or Smart select.")

    def _choose(self, name: str) -> None:
        """Make a tool the active one, and show the images, unless it works in the point cloud, too."""
        self._editor.set_tool(name)
        if not self._editor.tools[name].points_only:
            self.context.centre.show_images()

    def _point(self, event: PointerEvent) -> bool:
        self.context.refresh.now()  # the pointer event refers to what is drawn
        return not self.keys.crosshair.give_way(event) or self._editor.pointer(event)
