"""The work is in the journal soon after every change, and in memory as long as the journal cannot be written."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.project.store import WorkStore
from gui.work.loading import restore
from ilf.data.frame import RGBDFrame
from ilf.errors import InputError
from ilf.project.decoding import load_state
from ilf.project.encoding import frame_part
from ilf.project.journals import left_work
from ilf.segmentation.editing.patches import patch_between

from .recording import WAIT_MS, Recording, assert_holds


@pytest.fixture
def desk(qtbot: QtBot, tmp_path: Path, small_frame: RGBDFrame, small_labels: np.ndarray) -> Iterator[Recording]:
    desk = Recording(tmp_path / "autosave", tmp_path / "aside", small_frame, small_labels)
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        pass
    yield desk
    desk.end()


def test_all_changes_are_kept_and_nothing_else(desk: Recording, qtbot: QtBot) -> None:
    one, two = desk.sessions
    for row in range(4):
        desk.erase(one, row)
    desk.erase(two, 10)
    desk.workspace.edit_info(1, "Rename", name="wall")
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        pass
    desk.erase(one, 20)
    desk.workspace.close_session(two)
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        pass
    journal = desk.journal()
    assert_holds(journal, one)
    states = {name for name in journal.names() if name.startswith("frames/")}
    assert states == {frame_part(one.id)}, "the other has been closed"
    arrays = {name for name in journal.names() if name.startswith("arrays/")}
    assert arrays == load_state(one.id, journal).names, "those of former states are gone"
    assert journal.note.unsaved
    journal.discard()


def test_a_stroke_is_there_as_a_whole_or_not_at_all(desk: Recording, qtbot: QtBot) -> None:
    one, _ = desk.sessions
    desk.workspace.show_session(one)
    before, labels = one.labels.copy(), one.labels.copy()
    labels[30] = 0
    desk.workspace.stroke(patch_between(one.labels, labels))
    desk.workspace.set_note(desk.workspace.entries[0], "look")
    qtbot.wait(200)
    desk.workspace.drop_stroke()
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        pass
    journal = desk.journal()
    state = load_state(one.id, journal).state
    journal.discard()
    assert (state.note, np.array_equal(state.labels, before)) == ("look", True)


def test_what_is_put_away_is_read_as_it_was_left(desk: Recording) -> None:
    one, _ = desk.sessions
    desk.erase(one, 5)
    left = one.labels.copy()
    desk.recorder.keep(one)
    desk.workspace.put_away(one)
    assert desk.store.has(one.id)
    assert np.array_equal(desk.store.read(one.id).state.labels, left)


@pytest.mark.parametrize("readable", [True, False])
def test_where_the_journal_cannot_be_written_all_is_in_memory_until_it_can(
    desk: Recording, qtbot: QtBot, readable: bool
) -> None:
    one, two = desk.sessions
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        desk.erase(two, 1)
    if not readable:  # as on a drive that is pulled out
        desk.store._journal._database.close()
    shutil.rmtree(desk.folder)
    desk.folder.write_text("in the way")
    with qtbot.waitSignal(desk.recorder.failed, timeout=WAIT_MS) as failed:
        desk.erase(one, 3)
    assert str(desk.folder) in str(failed.args[0])
    settled: list[Exception | None] = []
    desk.recorder.settle(settled.append)
    qtbot.waitUntil(lambda: bool(settled), timeout=WAIT_MS)
    assert settled == [None], "it can be saved to the project file"
    for session in (one, two):
        assert np.array_equal(load_state(session.id, desk.store.parts).state.labels, session.labels)
    desk.folder.unlink()
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        desk.erase(one, 4)
    journal = desk.journal()
    assert_holds(journal, one)
    assert_holds(journal, two)
    journal.discard()


class _Project:
    """A project file that can be taken away."""

    def __init__(self, parts: dict[str, bytes]) -> None:
        self._parts = parts

    def names(self) -> list[str]:
        return list(self._parts)

    def read(self, name: str) -> bytes:
        if name not in self._parts:
            raise InputError(f"There is no part {name}.")
        return self._parts[name]


@pytest.mark.parametrize("goes", [False, True])
def test_what_is_in_the_project_file_is_in_the_journal_too_once_a_frame_changes(
    desk: Recording, qtbot: QtBot, goes: bool
) -> None:
    one, _ = desk.sessions
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        desk.erase(one, 1)
    parts = {name: desk.store.part(name) for name in desk.store.all_names()}
    desk.workspace.close_session(one)
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        pass
    desk.store.project = _Project(parts)
    state = desk.store.read(one.id).state
    assert desk.store.lacks(frame_part(one.id))
    if goes:
        parts.clear()
    again = restore(state, None, "one")
    desk.workspace.add_session(again, restored=True)
    with qtbot.waitSignal(desk.recorder.kept, timeout=WAIT_MS):
        desk.erase(again, 2)
    journal = desk.journal()
    assert_holds(journal, again)
    assert load_state(again.id, journal).state.notes.drawn is not None
    journal.discard()


def test_parameters_that_were_for_all_frames_are_stored_with_each_when_they_are_not(
    desk: Recording, qtbot: QtBot
) -> None:
    one, two = desk.sessions
    workspace = desk.workspace
    workspace.show_session(one)
    former = two.common
    workspace.share_parameters()
    workspace.set_parameters(workspace.parameters.replace(max_iterations=7))
    _stored(desk, qtbot)
    workspace.part_parameters()
    _stored(desk, qtbot)
    assert desk.store.read(two.id).state.common == two.common == former.replace(max_iterations=7)
    assert two.unsaved
    while one.undo_stack.canUndo():
        one.undo_stack.undo()
    _stored(desk, qtbot)
    assert desk.store.read(two.id).state.common == two.common == former


def test_a_note_on_a_frame_that_is_put_away_is_among_what_is_left(desk: Recording, qtbot: QtBot) -> None:
    one, two = desk.sessions
    desk.recorder.is_unsaved = lambda: True
    desk.erase(two, 3)
    desk.workspace.show_session(one)
    _stored(desk, qtbot)
    entry = desk.workspace.entries[1]
    desk.workspace.put_away(two)
    desk.workspace.set_note(entry, "Look again.")
    _stored(desk, qtbot)
    desk.journal().close()
    (left,) = left_work(desk.aside)
    left.release()
    assert {frame.id: frame.summary.note for frame in left.frames}[entry.id] == "Look again."


def _stored(desk: Recording, qtbot: QtBot) -> None:
    told: list[Exception | None] = []
    desk.recorder.settle(told.append)
    qtbot.waitUntil(lambda: bool(told), timeout=WAIT_MS)
    assert told == [None]


def test_a_part_is_read_from_the_file_that_has_taken_the_others_place(tmp_path: Path) -> None:
    class Replaced:
        """A project file that is closed as another one is saved, while it is read."""

        def names(self) -> set[str]:
            return {"arrays/1.png"}

        def read(self, name: str) -> bytes:
            store.project = Saved()
            raise InputError("It is closed.")

    class Saved(Replaced):
        def read(self, name: str) -> bytes:
            return b"content"

    store = WorkStore(tmp_path)
    store.project = Replaced()
    assert store.part("arrays/1.png") == b"content"


def test_what_is_discarded_is_soon_out_of_the_journal(desk: Recording, qtbot: QtBot) -> None:
    _, two = desk.sessions
    desk.erase(two, 3)
    _stored(desk, qtbot)
    desk.recorder.revert([two.id], lambda: desk.workspace.put_away(two))
    qtbot.waitUntil(lambda: two not in desk.workspace.sessions, timeout=WAIT_MS)
    qtbot.waitUntil(lambda: desk.store.is_written, timeout=WAIT_MS)
    journal = desk.journal()
    assert frame_part(two.id) not in journal.names()
    journal.discard()
