"""Profile line, rectangle and measurements of the current frame."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from ilf.data.blocks import Box
from ilf.errors import InputError
from ilf.evaluation.measuring import point_in_space

from .session import Chains, Point
from .workspace import Workspace

# Measured points of all open frames.


class Measurements(QObject):
    """Chains of points on the current frame, in image coordinates; each is one measurement. Stored with the frame.

    Signals
    -------
    changed()
        Points, or the reference of heights.
    refused(str)
        Why a point was rejected.
    """

    changed = Signal()
    refused = Signal(str)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        workspace.frames.session_changed.connect(self.changed)

    @property
    def chains(self) -> list[tuple[Point, ...]]:
        """All measurements, oldest first."""
        return [tuple(chain) for chain in self._held.chains]

    @property
    def is_open(self) -> bool:
        """Whether the next point continues the last measurement."""
        return self._held.is_open

    @property
    def reference(self) -> int:
        """The block whose plane is the reference of heights; 0 for the image's vertical."""
        return self._held.reference

    def add_point(self, x: float, y: float) -> bool:
        """Add the pixel at image coordinates x, y to the open measurement, or start one there; False, with `refused`,
        if the pixel has no 3D position."""
        if not self._workspace.has_session:
            return False
        session = self._workspace.session
        depth = session.current_depth()
        try:
            point_in_space(session.frame.depth if depth is None else depth, (x, y), session.frame.intrinsics)
        except InputError as error:
            self.refused.emit(str(error))
            return False
        held = self._held
        if held.is_open:
            held.chains[-1].append((x, y))
        else:
            held.chains.append([(x, y)])
            held.is_open = True
        self._changed()
        return True

    def move_point(self, chain: int, point: int, to: Point) -> None:
        """Move a point of a measurement."""
        self._held.chains[chain][point] = to
        self._changed()

    def undo_last(self) -> bool:
        """Remove the last point of the open measurement; False if there is none."""
        held = self._held
        if not held.is_open:
            return False
        held.chains[-1].pop()
        if not held.chains[-1]:
            held.chains.pop()
            held.is_open = False
        self._changed()
        return True

    def end(self) -> bool:
        """Close the open measurement; a single point is dropped. False if there is none."""
        held = self._held
        if not held.is_open:
            return False
        held.is_open = False
        if len(held.chains[-1]) == 1:
            held.chains.pop()
        self._changed()
        return True

    def replace(self, chains: list[tuple[Point, ...]]) -> None:
        """Replace all measurements."""
        held = self._held
        held.chains, held.is_open = [list(chain) for chain in chains], False
        self._changed()

    def set_reference(self, label: int) -> None:
        """Measure heights over the plane of a block; 0 for the image's vertical."""
        if label != self._held.reference:
            self._held.reference = label
            self._changed()

    @property
    def _held(self) -> Chains:
        return self._workspace.session.chains if self._workspace.has_session else Chains()

    def _changed(self) -> None:
        self._workspace.frames.touch(self._workspace.session)
        self.changed.emit()


Line = tuple[Point, Point]
"""Ends in image coordinates."""


class Inspection(QObject):
    """The inspection marks of the current frame. They are stored with the frame; changing them is not undoable.

    Attributes
    ----------
    measurements : Measurements

    Signals
    -------
    line_changed()
        The profile line was changed or removed.
    """

    line_changed = Signal()

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.measurements = Measurements(workspace, self)
        workspace.frames.session_changed.connect(self.line_changed)

    @property
    def line(self) -> Line | None:
        """The current frame's profile line."""
        return self._workspace.session.line if self._workspace.has_session else None

    def set_line(self, line: Line | None) -> None:
        """Set the profile line; None removes it."""
        if line == self.line:
            return
        session = self._workspace.session
        session.line = line
        self._workspace.frames.touch(session, viewing=True)
        self.line_changed.emit()

    @property
    def region(self) -> Box | None:
        """The current frame's rectangle."""
        return self._workspace.session.region if self._workspace.has_session else None

    def set_region(self, box: Box | None) -> None:
        """Set the rectangle; None removes it."""
        self._workspace.blocks.set_region(box)
