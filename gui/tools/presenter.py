"""Connects the active tool and its options with the tool bar."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction

from .editor import Editor
from .options_row import OptionsRow


class ToolsPresenter(QObject):
    """The presenter of the active tool and its options.

    Parameters
    ----------
    choices : mapping of str to QAction
        Tool name -> action.
    row : OptionsRow
    """

    def __init__(self, editor: Editor, choices: Mapping[str, QAction], row: OptionsRow) -> None:
        super().__init__(editor)
        self._editor = editor
        self._choices = choices
        self._row = row
        for name, action in choices.items():
            action.triggered.connect(lambda _=False, name=name: editor.set_tool(name))
        row.changed.connect(editor.set_option)

    def show(self) -> None:
        """Show the active tool and its options."""
        self._choices[self._editor.tool_name].setChecked(True)
        self._row.show_options(self._editor.tool.options, self._editor.options)
