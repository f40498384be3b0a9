"""The guide of a frame: dialog to load it, command to remove it, and its description."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple
from weakref import WeakSet

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from ilf.completion.completion import guide_text
from ilf.completion.edge_aware.fitted_guide import FittedGuide, fit_guide
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError
from ilf.io.frame_additions import load_guide

from ..base.commands import Command
from ..base.needs import Need
from ..state.document import Document
from ..widgets.basics import label_of, row
from ..widgets.file_choice import choose_file
from ..work.latest_request import LatestRequest
from .context import Context, Feature
from .documents.file_dialogs import PreviewDialog
from .documents.frame_files import guide_files

# The dialog that loads a guide: file, and the fit to the known depth.

_FOLDER_KEY = "guide/folder"
_NOTHING_SELECTED = (
    "Choose depth or inverse depth of this frame, in any unit: from a network that predicts depth from colour, or "
    "from another sensor. Zero and NaN are ignored."
)


class GuideSource(NamedTuple):
    """A file with a guide of a frame."""

    frame: RGBDFrame
    path: str


class GuidedFrame(NamedTuple):
    """The frame with its guide, and the guide fitted in metres."""

    frame: RGBDFrame
    fitted: FittedGuide
    use: str
    """How it is used, after "The guide is"."""


def read_guided_frame(source: GuideSource) -> GuidedFrame:
    """Read the file and fit it to the known depth; called in a worker thread."""
    frame = source.frame.with_guide(load_guide(source.path, source.frame.shape, source.frame.rgb))
    fitted = fit_guide(frame)
    assert fitted is not None
    return GuidedFrame(frame, fitted, guide_text(frame))


class GuideDialog(PreviewDialog[GuideSource, GuidedFrame]):
    """Dialog to choose a guide, with a preview.

    Parameters
    ----------
    frame : RGBDFrame
    questions : LatestRequest
        Reads a `GuideSource` in a worker thread.
    """

    def __init__(
        self, frame: RGBDFrame, questions: LatestRequest[GuideSource, GuidedFrame], parent: QWidget | None = None
    ) -> None:
        placeholder = "Depth or inverse depth: PNG, TIFF, PGM, NPY or NPZ; or a network: ONNX"
        title = f"Load Guide for {frame.name}"
        super().__init__(title, placeholder, _NOTHING_SELECTED, "Guide, fitted", questions, parent)
        self._frame = frame
        self.path.setToolTip("The file with the guide")
        self.load_button.setToolTip("Use this guide in the next runs")
        self.file_button.setToolTip("Choose the file with the guide")
        self.setMinimumWidth(600)
        self.ask(row(label_of("&Guide", self.path), self.path, self.file_button))

    def source(self, path: str) -> GuideSource:
        return GuideSource(self._frame, str(Path(path).expanduser().absolute()))

    def show_found(self, found: GuidedFrame) -> None:
        self.preview.show_depth(found.fitted.depth)
        self.message.show_message(describe_guide(found), "warning" if found.use.startswith("not") else "good")

    def browse(self) -> None:
        self.choose(choose_file(self, "Choose guide", _FOLDER_KEY, guide_files()))


def describe_guide(found: GuidedFrame) -> str:
    """Describe the coverage of a guide and how it is used."""
    coverage = f"It covers {(found.fitted.confidence > 0).mean():.0%} of the pixels"
    return f"{coverage}, and is {found.use}."


class GuideFeature(Feature):
    """The commands on the guide."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        actions, workspace = context.actions, context.workspace
        actions.add(
            (
                Command(
                    "load_guide",
                    "Load &guide…",
                    "Use depth or inverse depth from another source, or a network that predicts it, where it helps",
                    icon="ph.compass",
                    handler=self.ask,
                    needs=Need.FRAME,
                ),
                Command(
                    "remove_guide",
                    "Remove guide",
                    "Complete the frame without a guide",
                    icon="ph.x-circle",
                    handler=self.remove,
                    needs=Need.GUIDE,
                ),
            )
        )
        self._reader = LatestRequest[GuideSource, GuidedFrame](read_guided_frame, self)
        for changed in (workspace.frames.session_changed, workspace.blocks.guide_changed):
            changed.connect(self._tell_guide)
        self._reported: WeakSet[Document] = WeakSet()
        """Frames whose guide has been reported, or loaded here."""

    def ask(self) -> None:
        """Load a guide for the current frame by the dialog."""
        document = self.context.workspace.current
        dialog = GuideDialog(document.frame, self._reader, self.context.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take(document, dialog.found()))
        dialog.open()

    def load(self, path: str) -> bool:
        """Load the guide of the current frame from a file; return False, with a message, if that fails."""
        document = self.context.workspace.current
        try:
            found = read_guided_frame(GuideSource(document.frame, path))
        except IlfError as error:
            self.context.notes.report("Load guide", error)
            return False
        self._take(document, found)
        return True

    def remove(self) -> None:
        """Complete the current frame without a guide."""
        self.context.workspace.current.set_guide(None, "Remove guide")
        self.context.notes.show_message("Guide removed.")

    def _take(self, document: Document, found: GuidedFrame) -> None:
        workspace, guide = self.context.workspace, found.frame.guide
        if document not in workspace.open or guide is None:
            return
        workspace.show(document)  # another frame may have been opened meanwhile
        self._reported.add(document)
        workspace.current.set_guide(guide, "Load guide")
        name = "" if guide.path is None else f" {Path(guide.path).name}"
        self.context.notes.show_message(f"Guide{name}: {describe_guide(found)}")

    def _tell_guide(self) -> None:
        """Tell once that a frame was opened with a guide."""
        workspace = self.context.workspace
        if self._has_guide and workspace.current not in self._reported:
            self._reported.add(workspace.current)
            name = workspace.current.name
            self.context.notes.show_message(
                f"{name} has a guide, which the runs use. To run without it: File > Remove guide."
            )

    @property
    def _has_guide(self) -> bool:
        workspace = self.context.workspace
        return workspace.has_current and workspace.current.frame.guide is not None
