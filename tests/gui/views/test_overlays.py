"""What lies over the pictures and moves: nothing of it stays where it was, and it goes with its picture."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath
from PySide6.QtWidgets import QApplication

from gui.features.inspect.marks import Marks
from gui.state.parts import Part
from gui.views.drawings import HaloPath, PointsItem
from gui.views.interaction import Preview

from .given_views import GivenViews

HEIGHT, WIDTH = 240, 320
STEPS = 12
UNLIKE = 32
"""Difference of a colour that no scaling makes: Qt rounds a picture otherwise where only part of it is painted."""

Move = Callable[[int], None]


def _place(step):
    """Another place of the frame, at and near its rims, too."""
    return WIDTH * (0.5 + 0.5 * math.sin(0.31 * step)), HEIGHT * (0.5 + 0.5 * math.cos(0.23 * step))


@pytest.fixture
def views(shown):
    """Four views of a smooth frame, whose colour bars follow the cursor."""
    views = GivenViews()
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    rgb = np.dstack((rows // 2, columns // 2, (rows + columns) // 4)).astype(np.uint8)
    depth = (1 + columns / WIDTH + rows / HEIGHT).astype(np.float32)
    views.open(rgb, depth)
    views.give(depth=depth + np.float32(0.02))
    views.give(expected=np.float32(0.01) * depth)
    labels = (1 + columns // (WIDTH // 4)).astype(np.int32)
    views.paint(labels, np.array([[0, 0, 0, 0]] + [[90, 120, 150, 255]] * 4, np.uint8))
    return shown(views, 1000, 760)


def _cursor(views):
    return lambda step: None  # it moves in any case


def _tool_line(views):
    def move(step):
        path = QPainterPath(QPointF(*_place(step - 1)))
        path.lineTo(*_place(step + 7))
        area = QPainterPath()
        area.addEllipse(QPointF(*_place(step)), 9, 9)
        views.set_preview(Preview(path, [_place(step)], step % 2 > 0, area))

    return move


def _rings(views):
    items = [HaloPath(1.5, QColor(255, 96, 208), 170, 5.5) for _ in views.cells]
    for cell, item in zip(views.cells.values(), items, strict=True):
        cell.view.add(item)

    def move(step):
        path = QPainterPath()
        path.addEllipse(QPointF(*_place(step)), 10, 10)
        for item in items:
            item.set_path(path)

    return move


def _swipe(views):
    views.sides.choose("depth-in", "result")
    views.sides.divide(True)
    return lambda step: views.sides.move_to(_place(step)[0])


def _inspected(views):
    items = [Marks(cell.view) for cell in views.cells.values()]

    def move(step):
        at, other = _place(step), _place(step + 5)
        region = slice(20, 40 + step), slice(30, 60 + step)
        for item in items:
            item.show((at, other), _place(step + 2), region, [(other, at)], ["1.234 m"])

    return move


def _names(views):
    views.blocks.show_names(True)

    def move(step):
        for label in range(1, 5):
            views.document.change_info(label, name="A block whose name is a long one" if label == 1 + step % 4 else "")
        views.blocks.draw(Part.INFOS)

    return move


def _selection(views):
    return lambda step: views.select(1 + step % 4)


OVERLAYS = [_cursor, _tool_line, _rings, _swipe, _inspected, _names, _selection]


def _numbers(picture):
    image = picture.toImage().convertToFormat(QImage.Format.Format_RGBA8888)
    return np.array(image.constBits(), np.int16).reshape(image.height(), image.width(), 4)


def _stale(views):
    """How many pixels of the screen are not what they would be if all were painted anew."""
    shown = _numbers(views.screen().grabWindow(views.winId()))
    return int(np.count_nonzero(np.abs(shown - _numbers(views.grab())).max(axis=2) > UNLIKE))


@pytest.mark.parametrize("overlay", OVERLAYS)
def test_nothing_stays_where_it_was(views, overlay):
    move = overlay(views)
    for scale in (1.5, 3.0, 0.4):
        views.transform.look_at(WIDTH / 2, HEIGHT / 2, scale)
        for step in range(STEPS):
            move(step)
            x, y = _place(step + 3)
            views.navigation.point_at((min(int(x), WIDTH - 1), min(int(y), HEIGHT - 1)))
            if step % 6 < 2:  # it is painted after one move and after several
                QApplication.processEvents()
        QApplication.processEvents()
        assert _stale(views) == 0, f"at {scale} screen pixels per pixel"


def _square():
    path = QPainterPath()
    path.addRect(90, 60, 60, 50)
    return path


@pytest.mark.parametrize(
    "parts", [{"line": _square()}, {"corners": [(90, 60)]}, {"area": _square()}, {"line_preview": _square()}]
)
def test_every_part_of_a_preview_is_drawn_until_it_ends(views, parts):
    viewport = views.cells["colour"].view.viewport()
    before = _numbers(viewport.grab())
    views.set_preview(Preview(**{"line": QPainterPath()} | parts))
    assert (_numbers(viewport.grab()) != before).any()
    views.set_preview(None)
    assert (_numbers(viewport.grab()) == before).all()


def test_the_line_of_a_preview_is_dashed_where_it_is_a_suggestion(views):
    viewport, pictures = views.cells["colour"].view.viewport(), []
    for given in ({}, {"dashed": False}, {"dashed": True}):
        views.set_preview(Preview(_square(), **given))
        pictures.append(_numbers(viewport.grab()))
    assert (pictures[0] == pictures[1]).all()
    assert (pictures[1] != pictures[2]).any()


def test_lines_around_blocks_are_repainted_in_the_whole_frame(views):
    assert views.cells["colour"].view.lines.extent == QRectF(0, 0, WIDTH, HEIGHT)


@pytest.fixture
def half_empty(views):
    """The same views before there is a result."""
    views.give(depth=None)
    views.give(expected=None)
    return views


@pytest.mark.parametrize("overlay", OVERLAYS)
def test_nothing_lies_over_a_view_that_has_no_picture(half_empty, overlay):
    viewport = half_empty.cells["depth-out"].view.viewport()
    before = _numbers(viewport.grab())
    overlay(half_empty)(3)
    half_empty.navigation.point_at((40, 50))
    assert (_numbers(viewport.grab()) == before).all()
    half_empty.give(depth=half_empty.data.frame.measured)
    assert (_numbers(viewport.grab()) != before).any()


def _dots(views, content):
    view = next(cell.view for cell in views.cells.values() if cell.content == content)
    return sum(middles.size() for _, middles in view.points.dots)


def test_sparse_depth_is_drawn_as_dots_of_the_screens_size(views):
    rgb = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    depth = np.full((HEIGHT, WIDTH), np.nan, np.float32)
    assert _dots(views, "depth-in") == 0, "dense depth needs none"
    depth[20::40, 30::50] = 2.0
    depth[100, 160] = 5.0
    views.open(rgb, depth)
    assert _dots(views, "depth-in") == np.isfinite(depth).sum()
    points = PointsItem(0)
    indices = np.zeros((40, 60), np.uint8)
    indices[10, 20] = 7
    table = np.zeros((256, 4), np.uint8)
    table[7] = 255, 0, 0, 255
    points.set_indices(indices, table)
    for scale, side in ((0.5, PointsItem.SIZE), (2.0, PointsItem.SIZE), (8.0, 0)):
        image = QImage(480, 320, QImage.Format.Format_RGB32)
        image.fill(0)
        painter = QPainter(image)
        painter.scale(scale, scale)
        points.paint(painter, 1 / scale)
        painter.end()
        reds = np.ndarray((320, 480), np.uint32, image.constBits()) == 0xFFFF0000
        assert reds.sum() == side**2, f"at {scale}"
        if side:
            rows, columns = np.nonzero(reds)
            assert (rows.mean() + 0.5, columns.mean() + 0.5) == pytest.approx((10.5 * scale, 20.5 * scale), abs=1)
    indices[:] = 7
    points.set_indices(indices, table)
    assert points.dots == [], "too many for dots"
