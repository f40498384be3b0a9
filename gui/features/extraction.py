"""The panel of the extraction: its parameters, a preview of its stages, and the commands that extract blocks."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from ilf._runtime.formatting import counted, covered
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.drawing.blocks import stage_count, stage_legend, stage_picture
from ilf.segmentation.extraction import Extraction, extract

from ..base import theme
from ..base.commands import Command, command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..views.layouts import LAYOUT_TEXTS
from ..views.view_data import ShownStage
from ..widgets.basics import TEXT_BESIDE_ICON, command_button, lay_out
from ..widgets.notices import error_text
from ..widgets.parameter_form import ParameterForm
from .context import Context
from .panel import Panel

LAYOUT = "grid-extraction"
"""Layout to switch to when a stage is requested and its view is not visible."""

_OFF = "Switch the preview of the extraction on, or extract blocks"

_COMMANDS = {
    "strength": ("Edge &strength", "Show the edge strength: how much each pixel looks like a boundary"),
    "binarised": ("&Binarised edges", "Show the binarised edges over the colour image"),
    "dilated": ("&Dilated edges", "Show the dilated edges, with the added pixels marked"),
    "contracted": ("&Contracted regions", "Show the regions after contraction, grown back to the edges"),
    "blocks": ("B&locks found", "Show the blocks that the extraction finds"),
}
"""Text and hint of the command that shows a stage."""


def _stage_command(number: int, name: str) -> Command:
    text, hint = _COMMANDS[name]
    on, show = name == ShownStage().name, lambda panel: panel.show_stage(name)
    keys = f"Alt+{number}"
    return Command(f"stage_{name}", text, hint, keys=keys, group="stage", on=on, handler=show, needs=Need.FRAME)


_Stage = tuple[RGBDFrame, BlockParameters, str]
"""Frame, parameters and name of a stage: what its picture depends on."""


class ExtractionPanel(Panel):
    """The parameters of the extraction, and the view of its stages.

    While the view is visible and the preview is on, it follows the panel's parameters; with the preview off it shows
    the extraction of the frame's blocks. Only `extract` changes the frame's blocks. What both compute is
    computed once: the library caches the parts of an extraction with the frame.
    """

    title, icon, group = "Extraction", "ph.polygon", None
    parts = Part.FRAME | Part.EXTRACTION | Part.LABELS | Part.INFOS
    contents = ("stage",)
    what = "extraction"
    more_commands = tuple(map(_stage_command, range(1, 1 + len(_COMMANDS)), _COMMANDS))

    def __init__(self, context: Context) -> None:
        self._drawn: _Stage | None = None
        """What the picture in the view answers."""
        self._found: Extraction | None = None
        """The extraction in the view."""
        self._failure = ""
        self._previews = True
        """Whether the view follows the parameters."""
        super().__init__(context)
        for signal in (context.views.shownChanged, context.centre.turned):
            signal.connect(self.redraw)
        self.workspace.on(Part.FRAME, self._turn)

    def make(self) -> QWidget:
        """Make the form, with the commands and the summary above it."""
        button = command_button(self.context.actions["extract"], TEXT_BESIDE_ICON)
        preview = QCheckBox("Preview")
        preview.setChecked(self._previews)
        preview.setToolTip(
            "Update the view of the extraction as the parameters below change; the frame's blocks stay as they are"
        )
        preview.clicked.connect(self._switch_preview)
        keep = QCheckBox("Keep blocks made by hand")
        keep.setChecked(self.workspace.parameters.keeps_handmade)
        keep.setToolTip(
            "Keep the blocks that you drew, enlarged, merged or erased from when blocks are extracted again; locked "
            "blocks are always kept"
        )
        keep.clicked.connect(self.workspace.parameters.set_keeps_handmade)
        self._summary = QLabel(wordWrap=True)
        self._summary.setObjectName("summary")
        self._summary.linkActivated.connect(self.show_view)
        self._summary.hide()
        self.form = ParameterForm(BlockParameters)
        self.form.changed.connect(self.workspace.parameters.set_extraction)
        row = lay_out(QHBoxLayout(), button, preview, None, spacing=10)
        widget = QWidget()
        lay_out(QVBoxLayout(widget), row, keep, self._summary, self.form, margins=(8, 8, 4, 4), stretched=self.form)
        return widget

    # the view

    def refresh(self, parts: Part) -> None:
        """Update the picture and the summary from frame, parameters and stage."""
        if self.made:
            self.form.set_parameters(self.workspace.parameters.extraction)
        if (document := self.workspace.shown) is not None and self.views.shows("stage"):
            self._ask_stage(document)
        self._describe()

    def _turn(self) -> None:
        """Release the data of a frame that is not shown any more."""
        self._drawn, self._found, self._failure = None, None, ""
        self.requests.cancel()

    def _ask_stage(self, document: Document) -> None:
        """Ask for the picture of the shown stage, unless the view shows it."""
        parameters = self.workspace.parameters.extraction if self._previews else document.blocks.extraction
        if parameters is None:
            self._drawn = None
            self._tell(message=_OFF)
            return
        stage = document.frame, parameters, self.views.data.stage.name
        if stage != self._drawn or self.busy:
            self.requests.ask(lambda: _draw_stage(*stage), lambda drawn: self._show_stage(stage, *drawn), key=stage)

    def _tell(self, **changes: Any) -> None:
        """Change what the views show of the stage: with a message, it has no picture."""
        stage = ShownStage(self.views.data.stage.name) if "message" in changes else self.views.data.stage
        self.views.show_found(stage=stage._replace(**changes))

    def _show_stage(self, stage: _Stage, found: Extraction, picture: NDArray[np.uint8]) -> None:
        """Show the picture."""
        self._found = found
        self._failure = ""
        if (name := stage[-1]) == self.views.data.stage.name:
            self._drawn = stage
            legend, text = stage_legend(name, found), stage_count(name, found)
            self.views.show_found(stage=ShownStage(name, picture, text=text, legend=legend))
        self._describe()

    def fail(self, error: Exception) -> None:
        """Show the error in the panel: a dialog would come at every move of a slider."""
        self._failure, self._drawn = f"The extraction failed: {error_text(error)}", None
        self._tell(message="The extraction failed")
        self._describe()
        self.notes.show_message(self._failure)

    def show_stage(self, name: str) -> None:
        """Show a stage, and the view of the extraction if it is not visible."""
        self._tell(name=name)
        self.show_view()
        self.redraw()

    def show_view(self, *_: str) -> None:
        """Show the view of the extraction if it is not visible."""
        self.context.centre.show_images()
        if not self.views.shows("stage"):
            self.views.set_content("extraction", "extraction")
            self.views.sheet.set_layout(LAYOUT)

    def _switch_preview(self, on: bool) -> None:
        self._previews = on
        if on:
            self.show_view()
        self.redraw()

    @command("extract", "E&xtract blocks", icon="ph.polygon", keys="Ctrl+B", needs=Need.FRAME | Need.IDLE)
    def extract(self) -> None:
        """Extract the blocks again; locked blocks and hand-made blocks stay."""
        self.context.loader.extract(self.workspace.current)

    # the summary

    def _describe(self) -> None:
        """Show the summary of the parameters' result in the panel, with the blocks that are kept; or a link to the
        layout that shows that result."""
        if not self.made:
            return
        colours, workspace, text, note = theme.colours(self.widget.palette()), self.workspace, "", ""
        if self.views.shows("stage"):
            if self._failure:
                note = html.escape(self._failure)
            elif self._found is not None:
                text, note = html.escape(self._text(self._found)), html.escape(" ".join(self._found.notes))
        elif self._previews and (now := workspace.shown) and now.blocks.extraction != workspace.parameters.extraction:
            link = f'<a href="view" style="color: {colours.accent.name()}">{html.escape(LAYOUT_TEXTS[LAYOUT])}</a>'
            text = f"Choose the view set {link} to see the result of these parameters."
        # not by palette, which a new application style sheet would reset
        lines = [
            f'<span style="color: {tone.name()}">{words}</span>'
            for words, tone in ((text, colours.muted), (note, colours.warning))
            if words
        ]
        self._summary.setText("<br>".join(lines))
        self._summary.setVisible(bool(lines))

    def _text(self, found: Extraction) -> str:
        if self._previews:
            title = "Preview"
        else:
            fits = self.workspace.current.blocks.extraction == self.workspace.parameters.extraction
            title = "With these parameters" if fits else "With other parameters"
        blocks = found.blocks
        locked, by_hand = self.workspace.current.staying(self.workspace.parameters.keeps_handmade)
        kinds = (len(locked), "locked"), (len(by_hand), "made by hand")
        kept = " and ".join(f"{counted(count, 'block')} {kind}" for count, kind in kinds if count)
        around = f", around {kept}" if kept else ""
        return f"{title}: {covered(int(blocks.max()), float((blocks > 0).mean()))}{around}."


def _draw_stage(frame: RGBDFrame, parameters: BlockParameters, stage: str) -> tuple[Extraction, NDArray[np.uint8]]:
    """Extract the blocks, whose parts are cached with the frame, and draw a stage; called in a worker thread."""
    found = extract(frame, parameters)
    return found, stage_picture(stage, frame.rgb, found)
