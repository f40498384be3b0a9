"""The dialog that starts a hold-out test: pattern, seeds and candidates."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QListWidget,
    QListWidgetItem,
    QSpinBox,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest

from ...widgets.basics import Message, PlainLabel, answers, form, label_of, stack
from .hold_out import Candidate

_PATTERN_KEY, _SEEDS_KEY = "hold_out_test/pattern", "hold_out_test/seeds"
_SEEDS, _MAX_SEEDS = 3, 20
_PATTERN_TEXTS = {"areas": "Areas, like holes in sensor depth", "random": "Random pixels"}


class HoldOutDialog(QDialog):
    """Dialog of the hold-out test: pattern, number of seeds, and candidates with a tick each.

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
        self.pattern = QComboBox()
        self.pattern.setToolTip("Which known depth is hidden")
        for name in sorted(HOLD_OUT_PATTERNS):
            self.pattern.addItem(_PATTERN_TEXTS.get(name, name), name)
            self.pattern.setItemData(self.pattern.count() - 1, HOLD_OUT_PATTERNS[name], Qt.ItemDataRole.ToolTipRole)
        self.pattern.setCurrentIndex(max(self.pattern.findData(QSettings().value(_PATTERN_KEY, "areas")), 0))
        self.seeds = QSpinBox(minimum=1, maximum=_MAX_SEEDS, value=int(str(QSettings().value(_SEEDS_KEY, _SEEDS, int))))
        self.seeds.setToolTip("Number of random hold-outs; errors are pooled. The same number gives the same pixels.")
        self.candidates = QListWidget()
        self.candidates.setToolTip("Candidates; tick those to test and compare")
        self._offered = [candidate for candidate, _ in candidates]
        for candidate, ticked in candidates:
            item = QListWidgetItem(candidate.name, self.candidates)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            item.setCheckState(Qt.CheckState.Checked if ticked else Qt.CheckState.Unchecked)
        self.amount = PlainLabel()
        hint = "Test the ticked candidates in the background; the panel Accuracy shows the errors"
        buttons, self.test_button = answers(self, QDialogButtonBox.StandardButton.Ok, "&Test", hint)
        self.candidates.itemChanged.connect(lambda _: self._describe())
        self.seeds.valueChanged.connect(lambda _: self._describe())

        choices = form(("&Hide", self.pattern), ("&Seeds", self.seeds))
        label = label_of("&Candidates", self.candidates)
        stack(self, about, choices, label, self.candidates, self.amount, buttons, stretched=self.candidates)
        self.resize(430, 440)
        self._describe()

    def test(self) -> HoldOutTest:
        """The selected test."""
        return HoldOutTest(str(self.pattern.currentData()), tuple(range(self.seeds.value())))

    def chosen(self) -> list[Candidate]:
        """The ticked candidates."""
        items = (self.candidates.item(number) for number in range(self.candidates.count()))
        pairs = zip(self._offered, items, strict=True)
        return [candidate for candidate, item in pairs if item.checkState() == Qt.CheckState.Checked]

    def accept(self) -> None:
        QSettings().setValue(_PATTERN_KEY, self.pattern.currentData())
        QSettings().setValue(_SEEDS_KEY, self.seeds.value())
        super().accept()

    def _describe(self) -> None:
        count, seeds = len(self.chosen()), self.seeds.value()
        self.test_button.setEnabled(count > 0)
        runs = count * seeds
        self.amount.setText(counted(runs, "run") if count else "Tick at least one candidate.")
