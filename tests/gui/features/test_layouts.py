"""Layouts of the window: each stays as it was left, own ones are kept, and each can be reset."""

from dataclasses import replace

import pytest
import shiboken6
from PySide6.QtCore import QByteArray, QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget, QMainWindow, QWidget

from gui.app.main_window import MainWindow
from gui.features.layouts import Arrangement, LayoutsFeature, LayoutStore
from gui.widgets.docks import Docks, PanelGroup


@pytest.fixture
def opened(shown):
    """Opens windows that remember their layouts, one after the other."""

    def open_window() -> tuple[MainWindow, LayoutsFeature]:
        window = shown(MainWindow(), 1280, 800)
        return window, window.feature(LayoutsFeature)

    return open_window


def _key(window: MainWindow, key: Qt.Key, modifier: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier) -> None:
    QTest.keyClick(window, key, modifier)


def _click(window: MainWindow, title: str) -> None:
    next(action for action in window.panels.toggles() if action.text() == title).trigger()


@pytest.mark.parametrize("name", ["block_names", "film_strip", "live", "only_icons", "propagate_flow", "show_missing"])
def test_what_is_switched_holds_for_the_next_window(opened, name):
    action = opened()[0].actions_[name]
    action.trigger()
    assert opened()[0].actions_.is_on(name) == action.isChecked()


def test_each_stays_as_it_was_left_also_for_the_next_window(qtbot, opened):
    window, layouts = opened()
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    assert window.panels.open == ["Blocks", "Parameters"]
    _key(window, Qt.Key.Key_F4)
    assert (layouts.present, window.views.sheet.layout_name) == ("correct", "correct")
    assert window.panels.open == [], "correcting begins with the largest picture"
    assert window.actions_["contours_only"].isChecked()
    _click(window, "Blocks")
    _key(window, Qt.Key.Key_F4)
    assert (layouts.present, window.views.sheet.layout_name) == ("standard", "grid")
    assert window.panels.open == ["Blocks", "Parameters"]
    _click(window, "Parameters")
    window.actions_["cloud_beside"].trigger()
    window.views.sides.choose("depth-in", "ground_truth")
    _key(window, Qt.Key.Key_F12)
    assert set(window.panels.open) >= {"Parameters", "Convergence"}
    window.actions_["contours_only"].trigger()
    window.close()
    second, layouts = opened()
    assert layouts.present == "tune"
    assert set(second.panels.open) >= {"Parameters", "Convergence"}
    assert second.actions_["contours_only"].isChecked()
    assert (second.actions_["cloud_beside"].isChecked(), second.views.data.chosen_sides) == (False, ("", ""))
    layouts.turn("standard")
    assert second.panels.open == ["Blocks"]
    assert (second.actions_["cloud_beside"].isChecked(), second.views.data.chosen_sides) == (
        True,
        ("depth-in", "ground_truth"),
    )
    second.views.sheet.set_layout("row")
    assert (layouts.present, second.panels.open) == ("standard", ["Blocks"])
    assert second.views.sheet.layout_name == "row"
    layouts.reset()
    assert (second.views.sheet.layout_name, second.panels.open) == ("grid", ["Blocks", "Parameters"])
    second.close()


def _area(window: MainWindow, title: str) -> Qt.DockWidgetArea:
    return window.dockWidgetArea(window.findChild(QDockWidget, title))


def test_own_layouts_have_keys_are_renamed_deleted_and_brought_back(opened):
    window, layouts = opened()
    left, right = Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea
    assert not layouts.save("inspect"), "those that are always there are not replaced"
    _click(window, "History")
    window.addDockWidget(left, window.findChild(QDockWidget, "Blocks"))
    window.views.sheet.set_layout("depth-out")
    window.views.set_content("colour", "depth-in")
    assert layouts.save("Mine & yours")
    _click(window, "History")
    window.actions_["layout_standard"].trigger()
    layouts.reset()
    assert (_area(window, "Blocks"), window.views.sheet.layout_name) == (right, "grid")
    assert window.views.contents()["colour"] == "colour"
    window.actions_["layout_own_1"].trigger()
    assert (_area(window, "Blocks"), window.views.sheet.layout_name) == (left, "depth-out")
    assert window.views.contents()["colour"] == "depth-in"
    assert "History" not in window.panels.open, "as it was left"
    layouts.reset()
    assert "History" in window.panels.open, "as it was saved"
    assert layouts.rename("Ours")
    assert [action.text() for action in layouts.menu.actions()].count("Ours") == 1
    layouts.delete()
    assert layouts.present == "standard"
    assert not window.actions_["layout_own_1"].isVisible()
    window.actions_["restore_layout"].trigger()
    assert (layouts.present, _area(window, "Blocks")) == ("own_1", left)
    window.close()
    stored = LayoutStore()
    assert [layout.text for layout in stored.own.values()] == ["Ours"]


def test_places_of_another_version_and_panels_that_are_gone_are_passed_over(qtbot, opened):
    older = QMainWindow()
    qtbot.addWidget(older)
    store = LayoutStore()
    store.changed["standard"] = Arrangement("no such views", {}, ("Log", "Gone"), bytes(older.saveState(0).data()))
    store.write()
    window, _ = opened()
    assert window.panels.open == ["Log"]
    assert window.views.sheet.layout_name == "grid"
    window.close()


def test_layouts_are_kept_and_damaged_ones_are_left_out(qapp):
    """Qt crashes at some damaged places."""
    contents = {"colour": "depth-in"}
    arrangement = Arrangement("grid", contents, ("Blocks",), bytes(range(200)), ("a", "b"), True, True, "Mine")
    store = LayoutStore()
    store.present = "own_1"
    store.changed["standard"] = replace(arrangement, panels=None)
    store.put("own_1", arrangement)
    kept = LayoutStore()
    assert (kept.present, kept.own, kept.left("standard").panels) == ("own_1", store.own, None)
    assert kept.left("own_1") == arrangement
    stored = bytearray(QSettings().value("layouts").data())
    for place in range(len(stored)):
        damaged = stored.copy()
        damaged[place] ^= 4
        QSettings().setValue("layouts", QByteArray(bytes(damaged)))
        assert LayoutStore().left("standard").places in (b"", arrangement.places)


def test_a_window_with_open_panels_may_be_deleted_without_being_closed(qtbot):
    window = QMainWindow()
    panels = Docks(window)
    panels.add("Blocks", QWidget(), PanelGroup.WORK, "ph.stack", is_open=True)
    window.show()
    with qtbot.captureExceptions() as raised:
        shiboken6.delete(window)
    assert not raised
