"""Smart select in the real window: clicks, box, wheel and Enter, on a frame of two blocks that meet at x = 30."""

import numpy as np
import pytest
from PySide6.QtCore import Qt

from .conftest import activate
from .hand import ALT, CTRL, SHIFT, click, drag, hover, key, turn_wheel

_Key = Qt.Key


@pytest.fixture
def selecting(opened, qtbot):
    """The window with the tool, no block selected."""
    activate(opened, qtbot)
    opened.workspace.select([])
    opened.actions_["tool_smart_select"].trigger()
    opened.views.cells["colour"].view.setFocus()
    opened.refresh.now()
    return opened


def _wait(window, qtbot):
    qtbot.waitUntil(lambda: not window.editor.working)


def _shown(window) -> tuple[float, float, float, float]:
    """What the preview covers: left, top, right, bottom."""
    extent = window.views.cells["colour"].view.preview.extent
    return extent.left(), extent.top(), extent.right(), extent.bottom()


def test_a_click_and_enter_make_a_block_in_one_undo_step_and_a_box_starts_a_new_object(selecting, qtbot):
    document = selecting.workspace.current
    before = document.labels.copy()
    click(selecting, (50, 20))
    key(selecting, _Key.Key_Return)  # before or after the selection is there
    _wait(selecting, qtbot)
    new = document.selected[0]
    assert new not in before
    assert document.labels[20, 50] == new
    assert document.labels[20, 5] != new
    assert document.undo_stack.count() == 1
    assert not selecting.editor.busy
    key(selecting, _Key.Key_Z, CTRL)
    assert np.array_equal(document.labels, before)

    selecting.workspace.select([])
    click(selecting, (5, 20))
    _wait(selecting, qtbot)
    key(selecting, _Key.Key_Return)
    first = document.selected[0]
    drag(selecting, [(28, 1), (40, 20), (before.shape[1] - 1, before.shape[0] - 1)])
    _wait(selecting, qtbot)
    key(selecting, _Key.Key_Return)
    assert document.labels[20, 5] == first
    assert document.labels[20, 50] == document.selected[0] != first
    assert document.undo_stack.count() == 2


def test_the_preview_shows_what_pointer_wheel_box_and_the_next_click_would_select(selecting, qtbot):
    hover(selecting, (48, 20))
    hover(selecting, (50, 20))
    _wait(selecting, qtbot)
    left, _, right, _ = _shown(selecting)
    assert left < 50 < right
    scale = selecting.views.cells["colour"].view.transform.m11()
    click(selecting, (50, 20))
    for _ in range(20):
        turn_wheel(selecting, (50, 20), 1, CTRL)
    _wait(selecting, qtbot)
    assert selecting.views.cells["colour"].view.transform.m11() == scale
    left, _, right, _ = _shown(selecting)
    assert left <= 0
    assert right >= selecting.workspace.current.labels.shape[1]

    key(selecting, _Key.Key_Escape)
    click(selecting, (50, 20))
    _wait(selecting, qtbot)
    left, *_ = _shown(selecting)
    hover(selecting, (6, 20))
    hover(selecting, (5, 20))
    _wait(selecting, qtbot)
    assert _shown(selecting)[0] < 5 < left

    key(selecting, _Key.Key_Escape)
    height, width = selecting.workspace.current.labels.shape
    drag(selecting, [(28, 1), (40, 20), (width - 1, height - 1)])
    _wait(selecting, qtbot)
    click(selecting, (5, 20))
    _wait(selecting, qtbot)
    left, _, right, _ = _shown(selecting)
    assert left < 5
    assert right > 50


def test_ctrl_click_takes_away_backspace_brings_back_and_escape_cancels(selecting, qtbot):
    document = selecting.workspace.current
    before = document.labels.copy()
    for point, modifiers in (((50, 20), ()), ((5, 20), ()), ((5, 5), (CTRL,))):
        click(selecting, point, *modifiers)
        _wait(selecting, qtbot)
    key(selecting, _Key.Key_Backspace)
    _wait(selecting, qtbot)
    assert selecting.editor.busy
    assert selecting.editor.tool.hint.startswith("Enter: make it a block"), "also where the end is elided"
    key(selecting, _Key.Key_Escape)
    assert not selecting.editor.busy
    assert np.array_equal(document.labels, before)
    click(selecting, (50, 20))
    click(selecting, (5, 20), ALT)
    key(selecting, _Key.Key_Return)
    _wait(selecting, qtbot)
    assert document.labels[20, 50] == document.selected[0] != document.labels[20, 5]


def test_with_a_block_selected_shift_adds_ctrl_takes_away_a_click_makes_a_new_one_and_a_lock_holds(selecting, qtbot):
    document = selecting.workspace.current
    before, left = document.labels.copy(), int(document.labels[20, 5])
    selecting.workspace.select([left])
    for modifiers, joins in (((SHIFT,), True), ((CTRL,), False), ((SHIFT,), True), ((), False)):
        click(selecting, (50, 20), *modifiers)
        _wait(selecting, qtbot)
        key(selecting, _Key.Key_Return)
        assert (document.labels[20, 50] == left) == joins
        assert document.labels[20, 5] == left
        selecting.workspace.select([left])
    assert document.labels[20, 50] not in {0, *before.flat}
    assert document.undo_stack.count() == 4

    selecting.actions_["lock_blocks"].trigger()
    assert document.undo_stack.undoText().startswith("Lock ")
    before = document.labels.copy()
    click(selecting, (50, 20), SHIFT)
    _wait(selecting, qtbot)
    key(selecting, _Key.Key_Return)
    assert np.array_equal(document.labels, before)


def test_a_stroke_with_shift_acts_like_a_click(selecting, qtbot):
    document = selecting.workspace.current
    drag(selecting, [(36, 8), (50, 20), (54, 36)], SHIFT)
    _wait(selecting, qtbot)
    drag(selecting, [(4, 8), (8, 30)], SHIFT | CTRL)
    _wait(selecting, qtbot)
    key(selecting, _Key.Key_Return)
    new = document.selected[0]
    assert document.labels[8, 36] == document.labels[36, 54] == new
    assert document.labels[8, 4] != new != document.labels[30, 8]


def test_steps_of_a_click_stay_when_another_is_added(selecting, qtbot):
    document = selecting.workspace.current
    click(selecting, (50, 20))
    turn_wheel(selecting, (50, 20), 20, CTRL)
    click(selecting, (52, 22))
    key(selecting, _Key.Key_Return)
    _wait(selecting, qtbot)
    assert (document.labels == document.selected[0]).all()


@pytest.mark.parametrize(("start", "how"), [("click", "wheel"), ("box", "keys")])
def test_sizes_step_after_a_click_as_after_a_box_and_their_end_is_said(selecting, qtbot, start, how):
    said = list[str]()
    selecting.editor.message.connect(said.append)
    height, width = selecting.workspace.current.labels.shape

    def step(steps: int) -> float:
        """The size of the preview's extent after a step."""
        if how == "wheel":
            turn_wheel(selecting, (50, 20), steps, CTRL)
        else:
            selecting.actions_["brush_larger" if steps > 0 else "brush_smaller"].trigger()
        _wait(selecting, qtbot)
        left, top, right, bottom = _shown(selecting)
        return (right - left) * (bottom - top)

    if start == "click":
        click(selecting, (50, 20))
    else:
        drag(selecting, [(28, 1), (40, 20), (width - 1, height - 1)])
    hover(selecting, (50, 20))
    _wait(selecting, qtbot)
    sizes = [step(1)]
    while not said:
        sizes.append(step(1))
    assert sizes == sorted(sizes)
    assert said == ["There is no larger region here: click what else belongs to it, or drag a box around it."]
    said.clear()
    smaller = [step(-1)]
    assert not said, "a step that had no effect is not counted"
    while not said:
        smaller.append(step(-1))
    assert said == ["There is no smaller region here: take parts away with Ctrl+click, or drag a box."]
    assert smaller[-1] < sizes[-1]


def test_sizes_of_what_is_taken_away_are_told_to_be_none(selecting, qtbot):
    said = list[str]()
    selecting.editor.message.connect(said.append)
    selecting.workspace.select([int(selecting.workspace.current.labels[20, 5])])
    click(selecting, (5, 20), CTRL)
    _wait(selecting, qtbot)
    turn_wheel(selecting, (5, 20), 1, CTRL)
    assert said == ["Sizes belong to what a click or a box adds: click what you want to add first."]
