"""Several blocks in the real window: a table of seven strips is selected and merged by pointer, list and keys."""

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt

from gui.features.blocks.feature import BlocksFeature
from gui.features.status import StatusFeature
from ilf.segmentation.editing.patches import patch_between

from .conftest import activate
from .hand import CTRL, SHIFT, click, drag, key

STRIPS = range(1, 8)
LOCKED = 4


@pytest.fixture
def strips(opened, qtbot):
    """The window with seven strips, the upper half of which is block 8; strip 3 has a piece apart."""
    window, document = opened, opened.workspace.current
    labels = np.repeat(np.linspace(1, 7.99, document.labels.shape[1]).astype(np.int32)[None], len(document.labels), 0)
    labels[:10] = 8
    labels[:4, :8] = 3
    window.workspace.current.edit(patch_between(document.labels, labels), "Seven strips")
    window.workspace.select([])
    activate(window, qtbot)
    window.actions_["tool_select"].trigger()
    window.refresh.now()
    return window


def middle(window, label: int) -> tuple[float, float]:
    rows, columns = np.nonzero(window.workspace.current.labels[20:] == label)
    return float(columns.mean()) + 0.5, float(rows.mean()) + 20.5


def across(window) -> list[tuple[float, float]]:
    return [middle(window, label) for label in STRIPS]


def status(window) -> str:
    window.refresh.now()
    return window.feature(StatusFeature).bar.hint.text()


def test_one_stroke_merges_the_seven_strips_in_one_step_unless_it_is_cancelled(strips):
    document, before = strips.workspace.current, strips.workspace.current.labels.copy()
    steps, start, end = document.undo_stack.count(), middle(strips, 1), middle(strips, 7)
    drag(strips, across(strips), CTRL | SHIFT, release=False)
    assert "merge 7 blocks" in status(strips)
    assert np.array_equal(document.labels, before), "only shown so far"
    outlined = strips.views.cells["colour"].view.preview.extent
    assert outlined.contains(QPointF(*start))
    assert outlined.contains(QPointF(*end))
    drag(strips, across(strips), CTRL | SHIFT)
    assert len(np.unique(document.labels[10:])) == 1
    assert document.undo_stack.count() == steps + 1
    assert document.selected == [document.labels[20, 20]]
    key(strips, Qt.Key.Key_Z, CTRL)
    assert np.array_equal(document.labels, before)

    drag(strips, across(strips), CTRL | SHIFT, release=False)
    key(strips, Qt.Key.Key_Escape)
    assert not strips.editor.busy
    assert status(strips) == strips.editor.tool.hint
    assert np.array_equal(document.labels, before)


def test_a_merging_stroke_leaves_locked_blocks_out_and_says_so(strips):
    document, said = strips.workspace.current, list[str]()
    strips.editor.message.connect(said.append)
    strips.workspace.current.set_lock(LOCKED, True)
    locked = document.labels == LOCKED
    drag(strips, across(strips), CTRL | SHIFT, release=False)
    assert "merge 6 blocks" in status(strips)
    assert f"{document.info(LOCKED).name} left out: locked" in status(strips)
    drag(strips, across(strips), CTRL | SHIFT)
    assert np.array_equal(document.labels == LOCKED, locked)
    assert len(np.unique(document.labels[10:])) == 2
    assert said[0].startswith(f"{document.info(LOCKED).name} left out: locked")
    said.clear()
    steps = document.undo_stack.count()
    drag(strips, [(3, 30), (3, 36)], CTRL | SHIFT)
    assert said == ["Two or more unlocked blocks are needed to merge: select them, or Ctrl+Shift+drag across them."]
    assert document.undo_stack.count() == steps


def test_several_blocks_are_selected_alike_by_every_way(strips):
    document, table = strips.workspace.current, strips.feature(BlocksFeature).table
    for way in ("clicks", "stroke", "box", "list", "keys"):
        strips.workspace.select([])
        if way == "clicks":
            for point, modifier in zip(across(strips), (CTRL, SHIFT) * 4, strict=False):
                click(strips, point, modifier)
        elif way == "stroke":
            drag(strips, across(strips), CTRL)
        elif way == "box":
            drag(strips, [(0.5, 11), (40, 30), (document.labels.shape[1] - 0.5, len(document.labels) - 0.5)], SHIFT)
        else:
            strips.refresh.now()
            table.setFocus()
            table.selectRow(0)
            for _ in range(6):
                key(strips, Qt.Key.Key_Down, SHIFT)
            if way == "keys":
                key(strips, Qt.Key.Key_A, CTRL)
                click(strips, (30, 5), CTRL)
        assert sorted(document.selected) == list(STRIPS), way
        pixels = np.count_nonzero(np.isin(document.labels, STRIPS))
        assert status(strips).startswith(f"7 selected, {pixels:,} px | Click: select")
        assert sorted(table.chosen()) == list(STRIPS)
        key(strips, Qt.Key.Key_M, CTRL)
        assert len(np.unique(document.labels[10:])) == 1
        assert "selected" not in status(strips)
        key(strips, Qt.Key.Key_Z, CTRL)
