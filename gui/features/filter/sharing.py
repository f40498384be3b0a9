"""Parameters shared by all frames or for the current one: row in the filter panel, and commands."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject, Signal

from ilf._runtime.formatting import counted

from ...base.actions import Actions
from ...state.workspace import Workspace
from .panel import Sharing, SharingRow


class SharingPresenter(QObject):
    """Presenter of which frames share the parameters; every change is one undoable step of the current frame.

    Signals
    -------
    message(str)
        A message that needs no answer.
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace, row: SharingRow, actions: Actions) -> None:
        super().__init__(row)
        self._workspace = workspace
        self._row = row
        self._actions = actions
        row.chosen.connect(self.choose)

    @property
    def sharing(self) -> Sharing:
        """Which frames share the parameters of the current one."""
        workspace = self._workspace
        if not workspace.parameters.shared.on:
            return Sharing.EACH
        own = workspace.has_session and workspace.session.own_parameters
        return Sharing.ALONE if own else Sharing.ALL

    def show(self) -> None:
        """Show the sharing, and enable its commands."""
        sharing = self.sharing
        self._row.show_sharing(sharing)
        no_frame = "" if self._workspace.has_session else "Open a frame first."
        self._row.setEnabled(not no_frame)
        shared = no_frame or ("" if sharing is not Sharing.EACH else "Every frame has its own parameters.")
        allow = self._actions.allow
        allow(
            no_frame or ("" if sharing is not Sharing.ALL else "The parameters are shared by all frames already."),
            "share_parameters",
        )
        allow(
            shared or ("" if sharing is Sharing.ALL else "This frame has its own parameters already."),
            "keep_own_parameters",
        )
        allow(
            shared or ("" if sharing is Sharing.ALONE else "This frame uses the shared parameters already."),
            "reset_to_shared",
        )
        allow(shared, "separate_parameters")

    def choose(self, wanted: Sharing) -> None:
        """Change the sharing; a frame with its own parameters gets the shared ones back."""
        present = self.sharing
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
        name = self._workspace.session.name
        changed = self._workspace.parameters.current != self._workspace.parameters.shared.values
        self._workspace.parameters.reset_to_shared()
        if changed:
            self.message.emit(f"{name} uses the shared parameters again; undo restores its own.")

    def separate(self) -> None:
        """Give every frame its own parameters."""
        self._workspace.parameters.separate()
        if any(entry.session is None and entry.has_state for entry in self._workspace.frames.entries):
            self.message.emit("Frames that are not open keep their last parameters.")
