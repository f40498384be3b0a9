"""Blocks that came from another frame: taken as one step, and looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gui.features.blocks.feature import block_rows
from gui.features.propagation.propagator import session_of
from gui.state.entries import Entry
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.runs import RunController
from ilf.data.blocks import Blocks
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.project.propagation import propagate_state
from ilf.segmentation.editing.patches import LabelPatch, patch_between
from ilf.sources.frame_ref import FrameRef

REASON = "It was not in the picture before."


@pytest.fixture
def propagated(session: Session, other: Session) -> FrameState:
    """The blocks of `other` on the frame of `session`, with other values; block 2 needs a look."""
    other.change_info(1, name="Wall", locked=True)
    other.change_blocks(own={1: {"smoothness": 3.0}})
    other.change(common=Parameters(s_criteria=0.002))
    other.change(extrapolate=True)
    state = propagate_state(other.snapshot(), session.snapshot()).state
    labels = state.blocks.labels.copy()
    labels[:5] = 2
    return replace(
        state,
        blocks=replace(state.blocks, labels=labels, extracted=labels, reasons={2: REASON}),
        to_check=frozenset({2}),
        selected=(1,),
    )


def known(session: Session) -> object:
    notes = session.blocks
    return (
        session.labels.tolist(),
        *(dict(notes.infos), dict(notes.own), notes.propagated_from, notes.kept),
        *(session.state.common, session.state.extrapolate, session.state.to_check),
    )


def edit(workspace: Workspace, at: tuple[slice, slice], label: int) -> None:
    labels = workspace.session.labels.copy()
    labels[at] = label
    workspace.blocks.edit(patch_between(workspace.session.labels, labels), "Edit")


def test_blocks_are_taken_and_given_back_as_one_step(
    workspace: Workspace, session: Session, propagated: FrameState, told: list[str]
) -> None:
    session.info(1)
    before = known(session)
    touched: list[object] = []
    workspace.frames.touched.connect(touched.append)
    workspace.blocks.take_propagated(session, propagated, "Carry blocks from other")
    assert {"blocks.labels_changed", "blocks.infos_changed", "parameters.changed", "runs.results_changed"} <= set(told)
    assert touched == [session]
    after = known(session)
    assert session.labels.tolist() == propagated.blocks.labels.tolist()
    assert session.info(1).name == "Wall"
    assert (session.parameters_of(1).smoothness, session.state.extrapolate) == (3.0, True)
    assert session.summary().stage is Stage.PROPAGATED
    assert session.summary().to_check == 1
    assert session.selected == [1]
    session.undo_stack.undo()
    assert known(session) == before
    session.undo_stack.redo()
    assert known(session) == after


def test_blocks_are_taken_where_nobody_looks(workspace: Workspace, other: Session, propagated: FrameState) -> None:
    state = propagate_state(propagated, other.snapshot()).state
    workspace.blocks.take_propagated(other, state, "Carry blocks")
    assert np.array_equal(other.labels, state.blocks.labels)
    assert other.unsaved


def test_results_of_the_blocks_before_come_back_with_undo(
    workspace: Workspace, session: Session, propagated: FrameState, results: list
) -> None:
    workspace.runs.store_results(session, results)
    workspace.blocks.take_propagated(session, propagated, "Carry blocks")
    assert 2 not in session.valid_results()
    session.undo_stack.undo()
    assert set(session.valid_results()) == {1, 2}


def test_a_block_needs_no_look_once_it_is_edited_or_looked_at(
    workspace: Workspace, session: Session, propagated: FrameState
) -> None:
    workspace.blocks.take_propagated(session, propagated, "Carry blocks")
    runs = RunController(workspace)
    assert [row.look for row in block_rows(session, runs)] == ["", REASON]
    workspace.blocks.mark_checked([1])
    assert session.undo_stack.count() == 1  # it needs none
    workspace.blocks.mark_checked([1, 2])
    assert session.undo_stack.undoText() == "Mark Block 2 as checked"
    assert not session.state.to_check
    session.undo_stack.undo()
    assert session.state.to_check == {2}

    edit(workspace, np.s_[40:44, 2:6], 0)
    assert session.state.to_check == {2}  # another block
    edit(workspace, np.s_[40:44, 50:54], 0)
    assert not session.state.to_check
    session.undo_stack.undo()
    assert session.state.to_check == {2}
    runs.shutdown()


def test_what_a_stroke_edits_has_been_looked_at(workspace: Workspace, session: Session, propagated: FrameState) -> None:
    workspace.blocks.take_propagated(session, propagated, "Carry blocks")
    box = np.s_[40:44, 50:54]
    before = session.labels[box].copy()
    workspace.blocks.stroke(LabelPatch(box, before, np.zeros_like(before)))
    assert session.state.to_check == {2}
    workspace.blocks.end_stroke("Erase")
    assert not session.state.to_check


def test_another_extraction_forgets_what_was_carried(
    workspace: Workspace, session: Session, propagated: FrameState
) -> None:
    workspace.blocks.take_propagated(session, propagated, "Carry blocks")
    names = {1: "Left", 2: "Right"}
    workspace.blocks.replace(np.where(session.labels == 1, 1, 3).astype(np.int32), "Load blocks", names)
    assert not session.state.to_check
    assert session.blocks.propagated_from == ""
    session.undo_stack.undo()
    assert session.state.to_check == {2}
    assert session.blocks.propagated_from == propagated.blocks.propagated_from


def test_of_frames_of_the_same_files_the_chosen_one_is_opened(workspace: Workspace, small_frame: RGBDFrame) -> None:
    chosen, other = (Entry.of(FrameRef("/frames/one")) for _ in range(2))
    workspace.frames.add_entries([chosen, other])
    state = FrameState(chosen.id, small_frame, Blocks(np.zeros(small_frame.shape, np.int32)))
    workspace.add_session(session_of(chosen, state), show=False)
    assert chosen.session is not None
    assert other.session is None
