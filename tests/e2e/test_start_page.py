"""The start page: there while no frame is open, with what was opened last, by mouse and keyboard."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QTextDocumentFragment
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from gui.features.edit_summary import EditSummaryFeature
from gui.features.export.feature import ExportFeature
from gui.features.start_page import StartPage, StartPageFeature
from gui.work.jobs import stop_workers
from ilf.sources.frame_ref import FrameRef

from .conftest import loaded, open_frame, save, write_frame


def test_it_goes_with_a_frame_comes_back_and_offers_what_was_open(window, qtbot, tmp_path, small_frame):
    page, summary = window.feature(StartPageFeature).page, window.feature(EditSummaryFeature).line.label
    assert page.isVisible()
    assert not page.recent.isVisible(), "nothing was opened yet"
    assert not QTextDocumentFragment.fromHtml(summary.text()).toPlainText(), "there is nothing to edit"
    for button in page.findChildren(QToolButton):
        assert button.focusPolicy() == Qt.FocusPolicy.StrongFocus
        assert button.defaultAction().isEnabled()
    for number in range(2):
        open_frame(window, qtbot, write_frame(tmp_path / f"frame-{number}", small_frame))
        assert not page.isVisible()
    assert "last edit" in summary.text()
    save(window, qtbot, tmp_path / "both.ilf")
    window.project.new()
    qtbot.waitUntil(page.isVisible)
    names = [page.recent.item(row).text() for row in range(page.recent.count())]
    assert names == [f"{tmp_path.name}/both.ilf", "frame-1", "frame-0"]
    made = page.thumbnails._made
    qtbot.waitUntil(lambda: [picture and not picture.isNull() for picture in made.values()] == [True] * 3)

    assert len({page.recent.visualItemRect(page.recent.item(row)).top() for row in range(3)}) == 1, "all in a row"

    page.recent.setFocus()
    page.recent.setCurrentRow(2)
    loaded(window, qtbot, QTest.keyClick, page.recent, Qt.Key.Key_Return)
    assert window.workspace.current.key == str(tmp_path / "frame-0")
    assert not page.isVisible()
    window.actions_["close_frame"].trigger()
    qtbot.waitUntil(page.isVisible)
    assert page.recent.item(0).text() == "frame-0", "the latest first"


def test_a_folder_of_frames_has_the_thumbnail_of_its_first_frame(tmp_path, small_frame, qtbot):
    write_frame(tmp_path / "frame-0", small_frame)
    page = StartPage([], print)
    qtbot.addWidget(page)
    page.show_recent([FrameRef(str(tmp_path))])
    (key,) = page.thumbnails._made
    qtbot.waitUntil(lambda: page.thumbnails._made[key] is not None)
    assert not page.thumbnails._made[key].isNull()
    assert stop_workers(page)


def test_results_of_the_sample_are_not_proposed_among_the_programs_own_files(window, qtbot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    loaded(window, qtbot, window.actions_["open_sample"].trigger)
    window.actions_["export"].trigger()
    dialog = window.feature(ExportFeature)
    assert dialog.folder_path.text() == str(tmp_path / "room-ilf")
    dialog.widget.close()
