"""The dialog that starts a test on hidden depth: what is hidden, how often, and what is tested."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QListWidget,
    QListWidgetItem,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from gui.accuracy.hidden_tests import Candidate
from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel
from ilf.judgement import HIDDEN_PATTERNS, HiddenTest

_PATTERN_KEY, _SEEDS_KEY = "hidden_test/pattern", "hidden_test/seeds"
_SEEDS, _MOST_SEEDS = 3, 20
_ABOUT = {"areas": "Areas, like the holes that cameras leave", "random": "Random pixels"}


class HiddenTestDialog(QDialog):
    """Pattern, number of seeds, and candidates with a tick each.

    Parameters
    ----------
    frame_name : str
    candidates : sequence of (Candidate, bool)
        What can be tested, and whether it is ticked at first.
    """

    def __init__(self, frame_name: str, candidates: Sequence[tuple[Candidate, bool]], parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Test {frame_name} on Hidden Depth")
        about = Message(lines=2)
        about.say(
            "Some of the known depth is hidden, the blocks are completed without it, and what comes out is compared "
            "with it. All that is ticked is judged on the same pixels."
        )
        self.pattern = QComboBox()
        self.pattern.setToolTip("Which known depth is hidden")
        for name in sorted(HIDDEN_PATTERNS):
            self.pattern.addItem(_ABOUT.get(name, name), name)
            self.pattern.setItemData(self.pattern.count() - 1, HIDDEN_PATTERNS[name], Qt.ItemDataRole.ToolTipRole)
        self.pattern.setCurrentIndex(max(self.pattern.findData(QSettings().value(_PATTERN_KEY, "areas")), 0))
        self.seeds = QSpinBox(
            minimum=1, maximum=_MOST_SEEDS, value=int(str(QSettings().value(_SEEDS_KEY, _SEEDS, int)))
        )
        self.seeds.setToolTip(
            "How often other depth is hidden; the errors are pooled. The same number, the same pixels."
        )
        self.candidates = QListWidget()
        self.candidates.setToolTip("What is tested; tick what you want to compare")
        self._offered = [candidate for candidate, _ in candidates]
        for candidate, ticked in candidates:
            item = QListWidgetItem(candidate.name, self.candidates)
            item.setFlags(item.flags() | Qt.ItemFlag.ItemIsUserCheckable)
            item.setCheckState(Qt.CheckState.Checked if ticked else Qt.CheckState.Unchecked)
        self.amount = PlainLabel()
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        self.test_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.test_button.setText("&Test")
        self.test_button.setToolTip("Test what is ticked, in the background; the panel Accuracy shows what comes")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self.candidates.itemChanged.connect(lambda _: self._describe())
        self.seeds.valueChanged.connect(lambda _: self._describe())

        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Hide", self.pattern)
        form.addRow("&Seeds", self.seeds)
        label = PlainLabel("&What is tested")
        label.setBuddy(self.candidates)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addLayout(form)
        layout.addWidget(label)
        layout.addWidget(self.candidates, 1)
        layout.addWidget(self.amount)
        layout.addWidget(buttons)
        self.resize(430, 440)
        self._describe()

    def test(self) -> HiddenTest:
        """Which depth is hidden."""
        return HiddenTest(str(self.pattern.currentData()), tuple(range(self.seeds.value())))

    def chosen(self) -> list[Candidate]:
        """What is ticked."""
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
        self.amount.setText(f"{runs} run{'s' * (runs != 1)}" if count else "Tick at least one.")
