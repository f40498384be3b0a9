"""The start page: there while no frame is open, with what was opened last, by mouse and keyboard."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton
from pytestqt.qtbot import QtBot

from gui.app.main_window import MainWindow
from gui.features.project.start_page import StartPageFeature
from ilf.data.frame import RGBDFrame
from ilf.sources.frame_source import FrameSource

from .conftest import WAIT_MS, open_frame, write_frame
from .test_projects import save


def test_it_goes_with_a_frame_comes_back_and_offers_what_was_open(
    window: MainWindow, qtbot: QtBot, tmp_path: Path, small_frame: RGBDFrame
) -> None:
    page = window.feature(StartPageFeature).page
    assert page.isVisible()
    assert not page.recent.isVisible(), "nothing was opened yet"
    for button in page.findChildren(QToolButton):
        assert button.focusPolicy() == Qt.FocusPolicy.StrongFocus
        assert button.defaultAction().isEnabled()
    for number in range(2):
        open_frame(window, qtbot, FrameSource(str(write_frame(tmp_path / f"frame-{number}", small_frame))))
        assert not page.isVisible()
    save(window, qtbot, tmp_path / "both.ilf")
    window.project.new()
    qtbot.waitUntil(page.isVisible)
    names = [page.recent.item(row).text() for row in range(page.recent.count())]
    assert names == [f"{tmp_path.name}/both.ilf", "frame-1", "frame-0"]
    qtbot.waitUntil(lambda: all(page.has_picture(row) for row in range(3)), timeout=WAIT_MS)

    page.recent.setFocus()
    page.recent.setCurrentRow(2)
    with qtbot.waitSignal(window.loader.idle, timeout=WAIT_MS):
        QTest.keyClick(page.recent, Qt.Key.Key_Return)
    assert window.workspace.session.key == str(tmp_path / "frame-0")
    assert not page.isVisible()
    window.actions_["close_frame"].trigger()
    qtbot.waitUntil(page.isVisible)
    assert page.recent.item(1).text() == "frame-0", "the latest frame first"
