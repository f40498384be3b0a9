"""The tools as state machines, without a window: what a hand does, and what comes of it."""

from functools import partial

import numpy as np
import pytest

from gui.tools.kinds import KINDS
from gui.views.interaction import PointerEvent, PointerKind
from ilf.segmentation.editing.patches import patch_between

from ..tool_host import ToolHost, hand


def _move(at, keys=""):
    return PointerKind.MOVE, at, keys


def _release(at, keys=""):
    return PointerKind.RELEASE, at, keys


def _all_to(host, label):
    return _box_to(host, label, np.s_[:, :])


def _box_to(host, label, box):
    after = host.labels.copy()
    after[box] = label
    return patch_between(host.labels, after)


# border


def test_a_border_shows_where_it_would_lie_while_it_is_drawn(host):
    host.options.leash = 6
    border = hand(host, "border")
    border.drag([(33, 5), (33.5, 15), (33, 25), (33.5, 40)], release=False)
    bounds = host.preview.line.boundingRect()
    assert abs(bounds.center().x() - 30) < 1.5, "it snaps to the jump at x = 30"
    host.options.leash = 0
    border.send(*_move((33, 42)))
    bounds = host.preview.line.boundingRect()
    assert 32.5 < bounds.center().x() < 34


def test_shift_draws_a_border_straight_and_free_again_without(host):
    host.options.leash = 6
    border = hand(host, "border")
    border.press((33, 5))
    for point in ((40, 12), (20, 20), (34, 40)):
        border.send(*_move(point, "s"))
    line = host.preview.line
    assert line.elementCount() == 2, "from the press to the pointer, not moved onto an edge"
    assert (line.elementAt(1).x, line.elementAt(1).y) == pytest.approx((34, 40), abs=1)


def test_whose_border_would_move_is_said_before_it_moves(host):
    border = hand(host, "border")
    border.drag([(30, 10), (36, 16), (36, 24), (30, 30)], release=False)
    assert "px from Block 2 to Block 1" in border.tool.hint
    assert host.preview.line_preview.boundingRect().left() == 30, "the old border"
    border.send(*_release((30, 30)))
    assert "Release" not in border.tool.hint
    border.drag([(45, 20), (55, 20)], release=False)
    assert "no pixel changes" in border.tool.hint
    border.tool.cancel(host)
    host.workspace.current.set_lock(2, True)
    border.drag([(30, 10), (24, 16), (24, 24), (30, 30)], release=False)
    assert "Block 2 is locked" in border.tool.hint


def test_what_is_found_out_of_a_line_that_is_gone_shows_nothing(host):
    host.waits = True
    for name in ("border", "give", "split", "outline"):
        user = hand(host, name)
        user.drag([(26, 10), (36, 16), (36, 24), (26, 30)], release=False)
        user.tool.cancel(host)
        for answer in host.waiting:
            answer()
        assert host.preview is None, name
        assert "Release" not in user.tool.hint


# outline


@pytest.mark.parametrize("end", ["enter", "double click", "first corner"])
def test_an_outline_of_clicks_is_closed(host, end):
    outline = hand(host, "outline")
    for corner in ((40, 10), (50, 10), (50, 20)):
        outline.click(corner)
    assert host.steps == []
    if end == "double click":
        outline.double_click((40, 20))
    elif end == "enter":
        outline.click((40, 20))
        assert outline.finish()
    else:
        outline.click((40, 20))
        outline.click((41, 10.5))
    assert (host.labels[11:19, 41:49] == 3).all()
    assert not outline.tool.busy
    assert outline.finish(), "it could still be adjusted"
    assert not outline.finish()


def test_an_outline_may_be_clicked_and_dragged_in_turns(host):
    outline = hand(host, "outline")
    outline.click((40, 10))
    outline.drag([(50, 10), (53, 15), (50, 20)])
    assert host.steps == []
    outline.click((40, 20))
    assert len(host.preview.corners) == 4  # type: ignore[union-attr]
    outline.finish()
    assert host.labels[15, 51] == 3
    assert host.labels[15, 54] == 2


def test_two_corners_are_no_outline_and_escape_drops_them(host):
    outline = hand(host, "outline")
    outline.click((40, 10))
    outline.click((50, 10))
    assert outline.finish()
    assert "three corners" in host.said[0]
    assert outline.cancel()
    assert not outline.cancel()
    assert host.preview is None
    assert host.steps == []


# split


def test_a_line_of_clicks_cuts_bent(host):
    split = hand(host, "split")
    split.click((29, 20), "c")
    split.click((50, 20))
    split.hover((55, 30))
    assert host.preview.line.currentPosition().x() == 55
    split.double_click((50, 49))
    assert host.labels[30, 40] != host.labels[10, 40]
    assert host.labels[30, 60] == host.labels[10, 40]


def test_a_suggested_line_is_given_up_by_escape_or_by_a_drag(small_frame, qapp):
    host = ToolHost(small_frame, np.ones((48, 64), np.int32))
    split = hand(host, "split")
    split.click((10, 5))
    assert split.cancel()
    assert host.preview is None
    split.click((10, 5))
    split.drag([(-1, 24), (30, 24), (65, 24)])
    assert host.labels[10, 10] == host.labels[10, 60] != host.labels[40, 10]
    assert len(host.steps) == 1


@pytest.mark.parametrize("end", ["click", "escape", "drag"])
def test_a_line_that_is_still_looked_for(small_frame, qapp, end):
    host = ToolHost(small_frame, np.ones((48, 64), np.int32))
    host.waits = True
    split = hand(host, "split")
    split.click((10, 5))
    assert "Looking" in split.tool.hint
    if end == "click":
        split.double_click((10, 5))
    elif end == "escape":
        assert split.cancel()
    else:
        split.drag([(-1, 24), (30, 24), (65, 24)])
    for answer in host.waiting:
        answer()
    assert host.steps == ([] if end == "escape" else ["Split Block 1"])
    assert (host.labels[5, 10] == host.labels[5, 50]) == (end != "click")
    assert not split.tool.busy


def test_where_nothing_suggests_itself_a_click_draws_nothing(host):
    split = hand(host, "split")
    split.click((45, -1))
    assert split.tool.undo_last(host), "off the frame, a line is begun"
    split.click((45, 5))
    assert "No line between two surfaces was found in Block 2" in host.said[-1]
    assert not split.tool.busy
    assert host.preview is None
    split.hover((50, 20))
    split.click((50, 20))
    assert host.steps == []


def test_open_ends_of_a_cut_run_on_to_the_boundary_and_are_shown(host):
    split = hand(host, "split")
    split.drag([(46.5, 14), (46.5, 20), (46.5, 25), (46.5, 32)], release=False)
    shown = host.preview.line_preview.boundingRect()
    assert shown.top() <= 0, "14 px short of the frame's rim"
    assert shown.bottom() >= 48
    assert host.preview.line.boundingRect().bottom() == 32
    assert "cut Block 2" in split.tool.hint
    split.send(*_release((46.5, 32)))
    assert (host.labels[:, 47:] == 2).all() != (host.labels[:, 30:46] == 2).all()
    assert len(set(np.unique(host.labels[:, 47:]))) == len(set(np.unique(host.labels[:, 30:46]))) == 1
    assert host.steps == ["Split Block 2"]
    assert "Release" not in split.tool.hint


def test_how_near_an_end_must_come_goes_by_the_screen(host):
    """Seen from afar, a hand misses the boundary by more pixels of the image."""
    give = hand(host, "give")
    line = [(25.0, 20.5), (40.0, 20.5), (54.0, 20.5)]  # 10 px short of the frame's rim
    for pixel, steps in ((0.25, []), (1.0, ["Give a part of Block 2 to Block 1"])):
        for kind, (x, y) in zip((PointerKind.PRESS, PointerKind.MOVE, PointerKind.MOVE), line, strict=True):
            give.tool.pointer(PointerEvent(kind, x, y, pixel=pixel), host)
        release = PointerEvent(PointerKind.RELEASE, *line[-1], pixel=pixel)
        host.attempt(partial(give.tool.pointer, release, host))
        assert host.steps == steps


def test_edges_that_are_still_looked_for_are_said(host):
    host.edge_data = None
    split = hand(host, "split")
    split.click((45, 20))
    assert "still being computed" in host.said[0]
    assert not split.tool.busy
    split.drag([(45, -1), (45, 49)])
    assert len(host.steps) == 1, "a line needs no edges: it is taken as drawn"


# brush


def test_similar_only_keeps_a_stroke_from_going_over_an_edge(host):
    host.workspace.current.edit(_all_to(host, 1), "All")
    host.document.select([1])
    host.document.info(2)
    host.document.select([2])
    host.options.similar_only = True
    paint = hand(host, "paint")
    paint.drag([(40, 24), (20, 24)])
    assert host.labels[24, 38] == 2
    assert (host.labels[:, :29] == 1).all(), "beyond the edge is another surface"
    host.edge_data = None
    paint.drag([(40, 44), (20, 44)])
    assert host.labels[44, 38] == 1
    assert "still being computed" in host.said[-1]


# give


def test_a_click_gives_a_part_or_with_control_a_region(host):
    host.workspace.current.edit(_all_to(host, 1), "All")
    host.workspace.current.edit(_box_to(host, 5, np.s_[5:15, 20:40]), "Box")
    host.document.info(7)
    host.document.select([7])
    give = hand(host, "give")
    give.hover((25, 10), "c")
    assert host.preview.line.boundingRect().getRect() == (20, 5, 10, 10), "up to where the region ends"
    give.hover((25, 10))
    assert host.preview.line.boundingRect().getRect() == (20, 5, 20, 10)
    give.click((25, 10), "c")
    assert (host.labels[5:15, 20:30] == 7).all()
    assert (host.labels[5:15, 30:40] == 5).all()
    give.hover((35, 10))
    assert host.preview.line.boundingRect().getRect() == (30, 5, 10, 10), "the label map has changed since"
    give.click((35, 10))
    assert not (host.labels == 5).any()
    give.click((35, 10))
    assert "already" in host.said[-1]


def test_a_line_cuts_a_part_off_for_the_block_that_it_begins_in(host):
    give = hand(host, "give")
    before = host.labels.copy()
    give.drag([(25, 20.5), (40, 20.5), (58, 20.5), (62, 20.5)])
    after = before.copy()
    after[:21, 30:] = 1
    assert np.array_equal(host.labels, after)
    assert host.document.selected == [], "the next line is for the block that it begins in"
    host.document.undo_stack.undo()
    give.drag([(25, 20.5), (40, 20.5)])
    assert "cuts nothing off" in host.said[-1]
    host.document.select([1])
    give.drag([(50.5, 46), (50.5, 30), (50.5, 10), (50.5, -2)])
    assert (host.labels[:, :50] == 1).all(), "begun in the block itself, it is for the chosen one: what is beside that"
    assert (host.labels[:, 51:] == 2).all()
    host.document.undo_stack.undo()
    host.workspace.current.set_lock(2, True)
    give.drag([(25, 20.5), (40, 20.5), (62, 20.5)])
    assert "locked" in host.said[-1]
    assert np.array_equal(host.labels, before)


def test_a_part_smaller_than_the_line_in_its_block_is_not_meant(host):
    """The line goes along the rim of a third block, farther than through the block that it cuts."""
    host.workspace.current.edit(_box_to(host, 3, np.s_[:10, 30:]), "Third block")
    host.workspace.current.edit(_box_to(host, 4, np.s_[10:13, 30:]), "To be cut")
    hand(host, "give").drag([(28, 8.5), (33, 8.5), (43.5, 8.5), (43.5, 15)])
    assert (host.labels[:10, 30:] == 3).all()
    assert (host.labels[10:13, 30:43] == 1).all()
    assert (host.labels[10:13, 44:] == 4).all()


def _three_blocks(host):
    """Block 3 in the upper left corner, above Block 1; Block 2 on the right of both."""
    host.workspace.current.edit(_box_to(host, 3, np.s_[:24, :30]), "Third block")


def test_a_line_begun_beside_the_chosen_block_is_for_that(host):
    _three_blocks(host)
    line = [(27.0, 20.0), (36.0, 34.0), (50.0, 40.0), (58.0, 49.0)]
    hand(host, "give").drag(line)
    assert host.labels[40, 35] == 3, "without a chosen block it is for the one that it begins in"
    host.document.undo_stack.undo()
    host.document.select([1])
    give = hand(host, "give")
    give.drag(line, release=False)
    assert "from Block 2 to Block 1" in give.tool.hint
    assert host.preview.line_preview.boundingRect().left() == 30
    give.send(*_release(line[-1]))
    assert host.labels[40, 35] == 1, "it begins 4 px from the chosen one"
    assert (host.labels[:24, :30] == 3).all()


def test_what_would_lie_apart_from_its_block_is_said(host):
    _three_blocks(host)
    host.workspace.current.edit(_box_to(host, 5, np.s_[:10, :10]), "Corner")
    host.document.select([5])
    give = hand(host, "give")
    give.drag([(50.5, 46), (50.5, 30), (50.5, -2)], release=False)
    assert "to Block 5" in give.tool.hint
    assert "disconnected" in give.tool.hint
    give.send(*_release((50.5, -2)))
    assert "Block 5 now has" in host.said[-1]
    host.said.clear()
    outline = hand(host, "outline")
    island = [(5.0, 30.0), (15.0, 30.0), (15.0, 40.0), (5.0, 40.0)]
    outline.drag(island, "c", release=False)
    assert "100 px from Block 1 to Block 5, disconnected from the rest of it" in outline.tool.hint
    outline.send(*_release(island[-1]))
    assert host.labels[35, 10] == 5
    assert host.said == [
        "Block 5 now has 100 px that are disconnected from the rest of it. "
        "Start an outline without Ctrl to make a new block."
    ]
    outline.drag([(5, 8), (12, 8), (12, 14), (5, 14)], "c", release=False)
    assert "from Block 3 to Block 5" in outline.tool.hint
    assert "disconnected" not in outline.tool.hint
    outline.send(*_release((5, 14)))
    assert len(host.said) == 1, "that touches it"
    outline.drag([(40, 30), (50, 30), (50, 40), (40, 40)], release=False)
    assert "to a new block" in outline.tool.hint
    outline.tool.cancel(host)
    assert "Release" not in outline.tool.hint


def test_giving_needs_a_block_that_takes(host):
    give = hand(host, "give")
    give.click((10, 10))
    assert host.document.selected == [1]
    give.click((50, 10), "s")
    assert host.document.selected == [2]
    host.workspace.current.set_lock(1, True)
    give.click((10, 10))
    assert "locked" in host.said[-1]
    assert (host.labels[:, :30] == 1).all()


# distrust


def test_there_must_be_depth_to_distrust(host):
    mark_invalid = hand(host, "mark_invalid")
    mark_invalid.click((14, 16))
    assert "no valid measured depth" in host.said[0]
    mark_invalid.drag([(50, 10), (55, 10)], "a")
    assert "no invalid depth" in host.said[1]
    assert host.steps == []


def test_erasing_beside_the_selected_block_says_why_nothing_happens(host):
    host.document.select([1])
    hand(host, "erase").drag([(45, 10), (50, 12)])
    assert "Block 1 is selected" in host.said[-1]


# choosing


@pytest.mark.parametrize("name", [kind.name for kind in KINDS])
def test_what_is_given_up_leaves_nothing(host, name):
    """Events of a drag that was given up come all the same, and mean nothing."""
    user = hand(host, name)
    host.options.hand_depth = 2.0
    before = host.labels.copy()
    user.drag([(25, 10), (35, 20), (45, 30)], "s" if name == "select" else "", release=False)
    assert user.tool.busy
    assert user.cancel()
    assert not user.tool.busy
    user.send(*_move((50, 10)))
    user.send(*_release((50, 10)))
    assert np.array_equal(host.labels, before)
    assert host.steps == []


# the pen


@pytest.mark.parametrize(
    ("name", "line"), [("border", [(30, 10), (36, 20), (30, 30)]), ("paint", [(45, 10), (50, 12)])]
)
def test_a_line_that_only_a_lock_holds_back_names_the_locked_block(host, name, line):
    before = host.labels.copy()
    host.document.select([1])
    host.workspace.current.set_lock(2, True)
    hand(host, name).drag(line)
    assert np.array_equal(host.labels, before)
    assert "Block 2 is locked" in host.said[-1]
