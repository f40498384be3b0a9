"""Editing of blocks: the active tool, and the commands that act on the chosen blocks."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QPainterPath

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.tools.base import Tool
from gui.tools.brush import BrushTool
from gui.tools.select import SelectTool
from gui.tools.split import SplitTool
from gui.views.linked_views import LinkedViews
from gui.views.pointer import PointerEvent
from ilf.ebs.edit import LabelPatch, delete, merge

BRUSH_RADII = (1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0)


class Editor(QObject):
    """Host of the tools: brings pointer events to the active one and its changes to the workspace."""

    tool_changed = Signal()
    brush_changed = Signal()
    message = Signal(str)

    def __init__(self, workspace: Workspace, views: LinkedViews, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._views = views
        self.tools: dict[str, Tool] = {
            "select": SelectTool(),
            "paint": BrushTool(erases=False),
            "erase": BrushTool(erases=True),
            "split": SplitTool(),
        }
        self._active = "select"
        self.brush_radius = 8.0
        workspace.about_to_change.connect(self.cancel)

    # the tools

    @property
    def tool(self) -> Tool:
        """The active tool."""
        return self.tools[self._active]

    @property
    def tool_name(self) -> str:
        """What the active tool is called."""
        return self._active

    def set_tool(self, name: str) -> None:
        """Make another tool the active one."""
        self.cancel()
        self._active = name
        self._views.set_preview(None)
        self.tool_changed.emit()

    def cancel(self) -> None:
        """Give up what the tool has under way."""
        if self._workspace.has_session:
            self.tool.cancel(self)

    def change_brush(self, steps: int) -> None:
        """A larger or smaller brush."""
        nearest = min(range(len(BRUSH_RADII)), key=lambda k: abs(BRUSH_RADII[k] - self.brush_radius))
        self.set_brush(BRUSH_RADII[min(max(nearest + steps, 0), len(BRUSH_RADII) - 1)])

    def set_brush(self, radius: float) -> None:
        """A brush of just this radius, in pixels."""
        self.brush_radius = radius
        self.brush_changed.emit()

    def pointer(self, event: PointerEvent) -> bool:
        """Bring an event to the active tool; False for a press that is not its."""
        return self._workspace.has_session and self.tool.pointer(event, self)

    # what tools ask of their host

    @property
    def session(self) -> Session:
        """The present frame's session."""
        return self._workspace.session

    def select(self, labels: list[int]) -> None:
        """Choose blocks."""
        self._workspace.select(labels)

    def commit(self, patch: LabelPatch | None, text: str) -> bool:
        """Make a change of the label map one undoable step."""
        return self._workspace.edit_labels(patch, text)

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke."""
        self._workspace.stroke(patch)

    def end_stroke(self, text: str) -> bool:
        """Make the stroke one undoable step."""
        return self._workspace.end_stroke(text)

    def drop_stroke(self) -> bool:
        """Give the stroke up."""
        return self._workspace.drop_stroke()

    def show_preview(self, path: QPainterPath | None) -> None:
        """Draw a tool's preview over the views."""
        self._views.set_preview(path)

    def say(self, message: str) -> None:
        """Show a message in the status bar."""
        self.message.emit(message)

    # commands on the chosen blocks

    def delete_selected(self) -> None:
        """Dissolve the chosen blocks."""
        session = self.session
        if self._refuses_locked("delete"):
            return
        if self.commit(delete(session.labels, session.selected, session.locked), self._text("Delete")):
            self.select([])

    def merge_selected(self) -> None:
        """Join the chosen blocks into the largest of them."""
        session = self.session
        if self._refuses_locked("merge"):
            return
        counts = session.counts()
        chosen = sorted(
            (label for label in session.selected if label in counts), key=lambda label: -counts[label].pixels
        )
        if len(chosen) < 2:
            self.say("Choose two or more blocks to merge: Ctrl+click adds one.")
        elif self.commit(merge(session.labels, chosen, session.locked), self._text("Merge")):
            self.select(chosen[:1])

    def toggle_locks(self) -> None:
        """Lock the chosen blocks, or unlock them if all are locked."""
        session = self.session
        lock = not all(session.info(label).locked for label in session.selected)
        for label in list(session.selected):
            if session.info(label).locked != lock:
                self._workspace.set_lock(label, lock)

    def select_all(self) -> None:
        """Choose every block."""
        self.select(list(self.session.counts()))

    def new_block(self) -> None:
        """Choose a number that no block has yet, and the brush to paint it."""
        label = self._workspace.start_block()
        self.set_tool("paint")
        self.say(f"Paint the pixels of {self.session.info(label).name}.")

    def _refuses_locked(self, verb: str) -> bool:
        locked = [label for label in self.session.selected if label in self.session.locked]
        if locked:
            self.say(f"{self.session.info(locked[0]).name} is locked. Unlock it to {verb} it.")
        return bool(locked)

    def _text(self, verb: str) -> str:
        chosen = self.session.selected
        return f"{verb} {self.session.info(chosen[0]).name}" if len(chosen) == 1 else f"{verb} {len(chosen)} blocks"
