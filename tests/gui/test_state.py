"""The window's state without widgets: sessions, results, commands, and who is told of what."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QObject
from pytestqt.qtbot import QtBot

from gui.state.commands import DRAG_S
from gui.state.own_values import own_values
from gui.state.results import Held
from gui.state.session import LARGEST_LABEL, Session
from gui.state.tally import BlockCounts
from gui.state.workspace import Kept, Workspace
from ilf.completion import complete
from ilf.ebs import Extraction, extract
from ilf.ebs.edit import patch_between
from ilf.errors import InputError
from ilf.frame import RGBDFrame
from ilf.outcomes import BlockResult, compose
from ilf.parameters import BlockParameters, preset
from ilf.run import Run

QUICK = preset("paper", max_iterations=2)
QUICK_OWN = own_values(QUICK, preset())
SIGNALS = (
    *("about_to_change", "sessions_changed", "session_changed", "labels_changed", "stroke_changed", "infos_changed"),
    *("results_changed", "results_added", "records_added", "previews_changed", "error_changed", "selection_changed"),
    *("parameters_changed", "extraction_changed", "distrusted_changed"),
)


@pytest.fixture
def session(small_frame: RGBDFrame, small_labels: np.ndarray, qapp: QObject) -> Session:
    """`small_frame` with its two blocks, as an extraction gave them."""
    return Session.of(Run(small_frame, small_labels, extraction=BlockParameters()), "origin", "key")


@pytest.fixture
def other(small_frame: RGBDFrame, small_labels: np.ndarray, qapp: QObject) -> Session:
    """Another frame, of the same pixels."""
    return Session.of(Run(small_frame, small_labels, extraction=BlockParameters()), "other origin", "other key")


@pytest.fixture
def workspace(session: Session, other: Session) -> Workspace:
    """Both frames, the first the present one."""
    workspace = Workspace()
    workspace.add_session(other)
    workspace.add_session(session)
    return workspace


@pytest.fixture
def told(workspace: Workspace) -> list[str]:
    """Names of the signals that the workspace sends from now on."""
    names: list[str] = []
    for name in SIGNALS:
        getattr(workspace, name).connect(lambda *_, name=name: names.append(name))
    return names


@pytest.fixture
def results(session: Session) -> list[BlockResult]:
    """What a short run of both blocks gives."""
    return list(complete(session.frame, session.labels, QUICK).results.values())


def painted(session: Session, label: int, rows: slice = np.s_[0:4], columns: slice = np.s_[0:5]) -> np.ndarray:
    """The label map with a box of another label."""
    labels = session.labels.copy()
    labels[rows, columns] = label
    return labels


def edit(workspace: Workspace, label: int, **box: slice) -> bool:
    labels = workspace.session.labels
    return workspace.edit_labels(patch_between(labels, painted(workspace.session, label, **box)), "Edit")


def extraction(session: Session, labels: np.ndarray) -> Extraction:
    """One that gives these blocks."""
    return replace(extract(session.frame), blocks=labels.copy())


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
    anything = session.infos.pop(LARGEST_LABEL - 1)
    session.infos.update(dict.fromkeys(set(range(3, LARGEST_LABEL + 1)) - {LARGEST_LABEL - 1}, anything))
    assert session.next_label() == LARGEST_LABEL - 1


def test_blocks_are_edited_unless_they_are_what_the_extraction_gave(session: Session, small_labels: np.ndarray) -> None:
    assert not session.edited
    session.set_labels(painted(session, 2))
    assert session.edited
    session.set_labels(small_labels)
    assert not session.edited
    session.notes.kept = frozenset({1})
    assert session.edited
    for parameters, by_hand in ((None, False), (BlockParameters(), True)):
        run = Run(session.frame, small_labels, extraction=parameters, edited=by_hand)
        assert Session.of(run, "origin", "key").edited


def test_blocks_made_by_hand_are_those_that_were_and_those_that_have_gained_pixels(session: Session) -> None:
    assert session.handmade() == set()
    session.set_labels(painted(session, 2))
    assert session.handmade() == {2}
    session.notes.handmade = frozenset({1, 9})
    assert session.handmade() == {1, 2}, "9 is gone"


def test_parameters_of_a_block_are_its_own_or_those_of_all(session: Session) -> None:
    session.notes.own[2] = QUICK_OWN
    assert session.parameters_of(2, preset()) == QUICK
    assert session.parameters_of(1, preset()) == preset()


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
    kept = session.swap_results(Held({}))
    assert session.completion() is None
    assert session.valid_results() == {}
    session.swap_results(kept)
    assert list(session.valid_results()) == [1, 2]


def test_what_is_unsaved(workspace: Workspace, session: Session, results: list[BlockResult]) -> None:
    assert not session.unsaved
    session.add_results(results)
    assert session.unsaved
    early = session.saving()
    session.add_results(results)
    workspace.note_saved(session, early)
    assert session.unsaved, "more has come since"
    workspace.note_saved(session, session.saving())
    assert not session.unsaved

    edit(workspace, 2)
    assert session.unsaved
    state = session.saving()
    workspace.note_saved(session, state)
    assert not session.unsaved
    session.undo_stack.undo()
    assert session.unsaved
    session.undo_stack.redo()
    assert not session.unsaved
    state = session.saving()
    edit(workspace, 2, columns=np.s_[8:12])
    workspace.note_saved(session, state)
    assert session.unsaved, "what was exported is not what there is"


# results while a run goes on


def test_records_and_previews_of_a_run(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    first, second = results
    assert session.records_of(1) == ()
    workspace.add_records(session, 1, first.history[:1])
    workspace.add_records(session, 2, second.history[:1])
    workspace.add_records(session, 1, first.history[1:])
    assert session.results.running == [1, 2]
    assert session.records_of(1) == list(first.history)
    assert session.present_depth() is None

    workspace.add_previews(session, [(first.block, first.depth + 1), (second.block, second.depth + 1)])
    depth = session.present_depth()
    np.testing.assert_array_equal(depth[first.block.box][first.block.mask], first.depth + 1)
    assert told == ["records_added"] * 3 + ["previews_changed"]
    told.clear()

    workspace.store_results(session, [first])
    assert told == ["results_added"]
    assert session.results.running == [2]
    assert session.records_of(1) == first.history
    depth = session.present_depth()
    np.testing.assert_array_equal(depth[first.block.box][first.block.mask], first.depth)
    np.testing.assert_array_equal(depth[second.block.box][second.block.mask], second.depth + 1)
    workspace.add_previews(session, [(first.block, first.depth + 9)])
    assert list(session.results.previews) == [2], "what has ended shows its result"

    told.clear()
    workspace.end_run(session, previews_stay=True)
    assert (session.results.running, list(session.results.previews), told) == ([], [2], ["results_changed"])
    workspace.end_run(session)
    assert not session.results.previews
    np.testing.assert_array_equal(session.present_depth(), session.completion().depth)


def test_of_other_frames_only_the_list_is_told(
    workspace: Workspace, other: Session, results: list[BlockResult], told: list[str]
) -> None:
    workspace.add_records(other, 1, results[0].history)
    workspace.add_previews(other, [(results[0].block, results[0].depth)])
    assert told == []
    workspace.store_results(other, results)
    workspace.end_run(other)
    assert told == ["sessions_changed"] * 2
    workspace.store_error(other, other.completion(), np.ones(other.frame.shape, np.float32))
    assert told == ["sessions_changed"] * 2
    assert other.expected_error() is not None


def test_an_expected_error_is_that_of_the_present_completion(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    error = np.ones(session.frame.shape, np.float32)
    session.add_results(results[:1])
    early = session.completion()
    session.add_results(results[1:])
    workspace.store_error(session, early, error)
    assert (session.expected_error(), told) == (None, [])
    workspace.store_error(session, session.completion(), error)
    assert session.expected_error() is error
    assert told == ["error_changed"]
    edit(workspace, 2)
    assert session.expected_error() is None
    told.clear()
    workspace.clear_results()
    assert told == ["results_changed"]


# frames


def test_opening_showing_and_closing_frames(
    workspace: Workspace, session: Session, other: Session, told: list[str]
) -> None:
    assert workspace.session is session
    assert workspace.is_present(session)
    assert not workspace.is_present(other)
    assert workspace.session_of("other key") is other
    assert workspace.session_of("unknown") is None
    workspace.show_session(session)
    assert told == []
    workspace.show_session(other)
    assert told == ["about_to_change", "session_changed"]
    assert workspace.undo_group.activeStack() is other.undo_stack
    workspace.close_session(session)
    assert workspace.session is other, "another than the present one was closed"
    workspace.close_session(other)
    assert not workspace.has_session
    assert workspace.chosen == 0
    assert workspace.undo_group.stacks() == [workspace.undo_group.activeStack()] or not workspace.undo_group.stacks()
    with pytest.raises(RuntimeError, match="no frame"):
        _ = workspace.session


def test_the_frame_before_a_closed_one_is_shown(
    workspace: Workspace, session: Session, other: Session, small_frame: RGBDFrame
) -> None:
    third = Session.of(Run(small_frame, other.labels), "third", "third")
    workspace.add_session(third)
    workspace.show_session(session)
    workspace.close_session(session)
    assert workspace.session is other
    workspace.close_session(other)
    assert workspace.session is third, "of the first one, the one that is then first"


def test_parameters_of_a_recorded_run(small_frame: RGBDFrame, small_labels: np.ndarray, session: Session) -> None:
    """They are those of all blocks where no other frame is open, else its own blocks' alone."""
    labels = small_labels.copy()
    labels[:5] = 3
    run = Run(small_frame, labels, QUICK, {3: preset()}, extraction=BlockParameters(granularity=0.9))
    recorded, alone = Session.of(run, "run.json", "run.json"), Workspace()
    alone.add_session(recorded, run)
    assert alone.parameters == QUICK
    assert recorded.parameters_of(3, QUICK) == preset()
    assert list(recorded.notes.own) == [3]
    assert recorded.selected == []
    assert alone.extraction_parameters.granularity == 0.9

    run = Run(small_frame, labels, QUICK, only=frozenset({2, 3}))
    second, beside = Session.of(run, "run.json", "run.json"), Workspace()
    beside.add_session(session)
    beside.add_session(second, run)
    assert beside.parameters == preset()
    assert second.notes.own == {2: QUICK_OWN, 3: QUICK_OWN}
    assert second.selected == [2, 3], "the blocks that were run"
    assert beside.extraction_parameters == BlockParameters()


def test_what_a_run_is_made_of(session: Session, results: list[BlockResult]) -> None:
    session.notes.own |= {2: {"smoothness": 2.0}, 9: {"smoothness": 3.0}}
    run = session.run(preset(), [1])
    assert (run.parameters, dict(run.own), run.only) == (preset(), {2: preset(smoothness=2.0)}, [1])
    assert (run.extraction, run.edited, run.dense) == (BlockParameters(), False, False)
    np.testing.assert_array_equal(run.blocks, session.labels)
    session.set_labels(painted(session, 2))
    assert session.run(QUICK).edited
    assert session.run(QUICK).only is None
    assert run.blocks[0, 0] == 1, "a run keeps the blocks that it was made with"


# edits


def test_edits_can_be_undone_and_each_is_said_once(workspace: Workspace, session: Session, told: list[str]) -> None:
    before = session.labels.copy()
    assert edit(workspace, 2)
    assert told == ["about_to_change", "labels_changed", "results_changed"]
    assert (session.labels[0:4, 0:5] == 2).all()
    assert session.undo_stack.undoText() == "Edit"
    told.clear()
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    assert told == ["about_to_change", "labels_changed", "results_changed"]
    session.undo_stack.redo()
    assert (session.labels[0:4, 0:5] == 2).all()
    told.clear()
    assert not workspace.edit_labels(None, "Nothing")
    assert told == []


def test_the_changed_box_is_told(workspace: Workspace, qtbot: QtBot) -> None:
    with qtbot.waitSignal(workspace.labels_changed) as signal:
        edit(workspace, 2, rows=np.s_[3:9], columns=np.s_[4:6])
    assert signal.args == [(slice(3, 9), slice(4, 6))]


def test_of_edits_of_other_frames_only_the_list_is_told(workspace: Workspace, other: Session, told: list[str]) -> None:
    workspace.show_session(other)
    edit(workspace, 2)
    workspace.edit_info(1, "Rename", name="Floor")
    workspace.show_session(workspace.sessions[1])
    told.clear()
    other.undo_stack.undo()
    other.undo_stack.undo()
    assert set(told) == {"sessions_changed"}
    assert other.labels[0, 0] == 1
    assert other.info(1).name == "Block 1"


def test_a_stroke_is_one_step(workspace: Workspace, session: Session, told: list[str]) -> None:
    before = session.labels.copy()
    workspace.stroke(None)
    assert not workspace.end_stroke("Paint")
    for column in (0, 4):
        workspace.stroke(patch_between(session.labels, painted(session, 2, columns=np.s_[column : column + 4])))
    assert told == ["stroke_changed"] * 2
    assert workspace.end_stroke("Paint")
    assert session.undo_stack.count() == 1
    assert (session.labels[0:4, 0:8] == 2).all()
    assert told[2:] == ["labels_changed", "results_changed"]
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    session.undo_stack.redo()
    assert (session.labels[0:4, 0:8] == 2).all()


def test_a_stroke_that_is_given_up_leaves_nothing(
    workspace: Workspace, session: Session, other: Session, told: list[str]
) -> None:
    before = session.labels.copy()
    assert not workspace.drop_stroke()
    workspace.stroke(patch_between(before, painted(session, 2)))
    assert workspace.drop_stroke()
    np.testing.assert_array_equal(session.labels, before)
    assert told == ["stroke_changed"] * 2
    assert not workspace.drop_stroke()
    workspace.stroke(patch_between(before, painted(session, 2)))
    workspace.show_session(other)
    np.testing.assert_array_equal(session.labels, before, "leaving the frame gives the stroke up")
    assert session.undo_stack.count() == 0


def test_names_and_locks_are_undoable_and_visibility_is_not(
    workspace: Workspace, session: Session, told: list[str]
) -> None:
    workspace.edit_info(1, "Rename block", name="Floor")
    workspace.set_lock(1, True)
    assert session.undo_stack.undoText() == "Lock Floor"
    assert session.locked == {1}
    workspace.set_lock(1, False)
    assert session.undo_stack.undoText() == "Unlock Floor"
    workspace.set_visible(2, False)
    assert told == ["infos_changed"] * 4
    assert session.undo_stack.count() == 3
    for _ in range(3):
        session.undo_stack.undo()
    assert session.info(1).name == "Block 1"
    assert not session.info(2).visible


def test_chosen_blocks(workspace: Workspace, session: Session, told: list[str]) -> None:
    assert workspace.chosen == 0
    workspace.select([2, 1])
    assert workspace.chosen == 2
    workspace.select([2, 1])
    assert told == ["selection_changed"]
    Workspace().select([1])


def test_a_chosen_block_that_is_gone_is_chosen_no_more(workspace: Workspace, session: Session) -> None:
    session.info(2)
    workspace.select([2, 1])
    edit(workspace, 1, rows=np.s_[:], columns=np.s_[:])
    assert session.selected == [1]
    new = workspace.start_block()
    assert (new, session.selected) == (3, [3])
    edit(workspace, 0)
    assert session.selected == [3], "it has never been there"


# extraction


def test_a_new_extraction_flows_around_what_stays(workspace: Workspace, session: Session, told: list[str]) -> None:
    session.change_info(1, name="Floor", locked=True)
    session.notes.own |= {1: QUICK_OWN, 2: QUICK_OWN}
    used = BlockParameters(granularity=0.2)
    fresh = np.full(session.frame.shape, 7, np.int32)
    fresh[:24] = 5
    before = session.labels.copy()
    assert workspace.set_extracted(session, extraction(session, fresh), used) == Kept(1, 0, False)
    np.testing.assert_array_equal(session.labels == 1, before == 1)
    assert len(session.counts()) == 3
    assert session.undo_stack.undoText() == "Extract blocks"
    assert session.notes.extraction == used
    assert session.edited, "one block was kept"
    assert session.notes.kept == {1}
    assert session.handmade() == set(), "a block that only was locked is not made by hand"
    assert session.info(1).name == "Floor"
    assert session.notes.own == {1: QUICK_OWN}
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.labels, before)
    assert session.notes.own == {1: QUICK_OWN, 2: QUICK_OWN}
    assert session.notes.extraction == BlockParameters()


def test_blocks_made_by_hand_stay_unless_they_shall_not(
    workspace: Workspace, session: Session, told: list[str]
) -> None:
    edit(workspace, 3)
    assert workspace.staying(session) == (frozenset(), {3})
    session.change_info(3, locked=True)
    session.change_info(8, locked=True)
    assert workspace.staying(session) == ({3}, frozenset()), "8 is not there"
    session.change_info(3, locked=False)
    told.clear()
    workspace.set_keeps_handmade(False)
    assert told == ["extraction_changed"]
    assert workspace.staying(session) == (frozenset(), frozenset())
    workspace.set_keeps_handmade(True)
    fresh = np.ones(session.frame.shape, np.int32)
    assert workspace.set_extracted(session, extraction(session, fresh), BlockParameters()) == Kept(0, 1, False)
    assert session.handmade() == {3}
    workspace.set_lock(3, True)
    for label in set(session.counts()) - {3}:
        session.set_labels(np.where(session.labels == label, 0, session.labels))
    assert workspace.set_extracted(session, extraction(session, session.labels), BlockParameters()).all_of_them


def test_the_same_blocks_again_are_no_step_but_their_notes_are(workspace: Workspace, session: Session) -> None:
    session.change_info(1, name="Floor")
    session.notes.own[2] = QUICK_OWN
    used = BlockParameters(granularity=0.1)
    workspace.set_extracted(session, extraction(session, session.labels), used)
    assert session.undo_stack.count() == 0
    assert session.notes.extraction == used
    assert (session.info(1).name, session.notes.own) == ("Floor", {2: QUICK_OWN})


def test_loaded_blocks_leave_locked_ones_alone(workspace: Workspace, session: Session) -> None:
    session.change_info(2, locked=True)
    before = session.labels.copy()
    workspace.replace_labels(np.full(session.frame.shape, 9, np.int32), "Load blocks")
    np.testing.assert_array_equal(session.labels == 2, before == 2)
    assert len(session.counts()) == 2
    assert session.notes.extraction is None
    assert session.edited
    assert session.undo_stack.undoText() == "Load blocks"


def test_loaded_blocks_bring_their_names_also_where_locked_ones_have_their_numbers(
    workspace: Workspace, session: Session
) -> None:
    session.change_info(2, name="Mine", locked=True)
    before = session.labels.copy()
    loaded = np.where(before == 2, 7, 2).astype(np.int32)
    loaded[:1][before[:1] != 2] = 1
    workspace.replace_labels(loaded, "Load blocks", {1: "Wall", 2: "Floor", 7: "Under the locked one"})
    names = {label: session.info(label).name for label in session.counts()}
    assert names.pop(2) == "Mine"
    assert sorted(names.values()) == ["Floor", "Wall"]
    floor = next(label for label, name in names.items() if name == "Floor")
    np.testing.assert_array_equal(session.labels == floor, loaded == 2)
    workspace.undo_group.undo()
    assert session.info(1).name == "Block 1"


def test_the_same_blocks_with_other_names_are_one_step(workspace: Workspace, session: Session) -> None:
    workspace.replace_labels(session.labels.copy(), "Load blocks", {1: "Wall", 2: "Block 2"})
    assert session.info(1).name == "Wall"
    assert session.undo_stack.count() == 1
    workspace.undo_group.undo()
    assert session.info(1).name == "Block 1"


# parameters


def test_parameters_of_all_blocks_and_of_some(workspace: Workspace, session: Session, told: list[str]) -> None:
    workspace.set_parameters(QUICK, 2)
    assert session.notes.own == {2: QUICK_OWN}
    assert workspace.parameters == preset()
    workspace.set_parameters(preset(), 2)
    assert session.notes.own == {}
    workspace.set_parameters(preset(), 1)
    assert told == ["parameters_changed"] * 2, "the last changed nothing"
    workspace.set_parameters(QUICK)
    assert workspace.parameters == QUICK
    told.clear()
    workspace.set_extraction_parameters(BlockParameters(dilation=4))
    assert workspace.extraction_parameters.dilation == 4
    assert told == ["extraction_changed"]


def test_own_values_stand_one_by_one_over_the_common_ones(workspace: Workspace, session: Session) -> None:
    workspace.set_own({"smoothness": 2.0}, [1, 2])
    workspace.set_own({"noise": 0.01}, [2])
    assert session.notes.own == {1: {"smoothness": 2.0}, 2: {"smoothness": 2.0, "noise": 0.01}}
    workspace.set_parameters(preset(slope_weight=0.5))
    assert session.parameters_of(2, workspace.parameters) == preset(slope_weight=0.5, smoothness=2.0, noise=0.01)
    workspace.set_own({"smoothness": 1.0}, [1])
    assert list(session.notes.own) == [2], "what is equal to the common value is none of its own"
    workspace.copy_own(2, [1])
    assert session.notes.own[1] == session.notes.own[2]
    workspace.reset_own([1, 2])
    assert session.notes.own == {}
    while session.undo_stack.canUndo():
        session.undo_stack.undo()
    assert (session.notes.own, workspace.parameters) == ({}, preset())
    while session.undo_stack.canRedo():
        session.undo_stack.redo()
    assert (session.notes.own, workspace.parameters) == ({}, preset(slope_weight=0.5))


def test_a_drag_of_a_value_is_one_step(workspace: Workspace, session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("gui.state.commands.time.monotonic", lambda: now)
    for value in (2.0, 3.0, 4.0):
        workspace.set_parameters(preset(smoothness=value))
        now += DRAG_S / 2
    assert (session.undo_stack.count(), session.unsaved) == (1, True)
    now += DRAG_S
    workspace.set_parameters(preset(smoothness=5.0))
    workspace.set_parameters(preset(smoothness=5.0, noise=0.1))
    texts = [session.undo_stack.text(i) for i in range(session.undo_stack.count())]
    assert texts == ["Set Smoothness", "Set Smoothness", "Set Noise"]
    session.undo_stack.setClean()
    workspace.set_parameters(preset(smoothness=5.0, noise=0.2))
    assert session.unsaved, "what is saved is not changed behind the user's back"
    for wanted in ((5.0, 0.1), (5.0, 0.0), (4.0, 0.0), (1.0, 0.0)):
        session.undo_stack.undo()
        assert (workspace.parameters.smoothness, workspace.parameters.noise) == wanted


def test_a_drag_of_own_values_goes_back_to_where_it_began(workspace: Workspace, session: Session) -> None:
    workspace.set_own({"smoothness": 2.0}, [1])
    session.undo_stack.setClean()
    for value in (3.0, 4.0, 5.0):
        workspace.set_own({"smoothness": value}, [1, 2])
    assert session.undo_stack.count() == 2
    session.undo_stack.undo()
    assert session.notes.own == {1: {"smoothness": 2.0}}
    session.undo_stack.redo()
    assert session.notes.own == {1: {"smoothness": 5.0}, 2: {"smoothness": 5.0}}


def test_results_of_the_parameters_that_undo_brings_back_come_back(workspace: Workspace, session: Session) -> None:
    first = list(complete(session.frame, session.labels, QUICK).results.values())
    workspace.set_parameters(QUICK)
    workspace.store_results(session, first)
    other = QUICK.replace(max_iterations=3)
    workspace.set_parameters(other, 1)
    assert session.changed_blocks() == [1]
    assert session.valid_results()[1] is first[0], "shown until there is another"
    second = complete(session.frame, session.labels, other).results[1]
    workspace.store_results(session, [second])
    assert session.changed_blocks() == []
    session.undo_stack.undo()
    assert (session.valid_results()[1], session.changed_blocks()) == (first[0], [])
    session.undo_stack.redo()
    assert session.valid_results()[1] is second


def test_clearing_results_can_be_undone(workspace: Workspace, session: Session, results: list[BlockResult]) -> None:
    workspace.clear_results()
    assert session.undo_stack.count() == 0, "there are none"
    workspace.store_results(session, results)
    depth = session.present_depth().copy()
    workspace.clear_results()
    assert (session.completion(), session.present_depth(), session.unsaved) == (None, None, True)
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.present_depth(), depth)
    assert list(session.completion().results.values()) == results


def test_what_has_been_run_since_results_were_cleared_stays_when_they_come_back(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    workspace.store_results(session, results)
    workspace.clear_results()
    newer = complete(session.frame, session.labels, QUICK.replace(max_iterations=3)).results[1]
    workspace.store_results(session, [newer])
    session.undo_stack.undo()
    assert session.valid_results() == {1: newer, 2: results[1]}
    session.undo_stack.redo()
    assert session.valid_results() == {}
    session.undo_stack.undo()
    assert session.valid_results() == {1: newer, 2: results[1]}


def test_the_depth_of_an_edited_block_stays_to_be_seen_as_stale(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    workspace.store_results(session, results)
    before = session.present_depth().copy()
    assert not session.stale.any()
    edit(workspace, 3)
    after = session.present_depth()
    assert not session.valid_results().keys() & {1, 3}
    np.testing.assert_array_equal(after, before)
    changed = np.isin(session.labels, (1, 3)) & np.isfinite(before)
    np.testing.assert_array_equal(session.stale, changed)
    assert session.update_depth() is None, "nothing has changed since"
    again = session.run(QUICK).complete().results
    workspace.store_results(session, [again[3]])
    session.update_depth()
    assert not session.stale[session.labels == 3].any()
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.present_depth(), before)
    assert not session.stale.any()
    session.undo_stack.redo()
    assert list(session.valid_results()) == [2, 3], "what has been solved since is not lost either"


def test_the_present_depth_is_that_of_the_completion_whatever_happens(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    """What is kept up to date box by box is what would be made anew."""
    random = np.random.default_rng(0)
    workspace.store_results(session, results)
    for _ in range(30):
        rows, columns = (sorted(random.choice(40, 2, replace=False)) for _ in range(2))
        edit(
            workspace, int(random.integers(0, 4)), rows=np.s_[rows[0] : rows[1]], columns=np.s_[columns[0] : columns[1]]
        )
        if random.random() < 0.5:
            wanted = session.changed_blocks()[:2]
            done = session.run(QUICK, wanted).complete()
            workspace.store_results(session, list(done.results.values()))
        for _ in range(random.integers(0, 3)):
            session.undo_stack.undo()
        fresh = compose(session.frame, session.valid_results())
        np.testing.assert_array_equal((session.completion() or fresh).depth, fresh.depth)
        shown = np.where(session.stale, fresh.depth, session.present_depth())
        np.testing.assert_array_equal(shown, fresh.depth)
        assert not np.isin(session.labels, [0, *session.valid_results()])[session.stale].any()
        session._tally, counts = None, session.counts()
        assert session.counts() == counts


def test_borders_that_come_by_an_edit_are_drawn_ones(workspace: Workspace, session: Session) -> None:
    assert session.run(QUICK).drawn is None
    edit(workspace, 3)
    drawn = session.run(QUICK).drawn
    np.testing.assert_array_equal(
        drawn[:6, :7],
        np.array(
            [[False] * 4 + [True] * 2 + [False]] * 3
            + [[True] * 5 + [True, False], [True] * 5 + [False] * 2, [False] * 7]
        ),
    )
    assert not drawn[:, 28:].any(), "extracted borders stay what they are"
    session.undo_stack.undo()
    assert session.run(QUICK).drawn is None
    session.undo_stack.redo()
    np.testing.assert_array_equal(session.run(QUICK).drawn, drawn)
    again = Session.of(session.run(QUICK), "run.json", "run.json")
    np.testing.assert_array_equal(again.run(QUICK).drawn, drawn)
    fresh = np.full(session.frame.shape, 7, np.int32)
    workspace.set_extracted(session, extraction(session, fresh), BlockParameters())
    kept = session.labels == 3
    np.testing.assert_array_equal(session.notes.drawn, drawn & kept)
    workspace.replace_labels(fresh, "Load blocks")
    assert session.run(QUICK).drawn is None


def test_depth_that_is_distrusted_is_missing_and_undo_brings_it_back(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    workspace.store_results(session, results)
    mask = np.zeros(session.frame.shape, bool)
    mask[30:40, 5:20] = True
    told.clear()
    assert workspace.set_distrusted(mask, "Distrust depth")
    assert not workspace.set_distrusted(mask.copy(), "Distrust depth")
    assert told == ["distrusted_changed", "results_changed"]
    assert np.isnan(session.frame.depth[mask]).all()
    assert session.counts()[1].known == (session.frame.known & (session.labels == 1)).sum()
    assert session.valid_results() == {}
    session.undo_stack.undo()
    assert session.frame.distrusted is None
    assert list(session.valid_results()) == [1, 2]
    with pytest.raises(InputError, match="nothing is left"):
        workspace.set_distrusted(np.ones_like(mask), "Distrust depth")
    assert session.frame.distrusted is None


def test_results_go_with_the_extraction_whose_edges_the_filter_saw(workspace: Workspace, session: Session) -> None:
    """Blocks that stay have the same pixels, but other edges: a run of them would not give the same result."""
    for label in (1, 2):
        workspace.set_lock(label, True)
    jumps, pieces = BlockParameters(depth_jump=0.5), BlockParameters(granularity=0.9)
    session.add_results(list(complete(session.frame, session.labels, preset()).results.values()))
    assert set(session.valid_results()) == {1, 2}
    found = extract(session.frame, pieces)
    workspace.set_extracted(session, found, pieces)
    assert set(session.valid_results()) == {1, 2}, "the edges are the same"
    workspace.set_extracted(session, found, jumps)
    assert session.valid_results() == {}
    assert session.completion() is None
    paper = complete(session.frame, session.labels, preset("paper", max_iterations=5), extraction=jumps)
    session.add_results(list(paper.results.values()))
    workspace.set_extracted(session, found, BlockParameters())
    assert set(session.valid_results()) == {1, 2}, "the pass band knows no edges"
