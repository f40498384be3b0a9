"""The dialog that starts a hold-out test: its hold-out and candidates."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QListWidget, QListWidgetItem, QWidget

from ilf._runtime.formatting import counted

from ...widgets.basics import Message, PlainLabel, answers, form, label_of, stack
from ...widgets.hold_out_choice import HoldOutChoice
from .hold_out import Candidate


class HoldOutDialog(QDialog):
    """Dialog of the hold-out test: the hold-out, and candidates with a tick each.

    Parameters
    ----------
    frame_name : str
    candidates : sequence of (Candidate, bool)
        What can be tested, and whether it is initially ticked.
    """

    def __init__(self, frame_name: str, candidates: Sequence[tuple[Candidate, bool]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Hold-out Test of {frame_name}")
        about = Message(lines=2)
        about.show_message(
            "Hides some known depth, completes the blocks without it, and compares the result with it. All ticked "
            "candidates are evaluated on the same pixels."
        )
        self.hold_out = HoldOutChoice()
        self.candidates = QListWidget()
        self.candidates.setToolTip("Candidates; tick those to test and compare")
        for candidate, ticked in candidates:
            item = QListWidgetItem(candidate.name, self.candidates)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            item.setData(Qt.ItemDataRole.UserRole, candidate)
            item.setCheckState(Qt.CheckState.Checked if ticked else Qt.CheckState.Unchecked)
        self.amount = PlainLabel()
        hint = "Test the ticked candidates in the background; the panel Accuracy shows the errors"
        buttons, self.test_button = answers(self, QDialogButtonBox.StandardButton.Ok, "&Test", hint)
        self.candidates.itemChanged.connect(lambda _: self._describe())
        self.hold_out.changed.connect(self._describe)

        choices = form(("&Hide", self.hold_out))
        label = label_of("&Candidates", self.candidates)
        stack(self, about, choices, label, self.candidates, self.amount, buttons, stretched=self.candidates)
        self.resize(430, 440)
        self._describe()

    def chosen(self) -> list[Candidate]:
        """The ticked candidates."""
        items = (self.candidates.item(number) for number in range(self.candidates.count()))
        return [item.data(Qt.ItemDataRole.UserRole) for item in items if item.checkState() == Qt.CheckState.Checked]

    def _describe(self) -> None:
        runs = len(self.chosen()) * len(self.hold_out.test().seeds)
        self.test_button.setEnabled(runs > 0)
        self.amount.setText(counted(runs, "run") if runs else "Tick at least one candidate.")
