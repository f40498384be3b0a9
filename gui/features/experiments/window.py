"""The window of the paper's experiments: list, options, progress and results."""

from __future__ import annotations

import html
from collections.abc import Callable, Sequence
from pathlib import Path

from PySide6.QtCore import QSize, Qt, QUrl, Signal
from PySide6.QtGui import QCloseEvent, QDesktopServices, QIcon, QPalette
from PySide6.QtWidgets import (
    QFileDialog,
    QFrame,
    QHBoxLayout,
    QLabel,
    QListWidget,
    QListWidgetItem,
    QMessageBox,
    QProgressBar,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.files import write_bytes
from ilf.errors import IlfError
from ilf.lab.experiments.files import StoredResult, read_result
from ilf.lab.experiments.registry import EXPERIMENTS
from ilf.lab.experiments.report import REPORT_FILE, write_report

from ...base import theme
from ...widgets.basics import Message, Themed, literal_text
from ...widgets.notices import error_details, error_text, warn
from ...work.jobs import Pace
from ..documents.file_dialogs import ask_path
from .options import ExperimentOptions
from .result_view import ResultView
from .runner import ExperimentRunner

_SIZE = QSize(1280, 800)
_LEFT_WIDTH = 335
_FIGURE_KINDS = {"PNG image (*.png)": ".png", "SVG drawing (*.svg)": ".svg"}


class ExperimentsWindow(Themed, QWidget):
    """Window that runs experiments and shows all results of the results folder.

    Signals
    -------
    message(str)
        Status of a run while this window is closed.
    """

    message = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.setWindowTitle("Experiments of the paper")
        self.resize(_SIZE)
        self._results: dict[str, StoredResult | IlfError] = {}
        self._pace = Pace()
        self.runner = ExperimentRunner(self)
        self.runner.changed.connect(self._show_state)
        self.runner.written.connect(self._take_written)
        self.runner.ended.connect(self._show_end)
        self.runner.failed.connect(self._report_failure)
        self.options = ExperimentOptions()
        self.options.folder_changed.connect(self.refresh)
        self.view = ResultView()
        self.view.save_requested.connect(self._ask_save_figure)
        self._make_list()
        splitter = QSplitter(Qt.Orientation.Horizontal)
        splitter.addWidget(self._left_side())
        splitter.addWidget(self._right_side())
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([_LEFT_WIDTH, _SIZE.width() - _LEFT_WIDTH])
        splitter.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(splitter)
        self.list.setCurrentRow(0)
        self.refresh()

    # parts

    def _make_list(self) -> None:
        self.list = QListWidget()
        self.list.setAccessibleName("Experiments")
        self.list.setFrameShape(QFrame.Shape.StyledPanel)
        self.list.setIconSize(QSize(18, 18))
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setTextElideMode(Qt.TextElideMode.ElideRight)
        self._items: dict[str, QListWidgetItem] = {}
        for name, experiment in EXPERIMENTS.items():
            item = QListWidgetItem(self.list)
            item.setData(Qt.ItemDataRole.UserRole, name)
            item.setToolTip(experiment.about)
            item.setSizeHint(QSize(0, 2 * self.list.fontMetrics().lineSpacing() + 12))
            self._items[name] = item
        self.list.currentItemChanged.connect(lambda *_: self._show_chosen())

    def _left_side(self) -> QWidget:
        self.run_button = _button("Run", "Run the selected experiment", self.run_chosen)
        self.run_all_button = _button("Run all", "Run every experiment, one after the other", self.run_all)
        self.cancel_button = _button("Cancel", "Stop; completed experiments keep their results", self.runner.cancel)
        self.progress = QProgressBar()
        self.progress.setAccessibleName("Progress")
        self.progress.setTextVisible(False)
        self.progress.setFixedHeight(8)
        self.state = Message()
        side = QWidget()
        side.setMinimumWidth(250)
        column = QVBoxLayout(side)
        column.setContentsMargins(10, 10, 8, 10)
        column.setSpacing(10)
        column.addWidget(self.list, 1)
        column.addWidget(self.options)
        buttons = QHBoxLayout()
        for button in (self.run_button, self.run_all_button, self.cancel_button):
            buttons.addWidget(button, 1)
        column.addLayout(buttons)
        column.addWidget(self.progress)
        column.addWidget(self.state)
        return side

    def _right_side(self) -> QWidget:
        self.message_label = QLabel()
        self.message_label.setOpenExternalLinks(True)
        self.message_label.setMinimumWidth(0)
        self.open_button = _button("Open results folder", "Open the folder with the result files", self._open_folder)
        self.report_button = _button("Write report…", "Write all results shown here as one HTML page", self._ask_report)
        side = QWidget()
        column = QVBoxLayout(side)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.view, 1)
        foot = QHBoxLayout()
        foot.setContentsMargins(14, 8, 10, 10)
        foot.setSpacing(8)
        foot.addWidget(self.message_label, 1)
        foot.addWidget(self.open_button)
        foot.addWidget(self.report_button)
        column.addLayout(foot)
        return side

    # running

    @property
    def chosen(self) -> str:
        """The experiment selected in the list."""
        return str(self.list.currentItem().data(Qt.ItemDataRole.UserRole))

    def choose(self, name: str) -> None:
        """Select an experiment."""
        self.list.setCurrentItem(self._items[name])

    def run_chosen(self) -> None:
        """Run the selected experiment."""
        self._run([self.chosen])

    def run_all(self) -> None:
        """Run every experiment."""
        self._run(list(EXPERIMENTS))

    def run_all_quick(self) -> None:
        """Run every experiment with few points."""
        if not self.runner.busy:
            self.options.set_quick(True)
            self.run_all()

    def _run(self, names: Sequence[str]) -> None:
        if not self.runner.busy:
            self._show_message("")
            self.runner.start(names, self.options.settings(), self.options.results_folder())

    def _take_written(self, name: str) -> None:
        self._results.update(_stored(self.options.results_folder(), [name]))
        if name == self.chosen:
            self._show_chosen()

    def _show_end(self, how: str) -> None:
        self._show_message({"finished": "", "cancelled": "Cancelled.", "failed": "Stopped by an error."}[how])
        if not self.isVisible():
            self.message.emit(f"Experiments: {how}.")

    def _report_failure(self, name: str, error: Exception) -> None:
        self._report(EXPERIMENTS[name].title if name else "Experiments", error)

    # showing

    def refresh(self) -> None:
        """Read the results from the results folder."""
        self._results = _stored(self.options.results_folder(), list(EXPERIMENTS))
        self._show_chosen()
        self._show_state()

    def _show_chosen(self) -> None:
        found = self._results.get(self.chosen)
        result = found if isinstance(found, StoredResult) else None
        self.view.show_experiment(EXPERIMENTS[self.chosen], result, self.options.results_folder())
        self.view.show_message(self._without_result())

    def _without_result(self) -> str:
        """Text of the selected experiment while it has no result."""
        found = self._results.get(self.chosen)
        if self.chosen == self.runner.present:
            return f"Running: {self._count()}"
        if self.chosen in self.runner.waiting:
            return "Waiting."
        if isinstance(found, IlfError):
            return str(found)
        kind = "quick" if self.options.quick else "full"
        return f"There is no {kind} result in {self.options.results_folder()} yet. Run it."

    def _show_state(self) -> None:
        """Show the progress and the state of every experiment."""
        runner, busy = self.runner, self.runner.busy
        for name, item in self._items.items():
            icon, tone, state = self._state_of(name)
            experiment = EXPERIMENTS[name]
            item.setText(f"{experiment.title}\n{experiment.source} · {state}")
            item.setIcon(self._icon(icon, tone))
        self.view.show_message(self._without_result())
        for widget in (self.options, self.run_button, self.run_all_button):
            widget.setEnabled(not busy)
        self.cancel_button.setEnabled(busy and not runner.cancelling)
        self.report_button.setEnabled(any(isinstance(found, StoredResult) for found in self._results.values()))
        self.open_button.setEnabled(self.options.results_folder().is_dir())
        progress = runner.progress
        self.progress.setVisible(busy)
        # without a number of steps the bar is indeterminate
        self.progress.setRange(0, progress.total if progress is not None and not runner.writing else 0)
        self.progress.setValue(progress.done if progress is not None else 0)
        self.state.setVisible(busy)
        self.state.show_message(self._activity() if busy else "")

    def _activity(self) -> str:
        runner = self.runner
        if runner.cancelling:
            return "Stopping…"
        if not runner.present:
            return "Starting…"
        place = runner.names.index(runner.present) + 1
        of_all = f" ({place} of {len(runner.names)})" if len(runner.names) > 1 else ""
        return f"{EXPERIMENTS[runner.present].title}{of_all}: {self._count()}"

    def _count(self) -> str:
        if self.runner.writing:
            return "writing files"
        progress = self.runner.progress
        if progress is None or not progress.total:
            return "starting"
        self._pace.note(progress.done / progress.total)
        return ", ".join(filter(None, (f"{progress.done} of {progress.total}", self._pace.text())))

    def _state_of(self, name: str) -> tuple[str, str, str]:
        """Icon, tone and text of an experiment's state."""
        found = self._results.get(name)
        if name == self.runner.present:
            return "ph.play-circle", "accent", self._count()
        if name in self.runner.waiting:
            return "ph.hourglass", "muted", "waiting"
        if isinstance(found, IlfError):
            return "ph.warning-circle", "error", "cannot be read"
        if found is None:
            return "ph.circle", "muted", "not run"
        return "ph.check-circle", "good", f"{'quick' if found.quick else 'full'}, {found.seconds:.0f} s"

    def _icon(self, name: str, tone: str) -> QIcon:
        """Icon in one of the theme's colours; in the text colour if selected."""
        palette, size = QPalette(self.palette()), self.list.iconSize()
        icon = QIcon()
        for mode, colour in (
            (QIcon.Mode.Normal, getattr(theme.colours(palette), tone)),
            (QIcon.Mode.Selected, self.palette().highlightedText().color()),
        ):
            palette.setColor(QPalette.ColorRole.WindowText, colour)
            icon.addPixmap(theme.icon(name, palette).pixmap(size, self.devicePixelRatioF()), mode)
        return icon

    # files

    def _open_folder(self) -> None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.options.results_folder())))

    def _ask_report(self) -> None:
        start = str(self.options.results_folder() / REPORT_FILE)
        if path := ask_path(self, "Write report", start, "Web page (*.html)"):
            self.write_report(Path(path))

    def write_report(self, path: Path) -> None:
        """Write the report of the results shown."""
        try:
            write_report(self.options.results_folder(), path)
        except IlfError as error:
            self._report("Write report", error)
        else:
            self._show_written(path)

    def _ask_save_figure(self, source: Path) -> None:
        # without suffix, so that the selected file type decides
        start = str(Path.home() / source.stem)
        typed, kind = QFileDialog.getSaveFileName(self, "Save figure", start, ";;".join(_FIGURE_KINDS))
        if not typed:
            return
        path = Path(typed)
        if path.suffix.lower() not in _FIGURE_KINDS.values():
            path = Path(typed + _FIGURE_KINDS[kind])
            # the dialog has only checked the typed name
            if path.exists() and not self._may_replace(path):
                return
        self.save_figure(source, path)

    def _may_replace(self, path: Path) -> bool:
        answer = QMessageBox.question(self, "Save figure", literal_text(f"{path} already exists. Replace it?"))
        return answer == QMessageBox.StandardButton.Yes

    def save_figure(self, source: Path, path: Path) -> None:
        """Save a figure of the results, as SVG if that is the suffix, otherwise as PNG."""
        suffix = ".svg" if path.suffix.lower() == ".svg" else ".png"
        try:
            write_bytes(path, source.with_suffix(suffix).read_bytes())
        except (IlfError, OSError) as error:
            self._report("Save figure", error)
        else:
            self._show_written(path)

    # messages

    def _show_message(self, text: str) -> None:
        self.message_label.setText(text)

    def _show_written(self, path: Path) -> None:
        url = QUrl.fromLocalFile(str(path)).toString()
        self._show_message(f'Written: <a href="{url}">{html.escape(path.name)}</a>')
        self.message_label.setToolTip(literal_text(str(path)))

    def _report(self, what: str, error: Exception) -> None:
        warn(self, what, error_text(error), error_details(error))

    # events

    def _take_theme(self) -> None:
        if hasattr(self, "message_label"):
            self._show_state()

    def shutdown(self) -> bool:
        """Cancel the run and wait for its end. True if it has ended."""
        ended = self.runner.shutdown()
        self._show_state()
        return ended

    def closeEvent(self, event: QCloseEvent) -> None:
        """Close the window; a run continues until the program ends."""
        super().closeEvent(event)
        if self.runner.busy:
            self.message.emit("The experiments continue. Open their window again to follow or cancel them.")


def _button(text: str, hint: str, slot: Callable[[], object]) -> QPushButton:
    button = QPushButton(text)
    button.setToolTip(hint)
    button.clicked.connect(lambda _=False: slot())
    return button


def _stored(folder: Path, names: Sequence[str]) -> dict[str, StoredResult | IlfError]:
    """Read the results in a folder; unreadable ones map to their error."""
    found: dict[str, StoredResult | IlfError] = {}
    for name in names:
        path = folder / f"{name}.json"
        if path.is_file():
            try:
                found[name] = read_result(path)
            except IlfError as error:
                found[name] = error
    return found
