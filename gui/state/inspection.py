"""What of the present frame is looked at closely: a line, a rectangle, measurements."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from gui.state.chains import Point
from gui.state.measurements import Measurements
from gui.state.workspace import Workspace
from ilf.blocks import Box

Line = tuple[Point, Point]
"""Ends in image coordinates."""


class Inspection(QObject):
    """Where the user looks. It stays with its frame, and is no part of what is saved or undone.

    Attributes
    ----------
    measurements : Measurements

    Signals
    -------
    line_changed()
        There is another profile line, or none.
    """

    line_changed = Signal()

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.measurements = Measurements(workspace, self)
        workspace.session_changed.connect(self.line_changed)

    @property
    def line(self) -> Line | None:
        """The present frame's profile line."""
        return self._workspace.session.line if self._workspace.has_session else None

    def set_line(self, line: Line | None) -> None:
        """Take another profile line; None for none."""
        if line == self.line:
            return
        session = self._workspace.session
        session.line = line
        self._workspace.touch(session, looked=True)
        self.line_changed.emit()

    @property
    def region(self) -> Box | None:
        """The present frame's rectangle."""
        return self._workspace.session.region if self._workspace.has_session else None

    def set_region(self, box: Box | None) -> None:
        """Take another rectangle; None for none."""
        self._workspace.set_region(box)
