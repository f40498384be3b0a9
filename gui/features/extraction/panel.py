"""The panel of the extraction, and the preview of its stages."""

from __future__ import annotations

import html
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QToolButton, QVBoxLayout, QWidget

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import stage_picture

from ...base import theme
from ...widgets.basics import Themed
from ...widgets.parameter_form import ParameterForm
from ...work.found_blocks import FoundBlocks, find
from ...work.latest_request import LatestRequest

# The panel of EBS: its parameters, their preview, and the button that extracts blocks again.


class ExtractionPanel(Themed, QWidget):
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
            text = f"Choose the view set {link} to see the result of these parameters."
            lines.append(f'<span style="color: {colours.muted.name()}">{text}</span>')
        self._summary.setText("<br>".join(lines))
        self._summary.setVisible(bool(lines))

    def _take_theme(self) -> None:
        if hasattr(self, "form"):
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
