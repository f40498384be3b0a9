"""Commands on the chosen blocks."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from gui.state.workspace import Workspace
from gui.tools.editor import Editor, sliver_size
from ilf.ebs.edit import LabelPatch, clean_up, count_slivers, delete, grow, merge, parts_touch, shrink, smooth


class BlockCommands(QObject):
    """What can be done to the chosen blocks at once.

    Signals
    -------
    message(str)
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace, editor: Editor) -> None:
        super().__init__(editor)
        self._workspace = workspace
        self._editor = editor

    def delete(self) -> None:
        """Dissolve the chosen blocks."""
        session = self._workspace.session
        if self._refuses_locked("delete"):
            return
        if self._edit(lambda: delete(session.labels, session.selected, session.locked), self._text("Delete")):
            self._workspace.select([])

    def merge(self) -> None:
        """Join the chosen blocks into the largest of them."""
        session = self._workspace.session
        if self._refuses_locked("merge"):
            return
        counts = session.counts()
        chosen = sorted(
            (label for label in session.selected if label in counts), key=lambda label: -counts[label].pixels
        )
        if len(chosen) < 2:
            self.message.emit("Choose two or more blocks to merge: Ctrl+click adds one.")
            return
        apart = not parts_touch(session.labels, chosen)
        if self._edit(lambda: merge(session.labels, chosen, session.locked), self._text("Merge")):
            self._workspace.select(chosen[:1])
            if apart:
                name = session.info(chosen[0]).name
                self.message.emit(f"{name} now has parts that do not touch: each is completed without the others.")

    def toggle_locks(self) -> None:
        """Lock the chosen blocks, or unlock them if all are locked."""
        session = self._workspace.session
        lock = not all(session.info(label).locked for label in session.selected)
        changed = [label for label in session.selected if session.info(label).locked != lock]
        if changed:
            text = self._text("Lock" if lock else "Unlock")
            self._workspace.edit_infos({label: {"locked": lock} for label in changed}, text)

    def look_at(self) -> None:
        """The chosen blocks came from another frame, and are right as they are."""
        self._workspace.look_at(self._workspace.session.selected)

    def toggle_visibility(self) -> None:
        """Show the chosen blocks in the overlay if any of them is hidden, otherwise hide them."""
        session = self._workspace.session
        show = not all(session.info(label).visible for label in session.selected)
        for label in list(session.selected):
            if session.info(label).visible != show:
                self._workspace.set_visible(label, show)

    def select_all(self) -> None:
        """Choose every block."""
        self._workspace.select(list(self._workspace.session.counts()))

    def new(self) -> None:
        """Choose a number that no block has yet, and a tool to draw it."""
        label = self._workspace.start_block()
        if self._editor.tool_name != "outline":
            self._editor.set_tool("paint")
        verb = "Draw around" if self._editor.tool_name == "outline" else "Paint"
        self.message.emit(f"{verb} the pixels of {self._workspace.session.info(label).name}.")

    def grow(self) -> None:
        """Let the chosen blocks gain a rim."""
        self._change("Grow", grow)

    def shrink(self) -> None:
        """Let the chosen blocks lose a rim to their neighbours."""
        self._change("Shrink", shrink)

    def smooth(self) -> None:
        """Take bumps and dents from the outlines of the chosen blocks."""
        self._change("Smooth", smooth)

    def clean_up(self) -> None:
        """Give islands, slivers and holes of the whole frame to where they belong."""
        session = self._workspace.session
        smallest = sliver_size(session.labels.size)
        self._editor.cancel()
        found = count_slivers(session.labels, smallest, locked=session.locked)
        if self._edit(lambda: clean_up(session.labels, smallest, session.locked), "Clean up"):
            self.message.emit(f"{found} sliver{'s' * (found != 1)} of fewer than {smallest} px cleaned up.")
        else:
            self.message.emit(f"There are no islands, slivers or holes of fewer than {smallest} px.")

    def _change(self, verb: str, change: Callable[..., LabelPatch | None]) -> None:
        """One step of grow, shrink or smooth for all chosen blocks, one after another."""
        session, amount = self._workspace.session, self._editor.options.amount
        if self._refuses_locked(verb.lower()):
            return
        text = f"{self._text(verb)} by {amount} px"
        if not self._edit_each(lambda label: change(session.labels, label, amount, session.locked), text):
            self.message.emit(f"{verb}: nothing to change by {amount} px here.")

    def _edit_each(self, edit: Callable[[int], LabelPatch | None], text: str) -> bool:
        """Edits of several blocks as one step."""
        self._editor.cancel()
        for label in list(self._workspace.session.selected):
            self._workspace.stroke(edit(label))
        return self._workspace.end_stroke(text) is not None

    def _edit(self, edit: Callable[[], LabelPatch | None], text: str) -> bool:
        """An edit of the label map as it is without the stroke that may be under way."""
        self._editor.cancel()
        return self._workspace.edit_labels(edit(), text)

    def _refuses_locked(self, verb: str) -> bool:
        session = self._workspace.session
        locked = [label for label in session.selected if label in session.locked]
        if locked:
            self.message.emit(f"{session.info(locked[0]).name} is locked. Unlock it to {verb} it.")
        return bool(locked)

    def _text(self, verb: str) -> str:
        session = self._workspace.session
        chosen = session.selected
        return f"{verb} {session.info(chosen[0]).name}" if len(chosen) == 1 else f"{verb} {len(chosen)} blocks"
