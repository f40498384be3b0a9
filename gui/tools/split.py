"""Cutting a block along a line."""

from __future__ import annotations

import math

import cv2
import numpy as np

from gui.state.session import Session
from gui.tools.base import Host, line_path
from gui.views.pointer import PointerEvent, PointerKind
from ilf.ebs.edit import split


class SplitTool:
    """Drag a line across a block, from outside to outside; Shift keeps it at multiples of 45 degrees."""

    hint = "Drag a line right across a block to cut it in two | Shift: 45 degree steps | Esc: give up"

    def __init__(self) -> None:
        self._start: tuple[float, float] | None = None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Draw the line while the button is down, cut at its release."""
        if event.kind is PointerKind.PRESS:
            self._start = event.x, event.y
        elif self._start is not None and event.kind is PointerKind.MOVE:
            host.show_preview(line_path([self._start, _end_point(self._start, event)]))
        elif self._start is not None and event.kind is PointerKind.RELEASE:
            start, self._start = self._start, None
            host.show_preview(None)
            self._cut([start, _end_point(start, event)], host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a press like any other

    def cancel(self, host: Host) -> bool:
        """Drop the line."""
        under_way, self._start = self._start is not None, None
        host.show_preview(None)
        return under_way

    def _cut(self, points: list[tuple[float, float]], host: Host) -> None:
        session = host.session
        label = most_crossed(session, points)
        if label == 0:
            host.say("The line crosses no block.")
            return
        name = session.info(label).name
        if label in session.locked:
            host.say(f"{name} is locked. Unlock it in the table of blocks.")
        elif host.commit(split(session.labels, label, points, session.locked, session.next_label()), f"Split {name}"):
            host.select([label])
        else:
            host.say(f"The line does not part {name}: draw it from boundary to boundary.")


def most_crossed(session: Session, points: list[tuple[float, float]]) -> int:
    """The chosen block if the line crosses it, else the one it crosses most; 0 for none."""
    line = np.zeros(session.labels.shape, np.uint8)
    path = np.floor(np.asarray(points)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], False, 1)
    crossed = np.bincount(session.labels[line > 0], minlength=1)
    crossed[0] = 0
    for label in session.selected[:1]:
        if label < crossed.size and crossed[label]:
            return label
    return int(np.argmax(crossed))


def _end_point(start: tuple[float, float], event: PointerEvent) -> tuple[float, float]:
    if not event.shift:
        return event.x, event.y
    along, down = event.x - start[0], event.y - start[1]
    angle = round(math.atan2(down, along) / (math.pi / 4)) * math.pi / 4
    length = math.hypot(along, down)
    return start[0] + length * math.cos(angle), start[1] + length * math.sin(angle)
