"""What tools have in common whose drag draws one shape over the picture, or changes the one that is there."""

from __future__ import annotations

from typing import Generic, TypeVar

from gui.state.inspection import Inspection
from gui.tools.base import Host, Press, Tool
from gui.views.pointer import PointerEvent, PointerKind

Shape = TypeVar("Shape")
Grip = TypeVar("Grip")


class DraggedTool(Tool, Generic[Shape, Grip]):
    """A drag draws the shape anew, or from where the press takes hold of it, changes it; there is one per frame."""

    def __init__(self) -> None:
        self._press: Press | None = None
        self._before: Shape | None = None
        self._grip: Grip | None = None
        """What the press has taken hold of; None to draw anew."""

    def shape(self, inspection: Inspection) -> Shape | None:
        """The present shape."""
        raise NotImplementedError

    def put(self, inspection: Inspection, shape: Shape | None) -> None:
        """Have another shape, or none."""
        raise NotImplementedError

    def grip(self, shape: Shape, event: PointerEvent) -> Grip | None:
        """What a press takes hold of; None for nothing."""
        raise NotImplementedError

    def dragged(self, press: Press, event: PointerEvent, frame: tuple[int, int]) -> Shape:
        """The shape that a drag has come to, on a frame of shape (H, W)."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether the shape is being dragged."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw or change the shape while the button is down."""
        if event.kind is PointerKind.PRESS:
            self._press, self._before = Press(event), self.shape(host.inspection)
            self._grip = None if self._before is None else self.grip(self._before, event)
        elif event.kind in (PointerKind.MOVE, PointerKind.RELEASE) and self._press is not None:
            if self._press.follow(event):
                self.put(host.inspection, self.dragged(self._press, event, host.session.frame.shape))
            if event.kind is PointerKind.RELEASE:
                self._press = None
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Put the shape back as it was."""
        under_way, self._press = self.busy, None
        if under_way:
            self.put(host.inspection, self._before)
        return under_way

    def remove(self, host: Host) -> bool:
        """Remove the shape."""
        there = self.shape(host.inspection) is not None
        self.put(host.inspection, None)
        return there
