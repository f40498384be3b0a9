"""The linked views through real mouse events and the pixels they paint."""

import math

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QContextMenuEvent, QPainterPath
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from gui.base import theme
from gui.views.colours import depth_table, error_table
from gui.views.interaction import PointerKind, Preview
from gui.views.view_data import Before
from ilf.drawing.colours import robust_difference_level, to_indices
from tests.pins.window.hand import wheel

from .given_views import GivenViews, colour_at, place

HEIGHT, WIDTH = 48, 64
LEFT = Qt.MouseButton.LeftButton


def coded_rgb():
    """Colour that tells row and column of every pixel."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    return np.dstack((rows * 5, columns * 4 - (columns == 64), np.full_like(rows, 7))).astype(np.uint8)


@pytest.fixture
def views(shown):
    widget = GivenViews()
    depth = np.full((HEIGHT, WIDTH), 2.0, np.float32)
    depth[:, :10] = 1.0
    depth[10:20, 10:20] = np.nan
    widget.open(coded_rgb(), depth)
    return shown(widget, 900, 700)


def view_of(views, name="colour"):
    return views.cells[name].view


@pytest.mark.parametrize("zoom", [None, (slice(0, 48), slice(0, 64)), (slice(20, 30), slice(30, 42)), "closest"])
def test_a_press_names_the_pixel_that_is_painted_there(views, zoom):
    heard = []
    views.navigation.set_handler(heard.append)
    view = view_of(views)
    if zoom == "closest":
        for _ in range(40):
            wheel(view.viewport(), place(view, 33.3, 25.7))
    elif zoom is not None:
        views.transform.show(*zoom)
    for position in (view.viewport().rect().center(), view.viewport().rect().center() + QPoint(37, -23)):
        QTest.mouseClick(view.viewport(), LEFT, Qt.KeyboardModifier.ShiftModifier, position)
        red, green, _ = colour_at(view, position)
        press = next(event for event in reversed(heard) if event.kind is PointerKind.PRESS)
        assert (math.floor(press.y), math.floor(press.x)) == (red // 5, green // 4)
        assert press.shift
        assert not press.ctrl


@pytest.mark.parametrize("handler", [None, lambda event: False])
def test_left_drag_pans_all_views_when_nobody_wants_it(views, handler):
    views.navigation.set_handler(handler)
    view = view_of(views)
    QTest.mousePress(view.viewport(), LEFT, pos=QPoint(100, 100))
    QTest.mouseMove(view.viewport(), QPoint(140, 120))
    QTest.mouseRelease(view.viewport(), LEFT, pos=QPoint(140, 120))
    scale = view.transform.m11()
    for cell in views.sheet.shown:
        other = cell.view
        centre = other.to_image(other.viewport().rect().toRectF().center())
        assert centre.x() == pytest.approx(WIDTH / 2 - 40 / scale, abs=1 / scale)
        assert centre.y() == pytest.approx(HEIGHT / 2 - 20 / scale, abs=1 / scale)


def test_the_wheel_zooms_all_views_at_the_cursor(views):
    view = view_of(views, "depth-out")
    position = place(view, 12, 30)
    before = view.to_image(QPointF(position))
    wheel(view.viewport(), position)
    wheel(view.viewport(), position)
    after = view.to_image(QPointF(position))
    scales = {view_of(views, name).transform.m11() for name in views.cells}
    assert len(scales) == 1
    tolerance = 1 / scales.pop()
    assert after.x() == pytest.approx(before.x(), abs=tolerance)
    assert after.y() == pytest.approx(before.y(), abs=tolerance)


@pytest.mark.parametrize(
    ("key", "moved"),
    [
        (Qt.Key.Key_Left, (60, 0)),
        (Qt.Key.Key_Right, (-60, 0)),
        (Qt.Key.Key_Up, (0, 60)),
        (Qt.Key.Key_Down, (0, -60)),
    ],
)
def test_arrow_keys_with_alt_pan_by_screen_pixels(views, key, moved):
    view = view_of(views)
    for _ in range(8):
        wheel(view.viewport(), view.viewport().rect().center())
    before = view.transform.map(QPointF(32, 24))
    QTest.keyClick(view, key, Qt.KeyboardModifier.AltModifier)
    after = view.transform.map(QPointF(32, 24))
    assert ((after - before).x(), (after - before).y()) == pytest.approx(moved, abs=0.5)


def test_zoom_stays_within_its_limits_and_fit_comes_back(views):
    view = view_of(views)
    fitted = view.transform.m11()
    for _ in range(60):
        wheel(view.viewport(), QPoint(100, 100), -1)
    assert view.transform.m11() == pytest.approx(fitted / 4)
    for _ in range(60):
        wheel(view.viewport(), QPoint(100, 100))
    assert view.viewport().width() / view.transform.m11() == pytest.approx(8, abs=0.1)
    views.transform.fit()
    assert view.transform.m11() == pytest.approx(fitted)
    views.open(np.zeros((480, 640, 3), np.uint8), np.ones((480, 640), np.float32))
    views.transform.look_at(320, 240, 1)
    assert view.transform.m11() == pytest.approx(1)


def test_a_resize_keeps_a_fitted_frame_whole_and_any_other_zoom_unchanged(views, qtbot):
    views.resize(1300, 1000)
    qtbot.waitUntil(lambda: view_of(views).viewport().height() > 400)
    for view in (cell.view for cell in views.cells.values() if cell.isVisible()):
        corner = view.transform.map(QPointF(WIDTH, HEIGHT))
        assert view.viewport().rect().contains(corner.toPoint())
    views.transform.show(slice(10, 20), slice(10, 20))
    scale = view_of(views).transform.m11()
    views.resize(800, 600)
    qtbot.waitUntil(lambda: view_of(views).viewport().height() < 400)
    assert view_of(views).transform.m11() == scale


def test_a_context_menu_names_place_and_pixel(views, qtbot):
    view = view_of(views)
    position = place(view, 20.5, 10.5)
    event = QContextMenuEvent(QContextMenuEvent.Reason.Mouse, position, view.viewport().mapToGlobal(position))
    with qtbot.waitSignal(views.navigation.contextMenuRequested) as caught:
        QApplication.sendEvent(view.viewport(), event)
    where, x, y = caught.args
    assert where == view.viewport().mapToGlobal(position)
    assert (math.floor(x), math.floor(y)) == (20, 10)


def test_difference_is_in_millimetres_and_marks_filled_apart_from_missing(views):
    result = np.full((HEIGHT, WIDTH), 2.0, np.float32)
    result[:, :10] = 1.004
    result[:, 40:] = 1.996
    result[10:15, 10:20] = np.nan
    views.give(depth=result)
    views.set_content("difference", "difference:result:depth-in")
    views.sheet.set_layout("grid-difference")
    view, table = view_of(views, "difference"), views.cells["difference"].bar
    assert table.levels == (-5.0, 5.0)
    above, below, zero, filled, missing = (
        colour_at(view, place(view, x, y)) for x, y in ((5, 40), (50, 40), (30, 40), (15, 18), (15, 12))
    )
    assert above[0] > above[2] + 30
    assert below[2] > below[0] + 30
    assert max(zero) - min(zero) < 16
    assert filled[1] > max(filled[0], filled[2])
    assert max(missing) - min(missing) < 24
    views.give(depth=None)
    assert view.image.pixels is None


def test_the_expected_error_is_logarithmic_in_millimetres_and_tells_measured_from_missing(views):
    error = np.full((HEIGHT, WIDTH), np.nan, np.float32)
    error[10:20, 10:15] = 0.01
    error[10:15, 15:20] = np.repeat(np.float32([[0.001], [0.01], [0.01], [0.1], [0.1]]), 5, axis=1)
    views.give(expected=error)
    view, bar = view_of(views, "expected-error"), views.cells["expected-error"].bar
    assert (bar.levels, bar._logarithmic) == ((1.0, 100.0), True)
    small, middle, large = (colour_at(view, place(view, 17, y)) for y in (10.5, 12, 14))
    assert sum(small) < sum(middle) < sum(large)
    assert middle == tuple(error_table()[128, :3])
    measured, missing = colour_at(view, place(view, 40, 40)), colour_at(view, place(view, 17, 18))
    assert max(measured) - min(measured) < 16
    assert measured != missing
    views.give(expected=None)
    assert view.image.pixels is None
    assert bar.levels is None


def test_depth_colours_follow_levels_and_map(views):
    views.ranges.set("depth", "fixed", (1.0, 3.0))
    view = view_of(views, "depth-in")
    for name in ("viridis", "grey"):
        views.ranges.set_depth_map(name)
        expected = depth_table(name)[to_indices(np.float32([[2.0]]), 1.0, 3.0)[0, 0], :3]
        assert colour_at(view, place(view, 40, 40)) == tuple(expected)
    with pytest.raises(ValueError, match="below"):
        views.ranges.set("depth", "fixed", (2, 2))
    with pytest.raises(ValueError, match="turbo"):
        views.ranges.set_depth_map("rainbow")


def test_indices_keep_zero_for_missing():
    values = np.array([[np.nan, -1, 1, 1.5, 2, 9]], np.float32)
    assert to_indices(values, 1, 2).tolist() == [[0, 1, 1, 128, 255, 255]]
    assert robust_difference_level(np.full((4, 4), np.nan, np.float32)) == 1
    assert robust_difference_level(np.linspace(-30, 30, 10_000, dtype=np.float32)) == 50


def blocks():
    labels = np.zeros((HEIGHT, WIDTH), np.int32)
    labels[5:25, 5:30] = 1
    labels[5:25, 30:60] = 2
    return labels, np.array([[9, 9, 9, 255], [200, 0, 0, 255], [0, 100, 200, 255], [0, 200, 0, 255]], np.uint8)


def test_a_region_update_gives_the_same_picture_as_a_new_map(views):
    labels, table = blocks()
    views.paint(labels, table)
    changed = labels.copy()
    changed[20:30, 25:40] = 3
    changed[0:3, 0:4] = 2
    views.select(3)
    lines = view_of(views).lines.find().copy()
    views.stroke(slice(20, 30), slice(25, 40), 3)
    views.stroke(slice(0, 3), slice(0, 4), 2)
    in_boxes = views.blocks.pixels.copy(), view_of(views).lines.find().copy()
    assert not np.array_equal(lines, in_boxes[1])
    views.paint(changed, table)
    views.select(3)
    np.testing.assert_array_equal(in_boxes[0], views.blocks.pixels)
    np.testing.assert_array_equal(in_boxes[1], view_of(views).lines.find())


def border_colours(views, name, x, y):
    """Brightest and darkest that is painted across a border between pixels x - 1 and x."""
    view = view_of(views, name)
    at = place(view, x, y)
    greys = [sum(colour_at(view, at + QPoint(shift, 0))) / 3 for shift in range(-3, 4)]
    return max(greys), min(greys)


@pytest.mark.parametrize("opacity", [0.0, 0.45])
def test_lines_part_all_blocks_in_all_views_on_any_picture(views, opacity):
    labels, table = blocks()
    views.blocks.set_opacity(opacity)
    views.paint(labels, table)
    views.give(depth=np.full((HEIGHT, WIDTH), 2.0, np.float32))
    for name in ("colour", "depth-in", "depth-out"):
        flat = border_colours(views, name, 35, 15)
        bright, dark = border_colours(views, name, 30, 15)
        assert bright > flat[0] + 25
        assert dark < flat[1] - 10
    table[1, 3] = table[2, 3] = 0
    views.paint(labels, table)
    assert not view_of(views).lines.find().any()


def test_the_chosen_block_has_the_wider_line(views):
    labels, table = blocks()
    views.paint(labels, table)
    before = np.count_nonzero(view_of(views).lines.find() == 0xFFFFFFFF)
    views.select(2)
    assert before == 0
    view, white = view_of(views), (255, 255, 255)
    assert colour_at(view, place(view, 30, 15) + QPoint(1, 0)) == white
    assert colour_at(view, place(view, 30, 15) - QPoint(3, 0)) != white
    views.transform.show(slice(10, 20), slice(40, 50))
    assert not (view.lines.find() == 0xFFFFFFFF).any(), "the view's edge is no border"
    views.transform.fit()
    views.paint(np.full(labels.shape, 2, np.int32), table)
    assert (view.lines.find()[[0, -1]] == 0xFFFFFFFF).all(), "the frame's edge is"
    views.select(99)
    assert not (view_of(views).lines.find() == 0xFFFFFFFF).any()


def test_contours_alone_have_the_colours_of_their_blocks(views):
    labels, table = blocks()
    view = view_of(views)
    border = place(view, 30, 15)
    plain, beside = colour_at(view, place(view, 15.5, 15.5)), colour_at(view, border - QPoint(5, 0))
    views.paint(labels, table)
    views.blocks.set_contours_only(True)
    assert colour_at(view, place(view, 15.5, 15.5)) == plain
    assert colour_at(view, border - QPoint(1, 0)) == (200, 0, 0)
    assert colour_at(view, border) == (0, 100, 200)
    red, green, _ = colour_at(view, border - QPoint(5, 0))
    assert red > beside[0], "a tinted band along the line shows what is one block"
    assert green < beside[1]


def test_missing_and_distrusted_depth_are_striped(views):
    def colours(name, left, top):
        view = view_of(views, name)
        return {colour_at(view, place(view, left, top) + QPoint(shift, 0)) for shift in range(8)}

    plain = colours("colour", 12, 14)
    views.show_found(shows_missing=True)
    assert len(colours("colour", 12, 14)) > len(plain)
    assert colours("colour", 40, 40) == colours("colour", 40, 40)
    views.show_found(shows_missing=False)
    assert colours("colour", 12, 14) == plain
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[30:40, 30:50] = mask[12:14, 12:14] = True
    views.give(depth=np.full((HEIGHT, WIDTH), 2.0, np.float32))
    views.give(invalid_mask=mask)
    for name in ("colour", "depth-in", "depth-out"):
        assert (255, 144, 32) in colours(name, 40, 35)
    assert (255, 144, 32) not in colours("depth-in", 12, 13), "where nothing was measured there is nothing to distrust"
    views.set_content("difference", "difference:result:depth-in")
    views.sheet.set_layout("difference")
    view = view_of(views, "difference")
    assert view.shown[35, 40] == 0, "distrusted depth is not compared with"
    views.give(invalid_mask=None)
    assert view.shown[35, 40] > 0


def test_a_hidden_view_has_its_stripes_once_it_is_shown(views):
    cell, mask = views.cells["depth-in"], np.zeros((HEIGHT, WIDTH), bool)
    mask[30:40, 30:50] = True
    cell.hide()
    views.give(depth=np.full((HEIGHT, WIDTH), 2.0, np.float32))
    views.give(invalid_mask=mask)
    assert not cell.view.striped, "nobody sees them"
    cell.show()
    np.testing.assert_array_equal(cell.view.striped["invalid"], mask)


def test_invalid_depth_of_a_played_frame_is_striped(views):
    invalid, played = np.zeros((HEIGHT, WIDTH), bool), views.data.frame
    invalid[30:40, 30:50] = True
    view = view_of(views, "depth-in")
    for mask, striped in ((invalid, True), (None, False)):
        views.show_played(played.with_invalid_mask(mask), None, "", Before())
        colours = {colour_at(view, place(view, 40, 35) + QPoint(shift, 0)) for shift in range(8)}
        assert ((255, 144, 32) in colours) is striped


def test_what_lies_outside_the_view_has_stripes_and_a_name_of_its_own(views):
    outside = np.zeros((HEIGHT, WIDTH), bool)
    outside[:, :12] = True
    rgb, depth = views.data.frame.rgb, np.where(outside, np.float32(np.nan), np.float32(2.0))
    views.open(rgb, depth, outside)

    def is_blue(name):
        view = view_of(views, name)
        return (60, 140, 220) in {colour_at(view, place(view, 6, 20) + QPoint(shift, 0)) for shift in range(8)}

    assert is_blue("depth-in")
    assert not is_blue("colour"), "colour shows it with what is missing"
    views.show_found(shows_missing=True)
    assert is_blue("colour")
    views.open(rgb, depth)
    assert not is_blue("depth-in")


def test_stale_depth_is_greyed_and_only_what_changed_is_drawn_again(views):
    result = np.full((HEIGHT, WIDTH), 1.2, np.float32)
    views.give(depth=result)
    cell, view = views.cells["depth-out"], view_of(views, "depth-out")
    fresh = colour_at(view, place(view, 40, 30))
    stale = np.zeros(result.shape, bool)
    stale[:, 32:] = True
    drawn = []
    update = view.image.notify_change
    view.image.notify_change = lambda box: (drawn.append(box), update(box))
    views.give(depth=result, stale=stale)
    greyed = colour_at(view, place(view, 40, 30))
    assert max(greyed) - min(greyed) < (max(fresh) - min(fresh)) * 0.6
    assert colour_at(view, place(view, 20, 30)) == fresh
    assert [text for _, text in cell.strip._legend] == ["missing", "stale"]
    result[5:9, 3:7] = 1.9
    stale[:] = False
    views.give(depth=result, stale=stale)
    views.give(depth=result, stale=stale)
    assert drawn == [(slice(0, HEIGHT), slice(32, WIDTH)), (slice(0, HEIGHT), slice(3, WIDTH))]
    assert colour_at(view, place(view, 40, 30)) == fresh
    assert [text for _, text in cell.strip._legend] == ["missing"]


def test_correct_has_one_large_view_and_any_small_one_takes_its_place(views, qtbot):
    def widths():
        return {name: cell.width() for name, cell in views.cells.items() if cell.isVisible()}

    views.transform.show(slice(10, 20), slice(10, 20))
    views.sheet.set_layout("correct")
    assert max(widths(), key=widths().get) == "colour"
    assert widths()["colour"] > 2 * widths()["depth-out"]
    large, small = view_of(views), view_of(views, "depth-out")
    across = [view.viewport().width() / view.transform.m11() for view in (large, small)]
    assert across[0] == pytest.approx(across[1], rel=0.1), "a small view shows the same, smaller"
    QTest.mousePress(small.viewport(), Qt.MouseButton.MiddleButton, pos=QPoint(50, 50))
    before = small.to_image(QPointF(50, 50)), large.to_image(QPointF(50, 50))
    QTest.mouseMove(small.viewport(), QPoint(60, 50))
    QTest.mouseRelease(small.viewport(), Qt.MouseButton.MiddleButton, pos=QPoint(60, 50))
    assert small.to_image(QPointF(60, 50)).x() == pytest.approx(before[0].x(), abs=1 / small.transform.m11())
    assert large.to_image(QPointF(50, 50)).x() < before[1].x()
    QTest.mouseDClick(views.cells["depth-out"].strip, LEFT)
    assert max(widths(), key=widths().get) == "depth-out"
    QTest.mouseDClick(views.cells["depth-out"].strip, LEFT)
    assert list(widths()) == ["depth-out"]
    QTest.mouseDClick(views.cells["depth-out"].strip, LEFT)
    assert (views.sheet.layout_name, max(widths(), key=widths().get)) == ("correct", "depth-out")
    QTest.mouseRelease(views, LEFT)  # what has moved away meanwhile has not had it: it would be held in later tests


def test_handles_have_one_size_on_the_screen_and_never_hide_their_outline(views):
    views.open(np.zeros((HEIGHT, WIDTH, 3), np.uint8), np.full((HEIGHT, WIDTH), 2.0, np.float32))
    turns = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    corners = [(32 + 3 * math.cos(turn), 24 + 3 * math.sin(turn)) for turn in turns]
    views.set_preview(Preview(QPainterPath(), corners))

    def sizes():
        """Side of a handle, and the distance to the next one, on the screen."""
        view = view_of(views)
        image = view.viewport().grab().toImage()
        centre = view.transform.map(QPointF(*corners[3]))
        row = [image.pixelColor(x, round(centre.y())) for x in range(image.width())]
        yellow = [x for x, colour in enumerate(row) if colour.red() > 180 > colour.blue()]
        near = [x for x in yellow if abs(x - centre.x()) < 8]
        return len(near), math.dist(corners[3], corners[4]) * view.transform.m11()

    found = []
    for box in ((slice(0, 48), slice(0, 64)), (slice(17, 31), slice(23, 41)), (slice(20, 28), slice(28, 36))):
        views.transform.show(*box)
        found.append(sizes())
    sides, distances = zip(*found, strict=True)
    assert all(2 <= side <= 9 for side in sides)
    assert all(2 * side < distance for side, distance in found)
    assert sides[0] < sides[1] == sides[2]
    assert distances[0] < distances[1] < distances[2]


def test_a_new_palette_repaints_background_and_hatch(views, qapp, any_theme, qtbot):
    seen = {}
    for name in ("light", "dark"):
        theme.apply_theme(qapp, name)
        qtbot.waitUntil(lambda name=name: theme.is_dark(views.palette()) == (name == "dark"))
        view = view_of(views, "depth-in")
        expected = theme.colours(views.palette()).background
        assert colour_at(view, QPoint(1, 1)) == expected.getRgb()[:3]
        seen[name] = colour_at(view, place(view, 15, 15))
    assert min(seen["light"]) > max(seen["dark"]) + 60
