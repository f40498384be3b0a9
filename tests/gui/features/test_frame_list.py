"""The frame list: what is shown of it, in which order, and what its rows say and report."""

import cv2
import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit

from gui.features.frame_list import thumbnails as thumbnails_module
from gui.features.frame_list.model import FrameListModel, last_line, shown_entries, tooltip_text
from gui.features.frame_list.panel import FramesPanel
from gui.state.workspace import Entry
from gui.work.jobs import stop_workers
from ilf.project.project import FrameSummary, Stage
from ilf.sources.frame_ref import FrameRef, ReadingOptions

SUMMARIES = {
    "frame-10": FrameSummary(),
    "frame-2": FrameSummary(Stage.RUN, "glass door", (480, 640), 0.25, 14, 12, 3),
    "Frame-1": FrameSummary(Stage.EDITED, "", (480, 640), 0.5, 3),
    "broken": FrameSummary(Stage.FAILED, problem="its depth is truncated"),
}


def _entries() -> list[Entry]:
    found = []
    for name, summary in SUMMARIES.items():
        entry = Entry.of(FrameRef(f"/nowhere/{name}"))
        entry.set_summary(summary)
        found.append(entry)
    return found


def _names(entries: list[Entry]) -> list[str]:
    return [entry.name for entry in entries]


@pytest.mark.parametrize(
    ("chosen", "names"),
    [
        ({}, ["frame-10", "frame-2", "Frame-1", "broken"]),
        ({"text": "FRAME"}, ["frame-10", "frame-2", "Frame-1"]),
        ({"text": "glass fra"}, ["frame-2"]),
        ({"state": "failed"}, ["broken"]),
        ({"state": "note"}, ["frame-2"]),
        ({"state": "check"}, ["frame-2"]),
        ({"state": "unsaved"}, []),
        ({"text": "1", "state": "edited"}, ["Frame-1"]),
        ({"order": "name"}, ["broken", "Frame-1", "frame-2", "frame-10"]),
        ({"order": "state"}, ["frame-10", "Frame-1", "frame-2", "broken"]),
        ({"order": "missing"}, ["Frame-1", "frame-2", "frame-10", "broken"]),
    ],
)
def test_sieve_leaves_out_and_sorts(chosen, names):
    entries = _entries()
    assert _names(shown_entries(entries, **chosen)) == names
    assert entries[0] in shown_entries(entries, **chosen, always=entries[0]), "the frame that is looked at stays"


def test_row_says_all_in_words(qapp):
    entry = _entries()[1]
    text = tooltip_text(entry)
    for words in ("frame-2", "Run, 12 of 14 blocks, 3 to check", "640 x 480, 25.0% missing", "Note: glass door"):
        assert words in text
    broken = _entries()[3]
    assert "its depth is truncated" in tooltip_text(broken)
    broken.set_summary(FrameSummary(Stage.FAILED, problem="/nowhere/broken: its depth is truncated"))
    assert last_line(broken) == "its depth is truncated"
    model = FrameListModel(lambda entry: None)
    model.set_entries([entry])
    assert model.index(0, 0).data(Qt.ItemDataRole.AccessibleTextRole) == (
        "frame-2, Run, 12 of 14 blocks, 3 to check, glass door"
    )


@pytest.fixture
def panel(shown):
    panel = FramesPanel(lambda id: None)
    entries = _entries()
    panel.show_entries(entries, entries[0])
    shown(panel, 300, 400)
    yield panel
    stop_workers(panel)


def test_the_frame_that_a_key_with_ctrl_leads_to_is_selected_alone(panel, qtbot):
    entries, keyboard = list(panel.model.entries), panel.window().windowHandle()
    QTest.keyPress(keyboard, Qt.Key.Key_PageDown, Qt.KeyboardModifier.ControlModifier)
    assert QGuiApplication.keyboardModifiers() == Qt.KeyboardModifier.ControlModifier
    panel.show_entries(entries, entries[1])
    QTest.keyRelease(keyboard, Qt.Key.Key_PageDown)
    assert panel.view.chosen() == [entries[1]]


def test_a_note_is_edited_in_the_row_that_is_chosen(panel, qtbot):
    told, view, model = [], panel.view, panel.model
    model.noted.connect(lambda entry, text: told.append((entry.name, text)))
    view.note_requested.connect(lambda entry: view.write_note(model.index_of(entry)))

    def edit(typed: str) -> QLineEdit:
        view.setCurrentIndex(model.index(1, 0))
        qtbot.keyClick(view, Qt.Key.Key_F2)
        (line,) = (line for line in view.findChildren(QLineEdit) if line.isVisible())
        assert line.text() == "glass door"
        qtbot.keyClicks(line, typed)
        assert view.viewport().rect().contains(line.geometry())
        return line

    line = edit("mirror")
    model.set_entries(model.entries)
    assert line.text() == "mirror", "the list is drawn anew meanwhile"
    view.setCurrentIndex(model.index(2, 0))
    view.setFocus()
    qtbot.waitUntil(lambda: told == [("frame-2", "mirror")])
    qtbot.keyClick(edit("no"), Qt.Key.Key_Escape)
    assert len(told) == 1, "given up"
    qtbot.waitUntil(view.hasFocus)
    qtbot.keyClick(edit(" tin "), Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: told[1:] == [("frame-2", "tin")])


def test_thumbnails_come_from_files_from_the_store_and_fail_quietly(tmp_path, qtbot, monkeypatch):
    red, green = (
        (np.full((60, 80, 3), 0, np.uint8) + np.array(colour, np.uint8)) for colour in ((0, 0, 255), (0, 255, 0))
    )
    cv2.imwrite(str(tmp_path / "rgb.png"), red)
    stated = ReadingOptions(intrinsics={"fx": 50.0, "fy": 50.0, "cx": 40.0, "cy": 30.0})  # as data sets state it
    of_file, of_store, broken = (
        Entry.of(FrameRef(str(tmp_path / name), "depth.png", options=stated))
        for name in ("rgb.png", "rgb.png", "gone.png")
    )
    jpeg = cv2.imencode(".jpg", green)[1].tobytes()
    panel = FramesPanel(lambda id: jpeg if id == of_store.id else None)
    qtbot.addWidget(panel)
    picture_of, wanted = panel.picture_of, [of_file, of_store, broken]
    assert [picture_of(entry) for entry in wanted] == [None] * 3
    qtbot.waitUntil(lambda: all(picture_of(entry) is not None for entry in wanted))
    colours = [picture_of(entry).toImage().pixelColor(5, 5) for entry in wanted[:2]]
    assert [(colour.red() > 200, colour.green() > 200) for colour in colours] == [(True, False), (False, True)]
    assert picture_of(broken).isNull()
    broken.source = of_file.source
    qtbot.waitUntil(lambda: picture_of(broken) is not None)
    assert not picture_of(broken).isNull(), "its file has been found elsewhere"
    monkeypatch.setattr(thumbnails_module, "MAX_THUMBNAILS", 2)
    picture_of(of_file)
    other = Entry.of(FrameRef(str(tmp_path / "rgb.png"), "other.png"))
    qtbot.waitUntil(lambda: picture_of(other) is not None)
    assert len(panel.thumbnails._made) == 2
    assert stop_workers(panel)
