"""A folder of frames, worked through in the window: opened when they are looked at, put away, and there again."""

import shutil
import threading

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QLineEdit

from gui.features.documents.recent import key_of
from gui.features.frame_list.feature import FramesFeature
from gui.features.frame_list.model import ENTRY
from ilf.project.project import Stage
from ilf.segmentation.extraction import extract

from ..gui.states import edit
from .conftest import activate, answer, loaded, reading, write_frame

COUNT = 6


@pytest.fixture
def folder(tmp_path, small_frame):
    """Six frames, of which the third is broken, and what is none."""
    root = tmp_path / "walk"
    root.mkdir()
    for number in range(COUNT):
        write_frame(root / f"frame-{number}", small_frame)
    (root / "frame-2" / "depth.png").write_bytes(b"nothing")
    (root / "notes").mkdir()
    return root


@pytest.fixture
def listed(window, qtbot, folder):
    """The window with the folder's list, and the first frame open."""
    window.recorder.start()
    loaded(window, qtbot, window.documents.open_paths, [folder])
    return window


def _go(window, qtbot, command="next_frame"):
    loaded(window, qtbot, window.actions_[command].trigger)


def _present(window):
    return window.workspace.entries.of(window.workspace.current.id)


def test_a_frame_that_is_shown_again_has_its_zoom(listed, qtbot):
    views = listed.views
    views.transform.show(slice(10, 20), slice(10, 20))
    place = views.transform.place
    _go(listed, qtbot)
    assert views.transform.place is None, "a frame is shown whole at first"
    listed.actions_["previous_frame"].trigger()
    listed.refresh.now()
    assert views.transform.place == place
    listed.actions_["next_frame"].trigger()
    listed.refresh.now()
    assert views.transform.place is None


def test_folder_is_worked_through_and_left_frames_come_back(listed, qtbot, folder):
    window, workspace = listed, listed.workspace
    part, entries = window.feature(FramesFeature), workspace.entries
    assert [entry.name for entry in entries] == [f"frame-{number}" for number in range(COUNT)]
    assert [entry.document is not None for entry in entries] == [True, False, False, False, False, False]
    assert [key_of(origin) for origin in window.documents.recent.origins] == [str(folder)]
    assert _present(window).summary.stage is Stage.EXTRACTED
    part.open_frames.max_open = 2

    first = workspace.current
    edit(workspace, 0, rows=np.s_[:8], columns=np.s_[:8])
    workspace.set_note(entries[0], "glass")
    first_id, labels = first.id, first.labels.copy()

    _go(window, qtbot)
    assert _present(window) is entries[1]
    _go(window, qtbot)
    assert entries[2].summary.stage is Stage.FAILED
    assert "frame-2" in entries[2].summary.problem
    assert _present(window) is entries[1], "the one that cannot be opened is passed by"
    _go(window, qtbot)
    assert _present(window) is entries[3]
    qtbot.waitUntil(lambda: entries[0].document is None)
    assert len(workspace.open) == 2
    assert (entries[0].summary.stage, entries[0].note, entries[0].unsaved) == (Stage.EDITED, "glass", True)

    shutil.rmtree(folder / "frame-4")
    _go(window, qtbot, "next_untouched")
    assert entries[4].summary.stage is Stage.FAILED
    part.open(entries[0])
    qtbot.waitUntil(lambda: _present(window) is entries[0])
    back = workspace.current
    assert back is not first
    assert (back.id, back.state.note, back.unsaved) == (first_id, "glass", True)
    assert np.array_equal(back.labels, labels)
    assert not back.undo_stack.canUndo()


def test_frames_that_are_passed_by_are_not_extracted_before_they_are_shown_again(listed, qtbot, monkeypatch):
    go_on, entries, frames = threading.Event(), listed.workspace.entries, listed.feature(FramesFeature)

    def slow(*given):
        go_on.wait(10)
        return extract(*given)

    monkeypatch.setattr("gui.project.loading.extract", slow)
    with reading(listed, qtbot):
        for row in (1, 3, 4):
            frames.open(entries[row])
            qtbot.waitUntil(lambda row=row: listed.workspace.current_entry is entries[row])
        go_on.set()
    assert [entry.summary.stage for entry in (entries[1], entries[3], entries[4])] == [
        "extracted",
        "untouched",
        "extracted",
    ]
    loaded(listed, qtbot, frames.open, entries[3])
    assert _present(listed) is entries[3]
    assert entries[3].summary.stage is Stage.EXTRACTED


def test_the_film_strip_goes_from_frame_to_frame(listed, qtbot):
    strip, entries = listed.feature(FramesFeature).panel.view, listed.workspace.entries
    assert strip.isVisible()
    assert strip.is_strip
    qtbot.waitUntil(lambda: strip.model().rowCount() == len(entries))
    second = strip.visualRect(strip.model().index(1, 0)).center()
    with reading(listed, qtbot):
        QTest.mouseClick(strip.viewport(), Qt.MouseButton.LeftButton, pos=second)
    assert _present(listed) is entries[1]
    for _ in range(2):
        QTest.keyClick(strip, Qt.Key.Key_Right)
    loaded(listed, qtbot, QTest.keyClick, strip, Qt.Key.Key_Return)
    assert _present(listed) is entries[3]
    _go(listed, qtbot)
    qtbot.waitUntil(lambda: strip.currentIndex().data(ENTRY) is entries[4])
    height = listed.views.height()
    listed.actions_["film_strip"].trigger()
    qtbot.waitUntil(lambda: listed.views.height() > height)
    assert not strip.isVisible()
    listed.actions_["film_strip"].trigger()
    listed.panels.reveal("Frames")
    qtbot.waitUntil(lambda: strip.isVisible() and not strip.is_strip)
    listed.panels.toggle_all()
    qtbot.waitUntil(lambda: strip.isVisible() and strip.is_strip)
    activate(listed, qtbot)
    listed.actions_["note_frame"].trigger()
    qtbot.waitUntil(lambda: isinstance(listed.focusWidget(), QLineEdit))
    qtbot.wait(50)
    assert listed.focusWidget().isVisible()
    assert strip.isAncestorOf(listed.focusWidget())
    assert not strip.is_strip


def test_what_is_not_stored_or_runs_stays_open(listed, qtbot, monkeypatch):
    window, entries = listed, listed.workspace.entries
    part = window.feature(FramesFeature)
    part.open_frames.max_open = 1
    told = []
    monkeypatch.setattr(window.recorder, "flush", told.append)
    _go(window, qtbot)
    assert len(told) == 1
    told[0](OSError("disk full"))
    assert len(window.workspace.open) == 2, "it could not be stored"
    monkeypatch.setattr(window.recorder.store, "has", lambda id: False)
    told[0](None)
    assert len(window.workspace.open) == 2, "nothing is stored of it"
    monkeypatch.setattr(window.recorder.store, "has", lambda id: True)
    document = entries[0].document
    assert document is not None
    window.workspace.set_note(entries[0], "changed since")
    told[0](None)
    assert entries[0].document is document, "it has changed since"
    monkeypatch.setattr(part.open_frames, "is_busy", lambda one: True)
    part.open_frames.close_surplus()
    assert len(told) == 1, "what is at work is not even asked for"


def test_keys_follow_the_list_as_it_is_shown_and_removal_asks_once(listed, qtbot, monkeypatch):
    window, workspace, entries = listed, listed.workspace, listed.workspace.entries
    panel, part = window.feature(FramesFeature).panel, window.feature(FramesFeature)
    workspace.set_note(entries[1], "shiny")
    workspace.set_note(entries[5], "shiny")
    panel.text.setText("shiny")
    assert [entry.name for entry in panel.model.entries] == ["frame-0", "frame-1", "frame-5"], "the present one stays"
    _go(window, qtbot, "previous_frame")
    assert _present(window) is entries[5]
    part._show_list()
    assert [entry.name for entry in panel.model.entries] == ["frame-1", "frame-5"], "what was left is left out now"
    panel.text.clear()
    panel.state.setCurrentIndex(0)
    assert len(panel.model.entries) == COUNT
    row = panel.view.visualRect(panel.model.index_of(entries[5]))
    assert panel.view.viewport().rect().contains(row), "the present one is in sight again"

    asked = []
    some = [entries[1], entries[3], entries[5]]
    with monkeypatch.context() as patch:
        patch.setattr(window.project, "ask_remove", lambda entries, then: asked.append(list(entries)))
        part.remove(some)
    assert asked == [some]
    assert len(entries) == COUNT, "the user would rather keep them"
    part.remove(some)
    assert [entry.name for entry in entries] == ["frame-0", "frame-2", "frame-4"]
    assert _present(window) is entries[0]
    assert workspace.open == [entries[0].document]


def _open_folder(window, qtbot, folder):
    window.documents.open_paths([folder])
    qtbot.waitUntil(lambda: window.workspace.shown is not None and not window.loader.busy)


def test_work_on_a_folder_is_there_again_the_next_time(another, qtbot, folder, small_frame):
    window = another(persistent=True)
    _open_folder(window, qtbot, folder)
    assert not window.project.present.unsaved, "looking is no work"
    _go(window, qtbot)
    window.workspace.set_note(window.workspace.entries[1], "mirror")
    window.workspace.set_note(window.workspace.entries[4], "not opened yet")
    edit(window.workspace, 0, rows=np.s_[:8], columns=np.s_[:8])
    labels = window.workspace.current.labels.copy()
    assert window.project.present.unsaved
    _save(window, qtbot)
    assert not window.project.present.unsaved
    project = window.project.present.path
    assert [key_of(origin) for origin in window.documents.recent.origins] == [str(project), str(folder)]
    assert window.close()

    write_frame(folder / "frame-9", small_frame)
    again = another(persistent=True)
    _open_folder(again, qtbot, folder)
    qtbot.waitUntil(lambda: len(again.workspace.entries) == COUNT + 1)
    entries = again.workspace.entries
    assert [entry.note for entry in entries] == ["", "mirror", "", "", "not opened yet", "", ""]
    assert _present(again) is entries[1]
    assert np.array_equal(again.workspace.current.labels, labels)
    assert entries[6].name == "frame-9"
    assert not again.project.present.unsaved, "that a frame has come to the folder is no work"

    other = another(persistent=True)
    _open_folder(other, qtbot, folder)
    assert other.project.present.path == again.project.present.path
    project = again.project.present.path
    project.write_bytes(b"damaged")
    told = []
    last = another(persistent=True)
    last.notes.report = lambda what, error: told.append(what)
    _open_folder(last, qtbot, folder)
    assert told == ["Opening walk.ilf"]
    assert len(last.workspace.entries) == COUNT + 1
    assert last.project.present.path is None, "what is damaged is not written over"


@pytest.fixture
def in_folder(another, qtbot, folder):
    """The window with the folder's project."""
    window = another(persistent=True)
    window.project.discard_silently = False
    _open_folder(window, qtbot, folder)
    return window


def _save(window, qtbot):
    with qtbot.waitSignal(window.project.saving.saved):
        window.actions_["save_project"].trigger()


def test_a_folder_beside_another_file_of_that_name_is_saved_where_the_user_says(another, qtbot, folder, monkeypatch):
    folder.with_name("walk.ilf").write_bytes(b"of somebody else")
    mine = folder.with_name("mine.ilf")
    window = another(persistent=True)
    _open_folder(window, qtbot, folder)
    assert window.project.present.path is None
    window.workspace.set_note(window.workspace.entries[1], "mirror")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(mine), ""))
    window.actions_["save_project"].trigger()
    with qtbot.waitSignal(window.project.saving.saved):
        answer(window, "&Leave them out")
    again = another(persistent=True)
    _open_folder(again, qtbot, folder)
    assert again.project.present.path == mine
    assert again.workspace.entries[1].note == "mirror"


@pytest.mark.parametrize("button", ["&Add to it", "&New project", "Cancel"])
def test_a_frame_opened_later_joins_the_folders_project_only_if_the_user_wants_it(
    in_folder, qtbot, folder, small_frame, button
):
    _save(in_folder, qtbot)
    project = in_folder.project.present.path
    other = write_frame(folder.with_name("elsewhere"), small_frame)
    in_folder.documents.open_paths([folder / "frame-1"])
    qtbot.waitUntil(lambda: _present(in_folder).name == "frame-1")
    in_folder.documents.open_paths([other])
    qtbot.waitUntil(lambda: not in_folder.loader.busy)
    assert "walk" in answer(in_folder, button)
    qtbot.waitUntil(lambda: not in_folder.loader.busy)
    names = {"&Add to it": COUNT + 1, "&New project": 1, "Cancel": COUNT}
    qtbot.waitUntil(lambda: len(in_folder.workspace.entries) == names[button])
    assert in_folder.project.present.path == (None if button == "&New project" else project)


@pytest.mark.parametrize("name", ["empty", "other.json"])
def test_nobody_is_asked_to_close_the_project_for_what_cannot_be_opened(in_folder, qtbot, folder, monkeypatch, name):
    _save(in_folder, qtbot)
    other = folder.with_name(name)
    other.write_text("{}") if other.suffix else other.mkdir()
    told = []
    monkeypatch.setattr(in_folder.notes, "report", lambda what, error: told.append(what))
    in_folder.documents.open_paths([other])
    qtbot.waitUntil(lambda: told == [f"Opening {name}"])


def test_before_anything_is_done_in_it_a_folders_project_ends_when_another_frame_is_opened(
    in_folder, qtbot, folder, small_frame
):
    assert in_folder.project.present.path == folder.with_name("walk.ilf")
    in_folder.documents.open_paths([write_frame(folder.with_name("elsewhere"), small_frame)])
    qtbot.waitUntil(lambda: len(in_folder.workspace.entries) == COUNT + 1)
    qtbot.waitUntil(lambda: in_folder.project.present.path is None)
