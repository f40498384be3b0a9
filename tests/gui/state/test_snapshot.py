"""The state of an open frame is taken for other threads, and opens as the same frame again."""

from dataclasses import dataclass

import numpy as np

from gui.state.document import Document
from gui.state.workspace import Workspace
from ilf.data.results import BlockResult
from ilf.project.frame_state import FrameState
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between

from ..states import QUICK, edit, painted


def test_a_session_comes_back_as_it_was(small_frame, small_labels):
    run = Run(small_frame, small_labels)
    results: list[BlockResult] = list(run.complete().results.values())
    workspace = Workspace()
    touched: list[Document] = []
    workspace.touched.connect(touched.append)
    document = Document.of(run, None, "here")
    workspace.open_document(document)
    document.snapshot()

    document.change(note="look here")
    workspace.current.edit_info(1, "Rename", name="wall", locked=True)
    edited = small_labels.copy()
    edited[40:, :10] = 0
    workspace.current.edit(patch_between(document.labels, edited), "Erase")
    workspace.parameters.set_own({"max_iterations": 7}, [2])
    document.store_results(results)
    workspace.current.set_visible(2, False)
    assert touched == [document] * 5
    state = document.snapshot()
    workspace.current.edit_info(1, "Rename", name="floor")
    document.labels[:] = 9

    again = Document.of_state(state, None, "here")
    assert np.array_equal(again.labels, edited)
    assert (again.state.note, again.locked) == ("look here", {1})
    assert (again.info(1).name, again.info(2).visible) == ("wall", False)
    assert again.blocks.drawn is not None
    assert state.blocks.drawn is not None
    assert np.array_equal(again.blocks.drawn, state.blocks.drawn)
    assert again.blocks.drawn is not state.blocks.drawn
    assert again.parameters_of(2).max_iterations == 7
    assert list(again.valid_results()) == [2], "the other block has lost pixels since"
    assert (again.id, again.unsaved, again.undo_stack.count()) == (document.id, False, 0)


def test_only_what_has_changed_is_another_object_in_the_next_state(workspace, document):
    edit(workspace, 2)
    first, second = document.snapshot(), document.snapshot()
    assert second.blocks.labels is first.blocks.labels
    assert second.blocks.drawn is first.blocks.drawn is not None
    assert document.run(QUICK).blocks.labels is first.blocks.labels, "a run shares them, too"

    before = first.blocks.labels.copy()
    document.set_labels(painted(document, 1, np.s_[20:30]))
    third = document.snapshot()
    assert third.blocks.labels is not first.blocks.labels
    assert third.blocks.drawn is first.blocks.drawn
    assert np.array_equal(first.blocks.labels, before)
    assert np.array_equal(third.blocks.labels, document.labels)
    assert not third.blocks.labels.flags.writeable


def test_a_stroke_in_progress_copies_nothing(workspace, document):
    labels = document.labels
    for row in range(3):
        workspace.current.stroke(patch_between(document.labels, painted(document, 2, np.s_[row : row + 1])))
    assert document.labels is labels
    document.edit(document.drop_stroke(), "Paint")
    assert document.labels is labels


@dataclass(frozen=True, eq=False)
class WeatherState(FrameState):
    """A state that knows one thing more."""

    weather: str = "sunny"


def test_a_new_field_of_the_state_needs_no_line_in_the_session(document):
    opened = Document.of_state(
        WeatherState("a1", document.frame, document.snapshot().blocks, weather="snow"), None, "here"
    )
    assert isinstance(opened.state, WeatherState)
    assert opened.state.weather == "snow"
    opened.change(weather="rain")
    opened.change_blocks(own={1: {"smoothness": 2.0}})
    taken = opened.snapshot()
    assert isinstance(taken, WeatherState)
    again = Document.of_state(taken, None, "there")
    assert isinstance(again.state, WeatherState)
    assert again.state.weather == "rain"
