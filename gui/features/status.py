"""Status bar: hint for the mouse, readout of the pixel, and progress of the work."""

from __future__ import annotations

import html
import math

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QProgressBar, QSizePolicy, QStatusBar, QWidget

from ilf._runtime.formatting import grouped, length_text
from ilf.data.frame import RGBDFrame

from ..state.document import Document
from ..state.parts import Part
from ..views.view_data import FLICKERS, MarkedDepth
from ..widgets.basics import ElidedLabel, literal_text
from ..work.frame_runs import RunState
from ..work.jobs import Pace
from .cloud import CloudPanel
from .context import Context, Feature
from .expected_error import ErrorFeature
from .project.feature import ProjectFeature

# The status bar: effect of a click, pixel under the cursor, progress.

_LONGEST = "Filtering 10 of 20, 99 %, 10 min left "
"""What the progress has room for; longer names are cut."""
_MARGIN = 6
_ROOM = 8
"""Height beside that of a line: buttons of messages fit, so that the bar never moves the pictures."""


class _Progress(QProgressBar):
    """A bar that shows its text also while the finished share is not known."""

    def text(self) -> str:
        return self.format()


class StatusBar(QStatusBar):
    """Status bar with a hint on the left, readout and progress on the right. Messages are shown elsewhere."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.hint = ElidedLabel()
        self.hint.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.readout = QLabel()
        self.progress = _Progress(textVisible=True)
        # its text must not limit the width of the window
        self.readout.setMinimumWidth(1)
        self.progress.setFixedWidth(self.fontMetrics().horizontalAdvance(_LONGEST))
        self.progress.setAccessibleName("Progress")
        self.progress.hide()
        self.progress.setMaximumHeight(self.fontMetrics().height())
        self.setFixedHeight(self.fontMetrics().height() + _ROOM)
        self.setSizeGripEnabled(False)
        self.setContentsMargins(_MARGIN, 0, _MARGIN, 0)
        self.addWidget(self.hint, 1)
        self.addPermanentWidget(self.readout)
        self.addPermanentWidget(self.progress)

    def show_progress(self, text: str, share: float | None, left: str) -> None:
        """Show the work in progress, its finished share (0-1, None if unknown), and the remaining time.

        An empty text hides the progress.
        """
        progress = self.progress
        progress.setVisible(bool(text))
        suffix = ""
        if share is None:
            progress.setRange(0, 0)
        else:
            progress.setRange(0, 100)
            progress.setValue(round(100 * share))
            suffix = f", {round(100 * share)} %" + (f", {left}" if left else "")
        metrics = progress.fontMetrics()
        room = progress.width() - 2 * metrics.averageCharWidth() - metrics.horizontalAdvance(suffix)
        progress.setFormat(metrics.elidedText(text, Qt.TextElideMode.ElideRight, room) + suffix)
        progress.setToolTip(literal_text(text + suffix))


_READ = Part.DEPTH | Part.EXPECTED_ERROR | Part.GROUND_TRUTH | Part.COMPARED | Part.INFOS
"""The parts whose values the readout shows."""

_NO_FRAME = "Open a frame with the menu File, or drop its files here"


class StatusFeature(Feature):
    """Hint and progress in the status bar, and the readout of the pixel under the cursor."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._saving = context.feature(ProjectFeature).saving
        self._editor = editor = context.editor
        self._pace = Pace()
        self._playing, self._exporting = "", ""
        self.bar = StatusBar()
        context.window.setStatusBar(self.bar)
        context.views.cursorMoved.connect(lambda _: self.show_readout())
        self._error = context.feature(ErrorFeature)
        add = context.refresh.add
        hinted = editor.tool_changed, editor.hint_changed, context.centre.turned
        add("hint", self.show_hint, Part.FRAME | Part.LOADING | Part.SELECTION | Part.LABELS, also=hinted)
        working = self._saving.changed, self._error.requests.begun, self._error.requests.ended
        later = Part.SOME_RESULTS | Part.RECORDS | Part.PREVIEWS
        add("progress", self.show_progress, Part.FRAME | Part.RUNNING | Part.LOADING, later, working)
        add("readout", self.show_readout, _READ, Part.SOME_RESULTS | Part.PREVIEWS)

    def show_playing(self, text: str) -> None:
        """Show a text about the frame that is played, and its pixel under the cursor; "" once playing has ended."""
        self._playing = text
        self.show_hint()
        self.show_readout()

    def show_exporting(self, text: str) -> None:
        """Show how far an export is; "" once it has ended."""
        self._exporting = text
        self.context.refresh.mark("progress")

    def show_hint(self) -> None:
        """Show what is played, or else how much is selected and the effect of a click."""
        if (document := self.workspace.shown) is not None:
            cloud = self.context.made(CloudPanel)
            hint = (cloud is not None and cloud.hint) or self._editor.hint
            idle = " | ".join(filter(None, (_selected_text(document), hint)))
        else:
            idle = self.context.loader.present or _NO_FRAME
        self.bar.hint.setText(self._playing or idle)
        self.bar.hint.setToolTip(literal_text(idle))  # for windows that are too narrow for the text

    def show_progress(self) -> None:
        """Show the stage and the share done of runs, opening and extraction with the remaining time, or that blocks are
        completed again, files are written or the expected error is estimated."""
        loader, share = self.context.loader, None
        if self.context.runs.running:
            text, share = self._runs_text()
        elif loader.reading or loader.extracting:
            text, share = loader.present, loader.share_done or None
            self._pace.note(share or 0.0)
        elif self.context.runs.state is RunState.RESOLVING:
            text = "Completing"
        elif self._saving.busy:
            text, share = "Saving", self._saving.share
        else:
            text = self._exporting or ("Estimating the error" if self._error.busy else "")
        if not text:
            self._pace.forget()
        self.bar.show_progress(text, share, self._pace.text() if share is not None else "")

    def _runs_text(self) -> tuple[str, float | None]:
        """Return the stage and the finished share of the current frame's run, or else of the other frames' runs; None
        where the share is not known."""
        runs, present = self.context.runs, not self.context.runs.state.free
        going = [self.workspace.current] if present else runs.running
        shares = [runs.of(document).share_done for document in going]
        share = sum(shares) / len(shares)
        self._pace.note(share, going=runs.state is not RunState.PAUSED)
        if present:
            return runs.of(going[0]).stage, share if 0 < share < 1 else None
        return (going[0].name if len(going) == 1 else f"{len(going)} other frames running"), share

    # readout under the cursor: position, block, depth in and out, expected error, compared runs, ground truth and error

    def show_readout(self) -> None:
        """Show the values of the pixel under the cursor."""
        pixel = self.views.navigation.pixel
        self.bar.readout.setText("" if pixel is None else "  |  ".join(self._parts(*pixel)))

    def _parts(self, x: int, y: int) -> list[str]:
        """Return the values of a pixel in what the views show; none if it is outside of it."""
        data = self.views.data
        frame, document, error = data.frame, data.document, data.expected
        if frame is None or x >= frame.shape[1] or y >= frame.shape[0]:  # another frame may be shown meanwhile
            return []
        parts = [f"x {x}, y {y}"]
        if document is not None:
            label = int(document.labels[y, x])
            block = document.info(label).name if label else "no block"
            parts.append(html.escape(block) + " (locked)" * (label in document.locked))
        parts.append(self._given(frame, x, y))
        if frame.brought is not None and not frame.brought.seen[y, x]:
            parts.append("not seen by colour")
        if data.result is not None:
            parts += self._completed(data.result, float(frame.depth[y, x]), x, y)
        for name, depths in (("in", FLICKERS["flicker-in"]), ("out", FLICKERS["flicker"])):
            now, before = (data.depth(depth) for depth in depths)
            if now is not None and before is not None and np.isfinite(change := now.depth[y, x] - before.depth[y, x]):
                parts.append(f"flicker {name} {1000 * change:+.1f} mm")
        if error is not None and not data.error_is_outdated and not data.moment and np.isfinite(error[y, x]):
            parts.append(f"\u00b1 {length_text(float(error[y, x]))}")
            parts += ["unsupported"] * (data.unsupported is not None and bool(data.unsupported[y, x]))
        if frame.ground_truth is not None and np.isfinite(truth := float(frame.ground_truth[y, x])):
            parts.append(f"ground truth {_metres(truth)}")
            if data.result is not None and np.isfinite(depth := float(data.result.depth[y, x])):
                parts.append(f"error {1000 * (depth - truth):+.1f} mm")
        return [*parts, *(f"{html.escape(run.name)} {_metres(float(run.completion.depth[y, x]))}" for run in data.runs)]

    def _given(self, frame: RGBDFrame, x: int, y: int) -> str:
        """Return the depth in, and where it is from or why there is none."""
        data, depth = self.views.data, float(frame.depth[y, x])
        if frame.from_neighbours is not None and frame.from_neighbours[y, x]:
            return f"from neighbours {_metres(depth)}"
        if frame.outside_view is not None and frame.outside_view[y, x]:
            return "outside the depth camera's view"
        if data.by_hand is not None and data.by_hand[y, x] and data.document is not None:
            by_hand = data.document.blocks.by_hand
            return f"by hand {_metres(math.nan if by_hand is None else float(by_hand.depth[y, x]))}"
        if data.invalid_mask is not None and data.invalid_mask[y, x]:
            return f"invalid {_metres(float(frame.measured[y, x]))}"
        return f"in {_metres(depth)}"

    def _completed(self, result: MarkedDepth, depth_in: float, x: int, y: int) -> list[str]:
        """Return the depth out, what it is, and its difference from depth in."""
        document, depth = self.views.data.document, float(result.depth[y, x])
        proposal = None if document is None else document.proposal
        viewed = self.workspace.viewed_iteration
        if proposal is not None and np.isfinite(proposal[y, x]):
            return [f"proposed {_metres(float(proposal[y, x]))}"]
        if viewed is not None:
            text = f"after iteration {viewed.iteration} {_metres(depth)}"
        else:
            text = f"out {_metres(depth)}"
            text += " (extrapolated)" * (result.extrapolated is not None and bool(result.extrapolated[y, x]))
        return [text, f"{1000 * (depth - depth_in):+.1f} mm"] if np.isfinite(depth - depth_in) else [text]


def _selected_text(document: Document) -> str:
    """Return how many blocks are selected, and their pixels; "" for less than two."""
    counts = document.counts()
    chosen = [counts[label].pixels for label in document.selected if label in counts]
    return f"{len(chosen)} selected, {grouped(sum(chosen))} px" if len(chosen) > 1 else ""


def _metres(depth: float) -> str:
    return f"{depth:.3f} m" if np.isfinite(depth) else "missing"
