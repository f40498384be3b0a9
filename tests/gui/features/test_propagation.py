"""Blocks that came from another frame: taken as one step, and looked at."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtWidgets import QWidget

import ilf
from gui.features.blocks.feature import block_rows
from gui.project.loading import FrameLoader
from gui.project.store import WorkStore
from gui.state.document import Document
from gui.state.entries import Entry
from gui.state.parts import Part
from gui.work.jobs import stop_workers
from gui.work.runs import RunController
from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.project.propagation import propagate_state
from ilf.project.state_codec import Decoded
from ilf.segmentation.editing.patches import LabelPatch
from ilf.sources.frame_ref import FrameRef

from ..states import edit

REASON = "It was not in the picture before."


@pytest.fixture
def propagated(document, other):
    """The blocks of `other` on the frame of `session`, with other values; block 2 needs a look."""
    other.change_info(1, name="Wall", locked=True)
    other.change_blocks(own={1: {"smoothness": 3.0}})
    other.change(common=ilf.Parameters(s_criteria=0.002))
    other.change(extrapolate=True)
    state = propagate_state(other.snapshot(), document.snapshot()).state
    labels = state.blocks.labels.copy()
    labels[:5] = 2
    return replace(
        state,
        blocks=replace(state.blocks, labels=labels, extracted=labels, reasons={2: REASON}),
        to_check=frozenset({2}),
        selected=(1,),
    )


def known(document: Document) -> object:
    notes = document.blocks
    return (
        document.labels.tolist(),
        *(dict(notes.infos), dict(notes.own), notes.propagated_from, notes.kept),
        *(document.state.common, document.state.extrapolate, document.state.to_check),
    )


def test_blocks_are_taken_and_given_back_as_one_step(workspace, document, propagated, told):
    document.info(1)
    before = known(document)
    touched: list[object] = []
    workspace.touched.connect(touched.append)
    workspace.take_propagated(document, propagated, "Carry blocks from other")
    assert Part.LABELS | Part.INFOS | Part.PARAMETERS | Part.RESULTS in told()
    assert touched == [document]
    after = known(document)
    assert document.labels.tolist() == propagated.blocks.labels.tolist()
    assert document.info(1).name == "Wall"
    assert (document.parameters_of(1).smoothness, document.state.extrapolate) == (3.0, True)
    assert document.summary().stage is Stage.PROPAGATED
    assert document.summary().to_check == 1
    assert document.selected == [1]
    document.undo_stack.undo()
    assert known(document) == before
    document.undo_stack.redo()
    assert known(document) == after


def test_a_block_needs_no_look_once_it_is_edited_or_looked_at(workspace, document, propagated):
    workspace.take_propagated(document, propagated, "Carry blocks")
    runs = RunController(workspace)
    assert [row.look for row in block_rows(document, runs.current)] == ["", REASON]
    workspace.current.mark_checked([1])
    assert document.undo_stack.count() == 1  # it needs none
    workspace.current.mark_checked([1, 2])
    assert document.undo_stack.undoText() == "Mark Block 2 as checked"
    assert not document.state.to_check
    document.undo_stack.undo()
    assert document.state.to_check == {2}

    edit(workspace, 0, rows=np.s_[40:44], columns=np.s_[2:6])
    assert document.state.to_check == {2}  # another block
    edit(workspace, 0, rows=np.s_[40:44], columns=np.s_[50:54])
    assert not document.state.to_check
    document.undo_stack.undo()
    assert document.state.to_check == {2}
    assert stop_workers(runs)


def test_what_a_stroke_edits_has_been_looked_at(workspace, document, propagated):
    workspace.take_propagated(document, propagated, "Carry blocks")
    box = np.s_[40:44, 50:54]
    before = document.labels[box].copy()
    workspace.current.stroke(LabelPatch(box, before, np.zeros_like(before)))
    assert document.state.to_check == {2}
    assert workspace.current.edit(workspace.current.drop_stroke(), "Erase")
    assert not document.state.to_check
    assert not workspace.current.edit(workspace.current.drop_stroke(), "Erase"), "there is no other"


def test_another_extraction_forgets_what_was_carried(workspace, document, propagated):
    workspace.take_propagated(document, propagated, "Carry blocks")
    names = {1: "Left", 2: "Right"}
    workspace.current.replace_blocks(np.where(document.labels == 1, 1, 3).astype(np.int32), "Load blocks", names)
    assert not document.state.to_check
    assert document.blocks.propagated_from == ""
    document.undo_stack.undo()
    assert document.state.to_check == {2}
    assert document.blocks.propagated_from == propagated.blocks.propagated_from


def test_of_frames_of_the_same_files_the_chosen_one_is_opened(workspace, small_frame, qtbot):
    window, notes = QWidget(), SimpleNamespace(warn=lambda what, problems: None)
    qtbot.addWidget(window)
    chosen, other = (Entry.of(FrameRef("/frames/one")) for _ in range(2))
    workspace.add_entries([chosen, other])
    state = FrameState(chosen.id, small_frame, ilf.Blocks(np.zeros(small_frame.shape, np.int32)))
    FrameLoader(workspace, WorkStore(None), notes, window).open_state(chosen, Decoded(state), show=False)
    assert chosen.document is not None
    assert other.document is None
