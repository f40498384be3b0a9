"""Blocks that came from another frame: taken as one step, and looked at."""

from dataclasses import replace

import pytest

import ilf
from gui.state.document import Document
from gui.state.parts import Part
from ilf.project.project import Stage
from ilf.project.propagation import propagate_state

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
