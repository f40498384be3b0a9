"""Commands that share the parameters of the filter between all frames."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from ilf._runtime.formatting import counted

from ...state.workspace import Workspace
from .panel import Sharing


class SharingCommands(QObject):
    """Changes which frames share the parameters; every change is one undoable step of the current frame.

    Signals
    -------
    message(str)
        A message that needs no answer.
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._workspace = workspace

    @property
    def present(self) -> Sharing:
        """Which frames share the parameters of the current one."""
        workspace = self._workspace
        if not workspace.parameters.shared.on:
            return Sharing.EACH
        own = workspace.has_current and workspace.current.state.own_parameters
        return Sharing.ALONE if own else Sharing.ALL

    def choose(self, wanted: Sharing) -> None:
        """Change the sharing; a frame with its own parameters gets the shared ones back."""
        present = self.present
        if wanted is present:
            return
        do: dict[Sharing, Callable[[], None]] = {
            Sharing.EACH: self.separate,
            Sharing.ALL: self.reset if present is Sharing.ALONE else self.share,
            Sharing.ALONE: self.keep,
        }
        do[wanted]()

    def share(self) -> None:
        """Share the current frame's parameters with all frames."""
        others = self._workspace.parameters.share()
        text = "All frames share the parameters of the filter now."
        if others:
            text += f" {counted(len(others), 'open frame')} had other parameters; undo restores them."
        self.message.emit(text)

    def keep(self) -> None:
        """Give the current frame its own parameters."""
        self._workspace.parameters.keep_own()

    def reset(self) -> None:
        """Reset the current frame to the shared parameters."""
        name = self._workspace.current.name
        changed = self._workspace.parameters.current != self._workspace.parameters.shared.values
        self._workspace.parameters.reset_to_shared()
        if changed:
            self.message.emit(f"{name} uses the shared parameters again; undo restores its own.")

    def separate(self) -> None:
        """Give every frame its own parameters."""
        self._workspace.parameters.separate()
        if any(entry.document is None and entry.has_state for entry in self._workspace.entries):
            self.message.emit("Frames that are not open keep their last parameters.")
