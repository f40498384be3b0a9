"""The tools in the window: their commands, options, keys and messages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

from ilf._runtime.formatting import counted

from ..base.commands import Command, command
from ..base.needs import Need
from ..state.parts import Part
from ..tools.depth_by_hand import DepthByHandTool
from ..tools.editor import Editor
from ..tools.keys import ToolKeys
from ..tools.kinds import KINDS
from ..tools.options_row import OptionsRow
from ..views.interaction import PointerEvent
from .context import Context, Feature
from .inspect.panel import TOOLS, InspectPanel


class ToolsFeature(Feature):
    """Connects the editor, which hosts the tools, with the window."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._editor = editor = context.editor
        actions, notes = context.actions, context.notes
        hint, key = "Leave out the names beside the icons of the tools", "views/only_icons"
        names = Command("only_icons", "Tools &without names", hint, checkable=True, remembered=key)
        actions.add((*self._choices(), names))
        self.options = OptionsRow(actions)
        self.options.changed.connect(editor.set_option)
        self.keys = ToolKeys(context.window, editor, context.views, actions.held)
        context.views.navigation.set_handler(self._point)
        editor.message.connect(notes.show_message)
        editor.slivers_left.connect(lambda left: notes.offer(f"{counted(left, 'sliver')} left.", actions["clean_up"]))
        editor.failed.connect(lambda error: notes.report("Edges of the frame", error))
        changed = editor.tool_changed, editor.options_changed
        context.refresh.add("tools", self.show, on=Part.FRAME, also=changed)

    def show(self) -> None:
        """Show the active tool and its options, and a rectangle that was stored with the frame."""
        self.context.actions[f"tool_{self._editor.tool_name}"].setChecked(True)
        self.options.show_options(self._editor.tool.options, self._editor.options)
        if self._editor.ready and self.workspace.current.state.looked.region is not None:
            self.context.feature(InspectPanel)  # which draws it

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

    @command("cancel_stroke", "Cancel s&troke", keys="Esc")
    def _cancel_stroke(self) -> None:
        """Cancel the stroke or line in progress, or clear the selection."""
        self._editor.escape()

    @command(
        "similar_only", "Similar onl&y", icon="ph.eyedropper", keys="Ctrl+Shift+K", checkable=True, needs=Need.FRAME
    )
    def _keep_to_similar(self, on: bool) -> None:
        """Limit strokes to pixels of similar colour and depth, up to strong edges."""
        self._editor.set_option("similar_only", on)

    @command(
        "to_no_block",
        "Erase to &no block",
        icon="ph.selection-slash",
        keys="Ctrl+Shift+E",
        checkable=True,
        needs=Need.FRAME,
    )
    def _erase_to_no_block(self, on: bool) -> None:
        """Assign pixels that are taken away to no block instead of the best-fitting neighbour."""
        self._editor.set_option("to_no_block", on)

    def _step_size(self, steps: int) -> None:
        if self._editor.has_size:
            self._editor.step_brush(steps)
        elif self._editor.tool.wheel:
            self.notes.show_message("Point at a view first: the keys size the selection under the pointer.")
        else:
            self.notes.show_message("This tool has no size. Choose a brush or Smart select.")

    def _choose(self, name: str) -> None:
        """Make a tool the active one, and go to the images, unless it works in the point cloud, too."""
        self._editor.set_tool(name)
        if not self._editor.tools[name].points_only:
            self.context.centre.show_images()
            self.views.active.view.setFocus()
        if name in TOOLS:
            self.context.feature(InspectPanel).reveal_page(TOOLS.index(name))

    def _point(self, event: PointerEvent) -> bool:
        self.context.refresh.now()  # the pointer event refers to what is drawn
        return not self.keys.crosshair.give_way(event) or self._editor.pointer(event)

    # depth by hand

    def _by_hand(self, act: Callable[[DepthByHandTool, Editor], None]) -> None:
        """Let the tool act, which is the active one then."""
        tool = self._editor.tools["depth_by_hand"]
        assert isinstance(tool, DepthByHandTool)
        if self._editor.tool is not tool:
            self._choose("depth_by_hand")
        self._editor.attempt(lambda: act(tool, self._editor))

    @command("fill_by_hand", "&Fill with depth", icon="ph.paint-bucket", needs=Need.SELECTION)
    def fill(self) -> None:
        """State the depth in the tool bar at all missing depth of the selected blocks."""
        self._by_hand(DepthByHandTool.fill)

    @command("continue_plane", "&Continue this plane", icon="ph.square-half", keys="Ctrl+Shift+U", needs=Need.SELECTION)
    def continue_plane(self) -> None:
        """Continue the plane of the known depth in the rectangle, or in the selected blocks, into their holes."""
        self._by_hand(DepthByHandTool.propose_plane)

    @command("nearer_surface", "Nearer s&urface", icon="ph.arrow-line-down", needs=Need.SELECTION)
    def continue_nearer(self) -> None:
        """Continue the nearer of the two surfaces around a hole of the selected blocks into it."""
        self._by_hand(partial(DepthByHandTool.propose_surface, nearer=True))

    @command("farther_surface", "F&arther surface", icon="ph.arrow-line-up", needs=Need.SELECTION)
    def continue_farther(self) -> None:
        """Continue the farther of the two surfaces around a hole of the selected blocks into it."""
        self._by_hand(partial(DepthByHandTool.propose_surface, nearer=False))

    @command("remove_by_hand", "Remo&ve depth by hand", icon="ph.backspace", needs=Need.BY_HAND)
    def remove(self) -> None:
        """Remove depth by hand from the selected blocks, or everywhere if none is selected."""
        self._by_hand(DepthByHandTool.erase)
