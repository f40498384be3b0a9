"""What of the present frame is looked at closely: a line, a rectangle, measurements."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from ilf.data.blocks import Box
from ilf.errors import InputError
from ilf.evaluation.measuring import place_of

from .session import Chains, Point
from .workspace import Workspace

# The points that are measured between, of every open frame.


class Measurements(QObject):
    """Chains of points on the present frame, in image coordinates; each is one measurement. They stay with their frame.

    Signals
    -------
    changed()
        Points, or what heights are measured along.
    refused(str)
        Why a point has not been taken.
    """

    changed = Signal()
    refused = Signal(str)

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        workspace.session_changed.connect(self.changed)

    @property
    def chains(self) -> list[tuple[Point, ...]]:
        """All measurements, the oldest first."""
        return [tuple(chain) for chain in self._held.chains]

    @property
    def is_open(self) -> bool:
        """Whether the next point belongs to the last measurement."""
        return self._held.is_open

    @property
    def reference(self) -> int:
        """The block whose plane heights are measured over; 0 for the image's upright."""
        return self._held.reference

    def add_point(self, x: float, y: float) -> bool:
        """Go on to the pixel at image coordinates x, y, or begin there; False, with `refused`, if it has no place in
        space."""
        if not self._workspace.has_session:
            return False
        session = self._workspace.session
        depth = session.present_depth()
        try:
            place_of(session.frame.depth if depth is None else depth, (x, y), session.frame.intrinsics)
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
        """Put a point of a measurement elsewhere."""
        self._held.chains[chain][point] = to
        self._changed()

    def take_back(self) -> bool:
        """Drop the last point of the measurement under way; False if there is none."""
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
        """Let the next point begin another measurement; a single point is dropped. False if none is under way."""
        held = self._held
        if not held.is_open:
            return False
        held.is_open = False
        if len(held.chains[-1]) == 1:
            held.chains.pop()
        self._changed()
        return True

    def replace(self, chains: list[tuple[Point, ...]]) -> None:
        """Have these measurements in place of those there are."""
        held = self._held
        held.chains, held.is_open = [list(chain) for chain in chains], False
        self._changed()

    def set_reference(self, label: int) -> None:
        """Measure heights over the plane of a block; 0 for the image's upright."""
        if label != self._held.reference:
            self._held.reference = label
            self._changed()

    @property
    def _held(self) -> Chains:
        return self._workspace.session.chains if self._workspace.has_session else Chains()

    def _changed(self) -> None:
        self._workspace.touch(self._workspace.session)
        self.changed.emit()


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
