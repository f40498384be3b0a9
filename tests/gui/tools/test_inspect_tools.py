"""The tools that inspect: a line, a rectangle, points to measure between. They leave blocks alone."""

import numpy as np

import ilf
from gui.state.document import Document
from gui.tools.kinds import KINDS
from gui.views.interaction import PointerKind

from ..tool_host import hand


def measured(host):
    return list(host.document.state.looked.measurements)


def test_inspecting_changes_no_block_and_needs_no_edges(host):
    host.edge_data = None
    host.document.change_info(1, locked=True)
    labels = host.labels.copy()
    for kind in KINDS:
        if not kind.inspects:
            continue
        user = hand(host, kind.name)
        user.drag([(5, 5), (20, 30), (40, 35)])
        user.click((50, 10))
    assert not host.steps
    assert not any("edges" in text for text in host.said)
    assert np.array_equal(host.labels, labels)


# the profile line


def test_a_line_is_drawn_moved_by_its_ends_and_as_a_whole(host):
    user = hand(host, "profile")
    user.drag([(5.2, 6.7), (30, 20), (40.9, 26.1)])
    assert host.document.state.looked.line == ((5.5, 6.5), (40.5, 26.5))
    user.drag([(40, 27), (50.0, 30.0)])
    assert host.document.state.looked.line == ((5.5, 6.5), (50.5, 30.5))
    user.drag([(6, 6), (10.0, 6.0)])
    assert host.document.state.looked.line == ((10.5, 6.5), (50.5, 30.5))
    user.drag([(30.5, 18.5), (33.4, 23.6)])
    assert host.document.state.looked.line == ((13.5, 11.5), (53.5, 35.5))
    user.drag([(5, 45), (20, 46)], "s")
    assert host.document.state.looked.line == ((5.5, 45.5), (20.5, 45.5))


def test_a_line_keeps_to_the_frame(host):
    user = hand(host, "profile")
    user.drag([(20, 20), (90, -9)])
    assert host.document.state.looked.line == ((20.5, 20.5), (63.5, 0.5))
    user.drag([(42, 10.5), (42, 90)])
    assert host.document.state.looked.line == ((20.5, 47.5), (63.5, 27.5))


def test_lines_and_measurements_stay_with_their_frame(host, small_frame):
    first = host.document
    hand(host, "profile").drag([(5, 5), (40, 5)])
    hand(host, "measure").click((5, 5))
    line, former = host.document.state.looked.line, measured(host)
    host.workspace.open_document(Document.of(ilf.Run(small_frame, host.labels), "other", "other"))
    assert host.document.state.looked.line is None
    assert measured(host) == []
    host.workspace.show(first)
    assert host.document.state.looked.line == line
    assert measured(host) == former


# the rectangle


def test_a_rectangle_is_drawn_resized_and_moved(host):
    user = hand(host, "rectangle")
    user.drag([(30.2, 12.5), (12.7, 30.1)])
    assert host.document.state.looked.region == (slice(12, 31), slice(12, 31))
    user.drag([(31, 20), (45.2, 22)])
    assert host.document.state.looked.region == (slice(12, 31), slice(12, 45))
    user.drag([(12, 12), (18, 14)])
    assert host.document.state.looked.region == (slice(14, 31), slice(18, 45))
    user.drag([(30, 22.5), (90, 22.5)])
    assert host.document.state.looked.region == (slice(14, 31), slice(37, 64))
    user.drag([(37, 22), (70, 22)])
    assert host.document.state.looked.region == (slice(14, 31), slice(63, 64))
    user.drag([(2, 2), (6, 6)], release=False)
    assert host.document.state.looked.region == (slice(2, 6), slice(2, 6))
    user.tool.cancel(host)
    assert host.document.state.looked.region == (slice(14, 31), slice(63, 64))
    assert user.tool.remove(host)
    assert host.document.state.looked.region is None


# measuring


def test_a_drag_makes_a_measurement(host):
    user = hand(host, "measure")
    user.drag([(3, 3), (9, 3), (20, 3)])
    assert measured(host) == [((3.5, 3.5), (20.5, 3.5))]
    assert host.preview is None
    user.drag([(12, 15), (30, 5), (40, 5)])  # a press without depth
    assert len(host.said) == 1
    assert "no depth at x 12, y 15" in host.said[0]
    assert not user.tool.busy
    user.drag([(5, 40), (40, 5)], release=False)
    user.tool.cancel(host)
    assert not user.tool.busy
    assert len(measured(host)) == 1


def test_a_point_is_dragged_and_put_back(host):
    user = hand(host, "measure")
    user.click((3, 3))
    user.hover((25, 40))
    assert host.preview is not None
    user.click((20, 3))
    assert host.preview is None
    user.click((5, 40))
    assert user.tool.undo_last(host)
    assert not user.tool.busy
    user.drag([(21, 3), (22, 30)])
    assert measured(host) == [((3.5, 3.5), (22.5, 30.5))]
    user.drag([(3, 3), (10, 40)], release=False)
    assert measured(host)[0][0] == (10.5, 40.5)
    user.tool.cancel(host)
    assert measured(host)[0][0] == (3.5, 3.5)


def test_a_point_without_a_place_in_space_is_refused(host, small_frame):
    user = hand(host, "measure")
    user.click((12, 15))
    assert "no depth at x 12, y 15" in host.said[0]
    assert user.send(PointerKind.HOVER, (5, 5))
    assert not user.tool.busy
    blind = ilf.RGBDFrame(small_frame.rgb, small_frame.depth)
    host.workspace.open_document(Document.of(ilf.Run(blind, host.labels), "blind", "blind"))
    user.click((3, 3))
    assert "intrinsics" in host.said[1]
    assert measured(host) == []
