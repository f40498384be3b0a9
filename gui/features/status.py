"""Status bar: hint for the mouse, readout of the pixel, and progress of the work."""

from __future__ import annotations

import html

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QLabel, QProgressBar, QSizePolicy, QStatusBar, QWidget

from ilf._runtime.formatting import length_text

from ..state.document import Document
from ..state.parts import Part
from ..tools.select import selected_text
from ..views.cloud.canvas import HINT, MOVES
from ..views.view_data import FLICKERS
from ..widgets.basics import ElidedLabel, literal_text
from ..work.frame_runs import RunState
from ..work.jobs import Pace
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
        self.progress = _Progress()
        # its text must not limit the width of the window
        self.readout.setMinimumWidth(1)
        self.progress.setFixedWidth(self.fontMetrics().horizontalAdvance(_LONGEST))
        self.progress.setAccessibleName("Progress")
        self.progress.setTextVisible(True)
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

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = context.workspace
        self._runs = context.runs
        self._loader = context.loader
        self._saving = context.feature(ProjectFeature).saving
        self._editor = editor = context.editor
        self._pace = Pace()
        self._playing, self._exporting = "", ""
        self._paced: list[Document] = []
        """Frames whose runs the pace was measured on."""
        self.bar = StatusBar()
        context.window.setStatusBar(self.bar)
        self._data = context.views.data
        self._pixel: tuple[int, int] | None = None
        """The pixel (x, y) under the cursor; None if it is off the frame."""
        context.views.cursorMoved.connect(self.point_at)
        self._error = context.feature(ErrorFeature)
        add = context.refresh.add
        hinted = editor.tool_changed, editor.hint_changed, context.cloud.canvas.hover_changed, context.centre.turned
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
        idle = self._loader.present or _NO_FRAME
        if self._workspace.has_current:
            hint = self._hint_of_cloud() or self._editor.tool.hint
            idle = " | ".join(filter(None, (selected_text(self._workspace.current), hint)))
        self.bar.hint.setText(self._playing or idle)
        self.bar.hint.setToolTip(literal_text(idle))  # for windows that are too narrow for the text

    def _hint_of_cloud(self) -> str:
        """Return the mouse hint of the point cloud if the mouse is over it; "" otherwise."""
        if not (self.context.centre.shows_cloud_alone or self.context.cloud.canvas.underMouse()):
            return ""
        tool = self._editor.tool
        return f"{tool.hint} | {MOVES}" if tool.points_only else HINT

    def show_progress(self) -> None:
        """Show the stage and the share done of runs, opening and extraction with the remaining time, or that blocks are
        completed again, files are written or the expected error is estimated."""
        loader, share = self._loader, None
        if self._runs.running:
            text, share = self._runs_text()
        elif loader.busy:
            text, share = loader.present, loader.share_done or None
            self._pace.note(share or 0.0)
        elif self._runs.state is RunState.RESOLVING:
            text = "Completing"
        elif self._saving.busy:
            text, share = "Saving", self._saving.share
        else:
            text = self._exporting or ("Estimating the error" if self._error.busy else "")
        if not text:
            self._pace.forget()
            self._paced = []
        self.bar.show_progress(text, share, self._pace.text() if share is not None else "")

    def _runs_text(self) -> tuple[str, float | None]:
        """Return the stage and the finished share of the current frame's run, or else of the other frames' runs; None
        where the share is not known."""
        runs, present = self._runs, not self._runs.state.free
        going = [self._workspace.current] if present else runs.running
        shares = [runs.of(document).share_done for document in going]
        share = sum(shares) / len(shares)
        if going != self._paced:
            self._paced = going
            self._pace.forget()
        self._pace.note(share, going=runs.state is not RunState.PAUSED)
        if present:
            return runs.of(going[0]).stage, share if 0 < share < 1 else None
        return (going[0].name if len(going) == 1 else f"{len(going)} other frames running"), share

    # readout under the cursor: position, block, depth in and out, expected error, compared runs, ground truth and error

    def point_at(self, pixel: tuple[int, int] | None) -> None:
        self._pixel = pixel
        self.show_readout()

    def show_readout(self) -> None:
        """Show the values of the pixel under the cursor."""
        self.bar.readout.setText("" if self._pixel is None else "  |  ".join(self._parts(*self._pixel)))

    def _parts(self, x: int, y: int) -> list[str]:
        if not self._workspace.has_current:
            return self._played(x, y)
        document = self._workspace.current
        height, width = document.frame.shape
        if x >= width or y >= height:  # the cursor has not moved since another frame was shown
            return []
        label = int(document.labels[y, x])
        block = document.info(label).name if label else "no block"
        depth_in, measured = float(document.frame.depth[y, x]), float(document.frame.measured[y, x])
        invalid_mask = np.isfinite(measured) and not np.isfinite(depth_in)
        given = f"invalid {_metres(measured)}" if invalid_mask else f"in {_metres(depth_in)}"
        outside = document.frame.outside_view
        if outside is not None and outside[y, x]:
            given = "outside the depth camera's view"
        added = document.frame.from_neighbours
        if added is not None and added[y, x]:
            given = f"from neighbours {_metres(depth_in)}"
        if document.blocks.by_hand is not None and np.isfinite(document.blocks.by_hand.depth[y, x]):
            own = np.isfinite(depth_in) and (added is None or not added[y, x])
            if not own and (outside is None or not outside[y, x]):
                given = f"by hand {_metres(float(document.blocks.by_hand.depth[y, x]))}"
        locked = " (locked)" if label in document.locked else ""
        parts = [f"x {x}, y {y}", f"{html.escape(block)}{locked}", given]
        brought = document.frame.brought
        parts += ["not seen by colour"] if brought is not None and not brought.seen[y, x] else []
        viewed_iteration, error = self._workspace.viewed_iteration, document.expected_error()
        depth = document.current_depth() if viewed_iteration is None else viewed_iteration.depth
        if depth is not None:
            depth_out = float(depth[y, x])
            completion = document.completion()
            extrapolated = completion is not None and completion.extrapolated[y, x]
            if viewed_iteration is not None:
                parts.append(f"after iteration {viewed_iteration.iteration} {_metres(depth_out)}")
            else:
                parts.append(f"out {_metres(depth_out)}{' (extrapolated)' if extrapolated else ''}")
            if np.isfinite(depth_in) and np.isfinite(depth_out):
                parts.append(f"{1000 * (depth_out - depth_in):+.1f} mm")
        parts += self._flicker(x, y)
        if document.proposal is not None and np.isfinite(document.proposal[y, x]):
            parts.append(f"proposed {_metres(float(document.proposal[y, x]))}")
        if viewed_iteration is None and error is not None and np.isfinite(error[y, x]):
            parts.append(f"\u00b1 {length_text(float(error[y, x]))}")
            unsupported = document.unsupported()
            if unsupported is not None and unsupported[y, x]:
                parts.append("unsupported")
        runs = [f"{html.escape(kept.name)} {_metres(float(kept.completion.depth[y, x]))}" for kept in document.compared]
        return [*parts, *_evaluated(document, depth, x, y), *runs]

    def _played(self, x: int, y: int) -> list[str]:
        """Return the values of a frame that is played; none if the pixel is outside."""
        depths = [(name, self._data.depth(depth)) for name, depth in (("in", "depth-in"), ("out", "result"))]
        height, width = (0, 0) if depths[0][1] is None else depths[0][1].depth.shape
        if x >= width or y >= height:
            return []
        values = [f"{name} {_metres(float(layer.depth[y, x]))}" for name, layer in depths if layer is not None]
        return [f"x {x}, y {y}", *values, *self._flicker(x, y)]

    def _flicker(self, x: int, y: int) -> list[str]:
        """Return the change of depth in and depth out against the frame before, as far as it is known."""
        parts = []
        for name, depths in (("in", FLICKERS["flicker-in"]), ("out", FLICKERS["flicker"])):
            now, before = (self._data.depth(depth) for depth in depths)
            if now is not None and before is not None and np.isfinite(change := now.depth[y, x] - before.depth[y, x]):
                parts.append(f"flicker {name} {1000 * change:+.1f} mm")
        return parts


def _evaluated(document: Document, depth: NDArray[np.float32] | None, x: int, y: int) -> list[str]:
    """Return ground truth and the error of completed depth as texts."""
    ground_truth = document.frame.ground_truth
    if ground_truth is None or not np.isfinite(ground_truth[y, x]):
        return []
    parts = [f"ground truth {_metres(float(ground_truth[y, x]))}"]
    if depth is not None and np.isfinite(depth[y, x]):
        parts.append(f"error {1000 * float(depth[y, x] - ground_truth[y, x]):+.1f} mm")
    return parts


def _metres(depth: float) -> str:
    return f"{depth:.3f} m" if np.isfinite(depth) else "missing"
