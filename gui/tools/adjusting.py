"""Lines that are adjusted after they were drawn: their points are moved, added and removed, and the effect follows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

from ilf.segmentation.editing.patches import LabelPatch, Labels

from ..state.document import Document
from ..views.interaction import PointerEvent
from .base import Host, Point, Press, line_path
from .line import LineTool, Snap, Stretch, effect_of, nearest, off_line, touches

_SLACK = 4.0
"""Maximum distance of a free line from the straight lines between its points [screen pixels]."""


@dataclass(frozen=True)
class AdjustableLine:
    """A line with points that can be moved.

    Attributes
    ----------
    stretches : tuple of tuple of (x, y)
        The line from one point to the next; each starts where the one before it ends.
    closed : bool
        Whether the last stretch ends where the first one starts.
    """

    stretches: tuple[tuple[Point, ...], ...]
    closed: bool

    @staticmethod
    def of(drawn: Sequence[Stretch], closing: Sequence[Point], slack: float) -> AdjustableLine:
        """Return a drawn line; its points are the ends of its stretches, and the bends of those drawn freely.

        Parameters
        ----------
        drawn : sequence of Stretch
        closing : sequence of (x, y)
            The line from its end back to its start; empty for an open line.
        slack : float
            Maximum distance of a free stretch from the straight lines between its points [px].
        """
        stretches = [part for one in drawn for part in (_parts(one.line, slack) if one.free else [one.line])]
        if closing and math.dist(closing[0], closing[-1]) <= 2 * slack:
            stretches[-1] = [*stretches[-1], closing[-1]]
        elif closing:
            stretches.append(list(closing))
        return AdjustableLine(tuple(tuple(one) for one in stretches), bool(closing))

    @property
    def corners(self) -> list[Point]:
        """The points that can be moved."""
        starts = [stretch[0] for stretch in self.stretches]
        return starts if self.closed else [*starts, self.stretches[-1][-1]]

    @property
    def points(self) -> list[Point]:
        """All points of the line; of a closed one, the first is not repeated."""
        points = [point for stretch in self.stretches for point in stretch[:-1]]
        return points if self.closed else [*points, self.stretches[-1][-1]]

    def moved(self, corner: int, point: Point, straight: bool, snap: Snap) -> AdjustableLine:
        """Return the line with a point moved; the stretches beside it keep their shape and snap, or become straight."""
        before, after = self._beside(corner)
        old = self.corners[corner]
        shift = point[0] - old[0], point[1] - old[1]
        line: list[Point] = []
        if before is not None:
            stretch = self.stretches[before]
            line = [stretch[0], point] if straight else _bent(stretch, shift)
        if after is not None:
            stretch = self.stretches[after]
            line = line[:-1] + ([point, stretch[-1]] if straight else _bent(stretch[::-1], shift)[::-1])
        if not straight:
            line = list(snap(line))
        at = min(range(len(line)), key=lambda k: math.dist(line[k], point))
        at = 0 if before is None else len(line) - 1 if after is None else min(max(at, 1), len(line) - 2)
        changed = list(self.stretches)
        if before is not None:
            changed[before] = (self.stretches[before][0], *line[1 : at + 1])
        if after is not None:
            changed[after] = (*line[at:-1], self.stretches[after][-1])
        return replace(self, stretches=tuple(changed))

    def divided(self, event: PointerEvent) -> tuple[AdjustableLine, int] | None:
        """Return the line with a point added under the pointer, and its index; None if it is not on the line."""
        at = event.x, event.y
        found = [
            (off_line(at, *ends), number, k)
            for number, stretch in enumerate(self.stretches)
            for k, ends in enumerate(itertools.pairwise(stretch))
            if touches(*ends, event)
        ]
        if not found:
            return None
        _, number, k = min(found)
        stretch = self.stretches[number]
        parts = (*stretch[: k + 1], at), (at, *stretch[k + 1 :])
        return replace(self, stretches=(*self.stretches[:number], *parts, *self.stretches[number + 1 :])), number + 1

    def without(self, corner: int, snap: Snap) -> AdjustableLine | None:
        """Return the line without a point; None if too few would be left."""
        if len(self.corners) <= (3 if self.closed else 2):
            return None
        before, after = self._beside(corner)
        changed = list(self.stretches)
        if before is not None and after is not None:
            ends = changed[before][0], changed[after][-1]
            changed[before] = (ends[0], *snap(list(ends))[1:-1], ends[1])
        del changed[corner if after is not None else corner - 1]
        return replace(self, stretches=tuple(changed))

    def _beside(self, corner: int) -> tuple[int | None, int | None]:
        """The indices of the stretches that end and start at a point."""
        count = len(self.stretches)
        if self.closed:
            return (corner - 1) % count, corner
        return (corner - 1 if corner > 0 else None), (corner if corner < count else None)


def _parts(line: Sequence[Point], slack: float) -> list[list[Point]]:
    """Divide a line at its bends, so that each part is nearly straight."""
    inner = range(1, len(line) - 1)
    farthest = max(inner, key=lambda k: off_line(line[k], line[0], line[-1]), default=0)
    if off_line(line[farthest], line[0], line[-1]) <= slack:
        return [list(line)]
    return _parts(line[: farthest + 1], slack) + _parts(line[farthest:], slack)


def _bent(stretch: Sequence[Point], shift: Point) -> list[Point]:
    """Return a stretch whose end is moved, and whose other points follow the less the nearer they are to its start."""
    last = len(stretch) - 1
    return [(x + shift[0] * k / last, y + shift[1] * k / last) for k, (x, y) in enumerate(stretch)]


@dataclass(frozen=True, eq=False)
class _Applied:
    """A line after it was applied: the labels before, and the undo step that it made; None if it changes nothing."""

    line: AdjustableLine
    document: Document
    before: Labels
    text: str
    step: int | None


_Grip = tuple[AdjustableLine, int, bool]
"""A line that has a point which is held, the point, and whether it is removed unless it is dragged."""


class AdjustableTool(LineTool):
    """Base of line tools whose line stays with its points after it was applied, until Enter or another action.

    Changes of the line replace the undo step that it made. Escape drops it with that step.
    """

    def __init__(self) -> None:
        super().__init__()
        self._applied: _Applied | None = None
        self._grip: _Grip | None = None
        self.label = 0
        """The block that the line is drawn for; 0 for none."""

    def change(self, labels: Labels, line: list[Point], document: Document) -> LabelPatch | None:
        """Return the change of a label map of a document by a line; also called in the background."""
        raise NotImplementedError

    def explain(self, line: list[Point], document: Document) -> str:
        """Return a sentence why a line changes nothing."""
        raise NotImplementedError

    def after_change(self, before: Labels, patch: LabelPatch, host: Host) -> None:
        """Called after a line has changed a label map."""

    def draw(self, press: Press, event: PointerEvent, host: Host) -> None:
        """End a click or a drag that does not adjust the line."""
        raise NotImplementedError

    @property
    def slack(self) -> float:
        """Maximum distance of a free line from the straight lines between its points [px]."""
        return _SLACK * self._pixel

    @property
    def adjust_hint(self) -> str:
        """Hint while the line can be adjusted; empty if there is none."""
        if self._grip is not None and self.release_hint:
            return self.release_hint
        if self._applied is None:
            return ""
        return (
            "Drag a point: adjust the line | click the line: add a point | Ctrl+click: remove a point | Enter: done | "
            "Esc: drop the line"
        )

    def cancel(self, host: Host) -> None:
        """Cancel the line, or end its adjustment."""
        self._grip = self._applied = None
        super().cancel(host)

    def finish(self, host: Host) -> bool:
        """End the adjustment of the line."""
        if self._applied is None:
            return False
        self.cancel(host)
        return True

    def remove(self, host: Host) -> bool:
        """Drop the line that was applied, and undo its effect."""
        applied = self._applied
        if applied is None:
            return False
        undoes = applied.step is not None and self._is_last(applied, host)
        self.cancel(host)
        if undoes:
            host.document.undo_stack.undo()
        return True

    def apply(self, line: AdjustableLine, text: str, host: Host) -> None:
        """Apply a line as one undo step, and keep it for adjustment if it changes anything."""
        self._put(_Applied(line, host.document, host.document.labels.copy(), text, None), host)

    def _put(self, applied: _Applied, host: Host) -> None:
        """Make the undo step of a line in place of the one that it had, or show a message if it changes nothing."""
        is_kept = self._applied is not None
        patch = self.change(applied.before, applied.line.points, applied.document)
        if applied.step is not None:
            host.document.undo_stack.undo()
        done = host.commit(patch, applied.text, self.label)
        if done is not None:
            self.after_change(applied.before, done, host)
        elif patch is None:
            host.show_message(self.explain(applied.line.points, host.document))
        if is_kept or done is not None:
            step = None if done is None else host.document.undo_stack.index()
            self._keep(replace(applied, step=step), host)

    def _begin(self, event: PointerEvent, host: Host) -> bool:
        """Hold a point of the line under the press; elsewhere, its adjustment ends."""
        applied, self._grip = self._applied, None
        if applied is not None:
            self._grip = self._gripped(applied.line, event) if self._is_last(applied, host) else None
            if self._grip is None:
                self.cancel(host)
        return True

    @staticmethod
    def _gripped(line: AdjustableLine, event: PointerEvent) -> _Grip | None:
        """Return the point of a line under a press, or one that is added there; None beside the line."""
        corner = nearest(line.corners, event)
        held = line.divided(event) if corner is None else (line, corner)
        return None if held is None else (*held, corner is not None and event.opposite)

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Move the point that is held, or draw."""
        grip, applied = self._grip, self._applied
        if grip is None or applied is None:
            return super()._drag(press, event, host)
        if press.follow(event):
            self._pixel = event.pixel
            line = grip[0].moved(grip[1], (event.x, event.y), event.shift, self._snap(host))
            self._show_line(line, host)
            find = partial(self.change, applied.before, line.points, applied.document)
            host.run_in_background(find, partial(self._preview, line, host))
        return press.drags

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        """Let go of the point: it is moved, removed or added."""
        grip, applied = self._grip, self._applied
        if grip is None or applied is None:
            self.draw(press, event, host)
            return
        self._grip = self._effect = None
        line, corner, removes = grip
        snap = self._snap(host)
        if press.drags:
            self._put(replace(applied, line=line.moved(corner, (event.x, event.y), event.shift, snap)), host)
        elif removes:
            fewer = line.without(corner, snap)
            if fewer is None:
                host.show_message("The line needs its last points. Esc drops it.")
            else:
                self._put(replace(applied, line=fewer), host)
        elif line is not applied.line:  # a point was added
            self._keep(replace(applied, line=line), host)

    def _is_last(self, applied: _Applied, host: Host) -> bool:
        """Return whether nothing else was done since the line was applied."""
        return applied.document is host.document and applied.step in (None, host.document.undo_stack.index())

    def _keep(self, applied: _Applied, host: Host) -> None:
        self._applied = applied
        self._show_line(applied.line, host)

    def _preview(self, line: AdjustableLine, host: Host, patch: LabelPatch | None) -> None:
        if self._grip is not None:
            self._effect = effect_of(host.document, patch)
            self._show_line(line, host)

    def _show_line(self, line: AdjustableLine, host: Host) -> None:
        self._show_path(line_path(line.points, line.closed), line.corners, host)
