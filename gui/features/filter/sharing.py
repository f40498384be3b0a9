"""Parameters for all frames or for this one: the choice in the filter's panel, and its commands."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from ilf._runtime.formatting import counted

from ...base.actions import Actions
from ...state.workspace import Workspace
from .panel import FramesRow, Sharing


class SharingPresenter(QObject):
    """Says which frames the common values are of, and changes it, each time as one undoable step of the present frame.

    Signals
    -------
    message(str)
        Something that needs no answer.
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace, row: FramesRow, actions: Actions) -> None:
        super().__init__(row)
        self._workspace = workspace
        self._row = row
        self._actions = actions
        row.chosen.connect(self.choose)

    @property
    def sharing(self) -> Sharing:
        """Which frames have the values of the present one."""
        workspace = self._workspace
        if not workspace.shared.on:
            return Sharing.EACH
        own = workspace.has_session and workspace.session.own_parameters
        return Sharing.ALONE if own else Sharing.ALL

    def show(self) -> None:
        """Say it, and what can be done."""
        sharing = self.sharing
        self._row.show_sharing(sharing)
        no_frame = "" if self._workspace.has_session else "Open a frame first."
        self._row.setEnabled(not no_frame)
        shared = no_frame or ("" if sharing is not Sharing.EACH else "Every frame has values of its own.")
        allow = self._actions.allow
        allow(no_frame or ("" if sharing is not Sharing.ALL else "They are for all frames."), "share_values")
        allow(shared or ("" if sharing is Sharing.ALL else "This frame has its own values."), "keep_values")
        allow(shared or ("" if sharing is Sharing.ALONE else "This frame has the values of all."), "reset_values")
        allow(shared, "part_values")

    def choose(self, wanted: Sharing) -> None:
        """Have the values be of other frames; a frame with its own gets those of all back."""
        present = self.sharing
        if wanted is present:
            return
        do: dict[Sharing, Callable[[], None]] = {
            Sharing.EACH: self.part,
            Sharing.ALL: self.reset if present is Sharing.ALONE else self.share,
            Sharing.ALONE: self.keep,
        }
        do[wanted]()

    def share(self) -> None:
        """The present frame's values are for all frames from now on."""
        others = self._workspace.share_parameters()
        text = "The values of the filter are for all frames now."
        if others:
            text += f" {counted(len(others), 'open frame')} had others; undo brings them back."
        self.message.emit(text)

    def keep(self) -> None:
        """The present frame's values are its own from now on."""
        self._workspace.keep_own_parameters()

    def reset(self) -> None:
        """The present frame has the values of all again."""
        name = self._workspace.session.name
        changed = self._workspace.parameters != self._workspace.shared.values
        self._workspace.reset_to_shared()
        if changed:
            self.message.emit(f"{name} has the values of all frames again; undo brings its own back.")

    def part(self) -> None:
        """Every frame has values of its own from now on."""
        self._workspace.part_parameters()
        if any(entry.session is None and entry.has_state for entry in self._workspace.entries):
            self.message.emit("Frames that are not open have the values with which they were left.")
