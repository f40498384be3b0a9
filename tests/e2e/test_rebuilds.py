"""How often the table of blocks is rebuilt: once per click, per opening, per undo."""

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from gui.features.blocks.feature import BlocksFeature
from ilf import RGBDFrame

from .conftest import open_frame, write_frame


class _Count:
    """How often a widget's method has been called since the last look, the events that are due done first."""

    def __init__(self, monkeypatch, owner, name):
        self._calls = 0
        method = getattr(owner, name)

        def counted(*arguments):
            self._calls += 1
            return method(*arguments)

        monkeypatch.setattr(owner, name, counted)

    def taken(self):
        for _ in range(3):
            QApplication.processEvents()
        calls, self._calls = self._calls, 0
        return calls


def _click(window, x, y):
    view = window.views.cells["colour"].view
    place = view.viewportTransform().map(QPointF(x, y)).toPoint()
    QTest.mouseClick(view.viewport(), Qt.MouseButton.LeftButton, pos=place)


def test_one_click_an_edit_and_its_undo_rebuild_the_table_once_each(opened, monkeypatch):
    rows = _Count(monkeypatch, opened.feature(BlocksFeature).table, "set_rows")
    _click(opened, 50, 24)
    assert rows.taken() == 1
    _click(opened, 50, 24)
    assert rows.taken() == 0, "it is chosen already"
    _click(opened, 5, 24)
    assert rows.taken() == 1
    opened.feature(BlocksFeature).table.selectRow(0)
    assert rows.taken() == 1

    depth = _Count(monkeypatch, opened.views.cells["depth-out"], "draw_again")
    opened.actions_["select_all"].trigger()
    assert (rows.taken(), depth.taken()) == (1, 0)
    opened.actions_["merge_blocks"].trigger()
    assert (rows.taken(), depth.taken()) == (1, 1)
    opened.actions_["undo"].trigger()
    assert (rows.taken(), depth.taken()) == (1, 1)
    opened.actions_["redo"].trigger()
    assert (rows.taken(), depth.taken()) == (1, 1)


def test_a_window_at_rest_draws_nothing_and_takes_no_turns(opened, qtbot, monkeypatch):
    opened.hide()
    opened.show()
    qtbot.wait(300)
    turns = _Count(monkeypatch, opened.workspace, "tell")
    qtbot.wait(200)
    assert turns.taken() <= 2


def test_opening_a_frame_rebuilds_the_table_once_and_turning_to_it_too(opened, qtbot, tmp_path, monkeypatch):
    frame = opened.workspace.current.frame
    folder = write_frame(tmp_path / "other", RGBDFrame(frame.rgb[:40], frame.depth[:40]))
    rows = _Count(monkeypatch, opened.feature(BlocksFeature).table, "set_rows")
    pictures = _Count(monkeypatch, opened.views.ranges, "reset_for_frame")
    open_frame(opened, qtbot, folder)
    assert rows.taken() <= 2, "without blocks at first, if these take their time"
    assert pictures.taken() == 1
    opened.actions_["previous_frame"].trigger()
    assert (rows.taken(), pictures.taken()) == (1, 1)


def test_a_stroke_repaints_its_box_alone_until_it_ends(opened, monkeypatch):
    view = opened.views.cells["colour"].view
    _click(opened, 50, 24)
    opened.actions_["tool_paint"].trigger()
    rows = _Count(monkeypatch, opened.feature(BlocksFeature).table, "set_rows")
    whole = _Count(monkeypatch, opened.views.blocks.items[0], "set_pixels")
    rows.taken()
    boxes = []
    monkeypatch.setattr(opened.views.blocks.items[0], "notify_change", boxes.append)
    first, second = (view.viewportTransform().map(QPointF(x, 24)).toPoint() for x in (20, 14))
    QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, pos=first)
    QTest.mouseMove(view.viewport(), second)
    assert (rows.taken(), whole.taken()) == (0, 0)
    assert boxes
    np.testing.assert_array_equal(opened.views.blocks.labels, opened.workspace.current.labels)
    QTest.mouseRelease(view.viewport(), Qt.MouseButton.LeftButton, pos=second)
    assert (rows.taken(), whole.taken()) == (1, 0)
    opened.actions_["undo"].trigger()
    assert rows.taken() == 1
    np.testing.assert_array_equal(opened.views.blocks.labels, opened.workspace.current.labels)
