"""Options of a run: quick or full, frames, seed, and folder for the results."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QSettings, QStandardPaths, Signal
from PySide6.QtWidgets import (
    QComboBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ilf.lab.experiments.experiment import Settings

from ...widgets.basics import last_folder

QUICK_FOLDER = "quick"
"""Subfolder of quick results, so that they never replace full ones."""

Slot = Callable[[], None]

_FOLDER_KEY, _DATA_KEY = "experiments/folder", "experiments/last_data"


class ExperimentOptions(QWidget):
    """Form with the options of a run.

    Signals
    -------
    folder_changed()
        The results folder changed: another folder, or quick instead of full.
    """

    folder_changed = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.thoroughness = QComboBox()
        self.thoroughness.addItems(["Quick: a check with few points", "Full: reliable numbers"])
        self.thoroughness.setToolTip("Full runs take minutes to hours. Quick and full results are stored separately.")
        self.thoroughness.currentIndexChanged.connect(lambda _: self.folder_changed.emit())
        self.data = QLineEdit(placeholderText="The bundled sample", clearButtonEnabled=True)
        self.data.setAccessibleName("Frames")
        self.data.setToolTip(
            "Frames for 'Real frames' and 'Errors over all operation blocks': a folder of frame folders, one frame "
            "folder, or nyu_depth_v2_labeled.mat"
        )
        self.limit = QSpinBox(maximum=100_000)
        self.limit.setSpecialValueText("all")
        self.limit.setToolTip("Maximum number of frames, from the first")
        self.seed = QSpinBox(maximum=2**31 - 1)
        self.seed.setToolTip("Seed of noise and held-out pixels: the same seed gives the same numbers")
        self.folder = QLineEdit(str(QSettings().value(_FOLDER_KEY, "")) or _default_folder())
        self.folder.setAccessibleName("Folder for the results")
        self.folder.setToolTip(f"Folder for the results; quick runs use its subfolder '{QUICK_FOLDER}'")
        self.folder.editingFinished.connect(self._take_folder)
        self._known_folder = self.folder.text()

        for spin in (self.limit, self.seed):
            spin.setMinimumHeight(self.data.sizeHint().height())
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        form = QFormLayout(self)
        form.setContentsMargins(0, 0, 0, 0)
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("Run", self.thoroughness)
        form.addRow("Frames", _stacked(self.data, (("Folder…", self._ask_data_folder), ("File…", self._ask_data_file))))
        form.addRow("Max. frames", self.limit)
        form.addRow("Seed", self.seed)
        form.addRow("Results", _beside(self.folder, "…", "Select another folder for results", self._ask_folder))

    @property
    def quick(self) -> bool:
        """Whether a quick run is selected."""
        return self.thoroughness.currentIndex() == 0

    def set_quick(self, quick: bool) -> None:
        """Select a quick or a full run."""
        self.thoroughness.setCurrentIndex(0 if quick else 1)

    def settings(self) -> Settings:
        """The selected settings."""
        data = self.data.text().strip()
        return Settings(
            data=Path(data).expanduser() if data else None,
            limit=self.limit.value() or None,
            quick=self.quick,
            seed=self.seed.value(),
        )

    def results_folder(self) -> Path:
        """Folder of the results of such runs."""
        folder = Path(self.folder.text()).expanduser()
        return folder / QUICK_FOLDER if self.quick else folder

    def _take_folder(self) -> None:
        if not self.folder.text().strip():
            self.folder.setText(_default_folder())
        if self.folder.text() != self._known_folder:
            self._known_folder = self.folder.text()
            QSettings().setValue(_FOLDER_KEY, self._known_folder)
            self.folder_changed.emit()

    def _ask_folder(self) -> None:
        path = QFileDialog.getExistingDirectory(self, "Folder for results", self.folder.text())
        if path:
            self.folder.setText(path)
            self._take_folder()

    def _ask_data_folder(self) -> None:
        self._take_data(QFileDialog.getExistingDirectory(self, "Folder of frames", last_folder(_DATA_KEY)))

    def _ask_data_file(self) -> None:
        kinds = "NYU Depth V2, labelled (*.mat)"
        self._take_data(QFileDialog.getOpenFileName(self, "File of frames", last_folder(_DATA_KEY), kinds)[0])

    def _take_data(self, path: str) -> None:
        if path:
            self.data.setText(path)
            QSettings().setValue(_DATA_KEY, str(Path(path).parent))


def _default_folder() -> str:
    place = QStandardPaths.writableLocation(QStandardPaths.StandardLocation.AppLocalDataLocation)
    return str(Path(place) / "experiments")


def _stacked(line: QLineEdit, buttons: tuple[tuple[str, Slot], ...]) -> QVBoxLayout:
    column = QVBoxLayout()
    column.setSpacing(4)
    row = QHBoxLayout()
    row.setSpacing(4)
    for text, slot in buttons:
        button = QPushButton(text)
        button.clicked.connect(lambda _=False, slot=slot: slot())
        row.addWidget(button)
    column.addWidget(line)
    column.addLayout(row)
    return column


def _beside(line: QLineEdit, text: str, hint: str, slot: Slot) -> QHBoxLayout:
    row = QHBoxLayout()
    row.setSpacing(4)
    button = QPushButton(text)
    button.setFixedWidth(32)
    button.setToolTip(hint)
    button.clicked.connect(lambda _=False: slot())
    row.addWidget(line)
    row.addWidget(button)
    return row
