"""The dialog that sends blocks through the next frames: how many, how, and what becomes of work that is there."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel

_USUAL = 30


class CarryDialog(QDialog):
    """How many frames, and how.

    Parameters
    ----------
    frame_name : str
        Whose blocks are carried.
    names : sequence of str
        The frames after it.
    ways : sequence of (str, str, str)
        How blocks can be carried: name, text and explanation.
    how : str
        The name that is chosen at first.
    """

    def __init__(
        self, frame_name: str, names: Sequence[str], ways: Sequence[tuple[str, str, str]], how: str, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Carry Blocks of {frame_name}")
        self._names = names
        about = Message(lines=3)
        about.say(
            "The blocks go from each frame to the next, with names, locks, values and drawn borders. Blocks that need "
            "a look are marked. As long as a frame stays open, undo brings back what it had."
        )
        self.count = QSpinBox(minimum=1, maximum=len(names), value=min(_USUAL, len(names)))
        self.count.setToolTip("Through how many of the next frames of the list the blocks are carried")
        self.how = QComboBox()
        self.how.setToolTip("How blocks find their place in the next frame")
        for number, (name, text, hint) in enumerate(ways):
            self.how.addItem(text, name)
            self.how.setItemData(number, hint, Qt.ItemDataRole.ToolTipRole)
        self.how.setCurrentIndex(max(self.how.findData(how), 0))
        self.replaces = QCheckBox("&Replace blocks that have been edited or run")
        self.replaces.setToolTip(
            "Also in frames that have been worked on. Otherwise they stay as they are, and their blocks are carried on "
            "from there."
        )
        self.last = PlainLabel()
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        carry = buttons.button(QDialogButtonBox.StandardButton.Ok)
        carry.setText("&Carry")
        carry.setToolTip("Begin, in the background; a line under the views shows how far it is")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self.count.valueChanged.connect(lambda _: self._describe())
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Frames", self.count)
        form.addRow("", self.last)
        form.addRow("&How", self.how)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addLayout(form)
        layout.addWidget(self.replaces)
        layout.addWidget(buttons)
        self.resize(430, 0)
        self._describe()

    @property
    def chosen_way(self) -> str:
        """How blocks are carried."""
        return str(self.how.currentData())

    def _describe(self) -> None:
        self.last.setText(f"up to {self._names[self.count.value() - 1]}, of {len(self._names)} that follow")
