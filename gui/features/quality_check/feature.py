"""Steps through the quality checks of the current frame, updated after edits."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainterPath

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.data.parameters import BlockParameters
from ilf.errors import IlfError
from ilf.evaluation.quality.ignored import without_ignored
from ilf.evaluation.quality.places import Place
from ilf.evaluation.quality.ranking import find_places, propagated_places
from ilf.evaluation.quality.remedies import Remedy, find_remedy
from ilf.segmentation.edges.frame_edges import find_edges

from ...base.commands import Command
from ...base.needs import Need
from ...state.document import Document
from ...work.latest_request import LatestRequest
from ..context import Context, Feature
from ..tools import ToolsFeature
from .marks import CheckStrip, PlaceMarks, RemedyPreviews
from .review import Review

_MIN_SIDE, _MAX_SIDE = 96, 320
"""Minimum and maximum side of the shown region [px]."""

_RING = 10.0
"""Radius of the ring around the centre of a place [px]."""


@dataclass(frozen=True, eq=False)
class _Request:
    document: Document
    frame: RGBDFrame
    labels: NDArray[np.int32]
    extraction: BlockParameters
    error: NDArray[np.float32] | None
    to_check: dict[int, str]
    """Propagated blocks that need a check -> reason."""


@dataclass(frozen=True, eq=False)
class _RemedyRequest:
    """A place that was found by a search, locked blocks, and the label of a new block."""

    search: _Request
    place: Place
    locked: frozenset[int]
    new: int


class QualityCheckFeature(Feature):
    """Shows one flagged place after the other: zooms to it, selects the block, shows reason and number, and a remedy.

    The search runs in a worker thread, and again after every edit while the strip is visible. The remedy for the place
    follows in another; Enter applies it and goes on to the next place.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = workspace = context.workspace
        self._views = views = context.views
        self._has_place = False
        """Whether there is a place to ignore."""
        self._requested: _Request | None = None
        """The last request; None while the review is closed."""
        self._found: Sequence[Place] = ()
        """All places of the last search, with ignored ones."""
        self._fresh = False
        self._pending_step = 0
        self._remedy_requested: _RemedyRequest | None = None
        self._remedy: Remedy | None = None
        context.actions.add(self._commands())
        names = "previous_check", "next_check", "ignore_check", "apply_remedy", "close_checks"
        self.strip = CheckStrip(*(context.actions[name] for name in names))
        context.centre.add_strip(self.strip)
        self._marks, self._previews = PlaceMarks(views), RemedyPreviews(views)
        self._reviews: WeakKeyDictionary[Document, Review] = WeakKeyDictionary()
        self._questions = LatestRequest[_Request, Sequence[Place]](_find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)
        self._remedies = LatestRequest[_RemedyRequest, Remedy | None](_find_remedy, self)
        self._remedies.answered.connect(self._take_remedy)
        self._remedies.failed.connect(self._fail)
        workspace.frames.session_changed.connect(self.close)
        for changed in (
            workspace.labels_changed,
            workspace.blocks.invalid_mask_changed,
            workspace.blocks.neighbours_changed,
            workspace.runs.error_changed,
        ):
            changed.connect(lambda *_: self._ask_again())
        workspace.blocks.infos_changed.connect(self._note_infos)
        workspace.blocks.ignored_changed.connect(self._note_ignored)

    def begin(self) -> None:
        """Connect the key that applies the remedy, unless the tool needs it, as its hint says."""
        self.context.feature(ToolsFeature).keys.on_enter(lambda: self.strip.isVisible() and self.apply())
        for changed in (self.context.editor.hint_changed, self.context.editor.tool_changed):
            changed.connect(self._show_remedy)

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "next_check",
                "Next &quality check",
                "Go to the next place where blocks or filled depth look wrong, largest error first",
                icon="ph.crosshair",
                keys="F8",
                handler=lambda: self.go(1),
                needs=Need.FRAME,
            ),
            Command(
                "previous_check",
                "Pre&vious quality check",
                "Go to the previous place",
                icon="ph.caret-left",
                keys="Shift+F8",
                handler=lambda: self.go(-1),
                needs=Need.FRAME,
            ),
            Command(
                "apply_remedy",
                "&Apply remedy",
                "Apply the remedy that is shown for the place, and go to the next place; Enter does the same",
                icon="ph.check",
                handler=self.apply,
                why_off=lambda: "" if self._remedy is not None else "No remedy is shown: press F8 first.",
            ),
            Command(
                "ignore_check",
                "&Ignore",
                "Ignore this place: it is not shown again until blocks or known depth change there",
                icon="ph.eye-slash",
                keys="Ctrl+F8",
                handler=self.leave,
                why_off=lambda: "" if self._has_place else "No place is shown: press F8 first.",
            ),
            Command("close_checks", "&Close", "End the quality check", icon="ph.x", handler=self.close),
        )

    @property
    def busy(self) -> bool:
        """Whether a search for places or for a remedy is in progress."""
        return self._questions.busy or self._remedies.busy

    @property
    def review(self) -> Review:
        """The places of the current frame."""
        return self._reviews.setdefault(self._workspace.current, Review())

    @property
    def remedy(self) -> Remedy | None:
        """The remedy shown for the current place; None if there is none, or none yet."""
        return self._remedy

    def go(self, by: int) -> None:
        """Show the next place, or the previous one with -1."""
        if not self._workspace.has_current:
            return
        self._views.take_focus()
        if not self._fresh:
            self._pending_step = by
            self.strip.show_places("Running quality checks…")
            if self._requested is None:
                self._ask()
            return
        self._show(self.review.step(by))

    def apply(self) -> bool:
        """Apply the remedy and show the next place; return False if none is shown."""
        request, remedy = self._remedy_requested, self._remedy
        if request is None or remedy is None:
            return False
        self._pending_step = 1
        if remedy.kind == "checked":
            self._workspace.current.mark_checked(request.place.labels)
        elif remedy.patch is not None:
            if self.context.editor.commit(remedy.patch, self._named(remedy.text)) is None:
                self._pending_step = 0
                self.go(1)  # only a rest would have been cut off
        elif remedy.by_hand is not None:
            self._workspace.current.set_by_hand(remedy.by_hand, np.isfinite(remedy.by_hand), "Continue plane")
            self._pending_step = 0
            self.go(1)  # blocks and known depth are the same
        elif remedy.invalid is not None:
            former = request.search.frame.invalid_mask
            mask = remedy.invalid if former is None else former | remedy.invalid
            try:
                self._workspace.current.set_invalid_mask(mask, "Mark depth as invalid")
            except IlfError as error:
                self._pending_step = 0
                self.context.notes.report("Quality check", error)
        return True

    def leave(self) -> None:
        """Ignore the current place and show the next; a propagated block is marked as checked."""
        if not (self._workspace.has_current and self._fresh):
            return
        place = self.review.present
        if place is None:
            self._show(self.review.step(1))
            return
        self._pending_step = 1
        if place.kind == "propagated":
            self._workspace.current.mark_checked(place.labels)
        else:
            self._workspace.current.ignore_place(place)

    def close(self) -> None:
        """Close the review."""
        self._questions.forget()
        self._requested, self._found, self._fresh, self._pending_step = None, (), False, 0
        self._marks.clear()
        self._drop_remedy()
        self._note_place(False)
        self.strip.hide()

    def _note_place(self, there: bool) -> None:
        if there != self._has_place:
            self._has_place = there
            self.context.actions.refresh()

    # the search

    def _ask_again(self) -> None:
        if self._requested is not None:
            self._ask()

    def _note_infos(self) -> None:
        """Search again if other blocks need a check; look for the remedy again if other blocks are locked."""
        if self._requested is None:
            return
        document = self._workspace.current
        if document.state.to_check != self._requested.to_check.keys():
            self._ask()
        elif self._remedy_requested is not None and self._remedy_requested.locked != document.locked:
            self._ask_remedy(self._remedy_requested.place, self._requested)

    def _note_ignored(self) -> None:
        """Show the places without those that are ignored now."""
        if self._requested is not None and self._fresh:
            self._take_places(self._requested)

    def _ask(self) -> None:
        document = self._workspace.current
        to_check = {label: document.blocks.reasons.get(label, "") for label in document.state.to_check}
        extraction = document.blocks.extraction or BlockParameters()
        self._fresh = False
        self._drop_remedy()
        labels = document.labels.copy()
        self._requested = _Request(document, document.frame, labels, extraction, self._error(labels), to_check)
        self._questions.ask(self._requested)

    def _error(self, labels: NDArray[np.int32]) -> NDArray[np.float32] | None:
        """Return the expected error; until depth has been completed again, the former one where blocks are the same."""
        document, former = self._workspace.current, self._requested
        error = document.expected_error()
        if error is None and former is not None and former.error is not None:
            return np.where(labels == former.labels, former.error, np.float32(np.nan))
        return error

    def _take(self, question: _Request, found: Sequence[Place]) -> None:
        if question is self._requested:
            self._found, self._fresh = found, True
            self._take_places(question)

    def _take_places(self, search: _Request) -> None:
        former = self.review.present
        gone = self.review.take(
            without_ignored(self._found, search.document.state.ignored, search.frame, search.labels)
        )
        # the expected error is unknown until the depth has been completed again
        fixed = gone and former is not None and (former.kind != "error" or search.document.expected_error() is not None)
        pending_step, self._pending_step = self._pending_step, 0
        if pending_step:
            self._show(self.review.step(pending_step))
        else:
            self._say(fixed)

    def _fail(self, _question: object, error: Exception) -> None:
        self.close()
        self.context.notes.report("Quality check", error)

    # the remedy

    def _drop_remedy(self) -> None:
        self._remedies.forget()
        self._remedy_requested = None
        self._set_remedy(None)

    def _set_remedy(self, remedy: Remedy | None) -> None:
        if remedy is not self._remedy:
            self._remedy = remedy
            self._previews.show(remedy)
            self.context.actions.refresh()

    def _ask_remedy(self, place: Place, search: _Request) -> None:
        """Look for the remedy of a place."""
        document = search.document
        self._drop_remedy()
        self._remedy_requested = _RemedyRequest(search, place, document.locked, document.next_label())
        self.strip.show_remedy("Looking for a remedy…")
        self._remedies.ask(self._remedy_requested)

    def _take_remedy(self, question: _RemedyRequest, remedy: Remedy | None) -> None:
        if question is self._remedy_requested:
            self._set_remedy(remedy)
            self.strip.show_remedy("No remedy found")
            self._show_remedy()

    def _show_remedy(self) -> None:
        if self._remedy is not None:
            key = "" if "Enter" in self.context.editor.tool.hint else " (Enter)"
            self.strip.show_remedy(f"{self._named(self._remedy.text)}{key}")

    # what is shown

    def _show(self, place: Place | None) -> None:
        if place is not None:
            document = self._workspace.current
            there = [label for label in place.labels if label in document.counts()]
            self._workspace.select(there[:1])
            self._views.zoom_to(*_region_around(place, document.frame.shape))
        self._say(False)
        self.context.centre.show_images()

    def _say(self, fixed: bool) -> None:
        review, search = self.review, self._requested
        count, place = len(review.places), review.present
        self._note_place(place is not None)
        if place is not None and search is not None:
            path = QPainterPath()
            path.addEllipse(QPointF(*place.point), _RING, _RING)
            self._marks.show(path)
            self.strip.show_places(self._named(place.reason), f"{review.number} of {count}")
            self._ask_remedy(place, search)
            return
        self._marks.clear()
        self._drop_remedy()
        ignored = len(self._found) - count
        and_ignored = f" {ignored} ignored." if ignored else ""
        if count:
            done = "Fixed. " if fixed else ""
            self.strip.show_places(f"{done}{counted(count, 'flagged place')} left to check.")
        elif fixed:
            self.strip.show_places(f"Fixed. That was the last flagged place.{and_ignored}")
        else:
            self.strip.show_places(f"No more flagged places.{and_ignored}" if ignored else "No flagged places.")

    def _named(self, text: str) -> str:
        """Return a text with the names of blocks instead of their numbers."""
        infos = self._workspace.current.blocks.infos

        def name(found: re.Match[str]) -> str:
            info = infos.get(int(found[1]))
            return found[0] if info is None else info.name

        return re.sub(r"Block (\d+)", name, text)


def _find(question: _Request) -> Sequence[Place]:
    """Find the flagged places; called in a worker thread."""
    strength = find_edges(question.frame, question.extraction).strength
    propagated = propagated_places(question.labels, question.to_check)
    return [*propagated, *find_places(question.frame, question.labels, strength, question.error)]


def _find_remedy(question: _RemedyRequest) -> Remedy | None:
    """Find the remedy for a place; called in a worker thread."""
    search = question.search
    return find_remedy(
        question.place,
        search.frame,
        search.labels,
        find_edges(search.frame, search.extraction).strength,
        locked=question.locked,
        first_new=question.new,
    )


def _region_around(place: Place, shape: tuple[int, int]) -> Box:
    """Return the region to show: the place with its surroundings, or only its centre if it is too large."""
    spans = []
    for span, middle, size in zip(place.box, place.point[::-1], shape, strict=True):
        side = min(max(2 * (span.stop - span.start), _MIN_SIDE), _MAX_SIDE)
        centre = middle if span.stop - span.start > _MAX_SIDE else (span.start + span.stop) / 2
        start = min(max(round(centre - side / 2), 0), max(size - side, 0))
        spans.append(slice(start, min(start + side, size)))
    return spans[0], spans[1]
