"""Each control of each dialog is heard: with it changes something else that is seen, what the dialog asks for, or what
is remembered."""

import gc
from collections.abc import Callable, Iterator

import pytest
from PySide6.QtCore import QCoreApplication, QSettings, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QDockWidget,
    QGraphicsView,
    QLineEdit,
    QTabWidget,
    QWidget,
    QWidgetItem,
)
from shiboken6 import getAllValidWrappers, isValid

from gui.features.export.feature import ExportFeature
from gui.features.project.closing import CloseDialog
from gui.state.workspace import Entry
from ilf.errors import IlfError
from ilf.project.state_codec import encode
from ilf.sources.frame_ref import FrameRef

from .conftest import in_front, settle, write_frame

_WHOLE = QAbstractSpinBox, QComboBox
_TICK = Qt.ItemDataRole.CheckStateRole


def _controls(dialog: QDialog) -> Iterator[QWidget]:
    """What can be used, a page after the other."""
    for pages in [*dialog.findChildren(QTabWidget), None]:
        for page in [at for at in range(pages.count()) if pages.isTabVisible(at)] if pages else [None]:
            if pages:
                pages.setCurrentIndex(page)
            for control in dialog.findChildren(QWidget):
                can_be_used = isValid(control) and control.isVisible() and control.isEnabled()
                if can_be_used and not isinstance(control.parentWidget(), _WHOLE):
                    yield control


def _value(widget: QWidget) -> object:
    """What is seen of a widget."""
    if isinstance(widget, QAbstractItemView):
        first = widget.model().index(0, 0)
        return first.data(), first.data(_TICK)
    if isinstance(widget, QGraphicsView):
        return hash(bytes(widget.viewport().grab().toImage().constBits()))
    state = widget.isChecked() if isinstance(widget, QAbstractButton) else widget.isEnabled()
    return next((widget.property(name) for name in ("currentText", "text") if widget.property(name)), ""), state


def _uses(control: QWidget) -> Iterator[object]:
    """Change a control as a user does, by a click, a key, or a tick in its first row; then change it back."""
    if isinstance(control, QAbstractItemView):
        first = control.model().index(0, 0)
        for state in (Qt.CheckState.Unchecked, Qt.CheckState.Checked) if first.data(_TICK) is not None else ():
            yield control.model().setData(first, state, _TICK)
    elif isinstance(control, QAbstractButton) and control.isCheckable():
        yield control.click()
        yield control.click()
    elif isinstance(control, QLineEdit):
        yield QTest.keyClicks(control, "7")
        yield QTest.keyClick(control, Qt.Key.Key_Backspace)
    elif isinstance(control, _WHOLE):
        before, (there, back) = _value(control), (Qt.Key.Key_Down, Qt.Key.Key_Up)
        QTest.keyClick(control, there)
        if _value(control) == before:
            there, back = back, there
            QTest.keyClick(control, there)
        if isinstance(control, QAbstractSpinBox):
            QTest.keyClick(control, Qt.Key.Key_Tab)
        yield
        yield QTest.keyClick(control, back)


def _told(dialog: QDialog, gives: Callable[[], object], control: QWidget) -> object:
    """All that changes but the control itself."""
    others = [
        one
        for one in dialog.window().findChildren(QWidget)
        if one is not control and not control.isAncestorOf(one) and not one.isAncestorOf(control)
    ]
    given, settings = _given(gives), QSettings()
    return (
        given,
        [_value(one) for one in others if isValid(one) and one.isVisible()],
        [(key, settings.value(key)) for key in settings.allKeys()],
    )


def _given(gives: Callable[[], object]) -> str:
    try:
        return str(gives())
    except IlfError as error:
        return str(error)


def _deaf(dialog: QDialog, gives: Callable[[], object] = str) -> tuple[int, list[str]]:
    """How many controls were used, and those with which nothing changed."""
    used, deaf = set(), []
    for control in _controls(dialog):
        if control in used:
            continue
        before = _told(dialog, gives, control), _value(control)
        for number, _ in enumerate(_uses(control)):
            QCoreApplication.processEvents()
            if number == 0 and _value(control) != before[1]:
                used.add(control)
                if _told(dialog, gives, control) == before[0]:
                    deaf.append(f"{type(control).__name__} {control.accessibleName() or control.toolTip()}")
    return len(used), deaf


@pytest.mark.parametrize(
    ("name", "least", "unseen"),
    [
        ("export", 20, 0),
        ("batch", 5, 0),
        ("report", 5, 1),  # whether it is opened is asked when it is written
        ("hold_out_test", 3, 0),
        ("sweep", 5, 3),  # the other end, the scale and the blocks are read when it starts
        ("quit", 2, 0),
    ],
)
def test_each_control_of_a_dialog_is_heard(opened, tmp_path, name, least, unseen):
    opened.workspace.current.set_lock(2, True)
    opened.workspace.select([1])
    opened.project.discard_silently = False
    opened.actions_[name].trigger()
    dialog, gives = in_front(opened, QDialog), str
    if name in ("export", "batch", "report"):
        opened.feature(ExportFeature).folder_path.setText(str(tmp_path / "out"))
        gives = opened.feature(ExportFeature).request
    used, deaf = _deaf(dialog, gives)
    assert len(deaf) <= unseen, deaf
    assert used >= least
    for box in dialog.findChildren(QDialogButtonBox):
        for button in box.buttons():
            if box.buttonRole(button) == QDialogButtonBox.ButtonRole.RejectRole:
                button.click()
                assert not dialog.isVisible()


@pytest.mark.parametrize("kind", ["frame", "frames"])
def test_each_reading_option_is_asked_for(opened, small_frame, frame_folder, kind):
    write_frame(frame_folder.parent / "another", small_frame)
    opened.actions_["open"].trigger()
    dialog = in_front(opened, QDialog)
    dialog.set_files(str(frame_folder if kind == "frame" else frame_folder.parent))
    dialog.more.setChecked(True)
    used, deaf = _deaf(dialog, dialog.request)
    assert (deaf, used >= 8) == ([], True)


def test_each_control_of_a_panel_is_heard(opened, qtbot, run_all):
    run_all(opened)
    opened.workspace.add_entries([Entry.of(FrameRef("/nowhere/other"))])

    def state() -> object:
        settle(opened, qtbot)
        return encode(opened.workspace.current.state).content, opened.workspace.parameters.current

    used, deaf = 0, set[str]()
    for toggle in opened.panels.toggles():
        opened.workspace.select([1])
        opened.panels.reveal(toggle.text())
        settle(opened, qtbot)
        number, unheard = _deaf(opened.findChild(QDockWidget, toggle.text()), state)
        used, deaf = used + number, deaf | {*unheard}
    # How blocks are extracted next, the step of neighbours, and a range of colours that robust and full share.
    assert len(deaf) <= 4, deaf
    assert used >= 28


@pytest.mark.parametrize("rows", [{}, {"a1": ("frame", "blocks")}])
def test_enter_in_the_question_before_closing_loses_nothing(opened, rows):
    lost = []
    dialog = CloseDialog("closing", rows, lambda: ["A run goes on."], opened.runs, lambda _: iter(()), opened)
    dialog.discard_button.clicked.connect(lost.append)
    dialog.show()
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    assert not lost


def test_no_item_of_a_layout_is_remembered(opened, qtbot):
    """PySide would take what is later allocated in the place of a deleted one for it, which crashes."""
    for toggle in opened.panels.toggles():
        opened.panels.reveal(toggle.text())
        settle(opened, qtbot)
    for name in ("export", "open", "hold_out_test", "sweep", "shortcuts"):
        opened.actions_[name].trigger()
        in_front(opened, QDialog).close()
    gc.collect()
    assert not [one for one in getAllValidWrappers() if isinstance(one, QWidgetItem)]
