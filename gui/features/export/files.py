"""The files of an export, with their formats and units."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from PySide6.QtCore import QSettings, Signal
from PySide6.QtWidgets import (
    QBoxLayout,
    QCheckBox,
    QGridLayout,
    QHBoxLayout,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.data.frame import FrameInputs
from ilf.data.results import Completion
from ilf.errors import ParameterError
from ilf.io.depth import png_fit, precision_loss
from ilf.io.encodings import UINT16_MAX
from ilf.run.formats import BLOCKS, CAMERA, DEPTH, FORMATS
from ilf.run.options import WORLD, ExportOptions
from ilf.run.run import Run
from ilf.run.writing import filenames

from ...widgets.basics import Message, combo, form, group, lay_out, literal_text, typed_list

_OPTIONS_KEY = "export/options"
_UNITS_KEY = "export/png_units"
"""Settings key of PNG units chosen instead of the input's."""

_PNG_UNITS = ("1000 (millimetres)", "5000 (TUM)", "10000 (0.1 mm)", "256 (KITTI)")
_DEPTH_FORMATS = {"png": "PNG, 16 bit", "tiff": "TIFF, float32 metres", "npy": "NPY, float32 metres"}
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
_NO_INTRINSICS = "The frame has no camera intrinsics. Open it again with a camera: blocks and results stay."


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


class FilesForm(QWidget):
    """Which files are written of each frame.

    Signals
    -------
    changed()
    """

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self._run: Run | None = None
        self._completion: Completion | None = None
        self._usual_units = ""
        self.depths = {name: QCheckBox(text) for name, text in _DEPTH_FORMATS.items()}
        self.png_units = typed_list()
        self.png_units.addItems(_PNG_UNITS)
        self.png_units.setToolTip("PNG values per metre; by default those of the frame's depth file")
        self.png_units.setAccessibleName("Units of the PNG per metre")
        self.png_note, self.extrapolation_note, self.cloud_note = Message(lines=2), Message(), Message()
        self.expected_error = check(
            "Expected error as well (expected_error.*)",
            "The expected error of the filled pixels, in the same format and units as each file above. Over many "
            "frames, about 68 % of the true errors lie within it (not calibrated for extrapolated pixels)",
        )
        self.cloud, self.mesh = QCheckBox("Write the point cloud"), QCheckBox("Write a mesh, cut where depth jumps")
        self.cloud.setToolTip("All points, also those that Clip and Selected only leave out in the 3D view")
        self.cloud_format = combo(
            _CLOUD_FORMATS,
            "PLY and PCD contain for every point its expected error (0 where depth was measured), whether it was "
            "filled, its block, and whether it is unsupported. CloudCompare shows these as scalar fields, MeshLab the "
            "expected error as quality.",
            "Format of the point cloud",
        )
        self.mesh_format = combo(
            _MESH_FORMATS,
            "GLB is always in metres with y up, independent of the axes and unit below",
            "Format of the mesh",
        )
        self.normals = check("Normals", "Surface normal of every point; not available in XYZ")
        self.drop_flying = check(
            "Remove flying points", "Leave out points between two surfaces; the depth files keep them"
        )
        self.axes, self.cloud_unit = combo(_AXES, name="Axes"), combo(_CLOUD_UNITS, name="Unit")
        self.labels = QCheckBox("Blocks as label map (blocks.png)")
        self.curves = QCheckBox("Convergence curves (curves.csv)")
        self.run_record = QCheckBox("Run record, needed for a replay (run.json)")
        self.exports = {name: QCheckBox(format.title) for name, format in FORMATS.items()}
        self._formats = {"cloud": (self.cloud, self.cloud_format), "mesh": (self.mesh, self.mesh_format)}
        self._choices = {"axes": self.axes, "cloud_unit": self.cloud_unit}
        checks = "expected_error", "labels", "curves", "run_record", "normals", "drop_flying"
        self._checks: dict[str, QCheckBox] = {name: getattr(self, name) for name in checks}
        self._lay_out()
        for box in self._boxes():
            box.toggled.connect(self._update)
        for choice in (*self._choices.values(), self.cloud_format, self.mesh_format):
            choice.currentIndexChanged.connect(self._update)
        self.png_units.editTextChanged.connect(self._update)

    def restore(self, inputs: FrameInputs | None) -> None:
        """Restore the last choice, with the units of a frame's depth file unless others were chosen."""
        # depth in metres is fractional
        whole = inputs.depth_units if inputs is not None and inputs.depth_units > 1 else ExportOptions().depth_units
        self._usual_units = f"{whole:.12g}"
        options = stored_options()
        for name, box in self.depths.items():
            box.setChecked(name in options.depth_formats)
        for name, box in self.exports.items():
            box.setChecked(name in options.exports)
        for name, box in self._checks.items():
            box.setChecked(getattr(options, name))
        for name, (box, choice) in self._formats.items():
            box.setChecked(getattr(options, name) is not None)
            choice.setCurrentIndex(max(choice.findData(getattr(options, name)), 0))
        for name, choice in self._choices.items():
            choice.setCurrentIndex(max(choice.findData(getattr(options, name)), 0))
        units = str(QSettings().value(_UNITS_KEY) or self._usual_units)
        self.png_units.setCurrentText(next((text for text in _PNG_UNITS if text.partition(" ")[0] == units), units))

    def describe(self, run: Run | None, completion: Completion | None = None) -> None:
        """Offer what is possible for the run of one frame; everything for None.

        `completion` is None if no block has a result: then there are no curves, and the depth is the input depth.
        """
        self._run, self._completion = run, completion
        if run is not None and run.frame.pose is None:
            self.axes.removeItem(self.axes.findData(WORLD))
        elif self.axes.findData(WORLD) < 0:
            self.axes.addItem(_AXES[WORLD], WORLD)
        self._update()

    def choose_none(self) -> None:
        """Write no files."""
        for box in self._boxes():
            box.setChecked(False)

    def options(self) -> ExportOptions:
        """Return the chosen options, without those that are not possible for the frame.

        Raises
        ------
        ParameterError
            If the PNG units are not a positive number.
        """
        return self._options(possible=True)

    def names(self) -> tuple[str, ...]:
        """Return the names of the files of a frame; raises as `options`."""
        options = self.options()
        return options.filenames() if self._run is None else filenames(self._run, options) * bool(options.filenames())

    def store(self) -> None:
        """Remember the choice. What is not possible for this frame keeps its stored choice."""
        QSettings().setValue(_OPTIONS_KEY, json.dumps(asdict(self._options(possible=False))))
        chosen = self._chosen_units()
        QSettings().setValue(_UNITS_KEY, "" if chosen == self._usual_units else chosen)

    def _options(self, possible: bool) -> ExportOptions:
        def on(box: QCheckBox) -> bool:
            return box.isChecked() and (box.isEnabled() or not possible)

        values: dict[str, Any] = {name: on(box) for name, box in self._checks.items()}
        values |= {name: combo.currentData() if on(box) else None for name, (box, combo) in self._formats.items()}
        values |= {name: combo.currentData() for name, combo in self._choices.items()}
        formats = tuple(name for name, box in self.depths.items() if box.isChecked())
        exports = tuple(name for name, box in self.exports.items() if on(box))
        return ExportOptions(depth_formats=formats, depth_units=self._units(), exports=exports, **values)

    def _boxes(self) -> list[QCheckBox]:
        named = self.depths, self._checks, self.exports
        return [*(box for boxes in named for box in boxes.values()), self.cloud, self.mesh]

    def _lay_out(self) -> None:
        depth_box, depth = group("Completed depth")
        depth.addLayout(lay_out(QHBoxLayout(), self.depths["png"], self.png_units, stretched=self.png_units))
        of_group = {
            group: [box for name, box in self.exports.items() if FORMATS[name].group == group]
            for group in (DEPTH, BLOCKS, CAMERA)
        }
        depth.addWidget(self.png_note)
        _add_in_pairs(depth, [self.depths["tiff"], self.depths["npy"], *of_group[DEPTH]])
        depth.addWidget(self.expected_error)
        depth.addWidget(self.extrapolation_note)
        cloud_box, cloud = group("Point cloud and mesh")
        for box, choice in self._formats.values():
            cloud.addWidget(box)
            cloud.addWidget(choice)
        cloud.addLayout(form(("Axes", self.axes), ("Unit", self.cloud_unit)))
        for part in (self.normals, self.drop_flying, self.cloud_note):
            cloud.addWidget(part)
        others_box, others = group("Blocks and run")
        others.addWidget(self.labels)
        _add_in_pairs(others, of_group[BLOCKS])
        for box in (self.curves, self.run_record):
            others.addWidget(box)
        camera_box, camera = group("Camera")
        _add_in_pairs(camera, of_group[CAMERA])
        left = lay_out(QVBoxLayout(), depth_box, others_box, None, spacing=12)
        right = lay_out(QVBoxLayout(), cloud_box, camera_box, None, spacing=12)
        lay_out(QHBoxLayout(self), left, right, margins=(10, 10, 10, 10), spacing=12, stretched=(left, right))

    def _update(self) -> None:
        """Update what depends on the choice."""
        has_result = self._run is None or self._completion is not None
        has_intrinsics = self._run is None or self._run.frame.intrinsics is not None
        self.png_units.setEnabled(self.depths["png"].isChecked())
        self.curves.setEnabled(has_result)
        self.expected_error.setEnabled(has_result and any(box.isChecked() for box in self.depths.values()))
        for box, choice in self._formats.values():
            box.setEnabled(has_intrinsics)
            choice.setEnabled(has_intrinsics and box.isChecked())
        for name, box in self.exports.items():
            why = "" if self._run is None else FORMATS[name].lacks(self._run)
            box.setEnabled(not why)
            box.setToolTip(literal_text(why or f"Written as {FORMATS[name].file}"))
        in_3d = self.cloud_format.isEnabled() or self.mesh_format.isEnabled()
        for field in (self.axes, self.cloud_unit, self.normals, self.drop_flying):
            field.setEnabled(in_3d)
        self.cloud_note.show_message("" if has_intrinsics else _NO_INTRINSICS, "warning")
        self.extrapolation_note.show_message(self._extrapolation_text())
        for message in (self.cloud_note, self.extrapolation_note):
            message.setVisible(bool(message.text()))
        try:
            note = self._png_note(self.options().depth_units) if self.depths["png"].isChecked() else ("", "muted")
        except ParameterError:
            note = "", "muted"
        self.png_note.show_message(*note)
        self.changed.emit()

    def _extrapolation_text(self) -> str:
        if self._run is None:
            return ""
        if self._run.extrapolate:
            return "Pixels that no block could complete are extrapolated; extrapolated.png shows where."
        if self._completion is None:
            return ""
        missing = np.mean(self._run.frame.missing & np.isnan(self._completion.depth))
        return f"{missing:.1%} of the pixels stay missing. To fill them: Run > Extrapolate the rest." if missing else ""

    def _png_note(self, units: float) -> tuple[str, str]:
        steps = f"Steps of {1000 / units:.3g} mm"
        if self._run is None:
            return f"{steps}.", "muted"
        inputs = self._run.frame.inputs
        depth = self._run.frame.depth if self._completion is None else self._completion.depth
        deepest, largest, clipped, _ = png_fit(depth, units)
        if not clipped and (coarser := precision_loss(1.0 if inputs is None else inputs.depth_units, units)):
            return coarser, "warning"
        if np.isnan(deepest):
            return f"{steps}.", "muted"
        needs = f"maximum {deepest:.2f} m → {largest}"
        if not clipped:
            return f"{steps}; {needs}, fits.", "muted"
        return (
            f"{needs.capitalize()}, over {UINT16_MAX}: clips {counted(clipped, 'pixel')}. Use fewer units per metre.",
            "warning",
        )

    def _chosen_units(self) -> str:
        return self.png_units.currentText().strip().partition(" ")[0]

    def _units(self) -> float:
        try:
            return float(self._chosen_units())
        except ValueError as error:
            text = self.png_units.currentText().strip()
            raise ParameterError(f"PNG values per metre must be a number such as 1000, not {text!r}.") from error


def _add_in_pairs(column: QBoxLayout, boxes: Sequence[QCheckBox]) -> None:
    """Add boxes to a column, two in a row, which take half of its width each."""
    pairs = QGridLayout()
    pairs.setColumnStretch(0, 1)
    pairs.setColumnStretch(1, 1)
    for number, box in enumerate(boxes):
        pairs.addWidget(box, *divmod(number, 2))
    column.addLayout(pairs)


def check(text: str, hint: str) -> QCheckBox:
    """Return a box to check, with a hint."""
    box = QCheckBox(text)
    box.setToolTip(hint)
    return box
