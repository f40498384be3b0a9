"""Opening, exporting and closing frames, with the dialogs and messages that go with them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path

from PySide6.QtCore import QObject, QSettings, Qt, Signal
from PySide6.QtGui import QPixmap
from PySide6.QtWidgets import QFileDialog, QWidget

from ilf._runtime.installation import asset_path
from ilf.data.results import compose
from ilf.errors import IlfError, InputError
from ilf.io.block_files import BLOCK_FORMATS
from ilf.io.labels import LoadedBlocks
from ilf.run.options import ExportOptions, output_folder_name
from ilf.run.writing import Written, write
from ilf.sources.frame_source import FrameSource

from ...base.paths import sorted_out
from ...state.entries import Entry
from ...state.session import Session
from ...state.workspace import Workspace
from ...widgets.notices import Notes
from ...work.found_blocks import describe_blocks
from ...work.jobs import Worker
from ...work.latest_question import LatestQuestion
from ...work.loading import FirstLook, FrameLoader, holds_frames, look_into
from .blocks import BlockSource, LoadBlocksDialog, blocks_from, save_blocks
from .export import ExportDialog, behind
from .file_dialogs import save_folder
from .open_frame import OpenFrameDialog

_IMAGES = "PNG image (*.png)"
_TOO_MANY = (
    "A colour file and its depth file are opened at a time. For several frames, drop the folder that holds them."
)


class Documents(QObject):
    """What comes from files and goes to files.

    Parameters
    ----------
    window : QWidget
        In front of which dialogs open.
    take_picture : callable
        Gives what the window shows.

    Signals
    -------
    folder_wished(object)
        The FrameSource of a folder of frames or a recording, which has been dropped or named: how they are to be read.
    project_wished(object)
        A project file, by its Path, has been dropped or named.
    exported(object)
        What has been Written by an export.
    exporting_changed()
        An export has begun or ended, or more of the project has been saved.
    """

    folder_wished = Signal(object)
    project_wished = Signal(object)
    exported = Signal(object)
    exporting_changed = Signal()

    def __init__(
        self,
        window: QWidget,
        take_picture: Callable[[], QPixmap],
        workspace: Workspace,
        loader: FrameLoader,
        notes: Notes,
    ) -> None:
        super().__init__(window)
        self._window = window
        self._take_picture = take_picture
        self._workspace = workspace
        self._loader = loader
        self._notes = notes
        self._block_questions = LatestQuestion[BlockSource, LoadedBlocks](blocks_from, self)
        self._looks = LatestQuestion[FrameSource, FirstLook](look_into, self)
        self._exporter = Worker(self)
        self._exporter.finished.connect(self._note_exported)
        self._exporter.failed.connect(lambda error: notes.report("Export failed", error))
        for ended in (self._exporter.finished, self._exporter.failed):
            ended.connect(lambda _: self.exporting_changed.emit())
        self.discard_silently = False
        """Close without asking; for pictures and checks made without a user."""
        self.saved_share: Callable[[], float | None] = lambda: None
        """How much of the project that is being saved is written, 0-1; None if none is."""
        self.leave: Callable[[Sequence[Entry], Callable[[], None]], None] = lambda entries, then: then()
        """Closes frames: calls what follows as soon as nothing of them would be lost, if the user wants it."""
        self.remove: Callable[[Sequence[Entry], Callable[[], None]], None] = lambda entries, then: then()
        """Takes frames out of the list: calls what follows if the user wants it."""
        self.close: Callable[[Entry], None] = lambda entry: workspace.remove_entries([entry])
        """Closes a frame."""

    # opening

    def ask_open(self) -> None:
        """Open a frame by the dialog."""
        self._open_dialog(None, None)

    def open_sample(self) -> None:
        """Open the bundled room."""
        try:
            self.open_source(FrameSource(str(asset_path("samples/room"))))
        except IlfError as error:
            self._notes.report("Open sample", error)

    def open_paths(self, paths: list[Path]) -> None:
        """Open what was dropped or named: frames, folders and recordings of them at once, single files by the dialog,
        run.json as a run; a project in the place of the present one."""
        projects, folders, records, files = sorted_out(paths)
        if projects:
            self.project_wished.emit(projects[-1])
        for folder in folders:
            self.open_source(FrameSource(str(folder)))
        for record in records:
            self._loader.open_run(record)
        if len(files) > 2:
            self._notes.report("Open", InputError(_TOO_MANY))
        elif files:
            self._open_dialog(str(files[0]), str(files[1]) if len(files) > 1 else None)

    def open_source(self, source: FrameSource) -> None:
        """Open a frame, or the frames of a folder or a recording; ask first if it would replace the same frame, read in
        another way, and the work done there, saved or not."""
        source = source.absolute()
        if source.depth is None and source.frame is None and holds_frames(source.rgb):
            self.folder_wished.emit(source)
            return
        entry = self._workspace.entries.of_key(source.key)
        if entry is None or entry.origin == source:
            self._loader.open(source)
        else:
            self.remove([entry], lambda: self._loader.open(source))

    def _open_dialog(self, rgb: str | None, depth: str | None) -> None:
        dialog = OpenFrameDialog(self._looks, self._window)
        if rgb is not None:
            dialog.set_files(rgb, depth)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self.open_source(dialog.request()))
        dialog.open()

    def ask_open_run(self) -> None:
        """Open a run.json: its frame, blocks and parameters."""
        path, _ = QFileDialog.getOpenFileName(self._window, "Open run", "", "Run record (run.json *.json)")
        if path:
            self._loader.open_run(Path(path))

    # blocks

    def ask_load_blocks(self) -> None:
        """Replace the blocks by those of a file or folder, by the dialog."""
        session, filling = self._workspace.session, self._workspace.extraction_parameters
        dialog = LoadBlocksDialog(session.frame, filling, self._block_questions, self._window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take_blocks(dialog.found()))
        dialog.open()

    def load_blocks(self, path: str, fill_gaps: bool = False) -> None:
        """Replace the blocks by those of a file or folder, as one undoable step; locked blocks stay."""
        filling = self._workspace.extraction_parameters if fill_gaps else None
        try:
            blocks = blocks_from(BlockSource(self._workspace.session.frame, path, filling))
        except IlfError as error:
            self._notes.report("Load blocks", error)
        else:
            self._take_blocks(blocks)
            self._notes.warn("Blocks loaded", blocks.notes)

    def _take_blocks(self, blocks: LoadedBlocks) -> None:
        self._workspace.replace_labels(blocks.labels, "Load blocks", blocks.names)
        count = len(self._workspace.session.counts())
        self._notes.tell(f"Loaded: {describe_blocks(count, self._workspace.session.labels)}.")

    def ask_save_blocks(self) -> None:
        """Write the blocks to a file that the user chooses, in one of the formats."""
        filters = {f"{text} (*{suffix})": name for name, (text, suffix) in BLOCK_FORMATS.items()}
        proposed = _export_folder(self._workspace.session).parent / f"{self._workspace.session.name}-blocks.png"
        path, chosen = QFileDialog.getSaveFileName(self._window, "Save blocks", str(proposed), ";;".join(filters))
        if path:
            format = filters.get(chosen, "png")
            suffix = BLOCK_FORMATS[format][1]
            known = {suffix for _, suffix in BLOCK_FORMATS.values()}
            if Path(path).suffix.lower() not in known:
                path += suffix
            # a suffix that was typed says more than the filter that it does not fit
            self.save_blocks(path, format if Path(path).suffix.lower() == suffix else None)

    def save_blocks(self, path: str, format: str | None = None) -> bool:
        """Write the blocks, with their names; False, with a message, if the file cannot be written."""
        session = self._workspace.session
        try:
            save_blocks(Path(path), session, format)
        except IlfError as error:
            self._notes.report("Save blocks", error)
            return False
        names = "" if path.lower().endswith(".json") else "; a label map holds no names, COCO and labelme do"
        self._notes.tell(f"Saved {len(session.counts())} blocks to {path}{names}")
        return True

    # closing

    def close_frame(self) -> None:
        """Close the present frame, after asking about the work on it; what has been saved stays in the list."""
        entry = self._workspace.entries.of(self._workspace.session.id)
        if entry is not None:
            self.leave([entry], lambda: self.close(entry))

    def remove_entries(self, entries: Sequence[Entry], then: Callable[[], object] = lambda: None) -> None:
        """Take frames out of the list, after asking once about the work on them; `then` follows if that is done."""

        def remove() -> None:
            self._workspace.remove_entries(entries)
            then()

        self.remove(entries, remove)

    # export

    def ask_export(self) -> None:
        """Export by the dialog."""
        session = self._workspace.session
        completion = session.completion()
        run = session.run(session.common, dense=session.guessed)
        dialog = ExportDialog(
            run, completion is not None, str(_export_folder(session)), self._window, behind=behind(session)
        )
        dialog.set_depth(completion.depth if completion is not None else session.frame.depth)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self.export(Path(dialog.folder()), dialog.options(), dialog.png_note.text()))
        dialog.open()

    def export(self, folder: Path, options: ExportOptions, told: str = "") -> None:
        """Write the present frame's results, off the GUI's thread. What has been `told` before is no warning."""
        if self._exporter.busy:
            self._notes.tell("An export is under way already.")
            return
        session = self._workspace.session
        completion = session.completion() or compose(session.frame, {})
        run = session.run(session.common, dense=session.guessed)
        QSettings().setValue("export/folder", str(folder.absolute().parent))

        def job() -> Generator[None, None, Written]:
            yield None
            written = write(folder, run, completion, options)
            known = [note for note in written.notes if told and told in note]
            notes = tuple(note for note in written.notes if note not in known)
            return replace(written, notes=notes, remarks=(*written.remarks, *known))

        self._exporter.start(job)
        self.exporting_changed.emit()
        self._notes.tell(" ".join((f"Exporting to {folder}…", behind(session) if session.results.kept else "")).strip())

    @property
    def exporting(self) -> bool:
        """Whether an export is under way."""
        return self._exporter.busy

    def _note_exported(self, written: Written) -> None:
        folder = written.files[0].parent if written.files else ""
        self._notes.tell(". ".join((f"Exported {len(written.files)} files to {folder}", *written.remarks)))
        self._notes.warn("Exported, with warnings", written.notes)
        self.exported.emit(written)

    def ask_save_picture(self) -> None:
        """Save what the window shows."""
        path, _ = QFileDialog.getSaveFileName(self._window, "Save picture", "ilf-studio.png", _IMAGES)
        if path:
            self.save_picture(path)

    def save_picture(self, path: str) -> bool:
        """Save what the window shows as PNG; False, with a message, if the file cannot be written."""
        saved = self._take_picture().save(path, "PNG")
        if saved:
            self._notes.tell(f"Saved {path}")
        else:
            self._notes.report("Save picture", IlfError(f"{path} could not be written. Choose another folder."))
        return saved

    def shutdown(self) -> None:
        """Wait for an export that is under way, before the window closes."""
        self._block_questions.shutdown()
        self._looks.shutdown()
        self._exporter.shutdown()


def _export_folder(session: Session) -> Path:
    """Where an export goes unless the user says otherwise: beside the last one, or in the working folder."""
    return save_folder() / output_folder_name(session.name)
