"""The export dialog offers what can be written, and says what that would replace or lose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QSettings

from gui.features.documents.export import ExportDialog
from ilf.data.frame import FrameInputs, InputFile
from ilf.errors import ParameterError
from ilf.run.options import ExportOptions
from ilf.run.run import Run


@pytest.fixture
def make(qtbot, tmp_path, small_frame, small_labels):
    def make(has_intrinsics: bool = True, has_result: bool = True, extrapolate: bool = False) -> ExportDialog:
        frame = small_frame if has_intrinsics else replace(small_frame, intrinsics=None)
        dialog = ExportDialog(Run(frame, small_labels, extrapolate=extrapolate), has_result, str(tmp_path))
        qtbot.addWidget(dialog)
        return dialog

    return make


def test_starts_with_the_defaults(make, tmp_path):
    dialog = make()
    assert dialog.options() == ExportOptions()
    assert dialog.folder() == str(tmp_path)
    assert dialog.export_button.isEnabled()


def test_choices_are_remembered_when_exported_only(make):
    dialog = make()
    dialog.depth_tiff.setChecked(True)
    dialog.cloud_format.setCurrentText("PCD")
    dialog.png_units.setEditText("5000")
    chosen = dialog.options()
    dialog.reject()
    assert make().options() == ExportOptions()
    dialog.accept()
    assert make().options() == chosen == ExportOptions(("png", "tiff", "npy"), depth_units=5000, cloud="pcd")


def test_without_intrinsics_no_cloud_now_but_the_choice_stays(make):
    dialog = make(has_intrinsics=False)
    assert dialog.options().cloud is None
    assert not dialog.cloud.isEnabled()
    dialog.accept()
    assert make().options().cloud == "ply"


def test_a_mesh_with_or_without_a_cloud(make):
    dialog = make()
    dialog.mesh.setChecked(True)
    assert "mesh.glb" in dialog.message.text()
    dialog.mesh_format.setCurrentText("OBJ, text")
    dialog.normals.setChecked(True)
    dialog.drop_flying.setChecked(True)
    assert dialog.options() == ExportOptions(mesh="obj", normals=True, drop_flying=True)
    dialog.cloud.setChecked(False)
    assert dialog.axes.isEnabled()
    assert dialog.drop_flying.isEnabled()
    dialog.accept()
    assert make().options() == ExportOptions(cloud=None, mesh="obj", normals=True, drop_flying=True)
    without = make(has_intrinsics=False)
    assert without.options() == ExportOptions(cloud=None)
    assert not any(field.isEnabled() for field in (without.mesh, without.mesh_format, without.normals, without.axes))
    without.accept()
    assert make().options().mesh == "obj"


def test_the_expected_error_goes_with_the_depth_files(make):
    dialog = make()
    assert "expected_error.png" in dialog.message.text()
    dialog.expected_error.setChecked(False)
    assert "expected_error" not in dialog.message.text()
    dialog.accept()
    assert not make().options().expected_error
    for box in (dialog.depth_png, dialog.depth_npy):
        box.setChecked(False)
    assert not dialog.expected_error.isEnabled()


def test_without_result_no_curves_and_a_word_about_it(make):
    dialog = make(has_result=False)
    assert not dialog.options().curves
    assert not dialog.options().expected_error
    assert not dialog.expected_error.isEnabled()
    assert "No block has been run" in dialog.message.text()


def test_what_the_results_lack_is_said(qtbot, tmp_path, small_frame, small_labels):
    dialog = ExportDialog(Run(small_frame, small_labels), True, str(tmp_path), behind="1 of 2 blocks has not.")
    qtbot.addWidget(dialog)
    assert "1 of 2 blocks has not." in dialog.message.text()
    assert dialog.message.tone() == "warning"


def test_files_that_would_be_replaced_are_named(make, tmp_path):
    (tmp_path / "depth.png").touch()
    (tmp_path / "other.png").touch()
    dialog = make()
    assert "Replaces in this folder: depth.png." in dialog.message.text()
    assert dialog.message.tone() == "warning"
    dialog.depth_png.setChecked(False)
    assert "Replaces" not in dialog.message.text()


def test_clipping_is_foretold(make):
    dialog = make()
    depth = np.full((48, 64), 2.0, np.float32)
    depth[0, :4] = (5.2, 8.0, 8.0, np.nan)
    dialog.set_depth(depth)
    assert "8.00 m → 8000, fits" in dialog.png_note.text()
    dialog.png_units.setCurrentText("10000 (0.1 mm)")
    assert "→ 80000, over 65535: clips 2 pixels" in dialog.png_note.text()
    assert dialog.png_note.tone() == "warning"


@pytest.mark.parametrize("units", ["", "mm", "0", "-5", "nan"])
def test_units_that_are_no_number_are_refused(make, units):
    dialog = make()
    dialog.png_units.setEditText(units)
    assert not dialog.export_button.isEnabled()
    assert dialog.message.tone() == "error"
    with pytest.raises(ParameterError):
        dialog.options()


def test_a_file_is_no_folder_and_nothing_is_no_export(make, tmp_path):
    (tmp_path / "taken").touch()
    dialog = make()
    dialog.folder_path.setText(str(tmp_path / "taken"))
    assert not dialog.export_button.isEnabled()
    dialog.folder_path.setText(str(tmp_path / "new"))
    assert dialog.export_button.isEnabled()
    for box in (dialog.depth_png, dialog.depth_npy, dialog.cloud, dialog.labels, dialog.curves, dialog.run_record):
        box.setChecked(False)
    assert not dialog.export_button.isEnabled()


def test_settings_of_another_version_do_no_harm(make):
    QSettings().setValue("export/options", '{"depth_formats": ["exr"], "colour": 1}')
    assert make().options() == ExportOptions()


def test_options_are_checked_and_name_their_files():
    assert ExportOptions(cloud="xyzrgb", labels=False).filenames() == (
        "depth.png", "depth.npy", "expected_error.png", "expected_error.npy", "unsupported.png", "curves.csv",
        "cloud.xyzrgb", "run.json",
    )  # fmt: skip
    for wrong in ({"cloud": "obj"}, {"axes": "up"}, {"cloud_unit": "km"}, {"depth_units": 0.0}):
        with pytest.raises(ParameterError):
            ExportOptions(**wrong)


def test_units_coarser_than_the_inputs_are_pointed_out(qtbot, tmp_path, small_frame, small_labels):
    inputs = FrameInputs(InputFile("rgb.png", "0"), InputFile("depth.png", "0"), 2000.0, None)
    dialog = ExportDialog(Run(replace(small_frame, inputs=inputs), small_labels), True, str(tmp_path))
    qtbot.addWidget(dialog)
    dialog.png_units.setCurrentText("1000 (millimetres)")
    assert "steps of 1 mm, the input has 0.5 mm" in dialog.png_note.text()
    assert dialog.png_note.tone() == "warning"
    dialog.png_units.setEditText("2000")
    assert dialog.png_note.text() == "Steps of 0.5 mm."


def test_a_png_has_the_units_of_the_input_unless_others_are_chosen(qtbot, tmp_path, small_frame, small_labels):
    def dialog_of(units: float) -> ExportDialog:
        inputs = FrameInputs(InputFile("rgb.png", "0"), InputFile("depth.png", "0"), units, None)
        dialog = ExportDialog(Run(replace(small_frame, inputs=inputs), small_labels), True, str(tmp_path))
        qtbot.addWidget(dialog)
        return dialog

    for units in (10_000.0, 5000.0, 256.0, 1234.5678):
        dialog = dialog_of(units)
        assert dialog.options().depth_units == units
        assert dialog.png_note.tone() == "muted"
        dialog.accept()
    assert dialog_of(10_000.0).png_units.currentText() == "10000 (0.1 mm)"
    assert dialog_of(1.0).options().depth_units == 1000, "depth in metres has fractions"
    dialog = dialog_of(5000.0)
    dialog.png_units.setCurrentText("1000 (millimetres)")
    dialog.accept()
    assert dialog_of(10_000.0).options().depth_units == 1000, "as it was chosen"
    dialog = dialog_of(5000.0)
    dialog.png_units.setCurrentText("5000 (TUM)")
    dialog.accept()
    assert dialog_of(10_000.0).options().depth_units == 10_000
