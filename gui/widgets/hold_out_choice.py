"""The choice of a hold-out: its pattern and seeds, the same wherever it is made."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QSettings, QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QSpinBox, QWidget

from ilf.evaluation.hold_out import AREAS_HIDDEN, HOLD_OUT_PATTERNS, RANDOM_KEPT, HoldOutTest

from .basics import combo, label_of, lay_out

_PATTERN_KEY, _SEEDS_KEY = "hold_out/pattern", "hold_out/seeds"
_SEEDS, _MAX_SEEDS = 3, 20
_TEXTS = {
    "areas": f"Areas, {AREAS_HIDDEN:.0%} hidden",
    "random": f"Random pixels, {1 - RANDOM_KEPT:.0%} hidden",
}


class HoldOutChoice(QWidget):
    """Pattern and number of seeds of a hold-out. What is chosen in one place is so in all others, and is remembered.

    Signals
    -------
    changed()
        Another hold-out is chosen.
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.pattern = combo(_TEXTS, "Which known depth is hidden", "Pattern of the hold-out")
        for row, name in enumerate(_TEXTS):
            self.pattern.setItemData(row, HOLD_OUT_PATTERNS[name], Qt.ItemDataRole.ToolTipRole)
        self.seeds = QSpinBox(minimum=1, maximum=_MAX_SEEDS, value=_SEEDS)
        self.seeds.setToolTip(
            "Number of random hold-outs, whose errors are pooled; more are slower but more reliable. The same number "
            "gives the same pixels."
        )
        lay_out(QHBoxLayout(self), self.pattern, label_of("S&eeds", self.seeds), self.seeds, stretched=self.pattern)
        self.setFocusProxy(self.pattern)
        self._recall()
        self.pattern.currentIndexChanged.connect(self._take)
        self.seeds.valueChanged.connect(self._take)

    def test(self) -> HoldOutTest:
        """The chosen hold-out."""
        return HoldOutTest(str(self.pattern.currentData()), tuple(range(self.seeds.value())))

    def event(self, event: QEvent) -> bool:
        """Show what has been chosen elsewhere meanwhile."""
        if event.type() in (QEvent.Type.Show, QEvent.Type.WindowActivate):
            self._recall()
        return super().event(event)

    def _recall(self) -> None:
        former, settings = self.test(), QSettings()
        with QSignalBlocker(self.pattern), QSignalBlocker(self.seeds):
            self.pattern.setCurrentIndex(max(self.pattern.findData(settings.value(_PATTERN_KEY)), 0))
            self.seeds.setProperty("value", settings.value(_SEEDS_KEY, _SEEDS))
        if self.test() != former:
            self.changed.emit()

    def _take(self) -> None:
        QSettings().setValue(_PATTERN_KEY, self.pattern.currentData())
        QSettings().setValue(_SEEDS_KEY, self.seeds.value())
        self.changed.emit()
