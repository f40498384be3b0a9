"""The undo history of the current frame."""

from __future__ import annotations

from functools import partial

from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QUndoView

from ..base.commands import WHY_NOT, describe
from ..widgets.docks import PanelGroup
from .context import Context, Feature


class HistoryFeature(Feature):
    """The panel *History*, and the commands that undo and redo, whose texts and states come from the history."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        window, history = context.window, context.workspace.undo_group
        undo, redo = history.createUndoAction(window, "Undo"), history.createRedoAction(window, "Redo")
        undo.triggered.disconnect()  # during a stroke, it cancels the stroke
        undo.triggered.connect(lambda _=False: context.editor.undo())
        undo.setShortcut(QKeySequence("Ctrl+Z"))
        redo.setShortcuts([QKeySequence("Ctrl+Shift+Z"), QKeySequence("Ctrl+Y")])
        icons = "ph.arrow-counter-clockwise", "ph.arrow-clockwise"
        for name, action, icon in zip(("undo", "redo"), (undo, redo), icons, strict=True):
            action.setProperty(WHY_NOT, f"Nothing to {name}.")
            context.actions.adopt(name, action, icon)
            action.changed.connect(partial(describe, action))
            describe(action)
        self.panel = QUndoView(history)  # the steps, oldest first, with the current state marked
        self.panel.setEmptyLabel("As opened")
        self.panel.setAccessibleName("History")
        self.panel.setToolTip("Click a step to go to the state after it")
        self.panel.setUniformItemSizes(True)
        context.panels.add("History", self.panel, PanelGroup.WORK, "ph.clock-counter-clockwise")
