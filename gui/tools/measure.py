"""Points to measure between."""

from __future__ import annotations

from gui.tools.base import Host, Point, Press, Tool, line_path
from gui.tools.grips import clamped, nearest
from gui.views.pointer import PointerEvent, PointerKind
from gui.views.preview import Preview


class MeasureTool(Tool):
    """Every click adds a point to the measurement under way; a point that is dragged moves."""

    points_only = True

    def __init__(self) -> None:
        self._press: Press | None = None
        self._held: tuple[int, int] | None = None
        self._before: Point = 0.0, 0.0
        self._under_way = False

    @property
    def hint(self) -> str:
        """What a click would do."""
        if self._under_way:
            return "Click: the next point | Backspace: take back | Enter or double-click: done"
        return "Click: measure from here | drag a point: move it"

    @property
    def busy(self) -> bool:
        """Whether a measurement is under way."""
        return self._under_way or self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Add a point by a click, move one by a drag, show how the measurement would go on."""
        measurements, at = host.inspection.measurements, clamped((event.x, event.y), host.session.frame.shape)
        if event.kind is PointerKind.PRESS:
            self._press, self._held = Press(event), _held(host, event)
            if self._held is not None:
                self._before = measurements.chains[self._held[0]][self._held[1]]
        elif event.kind is PointerKind.MOVE and self._press is not None:
            if self._press.follow(event) and self._held is not None:
                measurements.move_point(*self._held, at)
        elif event.kind is PointerKind.RELEASE and self._press is not None:
            press, self._press = self._press, None
            if self._held is None or not press.drags:
                measurements.add_point(*at)
        elif event.kind is PointerKind.DOUBLE:
            self.finish(host)
        self._under_way = measurements.is_open
        shows = self._under_way and event.kind is PointerKind.HOVER
        host.show_preview(Preview(line_path([measurements.chains[-1][-1], at]), dashed=True) if shows else None)
        return True

    def finish(self, host: Host) -> bool:
        """The measurement is whole."""
        return self.cancel(host)

    def cancel(self, host: Host) -> bool:
        """Put back a point that is being dragged, or end the measurement, which stays if it has more than one point."""
        measurements = host.inspection.measurements
        press, self._press = self._press, None
        host.show_preview(None)
        if press is not None and press.drags and self._held is not None:
            measurements.move_point(*self._held, self._before)
            return True
        self._under_way = False
        return measurements.end() or press is not None

    def take_back(self, host: Host) -> bool:
        """Drop the last point."""
        host.show_preview(None)
        done = host.inspection.measurements.take_back()
        self._under_way = host.inspection.measurements.is_open
        return done


def _held(host: Host, event: PointerEvent) -> tuple[int, int] | None:
    """Measurement and number of the point that a press takes hold of."""
    places = [(n, m) for n, chain in enumerate(host.inspection.measurements.chains) for m in range(len(chain))]
    points = [point for chain in host.inspection.measurements.chains for point in chain]
    found = nearest(points, event)
    return None if found is None else places[found]
