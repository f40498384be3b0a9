"""The hold-out test: started in a dialog, run in the background, stored with its frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, QSettings, Qt, Signal
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

from ilf._runtime.formatting import counted
from ilf.data.parameters import PRESETS
from ilf.data.presets import list_presets
from ilf.evaluation.evaluation import Progress
from ilf.evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest, untrusted_note
from ilf.run.run import Run

from ...state.document import Document
from ...widgets.basics import Message, PlainLabel
from ...work.jobs import Worker
from ..context import Context
from .hold_out_tests import CURRENT, Candidate, HoldOutOutcome, outcome_steps
from .panel import AccuracyPanel
from .rows import hold_out_rows

# The dialog that starts a hold-out test: pattern, seeds and candidates.

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
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        self.test_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.test_button.setText("&Test")
        self.test_button.setToolTip("Test the ticked candidates in the background; the panel Accuracy shows the errors")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self.candidates.itemChanged.connect(lambda _: self._describe())
        self.seeds.valueChanged.connect(lambda _: self._describe())

        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Hide", self.pattern)
        form.addRow("&Seeds", self.seeds)
        label = PlainLabel("&Candidates")
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


_NOT_TESTED = "Not tested yet. The hold-out test hides known depth and measures the error of its completion."
_OUTDATED = "Outdated: blocks or depth have changed. Test again."
_OTHER_VALUES = "The current values differ from those tested. Test again."


class HoldOutPresenter(QObject):
    """Presenter of the hold-out page.

    Signals
    -------
    tested()
        The hold-out errors of the blocks changed.
    """

    tested = Signal()

    def __init__(self, context: Context, panel: AccuracyPanel) -> None:
        super().__init__(panel)
        self._context = context
        self._panel = panel
        self._outcomes: WeakKeyDictionary[Document, HoldOutOutcome] = WeakKeyDictionary()
        self._testing: Document | None = None
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take_steps)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self._end("The hold-out test was cancelled."))
        panel.cancelled.connect(self.worker.cancel)
        context.workspace.frames.sessions_changed.connect(self._cancel_closed)

    @property
    def testing(self) -> Document | None:
        """The frame being tested."""
        return self._testing

    @property
    def outcome(self) -> HoldOutOutcome | None:
        """The test outcome of the current frame, if any."""
        workspace = self._context.workspace
        return self._outcomes.get(workspace.current) if workspace.has_current else None

    def ask(self) -> None:
        """Open the dialog, and start the test when it is accepted."""
        workspace = self._context.workspace
        if not workspace.has_current:
            return
        if self.worker.busy:
            self._context.notes.show_message("A hold-out test is already in progress.")
            return
        document = workspace.current
        present = document.run(document.state.common)
        dialog = HoldOutDialog(document.name, _candidates(document, present), self._context.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self.start(document, dialog.chosen(), present, dialog.test()))
        dialog.open()

    def start(self, document: Document, candidates: Sequence[Candidate], present: Run, test: HoldOutTest) -> None:
        """Test some candidates; `present` is the frame with its current blocks and values."""
        if self.worker.busy:
            return
        self._testing = document
        self._panel.work.begin()
        self.worker.start(lambda: outcome_steps(candidates, present, test))
        self.show()

    def show(self) -> None:
        """Show the hold-out errors of the current frame."""
        workspace, outcome = self._context.workspace, self.outcome
        chosen = workspace.chosen
        self._panel.set_chosen(workspace.current.info(chosen).name if chosen else "")
        if outcome is None:
            testing = self.worker.busy and workspace.has_current and workspace.current is self._testing
            self._panel.show_hold_out([], "", "muted", "Testing…" if testing else _NOT_TESTED)
            return
        text, tone = _describe_outcome(outcome, workspace.current)
        label = chosen if self._panel.over_selected else 0
        empty = "Select a block to see its errors." if self._panel.over_selected and not chosen else ""
        self._panel.show_hold_out([] if empty else hold_out_rows(outcome, label), text, tone, empty)

    def _take_steps(self, batch: list[Progress]) -> None:
        self._panel.work.show_share(batch[-1].share)

    def _finish(self, outcome: HoldOutOutcome) -> None:
        document = self._testing
        if document is not None and document in self._context.workspace.open:
            self._outcomes[document] = outcome
            for one in outcome.tested:
                kept = one.candidate.kept
                if kept in document.state.runs and kept.run is one.candidate.run_when_selected:
                    document.change_run(kept, hold_out_error=one.whole.rmse, hold_out_test=outcome.test)
        self._end("")

    def _fail(self, error: Exception) -> None:
        self._end("")
        self._context.notes.report("Hold-out test", error)

    def _end(self, text: str) -> None:
        self._testing = None
        self._panel.work.end()
        self.show()
        if text:
            self._context.notes.show_message(text)
        self.tested.emit()

    def _cancel_closed(self) -> None:
        """Cancel the test if its frame was closed."""
        if self._testing is not None and self._testing not in self._context.workspace.open:
            self.worker.cancel()


def _candidates(document: Document, present: Run) -> list[tuple[Candidate, bool]]:
    """Candidates, and whether they are initially ticked, as the current values and the compared runs are."""
    found = [(Candidate(CURRENT, present), True)]
    found += [(Candidate.of(kept), kept in document.compared) for kept in document.state.runs]
    presets = PRESETS | {name: preset.parameters for name, preset in list_presets().presets.items()}
    plain = replace(present, blocks=replace(present.blocks, own={}))
    for name, parameters in presets.items():
        found.append((Candidate(f"Preset {name}", replace(plain, parameters=parameters)), False))
    return found


def _describe_outcome(outcome: HoldOutOutcome, document: Document) -> tuple[str, str]:
    """Describe the test, when it was made and whether it is still valid; and return the tone of the message."""
    seeds = len(outcome.test.seeds)
    pattern = {"areas": "areas", "random": "random pixels"}.get(outcome.test.pattern, outcome.test.pattern)
    left_out = untrusted_note(outcome.present.frame)
    text = f"Held out: {pattern}, {counted(seeds, 'seed')}, at {outcome.when:%H:%M}. {left_out}".rstrip()
    if not outcome.is_valid_for(document):
        return f"{text} {_OUTDATED}", "warning"
    if outcome.current_result is not None and not outcome.has_values_of(document):
        return f"{text} {_OTHER_VALUES}", "warning"
    return text, "muted"
