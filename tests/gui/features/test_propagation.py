"""Blocks that came from another frame: taken as one step, and looked at."""

from dataclasses import replace

import numpy as np
import pytest

import ilf
from gui.features.blocks.feature import block_rows
from gui.features.blocks.table import BlockColumn
from gui.state.document import Document
from gui.state.parts import Part
from gui.work.frame_runs import RunController
from gui.work.jobs import stop_workers
from ilf.project.project import Stage
from ilf.project.propagation import propagate_state

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
    rows = block_rows(document, runs.current).values()
    assert [REASON in row[BlockColumn.NAME].hint for row in rows] == [False, True]
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


def test_another_extraction_forgets_what_was_carried(workspace, document, propagated):
    workspace.take_propagated(document, propagated, "Carry blocks")
    names = {1: "Left", 2: "Right"}
    workspace.current.replace_blocks(np.where(document.labels == 1, 1, 3).astype(np.int32), "Load blocks", names)
    assert not document.state.to_check
    assert document.blocks.propagated_from == ""
    document.undo_stack.undo()
    assert document.state.to_check == {2}
    assert document.blocks.propagated_from == propagated.blocks.propagated_from
