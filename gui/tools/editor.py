"""The editor: runs the active tool and applies its changes to the workspace."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf._runtime.formatting import grouped
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.errors import InputError
from ilf.segmentation.editing.cleaning import count_slivers, tidied
from ilf.segmentation.editing.patches import LabelPatch
from ilf.segmentation.extraction import extract

from ..state.document import Document
from ..state.parts import Part
from ..state.workspace import Workspace
from ..views.interaction import PointerEvent, PointerKind, Preview
from ..views.linked_views import LinkedViews
from ..work.latest_request import LatestRequest
from .base import EdgeData, Result, Tool, ToolOptions
from .kinds import KINDS, Tools


class Editor(QObject):
    """Host of the tools: passes pointer and keys to the active tool, and its changes to the workspace.

    Signals
    -------
    tool_changed()
    options_changed()
    hint_changed()
        The hint of the active tool has changed.
    message(str)
    slivers_left(int)
        Number of islands, slivers and holes that an edit has left.
    failed(object)
        The exception that was raised by a background computation.
    """

    tool_changed = Signal()
    options_changed = Signal()
    hint_changed = Signal()
    message = Signal(str)
    slivers_left = Signal(int)
    failed = Signal(object)

    def __init__(self, workspace: Workspace, views: LinkedViews, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._views = views
        self._edge_requests = LatestRequest(self, self._take_error)
        self._edge_data: EdgeData | None = None
        self._edges_of: tuple[Document, BlockParameters] | None = None
        """Whose edges `_edge_data` are, or will be."""
        self._jobs = LatestRequest(self, self._take_error)
        self.tools = Tools()
        self.options = ToolOptions()
        self.tool_name = "select"
        """The name of the active tool; `set_tool` sets it."""
        self.hint = self.tool.hint
        """What a click or a drag would do, said by the active tool."""
        self._pointer: PointerEvent | None = None
        workspace.about_to_change.connect(self.cancel)
        workspace.on(Part.FRAME, self._turn)

    # the tools

    @property
    def tool(self) -> Tool:
        """The active tool."""
        return self.tools[self.tool_name]

    def set_tool(self, name: str) -> None:
        """Make a tool the active one."""
        self.cancel()
        self.tool_name = name
        self._views.set_preview(None)
        self._look_ahead()
        self._hover_again()
        self.hint = self.tool.hint
        self.tool_changed.emit()

    def cycle_tool(self, steps: int) -> None:
        """Move on by a number of tools, among those that correct or those that inspect."""
        inspects = {kind.name: kind.inspects for kind in KINDS}
        names = [name for name in inspects if inspects[name] == inspects[self.tool_name]]
        self.set_tool(names[(names.index(self.tool_name) + steps) % len(names)])

    @property
    def ready(self) -> bool:
        """Whether there is a frame to edit."""
        return self._workspace.shown is not None

    @property
    def busy(self) -> bool:
        """Whether the tool has an action in progress."""
        return self._workspace.shown is not None and self.tool.busy

    def cancel(self) -> bool:
        """Cancel the tool's action in progress; False if there is none."""
        self._jobs.forget()
        was_busy = self.busy
        if self._workspace.shown is not None:
            self.tool.cancel(self)
        return self._update_hint(was_busy)

    def escape(self) -> None:
        """Cancel the tool's action in progress, or else remove its mark, or else clear the selection."""
        if self.busy:
            self.cancel()
        elif not self._update_hint(self._workspace.shown is not None and self.tool.remove(self)):
            self.cancel()
            self._workspace.select([])

    def undo(self) -> None:
        """Cancel the tool's action in progress, or else undo the last step."""
        if not self.cancel():
            self._workspace.undo_group.undo()

    def finish(self) -> bool:
        """Complete the tool's action in progress; False if there is none."""
        return self._update_hint(self._workspace.shown is not None and self.attempt(lambda: self.tool.finish(self)))

    def undo_last(self) -> bool:
        """Undo the last part of the tool's action in progress; False if there is none."""
        return self._update_hint(self._workspace.shown is not None and self.tool.undo_last(self))

    def pointer(self, event: PointerEvent) -> bool:
        """Pass an event to the active tool; False if the tool does not use it."""
        if self._workspace.shown is None:
            return False
        if event.kind is PointerKind.WHEEL and not self.tool.wheel:
            if "brush" in self.tool.options:
                self.step_brush(event.steps)
            return "brush" in self.tool.options
        self._pointer = None if event.kind is PointerKind.LEAVE else event
        return self._update_hint(self.attempt(lambda: self.tool.pointer(event, self)))

    def _update_hint(self, answer: bool) -> bool:
        if self.tool.hint != self.hint:
            self.hint = self.tool.hint
            self.hint_changed.emit()
        return answer

    def _turn(self) -> None:
        """Update after a change of the current frame."""
        self._pointer = None
        if self._edges_of is not None and self._edges_of[0] is not self._workspace.shown:
            self._edges_of = self._edge_data = None
            self._edge_requests.forget()
        self._look_ahead()

    def _look_ahead(self) -> None:
        """Start finding the edges before they are needed."""
        by_edges = self.options.similar_only or "similar_only" not in self.tool.options
        if self._workspace.shown is not None and self.tool.guided and by_edges:
            _ = self.edge_data

    # options

    @property
    def has_size(self) -> bool:
        """Whether the tool has a brush, or a selection under the pointer whose size the wheel changes."""
        return "brush" in self.tool.options or (self.tool.wheel and self._pointer is not None)

    def step_brush(self, steps: int) -> None:
        """Change the brush size by steps, or what the wheel changes for the tool."""
        at = self._pointer
        if self.tool.wheel and at is not None:
            self.pointer(PointerEvent(PointerKind.WHEEL, at.x, at.y, pixel=at.pixel, steps=steps))
            return
        self.options.step_brush(steps)
        self._take_options()

    def set_option(self, name: str, value: float | bool) -> None:
        """Set one of the `ToolOptions`, for all tools that have it."""
        setattr(self.options, name, value)
        self._take_options()

    def _take_options(self) -> None:
        self._look_ahead()
        self.options_changed.emit()
        self._hover_again()

    def _hover_again(self) -> None:
        """Show the tool's preview at the pointer again."""
        if self._pointer is not None and self._workspace.shown is not None:
            at = self._pointer
            self._update_hint(self.tool.pointer(PointerEvent(PointerKind.HOVER, at.x, at.y, pixel=at.pixel), self))

    # interface for the tools (Host)

    @property
    def document(self) -> Document:
        """The current frame's document."""
        return self._workspace.current

    @property
    def edge_data(self) -> EdgeData | None:
        """Edges and regions of the current frame; None while they are being computed.

        Later changes of the invalid mask do not change them.
        """
        of = self.document, self.document.blocks.extraction or BlockParameters()
        if of != self._edges_of:
            self._edges_of, self._edge_data = of, None
            self._edge_requests.forget()
            self._edge_requests.ask(partial(_find_edges, of[0].frame, of[1]), partial(setattr, self, "_edge_data"))
        return self._edge_data

    def commit(self, patch: LabelPatch | None, text: str, label: int = 0) -> LabelPatch | None:
        """Make a change of the label map, with what it would leave behind, one undo step."""
        if patch is None:
            return None
        whole = self._tidied(patch, label)
        if self.document.edit(whole, text) and whole is not None:
            self._tell_of_rests(patch, whole)
        return whole

    def attempt(self, act: Callable[[], object]) -> bool:
        """Let a tool act, and return its answer; True, with a message, if it refuses by an InputError."""
        try:
            return bool(act())
        except InputError as error:
            self.show_message(str(error))
            return True

    def run_in_background(self, find: Callable[[], Result], take: Callable[[Result], None]) -> None:
        """Call `find` in the background, then `take` with its result, unless the tool is cancelled before."""

        def take_answer(answer: Result) -> None:
            self.attempt(lambda: take(answer))
            self._update_hint(True)

        self._jobs.ask(find, take_answer)

    def _take_error(self, error: Exception) -> None:
        if isinstance(error, InputError):
            self.show_message(str(error))
        else:
            self.failed.emit(error)

    @property
    def working(self) -> bool:
        """Whether a background computation is in progress."""
        return self._jobs.busy

    def show_preview(self, preview: Preview | None) -> None:
        """Draw a tool's preview over the views."""
        self._views.set_preview(preview)

    def show_message(self, message: str) -> None:
        """Show a message to the user."""
        self.message.emit(message)

    def _tidied(self, patch: LabelPatch, label: int) -> LabelPatch | None:
        """The change without slivers and rests; `label` is the block that is painted or drawn."""
        document, labels, by_hand = self.document, self.document.labels, self.document.blocks.by_hand
        known = document.frame.known if by_hand is None else document.frame.known | np.isfinite(by_hand.depth)
        smallest_block = (document.blocks.extraction or BlockParameters()).smallest_block(labels.size)
        whole = tidied(
            labels,
            patch,
            sliver_size(labels.size),
            known=known,
            smallest_block=smallest_block,
            label=label,
            locked=document.locked,
        )
        if whole is None:
            self.show_message("Nothing has changed: the new part would be too small to complete without known depth.")
        return whole

    def _tell_of_rests(self, patch: LabelPatch, whole: LabelPatch) -> None:
        """Name the blocks whose rest went with the change; count the slivers that it has added."""
        document, lost = self.document, patch.before[patch.before != patch.after]
        gone = set(np.unique(whole.before).tolist()) - document.counts().keys() - {0}
        for label in sorted(gone):
            rest = np.count_nonzero(whole.before == label) - np.count_nonzero(lost == label)
            if rest:
                self.show_message(
                    f"The last {grouped(rest)} px of {document.info(label).name} went to the block beside them."
                )
        former = document.labels.copy()
        whole.revert(former)
        left, there = (
            count_slivers(labels, sliver_size(labels.size), whole.box, document.locked)
            for labels in (document.labels, former)
        )
        if left > there:
            self.slivers_left.emit(left - there)


def _find_edges(frame: RGBDFrame, parameters: BlockParameters) -> EdgeData:
    """Find the edges and regions of a frame by an extraction, for which its edges are cached."""
    extraction = extract(frame, parameters)
    return EdgeData.of(frame, extraction.strength, extraction.contracted)


def sliver_size(pixels: int) -> int:
    """Return the size from which a part is no sliver, for a frame with `pixels` pixels."""
    return max(12, pixels // 10_000)
