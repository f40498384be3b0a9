"""The form shows, keeps and reports the values of a parameter set."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox, QSpinBox, QToolButton, QWidget

from gui.panels.parameter_form import ParameterForm
from ilf.parameters import BlockParameters, Parameters, preset


@pytest.fixture
def form(qtbot):
    form = ParameterForm(Parameters)
    qtbot.addWidget(form)
    form.resize(280, 400)
    form.show()
    qtbot.waitExposed(form)
    return form


def _wheel(form: ParameterForm, target: QWidget) -> None:
    """One notch towards the user, as the window system reports it."""
    QTest.wheelEvent(form.windowHandle(), target.mapTo(form, target.rect().center()), QPoint(0, -120))


@pytest.mark.parametrize("set_class", [Parameters, BlockParameters])
def test_every_declaration_has_an_editor_with_its_range(qtbot, set_class):
    form = ParameterForm(set_class)
    qtbot.addWidget(form)
    for name, declaration in set_class.declarations().items():
        editor = form.findChild(QWidget, name)
        assert declaration.help in editor.toolTip()
        if isinstance(editor, QSpinBox | QDoubleSpinBox):
            assert (editor.minimum(), editor.maximum()) == (declaration.minimum, declaration.maximum)
            assert editor.suffix().strip() == declaration.unit
        else:
            assert isinstance(editor, QCheckBox if declaration.kind is bool else QComboBox)
    assert form.parameters() == set_class()


def test_values_beyond_the_step_survive_and_are_shown(form, qtbot):
    parameters = Parameters(s_criteria=0.00512, padding=1 / 3 + 1, mode="fill+denoise")
    with qtbot.assertNotEmitted(form.changed):
        form.set_parameters(parameters)
        for editor in form.findChildren(QDoubleSpinBox):
            qtbot.keyClick(editor, Qt.Key.Key_Return)
    assert form.parameters() == parameters
    assert form.findChild(QDoubleSpinBox, "s_criteria").text() == "0.00512 m"


def test_an_edit_is_reported_once_with_the_whole_set(form, qtbot):
    editor = form.findChild(QSpinBox, "max_iterations")
    editor.selectAll()
    with qtbot.waitSignal(form.changed) as blocker:
        qtbot.keyClicks(editor, "240")
        qtbot.keyClick(editor, Qt.Key.Key_Return)
    assert blocker.args == [Parameters(max_iterations=240)]


def test_reset_goes_back_to_the_preset(form, qtbot):
    base = preset("released-code")
    form.set_parameters(base)
    form.set_base(base)
    reset = form.findChild(QToolButton, "reset_schedule")
    assert not reset.isVisible()
    form.findChild(QComboBox, "schedule").setCurrentText("staged")
    assert reset.isVisible()
    qtbot.mouseClick(reset, Qt.MouseButton.LeftButton)
    assert form.parameters() == base
    assert not reset.isVisible()


def test_wheel_scrolls_the_panel_and_changes_no_value(form, qtbot):
    for name in ("schedule", "padding", "s_criteria"):
        editor = form.findChild(QWidget, name)
        editor.clearFocus()
        form.ensureWidgetVisible(editor)
        before = form.verticalScrollBar().value()
        _wheel(form, editor)
        assert form.verticalScrollBar().value() > before
    assert form.parameters() == Parameters()


def test_special_minimum_is_a_word(qtbot):
    form = ParameterForm(BlockParameters)
    qtbot.addWidget(form)
    assert form.findChild(QDoubleSpinBox, "canny_high").text() == "auto"
    assert form.findChild(QSpinBox, "margin").text() == "auto"


def test_nothing_is_cut_off_at_280_pixels(form):
    for name in Parameters.declarations():
        editor = form.findChild(QWidget, name)
        assert form.widget().rect().contains(editor.mapTo(form.widget(), editor.rect().bottomRight()))
    assert form.widget().minimumSizeHint().width() <= form.viewport().width()


def test_wheel_steps_the_editor_that_has_the_focus(form, qtbot):
    editor = form.findChild(QDoubleSpinBox, "padding")
    form.ensureWidgetVisible(editor)
    editor.setFocus()
    qtbot.waitUntil(editor.hasFocus)
    _wheel(form, editor)
    assert form.parameters() == Parameters(padding=1.75)
