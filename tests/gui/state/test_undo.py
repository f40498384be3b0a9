"""What undo takes back and brings back beside pixels: parameters, results, drawn borders, distrusted depth."""

from __future__ import annotations

import numpy as np
import pytest

from gui.state.parameters import DRAG_S
from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.data.parameters import BlockParameters
from ilf.data.presets import preset
from ilf.data.results import BlockResult, compose
from ilf.errors import InputError
from ilf.run.run import complete
from ilf.segmentation.extraction import extract

from ..states import QUICK, QUICK_OWN, edit, extraction


def test_parameters_of_all_blocks_and_of_some(workspace: Workspace, session: Session, told: list[str]) -> None:
    workspace.parameters.set(QUICK, 2)
    assert session.blocks.own == {2: QUICK_OWN}
    assert workspace.parameters.current == preset()
    workspace.parameters.set(preset(), 2)
    assert session.blocks.own == {}
    workspace.parameters.set(preset(), 1)
    assert told == ["parameters.changed"] * 2, "the last changed nothing"
    workspace.parameters.set(QUICK)
    assert workspace.parameters.current == QUICK
    told.clear()
    workspace.parameters.set_extraction(BlockParameters(dilation=4))
    assert workspace.parameters.extraction.dilation == 4
    assert told == ["parameters.extraction_changed"]


def test_own_values_stand_one_by_one_over_the_common_ones(workspace: Workspace, session: Session) -> None:
    workspace.parameters.set_own({"smoothness": 2.0}, [1, 2])
    workspace.parameters.set_own({"noise": 0.01}, [2])
    assert session.blocks.own == {1: {"smoothness": 2.0}, 2: {"smoothness": 2.0, "noise": 0.01}}
    workspace.parameters.set(preset(slope_weight=0.5))
    assert session.parameters_of(2) == preset(slope_weight=0.5, smoothness=2.0, noise=0.01)
    workspace.parameters.set_own({"smoothness": 1.0}, [1])
    assert list(session.blocks.own) == [2], "what is equal to the common value is none of its own"
    workspace.parameters.copy_own(2, [1])
    assert session.blocks.own[1] == session.blocks.own[2]
    workspace.parameters.reset_own([1, 2])
    assert session.blocks.own == {}
    while session.undo_stack.canUndo():
        session.undo_stack.undo()
    assert (session.blocks.own, workspace.parameters.current) == ({}, preset())
    while session.undo_stack.canRedo():
        session.undo_stack.redo()
    assert (session.blocks.own, workspace.parameters.current) == ({}, preset(slope_weight=0.5))


def test_a_drag_of_a_value_is_one_step(workspace: Workspace, session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr("gui.state.parameters.time.monotonic", lambda: now)
    for value in (2.0, 3.0, 4.0):
        workspace.parameters.set(preset(smoothness=value))
        now += DRAG_S / 2
    assert (session.undo_stack.count(), session.unsaved) == (1, True)
    now += DRAG_S
    workspace.parameters.set(preset(smoothness=5.0))
    workspace.parameters.set(preset(smoothness=5.0, noise=0.1))
    texts = [session.undo_stack.text(i) for i in range(session.undo_stack.count())]
    assert texts == ["Set Smoothness", "Set Smoothness", "Set Noise"]
    session.undo_stack.setClean()
    workspace.parameters.set(preset(smoothness=5.0, noise=0.2))
    assert session.unsaved, "what is saved is not changed behind the user's back"
    for wanted in ((5.0, 0.1), (5.0, 0.0), (4.0, 0.0), (1.0, 0.0)):
        session.undo_stack.undo()
        assert (workspace.parameters.current.smoothness, workspace.parameters.current.noise) == wanted


def test_a_drag_of_own_values_goes_back_to_where_it_began(workspace: Workspace, session: Session) -> None:
    workspace.parameters.set_own({"smoothness": 2.0}, [1])
    session.undo_stack.setClean()
    for value in (3.0, 4.0, 5.0):
        workspace.parameters.set_own({"smoothness": value}, [1, 2])
    assert session.undo_stack.count() == 2
    session.undo_stack.undo()
    assert session.blocks.own == {1: {"smoothness": 2.0}}
    session.undo_stack.redo()
    assert session.blocks.own == {1: {"smoothness": 5.0}, 2: {"smoothness": 5.0}}


def test_results_of_the_parameters_that_undo_brings_back_come_back(
    workspace: Workspace, session: Session, told: list[str]
) -> None:
    first = list(complete(session.frame, session.labels, QUICK).results.values())
    workspace.parameters.set(QUICK)
    workspace.runs.store_results(session, first)
    other = QUICK.replace(max_iterations=3)
    workspace.parameters.set(other, 1)
    assert session.changed_blocks() == [1]
    assert session.valid_results()[1] is first[0], "shown until there is another"
    before = session.current_depth().copy()
    second = complete(session.frame, session.labels, other).results[1]
    workspace.runs.store_results(session, [second])
    assert session.changed_blocks() == []
    after = session.current_depth().copy()
    assert not np.array_equal(before, after, equal_nan=True)
    told.clear()
    session.undo_stack.undo()
    assert (session.valid_results()[1], session.changed_blocks()) == (first[0], [])
    assert "runs.results_changed" in told
    np.testing.assert_array_equal(session.current_depth(), before)
    session.undo_stack.redo()
    assert session.valid_results()[1] is second
    np.testing.assert_array_equal(session.current_depth(), after)


def test_clearing_results_can_be_undone(workspace: Workspace, session: Session, results: list[BlockResult]) -> None:
    workspace.runs.clear_results()
    assert session.undo_stack.count() == 0, "there are none"
    workspace.runs.store_results(session, results)
    depth = session.current_depth().copy()
    workspace.runs.clear_results()
    assert (session.completion(), session.current_depth(), session.unsaved) == (None, None, True)
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.current_depth(), depth)
    assert list(session.completion().results.values()) == results


def test_what_has_been_run_since_results_were_cleared_stays_when_they_come_back(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    workspace.runs.store_results(session, results)
    workspace.runs.clear_results()
    newer = complete(session.frame, session.labels, QUICK.replace(max_iterations=3)).results[1]
    workspace.runs.store_results(session, [newer])
    session.undo_stack.undo()
    assert session.valid_results() == {1: newer, 2: results[1]}
    session.undo_stack.redo()
    assert session.valid_results() == {}
    session.undo_stack.undo()
    assert session.valid_results() == {1: newer, 2: results[1]}


def test_the_depth_of_an_edited_block_stays_to_be_seen_as_stale(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    workspace.parameters.set(QUICK)
    workspace.runs.store_results(session, results)
    before = session.current_depth().copy()
    assert not session.stale.any()
    edit(workspace, 3)
    after = session.current_depth()
    assert not session.valid_results().keys() & {1, 3}
    np.testing.assert_array_equal(after, before)
    changed = np.isin(session.labels, (1, 3)) & np.isfinite(before)
    np.testing.assert_array_equal(session.stale, changed)
    assert session.update_depth() is None, "nothing has changed since"
    again = session.run(QUICK).complete().results
    workspace.runs.store_results(session, [again[3]])
    session.update_depth()
    assert not session.stale[session.labels == 3].any()
    session.undo_stack.undo()
    np.testing.assert_array_equal(session.current_depth(), before)
    assert not session.stale.any()
    session.undo_stack.redo()
    assert list(session.valid_results()) == [2, 3], "what has been solved since is not lost either"


def test_the_present_depth_is_that_of_the_completion_whatever_happens(
    workspace: Workspace, session: Session, results: list[BlockResult]
) -> None:
    """What is kept up to date box by box is what would be made anew."""
    random = np.random.default_rng(0)
    session.change(common=QUICK)
    workspace.runs.store_results(session, results)
    for _ in range(30):
        rows, columns = (sorted(random.choice(40, 2, replace=False)) for _ in range(2))
        edit(
            workspace, int(random.integers(0, 4)), rows=np.s_[rows[0] : rows[1]], columns=np.s_[columns[0] : columns[1]]
        )
        if random.random() < 0.5:
            wanted = session.changed_blocks()[:2]
            done = session.run(QUICK, wanted).complete()
            workspace.runs.store_results(session, list(done.results.values()))
        for _ in range(random.integers(0, 3)):
            session.undo_stack.undo()
        fresh = compose(session.run(QUICK), session.valid_results())
        np.testing.assert_array_equal((session.completion() or fresh).depth, fresh.depth)
        shown = np.where(session.stale, fresh.depth, session.current_depth())
        np.testing.assert_array_equal(shown, fresh.depth)
        assert not np.isin(session.labels, [0, *session.valid_results()])[session.stale].any()
        session._tally, counts = None, session.counts()
        assert session.counts() == counts


def test_borders_that_come_by_an_edit_are_drawn_ones(workspace: Workspace, session: Session) -> None:
    assert session.run(QUICK).blocks.drawn is None
    edit(workspace, 3)
    drawn = session.run(QUICK).blocks.drawn
    np.testing.assert_array_equal(
        drawn[:6, :7],
        np.array(
            [[False] * 4 + [True] * 2 + [False]] * 3
            + [[True] * 5 + [True, False], [True] * 5 + [False] * 2, [False] * 7]
        ),
    )
    assert not drawn[:, 28:].any(), "extracted borders stay what they are"
    session.undo_stack.undo()
    assert session.run(QUICK).blocks.drawn is None
    session.undo_stack.redo()
    np.testing.assert_array_equal(session.run(QUICK).blocks.drawn, drawn)
    again = Session.of(session.run(QUICK), "run.json", "run.json")
    np.testing.assert_array_equal(again.run(QUICK).blocks.drawn, drawn)
    fresh = np.full(session.frame.shape, 7, np.int32)
    workspace.blocks.set_extracted(session, extraction(session, fresh), BlockParameters())
    kept = session.labels == 3
    np.testing.assert_array_equal(session.blocks.drawn, drawn & kept)
    workspace.blocks.replace(fresh, "Load blocks")
    assert session.run(QUICK).blocks.drawn is None


def test_depth_that_is_distrusted_is_missing_and_undo_brings_it_back(
    workspace: Workspace, session: Session, results: list[BlockResult], told: list[str]
) -> None:
    workspace.runs.store_results(session, results)
    mask = np.zeros(session.frame.shape, bool)
    mask[30:40, 5:20] = True
    told.clear()
    assert workspace.blocks.set_invalid_mask(mask, "Distrust depth")
    assert not workspace.blocks.set_invalid_mask(mask.copy(), "Distrust depth")
    assert told == ["blocks.invalid_mask_changed", "runs.results_changed"]
    assert np.isnan(session.frame.depth[mask]).all()
    assert session.counts()[1].known == (session.frame.known & (session.labels == 1)).sum()
    assert session.valid_results() == {}
    session.undo_stack.undo()
    assert session.frame.invalid_mask is None
    assert list(session.valid_results()) == [1, 2]
    with pytest.raises(InputError, match="no known depth is left"):
        workspace.blocks.set_invalid_mask(np.ones_like(mask), "Distrust depth")
    assert session.frame.invalid_mask is None


def test_a_truth_outlasts_what_is_undone_of_the_depth(workspace: Workspace, session: Session) -> None:
    mask = np.zeros(session.frame.shape, bool)
    mask[30:40, 5:20] = True
    workspace.blocks.set_invalid_mask(mask, "Distrust depth")
    workspace.blocks.set_ground_truth(np.full(session.frame.shape, 2.0, np.float32))
    ground_truth = session.frame.ground_truth
    session.undo_stack.undo()
    assert session.frame.invalid_mask is None
    np.testing.assert_array_equal(session.frame.ground_truth, ground_truth)
    workspace.blocks.set_ground_truth(None)
    session.undo_stack.redo()
    assert session.frame.ground_truth is None
    assert session.frame.invalid_mask is not None


def test_results_go_with_the_extraction_whose_edges_the_filter_saw(workspace: Workspace, session: Session) -> None:
    """Blocks that stay have the same pixels, but other edges: a run of them would not give the same result."""
    for label in (1, 2):
        workspace.blocks.set_lock(label, True)
    jumps, pieces = BlockParameters(depth_jump=0.5), BlockParameters(granularity=0.9)
    session.add_results(list(complete(session.frame, session.labels, preset()).results.values()))
    assert set(session.valid_results()) == {1, 2}
    found = extract(session.frame, pieces)
    workspace.blocks.set_extracted(session, found, pieces)
    assert set(session.valid_results()) == {1, 2}, "the edges are the same"
    workspace.blocks.set_extracted(session, found, jumps)
    assert session.valid_results() == {}
    assert session.completion() is None
    paper = complete(session.frame, session.labels, preset("paper", max_iterations=5), extraction=jumps)
    session.add_results(list(paper.results.values()))
    workspace.blocks.set_extracted(session, found, BlockParameters())
    assert set(session.valid_results()) == {1, 2}, "the pass band knows no edges"
