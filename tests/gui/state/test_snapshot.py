"""The state of an open frame is taken for other threads, and opens as the same frame again."""

from dataclasses import dataclass

import numpy as np

from gui.state.document import Document
from ilf.project.frame_state import FrameState

from ..states import QUICK, edit, painted


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


@dataclass(frozen=True, eq=False)
class WeatherState(FrameState):
    """A state that knows one thing more."""

    weather: str = "sunny"


def test_a_new_field_of_the_state_needs_no_line_in_the_session(document):
    opened = Document.of_state(
        WeatherState("a1", document.frame, document.snapshot().blocks, weather="snow"), None, "here"
    )
    assert opened.state.weather == "snow"
    opened.change(weather="rain")
    opened.change_blocks(own={1: {"smoothness": 2.0}})
    taken = opened.snapshot()
    assert isinstance(taken, WeatherState)
    again = Document.of_state(taken, None, "there")
    assert again.state.weather == "rain"
