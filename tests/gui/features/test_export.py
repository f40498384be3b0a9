"""The export dialog offers what can be written, and says what that would replace or lose."""

from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QSettings
from PySide6.QtWidgets import QApplication

import ilf
from gui.features.export import feature
from gui.features.export.feature import ExportFeature
from gui.widgets.hold_out_choice import HoldOutChoice
from ilf.data.frame import FrameInputs, InputFile
from ilf.data.results import compose
from ilf.errors import ParameterError
from ilf.run.formats import FORMATS
from ilf.run.options import ExportOptions


@pytest.fixture
def make(context, tmp_path, small_frame, small_labels, monkeypatch):
    context.feature = lambda kind: MagicMock()
    monkeypatch.setattr(ExportFeature, "start", lambda *_: None)

    def make(
        has_intrinsics: bool = True,
        has_result: bool = True,
        depth: NDArray[np.float32] | None = None,
        units: float | None = None,
        behind: str = "",
    ) -> ExportFeature:
        frame = small_frame if has_intrinsics else replace(small_frame, intrinsics=None)
        if units is not None:
            inputs = FrameInputs(InputFile("rgb.png", "0"), InputFile("depth.png", "0"), units, None)
            frame = replace(frame, inputs=inputs)
        run = ilf.Run(frame, small_labels)
        completion = compose(run, {}) if depth is None else replace(compose(run, {}), depth=depth)
        monkeypatch.setattr(feature, "present_frame", lambda document: (run, completion if has_result else None))
        monkeypatch.setattr(feature, "behind", lambda document: behind)
        dialog = ExportFeature(context)
        dialog.ask()
        dialog.folder_path.setText(str(tmp_path))
        return dialog

    return make


def box(dialog: ExportFeature, name: str, choice: str = ""):
    """What is ticked for an option."""
    return dialog.files.fields[name].boxes[choice]


def accept(dialog: ExportFeature) -> None:
    dialog.begin_export(dialog.request())


def test_choices_are_remembered_when_exported_only(make):
    dialog = make()
    box(dialog, "depth_formats", "tiff").setChecked(True)
    dialog.files.fields["cloud"].choice.setCurrentText("PCD")
    dialog.files.png_units.setEditText("5000")
    chosen = dialog.files.options()
    dialog.widget.reject()
    assert make().files.options() == ExportOptions()
    accept(dialog)
    assert make().files.options() == chosen == ExportOptions(("png", "tiff", "npy"), depth_units=5000, cloud="pcd")


def test_files_of_other_programs_are_offered_where_the_frame_has_what_they_need(make):
    dialog = make()
    for each in dialog.files.fields["exports"].boxes.values():
        assert each.isEnabled()
        each.setChecked(True)
    assert dialog.files.options().exports == tuple(FORMATS)
    names = dialog.files.names()
    assert all(format.file in names for format in FORMATS.values())
    accept(dialog)
    without = make(has_intrinsics=False)
    assert without.files.options().exports == ("exr", "tum.png", "palette.png", "coco.json", "labelme.json")
    assert "no camera intrinsics" in box(without, "exports", "camera.json").toolTip()
    accept(without)
    again = make()
    assert (again.files.options().exports, again.files.options().cloud) == (tuple(FORMATS), "ply")
    again.files.choose_none()
    assert again.files.options().exports == ()


def test_a_hold_out_that_is_chosen_in_one_place_is_so_in_all(qtbot):
    here, there = HoldOutChoice(), HoldOutChoice()
    for choice in (here, there):
        qtbot.addWidget(choice)
        choice.show()
    here.pattern.setCurrentIndex(1)
    here.seeds.setValue(7)
    with qtbot.waitSignal(there.changed):
        QApplication.sendEvent(there, QEvent(QEvent.Type.WindowActivate))
    assert there.test() == ilf.HoldOutTest("random", tuple(range(7))) == here.test()
    QSettings().setValue("hold_out/seeds", "some")
    QSettings().setValue("hold_out/pattern", "none such")
    damaged = HoldOutChoice()
    qtbot.addWidget(damaged)
    assert damaged.test() == ilf.HoldOutTest("areas", (0, 1, 2))


def test_a_mesh_with_or_without_a_cloud(make):
    dialog = make()
    box(dialog, "mesh").setChecked(True)
    assert "mesh.glb" in dialog.message.text()
    dialog.files.fields["mesh"].choice.setCurrentText("OBJ, text")
    box(dialog, "normals").setChecked(True)
    box(dialog, "drop_flying").setChecked(True)
    assert dialog.files.options() == ExportOptions(mesh="obj", normals=True, drop_flying=True)
    box(dialog, "cloud").setChecked(False)
    assert dialog.files.fields["axes"].choice.isEnabled()
    assert box(dialog, "drop_flying").isEnabled()
    accept(dialog)
    assert make().files.options() == ExportOptions(cloud=None, mesh="obj", normals=True, drop_flying=True)
    without = make(has_intrinsics=False)
    assert without.files.options() == ExportOptions(cloud=None)
    fields = without.files.fields
    controls = box(without, "mesh"), fields["mesh"].choice, box(without, "normals"), fields["axes"].choice
    assert not any(control.isEnabled() for control in controls)
    accept(without)
    assert make().files.options().mesh == "obj"


def test_without_result_no_curves_and_a_word_about_it(make):
    dialog = make(has_result=False)
    assert not dialog.files.options().curves
    assert not dialog.files.options().expected_error
    assert not box(dialog, "expected_error").isEnabled()
    assert "No block has been run" in dialog.warning.text()


def test_what_the_results_lack_is_said(make):
    dialog = make(behind="1 of 2 blocks has not.")
    assert dialog.warning.text() == "1 of 2 blocks has not."
    assert (dialog.message.text().partition(" ")[0], dialog.message.tone()) == ("Writes", "muted"), "no warning"


@pytest.mark.parametrize("units", ["", "mm", "0", "-5", "nan"])
def test_units_that_are_no_number_are_refused(make, units):
    dialog = make()
    dialog.files.png_units.setEditText(units)
    assert not dialog.export_button.isEnabled()
    assert dialog.message.tone() == "error"
    with pytest.raises(ParameterError):
        dialog.files.options()


def test_world_axes_need_a_pose(make):
    dialog = make()
    axes = dialog.files.fields["axes"].choice
    axes.setCurrentIndex(axes.findData("world"))
    assert "pose" in dialog.message.text()
    assert not dialog.export_button.isEnabled()
    box(dialog, "cloud").setChecked(False)
    assert dialog.export_button.isEnabled()


def test_settings_of_another_version_do_no_harm(make):
    QSettings().setValue("export/files", '{"depth_formats": ["exr"], "colour": 1}')
    assert make().files.options() == ExportOptions()


def test_a_png_has_the_units_of_the_input_unless_others_are_chosen(make):
    for units in (10_000.0, 5000.0, 256.0, 1234.5678):
        dialog = make(units=units)
        assert dialog.files.options().depth_units == units
        assert dialog.files.png_note.tone() == "muted"
        accept(dialog)
    assert make(units=10_000.0).files.png_units.currentText() == "10000 (0.1 mm)"
    assert make(units=1.0).files.options().depth_units == 1000, "depth in metres has fractions"
    dialog = make(units=5000.0)
    dialog.files.png_units.setCurrentText("1000 (millimetres)")
    accept(dialog)
    assert make(units=10_000.0).files.options().depth_units == 1000, "as it was chosen"
    dialog = make(units=5000.0)
    dialog.files.png_units.setCurrentText("5000 (TUM)")
    accept(dialog)
    assert make(units=10_000.0).files.options().depth_units == 10_000
