"""What the cells of the linked views show: contents, two depths compared, ranges, values under the pointer."""

import dataclasses

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

import ilf
from gui.views.colours import FULL, KINDS, ROBUST, strength_table
from gui.views.layers import CONTENTS, Content, Layer, checked
from gui.views.layouts import CELLS
from gui.views.view_data import READ, SIDES
from ilf.segmentation.edges.frame_edges import find_edges

from .given_views import GivenViews, colour_at, place

HEIGHT, WIDTH = 48, 64
LEFT = Qt.MouseButton.LeftButton


def flat(depth: float) -> np.ndarray:
    return np.full((HEIGHT, WIDTH), depth, np.float32)


@pytest.fixture
def views(shown):
    widget = GivenViews()
    depth = flat(2.0)
    depth[:, :10] = 1.0
    depth[10:20, 10:20] = np.nan
    widget.open(np.full((HEIGHT, WIDTH, 3), 90, np.uint8), depth)
    return shown(widget, 900, 700)


def painted_at(cell, x, y):
    return colour_at(cell.view, place(cell.view, x, y))


def drag(view, start, stop):
    places = [place(view, *point) for point in (start, stop)]
    QTest.mousePress(view.viewport(), LEFT, pos=places[0])
    QTest.mouseMove(view.viewport(), places[1])
    QTest.mouseRelease(view.viewport(), LEFT, pos=places[1])


def test_every_content_can_be_shown_in_every_cell_and_leaves_nothing_behind(views):
    views.give(depth=flat(2.1))
    views.give(ground_truth=flat(2.2))
    views.give(runs=[views.run("Run 1", flat(2.3))])
    start = views.contents()
    assert start == {name: content for name, (_, content) in CELLS.items()}
    cell = views.cells["depth-in"]
    before = cell.grab().toImage()
    for content in (*CONTENTS, *SIDES, "run-1", "evaluation", "difference:ground_truth:run-1", "depth-in"):
        views.set_content("depth-in", content)
    assert cell.grab().toImage() == before
    views.set_content("depth-in", "ground_truth")
    views.reset_contents()
    assert views.contents() == start
    for wrong in ("depth", "difference:result", "difference:result:colour"):
        with pytest.raises(ValueError, match="cannot show"):
            checked(wrong)
    with pytest.raises(ValueError, match="cell must be"):
        views.set_content("result", "ground_truth")


@pytest.mark.parametrize("content", CONTENTS)
def test_a_content_is_drawn_again_and_coloured_by_what_there_is(views, content):
    told = {*READ, *vars(views.data), "levels", "swipe"}
    assert set(CONTENTS[content].uses) <= told, "what is told of by no other name"
    assert CONTENTS[content].range_kind in {"", *KINDS}


def test_creases_are_shown_where_the_detector_tells_of_them(views):
    edges = find_edges(
        ilf.RGBDFrame(np.full((HEIGHT, WIDTH, 3), 90, np.uint8), flat(2.0)), ilf.BlockParameters(detector="canny")
    )
    cell = views.cells["depth-in"]
    views.set_content("depth-in", "creases")
    views.show_found(edges=edges)
    assert cell.view.value_at(3, 4) is None
    views.show_found(edges=dataclasses.replace(edges, crease=flat(0.25)))
    assert cell.view.value_at(3, 4) == 0.25
    views.set_content("depth-in", "strength")
    assert cell.view.value_at(3, 4) == 0


def test_the_difference_is_of_the_result_and_the_best_that_there_is(views):
    views.sheet.set_layout("grid-difference")
    cell = views.cells["difference"]
    views.give(depth=flat(2.1))
    assert cell.concrete == "difference:result:interpolated"
    assert views.shows("interpolated")
    assert cell.view.shown is None
    views.show_found(interpolated=flat(2.0))
    assert cell.view.value_at(30, 30) == pytest.approx(100, abs=0.01)
    views.give(ground_truth=flat(2.2))
    assert cell.view.value_at(30, 30) == pytest.approx(-100, abs=0.01)
    assert not views.shows("interpolated")
    before = views.run("Before", flat(2.3), is_ticked=False)
    views.give(runs=[before])
    assert "Before" in cell.strip.title
    views.give(runs=[views.run("Mine", flat(2.4), number=2), before])
    assert cell.view.value_at(30, 30) == pytest.approx(-300, abs=0.01)
    assert cell.bar.levels == (-500, 500)
    assert "Mine" in cell.strip.title


def test_equal_depths_are_said_to_be_equal(views):
    views.sheet.set_layout("grid-difference")
    cell = views.cells["difference"]
    views.give(depth=flat(2.0))
    views.give(runs=[views.run("Same", flat(2.0))])
    assert cell.view.shown is None
    assert cell.view.layer.message == "No difference"
    views.set_content("difference", "difference:result:depth-in")
    other = flat(2.0)
    other[:, :10] = 1.0
    views.give(depth=other)
    assert cell.view.shown is not None, "what was filled is to be seen"
    assert "no difference" in cell.strip._text


def test_a_handle_parts_two_depths_and_is_dragged_past_the_tool(views):
    heard = []
    views.navigation.set_handler(lambda event: heard.append(event.kind.name))
    views.ranges.set("depth", "fixed", (1.0, 3.0))
    views.give(depth=flat(2.9))
    views.give(runs=[views.run("Run 1", flat(1.1))])
    cell = views.cells["depth-out"]
    run_2 = painted_at(cell, 10.5, 30.5)
    views.sides.divide(True)
    run_1 = painted_at(cell, 10.5, 30.5)
    assert run_1 != run_2 == painted_at(cell, 60.5, 30.5)
    drag(cell.view, (WIDTH / 2, 30), (50, 30))
    assert views.sides.x == 50
    assert painted_at(cell, 45.5, 30.5) == run_1
    assert painted_at(cell, 60.5, 40.5) == run_2
    assert not {"PRESS", "MOVE", "RELEASE"} & set(heard)
    assert cell.view.value_at(45, 30) == pytest.approx(1.1)
    drag(views.cells["depth-in"].view, (50, 30), (20, 30))
    assert views.sides.x == 50, "where there is no handle there is nothing to drag"
    assert "PRESS" in heard
    for x, is_over in ((50, True), (20, False)):
        QTest.mouseMove(cell.view.viewport(), place(cell.view, x, 30))
        assert (cell.view.viewport().cursor().shape() is Qt.CursorShape.SplitHCursor) is is_over
    views.give(ground_truth=flat(2.9))
    views.sides.choose("ground_truth", "run-1")
    assert painted_at(cell, 45.5, 40.5) == run_2
    views.give(ground_truth=flat(1.1))
    assert painted_at(cell, 45.5, 40.5) == run_1, "a side that changes is drawn anew"
    views.sides.choose("result", "run-1")
    assert painted_at(cell, 45.5, 40.5) == run_2
    views.open(views.data.frame.rgb, flat(1.1))
    assert views.data.swipe_column == views.sides.x == WIDTH / 2, "of another frame, it stands in the middle"
    views.ranges.set("depth", "fixed", (1.0, 3.0))
    views.give(depth=flat(2.9))
    views.sides.divide(False)
    assert painted_at(cell, 60.5, 40.5) == run_2


def test_blocks_of_the_two_sides_are_parted_where_they_differ(views):
    table = np.array([[0, 0, 0, 0], [200, 0, 0, 255], [0, 0, 200, 255]], np.uint8)
    ones = np.ones((HEIGHT, WIDTH), np.int32)
    views.blocks.set_opacity(1.0)
    views.paint(ones, table)
    views.give(depth=flat(2.9))
    cell = views.cells["colour"]
    views.give(runs=[views.run("Run 1", flat(1.1), labels=2 * ones)])
    views.sides.divide(True)
    assert [painted_at(cell, x, 40.5) for x in (10.5, 50.5)] == [(0, 0, 200), (200, 0, 0)]
    beside = 6 / cell.view.transform.m11()
    covered = [painted_at(cell, WIDTH / 2 + side * beside, HEIGHT / 2) for side in (-1, 1)]
    assert covered == [(0, 0, 200), (200, 0, 0)], "no grip over the photo"
    drag(cell.view, (WIDTH / 2, 30), (20, 30))
    assert [painted_at(cell, x, 40.5) for x in (10.5, 30.5)] == [(0, 0, 200), (200, 0, 0)]
    views.sides.choose("depth-in", "run-1")
    assert painted_at(cell, 50.5, 40.5) == (0, 0, 200)
    views.sides.divide(False)
    assert painted_at(cell, 10.5, 40.5) == (200, 0, 0)


def test_ranges_are_robust_full_or_fixed_and_stay_when_they_are_locked(views):
    depth = flat(2.0)
    depth[0, :3] = 9.0
    depth[:, 60:] = 3.0
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    views.open(rgb, depth)
    assert views.ranges.depth == (2.0, 3.0)
    views.ranges.set("depth", FULL)
    assert views.ranges.depth == (2.0, 9.0)
    views.ranges.set("depth", "fixed", (1.5, 2.5))
    assert views.cells["depth-in"].bar.levels == (1.5, 2.5)
    views.open(rgb, depth)
    assert views.ranges.depth == (2.0, 3.0), "numbers were for the frame before"
    views.ranges.set("depth", ROBUST, (1.0, 4.0), locked=True)
    views.open(rgb, depth)
    assert views.ranges.depth == (1.0, 4.0)
    views.ranges.set("depth", ROBUST, locked=False)
    assert views.ranges.depth == (2.0, 3.0)


def test_a_title_opens_a_menu_and_a_double_click_still_enlarges(views, qtbot):
    views.give(depth=flat(2.1))
    views.give(runs=[views.run("Mine & yours", flat(2.2))])
    cell = views.cells["depth-in"]
    QTest.mouseClick(cell.strip, LEFT, pos=QPoint(10, 5))
    assert cell._menu.isVisible()
    entries = {action.text(): action for action in cell._menu.actions()}
    assert entries["Depth in"].isChecked()
    assert not entries["Ground truth"].isEnabled()
    assert "no guide" in entries["Guide, fitted"].toolTip(), "what the frame lacks"
    with qtbot.waitSignal(views.shownChanged):
        entries["Mine && yours"].trigger()
    cell._menu.close()
    assert cell.strip.title == "Mine & yours"
    QTest.mouseDClick(cell.strip, LEFT, pos=QPoint(10, 5))
    assert not cell._menu.isVisible()
    assert views.sheet.layout_name == "depth-in"
    QTest.mouseClick(cell.strip, LEFT, pos=QPoint(cell.strip.width() - 20, 5))
    assert not cell._menu.isVisible(), "the legend opens nothing"


@pytest.mark.parametrize(
    ("chosen", "sides"),
    [
        (("", ""), ("run-2", "result")),
        (("run-1", ""), ("run-1", "run-2")),
        (("run-1", "result"), ("run-2", "result")),
        (("", "run-1"), ("run-2", "run-1")),
        (("", "depth-in"), ("run-1", "depth-in")),
        (("result", "result"), ("run-2", "result")),
        (("run-2", "run-2"), ("run-1", "run-2")),
    ],
)
def test_a_run_is_never_compared_with_itself(views, chosen, sides):
    views.give(depth=flat(2.0))
    mine, other = views.run("Mine", flat(2.0), 4, is_result=True), views.run("Other", flat(2.3), 3)
    views.give(runs=[mine, other])
    views.sides.choose(*chosen)
    assert views.data.sides == sides
    views.sheet.set_layout("grid-difference")
    assert views.cells["difference"].concrete == "difference:result:run-2"


def test_a_new_layer_is_one_function_and_one_line(views, monkeypatch):
    def nearness(material, name):
        return Layer(
            (material.frame.own_depth,), lambda depth: 1 / depth, (0.0, 1.0), table=strength_table(), text="of depth in"
        )

    monkeypatch.setitem(CONTENTS, "nearness", Content("Nearness", nearness, frozenset({"invalid_mask"}), unit="1/m"))
    views.set_content("colour", "nearness")
    cell = views.cells["colour"]
    assert cell.strip.title == "Nearness"
    assert cell.view.value_at(30, 30) == pytest.approx(0.5)
    assert cell.view.value_at(5, 30) == pytest.approx(1.0)
    assert cell.view.value_at(15, 15) is None
    assert painted_at(cell, 30, 30) == tuple(strength_table()[128][:3])
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[30, 30] = True
    views.give(invalid_mask=mask)
    assert cell.view.value_at(30, 30) is None
    cell.open_menu()
    chosen = [action for action in cell._menu.actions() if action.isChecked()]
    cell._menu.close()
    assert [action.text() for action in chosen] == ["Nearness"]
