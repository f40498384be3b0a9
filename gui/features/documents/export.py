"""Dialog with the options of an export, and a list of the files that it writes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSettings
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.errors import ParameterError
from ilf.io.depth import UINT16_MAX, png_fit, precision_loss
from ilf.run.options import WORLD, ExportOptions
from ilf.run.run import Run
from ilf.run.writing import filenames

from ...state.document import Document
from ...widgets.basics import Message, group, label_of, row, stack

_OPTIONS_KEY = "export/options"
_UNITS_KEY = "export/png_units"
"""Settings key of PNG units chosen instead of the input's."""

_PNG_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "256 (KITTI)")
_CLOUD_FORMATS = {
    "ply": "PLY, binary",
    "ply-ascii": "PLY, text",
    "pcd": "PCD",
    "xyz": "XYZ, no colour",
    "xyzrgb": "XYZRGB",
}
_MESH_FORMATS = {"glb": "GLB, for viewers and browsers", "ply": "PLY, with all attributes", "obj": "OBJ, text"}
_AXES = {
    "camera": "Camera: x right, y down, z forward",
    "y-up": "Y up: x right, y up, z backward",
    WORLD: "World: by the frame's pose",
}
_CLOUD_UNITS = {"m": "Metres", "mm": "Millimetres"}


def stored_options() -> ExportOptions:
    """Return the options of the last export."""
    stored = QSettings().value(_OPTIONS_KEY)
    if stored:
        try:
            return ExportOptions(**json.loads(str(stored)))
        except (ValueError, TypeError, RecursionError):
            # damaged: use the defaults
            QSettings().remove(_OPTIONS_KEY)
    return ExportOptions()


class ExportDialog(QDialog):
    """Dialog to choose files, formats and units of an export.

    Parameters
    ----------
    run : Run
        The run to export.
    has_result : bool
        Whether any block has been run; if not, there are no curves and no expected error, and the depth is the input
        depth.
    folder : str
        Default target folder.
    behind : str
        Text from `behind` about missing or outdated results.
    scopes : mapping, optional
        For an export of many frames: name of a choice of frames -> its text and number of frames. The run is that of
        one of them.
    """

    def __init__(
        self,
        run: Run,
        has_result: bool,
        folder: str,
        parent: QWidget | None = None,
        *,
        behind: str = "",
        scopes: Mapping[str, tuple[str, int]] | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Export {run.frame.name}" if scopes is None else "Export all")
        self._counts = {name: count for name, (_, count) in (scopes or {}).items()}
        self.scope = QComboBox()
        self.scope.setToolTip("Frames of the list to export, each into a folder of its own")
        for name, (text, count) in (scopes or {}).items():
            self.scope.addItem(f"{text}: {count}", name)
        inputs = run.frame.inputs
        self._input_units = inputs.depth_units if inputs is not None else 1.0
        is_whole = self._input_units > 1  # depth in metres is fractional
        self._usual_units = f"{self._input_units if is_whole else ExportOptions().depth_units:.12g}"
        self._run = run
        self._has_intrinsics = run.frame.intrinsics is not None
        self._has_result = has_result
        self._behind = behind
        self._depth: NDArray[np.floating] = np.empty(0, np.float32)

        self.folder_path = QLineEdit(folder)
        self.depth_png = QCheckBox("PNG, 16 bit")
        self.depth_tiff = QCheckBox("TIFF, float32 metres")
        self.depth_npy = QCheckBox("NPY, float32 metres")
        self.png_units = QComboBox(editable=True)
        self.png_units.addItems(_PNG_UNITS)
        self.png_units.setCompleter(None)  # type: ignore[arg-type]  # it would swallow Enter
        self.png_units.setToolTip("PNG values per metre; by default those of the frame's depth file")
        self.png_units.setAccessibleName("Units of the PNG per metre")
        self.png_note = Message(lines=2)
        self.expected_error = _check(
            "Expected error as well (expected_error.*)",
            "The expected error of the filled pixels, in the same format and units as each depth file. Over many "
            "frames, about 68 % of the true errors lie within it (not calibrated for extrapolated pixels)",
        )
        self.extrapolation_note = Message()
        self.cloud = QCheckBox("Write the point cloud")
        self.cloud_format = _combo(
            _CLOUD_FORMATS,
            "PLY and PCD contain for every point its expected error (0 where depth was measured), whether it was "
            "filled, its block, and whether it is unsupported. CloudCompare shows these as scalar fields, MeshLab the "
            "expected error as quality.",
            "Format of the point cloud",
        )
        self.mesh = QCheckBox("Write a mesh, cut where depth jumps")
        self.mesh_format = _combo(
            _MESH_FORMATS,
            "GLB is always in metres with y up, independent of the axes and unit below",
            "Format of the mesh",
        )
        self.normals = _check("Normals", "Surface normal of every point; not available in XYZ")
        self.drop_flying = _check(
            "Remove flying points", "Leave out points between two surfaces; the depth files keep them"
        )
        self.axes = _combo({axes: text for axes, text in _AXES.items() if axes != WORLD or run.frame.pose is not None})
        self.cloud_unit = _combo(_CLOUD_UNITS)
        self.labels = QCheckBox("Blocks as label map (blocks.png)")
        self.curves = QCheckBox("Convergence curves (curves.csv)")
        self.run_record = QCheckBox("Run record, needed for a replay (run.json)")
        self.message = Message(lines=3)
        self._depth_boxes = {"png": self.depth_png, "tiff": self.depth_tiff, "npy": self.depth_npy}
        self._formats = {"cloud": (self.cloud, self.cloud_format), "mesh": (self.mesh, self.mesh_format)}
        self._choices = {"axes": self.axes, "cloud_unit": self.cloud_unit}
        checks = "expected_error", "labels", "curves", "run_record", "normals", "drop_flying"
        self._checks: dict[str, QCheckBox] = {name: getattr(self, name) for name in checks}
        self._build()
        self._restore()
        self._watch()
        self._refresh()

    def set_depth(self, depth: NDArray[np.floating]) -> None:
        """Set the depth to export [m], (H, W), NaN = missing; used for the note on the range of 16 bits."""
        self._depth = depth
        self.extrapolation_note.show_message(self._extrapolation_text(depth))
        self._refresh()

    def folder(self) -> str:
        """Return the target folder; it need not exist yet."""
        return self.folder_path.text().strip()

    def options(self) -> ExportOptions:
        """Return the chosen options, without those that are not possible for this frame.

        Raises
        ------
        ParameterError
            If the PNG units are not a positive number.
        """
        return self._options(possible=True)

    def accept(self) -> None:
        """Store the options. Options that are not possible for this frame keep their stored choice."""
        QSettings().setValue(_OPTIONS_KEY, json.dumps(asdict(self._options(possible=False))))
        if (chosen := self._chosen_units()) != self._proposed_units:
            QSettings().setValue(_UNITS_KEY, "" if chosen == self._usual_units else chosen)
        super().accept()

    def _options(self, possible: bool) -> ExportOptions:
        """Return the chosen options, or only those that are possible for this frame: the others are disabled."""

        def on(box: QCheckBox) -> bool:
            return box.isChecked() and (box.isEnabled() or not possible)

        values: dict[str, Any] = {name: on(box) for name, box in self._checks.items()}
        values |= {name: combo.currentData() if on(box) else None for name, (box, combo) in self._formats.items()}
        values |= {name: combo.currentData() for name, combo in self._choices.items()}
        formats = tuple(name for name, box in self._depth_boxes.items() if box.isChecked())
        return ExportOptions(depth_formats=formats, depth_units=self._units(), **values)

    def _build(self) -> None:
        browse = QPushButton("Browse…", autoDefault=False)
        browse.clicked.connect(self._browse)
        depth_box, depth = group("Completed depth")
        png = QHBoxLayout()
        png.addWidget(self.depth_png)
        png.addWidget(self.png_units, 1)
        depth.addLayout(png)
        depth.addWidget(self.png_note)
        depth.addWidget(self.depth_tiff)
        depth.addWidget(self.depth_npy)
        depth.addWidget(self.expected_error)
        depth.addWidget(self.extrapolation_note)
        depth.addStretch(1)

        cloud_box, cloud = group("Point cloud and mesh")
        for box, choice in self._formats.values():
            cloud.addWidget(box)
            cloud.addWidget(choice)
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        for text, field in (("Axes", self.axes), ("Unit", self.cloud_unit)):
            form.addRow(text, field)
        cloud.addLayout(form)
        cloud.addWidget(self.normals)
        cloud.addWidget(self.drop_flying)
        if not self._has_intrinsics:
            reason = Message()
            reason.show_message(
                "The frame has no camera intrinsics. Open it again with a camera preset or numbers.", "warning"
            )
            cloud.addWidget(reason)
        cloud.addStretch(1)

        others_box, others = group("Blocks and run")
        for box in (self.labels, self.curves, self.run_record):
            others.addWidget(box)

        self._buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self.export_button = self._buttons.addButton("Export", QDialogButtonBox.ButtonRole.AcceptRole)
        self.export_button.setDefault(True)
        self._buttons.accepted.connect(self.accept)
        self._buttons.rejected.connect(self.reject)

        boxes = QHBoxLayout()
        boxes.setSpacing(12)
        boxes.addWidget(depth_box, 1)
        boxes.addWidget(cloud_box, 1)
        top = QFormLayout()
        top.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        if self._counts:
            top.addRow("F&rames", self.scope)
        top.addRow(label_of("&Folder", self.folder_path), row(self.folder_path, browse))
        stack(self, top, boxes, others_box, self.message, self._buttons, spacing=12)
        self.setMinimumWidth(680)

    def _watch(self) -> None:
        self.folder_path.textChanged.connect(self._refresh)
        self.scope.currentIndexChanged.connect(self._refresh)
        self.png_units.editTextChanged.connect(self._refresh)
        for box, choice in self._formats.values():
            box.toggled.connect(self._refresh)
            choice.currentIndexChanged.connect(self._refresh)
        for box in (*self._depth_boxes.values(), *self._checks.values()):
            box.toggled.connect(self._refresh)

    def _browse(self) -> None:
        start = Path(self.folder())
        while not start.is_dir() and start != start.parent:
            start = start.parent
        path = QFileDialog.getExistingDirectory(self, "Choose target folder", str(start))
        if path:
            self.folder_path.setText(path)

    def _restore(self) -> None:
        options = stored_options()
        for name, box in self._depth_boxes.items():
            box.setChecked(name in options.depth_formats)
        for name, box in self._checks.items():
            box.setChecked(getattr(options, name))
        for name, (box, choice) in self._formats.items():
            box.setChecked(getattr(options, name) is not None)
            choice.setCurrentIndex(max(choice.findData(getattr(options, name)), 0))
        for name, choice in self._choices.items():
            choice.setCurrentIndex(max(choice.findData(getattr(options, name)), 0))
        self._proposed_units = units = str(QSettings().value(_UNITS_KEY) or self._usual_units)
        known = [text for text in _PNG_UNITS if text.partition(" ")[0] == units]
        self.png_units.setCurrentText(known[0] if known else units)

    def _refresh(self) -> None:
        """Update everything that depends on the options."""
        self.png_units.setEnabled(self.depth_png.isChecked())
        self.curves.setEnabled(self._has_result)
        depth_chosen = any(box.isChecked() for box in self._depth_boxes.values())
        self.expected_error.setEnabled(self._has_result and depth_chosen)
        in_3d = False
        for box, choice in self._formats.values():
            box.setEnabled(self._has_intrinsics)
            choice.setEnabled(self._has_intrinsics and box.isChecked())
            in_3d |= choice.isEnabled()
        for field in (self.axes, self.cloud_unit, self.normals, self.drop_flying):
            field.setEnabled(in_3d)
        try:
            options = self.options()
        except ParameterError as error:
            self.png_note.show_message("")
            self._refuse(str(error))
            return
        self.png_note.show_message(
            *self._png_note(options.depth_units) if self.depth_png.isChecked() else ("", "muted")
        )
        names, folder = filenames(self._run, options), Path(self.folder())
        problem = self._problem(names, folder)
        if problem:
            self._refuse(problem)
            return
        self.export_button.setEnabled(True)
        self.message.show_message(*self._plan_for_many(names) if self._counts else self._plan(names, folder))

    def _problem(self, names: tuple[str, ...], folder: Path) -> str:
        """Return why nothing can be exported, and what to do; "" if it can."""
        if not self.folder():
            return "Choose a target folder."
        if folder.exists() and not folder.is_dir():
            return f"{folder} is a file, not a folder. Choose another folder."
        if not names:
            return "Choose at least one file to write."
        if self._counts and not self._counts[self.scope.currentData()]:
            return "There is no such frame. Choose other frames."
        return ""

    def _plan(self, names: tuple[str, ...], folder: Path) -> tuple[str, str]:
        """Return what the export would write, and the tone of the message."""
        lines = [
            f"Writes {', '.join(names)}." if folder.is_dir() else f"Creates the folder, writes {', '.join(names)}."
        ]
        replaced = [name for name in names if (folder / name).exists()]
        if replaced:
            lines.append(f"Replaces in this folder: {', '.join(replaced)}.")
        if not self._has_result:
            lines.append("No block has been run in its current state: the input depth is exported.")
        elif self._behind:
            lines.append(self._behind)
        return "\n".join(lines), "warning" if len(lines) > 1 else "muted"

    def _plan_for_many(self, names: tuple[str, ...]) -> tuple[str, str]:
        """Return what an export of many frames would write, and the tone of the message."""
        skipped = " Frames that have not changed since an earlier export are skipped." * self.run_record.isChecked()
        folders = counted(self._counts[self.scope.currentData()], "folder")
        return (
            f"Writes {folders}, one per frame, with {', '.join(names)}, as far as the frame has them. Blocks without a "
            f"result are run first.{skipped}",
            "muted",
        )

    def _extrapolation_text(self, depth: NDArray[np.floating]) -> str:
        if self._run.extrapolate:
            return "Pixels that no block could complete are extrapolated; extrapolated.png shows where."
        if not self._has_result:
            return ""
        frame, lines = self._run.frame, []
        if frame.outside_view is not None and (outside := np.mean(frame.outside_view & np.isnan(depth))):
            lines.append(f"{outside:.1%} of the pixels lie outside the depth camera's view and stay missing.")
        if missing := np.mean(frame.missing & np.isnan(depth)):
            lines.append(f"{missing:.1%} of the pixels stay missing. To fill them all: Run > Extrapolate the rest.")
        return "\n".join(lines)

    def _png_note(self, units: float) -> tuple[str, str]:
        fit = png_fit(self._depth, units)
        if not fit.clipped and (coarser := precision_loss(self._input_units, units)):
            return coarser, "warning"
        if np.isnan(fit.deepest):
            return f"Steps of {1000 / units:.3g} mm.", "muted"
        needs = f"maximum {fit.deepest:.2f} m → {fit.largest}"
        if not fit.clipped:
            return f"Steps of {1000 / units:.3g} mm; {needs}, fits.", "muted"
        return (
            f"{needs.capitalize()}, over {UINT16_MAX}: clips {counted(fit.clipped, 'pixel')}. "
            "Use fewer units per metre.",
            "warning",
        )

    def _refuse(self, text: str) -> None:
        self.export_button.setEnabled(False)
        self.message.show_message(text, "error")

    def _chosen_units(self) -> str:
        return self.png_units.currentText().strip().partition(" ")[0]

    def _units(self) -> float:
        try:
            return float(self._chosen_units())
        except ValueError as error:
            text = self.png_units.currentText().strip()
            raise ParameterError(f"PNG values per metre must be a number such as 1000, not {text!r}.") from error


def behind(document: Document) -> str:
    """Describe which blocks of a frame lack up-to-date results; "" for none."""
    counts = document.counts()
    without = len(counts.keys() - document.valid_results().keys())
    otherwise = len(document.changed_blocks()) - without
    sentences = []
    if without:
        sentences.append(
            f"Not run in their current state, so that their missing depth stays missing: {without} of {len(counts)} "
            "blocks."
        )
    if otherwise:
        sentences.append(f"Run with other parameters than the current ones: {otherwise} of {len(counts)} blocks.")
    return " ".join([*sentences, "Run them first (F5)."] if sentences else [])


def _check(text: str, hint: str) -> QCheckBox:
    box = QCheckBox(text)
    box.setToolTip(hint)
    return box


def _combo(texts: Mapping[str, str], hint: str = "", name: str = "") -> QComboBox:
    """Return a list of values, shown by their texts."""
    combo = QComboBox()
    combo.setToolTip(hint)
    combo.setAccessibleName(name)
    for value, text in texts.items():
        combo.addItem(text, value)
    return combo
