"""Brings the stages of the extraction to their view, and extracts blocks when asked to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer

from gui.documents import error_text
from gui.extraction_preview import Answer, ExtractionPreview, Question
from gui.loader import describe_blocks
from ilf.ebs import Extraction
from ilf.frame import RGBDFrame
from ilf.parameters import BlockParameters

if TYPE_CHECKING:
    from gui.main_window import MainWindow

LAYOUT = "grid-extraction"
"""Layout that is chosen when stages are asked for and their view is not to be seen."""

_SLOW_MS = 300
"""Age at which an extraction is worth saying that it is under way: an edge network's first look at a frame."""

_OFF = "Switch on the preview of the extraction, or extract blocks"


class StagePresenter(QObject):
    """Decides what the view of the extraction shows.

    While that view is to be seen and the preview is on, it follows the panel's parameters; with the preview off it
    keeps to the last extraction of the frame. The frame's blocks change by `extract` alone.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._workspace = window.workspace
        self._preview = ExtractionPreview(self)
        self._preview.found.connect(self._take)
        self._preview.failed.connect(self._fail)
        self._frame: RGBDFrame | None = None
        self._slow = QTimer(self, singleShot=True, interval=_SLOW_MS)
        self._slow.timeout.connect(lambda: self._cell.strip.set_text("Extracting…"))
        self._cell = window.views.extraction

    @property
    def busy(self) -> bool:
        """Whether a picture is to come."""
        return self._preview.busy

    def refresh(self) -> None:
        """Show what is to be seen now; called when frame, parameters, stage, layout or the preview's switch change."""
        frame = self._workspace.session.frame if self._workspace.has_session else None
        if frame is not self._frame:
            self._frame = frame
            self._preview.turn_to(frame)
            self._slow.stop()
            self._window.extraction_panel.show_summary("")
        if frame is None or not self._window.views.shows_extraction:
            return
        panel = self._window.extraction_panel
        wanted = self._workspace.extraction_parameters
        parameters = wanted if panel.previews else self._preview.held_parameters(frame)
        if parameters is None:
            self._cell.show_message(_OFF)
            return
        self._preview.ask(Question(frame, parameters, self._cell.stage))
        self._watch()

    def show_stage(self, name: str) -> None:
        """Show a stage, and the view of the extraction if it is not to be seen."""
        self._cell.set_stage(name)
        self.show_view()

    def show_view(self) -> None:
        """Bring the view of the extraction up if it is not to be seen."""
        window = self._window
        window.centre.setCurrentWidget(window.views)
        if not window.views.shows_extraction:
            window.views.set_layout(LAYOUT)

    def take_parameters(self, parameters: BlockParameters) -> None:
        """The user set other parameters of EBS; the blocks take them at the next extraction."""
        self._workspace.extraction_parameters = parameters
        self.refresh()

    def take_keeping(self, on: bool) -> None:
        """The user wants blocks made by hand to stay at the next extraction, or not."""
        self._workspace.keeps_handmade = on

    def switch(self, on: bool) -> None:
        """The preview was switched on or off."""
        if on:
            self.show_view()
        self.refresh()

    def extract(self) -> None:
        """Extract the blocks again with the panel's parameters; at once where that is what the preview has found."""
        session = self._workspace.session
        found = self._preview.held(session.frame, self._workspace.extraction_parameters)
        self._window.loader.extract(session, found)

    def hold(self, frame: RGBDFrame, parameters: BlockParameters, extraction: Extraction, seconds: float) -> None:
        """An extraction has been made for the blocks of a frame; it need not be made again for the view."""
        if self._window.views.shows_extraction:
            self._preview.hold(frame, parameters, extraction, seconds)
            if frame is self._frame:
                self.refresh()

    def shutdown(self) -> None:
        """Stop before the window closes."""
        self._slow.stop()
        self._preview.shutdown()

    def _watch(self) -> None:
        """Say that an extraction is under way if nothing has come of it after a while."""
        if not self._preview.busy:
            self._slow.stop()
        elif not self._slow.isActive():
            self._slow.start()

    def _take(self, answer: Answer) -> None:
        self._slow.stop()
        self._watch()
        question, blocks = answer.question, answer.extraction.blocks
        if question.stage == self._cell.stage:
            self._cell.show_picture(question.stage, answer.picture)
        count, regions = int(blocks.max()), int(answer.extraction.contracted.max())
        found = f"{regions} region" if question.stage == "contracted" else f"{count} block"
        self._cell.strip.set_text(found if found.startswith("1 ") else f"{found}s")
        panel = self._window.extraction_panel
        fits = panel.previews or question.parameters == self._workspace.extraction_parameters
        title = "Preview" if fits else "With other values"
        text = f"{title}: {describe_blocks(count, blocks)}, in {1000 * answer.seconds:.0f} ms."
        panel.show_summary(text, answer.extraction.note)

    def _fail(self, error: Exception) -> None:
        self._slow.stop()
        self._watch()
        text = f"The extraction failed: {error_text(error)}"
        self._cell.show_message("The extraction failed")
        self._window.extraction_panel.show_summary("", text)
        self._window.documents.tell(text)
