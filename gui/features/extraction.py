"""Shows the stages of the extraction in their view, and extracts blocks on request."""

from __future__ import annotations

import html
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import stage_picture

from ..base import theme
from ..state.session import Session
from ..state.workspace import Workspace
from ..views.layouts import LAYOUT_TEXTS
from ..views.linked_views import LinkedViews
from ..widgets.notices import Notes, error_text
from ..widgets.parameter_form import ParameterForm
from ..work.found_blocks import FoundBlocks, describe_blocks, find
from ..work.latest_request import LatestRequest

# The panel of EBS: its parameters, their preview, and the button that extracts blocks again.


class ExtractionPanel(QWidget):
    """Form with the parameters of the extraction, and the commands that use them.

    Signals
    -------
    edited(object)
        The user has changed the BlockParameters.
    preview_switched(bool)
        The user has switched the preview on or off.
    keeping_switched(bool)
        The user has switched keeping of blocks made by hand on or off.
    view_requested()
        The user has clicked the link of `offer_view` to see the result of the parameters.
    """

    edited = Signal(object)
    preview_switched = Signal(bool)
    keeping_switched = Signal(bool)
    view_requested = Signal()

    def __init__(self, extract: QAction, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        button = QToolButton()
        button.setDefaultAction(extract)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._preview = QCheckBox("Preview")
        self._preview.setChecked(True)
        self._preview.setToolTip(
            "Update the view of the extraction as the parameters below change; the frame's blocks stay as they are"
        )
        self._preview.clicked.connect(self.preview_switched)
        self._keep = QCheckBox("Keep blocks made by hand")
        self._keep.setChecked(True)
        self._keep.setToolTip(
            "Keep the blocks that you drew, enlarged, merged or erased from when blocks are extracted again; locked "
            "blocks are always kept"
        )
        self._keep.clicked.connect(self.keeping_switched)
        self._summary = QLabel()
        self._summary.setObjectName("summary")
        self._summary.setWordWrap(True)
        self._summary.linkActivated.connect(lambda _: self.view_requested.emit())
        self._summary.hide()
        self._text = self._warning = self._layout = ""
        self.form = ParameterForm(BlockParameters)
        self.form.set_base(BlockParameters())
        self.form.changed.connect(self.edited)
        row = QHBoxLayout()
        row.setSpacing(10)
        row.addWidget(button)
        row.addWidget(self._preview)
        row.addStretch()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(8, 8, 4, 4)
        layout.addLayout(row)
        layout.addWidget(self._keep)
        layout.addWidget(self._summary)
        layout.addWidget(self.form, 1)

    @property
    def previews(self) -> bool:
        """Whether the view of the extraction follows the parameters."""
        return self._preview.isChecked()

    def show_summary(self, text: str, warning: str = "") -> None:
        """Show a summary of the result of the parameters, and a warning."""
        self._text, self._warning, self._layout = text, warning, ""
        self._write()

    def offer_view(self, layout: str) -> None:
        """Show a link to the layout that shows the result of the parameters."""
        self._text, self._warning, self._layout = "", "", layout
        self._write()

    def _write(self) -> None:
        colours = theme.colours(self.palette())
        pairs = ((self._text, colours.muted), (self._warning, colours.warning))
        # not by palette, which a new application style sheet would reset
        lines = [f'<span style="color: {tone.name()}">{html.escape(text)}</span>' for text, tone in pairs if text]
        if self._layout:
            link = f'<a href="view" style="color: {colours.accent.name()}">{html.escape(self._layout)}</a>'
            text = f"Choose the layout {link} to see the result of these parameters."
            lines.append(f'<span style="color: {colours.muted.name()}">{text}</span>')
        self._summary.setText("<br>".join(lines))
        self._summary.setVisible(bool(lines))

    def changeEvent(self, event: QEvent) -> None:
        """Apply the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "form"):
            self._write()


# The stages of the extraction while its parameters change, computed and drawn in a worker thread.


@dataclass(frozen=True)
class StageRequest:
    """Request for the picture of one stage."""

    frame: RGBDFrame
    parameters: BlockParameters
    stage: str


@dataclass(frozen=True, eq=False)
class StageResult:
    """Picture returned by `stage_picture`, with the extraction that it shows."""

    question: StageRequest
    found: FoundBlocks
    picture: NDArray[np.uint8]


class ExtractionPreview(QObject):
    """Computes the latest requested picture of a stage.

    The last extraction is cached, so that its other stages only have to be drawn.

    Signals
    -------
    found(object)
        An Answer; during a drag also answers to outdated requests, but never of another frame than the current one.
    failed(object)
        The exception raised by a request.
    """

    found = Signal(object)
    failed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._held: FoundBlocks | None = None
        self._questions = LatestRequest[StageRequest, StageResult](self._find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: self.failed.emit(error))

    @property
    def busy(self) -> bool:
        """Whether an answer is pending."""
        return self._questions.busy

    def ask(self, question: StageRequest) -> None:
        """Request a picture; `found` follows."""
        self._questions.ask(question)

    def hold(self, found: FoundBlocks) -> None:
        """Cache an extraction that was made elsewhere."""
        self._held = found

    def held(self, frame: RGBDFrame, parameters: BlockParameters) -> FoundBlocks | None:
        """Return the cached extraction if it is of this frame with these parameters, else None."""
        held = self._held  # another thread may replace it meanwhile
        return held if held is not None and held.matches(frame, parameters) else None

    def cached_parameters(self, frame: RGBDFrame) -> BlockParameters | None:
        """Return the parameters of the cached extraction if it is of this frame, else None."""
        return self._held.parameters if self._held is not None and self._held.frame is frame else None

    def set_frame(self, frame: RGBDFrame | None) -> None:
        """Drop a cached extraction of another frame, and all pending requests."""
        if self._held is not None and self._held.frame is not frame:
            self._held = None
        self._questions.forget()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _find(self, question: StageRequest) -> StageResult:
        """Compute an answer; called in a worker thread."""
        found = self.held(question.frame, question.parameters) or find(question.frame, question.parameters)
        return StageResult(question, found, stage_picture(question.stage, question.frame.rgb, found.extraction))

    def _take(self, _: StageRequest, answer: StageResult) -> None:
        self.hold(answer.found)
        self.found.emit(answer)


LAYOUT = "grid-extraction"
"""Layout to switch to when a stage is requested and its view is not visible."""

_SLOW_MS = 300
"""Delay until a running extraction is shown [ms]: an edge network's first pass over a frame takes longer."""

_OFF = "Switch the preview of the extraction on, or extract blocks"


class StagePresenter(QObject):
    """Presenter of the view of the extraction and of the summary in the panel.

    While the view is visible and the preview is on, it follows the panel's parameters; with the preview off it shows
    the last extraction of the frame. Only `extract` changes the frame's blocks. While they are being extracted, the
    presenter waits for that result instead of computing it a second time.

    Parameters
    ----------
    is_extracting : callable
        Returns whether a session's blocks are being extracted or about to be; `hold` or `go_on` follows.

    Signals
    -------
    changed()
        The output of `show` has changed: another stage, or the preview was switched.
    described()
        The output of `describe` has changed.
    extraction_requested(object, object)
        Request to extract the blocks of a session; the Found of these parameters if it exists already, or None.
    view_requested()
        Request to bring the linked views to the front.
    """

    changed = Signal()
    described = Signal()
    extraction_requested = Signal(object, object)
    view_requested = Signal()

    def __init__(
        self,
        workspace: Workspace,
        views: LinkedViews,
        panel: ExtractionPanel,
        notes: Notes,
        is_extracting: Callable[[Session], bool],
    ) -> None:
        super().__init__(panel)
        self._workspace = workspace
        self._is_extracting = is_extracting
        self._is_waiting = False
        """Whether a request waits until the blocks have been extracted."""
        self._views = views
        self._panel = panel
        self._notes = notes
        self._board = views.extraction
        self._preview = ExtractionPreview(self)
        self._preview.found.connect(self._take)
        self._preview.failed.connect(self._fail)
        self._frame: RGBDFrame | None = None
        self._found: FoundBlocks | None = None
        self._failure = ""
        self._slow = QTimer(self, singleShot=True, interval=_SLOW_MS)
        self._slow.timeout.connect(lambda: self._board.show_text("Extracting…"))
        self._board.stageChanged.connect(self.changed)
        views.layoutChanged.connect(self.changed)
        panel.edited.connect(workspace.parameters.set_extraction)
        panel.keeping_switched.connect(workspace.parameters.set_keeps_handmade)
        panel.preview_switched.connect(self._switch)
        panel.view_requested.connect(self.show_view)

    @property
    def busy(self) -> bool:
        """Whether a picture is pending."""
        return self._preview.busy or self._is_waiting

    def show(self) -> None:
        """Update the picture and the summary from frame, parameters and stage."""
        self._panel.form.set_parameters(self._workspace.parameters.extraction)
        frame = self._workspace.session.frame if self._workspace.has_session else None
        if frame is not self._frame:
            self._frame = frame
            self._preview.set_frame(frame)
            self._slow.stop()
            self._found, self._failure = None, ""
        self._is_waiting = False
        if frame is not None and self._views.shows_extraction:
            self._ask(frame)
            self._watch()
        self.describe()

    def _ask(self, frame: RGBDFrame) -> None:
        if self._panel.previews:
            parameters: BlockParameters | None = self._workspace.parameters.extraction
        else:
            parameters = self._preview.cached_parameters(frame) or self._workspace.session.notes.extraction
        if parameters is None:
            self._board.show_message(_OFF)
            return
        self._is_waiting = self._is_extracting(self._workspace.session) and not self._preview.held(frame, parameters)
        if not self._is_waiting:
            self._preview.ask(StageRequest(frame, parameters, self._board.stage))

    def describe(self) -> None:
        """Show the summary of the parameters' result in the panel, with the blocks that are kept."""
        panel, shown = self._panel, self._views.shows_extraction
        if self._frame is None or not self._workspace.has_session:
            panel.show_summary("")
        elif not shown and self._has_new_values() and panel.previews:
            panel.offer_view(LAYOUT_TEXTS[LAYOUT])
        elif self._failure and shown:
            panel.show_summary("", self._failure)
        elif self._found is not None and shown:
            panel.show_summary(self._summary(self._found), " ".join(self._found.extraction.notes))
        else:
            panel.show_summary("")

    def _has_new_values(self) -> bool:
        """Whether the frame's blocks were extracted with other parameters than the panel's."""
        return self._workspace.session.notes.extraction != self._workspace.parameters.extraction

    def _summary(self, found: FoundBlocks) -> str:
        if self._panel.previews:
            title = "Preview"
        else:
            fits = found.parameters == self._workspace.parameters.extraction
            title = "With these parameters" if fits else "With other parameters"
        blocks = found.extraction.blocks
        locked, by_hand = self._workspace.blocks.staying(self._workspace.session)
        around = _describe_around(len(locked), len(by_hand))
        return f"{title}: {describe_blocks(int(blocks.max()), blocks)}{around}, in {_duration(found.seconds)}."

    def show_stage(self, name: str) -> None:
        """Show a stage, and the view of the extraction if it is not visible."""
        self._board.set_stage(name)
        self.show_view()

    def show_view(self) -> None:
        """Show the view of the extraction if it is not visible."""
        self.view_requested.emit()
        if not self._views.shows_extraction:
            self._views.set_content("extraction", "extraction")
            self._views.set_layout(LAYOUT)

    def _switch(self, on: bool) -> None:
        if on:
            self.show_view()
        self.changed.emit()

    def extract(self) -> None:
        """Extract the blocks again with the panel's parameters; at once if the preview has the result."""
        session = self._workspace.session
        found = self._preview.held(session.frame, self._workspace.parameters.extraction)
        self.extraction_requested.emit(session, found)

    def hold(self, found: FoundBlocks) -> None:
        """Reuse the extraction of a frame's blocks for the view."""
        self._preview.hold(found)
        self.changed.emit()

    def go_on(self) -> None:
        """Update if waiting, because an extraction of blocks has started or ended and may not deliver a result."""
        if self._is_waiting:
            self.changed.emit()

    def shutdown(self) -> None:
        """Stop before the window closes."""
        self._slow.stop()
        self._preview.shutdown()

    def _watch(self) -> None:
        """Show that an extraction is running if it takes long."""
        if not self.busy:
            self._slow.stop()
        elif not self._slow.isActive():
            self._slow.start()

    def _take(self, answer: StageResult) -> None:
        self._slow.stop()
        self._watch()
        if answer.question.frame is not self._frame:
            return
        self._found, self._failure = answer.found, ""
        if answer.question.stage == self._board.stage:
            self._board.show_picture(answer.question.stage, answer.picture, answer.found.extraction)
        self.described.emit()

    def _fail(self, error: Exception) -> None:
        self._slow.stop()
        self._watch()
        self._failure = f"The extraction failed: {error_text(error)}"
        self._board.show_message("The extraction failed")
        self.described.emit()
        self._notes.show_message(self._failure)


def _describe_around(locked: int, by_hand: int) -> str:
    """Return which kept blocks the new blocks surround; "" for none."""
    kinds = (locked, "locked"), (by_hand, "made by hand")
    parts = [f"{counted(count, 'block')} {kind}" for count, kind in kinds if count]
    return f", around {' and '.join(parts)}" if parts else ""


def _duration(seconds: float) -> str:
    return f"{1000 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"
