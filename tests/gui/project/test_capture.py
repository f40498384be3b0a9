"""How a session stands is taken in no time, and comes back as it was."""

from __future__ import annotations

import numpy as np

from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between


def test_a_session_comes_back_as_it_was(small_frame: RGBDFrame, small_labels: np.ndarray) -> None:
    run = Run(small_frame, small_labels)
    results: list[BlockResult] = list(run.complete().results.values())
    workspace = Workspace()
    touched: list[Session] = []
    workspace.frames.touched.connect(touched.append)
    session = Session.of(run, None, "here")
    workspace.add_session(session)
    session.snapshot()

    session.change(note="look here")
    workspace.blocks.edit_info(1, "Rename", name="wall", locked=True)
    edited = small_labels.copy()
    edited[40:, :10] = 0
    workspace.blocks.edit(patch_between(session.labels, edited), "Erase")
    workspace.parameters.set_own({"max_iterations": 7}, [2])
    workspace.runs.store_results(session, results)
    workspace.blocks.set_visible(2, False)
    assert touched == [session] * 5
    state = session.snapshot()
    workspace.blocks.edit_info(1, "Rename", name="floor")
    session.labels[:] = 9

    again = Session.of_state(state, None, "here")
    assert np.array_equal(again.labels, edited)
    assert (again.state.note, again.locked) == ("look here", {1})
    assert (again.info(1).name, again.info(2).visible) == ("wall", False)
    assert again.blocks.drawn is not None
    assert state.blocks.drawn is not None
    assert np.array_equal(again.blocks.drawn, state.blocks.drawn)
    assert again.blocks.drawn is not state.blocks.drawn
    assert again.parameters_of(2).max_iterations == 7
    assert list(again.valid_results()) == [2], "the other block has lost pixels since"
    assert (again.id, again.unsaved, again.undo_stack.count()) == (session.id, False, 0)
