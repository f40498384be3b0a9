"""Refine edge, and lines that are adjusted after they were drawn."""

import numpy as np
import pytest

from gui.tools.kinds import Tools
from gui.views.interaction import PointerKind

from ..tool_host import Hand, ToolHost


def hand(host, name):
    made = Hand(Tools()[name], host)
    host.workspace.about_to_change.connect(lambda: made.tool.cancel(host))
    return made


BULGE = [(30.0, 10.0), (36.0, 20.0), (30.0, 30.0)]


def test_a_point_of_a_border_is_moved_in_the_same_undo_step(host):
    border, before = hand(host, "border"), host.labels.copy()
    border.drag(BULGE)
    assert list(host.preview.corners) == BULGE
    border.drag([(36, 20), (30, 20), (24, 20)], release=False)
    assert "px from Block 1 to Block 2" in border.tool.hint
    border.send(PointerKind.RELEASE, (24, 20))
    assert host.steps == ["Redraw border"]
    assert host.labels[20, 26] == 2
    assert host.labels[20, 32] == 2, "the first shape is gone"
    assert list(host.preview.corners) == [(30, 10), (24, 20), (30, 30)]
    host.undo()
    assert np.array_equal(host.labels, before)
    assert host.preview is None


def test_points_are_added_and_removed(host):
    border = hand(host, "border")
    border.drag([(30, 2), (50, 24), (30, 46)])
    border.click((40, 13))
    assert len(host.preview.corners) == 4, "a click on the line adds a point and changes nothing"
    assert host.steps == ["Redraw border"]
    border.drag([(40, 13), (44, 9), (48, 9)])
    assert host.labels[13, 44] == 1
    border.click((48, 9), "c")
    assert host.labels[13, 44] == 2
    border.click((50, 24), "a")
    assert host.labels[24, 32] == 2
    assert "moves no border" in host.said[-1], "the straight line that is left is the old border"
    border.click((30, 2), "a")
    assert "last points" in host.said[-1]
    border.drag([(30, 22), (31, 22), (38, 22)])
    assert host.labels[22, 34] == 1, "a drag of the line adds a point there"
    assert host.steps == ["Redraw border"]


def test_enter_takes_a_line_escape_drops_it_and_another_action_ends_it(host):
    border, before = hand(host, "border"), host.labels.copy()
    border.drag(BULGE)
    assert not border.tool.busy, "Ctrl+Z undoes the stroke"
    assert border.finish()
    assert host.preview is None
    assert not border.tool.remove(host), "Escape is for the selection again"
    assert host.steps == ["Redraw border"]
    border.drag([(30, 30), (24, 36), (30, 42)])
    assert border.tool.remove(host)
    assert host.steps == ["Redraw border"]
    border.drag([(30, 10), (33, 20), (30, 30)])
    border.click((50, 20))
    assert host.document.selected == [2], "a click beside the line selects"
    assert host.preview is None
    host.undo()
    host.undo()
    assert np.array_equal(host.labels, before)


def test_a_line_is_not_adjusted_after_another_step(host):
    border = hand(host, "border")
    border.drag(BULGE)
    host.document.undo_stack.beginMacro("Rename")
    host.document.undo_stack.endMacro()
    labels = host.labels.copy()
    border.drag([(36, 20), (42, 20)])
    assert host.steps[:2] == ["Redraw border", "Rename"]
    assert border.tool.remove(host) or True
    assert np.array_equal(labels[:, :30], host.labels[:, :30])


def test_a_moved_point_snaps_and_its_line_keeps_its_shape(small_frame, small_labels):
    small_labels[:, 26:] = 2
    host = ToolHost(small_frame, small_labels, leash=3)
    border = hand(host, "border")
    border.drag([(24, 5), (21, 15), (22, 24), (21, 33), (24, 43)])
    corners = list(host.preview.corners)
    middle = min(corners, key=lambda corner: abs(corner[1] - 24))
    at = corners.index(middle)
    border.drag([middle, (27, 24), (28.5, 24)])
    x, y = list(host.preview.corners)[at]
    assert abs(x - 30) < 1, "it lies at the edge, not where it was left"
    assert abs(y - 24) < 2
    assert [corner for k, corner in enumerate(host.preview.corners) if k != at] == [
        corner for k, corner in enumerate(corners) if k != at
    ]


def test_an_outline_is_adjusted_with_its_block(host):
    outline = hand(host, "outline")
    for corner in ((40, 10), (50, 10), (50, 20), (40, 20)):
        outline.click(corner)
    assert outline.finish()
    assert len(host.preview.corners) == 4
    outline.drag([(50, 20), (55, 25), (58, 30)])
    assert host.labels[25, 53] == 3
    assert host.document.selected == [3]
    outline.click((40, 10), "a")
    assert host.labels[12, 42] == 2
    assert len(host.steps) == 1
    assert outline.tool.remove(host)
    assert host.steps == []
    assert set(np.unique(host.labels)) == {1, 2}


def test_refine_edge_divides_the_band_on_release(small_frame, small_labels):
    small_labels[:, 26:] = 2
    host = ToolHost(small_frame, small_labels)
    host.options.brush_radius = 7
    refine = hand(host, "refine")
    refine.drag([(27, 10), (27, 24), (27, 38)], release=False)
    assert "px from Block 2 to Block 1" in refine.tool.hint
    assert host.preview.line_preview.boundingRect().right() == pytest.approx(30, abs=1), "what would change"
    assert host.steps == []
    refine.send(PointerKind.RELEASE, (27, 38))
    assert host.steps == ["Refine edge"]
    assert (host.labels[12:36, :29] == 1).all()
    assert (host.labels[12:36, 31:] == 2).all(), "the border lies at the edge"


def test_refine_edge_says_why_nothing_changes(host):
    refine = hand(host, "refine")
    refine.drag([(50, 10), (50, 30)])
    assert "no border under the brush" in host.said[-1]
    refine.drag([(30, 10), (30, 30)])
    assert "The border stays" in host.said[-1]
    host.document.change_info(2, locked=True)
    refine.drag([(30, 10), (30, 30)])
    assert "Block 2 is locked" in host.said[-1]
    host.edge_data = None
    refine.drag([(30, 10), (30, 30)])
    assert "still being computed" in host.said[-1]
    assert host.steps == []


def test_a_band_that_is_being_decided_is_cancelled_or_ended_by_the_next_stroke(small_frame, small_labels):
    small_labels[:, 27:] = 2
    host = ToolHost(small_frame, small_labels)
    host.options.brush_radius = 6
    host.waits = True
    refine = hand(host, "refine")
    refine.drag([(28, 5), (28, 20)])
    assert refine.tool.busy
    assert refine.cancel()
    for answer in host.waiting:
        answer()
    assert host.steps == []
    refine.drag([(28, 5), (28, 20)])
    refine.press((28, 30))
    assert host.steps == ["Refine edge"]
    assert refine.tool.busy, "the next stroke"
