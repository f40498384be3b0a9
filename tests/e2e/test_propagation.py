"""Blocks go from frame to frame in the real window."""

import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from gui.features.blocks.feature import block_rows
from gui.features.blocks.table import BlockColumn
from gui.features.filter import FilterPanel
from gui.features.frame_list.feature import FramesFeature
from gui.features.propagation import PropagateDialog, PropagationFeature
from gui.features.quality import QualityPanel
from gui.features.sharing import Sharing, SharingPanel
from gui.state.document import Document
from gui.state.parts import Part
from gui.state.workspace import Entry
from ilf.data.blocks import Blocks
from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.sources.frame_ref import FrameRef
from ilf.sources.reading import read_frame

from ..gui.states import edit
from .conftest import open_frame, settle, write_frame

SHIFTS = 0, 0, 3, 6, 9


@pytest.fixture
def sequence(tmp_path, small_frame):
    """`small_frame` as a camera sees it that stands still at first and then moves to the left."""
    sources = []
    for number, shift in enumerate(SHIFTS):
        rgb, depth = (np.roll(picture, shift, axis=1) for picture in (small_frame.rgb, small_frame.depth))
        rgb[:, :shift], depth[:, :shift] = small_frame.rgb[:, :1], small_frame.depth[:, :1]
        folder = write_frame(tmp_path / f"frame-{number}", replace(small_frame, rgb=rgb, depth=depth))
        sources.append(FrameRef(str(folder)))
    return sources


@pytest.fixture
def listed(window, qtbot, sequence):
    """The window with the sequence in its list, the first frame open, and two blocks there."""
    window.workspace.add_entries([Entry.of(source) for source in sequence])
    open_frame(window, qtbot, sequence[0].rgb)
    labels = np.ones(window.workspace.current.labels.shape, np.int32)
    labels[:, 30:] = 2
    window.workspace.current.replace_blocks(labels, "Blocks of the test", {1: "Wall", 2: "Floor"})
    window.workspace.current.set_lock(1, True)
    return window


@pytest.fixture
def part(listed):
    return listed.feature(PropagationFeature)


def ended(part, qtbot, timeout=20_000):
    """Wait until blocks have been carried."""
    qtbot.waitUntil(lambda: part.run is None, timeout=timeout)


def propagate_state(window, part, qtbot, command: str) -> Document:
    """Give a command and wait until blocks have been carried; the frame that is shown then."""
    window.actions_[command].trigger()
    ended(part, qtbot)
    window.refresh.now()
    return window.workspace.current


def border(document) -> int:
    """The column in which the right one of the two blocks begins, in the middle of the frame."""
    return int(np.argmax(document.labels[24] == 2))


def test_next_frame_with_these_blocks(listed, part, qtbot):
    window, workspace = listed, listed.workspace
    first = workspace.current
    second = propagate_state(window, part, qtbot, "propagate_next")
    assert second.name == "frame-1"
    assert np.array_equal(second.labels, first.labels)
    assert [(info.name, info.locked) for info in second.blocks.infos.values()] == [("Wall", True), ("Floor", False)]
    assert "propagated to 1 frame (frame-1): 1 copied. 0 blocks to check." in window.notes.message
    assert not window.loader.busy  # nobody has extracted blocks that are not wanted
    third = propagate_state(window, part, qtbot, "propagate_next")
    assert abs(border(third) - (30 + SHIFTS[2])) <= 1
    assert "optical flow" in window.notes.message
    window.actions_["undo"].trigger()
    assert not third.counts()
    assert workspace.current is third

    third = propagate_state(window, part, qtbot, "propagate_previous")
    assert third.name == "frame-2"
    assert abs(border(third) - (30 + SHIFTS[2])) <= 1


def test_through_frames_that_keep_what_was_done_by_hand(listed, part, qtbot, sequence):
    window, workspace, entries = listed, listed.workspace, listed.workspace.entries
    first = workspace.current
    third = propagate_state(window, part, qtbot, "propagate_next") and propagate_state(
        window, part, qtbot, "propagate_next"
    )
    edit(workspace, 3, rows=np.s_[:8], columns=np.s_[50:])
    labels = third.labels.copy()
    workspace.show(first)
    (Path(sequence[3].rgb) / "depth.png").write_bytes(b"nothing")
    said: list[str] = []
    window.notes.warn = lambda what, notes, details="": said.extend(notes)

    window.actions_["propagate_through"].trigger()
    dialog = window.findChild(PropagateDialog)
    assert dialog.count.value() == 4
    assert dialog.how.currentData() == "auto"
    dialog.how.setCurrentIndex(dialog.how.findData("flow"))
    dialog.accept()
    ended(part, qtbot)
    window.refresh.now()
    assert part.how == "flow"
    assert workspace.current is first
    assert np.array_equal(third.labels, labels)
    last = entries[4].document
    assert last.labels[4, 62] == 3  # the frame that was edited is carried on from
    assert [entry.summary.stage for entry in entries][2:] == [Stage.EDITED, Stage.FAILED, Stage.PROPAGATED]
    assert len(said) == 1
    assert said[0].startswith("frame-3: ")
    assert "1 frame (frame-2) had been edited or run" in window.notes.message
    assert not part.strip.isVisible()


def test_a_typed_number_of_frames_replaces_the_proposed_one(listed):
    listed.actions_["propagate_through"].trigger()
    dialog = listed.findChild(PropagateDialog)
    QTest.keyClicks(dialog.count, "2")
    assert dialog.count.value() == 2
    listed.workspace.remove_entries([listed.workspace.current_entry])
    dialog.accept()  # from a frame that has gone meanwhile
    assert listed.feature(PropagationFeature).run is None


def test_blocks_edited_by_hand_are_carried_on_from_where_they_are_stored(listed, part, qtbot):
    window, workspace, entries = listed, listed.workspace, listed.workspace.entries
    first = workspace.current
    propagate_state(window, part, qtbot, "propagate_next")
    edit(workspace, 3, rows=np.s_[:8], columns=np.s_[50:])
    workspace.show(first)
    window.feature(FramesFeature).open_frames.max_open = 1
    window.feature(FramesFeature).open_frames.close_surplus()
    qtbot.waitUntil(lambda: entries[1].document is None)
    part.propagate_through(2)
    ended(part, qtbot)
    assert "propagated to 1 frame (frame-2)" in window.notes.message
    assert "1 frame (frame-1) had been edited or run" in window.notes.message
    assert entries[2].summary.blocks == 3
    assert entries[1].document is None  # nobody had to open it


def test_frames_that_are_done_are_not_kept_in_memory(listed, part, qtbot):
    part.propagate_through(4)
    run = part.run
    ended(part, qtbot)
    assert len(run.done) == 4
    told = {name: value for name, value in vars(run).items() if name != "present"}
    assert len(pickle.dumps(told)) < listed.workspace.current.labels.nbytes / 4


@pytest.mark.parametrize("by", ["button", "key"])
def test_it_can_be_stopped_and_says_how_far_it_is(listed, part, qtbot, monkeypatch, by):
    window, shown, take = listed, [], listed.workspace.take_propagated

    def stop():
        shown.append(part.label.text())
        if by == "button":
            part.work.cancel_button.click()
        else:
            window.actions_["cancel"].trigger()

    def take_and_stop(*given):
        take(*given)
        QTimer.singleShot(0, stop)

    monkeypatch.setattr(window.workspace, "take_propagated", take_and_stop)
    part.propagate_through(4)
    ended(part, qtbot)
    assert shown == ["Propagating blocks to frame-2 (2 of 4)"]
    assert "Stopped after 1 of 4 frames." in window.notes.message
    assert window.actions_["propagate_next"].isEnabled()
    assert not any(entry.summary.blocks for entry in list(window.workspace.entries)[2:])


def test_frames_that_are_taken_out_of_the_list_on_the_way_stay_out(listed, part, qtbot, monkeypatch):
    workspace, entries, take = listed.workspace, listed.workspace.entries, listed.workspace.take_propagated
    workspace.add_entries([Entry.of(FrameRef(f"/nowhere/{number}")) for number in range(1500)])

    def take_and_remove(*given):
        take(*given)
        workspace.remove_entries(list(entries)[2:])

    monkeypatch.setattr(workspace, "take_propagated", take_and_remove)
    part.propagate_through(1500)
    run = part.run
    ended(part, qtbot)
    assert run.done == ["frame-1"]
    assert (run.total, run.notes) == (1, [])
    assert len(entries) == 2


def test_what_cannot_be_read_of_a_frame_on_the_way_is_told(listed, part, qtbot):
    window, entry = listed, listed.workspace.entries[1]
    state = FrameState(
        entry.id, read_frame(entry.source), Blocks(np.zeros(window.workspace.current.labels.shape, np.int32))
    )
    damaged = SimpleNamespace(state=state, problems=("Its runs cannot be read.",))
    window.loader.store = SimpleNamespace(has=lambda id: True, state=lambda id: damaged)
    entry.has_state = True
    told: list[str] = []
    window.notes.warn = lambda what, problems: told.extend(problems)
    propagate_state(window, part, qtbot, "propagate_next")
    assert told == ["Its runs cannot be read."]


def test_what_needs_a_look_is_gone_through(listed, part, qtbot):
    window = listed
    document = propagate_state(window, part, qtbot, "propagate_next")
    document.change(to_check=frozenset({1, 2}))
    reasons = {1: "A half of it could not be seen before.", 2: "It was not in the picture before."}
    document.change_blocks(reasons=reasons)
    document.note(Part.INFOS)
    rows = block_rows(document, window.runs.current)
    assert [reasons[label] in rows[label][BlockColumn.NAME].hint for label in (1, 2)] == [True, True]
    edit(window.workspace, 0, rows=np.s_[40:44], columns=np.s_[50:54])
    assert document.state.to_check == {1}, "what is edited has been looked at"
    document.undo_stack.undo()
    document.replace_blocks(np.where(document.labels == 1, 4, 3).astype(np.int32), "Load blocks")
    assert (document.state.to_check, document.blocks.propagated_from) == (frozenset({1}), ""), "a locked block stays"
    document.undo_stack.undo()
    assert document.state.to_check == {1, 2}

    def said(command: str) -> str:
        window.actions_[command].trigger()
        settle(window, qtbot)
        return window.feature(QualityPanel).reason.text()

    assert "Floor was propagated: it was not in the picture before." in said("next_check")
    assert document.selected == [2]
    assert "Wall was propagated: a half of it" in said("ignore_check")
    assert document.state.to_check == {1}
    assert document.selected == [1]
    assert "was propagated" not in said("mark_checked")
    assert not document.state.to_check
    assert not window.actions_["mark_checked"].isEnabled()
    window.actions_["undo"].trigger()
    assert document.state.to_check == {1}
    assert "Wall was propagated" in said("next_check")
    assert window.feature(QualityPanel).remedy_button.text() == "Mark Wall as checked (Enter)"
    assert "was propagated" not in said("apply_remedy")
    assert not document.state.to_check


def test_values_for_all_frames_or_for_one(listed, part, qtbot):
    window, workspace, row = listed, listed.workspace, listed.feature(SharingPanel)
    first = workspace.current
    second = propagate_state(window, part, qtbot, "propagate_next")
    assert row.box.currentText() == Sharing.EACH
    row.choose(Sharing.ALL)
    assert window.notes.message == "All frames share the parameters of the filter now."
    window.feature(FilterPanel).set_values({"smoothness": 3.0})
    window.refresh.now()
    assert row.box.currentText() == Sharing.ALL
    assert not any(button.isVisible() for button in row.widget.findChildren(QToolButton))
    assert first.state.common.smoothness == 3.0
    assert window.actions_["undo"].text() == "Undo Set Smoothness for all frames"
    row.choose(Sharing.ALONE)
    window.feature(FilterPanel).set_values({"smoothness": 5.0})
    window.refresh.now()
    assert row.box.currentText() == Sharing.ALONE
    offered = [
        button.defaultAction().objectName() for button in row.widget.findChildren(QToolButton) if button.isVisible()
    ]
    assert offered == ["share_parameters", "reset_to_shared"], "only a frame with parameters of its own has them"
    assert (first.state.common.smoothness, second.state.common.smoothness) == (3.0, 5.0)
    assert window.actions_["undo"].text() == "Undo Set Smoothness"
    assert workspace.entries[1].summary.own_parameters
    third = propagate_state(window, part, qtbot, "propagate_next")  # the values of runs go along, as its own
    assert (third.state.common.smoothness, third.state.own_parameters) == (5.0, True)
    window.actions_["reset_to_shared"].trigger()
    assert (third.state.common.smoothness, third.state.own_parameters) == (3.0, False)
    window.actions_["undo"].trigger()
    assert (third.state.common.smoothness, third.state.own_parameters) == (5.0, True)
    workspace.show(first)
    window.refresh.now()
    assert row.box.currentText() == Sharing.ALL
