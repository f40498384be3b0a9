"""The work is in the autosave soon after every change, and in memory as long as that cannot be written."""

import shutil

import numpy as np
import pytest

from gui.project.store import WorkStore
from gui.state.document import Document
from ilf.errors import InputError
from ilf.project.project import Stage
from ilf.project.recovery import find_recoverable_work
from ilf.project.state_codec import Known, encode, frame_part, load_state
from ilf.segmentation.editing.patches import patch_between

from ..recording import Recording, assert_holds


@pytest.fixture(autouse=True)
def prompt_autosave(monkeypatch):
    """Changes are stored at once instead of after two seconds, and again what could not be."""
    monkeypatch.setattr("gui.project.recorder.AFTER_MS", 50)
    monkeypatch.setattr("gui.project.recorder._RETRY_MS", 100)


@pytest.fixture
def context(qtbot, tmp_path, small_frame, small_labels):
    context = Recording(tmp_path / "autosave", tmp_path / "aside", small_frame, small_labels)
    with qtbot.waitSignal(context.recorder.kept):
        pass
    yield context
    context.end()


def test_all_changes_are_kept_and_nothing_else(context, qtbot):
    one, two = context.documents
    for row in range(4):
        context.erase(one, row)
    context.erase(two, 10)
    context.workspace.current.edit_info(1, "Rename", name="wall")
    with qtbot.waitSignal(context.recorder.kept):
        pass
    context.erase(one, 20)
    context.workspace.remove_entries([context.workspace.entries.of(two.id)])
    with qtbot.waitSignal(context.recorder.kept):
        pass
    written = context.written()
    assert_holds(written, one)
    states = {name for name in written.names() if name.startswith("frames/")}
    assert states == {frame_part(one.id)}, "the other has been closed"
    arrays = {name for name in written.names() if name.startswith("arrays/")}
    known = Known()
    state = load_state(one.id, written, known=known).state
    assert arrays == encode(state, known).names, "those of former states are gone"
    assert written.header.unsaved
    written.discard()


def test_a_stroke_is_there_as_a_whole_or_not_at_all(context, qtbot):
    one, _ = context.documents
    context.workspace.show(one)
    before, labels = one.labels.copy(), one.labels.copy()
    labels[30] = 0
    context.workspace.current.stroke(patch_between(one.labels, labels))
    context.workspace.set_note(context.workspace.entries[0], "look")
    qtbot.wait(200)
    context.workspace.current.drop_stroke()
    with qtbot.waitSignal(context.recorder.kept):
        pass
    written = context.written()
    state = load_state(one.id, written).state
    written.discard()
    assert (state.note, np.array_equal(state.blocks.labels, before)) == ("look", True)


def test_what_is_put_away_is_read_as_it_was_left(context):
    one, _ = context.documents
    context.erase(one, 5)
    left = one.labels.copy()
    context.recorder.keep(one)
    context.workspace.unload(one)
    assert context.store.has(one.id)
    assert np.array_equal(context.store.state(one.id).state.blocks.labels, left)


def test_where_nothing_can_be_written_all_is_in_memory_until_it_can(context, qtbot):
    one, two = context.documents
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(two, 1)
    shutil.rmtree(context.folder)
    context.folder.write_text("in the way")
    with qtbot.waitSignal(context.recorder.failed) as failed:
        context.erase(one, 3)
    assert str(context.folder) in str(failed.args[0])
    settled: list[Exception | None] = []
    context.recorder.flush(settled.append)
    qtbot.waitUntil(lambda: bool(settled))
    assert settled == [None], "it can be saved to the project file"
    assert np.array_equal(context.store.state(one.id).state.blocks.labels, one.labels)
    context.folder.unlink()
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(one, 4)
    context.assert_written(one, two)


class _Project:
    """A project file that can be taken away."""

    def __init__(self, parts: dict[str, bytes]):
        self._parts = parts

    def names(self) -> list[str]:
        return list(self._parts)

    def read(self, name: str) -> bytes:
        if name not in self._parts:
            raise InputError(f"There is no part {name}.")
        return self._parts[name]


@pytest.mark.parametrize("goes", [False, True])
def test_what_is_in_the_project_file_is_in_the_autosave_too_once_a_frame_changes(context, qtbot, goes):
    one, _ = context.documents
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(one, 1)
    parts = {name: context.store.read(name) for name in context.store.names()}
    context.workspace.remove_entries([context.workspace.entries.of(one.id)])
    with qtbot.waitSignal(context.recorder.kept):
        pass
    context.store.project = _Project(parts)
    state = context.store.state(one.id).state
    assert frame_part(one.id) not in context.store.own_names()
    if goes:
        parts.clear()
    again = Document.of_state(state, None, "one")
    context.workspace.open_document(again, restored=True)
    with qtbot.waitSignal(context.recorder.kept):
        context.erase(again, 2)
    written = context.written()
    assert_holds(written, again)
    assert load_state(again.id, written).state.blocks.drawn is not None
    written.discard()


def test_parameters_that_were_for_all_frames_are_stored_with_each_when_they_are_not(context, qtbot):
    one, two = context.documents
    workspace = context.workspace
    workspace.show(one)
    former = two.state.common
    workspace.parameters.share()
    workspace.parameters.set(workspace.parameters.current.replace(max_iterations=7))
    _stored(context, qtbot)
    workspace.parameters.separate()
    _stored(context, qtbot)
    assert context.store.state(two.id).state.common == two.state.common == former.replace(max_iterations=7)
    assert two.unsaved
    while one.undo_stack.canUndo():
        one.undo_stack.undo()
    _stored(context, qtbot)
    assert context.store.state(two.id).state.common == two.state.common == former


def test_a_note_on_a_frame_that_is_put_away_is_among_what_is_left(context, qtbot):
    one, two = context.documents
    context.erase(two, 3)
    context.workspace.show(one)
    _stored(context, qtbot)
    entry = context.workspace.entries[1]
    context.workspace.unload(two)
    context.workspace.set_note(entry, "Look again.")
    _stored(context, qtbot)
    context.written().close()
    (left,) = find_recoverable_work(context.aside)
    left.release()
    assert {frame.id: frame.summary.note for frame in left.frames}[entry.id] == "Look again."


def test_what_is_left_says_how_far_the_work_on_a_frame_is(context, qtbot):
    one, two = context.documents
    _stored(context, qtbot)
    context.workspace.show(two)
    two.edit(patch_between(two.labels, np.zeros_like(two.labels)), "Erase all")
    _stored(context, qtbot)
    context.written().close()
    (left,) = find_recoverable_work(context.aside)
    left.release()
    stages = {frame.id: frame.summary.stage for frame in left.read.project.frames}
    assert stages == {one.id: Stage.EDITED, two.id: Stage.UNTOUCHED}


def _stored(context, qtbot):
    told: list[Exception | None] = []
    context.recorder.flush(told.append)
    qtbot.waitUntil(lambda: bool(told))
    assert told == [None]


def test_a_part_is_read_from_the_file_that_has_taken_the_others_place(tmp_path):
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
    assert store.read("arrays/1.png") == b"content"


def test_what_is_discarded_is_soon_out_of_the_autosave(context, qtbot):
    _, two = context.documents
    context.erase(two, 3)
    _stored(context, qtbot)
    with qtbot.waitSignal(context.recorder.kept):
        context.recorder.revert([two.id], lambda: context.workspace.unload(two))
    assert two not in context.workspace.open
    written = context.written()
    assert frame_part(two.id) not in written.names()
    written.discard()
