"""What a new user sees: tools with names, and commands that need a block only once one is selected."""

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QToolButton

from gui.app.main_window import MainWindow
from gui.base.commands import plain
from gui.features.shortcuts import Keymap
from gui.tools import kinds
from gui.tools.kinds import KINDS, ToolKind
from gui.tools.select import SelectTool


def _shown(window) -> set[str]:
    """The commands with a button in the tool bar."""
    buttons = window.tool_bar.findChildren(QToolButton)
    seen = [button for button in buttons if button.isVisible() and not button.visibleRegion().isEmpty()]
    return {button.defaultAction().objectName() for button in seen if button.defaultAction() is not None}


def test_what_needs_a_selected_block_is_there_once_one_is_selected_and_panels_are_in_the_menu(opened, qtbot):
    opened.resize(1440, 900)
    opened.workspace.select([])
    of_selection = {"run_selected", "delete_blocks", "grow_blocks", "shrink_blocks", "smooth_blocks"}
    assert not _shown(opened) & of_selection
    opened.workspace.select([1])
    qtbot.waitUntil(lambda: of_selection <= _shown(opened))
    assert "merge_blocks" not in _shown(opened), "it needs two"
    opened.workspace.select([])
    qtbot.waitUntil(lambda: not _shown(opened) & of_selection)

    view = next(action.menu() for action in opened.menuBar().actions() if action.text() == "&View")
    panels = next(action.menu() for action in view.actions() if plain(action.text()) == "Panels")
    assert panels.actions() == opened.panels.toggles()


def test_letters_of_tools_are_no_keys_that_are_held_and_can_be_changed(opened):
    held = {command.held for command in opened.actions_.commands.values()} - {""}
    assert not held & {kind.key for kind in KINDS}
    keymap = Keymap(opened)
    keymap.assign("tool_paint", [QKeySequence("Y")])
    assert opened.actions_["tool_paint"].toolTip().startswith("<b>Paint (Y)</b>")
    opened.activateWindow()
    QTest.keyClick(opened, Qt.Key.Key_B)
    assert opened.editor.tool_name == "select"
    QTest.keyClick(opened, Qt.Key.Key_Y)
    assert opened.editor.tool_name == "paint"


def test_a_new_tool_is_one_record(qtbot, monkeypatch):
    class WandTool(SelectTool):
        """Do magic.

        It is not said how.
        """

    new = ToolKind("wand", "&Wand", "ph.magic-wand", "Q", WandTool)
    for module in ("gui.tools.kinds", "gui.tools.editor", "gui.features.tools"):
        monkeypatch.setattr(f"{module}.KINDS", (*kinds.KINDS[:-3], new, *kinds.KINDS[-3:]))
    window = MainWindow(persistent=False)
    qtbot.addWidget(window)
    assert list(window.editor.tools) == ["select"], "others are made when they are first taken"
    assert isinstance(window.editor.tools["wand"], WandTool)
    assert window.actions_["tool_wand"].toolTip() == "<b>Wand (Q)</b><br>Do magic"
    window.close()
