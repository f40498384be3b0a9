"""Export of all frames of a list: worked through, marked as done, exported, and exported again."""

import json
import threading

import numpy as np
import pytest
from PySide6.QtCore import QCoreApplication, QEvent, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

import ilf
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export, Scope
from gui.features.frame_list.feature import FramesFeature
from gui.features.status import StatusFeature
from ilf.project.exporting import export_frames
from ilf.run.options import ExportOptions
from tests.gui.naming import unnamed

from ..gui.states import edit
from .conftest import loaded, write_frame

NAMES = ["frame-0", "frame-1", "frame-2"]
OPTIONS = ExportOptions(depth_formats=("npy",), expected_error=False, cloud=None)


@pytest.fixture
def listed(window, qtbot, tmp_path, small_frame):
    """The window with a list of three frames, the first of them open."""
    (tmp_path / "walk").mkdir()
    for name in NAMES:
        write_frame(tmp_path / "walk" / name, small_frame)
    window.recorder.start()
    loaded(window, qtbot, window.documents.open_paths, [tmp_path / "walk"])
    window.workspace.parameters.set(ilf.preset("paper", max_iterations=20))
    return window


def _export(window, qtbot, folder, scope):
    feature = window.feature(ExportFeature)
    with qtbot.waitSignal(feature.requests.ended):
        feature.start(Export(folder, OPTIONS, scope))
        assert feature.pending_work()
        window.refresh.now()
        assert window.feature(StatusFeature).bar.progress.toolTip().startswith("Exporting 0 of ")
    return window.notes.message


def test_frames_that_are_done_are_exported_as_they_were_left(listed, qtbot, tmp_path):
    window, workspace, out = listed, listed.workspace, tmp_path / "out"
    entries = workspace.entries
    window.feature(FramesFeature).open_frames.max_open = 1
    edit(workspace, 0, rows=np.s_[:8], columns=np.s_[:8])
    labels = workspace.current.labels.copy()
    loaded(window, qtbot, window.actions_["mark_done"].trigger)
    assert entries[0].summary.done
    assert entries.of(workspace.current.id) is entries[1], "the next one that is not done"
    qtbot.waitUntil(lambda: entries[0].document is None)
    assert entries[0].summary.done, "also when it is closed"

    assert "1 written" in _export(window, qtbot, out, Scope.DONE)
    assert sorted(path.name for path in out.iterdir()) == NAMES[:1]
    run = ilf.replay(out / NAMES[0] / "run.json").run
    assert np.array_equal(run.blocks.labels, labels)
    assert run.parameters.max_iterations == 20

    assert "2 written, 1 unchanged" in _export(window, qtbot, out, Scope.ALL)
    assert sorted(path.name for path in out.iterdir()) == NAMES
    assert "3 unchanged" in _export(window, qtbot, out, Scope.ALL)
    loaded(window, qtbot, window.actions_["mark_done"].trigger)
    window.actions_["mark_done"].trigger()
    assert entries.of(workspace.current.id) is entries[2]
    assert not window.loader.busy, "all are done"


def test_present_results_are_exported_without_another_run(listed, qtbot, tmp_path, monkeypatch):
    window, out = listed, tmp_path / "out"
    with qtbot.waitSignal(window.runs.finished):
        window.actions_["run"].trigger()
    completion = window.workspace.current.completion()
    window.actions_["mark_done"].trigger()
    qtbot.waitUntil(lambda: not window.loader.busy)
    monkeypatch.setattr("ilf.run.run.Run.complete", None)
    assert "1 written" in _export(window, qtbot, out, Scope.DONE)
    assert np.array_equal(np.load(out / NAMES[0] / "depth.npy"), completion.depth, equal_nan=True)


def test_a_frame_that_cannot_be_read_is_named_and_the_others_are_written(listed, qtbot, tmp_path, monkeypatch):
    warned = []
    monkeypatch.setattr(listed.context.notes, "warn", lambda what, notes: warned.append((what, list(notes))))
    (tmp_path / "walk" / "frame-1" / "depth.png").unlink()
    assert "2 written, 1 failed" in _export(listed, qtbot, tmp_path / "out", Scope.ALL)
    ((what, (reason,)),) = warned
    assert what == "Not exported: 1 frame"
    assert reason.startswith("frame-1: ")


def test_an_export_of_which_all_has_failed_is_not_called_exported(listed, qtbot, tmp_path):
    for name in NAMES:
        (tmp_path / name).write_bytes(b"")  # a file where the frame's folder would be
    told = _export(listed, qtbot, tmp_path, Scope.ALL)
    assert "3 failed" in told
    assert not told.startswith("Exported")


def test_the_dialog_offers_frames_shows_what_was_written_and_asks_before_it_replaces(listed, qtbot, tmp_path):
    (tmp_path / "walk" / "frame-1" / "depth.png").unlink()
    listed.actions_["export_all"].trigger()
    dialog = listed.feature(ExportFeature)
    texts = [dialog.scope.itemText(row) for row in range(dialog.scope.count())]
    assert texts == [
        "This frame: frame-0", "Frames marked as done: 0", "Frames that have been worked on: 0",
        "Selected rows of the list: 1", "All frames of the list: 3",
    ]  # fmt: skip
    assert [dialog.scope.model().item(row).isEnabled() for row in range(5)] == [True, False, False, True, True]
    assert not list(unnamed(dialog.widget))
    assert dialog.scope.currentData() == Scope.ALL
    assert "Writes 3 folders, one per frame" in dialog.message.text()
    assert dialog.export_button.isEnabled()
    dialog.scope.setCurrentIndex(1)
    assert not dialog.export_button.isEnabled()
    dialog.scope.setCurrentIndex(4)
    (tmp_path / "file").write_text("")
    dialog.folder_path.setText(str(tmp_path / "file" / "out"))
    with qtbot.waitSignal(listed.feature(ExportFeature).requests.ended):
        dialog.export_button.click()
    assert dialog.message.tone() == "error"
    assert dialog.results.topLevelItemCount() == 0, "no frame is completed in vain"
    dialog.folder_path.setText(str(tmp_path / "out"))
    with qtbot.waitSignal(listed.feature(ExportFeature).requests.ended):
        QTest.keyClick(dialog.folder_path, Qt.Key.Key_Return)
    rows = [dialog.results.topLevelItem(number) for number in range(3)]
    assert [(row.text(0), row.text(1)) for row in rows] == list(
        zip(NAMES, ("written", "failed", "written"), strict=True)
    )
    assert "depth.png" in rows[1].text(2)
    assert "frame-1: " in dialog.message.text()
    assert dialog.visible

    def answer(button):
        dialog.export_button.click()
        (box,) = dialog.widget.findChildren(QMessageBox)
        assert "frame-0/depth.png" in box.informativeText()
        next(one for one in box.buttons() if one.text() == button).click()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)

    answer("Cancel")
    assert not listed.feature(ExportFeature).busy
    with qtbot.waitSignal(listed.feature(ExportFeature).requests.ended):
        answer("&Replace")
    assert [dialog.results.topLevelItem(row).text(1) for row in range(3)] == ["unchanged", "failed", "unchanged"]
    QTest.keyClick(dialog.widget, Qt.Key.Key_Escape)
    assert not dialog.visible


def test_export_all_proposes_all_frames_also_if_some_are_marked_as_done(listed):
    listed.workspace.set_done(listed.workspace.entries[1], True)
    listed.actions_["export_all"].trigger()
    assert listed.feature(ExportFeature).scope.currentText() == "All frames of the list: 3"


def test_the_dialog_offers_the_frame_that_was_turned_to_during_an_export(listed, qtbot, tmp_path, monkeypatch):
    window, feature, turned = listed, listed.feature(ExportFeature), threading.Event()

    def held(*given):
        turned.wait(20)
        yield from export_frames(*given)

    monkeypatch.setattr("gui.features.export.feature.export_frames", held)
    feature.ask()
    first = feature.folder_path.text()
    feature.export_button.click()
    loaded(window, qtbot, window.loader.open_entry, window.workspace.entries[1])
    window.refresh.now()
    with qtbot.waitSignal(feature.requests.ended):
        assert feature.busy
        turned.set()
    assert window.workspace.current.name in feature.widget.windowTitle()
    assert feature.folder_path.text() != first, "it would replace the files of the other frame"
    assert feature.message.text().startswith("Exported to")


def test_all_frames_are_proposed_beside_their_folders_also_after_an_export_of_one(listed, qtbot, tmp_path):
    feature = listed.feature(ExportFeature)
    _export(listed, qtbot, tmp_path / "walk" / NAMES[0] / "completed", Scope.THIS)
    feature.ask(of_all=True)
    assert feature.folder_path.text() == str(tmp_path / "walk" / "export")
    _export(listed, qtbot, tmp_path / "elsewhere" / "all", Scope.ALL)
    feature.ask(of_all=True)
    assert feature.folder_path.text() == str(tmp_path / "elsewhere" / "export")


def test_no_folder_in_that_of_a_frame_is_proposed_whatever_the_frame_is_called(window, qtbot, tmp_path, small_frame):
    (tmp_path / "walk").mkdir()
    folder = write_frame(tmp_path / "walk" / "a", small_frame)
    meta = json.loads((folder / "meta.json").read_text()) | {"name": "desk"}
    (folder / "meta.json").write_text(json.dumps(meta))
    loaded(window, qtbot, window.documents.open_paths, [folder])
    assert window.workspace.current.name == "desk"
    window.feature(ExportFeature).ask(of_all=True)
    assert window.feature(ExportFeature).folder_path.text() == str(tmp_path / "walk" / "export")


def test_exports_of_another_data_set_are_proposed_beside_its_own_frames(listed, qtbot, tmp_path, small_frame):
    feature = listed.feature(ExportFeature)
    _export(listed, qtbot, tmp_path / "elsewhere" / "all", Scope.ALL)
    (tmp_path / "run").mkdir()
    for name in NAMES[:2]:
        write_frame(tmp_path / "run" / name, small_frame)
    loaded(listed, qtbot, listed.documents.open_paths, [tmp_path / "run"])
    for command, name in (("export_all", "export"), ("batch", "batch")):
        listed.actions_[command].trigger()
        assert feature.folder_path.text() == str(tmp_path / "run" / name)
