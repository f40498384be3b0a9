"""Brings the active tool and the size of its brush to the tool bar, and back."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QObject, QSignalBlocker
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QLabel, QSlider

from gui.tools.editor import Editor


class ToolsPresenter(QObject):
    """Which tool is active, and how large its brush is.

    Parameters
    ----------
    choices : mapping of str to QAction
        The tools' actions by the names of the tools.
    brush, size : QSlider, QLabel
        Of the brush: its radius in pixels, and how many pixels it is across.
    """

    def __init__(self, editor: Editor, choices: Mapping[str, QAction], brush: QSlider, size: QLabel) -> None:
        super().__init__(editor)
        self._editor = editor
        self._choices = choices
        self._brush = brush
        self._size = size
        for name, action in choices.items():
            action.triggered.connect(lambda _=False, name=name: editor.set_tool(name))
        brush.valueChanged.connect(lambda radius: editor.set_brush(float(radius)))

    def show(self) -> None:
        """The active tool and the brush."""
        self._choices[self._editor.tool_name].setChecked(True)
        radius = self._editor.brush_radius
        with QSignalBlocker(self._brush):
            self._brush.setValue(round(radius))
        self._size.setText(f" {2 * radius:g} px ")
        self._brush.setToolTip(f"Brush: {2 * radius:g} px across ([ and ])")
