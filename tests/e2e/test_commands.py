"""Commands state what they need: they are off without it, and whoever looks is told what to do first."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QDoubleSpinBox, QFileDialog

from gui.base.commands import action_entries, command, why_not
from gui.base.needs import Need
from gui.features.context import Feature
from gui.features.filter import FilterPanel

from .conftest import activate

_CTRL_ALT = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier


_DONE: list[int] = []


class _Counter(Feature):
    @command("count_blocks", "&Count the blocks", keys="Ctrl+Alt+J", needs=Need.UNLOCKED | Need.IDLE)
    def count(self) -> None:
        """Count the selected blocks.

        They are of the current frame.
        """
        _DONE.append(len(self.workspace.current.selected))


def test_a_new_command_is_one_method(window, opened, qtbot):
    _DONE.clear()
    opened.context.add(_Counter)
    opened.actions_.refresh()
    activate(opened, qtbot)
    opened.workspace.select([])
    view, document = opened.views.cells["colour"].view, opened.workspace.current
    entry = next(entry for entry in action_entries(opened) if entry.key == "count_blocks")
    assert (entry.text, entry.keys, entry.hint) == ("Count the blocks", "Ctrl+Alt+J", "Count the selected blocks")

    def pressed() -> str:
        """Press its key at once after a change; what the window says."""
        opened.notes.clear()
        QTest.keyClick(view, Qt.Key.Key_J, _CTRL_ALT)
        return opened.notes.message

    assert pressed() == "Count the blocks: Select a block first."
    document.select([1])
    assert (pressed(), _DONE) == ("", [1])
    document.set_lock(1, True)
    assert pressed() == "Count the blocks: The selected blocks are locked: unlock them first."
    action = opened.actions_["count_blocks"]
    action.hover()
    assert action.toolTip() == (
        "<b>Count the blocks (Ctrl+Alt+J)</b><br>Count the selected blocks<br>"
        "The selected blocks are locked: unlock them first."
    )
    opened.documents.close_frame()
    assert pressed() == "Count the blocks: Open a frame first."
    assert _DONE == [1]
    with pytest.raises(LookupError, match="declares a command 'count_block'"):
        opened.actions_.menu("Count", opened, "count_blocks | count_block")


def test_the_first_thing_that_is_missing_is_told(opened):
    def told(*names: str) -> list[str]:
        opened.refresh.now()
        return [why_not(opened.actions_[name]) for name in names]

    opened.workspace.select([])
    assert told("run_all", "run_selected", "pause", "clear_results", "next_frame", "undo") == [
        "",
        "Select a block first.",
        "Nothing is running.",
        "There are no results yet: run the blocks first.",
        "The list has no other frame: open more frames, or a folder of frames.",
        "Nothing to undo.",
    ]
    opened.workspace.select([1])
    opened.actions_["delete_blocks"].trigger()
    opened.workspace.select([2])
    opened.refresh.now()
    opened.actions_["delete_blocks"].trigger()
    assert told("run_all", "run_selected") == ["There are no blocks: extract or draw some first."] * 2


def test_a_key_for_size_says_why_it_does_nothing(opened):
    radius = opened.editor.options.brush_radius
    opened.actions_["brush_larger"].trigger()
    assert opened.editor.options.brush_radius == radius
    assert "has no size" in opened.notes.message


def _begin_to_type(field, text):
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text)


def test_a_command_takes_over_the_number_that_is_being_typed(opened, qtbot):
    activate(opened, qtbot)
    field = opened.feature(FilterPanel).widget.findChild(QDoubleSpinBox, "slope_weight")
    _begin_to_type(field, "0.3")
    with qtbot.waitSignal(opened.runs.ended):
        QTest.keyClick(field, Qt.Key.Key_F5)
    assert {result.parameters.slope_weight for result in opened.workspace.current.valid_results().values()} == {0.3}
    assert field.hasFocus()


@pytest.mark.parametrize("leave", ["save_project", "quit", "close"])
def test_a_note_that_is_being_typed_is_work(opened, qtbot, tmp_path, monkeypatch, leave):
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(tmp_path / "work.ilf"), ""))
    activate(opened, qtbot)
    opened.project.discard_silently = False
    opened.actions_["note_frame"].trigger()
    field = QApplication.focusWidget()
    _begin_to_type(field, "glass")
    if leave == "close":
        opened.close()
    else:
        opened.actions_[leave].trigger()
    (dialog,) = (found for found in opened.findChildren(QDialog) if found.isVisible())
    dialog.reject()
    assert opened.isVisible()
    assert opened.workspace.entries[0].note == "glass"
