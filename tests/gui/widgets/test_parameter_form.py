"""The form shows, keeps and reports the values of a parameter set."""

from dataclasses import dataclass

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QCheckBox, QComboBox, QDoubleSpinBox, QSpinBox, QToolButton, QWidget

import ilf
from gui.widgets.parameter_form import ParameterForm, ValueSlider, has_slider
from ilf.data.declarations import ParameterSet, declare

PAPER = ilf.PRESETS["paper"]
"""Its filter has the rows that the tests turn to."""


@pytest.fixture
def form(shown):
    form = shown(ParameterForm(ilf.Parameters), 280, 400)
    form.set_parameters(PAPER)
    form.all_button.setChecked(True)
    return form


def _wheel(form, target: QWidget):
    """One notch towards the user, as the window system reports it."""
    QTest.wheelEvent(form.windowHandle(), target.mapTo(form, target.rect().center()), QPoint(0, -120))


@pytest.mark.parametrize("set_class", [ilf.Parameters, ilf.BlockParameters])
def test_every_declaration_has_an_editor_with_its_range(qtbot, set_class):
    form = ParameterForm(set_class)
    qtbot.addWidget(form)
    form.show_effects(dict.fromkeys(set_class.declarations(), "0 mm"))  # has every row made
    for name, declaration in set_class.declarations().items():
        editor = form.findChild(QWidget, name)
        assert declaration.help in editor.parentWidget().toolTip()
        if isinstance(editor, QSpinBox | QDoubleSpinBox):
            assert (editor.minimum(), editor.maximum()) == (declaration.minimum, declaration.maximum)
            assert editor.suffix().strip() == declaration.unit
        else:
            assert isinstance(editor, QCheckBox if declaration.kind is bool else QComboBox)
    assert form.parameters() == set_class()


def test_values_beyond_the_step_survive_and_are_shown(form, qtbot):
    parameters = PAPER.replace(s_criteria=0.00512, padding=1 / 3 + 1, mode="fill+denoise")
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
    assert blocker.args == [PAPER.replace(max_iterations=240)]


def test_reset_goes_back_to_the_preset(form, qtbot):
    base = ilf.preset("released-code")
    form.set_parameters(base, base)
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
    assert form.parameters() == PAPER


def _shown(form) -> list[str]:
    """Names of the parameters whose editors can be seen, or scrolled to."""
    editors = {name: form.findChild(QWidget, name) for name in form.parameters().declarations()}
    return [name for name, editor in editors.items() if editor is not None and editor.isVisibleTo(form)]


def _groups(form) -> set[str]:
    """Headings that can be seen, or scrolled to."""
    return {item.text() for item in form.findChildren(QToolButton) if item.text() and item.isVisibleTo(form)}


@pytest.mark.parametrize("name", ilf.PRESETS)
def test_six_parameters_come_first_then_those_that_differ_then_all(form, name):
    form.set_parameters(ilf.PRESETS[name], ilf.PRESETS[name])
    form.all_button.setChecked(False)
    assert len(_shown(form)) == 6
    assert _groups(form) == {form.all_button.text()}
    form.set_parameters(ilf.PRESETS[name].replace(min_known_pixels=7))
    assert len(_shown(form)) == 7
    assert "min_known_pixels" in _shown(form)
    form.all_button.setChecked(True)
    assert len(_shown(form)) > 15
    assert ParameterForm(ilf.Parameters).all_button.isChecked(), "the choice is remembered"


def test_dragging_a_slider_reports_every_value_and_moves_the_field(form, qtbot):
    slider = form.findChild(ValueSlider, "slider_padding")
    seen = []
    form.changed.connect(lambda parameters: seen.append(parameters.padding))
    for position in (5, 6, 6, 7):
        slider.setValue(position)
    assert seen == [2.25, 2.5, 2.75]
    assert form.findChild(QDoubleSpinBox, "padding").value() == 2.75
    form.findChild(QDoubleSpinBox, "padding").setValue(1.3)
    assert slider.value() == 1
    assert form.parameters() == PAPER.replace(padding=1.3), "a slider shows the nearest position and changes nothing"


@dataclass(frozen=True)
class _Sizes(ParameterSet):
    stiffness: float = declare(1.0, "Stiffness", "h", "g", minimum=0.001, maximum=1e6, step=0.1, scale="log")
    weight: float = declare(0.02, "Weight", "h", "g", minimum=0.0, maximum=1e6, step=0.01, scale="log")
    count: int = declare(1500, "Count", "h", "g", minimum=1, maximum=100_000, step=100, scale="log")
    switch_off: int = declare(150, "Switch off", "h", "g", minimum=0, maximum=1000, step=10, scale="log")
    share: float = declare(0.1, "Share", "h", "g", minimum=0.0, maximum=1.0, step=0.01)
    margin: int = declare(-1, "Margin", "h", "g", minimum=-1, maximum=20, special="auto")
    fine: float = declare(0.1, "Fine", "h", "g", minimum=0.0, maximum=1.0, step=0.001)
    open_ended: float = declare(0.1, "Open", "h", "g", minimum=0.0)


def test_sliders_reach_both_ends_rise_throughout_and_return_to_where_they_were(qapp):
    sizes = _Sizes.declarations()
    assert {name for name, item in sizes.items() if not has_slider(item)} == {"fine", "open_ended"}
    for declaration in filter(has_slider, sizes.values()):
        scale = ValueSlider(declaration)
        values = [scale.value_at(position) for position in range(scale.maximum() + 1)]
        assert values == sorted(values)
        assert (values[0], values[-1]) == (declaration.minimum, declaration.maximum)
        assert all(declaration.checked(value) == value for value in values)
        assert all(scale.value_at(scale.position_of(value)) == value for value in values)
        assert scale.position_of(declaration.default) in range(scale.maximum() + 1)
    whole = ValueSlider(sizes["margin"])
    assert [whole.value_at(position) for position in range(whole.maximum() + 1)] == list(range(-1, 21))
    middle = ValueSlider(sizes["stiffness"])
    assert middle.value_at(middle.position_of(1.0)) == pytest.approx(1.0, rel=0.1)
    assert middle.position_of(1.0) == pytest.approx(middle.maximum() / 3, abs=1), "equal ratios are equally far apart"
    assert 0 < ValueSlider(sizes["weight"]).value_at(1) <= 0.001


def test_wheel_steps_the_editor_that_has_the_focus(form, qtbot):
    editor = form.findChild(QDoubleSpinBox, "padding")
    form.ensureWidgetVisible(editor)
    editor.setFocus()
    qtbot.waitUntil(editor.hasFocus)
    _wheel(form, editor)
    assert form.parameters() == PAPER.replace(padding=1.75)


_offered = ["edges", "hed"]


@dataclass(frozen=True)
class _Network(ParameterSet):
    model: str = declare("edges", "Edge network", "h.", "g", offers=lambda: tuple(_offered))


@pytest.fixture
def network_form(shown, monkeypatch):
    monkeypatch.setattr("tests.gui.widgets.test_parameter_form._offered", ["edges", "hed"])
    form = ParameterForm(_Network)
    form.all_button.setChecked(True)
    return shown(form, 280, 100)


def _items(form) -> list[str]:
    combo = form.findChild(QComboBox, "model")
    return [combo.itemText(row) for row in range(combo.count())]


def test_values_that_come_and_go_are_asked_for_when_the_list_opens(network_form, qtbot):
    combo = network_form.findChild(QComboBox, "model")
    assert _items(network_form) == ["edges", "hed"]
    _offered.append("pidinet")
    with qtbot.assertNotEmitted(network_form.changed):
        combo.showPopup()
        combo.hidePopup()
    assert _items(network_form) == ["edges", "hed", "pidinet"]
    with qtbot.waitSignal(network_form.changed) as blocker:
        qtbot.keyClick(combo, Qt.Key.Key_End)
    assert blocker.args == [_Network(model="pidinet")]


def test_a_value_that_is_not_offered_stays_and_is_marked(network_form, qtbot):
    combo = network_form.findChild(QComboBox, "model")
    with qtbot.assertNotEmitted(network_form.changed):
        network_form.set_parameters(_Network(model="elsewhere"))
        combo.showPopup()
        combo.hidePopup()
    assert network_form.parameters() == _Network(model="elsewhere")
    assert combo.currentText() == "missing: elsewhere"
    assert "not on this computer" in combo.toolTip()
    combo.setCurrentIndex(combo.findData("hed"))
    assert network_form.parameters() == _Network(model="hed")
    assert _items(network_form) == ["edges", "hed"]
    assert not combo.toolTip()
