"""What is done to a project while it is saved, opened or left: nothing is mixed, and nothing is lost."""

import os
import uuid

import pytest

from gui.state.workspace import Entry
from ilf.project.file import open_project
from ilf.sources.frame_ref import FrameRef, ReadingOptions

from .conftest import answer, asked, loaded, save, write_frame


def test_the_present_project_is_opened_again_as_it_has_been_saved_before(opened, qtbot, tmp_path):
    path = tmp_path / "room.ilf"
    save(opened, qtbot, path)
    opened.workspace.current.edit_info(1, "Rename", name="Wall")
    opened.project.discard_silently = False
    opened.documents.open_paths([path])
    qtbot.waitUntil(lambda: opened.project.question is not None)
    dialog = opened.project.question
    with qtbot.waitSignal(opened.project.opening.opened):
        dialog.save_button.click()
    qtbot.waitUntil(lambda: opened.workspace.shown is not None)
    opened.project.discard_silently = True
    assert opened.workspace.current.info(1).name == "Wall"


@pytest.mark.parametrize("leave", ["new_project", "quit"])
def test_a_project_is_left_only_when_it_has_been_saved(opened, qtbot, tmp_path, leave):
    path, other = tmp_path / "room.ilf", tmp_path / "other.ilf"
    save(opened, qtbot, path)
    opened.project.discard_silently = False
    opened.project.saving.save(other)
    opened.actions_[leave].trigger()
    qtbot.waitUntil(lambda: not (opened.isVisible() and len(opened.workspace.entries)))
    with open_project(other) as project:
        assert [frame.has_state for frame in project.project.frames] == [True]
    if leave == "new_project":
        assert opened.project.present.path is None, "the file is not that of the new project"


def test_a_note_written_while_the_project_is_saved_stays_unsaved(opened, qtbot, tmp_path, small_frame):
    entry = Entry.of(FrameRef(str(write_frame(tmp_path / "second", small_frame))))
    opened.workspace.add_entries([entry])
    with qtbot.waitSignal(opened.project.saving.saved):
        opened.project.saving.save(tmp_path / "room.ilf")
        opened.workspace.set_note(entry, "Late.")
    assert entry.unsaved
    save(opened, qtbot, tmp_path / "room.ilf")
    assert not entry.unsaved


def test_two_frames_of_the_same_files_stay_apart(opened, qtbot):
    """As where work is restored beside a frame that is in the list already."""
    workspace = opened.workspace
    (worked,) = workspace.entries
    workspace.current.edit_info(1, "Rename", name="Wall")
    others = [
        Entry(uuid.uuid4().hex, worked.key, "other", FrameRef(worked.key, options=ReadingOptions(depth_units=units)))
        for units in (None, 1000.0)
    ]
    workspace.add_entries(others)
    for other in others:
        opened.loader.open_entry(other)
        qtbot.waitUntil(lambda: not opened.loader.busy)
    documents = [entry.document for entry in workspace.entries]
    assert None not in documents
    assert [document.id for document in documents if document is not None] == [worked.id, *(one.id for one in others)]
    assert worked.document.info(1).name == "Wall"


def test_a_frame_that_is_removed_while_it_is_read_does_not_come_back(opened, qtbot, tmp_path, small_frame):
    entry = Entry.of(FrameRef(str(write_frame(tmp_path / "second", small_frame))))
    opened.workspace.add_entries([entry])
    opened.loader.open_entry(entry)
    opened.workspace.remove_entries([entry])
    qtbot.waitUntil(lambda: not opened.loader.busy)
    assert len(opened.workspace.entries) == len(opened.workspace.open) == 1


def test_saved_work_is_not_replaced_unasked_by_the_same_frame_named_or_read_otherwise(
    opened, qtbot, tmp_path, frame_folder
):
    workspace, documents = opened.workspace, opened.documents
    (entry,) = workspace.entries
    workspace.current.edit_info(1, "Rename", name="Wall")
    save(opened, qtbot, tmp_path / "room.ilf")
    workspace.unload(workspace.current)
    opened.project.discard_silently = False

    loaded(opened, qtbot, documents.open_source, FrameRef(os.path.relpath(frame_folder)))
    assert workspace.current.info(1).name == "Wall"
    workspace.unload(workspace.current)
    documents.open_source(FrameRef(str(frame_folder), options=ReadingOptions(depth_units=2000.0)))
    asked(opened, qtbot)
    answer(opened, "Cancel")
    assert list(workspace.entries) == [entry]
    assert not opened.loader.busy
    opened.project.discard_silently = True
    nearer = FrameRef(str(frame_folder), options=ReadingOptions(depth_units=2000.0))
    loaded(opened, qtbot, documents.open_source, nearer)
    assert [one.id for one in workspace.entries] == [workspace.current.id] != [entry.id]
