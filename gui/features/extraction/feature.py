"""Shows the stages of the extraction in their view, and extracts blocks on request."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QTimer, Signal

from ilf._runtime.formatting import counted
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import STAGES

from ...base.commands import Command, hint_of
from ...base.needs import Need
from ...state.parts import Part
from ...views.layouts import LAYOUT_TEXTS
from ...widgets.notices import error_text
from ...work.found_blocks import FoundBlocks, describe_blocks
from ..context import Context, Feature
from .panel import ExtractionPanel, ExtractionPreview, StageRequest, StageResult

LAYOUT = "grid-extraction"
"""Layout to switch to when a stage is requested and its view is not visible."""

_SLOW_MS = 300
"""Delay until a running extraction is shown [ms]: an edge network's first pass over a frame takes longer."""

_OFF = "Switch the preview of the extraction on, or extract blocks"


class ExtractionFeature(Feature):
    """The view of the extraction, its panel with the summary, and the commands.

    While the view is visible and the preview is on, it follows the panel's parameters; with the preview off it shows
    the last extraction of the frame. Only `extract` changes the frame's blocks. While they are being extracted, the
    feature waits for that result instead of computing it a second time.

    Signals
    -------
    changed()
        The output of `show` has changed: another stage, or the preview was switched.
    described()
        The output of `describe` has changed.
    """

    changed = Signal()
    described = Signal()

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = workspace = context.workspace
        self._loader = loader = context.loader
        self._is_waiting = False
        """Whether a request waits until the blocks have been extracted."""
        self._views = views = context.views
        context.actions.add(self._commands())
        self.panel = panel = ExtractionPanel(context.actions["extract"])
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
        loader.extracted.connect(self.hold)
        loader.busy_changed.connect(self.go_on)
        self._mark_stages()
        seen = self.changed, views.shownChanged, context.centre.turned
        context.refresh.add("stages", self.show, Part.FRAME | Part.EXTRACTION, also=seen)
        context.refresh.add("extraction", self.describe, Part.LABELS | Part.INFOS, also=(self.described,))

    def _commands(self) -> Sequence[Command]:
        return (
            Command(
                "extract",
                "E&xtract blocks",
                "Extract the blocks again; locked blocks and hand-made blocks stay",
                icon="ph.polygon",
                keys="Ctrl+B",
                handler=self.extract,
                needs=Need.FRAME | Need.IDLE,
            ),
            Command(
                "stage_strength",
                "Edge &strength",
                "Show the edge strength: how much each pixel looks like a boundary",
                keys="Alt+1",
                group="stage",
                handler=partial(self.show_stage, "strength"),
                needs=Need.FRAME,
            ),
            Command(
                "stage_binarised",
                "&Binarised edges",
                "Show the binarised edges over the colour image",
                keys="Alt+2",
                group="stage",
                handler=partial(self.show_stage, "binarised"),
                needs=Need.FRAME,
            ),
            Command(
                "stage_dilated",
                "&Dilated edges",
                "Show the dilated edges, with the added pixels marked",
                keys="Alt+3",
                group="stage",
                handler=partial(self.show_stage, "dilated"),
                needs=Need.FRAME,
            ),
            Command(
                "stage_contracted",
                "&Contracted regions",
                "Show the regions after contraction, grown back to the edges",
                keys="Alt+4",
                group="stage",
                handler=partial(self.show_stage, "contracted"),
                needs=Need.FRAME,
            ),
            Command(
                "stage_blocks",
                "B&locks found",
                "Show the blocks that the extraction finds",
                keys="Alt+5",
                group="stage",
                handler=partial(self.show_stage, "blocks"),
                needs=Need.FRAME,
            ),
        )

    def _mark_stages(self) -> None:
        """Mark the command of the shown stage, and show the commands' hints on the buttons of the view."""
        board, stages = self._board, {name: self.context.actions[f"stage_{name}"] for name in STAGES}

        def show_hints() -> None:
            board.set_hints({name: hint_of(action) for name, action in stages.items()})

        stages[board.stage].setChecked(True)
        board.stageChanged.connect(lambda name: stages[name].setChecked(True))
        for action in stages.values():  # also when its shortcut changes
            action.changed.connect(show_hints)
        show_hints()

    @property
    def busy(self) -> bool:
        """Whether a picture is pending."""
        return self._preview.busy or self._is_waiting

    def show(self) -> None:
        """Update the picture and the summary from frame, parameters and stage."""
        self.panel.form.set_parameters(self._workspace.parameters.extraction)
        frame = self._workspace.current.frame if self._workspace.has_current else None
        if frame is not self._frame:
            self._frame = frame
            self._preview.set_frame(frame)
            self._slow.stop()
            self._found, self._failure = None, ""
        self._is_waiting = False
        if frame is not None and self._views.shows("stage"):
            self._ask(frame)
            self._watch()
        self.describe()

    def _ask(self, frame: RGBDFrame) -> None:
        if self.panel.previews:
            parameters: BlockParameters | None = self._workspace.parameters.extraction
        else:
            parameters = self._preview.cached_parameters(frame) or self._workspace.current.blocks.extraction
        if parameters is None:
            self._board.show_message(_OFF)
            return
        self._is_waiting = self._loader.is_extracting(self._workspace.current) and not self._preview.held(
            frame, parameters
        )
        if not self._is_waiting:
            self._preview.ask(StageRequest(frame, parameters, self._board.stage))

    def describe(self) -> None:
        """Show the summary of the parameters' result in the panel, with the blocks that are kept."""
        panel, shown = self.panel, self._views.shows("stage")
        if self._frame is None or not self._workspace.has_current:
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
        return self._workspace.current.blocks.extraction != self._workspace.parameters.extraction

    def _summary(self, found: FoundBlocks) -> str:
        if self.panel.previews:
            title = "Preview"
        else:
            fits = found.parameters == self._workspace.parameters.extraction
            title = "With these parameters" if fits else "With other parameters"
        blocks = found.extraction.blocks
        locked, by_hand = self._workspace.current.staying(self._workspace.parameters.keeps_handmade)
        around = _describe_around(len(locked), len(by_hand))
        took = f"{1000 * found.seconds:.0f} ms" if found.seconds < 1 else f"{found.seconds:.1f} s"
        return f"{title}: {describe_blocks(int(blocks.max()), blocks)}{around}, in {took}."

    def show_stage(self, name: str) -> None:
        """Show a stage, and the view of the extraction if it is not visible."""
        self._board.set_stage(name)
        self.show_view()

    def show_view(self) -> None:
        """Show the view of the extraction if it is not visible."""
        self.context.centre.show_images()
        if not self._views.shows("stage"):
            self._views.set_content("extraction", "extraction")
            self._views.set_layout(LAYOUT)

    def _switch(self, on: bool) -> None:
        if on:
            self.show_view()
        self.changed.emit()

    def extract(self) -> None:
        """Extract the blocks again with the panel's parameters; at once if the preview has the result."""
        document = self._workspace.current
        found = self._preview.held(document.frame, self._workspace.parameters.extraction)
        self._loader.extract(document, found)

    def hold(self, found: FoundBlocks) -> None:
        """Reuse the extraction of a frame's blocks for the view."""
        self._preview.hold(found)
        self.changed.emit()

    def go_on(self) -> None:
        """Update if waiting, because an extraction of blocks has started or ended and may not deliver a result."""
        if self._is_waiting:
            self.changed.emit()

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        self._slow.stop()
        return self._preview.shutdown()

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
        self.context.notes.show_message(self._failure)


def _describe_around(locked: int, by_hand: int) -> str:
    """Return which kept blocks the new blocks surround; "" for none."""
    kinds = (locked, "locked"), (by_hand, "made by hand")
    parts = [f"{counted(count, 'block')} {kind}" for count, kind in kinds if count]
    return f", around {' and '.join(parts)}" if parts else ""
