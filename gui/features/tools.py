"""The tools in the window: their commands, options, keys and messages."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import Qt

from ilf._runtime.formatting import counted

from ..base.commands import Command
from ..base.needs import Need
from ..state.parts import Part
from ..tools.keys import ToolKeys
from ..tools.kinds import KINDS
from ..tools.options_row import OptionsRow
from ..views.interaction import PointerEvent
from .by_hand import BY_HAND_COMMANDS, by_hand_commands
from .context import Context, Feature


class ToolsFeature(Feature):
    """Connects the editor, which hosts the tools, with the window."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._editor = editor = context.editor
        actions, notes = context.actions, context.notes
        actions.add(self._commands())
        actions.add(by_hand_commands(context, self._choose))
        by_amount = [actions[name] for name in ("grow_blocks", "shrink_blocks", "smooth_blocks")]
        by_hand = [actions[name] for name in BY_HAND_COMMANDS]
        self.options = OptionsRow(
            actions["similar_only"], actions["to_no_block"], actions["new_block"], by_amount, by_hand
        )
        self.options.changed.connect(editor.set_option)
        self.keys = ToolKeys(context.window, editor, context.views)
        context.views.set_pointer_handler(self._point)
        context.loader.extracted.connect(editor.edge_data_source.hold)
        editor.message.connect(notes.show_message)
        editor.slivers_left.connect(lambda left: notes.offer(f"{counted(left, 'sliver')} left.", actions["clean_up"]))
        editor.failed.connect(lambda error: notes.report("Edges of the frame", error))
        changed = editor.tool_changed, editor.options_changed
        context.refresh.add("tools", self.show, on=Part.FRAME, also=changed)

    def begin(self) -> None:
        """Connect the keys that switch commands on while held."""
        actions = self.context.actions
        for name, command in actions.commands.items():
            if command.held:
                self.keys.hold(Qt.Key[f"Key_{command.held}"], actions[name])

    def show(self) -> None:
        """Show the active tool and its options."""
        self.context.actions[f"tool_{self._editor.tool_name}"].setChecked(True)
        self.options.show_options(self._editor.tool.options, self._editor.options)

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the threads have ended."""
        return self._editor.shutdown()

    def _commands(self) -> Sequence[Command]:
        editor = self._editor
        return (
            *(
                Command(
                    f"tool_{kind.name}",
                    kind.text,
                    kind.hint,
                    icon=kind.icon,
                    keys=kind.key,
                    group="tool",
                    handler=partial(self._choose, kind.name),
                    needs=Need.FRAME,
                )
                for kind in KINDS
            ),
            Command("next_tool", "Next tool", keys=".", handler=partial(editor.cycle_tool, 1), needs=Need.FRAME),
            Command(
                "previous_tool", "Previous tool", keys=",", handler=partial(editor.cycle_tool, -1), needs=Need.FRAME
            ),
            *(
                Command(name, text, keys=keys, handler=partial(self._step_size, steps), needs=Need.FRAME)
                for name, text, keys, steps in (
                    ("brush_smaller", "Smaller brush or selection", "[", -1),
                    ("brush_larger", "Larger brush or selection", "]", 1),
                )
            ),
            Command(
                "cancel_stroke",
                "Ca&ncel stroke",
                "Cancel the stroke or line in progress, or clear the selection",
                keys="Esc",
                handler=editor.escape,
            ),
            Command(
                "only_icons",
                "Tools &without names",
                "Leave out the names beside the icons of the tools",
                checkable=True,
            ),
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
