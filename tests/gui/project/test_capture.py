"""How a session stands is taken in no time, and comes back as it was."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gui.project.recorder import SessionSnapshot, Tiles
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.work.loading import restore
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between


@given(
    st.tuples(st.integers(1, 600), st.integers(1, 600)),
    st.lists(st.tuples(*[st.integers(0, 600)] * 4), max_size=4),
)
def test_a_copy_in_tiles_is_the_array_of_its_moment(shape: tuple[int, int], boxes: list[tuple[int, ...]]) -> None:
    array = np.zeros(shape, np.int32)
    tiles = Tiles[np.int32]()
    moments = [(tiles.update(array, None), array.copy())]
    for number, (top, left, height, width) in enumerate(boxes, 1):
        box = (
            slice(min(top, shape[0]), min(top + height, shape[0])),
            slice(min(left, shape[1]), min(left + width, shape[1])),
        )
        array[box] = number
        moments.append((tiles.update(array, box), array.copy()))
    for copy, expected in moments:
        assert np.array_equal(copy(), expected)


def test_a_session_comes_back_as_it_was(small_frame: RGBDFrame, small_labels: np.ndarray) -> None:
    run = Run(small_frame, small_labels)
    results: list[BlockResult] = list(run.complete().results.values())
    workspace = Workspace()
    touched: list[Session] = []
    workspace.frames.touched.connect(touched.append)
    session = Session.of(run, None, "here")
    workspace.add_session(session)
    capture = SessionSnapshot(session)
    capture.take()()

    session.note = "look here"
    workspace.blocks.edit_info(1, "Rename", name="wall", locked=True)
    edited = small_labels.copy()
    edited[40:, :10] = 0
    workspace.blocks.edit(patch_between(session.labels, edited), "Erase")
    workspace.parameters.set_own({"max_iterations": 7}, [2])
    workspace.runs.store_results(session, results)
    workspace.blocks.set_visible(2, False)
    assert touched == [session] * 5
    state = capture.take()()
    workspace.blocks.edit_info(1, "Rename", name="floor")
    session.labels[:] = 9

    again = restore(state, None, "here")
    assert np.array_equal(again.labels, edited)
    assert (again.note, again.info(1).name, again.locked, again.info(2).visible) == ("look here", "wall", {1}, False)
    assert again.notes.drawn is not None
    assert state.blocks.drawn is not None
    assert np.array_equal(again.notes.drawn, state.blocks.drawn)
    assert again.notes.drawn is not state.blocks.drawn
    assert again.parameters_of(2, again.common).max_iterations == 7
    assert list(again.valid_results()) == [2], "the other block has lost pixels since"
    assert (again.id, again.unsaved, again.undo_stack.count()) == (session.id, False, 0)
