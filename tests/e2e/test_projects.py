"""Projects in the real window: all work is saved and comes back, and none of it is lost without being asked about."""

import errno
import json
import os
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QFileDialog, QMessageBox

import ilf
from gui.features.export.feature import ExportFeature
from gui.features.export.jobs import Export
from gui.features.frame_list.feature import FramesFeature
from gui.features.run_history.panel import RunsPanel
from gui.features.sweep.feature import SweepFeature
from gui.state.document import Document
from gui.state.parts import Part
from gui.state.workspace import Entry
from ilf.project.file import open_project as read_project
from ilf.project.project import Stage
from ilf.run.options import ExportOptions
from ilf.sources.frame_ref import FrameRef

from ..gui.states import edit
from ..ilf.project_states import assert_same
from .conftest import answer, asked, in_front, open_frame, save, write_frame


def open_project(window, qtbot, path: Path):
    with qtbot.waitSignal(window.project.opening.opened):
        window.documents.open_paths([path])
    qtbot.waitUntil(lambda: not window.loader.busy)
    window.refresh.now()


def show(window, qtbot, row: int) -> Document:
    """A frame of the list, as it is opened when it is looked at."""
    workspace, entry = window.workspace, window.workspace.entries[row]
    window.loader.open_entry(entry)
    qtbot.waitUntil(lambda: workspace.shown is not None and workspace.shown is entry.document)
    return workspace.current


def work_on(window, qtbot, run_all) -> Document:
    """Something of everything that a user can do to a frame."""
    workspace = window.workspace
    document = workspace.current
    first, second = list(document.counts())[:2]
    edit(workspace, 0, rows=np.s_[2:6], columns=np.s_[2:6])
    workspace.current.edit_info(first, "Rename", name="Wall", colour=(1, 2, 3), locked=True)
    workspace.current.set_visible(second, False)
    workspace.parameters.set(ilf.preset("paper", max_iterations=30))
    workspace.parameters.set_own({"max_iterations": 7}, [second])
    invalid_mask = np.zeros(document.labels.shape, bool)
    invalid_mask[24:28, 4:9] = True
    workspace.current.set_invalid_mask(invalid_mask, "MarkInvalid")
    workspace.current.set_ground_truth(np.full(document.labels.shape, 2.0, np.float32))
    run_all(window)
    workspace.set_note(window.workspace.entries[0], "Look at the corner.")
    workspace.current.look(Part.REGION, region=(slice(3, 20), slice(5, 30)))
    workspace.select([second])
    document.change_run(document.state.runs[0], note="the first")
    workspace.current.compare_runs(document.state.runs[:1])
    kept = document.state.runs[0]
    window.feature(RunsPanel).reveal()
    qtbot.waitUntil(lambda: kept.ground_truth_error is not None and kept.expected_error is not None)
    return document


def test_all_work_comes_back_in_another_window(opened, another, qtbot, run_all, tmp_path):
    document = work_on(opened, qtbot, run_all)
    opened.views.transform.show(slice(10, 20), slice(10, 30))
    opened.views.sheet.set_layout("grid-difference")
    opened.views.set_content("depth-in", "ground_truth")
    assert opened.views.transform.place is not None
    path = tmp_path / "room.ilf"
    assert (opened.isWindowModified(), document.unsaved_summary()) == (True, "5 edits, 1 run")
    save(opened, qtbot, path)
    opened.refresh.now()
    assert (document.unsaved, opened.project.present.unsaved, opened.isWindowModified()) == (False, False, False)
    assert opened.windowTitle().startswith("room — two-planes[*]")
    before = document.snapshot()

    window = another()
    open_project(window, qtbot, path)
    again = window.workspace.current
    assert_same(again.snapshot(), before)
    assert (again.unsaved, window.project.present.unsaved, again.undo_stack.count()) == (False, False, 0)
    assert window.views.sheet.layout_name == "grid-difference"
    assert window.views.contents()["depth-in"] == "ground_truth"
    assert window.views.transform.place is None, "the whole frame"
    assert all(again.records_of(label) for label in again.valid_results()), "results have their curves"

    window.workspace.current.edit_info(2, "Rename", name="Floor")
    window.workspace.current.undo_stack.undo()
    assert not window.project.present.unsaved, "as it was saved"


def test_a_project_opens_moved_with_its_frames_and_embedded_alone_and_a_damaged_frame_is_left_aside(
    opened, another, qtbot, run_all, tmp_path
):
    document = work_on(opened, qtbot, run_all)
    before = document.snapshot()
    frame = Path(opened.workspace.entries[0].key)
    there = tmp_path / "there"
    there.mkdir()
    save(opened, qtbot, there / "alone.ilf", embed=True)
    save(opened, qtbot, tmp_path / "room.ilf", embed=False)
    moved = tmp_path / "moved"
    moved.mkdir()
    shutil.move(frame, moved / frame.name)
    shutil.move(tmp_path / "room.ilf", moved / "room.ilf")
    window = another()
    for path in (moved / "room.ilf", there / "alone.ilf"):
        open_project(window, qtbot, path)
        again = window.workspace.current.snapshot()
        assert_same(again.results, before.results)
        assert_same(again.runs[0].results, before.runs[0].results)
        assert_same(again.blocks.labels, before.blocks.labels)

    path = moved / "room.ilf"
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        arrays = [info for info in archive.infolist() if info.filename.startswith("arrays/")]
        packed = max(arrays, key=lambda info: info.file_size)
        before_saving = set(archive.namelist())
    begin = packed.header_offset + 260
    content[begin : begin + 10] = bytes(10)
    path.write_bytes(content)
    open_project(window, qtbot, path)
    (left_aside,) = window.workspace.entries
    assert window.workspace.shown is None
    assert left_aside.summary.problem
    answer(window, "Open &anew")
    qtbot.waitUntil(lambda: window.workspace.shown is not None and not window.loader.busy)
    assert left_aside.document is None
    assert len(window.workspace.entries) == 2, "the files are opened anew, beside the work"
    save(window, qtbot, path)
    with zipfile.ZipFile(path) as archive:
        assert before_saving < set(archive.namelist())
    assert content[begin - 60 : begin + 60] in path.read_bytes(), "what cannot be read is not thrown away"


def test_missing_files_are_asked_for_and_checked(window, another, qtbot, small_frame, tmp_path, monkeypatch):
    folders = [write_frame(tmp_path / name, small_frame) for name in ("a", "b", "c", "d")]
    for number, folder in enumerate(folders[:3]):  # files that differ
        for file in ("rgb.png", "depth.png"):
            (folder / file).write_bytes((folder / file).read_bytes() + bytes(number))
        open_frame(window, qtbot, folder)
        window.workspace.current.edit_info(1, "Rename", name=f"Wall {number}")
    window.workspace.add_entries([Entry.of(FrameRef(str(folders[3])))])
    path = tmp_path / "project" / "p.ilf"
    path.parent.mkdir()
    save(window, qtbot, path)
    (tmp_path / "away").mkdir()
    for number in (0, 1, 3):
        shutil.move(folders[number], tmp_path / "away" / folders[number].name)
    (folders[2] / "depth.png").write_bytes((folders[2] / "rgb.png").read_bytes())

    second = another()
    workspace, starts = second.workspace, []

    def fail(number: int) -> list[str]:
        """Open a frame that cannot be; what is offered."""
        second.loader.open_entry(workspace.entries[number])
        return offered()

    def offered() -> list[str]:
        qtbot.waitUntil(lambda: not second.loader.busy)
        return [button.text() for button in in_front(second, QMessageBox).buttons()]

    def press(button: str, place: Path | str) -> None:
        monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda _, *asked: starts.append(asked) or (str(place), ""))
        monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(place))
        answer(second, button)
        qtbot.waitUntil(lambda: not second.loader.busy)

    window.project.present.release()
    open_project(second, qtbot, path)
    assert offered() == ["Locate f&older…", "Locate &file…", "Open &anew", "Cancel"]
    answer(second, "Cancel")
    assert workspace.shown is None
    assert "Frames" in second.panels.open
    assert fail(1) == ["Locate f&older…", "Locate &file…", "Cancel"], "only what has changed can be opened anew"
    answer(second, "Cancel")
    for _ in range(2):  # what cannot be opened is kept as it was, and what is said of it
        save(second, qtbot, path)
    with read_project(path) as project:
        assert [frame.summary.stage for frame in project.project.frames] == [Stage.EXTRACTED] * 3 + [Stage.UNTOUCHED]

    fail(0)
    press("Locate &file…", "")
    assert starts == [("Locate rgb.png", str(tmp_path))], "from the nearest folder that is there"
    fail(0)
    press("Locate &file…", folders[2] / "rgb.png")
    assert "No file with the original content is there" in answer(second, "Cancel")
    assert second.project.present.words() == ""
    fail(0)
    press("Locate f&older…", tmp_path / "away")
    assert workspace.current.info(1).name == "Wall 0"
    assert second.project.present.words() == "paths of files"
    assert show(second, qtbot, 1).info(1).name == "Wall 1"
    assert show(second, qtbot, 3).name == "d"

    shutil.copy(tmp_path / "away" / "a" / "depth.png", folders[2] / "depth.png")
    fail(2)
    press("Open &anew", "")
    assert (len(workspace.entries), workspace.current) == (5, workspace.entries[4].document)
    save(second, qtbot, path)
    third = another()
    second.project.present.release()
    open_project(third, qtbot, path)
    for number in (0, 1, 3):
        show(third, qtbot, number)
    assert third.workspace.entries[3].source.rgb == str(tmp_path / "away" / "d"), "what was found stays found"


def test_a_folder_of_a_frame_is_found_under_another_name(opened, qtbot, small_frame, tmp_path, monkeypatch):
    folder, present = write_frame(tmp_path / "a", small_frame), tmp_path / "b"
    opened.workspace.add_entries([Entry.of(FrameRef(str(folder)))])
    folder.rename(present)
    entry = opened.workspace.entries[1]
    opened.loader.open_entry(entry)
    qtbot.waitUntil(lambda: not opened.loader.busy)
    monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_: str(present))
    answer(opened, "Locate f&older…")
    qtbot.waitUntil(lambda: not opened.loader.busy)
    assert (opened.workspace.current_entry, entry.source.rgb) == (entry, str(present))


def test_a_save_that_fails_leaves_file_and_mark_and_one_message(opened, qtbot, tmp_path, monkeypatch):
    path = tmp_path / "room.ilf"
    opened.workspace.current.edit_info(1, "Rename", name="Wall")
    save(opened, qtbot, path)
    before = path.read_bytes()
    opened.workspace.current.edit_info(1, "Rename", name="Floor")
    told: list[str] = []
    monkeypatch.setattr(opened.notes, "report", lambda what, error: told.append(f"{what}: {error}"))

    write = zipfile.ZipFile.writestr

    def full(archive: zipfile.ZipFile, *content: Any, **options: Any):
        if archive.filename is None:  # in memory
            return write(archive, *content, **options)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patched:
        patched.setattr("zipfile.ZipFile.writestr", full)
        opened.actions_["save_project"].trigger()
        qtbot.waitUntil(lambda: bool(told))
    assert told[0].endswith("the disk is full. Check the folder and the space there, or choose another one.")
    assert path.read_bytes() == before
    assert opened.workspace.current.unsaved_summary() == "1 edit"

    opened.project.discard_silently = False
    opened.close()
    dialog = opened.project.question
    shutil.rmtree(tmp_path / "gone", ignore_errors=True)
    with monkeypatch.context() as patched:
        patched.setattr("zipfile.ZipFile.writestr", full)
        dialog.save_button.click()
        qtbot.waitUntil(lambda: len(told) == 2)
    assert opened.isVisible(), "a save that fails cancels the closing"
    assert opened.project.question is None
    opened.actions_["save_project"].trigger()
    qtbot.waitUntil(lambda: not opened.project.present.unsaved)
    assert list(tmp_path.glob(".ilf-*")) == []


def test_what_is_saved_is_what_there_was_and_replaces_nothing_unasked(opened, another, qtbot, tmp_path, monkeypatch):
    workspace, done = opened.workspace, []
    workspace.current.edit_info(1, "Rename", name="Wall")
    opened.project.saving.save(tmp_path / "p.ilf", then=done.append)
    workspace.current.edit_info(1, "Rename", name="Floor")
    qtbot.waitUntil(lambda: bool(done))
    assert workspace.current.unsaved
    path = tmp_path / "p.ilf"
    with read_project(path) as project:
        assert project.state(workspace.entries[0].id).state.blocks.infos[1].name == "Wall"

    # somebody else writes it
    save(opened, qtbot, path)
    other = path.read_bytes() + b" "
    path.write_bytes(other)
    opened.workspace.current.edit_info(1, "Rename", name="Floor")
    opened.actions_["save_project"].trigger()
    assert "Another window or program has changed" in answer(opened, "Cancel")
    assert path.read_bytes() == other
    assert opened.workspace.current.unsaved
    opened.actions_["save_project"].trigger()
    answer(opened, "&Replace")
    qtbot.waitUntil(lambda: not opened.workspace.current.unsaved)
    assert path.read_bytes() != other

    # another window has it open
    told: list[str] = []
    monkeypatch.setattr(opened.notes, "warn", lambda what, notes, details="": told.extend(notes))
    before = path.read_bytes()
    opened.project.present.release()
    open_project(another(), qtbot, path)
    open_project(opened, qtbot, path)
    assert told == ["p.ilf is open in another window: Save will ask for another file."]
    opened.workspace.current.edit_info(1, "Rename", name="Wall")
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "other"), ""))
    opened.actions_["save_project"].trigger()
    answer(opened, "&Leave them out")
    qtbot.waitUntil(lambda: (tmp_path / "other.ilf").exists() and not opened.project.saving.busy)
    assert (path.read_bytes(), opened.project.present.path) == (before, tmp_path / "other.ilf")

    # it is of another schema
    _change_project(path, schema=99)
    before = path.read_bytes()
    monkeypatch.setattr(QMessageBox, "open", lambda box: told.append(box.text()))
    opened.documents.open_paths([path])
    qtbot.waitUntil(lambda: len(told) == 2)
    assert "p.ilf has schema 99" in told[1]
    assert (path.read_bytes(), opened.project.present.path) == (before, tmp_path / "other.ilf")


def _change_project(path: Path, **values: object):
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    parts["project.json"] = json.dumps({**json.loads(parts["project.json"]), **values}).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)


def test_closing_saves_discards_or_stays_frame_by_frame(opened, another, qtbot, small_frame, tmp_path, monkeypatch):
    path, workspace = tmp_path / "p.ilf", opened.workspace
    opened.project.discard_silently = False
    assert opened.project.question is None
    open_frame(opened, qtbot, write_frame(tmp_path / "second", small_frame))
    first, second = (entry.document for entry in workspace.entries)
    for document in (first, second):
        workspace.show(document)
        workspace.current.edit_info(1, "Rename", name="Wall")

    opened.close()
    dialog = opened.project.question
    item = dialog.frames.topLevelItem(0)
    assert [item.text(column) for column in range(2)] == ["two-planes", "1 edit"]
    dialog.reject()
    assert opened.isVisible()
    assert [first.unsaved, second.unsaved] == [True, True]

    opened.close()
    dialog = opened.project.question
    dialog.frames.topLevelItem(1).setCheckState(0, Qt.CheckState.Unchecked)
    assert dialog.save_button.text() == "&Save 1 of 2"
    told: list[str] = []
    monkeypatch.setattr(opened.notes, "warn", lambda what, notes, details="": told.extend(notes))
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    dialog.save_button.click()
    asked(opened, qtbot)
    answer(opened, "&Include them")
    qtbot.waitUntil(lambda: not opened.isVisible())
    assert told == []

    window = another()
    with zipfile.ZipFile(path) as archive:
        stages = [frame["summary"]["stage"] for frame in json.loads(archive.read("project.json"))["frames"]]
    assert stages == ["extracted", "untouched"], "the list says of a frame what the file holds"
    open_project(window, qtbot, path)
    names = []
    for entry in window.workspace.entries:
        names.append(show(window, qtbot, list(window.workspace.entries).index(entry)).info(1).name)
    assert names == ["Wall", "Block 1"], "what was not ticked is as it was before"
    window.project.discard_silently = False
    window.close()
    assert not window.isVisible(), "there is nothing to be asked"


def test_a_frame_that_is_closed_comes_back_as_it_was_saved(opened, qtbot, tmp_path):
    workspace, path = opened.workspace, tmp_path / "p.ilf"
    workspace.current.edit_info(1, "Rename", name="Wall")
    save(opened, qtbot, path)
    opened.project.discard_silently = False
    for button, name in (("save_button", "Floor"), ("discard_button", "Floor")):
        workspace.current.edit_info(1, "Rename", name="Floor" if button == "save_button" else "Ceiling")
        opened.actions_["close_frame"].trigger()
        dialog = opened.project.question
        getattr(dialog, button).click()
        qtbot.waitUntil(lambda: workspace.shown is None)
        entry = workspace.entries[0]
        assert (len(workspace.entries), entry.unsaved) == (1, False)
        assert show(opened, qtbot, 0).info(1).name == name
    assert not opened.project.present.unsaved

    workspace.current.edit_info(1, "Rename", name="Ceiling")
    opened.feature(FramesFeature).remove([workspace.entries[0]])
    assert "The work on two-planes is removed, too" in answer(opened, "Cancel")
    assert len(workspace.entries) == 1
    opened.actions_["new_project"].trigger()
    dialog = opened.project.question
    dialog.discard_button.click()
    qtbot.waitUntil(lambda: len(workspace.entries) == 0)
    assert opened.project.present.path is None
    open_project(opened, qtbot, path)
    assert workspace.current.info(1).name == "Floor"


@pytest.mark.parametrize("waits", [False, True])
def test_a_run_is_not_lost_when_the_window_closes(opened, qtbot, tmp_path, waits):
    workspace, path = opened.workspace, tmp_path / "p.ilf"
    save(opened, qtbot, path)
    first, second = list(workspace.current.counts())[:2]
    endless = 20_000 if waits else 100_000
    workspace.parameters.set(ilf.preset("paper", max_iterations=3))
    workspace.parameters.set_own(
        ilf.preset("released-code", max_iterations=endless).differences_from(workspace.parameters.current), [second]
    )
    opened.project.discard_silently = False
    opened.actions_["run_all"].trigger()
    qtbot.waitUntil(lambda: second in workspace.current.results.live and first in workspace.current.valid_results())
    opened.close()
    dialog = opened.project.question
    item = dialog.frames.topLevelItem(0)
    assert "a run is in progress" in item.text(1)
    dialog.wait.setChecked(waits)
    dialog.save_button.click()
    qtbot.waitUntil(lambda: not opened.isVisible())
    with read_project(path) as project:
        state = project.state(project.project.frames[0].id).state
    (kept,) = state.runs
    assert kept.how == ("finished" if waits else "cancelled")
    assert set(state.results) == ({first, second} if waits else {first})


def test_an_export_is_no_saving_opening_no_work_and_a_sweep_is_named(opened, qtbot, tmp_path):
    assert not opened.project.present.unsaved, "a frame that was opened and extracted is no work"
    opened.workspace.current.edit_info(1, "Rename", name="Wall")
    with qtbot.waitSignal(opened.feature(ExportFeature).requests.ended):
        opened.feature(ExportFeature).start(Export(tmp_path / "out", ExportOptions()))
    assert opened.project.present.unsaved
    opened.workspace.undo_group.undo()
    assert not opened.project.present.unsaved

    sweep = shown = opened.feature(SweepFeature)
    opened.workspace.parameters.set(ilf.preset("released-code", max_iterations=100_000))
    opened.workspace.current.note_saved(opened.workspace.current.stamp)
    sweep.open("max_iterations")
    shown.start()
    assert shown.busy
    opened.project.discard_silently = False
    opened.close()
    dialog = opened.project.question
    assert "A sweep of two-planes is in progress: it is stopped" in dialog.also.text()
    assert dialog.discard_button.text() == "&Stop"
    dialog.reject()
    assert shown.busy

    opened.close()
    question = opened.project.question
    shown.requests.cancel()
    qtbot.waitUntil(lambda: question.also.text() == "It has ended.")
    question.reject()
    opened.project.discard_silently = True


def test_an_error_after_writing_keeps_no_one_from_saving_and_closing(opened, qtbot, tmp_path, monkeypatch):
    path = tmp_path / "room.ilf"
    opened.workspace.current.edit_info(1, "Rename", name="Wall")
    save(opened, qtbot, path)
    opened.workspace.current.edit_info(1, "Rename", name="Floor")
    errors: list[Exception] = []
    with monkeypatch.context() as patched:
        patched.setattr(opened.recorder, "note_project", lambda: 1 / 0)
        patched.setattr(opened.notes, "report", lambda what, error: errors.append(error))
        opened.actions_["save_project"].trigger()
        qtbot.waitUntil(lambda: bool(errors))
    assert not opened.project.saving.busy
    opened.workspace.current.edit_info(1, "Rename", name="Ceiling")
    save(opened, qtbot, path)
    assert not opened.workspace.current.unsaved
