"""The sessions: each ends the same twice, none leaves a part of the window out, and changed pictures are told."""

import ast
import inspect
from pathlib import Path

import pytest
from PySide6.QtWidgets import QToolBar

from . import hand, pictures, table
from .sessions import MODULES

_LEFT_OUT = {
    "play_camera": "needs a connected camera",
    "show_project": "opens the system's file manager",
    "rename_block": "edits the name in the table, as F2 does, with the keys of the system",
    "turn_cloud": "turns the tabs of the centre, as a click on them does",
    "mark_checked": "the sequence is so plain that no propagated block needs a check",
}

_NONE_OF_ITS_OWN = "experiment_", "layout_own_"
"""Commands of the paper's experiments, and places for layouts of the user."""


@pytest.fixture(autouse=True)
def _settings_of_the_tests(isolated_settings):
    """The sessions' settings are set up after those of all tests."""


def test_a_session_ends_the_same_twice():
    first, second = (table.run("give_pieces") for _ in range(2))
    assert len(first) > 10
    assert first == second


def _said() -> set[str]:
    """All texts in the sessions and in what a hand does."""
    trees = [ast.parse(inspect.getsource(code)) for code in (*MODULES, hand.Hand)]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    used = {str(node.value) for node in nodes}
    calls = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Call) and node.args]
    tools = [call.args[0] for call in calls if isinstance(call.func, ast.Attribute) and call.func.attr == "tool"]
    return used | {f"tool_{name.value}" for name in tools if isinstance(name, ast.Constant)}


def test_every_tool_panel_dialog_and_command_occurs(tmp_path):
    said = _said()
    with hand.isolated(tmp_path):
        user = hand.Hand(tmp_path)
        commands = {name for name in hand.commands(user.window) if not name.startswith(_NONE_OF_ITS_OWN)}
        panels = hand.panels(user.window)
        user.close()
    assert sorted(commands - said) == sorted(_LEFT_OUT)
    assert [title for title in panels if title not in said] == []
    assert hand.dialog_classes() == set(hand.DIALOGS)
    assert [title for title in hand.DIALOGS.values() if title not in said] == []


def _grab(folder: Path, user: hand.Hand) -> Path:
    folder.mkdir()
    pictures.grab(user).save(str(folder / "window.png"))
    return folder


@pytest.mark.parametrize("command", ["open", "undo"], ids=["on", "off"])
def test_a_moved_or_hidden_control_is_seen(tmp_path, command):
    with hand.isolated(tmp_path):
        user = hand.Hand(tmp_path)
        before, same = _grab(tmp_path / "before", user), _grab(tmp_path / "same", user)
        bar = next(bar for bar in user.window.findChildren(QToolBar) if bar.windowTitle() == "Tools")
        further = bar.insertSeparator(user.action(command))
        moved = _grab(tmp_path / "moved", user)
        bar.removeAction(further)
        user.action(command).setVisible(False)
        hidden = _grab(tmp_path / "hidden", user)
        user.close()
    assert pictures.differences(before, same) == []
    for changed in (moved, hidden):
        (sentence,) = pictures.differences(before, changed)
        assert sentence.startswith("window.png")
    (hidden / "window.png").unlink()
    assert pictures.differences(before, hidden) == ["window.png: only in the first folder."]
