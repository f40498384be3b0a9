"""Steps through the quality checks of the current frame, updated after edits."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, QPointF, Signal
from PySide6.QtGui import QAction, QPainterPath

from ilf._runtime.formatting import counted
from ilf.data.blocks import Box
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.evaluation.quality.places import Place
from ilf.evaluation.quality.ranking import find_places, propagated_places
from ilf.segmentation.edges.frame_edges import find_edges

from ...state.session import Session
from ...state.workspace import Workspace
from ...views.linked_views import LinkedViews
from ...work.latest_request import LatestRequest
from .marks import PlaceMarks, ReviewStrip

# Quality checks: the current place, and the ignored ones. No widgets.

_SAME = 30.0
"""Maximum distance [px] at which an ignored place equals another one of the same kind and block."""

_ROOM = 10
"""Margin [px] around the box of the former place in which a place counts as the same: an edit may move it."""


class Review:
    """Flagged places of one frame, the worst first, and the current one."""

    def __init__(self) -> None:
        self.places: Sequence[Place] = ()
        self.present: Place | None = None
        """The current place; None before the first one, and after it has been fixed."""
        self._ignored: list[Place] = []
        self._next = 0

    @property
    def ignored(self) -> int:
        """Number of ignored places."""
        return len(self._ignored)

    @property
    def number(self) -> int:
        """Number of the current place, from 1; 0 for none."""
        return 0 if self.present is None else self.places.index(self.present) + 1

    def take(self, found: Sequence[Place]) -> bool:
        """Set the places found after a change; return True if the current place is gone."""
        former = self.present
        self.places = [place for place in found if not any(_is_same(place, one) for one in self._ignored)]
        if former is None:
            return False
        self._next = self._worse_than(former)
        self.present = next((place for place in self.places if _is_part(place, former)), None)
        return self.present is None

    def _worse_than(self, former: Place) -> int:
        """Count the places with a higher score than a former one."""
        return sum(place.score > former.score for place in self.places)

    def step(self, by: int) -> Place | None:
        """Move to the next place, or to the previous one with -1, cyclically; return it, None if there is none."""
        if not self.places:
            self.present = None
            return None
        if self.present is None:
            position = self._next if by > 0 else self._next - 1
        else:
            position = self.places.index(self.present) + by
        self.present = self.places[position % len(self.places)]
        return self.present

    def leave(self) -> Place | None:
        """Ignore the current place permanently, and move to the next; return it, None if there is none."""
        if self.present is None:
            return self.step(1)
        self._ignored.append(self.present)
        self._next = self.number - 1
        self.places = [place for place in self.places if place is not self.present]
        self.present = None
        return self.step(1)


def _is_same(place: Place, other: Place) -> bool:
    alike = place.kind == other.kind and set(place.labels) & set(other.labels)
    return bool(alike) and math.dist(place.point, other.point) < _SAME


def _is_part(place: Place, whole: Place) -> bool:
    rows, columns = whole.box
    inside = (
        columns.start - _ROOM <= place.point[0] < columns.stop + _ROOM
        and rows.start - _ROOM <= place.point[1] < rows.stop + _ROOM
    )
    return inside and place.kind == whole.kind and bool(set(place.labels) & set(whole.labels))


_MIN_SIDE, _MAX_SIDE = 96, 320
"""Minimum and maximum side of the shown region [px]."""

_RING = 10.0
"""Radius of the ring around the centre of a place [px]."""


@dataclass(frozen=True, eq=False)
class _Request:
    session: Session
    frame: RGBDFrame
    labels: NDArray[np.int32]
    extraction: BlockParameters
    error: NDArray[np.float32] | None
    to_check: dict[int, str]
    """Propagated blocks that need a check -> reason."""


class ReviewPresenter(QObject):
    """Shows one flagged place after the other: zooms to it, selects the block, and shows reason and number.

    The search runs in a worker thread, and again after every edit while the strip is visible. Ignored places stay
    ignored while the frame is open.

    Parameters
    ----------
    leave : QAction
        Command that ignores a place; enabled while there is a current one.

    Signals
    -------
    shown()
        The views show a place.
    failed(object)
        The exception raised during the search.
    """

    shown = Signal()
    failed = Signal(object)

    def __init__(self, workspace: Workspace, views: LinkedViews, strip: ReviewStrip, leave: QAction) -> None:
        super().__init__(strip)
        self._workspace = workspace
        self._views = views
        self._strip = strip
        self._leave = leave
        leave.setEnabled(False)
        self._marks = PlaceMarks(views)
        self._reviews: WeakKeyDictionary[Session, Review] = WeakKeyDictionary()
        self._requested: _Request | None = None
        """The last request; None while the review is closed."""
        self._fresh = False
        self._pending_step = 0
        self._questions = LatestRequest[_Request, Sequence[Place]](_find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)
        workspace.frames.session_changed.connect(self.close)
        for changed in (
            workspace.blocks.labels_changed,
            workspace.blocks.invalid_mask_changed,
            workspace.runs.error_changed,
        ):
            changed.connect(lambda *_: self._ask_again())
        workspace.blocks.infos_changed.connect(self._note_checked)

    @property
    def busy(self) -> bool:
        """Whether the search is in progress."""
        return self._questions.busy

    @property
    def review(self) -> Review:
        """The places of the current frame."""
        return self._reviews.setdefault(self._workspace.session, Review())

    def go(self, by: int) -> None:
        """Show the next place, or the previous one with -1."""
        if not self._workspace.has_session:
            return
        if not self._fresh:
            self._pending_step = by
            self._strip.show_message("Running quality checks…")
            if self._requested is None:
                self._ask()
            return
        self._show(self.review.step(by))

    def leave(self) -> None:
        """Ignore the current place and show the next; a propagated block is marked as checked."""
        if not (self._workspace.has_session and self._fresh):
            return
        place = self.review.present
        if place is not None and place.kind == "propagated":
            self._pending_step = 1
            self._workspace.blocks.mark_checked(place.labels)
        else:
            self._show(self.review.leave())

    def close(self) -> None:
        """Close the review."""
        self._questions.forget()
        self._requested, self._fresh, self._pending_step = None, False, 0
        self._marks.clear()
        self._leave.setEnabled(False)
        self._strip.hide()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _ask_again(self) -> None:
        if self._requested is not None:
            self._ask()

    def _note_checked(self) -> None:
        """Search again if other blocks need a check."""
        if self._requested is not None and self._workspace.session.to_check != self._requested.to_check.keys():
            self._ask()

    def _ask(self) -> None:
        session = self._workspace.session
        to_check = {label: session.notes.reasons.get(label, "") for label in session.to_check}
        extraction = session.notes.extraction or BlockParameters()
        self._fresh = False
        self._requested = _Request(
            session, session.frame, session.labels.copy(), extraction, session.expected_error(), to_check
        )
        self._questions.ask(self._requested)

    def _take(self, question: _Request, found: Sequence[Place]) -> None:
        if question is not self._requested:
            return
        former = self.review.present
        gone = self.review.take(found)
        # the expected error is unknown until the depth has been completed again
        fixed = gone and former is not None and (former.kind != "error" or question.error is not None)
        self._fresh = True
        pending_step, self._pending_step = self._pending_step, 0
        if pending_step:
            self._show(self.review.step(pending_step))
        else:
            self._say(fixed)

    def _fail(self, question: _Request, error: Exception) -> None:
        self.close()
        self.failed.emit(error)

    def _show(self, place: Place | None) -> None:
        if place is not None:
            session = self._workspace.session
            there = [label for label in place.labels if label in session.counts()]
            self._workspace.blocks.select(there[:1])
            self._views.zoom_to(*_region_around(place, session.frame.shape))
        self._say(False)
        self.shown.emit()

    def _say(self, fixed: bool) -> None:
        review = self.review
        count, place = len(review.places), review.present
        self._leave.setEnabled(place is not None)
        if place is not None:
            path = QPainterPath()
            path.addEllipse(QPointF(*place.point), _RING, _RING)
            self._marks.show(path)
            self._strip.show_message(f"{review.number} of {count}: {self._named(place.reason)}")
            return
        self._marks.clear()
        ignored = f" {review.ignored} ignored." if review.ignored else ""
        if count:
            done = "Fixed. " if fixed else ""
            self._strip.show_message(f"{done}{counted(count, 'flagged place')} left to check.")
        elif fixed:
            self._strip.show_message(f"Fixed. That was the last flagged place.{ignored}")
        else:
            self._strip.show_message(f"No more flagged places.{ignored}" if ignored else "No flagged places.")

    def _named(self, reason: str) -> str:
        """Return the reason, with the names of blocks instead of their numbers."""
        infos = self._workspace.session.infos

        def name(found: re.Match[str]) -> str:
            info = infos.get(int(found[1]))
            return found[0] if info is None else info.name

        return re.sub(r"Block (\d+)", name, reason)


def _find(question: _Request) -> Sequence[Place]:
    """Find the flagged places; called in a worker thread."""
    strength = find_edges(question.frame, question.extraction).strength
    propagated = propagated_places(question.labels, question.to_check)
    return [*propagated, *find_places(question.frame, question.labels, strength, question.error)]


def _region_around(place: Place, shape: tuple[int, int]) -> Box:
    """Return the region to show: the place with its surroundings, or only its centre if it is too large."""
    spans = []
    for span, middle, size in zip(place.box, place.point[::-1], shape, strict=True):
        side = min(max(2 * (span.stop - span.start), _MIN_SIDE), _MAX_SIDE)
        centre = middle if span.stop - span.start > _MAX_SIDE else (span.start + span.stop) / 2
        start = min(max(round(centre - side / 2), 0), max(size - side, 0))
        spans.append(slice(start, min(start + side, size)))
    return spans[0], spans[1]
