"""The panel *Quality*: places where blocks or depth look wrong, one after the other, each with a remedy; and known
depth that is suggested to be marked as invalid."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QAction, QColor, QPainterPath
from PySide6.QtWidgets import QHBoxLayout, QSizePolicy, QToolButton, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted
from ilf.data.blocks import Box
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.errors import IlfError
from ilf.evaluation.quality.checks import find_places, propagated_places
from ilf.evaluation.quality.invalid_depth import suggest_invalid
from ilf.evaluation.quality.places import Place, without_ignored
from ilf.evaluation.quality.remedies import Remedy, find_remedy
from ilf.segmentation.edges.frame_edges import find_edges

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..views.drawings import HaloPath, PreviewDrawing
from ..views.interaction import Preview
from ..views.mask_paths import boundary_path
from ..widgets.basics import TEXT_BESIDE_ICON, PlainLabel, command_button, lay_out
from ..widgets.docks import PanelGroup
from ..work.steps import Steps, in_steps
from .context import Context
from .panel import Panel
from .tools import ToolsFeature

Mask = NDArray[np.bool_]

_KNOWN = Part.FRAME | Part.INVALID_MASK | Part.NEIGHBOURS
"""What known depth depends on, and what is suggested of it."""
_SEARCHED = _KNOWN | Part.LABELS | Part.EXPECTED_ERROR
"""What the search for places depends on."""

_MIN_SIDE, _MAX_SIDE = 96, 320
"""Minimum and maximum side of the shown region [px]."""

_RING = 10.0
"""Radius of the ring around the centre of a place [px]."""

_ROOM = 10
"""Margin [px] around the box of the former place in which a place counts as the same: an edit may move it."""

_COLOUR, _WIDTH, _HALO, _HEIGHT = QColor(255, 96, 208), 1.5, 170, 5.5
"""Of marks in the views: a colour used for nothing else."""


class Review:
    """Flagged places of one frame, the worst first, and the current one."""

    def __init__(self) -> None:
        self.places: Sequence[Place] = ()
        self.present: Place | None = None
        """The current place; None before the first one, and after it has been fixed."""
        self._next = 0

    @property
    def number(self) -> int:
        """Number of the current place, from 1; 0 for none."""
        return 0 if self.present is None else self.places.index(self.present) + 1

    def take(self, found: Sequence[Place]) -> bool:
        """Set the places found after a change; return True if the current place is gone."""
        former, self.places = self.present, found
        if former is None:
            return False
        self._next = sum(place.score > former.score for place in self.places)
        self.present = next((place for place in self.places if _is_part(place, former)), None)
        return self.present is None

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


def _is_part(place: Place, whole: Place) -> bool:
    rows, columns = whole.box
    inside = (
        columns.start - _ROOM <= place.point[0] < columns.stop + _ROOM
        and rows.start - _ROOM <= place.point[1] < rows.stop + _ROOM
    )
    return inside and place.kind == whole.kind and bool(set(place.labels) & set(whole.labels))


@dataclass(frozen=True, eq=False)
class _Search:
    """A search for the flagged places of a frame in its present state."""

    document: Document
    frame: RGBDFrame
    labels: NDArray[np.int32]
    extraction: BlockParameters
    error: NDArray[np.float32] | None
    locked: frozenset[int]
    to_check: Mapping[int, str]
    """Propagated blocks that need a check -> reason."""

    def places(self) -> Sequence[Place]:
        """Return the places; called in a worker thread, as `remedy_of`."""
        propagated = propagated_places(self.labels, dict(self.to_check))
        strength = find_edges(self.frame, self.extraction).strength
        return [*propagated, *find_places(self.frame, self.labels, strength, self.error)]

    def remedy_of(self, place: Place, new: int) -> Remedy | None:
        """Return the remedy for a place, given the label of a new block."""
        strength = find_edges(self.frame, self.extraction).strength
        return find_remedy(place, self.frame, self.labels, strength, locked=self.locked, first_new=new)


class QualityPanel(Panel):
    """Goes through flagged places: zooms to each, selects its block, marks it in all views and shows the reason and a
    remedy, which Enter applies; so it does with suggested invalid depth.

    While the panel is visible, the search runs again after every edit.
    """

    title, icon, group = "Quality", "ph.crosshair", PanelGroup.INSPECTION
    parts = _SEARCHED | Part.INFOS | Part.IGNORED
    what = "quality check"

    def __init__(self, context: Context) -> None:
        self._reviews: WeakKeyDictionary[Document, Review] = WeakKeyDictionary()
        self._search: _Search | None = None
        """The last search."""
        self._found: Sequence[Place] | None = None
        """All places of the last search, with ignored ones; None until they are known."""
        self._pending_step: int | None = None
        self._place: Place | None = None
        """The place whose remedy is looked for, or shown."""
        self._suggests = False
        """Whether invalid depth is looked for, or suggested: it stays until it is answered, or known depth changes."""
        self.remedy: Remedy | None = None
        """The remedy shown for the current place; None if there is none, or none yet."""
        super().__init__(context)

    def make(self) -> QWidget:
        """Make the marks in the views, and the lines of the panel."""
        actions = self.context.actions
        self._marks = [HaloPath(_WIDTH, _COLOUR, _HALO, _HEIGHT) for _ in self.views.cells]
        self._previews = [PreviewDrawing(_HEIGHT) for _ in self.views.cells]
        for items in (self._marks, self._previews):
            for cell, item in zip(self.views.cells.values(), items, strict=True):
                cell.view.add(item)
        self.position, self.reason = PlainLabel(), PlainLabel(wordWrap=True)
        self.remedy_button = _button(actions["apply_remedy"])
        self.remedy_button.setAccessibleName("Remedy")
        self.remedy_button.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.remedy_button.hide()
        arrows = [_button(actions[name]) for name in ("previous_check", "next_check")]
        for arrow, way in zip(arrows, (Qt.ArrowType.LeftArrow, Qt.ArrowType.RightArrow), strict=True):
            arrow.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            arrow.setArrowType(way)
        widget = QWidget()
        lay_out(
            QVBoxLayout(widget),
            lay_out(QHBoxLayout(), arrows[0], self.position, arrows[1], None, _button(actions["ignore_check"])),
            self.reason,
            self.remedy_button,
            None,
            lay_out(QHBoxLayout(), _button(actions["suggest_invalid"]), None),
            margins=(8, 6, 8, 6),
        )
        for changed in (self.context.editor.hint_changed, self.context.editor.tool_changed):
            changed.connect(lambda *_: self._show_remedy())
        self.context.feature(ToolsFeature).keys.on_enter = lambda: self.visible and self.apply()
        return widget

    @command("next_check", "Next &quality check", icon="ph.crosshair", keys="F8", needs=Need.FRAME)
    def _next(self) -> None:
        """Go to the next place where blocks or filled depth look wrong, largest error first."""
        self.go(1)

    @command("previous_check", "Pre&vious quality check", icon="ph.caret-left", keys="Shift+F8", needs=Need.FRAME)
    def _previous(self) -> None:
        """Go to the previous place."""
        self.go(-1)

    @property
    def review(self) -> Review:
        """The places of the current frame."""
        return self._reviews.setdefault(self.workspace.current, Review())

    def refresh(self, parts: Part) -> None:
        """Search again after a change, also if other blocks are locked."""
        if parts & Part.FRAME:
            self._search = None
        if parts & _KNOWN:
            self._drop_remedy()
        if self.workspace.shown is None:
            self._found = None
            self._show_no_place("Open a frame first.")
            return
        document, search = self.workspace.current, self._search
        blocks = document.locked, document.state.to_check
        if search is None or parts & _SEARCHED or blocks != (search.locked, search.to_check.keys()):
            self._ask_places()
        elif self._found is not None and parts & Part.IGNORED:
            self._take_places(search, self._found)

    def fail(self, error: Exception) -> None:
        """Report an error."""
        self._show_no_place("The quality check failed.")
        super().fail(error)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """While the panel is hidden, mark nothing: the search is made anew when it is shown again."""
        if watched is self.widget and event.type() == QEvent.Type.Hide:
            self.requests.forget()
            self._search = self._found = self._pending_step = None
            self._show_no_place("")
        return super().eventFilter(watched, event)

    # flagged places

    def go(self, by: int) -> None:
        """Show the next place, or the previous one with -1; the current one if the panel was closed meanwhile."""
        if not self.visible and self.review.present is not None:
            by = 0
        self.reveal()
        self.views.active.view.setFocus()
        self.context.refresh.now()
        if self._found is not None:
            self._show(self.review.step(by))
        else:
            self._pending_step = by

    def _why_no_remedy(self) -> str:
        return "" if self.remedy is not None else "No remedy is shown: press F8 first."

    @command("apply_remedy", "&Apply remedy", icon="ph.check", needs=Need.FRAME, why_off=_why_no_remedy)
    def apply(self) -> bool:
        """Apply the remedy that is shown for the place, and go to the next place; Enter does the same.

        Returns False if none is shown.
        """
        place, remedy, document = self._place, self.remedy, self.workspace.current
        if remedy is None:
            return False
        if place is not None and remedy.kind == "checked":
            document.mark_checked(place.labels)
        elif remedy.patch is not None:
            self.context.editor.commit(remedy.patch, self._named(remedy.text))
        elif remedy.by_hand is not None:
            document.set_by_hand(remedy.by_hand, np.isfinite(remedy.by_hand), "Continue plane")
        elif remedy.invalid is not None and not self._mark_invalid(remedy.invalid, "Mark depth as invalid"):
            return True
        if place is not None:
            self.go(1)
        return True

    def _why_no_place(self) -> str:
        return "" if self._place is not None or self._suggests else "No place is shown: press F8 first."

    @command("ignore_check", "&Ignore", icon="ph.eye-slash", keys="Ctrl+F8", needs=Need.FRAME, why_off=_why_no_place)
    def leave(self) -> None:
        """Ignore this place: it is not shown again until blocks or known depth change there.

        A propagated block is marked as checked; suggested invalid depth stays valid.
        """
        place = self._place
        if place is None:
            self._say(False)
            return
        if place.kind == "propagated":
            self.workspace.current.mark_checked(place.labels)
        else:
            self.workspace.current.ignore_place(place)
        self.go(1)

    @in_steps
    def _ask_places(self) -> Steps[None]:
        """Look for places in the present state."""
        document = self.workspace.current
        to_check = {label: document.blocks.reasons.get(label, "") for label in document.state.to_check}
        extraction = document.blocks.extraction or BlockParameters()
        labels = document.labels.copy()
        search = _Search(document, document.frame, labels, extraction, self._error(labels), document.locked, to_check)
        self._found, self._search = None, search
        if not self._suggests:
            self._drop_remedy()
            self.reason.setText("Running quality checks…")
        places: Sequence[Place] = yield partial(self.requests.ask, search.places, kind="places")
        if search is self._search:
            self._found = places
            self._take_places(search, places)

    def _error(self, labels: NDArray[np.int32]) -> NDArray[np.float32] | None:
        """Return the expected error; until depth has been completed again, the former one where blocks are the same."""
        error, former = self.workspace.current.expected_error(), self._search
        if error is None and former is not None and former.error is not None:
            return np.where(labels == former.labels, former.error, np.float32(np.nan))
        return error

    def _take_places(self, search: _Search, found: Sequence[Place]) -> None:
        former, document = self.review.present, search.document
        gone = self.review.take(without_ignored(found, document.state.ignored, search.frame, search.labels))
        # the expected error is unknown until the depth has been completed again
        fixed = gone and former is not None and (former.kind != "error" or document.expected_error() is not None)
        pending_step, self._pending_step = self._pending_step, None
        if pending_step is not None:
            self._show(self.review.step(pending_step))
        elif not self._suggests:
            self._say(fixed)

    def _show(self, place: Place | None) -> None:
        if place is not None:
            document = self.workspace.current
            there = [label for label in place.labels if label in document.counts()]
            self.workspace.select(there[:1])
            self.views.transform.show(*_region_around(place, document.frame.shape))
        self._say(False)
        self.context.centre.show_images()

    def _say(self, fixed: bool) -> None:
        """Show the current place, or how many are left."""
        review, search = self.review, self._search
        count, place = len(review.places), review.present
        if place is not None and search is not None:
            path = QPainterPath()
            path.addEllipse(QPointF(*place.point), _RING, _RING)
            self._mark(self._marks, path)
            self.position.setText(f"{review.number} of {count}")
            self.reason.setText(self._named(place.reason))
            self._ask_remedy(place, search)
            return
        ignored, done = len(self._found or ()) - count, "Fixed. " if fixed else ""
        if count:
            text = f"{done}{counted(count, 'flagged place')} left to check."
        else:
            text = f"{done}No more flagged places." if fixed or ignored else "No flagged places."
        self._show_no_place(f"{text} {ignored} ignored." if ignored else text)

    def _show_no_place(self, text: str) -> None:
        self._mark(self._marks, None)
        self._drop_remedy()
        self.position.setText("")
        self.reason.setText(text)

    @staticmethod
    def _mark(items: Sequence[HaloPath], path: QPainterPath | None) -> None:
        for item in items:
            item.set_path(path)

    # the remedy

    @in_steps
    def _ask_remedy(self, place: Place, search: _Search) -> Steps[None]:
        """Look for the remedy of a place."""
        self._drop_remedy()
        self._place = place
        self._show_remedy("Looking for a remedy…")
        find = partial(search.remedy_of, place, search.document.next_label())
        remedy: Remedy | None = yield partial(self.requests.ask, find, kind="remedy")
        if place is self._place:
            self._set_remedy(remedy)
            self._show_remedy("No remedy found")

    def _drop_remedy(self) -> None:
        self._place, self._suggests = None, False
        self._set_remedy(None)

    def _set_remedy(self, remedy: Remedy | None) -> None:
        self.remedy = remedy
        preview = _preview(remedy)
        for item in self._previews:
            item.set_preview(preview)
        self.remedy_button.hide()
        self.context.actions.refresh()

    def _show_remedy(self, otherwise: str = "") -> None:
        """Write on the button what the remedy does, or another text while there is none."""
        text = otherwise
        if self.remedy is not None:
            key = "" if "Enter" in self.context.editor.hint else " (Enter)"
            text = f"{self._named(self.remedy.text)}{key}"
        if text:
            self.remedy_button.defaultAction().setIconText(text)
            self.remedy_button.show()

    def _named(self, text: str) -> str:
        """Return a text with the names of blocks instead of their numbers."""
        infos = self.workspace.current.blocks.infos

        def name(found: re.Match[str]) -> str:
            info = infos.get(int(found[1]))
            return found[0] if info is None else info.name

        return re.sub(r"Block (\d+)", name, text)

    # invalid depth

    @command("suggest_invalid", "Su&ggest invalid depth", icon="ph.warning", needs=Need.FRAME)
    @in_steps
    def suggest(self) -> Steps[None]:
        """Find known depth that is probably wrong (flying pixels, speckles, glass), to mark it or to ignore it."""
        self.reveal()
        self.context.refresh.now()
        document = self.workspace.current
        frame, extraction = document.frame, document.blocks.extraction or BlockParameters()
        self._pending_step = None
        self._show_no_place("Looking for depth that may be invalid…")
        self._suggests = True
        found: Mask = yield partial(
            self.requests.ask, lambda: suggest_invalid(frame, find_edges(frame, extraction).strength), kind="invalid"
        )
        if not self._suggests or document is not self.workspace.shown:
            return
        if not found.any():
            self._show_no_place("No invalid depth found: no flying pixels, speckles or glass.")
            return
        self.views.transform.fit()
        what = counted(int(np.count_nonzero(found)), "pixel")
        self._show_no_place(f"{what} of known depth may be invalid: flying pixels, speckles or glass.")
        self._suggests = True
        self._set_remedy(Remedy("invalid", f"Mark {what} as invalid", invalid=found))
        self._show_remedy()

    def _mark_invalid(self, found: Mask, text: str) -> bool:
        """Mark known depth as invalid; return False, with a message, if no depth would be left."""
        former = self.workspace.current.frame.invalid_mask
        try:
            self.workspace.current.set_invalid_mask(found if former is None else former | found, text)
        except IlfError as error:
            self.notes.report(text, error)
            return False
        return True


def _preview(remedy: Remedy | None) -> Preview | None:
    """Return the dashed outline of what a remedy changes."""
    if remedy is None:
        return None
    if remedy.patch is not None:
        rows, columns = remedy.patch.box
        return Preview(boundary_path(remedy.patch.before != remedy.patch.after, columns.start, rows.start), dashed=True)
    changed = remedy.invalid if remedy.by_hand is None else np.isfinite(remedy.by_hand)
    return None if changed is None else Preview(boundary_path(changed), dashed=True)


def _region_around(place: Place, shape: tuple[int, int]) -> Box:
    """Return the region to show: the place with its surroundings, or only its centre if it is too large."""
    spans = []
    for span, middle, size in zip(place.box, place.point[::-1], shape, strict=True):
        side = min(max(2 * (span.stop - span.start), _MIN_SIDE), _MAX_SIDE)
        centre = middle if span.stop - span.start > _MAX_SIDE else (span.start + span.stop) / 2
        start = min(max(round(centre - side / 2), 0), max(size - side, 0))
        spans.append(slice(start, min(start + side, size)))
    return spans[0], spans[1]


def _button(action: QAction) -> QToolButton:
    button = command_button(action, TEXT_BESIDE_ICON)
    button.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # keeps the keyboard focus in the views
    return button
