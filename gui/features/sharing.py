"""Which frames share the parameters of the filter: the row of the filter panel, and its commands."""

from __future__ import annotations

from enum import StrEnum

from PySide6.QtCore import Qt
from PySide6.QtGui import QStandardItemModel
from PySide6.QtWidgets import QHBoxLayout, QWidget

from ilf._runtime.formatting import counted

from ..base.commands import command
from ..base.needs import Need
from ..state.parts import Part
from ..widgets.basics import combo, command_button, lay_out
from .panel import Panel


class Sharing(StrEnum):
    """Which frames share the common parameters of the current one."""

    EACH = "Separate for each frame"
    ALL = "All frames"
    ALONE = "This frame only"


_HINTS = {
    Sharing.EACH: "Every frame has its own parameters; a frame that is opened next starts with those of this one",
    Sharing.ALL: "These parameters apply to all frames of the list except those with parameters of their own",
    Sharing.ALONE: "This frame has its own parameters; the others share theirs",
}


class SharingPanel(Panel):
    """The row of the filter panel that shows which frames the parameters apply to, and changes it; every change is one
    undoable step of the current frame."""

    title, icon, group = "Sharing", "ph.share-network", None
    parts = Part.FRAME | Part.LIST | Part.PARAMETERS

    def make(self) -> QWidget:
        """Make the row; the buttons are for a frame with parameters of its own."""
        self.box = combo({sharing: sharing.value for sharing in Sharing}, name="Frames that the parameters apply to")
        for number, sharing in enumerate(Sharing):
            self.box.setItemData(number, _HINTS[sharing], Qt.ItemDataRole.ToolTipRole)
        self.box.activated.connect(lambda _: self.choose(Sharing(self.box.currentData())))
        self._buttons = [command_button(self.context.actions[name]) for name in ("share_parameters", "reset_to_shared")]
        row = QWidget()
        lay_out(QHBoxLayout(row), self.box, *self._buttons, spacing=2, stretched=self.box)
        return row

    @command(
        "keep_own_parameters",
        "Use parameters for th&is frame only",
        icon="ph.push-pin",
        needs=Need.FRAME,
        why_off=lambda self: self._why_not(Sharing.ALL, "This frame has its own parameters already."),
    )
    def _keep_own(self) -> None:
        """Give this frame its own filter parameters: changes for all frames do not affect them."""
        self.workspace.parameters.keep_own()

    @property
    def present(self) -> Sharing:
        """Which frames share the parameters of the current one."""
        if not self.workspace.parameters.shared.on:
            return Sharing.EACH
        own = self.workspace.shown is not None and self.workspace.shown.state.own_parameters
        return Sharing.ALONE if own else Sharing.ALL

    def refresh(self, parts: Part) -> None:
        """Show which frames share the parameters."""
        sharing = self.present
        self.box.setCurrentIndex(self.box.findData(sharing))
        self.box.setToolTip(_HINTS[sharing])
        model = self.box.model()
        if isinstance(model, QStandardItemModel):
            model.item(self.box.findData(Sharing.ALONE)).setEnabled(sharing is not Sharing.EACH)
        for button in self._buttons:
            button.setVisible(sharing is Sharing.ALONE)
        self.widget.setEnabled(self.workspace.shown is not None)

    def choose(self, wanted: Sharing) -> None:
        """Change the sharing; a frame with its own parameters gets the shared ones back."""
        to_all = self._reset if self.present is Sharing.ALONE else self._share
        changes = {Sharing.EACH: self._separate, Sharing.ALONE: self._keep_own, Sharing.ALL: to_all}
        if wanted is not self.present:
            changes[wanted]()

    @command(
        "share_parameters",
        "Use parameters for all &frames",
        icon="ph.share-network",
        needs=Need.FRAME,
        why_off=lambda self: "The parameters are shared by all frames already." if self.present is Sharing.ALL else "",
    )
    def _share(self) -> None:
        """Use this frame's filter parameters for all frames in the list, now and after each change."""
        others = self.workspace.parameters.share()
        text = "All frames share the parameters of the filter now."
        if others:
            text += f" {counted(len(others), 'open frame')} had other parameters; undo restores them."
        self.notes.show_message(text)

    @command(
        "reset_to_shared",
        "Reset to shared parameters",
        icon="ph.arrow-u-up-left",
        needs=Need.FRAME,
        why_off=lambda self: self._why_not(Sharing.ALONE, "This frame uses the shared parameters already."),
    )
    def _reset(self) -> None:
        """Reset this frame to the filter parameters that all frames share."""
        name, parameters = self.workspace.current.name, self.workspace.parameters
        changed = parameters.current != parameters.shared.values
        parameters.reset_to_shared()
        if changed:
            self.notes.show_message(f"{name} uses the shared parameters again; undo restores its own.")

    def _why_separate(self) -> str:
        return self._why_not(self.present, "")

    @command("separate_parameters", "Separate parameters for each frame", needs=Need.FRAME, why_off=_why_separate)
    def _separate(self) -> None:
        """Set filter parameters for each frame separately; all frames keep their current parameters."""
        self.workspace.parameters.separate()
        if any(entry.document is None and entry.has_state for entry in self.workspace.entries):
            self.notes.show_message("Frames that are not open keep their last parameters.")

    def _why_not(self, needed: Sharing, otherwise: str) -> str:
        if self.present is Sharing.EACH:
            return "Every frame has its own parameters."
        return "" if self.present is needed else otherwise
