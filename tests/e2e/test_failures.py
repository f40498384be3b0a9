"""What goes wrong is said in one message, and the frame, the edits and the files stay as they were."""

import errno
from pathlib import Path

import cv2
import numpy as np
from PySide6.QtCore import QMimeData, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDragLeaveEvent, QDragMoveEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QLineEdit

import ilf
from gui.features.blocks.feature import block_rows
from gui.features.blocks.table import BlockColumn
from gui.features.cloud import CloudPanel
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef
from tests.pins.window.hand import dragged

from .conftest import loaded


def _drop(window, *paths: Path):
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
    for kind in (QDragEnterEvent, QDropEvent):
        QApplication.sendEvent(window, dragged(kind, data))


def _dragged(kind: type[QDropEvent], data: QMimeData, actions: Qt.DropAction) -> QDropEvent:
    """As a file manager sends it that would rather move the files."""
    event = dragged(kind, data, actions, Qt.KeyboardModifier.ShiftModifier)
    event.setDropAction(Qt.DropAction.MoveAction)
    event.ignore()
    return event


def test_what_cannot_be_read_or_written_leaves_the_open_frame_alone(opened, qtbot, reported, tmp_path, monkeypatch):
    document = opened.workspace.current
    picture = tmp_path / "picture.png"
    cv2.imwrite(str(picture), np.zeros((48, 64, 3), np.uint8))
    loaded(opened, qtbot, opened.loader.open, FrameRef(str(picture), str(picture)))
    assert "not depth" in reported[0]
    assert len(reported) == 1
    assert opened.workspace.open == [document]
    assert "picture.png" in opened.log.text.toPlainText()
    opened.loader.open(FrameRef(document.key))
    assert not opened.loader.busy, "it is open already"

    def full(path, content):
        raise OSError(errno.ENOSPC, "full")

    before = picture.read_bytes()
    monkeypatch.setattr(Path, "write_bytes", full)
    assert not opened.documents.save_picture(str(picture))
    assert "the disk is full" in reported[1]
    assert picture.read_bytes() == before


def test_files_are_taken_as_copies_and_by_the_window_alone(window, qtbot, frame_folder, tmp_path):
    """After a move, the file manager may delete what was dropped."""
    files, move = QMimeData(), Qt.DropAction.MoveAction
    files.setUrls([QUrl.fromLocalFile(str(frame_folder))])
    files.setText(str(frame_folder))  # as file managers do, for text fields
    either = Qt.DropAction.CopyAction | move
    QApplication.instance().focusWindowChanged.emit(window.windowHandle())
    QApplication.sendEvent(window.windowHandle(), _dragged(QDragEnterEvent, files, either))  # as the system sends it
    fields = [*window.findChildren(QLineEdit), window.log.text.viewport()]
    for field in [field for field in fields if field.acceptDrops()]:
        for kind in (QDragEnterEvent, QDragMoveEvent, QDropEvent):
            event = _dragged(kind, files, either)
            QApplication.sendEvent(field, event)
            taken = event.isAccepted() and event.dropAction() != Qt.DropAction.CopyAction
            assert not taken, f"{field.accessibleName() or field} takes files to be moved"
        assert "two-planes" not in getattr(field, "text", str)()
    QApplication.sendEvent(window, QDragLeaveEvent())
    assert not window.statusBar().currentMessage()

    only_move = _dragged(QDragEnterEvent, files, move)
    QApplication.sendEvent(window, only_move)
    assert not only_move.isAccepted()
    far = QMimeData()
    far.setUrls([QUrl("https://example.org/frame")])
    elsewhere = _dragged(QDragEnterEvent, far, either)
    QApplication.sendEvent(window, elsewhere)
    assert not elsewhere.isAccepted(), "what cannot be opened is not taken"
    assert not window.statusBar().currentMessage()

    entered = _dragged(QDragEnterEvent, files, either)
    QApplication.sendEvent(window, entered)
    assert (entered.isAccepted(), entered.dropAction()) == (True, Qt.DropAction.CopyAction)
    assert window.statusBar().currentMessage() == "Drop to open two-planes"
    QApplication.sendEvent(window, QDragLeaveEvent())
    assert not window.statusBar().currentMessage()
    QApplication.sendEvent(window, entered)
    dropped = _dragged(QDropEvent, files, either)
    loaded(window, qtbot, QApplication.sendEvent, window, dropped)
    assert (dropped.isAccepted(), dropped.dropAction()) == (True, Qt.DropAction.CopyAction)
    assert not window.statusBar().currentMessage()
    assert window.workspace.current.name == "two-planes"


def test_dropping_what_is_no_frame_says_so(window, qtbot, reported, tmp_path):
    loaded(window, qtbot, _drop, window, tmp_path)
    assert "meta.json" in reported[0]
    (tmp_path / "run.json").write_text("{not json")
    loaded(window, qtbot, _drop, window, tmp_path / "run.json")
    assert "run.json" in window.notes.message
    assert window.workspace.shown is None


def test_what_a_depth_png_loses_is_told_and_a_failing_export_leaves_what_was_there(
    opened, qtbot, run_all, reported, tmp_path
):
    run_all(opened)
    opened.actions_["export"].trigger()
    dialog = feature = opened.feature(ExportFeature)
    for units, before, after in (
        ("500", "steps of 2 mm, the input has 1 mm", "steps of 2 mm"),
        ("50000", "clipped", "clipped"),
    ):
        dialog.files.png_units.setEditText(units)
        assert before in dialog.files.png_note.text()
        dialog.folder_path.setText(str(tmp_path / units))
        with qtbot.waitSignal(feature.requests.ended):
            dialog.export_button.click()
        assert after in dialog.message.text()
        assert after in opened.log.text.toPlainText()
    assert reported == [], "the dialog has said so"

    dialog.widget.reject()
    target = tmp_path / "taken"
    target.write_text("a file where the folder should be")
    feature.start(Export(target, ExportOptions()))
    qtbot.waitUntil(lambda: bool(reported))
    assert "taken is a file, not a folder" in reported[0]
    assert target.read_text() == "a file where the folder should be"
    assert opened.workspace.current.unsaved


def test_a_filter_without_its_network_is_told_of_in_the_log_and_in_the_table(opened, run_all):
    workspace = opened.workspace
    workspace.parameters.set(ilf.preset(model="elsewhere"))
    said: list[str] = []
    opened.runs.ended.connect(said.append)
    run_all(opened)
    assert "Canny's edges replace" in said[0]
    assert said[0] in opened.log.text.toPlainText()
    rows = block_rows(workspace.current, opened.runs.current).values()
    assert [row[BlockColumn.STATE].hint.splitlines()[-1] for row in rows] == list(
        workspace.current.completion().notes
    ) * len(rows)


def test_without_intrinsics_the_cloud_tab_says_what_to_do(window, qtbot, tmp_path):
    cv2.imwrite(str(tmp_path / "rgb.png"), np.full((20, 30, 3), 90, np.uint8))
    cv2.imwrite(str(tmp_path / "depth.png"), np.full((20, 30), 1500, np.uint16))
    loaded(window, qtbot, window.loader.open, FrameRef(str(tmp_path / "rgb.png"), str(tmp_path / "depth.png")))
    window.centre.show_cloud()
    window.refresh.now()
    assert "intrinsics" in window.feature(CloudPanel).view.canvas.message
