"""Opening, exporting and closing frames, with their dialogs and messages."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QApplication

from ilf._runtime.formatting import counted, covered
from ilf._runtime.installation import asset_path
from ilf.data.blocks import Blocks
from ilf.data.results import Completion
from ilf.errors import IlfError, InputError
from ilf.io.block_files import BLOCK_FORMATS, write_blocks
from ilf.run.record import read_record
from ilf.run.run import Run
from ilf.run.writing import check_not_an_input
from ilf.sources.frame_ref import RECORD_FILE, FrameRef
from ilf.sources.listing import Listing, list_frames
from ilf.sources.named_places import note_opened
from ilf.sources.reading import read_frame

from ...base.commands import command
from ...base.needs import Need
from ...base.paths import contains_frames, sort_paths
from ...state.document import Document
from ...state.parts import Part
from ...widgets.basics import open_once
from ...widgets.file_choice import ask_file, ask_path, save, write_picture
from ...work.latest_request import LatestRequest
from ..cloud import CloudPanel
from ..context import Context, Feature
from ..project.feature import ProjectFeature
from .frame_files import Kind
from .recent import Origin, RecentMenu

_NO_RESULT = (
    "The result is not shown: its depth is not beside the record as it was computed, in depth.npy or depth.tiff. Run "
    "the frame to get it."
)
_TOO_MANY = "Only one colour file and its depth file can be opened at a time. For several frames, drop their folder."


class DocumentsFeature(Feature):
    """Opening and writing of files, and the menu of what was opened last."""

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._window = context.window
        self._project = context.feature(ProjectFeature)
        self._looks, self._block_files = LatestRequest(self), LatestRequest(self)
        self.recent = RecentMenu(self.open_again, context.window)
        context.actions.adopt("recent_menu", self.recent.menuAction(), "ph.clock-counter-clockwise")
        self._noted: set[str] = set()
        context.workspace.on(Part.LIST, self._note_recent)
        self._project.opening.opened.connect(lambda opened: self.recent.note(opened.path))
        self._project.saving.saved.connect(lambda path, _: self.recent.note(path))
        self.context.loader.listed.connect(self._tell_listed)
        self.context.loader.replayed.connect(self._tell_differences)
        context.runs.finished.connect(self._tell_verdict)

    # opening

    @command("open", "&Open…", icon="ph.folder-open", keys="Ctrl+O")
    def ask_open(self) -> None:
        """Open a pair of images, a folder or data set, a recording, a project or a run."""
        self._open_dialog()

    @command("open_sample", "Open sa&mple", icon="ph.house", keys="Ctrl+Shift+O")
    def open_sample(self) -> None:
        """Open the bundled sample frame, a synthetic room."""
        try:
            self.open_source(FrameRef(str(asset_path("samples/room"))))
        except IlfError as error:
            self.notes.report("Open sample", error)

    def open_paths(self, paths: list[Path]) -> None:
        """Open dropped or given paths: folders of frames and recordings at once, single files with the dialog,
        run.json as a run; a project replaces the current one."""
        projects, folders, records, files = sort_paths(paths)
        if projects:
            self._project.opening.open(projects[-1].absolute())
        for folder in folders:
            self.open_source(FrameRef(str(folder)))
        for record in records:
            self.open_run(record)
        if len(files) > 2:
            self.notes.report("Open", InputError(_TOO_MANY))
        elif files:
            self._open_dialog(*map(str, files))

    def open_source(self, source: FrameRef) -> None:
        """Open a frame, or the frames of a folder or a recording; ask first if that would replace the same frame, read
        with other options, and the work on it, or if it is not of the folder of the project. Other intrinsics alone
        replace nothing."""
        source = source.absolute()
        note_opened(*source.paths)
        several = source.depth is None and source.frame is None and contains_frames(source.rgb)
        open_ = self._project.opening.open_folder if several else self.context.loader.open
        look = partial(list_frames, source.rgb, source.options) if several else partial(read_frame, source)
        self._project.join(Path(source.rgb), look, lambda: open_(source))

    def open_run(self, record: Path) -> None:
        """Open the run.json of a result, as its folder: the frame, blocks, parameters and result of the run."""
        if record.name != RECORD_FILE:
            text = f"{record} is not a run record: give the {RECORD_FILE} of an export, under this name."
            self.notes.report(f"Opening {record.name}", InputError(text))
            return
        folder = FrameRef(os.path.abspath(record.parent))  # one key for all spellings of the path
        self._project.join(record.absolute(), partial(read_record, record), lambda: self.context.loader.open(folder))

    def _open_dialog(self, *files: str) -> None:
        from .open_dialog import OpenDialog

        dialog = OpenDialog(self._looks, self._window)
        if files:
            dialog.set_files(*files)

        def take() -> None:
            if dialog.kind in (Kind.PROJECT, Kind.RUN):
                self.open_paths([Path(dialog.path.text().strip())])
            else:
                self.open_source(dialog.request())

        open_once(dialog, take)

    # blocks

    @command("load_blocks", "Load bloc&ks…", icon="ph.squares-four", needs=Need.FRAME | Need.IDLE)
    def ask_load_blocks(self) -> None:
        """Replace the blocks with those from a label map, a labelme or COCO file, or a folder of masks."""
        from .load_blocks import LoadBlocksDialog

        document, filling = self.workspace.current, self.workspace.parameters.extraction
        dialog = LoadBlocksDialog(document.frame, filling, self._block_files, self._window)
        open_once(dialog, lambda: self._take_blocks(dialog.seen.found))

    def _take_blocks(self, blocks: Blocks) -> None:
        self.workspace.current.replace_blocks(blocks.labels, "Load blocks", blocks.names)
        document = self.workspace.current
        share = float((document.labels > 0).mean())
        self.notes.show_message(f"Loaded: {covered(len(document.counts()), share)}.")

    @command("save_blocks", "Save b&locks…", needs=Need.BLOCKS)
    def ask_save_blocks(self) -> None:
        """Write the blocks and their names as label map (PNG), COCO or labelme file."""
        kinds = {f"{text} (*{suffix})": (name, suffix) for name, (text, suffix) in BLOCK_FORMATS.items()}
        proposed = f"{self.workspace.current.name}-blocks.png"
        path, kind = ask_file(self._window, "Save blocks", proposed, ";;".join(kinds))
        if path:
            format, suffix = kinds[kind]
            # a typed suffix takes precedence over the kind
            self.save_blocks(path, format if Path(path).suffix.lower() == suffix else None)

    def save_blocks(self, path: str, format: str | None = None) -> bool:
        """Write the blocks with their names; return False, with a message, if the file cannot be written."""
        from .load_blocks import colour_file

        document = self.workspace.current
        blocks, image = document.blocks, colour_file(document.frame)
        try:
            check_not_an_input(document.frame, [Path(path)])
            write_blocks(path, blocks.labels, format=format, names=blocks.names, colours=blocks.colours, image=image)
        except IlfError as error:
            self.notes.report("Save blocks", error)
            return False
        names = "" if path.lower().endswith(".json") else " (without names: use COCO or labelme for these)"
        self.notes.show_message(f"Saved {counted(len(document.counts()), 'block')} to {path}{names}")
        return True

    # closing

    @command("close_frame", "&Close frame", icon="ph.x", keys="Ctrl+W", needs=Need.FRAME)
    def close_frame(self) -> None:
        """Close the current frame.

        It asks about unsaved work; a saved frame stays in the list.
        """
        entry = self.workspace.current_entry
        if entry is not None:
            self._project.close_frame(entry)

    # what was opened last

    def _note_recent(self) -> None:
        """Record newly opened frames, except those of a project or a folder."""
        open_now = {document.key: document for document in self.workspace.open}
        for key, document in open_now.items():
            entry = self.workspace.entries.of(document.id)
            brought = entry is not None and (entry.has_state or entry.from_folder)
            if key not in self._noted and not brought and isinstance(document.origin, FrameRef):
                self.recent.note(document.origin)
        self._noted = set(open_now)

    def _tell_listed(self, how: FrameRef, listing: Listing) -> None:
        self.recent.note(how)
        text = f"{how.name}: {counted(len(listing.sources), 'frame')}."
        self.notes.show_message(" ".join((text, *listing.notes)))

    def open_again(self, origin: Origin) -> None:
        """Open what was opened before."""
        if isinstance(origin, Path):
            self._project.opening.open(origin)
        else:
            self.open_source(origin)

    # pictures

    @command("save_picture", "Save &picture of the views…", icon="ph.camera")
    def ask_save_picture(self) -> None:
        """Save a figure as PNG: the views or the point cloud as they are shown, with titles and colour bars."""
        if path := ask_path(self._window, "Save picture", "ilf-studio.png", "PNG image (*.png)"):
            self.save_picture(path)

    def save_picture(self, path: str) -> bool:
        """Save a picture of the views as PNG, without crosshair and focus; return False, with a message, if the file
        cannot be written."""
        focused = QApplication.focusWidget()
        self.views.navigation.point_at(None)
        if focused is not None:
            focused.clearFocus()
        self._finish_cloud()
        picture = self.context.centre.picture()
        if focused is not None:
            focused.setFocus()
        return save(self.notes, path, lambda: write_picture(path, picture))

    def picture(self) -> QPixmap:
        """Return a screenshot of the window."""
        self.context.refresh.now()
        self._finish_cloud()
        return self._window.grab()

    def _finish_cloud(self) -> None:
        if (cloud := self.context.made(CloudPanel)) is not None:
            cloud.view.canvas.drawing.finish()

    # runs opened from a record

    def _tell_differences(self, document: Document) -> None:
        """Report which input, network, version or output of a document opened from a record differs, if any, and
        whether its result cannot be shown."""
        again = document.record_replay
        if again is not None:
            unshown = () if again.completion is not None else (_NO_RESULT,)
            self.notes.warn(f"{document.name}: differences to the run record", (*again.differences, *unshown))

    def _tell_verdict(self, document: Document) -> None:
        """If the run that has ended is the recorded one, report whether its result equals the record."""
        again, completion = document.record_replay, document.completion()
        if again is None or completion is None or not _is_recorded_run(document, again.run, completion):
            return
        verdict = again.verdict(completion)
        if verdict:
            self.notes.warn(f"{document.name}: the result differs from the run record", verdict)
        else:
            self.notes.show_message(f"{document.name}: the result equals the run record.")


def _is_recorded_run(document: Document, recorded: Run, completion: Completion) -> bool:
    """Whether the completion is of the recorded run: the same blocks with drawn borders, depth by hand, invalid mask,
    guide, depth of neighbours and parameters."""
    if document.extrapolated != recorded.extrapolate or not document.has_inputs_of(recorded):
        return False
    return set(completion.results) == (recorded.only or frozenset()) and all(
        result.parameters == recorded.parameters_of(label) for label, result in completion.results.items()
    )
