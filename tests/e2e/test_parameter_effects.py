"""What a parameter of the filter does to this frame is shown beside it, and those that do most come first."""

from threading import Event

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLabel, QSlider, QToolButton, QWidget

from gui.features.filter import FilterPanel
from gui.features.parameter_effects import effect_of
from gui.work.frame_runs import RunState
from ilf._runtime.formatting import millimetres

from ..gui.states import edit
from .conftest import settle


@pytest.fixture
def panel(opened, run_all):
    """The filter's panel; all blocks are completed, and the first is selected."""
    run_all(opened)
    opened.workspace.select([1])
    opened.refresh.now()
    return opened.feature(FilterPanel)


def _effect(panel, name: str) -> str:
    label = panel.form.findChild(QLabel, f"effect_{name}")
    return label.text() if label.isVisible() else ""


def _drag(panel, name: str, *steps: int):
    slider = panel.form.findChild(QSlider, f"slider_{name}")
    for step in steps:
        slider.setValue(slider.value() + step)


def test_after_a_drag_the_difference_to_the_depth_before_it_stands_beside_the_parameter(
    opened, panel, qtbot, monkeypatch
):
    monkeypatch.setattr("gui.state.parameters.DRAG_S", 1000.0)  # however busy the machine is
    before = opened.workspace.current.completion().depth
    assert _effect(panel, "slope_weight") == ""
    _drag(panel, "slope_weight", 20, 20, 20)
    settle(opened, qtbot)
    difference = np.abs(opened.workspace.current.completion().depth - before)
    changed = difference[difference >= 1e-4]
    assert changed.size
    assert _effect(panel, "slope_weight") == (
        f"{changed.size} px changed: median {millimetres(np.median(changed))}, largest {millimetres(changed.max())} mm"
    )
    assert _effect(panel, "noise") == ""
    _drag(panel, "slope_weight", -60)
    settle(opened, qtbot)
    assert _effect(panel, "slope_weight") == "no pixel changed by 0.1 mm", "the drag goes on, and is back"


def test_a_drag_goes_on_while_the_depth_before_it_is_compared(opened, panel, qtbot, monkeypatch):
    begun, go_on = Event(), Event()

    def find(depths: object) -> object:
        begun.set()
        assert go_on.wait(60)
        return effect_of(depths)

    monkeypatch.setattr("gui.features.filter.effect_of", find)
    _drag(panel, "slope_weight", 20)
    qtbot.waitUntil(begun.is_set)
    _drag(panel, "slope_weight", 20)
    qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    opened.refresh.now()
    go_on.set()
    settle(opened, qtbot)
    assert " px changed: median " in _effect(panel, "slope_weight")


def test_effects_of_another_state_are_not_shown(opened, panel, qtbot):
    for leave, step in (
        (opened.actions_["undo"].trigger, 60),
        (lambda: edit(opened.workspace, 0, rows=np.s_[:10], columns=np.s_[:10]), 60),
        (opened.actions_["close_frame"].trigger, -30),
    ):
        _drag(panel, "slope_weight", step)
        settle(opened, qtbot)
        assert _effect(panel, "slope_weight")
        leave()
        opened.refresh.now()
        assert _effect(panel, "slope_weight") == ""
        settle(opened, qtbot)
        assert _effect(panel, "slope_weight") == ""


@pytest.mark.parametrize("for_selected", [False, True])
def test_what_acts_most_comes_first_once_it_is_tried(opened, panel, qtbot, for_selected):
    document = opened.workspace.current
    panel.scope.setCurrentIndex(int(for_selected))
    panel.redraw()
    opened.refresh.now()
    parameters, depth = document.state.common, document.completion().depth.copy()
    button = next(b for b in panel.form.findChildren(QToolButton) if b.text() == "Try parameters")
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert panel.busy
    settle(opened, qtbot)
    assert not panel.work.isVisible()
    rows = {name: panel.form.findChild(QWidget, name).parentWidget() for name in panel.form.shown}
    order = sorted(rows, key=lambda name: rows[name].mapTo(panel.form.widget(), rows[name].rect().topLeft()).y())
    acting = [name for name in order if "px changed" in _effect(panel, name)]
    assert order[: len(acting)] == acting != []
    assert all(_effect(panel, name).startswith("at ") for name in order)
    assert "smoothness" not in order, "it acts little when only filling"
    assert (document.state.common, document.blocks.own) == (parameters, {})
    np.testing.assert_array_equal(document.completion().depth, depth)


def test_a_trial_can_be_cancelled(opened, panel, qtbot):
    opened.actions_["try_parameters"].trigger()
    qtbot.waitUntil(panel.work.isVisible)
    panel.work.cancel_button.click()
    assert not panel.work.cancel_button.isEnabled()
    qtbot.waitUntil(lambda: not panel.busy)
    assert not panel.work.isVisible()
    assert not any(_effect(panel, name) for name in panel.form.shown)


def test_depth_that_comes_or_goes_counts_as_changed():
    before = np.array([1.0, 1.0, np.nan, np.nan, 2.0], np.float32)
    after = np.array([1.00005, 1.003, np.nan, 1.0, np.nan], np.float32)
    effect = effect_of([(before, after)])
    assert effect.pixels == 3
    assert (effect.median, effect.largest) == pytest.approx((0.003, 0.003), rel=1e-3)
    assert effect_of([]).text == "no pixel changed by 0.1 mm"
    nothing = np.full_like(before, np.nan)
    assert effect_of([(nothing, np.ones_like(before))]).text == f"{before.size} px changed: missing before or after"
