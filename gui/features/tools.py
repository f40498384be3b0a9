"""The tools in the window: their commands, options, keys and messages."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import Qt

from ilf._runtime.formatting import counted

from ..base.commands import Command
from ..base.needs import Need
from ..tools.keys import ToolKeys
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
        self.options = OptionsRow(actions["similar_only"], actions["to_no_block"], by_amount, by_hand)
        self.options.changed.connect(editor.set_option)
        self.keys = ToolKeys(context.window, editor, context.views)
        context.views.set_pointer_handler(self._point)
        context.loader.extracted.connect(editor.edge_data_source.hold)
        editor.message.connect(notes.show_message)
        editor.slivers_left.connect(lambda left: notes.offer(f"{counted(left, 'sliver')} left.", actions["clean_up"]))
        editor.failed.connect(lambda error: notes.report("Edges of the frame", error))
        changed = context.workspace.frames.session_changed, editor.tool_changed, editor.options_changed
        context.refresh.add("tools", self.show, changed)

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
            Command(
                "tool_select",
                "&Select",
                "Select blocks",
                icon="ph.cursor",
                keys="Ctrl+1",
                group="tool",
                handler=partial(self._choose, "select"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_smart_select",
                "S&mart select",
                "Select a surface or object by clicks, strokes or a box: a new block, or a change of the selected one",
                icon="ph.magic-wand",
                keys="Ctrl+G",
                group="tool",
                handler=partial(self._choose, "smart_select"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_border",
                "&Border",
                "Redraw a border between two blocks; the blocks on both sides follow",
                icon="ph.pencil-line",
                keys="Ctrl+2",
                group="tool",
                handler=partial(self._choose, "border"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_refine",
                "&Refine edge",
                "Brush along a border: only the pixels under the brush are divided anew, by edges, colour and depth",
                icon="ph.waves",
                keys="Ctrl+T",
                group="tool",
                handler=partial(self._choose, "refine"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_outline",
                "&Outline",
                "Outline pixels to add to the selected block, or to make a new block",
                icon="ph.scribble-loop",
                keys="Ctrl+3",
                group="tool",
                handler=partial(self._choose, "outline"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_split",
                "Sp&lit",
                "Cut a block along a line",
                icon="ph.scissors",
                keys="Ctrl+4",
                group="tool",
                handler=partial(self._choose, "split"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_paint",
                "&Paint",
                "Add pixels to the selected block",
                icon="ph.paint-brush",
                keys="Ctrl+5",
                group="tool",
                handler=partial(self._choose, "paint"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_erase",
                "&Erase",
                "Remove pixels from the selected block",
                icon="ph.eraser",
                keys="Ctrl+6",
                group="tool",
                handler=partial(self._choose, "erase"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_give",
                "&Give",
                "Give pieces of other blocks to the selected block",
                icon="ph.puzzle-piece",
                keys="Ctrl+7",
                group="tool",
                handler=partial(self._choose, "give"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_mark_invalid",
                "Mark depth &invalid",
                "Mark measured depth as invalid, for example behind glass: it counts as missing",
                icon="ph.shield-slash",
                keys="Ctrl+8",
                group="tool",
                handler=partial(self._choose, "mark_invalid"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_depth_by_hand",
                "&Depth by hand",
                "State depth where it is missing: paint it, fill a hole, or continue a surface",
                icon="ph.hand-pointing",
                keys="Ctrl+U",
                group="tool",
                handler=partial(self._choose, "depth_by_hand"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_profile",
                "&Profile line",
                "Draw a line across the image and plot the depth along it",
                icon="ph.chart-line-up",
                keys="Ctrl+I",
                group="tool",
                handler=partial(self._choose, "profile"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_rectangle",
                "&Rectangle",
                "Draw a rectangle for statistics and errors",
                icon="ph.bounding-box",
                keys="Ctrl+R",
                group="tool",
                handler=partial(self._choose, "rectangle"),
                needs=Need.FRAME,
            ),
            Command(
                "tool_measure",
                "&Measure",
                "Measure distances, heights and angles between points",
                icon="ph.ruler",
                keys="Ctrl+D",
                group="tool",
                handler=partial(self._choose, "measure"),
                needs=Need.FRAME,
            ),
            Command(
                "cancel_stroke",
                "Ca&ncel stroke",
                "Cancel the stroke or line in progress, or clear the selection",
                keys="Esc",
                handler=editor.escape,
            ),
            Command(
                "brush_smaller", "Smaller brush", keys="[", handler=lambda: editor.step_brush(-1), needs=Need.FRAME
            ),
            Command("brush_larger", "Larger brush", keys="]", handler=lambda: editor.step_brush(1), needs=Need.FRAME),
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
                "To &no block",
                "Assign erased pixels to no block instead of the best-fitting neighbour",
                icon="ph.selection-slash",
                keys="Ctrl+Shift+E",
                checkable=True,
                needs=Need.FRAME,
            ),
        )

    def _choose(self, name: str) -> None:
        """Make a tool the active one, and show the images, unless it works in the point cloud, too."""
        self._editor.set_tool(name)
        if not self._editor.tools[name].points_only:
            self.context.centre.show_images()

    def _point(self, event: PointerEvent) -> bool:
        self.context.refresh.now()  # the pointer event refers to what is drawn
        return self._editor.pointer(event)
