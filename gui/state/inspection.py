"""Profile line, rectangle and measurements of the current frame."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QObject, Signal

from ilf.data.label_map import Box
from ilf.errors import InputError
from ilf.evaluation.measuring import Line, point_in_space
from ilf.project.frame_state import Point

from .parts import Part
from .workspace import Workspace


class Inspection(QObject):
    """The inspection marks of the current frame. They are stored with the frame; changing them is not undoable.

    Signals
    -------
    refused(str)
        Why a point was rejected.
    """

    refused = Signal(str)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace

    @property
    def line(self) -> Line | None:
        """The current frame's profile line."""
        return self._workspace.current.state.looked.line if self._workspace.has_current else None

    def set_line(self, line: Line | None) -> None:
        """Set the profile line; None removes it."""
        self._workspace.current.look(Part.MARKS, line=line)

    @property
    def region(self) -> Box | None:
        """The current frame's rectangle."""
        return self._workspace.current.state.looked.region if self._workspace.has_current else None

    def set_region(self, box: Box | None) -> None:
        """Set the rectangle; None removes it."""
        self._workspace.current.set_region(box)

    @property
    def measurements(self) -> tuple[Line, ...]:
        """The current frame's measurements, oldest first."""
        return self._workspace.current.state.looked.measurements if self._workspace.has_current else ()

    def set_measurements(self, lines: Sequence[Line]) -> None:
        """Set all measurements."""
        self._workspace.current.look(Part.MARKS, viewing=False, measurements=tuple(lines))

    def has_depth(self, point: Point) -> bool:
        """Whether the pixel at image coordinates x, y has a position in space; else False, with `refused`."""
        if not self._workspace.has_current:
            return False
        document = self._workspace.current
        depth = document.current_depth()
        try:
            point_in_space(document.frame.depth if depth is None else depth, point, document.frame.intrinsics)
        except InputError as error:
            self.refused.emit(str(error))
            return False
        return True
