"""Dialog with the options of an export, and a list of the files that it writes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

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
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.errors import ParameterError
from ilf.io.depth import UINT16_MAX, png_fit, precision_loss
from ilf.run.options import ExportOptions
from ilf.run.run import Run
from ilf.run.writing import filenames

from ...state.session import Session
from ...widgets.basics import Message, PlainLabel, group

_OPTIONS_KEY = "export/options"
_UNITS_KEY = "export/png_units"
"""Settings key of PNG units chosen instead of the input's."""

_PNG_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "256 (KITTI)")
_CLOUD_FORMATS = {
    "PLY, binary": "ply",
    "PLY, text": "ply-ascii",
    "PCD": "pcd",
    "XYZ, no colour": "xyz",
    "XYZRGB": "xyzrgb",
}
_MESH_FORMATS = {"GLB, for viewers and browsers": "glb", "PLY, with all attributes": "ply", "OBJ, text": "obj"}
_AXES = {
    "Camera: x right, y down, z forward": "camera",
    "Y up: x right, y up, z backward": "y-up",
    "World: by the frame's pose": "world",
}
_CLOUD_UNITS = {"Metres": "m", "Millimetres": "mm"}


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
        self.png_note = Message(lines=2)
        self.expected_error = QCheckBox("Expected error as well (expected_error.*)")
        self.expected_error.setToolTip(
            "The expected error of the filled pixels, in the same format and units as each depth file. Over many "
            "frames, about 68 % of the true errors lie within it (not calibrated for extrapolated pixels)"
        )
        self.extrapolation_note = Message()
        self.cloud = QCheckBox("Write the point cloud")
        self.cloud_format, self.axes, self.cloud_unit = QComboBox(), QComboBox(), QComboBox()
        self.cloud_format.addItems(list(_CLOUD_FORMATS))
        self.png_units.setAccessibleName("Units of the PNG per metre")
        self.mesh = QCheckBox("Write a mesh, cut where depth jumps")
        self.mesh_format = QComboBox()
        self.mesh_format.addItems(list(_MESH_FORMATS))
        self.mesh_format.setAccessibleName("Format of the mesh")
        self.cloud_format.setAccessibleName("Format of the point cloud")
        self.cloud_format.setToolTip(
            "PLY and PCD contain for every point its expected error (0 where depth was measured), whether it was "
            "filled, its block, and whether it is unsupported. CloudCompare shows these as scalar fields, MeshLab the "
            "expected error as quality."
        )
        self.mesh_format.setToolTip("GLB is always in metres with y up, independent of the axes and unit below")
        self.normals = QCheckBox("Normals")
        self.normals.setToolTip("Surface normal of every point; not available in XYZ")
        self.drop_flying = QCheckBox("Remove flying points")
        self.drop_flying.setToolTip("Leave out points between two surfaces; the depth files keep them")
        self.axes.addItems([text for text, axes in _AXES.items() if axes != "world" or run.frame.pose is not None])
        self.cloud_unit.addItems(list(_CLOUD_UNITS))
        self.labels = QCheckBox("Blocks as label map (blocks.png)")
        self.curves = QCheckBox("Convergence curves (curves.csv)")
        self.run_record = QCheckBox("Run record, needed for a replay (run.json)")
        self.message = Message(lines=3)
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
        boxes = {"png": self.depth_png, "tiff": self.depth_tiff, "npy": self.depth_npy}
        return ExportOptions(
            depth_formats=tuple(name for name, box in boxes.items() if box.isChecked()),
            depth_units=self._units(),
            expected_error=self.expected_error.isChecked() and self._has_result,
            labels=self.labels.isChecked(),
            curves=self.curves.isChecked() and self._has_result,
            cloud=_CLOUD_FORMATS[self.cloud_format.currentText()] if self._exports_cloud() else None,
            axes=_AXES[self.axes.currentText()],
            cloud_unit=_CLOUD_UNITS[self.cloud_unit.currentText()],
            run_record=self.run_record.isChecked(),
            mesh=_MESH_FORMATS[self.mesh_format.currentText()] if self._exports_mesh() else None,
            normals=self.normals.isChecked() and self._exports_3d(),
            drop_flying=self.drop_flying.isChecked() and self._exports_3d(),
        )

    def accept(self) -> None:
        """Store the options. Options that are not possible for this frame keep their stored choice."""
        choices = asdict(self.options())
        choices["curves"] = self.curves.isChecked()
        choices["expected_error"] = self.expected_error.isChecked()
        choices["cloud"] = _CLOUD_FORMATS[self.cloud_format.currentText()] if self.cloud.isChecked() else None
        choices["mesh"] = _MESH_FORMATS[self.mesh_format.currentText()] if self.mesh.isChecked() else None
        choices["normals"], choices["drop_flying"] = self.normals.isChecked(), self.drop_flying.isChecked()
        QSettings().setValue(_OPTIONS_KEY, json.dumps(choices))
        if (chosen := self._chosen_units()) != self._proposed_units:
            QSettings().setValue(_UNITS_KEY, "" if chosen == self._usual_units else chosen)
        super().accept()

    def _build(self) -> None:
        browse = QPushButton("Browse…", autoDefault=False)
        browse.clicked.connect(self._browse)
        target = QHBoxLayout()
        target.addWidget(self.folder_path, 1)
        target.addWidget(browse)

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
        for box, choice in ((self.cloud, self.cloud_format), (self.mesh, self.mesh_format)):
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
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(12)
        top = QFormLayout()
        top.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        if self._counts:
            top.addRow("F&rames", self.scope)
        label = PlainLabel("&Folder")
        label.setBuddy(self.folder_path)
        top.addRow(label, target)
        layout.addLayout(top)
        layout.addLayout(boxes)
        layout.addWidget(others_box)
        layout.addWidget(self.message)
        layout.addStretch(1)
        layout.addWidget(self._buttons)
        self.setMinimumWidth(680)

    def _watch(self) -> None:
        self.folder_path.textChanged.connect(self._refresh)
        self.scope.currentIndexChanged.connect(self._refresh)
        self.png_units.editTextChanged.connect(self._refresh)
        self.cloud_format.currentTextChanged.connect(self._refresh)
        self.mesh_format.currentTextChanged.connect(self._refresh)
        checks = (self.depth_png, self.depth_tiff, self.depth_npy, self.cloud, self.mesh)
        for box in (*checks, self.expected_error, self.labels, self.curves, self.run_record):
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
        self.depth_png.setChecked("png" in options.depth_formats)
        self.depth_tiff.setChecked("tiff" in options.depth_formats)
        self.depth_npy.setChecked("npy" in options.depth_formats)
        self._proposed_units = units = str(QSettings().value(_UNITS_KEY) or self._usual_units)
        known = [text for text in _PNG_UNITS if text.partition(" ")[0] == units]
        self.png_units.setCurrentText(known[0] if known else units)
        self.expected_error.setChecked(options.expected_error)
        self.cloud.setChecked(options.cloud is not None)
        _show(self.cloud_format, _CLOUD_FORMATS, options.cloud or "ply")
        self.mesh.setChecked(options.mesh is not None)
        _show(self.mesh_format, _MESH_FORMATS, options.mesh or "glb")
        self.normals.setChecked(options.normals)
        self.drop_flying.setChecked(options.drop_flying)
        _show(self.axes, _AXES, options.axes)
        _show(self.cloud_unit, _CLOUD_UNITS, options.cloud_unit)
        self.labels.setChecked(options.labels)
        self.curves.setChecked(options.curves)
        self.run_record.setChecked(options.run_record)

    def _refresh(self) -> None:
        """Update everything that depends on the options."""
        self.png_units.setEnabled(self.depth_png.isChecked())
        self.cloud.setEnabled(self._has_intrinsics)
        self.mesh.setEnabled(self._has_intrinsics)
        self.curves.setEnabled(self._has_result)
        depth_files = (self.depth_png, self.depth_tiff, self.depth_npy)
        self.expected_error.setEnabled(self._has_result and any(box.isChecked() for box in depth_files))
        self.cloud_format.setEnabled(self._exports_cloud())
        self.mesh_format.setEnabled(self._exports_mesh())
        for field in (self.axes, self.cloud_unit, self.normals, self.drop_flying):
            field.setEnabled(self._exports_3d())
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
        if not self.folder():
            self._refuse("Choose a target folder.")
        elif folder.exists() and not folder.is_dir():
            self._refuse(f"{folder} is a file, not a folder. Choose another folder.")
        elif not names:
            self._refuse("Choose at least one file to write.")
        elif self._counts and not self._counts[self.scope.currentData()]:
            self._refuse("There is no such frame. Choose other frames.")
        elif self._counts:
            self.export_button.setEnabled(True)
            self.message.show_message(self._plan_for_many(names), "muted")
        else:
            self.export_button.setEnabled(True)
            self.message.show_message(*self._plan(names, folder))

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

    def _plan_for_many(self, names: tuple[str, ...]) -> str:
        """Return what an export of many frames would write."""
        skipped = " Frames that have not changed since an earlier export are skipped." * self.run_record.isChecked()
        return (
            f"Writes {counted(self._counts[self.scope.currentData()], 'folder')}, one per frame, with "
            f"{', '.join(names)}, as far as the frame has them. Blocks without a result are run first.{skipped}"
        )

    def _extrapolation_text(self, depth: NDArray[np.floating]) -> str:
        if self._run.extrapolate:
            return "Pixels that no block could complete are extrapolated; extrapolated.png shows where."
        frame = self._run.frame
        missing = np.count_nonzero(frame.missing & np.isnan(depth)) / depth.size
        outside = (
            0 if frame.outside_view is None else np.count_nonzero(frame.outside_view & np.isnan(depth)) / depth.size
        )
        if not self._has_result:
            return ""
        lines = (
            [f"{outside:.1%} of the pixels lie outside the depth camera's view and stay missing."] if outside else []
        )
        if missing:
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

    def _exports_cloud(self) -> bool:
        return self._has_intrinsics and self.cloud.isChecked()

    def _exports_mesh(self) -> bool:
        return self._has_intrinsics and self.mesh.isChecked()

    def _exports_3d(self) -> bool:
        return self._exports_cloud() or self._exports_mesh()

    def _chosen_units(self) -> str:
        return self.png_units.currentText().strip().partition(" ")[0]

    def _units(self) -> float:
        try:
            return float(self._chosen_units())
        except ValueError as error:
            text = self.png_units.currentText().strip()
            raise ParameterError(f"PNG values per metre must be a number such as 1000, not {text!r}.") from error


def behind(session: Session) -> str:
    """Describe which blocks of a frame lack up-to-date results; "" for none."""
    counts = session.counts()
    without = len(counts.keys() - session.valid_results().keys())
    otherwise = len(session.changed_blocks()) - without
    sentences = []
    if without:
        sentences.append(
            f"Not run in their current state, so that their missing depth stays missing: {without} of {len(counts)} "
            "blocks."
        )
    if otherwise:
        sentences.append(f"Run with other parameters than the current ones: {otherwise} of {len(counts)} blocks.")
    return " ".join([*sentences, "Run them first (F5)."] if sentences else [])


def _show(combo: QComboBox, values: dict[str, str], value: str) -> None:
    combo.setCurrentText(next(text for text, known in values.items() if known == value))
