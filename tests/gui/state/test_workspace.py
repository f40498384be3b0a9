"""The window's state without widgets: sessions, frames, edits, and who is told of what."""

from __future__ import annotations

import numpy as np
import pytest
from pytestqt.qtbot import QtBot

from gui.state.blocks import KeptBlocks
from gui.state.results import BlockCounts, ErrorEstimate, FrameResults
from gui.state.session import LARGEST_LABEL, Session
from gui.state.workspace import Workspace
from ilf.data.blocks import Blocks
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.data.presets import preset
from ilf.data.results import BlockResult
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between

from ..states import QUICK, QUICK_OWN, edit, extraction, painted

# sessions


def test_counts_are_of_the_blocks_there_are(session: Session) -> None:
    known = session.frame.known
    left, right = session.labels == 1, session.labels == 2
    assert session.counts() == {
        1: BlockCounts(left.sum(), (left & known).sum()),
        2: BlockCounts(right.sum(), (right & known).sum()),
    }
    assert session.counts()[1].defect_rate == pytest.approx(144 / (48 * 30))
    assert BlockCounts(0, 0).defect_rate == 0.0
    session.set_labels(painted(session, 0, np.s_[:], np.s_[30:]))
    assert list(session.counts()) == [1], "0 is no block"


def test_a_block_under_a_point_of_the_image(session: Session) -> None:
    assert session.label_at(29.99, 47.99) == 1
    assert session.label_at(30.0, 0.0) == 2
    for x, y in ((-0.01, 5), (5, -0.01), (64.0, 5), (5, 48.0)):
        assert session.label_at(x, y) == 0


def test_infos_have_names_by_number_and_can_be_changed(session: Session) -> None:
    assert session.info(2).name == "Block 2"
    assert session.info(2).visible
    assert not session.info(2).locked
    session.change_info(2, name="Wall", locked=True)
    assert (session.info(2).name, session.locked, session.info(2).visible) == ("Wall", {2}, True)
    assert session.info(1).colour != session.info(2).colour


def test_the_next_label_is_one_that_no_block_has_or_had(session: Session) -> None:
    assert session.next_label() == 3
    session.info(7)
    assert session.next_label() == 8
    session.info(LARGEST_LABEL - 1)
    assert session.next_label() == LARGEST_LABEL
    session.info(LARGEST_LABEL)
    assert session.next_label() == 3, "the lowest that is free"
    free = LARGEST_LABEL - 1
    session.change_blocks(infos=dict.fromkeys(set(range(1, LARGEST_LABEL + 1)) - {free}, session.blocks.infos[free]))
    assert session.next_label() == LARGEST_LABEL - 1


def test_blocks_are_edited_unless_they_are_what_the_extraction_gave(session: Session, small_labels: np.ndarray) -> None:
    assert not session.blocks.edited
    session.set_labels(painted(session, 2))
    assert session.blocks.edited
    session.set_labels(small_labels)
    assert not session.blocks.edited
    session.change_blocks(kept=frozenset({1}))
    assert session.blocks.edited
    for parameters, by_hand in ((None, False), (BlockParameters(), True)):
        run = Run(
            session.frame, Blocks(small_labels, extraction=parameters, extracted=None if by_hand else small_labels)
        )
        assert Session.of(run, "origin", "key").blocks.edited


def test_blocks_made_by_hand_are_those_that_were_and_those_that_have_gained_pixels(session: Session) -> None:
    assert session.handmade() == set()
    session.set_labels(painted(session, 2))
    assert session.handmade() == {2}
    session.change_blocks(handmade=frozenset({1, 9}))
    assert session.handmade() == {1, 2}, "9 is gone"


def test_parameters_of_a_block_are_its_own_or_those_of_all(session: Session) -> None:
    session.change_blocks(own={2: QUICK_OWN})
    assert session.parameters_of(2) == QUICK
    assert session.parameters_of(1) == preset()


def test_results_count_as_long_as_the_block_has_the_very_pixels(session: Session, results: list[BlockResult]) -> None:
    assert session.completion() is None
    session.add_results(results[::-1])
    assert list(session.valid_results()) == [1, 2]
    completion = session.completion()
    assert completion is session.completion()
    assert completion.filled.any()
    before = session.labels.copy()
    for label, left in ((0, [2]), (2, [])):
        session.set_labels(painted(session, label))
        assert list(session.valid_results()) == left
        assert session.completion() is not completion
        session.set_labels(before)
        assert list(session.valid_results()) == [1, 2], "undo brings them back"
    elsewhere = painted(session, 1, np.s_[40:44], np.s_[60:64])
    session.set_labels(elsewhere)
    assert list(session.valid_results()) == [], "one has lost pixels, the other gained some outside its box"
    session.set_labels(before)
    kept = session.swap_results(FrameResults({}))
    assert session.completion() is None
    assert session.valid_results() == {}
    session.swap_results(kept)
    assert list(session.valid_results()) == [1, 2]


def test_what_is_unsaved(workspace: Workspace, session: Session, results: list[BlockResult]) -> None:
    assert not session.unsaved
    workspace.runs.store_results(session, results)
    assert session.unsaved
    early = session.stamp
    workspace.runs.store_results(session, results)
    workspace.frames.note_saved(session, early)
    assert session.unsaved, "more has come since"
    workspace.frames.note_saved(session, session.stamp)
    assert not session.unsaved

    edit(workspace, 2)
    assert session.unsaved
    state = session.stamp
    workspace.frames.note_saved(session, state)
    assert not session.unsaved
    session.undo_stack.undo()
    assert session.unsaved
    session.undo_stack.redo()
    assert not session.unsaved
    state = session.stamp
    edit(workspace, 2, columns=np.s_[8:12])
    workspace.frames.note_saved(session, state)
    assert session.unsaved, "what was saved is not what there is"


# results while a run goes on


def test_records_and_previews_of_a_run(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    first, second = results
    assert session.records_of(1) == ()
    workspace.runs.add_records(session, 1, first.history[:1])
    workspace.runs.add_records(session, 2, second.history[:1])
    workspace.runs.add_records(session, 1, first.history[1:])
    assert session.results.running == [1, 2]
    assert session.records_of(1) == list(first.history)
    assert session.current_depth() is None

    workspace.runs.add_previews(session, [(first.block, first.depth + 1), (second.block, second.depth + 1)])
    depth = session.current_depth()
    np.testing.assert_array_equal(depth[first.block.box][first.block.mask], first.depth + 1)
    assert told == ["runs.records_added"] * 3 + ["runs.previews_changed"]
    told.clear()

    workspace.runs.store_results(session, [first])
    assert told == ["runs.results_added"]
    assert session.results.running == [2]
    assert session.records_of(1) == first.history
    depth = session.current_depth()
    np.testing.assert_array_equal(depth[first.block.box][first.block.mask], first.depth)
    np.testing.assert_array_equal(depth[second.block.box][second.block.mask], second.depth + 1)
    workspace.runs.add_previews(session, [(first.block, first.depth + 9)])
    assert list(session.results.previews) == [2], "what has ended shows its result"

    told.clear()
    workspace.runs.end(session, keep_previews=True)
    assert (session.results.running, list(session.results.previews), told) == ([], [2], ["runs.results_changed"])
    workspace.runs.end(session)
    assert not session.results.previews
    np.testing.assert_array_equal(session.current_depth(), session.completion().depth)


def test_of_other_frames_only_the_list_is_told(
    workspace: Workspace, other: Session, results: list[BlockResult], told: list[str]
) -> None:
    workspace.runs.add_records(other, 1, results[0].history)
    workspace.runs.add_previews(other, [(results[0].block, results[0].depth)])
    assert told == []
    workspace.runs.store_results(other, results)
    workspace.runs.end(other)
    assert told == ["frames.sessions_changed"] * 2
    workspace.runs.store_error_estimate(
        other,
        other.completion(),
        ErrorEstimate(np.ones(other.frame.shape, np.float32), np.zeros(other.frame.shape, bool)),
    )
    assert told == ["frames.sessions_changed"] * 2
    assert other.expected_error() is not None


def test_an_expected_error_is_that_of_the_present_completion(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    doubt = ErrorEstimate(np.ones(session.frame.shape, np.float32), np.zeros(session.frame.shape, bool))
    session.add_results(results[:1])
    early = session.completion()
    session.add_results(results[1:])
    workspace.runs.store_error_estimate(session, early, doubt)
    assert (session.expected_error(), session.unsupported(), told) == (None, None, [])
    workspace.runs.store_error_estimate(session, session.completion(), doubt)
    assert session.expected_error() is doubt.error
    assert session.unsupported() is doubt.unsupported
    assert told == ["runs.error_changed"]
    edit(workspace, 2)
    assert session.expected_error() is None
    told.clear()
    workspace.runs.clear_results()
    assert told == ["runs.results_changed"]


# frames


def test_opening_showing_and_closing_frames(
    workspace: Workspace, session: Session, other: Session, told: list[str]
) -> None:
    assert workspace.session is session
    assert workspace.frames.is_current(session)
    assert not workspace.frames.is_current(other)
    assert workspace.frames.session_of("other key") is other
    assert workspace.frames.session_of("unknown") is None
    workspace.frames.show(session)
    assert told == []
    workspace.frames.show(other)
    assert told == ["blocks.about_to_change", "frames.session_changed"]
    assert workspace.undo_group.activeStack() is other.undo_stack
    workspace.frames.close(session)
    assert workspace.session is other, "another than the present one was closed"
    workspace.frames.close(other)
    assert not workspace.has_session
    assert workspace.blocks.chosen == 0
    assert workspace.undo_group.stacks() == [workspace.undo_group.activeStack()] or not workspace.undo_group.stacks()
    with pytest.raises(RuntimeError, match="no frame"):
        _ = workspace.session


def test_the_frame_before_a_closed_one_is_shown(
    workspace: Workspace, session: Session, other: Session, small_frame: RGBDFrame
) -> None:
    third = Session.of(Run(small_frame, other.labels), "third", "third")
    workspace.add_session(third)
    workspace.frames.show(session)
    workspace.frames.close(session)
    assert workspace.session is other
    workspace.frames.close(other)
    assert workspace.session is third, "of the first one, the one that is then first"


def test_parameters_of_a_recorded_run(small_frame: RGBDFrame, small_labels: np.ndarray, session: Session) -> None:
    """They are its frame's, whatever other frames have."""
    labels = small_labels.copy()
    labels[:5] = 3
    blocks = Blocks(labels, extraction=BlockParameters(granularity=0.9)).with_parameters({3: preset()}, QUICK)
    run = Run(small_frame, blocks, QUICK)
    recorded, alone = Session.of(run, "run.json", "run.json"), Workspace()
    alone.add_session(recorded, run)
    assert alone.parameters.current == QUICK
    assert recorded.parameters_of(3) == preset()
    assert list(recorded.blocks.own) == [3]
    assert recorded.selected == []
    assert alone.parameters.extraction.granularity == 0.9

    run = Run(small_frame, labels, QUICK, only=frozenset({2, 3}))
    second, beside = Session.of(run, "run.json", "run.json"), Workspace()
    beside.add_session(session)
    beside.add_session(second, run)
    assert (beside.parameters.current, session.state.common) == (QUICK, preset())
    assert second.blocks.own == {}
    assert second.selected == [2, 3], "the blocks that were run"
    assert beside.parameters.extraction == BlockParameters()


def test_what_a_run_is_made_of(session: Session, results: list[BlockResult]) -> None:
    session.change_blocks(own={2: {"smoothness": 2.0}, 9: {"smoothness": 3.0}})
    run = session.run(preset(), [1])
    assert (run.parameters, dict(run.blocks.own), run.only) == (preset(), {2: {"smoothness": 2.0}}, [1])
    assert (run.blocks.extraction, run.blocks.edited, run.extrapolate) == (BlockParameters(), False, False)
    np.testing.assert_array_equal(run.blocks.labels, session.labels)
    session.set_labels(painted(session, 2))
    assert session.run(QUICK).blocks.edited
    assert session.run(QUICK).only is None
    assert run.blocks.labels[0, 0] == 1, "a run keeps the blocks that it was made with"


# edits


def test_edits_can_be_undone_and_each_is_said_once(workspace: Workspace, session: Session, told: list[str]) -> None:
    before = session.labels.copy()
    assert edit(workspace, 2)
    assert told == ["blocks.about_to_change", "blocks.labels_changed", "runs.results_changed"]
    assert (session.labels[0:4, 0:5] == 2).all()
    assert session.undo_stack.undoText() == "Edit"
    told.clear()
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    assert told == ["blocks.about_to_change", "blocks.labels_changed", "runs.results_changed"]
    session.undo_stack.redo()
    assert (session.labels[0:4, 0:5] == 2).all()
    told.clear()
    assert not workspace.blocks.edit(None, "Nothing")
    assert told == []


def test_the_changed_box_is_told(workspace: Workspace, qtbot: QtBot) -> None:
    with qtbot.waitSignal(workspace.blocks.labels_changed) as signal:
        edit(workspace, 2, rows=np.s_[3:9], columns=np.s_[4:6])
    assert signal.args == [(slice(3, 9), slice(4, 6))]


def test_of_edits_of_other_frames_only_the_list_is_told(workspace: Workspace, other: Session, told: list[str]) -> None:
    workspace.frames.show(other)
    edit(workspace, 2)
    workspace.blocks.edit_info(1, "Rename", name="Floor")
    workspace.frames.show(workspace.frames.sessions[1])
    told.clear()
    other.undo_stack.undo()
    other.undo_stack.undo()
    assert set(told) == {"frames.sessions_changed"}
    assert other.labels[0, 0] == 1
    assert other.info(1).name == "Block 1"


def test_a_stroke_is_one_step(workspace: Workspace, session: Session, told: list[str]) -> None:
    before = session.labels.copy()
    workspace.blocks.stroke(None)
    assert not workspace.blocks.end_stroke("Paint")
    for column in (0, 4):
        workspace.blocks.stroke(patch_between(session.labels, painted(session, 2, columns=np.s_[column : column + 4])))
    assert told == ["blocks.stroke_changed"] * 2
    assert workspace.blocks.end_stroke("Paint")
    assert session.undo_stack.count() == 1
    assert (session.labels[0:4, 0:8] == 2).all()
    assert told[2:] == ["blocks.labels_changed", "runs.results_changed"]
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    session.undo_stack.redo()
    assert (session.labels[0:4, 0:8] == 2).all()


def test_a_stroke_that_is_given_up_leaves_nothing(
    workspace: Workspace, session: Session, other: Session, told: list[str]
) -> None:
    before = session.labels.copy()
    assert not workspace.blocks.drop_stroke()
    workspace.blocks.stroke(patch_between(before, painted(session, 2)))
    assert workspace.blocks.drop_stroke()
    np.testing.assert_array_equal(session.labels, before)
    assert told == ["blocks.stroke_changed"] * 2
    assert not workspace.blocks.drop_stroke()
    workspace.blocks.stroke(patch_between(before, painted(session, 2)))
    workspace.frames.show(other)
    np.testing.assert_array_equal(session.labels, before, "leaving the frame gives the stroke up")
    assert session.undo_stack.count() == 0


def test_names_and_locks_are_undoable_and_visibility_is_not(
    workspace: Workspace, session: Session, told: list[str]
) -> None:
    workspace.blocks.edit_info(1, "Rename block", name="Floor")
    workspace.blocks.set_lock(1, True)
    assert session.undo_stack.undoText() == "Lock Floor"
    assert session.locked == {1}
    workspace.blocks.set_lock(1, False)
    assert session.undo_stack.undoText() == "Unlock Floor"
    workspace.blocks.set_visible(2, False)
    assert told == ["blocks.infos_changed"] * 4
    assert session.undo_stack.count() == 3
    for _ in range(3):
        session.undo_stack.undo()
    assert session.info(1).name == "Block 1"
    assert not session.info(2).visible


def test_chosen_blocks(workspace: Workspace, session: Session, told: list[str]) -> None:
    assert workspace.blocks.chosen == 0
    workspace.blocks.select([2, 1])
    assert workspace.blocks.chosen == 2
    workspace.blocks.select([2, 1])
    assert told == ["blocks.selection_changed"]
    Workspace().blocks.select([1])


def test_a_chosen_block_that_is_gone_is_chosen_no_more(workspace: Workspace, session: Session) -> None:
    session.info(2)
    workspace.blocks.select([2, 1])
    edit(workspace, 1, rows=np.s_[:], columns=np.s_[:])
    assert session.selected == [1]
    new = workspace.blocks.start()
    assert (new, session.selected) == (3, [3])
    edit(workspace, 0)
    assert session.selected == [3], "it has never been there"


# extraction


def test_a_new_extraction_flows_around_what_stays(workspace: Workspace, session: Session, told: list[str]) -> None:
    session.change_info(1, name="Floor", locked=True)
    session.change_blocks(own={1: QUICK_OWN, 2: QUICK_OWN})
    used = BlockParameters(granularity=0.2)
    fresh = np.full(session.frame.shape, 7, np.int32)
    fresh[:24] = 5
    before = session.labels.copy()
    assert workspace.blocks.set_extracted(session, extraction(session, fresh), used) == KeptBlocks(1, 0, False)
    np.testing.assert_array_equal(session.labels == 1, before == 1)
    assert len(session.counts()) == 3
    assert session.undo_stack.undoText() == "Extract blocks"
    assert session.blocks.extraction == used
    assert session.blocks.edited, "one block was kept"
    assert session.blocks.kept == {1}
    assert session.handmade() == set(), "a block that only was locked is not made by hand"
    assert session.info(1).name == "Floor"
    assert session.blocks.own == {1: QUICK_OWN}
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    assert session.blocks.own == {1: QUICK_OWN, 2: QUICK_OWN}
    assert session.blocks.extraction == BlockParameters()


def test_blocks_made_by_hand_stay_unless_they_shall_not(
    workspace: Workspace, session: Session, told: list[str]
) -> None:
    edit(workspace, 3)
    assert workspace.blocks.staying(session) == (frozenset(), {3})
    session.change_info(3, locked=True)
    session.change_info(8, locked=True)
    assert workspace.blocks.staying(session) == ({3}, frozenset()), "8 is not there"
    session.change_info(3, locked=False)
    told.clear()
    workspace.parameters.set_keeps_handmade(False)
    assert told == ["parameters.extraction_changed"]
    assert workspace.blocks.staying(session) == (frozenset(), frozenset())
    workspace.parameters.set_keeps_handmade(True)
    fresh = np.ones(session.frame.shape, np.int32)
    assert workspace.blocks.set_extracted(session, extraction(session, fresh), BlockParameters()) == KeptBlocks(
        0, 1, False
    )
    assert session.handmade() == {3}
    workspace.blocks.set_lock(3, True)
    for label in set(session.counts()) - {3}:
        session.set_labels(np.where(session.labels == label, 0, session.labels))
    assert workspace.blocks.set_extracted(session, extraction(session, session.labels), BlockParameters()).all_of_them


def test_the_same_blocks_again_are_no_step_but_their_notes_are(workspace: Workspace, session: Session) -> None:
    session.change_info(1, name="Floor")
    session.change_blocks(own={2: QUICK_OWN})
    used = BlockParameters(granularity=0.1)
    workspace.blocks.set_extracted(session, extraction(session, session.labels), used)
    assert session.undo_stack.count() == 0
    assert session.blocks.extraction == used
    assert (session.info(1).name, session.blocks.own) == ("Floor", {2: QUICK_OWN})


def test_loaded_blocks_leave_locked_ones_alone(workspace: Workspace, session: Session) -> None:
    session.change_info(2, locked=True)
    before = session.labels.copy()
    workspace.blocks.replace(np.full(session.frame.shape, 9, np.int32), "Load blocks")
    np.testing.assert_array_equal(session.labels == 2, before == 2)
    assert len(session.counts()) == 2
    assert session.blocks.extraction is None
    assert session.blocks.edited
    assert session.undo_stack.undoText() == "Load blocks"


def test_loaded_blocks_bring_their_names_also_where_locked_ones_have_their_numbers(
    workspace: Workspace, session: Session
) -> None:
    session.change_info(2, name="Mine", locked=True)
    before = session.labels.copy()
    loaded = np.where(before == 2, 7, 2).astype(np.int32)
    loaded[:1][before[:1] != 2] = 1
    workspace.blocks.replace(loaded, "Load blocks", {1: "Wall", 2: "Floor", 7: "Under the locked one"})
    names = {label: session.info(label).name for label in session.counts()}
    assert names.pop(2) == "Mine"
    assert sorted(names.values()) == ["Floor", "Wall"]
    floor = next(label for label, name in names.items() if name == "Floor")
    np.testing.assert_array_equal(session.labels == floor, loaded == 2)
    workspace.undo_group.undo()
    assert session.info(1).name == "Block 1"


def test_the_same_blocks_with_other_names_are_one_step(workspace: Workspace, session: Session) -> None:
    workspace.blocks.replace(session.labels.copy(), "Load blocks", {1: "Wall", 2: "Block 2"})
    assert session.info(1).name == "Wall"
    assert session.undo_stack.count() == 1
    workspace.undo_group.undo()
    assert session.info(1).name == "Block 1"
